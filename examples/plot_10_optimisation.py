"""
An optimisation
===============

Find the eccentricity and the pin radius with the lowest tooth pressure for the paper's reducer.

The checks of the design are additional limits; the result lists how many points each of them rejects. The pin circle
and the clearances do not change, and the backlash may not increase.
"""

import matplotlib.pyplot as plt

import cycloid_mj as cm

design = cm.load("pin")
optimum = cm.optimize(
    design,
    vary={"gear.eccentricity_mm": (0.6, 1.1), "ring.pin_radius_mm": (1.5, 3.2)},
    minimize="pin_gear_pressure",
    limits=["backlash<=1.0"],
    evaluations=40,
    starts=1,
    seed=1,
    verify=False,
)
print(optimum.values(optimum.best), optimum.figures(optimum.best))
print("refused:", optimum.refused)

# %%
# All evaluated points, coloured by tooth pressure. Crosses are points that a check or the limit refused.

points = {number: tuple(optimum.values(number).values()) for number in range(optimum.evaluations)}
feasible = optimum.feasible
pressure = [optimum.figures(number)["pin_gear_pressure"] for number in feasible]

figure, axes = plt.subplots(layout="constrained")
for number in set(points) - set(feasible):
    axes.plot(*points[number], "x", color="0.7")
shown = axes.scatter(*zip(*(points[number] for number in feasible), strict=True), c=pressure, cmap="turbo", norm="log")
figure.colorbar(shown, label="largest Hertz pressure of the teeth [MPa]")
axes.set(xlabel="eccentricity [mm]", ylabel="pin radius [mm]")
