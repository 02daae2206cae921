"""Friction of the contacts at a rotating crank, against the sliding of the ideal parts, and its losses."""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.geometry import ideal_loads, profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.gaps import Gaps


def compute_friction_per_force(reducer: Reducer, mesh_gaps: Gaps, motion: Array) -> Array:
    """Compute the generalised friction force of each of n contacts, divided by its normal force [1], shape (..., n, u).

    Coulomb friction opposes the sliding of the ideal parts. Its generalised force on an unknown z is -mu sign(v) ds/dz
    per normal force, with the friction coefficient mu, the sliding distance s and the sliding velocity v of the
    contact.

    Parameters
    ----------
    mesh_gaps
        The contacts, with the u unknowns z of ``reducer.gaps``.
    motion
        Velocities of z in the ideal motion [m/s], shape (..., u): `reducer.gaps.ideal_motion` times the crank's speed.
    """
    sliding = np.einsum("...nu,...u->...n", mesh_gaps.slip_slope, motion)
    coefficient = np.where(
        mesh_gaps.kind == "output", reducer.design.friction_of("output"), reducer.design.mesh_friction
    )
    return np.asarray(-(coefficient * np.sign(sliding))[..., np.newaxis] * mesh_gaps.slip_slope)


def missing_friction(reducer: Reducer) -> tuple[float, float]:
    """Estimate the friction losses that a simulation misses because contacts slide slower than the creep speed.

    Returns
    -------
    tuple of float
        Missing loss divided by the friction loss of teeth and output pins [1], and missing loss divided by the output
        power [1]. Both are 0 without friction.

    Notes
    -----
    The full Coulomb loss of a contact with the force F and the sliding speed v is mu F v. If v is below v0 F/F_w, with
    the creep speed v0 and the working force F_w, a simulation has only the share v F_w/(v0 F) of it. Tooth forces are
    those of a disc that only rotates, by an angle t: F = K max(a t - g, 0) for a tooth with the stiffness K, the lever
    arm a and the full clearance g. With weight, or if the disc moves sideways, the missing loss may be twice as large.
    A moving pin or sleeve divides the sliding between its two contacts, which extends the range to higher speeds.
    """
    design, gear = reducer.design, reducer.tooth_profile
    torque = reducer.contacts.working_load / design.gear.discs
    speed = abs(reducer.speed_against_ring)
    angles = np.arange(12) / 12 * 2.0 * np.pi / gear.ring_teeth
    phases = profile.pin_angles(gear) + angles[:, np.newaxis]
    play = sum(getattr(design.clearance, kind) for kind in (design.tooth_pair, design.seat_pair) if kind)
    tooth_forces = _forces_with_clearance(
        profile.moment_arm(gear, phases), torque, play, reducer.contacts.mesh_stiffness
    )
    pin_forces = ideal_loads.ideal_output_forces(
        gear, design.output.pins, design.output.pin_circle_radius, torque, angles
    )
    sliding = np.abs(profile.pitch_distance(gear, phases) - gear.pin_radius) * speed / gear.lobes
    hole_speed = gear.eccentricity * speed * gear.ring_teeth / gear.lobes
    total_loss, missing_loss = 0.0, 0.0
    contacts = [(design.tooth_pair, design.mesh_friction, tooth_forces, sliding, _creep_speed_factor(reducer))]
    if design.layout == "central":
        contacts.append(("output", design.friction_of("output"), pin_forces, np.full_like(pin_forces, hole_speed), 1.0))
    for kind, friction, force, slip, speed_factor in contacts:
        loss = friction * force * slip
        limit_speed = speed_factor * reducer.contacts.creep_speed * force / reducer.contacts[kind].force
        total_loss += float(np.mean(np.sum(loss, axis=1)))
        missing_loss += float(
            np.mean(np.sum(loss * np.maximum(1.0 - slip / np.maximum(limit_speed, 1e-12), 0.0), axis=1))
        )
    return (missing_loss / total_loss, missing_loss * gear.lobes / (torque * speed)) if total_loss else (0.0, 0.0)


def _creep_speed_factor(reducer: Reducer) -> float:
    """Compute the factor by which moving pins raise the creep speed of the teeth [1].

    Below the creep speed, friction is less than its Coulomb limit. The factor is 1 for fixed pins, and without
    friction. A moving pin of the radius R turns in a socket or on a core of the radius r. The sliding of the disc is
    divided between two contacts in series, at the disc and at the seat. Their friction forces f and f' are in
    equilibrium if r f' = R f, and have the limits mu F and mu' F under the normal force F. Below its limit, each
    contact creeps at a speed proportional to f/(mu F) or f'/(mu' F). The pin's surface moves by R/r times the sliding
    at the seat.
    """
    design = reducer.design
    ring, seat_kind = design.ring, design.seat_pair
    flank_friction, seat_friction = (
        design.friction_of(design.tooth_pair),
        design.friction_of(seat_kind) if seat_kind else 0.0,
    )
    if not ring.has_pin_bodies or not min(flank_friction, seat_friction) > 0.0:
        return 1.0
    radius_ratio = ring.sleeve_bore_radius / ring.pin_radius if ring.has_sleeves else 1.0
    smaller_limit = min(flank_friction, radius_ratio * seat_friction)
    return smaller_limit / flank_friction + smaller_limit / (radius_ratio**2 * seat_friction)


def _forces_with_clearance(arms: Array, torque: float, play: float, stiffness: float) -> Array:
    """Compute the forces of N teeth on a disc that only rotates [N], shape (n, N), at n crank angles.

    `arms` (n, N) [m] are the lever arms of the teeth; those with a negative arm are unloaded. `torque` [N m] is the
    positive torque on the disc. Each tooth has a clearance `play` [m] and a `stiffness` [N/m]. Bisection determines the
    rotation of the disc.
    """
    arms = np.maximum(arms, 0.0)
    low_turn = np.zeros(len(arms))
    high_turn = 2.0 * (play / arms.max(axis=1) + torque / (stiffness * np.max(arms**2, axis=1)))
    for _ in range(50):  # bisection to rounding
        rotation = 0.5 * (low_turn + high_turn)
        is_above = np.sum(arms * stiffness * np.maximum(arms * rotation[:, np.newaxis] - play, 0.0), axis=1) > torque
        low_turn, high_turn = np.where(is_above, low_turn, rotation), np.where(is_above, rotation, high_turn)
    return np.asarray(stiffness * np.maximum(arms * high_turn[:, np.newaxis] - play, 0.0))


def ideal_losses(reducer: Reducer, crank: Array, friction: float) -> tuple[float, float, float]:
    """Compute the friction losses under the design's own load with ideal load sharing, relative to the output power.

    Parameters
    ----------
    crank
        Crank angles [rad], shape (n,), over which the losses are averaged.
    friction
        Friction coefficient of the mesh [1].

    Returns
    -------
    tuple of float
        Losses of mesh, output pins and cam, each divided by the output power [1].

    Notes
    -----
    Symbols: eccentricity c, N ring teeth, pin radius rho, crank speed w, output torque T. At a pin, B is its angle from
    the crank, alpha the angle of the contact normal, and l the distance of its centre from the pitch point.

    The holes slide on the output pins at c w N/(N-1). The cam of radius R slides at R w N/(N-1) under its total force;
    a cam with a rolling bearing has the friction coefficient of the bearing instead. For the mesh, see
    `ideal_mesh_loss`.
    """
    design = reducer.design
    gear, load, output = reducer.tooth_profile, design.load.torque, design.output
    ring_loads = ideal_loads.ideal_load_sharing(gear, load, crank)
    pin_forces = ideal_loads.ideal_output_forces(gear, output.pins, output.pin_circle_radius, load, crank)
    cam_forces = np.linalg.norm(ideal_loads.cam_force(ring_loads, pin_forces, crank), axis=1)
    losses = [
        design.friction_of(kind) * radius * gear.ring_teeth * np.mean(force) / load
        for kind, radius, force in (
            ("output", gear.eccentricity, np.sum(pin_forces, axis=1)),
            ("cam", design.gear.bore_radius, cam_forces),
        )
    ]
    return ideal_mesh_loss(reducer, crank, friction), float(losses[0]), float(losses[1])


def ideal_mesh_loss(reducer: Reducer, crank: Array, friction: float) -> float:
    """Compute the friction loss of the mesh with ideal load sharing, relative to the power of the carrier.

    Torque and speed of the carrier are taken relative to the ring. The relative loss is the same at all torques.

    Parameters
    ----------
    crank
        Crank angles [rad], shape (n,), over which the loss is averaged.
    friction
        Friction coefficient of the mesh [1].

    Returns
    -------
    float
        Loss divided by the power [1].

    Notes
    -----
    For the symbols, see `ideal_losses`. A tooth contact slides at (l - rho) w/(N-1). Its friction acts about the gear's
    centre with the arm s = l - rho + c (N-1) cos(B - alpha), against the gear's rotation. The normal forces F under the
    torque T are therefore larger by the factor 1/(1 - mu sum(F s)/T).
    """
    gear = reducer.tooth_profile
    phases = profile.pin_angles(gear) + crank[:, np.newaxis]
    distances = profile.pitch_distance(gear, phases) - gear.pin_radius
    forces_per_torque = ideal_loads.ideal_load_sharing(gear, 1.0, crank).forces
    arm = distances + gear.eccentricity * gear.lobes * np.cos(phases - profile.conjugate_alpha(gear, phases))
    friction_factor = 1.0 / (1.0 - friction * np.sum(forces_per_torque * arm, axis=1))
    return float(friction * np.mean(friction_factor * np.sum(forces_per_torque * distances, axis=1)))
