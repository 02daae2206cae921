"""Choice of rolling bearings in stock for the shaft, and the fits of bearings and dowels."""

import math

from cycloid_mj.design import stock
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.parts.export.casing import axial_play, bearing_width_of, ring_end
from cycloid_mj.reducer import Reducer

PRESS_FIT, PIN_FIT, RETAINED_FIT = "m6 in H7", "m6 in N7", "m6 in H7, glued: its socket is open"
"""Fits of dowels (m6, ISO 8734): that locate covers, that carry load as pressed-in pins, and of those in half-open
sockets, whose lips a press fit would push them out of."""

NEEDLE_FIT, BALL_FIT = "N6 outside, h5 on the shaft", "H7 outside, j6 on the shaft"
"""Fits of drawn cups and of the shaft under their needles (ISO 3245), and of ball bearings with a turning shaft."""

HUB_BEARING_FIT = "H7 outside, k6 on the hub"
"""Fit of the ball bearings of the output."""

SHAFT_BEARINGS = 2
"""Number of bearings of the shaft."""

MIN_CAM_STEP = 1e-5
"""Minimum step of the cam of a single disc from the shaft [m], as outlines must not touch."""


def shaft_bearing(reducer: Reducer) -> stock.StockBearing | None:
    """Return the bearing in stock for both seats of the shaft; None if none has its size."""
    return next(iter(stock.bearings_on(2.0 * reducer.design.shaft.radius, bearing_width_of(reducer))), None)


def cam_seat(reducer: Reducer) -> float:
    """Return the radius of the cam in its bearing [m], or in the disc if it slides there.

    Where no bearing in stock fits, rollers that touch each other fill the bore of the disc, which is their outer ring
    (``contact.cam_rollers``), if they leave a cam around the shaft.
    """
    gear, bought = reducer.design.gear, cam_bearing(reducer)
    if bought:
        return round(0.5 * bought[0].bore, 9)
    ratio = math.sin(math.pi / reducer.design.contact.cam_rollers)
    raceway = gear.bore_radius * (1.0 - ratio) / (1.0 + ratio)
    thinnest = gear.eccentricity + reducer.design.shaft.radius + MIN_CAM_STEP
    return raceway if gear.bearing == "rolling" and raceway > thinnest else gear.bore_radius


def free_pin(reducer: Reducer) -> stock.Roller | None:
    """Return the roller in stock for the ring pins that move in sockets between the covers; None if none has its size.

    Dowels are for press fits: 2 to 6 um thicker than their nominal size on the radius, they would jam in a socket.
    """
    design = reducer.design
    return stock.free_pin(2.0 * design.ring.pin_radius, 2.0 * ring_end(reducer), axial_play(reducer))


def pin_pieces(reducer: Reducer) -> tuple[int, float]:
    """Return the number of ring pins or sleeves in line, and the length of each [m], between the covers of a drive."""
    design = reducer.design
    if not design.seat_pair:
        return 1, design.gear.stack_width
    free = free_pin(reducer) if design.ring.has_sockets and not design.material_of("pin").is_plastic else None
    return (free.count, free.used) if free else (1, design.gear.stack_width)


def fit_of(bearing: stock.StockBearing) -> str:
    """Return the fit of a bearing in stock, by its kind."""
    return BALL_FIT if bearing in stock.ball_bearings() else NEEDLE_FIT
