"""Choice of the rolling bearing in stock for the cams; outside `parts.export`, which takes 50 ms to import."""

from cycloid_mj.base import names
from cycloid_mj.design import stock
from cycloid_mj.reducer import Reducer

MAX_RINGED = 2
"""Largest number of bearings with inner rings side by side on a soft cam, which does not load more evenly (assumed)."""


def needs_rings(reducer: Reducer) -> bool:
    """Return whether the bearings of the crank need inner rings: needles would wear a crank of plastic."""
    return reducer.design.material_of(names.SHAFT).is_plastic


def cam_bearing(reducer: Reducer) -> tuple[stock.StockBearing, int] | None:
    """Choose the rolling bearing in stock between each cam and its disc; None for a plain cam, or if no bearing fits.

    Returns
    -------
    tuple
        The bearing, and how many of them are side by side in a disc.
    """
    design = reducer.design
    gear = design.gear
    min_bore = round(2.0 * (gear.eccentricity + design.shaft.radius), 9)
    fitting = [
        bearing
        for bearing in stock.bearings_outside(2.0 * gear.bore_radius, ringed=needs_rings(reducer))
        if bearing.bore > min_bore or (design.has_one_piece_crank and bearing.bore == min_bore)
    ]
    chosen = stock.side_by_side(fitting, gear.face_width) if gear.bearing == "rolling" else None
    return (chosen[0], min(chosen[1], MAX_RINGED)) if chosen and needs_rings(reducer) else chosen
