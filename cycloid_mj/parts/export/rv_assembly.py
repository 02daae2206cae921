"""The assembled RV reducer: the positions of its parts at a crank angle, and its colours."""

from collections import Counter
from collections.abc import Iterator, Mapping

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts.accuracy import EXPORT_CHORD_ERROR
from cycloid_mj.parts.export.placement import place_discs, place_ring_pins
from cycloid_mj.parts.export.step import PlacedPart
from cycloid_mj.parts.inertia import mass_properties
from cycloid_mj.parts.part import Part
from cycloid_mj.parts.parts import COLOURS, Colour
from cycloid_mj.parts.rv import (
    CARRIER,
    CRANK,
    FLANGES,
    NEEDLE,
    PLANET,
    SUN,
    TAPERED_BEARING,
    axial_layout,
    crank_bearing_ends,
    planet_angle,
    rv_bearings,
    rv_parts,
)
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.rv_main_bearings import flange_face, main_bearing_ends, stop_ring_thickness

BEARING_FILL = 0.67
"""Mass of a rolling bearing relative to a solid ring: 608, 61804, 6204, HK1010 have 0.66 to 0.70 (SKF)."""

RV_COLOURS: Mapping[str, Colour] = {
    **COLOURS,
    CARRIER: COLOURS[names.OUTPUT],
    NEEDLE: (0.83, 0.84, 0.86, 1.0),
    TAPERED_BEARING: (0.7, 0.72, 0.75, 1.0),
    names.OUTPUT_BEARING: (0.8, 0.82, 0.85, 1.0),
    names.STOP_RING: COLOURS[names.HOUSING],
}
"""Colours by family of parts."""

RV_ALONG = (
    *(SUN, PLANET, FLANGES[0], CRANK, TAPERED_BEARING, NEEDLE),
    *(names.GEAR, names.PIN, names.HOUSING, names.STOP_RING, names.OUTPUT_BEARING, FLANGES[1]),
)
"""Families of parts, and the flanges, in their order along the axis of an exploded view, from input to output."""


def rv_assembly_parts(reducer: RvReducer) -> dict[str, Part]:
    """Return all parts of the assembly by name, each once; raises the errors of `rv.rv_parts`."""
    return rv_parts(reducer) | rv_bearings(reducer)


def rv_mass(reducer: RvReducer) -> float:
    """Compute the mass of an assembled RV reducer [kg], with all copies of each part; errors as `rv_assembly_parts`."""
    return sum(rv_masses(reducer).values())


def rv_masses(reducer: RvReducer) -> dict[str, float]:
    """Compute the mass of all copies of each part of `rv_assembly_parts` [kg], by name; raises the errors of that.

    Main bearings have `BEARING_FILL` times the mass of a solid ring; the rings of the tapered bearings are solid.
    """
    counts = Counter(placement.part for placement in place_rv_parts(reducer))
    parts = rv_assembly_parts(reducer)
    masses = {name: mass_properties(part.solid(EXPORT_CHORD_ERROR)).mass for name, part in parts.items()}
    if names.OUTPUT_BEARING in masses:
        masses[names.OUTPUT_BEARING] *= BEARING_FILL
    return {name: count * masses[name] for name, count in counts.items()}


def place_rv_parts(reducer: RvReducer, crank: float = 0.0) -> Iterator[PlacedPart]:
    """Yield all parts of an RV reducer with their positions at a crank angle [rad] against the ring, which is at rest.

    Each part is in the middle of its clearances, so no parts touch.
    """
    kinematics, axial, origin = reducer.kinematics, axial_layout(reducer), (0.0, 0.0, 0.0)
    carrier_angle = crank / float(kinematics.crank_per_carrier)
    sun_angle = crank / float(kinematics.crank_per_sun)
    planet_middle = axial.planet_middle
    yield PlacedPart(names.HOUSING, names.HOUSING, origin, 0.0, names.HOUSING)
    for flange in FLANGES:
        yield PlacedPart(flange, flange, origin, carrier_angle, CARRIER)
    yield PlacedPart(SUN, SUN, (0.0, 0.0, planet_middle), sun_angle, SUN)
    yield from place_discs(reducer, crank, carrier_angle)
    for number, (x, y) in enumerate(reducer.stage.crank_positions([crank])[0].tolist(), start=1):
        crank_name = names.numbered_name(CRANK, number)
        yield PlacedPart(crank_name, CRANK, (x, y, 0.0), crank, crank_name)
        angle = crank + planet_angle(reducer)
        yield PlacedPart(names.numbered_name(PLANET, number), PLANET, (x, y, planet_middle), angle, crank_name)
        for bearing, ends in enumerate(crank_bearing_ends(reducer), start=2 * number - 1):
            name = names.numbered_name(TAPERED_BEARING, bearing)
            yield PlacedPart(name, TAPERED_BEARING, (x, y, sum(ends) / 2.0), carrier_angle, CARRIER)
        yield from _place_needles(reducer, number, (x, y), crank)
    if reducer.design.ring.kind == "pin":
        yield from place_ring_pins(reducer, 0.0)
    if main_bearing := reducer.main_bearing:
        thickness = stop_ring_thickness(reducer, main_bearing)
        middles = {names.OUTPUT_BEARING: 0.5 * sum(main_bearing_ends(reducer, main_bearing))}
        middles |= {names.STOP_RING: flange_face(reducer) + 0.5 * thickness} if thickness else {}
        for part, middle in middles.items():
            for name, z in zip(names.all_numbered(part, 2), (-middle, middle), strict=True):
                yield PlacedPart(name, part, (0.0, 0.0, z), 0.0, names.HOUSING)


def _place_needles(
    reducer: RvReducer, crank_number: int, axis: tuple[float, float], crank: float
) -> Iterator[PlacedPart]:
    """Yield the positions of the needles on each eccentric of a crank, evenly spaced.

    Parameters
    ----------
    reducer
        The reducer.
    crank_number
        Number of the crank from 1.
    axis
        Axis of the crank (x, y) [m].
    crank
        Crank angle against the ring [rad].
    """
    gear, cranks = reducer.design.gear, reducer.cranks
    angles = 2.0 * np.pi * np.arange(cranks.needles) / cranks.needles - crank
    needle_offsets = reducer.needle_circle_radius * unit(angles)
    first_number = (crank_number - 1) * cranks.needles * gear.discs + 1
    for disc, (phase, plane) in enumerate(zip(reducer.phases, gear.disc_planes, strict=True)):
        centre = np.array(axis) + gear.eccentricity * unit(-(crank + phase))
        for needle, (x, y) in enumerate((centre + needle_offsets).tolist()):
            name = names.numbered_name(NEEDLE, first_number + disc * cranks.needles + needle)
            yield PlacedPart(name, NEEDLE, (x, y, plane), crank, NEEDLE)
