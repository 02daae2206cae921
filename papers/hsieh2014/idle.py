"""Motion without load: spread of each quantity over independent starts, for varied parameters, and chaos."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.record import Run
from cycloid_mj.comparison import StartSpread, Variation, settle_run
from cycloid_mj.design import Design, override
from hsieh2014.plan import Plan, designs, idle_runs, variations, varied_idle_runs
from hsieh2014.ranking import RANKED
from hsieh2014.run_figures import RunFigures
from hsieh2014.stage import Runs
from hsieh2014.verdicts import rank_order

Levels = Mapping[str, Mapping[str, StartSpread]]
"""Key of a ranked quantity -> name of a design -> rms difference from the closed form, for each of its runs."""


def pin_over_nonpin(levels: Levels, key: str) -> int:
    """Return which design fluctuates more in a quantity: 1 pin, -1 nonpin, 0 not significant."""
    return rank_order(levels[key]["pin"], levels[key]["nonpin"])


def idle(plan: Plan, runs: Runs) -> Levels:
    """Compute the idle fluctuations of both designs."""
    return levels_of({design.name: runs.figures(idle_runs(plan, design), plan.solver) for design in designs()})


def swept(plan: Plan, runs: Runs) -> dict[Variation, Levels]:
    """Run all starts without load with one parameter varied at a time; return the rms of their fluctuations.

    The rms values are by variation, then as in `Levels`.
    """
    cases = {
        variation: {design.name: varied_idle_runs(plan, variation, design) for design in designs()}
        for variation in variations(plan)
    }
    # all at once, so that the runs fill every core
    runs([run for case in cases.values() for starts in case.values() for run in starts], plan.solver)
    return {
        variation: levels_of({name: runs.figures(starts, plan.solver) for name, starts in case.items()})
        for variation, case in cases.items()
    }


def levels_of(starts: Mapping[str, Sequence[RunFigures]]) -> Levels:
    """Collect the levels of runs: name of a design -> its runs."""
    return {
        each.key: {name: StartSpread.of(figures.levels[each.key] for figures in runs) for name, runs in starts.items()}
        for each in RANKED
    }


NUDGE = 1e-9
"""Relative difference of gravity between two almost equal runs."""

SMALL, LARGE = 1e-6, 1e-1
"""Shares of the motion's rms between which the growth of the difference is measured; beyond, it saturates."""


@dataclass(frozen=True)
class Divergence:
    """Divergence of two almost equal runs."""

    foldings: float
    """Growth of their difference, in e-foldings per crank turn (roughly the largest Lyapunov exponent); NaN if the
    difference stays below `SMALL`, which means no chaos."""
    turns: float
    """Crank turns after which they differ by a tenth of the motion itself; infinite if they never do."""


def nudge_gravity(design: Design) -> Design:
    """Return the design under a gravity that differs by `NUDGE`."""
    return override(design, [f"environment.gravity_y_m_s2={design.environment.gravity_y * (1.0 + NUDGE)!r}"])


def divergence(run: Run, other: Run) -> Divergence:
    """Compute how fast two runs of the same length diverge, from the difference of the disc's transmission errors."""
    motion = settle_run(run)
    error, same = motion.gear_angle.error, settle_run(other).gear_angle.error
    size = np.abs(error - same) / (float(np.std(error[motion.hold])) or 1.0)
    turned = np.abs(motion.crank_angle - motion.crank_angle[0]) / (2.0 * math.pi)
    if not (size > SMALL).any():
        return Divergence(math.nan, math.inf)
    parted = bool((size > LARGE).any())
    first, last = int(np.argmax(size > SMALL)), int(np.argmax(size > LARGE) if parted else np.argmax(size))
    grown = math.log(size[last] / size[first]) / max(float(turned[last] - turned[first]), float(turned[1]))
    return Divergence(grown, float(turned[last]) if parted else math.inf)
