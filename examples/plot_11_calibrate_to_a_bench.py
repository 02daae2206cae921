"""
Calibrate to a bench
====================

A measured hysteresis loop, and the clearances that explain it: a published loop of the printed drive, as drawn with
clearances of 0.05 mm.

What the loop cannot tell apart, as play in the mesh and in the holes, is said so.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cycloid_mj as cm
from cycloid_mj.bench import read_loop

here = Path(__file__).parent if "__file__" in globals() else Path.cwd()
loop = read_loop(here.parent / "tests" / "data" / "bench" / "play_loop.csv")
found = cm.calibrate(cm.load("printed"), [loop], keys=("mesh_play", "tooth_stiffness"))
for key, one in found.estimates.items():
    print(f"{key}: {one.value:.4g} {one.unit}, 95 % {one.ci95[0]:.4g} to {one.ci95[1]:.4g}")
print(f"play {np.degrees(found.play[0]):.2f} deg, residual {np.degrees(found.rms):.3f} deg rms")

# %%
# The loop and the model's, torque against deflection of the output.

figure, axes = plt.subplots(layout="constrained")
axes.plot(loop.torque, np.degrees(loop.deflection), ".", markersize=3, label="measured")
axes.plot(loop.torque, np.degrees(found.fitted.turns[0]), label="model")
axes.set(xlabel="torque on the output [N m]", ylabel="deflection [deg]")
axes.legend()
