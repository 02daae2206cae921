"""When a drive jams: friction takes more at the crank than any motor made for the drive has."""

import math

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer

JAMMED = 10.0
"""Torque that friction takes at the crank over what the load asks for there without losses.

Forces that friction makes grow with the torque that overcomes them: where teeth lock themselves it has no bound but the
give of the parts. A drive of 9 % efficiency takes this much.
"""

STALLING = 5.0
"""Torque that friction takes at the crank, however small the load, over the crank's rated torque.

Motors stall at less: an induction motor pulls out at two to three times its rated torque, a servo motor is limited to
three or four times. A start at 12 000 rpm from rest, in which parts are thrown across wide play, takes three times.
"""

SELF_LOCKING = 1.0 / (1.0 + JAMMED)
"""Efficiency of a drive in which friction takes `JAMMED` times what goes to its load."""


def jamming_power(reducer: Reducer) -> float:
    """Compute the power of friction [W] above which a design jams; infinite where its crank stands."""
    design = reducer.design
    drive = design.drive
    asked = max(STALLING * abs(drive.torque), JAMMED * abs(design.load.torque) / design.reduction)
    return asked * abs(drive.speed) if asked and drive.speed else math.inf


def means_of_last(values: Array, before: Array) -> Array:
    """Compute the mean of each value and as many before it as `before` holds, which came before the first.

    `values` have shape (n,), as the means; `before` any other.
    """
    size = len(before) + 1
    sums = np.cumsum(np.concatenate([[0.0], before, values]))
    return (sums[size:] - sums[:-size]) / size
