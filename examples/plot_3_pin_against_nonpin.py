"""
Ring pins or an internal gear
=============================

What changes if an internal gear replaces the free ring pins?

A free pin has two clearances and two contacts in series. With equal clearances of 1 um, the reducer with the internal
gear (`nonpin`) therefore has less backlash, is stiffer, and has a smaller transmission error. Static results at
36.68 N m, without friction.
"""

import matplotlib.pyplot as plt
import numpy as np

import cycloid_mj as cm

ARCSEC, ARCMIN = np.pi / 648000.0, np.pi / 10800.0
crank = np.linspace(0.0, 2.0 * np.pi / 6.0, 121)
torque = np.concatenate([-np.geomspace(36.68, 0.01, 25), np.geomspace(0.01, 36.68, 25)])

figure, (above, below) = plt.subplots(2, 1, figsize=(6.4, 6.4), layout="constrained")
for name in ("pin", "nonpin"):
    design = cm.load(name)
    error = cm.statics.transmission_error(cm.Reducer(design), crank, 36.68)[:, 1] / ARCSEC
    above.plot(np.degrees(crank), error - error.mean(), label=f"{name}: {np.ptp(error):.2f} arcsec")
    standing = cm.load(name, {"drive.speed_rpm": 0.0, "environment.gravity_y_m_s2": 0.0})
    springs = cm.statics.springs_of(cm.Reducer(standing), [0.4], friction=False)
    turn = [cm.statics.loads(cm.Reducer(standing), springs, float(value)).output_turn[0] / ARCMIN for value in torque]
    below.plot(torque, turn, label=name)
above.set(
    xlabel="crank angle [deg]", ylabel="transmission error [arcsec]", title="difference from the mean, at 36.68 N m"
)
below.set(
    xlabel="torque on the output [N m]", ylabel="rotation of the output [arcmin]", title="crank locked at 0.4 rad"
)
above.legend()
below.legend()
