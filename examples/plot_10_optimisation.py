"""
An optimisation
===============

The best drive in an envelope: eccentricity and pin radius of the paper's reducer for the least tooth pressure.

The checks of the design are limits of their own, and what they refuse is counted. The pin circle, and so the envelope,
stays as it is; so do the clearances, and the backlash may not grow.
"""

import matplotlib.pyplot as plt

import cycloid_mj as cm

design = cm.load("pin")
found = cm.optimize(
    design,
    vary={"gear.eccentricity_mm": (0.6, 1.1), "ring.pin_radius_mm": (1.5, 3.2)},
    minimize="pin_gear_pressure",
    limits=["backlash<=1.0"],
    evaluations=40,
    starts=1,
    seed=1,
    verify=False,
)
print(found.values(found.best), found.figures(found.best))
print("refused:", found.refused)

# %%
# Every point that was tried, by the pressure of its teeth; those that a check or the limit refused are crosses.

places = {place: tuple(found.values(place).values()) for place in range(found.evaluations)}
good = found.feasible
pressure = [found.figures(place)["pin_gear_pressure"] for place in good]

figure, axes = plt.subplots(layout="constrained")
for place in set(places) - set(good):
    axes.plot(*places[place], "x", color="0.7")
shown = axes.scatter(*zip(*(places[place] for place in good), strict=True), c=pressure, cmap="turbo", norm="log")
figure.colorbar(shown, label="largest Hertz pressure of the teeth [MPa]")
axes.set(xlabel="eccentricity [mm]", ylabel="pin radius [mm]")
