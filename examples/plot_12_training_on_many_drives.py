"""
Training on many drives
=======================

A policy that is trained with a single joint knows only one drive. `reduce --spread` writes the joints of many random
drives within the tolerances.

Here, each of these joints moves the elbow of a robot arm. Links and inertias of the arm are those of I2RT's YAM in
MuJoCo Menagerie and mjlab 1.6 (`yam_elbow.xml`, without gripper). To run the joints, you need only `mujoco`, NumPy and
the files that `reduce` writes.
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
# Draw the drives: clearances of cam and output pins vary by 10 um, pin positions by 5 um.

words = ["reduce", "printed", "--spread", "--samples", "40", "--seed", "1", "--quiet"]
for tolerance in ('cam="uniform 10"', 'output="uniform 10"', 'pin_position="normal 5"'):
    words += ["--set", f"tolerance.{tolerance}"]
with TemporaryDirectory() as folder:
    subprocess.run([sys.executable, "-m", "cycloid_mj", *words, "--out", folder], check=True)
    joint = runpy.run_path(f"{folder}/joint.py")["Joint"]()
    reduced = cm.ReducedJoint.read(Path(folder) / "reducer.json")
    drives = list(csv.DictReader((Path(folder) / "samples.csv").read_text().splitlines()))

# %%
# Compile the model once. Each drive changes only arrays of the compiled model.

spec = mujoco.MjSpec.from_file(str(here / "yam_elbow.xml"))
cm.attach_reducer(spec, ELBOW, reduced)
servo = spec.add_actuator(name="servo", target=f"{ELBOW}_rotor", trntype=mujoco.mjtTrn.mjTRN_JOINT)
servo.set_to_position(kp=0.5, kv=0.02)  # on the crank, as a motor's own
model = spec.compile()


def step_response(drive: dict[str, str]) -> np.ndarray:
    """Simulate a step of the elbow with one drive; return time [s] and elbow angle [rad], shape (2, n)."""
    varied, data, samples = joint.varied(drive), mujoco.MjData(model), []
    varied.write(model, ELBOW)
    # crank angles at which the elbow is in the middle of its backlash
    start, goal = ((0.5 * sum(varied.values["stops"]) - angle) / varied.coefficient for angle in (START, GOAL))
    data.joint(ELBOW).qpos[0], data.joint(f"{ELBOW}_rotor").qpos[0] = START, start
    while data.time < 1.5:
        data.actuator("servo").ctrl[0] = start if data.time < 0.5 else goal
        varied.step(model, data, ELBOW)
        samples.append((data.time, data.joint(ELBOW).qpos[0]))
        mujoco.mj_step(model, data)
    return np.array(samples).T


figure, (moved, cloud) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
for drive in drives:
    time, angle = step_response(drive)
    moved.plot(time, np.degrees(angle), color="#0B2E4F", alpha=0.25, linewidth=0.8)
moved.set(xlabel="time [s]", ylabel="elbow [deg]", title=f"a step with {len(drives)} drives of one design")
cloud.plot(*([float(drive[key]) for drive in drives] for key in ("backlash_arcmin", "loss_percent")), "o")
cloud.set(xlabel="backlash [arcmin]", ylabel="loss under load [%]", title="backlash and loss of each drive")
