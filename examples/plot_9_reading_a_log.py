"""
Reading a log
=============

A log is one file that contains a run, its design and its model. This example reads a log and computes the orders of the
transmission error.
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
# The orders of the transmission error under full load. Each of the eight output pins passes the eccentric once per
# 35/36 of a crank turn. The strongest orders are therefore multiples of 8 x 36/35 = 8.23.

late = run.time > 0.01
crank = run["crank_angle"][late]
error = (run["output_angle"][late] + crank / design.lobes) * 206264.8
orders = cm.tapered_orders(crank, error, max_order=60.0)

figure, axes = plt.subplots(layout="constrained")
axes.fill_between(orders.order, orders.amplitude)
for multiple in (1, 2, 3):
    order = multiple * design.output.pins * design.ring.teeth / design.lobes
    peak = np.interp(order, orders.order, orders.amplitude)
    axes.annotate(f"{order:.2f}", (order, peak), (order + 2.0, peak))
axes.set(xlabel="order: cycles per crank turn", ylabel="amplitude [arcsec]", title="transmission error, 36.68 N m")
