"""Friction of a turning crank's contacts, against the way in which the ideal parts slide, and what it takes."""

import numpy as np

from cycloid_mj.base.types import Array
from cycloid_mj.geometry import ideal_loads, profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.gaps import Gaps


def rubbing(reducer: Reducer, mesh_gaps: Gaps, motion: Array) -> Array:
    """Compute the generalised friction of each contact per normal force [1], shape (..., n, u).

    `motion` is how the unknowns move with time, shape (..., u): `mechanism.gaps.ideal_motion` times the crank's speed.
    """
    sliding = np.einsum("...nu,...u->...n", mesh_gaps.slip_slope, motion)
    coefficient = np.where(
        mesh_gaps.kind == "output", reducer.design.friction_of("output"), reducer.design.mesh_friction
    )
    return np.asarray(-(coefficient * np.sign(sliding))[..., np.newaxis] * mesh_gaps.slip_slope)


def ideal_losses(reducer: Reducer, crank: Array, friction: float) -> tuple[float, float, float]:
    """Compute the ideal losses of mesh, output pins and cam as shares of the output power, by Coulomb's law.

    Means over crank angles [rad] (n,) under the design's own load and ideal sharing; `friction` is that of the mesh.
    A contact at l - rho from the pitch point slides at (l - rho) w/(N-1). Friction acts about the gear's centre with
    the arm s = l - rho + c (N-1) cos(B - alpha), against the gear's turning: the normal forces rise by
    1/(1 - mu sum F s / sum F arm). In the holes the gear slides at c w N/(N-1): its centre orbits while both turn back.
    The cam of radius R slides, or rolls with a bearing's coefficient, at R w N/(N-1) under its whole force.
    """
    design = reducer.design
    gear, load, output = reducer.tooth_profile, design.load.torque, design.output
    B = profile.pin_angles(gear) + crank[:, np.newaxis]
    reach = profile.pitch_distance(gear, B) - gear.pin_radius
    ring = ideal_loads.ideal_load_sharing(gear, load, crank)
    forces = ring.forces
    arm = reach + gear.eccentricity * gear.lobes * np.cos(B - profile.conjugate_alpha(gear, B))
    raised = 1.0 / (1.0 - friction * np.sum(forces * arm, axis=1) / load)
    mesh = friction * np.mean(raised * np.sum(forces * reach, axis=1)) / load
    pins = ideal_loads.ideal_output_forces(gear, output.pins, output.pin_circle_radius, load, crank)
    cam = np.linalg.norm(ideal_loads.cam_force(ring, pins, crank), axis=1)
    losses = [
        design.friction_of(kind) * radius * gear.ring_teeth * np.mean(force) / load
        for kind, radius, force in (
            ("output", gear.eccentricity, np.sum(pins, axis=1)),
            ("cam", design.gear.bore_radius, cam),
        )
    ]
    return float(mesh), float(losses[0]), float(losses[1])
