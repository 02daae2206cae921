"""
A tour in a notebook
====================

Sixteen cells: a design, its checks, forces, a simulation, tolerances, life, an optimisation and a joint for a robot.

Results show themselves: a line of text, a table, or a figure by ``.plot()``. You need no other import. The notebook
``examples/notebook.ipynb`` has the same cells.
"""

# sphinx_gallery_capture_repr = ("_repr_html_", "__repr__")

import cycloid_mj as cm

# %%
# A design is a preset or a TOML file, with changes. Here the pins of the ring are fixed, so that runs are short, and
# the motor has 0.1 N m.

design = cm.load("pin", {"ring.pins": "fixed", "drive.torque_nm": 0.1})
design.plot()

# %%
# Can it be built, and does it last? Each bar is a check: the margin to its limit.

checks = cm.check(design)
checks.plot()

# %%
# Forces, backlash, stiffness and losses by static equilibrium, in a second.

sheet = cm.statics(design)
sheet

# %%
# The same values relative to their closed forms.

sheet.plot()

# %%
# Every figure has a key, a unit and a definition.

cm.FIGURES["backlash_arcmin"].definition

# %%
# A simulation of one crank turn under load, at full speed from the start.

run = cm.simulate(cm.load(design, {"drive.ramp_s": 0.0, "drive.hold_s": 0.045, "load.torque_nm": 3.5}))
run.plot("transmission_error")

# %%
# The run compared with theory: where the power is lost.

findings = cm.analyze(run)
findings.plot()

# %%
# One measure on its own: the transmission error, unloaded and loaded.

cm.measure.te(design, quick=True).plot()

# %%
# Life, strength and heat of each part.

rating = cm.rate(design)
rating.plot()

# %%
# How much do drives differ within the tolerances, and which tolerance decides?

toleranced = cm.load(design, {"tolerance.cam": "uniform 0.4", "tolerance.pin_position": "normal 0.2"})
tolerances = cm.tolerance(toleranced, samples=128)
tolerances.plot()

# %%
# A sweep over one value.

cm.sweep(design, {"clearance.cam_um": "1:8:8"}, ["backlash_arcmin", "stiffness_nm_per_arcmin"]).plot()

# %%
# Two designs under equal conditions. ``quick`` needs a few runs only.

wide = cm.load(design, {"name": "wide", "gear.face_width_mm": 14.0})
cm.compare(design, wide, quick=True).plot("compare_tooth_force")

# %%
# The lightest design within ranges that keeps the stiffness.

best = cm.optimize(
    design,
    {"gear.face_width_mm": "8:14", "ring.pin_radius_mm": "2:2.6"},
    minimize="mass_kg",
    limits="stiffness_nm_per_arcmin>=45",
    evaluations=12,
    starts=1,
    verify=False,
)
best.plot()

# %%
# The drive as a joint of a robot: the output over the torque at a locked crank.

joint = cm.reduce(design)
joint.plot()

# %%
# All identified values of the joint, as a table.

joint
