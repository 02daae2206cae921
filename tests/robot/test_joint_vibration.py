"""The reduced joint vibrates as two masses: rotor and load on the springs between them, in MuJoCo alone."""

import math
from itertools import pairwise

import mujoco
import numpy as np
import pytest

from cycloid_mj.base.array import Array
from cycloid_mj.robot import ReducedJoint, reduce
from cycloid_mj.robot.mjcf import joint_xml, scene_xml

LOAD, TORQUE, STEP = 0.1, 8.0, 1e-4
"""Inertia on the output [kg m2], torque on it [N m], time step [s]."""

PULSE, PULSE_TIME = 0.1, 1e-3
"""Torque on the motor [N m], and how long it acts [s]."""


def relative_speed(reduced: ReducedJoint, pulse: float, settle: float = 6.0, watch: float = 0.25) -> Array:
    """Compute the speed of the wind-up [rad/s] after a pulse on the motor of a loaded joint that rests, shape (n,)."""
    files = {"joint.xml": joint_xml(reduced).encode()}
    model = mujoco.MjModel.from_xml_string(scene_xml(reduced, LOAD, STEP, "implicitfast"), files)
    data = mujoco.MjData(model)
    output, rotor = (model.joint(name).dofadr[0] for name in ("output", "output_rotor"))
    data.qfrc_applied[output] = TORQUE
    data.ctrl[0] = reduced.coefficient * TORQUE
    for _ in range(round(settle / STEP)):
        mujoco.mj_step(model, data)
    speeds = np.empty(round(watch / STEP))
    for place in range(len(speeds)):
        data.ctrl[0] = reduced.coefficient * TORQUE + (pulse if place * STEP < PULSE_TIME else 0.0)
        mujoco.mj_step(model, data)
        speeds[place] = data.qvel[output] + reduced.coefficient * data.qvel[rotor]
    return speeds


@pytest.mark.slow
def test_a_loaded_joint_vibrates_at_the_two_mass_frequency() -> None:
    """Two masses on a spring: f = sqrt(K (1/J_load + 1/(i^2 J_rotor))) / 2 pi, of the joint's own K, J and damping.

    For `printed` and 0.1 kg m2 these are 4260 N m/rad, 0.10017 and 169 * 1.09992e-4 kg m2: 82.96 Hz, and a damping
    ratio of 0.0066 (google-deepmind/mujoco issue 1524: a model of one mass where the bench shows two).
    """
    reduced = reduce("printed")
    stiffness = sum(spring.stiffness for spring in reduced.springs)
    load, rotor = LOAD + reduced.output_inertia, reduced.ratio**2 * reduced.rotor_inertia
    assert stiffness == pytest.approx(4260.0, rel=1e-3)
    assert load == pytest.approx(0.10017, rel=1e-4)
    assert rotor == pytest.approx(169.0 * 1.09992e-4, rel=1e-4)
    pulse = math.sqrt(stiffness * (1.0 / load + 1.0 / rotor))
    assert pulse / (2.0 * math.pi) == pytest.approx(82.96, rel=1e-3)
    ratio = 0.5 * reduced.damping * pulse / stiffness
    assert ratio == pytest.approx(0.0066, abs=1e-4)
    swing = relative_speed(reduced, PULSE) - relative_speed(reduced, 0.0)
    rises = np.flatnonzero((swing[:-1] < 0.0) & (swing[1:] >= 0.0))
    crossings = rises - swing[rises] / (swing[rises + 1] - swing[rises])
    frequency = (len(crossings) - 1) / float(crossings[-1] - crossings[0]) / STEP
    assert frequency == pytest.approx(82.96, rel=2e-3)
    tops = np.array([swing[a:b].max() for a, b in pairwise(rises)])
    decay = -np.polyfit(np.arange(len(tops)), np.log(tops), 1)[0] / (2.0 * math.pi)
    assert decay == pytest.approx(ratio, rel=0.1)
