"""The balance of a reducer's springs under a load."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.compiling import announced
from cycloid_mj.design import Design
from cycloid_mj.errors import RunError
from cycloid_mj.loaded.springs import Springs
from cycloid_mj.mechanism.kernel import BALANCED, balance
from cycloid_mj.types import Array

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
    departures
        Of gear and output from their ideal places, as in ``mechanism.gaps``, shape (m, 4) [m].
    output_turn
        Of the output from its ideal angle, shape (m,) [rad].
    """

    teeth: Array
    output: Array
    cam: Array
    departures: Array
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
    z[:, :2] = springs.contacts.cam_place[:, 0]
    force = np.zeros(springs.contacts.distance.shape)
    for _ in range(ROUNDS):
        with announced():
            left = balance(springs.contacts, springs.cam_play, springs.cam_stiffness, load + friction, z, force, False)
        if not left <= BALANCED:
            raise RunError(f"no static balance under the load: {left:.3g} of it is left over")
        off = z[:, :2] - springs.contacts.cam_place[:, 0]
        distance = np.maximum(np.linalg.norm(off, axis=1), np.finfo(float).tiny)
        pressed = springs.cam_stiffness * np.maximum(distance - springs.cam_play, 0.0)
        before, friction = friction, np.einsum("mn,mnk->mk", force, springs.rubbing)
        friction[:, 2] += springs.cam_rubbing * pressed
        if np.abs(friction - before).max() < SETTLED * np.linalg.norm(load, axis=1).min():
            cam = -(pressed / distance)[:, np.newaxis] * off
            return Loads(force[:, : springs.teeth], force[:, springs.teeth :], cam, z, z[:, 3] / lever)
    raise RunError("no static balance: the friction is too large for the crank to turn under this load")
