"""The validation steps of `cycloid-mj validate`: simulation results compared with closed forms and published cases.

Each module is one step and returns rows of *quantity, ours, reference, source, error, bound*; `suite` runs them. The
references use `profile`, `envelope` and `statics` only, never the collider.
"""
