"""Choice of rolling bearings in stock for the shaft, and the fits of bearings and dowels."""

import math

from cycloid_mj.base import names
from cycloid_mj.design import fits, stock
from cycloid_mj.parts import lay_out_parts, sleeve_core_radius
from cycloid_mj.parts.cam_bearing import cam_bearing, needs_ringed_cam, needs_rings
from cycloid_mj.parts.export.casing import (
    bearing_width_of,
)
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    axial_play,
    is_plastic,
    is_printed,
    ring_end,
    stock_shaft_bearing,
)
from cycloid_mj.reducer import Reducer, once

DOWEL_FIT, PIN_FIT = "m6 in H7", "m6 in N7"
"""Fits of locating dowels (ISO 8734, m6), and of pins that carry load by their press fit, for which H7 may be loose."""

GAUGE_FIT = "js5 in R7"
"""Fit of a pin gauge that carries load by its press fit, as tight as `PIN_FIT`; its +-2 um are within js5."""

RETAINED_FIT, FREE_FIT = "glued: its socket is open", "free in its socket"
"""Seats of ring pins in half-open sockets: a press fit would push them out; free pins roll. Neither is a dowel, which
is thicker than its nominal size by more than the teeth have clearance."""

ROLLER_FIT = "E8/m6"
"""Fit of a roller that turns on a dowel: 8 to 34 um of play on 5 mm; F8/m6 may be tight."""

SEALS = "-2RS1"
"""Suffix of the designation of ball bearings with seals (SKF)."""

HUB_BEARING_FIT = "H7 outside, k6 on the hub, sealed (2RS1)"
"""Fit of the ball bearings of the output, whose seals keep the grease in."""

ANGULAR_HUB_FIT = "H6 outside, k5 on the hub, back to back, light preload, greased; the flange covers a gap"
"""Fit of the angular contact bearings of the output, which have no seals."""

CROSSED_ROLLER_FIT = "H7 outside, g5 on the hub, clamped by the retainer and the flange"
"""Fit of a preloaded crossed roller bearing (CC0) in a joint of a robot, without interference (THK, No. 382-3E)."""

LIGHT_BORE = 18e-3
"""Bore up to which inner rings of ball bearings have the fit j5, above it k5 [m] (SKF, Rolling bearings, 2018)."""

NEEDLE_BORE = "F8"
"""Zone of the bore of a drawn-cup needle bearing in its seat (SKF; ISO 3245)."""

DOWEL_MATERIAL = "hardened steel"
"""Material of dowels of ISO 8734, type A: 550 to 650 HV."""

SHAFT_BEARINGS = 2
"""Number of bearings of the shaft."""


def adhesive_of(on_plastic: bool) -> str:
    """Return the adhesive of a joint in words: anaerobic compounds cure on metals only."""
    return "two-part epoxy" if on_plastic else "retaining compound"


def shaft_bearing(reducer: Reducer) -> stock.StockBearing | None:
    """Return the bearing in stock for both seats of the shaft; None if none has its size."""
    return stock_shaft_bearing(reducer, bearing_width_of(reducer))


@once
def roller_bearing(reducer: Reducer) -> tuple[stock.StockBearing, int] | None:
    """Return the drawn-cup needle bearing in each roller of the output pins, and how many are side by side.

    None for sliding sleeves, or if no needle bearing on the core pin leaves a wall of the roller. Of several, it is the
    one with the load rating that the design states, or else the one that fills the roller best.
    """
    design = reducer.design
    output, width = design.output, design.gear.face_width
    if not (output.has_needles and output.has_roller_parts):
        return None
    max_outside = 2.0 * (output.pin_radius - RULES.min_wall)
    cups = [
        cup
        for cup in stock.needle_bearings()
        if abs(cup.bore - 2.0 * output.root_radius) < stock.ROUNDING and cup.outside < max_outside + stock.ROUNDING
    ]
    required_rating = design.bearing.output_dynamic_capacity
    choices = [choice for cup in cups if (choice := stock.side_by_side([cup], width))]
    with_rating = [choice for choice in choices if required_rating and _has_rating(choice, required_rating)]
    return with_rating[0] if with_rating else stock.side_by_side(cups, width)


def _has_rating(choice: tuple[stock.StockBearing, int], rating: float) -> bool:
    """Return whether bearings side by side have a dynamic load rating [N] together (ISO 281: i^(7/9) C)."""
    bearing, count = choice
    return math.isclose(count ** (7.0 / 9.0) * bearing.dynamic, rating, rel_tol=1e-3)


def roller_tube(reducer: Reducer) -> stock.Tube | None:
    """Return the tube in stock for the rollers of a drive of plastic; None for others, which are turned.

    The outside of such a tube is soft, and its diameter deviates by up to 0.08 mm: enough for discs of plastic.
    """
    output = reducer.design.output
    if not (is_plastic(reducer) and output.has_roller_parts) or is_printed(reducer, names.OUTPUT):
        return None
    cup = roller_bearing(reducer)
    bore = cup[0].outside if cup else 2.0 * output.root_radius
    return stock.tube_for(2.0 * output.pin_radius, bore)


def bearing_clearances(reducer: Reducer) -> dict[str, tuple[str, float]]:
    """Return the fit and the mean radial clearance [m] of needle bearings of cams, and of rollers of output pins.

    The keys are those of the clearances of a design, ``cam`` and ``output``, to which these add; without such a bearing
    or roller a key is missing. Bearings with an inner ring are left out.
    """
    output, sizes = reducer.design.output, {}
    if (cam := cam_bearing(reducer)) and not stock.has_inner_ring(cam[0]):
        sizes["cam"] = f"{NEEDLE_BORE}/h5", cam[0].bore
    if output.has_roller_parts:
        fit = f"{NEEDLE_BORE}/m6" if roller_bearing(reducer) else ROLLER_FIT
        sizes["output"] = fit, 2.0 * output.root_radius
    return {key: (fit, 0.25 * sum(fits.clearances(fit, size))) for key, (fit, size) in sizes.items()}


def roller_bore(reducer: Reducer) -> float:
    """Return the bore radius of a roller in a drive [m]: of its needle bearing, or with the mean play on the pin."""
    if cup := roller_bearing(reducer):
        return 0.5 * cup[0].outside
    radius = reducer.design.output.root_radius
    return radius + 0.25 * sum(fits.clearances(ROLLER_FIT, 2.0 * radius))


def free_pin(reducer: Reducer) -> stock.Roller | None:
    """Return the roller in stock for the ring pins in sockets between the covers; None if no roller has their size.

    Dowels are not used: their radius is 2 to 6 um above the nominal size, so that they would jam in a socket.
    """
    design = reducer.design
    return stock.free_pin(2.0 * design.ring.pin_radius, 2.0 * ring_end(reducer), axial_play(reducer))


def ring_pin_limits(reducer: Reducer) -> tuple[float, float]:
    """Return the lower and upper deviation of the diameter of bought ring pins without sleeves [m]."""
    roller = free_pin(reducer)
    return roller.limits if roller else stock.ROLLER_LIMITS


def ring_pin_radius(reducer: Reducer) -> float:
    """Return the radius of ring pins or sleeves in a drive [m]; of bought pins the middle of their tolerance zone."""
    ring = reducer.design.ring
    is_made = ring.has_sleeves or is_printed(reducer, names.PIN)
    return ring.pin_radius + (0.0 if is_made else 0.25 * sum(ring_pin_limits(reducer)))


def sleeve_pin_depth(reducer: Reducer) -> float:
    """Compute how deep the pin inside a sleeve is pressed into each cover [m]: as deep as its diameter."""
    return 2.0 * sleeve_core_radius(reducer)


def press_fit(diameter: float, length: float) -> str:
    """Return the fit of a pressed-in pin of a diameter and total length [m], by the pin in stock for it."""
    pin = stock.single_pin(diameter, length)
    return GAUGE_FIT if pin and pin.designation.startswith(stock.GAUGES) else PIN_FIT


def output_pin_span(reducer: Reducer) -> tuple[float, float]:
    """Return the ends of an output pin [m], including its pressed-in lengths."""
    output, drawn_pin = reducer.design.output, lay_out_parts(reducer)[names.OUTPUT].segments[1]
    return drawn_pin.z0 - output.disc_thickness * (output.support == "both_ends"), drawn_pin.z1 + output.disc_thickness


def output_pin_length(reducer: Reducer) -> float:
    """Compute the length of an output pin through discs and gaps, including its pressed-in lengths [m]."""
    start, end = output_pin_span(reducer)
    return end - start


def output_pin(reducer: Reducer) -> stock.Dowel | None:
    """Return the pin in stock for the output pins; None if no pin has their size.

    A pin under a roller is a dowel. So is a pin on which a disc slides, if the upper deviation of its diameter does not
    exceed the clearance of the disc's holes; otherwise it is a pin gauge.
    """
    output, length = reducer.design.output, output_pin_length(reducer)
    diameter = 2.0 * output.root_radius
    has_room_for_dowel = reducer.design.clearance.output >= fits.limits("m6", diameter)[1]
    if output.rollers or has_room_for_dowel:
        return stock.single_pin(diameter, length)
    return stock.pin_gauge(diameter, length)


def output_pin_fit(reducer: Reducer) -> str:
    """Return the fit of the output pins in the discs of the output."""
    pin = output_pin(reducer)
    return GAUGE_FIT if pin and pin.designation.startswith(stock.GAUGES) else PIN_FIT


def sleeve_pin_length(reducer: Reducer) -> float:
    """Compute the length [m] of the pin inside a sleeve, which stands in both covers by `sleeve_pin_depth`."""
    return 2.0 * (ring_end(reducer) + sleeve_pin_depth(reducer))


def sleeve_pin_fit(reducer: Reducer) -> str:
    """Return the fit of the pins inside sleeves in the covers."""
    return press_fit(2.0 * sleeve_core_radius(reducer), sleeve_pin_length(reducer))


def pin_pieces(reducer: Reducer) -> tuple[int, float]:
    """Return the number of pieces in line that form each ring pin or sleeve of a drive, and the length of a piece [m].

    Only bought ring pins have several pieces, in a ring that is wider than the longest pin in stock.
    """
    ring, width = reducer.design.ring, reducer.design.gear.stack_width
    if ring.has_sleeves or is_printed(reducer, names.PIN):
        return 1, width
    stock_pin = free_pin(reducer)
    return (stock_pin.count, stock_pin.used_length) if stock_pin else (1, width)


def hub_bearing_fit(bearing: stock.StockBearing) -> str:
    """Return the fit of the bearings of the output."""
    if bearing.has_crossed_rollers:
        return CROSSED_ROLLER_FIT
    return ANGULAR_HUB_FIT if bearing.contact_angle else HUB_BEARING_FIT


def hub_bearing_designation(bearing: stock.StockBearing) -> str:
    """Return the designation to order for the bearings of the output: deep groove bearings with a seal at each end."""
    is_deep_groove = bearing.has_balls and not bearing.contact_angle
    return bearing.designation + (SEALS if is_deep_groove else "")


def cam_bearing_fit(reducer: Reducer, bearing: stock.StockBearing) -> str:
    """Return the zone of the bore of a disc for the bearing of its cam."""
    return "H7" if stock.has_inner_ring(bearing) else cup_fit(reducer, names.GEAR)


def cup_fit(reducer: Reducer, part: str) -> str:
    """Return the zone of the bore for a drawn cup in a part of the mechanism (ISO 3245): tighter in a plastic."""
    return "R6" if reducer.design.material_of(part).is_plastic else "N6"


def bearing_fit(reducer: Reducer, bearing: stock.StockBearing, part: str) -> str:
    """Return the fits of a bearing in stock whose outer ring is in `part`, such as "H7 outside, k5 on the crank".

    Needles run on the crank itself. The inner ring of a ball bearing has a tight fit, because it turns relative to the
    direction of the load.
    """
    if not stock.has_inner_ring(bearing):
        return f"{cup_fit(reducer, part)} outside, h5 under the needles"
    if part == names.GEAR and needs_ringed_cam(reducer) and not needs_rings(reducer):
        return "H7 outside, h5 on the slotted cam"
    if needs_rings(reducer):
        return "H7 outside, light press fit on the printed crank"
    return f"H7 outside, {'j5' if bearing.bore <= LIGHT_BORE else 'k5'} on the crank"


def shaft_bearing_fit(reducer: Reducer) -> str:
    """Return the fit of the bearings of the crank; a size out of stock gets the fit of a bearing with rings."""
    bearing = shaft_bearing(reducer)
    if bearing:
        return bearing_fit(reducer, bearing, names.HOUSING)
    return f"H7 outside, {'j5' if 2.0 * reducer.design.shaft.radius <= LIGHT_BORE else 'k5'} on the crank"


def shaft_seal(reducer: Reducer) -> str:
    """Return which ball bearings of the crank are sealed, such as "both sealed (RS1)"; empty for drawn cups.

    These are the seals that the losses include: one of a solid shaft, two of a hollow one.
    """
    bearing = shaft_bearing(reducer)
    if bearing and not stock.has_inner_ring(bearing):
        return ""
    return f"{'both' if reducer.design.shaft.bore_radius else 'the one next to the motor'} sealed (RS1)"
