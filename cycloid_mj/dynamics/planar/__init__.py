"""A compiled solver of the reducer's planar equations of motion, apart from MuJoCo.

The same reducer, laws, course and log as a run of MuJoCo's; contacts in known pairs, and friction by the contact's own
force: no convex cone. `system` takes what it needs of a design, `contacts` looks for touches in a pose, `equations`
solves a step for the speeds, and `stepper` takes the steps of a run.
"""
