"""The rolling bearings of a reducer: cam, shaft and output rollers, by their life and the largest load they bear."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.design.stock import StockBearing, ball_bearings
from cycloid_mj.life import rolling
from cycloid_mj.life.hub import held_by_hub
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import FAR, NEAR, Loading, relative_speed
from cycloid_mj.parts.crank import shaft_measures
from cycloid_mj.parts.export import cam_bearing, shaft_bearing
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.parts.export.drive import has_casing
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
class Ratings:
    """What a bearing bears: dynamic and static load rating [N], where each is from, and the exponent of its life."""

    dynamic: float
    static: float
    dynamic_source: str
    static_source: str
    exponent: float = rolling.EXPONENT


@dataclass(frozen=True)
class Seat:
    """A bearing, or several alike that share a key: its name and its ratings."""

    key: str
    name: str
    ratings: Ratings


def bearings(reducer: Reducer, loadings: Sequence[Loading], peak: float) -> Iterator[RatedItem]:
    """Rate every bearing at each point of a duty, and at the peak torque [N m] of an emergency stop."""
    design = reducer.design
    crank = np.array([abs(loading.point.speed) * loading.point.share for loading in loadings])
    relative = np.array([relative_speed(reducer, loading.point.speed) * loading.point.share for loading in loadings])
    if design.gear.bearing == "rolling":
        yield from _rated(reducer, cam_seat(reducer), [loading.cam for loading in loadings], relative, loadings, peak)
    for place, name in ((FAR, "far"), (NEAR, "near")):
        force = [rolling.magnitudes(loading.shaft[:, place]) for loading in loadings]
        yield from _rated(reducer, _shaft_seat(reducer, name), force, crank, loadings, peak)
    if has_casing(reducer):
        held = [held_by_hub(reducer, loading) for loading in loadings]
        turns = crank / design.reduction
        for which, forces in zip(("inner", "outer"), zip(*held, strict=True), strict=True):
            on_balls = [rolling.magnitudes(force) for force in forces]
            yield from _rated(reducer, _hub_seat(reducer, which), on_balls, turns, loadings, peak)
    if design.output.has_needles:
        # a roller turns on its pin as often as it rolls round its hole
        rolls = (
            reducer.share * crank * (design.output.hole_radius / design.output.pin_radius - 1.0 + 1.0 / design.lobes)
        )
        loads = [loading.output.reshape(len(loading.crank), -1) for loading in loadings]
        yield from _rated(reducer, _output_seat(reducer), loads, rolls, loadings, peak)


def cam_seat(reducer: Reducer) -> Seat:
    """Return the bearing of each cam: of stock, or rollers whose outer ring is the gear's bore."""
    design = reducer.design
    gear, bearing = design.gear, design.bearing
    row = RollerRow(
        design.contact.cam_rollers, 2.0 * reducer.contacts.roller_radius, gear.face_width, 2.0 * gear.bore_radius
    )
    where = "side by side on the cam's circle, the gear's bore as outer ring"
    given = bearing.dynamic_capacity, bearing.static_capacity
    return Seat("cam_bearing", "cam bearing", _ratings(given, cam_bearing(reducer), row, where))


def _shaft_seat(reducer: Reducer, name: str) -> Seat:
    radius, bearing = reducer.design.shaft.radius, reducer.design.bearing
    size = SHAFT_ROLLER_SHARE * radius
    low, high = shaft_measures(reducer).bearings[0]
    row = RollerRow(SHAFT_ROLLERS, size, high - low, 2.0 * radius + size)
    given, bought = (bearing.shaft_dynamic_capacity, bearing.shaft_static_capacity), shaft_bearing(reducer)
    return Seat(
        f"shaft_bearing_{name}",
        {"near": "shaft bearing next to the gear", "far": "shaft bearing far from the gear"}[name],
        _ratings(given, (bought, 1) if bought else None, row, "on the shaft"),
    )


def _hub_seat(reducer: Reducer, which: str) -> Seat:
    bearing = casing(reducer).hub
    source = f"of its maker's catalogue: {bearing.designation}"
    ratings = Ratings(bearing.dynamic, bearing.static, f"C {source}", f"C0 {source}", rolling.BALL_EXPONENT)
    return Seat(f"output_bearing_{which}", f"{which} bearing of the output", ratings)


def _output_seat(reducer: Reducer) -> Seat:
    design = reducer.design
    output, bearing = design.output, design.bearing
    needle = NEEDLE_FILL * (output.pin_radius - output.root_radius) * 2.0
    pitch = 2.0 * output.root_radius + needle
    row = RollerRow(max(int(math.pi * pitch / needle), 3), needle, design.gear.face_width, pitch)
    given = bearing.output_dynamic_capacity, bearing.output_static_capacity
    return Seat("output_rollers", "rollers of the output pins", _ratings(given, None, row, "round the core of a pin"))


def _ratings(
    given: tuple[float, float], bought: tuple[StockBearing, int] | None, row: RollerRow, where: str
) -> Ratings:
    """Return the ratings that the design file gives [N], or those of so many bearings in stock, or of a row."""
    exponent = rolling.EXPONENT
    if bought:
        bearing, count = bought
        dynamic, static = rolling.side_by_side(bearing.dynamic, count), count * bearing.static
        source = f"of its maker's catalogue: {f'{count} x ' if count > 1 else ''}{bearing.designation}"
        sources = f"C {source}", f"C0 {source}"
        exponent = rolling.BALL_EXPONENT if bearing in ball_bearings() else exponent
    else:
        plain = row.dynamic / rolling.MACHINED
        dynamic, static = row.dynamic, row.static
        sources = (
            f"assumed: {row} {where}, b_m {rolling.MACHINED:g} (b_m 1 leaves C {plain:.0f} N)",
            f"assumed: {row} {where}",
        )
    return Ratings(
        dynamic=given[0] or dynamic,
        static=given[1] or static,
        dynamic_source="C of the design file (bearing.*_capacity_n)" if given[0] else sources[0],
        static_source="C0 of the design file" if given[1] else sources[1],
        exponent=exponent,
    )


def _rated(
    reducer: Reducer, seat: Seat, force: Sequence[Array], turns: Array, loadings: Sequence[Loading], peak: float
) -> Iterator[RatedItem]:
    """Rate one bearing, the most loaded of those alike.

    `force` (m,) or (m, bearings) [N] at each point; `turns` the relative speeds there times the share of time [rad/s].
    """
    bearing, ratings = reducer.design.bearing, seat.ratings
    each = [one.reshape(len(one), -1) for one in force]
    load = bearing_load(reducer, each, turns)
    life = rolling.life_hours(ratings.dynamic, load, float(turns.sum()), bearing.reliability, ratings.exponent)
    power = "3" if ratings.exponent == rolling.BALL_EXPONENT else "(10/3)"
    formula = f"L = a1 (C/P)^{power}, a1 {rolling.reliability_factor(bearing.reliability):.3g}, ISO 281:2007"
    note = f"{ratings.dynamic_source}, service factor {bearing.service_factor:g}"
    yield RatedItem(seat.key, f"{seat.name}, life", load, ratings.dynamic, "N", None, life, formula, note)
    worst = max(float(one.max()) * peak / one_at for one, one_at in zip(each, _torques(loadings), strict=True))
    yield RatedItem(
        f"{seat.key}_static",
        f"{seat.name}, static factor",
        worst,
        ratings.static,
        "N",
        ratings.static / worst if worst else math.inf,
        None,
        "s0 = C0/P0, ISO 76",
        f"{ratings.static_source}; at the peak torque, {peak:.4g} N m, forces in proportion",
    )


def bearing_load(reducer: Reducer, force: Sequence[Array], turns: Array) -> float:
    """Average the forces on bearings alike [N], (m, bearings) for each point of a duty, for the most loaded of them.

    `turns` are the relative speeds at the points times the share of time [rad/s].
    """
    means = np.array([max(rolling.mean_load(column) for column in one.T) for one in force])
    return reducer.design.bearing.service_factor * rolling.mean_load(means, turns)


def _torques(loadings: Sequence[Loading]) -> list[float]:
    return [abs(loading.point.torque) for loading in loadings]
