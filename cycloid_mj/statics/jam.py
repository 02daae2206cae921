"""Whether friction jams a reducer, decided without the search for its balance."""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.statics.kernel import KernelSprings

STEP = 0.01
"""Share of the friction by which it is brought on."""

BORNE = 1.1
"""Multiple of the friction up to which it is brought on; parts that bear less of it jam where no balance is found.

Forces grow as 1/(1 - friction/limit), tenfold here: play and give move the contacts, and the limit, by the rest.
Of 18 random drives with 0.6 to 208 um of play all balance where 1.03 times their friction is borne, at 1 and 100 % of
the rated torque; where 0.97 times is, 4 jam under the rated torque, where 0.9 times is, 8; play lets others turn.
"""

_LEFT, _GROWN = 1e-6, 1000.0
"""What may be left of the load, as a share of it, and the way of a disc, as a multiple of a cam's give under the load,
from which on it jams: next to its limit forces grow as 1/(1 - friction/limit)."""


def friction_borne(springs: KernelSprings, k: int, load: Array) -> float:
    """Compute up to which multiple of their friction parts without play carry a load (u,) [N] at a crank angle.

    At its ideal place each contact is a linear spring that only pushes, and each cam one about its axis: a system that
    is homogeneous in departures and load, so that friction alone decides whether it has a solution, whatever the load.
    It is solved by Levenberg and Marquardt's method while friction is brought on in steps, up to `BORNE`.
    """
    from scipy.optimize import root

    slopes, rubbing, scale = springs.slope[k], springs.rubbing[k], float(np.abs(load).max())
    unit = scale / springs.cam_stiffness

    def left(z: Array, friction: float) -> Array:
        forces = springs.stiffness[k] * np.maximum(-slopes @ z * unit, 0.0)
        rest = load + forces @ (slopes + friction * rubbing)
        away = z[:-1].reshape(-1, 3)[:, :2] * unit
        rest[:-1].reshape(-1, 3)[:, :2] -= springs.cam_stiffness * away
        rest[2:-1:3] += friction * springs.cam_rubbing * springs.cam_stiffness * np.linalg.norm(away, axis=1)
        return np.asarray(rest / scale)

    z, borne = np.zeros(load.size), 0.0
    for friction in STEP * np.arange(round(BORNE / STEP) + 1):
        balanced = root(left, z, args=(friction,), method="lm")
        if np.abs(balanced.fun).max() > _LEFT or np.abs(balanced.x[:-1].reshape(-1, 3)[:, :2]).max() > _GROWN:
            break
        z, borne = balanced.x, float(friction)
    return borne
