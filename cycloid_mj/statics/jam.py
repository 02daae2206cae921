"""Jamming by friction, decided for parts without clearance."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.statics.kernel import KernelSprings


@dataclass(frozen=True)
class JamFrictionSettings:
    """Settings of the natural-parameter continuation in the friction of parts without clearance (`friction_limit`).

    Attributes
    ----------
    max_friction
        Multiple of the friction up to which parts without clearance must have an equilibrium; otherwise friction jams
        them. Forces grow as 1/(1 - friction/limit), tenfold at this limit: clearance and deflection move the contacts,
        and the limit, by the remaining tenth. Of 18 random drives with clearances of 0.6 to 208 um, all have an
        equilibrium at 1 and 100 % of the nominal torque if the limit is 1.03 times their friction; if it is 0.97 times,
        4 jam under the nominal torque, and if it is 0.9 times, 8.
    step
        Step of the friction, as a share of the design's friction.
    max_residual
        Largest residual of an equilibrium, relative to the load.
    max_displacement
        Largest displacement of a disc of an equilibrium, relative to the deflection of a cam under the load.
    """

    max_friction: float = 1.1
    step: float = 0.01
    max_residual: float = 1e-6
    max_displacement: float = 1000.0


JAM = JamFrictionSettings()


def friction_limit(springs: KernelSprings, angle_index: int, load: Array) -> float:
    """Compute the largest multiple of the design's friction [1] at which parts without clearance have an equilibrium.

    A larger friction jams the parts. The result is at most `JAM.max_friction`. `springs` are the contact springs.
    `load` (u,) [N] is the load on the u unknown displacements at the crank angle of index `angle_index`: forces along x
    and y and torque of each disc, then the torque of the output. Torques are divided by the radius of the circle of
    output pins.

    Notes
    -----
    Each contact is a linear unilateral spring in its ideal pose, each cam a linear spring about its axis. The system is
    homogeneous in displacements and load, so that friction alone decides whether it has a solution. It is solved by the
    Levenberg-Marquardt method, with the friction increased in steps (natural-parameter continuation).
    """
    from scipy.optimize import root

    slopes, friction_per_force, load_size = (
        springs.slope[angle_index],
        springs.friction_per_force[angle_index],
        float(np.abs(load).max()),
    )
    length_unit = load_size / springs.cam_stiffness

    def residual(displacements: Array, friction: float) -> Array:
        """Compute the residual forces divided by the largest component of the load [1], shape (u,).

        `displacements`, u unknowns, are multiples of the deflection `length_unit` [m]; `friction` is the multiple of
        the design's friction.
        """
        forces = springs.stiffness[angle_index] * np.maximum(-slopes @ displacements * length_unit, 0.0)
        residual_force = load + forces @ (slopes + friction * friction_per_force)
        cam_offsets = displacements[:-1].reshape(-1, 3)[:, :2] * length_unit
        lateral_offsets = friction * springs.cam_lateral * cam_offsets[:, ::-1] * (1.0, -1.0)
        residual_force[:-1].reshape(-1, 3)[:, :2] -= springs.cam_stiffness * (cam_offsets - lateral_offsets)
        residual_force[2:-1:3] += (
            friction * springs.cam_friction_per_force * springs.cam_stiffness * np.linalg.norm(cam_offsets, axis=1)
        )
        return np.asarray(residual_force / load_size)

    z, limit = np.zeros(load.size), 0.0
    for friction in JAM.step * np.arange(round(JAM.max_friction / JAM.step) + 1):
        solution = root(residual, z, args=(friction,), method="lm")
        if (
            np.abs(solution.fun).max() > JAM.max_residual
            or np.abs(solution.x[:-1].reshape(-1, 3)[:, :2]).max() > JAM.max_displacement
        ):
            break
        z, limit = solution.x, float(friction)
    return limit
