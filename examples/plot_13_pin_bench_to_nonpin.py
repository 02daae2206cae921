"""
From a measured drive to its twin
=================================

Values that are fitted to the loops of a printed drive, with ring pins in the model, predict the loops of its twin with
an internal gear in the model. The plots compare them with measurements before run-in.

Nothing is fitted to the twin except the zero of its deflection. Both real drives have an internal gear, one in one
piece, one in two halves (docs/printed-drive.md). The example therefore shows how much the kind of ring in the model
matters.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cycloid_mj as cm

here = Path(__file__).parent if "__file__" in globals() else Path.cwd()
bench = here.parent / "tests" / "data" / "bench"
pin = [cm.read_loop(bench / f"{name}_loop.csv") for name in ("play", "stiffness")]
nonpin = [cm.read_loop(bench / f"nonpin_{name}_loop.csv") for name in ("play", "stiffness")]

drawn = cm.load("printed")
fitted = cm.calibrate(drawn, pin).design
play = fitted.clearance.pin_gear
twin = drawn.but(
    ring={"kind": "nonpin"},
    clearance={"tooth": play, "output": fitted.clearance.output},
    springs=fitted.springs.model_dump(),
)
prediction = cm.predict_loops(cm.Reducer(twin), nonpin)
for name, unit, factor in (("play", "deg", 180.0 / np.pi), ("stiffness", "N m/rad", 1.0), ("coulomb", "N m", 1.0)):
    measured, predicted = getattr(prediction.measured, name), getattr(prediction.modelled, name)
    print(f"{name}: predicted {factor * predicted.value:.3g} {unit}, measured {factor * measured.value:.3g} {unit}")

# %%
# The large loop is predicted. The small one is half as wide in reality, which the drawing does not explain.

figure, axes = plt.subplots(1, 2, figsize=(9.0, 4.0), layout="constrained")
for loop, turn, share, panel in zip(nonpin, prediction.turns, prediction.shares, axes, strict=True):
    panel.plot(loop.torque, np.degrees(loop.deflection), ".", markersize=3, label="measured")
    panel.plot(loop.torque, np.degrees(turn), label=f"predicted, rms difference {share:.0%} of the height")
    panel.set(title=loop.name, xlabel="torque on the output [N m]", ylabel="deflection [deg]")
    panel.legend()
