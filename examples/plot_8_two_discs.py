"""
Two discs
=========

Most reducers on the market have two discs, half a turn apart on the crank. What is the benefit of the second one?

The preset `twodisc` is a published 29:1 drive whose output pins are supported at both ends. Its discs share the load
equally, and their forces on the crank cancel. If the pins are supported at one end only, the disc next to that end
carries most of the load.
"""

import matplotlib.pyplot as plt
import numpy as np

import cycloid_mj as cm

crank = np.linspace(0.0, 2.0 * np.pi, 181)

figure, (shares, forces) = plt.subplots(2, 1, figsize=(6.4, 6.4), sharex=True, layout="constrained")
for support, ends, line in (("both_ends", "both ends", "-"), ("cantilever", "one end", "--")):
    design = cm.load("twodisc", {"output.support": support})
    reducer = cm.Reducer(design)
    springs = cm.statics.springs_of(reducer, crank, friction=False)
    result = cm.statics.loads(reducer, springs, design.rated_torque, warm_start=True)
    for disc, colour in enumerate(("tab:blue", "tab:orange")):
        label = f"disc {disc + 1}, pins supported at {ends}"
        shares.plot(
            np.degrees(crank), 1e2 * result.share[:, disc], line, color=colour, linewidth=4.0 - 2.5 * disc, label=label
        )

    # the bearings of the crank carry the sum of the cam forces of both discs
    total = np.linalg.norm(result.cam.sum(axis=1), axis=-1)
    forces.plot(np.degrees(crank), total, line, color="black", label=f"pins supported at {ends}")
shares.set(ylabel="share of the torque [%]", ylim=(0.0, 100.0), title=f"at {design.rated_torque:.3g} N m")
forces.set(xlabel="crank angle [deg]", ylabel="force on the crank [N]", title="both cams together")
shares.legend(loc="upper center", bbox_to_anchor=(0.5, 0.82), ncols=2, fontsize=8)
forces.legend(loc="center right")
