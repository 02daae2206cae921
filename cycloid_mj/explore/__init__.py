"""What becomes of a design as its values change: sweeps of any key, tolerances, and which of them to tighten first."""

from cycloid_mj.explore.sweeps import Sweep, sweep
from cycloid_mj.explore.tolerances import Tolerances, tolerance

__all__ = ["Sweep", "Tolerances", "sweep", "tolerance"]
