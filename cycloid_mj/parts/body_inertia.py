"""Masses of the bodies of a simulation, and the inertia of the parts that rotate with the output."""

from dataclasses import replace

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array, significant, significant_tensor
from cycloid_mj.parts.inertia import MassProperties, mass_properties
from cycloid_mj.parts.parts import body_solids
from cycloid_mj.reducer import Reducer, RvReducer, once
from cycloid_mj.reducer.bodies import Role


def moving_masses(reducer: Reducer) -> dict[str, MassProperties]:
    """Return mass properties by part; a rotating ring includes its pins if these are not bodies."""
    return _moving_masses(reducer.shape)


@once
def _moving_masses(reducer: Reducer) -> dict[str, MassProperties]:
    masses = {name: mass_properties(solid) for name, solid in body_solids(reducer).items()}
    loaded_body = reducer.mechanism.turning
    if any(loaded_body in surfaces.bodies for surfaces in reducer.mechanism.surfaces if surfaces.role == Role.PIN):
        masses[loaded_body] = _add_pins(masses[loaded_body], masses["pin"], reducer)
    return masses


def pin_mass_matrix(reducer: Reducer) -> Array:
    """Return the mass matrix [kg] of a moving pin for its motion in each plane of contact, shape (planes, planes).

    A pin of two discs can tilt and has a plane of contact in the middle of each disc. With the mass m, the transverse
    inertia I about the centre and the distance 2 a between the planes, the diagonal elements are m/4 + I/(4 a^2), the
    others m/4 - I/(4 a^2). A pin that cannot tilt has one plane, and the matrix (1, 1) contains its mass.
    """
    pin_masses = moving_masses(reducer)[names.PIN]
    if not reducer.design.has_tilting_pins:
        return np.array([[pin_masses.mass]])
    first_plane, last_plane = reducer.design.gear.disc_planes
    tilting_mass = float(pin_masses.inertia[0, 0]) / (last_plane - first_plane) ** 2
    return 0.25 * pin_masses.mass + tilting_mass * np.array([[1.0, -1.0], [-1.0, 1.0]])


def output_inertia(reducer: Reducer) -> float:
    """Compute the inertia of the loaded member about the axis [kg m2]: the carrier or the ring."""
    return float(moving_masses(reducer)[reducer.mechanism.turning].inertia[2, 2])


def turning_inertia(reducer: Reducer) -> float:
    """Compute the inertia that rotates with the output at a locked crank [kg m2]: carrier and discs, or the ring.

    Ring pins, sleeves and cranks that are separate bodies count as if they were fixed in the ring or in the carrier.
    """
    return _turning_inertia(reducer.shape)


@once
def _turning_inertia(reducer: Reducer) -> float:
    masses, mechanism = moving_masses(reducer), reducer.mechanism
    rotating_masses = [masses[body.part] for body in mechanism.turning_along]
    rotation_inertia = sum(float(item.inertia[2, 2]) for item in (masses[mechanism.turning], *rotating_masses))
    return rotation_inertia + sum(
        masses[body.part].mass * float(body.position @ body.position) for body in mechanism.carried
    )


def play_inertia(reducer: Reducer) -> float:
    """Compute the inertia [kg m2], at the output, of all parts that move as the output crosses its backlash.

    The driven shaft is locked. These parts are the output alone (`turning_inertia`), except in an RV reducer, whose
    output also rotates the cranks with their planets and moves the discs on their orbit; these are the larger part.
    """
    if not isinstance(reducer, RvReducer):
        return turning_inertia(reducer)
    ratio = abs(float(reducer.member.crank_angle(1.0) / reducer.member.output_angle(1.0)))
    return turning_inertia(reducer) + _crank_inertia(reducer) * ratio**2


def _crank_inertia(reducer: RvReducer) -> float:
    """Compute the inertia of all cranks with their planets, and of the discs on their orbit, at the cranks [kg m2]."""
    masses, eccentricity = moving_masses(reducer), reducer.design.gear.eccentricity
    orbit_inertia = sum(masses[disc.part].mass for disc in reducer.mechanism.discs) * eccentricity**2
    return reducer.cranks.count * _about_axis(masses[names.CRANK]) + orbit_inertia


def input_inertia(reducer: Reducer) -> float:
    """Compute the moment of inertia of the mechanism at the input [kg m2], without the rotor of the motor.

    It is the sum of the crank, the discs on their orbit, and the slow parts divided by the square of the ratio; in an
    RV reducer also of the sun, with cranks, planets and discs reduced to it. The rotation of pins in a fixed ring is
    left out, about 1e-4 of the total, and so are needles.
    """
    design, masses = reducer.design, moving_masses(reducer)
    reduced_output = turning_inertia(reducer) / design.reduction**2
    if isinstance(reducer, RvReducer):
        speed_ratio = reducer.orbit_speed / design.drive.speed
        return _about_axis(masses[names.SUN]) + _crank_inertia(reducer) * speed_ratio**2 + reduced_output
    orbit_inertia = sum(masses[disc.part].mass for disc in reducer.mechanism.discs) * design.gear.eccentricity**2
    return _about_axis(masses[names.SHAFT]) + orbit_inertia + reduced_output


def _about_axis(part: MassProperties) -> float:
    """Return the inertia of a part about its axis of rotation, z [kg m2], which need not pass through its centroid."""
    return float(part.inertia[2, 2]) + part.mass * float(np.sum(part.centroid[:2] ** 2))


def _add_pins(housing: MassProperties, pin: MassProperties, reducer: Reducer) -> MassProperties:
    """Return the mass properties of a housing and its ring pins, evenly spaced on the pin circle, as one body.

    `pin` has the properties of one pin about its own centroid.
    """
    pin_count, polar_inertia = reducer.design.ring.mate_count, pin.mass * reducer.design.ring.pin_circle_radius**2
    orbit_inertia = np.diag([0.5 * polar_inertia, 0.5 * polar_inertia, polar_inertia])
    return replace(
        housing,
        mass=significant(housing.mass + pin_count * pin.mass),
        volume=significant(housing.volume + pin_count * pin.volume),
        inertia=significant_tensor(housing.inertia + pin_count * (pin.inertia + orbit_inertia)),
    )
