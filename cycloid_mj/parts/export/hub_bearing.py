"""Choice of the bearings of the output in stock, around the hub or around its discs, and the seats of the discs."""

import math
from operator import itemgetter

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.design import stock
from cycloid_mj.parts import sleeve_core_radius
from cycloid_mj.parts.export.bearing_retainer import StopRing, retainer_of
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    counterbore,
    is_plastic,
    least_wall,
    ring_end,
)
from cycloid_mj.parts.export.cover_screws import Screws
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP


def choose_hub_bearing(
    reducer: Reducer, screws: Screws, seat: float, rim: float, stop_ring_radius: float
) -> stock.StockBearing:
    """Choose the largest bearing of the output that fits between the cover screws and the hub or the output pins.

    Parameters
    ----------
    reducer, screws
        The reducer, and the screws of its covers.
    seat, rim
        Radii of the seats of the shaft bearings, and of the output's disc [m].
    stop_ring_radius
        Outer radius of a stop ring [m], if the bearings need one.

    Raises
    ------
    DesignError
        No bearing in stock fits, or the design does not permit the seats that it requests.
    """
    design, wall = reducer.design, least_wall(reducer)
    max_radius = screws.circle - counterbore(screws.bolt) - 2.0 * wall
    bearings, max_seat = _hub_bearings(reducer, max_radius, wall), design.ring_root_radius
    if has_both_seats(reducer):
        _require_both_seats(reducer, stop_ring_radius)
        max_seat = design.pin_retaining_radius
        if needs_stop_ring(reducer):
            bearings = tuple(bearing for bearing in bearings if bearing.shoulders[1] <= max_seat)
            max_seat = stop_ring_radius - wall
    if not design.output.has_disc_seat:
        min_bore = seat + 2.0 * wall if design.shaft.mounting == "straddle" else 0.0
        return _choose_largest(bearings, min(max_radius, max_seat), rim - wall, min_bore)
    if design.ring.has_sleeves:
        max_seat = min(max_seat, design.ring.pin_circle_radius - sleeve_core_radius(reducer) - wall)
    pin_wall = RULES.min_printed_wall if is_plastic(reducer) else RULES.min_wall  # the inner ring supports it
    pins_end = design.output.pin_circle_radius + design.output.root_radius + pin_wall
    return _choose_largest(bearings, min(max_radius, max_seat), math.inf, pins_end)


def _choose_largest(
    bearings: tuple[stock.StockBearing, ...], max_radius: float, max_bore_radius: float, min_bore_radius: float
) -> stock.StockBearing:
    """Choose the largest bearing that fits on the hub of the output and into its cover.

    Parameters
    ----------
    bearings
        Bearings in stock, the smallest first.
    max_radius
        Largest outer radius [m].
    max_bore_radius, min_bore_radius
        Largest and smallest radius of the bore [m]; the largest is infinite for a bearing around the output disc.

    Raises
    ------
    DesignError
        None of the bearings fits.
    """
    for bearing in reversed(bearings):
        if bearing.outside <= 2.0 * max_radius and 2.0 * min_bore_radius <= bearing.bore <= 2.0 * max_bore_radius:
            return bearing
    if math.isinf(max_bore_radius):
        raise DesignError(
            "no standard bearing, with the space that it needs, fits around the output disc: its bore must be at least "
            f"{2e3 * min_bore_radius:.4g} mm and its outside diameter at most {2e3 * max_radius:.4g} mm. Choose a "
            'smaller circle of output pins, a larger outer diameter, or output.main_bearing_seat = "hub"'
        )
    raise DesignError(
        f"no standard bearing fits the hub of the output: it needs a bore of {2e3 * min_bore_radius:.4g} to "
        f"{2e3 * max_bore_radius:.4g} mm and an outside diameter of at most {2e3 * max_radius:.4g} mm. Choose a larger "
        "outer diameter, or a thinner shaft (shaft.radius_mm)"
    )


def _hub_bearings(reducer: Reducer, max_radius: float, wall: float) -> tuple[stock.StockBearing, ...]:
    """Return the stock bearings for the output, of the kind that the design requires, in order of preference.

    The best is last: the largest. Crossed roller bearings whose retainer ends a minimum wall inside of the heads of the
    cover screws are better than those whose retainer reaches up to the heads. Other bearings are not yet checked for
    fit. `max_radius` [m] is two minimum walls, `wall` [m] each, inside of the heads.
    """
    kind = reducer.design.output.main_bearings
    if kind == "crossed_roller":
        retainers = ((bearing, retainer_of(reducer, bearing, wall)) for bearing in stock.crossed_roller_bearings())
        fitting_bearings = [
            (retainer.cover_radius <= max_radius + wall, bearing)
            for bearing, retainer in retainers
            if retainer and retainer.cover_radius <= max_radius + 2.0 * wall
        ]
        # the sort is stable: it keeps the order of sizes
        return tuple(bearing for _, bearing in sorted(fitting_bearings, key=itemgetter(0)))
    bearings_by_kind = {
        "deep_groove": stock.thin_ball_bearings,
        "angular_contact": stock.angular_contact_bearings,
        "tapered": stock.tapered_bearings,
    }
    return bearings_by_kind[kind]()


def has_both_seats(reducer: Reducer) -> bool:
    """Return whether a bearing is around each of the two discs of the output."""
    return reducer.design.output.main_bearing_seat == "both_discs"


def needs_stop_ring(reducer: Reducer) -> bool:
    """Return whether bearings with a contact angle are around both discs of the output, back to back on a stop ring."""
    return has_both_seats(reducer) and reducer.design.output.main_bearings in ("angular_contact", "tapered")


def _require_both_seats(reducer: Reducer, stop_ring_radius: float) -> None:
    """Raise DesignError if a design cannot have bearings around both output discs, the flanges of the output pins.

    It needs a second output disc, which supports the pins, and paired bearings; with a contact angle, also space for a
    stop ring, whose outer radius is at most `stop_ring_radius` [m].
    """
    design = reducer.design
    if design.output.support != "both_ends" or design.output.main_bearings == "crossed_roller":
        raise DesignError(
            "bearings around both discs of the output need a second output disc, and must be ball or tapered roller "
            "bearings, because a single crossed roller bearing carries forces and moments alone: set output.support = "
            '"both_ends" and output.main_bearings = "deep_groove", "angular_contact" or "tapered", or '
            'output.main_bearing_seat = "disc"'
        )
    if needs_stop_ring(reducer) and design.ring.has_sleeves:
        raise DesignError(
            "the pins inside the sleeves extend into both covers and leave no space for the stop ring of the bearing "
            'around the second output disc: set ring.sleeve_thickness_mm = 0, or output.main_bearings = "deep_groove"'
        )
    min_radius = design.ring_root_radius + (RULES.min_printed_wall if is_plastic(reducer) else RULES.min_wall)
    if needs_stop_ring(reducer) and stop_ring_radius < min_radius - stock.ROUNDING:
        raise DesignError(
            "the stop ring of the bearing around the second output disc does not fit between the ring pins and the "
            f"screws and dowels of the covers: it needs a diameter of {MILLIMETRES * 2.0 * min_radius:.4g} mm, but "
            f"{MILLIMETRES * 2.0 * stop_ring_radius:.4g} mm are available. Increase housing.outer_radius_mm, or set "
            'output.main_bearings = "deep_groove"'
        )


def seat_second_disc(
    reducer: Reducer, hub: stock.StockBearing, stop_ring: StopRing | None, wall: float
) -> tuple[float, float]:
    """Return the ends along z [m] of the bearing `hub` around the second disc of the output.

    The inner ring of a deep groove bearing is against a shoulder of two walls, `wall` [m] each, next to the cycloid
    discs. With a stop ring, bearings are back to back: the shoulder is at the other side of the inner ring, and the
    stop ring next to the outer one.

    Raises
    ------
    DesignError
        The disc is too thin for the bearing.
    """
    thickness, half_width = reducer.design.output.disc_thickness, reducer.design.gear.stack_width / 2.0
    disc_start = half_width + AXIAL_GAP
    start = ring_end(reducer) + stop_ring.thickness if stop_ring else disc_start + 2.0 * wall
    min_thickness = start + hub.width - disc_start + (2.0 * wall if stop_ring else 0.0)
    if thickness < min_thickness - stock.ROUNDING:
        raise DesignError(
            f"the discs of the output are too thin for the bearings of {MILLIMETRES * hub.width:g} mm around them: set "
            f"output.disc_thickness_mm to at least {MILLIMETRES * min_thickness:.4g}"
        )
    return -start - hub.width, -start


def count_cover_bearings(hub: stock.StockBearing, motor_bearing: tuple[float, float] | None) -> int:
    """Return the number of bearings of the output in its cover: 1 with crossed rollers or one around each disc, else 2.

    `motor_bearing` has the ends of the bearing around the second disc [m]; None without.
    """
    return 1 if motor_bearing or hub.has_crossed_rollers else 2
