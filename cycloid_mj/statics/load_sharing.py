"""Load sharing of springs with clearance that a common rotation closes: those of the pins of a disc, for example."""

import math

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import cacheable, njit


@njit(cache=cacheable(), error_model="numpy")
def share_torque(arms: Array, weights: Array, stiffness: Array, clearance: float, torque: Array) -> tuple[Array, Array]:
    """Compute the forces of m contact springs with clearance that share a torque by a common rotation, for n drives.

    Parameters
    ----------
    arms
        Lever arms of the springs [m], shape (n, m).
    weights
        Number of equal springs that each spring of a drive represents, shape (n,).
    stiffness
        Stiffness of a spring [N/m], shape (n,).
    clearance
        Clearance of all springs [m].
    torque
        Torque [N m], shape (n,).

    Returns
    -------
    tuple
        The forces [N], shape (n, m), and the torsional stiffness of the closed springs [N m/rad], shape (n,).
    """
    forces, torsional_stiffness = np.empty_like(arms), np.empty_like(torque)
    for drive in range(len(arms)):
        rotation, _, squared_arms = _solve_rotation(
            arms[drive], weights[drive], clearance, torque[drive] / stiffness[drive], 0.0, 0.0, np.inf
        )
        forces[drive] = stiffness[drive] * np.maximum(rotation * arms[drive] - clearance, 0.0)
        torsional_stiffness[drive] = stiffness[drive] * squared_arms
    return forces, torsional_stiffness


@njit(cache=cacheable(), error_model="numpy")
def protruding_forces(
    arms: Array, weights: Array, stiffness: Array, clearance: float, torque: Array, error: float
) -> Array:
    """Compute the force [N] of each of m contact springs if its clearance alone is reduced by an `error` [m].

    The result has the shape (n, m) for n candidate drives. `arms`, `weights`, `stiffness`, `clearance` and `torque` are
    those of `share_torque`.
    """
    forces, reduced_clearance = np.empty_like(arms), clearance - error
    for drive in range(len(arms)):
        load = torque[drive] / stiffness[drive]
        start, moment, squared_arms = _solve_rotation(arms[drive], weights[drive], clearance, load, 0.0, 0.0, np.inf)
        for spring in range(arms.shape[1]):
            arm, rotation = arms[drive, spring], start
            if start * arm > reduced_clearance:  # otherwise the spring is open and does not change the rotation
                first_step = (moment + arm * reduced_clearance) / (squared_arms + arm * arm)
                if _is_smaller(first_step, start):
                    rotation, _, _ = _solve_rotation(
                        arms[drive], weights[drive], clearance, load, arm, reduced_clearance, first_step
                    )
            forces[drive, spring] = stiffness[drive] * max(rotation * arm - reduced_clearance, 0.0)
    return forces


@njit(error_model="numpy", inner=True)
def _solve_rotation(
    arms: Array,
    weight: float,
    clearance: float,
    load: float,
    extra_arm: float,
    extra_clearance: float,
    start: float,
) -> tuple[float, float, float]:
    """Solve for the common rotation [rad] at which contact springs with clearance carry a moment.

    The springs have unit stiffness, so the moment `load` has the unit [m2]. There are `weight` springs with the
    `clearance` [m] at each of `arms` (m,) [m], and one spring with `extra_arm` and `extra_clearance` (none if the arm
    is 0). The moment is a convex, piecewise linear function of the rotation, so that Newton's method decreases to the
    solution from a larger `start` [rad], such as the solution without the extra spring, or inf, at which all springs
    are closed. The other results are sums over the closed springs [m2] whose ratio is the rotation: moments of the
    clearances, with `load`, and squared arms.
    """
    rotation, squared_arms = start, 0.0
    while True:
        moment, squared_arms = load, 1e-30
        for arm in arms:
            if rotation * arm > clearance:
                moment += weight * arm * clearance
                squared_arms += weight * arm * arm
        if rotation * extra_arm > extra_clearance:
            moment += extra_arm * extra_clearance
            squared_arms += extra_arm * extra_arm
        next_rotation = moment / squared_arms
        if not _is_smaller(next_rotation, rotation):
            return rotation, moment, squared_arms
        rotation = next_rotation


@njit(error_model="numpy", inner=True)
def _is_smaller(rotation: float, previous: float) -> bool:
    """Return whether a rotation is smaller than the `previous` by more than rounding."""
    return rotation < previous * (1.0 - math.copysign(1e-12, previous))
