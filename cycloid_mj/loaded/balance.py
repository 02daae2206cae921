"""The balance of a reducer's springs under a load."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.design import Design
from cycloid_mj.errors import RunError
from cycloid_mj.loaded.springs import FAR, Springs

Array = npt.NDArray[np.float64]

STEPS, TOLERANCE = 200, 1e-7
"""Most Newton steps, and largest residual force as a share of the load."""

ROUNDS, SETTLED = 30, 1e-4
"""Most rounds of friction, and the change of friction that ends them, as a share of the load."""


@dataclass(frozen=True)
class Loads:
    """Forces at m crank angles under one load.

    Attributes
    ----------
    teeth, output
        On each contact line with the ring, shape (m, lines), and each output pin [N], shape (m, pins).
    cam
        Of the cam on the gear [N], shape (m, 2).
    output_turn
        Of the output from its ideal angle, shape (m,) [rad].
    """

    teeth: Array
    output: Array
    cam: Array
    output_turn: Array


def loads(design: Design, springs: Springs, torque: float) -> Loads:
    """Give what the contacts carry under a torque on the output [N m], counter-clockwise, not 0.

    Raises
    ------
    RunError
        No balance was found.
    """
    lever, count = design.output.pin_circle_radius, springs.crank.size
    load = np.zeros((count, 4))
    load[:, :2], load[:, 3] = springs.body_force, torque / lever
    z, friction = np.zeros(load.shape), np.zeros(load.shape)
    for _ in range(ROUNDS):
        z = _pose(springs, load + friction, z)
        force = springs.stiffness * np.maximum(-_gap(springs, z), 0.0)
        pressed, towards, _ = _cam(springs, z)
        before, friction = friction, np.einsum("mn,mnk->mk", force, springs.rubbing)
        friction[:, 2] += springs.cam_rubbing * springs.cam_stiffness * pressed
        if np.abs(friction - before).max() < SETTLED * np.linalg.norm(load, axis=1).min():
            cam = -springs.cam_stiffness * pressed[:, np.newaxis] * towards
            return Loads(force[:, : springs.teeth], force[:, springs.teeth :], cam, z[:, 3] / lever)
    raise RunError("no static balance: the friction is too large for the crank to turn under this load")


def _pose(springs: Springs, load: Array, start: Array) -> Array:
    """Find the pose of least energy [m], shape (m, 4), under a load [N], (m, 4), from a pose near it or from 0."""
    z = start
    size = np.linalg.norm(load, axis=1)
    stiffest, travel = float(springs.stiffness.max() + springs.cam_stiffness), 10.0 * _play(springs)
    energy, gradient, hessian = _energy(springs, load, z)
    for _ in range(STEPS):
        left = np.linalg.norm(gradient, axis=1) / size
        if left.max() < TOLERANCE:
            return z
        # where too few contacts carry, the damping holds the step; it fades as the balance comes near
        damping = np.minimum(1e-3 * stiffest, size / travel) * np.minimum(left, 1.0)
        step = np.linalg.solve(hessian + damping[:, np.newaxis, np.newaxis] * np.eye(4), -gradient[..., np.newaxis])
        z, (energy, gradient, hessian) = _searched(springs, load, z, step[..., 0], energy, gradient)
    raise RunError(f"no static balance under the load: {left.max():.3g} of it is left over")


def _searched(
    springs: Springs, load: Array, z: Array, step: Array, energy: Array, gradient: Array
) -> tuple[Array, tuple[Array, Array, Array]]:
    """Go along the steps as far as the energy falls as it should (Armijo's rule); give the pose and what it has."""
    share, promised = np.ones(len(z)), np.sum(gradient * step, axis=1)
    for _ in range(30):
        tried = z + share[:, np.newaxis] * step
        found = _energy(springs, load, tried)
        rounding = 1e-12 * np.abs(energy)
        risen = found[0] > energy + 1e-4 * share * promised + rounding
        if not risen.any():
            break
        share = np.where(risen, 0.5 * share, share)
    return tried, found


def _energy(springs: Springs, load: Array, z: Array) -> tuple[Array, Array, Array]:
    """Give the energy less the work of the load [J], (m,), its gradient [N], (m, 4), and hessian [N/m], (m, 4, 4)."""
    depth = np.maximum(-_gap(springs, z), 0.0)
    force = springs.stiffness * depth
    closed = springs.stiffness * (depth > 0.0)
    energy = 0.5 * np.sum(force * depth, axis=1) - np.sum(load * z, axis=1)
    gradient = -np.einsum("mn,mnk->mk", force, springs.slope) - load
    hessian = np.einsum("mn,mnj,mnk->mjk", closed, springs.slope, springs.slope)
    pressed, towards, distance = _cam(springs, z)
    energy += 0.5 * springs.cam_stiffness * pressed**2
    gradient[:, :2] += springs.cam_stiffness * pressed[:, np.newaxis] * towards
    along = towards[:, :, np.newaxis] * towards[:, np.newaxis, :]
    across = (pressed / distance)[:, np.newaxis, np.newaxis] * (np.eye(2) - along)
    hessian[:, :2, :2] += springs.cam_stiffness * (along * (pressed > 0.0)[:, np.newaxis, np.newaxis] + across)
    return energy, gradient, hessian


def _play(springs: Springs) -> float:
    """Give the largest gap at the ideal pose [m]."""
    return float(springs.cam_play + np.abs(springs.gap[springs.gap < FAR]).max())


def _gap(springs: Springs, z: Array) -> Array:
    return springs.gap + np.einsum("mnk,mk->mn", springs.slope, z)


def _cam(springs: Springs, z: Array) -> tuple[Array, Array, Array]:
    """Depth of the cam in its bore [m], (m,), direction from the cam to the gear's centre, (m, 2), and distance [m]."""
    off = z[:, :2] - springs.cam_place
    distance = np.maximum(np.linalg.norm(off, axis=1), np.finfo(float).tiny)
    return np.maximum(distance - springs.cam_play, 0.0), off / distance[:, np.newaxis], distance
