"""
Training on many drives
=======================

A policy that is trained on one joint has seen one drive. `reduce --spread` draws drives of a design, within its
tolerances and the ranges of friction and stiffness, and writes their joints; here each moves the elbow of an arm with
links and inertias of I2RT's YAM, as MuJoCo Menagerie models it (`yam_elbow.xml`; as mjlab 1.6 ships it), without its
gripper. Only `mujoco`, numpy and what `reduce` wrote are needed to run it.
"""

import csv
import runpy
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import mujoco
import numpy as np

import cycloid_mj as cm

here = Path(__file__).parent if "__file__" in globals() else Path.cwd()
ELBOW, START, GOAL = "joint3", 1.2, 1.3  # [rad]

# %%
# The drives: clearances of the cam and of the output pins within 10 um, pins placed to 5 um.

words = ["reduce", "printed", "--spread", "--samples", "40", "--seed", "1", "--quiet"]
for one in ('cam="uniform 10"', 'output="uniform 10"', 'pin_position="normal 5"'):
    words += ["--set", f"tolerance.{one}"]
with TemporaryDirectory() as folder:
    subprocess.run([sys.executable, "-m", "cycloid_mj", *words, "--out", folder], check=True)
    joint = runpy.run_path(f"{folder}/joint.py")["Joint"]()
    reduced = cm.ReducedJoint.read(Path(folder) / "reducer.json")
    drives = list(csv.DictReader((Path(folder) / "samples.csv").read_text().splitlines()))

# %%
# The model is compiled once; each drive is written into it.

spec = mujoco.MjSpec.from_file(str(here / "yam_elbow.xml"))
cm.attach_reducer(spec, ELBOW, reduced)
servo = spec.add_actuator(name="servo", target=f"{ELBOW}_rotor", trntype=mujoco.mjtTrn.mjTRN_JOINT)
servo.set_to_position(kp=0.5, kv=0.02)  # on the crank, as a motor's own
model = spec.compile()


def step_response(drive: dict[str, str]) -> np.ndarray:
    """Step the servo of the elbow of one drive; give time [s] and the elbow's angle [rad], shape (2, n)."""
    other, data, course = joint.varied(drive), mujoco.MjData(model), []
    other.write(model, ELBOW)
    # cranks where the elbow stands in the middle of its play
    start, goal = ((0.5 * sum(other.values["stops"]) - angle) / other.coefficient for angle in (START, GOAL))
    data.joint(ELBOW).qpos[0], data.joint(f"{ELBOW}_rotor").qpos[0] = START, start
    while data.time < 1.5:
        data.actuator("servo").ctrl[0] = start if data.time < 0.5 else goal
        other.step(model, data, ELBOW)
        course.append((data.time, data.joint(ELBOW).qpos[0]))
        mujoco.mj_step(model, data)
    return np.array(course).T


figure, (moved, cloud) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
for drive in drives:
    time, angle = step_response(drive)
    moved.plot(time, np.degrees(angle), color="#0B2E4F", alpha=0.25, linewidth=0.8)
moved.set(xlabel="time [s]", ylabel="elbow [deg]", title=f"a step by {len(drives)} drives of one design")
cloud.plot(*([float(drive[key]) for drive in drives] for key in ("backlash_arcmin", "loss_percent")), "o")
cloud.set(xlabel="play [arcmin]", ylabel="loss under load [%]", title="play and loss of each drive")
