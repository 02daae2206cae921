"""
A tolerance budget
==================

Which tolerance should you tighten? Assign a tolerance to each dimension, draw samples, and see which tolerances cause
the scatter of the backlash.

Each sample is computed over a complete crank turn. 10 000 samples take less than a minute; this example uses 200.
"""

import matplotlib.pyplot as plt

import cycloid_mj as cm

design = cm.load(
    "pin",
    {
        "clearance.pin_gear_um": 15.0,
        "clearance.cam_um": 15.0,
        "clearance.output_um": 15.0,
        "tolerance.mesh": "uniform 5",
        "tolerance.cam": "uniform 5",
        "tolerance.output": "normal 2",
        "tolerance.pin_position": "normal 1",
    },
)
study = cm.tolerance(design, samples=200, seed=1)
print(f"{study.jams.mean():.1%} of them jam")
for key, spread in study.distributions.items():
    print(f"{key:20} {spread.p05:8.3f} to {spread.p95:8.3f} {spread.unit} for nine of ten samples")

# %%
# The budget is the share of each tolerance in the variance (Sobol indices, with 95 % intervals).

figure, (above, below) = plt.subplots(2, 1, figsize=(6.4, 6.0), layout="constrained")
above.hist(study.figures["backlash_arcmin"], bins=25)
above.set(xlabel="backlash [arcmin]", ylabel="samples")
sources = [share.source for share in study.budget][::-1]
below.barh(sources, [1e2 * share.total for share in study.budget][::-1])
below.set(xlabel="share of the variance of the backlash [%]", title="tighten the largest share first")
