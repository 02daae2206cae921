"""
Calibrate with measurements
===========================

Fit clearance, stiffness and friction to a measured hysteresis loop: a published loop of the printed drive, whose
clearances were designed as 0.05 mm.

`play` is one clearance for teeth and holes. `structure_stiffness` is the stiffness of the parts behind them. `drag` is
friction that acts at once, `hysteresis` is friction that builds up gradually. The result states which values the loop
does not determine.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cycloid_mj as cm

here = Path(__file__).parent if "__file__" in globals() else Path.cwd()
loop = cm.read_loop(here.parent / "tests" / "data" / "bench" / "stiffness_loop.csv")
calibration = cm.calibrate(cm.load("printed"), [loop])
for key, estimate in calibration.estimates.items():
    remark = "" if estimate.identified else ": not determined"
    low, high = estimate.ci95
    print(f"{key}: {estimate.value:.4g} {estimate.unit}, 95 % {low:.4g} to {high:.4g}{remark}")
for name in ("stiffness", "coulomb"):
    measured, modelled = getattr(calibration.measured, name), getattr(calibration.modelled, name)
    print(
        f"{name}: measured {measured.value:.3g} ({measured.low:.3g} to {measured.high:.3g}), model {modelled.value:.3g}"
    )
print(f"residual {np.degrees(calibration.rms):.3f} deg rms")

# %%
# Measured and fitted loop: rotation of the output over torque.

figure, axes = plt.subplots(layout="constrained")
axes.plot(loop.torque, np.degrees(loop.deflection), ".", markersize=3, label="measured")
axes.plot(loop.torque, np.degrees(calibration.fitted.turns[0]), label="model")
axes.set(xlabel="torque on the output [N m]", ylabel="rotation [deg]")
axes.legend()
