"""Mechanism of an RV reducer: its bodies, mating pairs and motion, shared by MuJoCo, the planar solver and the log.

Bodies, with their joints:

- the housing with the ring, or the carrier, at rest; the other one turns (joint ``output``);
- ``sun``: x, y and angle, or the angle only if bearings centre it;
- discs and free pins: x, y and angle;
- ``crank_1`` to ``crank_n``, each with its planet: the angle relative to the carrier, in which its axis is fixed.

Pairs of teeth and pins are those of a central crank. The others are

- ``crank_bearing``: an eccentric in its bore, with needles and tapered bearing in series, as in ``statics.rv``;
- ``planet_mesh``: sun and planet, with both flanks (`PlanetMesh`).

The bearings of the cranks in the carrier are thus part of those in the discs, and a crank has the place of its bore in
the carrier, which carries its mass. Needles have no mass. The frame is that of the carrier's axis: an offset of this
axis from that of the ring displaces the ring.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.deviations import Deviations
from cycloid_mj.geometry.kinematics import gear_centre
from cycloid_mj.geometry.rv import mesh_loss_factor
from cycloid_mj.reducer.bodies import (
    Body,
    Mating,
    Mechanism,
    Role,
    pin_bodies,
    ring_surfaces,
    surfaces_on_circle,
    tooth_mating,
)

if TYPE_CHECKING:
    from cycloid_mj.reducer.reducer import Reducer
    from cycloid_mj.reducer.rv import RvReducer

SUN_ANGLE = names.planar_joints(names.SUN)[-1]
"""Joint of the sun, and column of its angle in the log; speed and torque are ``sun_speed`` and ``sun_torque``."""


@dataclass(frozen=True)
class PlanetMesh:
    """Involute mesh of the sun with a planet, exact at every displacement.

    At the distance a of the centres, with the base radii b and B, the pressure angle alpha has cos(alpha) = (b + B)/a.
    With the angles s and p of sun and planet and the direction gamma from sun to planet, all counter-clockwise, the
    flanks of the sun are ahead of the middle of the backlash by the length t = b (s - gamma) + B (p - gamma) -
    `middle` - cos(alpha_0) e along the line of action, modulo the base pitch, and the gaps of the two flanks are::

        half_backlash + (b + B) (inv(alpha) - inv(alpha_0)) -+ t

    The transmission error is e = `amplitude` sin(`planet_teeth` (p - gamma) + `phase`). The upper sign is that of the
    flank which carries a counter-clockwise torque on the sun. Its normal from sun to planet leads from the direction
    gamma counter-clockwise to pi/2 - alpha, that of the other clockwise.

    Attributes
    ----------
    sun_base, planet_base
        Base radii b and B [m].
    pressure_angle
        alpha_0 [rad], at the distance of sun and crank axis.
    half_backlash
        Half of the backlash along the line of action [m].
    middle
        Value of b (s - gamma) + B (p - gamma) in the middle of the backlash at home [m], for each planet, shape (n,).
    base_pitch
        Distance of flanks along the line of action [m].
    amplitude, planet_teeth, phase
        Transmission error along the circle of cranks [m], its cycles per turn of the planet, phases [rad], shape (n,).
    arm
        Distance of the contact from the pitch point along the line of action [m]: friction there loses as much power
        as the mean over the path of contact does (`mesh_loss_factor`).
    """

    sun_base: float
    planet_base: float
    pressure_angle: float
    half_backlash: float
    middle: Array
    base_pitch: float
    amplitude: float
    planet_teeth: int
    phase: Array
    arm: float


def compute_planet_mesh(reducer: "RvReducer") -> PlanetMesh:
    """Compute the geometry of the involute mesh of sun and planets, with backlash and transmission error.

    At crank angle 0, each planet is mounted on its crank such that its teeth are in the middle of the backlash.
    """
    planet, (sun_gear, planet_gear) = reducer.planet, reducer.stage_gears
    sun_base, planet_base = sun_gear.base_radius, planet_gear.base_radius
    towards_planet = np.pi / 2.0 - 2.0 * np.pi * np.arange(reducer.cranks.count) / reducer.cranks.count
    loss_factor = mesh_loss_factor(planet.sun_teeth, planet.planet_teeth, planet.pressure_angle)
    return PlanetMesh(
        sun_base=sun_base,
        planet_base=planet_base,
        pressure_angle=math.acos(min(1.0, (sun_base + planet_base) / reducer.crank_radius)),
        half_backlash=0.5 * planet.backlash * math.cos(planet.pressure_angle),
        middle=-(sun_base + planet_base) * towards_planet,
        base_pitch=2.0 * np.pi * sun_base / planet.sun_teeth,
        amplitude=planet.transmission_error,
        planet_teeth=planet.planet_teeth,
        phase=planet.planet_teeth * towards_planet,
        arm=loss_factor * sun_base / (1.0 + planet.sun_teeth / planet.planet_teeth),
    )


def build_rv_mechanism(reducer: "RvReducer") -> Mechanism:
    """Build the mechanism of an RV reducer: its bodies, and the pairs of surfaces that may touch."""
    design, errors = reducer.design, reducer.deviations
    axis = np.array([reducer.crank_errors.axis_x, reducer.crank_errors.axis_y])
    errors = replace(errors, pin_displacement=errors.pin_displacement - axis)
    ring_side, seats = ring_surfaces(design, errors)
    discs = range(design.gear.discs)
    return Mechanism(
        design=design,
        phases=reducer.phases,
        bodies=tuple(_rv_bodies(reducer, errors)),
        matings=(
            *(tooth_mating(design, disc, ring_side) for disc in discs),
            *seats,
            *(_bearing_mating(reducer, disc) for disc in discs),
            _planet_mating(reducer),
        ),
    )


def crank_names(reducer: "RvReducer") -> tuple[str, ...]:
    """Return the names of the bodies of the cranks."""
    return names.all_numbered(names.CRANK, reducer.cranks.count)


def crank_joint(crank: str) -> str:
    """Return the joint of a crank, which is also the column of its angle relative to the carrier."""
    return names.planar_joints(crank)[-1]


def _rv_bodies(reducer: "RvReducer", errors: Deviations) -> Iterator[Body]:
    """Yield the bodies in this order: fixed member, sun, discs, loaded member, cranks, moving pins.

    The loaded member is the output: the carrier or the ring. `errors` displace the ring pins.
    """
    design, origin = reducer.design, np.zeros(2)
    loaded_body, fixed_body = reducer.member.turning_and_held
    yield Body(fixed_body, fixed_body, (), origin, origin)
    joints = names.planar_joints(names.SUN)
    is_floating = reducer.planet.sun_support == "floating"
    yield Body(names.SUN, names.SUN, joints if is_floating else joints[-1:], origin, origin)
    for name, phase, plane in zip(reducer.gears, reducer.phases, design.gear.disc_planes, strict=True):
        centre = gear_centre(reducer.tooth_profile, phase)
        yield Body(name, name, names.planar_joints(name), centre, centre, plane)
    yield Body(loaded_body, loaded_body, (names.OUTPUT_JOINT,), origin, origin)
    offsets = np.stack(
        [
            expanded(position_errors, (reducer.cranks.count,))
            for position_errors in (reducer.crank_errors.carrier_x, reducer.crank_errors.carrier_y)
        ],
        axis=-1,
    )
    for name, position in zip(crank_names(reducer), reducer.stage.crank_positions([0.0])[0] + offsets, strict=True):
        yield Body(name, names.CRANK, (crank_joint(name),), position, origin, carrier=names.OUTPUT)
    yield from pin_bodies(design, errors, names.HOUSING if loaded_body == names.HOUSING else "")


def _bearing_mating(reducer: "RvReducer", disc: int) -> Mating:
    """Return the pairs of surfaces of a disc's crank bores and the eccentrics of the cranks; `disc` is its index.

    The clearances of needle bearing and tapered bearing are included in the radius of the bores.
    """
    design, errors, crank_count = reducer.design, reducer.crank_errors, reducer.cranks.count
    error_shape, crank_bodies, disc_name = (design.gear.discs, crank_count), crank_names(reducer), reducer.gears[disc]

    def numbered_names(stem: str) -> tuple[str, ...]:
        return tuple(names.of_disc(name, disc, design.gear.discs) for name in names.all_numbered(stem, crank_count))

    bore_error = np.stack(
        [expanded(errors.bore_x, error_shape)[disc], expanded(errors.bore_y, error_shape)[disc]], axis=-1
    )
    radial_direction = profile.unit(np.array([-reducer.phases[disc]]))
    tangential_direction = np.stack([-radial_direction[:, 1], radial_direction[:, 0]], axis=-1)
    eccentric_error = (
        expanded(errors.eccentric_radial, error_shape)[disc][:, np.newaxis] * radial_direction
        + expanded(errors.eccentric_tangential, error_shape)[disc][:, np.newaxis] * tangential_direction
    )
    radius = reducer.cranks.eccentric_radius
    bores = surfaces_on_circle(
        numbered_names(names.BORE),
        disc_name,
        Role.OUTER,
        reducer.crank_radius,
        radius + reducer.bearing_clearance,
        bore_error,
        disc=disc,
    )
    eccentrics = surfaces_on_circle(
        numbered_names(names.ECCENTRIC),
        crank_bodies,
        Role.ECCENTRIC,
        design.gear.eccentricity,
        radius,
        eccentric_error,
        np.full(crank_count, -reducer.phases[disc]),
        disc=disc,
    )
    return Mating(names.CRANK_BEARING, numbered_names(names.CRANK), bores, eccentrics, disc)


def _planet_mating(reducer: "RvReducer") -> Mating:
    """Return the pairs of the sun and the planets; run-out displaces a planet's teeth from the axis of its crank."""
    crank_count, errors = reducer.cranks.count, reducer.crank_errors
    sun_gear, planet_gear = reducer.stage_gears
    runout = np.stack([expanded(errors.planet_x, (crank_count,)), expanded(errors.planet_y, (crank_count,))], axis=-1)
    sun_surfaces = surfaces_on_circle(
        (names.column(names.SUN, names.TEETH),), names.SUN, Role.SUN, 0.0, sun_gear.tip_radius
    )
    planet_names = names.all_numbered(names.PLANET, crank_count)
    planet_surfaces = surfaces_on_circle(
        planet_names, crank_names(reducer), Role.PLANET, 0.0, planet_gear.tip_radius, runout, np.zeros(crank_count)
    )
    return Mating(names.PLANET_MESH, planet_names, sun_surfaces, planet_surfaces)


def needle_share(needles: int) -> float:
    """Return the stiffness of each of Z needles over that of a bearing without clearance.

    The needles on one half of the bearing carry the load; the sum of the squared cosines of their angles is Z/4.
    """
    return 4.0 / needles


def needle_directions(reducer: "Reducer", crank: Array) -> Array:
    """Return the directions of the Z separate needles of a bearing at m angles as unit vectors, shape (m, Z, 2).

    The directions are the same for all cams or eccentrics, because the cage rolls with the crank in the disc. A needle
    is on +y at the crank angle 0. `crank` are crank angles against the ring [rad], shape (m,).
    """
    needle_count = reducer.separate_needles
    disc_angle = -crank / reducer.design.lobes
    needle_angle = (disc_angle + reducer.cage_ratio * (crank - disc_angle))[:, np.newaxis] + 2.0 * np.pi * np.arange(
        needle_count
    ) / max(needle_count, 1)
    return np.stack([-np.sin(needle_angle), np.cos(needle_angle)], axis=-1)


def rv_motion(reducer: "RvReducer", sun: float, speed: float) -> tuple[dict[str, float], dict[str, float]]:
    """Compute positions and speeds of the joints at an angle [rad] and speed [rad/s] of the sun, in the ideal motion.

    Parts are rigid and have no errors. Joints that the result does not have, such as those of moving pins, are at 0,
    the middle of their seats.

    Returns
    -------
    tuple of dict
        Positions [m] or [rad], and speeds [m/s] or [rad/s], by name of the joint.
    """
    member, gear = reducer.member, reducer.tooth_profile
    crank_angle, crank_speed = float(member.crank_angle(sun)), float(member.crank_angle(speed))
    position = {SUN_ANGLE: sun, names.OUTPUT_JOINT: float(member.output_angle(sun))}
    velocity = {SUN_ANGLE: speed, names.OUTPUT_JOINT: float(member.output_angle(speed))}
    for name, phase in zip(reducer.gears, reducer.phases, strict=True):
        x, y = (float(coordinate) for coordinate in gear_centre(gear, crank_angle + phase))
        joints = names.planar_joints(name)
        position |= dict(zip(joints, (x, y, float(member.gear_angle(sun))), strict=True))
        velocity |= dict(zip(joints, (-crank_speed * y, crank_speed * x, float(member.gear_angle(speed))), strict=True))
    for name in crank_names(reducer):
        position[crank_joint(name)] = float(member.against_carrier(sun))
        velocity[crank_joint(name)] = float(member.against_carrier(speed))
    return position, velocity


def expanded(values: tuple[float, ...], shape: tuple[int, ...]) -> Array:
    """Return a list of errors as an array of a `shape`; an empty list becomes zeros."""
    return np.array(values).reshape(shape) if values else np.zeros(shape)
