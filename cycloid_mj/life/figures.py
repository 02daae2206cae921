"""Functions of the catalogue's figures that need a rating or belong to the data sheet."""

import math
from dataclasses import dataclass

from cycloid_mj.base.units import KG_CM2, MILLIMETRES, RPM
from cycloid_mj.life import datasheet
from cycloid_mj.life.items import rate_at_rated_load
from cycloid_mj.life.loading import relative_speed
from cycloid_mj.life.rated import is_bearing_life, momentary_torque, rated_torque
from cycloid_mj.life.thermal import permissible_speed
from cycloid_mj.parts import body_inertia
from cycloid_mj.parts.export import cam_bearing, drive
from cycloid_mj.parts.export.casing import bearing_width_of, seat_radius
from cycloid_mj.reducer import Reducer, once


@dataclass(frozen=True)
class SpeedLimits:
    """Limits of the speed of greased needle bearings and of intermittent duty.

    Attributes
    ----------
    caged
        Speed [rpm] times mean diameter [m] of needle bearings with a cage, in grease, at C/P of about 8 (SKF, 2018).
    full_complement_share
        Share of that speed for rollers without a cage, which rub on each other (assumed; makers state a third to 0.6).
    intermittent_share
        Share of the time of an intermittent duty (S3 25 %).
    """

    caged: float = 300.0
    full_complement_share: float = 0.5
    intermittent_share: float = 0.25


SPEED_LIMITS = SpeedLimits()


def input_inertia(reducer: Reducer) -> float:
    """Compute the inertia at the input [kg cm2]."""
    return KG_CM2 * body_inertia.input_inertia(reducer)


def length(reducer: Reducer) -> float:
    """Compute the length of the mechanism [mm]."""
    near, far = datasheet.axial_extent(reducer)
    return MILLIMETRES * (far - near)


def drive_mass(reducer: Reducer) -> float:
    """Compute the mass of a drive with covers, bearings and screws [kg]; errors as ``drive.drive_mass``."""
    return drive.drive_mass(reducer)


def drive_length(reducer: Reducer) -> float:
    """Compute the length between the faces of motor and load [mm]; errors as ``drive.drive_length``."""
    return MILLIMETRES * drive.drive_length(reducer)


def drive_diameter(reducer: Reducer) -> float:
    """Compute the diameter of the covers [mm]; errors as ``drive.drive_diameter``."""
    return MILLIMETRES * drive.drive_diameter(reducer)


def drive_inertia(reducer: Reducer) -> float:
    """Compute the inertia at the input of a drive with hub and flange [kg cm2]; errors as ``drive.casing_inertia``."""
    return input_inertia(reducer) + KG_CM2 * drive.casing_inertia(reducer)


def largest_speed(reducer: Reducer) -> float:
    """Compute the largest speed of the crank [rpm] that the greased bearings of cams and shaft allow.

    It follows from the permissible product of speed and mean diameter of each type of bearing, `SPEED_LIMITS`.
    """
    shaft, gear = reducer.design.shaft, reducer.design.gear
    bearing_radius = seat_radius(reducer, bearing_width_of(reducer))
    speeds = [SPEED_LIMITS.caged / (shaft.radius + bearing_radius)]
    if gear.bearing == "rolling":
        stock_bearing = cam_bearing(reducer)
        inner_radius = 0.5 * stock_bearing[0].bore if stock_bearing else gear.bore_radius
        factor = SPEED_LIMITS.caged if stock_bearing else SPEED_LIMITS.full_complement_share * SPEED_LIMITS.caged
        speed_ratio = abs(reducer.design.drive.speed) / relative_speed(reducer, reducer.design.drive.speed)
        speeds.append(factor / (inner_radius + gear.bore_radius) * speed_ratio)
    return min(speeds)


def continuous_speed(reducer: Reducer) -> float:
    """Compute the largest continuous speed of the crank [rpm] at the nominal torque, by heat and bearings."""
    return _speed_by_heat(reducer, 1.0)


def intermittent_speed(reducer: Reducer) -> float:
    """Compute the largest speed at the nominal torque for `SpeedLimits.intermittent_share` of the time (S3) [rpm]."""
    return _speed_by_heat(reducer, SPEED_LIMITS.intermittent_share)


def _speed_by_heat(reducer: Reducer, duty_share: float) -> float:
    """Compute the largest speed of the crank [rpm] for a share of the time, by heat (`thermal`) and bearings."""
    return min(permissible_speed(reducer.design, duty_share) / RPM, largest_speed(reducer))


def life(reducer: Reducer) -> float:
    """Compute the shortest life of all parts without wear [h]; infinite if none is limited."""
    return rate_at_rated_load(reducer).shortest_life


def bearing_life(reducer: Reducer) -> float:
    """Compute the shortest life of the bearings [h]."""
    items = rate_at_rated_load(reducer).items.items()
    return min((item.life for key, item in items if is_bearing_life(key) and item.life is not None), default=math.inf)


def least_safety(reducer: Reducer) -> float:
    """Compute the smallest safety factor [1]."""
    return min(item.safety for item in rate_at_rated_load(reducer).items.values() if item.safety is not None)


def drive_efficiency(reducer: Reducer) -> float:
    """Compute the efficiency at the nominal torque and speed with the bearings of shaft and output [%]."""
    design = reducer.design
    output_power = design.rated_torque * abs(design.drive.speed) / design.reduction
    return 100.0 * output_power / (output_power + rate_at_rated_load(reducer).items["power_lost"].value)


def temperature_rise(reducer: Reducer) -> float:
    """Compute the temperature rise of the housing [K]."""
    return rate_at_rated_load(reducer).items["temperature"].value - reducer.design.service.ambient_temperature


@once
def momentary(reducer: Reducer) -> float:
    """Compute the momentary torque, with a safety factor of 1 [N m]."""
    return momentary_torque(reducer)[0]


def torque_for_life(reducer: Reducer) -> float:
    """Compute the rated torque for the design's life and speed, at most the momentary torque [N m]."""
    rated_limit, _ = rated_torque(reducer, reducer.design.drive.speed, reducer.design.service.life)
    return min(rated_limit, momentary(reducer))
