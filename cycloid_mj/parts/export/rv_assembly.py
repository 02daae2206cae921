"""The assembled RV reducer: the places of its parts at a crank angle, and its colours."""

from collections import Counter
from collections.abc import Iterator, Mapping

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts.accuracy import EXPORT_CHORD_ERROR
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
    crank_centres,
    heights,
    rv_bearings,
    rv_parts,
)
from cycloid_mj.reducer import RvReducer

RV_COLOURS: Mapping[str, Colour] = {
    **COLOURS,
    CRANK: (0.75, 0.35, 0.3, 1.0),
    PLANET: (0.8, 0.5, 0.35, 1.0),
    SUN: (0.85, 0.65, 0.3, 1.0),
    CARRIER: COLOURS[names.OUTPUT],
    NEEDLE: (0.83, 0.84, 0.86, 1.0),
    TAPERED_BEARING: (0.7, 0.72, 0.75, 1.0),
}
"""Colours by family of parts."""


def rv_assembly_parts(reducer: RvReducer) -> dict[str, Part]:
    """Return all parts of the assembly by name, each once; raises the errors of `rv.rv_parts`."""
    return rv_parts(reducer) | rv_bearings(reducer)


def rv_mass(reducer: RvReducer) -> float:
    """Compute the mass of all parts of `rv_assembly_parts` in their numbers [kg]; raises the same errors."""
    counts = Counter(place.part for place in rv_places(reducer))
    parts = rv_assembly_parts(reducer)
    return sum(count * mass_properties(parts[name].solid(EXPORT_CHORD_ERROR)).mass for name, count in counts.items())


def rv_places(reducer: RvReducer, crank: float = 0.0) -> Iterator[PlacedPart]:
    """Yield the places of all parts at a crank angle [rad] against the ring, which is drawn at rest.

    All clearances are centred, so nothing touches.
    """
    kinematics = reducer.kinematics
    carrier = crank / float(kinematics.crank_per_carrier)
    sun = crank / float(kinematics.crank_per_sun)
    along = heights(reducer)
    middle = sum(along.planets) / 2.0
    yield PlacedPart(names.HOUSING, names.HOUSING, (0.0, 0.0, 0.0), 0.0, names.HOUSING)
    for flange in FLANGES:
        yield PlacedPart(flange, flange, (0.0, 0.0, 0.0), carrier, CARRIER)
    yield PlacedPart(SUN, SUN, (0.0, 0.0, middle), sun, SUN)
    yield from _discs(reducer, crank, carrier)
    cos, sin = np.cos(carrier), np.sin(carrier)
    planet_teeth = reducer.planet.planet_teeth
    # at the crank angle 0 a tooth of planet 1 points to the sun's tooth space on +y
    first_tooth = np.pi - np.pi / planet_teeth
    for number, (x, y) in enumerate(crank_centres(reducer).tolist(), start=1):
        at = float(cos * x - sin * y), float(sin * x + cos * y)
        own = names.numbered_name(CRANK, number)
        yield PlacedPart(own, CRANK, (*at, 0.0), crank, own)
        yield PlacedPart(names.numbered_name(PLANET, number), PLANET, (*at, middle), crank + first_tooth, own)
        for side, ends in zip((1, 2), along.flanges, strict=True):
            name = f"{TAPERED_BEARING}_{2 * (number - 1) + side}"
            yield PlacedPart(name, TAPERED_BEARING, (*at, sum(ends) / 2.0), carrier, CARRIER)
        yield from _needles(reducer, number, at, crank)
    ring = reducer.design.ring
    if ring.kind == "pin":
        angles = 2.0 * np.pi * np.arange(ring.teeth) / ring.teeth
        for number, (x, y) in enumerate((ring.pin_circle_radius * unit(angles)).tolist(), start=1):
            yield PlacedPart(names.pin(number), names.PIN, (x, y, 0.0), 0.0, names.PIN)


def _discs(reducer: RvReducer, crank: float, carrier: float) -> Iterator[PlacedPart]:
    """Yield the places of the discs, which turn with the carrier on the eccentrics."""
    gear = reducer.design.gear
    for name, phase, plane in zip(reducer.gears, reducer.phases, gear.disc_planes, strict=True):
        x, y = gear.eccentricity * unit(-(crank + phase))  # unit turns clockwise, the crank the other way
        yield PlacedPart(name, name, (float(x), float(y), plane), carrier, name)


def _needles(reducer: RvReducer, crank_number: int, axis: tuple[float, float], crank: float) -> Iterator[PlacedPart]:
    """Yield the places of the needles of a crank, evenly spaced around each of its eccentrics."""
    gear, cranks = reducer.design.gear, reducer.cranks
    pitch_radius = cranks.eccentric_radius + cranks.needle_radius
    around = pitch_radius * unit(2.0 * np.pi * np.arange(cranks.needles) / cranks.needles - crank)
    first = (crank_number - 1) * cranks.needles * gear.discs + 1
    for disc, (phase, plane) in enumerate(zip(reducer.phases, gear.disc_planes, strict=True)):
        centre = np.array(axis) + gear.eccentricity * unit(-(crank + phase))
        for needle, (x, y) in enumerate((centre + around).tolist()):
            name = names.numbered_name(NEEDLE, first + disc * cranks.needles + needle)
            yield PlacedPart(name, NEEDLE, (x, y, plane), crank, NEEDLE)
