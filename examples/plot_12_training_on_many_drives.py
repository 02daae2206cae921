"""
Training on many drives
=======================

A policy that is trained on one joint has seen one drive. `reduce --spread` draws drives of a design, within its
tolerances and the ranges of friction and stiffness, and writes their joints; here each moves the elbow of a published
arm.

The arm has links and inertias of I2RT's YAM as MuJoCo Menagerie models it (as the package mjlab 1.6 ships it), without
its gripper. Nothing but `mujoco`, numpy and the files that `reduce` wrote is needed to run it.
"""

import csv
import importlib.util
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import mujoco
import numpy as np

import cycloid_mj as cm

ELBOW, START, GOAL = "joint3", 1.2, 1.3  # [rad]
ARM = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="5e-4" integrator="implicitfast"/>
  <worldbody><body name="arm"><body name="link_1" pos="0 0 0.0631" quat="1 0 0 1">
    <inertial pos="-0.00192861 -0.00795735 0.0208176" quat="0.297851 0.642634 0.360045 0.607185" mass="0.12415"
      diaginertia="0.000180751 0.000145532 5.89179e-05"/>
    <body name="link_2" pos="2.5e-05 -0.02 0.0409" quat="0.354 0.354 0.612 0.612">
      <inertial pos="0.132008 2.10599e-06 0.000293073" quat="1 1 1 1" mass="1.24434"
        diaginertia="0.0121902 0.0121318 0.000683304"/>
      <body name="link_3" pos="0.264 0 0" quat="0 1 0 0">
        <inertial pos="-0.121816 -0.054846 -0.000111108" quat="1 1 1 1" mass="0.853698"
          diaginertia="0.00699732 0.00696112 0.000788244"/>
        <joint name="joint3" axis="0 0 1" range="0 3.66519"/>
        <body name="link_4" pos="-0.245 -0.06 0" quat="1 0 0 0">
          <inertial pos="-0.0769778 -0.0527104 0.000154878" quat="0.667 0.667 -0.236 -0.236" mass="0.463511"
            diaginertia="0.000791532 0.000744733 0.000282116"/>
          <body name="link_5" pos="-0.074 -0.0395 2.5e-05" quat="1 -1 1 1">
            <inertial pos="3.64861e-05 0.00025665 0.0353526" mass="0.350962"
              diaginertia="0.000197802 0.0001775 0.000147402"/>
            <body name="link_6" pos="0 0.0353 0.0395" quat="1 -1 0 0">
              <inertial pos="-0.000217767 7.37059e-05 0.0270545" quat="1 1 0 0" mass="0.367476"
                diaginertia="0.000265958 0.000242686 0.000227409"/>
            </body></body></body></body></body></body></body></worldbody>
</mujoco>
"""

# %%
# The drives: clearances of the cam and of the output pins within 10 um, pins placed to 5 um.

TOLERANCES = ['tolerance.cam="uniform 10"', 'tolerance.output="uniform 10"', 'tolerance.pin_position="normal 5"']
with TemporaryDirectory() as folder:
    changes = [word for one in TOLERANCES for word in ("--set", one)]
    words = ["reduce", "printed", *changes, "--spread", "--samples", "40", "--seed", "1", "--out", folder, "--quiet"]
    subprocess.run([sys.executable, "-m", "cycloid_mj", *words], check=True, stdout=subprocess.DEVNULL)
    found = importlib.util.spec_from_file_location("joint", Path(folder) / "joint.py")
    written = importlib.util.module_from_spec(found)
    found.loader.exec_module(written)
    joint = written.Joint()
    reduced = cm.ReducedJoint.read(Path(folder) / "reducer.json")
    with (Path(folder) / "samples.csv").open() as file:
        drives = list(csv.DictReader(file))

# %%
# The model is compiled once; each drive is written into it.

spec = mujoco.MjSpec.from_string(ARM)
cm.attach_reducer(spec, ELBOW, reduced)
servo = spec.add_actuator(name="servo", target=f"{ELBOW}_rotor", trntype=mujoco.mjtTrn.mjTRN_JOINT)
servo.set_to_position(kp=0.5, kv=0.02)  # on the crank, as a motor's own
model = spec.compile()


def step_response(drive: dict[str, str]) -> np.ndarray:
    """Step the servo of the elbow of one drive; give time [s] and the elbow's angle [rad], shape (2, n)."""
    other = joint.varied(drive)
    other.write(model, ELBOW)
    data = mujoco.MjData(model)
    elbow, crank = data.joint(ELBOW), data.joint(f"{ELBOW}_rotor")
    middle = 0.5 * sum(other.values["stops"])
    told = []
    for angle, time in ((START, 0.5), (GOAL, 1.5)):
        if not told:
            elbow.qpos[0], crank.qpos[0] = angle, (middle - angle) / other.coefficient
        data.actuator("servo").ctrl[0] = (middle - angle) / other.coefficient
        while data.time < time:
            other.step(model, data, ELBOW)
            told.append((data.time, elbow.qpos[0]))
            mujoco.mj_step(model, data)
    return np.array(told).T


figure, (moved, cloud) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
for drive in drives:
    time, angle = step_response(drive)
    moved.plot(time, np.degrees(angle), color="#0B2E4F", alpha=0.25, linewidth=0.8)
moved.set(xlabel="time [s]", ylabel="elbow [deg]", title=f"a step by {len(drives)} drives of one design")
play, loss = ([float(drive[key]) for drive in drives] for key in ("backlash_arcmin", "loss_percent"))
cloud.plot(play, loss, "o", color="#D55E00", markersize=4)
cloud.set(
    xlabel="play [arcmin]", ylabel="loss under load [%]", title=f"correlation {np.corrcoef(play, loss)[0, 1]:+.2f}"
)
