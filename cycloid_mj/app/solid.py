"""The drive as triangles for the 3-D view of the page: shape, colour, place, motion and assembly step of each part."""

import base64
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from cycloid_mj.app.drive import BuildOptions, drive_of
from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import Part, mesh
from cycloid_mj.parts.export.assembly import COLOURS, assembly_parts, places
from cycloid_mj.parts.export.casing import casing_or_none
from cycloid_mj.parts.export.insertion import Move, moves
from cycloid_mj.parts.export.order import ALONG
from cycloid_mj.parts.export.step import Place
from cycloid_mj.parts.parts import tint
from cycloid_mj.reducer import Reducer

CHORD_ERROR = 1e-5
"""Chord error of the meshes [m]."""

EXPLODED_GAP = 0.06
"""Distance between the families of parts of the exploded view, relative to the outer radius of the housing."""

GROUPS = {"hub": "hub of the output", "flange": "output flange"}
"""Words for groups of parts that are not named after a part."""

MOVES = {names.SHAFT: "crank", names.OUTPUT: "output"}
"""Body -> what it moves with. Discs orbit with a phase each; other bodies are fixed."""


def assembly(reducer: Reducer, options: BuildOptions) -> dict[str, Any]:
    """Return the meshes of all parts of the drive with covers, their places and motions, in JSON values.

    Returns
    -------
    dict
        ``parts``: name, ``colour``, ``corners`` of triangles (float32 [mm] in base64, shape (triangles, 3, 3)) and
        ``places``; each place has x, y, z [mm], angle [rad], ``moves``, ``phase`` of its disc, ``step`` and ``apart``,
        by which it is moved along the axis in the exploded view [mm]. ``steps``: the moves of the assembly in words.
        ``orbit`` [mm]; ``gear_rate`` in turns per crank turn. Without covers, ``reason`` says why they do not fit.

    Raises
    ------
    DesignError
        The chosen motor does not fit, or a part cannot be manufactured.
    """
    reducer = drive_of(reducer)
    design = reducer.design
    sizes, reason = casing_or_none(reducer, options.motor)
    drawn, placed = assembly_parts(reducer, sizes), places(reducer, 0.0, sizes)
    assembled = moves(reducer, sizes) if sizes else ()
    steps, apart = _steps(assembled), _shifts(reducer, drawn, placed)
    phases = dict(zip(reducer.gears, map(float, reducer.phases), strict=True))
    parts = [
        {
            "name": name.replace("_", " "),
            "colour": list(tint(COLOURS[names.family(name)], name)),
            "corners": _triangles(part),
            "places": [
                _place(place, phases, steps.get(place.name, 0), apart[names.family(place.part)])
                for place in placed
                if place.part == name
            ],
        }
        for name, part in drawn.items()
    ]
    return {
        "parts": [part for part in parts if part["places"]],
        "steps": [*_steps_in_words(assembled)],
        "orbit": MILLIMETRES * design.gear.eccentricity,
        "gear_rate": -1.0 / design.lobes,
        "reason": reason,
    }


def _place(place: Place, phases: Mapping[str, float], step: int, apart: float) -> dict[str, Any]:
    """Return the place of a part; that of a disc or its bearing is relative to the centre of the disc."""
    x, y, z = place.origin
    on_disc = place.body in phases
    return {
        "at": np.round(MILLIMETRES * np.array([0.0 if on_disc else x, 0.0 if on_disc else y, z]), 4).tolist(),
        "angle": place.angle,
        "moves": "disc" if on_disc else MOVES.get(place.body, ""),
        "phase": phases.get(place.body, 0.0),
        "step": step,
        "apart": MILLIMETRES * apart,
    }


def _added_parts(assembled: Sequence[Move]) -> Iterator[tuple[str, list[str]]]:
    """Yield the group and the new parts of each move that adds some; a group that is complete moves without any."""
    seen, groups = set[str](), set[str]()
    for move in assembled:
        added = [name for name in move.parts if name not in seen | groups]
        groups.add(move.group)
        seen.update(move.parts)
        if added:
            yield move.group, added


def _steps(assembled: Sequence[Move]) -> dict[str, int]:
    """Return the step of each part, from 1, by its name."""
    return {name: number for number, (_, added) in enumerate(_added_parts(assembled), start=1) for name in added}


def _steps_in_words(assembled: Sequence[Move]) -> Iterator[str]:
    """Describe each step: the families of its parts with their numbers, and the group that they join."""
    for group_name, added in _added_parts(assembled):
        counts = Counter(names.family(name).replace("_", " ") for name in added)
        listed = ", ".join(f"{count} x {family}" if count > 1 else family for family, count in counts.items())
        if len(added) == 1:
            listed = added[0].replace("_", " ")
        group = GROUPS.get(group_name, group_name.replace("_", " "))
        yield listed if group_name in added or group in counts else f"{listed} into the {group}"


def _shifts(reducer: Reducer, parts: Mapping[str, Part], placed: Sequence[Place]) -> dict[str, float]:
    """Compute by how much each family of parts moves along the axis [m] so that they are separate, in their order."""
    gap, start, shifts = EXPLODED_GAP * reducer.design.housing.outer_radius, 0.0, dict[str, float]()
    families = {names.family(place.part) for place in placed}
    ends = {name: [z for stretch in part.stretches for z in (stretch.z0, stretch.z1)] for name, part in parts.items()}
    for family in sorted(families, key=lambda name: ALONG.index(name) if name in ALONG else len(ALONG)):
        heights = [
            place.origin[2] + z for place in placed if names.family(place.part) == family for z in ends[place.part]
        ]
        shifts[family] = start - min(heights)
        start += max(heights) - min(heights) + gap
    middle = 0.5 * (start - gap)
    return {family: shift - middle for family, shift in shifts.items()}


def _triangles(part: Part) -> str:
    """Encode the corners of the triangles of a part as float32 in millimetres."""
    shape = mesh(part.solid(CHORD_ERROR))
    corners: Array = MILLIMETRES * shape.vertices[shape.faces].reshape(-1, 3)
    return base64.b64encode(corners.astype("<f4").tobytes()).decode()
