"""A compiled solver of the reducer's planar equations of motion, independent of MuJoCo.

Reducer, laws, drive cycle and log are those of a MuJoCo run; contacts occur in known pairs only, and friction follows
the contact's own force: no convex cone. `system` has the arrays of a design, `contacts` the contact search at a pose,
`equations` solves a step for the speeds, and `stepper` takes the steps of a run.
"""
