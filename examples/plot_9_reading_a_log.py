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

design = cm.load("nonpin", {"drive.ramp_s": 0.0, "drive.hold_s": 0.08, "load.torque_nm": 36.68})
with tempfile.TemporaryDirectory() as folder:
    cm.write_log(cm.simulate(design), Path(folder) / "nonpin.mcap")
    run = cm.read_log(Path(folder) / "nonpin.mcap")
print(run)
print(sorted(run.attachments))

# %%
# The orders of its transmission error, once the load is on. In a turn of the crank against the gear, 35/36 of a turn,
# each of the eight output pins comes by once: so the strongest orders are multiples of 8 x 36/35 = 8.23.

late = run.time > 0.01
crank = run["crank_angle"][late]
error = (run["output_angle"][late] + crank / design.lobes) * 206264.8
found = cm.tapered_orders(crank, error, most=60.0)

figure, axes = plt.subplots(layout="constrained")
axes.fill_between(found.order, found.amplitude)
for multiple in (1, 2, 3):
    order = multiple * design.output.pins * design.ring.teeth / design.lobes
    peak = np.interp(order, found.order, found.amplitude)
    axes.annotate(f"{order:.2f}", (order, peak), (order + 2.0, peak))
axes.set(xlabel="order: cycles a crank turn", ylabel="amplitude [arcsec]", title="transmission error, 36.68 N m")
