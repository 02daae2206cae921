"""Rating of an RV reducer: bearings of the cranks, main bearings, teeth on pins, and planet teeth."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.names import CRANK_BEARING
from cycloid_mj.base.units import HOUR, RPM
from cycloid_mj.design import describe_plastic_limits
from cycloid_mj.design.materials import YIELD_PRESSURE
from cycloid_mj.design.stock import StockBearing
from cycloid_mj.geometry.ideal_loads import contact_modulus, hertz_line_contact
from cycloid_mj.life import rolling
from cycloid_mj.life.bearings import (
    Ratings,
    RollerRow,
    bearing_load,
    exponent_text,
    oil_viscosity,
    output_ratings,
    rate_modified_life,
)
from cycloid_mj.life.duty import Duty, describe_condition, turning_points
from cycloid_mj.life.item import ItemKind, RatedItem, Rating, sort_by_margin
from cycloid_mj.life.output_loads import equivalent_load, preload
from cycloid_mj.life.pitting_factors import factors_of_contact, mean_speed_and_radius
from cycloid_mj.life.surfaces import pitting_cycles, pitting_limit, rate_lubricated_pitting
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.rv_main_bearings import main_bearing_load_centre
from cycloid_mj.statics.bearings import Planes
from cycloid_mj.statics.film import CRANK_TAPER, MAIN_BEARING
from cycloid_mj.statics.rv_sheet import film_over_turn, ideal_rv, solve_running_equilibrium, springs_over_turn

TAPERS = RollerRow(13, 0.14, 0.24, 0.73)
"""Assumed rollers of a tapered bearing; lengths over its outer diameter."""


MAIN_BEARINGS = {"inner": "next to the planets", "outer": "away from the planets"}
"""Position of a main bearing in the key of its items -> words."""


@dataclass(frozen=True)
class _Row:
    """A kind of bearing: its key, name and pair of `lubricant_temperature`, load ratings, and forces [N].

    The forces at each torque have the shape (m, bearings). `spin` is its speed over that of the crank bearings [1], and
    `load_text` describes the forces.
    """

    key: str
    name: str
    pair: str
    ratings: Ratings
    forces: tuple[Array, ...]
    spin: float = 1.0
    load_text: str = "radial forces only"


def rate_rv(reducer: RvReducer, duty: Duty, life: float, temperatures: Mapping[str, float] | None = None) -> Rating:
    """Rate an RV reducer over a duty cycle for a life [h]: life and safety of bearings, cycloid and planet teeth.

    The speeds of the duty are speeds of the sun. The forces on crank and main bearings are those of ideal load sharing
    or of the static equilibrium with clearances and errors, whichever has the larger equivalent load. `temperatures` of
    the parts [°C] determine the viscosity of the oil in the bearings; by default they are those of the design.

    Raises
    ------
    DesignError
        The sun does not turn.
    RunError
        No static equilibrium exists at a torque of the duty.
    """
    duty_points = turning_points(duty, reducer.design, "a life in hours can be computed")
    torques = np.array([abs(point.torque) for point in duty_points])
    bearing_turns, ratio = float(reducer.kinematics.bearing_turns), reducer.design.ratio
    weighted_crank_speeds = np.array([bearing_turns * abs(point.speed / ratio) * point.share for point in duty_points])
    speed_ratios = np.array([abs(point.speed / reducer.design.drive.speed) for point in duty_points])
    rated_items = [
        *(
            rated_item
            for bearing_row in _bearing_rows(reducer, torques)
            for rated_item in _rate_bearing(
                reducer,
                bearing_row,
                torques,
                bearing_row.spin * weighted_crank_speeds,
                duty.peak,
                sum(point.share for point in duty_points),
                oil_viscosity(reducer, bearing_row.pair, temperatures),
            )
        ),
        *_rate_teeth(reducer, torques, weighted_crank_speeds, duty.peak, speed_ratios),
        *_rate_planets(reducer, torques, weighted_crank_speeds, speed_ratios),
    ]
    items_by_margin = sort_by_margin(rated_items, life)
    condition, assumptions = describe_condition(reducer.design, duty), tuple(_assumptions(reducer, duty))
    return Rating(reducer.design.name, condition, life, items_by_margin, assumptions, None, 0.0, reducer.parts_text)


def _bearing_rows(reducer: RvReducer, torques: Array) -> Iterator[_Row]:
    """Yield the crank bearings in discs and flanges, and the main bearings, if any, with load ratings and forces [N].

    Forces are those under each of `torques` [N m], shape (points,), the output torques at the points of a duty cycle.
    """
    needle_ratings, taper_ratings = crank_bearing_ratings(reducer)
    forces = [crank_forces(reducer, float(torque)) for torque in torques]
    disc_bearing_forces = tuple(np.linalg.norm(force, axis=-1).reshape(len(force), -1) for force in forces)
    flange_bearing_forces = tuple(flange_forces(reducer, force) for force in forces)
    yield _Row(
        "crank_needles",
        "needles of a crank in a disc",
        CRANK_BEARING,
        needle_ratings,
        disc_bearing_forces,
    )
    yield _Row(
        "crank_tapers",
        "tapered bearing of a crank in a flange",
        CRANK_TAPER,
        taper_ratings,
        flange_bearing_forces,
    )
    yield from _main_bearing_rows(reducer, forces)


def _main_bearing_rows(reducer: RvReducer, forces: Sequence[Array]) -> Iterator[_Row]:
    """Yield both main bearings with load ratings and equivalent loads [N]; none if the design has no main bearings.

    `forces` are those of the n cranks on the D discs at m crank angles [N], shape (m, D, n, 2), at each torque.
    """
    bearing = reducer.main_bearing
    if bearing is None:
        return
    forces_by_torque = [main_bearing_forces(reducer, bearing, force) for force in forces]
    for index, (position, position_text) in enumerate(MAIN_BEARINGS.items()):
        loads = (
            equivalent_load(bearing, rolling.magnitudes(bearing_forces[index]))[:, np.newaxis]
            for bearing_forces in forces_by_torque
        )
        yield _Row(
            f"output_bearing_{position}",
            f"main bearing {position_text}",
            MAIN_BEARING,
            output_ratings(bearing),
            tuple(loads),
            1.0 / float(reducer.kinematics.bearing_turns),
            f"forces of the discs and preload {preload(bearing):.3g} N",
        )


def main_bearing_forces(reducer: RvReducer, bearing: StockBearing, disc_forces: Array) -> tuple[Array, Array]:
    """Compute the radial forces [N] on the main bearings at m crank angles, next to the planets and away from them.

    The carrier is a beam on two supports, in the load centres of both bearings. The planets are not included: their
    forces on equally loaded cranks cancel.

    Parameters
    ----------
    bearing
        Main bearing on each flange.
    disc_forces
        Forces between the n cranks and the D discs [N], shape (m, D, n, 2).

    Returns
    -------
    tuple of Array
        Forces on both bearings [N], shape (m, 2) each.
    """
    load_centre = main_bearing_load_centre(reducer, bearing)
    planes = Planes(disc_forces.sum(axis=2), np.array(reducer.design.gear.disc_planes))
    return planes.reactions_at(-load_centre, load_centre)


def crank_bearing_ratings(reducer: RvReducer) -> tuple[Ratings, Ratings]:
    """Return the load ratings of the needles of a crank in a disc, and of its bearing in a flange.

    Values of the design file have priority. A bearing in stock has those of the catalogue; needles and a special
    bearing have those of rollers, which are assumed for the special bearing.
    """
    cranks, stated, bearing = reducer.cranks, reducer.design.bearing, reducer.crank_bearing
    needles = RollerRow(
        cranks.needles,
        2.0 * cranks.needle_radius,
        reducer.design.gear.face_width,
        2.0 * reducer.needle_circle_radius,
    )
    needle_source = f"assumed: {needles}, the eccentric as inner ring, the disc as outer ring"
    cup_diameter = 2.0 * cranks.taper_radius
    tapers: RollerRow | StockBearing = bearing or RollerRow(
        TAPERS.rollers, TAPERS.diameter * cup_diameter, TAPERS.length * cup_diameter, TAPERS.pitch * cup_diameter
    )
    taper_source = f"of NSK's catalogue: {bearing.designation}" if bearing else f"assumed: {tapers} of a light series"
    pitch = 0.5 * (bearing.bore + bearing.outside) if bearing else TAPERS.pitch * cup_diameter
    return (
        _ratings_of((stated.dynamic_capacity, stated.static_capacity), needles, needles.pitch, needle_source),
        _ratings_of((stated.shaft_dynamic_capacity, stated.shaft_static_capacity), tapers, pitch, taper_source),
    )


def _ratings_of(
    stated_ratings: tuple[float, float], bearing: RollerRow | StockBearing, pitch: float, source: str
) -> Ratings:
    """Return the load ratings of a bearing: C and C0 of the design file [N], or where they are 0 those of `bearing`.

    `source` describes the ratings of `bearing`, and `pitch` is its pitch diameter [m].
    """
    dynamic_source, static_source = (
        "of the design file (bearing.*_capacity_n)" if stated else source for stated in stated_ratings
    )
    return Ratings(
        stated_ratings[0] or bearing.dynamic,
        stated_ratings[1] or bearing.static,
        f"C {dynamic_source}",
        f"C0 {static_source}",
        pitch,
    )


def crank_forces(reducer: RvReducer, torque: float) -> Array:
    """Return the forces of the n cranks on the D discs [N] at m crank angles, shape (m, D, n, 2).

    The forces follow from ideal load sharing or from the static equilibrium, whichever has the larger equivalent load
    over all bearings and angles (`rolling.mean_load`). `torque` [N m] acts on the output.
    """
    ideal_loads, solved_loads = ideal_rv(reducer, torque), solve_running_equilibrium(reducer, torque)
    equivalent_loads = [rolling.mean_load(loads.bearings) for loads in (ideal_loads, solved_loads)]
    return (ideal_loads if equivalent_loads[0] >= equivalent_loads[1] else solved_loads).cranks


def flange_forces(reducer: RvReducer, disc_forces: Array) -> Array:
    """Compute the magnitudes of the radial forces [N] on the bearings of n cranks in both flanges, shape (m, 2 n).

    The first n columns are the cranks in the first flange, the others the same cranks in the second flange. A crank is
    a beam on two supports (`RvReducer.crank_support`). `disc_forces` [N] are the force vectors between the n cranks
    and the D discs at m crank angles, shape (m, D, n, 2).
    """
    planes, gear = np.array(reducer.design.gear.disc_planes), reducer.design.gear
    support_position = 0.5 * gear.stack_width + gear.disc_gap + reducer.crank_support
    near_share = (support_position - planes) / (2.0 * support_position)
    support_forces = [np.einsum("mdnj,d->mnj", disc_forces, share) for share in (near_share, 1.0 - near_share)]
    return np.concatenate([np.linalg.norm(forces_at_support, axis=-1) for forces_at_support in support_forces], axis=1)


def _rate_bearing(
    reducer: RvReducer,
    bearing_row: _Row,
    torques: Array,
    weighted_speeds: Array,
    peak_torque: float,
    running_share: float,
    viscosity: float,
) -> Iterator[RatedItem]:
    """Yield life and modified life (ISO 281) and static safety factor (ISO 76) of the most loaded of equal bearings.

    `bearing_row` has the equal bearings with their forces at each of the `torques` of the duty [N m], shape (points,).
    `weighted_speeds` are the bearing's speeds at these points times their shares of time [rad/s], and `running_share`
    is the sum of these shares [1]. The static safety factor is that at `peak_torque` [N m]. The modified life requires
    a known kinematic `viscosity` of the oil [m2/s]; it is 0 if unknown.
    """
    settings = reducer.design.bearing
    ratings = bearing_row.ratings
    load = bearing_load(reducer, bearing_row.forces, weighted_speeds, ratings.exponent)
    life = rolling.life_hours(
        ratings.dynamic, load, float(weighted_speeds.sum()), settings.reliability, ratings.exponent
    )
    yield RatedItem(
        bearing_row.key,
        f"{bearing_row.name}, life",
        load,
        ratings.dynamic,
        "N",
        None,
        life,
        f"L = a1 (C/P)^{exponent_text(ratings)}, a1 {rolling.reliability_factor(settings.reliability):.3g}, P over a "
        "turn of the carrier, ISO 281:2007",
        f"{ratings.dynamic_source}, service factor {settings.service_factor:g}; "
        f"{float(weighted_speeds.sum()) / RPM:.4g} rpm mean speed; "
        f"{bearing_row.load_text}",
        ItemKind.BEARING,
    )
    if viscosity:
        key, name = bearing_row.key, bearing_row.name
        speed = float(weighted_speeds.sum()) / running_share
        yield rate_modified_life(key, name, ratings, viscosity, settings.cleanliness, load, life, speed)
    peak_force = peak_torque * max(
        float(force.max() / torque) for force, torque in zip(bearing_row.forces, torques, strict=True)
    )
    yield RatedItem(
        f"{bearing_row.key}_static",
        f"{bearing_row.name}, static factor",
        peak_force,
        ratings.static,
        "N",
        ratings.static / peak_force,
        None,
        "s0 = C0/P0, ISO 76",
        f"{ratings.static_source}; at the peak torque of {peak_torque:.4g} N m, forces in proportion to the torque",
        ItemKind.BEARING,
    )


def _rate_teeth(
    reducer: RvReducer, torques: Array, weighted_speeds: Array, peak_torque: float, speed_ratios: Array
) -> Iterator[RatedItem]:
    """Yield the safety against first yield and the pitting life of the cycloid teeth on their pins.

    Each lobe is loaded once per turn of a crank in its disc. With the friction law ``film``, the pitting life with the
    lubricant factors is a third item.

    Parameters
    ----------
    torques, weighted_speeds
        Torques of the duty [N m], and speeds of the cranks times their shares of time [rad/s], shape (points,).
    peak_torque
        Torque at which first yield is rated [N m].
    speed_ratios
        Speed at each point over that of the design [1].
    """
    kind = reducer.design.tooth_pair
    contact = reducer.at_rated_load.contacts[kind]
    curvature = springs_over_turn(reducer).curvature
    pressures = [
        float(contact.pressure(solve_running_equilibrium(reducer, float(torque)).pins, curvature).max())
        for torque in torques
    ]
    peak_pressure = pressures[int(np.argmax(torques))] * math.sqrt(peak_torque / torques.max())
    limit = YIELD_PRESSURE * contact.strength
    yield RatedItem(
        f"{kind}_yield",
        "teeth on pins, first yield",
        1e-6 * peak_pressure,
        1e-6 * limit,
        "MPa",
        (limit / peak_pressure) ** 2,
        None,
        f"p0 = {YIELD_PRESSURE:g} Y below the surface; safety by torque",
        f"at the peak torque of {peak_torque:.4g} N m, pressure with the root of the torque",
        ItemKind.SURFACE,
    )
    pitting = _rate_pitting(f"{kind}_pitting", "teeth on pins, pitting", reducer, kind, pressures, weighted_speeds)
    yield pitting
    if reducer.design.has_film:
        contacts = [_tooth_contact(reducer, float(torque)) for torque in torques]
        yield _rate_lubricated_pitting(reducer, pitting, contacts, pressures, weighted_speeds, speed_ratios)


def _tooth_contact(reducer: RvReducer, torque: float) -> tuple[float, float]:
    """Return mean entrainment speed [m/s] and reduced radius [m] of the teeth, at the design's speed, under a torque.

    The means are weighted by the tooth forces. `torque` [N m] acts on the output.
    """
    loads = solve_running_equilibrium(reducer, torque)
    surfaces = film_over_turn(reducer, float(np.sign(torque))).surfaces(loads)
    return mean_speed_and_radius(surfaces.smaller_friction(loads.pins)[1], surfaces, loads.pins)


def _rate_lubricated_pitting(
    reducer: RvReducer,
    pitting: RatedItem,
    contacts: list[tuple[float, float]],
    pressures: list[float],
    load_rates: Array,
    speed_ratios: Array,
) -> RatedItem:
    """Rate the life until pitting of teeth with the lubricant factors of ISO 6336-2.

    Parameters
    ----------
    pitting
        Rated item of the pitting life without these factors.
    contacts
        Entrainment speed at the design's speed [m/s], and reduced radius [m], at each point of the duty.
    pressures, load_rates
        Largest Hertz pressure [Pa] at each point of the duty, and number of loads on a tooth per second, times the
        point's share of time and 2 pi [rad/s].
    speed_ratios
        Speed at each point over that of the design [1].
    """
    factors = [
        factors_of_contact(reducer.design, ratio * entrainment, radius, 1e6 * pitting.limit)
        for ratio, (entrainment, radius) in zip(speed_ratios.tolist(), contacts, strict=True)
    ]
    return rate_lubricated_pitting(pitting, factors, pressures, load_rates.tolist())


def _rate_planets(
    reducer: RvReducer, torques: Array, weighted_speeds: Array, speed_ratios: Array
) -> Iterator[RatedItem]:
    """Yield the pitting life of the sun's teeth, by the pressure at the pitch point.

    With the friction law ``film``, the pitting life with the lubricant factors is a second item. Each planet loads each
    tooth once per turn of the sun relative to the carrier. `weighted_speeds` are the speeds of the cranks times the
    shares of time [rad/s] at the `torques` of the duty [N m], `speed_ratios` the speeds at these points relative to the
    design's speed [1], shape (points,) each.
    """
    planet, material = reducer.planet, reducer.design.material
    pitch_radii = [0.5 * planet.module * tooth_count for tooth_count in (planet.sun_teeth, planet.planet_teeth)]
    curvature = sum(1.0 / (radius * math.sin(planet.pressure_angle)) for radius in pitch_radii)
    modulus = contact_modulus(material.youngs_modulus, material.poisson)
    forces = [float(solve_running_equilibrium(reducer, float(torque)).flanks.max()) for torque in torques]
    pressures = [
        float(hertz_line_contact(force, planet.face_width, curvature, modulus).peak_pressure) for force in forces
    ]
    load_rates = weighted_speeds * reducer.cranks.count * planet.planet_teeth / planet.sun_teeth
    kind = reducer.design.tooth_pair
    pitting = _rate_pitting("sun_pitting", "sun on planets, pitting", reducer, kind, pressures, load_rates)
    yield pitting
    if reducer.design.has_film:
        entrainment = reducer.crank_speed * pitch_radii[1] * math.sin(planet.pressure_angle)
        contacts = [(entrainment, 1.0 / curvature)] * len(torques)
        yield _rate_lubricated_pitting(reducer, pitting, contacts, pressures, load_rates, speed_ratios)


def _rate_pitting(
    key: str, name: str, reducer: RvReducer, kind: str, pressures: list[float], load_rates: Array
) -> RatedItem:
    """Rate the life until steel surfaces pit (AGMA 2001-D04), by Miner's sum over the points of a duty.

    Parameters
    ----------
    key, name
        Key and name of the rated item.
    kind
        Kind of mating pair, which determines the materials.
    pressures
        Largest Hertz pressure at each point of the duty [Pa].
    load_rates
        Number of loads on a tooth per second at each point of the duty, times the point's share of time and 2 pi
        [rad/s], shape (points,).
    """
    allowed_pressure, source = min(map(pitting_limit, reducer.design.partners(kind)), key=lambda limit: limit[0])
    loads_per_hour = load_rates / (2.0 * math.pi) * HOUR
    damage = sum(
        float(loads) / pitting_cycles(pressure, allowed_pressure)
        for loads, pressure in zip(loads_per_hour, pressures, strict=True)
    )
    return RatedItem(
        key,
        name,
        1e-6 * max(pressures),
        1e-6 * allowed_pressure,
        "MPa",
        None,
        1.0 / damage,
        "Z_N = 2.466 n^-0.056, S_c by hardness, AGMA 2001-D04; Miner",
        f"{loads_per_hour.sum():.0f} loads per hour on each tooth; {source}",
        ItemKind.SURFACE,
    )


def _assumptions(reducer: RvReducer, duty: Duty) -> Iterator[str]:
    """Yield the assumptions of the rating of an RV reducer over the duty cycle `duty`, a sentence each.

    They are about forces, reliability, peak torque, failures that are not rated, and plastics.
    """
    yield (
        "forces: the larger of ideal sharing and the balance of springs with the clearances and errors of the design, "
        "with friction, over a turn of the carrier"
    )
    yield f"reliability of bearings: {reducer.design.bearing.reliability:.0%} (bearing.reliability)"
    yield f"peak torque: {duty.peak:.4g} N m{'' if duty.peak_given else ', twice the largest of the duty (--peak-nm)'}"
    yield (
        "not rated: strength of cranks, discs and tooth roots (`cycloid-mj stress`), wear (`cycloid-mj wear`), "
        + ("and strength of the carrier" if reducer.main_bearing else "strength of the carrier, and main bearings")
    )
    yield from describe_plastic_limits(reducer.design)
