"""Studies of many designs: comparison, sweeps, tolerances with error budget, and optimisation."""

from cycloid_mj.explore.compared import compare
from cycloid_mj.explore.optimizer import optimize
from cycloid_mj.explore.optimum import Optimum
from cycloid_mj.explore.sweeps import Sweep, sweep
from cycloid_mj.explore.tolerances import Tolerances, tolerance

__all__ = ["Optimum", "Sweep", "Tolerances", "compare", "optimize", "sweep", "tolerance"]
