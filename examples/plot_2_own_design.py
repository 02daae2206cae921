"""
Your own design
===============

Change a preset, check it, and compute the force on every tooth.

The design is a 20:1 reducer. `cm.check` returns every check with its value, limit, reason and remedy. The forces over a
crank turn come from the static model, with all clearances.
"""

import matplotlib.pyplot as plt
import numpy as np

import cycloid_mj as cm

design = cm.load(
    "pin",
    {
        "name": "mine",
        "ring.teeth": 21,
        "ring.pin_circle_radius_mm": 40.75,
        "ring.pin_radius_mm": 2.25,
        "gear.eccentricity_mm": 1.2,
        "output.hole_radius_mm": 5.2,
        "clearance.pin_gear_um": 5.0,
        "load.torque_nm": 15.0,
    },
)
for check in cm.check(design):
    if not check.passed:
        print(check)

# %%
# The force of each pin on the disc over the crank angle. A pin carries load only where it can push against the load.

crank = np.linspace(0.0, 2.0 * np.pi, 181)
reducer = cm.Reducer(design)
springs = cm.statics.springs_of(reducer, crank, friction=False)
result = cm.statics.loads(reducer, springs, design.load.torque, warm_start=True)

figure, axes = plt.subplots(layout="constrained")
image = axes.pcolormesh(np.degrees(crank), np.arange(1, 22), result.teeth.T, cmap="magma_r", shading="nearest")
figure.colorbar(image, label="force [N]")
axes.set(xlabel="crank angle [deg]", ylabel="number of the pin", title=f"{design.load.torque:g} N m, clearance 5 um")
axes.set_yticks(range(1, 22, 4))
