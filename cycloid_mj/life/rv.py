"""Rating of an RV reducer: bearings of the cranks, teeth on pins, and planet teeth."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import HOUR, RPM
from cycloid_mj.design import describe_plastic_limits
from cycloid_mj.design.materials import YIELD_PRESSURE
from cycloid_mj.geometry.ideal_loads import contact_modulus, hertz_line_contact
from cycloid_mj.life import rolling
from cycloid_mj.life.bearings import RollerRow
from cycloid_mj.life.duty import Duty
from cycloid_mj.life.item import ItemKind, RatedItem, Rating
from cycloid_mj.life.surfaces import pitting_cycles, pitting_limit
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv_sheet import balance_running, ideal_rv, springs_over_turn

TAPERS = RollerRow(13, 0.14, 0.24, 0.73)
"""Assumed rollers of a tapered bearing; lengths over its outer diameter."""


@dataclass(frozen=True)
class _Row:
    """A kind of crank bearing: key and name, load ratings [N] with their source, and forces (m, bearings) [N]."""

    key: str
    name: str
    dynamic: float
    static: float
    source: str
    forces: tuple[Array, ...]


def rate_rv(reducer: RvReducer, duty: Duty, life: float) -> Rating:
    """Rate an RV reducer over a duty cycle for a life [h]: life and safety of crank bearings, cycloid and planet teeth.

    Speeds of the duty are those of the sun. Crank bearings carry the larger of the forces of ideal load sharing and of
    the static balance with clearances and errors.

    Raises
    ------
    DesignError
        The sun does not turn.
    RunError
        No static equilibrium exists at a torque of the duty.
    """
    points = [point for point in duty.points if point.speed and point.torque]
    if not points:
        raise DesignError(
            f"{reducer.design.name}: drive.speed_rpm is 0, but a life in hours can be computed only if the sun gear "
            "turns: set a speed other than 0, such as 2295 rpm"
        )
    torques = np.array([abs(point.torque) for point in points])
    weighted_speeds = np.array([_bearing_speed(reducer, point.speed) * point.share for point in points])
    items = [
        *(
            item
            for row in _crank_bearing_rows(reducer, torques)
            for item in _rate_bearing(reducer, row, torques, weighted_speeds, duty.peak)
        ),
        *_rate_teeth(reducer, torques, weighted_speeds, duty.peak),
        *_rate_planets(reducer, torques, weighted_speeds),
    ]
    by_key = {item.key: item for item in sorted(items, key=lambda item: item.margin(life))}
    return Rating(
        reducer.design.name, duty.words, life, by_key, tuple(_assumptions(reducer, duty)), None, 0.0, reducer.parts_text
    )


def _bearing_speed(reducer: RvReducer, speed: float) -> float:
    """Return the speed of the crank bearings [rad/s] at a speed of the sun [rad/s]."""
    return float(reducer.kinematics.bearing_turns) * abs(speed / reducer.design.ratio)


def _crank_bearing_rows(reducer: RvReducer, torques: Array) -> Iterator[_Row]:
    """Yield the crank bearings, in the discs then in the flanges, with load ratings [N] and forces at each torque [N].

    `torques` [N m] are those on the output at the points of a duty.
    """
    stated_ratings, (needles, tapers) = reducer.design.bearing, crank_bearing_rollers(reducer)
    forces = [_crank_forces(reducer, float(torque)) for torque in torques]
    disc_bearing_forces = tuple(np.linalg.norm(force, axis=-1).reshape(len(force), -1) for force in forces)
    flange_bearing_forces = tuple(flange_forces(reducer, force) for force in forces)
    source_text = "of the design file (bearing.*_capacity_n)"
    yield _Row(
        "crank_needles",
        "needles of a crank in a disc",
        stated_ratings.dynamic_capacity or needles.dynamic,
        stated_ratings.static_capacity or needles.static,
        source_text
        if stated_ratings.dynamic_capacity
        else f"assumed: {needles}, the eccentric as inner ring, the disc as outer ring",
        disc_bearing_forces,
    )
    yield _Row(
        "crank_tapers",
        "tapered bearing of a crank in a flange",
        stated_ratings.shaft_dynamic_capacity or tapers.dynamic,
        stated_ratings.shaft_static_capacity or tapers.static,
        source_text if stated_ratings.shaft_dynamic_capacity else f"assumed: {tapers} of a light series",
        flange_bearing_forces,
    )


def crank_bearing_rollers(reducer: RvReducer) -> tuple[RollerRow, RollerRow]:
    """Return the rollers of the bearings of a crank: the needles in a disc, and assumed tapered rollers in a flange."""
    cranks, outer = reducer.cranks, 2.0 * reducer.cranks.taper_radius
    pitch = 2.0 * (cranks.eccentric_radius + cranks.needle_radius)
    return (
        RollerRow(cranks.needles, 2.0 * cranks.needle_radius, reducer.design.gear.face_width, pitch),
        RollerRow(TAPERS.rollers, TAPERS.diameter * outer, TAPERS.length * outer, TAPERS.pitch * outer),
    )


def _crank_forces(reducer: RvReducer, torque: float) -> Array:
    """Return the forces of the n cranks on the D discs [N] at m crank angles, shape (m, D, n, 2).

    They are those of ideal load sharing or of the static balance, whichever have the larger mean load. `torque` [N m]
    is that on the output.
    """
    shared, solved = ideal_rv(reducer, torque), balance_running(reducer, torque)
    means = [rolling.mean_load(loads.bearings) for loads in (shared, solved)]
    return (shared if means[0] >= means[1] else solved).cranks


def flange_forces(reducer: RvReducer, disc_forces: Array) -> Array:
    """Return the radial forces on the bearings of n cranks in the two flanges [N], shape (m, 2 n), flange by flange.

    A crank is a beam on two supports, in the middles of the flanges. `disc_forces` [N] are those between the n cranks
    and the D discs at m crank angles, shape (m, D, n, 2).
    """
    planes, gear = np.array(reducer.design.gear.disc_planes), reducer.design.gear
    support = 0.5 * gear.stack_width + gear.disc_gap + 0.5 * reducer.cranks.flange_thickness
    near_share = (support - planes) / (2.0 * support)
    support_forces = [np.einsum("mdnj,d->mnj", disc_forces, share) for share in (near_share, 1.0 - near_share)]
    return np.concatenate([np.linalg.norm(item, axis=-1) for item in support_forces], axis=1)


def _rate_bearing(
    reducer: RvReducer, bearing_row: _Row, torques: Array, weighted_speeds: Array, peak_torque: float
) -> Iterator[RatedItem]:
    """Yield life (ISO 281) and static factor (ISO 76) of the most loaded bearing of a row.

    Parameters
    ----------
    bearing_row
        Equal bearings, with their forces at each torque.
    torques, weighted_speeds
        Torques of the duty [N m], and speeds of the bearing times their shares of time [rad/s].
    peak_torque
        Torque of the static factor [N m].
    """
    settings = reducer.design.bearing
    means = np.array([max(map(rolling.mean_load, force.T)) for force in bearing_row.forces])
    load = settings.service_factor * rolling.mean_load(means, weighted_speeds)
    life = rolling.life_hours(bearing_row.dynamic, load, float(weighted_speeds.sum()), settings.reliability)
    yield RatedItem(
        bearing_row.key,
        f"{bearing_row.name}, life",
        load,
        bearing_row.dynamic,
        "N",
        None,
        life,
        f"L = a1 (C/P)^(10/3), a1 {rolling.reliability_factor(settings.reliability):.3g}, P over a turn of the "
        "carrier, ISO 281:2007",
        f"C {bearing_row.source}, service factor {settings.service_factor:g}; "
        f"{float(weighted_speeds.sum()) / RPM:.4g} rpm mean speed; "
        "radial forces only",
        ItemKind.BEARING,
    )
    worst = peak_torque * max(
        float(force.max()) / torque for force, torque in zip(bearing_row.forces, torques, strict=True)
    )
    yield RatedItem(
        f"{bearing_row.key}_static",
        f"{bearing_row.name}, static factor",
        worst,
        bearing_row.static,
        "N",
        bearing_row.static / worst,
        None,
        "s0 = C0/P0, ISO 76",
        f"C0 {bearing_row.source}; at the peak torque of {peak_torque:.4g} N m, forces in proportion to the torque",
        ItemKind.BEARING,
    )


def _rate_teeth(reducer: RvReducer, torques: Array, weighted_speeds: Array, peak_torque: float) -> Iterator[RatedItem]:
    """Yield the safety against first yield and the pitting life of the cycloid teeth on their pins.

    Each lobe is loaded once per turn of a crank in its disc.

    Parameters
    ----------
    torques, weighted_speeds
        Torques of the duty [N m], and speeds of the cranks times their shares of time [rad/s].
    peak_torque
        Torque at which first yield is rated [N m].
    """
    kind = reducer.design.tooth_pair
    contact = reducer.at_rated_load.contacts[kind]
    curvature = springs_over_turn(reducer).curvature
    pressures = [
        float(contact.pressure(balance_running(reducer, float(torque)).pins, curvature).max()) for torque in torques
    ]
    worst = pressures[int(np.argmax(torques))] * math.sqrt(peak_torque / torques.max())
    limit = YIELD_PRESSURE * contact.strength
    yield RatedItem(
        f"{kind}_yield",
        "teeth on pins, first yield",
        1e-6 * worst,
        1e-6 * limit,
        "MPa",
        (limit / worst) ** 2,
        None,
        f"p0 = {YIELD_PRESSURE:g} Y below the surface; safety by torque",
        f"at the peak torque of {peak_torque:.4g} N m, pressure with the root of the torque",
        ItemKind.SURFACE,
    )
    yield _rate_pitting(f"{kind}_pitting", "teeth on pins, pitting", reducer, kind, pressures, weighted_speeds)


def _rate_planets(reducer: RvReducer, torques: Array, weighted_speeds: Array) -> Iterator[RatedItem]:
    """Yield the pitting life of the sun's teeth, by the pressure at the pitch point.

    Each planet loads each tooth once per turn of the sun relative to the carrier. `weighted_speeds` are the speeds of
    the cranks times the shares of time [rad/s] at the `torques` of the duty [N m].
    """
    planet, material = reducer.planet, reducer.design.material
    radii = [0.5 * planet.module * teeth for teeth in (planet.sun_teeth, planet.planet_teeth)]
    curvature = sum(1.0 / (radius * math.sin(planet.pressure_angle)) for radius in radii)
    modulus = contact_modulus(material.youngs_modulus, material.poisson)
    forces = [float(balance_running(reducer, float(torque)).flanks.max()) for torque in torques]
    pressures = [
        float(hertz_line_contact(force, planet.face_width, curvature, modulus).peak_pressure) for force in forces
    ]
    load_rates = weighted_speeds * reducer.cranks.count * planet.planet_teeth / planet.sun_teeth
    yield _rate_pitting(
        "sun_pitting", "sun on planets, pitting", reducer, reducer.design.tooth_pair, pressures, load_rates
    )


def _rate_pitting(
    key: str, name: str, reducer: RvReducer, kind: str, pressures: list[float], load_rates: Array
) -> RatedItem:
    """Return the item of the life until steel surfaces pit (AGMA 2001-D04), by Miner's sum over the points of a duty.

    Parameters
    ----------
    key, name
        Key and name of the item.
    kind
        Kind of pair, for the materials.
    pressures
        Largest Hertz pressure at each point of the duty [Pa].
    load_rates
        Loads of a tooth per time at each point of the duty, times the point's share of time, in [rad/s]: 2 pi per load.
    """
    allowed, source = min(map(pitting_limit, reducer.design.partners(kind)), key=lambda limit: limit[0])
    hourly = load_rates / (2.0 * math.pi) * HOUR
    damage = sum(
        float(loads) / pitting_cycles(pressure, allowed) for loads, pressure in zip(hourly, pressures, strict=True)
    )
    return RatedItem(
        key,
        name,
        1e-6 * max(pressures),
        1e-6 * allowed,
        "MPa",
        None,
        1.0 / damage,
        "Z_N = 2.466 n^-0.056, S_c by hardness, AGMA 2001-D04; Miner",
        f"{hourly.sum():.0f} loads per hour on each tooth; {source}",
        ItemKind.SURFACE,
    )


def _assumptions(reducer: RvReducer, duty: Duty) -> Iterator[str]:
    """Yield the assumptions of the rating of an RV reducer, a sentence each."""
    yield (
        "forces: the larger of ideal sharing and the balance of springs with the clearances and errors of the design, "
        "with friction, over a turn of the carrier"
    )
    yield f"reliability of bearings: {reducer.design.bearing.reliability:.0%} (bearing.reliability)"
    yield f"peak torque: {duty.peak:.4g} N m{'' if duty.peak_given else ', twice the largest of the duty (--peak-nm)'}"
    yield (
        "not rated: strength of cranks, discs and tooth roots (`cycloid-mj stress`), heat (`cycloid-mj thermal`), "
        "strength of the carrier, main bearings and wear"
    )
    yield from describe_plastic_limits(reducer.design)
