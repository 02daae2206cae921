"""Bearing in stock for the cams, and radius of the cams; outside `parts.export`, which takes 50 ms to import."""

import math

from cycloid_mj.base import names
from cycloid_mj.design import stock
from cycloid_mj.reducer import Reducer

MAX_RINGED = 2
"""Largest number of bearings with inner rings side by side on a cam, which does not load more evenly (assumed)."""


def needs_rings(reducer: Reducer) -> bool:
    """Return whether the bearings of the crank need inner rings: needles would wear a crank of plastic."""
    return reducer.design.material_of(names.SHAFT).is_plastic


def needs_ringed_cam(reducer: Reducer) -> bool:
    """Return whether the bearings of the cams need inner rings: on a cam of plastic, or on one that is slotted."""
    return needs_rings(reducer) or reducer.design.cam_joint == "clamp"


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
    fitting_bearings = [
        bearing
        for bearing in stock.bearings_outside(2.0 * gear.bore_radius, ringed=needs_ringed_cam(reducer))
        if bearing.bore > min_bore or (design.has_one_piece_crank and bearing.bore == min_bore)
    ]
    bearing_and_count = stock.side_by_side(fitting_bearings, gear.face_width) if gear.bearing == "rolling" else None
    return (
        (bearing_and_count[0], min(bearing_and_count[1], MAX_RINGED))
        if bearing_and_count and needs_ringed_cam(reducer)
        else bearing_and_count
    )


def cam_seat(reducer: Reducer) -> float:
    """Return the inner radius [m] of the bearing of the cam, or the bore radius of the disc if the cam slides.

    If no stock bearing fits, ``contact.cam_rollers`` rollers that touch each other run directly in the bore of the
    disc, and the result is the radius inside the rollers. This radius must exceed eccentricity plus shaft radius, so
    that there is a cam around the shaft; if it does not, the rollers are thinner, and the result is the mean of that
    sum and the bore radius of the disc.
    """
    gear, bearing_and_count = reducer.design.gear, cam_bearing(reducer)
    if bearing_and_count:
        return round(0.5 * bearing_and_count[0].bore, 9)
    roller_ratio = math.sin(math.pi / reducer.design.contact.cam_rollers)
    raceway_radius = gear.bore_radius * (1.0 - roller_ratio) / (1.0 + roller_ratio)
    min_seat = gear.eccentricity + reducer.design.shaft.radius
    if gear.bearing != "rolling" or min_seat >= gear.bore_radius:
        return gear.bore_radius
    return raceway_radius if raceway_radius > min_seat else 0.5 * (min_seat + gear.bore_radius)


def cam_radius(reducer: Reducer, seat: float | None = None) -> float:
    """Return the radius [m] of the cam in a drive, for a bearing whose bore has the radius `seat`.

    By default, `seat` is `cam_seat`. In a stock bearing, the cam is smaller than the seat by the cam clearance, but not
    smaller than eccentricity plus shaft radius; if the seat itself is smaller than this sum, the cam is as large as the
    seat. Without a stock bearing, the cam is as large as the seat, because the bore of the disc includes the clearance.
    """
    design, seat = reducer.design, cam_seat(reducer) if seat is None else seat
    min_radius = design.gear.eccentricity + design.shaft.radius
    return max(seat - design.clearance.cam, min(seat, min_radius)) if cam_bearing(reducer) else seat
