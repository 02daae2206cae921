"""Studies of many designs: sweeps, tolerances with error budget, and optimisation."""

from cycloid_mj.explore.optimizer import optimize
from cycloid_mj.explore.optimum import Optimum
from cycloid_mj.explore.sweeps import Sweep, sweep
from cycloid_mj.explore.tolerances import Tolerances, tolerance

__all__ = ["Optimum", "Sweep", "Tolerances", "optimize", "sweep", "tolerance"]
