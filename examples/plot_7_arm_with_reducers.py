"""
A robot arm with reducers
=========================

The preset `printed` on two joints of a published arm: how its backlash changes a step of the elbow.

The arm is that of Gymnasium's environment Pusher-v5 (Farama Foundation, MIT licence), with seven joints like the PR2's.
Each servo controls the angle of its motor, as a real one does. It cannot measure the motion within the backlash.
"""

from importlib.util import find_spec
from pathlib import Path

import matplotlib.pyplot as plt
import mujoco
import numpy as np

import cycloid_mj as cm

JOINTS = ("r_shoulder_lift_joint", "r_elbow_flex_joint")
START, GOAL = -1.0, -0.9  # of the elbow [rad]
ASSETS = Path(find_spec("gymnasium").origin).parent / "envs" / "mujoco" / "assets"


def step_response(reduced: cm.ReducedJoint) -> np.ndarray:
    """Simulate a step of the elbow; return time [s], elbow angle, and motor angle over the ratio [rad], (3, n)."""
    spec = mujoco.MjSpec.from_file(str(ASSETS / "pusher_v5.xml"))
    spec.option.timestep = 5e-4
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    for actuator in [each for each in spec.actuators if each.target in JOINTS]:
        spec.delete(actuator)
    for joint in JOINTS:
        servo = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.set_to_position(kp=60.0, kv=6.0)
        cm.attach_reducer(spec, joint, reduced)  # this moves the servo to the crank
    model = spec.compile()
    data = mujoco.MjData(model)
    elbow, servo = data.joint(JOINTS[1]), data.actuator(JOINTS[1])
    elbow.qpos[0] = START
    reduced.settle(model, data)
    samples = []
    while data.time < 3.0:
        servo.ctrl[0] = START if data.time < 0.2 else GOAL
        if reduced.level == "full":
            reduced.step(model, data)
        before = data.time, elbow.qpos[0]
        mujoco.mj_step(model, data)
        samples.append((*before, servo.length[0]))
    return np.array(samples).T


reduced = cm.reduce(cm.load("printed"))
figure, (above, below) = plt.subplots(2, 1, sharex=True, layout="constrained")
for level, colour, width in (("rigid", "#9CCBEA", 4.0), ("backlash", "#0B2E4F", 1.3), ("full", "#D55E00", 1.3)):
    time, turned, motor = step_response(reduced.at(level))
    above.plot(time, np.degrees(turned), color=colour, linewidth=width, label=level)
    below.plot(time, 60.0 * np.degrees(turned - motor), color=colour, linewidth=width)
for stop in reduced.stops:
    below.axhline(60.0 * np.degrees(stop), color="grey", linewidth=0.7, linestyle=":")
above.set(ylabel="elbow [deg]", title=f"{reduced.ratio:g}:1; dotted lines below: ends of the backlash")
above.legend()
below.set(xlabel="time [s]", ylabel="elbow minus motor [arcmin]")
