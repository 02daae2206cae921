"""
First run
=========

Simulate the paper's reducer under load. The plots show the transmission error of the output and the force on a pin.

The run is one crank turn at 1640 rpm and 36.68 N m, with massless pins: the inertia of the disc is included, that of
the pins is not. Mean values under load are the same as with real pins.
"""

import matplotlib.pyplot as plt

import cycloid_mj as cm

design = cm.load("pin", {"ring.pins": "massless", "drive.ramp_s": 0.0, "drive.hold_s": 0.05, "load.torque_nm": 36.68})
run = cm.simulate(design)
results = cm.analyze(run)

print(f"efficiency {results.efficiency:.1%}")
print(f"transmission error {results.transmission_error.peak_to_peak_arcsec:.2f} arcsec, peak to peak")

# %%
# A run has the time and named columns in SI units. The load increases during the first 5 ms.

crank, output = run["crank_angle"], run["output_angle"]
error = (output + crank / design.lobes) * 206264.8
force = run["pin_1_peak_force"]

figure, (above, below) = plt.subplots(2, 1, sharex=True, layout="constrained")
above.plot(1e3 * run.time, error)
above.set(ylabel="transmission error [arcsec]", title="difference of the output from the ideal motion")
below.plot(1e3 * run.time, force)
below.set(xlabel="time [ms]", ylabel="force [N]", title="pin 1 on the disc: loaded during half of the turn")
