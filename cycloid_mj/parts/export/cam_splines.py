"""Splined cams: straight-sided splines (ISO 14) in cams and spacer, whose hubs pass over the journals of the shaft."""

import math

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import in_mm
from cycloid_mj.design import stock
from cycloid_mj.parts.cam_bearing import cam_radius
from cycloid_mj.parts.export.casing_rules import RULES, axial_play
from cycloid_mj.parts.export.keyway import SplineContour
from cycloid_mj.reducer import Reducer, once


@once
def cam_spline(reducer: Reducer) -> stock.StockSpline | None:
    """Choose the spline between cams and shaft, the smallest around the journals; None if they have another joint.

    It leaves a wall in the cams, and stays within the faces of the spacer, which touch the cams but not their bearings.

    Raises
    ------
    DesignError
        No standard spline fits.
    """
    design = reducer.design
    if design.cam_joint != "spline":
        return None
    diameter, wall = 2.0 * design.shaft.radius, max(RULES.min_wall, axial_play(reducer))
    max_major = 2.0 * (cam_radius(reducer) - design.gear.eccentricity - wall)
    spline = next(iter(stock.splines_around(diameter)), None)
    if spline is None or spline.major > max_major:
        size_text = f"{in_mm(spline.major)} mm" if spline else "more than the largest one"
        raise DesignError(
            f'shaft.cam_joint = "spline" is not possible: the smallest spline of ISO 14 around a shaft of '
            f"{in_mm(diameter)} mm has a diameter of {size_text}, but the cams leave {in_mm(max(max_major, 0.0))} mm: "
            "choose a thinner shaft (shaft.radius_mm), larger cams (gear.bore_radius_mm), or another joint"
        )
    return spline


def spline_contour(spline: stock.StockSpline) -> SplineContour:
    """Return the section of a spline in the frame of the shaft, with a spline towards +y."""
    return SplineContour(spline.count, 0.5 * spline.minor, 0.5 * spline.major, spline.width, 0.5 * math.pi)


def spline_fit(spline: stock.StockSpline) -> str:
    """Return the designation of a spline, and its fits for a close fit that is centred on the minor diameter."""
    return f"{spline.designation}, close fit: H7/g7 on the minor diameter, H9/f9 on the flanks"
