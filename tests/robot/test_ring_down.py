"""The joint's damping, held against the decay of the full model in MuJoCo: crank locked, friction taken away."""

import math

import mujoco
import numpy as np
import pytest
from scipy.optimize import curve_fit

from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.reducer import Reducer
from cycloid_mj.robot import reduce

FREQUENCY = 200.0
"""Of the vibration [Hz], by an inertia added to the output: thousands of steps a period."""


def ring_down(reducer: Reducer, stiffness: float) -> tuple[float, float]:
    """Release the output from 7 % above the rated torque: its stiffness [N m/rad] and damping [N m s/rad] by decay."""
    model, rated = build(reducer.design).model, reducer.design.rated_torque
    data = mujoco.MjData(model)
    output, crank = model.joint("output"), model.joint("crank")
    inertia = stiffness / (2.0 * math.pi * FREQUENCY) ** 2
    model.opt.gravity[:] = 0.0
    for of_motor in (model.actuator_gainprm, model.actuator_biasprm, model.dof_damping, model.dof_frictionloss):
        of_motor[:] = 0.0
    model.pair_friction[:] = 1e-5
    model.dof_armature[crank.dofadr[0]] = 1e6 * inertia
    model.dof_armature[output.dofadr[0]] = inertia
    sense = (1.0 if reducer.design.output.turns_ring else -1.0) * -np.sign(reducer.design.drive.speed)
    period = round(1.0 / FREQUENCY / model.opt.timestep)
    turns = np.empty(12 * period)
    with install():
        model.dof_damping[output.dofadr[0]] = 2.0 * math.sqrt(stiffness * inertia)
        for i in range(8 * period):
            data.qfrc_applied[output.dofadr[0]] = sense * 1.07 * rated * min(1.0, i / (2 * period))
            mujoco.mj_step(model, data)
        model.dof_damping[output.dofadr[0]] = 0.0
        data.qfrc_applied[output.dofadr[0]] = sense * rated
        for i in range(turns.size):
            mujoco.mj_step(model, data)
            turns[i] = data.qpos[output.qposadr[0]]
    times = model.opt.timestep * np.arange(turns.size)
    swing = (turns - turns.mean()) / np.ptp(turns)
    fitted, _ = curve_fit(decaying, times, swing, [0.5, 2.0 * math.pi * FREQUENCY, 10.0, 0.0, 0.0])
    assert np.std(decaying(times, *fitted) - swing) < 1e-3
    _, pulse, decay, _, _ = fitted
    return inertia * (pulse**2 + decay**2), 2.0 * inertia * decay


def decaying(time: np.ndarray, size: float, pulse: float, decay: float, phase: float, rest: float) -> np.ndarray:
    return size * np.exp(-decay * time) * np.cos(pulse * time + phase) + rest


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changes"),
    [("nonpin", {"output.member": "carrier"}), ("nonpin", {"output.member": "ring"}), ("printed", {}), ("twodisc", {})],
)
def test_a_locked_drive_rings_down_as_its_joint(name: str, changes: dict[str, str]) -> None:
    """At one crank angle, whose stiffness is not the joint's mean over all; damping goes with it."""
    design = override(PRESETS[name], changes)
    loaded = override(design, {"load.torque_nm": design.rated_torque})
    joint = reduce(loaded)
    of_joint = joint.stiffness(design.rated_torque)
    stiffness, damping = ring_down(Reducer(loaded), of_joint)
    assert stiffness == pytest.approx(of_joint, rel=0.25 if name == "twodisc" else 0.07)
    assert damping / stiffness == pytest.approx(joint.damping / of_joint, rel=0.035)
