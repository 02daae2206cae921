"""The ladder of `cycloid-mj validate`: what the simulation gives, held against closed forms and published cases.

Each module is a rung and gives rows of *quantity, ours, reference, source, error, bound*; `ladder` runs them. The
references stand on `profile`, `envelope` and `statics` alone, never on the collider.
"""
