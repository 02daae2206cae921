"""
From a measured pin drive to its nonpin twin
============================================

Values fitted to the loops of a printed drive, by a model with pins, predict the loops of its twin by one with the
internal gear, of which only the kind of ring is changed: beside them stand those that were measured, before run-in.
Nothing is fitted to the twin but the zero of its deflection. Both measured drives have the internal gear, one in a
piece, one in two halves (docs/bench.md): what is tried here is how far the kind of ring in the model matters.
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
found = cm.predict_loops(cm.Reducer(twin), nonpin)
for name, unit, factor in (("play", "deg", 180.0 / np.pi), ("stiffness", "N m/rad", 1.0), ("coulomb", "N m", 1.0)):
    measured, predicted = getattr(found.measured, name), getattr(found.modelled, name)
    print(f"{name}: predicted {factor * predicted.value:.3g} {unit}, measured {factor * measured.value:.3g} {unit}")

# %%
# The whole loops: the large one is predicted; the small one is measured half as wide, which the drawing does not tell.

figure, axes = plt.subplots(1, 2, figsize=(9.0, 4.0), layout="constrained")
for loop, turn, share, at in zip(nonpin, found.turns, found.shares, axes, strict=True):
    at.plot(loop.torque, np.degrees(loop.deflection), ".", markersize=3, label="measured")
    at.plot(loop.torque, np.degrees(turn), label=f"predicted, off by {share:.0%} of the height")
    at.set(title=loop.name, xlabel="torque on the output [N m]", ylabel="deflection [deg]")
    at.legend()
