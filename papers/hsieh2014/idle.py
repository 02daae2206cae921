"""Idle motion: the spread of each quantity over independent starts as parameters vary, and how far it is chaotic."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.record import Run
from cycloid_mj.comparison import StartSpread, Variation, settled
from cycloid_mj.design import Design, override
from hsieh2014.plan import Plan, designs, idle_runs, variations, varied_idle_runs
from hsieh2014.ranking import RANKED
from hsieh2014.run_figures import RunFigures
from hsieh2014.stage import Runs
from hsieh2014.verdicts import rank_order

Levels = Mapping[str, Mapping[str, StartSpread]]
"""Key of a ranked quantity -> name of a design -> rms about the closed form of each of its runs."""


def pin_over_nonpin(levels: Levels, key: str) -> int:
    """Tell which design fluctuates more in a quantity: pin (1), nonpin (-1), or neither for sure (0)."""
    return rank_order(levels[key]["pin"], levels[key]["nonpin"])


def idle(plan: Plan, runs: Runs) -> Levels:
    """Compute the idle fluctuations of both designs."""
    return levels_of({design.name: runs.figures(idle_runs(plan, design), plan.solver) for design in designs()})


def swept(plan: Plan, runs: Runs) -> dict[Variation, Levels]:
    """Collect the idle fluctuations with one parameter varied at a time."""
    cases = {
        variation: {design.name: varied_idle_runs(plan, variation, design) for design in designs()}
        for variation in variations(plan)
    }
    # all at once, so that the runs fill every core
    runs([run for case in cases.values() for starts in case.values() for run in starts], plan.solver)
    return {
        one: levels_of({name: runs.figures(starts, plan.solver) for name, starts in case.items()})
        for one, case in cases.items()
    }


def levels_of(starts: Mapping[str, Sequence[RunFigures]]) -> Levels:
    """Collect the levels of runs: name of a design -> its runs."""
    return {
        each.key: {name: StartSpread.of(one.levels[each.key] for one in runs) for name, runs in starts.items()}
        for each in RANKED
    }


NUDGE = 1e-9
"""By how much of itself gravity differs between two runs that begin all but alike."""

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
    """Return the design under a gravity that differs by `NUDGE`."""
    return override(design, [f"environment.gravity_y_m_s2={design.environment.gravity_y * (1.0 + NUDGE)!r}"])


def divergence(run: Run, other: Run) -> Divergence:
    """Hold two runs of the same length against each other, by the transmission error of the gear."""
    motion = settled(run)
    error, same = motion.gear_angle.error, settled(other).gear_angle.error
    size = np.abs(error - same) / (float(np.std(error[motion.hold])) or 1.0)
    turned = np.abs(motion.crank_angle - motion.crank_angle[0]) / (2.0 * math.pi)
    if not (size > SMALL).any():
        return Divergence(math.nan, math.inf)
    parted = bool((size > LARGE).any())
    first, last = int(np.argmax(size > SMALL)), int(np.argmax(size > LARGE) if parted else np.argmax(size))
    grown = math.log(size[last] / size[first]) / max(float(turned[last] - turned[first]), float(turned[1]))
    return Divergence(grown, float(turned[last]) if parted else math.inf)
