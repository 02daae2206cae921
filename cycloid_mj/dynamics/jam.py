"""Detection of a jam: the friction torque on the crank exceeds that of any motor of the drive."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class JamSettings:
    """Friction torque at the crank above which a drive jams."""

    max_friction_over_load: float = 10.0
    """Largest friction torque at the crank, over the torque that the load requires there without losses.

    Friction forces grow with the torque that overcomes them. In self-locking teeth only the compliance of the parts
    limits this torque. A drive of 9 % efficiency reaches this value.
    """
    max_friction_over_rated: float = 5.0
    """Largest friction torque at the crank, over its rated torque, at any load.

    Motors stall below it: an induction motor at two to three times its rated torque, a servo motor at three to four
    times. A start at 12 000 rpm, in which parts cross wide clearances, takes three times the rated torque.
    """

    @property
    def min_efficiency(self) -> float:
        """Efficiency at which friction takes `max_friction_over_load` times the power of the load."""
        return 1.0 / (1.0 + self.max_friction_over_load)


JAM = JamSettings()


def jamming_power(reducer: Reducer) -> float:
    """Compute the friction power [W] above which a design jams; infinite if its crank is at rest.

    The power is the crank speed times the larger of two torques on the crank, each times a factor in `JamSettings`: the
    rated torque, and the torque that moves the load without losses.
    """
    design = reducer.design
    drive = design.drive
    torque = max(
        JAM.max_friction_over_rated * abs(drive.torque),
        JAM.max_friction_over_load * abs(design.load.torque) / design.reduction,
    )
    return torque * abs(drive.speed) if torque and drive.speed else math.inf


def moving_means(values: Array, before: Array) -> Array:
    """Compute the mean of each of n `values` and the m values before it, shape (n,); `before`, shape (m,), precedes."""
    size = len(before) + 1
    sums = np.cumsum(np.concatenate([[0.0], before, values]))
    return (sums[size:] - sums[:-size]) / size
