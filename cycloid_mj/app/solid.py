"""The drive as triangles for the 3-D view of the page: shape, colour, place, motion and assembly step of each part."""

import base64
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from cycloid_mj.app.drive import BuildOptions, reducer_at_reference
from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import Part, mesh
from cycloid_mj.parts.accuracy import SCREEN_CHORD_ERROR
from cycloid_mj.parts.export.assembly import COLOURS, assembly_parts, place_parts
from cycloid_mj.parts.export.casing import casing_or_none
from cycloid_mj.parts.export.insertion import Move, assembly_moves
from cycloid_mj.parts.export.order import ALONG
from cycloid_mj.parts.export.step import PlacedPart
from cycloid_mj.parts.parts import tint
from cycloid_mj.reducer import Reducer

EXPLODED_GAP = 0.06
"""Distance between the families of parts of the exploded view, relative to the outer radius of the housing."""

GROUPS = {"hub": "hub of the output", "flange": "output flange"}
"""Words for groups of parts that are not named after a part."""

MOVES = {names.SHAFT: "crank", names.OUTPUT: "output"}
"""Body -> what it moves with. Discs orbit with a phase each; other bodies are fixed."""


def assembly_meshes(reducer: Reducer, options: BuildOptions) -> dict[str, Any]:
    """Return the meshes of all parts of the drive with covers for the motor of `options`, and their motions, as JSON.

    Returns
    -------
    dict
        ``parts``: list of dicts with ``name``, ``colour`` (RGBA, 0 to 1), ``corners`` of triangles (float32 [mm] in
        base64, shape (triangles, 3, 3)) and ``copies``, a dict for each place of the part, see `_component_json`.
        ``steps``: the moves of the assembly in words. ``orbit``: eccentricity [mm]; ``gear_rate``: turns of a disc per
        crank turn. ``reason``: why the covers do not fit, else empty.

    Raises
    ------
    DesignError
        The chosen motor does not fit, or a part cannot be manufactured.
    """
    reducer = reducer_at_reference(reducer)
    design = reducer.design
    sizes, reason = casing_or_none(reducer, options.motor)
    geometry, components = assembly_parts(reducer, sizes), place_parts(reducer, 0.0, sizes)
    ordered_moves = assembly_moves(reducer, sizes) if sizes else ()
    steps, shifts = _number_steps(ordered_moves), _exploded_shifts(reducer, geometry, components)
    phases = dict(zip(reducer.gears, map(float, reducer.phases), strict=True))
    parts = [
        {
            "name": name.replace("_", " "),
            "colour": list(tint(COLOURS[names.family(name)], name)),
            "corners": _triangles(part),
            "copies": [
                _component_json(component, phases, steps.get(component.name, 0), shifts[names.family(component.part)])
                for component in components
                if component.part == name
            ],
        }
        for name, part in geometry.items()
    ]
    return {
        "parts": [part for part in parts if part["copies"]],
        "steps": [*_describe_steps(ordered_moves)],
        "orbit": MILLIMETRES * design.gear.eccentricity,
        "gear_rate": -1.0 / design.lobes,
        "reason": reason,
    }


def _component_json(component: PlacedPart, phases: Mapping[str, float], step: int, shift: float) -> dict[str, Any]:
    """Convert position and motion of a component to JSON values.

    `phases` are the angles of the discs on the crank [rad] by the name of their body, `step` is the assembly step of
    the component from 1 (0: none), and `shift` is its shift along the axis in the exploded view [m]. In the result,
    ``at`` is its position x, y, z [mm], for a disc and its bearing relative to the disc's centre. ``angle`` is its
    rotation [rad]. ``moves`` is what it moves with: "disc", "crank" or "output", or "" if it is fixed. ``phase`` is the
    angle of its disc on the crank [rad], 0 for other components. ``apart`` is `shift` in mm.
    """
    x, y, z = component.origin
    on_disc = component.body in phases
    return {
        "at": np.round(MILLIMETRES * np.array([0.0 if on_disc else x, 0.0 if on_disc else y, z]), 4).tolist(),
        "angle": component.angle,
        "moves": "disc" if on_disc else MOVES.get(component.body, ""),
        "phase": phases.get(component.body, 0.0),
        "step": step,
        "apart": MILLIMETRES * shift,
    }


def _parts_of_moves(moves: Sequence[Move]) -> Iterator[tuple[str, list[str]]]:
    """Yield, for each move of the assembly, the name of the group that is joined and the names of its new parts.

    Moves that only join groups which are already assembled are skipped.
    """
    added_before, groups = set[str](), set[str]()
    for move in moves:
        new_parts = [name for name in move.parts if name not in added_before | groups]
        groups.add(move.group)
        added_before.update(move.parts)
        if new_parts:
            yield move.group, new_parts


def _number_steps(moves: Sequence[Move]) -> dict[str, int]:
    """Return the step of each part, from 1, by its name."""
    return {name: number for number, (_, new_parts) in enumerate(_parts_of_moves(moves), start=1) for name in new_parts}


def _describe_steps(moves: Sequence[Move]) -> Iterator[str]:
    """Yield each step of the assembly in words: the added parts with their counts, and the group into which they go.

    `moves` are the moves that assemble the drive, in order.
    """
    for group_name, new_parts in _parts_of_moves(moves):
        counts = Counter(names.family(name).replace("_", " ") for name in new_parts)
        parts_text = ", ".join(f"{count} x {family}" if count > 1 else family for family, count in counts.items())
        if len(new_parts) == 1:
            parts_text = new_parts[0].replace("_", " ")
        group = GROUPS.get(group_name, group_name.replace("_", " "))
        yield parts_text if group_name in new_parts or group in counts else f"{parts_text} into the {group}"


def _exploded_shifts(reducer: Reducer, parts: Mapping[str, Part], components: Sequence[PlacedPart]) -> dict[str, float]:
    """Compute the axial shift [m] of each family of parts in the exploded view, by the name of the family.

    A family is a part with its numbered copies, such as all discs. `parts` are those of the drive by name, `components`
    their copies with positions. In the exploded view the families follow one another in the order of `ALONG` (from
    input to output), unlisted families last, with a gap between them, and are centred about z = 0.
    """
    gap, start, shifts = EXPLODED_GAP * reducer.design.housing.outer_radius, 0.0, dict[str, float]()
    families = {names.family(component.part) for component in components}
    end_heights = {name: [z for prism in part.segments for z in (prism.z0, prism.z1)] for name, part in parts.items()}
    for family in sorted(families, key=lambda name: ALONG.index(name) if name in ALONG else len(ALONG)):
        heights = [
            component.origin[2] + z
            for component in components
            if names.family(component.part) == family
            for z in end_heights[component.part]
        ]
        shifts[family] = start - min(heights)
        start += max(heights) - min(heights) + gap
    middle = 0.5 * (start - gap)
    return {family: shift - middle for family, shift in shifts.items()}


def _triangles(part: Part) -> str:
    """Encode the corners of the triangles of a part in base64: little-endian float32 [mm], shape (triangles, 3, 3)."""
    shape = mesh(part.solid(SCREEN_CHORD_ERROR))
    corners: Array = MILLIMETRES * shape.vertices[shape.faces].reshape(-1, 3)
    return base64.b64encode(corners.astype("<f4").tobytes()).decode()
