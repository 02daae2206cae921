"""The rolling bearings of a reducer: cam, shaft and output rollers, by their life and the largest load they bear."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import RPM
from cycloid_mj.design.stock import StockBearing, ball_bearings
from cycloid_mj.life import rolling
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import CAM, FAR, NEAR, Body, Loading, relative_speed
from cycloid_mj.life.output_bearing import balls_of, held_by_hub
from cycloid_mj.parts.crank import shaft_measures
from cycloid_mj.parts.export import cam_bearing, shaft_bearing
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.parts.export.drive import has_casing
from cycloid_mj.reducer import Reducer

NEEDLE_FILL = 0.35
"""Of the wall of an output roller: what its needles are thick, where their rating is not given (assumed)."""

SHAFT_ROLLERS, SHAFT_ROLLER_SHARE = 14, 0.4
"""Rollers of a shaft bearing, and their diameter over the shaft's radius, where its rating is not given (assumed)."""

NEEDLE_FRICTION = 0.002
"""Coefficient of friction of needle bearings, referred to the bore (SKF, Rolling bearings, 2018)."""


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
    """What a bearing supports: dynamic and static load rating [N], where each is from, and the exponent of its life."""

    dynamic: float
    static: float
    dynamic_source: str
    static_source: str
    exponent: float = rolling.EXPONENT


@dataclass(frozen=True)
class Bearing:
    """A bearing, or several alike that share a key.

    Attributes
    ----------
    key, name
        For programs, and in words.
    ratings
        Its load ratings.
    joins
        The two bodies that it joins: its speed is their relative speed, times `spin`.
    spin
        Turns of its rings against each other in a turn of these bodies [1].
    bore
        Diameter of the bore, for its friction [m]; 0 where the statics count its friction already.
    """

    key: str
    name: str
    ratings: Ratings
    joins: tuple[Body, Body]
    spin: float = 1.0
    bore: float = 0.0

    def speed(self, reducer: Reducer, crank: float) -> float:
        """Compute the speed of its rings against each other [rad/s] at a speed of the crank [rad/s]."""
        return self.spin * relative_speed(reducer, crank, self.joins)


def bearings_of(reducer: Reducer) -> tuple[Bearing, ...]:
    """List the rolling bearings of a drive: cams, shaft, the output's hub, rollers of the output pins.

    The shaft's far bearing stands in the hub of the output where it straddles the discs, else in the housing with the
    near one. A roller of the radius r in a hole of the radius R spins by R/r - 1 for each turn of the crank against the
    disc: the hole's middle moves by (R - r) times that speed, and the roller rolls in it.
    """
    return tuple(_bearings(reducer))


def _bearings(reducer: Reducer) -> Iterator[Bearing]:
    design = reducer.design
    output, shaft = design.output, design.shaft
    if design.gear.bearing == "rolling":
        yield Bearing("cam_bearing", "cam bearing", cam_ratings(reducer), CAM)
    on_shaft, straddles = _shaft_ratings(reducer), shaft.mounting == "straddle"
    for end, name in (("far", "shaft bearing far from the gear"), ("near", "shaft bearing next to the gear")):
        joins: tuple[Body, Body] = ("shaft", "output") if straddles and end == "far" else ("shaft", "housing")
        yield Bearing(f"shaft_bearing_{end}", name, on_shaft, joins, bore=2.0 * shaft.radius)
    if has_casing(reducer):
        ratings, bore = _hub_ratings(reducer), casing(reducer).hub.bore
        for which in ("inner", "outer"):
            name = f"{which} bearing of the output"
            yield Bearing(f"output_bearing_{which}", name, ratings, ("output", "housing"), bore=bore)
    if output.has_needles:
        spin = output.hole_radius / output.pin_radius - 1.0
        yield Bearing("output_rollers", "rollers of the output pins", _roller_ratings(reducer), CAM, spin)


def bearing_forces(reducer: Reducer, key: str, loading: Loading) -> Array:
    """Compute the forces on a bearing of `bearings_of` [N], shape (m, bearings): of several alike on each."""
    if key == "cam_bearing":
        return loading.cam
    if key == "output_rollers":
        return loading.output.reshape(len(loading.crank), -1)
    if key.startswith("shaft"):
        force = loading.shaft[:, FAR if key.endswith("far") else NEAR]
    else:
        inner, outer = held_by_hub(reducer, loading)
        force = inner if key.endswith("inner") else outer
    return rolling.magnitudes(force)[:, np.newaxis]


def rate_bearings(reducer: Reducer, loadings: Sequence[Loading], peak: float) -> Iterator[RatedItem]:
    """Rate every bearing at each point of a duty, and at the peak torque [N m] of an emergency stop."""
    for bearing in bearings_of(reducer):
        forces = [bearing_forces(reducer, bearing.key, loading) for loading in loadings]
        turns = np.array([bearing.speed(reducer, loading.point.speed) * loading.point.share for loading in loadings])
        yield from _rated(reducer, bearing, forces, turns, loadings, peak)


def bearing_losses(reducer: Reducer, loading: Loading) -> dict[str, float]:
    """Compute the friction of the bearings of shaft and output under a load [W], by key: mu F d/2 at their speeds.

    As makers estimate it, with the bore d (SKF, Rolling bearings, 2018, "Friction"), and the mu of a rolling cam, or
    `NEEDLE_FRICTION`. Cam and output pins are among the losses of the statics.
    """
    design = reducer.design
    mu = design.friction_of("cam") if design.gear.bearing == "rolling" else NEEDLE_FRICTION
    return {
        bearing.key: 0.5
        * mu
        * bearing.bore
        * float(bearing_forces(reducer, bearing.key, loading).mean())
        * bearing.speed(reducer, loading.point.speed)
        for bearing in bearings_of(reducer)
        if bearing.bore
    }


def cam_ratings(reducer: Reducer) -> Ratings:
    """Return the load ratings of each cam's bearing: of stock, or of rollers whose outer ring is the gear's bore."""
    design = reducer.design
    gear, bearing = design.gear, design.bearing
    row = RollerRow(
        design.contact.cam_rollers, 2.0 * reducer.contacts.roller_radius, gear.face_width, 2.0 * gear.bore_radius
    )
    where = "side by side on the cam's circle, the gear's bore as outer ring"
    given = bearing.dynamic_capacity, bearing.static_capacity
    return _ratings(given, cam_bearing(reducer), row, where)


def _shaft_ratings(reducer: Reducer) -> Ratings:
    radius, bearing = reducer.design.shaft.radius, reducer.design.bearing
    size = SHAFT_ROLLER_SHARE * radius
    low, high = shaft_measures(reducer).bearings[0]
    row = RollerRow(SHAFT_ROLLERS, size, high - low, 2.0 * radius + size)
    given, bought = (bearing.shaft_dynamic_capacity, bearing.shaft_static_capacity), shaft_bearing(reducer)
    return _ratings(given, (bought, 1) if bought else None, row, "on the shaft")


def _hub_ratings(reducer: Reducer) -> Ratings:
    """Return the ratings of each bearing of the output's hub, with what its balls would have by ISO 281."""
    bearing = casing(reducer).hub
    row, source = balls_of(bearing), f"of its maker's catalogue: {bearing.designation}"
    by_balls = rolling.ball_capacity(row.balls, row.diameter, row.pitch)
    spread = (by_balls / bearing.dynamic) ** rolling.BALL_EXPONENT
    other = (
        f"; ISO 281 gives {by_balls:.4g} N for {row.balls} balls of {1e3 * row.diameter:.3g} mm (estimated), "
        f"{spread:.3g} times the life; makers differ as much"
    )
    return Ratings(bearing.dynamic, bearing.static, f"C {source}{other}", f"C0 {source}", rolling.BALL_EXPONENT)


def _roller_ratings(reducer: Reducer) -> Ratings:
    design = reducer.design
    output, bearing = design.output, design.bearing
    needle = NEEDLE_FILL * (output.pin_radius - output.root_radius) * 2.0
    pitch = 2.0 * output.root_radius + needle
    row = RollerRow(max(int(math.pi * pitch / needle), 3), needle, design.gear.face_width, pitch)
    given = bearing.output_dynamic_capacity, bearing.output_static_capacity
    return _ratings(given, None, row, "round the core of a pin")


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
    reducer: Reducer, rated: Bearing, forces: Sequence[Array], turns: Array, loadings: Sequence[Loading], peak: float
) -> Iterator[RatedItem]:
    """Rate one bearing, the most loaded of those alike.

    `forces` (m, bearings) [N] at each point; `turns` the relative speeds there times the share of time [rad/s].
    """
    bearing, ratings = reducer.design.bearing, rated.ratings
    load = bearing_load(reducer, forces, turns, ratings.exponent)
    life = rolling.life_hours(ratings.dynamic, load, float(turns.sum()), bearing.reliability, ratings.exponent)
    power = "3" if ratings.exponent == rolling.BALL_EXPONENT else "(10/3)"
    formula = f"L = a1 (C/P)^{power}, a1 {rolling.reliability_factor(bearing.reliability):.3g}, ISO 281:2007"
    first, second = rated.joins
    note = (
        f"{ratings.dynamic_source}, service factor {bearing.service_factor:g}; between {first} and {second}, "
        f"{float(turns.sum()) / RPM:.4g} rpm on average"
    )
    yield RatedItem(rated.key, f"{rated.name}, life", load, ratings.dynamic, "N", None, life, formula, note)
    worst = max(float(one.max()) * peak / one_at for one, one_at in zip(forces, _torques(loadings), strict=True))
    yield RatedItem(
        f"{rated.key}_static",
        f"{rated.name}, static factor",
        worst,
        ratings.static,
        "N",
        ratings.static / worst if worst else math.inf,
        None,
        "s0 = C0/P0, ISO 76",
        f"{ratings.static_source}; at the peak torque, {peak:.4g} N m, forces in proportion",
    )


def bearing_load(reducer: Reducer, forces: Sequence[Array], turns: Array, exponent: float) -> float:
    """Compute the equivalent load on the most loaded of bearings alike [N], with the exponent p of their life.

    `forces` are those on each of them [N], (m, bearings), at each point of a duty, `turns` the relative speeds at the
    points times the share of time [rad/s]. So a life over a duty is Miner's sum of those at its points.
    """
    means = np.array([max(rolling.mean_load(column, exponent=exponent) for column in force.T) for force in forces])
    return reducer.design.bearing.service_factor * rolling.mean_load(means, turns, exponent)


def _torques(loadings: Sequence[Loading]) -> list[float]:
    return [abs(loading.point.torque) for loading in loadings]
