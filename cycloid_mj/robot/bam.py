"""The joint's friction as the models M3 and M5 of BAM (Better Actuator Models), in the parameters of BAM.

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
"""Share of the nominal torque from which friction is fitted, up to the nominal torque (heuristic)."""

WITHOUT_STRIBECK = {
    **dict.fromkeys(("friction_stribeck", *(f"load_friction_{part}_stribeck" for part in ("motor", "external"))), 0.0),
    **{"dtheta_stribeck": 0.2, "alpha": 1.35},
}
"""Parameters without a Stribeck effect; the last two are BAM's start values, and have no effect."""


def fit_bam_models(reduced: ReducedJoint) -> dict[str, Any]:
    """Fit the friction models M3 and M5 of BAM (Better Actuator Models) to a reduced joint; return JSON values.

    `reduced` is the joint model. The keys "m3" and "m5" have the parameters of the models, in N m, N m s/rad or 1.
    "source" and "joint" are texts. "largest_error_nm" has the largest errors of their friction [N m], and "fitted_nm"
    the range of fitted loads [N m]. The fit by nonnegative least squares (Lawson and Hanson) covers loads from
    `MIN_FIT_SHARE` to 1 of the nominal torque at the rated speed, with the crank driving and with the output driving.
    """
    base_torque, viscous = reduced.no_load_torque_at_output, reduced.no_load_damping_at_output
    external_torques, motor_torques, friction = _friction_samples(reduced)
    m3, _ = nnls((external_torques + motor_torques)[:, np.newaxis], friction)
    m5, _ = nnls(np.stack([external_torques, motor_torques], axis=1), friction)
    by_torque = {"load_friction_motor": float(m5[1]), "load_friction_external": float(m5[0])}
    common_parameters = {
        "friction_base": base_torque,
        "friction_viscous": viscous,
        "armature": reduced.reflected_inertia,
    }
    return {
        "source": "BAM, Rhoban, ICRA 2025: arXiv 2410.08650",
        "joint": f"output of {reduced.name}, {reduced.ratio:g}:1; torques at the joint [N m], speeds in rad/s",
        "m3": {"model": "m3", **common_parameters, "load_friction_base": float(m3[0])},
        "m5": {"model": "m5", **common_parameters, **by_torque, **WITHOUT_STRIBECK},
        "largest_error_nm": {
            "m3": float(np.abs(m3[0] * (external_torques + motor_torques) - friction).max()),
            "m5": float(np.abs(m5[0] * external_torques + m5[1] * motor_torques - friction).max()),
        },
        "fitted_nm": [MIN_FIT_SHARE * reduced.rated_torque, reduced.rated_torque],
    }


def _friction_samples(reduced: ReducedJoint) -> tuple[Array, Array, Array]:
    """Return n samples of a joint's load-dependent friction and of the torques at which it acts.

    Load-dependent friction is the friction at the joint minus the friction without a load. The motor torque is the
    torque on the crank times the ratio; it is negative if the motor must help to drive a self-locking reducer
    backwards.

    Returns
    -------
    tuple of Array
        External torque, motor torque and load-dependent friction [N m], shape (n,) each.
    """
    friction: FrictionMap = reduced.friction
    torques = np.array(
        [torque for torque in friction.torques if MIN_FIT_SHARE <= torque / reduced.rated_torque <= 1.0 + 1e-9]
    )
    rows = []
    for is_driving, sign in ((True, 1.0), (False, -1.0)):
        friction_at_joint = np.array(
            [reduced.ratio * friction.torque(torque, reduced.rated_speed, is_driving) for torque in torques]
        )
        rows.append(
            np.stack(
                [torques, torques + sign * friction_at_joint, friction_at_joint - reduced.no_load_torque_at_output]
            )
        )
    external_torques, motor_torques, load_dependent = np.concatenate(rows, axis=1)
    return external_torques, motor_torques, load_dependent
