"""All parts of a reducer by name."""

from collections.abc import Mapping

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.parts.accuracy import checked_chord_error
from cycloid_mj.parts.gear import gear_part
from cycloid_mj.parts.housing import housing_part, pin_part
from cycloid_mj.parts.output import output_centres, output_part, roller_part
from cycloid_mj.parts.part import Part, PartSection, Segment
from cycloid_mj.parts.prism import Prism, Solid
from cycloid_mj.parts.rv import rv_body_parts
from cycloid_mj.parts.shaft import crank_part, crank_parts, shaft_segments, shaft_solid
from cycloid_mj.reducer import Reducer, RvReducer, once

TINT = 0.25
"""Step towards white from one disc to the next."""

Colour = tuple[float, float, float, float]
"""Red, green, blue and opacity from 0 to 1."""

COLOURS: Mapping[str, Colour] = {
    names.HOUSING: (0.55, 0.58, 0.62, 1.0),
    names.SHAFT: (0.80, 0.62, 0.25, 1.0),
    names.GEAR: (0.25, 0.47, 0.70, 1.0),
    names.PIN: (0.83, 0.84, 0.86, 1.0),
    names.OUTPUT: (0.36, 0.62, 0.42, 1.0),
    names.CAM: (0.90, 0.72, 0.36, 1.0),
    names.SPACER: (0.62, 0.52, 0.34, 1.0),
    names.ROLLER: (0.72, 0.84, 0.74, 1.0),
    names.CRANK: (0.75, 0.35, 0.3, 1.0),
    names.PLANET: (0.8, 0.5, 0.35, 1.0),
    names.SUN: (0.85, 0.65, 0.3, 1.0),
}
"""Colours by family of parts, in MuJoCo and in viewers."""


def parts(reducer: Reducer, chord_error: float | None = None) -> dict[str, Solid]:
    """Return the parts of the mechanism as solids by name: housing, shaft, discs, a ring pin, and output.

    Each is in its own frame. The ring pin exists if the ring has pins; that of a sleeved ring is the sleeve, whose
    pressed-in pins belong to the housing. With D > 1 discs there are ``gear_1`` to ``gear_D`` in the frames of the
    discs, and ``cam_1`` to ``cam_D`` in the frame of the shaft. Equal parts occur once: ``spacer`` for all gaps between
    discs, and ``output_roller`` for all separate rollers. The parts of an RV reducer are those of `rv_body_parts`.

    Parameters
    ----------
    chord_error
        Largest distance of a chord from its curve [m]; by default that for mass properties.
    """
    return dict(_parts(reducer.shape, chord_error))


def part_sections(reducer: Reducer, splines: int = 1) -> dict[str, tuple[PartSection, ...]]:
    """Return the cross-sections of all parts by name, as curves for CAD with `splines` splines per lobe or root.

    Raises
    ------
    DesignError
        A part cannot be manufactured.
    """
    return {name: part.sections(splines) for name, part in lay_out_parts(reducer).items()}


def lay_out_parts(reducer: Reducer, chord_error: float | None = None) -> dict[str, Part]:
    """Return the parts by name, see `parts`; the crank is balanced for polygons of the chord error [m]."""
    return dict(_all_parts(reducer.shape, chord_error))


def body_solids(reducer: Reducer) -> dict[str, Solid]:
    """Return one solid per moving body, by the name of its main part; parts that move together are joined.

    The solid of the shaft is the entire crank. The solid of the output includes its rollers, after its own prisms. The
    bodies of an RV reducer are those of `rv_body_parts`.
    """
    joined_solids = {
        body: make_solid(reducer.shape)
        for body, make_solid in ((names.SHAFT, _crank_solid), (names.OUTPUT, _output_with_rollers))
        if attached_parts(reducer, body)
    }
    joined_parts = {part for body in joined_solids for part, _ in attached_parts(reducer, body).values()}
    return {name: joined_solids.get(name, solid) for name, solid in parts(reducer).items() if name not in joined_parts}


def rv_solids(reducer: RvReducer, chord_error: float | None = None) -> dict[str, Solid]:
    """Return one solid per body of an RV reducer, named by its part.

    `chord_error` [m] is the largest distance of a chord from its curve, by default that for mass properties.
    """
    return parts(reducer, chord_error)


def attached_parts(reducer: Reducer, body: str) -> dict[str, tuple[str, Array]]:
    """Return the parts that are mounted on shaft or output: cams and spacers, or the rollers of the output pins.

    `body` is the name of shaft or output. Cams in one piece with the shaft are not among them.

    Returns
    -------
    dict
        For the name of each copy, such as ``spacer_2``, its part and its position (3,) [m] in the frame of the body;
        empty if it carries none.
    """
    gear = reducer.design.gear
    if isinstance(reducer, RvReducer):
        return {}
    if body == names.SHAFT and not reducer.design.has_one_piece_crank:
        cams = {name: (name, np.zeros(3)) for name in names.all_numbered(names.CAM, gear.discs)}
        gap_middles = [plane + gear.disc_spacing / 2 for plane in gear.disc_planes[:-1]]
        spacers = zip(names.all_numbered(names.SPACER, len(gap_middles)), gap_middles, strict=True)
        return cams | {name: (names.SPACER, np.array([0.0, 0.0, mid_height])) for name, mid_height in spacers}
    if body == names.OUTPUT and reducer.design.output.has_roller_parts:
        return roller_positions(reducer)
    return {}


def roller_positions(reducer: Reducer) -> dict[str, tuple[str, Array]]:
    """Return the copies of rollers of all output pins in all discs, in the form of `attached_parts`."""
    positions = [
        np.array([*centre, plane]) for plane in reducer.design.gear.disc_planes for centre in output_centres(reducer)
    ]
    copies = zip(names.all_numbered(names.ROLLER, len(positions)), positions, strict=True)
    return {name: (names.ROLLER, position) for name, position in copies}


def crank_segments(reducer: Reducer) -> Mapping[str, Segment]:
    """Return the segments of the entire crank by name, balanced for mass properties; errors as `shaft_segments`."""
    return shaft_segments(reducer)


def crank_solid(reducer: Reducer) -> Solid:
    """Return the entire crank as in `body_solids`, without other parts; errors as `shaft_segments`."""
    return _crank_solid(reducer.shape)


@once
def _crank_solid(reducer: Reducer) -> Solid:
    return shaft_solid(reducer)


@once
def _output_with_rollers(reducer: Reducer) -> Solid:
    """Return the output disc with its pins and the rollers on them as one solid."""
    solids = _parts(reducer, None)
    (tube,) = solids[names.ROLLER].prisms
    rollers = [
        Prism(tube.outline + position[:2], tuple(hole + position[:2] for hole in tube.holes), tube.z0 + z, tube.z1 + z)
        for _, position in attached_parts(reducer, names.OUTPUT).values()
        for z in (float(position[2]),)
    ]
    disc_and_pins = solids[names.OUTPUT]
    return Solid(names.OUTPUT, (*disc_and_pins.prisms, *rollers), disc_and_pins.density)


@once
def _all_parts(reducer: Reducer, chord_error: float | None) -> dict[str, Part]:
    """Return all parts of the mechanism as exact outlines, by name.

    The counterweight of the crank is sized by polygons, whose chords deviate from the outlines by at most `chord_error`
    [m]; None: the chord error of mass properties.
    """
    if isinstance(reducer, RvReducer):
        return rv_body_parts(reducer)
    disc_count = reducer.design.gear.discs
    is_one_piece = reducer.design.has_one_piece_crank
    parts_of_crank = (crank_part(reducer, chord_error),) if is_one_piece else crank_parts(reducer)
    all_parts = [housing_part(reducer), *parts_of_crank, *(gear_part(reducer, disc) for disc in range(disc_count))]
    if reducer.design.ring.kind == "pin":
        all_parts.append(pin_part(reducer))
    all_parts.append(output_part(reducer))
    if reducer.design.output.has_roller_parts:
        all_parts.append(roller_part(reducer))
    return {part.name: part for part in all_parts}


@once
def _parts(reducer: Reducer, chord_error: float | None) -> dict[str, Solid]:
    max_error = checked_chord_error(reducer, chord_error)
    return {name: part.solid(max_error) for name, part in _all_parts(reducer, chord_error).items()}


def tint(colour: Colour, part: str) -> Colour:
    """Return the colour of a part from that of its family: each disc is lighter than the one before."""
    if names.family(part) != names.GEAR:
        return colour
    red, green, blue, opacity = colour
    share = TINT * (names.number_of(part) - 1)
    return red + share * (1.0 - red), green + share * (1.0 - green), blue + share * (1.0 - blue), opacity
