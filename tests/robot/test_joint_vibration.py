"""A reduced joint under load, in MuJoCo alone: vibration of two masses in motion, of one mass with a stuck crank."""

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


@pytest.fixture(scope="module")
def printed() -> ReducedJoint:
    """Joint of the built-in design `printed`, whose seals and lubricant brake the crank with 0.029 N m."""
    return reduce("printed")


def relative_speed(
    reduced: ReducedJoint, pulse: float, crank_speed: float, settle: float = 6.0, watch: float = 0.25
) -> Array:
    """Compute the speed of the wind-up [rad/s] after a pulse on the motor of a loaded joint, shape (n,).

    Before the pulse, the crank turns at about `crank_speed` [rad/s], and the motor overcomes load and friction.
    """
    files = {"joint.xml": joint_xml(reduced).encode()}
    model = mujoco.MjModel.from_xml_string(scene_xml(reduced, LOAD, STEP, "implicitfast"), files)
    data = mujoco.MjData(model)
    output, rotor = (model.joint(name).dofadr[0] for name in ("output", "output_rotor"))
    data.qvel[rotor], data.qvel[output] = crank_speed, -reduced.coefficient * crank_speed
    data.qfrc_applied[output] = TORQUE
    torque = reduced.coefficient * TORQUE + reduced.no_load_torque * np.sign(crank_speed)
    data.ctrl[0] = torque
    for _ in range(round(settle / STEP)):
        mujoco.mj_step(model, data)
    speeds = np.empty(round(watch / STEP))
    for place in range(len(speeds)):
        data.ctrl[0] = torque + (pulse if place * STEP < PULSE_TIME else 0.0)
        mujoco.mj_step(model, data)
        speeds[place] = data.qvel[output] + reduced.coefficient * data.qvel[rotor]
    return speeds


def rising_zeros(swing: Array) -> tuple[Array, float]:
    """Return the samples before rising zero crossings, and the frequency of these crossings [Hz]."""
    rises = np.flatnonzero((swing[:-1] < 0.0) & (swing[1:] >= 0.0))
    crossings = rises - swing[rises] / (swing[rises + 1] - swing[rises])
    return rises, (len(crossings) - 1) / float(crossings[-1] - crossings[0]) / STEP


@pytest.mark.slow
def test_a_loaded_joint_vibrates_at_the_two_mass_frequency(printed: ReducedJoint) -> None:
    """Two masses on a spring: f = sqrt(K (1/J_load + 1/(i^2 J_rotor))) / 2 pi, of the joint's own K, J and damping.

    For `printed` and 0.1 kg m2 these are 4242.3 N m/rad, 0.10017 and 169 * 1.09992e-4 kg m2: 82.79 Hz, and a damping
    ratio of 0.0066 (google-deepmind/mujoco issue 1524: a model of one mass where the bench shows two). With rigid
    needles in the output rollers, they were 4260 N m/rad and 82.96 Hz. The crank turns, so that its dry friction is a
    constant torque without effect on the vibration.
    """
    stiffness = sum(spring.stiffness for spring in printed.springs)
    load, rotor = LOAD + printed.output_inertia, printed.ratio**2 * printed.rotor_inertia
    assert stiffness == pytest.approx(4242.3, rel=1e-3)
    assert load == pytest.approx(0.10017, rel=1e-4)
    assert rotor == pytest.approx(169.0 * 1.09992e-4, rel=1e-4)
    pulse = math.sqrt(stiffness * (1.0 / load + 1.0 / rotor))
    assert pulse / (2.0 * math.pi) == pytest.approx(82.79, rel=1e-3)
    ratio = 0.5 * printed.damping * pulse / stiffness
    assert ratio == pytest.approx(0.0066, abs=1e-4)
    speed = printed.rated_speed
    swing = relative_speed(printed, PULSE, speed) - relative_speed(printed, 0.0, speed)
    rises, frequency = rising_zeros(swing)
    assert frequency == pytest.approx(82.79, rel=2e-3)
    tops = np.array([swing[a:b].max() for a, b in pairwise(rises)])
    decay = -np.polyfit(np.arange(len(tops)), np.log(tops), 1)[0] / (2.0 * math.pi)
    assert decay == pytest.approx(ratio, rel=0.1)


@pytest.mark.slow
def test_a_pulse_below_the_friction_leaves_the_load_on_the_springs(printed: ReducedJoint) -> None:
    """With a crank that friction holds at rest, the load vibrates as one mass: f = sqrt(K/J_load) / 2 pi = 32.75 Hz."""
    stiffness, load = sum(spring.stiffness for spring in printed.springs), LOAD + printed.output_inertia
    expected = math.sqrt(stiffness / load) / (2.0 * math.pi)
    assert expected == pytest.approx(32.75, rel=1e-3)
    _, frequency = rising_zeros(relative_speed(printed, PULSE, 0.0) - relative_speed(printed, 0.0, 0.0))
    assert frequency == pytest.approx(expected, rel=2e-3)
