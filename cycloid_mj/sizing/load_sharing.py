"""Load sharing of springs with clearance that a common rotation closes: those of the pins of a disc, for example."""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import cacheable, njit


@njit(cache=cacheable(), error_model="numpy")
def share_torque(
    arms: Array, weights: Array, stiffness: Array, clearance: float, error: float, torque: Array
) -> tuple[Array, Array, Array]:
    """Compute the forces of m springs of each of n candidates that balance a torque by a common rotation.

    Parameters
    ----------
    arms
        Lever arms of the springs [m], shape (n, m).
    weights
        Number of springs that each of them stands for, shape (n,).
    stiffness
        Stiffness of a spring [N/m], shape (n,).
    clearance
        Clearance of all springs [m].
    error
        Distance by which a single spring may protrude into its clearance [m].
    torque
        Torque [N m], shape (n,).

    Returns
    -------
    tuple
        The forces without errors [N], shape (n, m); the force of each spring if it is the one that protrudes [N], shape
        (n, m); and the torsional stiffness of the closed springs without errors [N m/rad], shape (n,).
    """
    forces, protruding, torsional = np.empty_like(arms), np.empty_like(arms), np.empty_like(torque)
    for row in range(len(arms)):
        arm, load = arms[row], torque[row] / stiffness[row]
        turn, torsional[row] = _solve_rotation(arm, weights[row], clearance, load, 0.0, 0.0)
        torsional[row] *= stiffness[row]
        for column in range(len(arm)):
            forces[row, column] = stiffness[row] * max(turn * arm[column] - clearance, 0.0)
            least, _ = _solve_rotation(arm, weights[row], clearance, load, arm[column], clearance - error)
            protruding[row, column] = stiffness[row] * max(least * arm[column] - clearance + error, 0.0)
    return forces, protruding, torsional


@njit(error_model="numpy", inner=True)
def _solve_rotation(
    arms: Array, weight: float, clearance: float, load: float, extra_arm: float, extra_clearance: float
) -> tuple[float, float]:
    """Solve for the rotation [rad] at which springs of unit stiffness have a moment `load` [m2] in all.

    Besides the springs with `arms` (m,), there is one with `extra_arm` and a clearance of its own (none if the arm is
    0). The moment is a convex, piecewise linear function of the rotation, so that Newton's method, started with all
    springs closed, decreases to the solution. The second result is the sum of the squared arms of closed springs [m2].
    """
    turn, squares = np.inf, 0.0
    while True:
        moment, squares = load, 1e-30
        for arm in arms:
            if turn * arm > clearance:
                moment += weight * arm * clearance
                squares += weight * arm * arm
        if turn * extra_arm > extra_clearance:
            moment += extra_arm * extra_clearance
            squares += extra_arm * extra_arm
        solution = moment / squares
        if not solution < turn * (1.0 - 1e-12):
            return turn, squares
        turn = solution
