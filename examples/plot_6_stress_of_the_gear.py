"""
Stress of the disc
==================

Finite elements under the forces of a run: the stress of the cycloid disc at one crank angle, and its maximum.

This needs the extra `fem`. The command `cycloid-mj stress` does the same for every part and degree of crank rotation,
and checks the mesh size.
"""

import matplotlib.pyplot as plt
import numpy as np

import cycloid_mj as cm

design = cm.load("pin", {"ring.pins": "massless", "drive.ramp_s": 0.0, "drive.hold_s": 0.05, "load.torque_nm": 36.68})
run = cm.simulate(design)

# %%
# The forces of the run act on flanks, bore and holes. Inertia and weight balance them.

grid = cm.stress.part_grid(design, "gear", cm.stress.GridSettings())
forces = cm.stress.part_loads(run, cm.Reducer(design), "gear", angles=[0.0])
result = cm.stress.stress_map(design, grid, forces, 0)

figure, axes = plt.subplots(layout="constrained")
x, y = 1e3 * result.points.T
image = axes.tripcolor(x, y, result.cells[:, :3], 1e-6 * result.von_mises, vmax=30.0, shading="gouraud", cmap="viridis")
figure.colorbar(image, label="von Mises stress [MPa]", extend="max")
axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal", title="disc at 36.68 N m")
largest = 1e-6 * np.max(result.von_mises[result.bulk])
print(f"maximum at more than {1e3 * grid.bulk_distance:.2g} mm from contacts: {largest:.1f} MPa")
