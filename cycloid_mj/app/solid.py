"""The drive as triangles for the 3-D view of the page: shape, colour, place, motion and assembly step of each part."""

import base64
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from cycloid_mj.app.drive import BuildOptions, reducer_at_reference
from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.design.layouts import Layout
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts import Part, mesh
from cycloid_mj.parts.accuracy import SCREEN_CHORD_ERROR
from cycloid_mj.parts.export.assembly import COLOURS, assembly_parts, place_parts
from cycloid_mj.parts.export.casing import casing_or_none
from cycloid_mj.parts.export.insertion import Move, assembly_moves
from cycloid_mj.parts.export.order import ALONG
from cycloid_mj.parts.export.rv_assembly import RV_ALONG, RV_COLOURS, place_rv_parts, rv_assembly_parts
from cycloid_mj.parts.export.step import PlacedPart
from cycloid_mj.parts.parts import Colour, tint
from cycloid_mj.parts.rv import CARRIER, NEEDLE, SUN
from cycloid_mj.reducer import Reducer, RvReducer

EXPLODED_GAP = 0.06
"""Distance between the families of parts of the exploded view, relative to the outer radius of the housing."""

GROUPS = {"hub": "hub of the output", "flange": "output flange"}
"""Words for groups of parts that are not named after a part."""

MOVES = {names.SHAFT: "crank", **dict.fromkeys((names.OUTPUT, names.ROLLER, CARRIER), "output"), SUN: "sun"}
"""Body -> what it moves with. Discs, and the cranks of an RV reducer, move about an axis of their own; other bodies are
fixed."""

NO_STEPS = "the view has no steps of assembly. Screws, main bearings and covers of an RV reducer are not modelled"
"""Why the view of an RV reducer has no covers and no steps of assembly."""


@dataclass(frozen=True)
class _Assembly:
    """The parts of a drive at the crank angle 0, and their motion.

    Attributes
    ----------
    parts, components
        Parts by name, and their copies with positions.
    colours, along
        Colour of each family of parts, and families or parts in their order along the axis of the exploded view.
    moves, reason
        Moves that assemble the drive, in order; and why there are none, else empty.
    motions
        Name of a motion -> turns of a part about its own axis, and of this axis about that of the reducer, per crank
        turn against the ring.
    """

    parts: Mapping[str, Part]
    components: Sequence[PlacedPart]
    colours: Mapping[str, Colour]
    along: Sequence[str]
    moves: Sequence[Move]
    reason: str
    motions: Mapping[str, tuple[float, float]]


def _assemble_central(reducer: Reducer, options: BuildOptions) -> _Assembly:
    """Return the parts of a drive with a central crank, with covers if these fit.

    The result also has the positions, colours and motions of the parts, and the moves that assemble them. `options` has
    the motor.
    """
    casing, reason = casing_or_none(reducer, options.motor)
    return _Assembly(
        assembly_parts(reducer, casing),
        place_parts(reducer, 0.0, casing),
        COLOURS,
        ALONG,
        assembly_moves(reducer, casing) if casing else (),
        f"Without covers: {reason}" if reason else "",
        _motions(reducer) | {"crank": (1.0, 1.0)},
    )


def _assemble_rv(reducer: Reducer, _options: BuildOptions) -> _Assembly:
    """Return the parts of an RV reducer, which has no covers, with their positions, colours and motions."""
    reducer = cast(RvReducer, reducer)
    motions = _motions(reducer)
    carrier_rate, _ = motions["output"]
    sun_rate = float(1 / reducer.kinematics.crank_per_sun)
    return _Assembly(
        rv_assembly_parts(reducer),
        tuple(place_rv_parts(reducer)),
        RV_COLOURS,
        RV_ALONG,
        (),
        f"The parts are in place: {NO_STEPS}.",
        motions | {"crank": (1.0, carrier_rate), "sun": (sun_rate, sun_rate)},
    )


def _motions(reducer: Reducer) -> dict[str, tuple[float, float]]:
    """Return the motions that the parts of all layouts have, by name; the ring is at rest.

    A motion is the turns of a part about its own axis, and of this axis about that of the reducer, per crank turn.
    """
    disc_rate = -1.0 / reducer.design.lobes
    return {"": (0.0, 0.0), "output": (disc_rate, disc_rate), "disc": (disc_rate, 1.0)}


ASSEMBLIES: Mapping[Layout, Callable[[Reducer, BuildOptions], _Assembly]] = {
    "central": _assemble_central,
    "rv": _assemble_rv,
}
"""Layout -> function that returns the parts of its 3-D view."""


def assembly_meshes(reducer: Reducer, options: BuildOptions) -> dict[str, Any]:
    """Return the meshes of all parts of the drive with covers for the motor of `options`, and their motions, as JSON.

    Returns
    -------
    dict
        ``parts``: list of dicts with ``name``, ``colour`` (RGBA, 0 to 1), ``corners`` of triangles (float32 [mm] in
        base64, shape (triangles, 3, 3)) and ``copies``, a dict for each place of the part, see `_component_json`.
        ``steps``: the moves of the assembly in words. ``motions``: name of a motion -> turns of a part about its axis
        and of its axis about that of the reducer, per crank turn. ``reason``: why there are no covers or no steps, a
        sentence; else empty.

    Raises
    ------
    DesignError
        The chosen motor does not fit, or a part cannot be manufactured.
    """
    reducer = reducer_at_reference(reducer)
    assembly = ASSEMBLIES[reducer.LAYOUT](reducer, options)
    steps, shifts = _number_steps(assembly.moves), _exploded_shifts(reducer, assembly)
    axes = _axis_positions(reducer)
    parts = [
        {
            "name": name.replace("_", " "),
            "colour": list(tint(assembly.colours[names.family(name)], name)),
            "corners": _triangles(part),
            "copies": [
                _component_json(component, axes, steps.get(component.name, 0), shifts[_group_of(name, assembly.along)])
                for component in assembly.components
                if component.part == name
            ],
        }
        for name, part in assembly.parts.items()
    ]
    return {
        "parts": [part for part in parts if part["copies"]],
        "steps": [*_describe_steps(assembly.moves)],
        "motions": assembly.motions,
        "reason": assembly.reason,
    }


def _axis_positions(reducer: Reducer) -> dict[str, Array]:
    """Return positions x, y [m] of the axes of discs, and of cranks of an RV reducer, by body such as "gear", (2,).

    The positions are those at the crank angle 0. The value for the needles, which turn with their cranks, has shape
    (cranks, 2).
    """
    centres = reducer.design.gear.eccentricity * unit(-np.array(reducer.phases))
    axes = dict(zip(reducer.gears, centres, strict=True))
    if isinstance(reducer, RvReducer):
        cranks = reducer.stage.crank_positions([0.0])[0]
        axes |= dict(zip(names.all_numbered(names.CRANK, len(cranks)), cranks, strict=True)) | {NEEDLE: cranks}
    return axes


def _component_json(component: PlacedPart, axes: Mapping[str, Array], number: int, shift: float) -> dict[str, Any]:
    """Convert position and motion of a component to JSON values.

    `axes` is the result of `_axis_positions`, `number` is the assembly step of the component from 1 (0: none), and
    `shift` is its shift along the axis in the exploded view [m]. In the result, ``at`` is the position x, y, z [mm] of
    the component relative to its axis ``axis`` [mm]. ``angle`` is its rotation [rad]. ``moves`` is the name of its
    motion: "disc", "crank", "output" or "sun", or "" if it is fixed. ``apart`` is `shift` in mm.
    """
    position, moves, axis = np.array(component.origin), MOVES.get(component.body, ""), np.zeros(3)
    if component.body in axes:
        moves = "disc" if names.family(component.body) == names.GEAR else "crank"
        candidates = np.atleast_2d(axes[component.body])
        axis[:2] = candidates[np.argmin(np.linalg.norm(candidates - position[:2], axis=1))]
    return {
        "at": np.round(MILLIMETRES * (position - axis), 4).tolist(),
        "axis": np.round(MILLIMETRES * axis[:2], 4).tolist(),
        "angle": component.angle,
        "moves": moves,
        "step": number,
        "apart": MILLIMETRES * shift,
    }


def _parts_of_moves(moves: Sequence[Move]) -> Iterator[tuple[str, list[str]]]:
    """Yield, for each move of the assembly, the name of the group that receives parts and the names of these parts.

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


def _group_of(part: str, along: Sequence[str]) -> str:
    """Return the name by which a part moves in the exploded view: its own, if it is in `along`, or its family."""
    return part if part in along else names.family(part)


def _exploded_shifts(reducer: Reducer, assembly: _Assembly) -> dict[str, float]:
    """Compute the shift of each group of parts along the axis [m] in the exploded view, by the name of the group.

    A group is a part with its numbered copies, such as all discs (`_group_of`). In the exploded view the groups follow
    one another in the order of `_Assembly.along` (from input to output), unlisted groups last, with a gap between them,
    and are centred about z = 0.
    """
    gap, start, shifts = EXPLODED_GAP * reducer.design.housing.outer_radius, 0.0, dict[str, float]()
    order, parts = assembly.along, assembly.parts
    groups = {_group_of(component.part, order) for component in assembly.components}
    end_heights = {name: [z for prism in part.segments for z in (prism.z0, prism.z1)] for name, part in parts.items()}
    for group in sorted(groups, key=lambda name: order.index(name) if name in order else len(order)):
        heights = [
            component.origin[2] + z
            for component in assembly.components
            if _group_of(component.part, order) == group
            for z in end_heights[component.part]
        ]
        shifts[group] = start - min(heights)
        start += max(heights) - min(heights) + gap
    middle = 0.5 * (start - gap)
    return {group: shift - middle for group, shift in shifts.items()}


def _triangles(part: Part) -> str:
    """Encode the corners of the triangles of a part in base64: little-endian float32 [mm], shape (triangles, 3, 3)."""
    shape = mesh(part.solid(SCREEN_CHORD_ERROR))
    corners: Array = MILLIMETRES * shape.vertices[shape.faces].reshape(-1, 3)
    return base64.b64encode(corners.astype("<f4").tobytes()).decode()
