"""
Two discs
=========

Most reducers on the market have two discs, half a turn apart on the crank. What does the second one buy?

The preset `twodisc` is a published 29:1 drive. Its discs share the load; bent output pins make the sharing uneven, and
the forces of both discs on the crank nearly cancel.
"""

import matplotlib.pyplot as plt
import numpy as np

import cycloid_mj as cm
from cycloid_mj.loaded import loads, springs_of

design = cm.load("twodisc")
crank = np.linspace(0.0, 2.0 * np.pi, 181)
found = loads(design, springs_of(design, crank, friction=False), design.rated_torque, follow=True)

# %%
# The cams' forces on the two discs, and what is left of both for the bearings of the crank.

cams = np.linalg.norm(found.cam, axis=-1)
left = np.linalg.norm(found.cam.sum(axis=1), axis=-1)

figure, (forces, shares) = plt.subplots(2, 1, sharex=True, layout="constrained")
for disc in range(2):
    forces.plot(np.degrees(crank), cams[:, disc], label=f"cam of disc {disc + 1}")
    shares.plot(np.degrees(crank), 1e2 * found.share[:, disc], label=f"disc {disc + 1}")
forces.plot(np.degrees(crank), left, label="both together", color="black")
forces.set(ylabel="force [N]", title=f"at {design.rated_torque:.3g} N m")
shares.set(xlabel="crank angle [deg]", ylabel="share of the torque [%]", ylim=(0.0, 100.0))
forces.legend()
shares.legend()
