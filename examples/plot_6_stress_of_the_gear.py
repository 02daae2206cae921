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

design = cm.load("pin", {"ring.pins": "massless", "drive.ramp_s": 0.0, "drive.hold_s": 0.05, "load.torque_nm": 36.68})
run = cm.simulate(design)

# %%
# The forces of the run press on the gear's flanks, bore and holes; its own inertia and weight hold the balance.

grid = cm.stress.part_grid(design, "gear", cm.stress.GridSettings())
forces = cm.stress.part_loads(run, cm.Reducer(design), "gear", angles=[0.0])
found = cm.stress.stress_map(design, grid, forces, 0)

figure, axes = plt.subplots(layout="constrained")
x, y = 1e3 * found.points.T
shown = axes.tripcolor(x, y, found.cells[:, :3], 1e-6 * found.von_mises, vmax=30.0, shading="gouraud", cmap="viridis")
figure.colorbar(shown, label="von Mises stress [MPa]", extend="max")
axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal", title="gear at 36.68 N m")
largest = 1e-6 * np.max(found.von_mises[found.bulk])
print(f"largest beyond {1e3 * grid.bulk_distance:.2g} mm from the contacts: {largest:.1f} MPa")
