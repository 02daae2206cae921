"""Figures of the catalogue that a rating computes, or that only a data sheet has: functions of a reducer."""

import math

from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.life import datasheet
from cycloid_mj.life.item import Rating
from cycloid_mj.life.items import rate
from cycloid_mj.life.rated import is_bearing_life, rated_torque
from cycloid_mj.reducer import Reducer, once

KG_CM2 = 1e4
"""Kilograms times square centimetres in a kg m2."""


@once
def rating(reducer: Reducer) -> Rating:
    """Rate a design at its rated torque and speed, once for all its figures; errors as `rate`."""
    return rate(reducer.design)


def input_inertia(reducer: Reducer) -> float:
    """Compute the inertia at the input [kg cm2]."""
    return KG_CM2 * datasheet.input_inertia(reducer)


def length(reducer: Reducer) -> float:
    """Compute the length over all [mm]."""
    near, far = datasheet.axial_extent(reducer)
    return MILLIMETRES * (far - near)


def life(reducer: Reducer) -> float:
    """Compute the shortest life of all parts [h]; infinite where none ends."""
    return min((item.life for item in rating(reducer).items.values() if item.life is not None), default=math.inf)


def bearing_life(reducer: Reducer) -> float:
    """Compute the shortest life of the bearings [h]."""
    items = rating(reducer).items.items()
    return min((item.life for key, item in items if is_bearing_life(key) and item.life is not None), default=math.inf)


def least_safety(reducer: Reducer) -> float:
    """Compute the least of all safeties [1]."""
    return min(item.safety for item in rating(reducer).items.values() if item.safety is not None)


def temperature_rise(reducer: Reducer) -> float:
    """Compute how much warmer than the surroundings the housing gets [K]."""
    return rating(reducer).items["temperature"].value - reducer.design.service.ambient_temperature


@once
def momentary(reducer: Reducer) -> float:
    """Compute the torque that is held once with a safety of 1 [N m]."""
    torque, _ = datasheet.momentary_torque(reducer)
    return torque


def torque_for_life(reducer: Reducer) -> float:
    """Compute the torque that all parts bear for the design's life at the rated speed, and that is held once [N m]."""
    lasting, _ = rated_torque(reducer, reducer.design.drive.speed, reducer.design.service.life)
    return min(lasting, momentary(reducer))
