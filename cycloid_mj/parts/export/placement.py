"""Positions of the parts that every layout has: discs on their eccentrics, and ring pins."""

from collections.abc import Iterator

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts.export.step import PlacedPart
from cycloid_mj.reducer import Reducer


def place_rotated(name: str, part: str, origin: Array, angle: float, body: str) -> PlacedPart:
    """Return a part that a body carries at `origin` (3,) [m] in its frame, with the body rotated by an angle [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y, z = origin
    return PlacedPart(name, part, (float(cos * x - sin * y), float(sin * x + cos * y), float(z)), angle, body)


def place_discs(reducer: Reducer, crank: float, carrier_angle: float) -> Iterator[PlacedPart]:
    """Yield the discs, rotated with the carrier [rad], on their eccentrics at a crank angle [rad]."""
    gear = reducer.design.gear
    for name, phase, plane in zip(reducer.gears, reducer.phases, gear.disc_planes, strict=True):
        x, y = gear.eccentricity * unit(-(crank + phase))  # unit turns clockwise, the crank the other way
        yield PlacedPart(name, name, (float(x), float(y), plane), carrier_angle, name)


def ring_pin_centres(reducer: Reducer, ring_angle: float) -> list[list[float]]:
    """Return the centres of the ring pins as pairs x, y [m], in a ring rotated by an angle [rad]."""
    ring = reducer.design.ring
    angles = 2.0 * np.pi * np.arange(ring.teeth) / ring.teeth - ring_angle
    centres: list[list[float]] = (ring.pin_circle_radius * unit(angles)).tolist()
    return centres


def place_ring_pins(reducer: Reducer, ring_angle: float, pieces: tuple[int, float] = (1, 0.0)) -> Iterator[PlacedPart]:
    """Yield the positions of the ring pins or sleeves, in a ring rotated counter-clockwise by `ring_angle` [rad].

    `pieces` are the number of pieces in line that form a pin, and the length [m] of a piece.
    """
    pins_in_line, length = pieces
    heights = length * (np.arange(pins_in_line) - 0.5 * (pins_in_line - 1))
    body = names.PIN if reducer.design.seat_pair else names.HOUSING
    centres = [(x, y, z) for z in heights.tolist() for x, y in ring_pin_centres(reducer, ring_angle)]
    for number, origin in enumerate(centres, start=1):
        yield PlacedPart(names.pin(number), names.PIN, origin, ring_angle, body)
