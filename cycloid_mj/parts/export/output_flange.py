"""Pattern of the output flange: its screws, the threads for the load, and the dowels of a flange of plastic."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import stock
from cycloid_mj.parts.export.bearing_retainer import Retainer
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    axial_play,
    flange_washer,
    hole_depth,
    in_one_piece,
    is_plastic,
    least_wall,
    stock_screw_length,
    thickest_bolt,
    thread_radius,
)
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class OutputFlange:
    """Sizes of the output flange and its joint with the hub [m].

    Attributes
    ----------
    flange_bolt, flange_thickness, flange_screws, flange_circle, flange_phase
        Screws of the output flange, its thickness, and number, circle radius and first angle [rad] of the screws.
    flange_dowel, flange_dowel_circle
        Dowels of hub and flange, as many as screws (None: friction alone), and the radius of their circle.
    hub_bore, flange_bore
        Largest radii of bores on the axis of hub and flange, inside screws and dowels.
    """

    flange_bolt: stock.Bolt
    flange_thickness: float
    flange_screws: int
    flange_circle: float
    flange_phase: float
    flange_dowel: stock.Dowel | None
    flange_dowel_circle: float
    hub_bore: float
    flange_bore: float


def size_output_flange(
    reducer: Reducer, hub: stock.StockBearing, retainer: Retainer | None, lip_height: float
) -> OutputFlange:
    """Choose screws, dowels and thickness of the output flange.

    The flange is on the hub of the output, or on the output's disc if the output bearings are around the discs.

    Parameters
    ----------
    reducer, hub
        The reducer, and the bearing around this hub or disc.
    retainer
        Ring around the flange, which clamps the outer ring of the bearing; None without. The flange is thicker than the
        retainer is high.
    lip_height
        Height by which the flange is thicker, to clear a lip of the output cover [m].

    Raises
    ------
    DesignError
        The screws, or the bore through a hollow shaft, do not fit.
    """
    output, wall = reducer.design.output, least_wall(reducer)
    if output.has_disc_seat:
        bolt, circle, count = choose_disc_pattern(reducer, hub, wall)
    else:
        bolt = thickest_bolt(RULES.flange_thread * hub.bore / 2.0, inserted=is_plastic(reducer))
        circle, count = choose_flange_pattern(reducer, hub, bolt, wall)
    washer_thickness = flange_washer(reducer, bolt)[1]
    thickness = hole_depth(reducer, bolt.thread, bolt.head_height + washer_thickness + max(bolt.thread, wall))
    if retainer:
        thickness = max(thickness, retainer.height + axial_play(reducer))
    dowel, dowel_circle = choose_flange_dowels(reducer, bolt, (circle, count), thickness, wall)
    hub_bore, flange_bore = axial_bores(reducer, bolt, circle, dowel, dowel_circle, wall)
    return OutputFlange(
        flange_bolt=bolt,
        flange_thickness=thickness + lip_height,
        flange_screws=count,
        flange_circle=circle,
        flange_phase=math.pi / output.pins if output.has_disc_seat else 0.0,
        flange_dowel=dowel,
        flange_dowel_circle=dowel_circle,
        hub_bore=hub_bore,
        flange_bore=flange_bore,
    )


def flange_screw_length(bolt: stock.Bolt, thickness: float) -> float:
    """Return the length of the screws of an output flange of a thickness [m]."""
    return stock_screw_length(bolt, thickness - bolt.head_height + RULES.engagement * bolt.thread)


def flange_screw_depth(reducer: Reducer, bolt: stock.Bolt, thickness: float) -> float:
    """Return the depth of the threads in the hub for the screws of an output flange of a thickness [m]."""
    return hole_depth(reducer, bolt.thread, flange_screw_length(bolt, thickness) - thickness + bolt.head_height)


def choose_flange_pattern(
    reducer: Reducer, hub: stock.StockBearing, bolt: stock.Bolt, wall: float
) -> tuple[float, int]:
    """Choose circle radius [m] and number of the flange screws in a hub, with walls around all holes.

    The number is the first of `RULES.flange_screws` that fits. `bolt` is the screw, `hub` the bearing around the hub,
    and `wall` [m] the minimum wall.

    Raises
    ------
    DesignError
        Not even the smallest number of screws fits.
    """
    hub_radius, hole_radius, head_radius = (
        0.5 * hub.bore,
        thread_radius(reducer, bolt.thread),
        flange_washer(reducer, bolt)[0],
    )
    flange_radius = hub.shoulders[0]
    circle = min(RULES.flange_circle * hub_radius, hub_radius - hole_radius - wall, flange_radius - head_radius - wall)
    min_pitch = head_radius + hole_radius + wall
    for count in RULES.flange_screws:
        if 2.0 * circle * math.sin(0.5 * math.pi / count) >= min_pitch:
            return circle, count
    raise DesignError(
        f"{RULES.flange_screws[-1]} screws {bolt.designation} and as many threads for the load do not fit in the "
        f"output flange on a hub of {2e3 * hub_radius:.4g} mm: choose a larger outer diameter, or a thinner shaft "
        "(shaft.radius_mm)"
    )


def choose_disc_pattern(reducer: Reducer, hub: stock.StockBearing, wall: float) -> tuple[stock.Bolt, float, int]:
    """Choose screw, circle radius [m] and number of the flange screws between the output pins in an output disc.

    It is the thickest screw that leaves walls around the holes of screws and pins, in each or in every second gap.

    `hub` is the bearing around the disc, and `wall` [m] the minimum wall.

    Raises
    ------
    DesignError
        No screw in stock fits between the pins.
    """
    output, disc_radius, shoulder_radius = reducer.design.output, 0.5 * hub.bore, hub.shoulders[0]
    pin_radius = 0.0 if in_one_piece(reducer) else output.root_radius
    counts = (output.pins, output.pins // 2) if output.pins % 2 == 0 and output.pins > 6 else (output.pins,)
    for bolt in sorted(stock.bolts(), key=lambda bolt: -bolt.thread):
        if bolt.thread > RULES.flange_thread * disc_radius or (
            is_plastic(reducer) and not stock.insert_of(bolt.thread)
        ):
            continue
        hole_radius, head_radius = thread_radius(reducer, bolt.thread), flange_washer(reducer, bolt)[0]
        circle = min(disc_radius - hole_radius - wall, shoulder_radius - head_radius - wall)
        pin_distance = math.dist(
            (circle * math.cos(math.pi / output.pins), circle * math.sin(math.pi / output.pins)),
            (output.pin_circle_radius, 0.0),
        )
        for count in counts:
            pitch = 2.0 * circle * math.sin(0.5 * math.pi / count)
            if pin_distance >= hole_radius + pin_radius + wall and pitch >= head_radius + hole_radius + wall:
                return bolt, circle, count
    raise DesignError(
        f"no screw of the output flange fits between the {output.pins} output pins in a disc of "
        f'{2e3 * disc_radius:.4g} mm: choose fewer or thinner output pins, or output.main_bearing_seat = "hub"'
    )


def pattern_angles(count: int) -> Array:
    """Return the angles [rad] of screws (even indices) and threads for the load (odd indices), shape (2 count,)."""
    return math.pi * np.arange(2 * count) / count


def _max_hole_reach(reducer: Reducer) -> float:
    """Return the radius [m] of holes in the hub that stays inside of the output pins; inf for a hub behind them."""
    output = reducer.design.output
    return output.pin_circle_radius - output.root_radius if output.has_disc_seat else math.inf


def axial_bores(
    reducer: Reducer, bolt: stock.Bolt, circle: float, dowel: stock.Dowel | None, dowel_circle: float, wall: float
) -> tuple[float, float]:
    """Compute the largest radii (hub, flange) [m] of bores on the axis, inside of screws and dowels.

    The hub has the threads of the screws, the flange their heads. `circle` and `dowel_circle` are the radii [m] of the
    circles of the screws, of size `bolt`, and of the dowels; `dowel` None: no dowels. `wall` [m] is the minimum wall.

    Raises
    ------
    DesignError
        The bore through a hollow shaft is larger.
    """
    dowel_limit = dowel_circle - 0.5 * dowel.diameter if dowel else math.inf
    dowel_limit = min(dowel_limit, _max_hole_reach(reducer))
    hole_radii = thread_radius(reducer, bolt.thread), flange_washer(reducer, bolt)[0]
    hub_radius, flange_radius = (min(circle - hole_radius, dowel_limit) - wall for hole_radius in hole_radii)
    bore_radius = reducer.design.shaft.bore_radius
    if bore_radius and min(hub_radius, flange_radius) < bore_radius:
        raise DesignError(
            f"a through bore of {2e3 * bore_radius:.4g} mm does not pass between the screws of the output flange, "
            f"which leave {2e3 * max(min(hub_radius, flange_radius), 0.0):.4g} mm: reduce shaft.bore_radius_mm, or "
            "choose a larger diameter"
        )
    return hub_radius, flange_radius


def choose_flange_dowels(
    reducer: Reducer, bolt: stock.Bolt, pattern: tuple[float, int], thickness: float, wall: float
) -> tuple[stock.Dowel | None, float]:
    """Choose the dowels of hub and flange in a plastic; return the dowel and the radius of their circle [m].

    A plastic keeps little of the preload of the screws, so that friction transmits less than the drive. The dowels are
    inside of the threads for the load, up to as thick as the screws, and equally deep in both parts. The dowel is None
    in a metal, or if none in stock leaves walls around all holes.

    Parameters
    ----------
    bolt, pattern
        Screws of the flange; radius of their circle [m] and their number.
    thickness
        Thickness of the flange [m].
    wall
        Minimum wall [m].
    """
    if not is_plastic(reducer):
        return None, 0.0
    screw_circle, count = pattern
    counterbore_radius = flange_washer(reducer, bolt)[0]
    depth = min(thickness - wall, 2.0 * RULES.engagement * bolt.thread)
    for diameter in reversed(stock.dowel_diameters()):
        dowel, margin = stock.longest_dowel(diameter, 2.0 * depth), 0.5 * diameter + wall
        circle = min(screw_circle - thread_radius(reducer, bolt.thread), _max_hole_reach(reducer)) - margin
        screw_distance = math.hypot(
            screw_circle - circle * math.cos(math.pi / count), circle * math.sin(math.pi / count)
        )
        half_spacing = circle * math.sin(math.pi / count)
        if (
            dowel
            and diameter <= bolt.thread
            and screw_distance >= counterbore_radius + margin
            and half_spacing >= margin
        ):
            return dowel, circle
    return None, 0.0
