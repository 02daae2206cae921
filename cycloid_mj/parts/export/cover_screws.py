"""Choice of the screws that join both covers of a drive, and of the dowels between covers and ring."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.design import stock
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    counterbore,
    is_plastic,
    min_grip,
    stock_screw_length,
    thickest_bolt,
)
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import wall_radius


@dataclass(frozen=True)
class Screws:
    """Screws of the covers: bolt, length and circle radius [m], and angles clockwise from +y [rad].

    `outside`: they pass next to the ring, which then has a seat in the motor cover.
    """

    bolt: stock.Bolt
    length: float
    circle: float
    angles: tuple[float, ...]
    outside: bool

    @property
    def hole(self) -> float:
        """Radius of the through hole [m]."""
        return 0.5 * stock.bolt_hole(self.bolt.thread)

    def centres(self) -> Array:
        """Compute the centres of the screws (n, 2) [m]."""
        return self.circle * unit(np.array(self.angles))


def choose_cover_screws(reducer: Reducer, wall: float) -> Screws:
    """Choose the thickest cover screws that fit in the wall of the ring, between its pins.

    If no screws fit or none are long enough, the screws are outside of the ring. `wall` [m] is the minimum wall around
    holes. The result has the screw in stock, its length, the radius of the circle of screws and their angles.
    """
    design = reducer.design
    ring, housing = design.ring, design.housing
    head_wall = wall if is_plastic(reducer) else max(0.5 * wall - RULES.head_play, 0.5 * RULES.min_wall)
    for bolt in _stock_bolts(housing.outer_radius, is_plastic(reducer)):
        hole_radius, head_radius = 0.5 * stock.bolt_hole(bolt.thread), counterbore(bolt)
        if housing.support == "bolts":
            angles = tuple(2.0 * math.pi * number / housing.bolts for number in range(housing.bolts))
            circle = design.bolt_circle_radius
            outside_margin = max(hole_radius + wall, head_radius + head_wall)
            does_fit = (
                circle - design.ring_root_radius >= hole_radius + wall
                and housing.outer_radius - circle >= outside_margin
            )
        else:
            circle, angles = housing.outer_radius - max(hole_radius, head_radius) - head_wall, _land_angles(ring.teeth)
            pin_and_screw = unit(np.array([0.0, math.pi / ring.teeth])) * np.array([[ring.pin_circle_radius], [circle]])
            does_fit = (
                ring.kind == "pin"
                and math.dist(*pin_and_screw.tolist()) >= ring.pin_radius + design.socket_play + hole_radius + wall
                and circle - hole_radius - wall >= wall_radius(design)
            )
        if does_fit and stock.bolt_length(bolt.thread, _min_cover_screw_length(bolt, wall, design.gear.stack_width)):
            return _screws_of_length(bolt, circle, angles, wall, design.gear.stack_width)
    bolt = thickest_bolt(RULES.thread_share * housing.outer_radius, inserted=is_plastic(reducer))
    circle = housing.outer_radius + max(0.5 * stock.bolt_hole(bolt.thread), counterbore(bolt)) + wall
    angles = tuple(2.0 * math.pi * number / RULES.max_screws for number in range(RULES.max_screws))
    return _screws_of_length(bolt, circle, angles, wall, 0.0)


def _stock_bolts(radius: float, inserted: bool) -> Iterator[stock.Bolt]:
    """Yield the screws in stock, the thickest for a cover radius [m] first; if `inserted`, only those with inserts."""
    thickest = thickest_bolt(RULES.thread_share * radius, inserted=inserted)
    usable_bolts = (bolt for bolt in reversed(stock.bolts()) if not inserted or stock.insert_of(bolt.thread))
    yield from (bolt for bolt in usable_bolts if bolt.thread <= thickest.thread)


def _land_angles(teeth: int) -> tuple[float, ...]:
    """Return the angles [rad] of screws between pins, clockwise from +y; at least two lands stay free for dowels."""
    count = max(min(RULES.max_screws, teeth - 2), 2)
    return tuple(2.0 * math.pi * (number * teeth // count + 0.5) / teeth for number in range(count))


def _min_cover_screw_length(bolt: stock.Bolt, wall: float, ring_width: float) -> float:
    """Compute the minimum length of a screw through a cover and a ring, wide as the discs, into the other cover [m]."""
    return min_grip(bolt, wall) + ring_width + RULES.engagement * bolt.thread


def _screws_of_length(
    bolt: stock.Bolt, circle: float, angles: tuple[float, ...], wall: float, ring_width: float
) -> Screws:
    """Return screws on a circle of a radius [m], with the shortest length in stock for a ring `ring_width` [m] wide."""
    length = stock_screw_length(bolt, _min_cover_screw_length(bolt, wall, ring_width))
    return Screws(bolt, length, circle, angles, outside=not ring_width)


def _thickest_dowel(max_diameter: float, max_length: float) -> stock.Dowel | None:
    """Return the thickest dowel in stock up to a diameter and a length [m]; None without one."""
    sizes = [size for size in reversed(stock.dowel_diameters()) if size <= max_diameter]
    dowels = [stock_pins[0] for size in sizes if (stock_pins := stock.pins(size, 2.0 * size))]
    return next((candidate for candidate in dowels if candidate.length <= max_length), None)


def choose_dowels(reducer: Reducer, screws: Screws, wall: float) -> tuple[stock.Dowel | None, tuple[float, ...], float]:
    """Choose two dowels for each face between covers and ring; return dowel, angles [rad] and circle radius [m].

    They are opposite each other between the screws. If the screws are outside of the ring, the dowels are in the wall
    of the ring and keep it from turning. If that wall is too thin, the dowels are on the circle of the screws and
    centre the covers on each other. The dowel is None if none in stock fits. `wall` [m] is the minimum wall.
    """
    design = reducer.design
    thread, ring_wall = screws.bolt.thread, design.housing.outer_radius - design.ring_root_radius - 2.0 * wall
    dowel = _thickest_dowel(min(thread, ring_wall) if screws.outside else thread, design.gear.stack_width - wall)
    if not dowel and screws.outside:
        dowel = _thickest_dowel(thread, 2.0 * thread)
        half_pitch = math.pi / len(screws.angles)
        return dowel, (half_pitch, half_pitch + math.pi), screws.circle
    if not dowel:
        return None, (), 0.0
    if screws.outside or design.housing.support == "bolts":
        half_pitch = math.pi / len(screws.angles)
        angles = half_pitch, half_pitch + 2.0 * math.pi * (len(screws.angles) // 2) / len(screws.angles)
        mid_radius = 0.5 * (design.ring_root_radius + design.housing.outer_radius)
        return dowel, angles, mid_radius if screws.outside else screws.circle
    teeth = design.ring.teeth
    free_lands = sorted({*range(teeth)} - {round(angle * teeth / (2.0 * math.pi) - 0.5) for angle in screws.angles})
    opposite_land = min(free_lands[1:], key=lambda land: abs(land - free_lands[0] - 0.5 * teeth))
    return (
        dowel,
        tuple(2.0 * math.pi * (land + 0.5) / teeth for land in (free_lands[0], opposite_land)),
        screws.circle,
    )
