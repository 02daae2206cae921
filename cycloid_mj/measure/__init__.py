"""What engineers measure of a reducer, by simulation, beside the closed form where there is one.

Each module is one measure: a function from a design to a `Measurement`.
"""

from cycloid_mj.measure.measurement import Measurement

__all__ = ["Measurement"]
