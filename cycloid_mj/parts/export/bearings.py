"""Choice of rolling bearings in stock for the shaft, and the fits of bearings and dowels."""

from cycloid_mj.design import stock
from cycloid_mj.parts.export.casing import bearing_width_of
from cycloid_mj.reducer import Reducer

PRESS_FIT, SOCKET_FIT = "m6 in H7", "m6, free in its socket"
"""Fits of dowels (m6, ISO 8734)."""

NEEDLE_FIT, BALL_FIT = "N6 outside, h5 on the shaft", "H7 outside, j6 on the shaft"
"""Fits of drawn cups and of the shaft under their needles (ISO 3245), and of ball bearings with a turning shaft."""

HUB_BEARING_FIT = "H7 outside, k6 on the hub"
"""Fit of the ball bearings of the output."""

SHAFT_BEARINGS = 2
"""Number of bearings of the shaft."""


def shaft_bearing(reducer: Reducer) -> stock.StockBearing | None:
    """Return the bearing in stock for both seats of the shaft; None if none has its size."""
    return next(iter(stock.bearings_on(2.0 * reducer.design.shaft.radius, bearing_width_of(reducer))), None)


def fit_of(bearing: stock.StockBearing) -> str:
    """Return the fit of a bearing in stock, by its kind."""
    return BALL_FIT if bearing in stock.ball_bearings() else NEEDLE_FIT
