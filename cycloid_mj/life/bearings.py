"""The rolling bearings of a reducer: cam, shaft and output rollers, by their life and the largest load they bear."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.life import rolling
from cycloid_mj.life.hours import hours
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import Loading, relative_speed
from cycloid_mj.parts.crank import shaft_measures
from cycloid_mj.reducer import Reducer

NEEDLE_FILL = 0.35
"""Of the wall of an output roller: what its needles are thick, where their rating is not given (assumed)."""

SHAFT_ROLLERS, SHAFT_ROLLER_SHARE = 14, 0.4
"""Rollers of a shaft bearing, and their diameter over the shaft's radius, where its rating is not given (assumed)."""


@dataclass(frozen=True)
class RollerRow:
    """A row of rollers side by side: their number, and diameter, length and pitch diameter [m]."""

    rollers: int
    diameter: float
    length: float
    pitch: float

    def __str__(self) -> str:
        """Format number and size."""
        return f"{self.rollers} rollers of {1e3 * self.diameter:.3g} x {1e3 * self.length:.3g} mm"

    @property
    def dynamic(self) -> float:
        """Basic dynamic load rating [N]."""
        return rolling.dynamic_capacity(self.rollers, self.diameter, self.length, self.pitch)

    @property
    def static(self) -> float:
        """Basic static load rating [N]."""
        return rolling.static_capacity(self.rollers, self.diameter, self.length, self.pitch)


@dataclass(frozen=True)
class Seat:
    """A bearing, or several alike that share a key: its row, its ratings by catalogue [N] (0: none), and what it is."""

    key: str
    name: str
    row: RollerRow
    dynamic: float
    static: float
    where: str


def bearings(reducer: Reducer, loadings: Sequence[Loading], peak: float) -> Iterator[RatedItem]:
    """Rate every bearing at each point of a duty, and at the peak torque [N m] of an emergency stop."""
    design = reducer.design
    crank = np.array([abs(loading.point.speed) * loading.point.share for loading in loadings])
    relative = np.array([relative_speed(reducer, loading.point.speed) * loading.point.share for loading in loadings])
    if design.gear.bearing == "rolling":
        yield from _rated(reducer, cam_seat(reducer), [loading.cam for loading in loadings], relative, loadings, peak)
    for place, name in enumerate(("far", "near"), start=-2):
        force = [rolling.magnitudes(loading.shaft[:, place]) for loading in loadings]
        yield from _rated(reducer, _shaft_seat(reducer, name), force, crank, loadings, peak)
    if design.output.rollers:
        # a roller turns on its pin as often as it rolls round its hole
        rolls = (
            reducer.share * crank * (design.output.hole_radius / design.output.pin_radius - 1.0 + 1.0 / design.lobes)
        )
        loads = [loading.output.reshape(len(loading.crank), -1) for loading in loadings]
        yield from _rated(reducer, _output_seat(reducer), loads, rolls, loadings, peak)


def cam_seat(reducer: Reducer) -> Seat:
    """Return the bearing of each cam, whose outer ring is the gear's bore."""
    design = reducer.design
    gear, bearing = design.gear, design.bearing
    row = RollerRow(
        design.contact.cam_rollers, 2.0 * reducer.contacts.roller_radius, gear.face_width, 2.0 * gear.bore_radius
    )
    where = "side by side on the cam's circle, the gear's bore as outer ring"
    return Seat("cam_bearing", "cam bearing", row, bearing.dynamic_capacity, bearing.static_capacity, where)


def _shaft_seat(reducer: Reducer, name: str) -> Seat:
    radius, bearing = reducer.design.shaft.radius, reducer.design.bearing
    size = SHAFT_ROLLER_SHARE * radius
    low, high = shaft_measures(reducer).bearings[0]
    row = RollerRow(SHAFT_ROLLERS, size, high - low, 2.0 * radius + size)
    ratings = bearing.shaft_dynamic_capacity, bearing.shaft_static_capacity
    return Seat(
        f"shaft_bearing_{name}",
        {"near": "shaft bearing next to the gear", "far": "shaft bearing far from the gear"}[name],
        row,
        *ratings,
        "on the shaft",
    )


def _output_seat(reducer: Reducer) -> Seat:
    design = reducer.design
    output, bearing = design.output, design.bearing
    needle = NEEDLE_FILL * (output.pin_radius - output.root_radius) * 2.0
    pitch = 2.0 * output.root_radius + needle
    row = RollerRow(max(int(math.pi * pitch / needle), 3), needle, design.gear.face_width, pitch)
    ratings = bearing.output_dynamic_capacity, bearing.output_static_capacity
    return Seat("output_rollers", "rollers of the output pins", row, *ratings, "round the core of a pin")


def _rated(
    reducer: Reducer, seat: Seat, force: Sequence[Array], turns: Array, loadings: Sequence[Loading], peak: float
) -> Iterator[RatedItem]:
    """Rate one bearing, the most loaded of those alike.

    `force` (m,) or (m, bearings) [N] at each point; `turns` the relative speeds there times the share of time [rad/s].
    """
    bearing = reducer.design.bearing
    each = [one.reshape(len(one), -1) for one in force]
    load = bearing_load(reducer, each, turns)
    capacity = seat.dynamic or seat.row.dynamic
    life = rolling.life_hours(capacity, load, float(turns.sum()), bearing.reliability)
    formula = f"L = a1 (C/P)^(10/3), a1 {rolling.reliability_factor(bearing.reliability):.3g}, ISO 281:2007"
    note = f"C of the design file (bearing.*_capacity_n), service factor {bearing.service_factor:g}"
    if not seat.dynamic:
        plain = capacity / rolling.MACHINED
        less = rolling.life_hours(plain, load, float(turns.sum()), bearing.reliability)
        note = (
            f"assumed: {seat.row} {seat.where}, b_m {rolling.MACHINED:g} "
            f"(b_m 1 leaves C {plain:.0f} N and {hours(less)}), service factor {bearing.service_factor:g}"
        )
    yield RatedItem(seat.key, f"{seat.name}, life", load, capacity, "N", None, life, formula, note)
    worst = max(float(one.max()) * peak / one_at for one, one_at in zip(each, _torques(loadings), strict=True))
    standing = seat.static or seat.row.static
    source = "C0 of the design file" if seat.static else f"assumed: {seat.row} {seat.where}"
    yield RatedItem(
        f"{seat.key}_static",
        f"{seat.name}, static factor",
        worst,
        standing,
        "N",
        standing / worst if worst else math.inf,
        None,
        "s0 = C0/P0, C0 = 44 (1 - D/D_pw) Z L D, ISO 76",
        f"{source}; at the peak torque, {peak:.4g} N m, forces in proportion",
    )


def bearing_load(reducer: Reducer, force: Sequence[Array], turns: Array) -> float:
    """Average the forces on bearings alike [N], (m, bearings) for each point of a duty, for the most loaded of them.

    `turns` are the relative speeds at the points times the share of time [rad/s].
    """
    means = np.array([max(rolling.mean_load(column) for column in one.T) for one in force])
    return reducer.design.bearing.service_factor * rolling.mean_load(means, turns)


def _torques(loadings: Sequence[Loading]) -> list[float]:
    return [abs(loading.point.torque) for loading in loadings]
