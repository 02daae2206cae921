"""
Stress of the gear
==================

Finite elements under the forces of a run: the stress of the gear at one crank angle, and where it is largest.

Needs the extra `fem`. The command `cycloid-mj stress` does this for every part and degree of the crank, with a study of
the grid.
"""

import matplotlib.pyplot as plt
import numpy as np

import cycloid_mj as cm
from cycloid_mj.stress.loads import part_loads

design = cm.load("pin", {"ring.pins": "massless", "drive.ramp_s": 0.0, "drive.hold_s": 0.05, "load.torque_nm": 36.68})
run = cm.simulate(design)
settled = run.select(run.time > 0.04)

# %%
# The forces of the run press on the gear's flanks, bore and holes; its own inertia and weight hold the balance.

grid = cm.stress.part_grid(design, "gear", cm.stress.GridSettings(refinement=0.7))
forces = part_loads(settled.select(np.arange(len(settled)) < 1), design, "gear")
found = cm.stress.stress_map(cm.stress.solve(grid, forces), 0)

figure, axes = plt.subplots(layout="constrained")
x, y = 1e3 * found.points.T[:2]
shown = axes.tripcolor(x, y, found.triangles, 1e-6 * found.stress, shading="gouraud", cmap="viridis")
figure.colorbar(shown, label="von Mises stress [MPa]")
axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal", title="gear at 36.68 N m")
