"""
Your own design
===============

Change a preset, have it checked, and see where its limit is.

A 20:1 reducer on a pin circle of 28 mm. `cm.check` says what cannot be made or will not hold, with the reason; here the
force on every tooth over a crank turn is found by statics, with all clearances.
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
# The force of each pin on the gear against the crank angle: a pin carries where it can push the gear back.

crank = np.linspace(0.0, 2.0 * np.pi, 181)
reducer = cm.Reducer(design)
springs = cm.statics.springs_of(reducer, crank, friction=False)
found = cm.statics.loads(reducer, springs, design.load.torque, follow=True)

figure, axes = plt.subplots(layout="constrained")
shown = axes.pcolormesh(np.degrees(crank), np.arange(1, 22), found.teeth.T, cmap="magma_r", shading="nearest")
figure.colorbar(shown, label="force [N]")
axes.set(xlabel="crank angle [deg]", ylabel="number of the pin", title=f"{design.load.torque:g} N m, clearance 5 um")
axes.set_yticks(range(1, 22, 4))
