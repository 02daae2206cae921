"""The rolling bearings of cams, shaft, output and output rollers: life, static factor and friction."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import MILLIMETRES, RPM
from cycloid_mj.design.lubricants import lubricant
from cycloid_mj.design.stock import StockBearing, has_catalogued_ratings, has_inner_ring
from cycloid_mj.life import rolling
from cycloid_mj.life.bearing_pair import balls_of
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import CAM, FAR, NEAR, Body, Loading, relative_speed
from cycloid_mj.life.modified_life import (
    LIMITS,
    fatigue_load_limit,
    life_curve,
    life_factor,
    reference_viscosity,
)
from cycloid_mj.life.output_loads import output_bearing_loads
from cycloid_mj.parts.crank import shaft_dimensions
from cycloid_mj.parts.export import cam_bearing, shaft_bearing
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.parts.export.drive import has_casing
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.reducer.roller_needles import needle_row
from cycloid_mj.statics.film import lubricant_temperature


@dataclass(frozen=True)
class AssumedRollers:
    """Rollers of bearings whose load ratings the design does not state.

    Attributes
    ----------
    shaft_rollers, shaft_roller_share
        Number of rollers of a shaft bearing, and their diameter over the shaft's radius.
    needle_friction
        Coefficient of friction of needle bearings, referred to the bore (SKF, Rolling bearings, 2018).
    """

    shaft_rollers: int = 14
    shaft_roller_share: float = 0.4
    needle_friction: float = 0.002


ASSUMED_ROLLERS = AssumedRollers()

MM2 = MILLIMETRES**2
"""Square millimetres in a square metre."""


@dataclass(frozen=True)
class RollerRow:
    """A row of rollers: their number, and diameter, length and pitch diameter [m]."""

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
    """Load ratings of a bearing [N] with their sources, its pitch diameter [m], and the exponent of its life."""

    dynamic: float
    static: float
    dynamic_source: str
    static_source: str
    pitch: float
    exponent: float = rolling.EXPONENT


@dataclass(frozen=True)
class Bearing:
    """A bearing, or several like ones that share a key.

    Attributes
    ----------
    key, name
        Key for programs, and name.
    ratings
        Load ratings.
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


@once
def bearings_of(reducer: Reducer) -> tuple[Bearing, ...]:
    """List the rolling bearings of a drive with their load ratings [N]: cams, shaft, hub and rollers of the output.

    If the bearings of the shaft are on both sides of the discs, the second is in the hub of the output, otherwise in
    the housing next to the first bearing. A roller of radius r in a hole of radius R spins R/r - 1 times per turn of
    the crank relative to the disc.
    """
    return tuple(_iterate_bearings(reducer))


def _iterate_bearings(reducer: Reducer) -> Iterator[Bearing]:
    """Yield all rolling bearings of a drive, for `bearings_of`: on cams, shaft, output hub and output pins.

    The shaft always has two. The cams have rolling bearings unless they are plain, the hub if the drive has a casing,
    and the output pins if their rollers run on needles.
    """
    design = reducer.design
    output, shaft = design.output, design.shaft
    if design.gear.bearing == "rolling":
        yield Bearing("cam_bearing", "cam bearing", cam_ratings(reducer), CAM)
    shaft_ratings, has_straddle_mounting = _shaft_ratings(reducer), shaft.mounting == "straddle"
    for position, bearing_name in (
        ("far", "shaft bearing far from the discs"),
        ("near", "shaft bearing next to the discs"),
    ):
        bodies: tuple[Body, Body] = (
            ("shaft", "output") if has_straddle_mounting and position == "far" else ("shaft", "housing")
        )
        yield Bearing(f"shaft_bearing_{position}", bearing_name, shaft_ratings, bodies, bore=2.0 * shaft.radius)
    if has_casing(reducer):
        hub = casing(reducer).hub
        ratings = output_ratings(hub)
        if hub.has_crossed_rollers:
            bearing_name = "crossed roller bearing of the output"
            yield Bearing("output_bearing", bearing_name, ratings, ("output", "housing"), bore=hub.bore)
        else:
            for position in ("inner", "outer"):
                key, bearing_name = f"output_bearing_{position}", f"{position} bearing of the output"
                yield Bearing(key, bearing_name, ratings, ("output", "housing"), bore=hub.bore)
    if output.has_needles:
        spin_ratio = output.hole_radius / output.pin_radius - 1.0
        yield Bearing("output_rollers", "rollers of the output pins", _output_roller_ratings(reducer), CAM, spin_ratio)


def bearing_forces(reducer: Reducer, bearing_key: str, loading: Loading) -> Array:
    """Return the load on each bearing of a kind [N], shape (m, bearings), at m crank angles.

    It is the magnitude of the radial force; for bearings of the output it is the equivalent load, which includes their
    preload and, for crossed rollers, the tilting moment.

    `bearing_key` is a key of `bearings_of`; equal bearings, such as those of all cams, share a key. `loading` has the
    solved forces at the crank angles.
    """
    if bearing_key == "cam_bearing":
        return loading.cam
    if bearing_key == "output_rollers":
        return loading.output.reshape(len(loading.crank), -1)
    if bearing_key.startswith("shaft"):
        force = loading.shaft[:, FAR if bearing_key.endswith("far") else NEAR]
    else:
        loads = output_bearing_loads(reducer, loading)
        return loads[0 if bearing_key.endswith("inner") else -1][:, np.newaxis]
    return rolling.magnitudes(force)[:, np.newaxis]


def rate_bearings(
    reducer: Reducer,
    loadings: Sequence[Loading],
    peak_torque: float,
    temperatures: Mapping[str, float] | None = None,
) -> Iterator[RatedItem]:
    """Rate each rolling bearing: its life over a duty cycle, and its static safety factor in an emergency stop.

    `loadings` are the solved forces at each point of the duty. `peak_torque` is the output torque of the emergency stop
    [N m]. `temperatures` of the parts [°C] determine the viscosity of the oil; by default they are those of the design.

    Yields
    ------
    RatedItem
        For each bearing its life (ISO 281), its modified life if an oil viscosity is known, and its static safety
        factor (ISO 76).
    """
    for bearing in bearings_of(reducer):
        forces = [bearing_forces(reducer, bearing.key, loading) for loading in loadings]
        weighted_speeds = np.array(
            [bearing.speed(reducer, loading.point.speed) * loading.point.share for loading in loadings]
        )
        viscosity = oil_viscosity(reducer, temperatures=temperatures)
        yield from _rate_bearing(reducer, bearing, forces, weighted_speeds, loadings, peak_torque, viscosity)


def bearing_losses(reducer: Reducer, loading: Loading) -> dict[str, float]:
    """Compute the friction loss of the bearings of shaft and output [W], by key, such as ``output_bearing_inner``.

    Each loss follows from the mean load over the crank angles. `loading` has the solved forces. Bearings of cams and
    output rollers are left out, because statics includes their losses.
    """
    return {
        bearing.key: friction_torque(reducer, bearing, float(bearing_forces(reducer, bearing.key, loading).mean()))
        * bearing.speed(reducer, loading.point.speed)
        for bearing in bearings_of(reducer)
        if bearing.bore
    }


def friction_torque(reducer: Reducer, bearing: Bearing, load: float) -> float:
    """Compute the friction torque of a shaft or output bearing [N m] under a `load` P [N]: mu P d/2.

    This is the estimate of manufacturers, with the bore d (SKF, Rolling bearings, 2018, "Friction"). mu is the friction
    coefficient of the cam if the cam has a rolling bearing, or else the coefficient of needles in `ASSUMED_ROLLERS`.
    """
    design = reducer.design
    mu = design.friction_of("cam") if design.gear.bearing == "rolling" else ASSUMED_ROLLERS.needle_friction
    return 0.5 * mu * load * bearing.bore


def cam_ratings(reducer: Reducer) -> Ratings:
    """Return the dynamic and static load rating C and C0 of the bearing of a cam [N], with their sources.

    Values in the design file have priority, then a bearing from stock, then a row of rollers in the disc's bore.
    """
    design = reducer.design
    gear, bearing = design.gear, design.bearing
    roller_row = RollerRow(
        design.contact.cam_rollers, 2.0 * reducer.contacts.roller_radius, gear.face_width, 2.0 * gear.bore_radius
    )
    location_text = "touching each other on the cam's circle, the disc's bore as outer ring"
    stated_ratings = bearing.dynamic_capacity, bearing.static_capacity
    return _choose_ratings(stated_ratings, cam_bearing(reducer), roller_row, location_text)


def _shaft_ratings(reducer: Reducer) -> Ratings:
    """Return the dynamic and static load rating C and C0 of a bearing of the shaft [N], with their sources.

    Values in the design file have priority, then a bearing from stock, then an assumed row of rollers on the shaft.
    """
    radius, bearing = reducer.design.shaft.radius, reducer.design.bearing
    roller_diameter = ASSUMED_ROLLERS.shaft_roller_share * radius
    bearing_start, bearing_end = shaft_dimensions(reducer).bearings[0]
    roller_row = RollerRow(
        ASSUMED_ROLLERS.shaft_rollers, roller_diameter, bearing_end - bearing_start, 2.0 * radius + roller_diameter
    )
    stated_ratings, stock_bearing = (
        (bearing.shaft_dynamic_capacity, bearing.shaft_static_capacity),
        shaft_bearing(reducer),
    )
    return _choose_ratings(stated_ratings, (stock_bearing, 1) if stock_bearing else None, roller_row, "on the shaft")


def output_ratings(bearing: StockBearing) -> Ratings:
    """Return the load ratings C (dynamic) and C0 (static) of a bearing of the output [N], with their sources.

    They are catalogued, or for angular contact bearings of a central crank estimated. For a deep groove bearing, the
    source also states the rating of its estimated balls by ISO 281, for comparison.
    """
    if bearing.has_crossed_rollers:
        source = f"of THK's catalogue: {bearing.designation}, P = F + 2 M/d_pw"
        return Ratings(bearing.dynamic, bearing.static, f"C {source}", f"C0 {source}", bearing.pitch)
    if bearing.has_tapered_rollers:
        source, pitch = f"of SKF, from a public table: {bearing.designation}", 0.5 * (bearing.bore + bearing.outside)
        return Ratings(bearing.dynamic, bearing.static, f"C {source}", f"C0 {source}", pitch)
    balls, source = balls_of(bearing), f"of the manufacturer's catalogue: {bearing.designation}"
    if bearing.contact_angle:
        source = f"of {bearing.designation}, estimated from series 618 by balls and contact angle (ISO 281, ISO 76)"
        if has_catalogued_ratings(bearing):
            source = f"of IBC's catalogue: {bearing.designation}"
        sources = f"C {source}", f"C0 {source}"
        return Ratings(bearing.dynamic, bearing.static, *sources, balls.pitch, rolling.BALL_EXPONENT)
    iso_rating = rolling.ball_capacity(balls.count, balls.diameter, balls.pitch)
    life_ratio = (iso_rating / bearing.dynamic) ** rolling.BALL_EXPONENT
    comparison_text = (
        f"; ISO 281 gives {iso_rating:.4g} N for {balls.count} balls of {1e3 * balls.diameter:.3g} mm (estimated), "
        f"{life_ratio:.3g} times the life; ratings of manufacturers differ by as much"
    )
    sources = f"C {source}{comparison_text}", f"C0 {source}"
    return Ratings(bearing.dynamic, bearing.static, *sources, balls.pitch, rolling.BALL_EXPONENT)


def _output_roller_ratings(reducer: Reducer) -> Ratings:
    """Return the load ratings C (dynamic) and C0 (static) of the needles in an output roller [N], with their sources.

    Values in the design file have priority; otherwise they follow from assumed dimensions of the needles.
    """
    design = reducer.design
    output, bearing = design.output, design.bearing
    needles = needle_row(output)
    roller_row = RollerRow(needles.needles, needles.diameter, design.gear.face_width, needles.pitch)
    stated_ratings = bearing.output_dynamic_capacity, bearing.output_static_capacity
    return _choose_ratings(stated_ratings, None, roller_row, "round the core of a pin")


def _choose_ratings(
    stated_ratings: tuple[float, float],
    stock_bearing: tuple[StockBearing, int] | None,
    row: RollerRow,
    location_text: str,
) -> Ratings:
    """Return the load ratings C and C0 [N] of a bearing: of the design file, else from stock, else of assumed rollers.

    Parameters
    ----------
    stated_ratings
        C and C0 of the design file [N]; 0 if not stated.
    stock_bearing
        Bearing from stock and how many of them are side by side; None if none is bought.
    row
        The row of rollers that is assumed otherwise.
    location_text
        Where these rollers are, in words.
    """
    exponent, pitch = rolling.EXPONENT, row.pitch
    if stock_bearing:
        bearing, count = stock_bearing
        pitch = 0.5 * (bearing.bore + bearing.outside)
        dynamic_rating, static_rating = rolling.side_by_side(bearing.dynamic, count), count * bearing.static
        source = f"of the manufacturer's catalogue: {f'{count} x ' if count > 1 else ''}{bearing.designation}"
        sources = f"C {source}", f"C0 {source}"
        exponent = rolling.BALL_EXPONENT if has_inner_ring(bearing) else exponent
    else:
        base_capacity = row.dynamic / rolling.ISO_281.roller_steel
        dynamic_rating, static_rating = row.dynamic, row.static
        sources = (
            f"assumed: {row} {location_text}, b_m {rolling.ISO_281.roller_steel:g} "
            f"(C {base_capacity:.0f} N with b_m 1)",
            f"assumed: {row} {location_text}",
        )
    return Ratings(
        dynamic=stated_ratings[0] or dynamic_rating,
        static=stated_ratings[1] or static_rating,
        dynamic_source="C of the design file (bearing.*_capacity_n)" if stated_ratings[0] else sources[0],
        static_source="C0 of the design file" if stated_ratings[1] else sources[1],
        pitch=pitch,
        exponent=exponent,
    )


def _rate_bearing(
    reducer: Reducer,
    bearing: Bearing,
    forces: Sequence[Array],
    weighted_speeds: Array,
    loadings: Sequence[Loading],
    peak_torque: float,
    viscosity: float,
) -> Iterator[RatedItem]:
    """Yield life, modified life and static safety factor of the most loaded of several equal bearings.

    Parameters
    ----------
    bearing
        The kind of bearing, one of `bearings_of`.
    forces
        Forces at each point of the duty [N], at m crank angles, shape (m, bearings) each.
    weighted_speeds
        Relative speed of the rings times the share of time at each point [rad/s], shape (points,).
    loadings
        Solved loads at each point of the duty, of which only torque and share of time are used.
    peak_torque
        Output torque for the static factor [N m]; forces are scaled in proportion to the torque.
    viscosity
        Kinematic viscosity of the oil [m2/s]; 0 if it is unknown.
    """
    settings, ratings = reducer.design.bearing, bearing.ratings
    load = bearing_load(reducer, forces, weighted_speeds, ratings.exponent)
    life = rolling.life_hours(
        ratings.dynamic, load, float(weighted_speeds.sum()), settings.reliability, ratings.exponent
    )
    reliability_factor = rolling.reliability_factor(settings.reliability)
    formula = f"L = a1 (C/P)^{exponent_text(ratings)}, a1 {reliability_factor:.3g}, ISO 281:2007"
    inner_body, outer_body = bearing.joins
    note = (
        f"{ratings.dynamic_source}, service factor {settings.service_factor:g}; between {inner_body} and {outer_body}, "
        f"{float(weighted_speeds.sum()) / RPM:.4g} rpm mean speed"
    )
    yield RatedItem(bearing.key, f"{bearing.name}, life", load, ratings.dynamic, "N", None, life, formula, note)
    if viscosity and weighted_speeds.any():
        speed = float(weighted_speeds.sum()) / sum(load_case.point.share for load_case in loadings)
        yield rate_modified_life(bearing.key, bearing.name, ratings, viscosity, settings.cleanliness, load, life, speed)
    forces_per_torque = (
        float(force.max()) / abs(load_case.point.torque) for force, load_case in zip(forces, loadings, strict=True)
    )
    peak_force = peak_torque * max(forces_per_torque)
    yield RatedItem(
        f"{bearing.key}_static",
        f"{bearing.name}, static factor",
        peak_force,
        ratings.static,
        "N",
        ratings.static / peak_force if peak_force else math.inf,
        None,
        "s0 = C0/P0, ISO 76",
        f"{ratings.static_source}; at the peak torque of {peak_torque:.4g} N m, forces in proportion to the torque",
    )


def exponent_text(ratings: Ratings) -> str:
    """Return the exponent of the life of a bearing as text: 3 of balls, (10/3) of rollers."""
    return "3" if ratings.exponent == rolling.BALL_EXPONENT else "(10/3)"


def oil_viscosity(reducer: Reducer, pair: str = "cam", temperatures: Mapping[str, float] | None = None) -> float:
    """Return the kinematic viscosity of the oil in the bearings [m2/s]; 0 if the design states no lubricant.

    If the design file states no viscosity, the lubricant of the friction law ``film`` determines it, at its temperature
    in the contacts of `pair`: "teeth", "output" or "cam" (`lubricant_temperature`). `temperatures` are those of the
    parts [°C], by default those of the design.
    """
    design = reducer.design
    if design.bearing.viscosity or not design.has_film:
        return design.bearing.viscosity
    oil = lubricant(design.friction.lubricant)
    return oil.kinematic_viscosity(lubricant_temperature(reducer, pair, temperatures)) / MM2


def rate_modified_life(
    key: str,
    name: str,
    ratings: Ratings,
    viscosity: float,
    cleanliness: float,
    load: float,
    basic_life: float,
    speed: float,
) -> RatedItem:
    """Rate a bearing by its life [h] modified for lubrication and contamination (ISO 281:2007).

    The modified life is a_ISO times `basic_life`.

    Parameters
    ----------
    key, name, ratings
        Key, name and load ratings of the bearing.
    viscosity
        Kinematic viscosity of the oil [m2/s].
    cleanliness
        Contamination factor e_C [1].
    load
        Equivalent load [N].
    basic_life
        Life without the factor a_ISO [h].
    speed
        Speed of the rings relative to each other [rad/s].
    """
    curve = life_curve(ratings.exponent)
    kappa = MM2 * viscosity / reference_viscosity(speed, ratings.pitch)
    fatigue_limit = fatigue_load_limit(ratings.static, ratings.pitch, curve)
    factor = life_factor(kappa, cleanliness, fatigue_limit, load, curve) if load else LIMITS.max_factor
    range_note = (
        f"; kappa is below {LIMITS.min_kappa:g}, where ISO 281 has no value" if kappa < LIMITS.min_kappa else ""
    )
    return RatedItem(
        f"{key}_modified",
        f"{name}, modified life",
        load,
        ratings.dynamic,
        "N",
        None,
        factor * basic_life,
        "L = a_ISO a1 L10, a_ISO by kappa and e_C C_u/P, ISO 281:2007",
        f"a_ISO {factor:.3g}: kappa {kappa:.3g} = {MM2 * viscosity:.3g} mm2/s over nu_1, e_C {cleanliness:g}, "
        f"C_u {fatigue_limit:.4g} N by C0, d_m {1e3 * ratings.pitch:.3g} mm{range_note}",
    )


def bearing_load(reducer: Reducer, forces: Sequence[Array], weighted_speeds: Array, exponent: float) -> float:
    """Compute the equivalent dynamic load [N] over a duty on the most loaded of equal bearings, with service factor.

    Parameters
    ----------
    forces
        Forces at each point of the duty [N], at m crank angles, shape (m, bearings) each.
    weighted_speeds
        Relative speed of the rings times the share of time at each point [rad/s], shape (points,).
    exponent
        Exponent p of the bearing's life. With this load, the life is Miner's sum over the points.
    """
    mean_loads = np.array(
        [max(rolling.mean_load(force_history, exponent=exponent) for force_history in force.T) for force in forces]
    )
    return reducer.design.bearing.service_factor * rolling.mean_load(mean_loads, weighted_speeds, exponent)
