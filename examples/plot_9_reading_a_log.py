"""
Reading a log
=============

A log is one file that holds the run, its design and its model. Read one, and find the orders of what it holds.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cycloid_mj as cm
from cycloid_mj.log import write

design = cm.load("nonpin", {"drive.ramp_s": 0.0, "drive.hold_s": 0.08, "load.torque_nm": 36.68})
with tempfile.TemporaryDirectory() as folder:
    write(cm.simulate(design), Path(folder) / "nonpin.mcap")
    run = cm.read_log(Path(folder) / "nonpin.mcap")
print(run)
print(sorted(run.attachments))

# %%
# The last two turns, evenly over the crank angle: whole orders then stand in single lines.

crank = run["crank_angle"]
even = crank[-1] - 4.0 * np.pi + np.linspace(0.0, 4.0 * np.pi, 4001)[:-1]
error = np.interp(even, crank, run["output_angle"] + crank / design.lobes) * 206264.8
size = 2.0 * np.abs(np.fft.rfft(error - error.mean())) / error.size
order = np.arange(size.size) / 2.0

figure, axes = plt.subplots(layout="constrained")
axes.stem(order[1:161], size[1:161], markerfmt=" ", basefmt=" ")
axes.annotate("mesh order 36", (36.0, size[72]), (45.0, 0.9 * size[1:161].max()), arrowprops={"arrowstyle": "-"})
axes.set(xlabel="order: cycles a crank turn", ylabel="amplitude [arcsec]", title="transmission error, 36.68 N m")
