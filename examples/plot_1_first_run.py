"""
First run
=========

Run the paper's reducer under load, and look at what the output does and what a pin feels.

One crank turn at 1640 rpm and the rated 36.68 N m, with massless pins: the gear's inertia is in the run, that of the
pins is not, which a loaded mean does not notice.
"""

import matplotlib.pyplot as plt

import cycloid_mj as cm

design = cm.load("pin", {"ring.pins": "massless", "drive.ramp_s": 0.0, "drive.hold_s": 0.05, "load.torque_nm": 36.68})
run = cm.simulate(design)
found = cm.analyze(run)

print(f"efficiency {found.efficiency:.1%}")
print(f"transmission error {found.transmission_error.peak_to_peak_arcsec:.2f} arcsec, peak to peak")

# %%
# A run is time with named columns in SI units. The load comes on in the first 5 ms.

crank, output = run["crank_angle"], run["output_angle"]
error = (output + crank / design.lobes) * 206264.8
force = run["pin_1_peak_force"]

figure, (above, below) = plt.subplots(2, 1, sharex=True, layout="constrained")
above.plot(1e3 * run.time, error)
above.set(ylabel="transmission error [arcsec]", title="output behind the ideal one")
below.plot(1e3 * run.time, force)
below.set(xlabel="time [ms]", ylabel="force [N]", title="pin 1 on the gear: loaded over half of the turn")
