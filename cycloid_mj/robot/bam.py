"""The joint's friction as the models M3 and M5 of BAM, which robot learners use, in BAM's own parameters.

Duclusaud, Passault, Padois, Ly, "Extended Friction Models for the Physics Simulation of Servo Actuators", ICRA 2025
(arXiv 2410.08650), and its code, Rhoban/bam, `bam/model.py`. With the motor's torque t_m and the external torque t_e at
the joint, both with their signs, friction is at most

- M3, load-dependent: friction_base + load_friction_base |t_e - t_m| + friction_viscous |w|
- M5, Stribeck, load-dependent, directional: friction_base + |load_friction_external t_e - load_friction_motor t_m|
  + exp(-|w/dtheta_stribeck|^alpha) (friction_stribeck + |load_friction_external_stribeck t_e -
  load_friction_motor_stribeck t_m|) + friction_viscous |w|

where w is the joint's speed. Friction of contacts here is Coulomb's at any speed, so what M5 has of Stribeck is 0.
"""

from typing import Any

import numpy as np
from scipy.optimize import nnls

from cycloid_mj.base.array import Array
from cycloid_mj.robot.friction import FrictionMap
from cycloid_mj.robot.reducer import ReducedJoint

MIN_FIT_SHARE = 0.25
"""Share of the nominal torque from which friction is fitted, up to the nominal torque."""

WITHOUT_STRIBECK = {
    **dict.fromkeys(("friction_stribeck", *(f"load_friction_{part}_stribeck" for part in ("motor", "external"))), 0.0),
    **{"dtheta_stribeck": 0.2, "alpha": 1.35},
}
"""Parameters without a Stribeck effect; the last two are BAM's start values, and have no effect."""


def bam(reduced: ReducedJoint) -> dict[str, Any]:
    """Return the parameters of M3 and M5 at the joint [N m, N m s/rad, 1], and their largest errors.

    Least squares over the loads from `MIN_FIT_SHARE` of the nominal torque on, driving and driven, at the rated speed.
    """
    base, viscous = reduced.no_load_torque_at_output, _viscous(reduced)
    external, motor, lost = _loads(reduced)
    m3, _ = nnls((external + motor)[:, np.newaxis], lost)
    m5, _ = nnls(np.stack([external, motor], axis=1), lost)
    by_torque = {"load_friction_motor": float(m5[1]), "load_friction_external": float(m5[0])}
    common = {"friction_base": base, "friction_viscous": viscous, "armature": reduced.reflected_inertia}
    return {
        "source": "BAM, Rhoban, ICRA 2025: arXiv 2410.08650",
        "joint": f"output of {reduced.name}, {reduced.ratio:g}:1; torques at the joint [N m], speeds in rad/s",
        "m3": {"model": "m3", **common, "load_friction_base": float(m3[0])},
        "m5": {"model": "m5", **common, **by_torque, **WITHOUT_STRIBECK},
        "largest_error_nm": {
            "m3": float(np.abs(m3[0] * (external + motor) - lost).max()),
            "m5": float(np.abs(m5[0] * external + m5[1] * motor - lost).max()),
        },
        "fitted_nm": [MIN_FIT_SHARE * reduced.rated_torque, reduced.rated_torque],
    }


def _loads(reduced: ReducedJoint) -> tuple[Array, Array, Array]:
    """Compute external torque, motor torque, and friction beyond that of no load at the joint [N m], shape (n,) each.

    The motor torque is that on the crank times the ratio; negative where it must assist a self-locking reducer.
    """
    friction: FrictionMap = reduced.friction
    torques = np.array(
        [item for item in friction.torques if MIN_FIT_SHARE <= item / reduced.rated_torque <= 1.0 + 1e-9]
    )
    rows = []
    for driving, sign in ((True, 1.0), (False, -1.0)):
        lost = np.array([reduced.ratio * friction.torque(item, reduced.rated_speed, driving) for item in torques])
        rows.append(np.stack([torques, torques + sign * lost, lost - reduced.no_load_torque_at_output]))
    external, motor, beyond = np.concatenate(rows, axis=1)
    return external, motor, beyond


def _viscous(reduced: ReducedJoint) -> float:
    """Compute the no-load friction in proportion to the joint's speed [N m s/rad], by centrifugal force."""
    first, last = reduced.friction.speeds[0], reduced.friction.speeds[-1]
    low, high = (reduced.friction.torque(0.0, speed, driving=True) for speed in (first, last))
    return max(0.0, reduced.ratio**2 * (high - low) / (last - first))
