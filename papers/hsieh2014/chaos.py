"""How far the idle motion is chaotic: how fast two runs part that begin a billionth of gravity apart."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.comparison import settled
from cycloid_mj.design import Design, override
from cycloid_mj.record import Run

NUDGE = 1e-9
"""By how much of itself gravity differs between the two runs."""

SMALL, LARGE = 1e-6, 1e-1
"""Between these shares of the motion's own rms the growth of the difference is timed: beyond, it has no more room."""


@dataclass(frozen=True)
class Divergence:
    """How two all but equal runs part.

    Attributes
    ----------
    foldings
        Growth of their difference, in e-foldings a crank turn (the largest Lyapunov exponent, roughly); not a number
        where it stays below `SMALL`, and nothing is found of chaos.
    turns
        Crank turns after which they differ by a tenth of the motion itself; infinite where they never do.
    """

    foldings: float
    turns: float


def nudged(design: Design) -> Design:
    """Give the design under a gravity that differs by `NUDGE`."""
    return override(design, [f"environment.gravity_y_m_s2={design.environment.gravity_y * (1.0 + NUDGE)!r}"])


def divergence(one: Run, other: Run) -> Divergence:
    """Hold two runs of the same length against each other, by the transmission error of the gear."""
    motion = settled(one)
    error, same = motion.gear_angle.error, settled(other).gear_angle.error
    size = np.abs(error - same) / (float(np.std(error[motion.hold])) or 1.0)
    turned = np.abs(motion.crank_angle - motion.crank_angle[0]) / (2.0 * math.pi)
    if not (size > SMALL).any():
        return Divergence(math.nan, math.inf)
    parted = bool((size > LARGE).any())
    first, last = int(np.argmax(size > SMALL)), int(np.argmax(size > LARGE) if parted else np.argmax(size))
    grown = math.log(size[last] / size[first]) / max(float(turned[last] - turned[first]), float(turned[1]))
    return Divergence(grown, float(turned[last]) if parted else math.inf)
