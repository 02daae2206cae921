"""
A printed drive
===============

A plastic disc on steel pins with clearances of 0.05 mm: the preset `printed`, a published 13:1 drive.

The clearances determine the backlash, the plastic determines the stiffness. Both are computed by the static model.
"""

import matplotlib.pyplot as plt
import numpy as np

import cycloid_mj as cm

STANDING = {"drive.speed_rpm": 0.0, "environment.gravity_y_m_s2": 0.0}
torque = np.concatenate([-np.geomspace(10.0, 0.01, 25), np.geomspace(0.01, 10.0, 25)])

figure, axes = plt.subplots(layout="constrained")
for label, changes in {
    "as drawn: 0.05 mm": {},
    "twice the clearance at the ring pins": {"clearance.pin_gear_um": 100.0},
    "a disc of aluminium": {"gear_material.name": "aluminium 6061"},
}.items():
    design = cm.load("printed", STANDING | changes)
    springs = cm.statics.springs_of(cm.Reducer(design), [0.3], friction=False)
    turn = np.degrees([cm.statics.loads(cm.Reducer(design), springs, float(value)).output_turn[0] for value in torque])
    backlash = turn[torque > 0.0].min() - turn[torque < 0.0].max()
    axes.plot(torque, turn, label=f"{label}: backlash {backlash:.2f} deg")
axes.set(xlabel="torque on the output [N m]", ylabel="rotation of the output [deg]", ylim=(-0.8, 1.1))
axes.set_title("crank locked at 0.3 rad")
axes.legend(loc="upper left")
