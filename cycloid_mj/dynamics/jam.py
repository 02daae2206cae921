"""Detection of a jam: friction takes more torque at the crank than any motor of the drive provides."""

import math

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer

MAX_FRICTION_OVER_LOAD = 10.0
"""Largest friction torque at the crank, over the torque that the load requires there without losses.

Friction forces grow with the torque that overcomes them. In self-locking teeth only the compliance of the parts limits
this torque. A drive of 9 % efficiency reaches this value.
"""

MAX_FRICTION_OVER_RATED = 5.0
"""Largest friction torque at the crank, over its rated torque, at any load.

Motors stall below it: an induction motor at two to three times its rated torque, a servo motor at three to four times.
A start at 12 000 rpm, in which parts cross wide clearances, takes three times the rated torque.
"""

SELF_LOCKING = 1.0 / (1.0 + MAX_FRICTION_OVER_LOAD)
"""Efficiency at which friction takes `MAX_FRICTION_OVER_LOAD` times the power of the load."""


def jamming_power(reducer: Reducer) -> float:
    """Compute the friction power [W] above which a design jams; infinite if its crank is at rest."""
    design = reducer.design
    drive = design.drive
    torque = max(
        MAX_FRICTION_OVER_RATED * abs(drive.torque), MAX_FRICTION_OVER_LOAD * abs(design.load.torque) / design.reduction
    )
    return torque * abs(drive.speed) if torque and drive.speed else math.inf


def moving_means(values: Array, before: Array) -> Array:
    """Compute the mean of each of n `values` and the m values before it, shape (n,); `before`, shape (m,), precedes."""
    size = len(before) + 1
    sums = np.cumsum(np.concatenate([[0.0], before, values]))
    return (sums[size:] - sums[:-size]) / size
