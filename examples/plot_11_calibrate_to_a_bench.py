"""
Calibrate to a bench
====================

A measured hysteresis loop, and the clearance, stiffness and friction that explain it: a published loop of the printed
drive, whose clearances were drawn as 0.05 mm.

`play` is one clearance for teeth and holes; `structure_stiffness` is that of what carries them; `drag` is friction that
comes on at once, `hysteresis` one that comes on little by little. What the loop does not determine, the search says.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cycloid_mj as cm

here = Path(__file__).parent if "__file__" in globals() else Path.cwd()
loop = cm.read_loop(here.parent / "tests" / "data" / "bench" / "stiffness_loop.csv")
found = cm.calibrate(cm.load("printed"), [loop])
for key, one in found.estimates.items():
    unsure = "" if one.identified else ": not determined"
    print(f"{key}: {one.value:.4g} {one.unit}, 95 % {one.ci95[0]:.4g} to {one.ci95[1]:.4g}{unsure}")
for name in ("stiffness", "coulomb"):
    measured, modelled = getattr(found.measured, name), getattr(found.modelled, name)
    print(
        f"{name}: measured {measured.value:.3g} ({measured.low:.3g} to {measured.high:.3g}), model {modelled.value:.3g}"
    )
print(f"residual {np.degrees(found.rms):.3f} deg rms")

# %%
# The loop and the model's, torque against deflection of the output.

figure, axes = plt.subplots(layout="constrained")
axes.plot(loop.torque, np.degrees(loop.deflection), ".", markersize=3, label="measured")
axes.plot(loop.torque, np.degrees(found.fitted.turns[0]), label="model")
axes.set(xlabel="torque on the output [N m]", ylabel="deflection [deg]")
axes.legend()
