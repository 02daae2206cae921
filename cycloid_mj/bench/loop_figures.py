"""The figures of a hysteresis loop, read off its points alone: measured or a model's, by the same definitions.

Each comes with its interval of 95 %, from how far the points lie from the straight lines that are laid through them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple, Self

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.units import DEGREE
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.uncertainty import COVERED, memory
from cycloid_mj.statics.windup import LOST_MOTION_SHARE

LOADED = (0.5, 0.98)
"""Part of a loading branch that is read as straight, as shares of the torque at its end: beyond it parts creep."""

LEAPT = 1.2
"""Coulomb torques from which on a branch is loaded: below, it leaps across the play."""

NEAR = 0.05
"""Half the width of the window about a level, as a share of the range."""

LOST_MOTION_WINDOW = 0.2
"""Half the width of the window about 3 % of the rated torque, as a share of that."""

TO_ZERO = 0.005
"""Share of the rated torque down to which a branch that is let go has not begun to cross its play."""

FEWEST = 5
"""Points that a line is laid through at least."""

DEFINITIONS = {
    "play_deg": "turn between the straight lines through both loading branches, from 50 to 98 % of the torque at their "
    "ends, each drawn back to the Coulomb torque of its side; of the loop that goes to the largest torque",
    "width_deg": "turn between the branches at zero torque, of the lowest loop; some authors state this opening as "
    "the play",
    "stiffness_nm_per_rad": "mean slope of both loading branches from 50 to 98 % of the torque at their ends, and "
    "beyond 1.2 times the Coulomb torque, of the loop that goes to the largest torque; the interval holds both sides'",
    "stiffness_positive_nm_per_rad": "slope of the branch on which the torque rises, from 50 to 98 % of its end",
    "stiffness_negative_nm_per_rad": "slope of the branch on which the torque falls, from 50 to 98 % of its end",
    "coulomb_nm": "half the torque between the branches half-way up the deflection of the lowest loop, where the teeth "
    "carry nothing",
}
"""How each figure of a loop is read, by its key in JSON."""


_Across = tuple[float, float, float]
"""Value of a branch at a level, its variance and its freedom."""


class LoopFigure(NamedTuple):
    """A value that is read off a loop, and the ends of its interval; no numbers where the loop does not show it."""

    value: float
    low: float
    high: float

    def scaled(self, factor: float) -> Self:
        """Return the figure in another unit."""
        return type(self)(*(factor * one for one in self))


NOTHING = LoopFigure(math.nan, math.nan, math.nan)


@dataclass(frozen=True)
class LoopReading:
    """What the loops of one drive show (`DEFINITIONS`): turns [rad], stiffness [N m/rad], torque [N m]."""

    play: LoopFigure
    width: LoopFigure
    stiffness: LoopFigure
    stiffness_positive: LoopFigure
    stiffness_negative: LoopFigure
    coulomb: LoopFigure

    def in_units(self) -> dict[str, LoopFigure]:
        """Return the figures by the keys of `DEFINITIONS`, in their units."""
        return {
            "play_deg": self.play.scaled(1.0 / DEGREE),
            "width_deg": self.width.scaled(1.0 / DEGREE),
            "stiffness_nm_per_rad": self.stiffness,
            "stiffness_positive_nm_per_rad": self.stiffness_positive,
            "stiffness_negative_nm_per_rad": self.stiffness_negative,
            "coulomb_nm": self.coulomb,
        }


class _Line(NamedTuple):
    """A straight line y = value + slope (x - middle), with the variances of both factors and their freedom."""

    middle: float
    value: float
    slope: float
    of_value: float
    of_slope: float
    freedom: float

    def at(self, x: float) -> tuple[float, float]:
        """Compute y and its variance."""
        away = x - self.middle
        return self.value + self.slope * away, self.of_value + self.of_slope * away**2


def read_figures(loops: Sequence[MeasuredLoop]) -> LoopReading:
    """Compute the figures of one drive: play and stiffness off the loop of the most torque, the rest off the lowest.

    What a loop does not show, as too few points on a branch, is no number.
    """
    loaded, lowest = max(loops, key=attrgetter("most")), min(loops, key=attrgetter("height"))
    coulomb = coulomb_of(lowest)
    low, high = LOADED
    below, above = loaded.ends
    rising = _loading(loaded, 1, low * above, high * above, coulomb.value)
    falling = _loading(loaded, -1, -low * below, -high * below, coulomb.value)
    positive, negative = _stiffness(rising), _stiffness(falling)
    both = _of_both(positive, negative)
    return LoopReading(_play(rising, falling, coulomb), width_of(lowest), both, positive, negative, coulomb)


def stiffness_between(loop: MeasuredLoop, low: float, high: float) -> LoopFigure:
    """Compute the mean slope of both loading branches between two torques [N m], as `stiffness_nm_per_rad` is read.

    No number where the loop does not reach the higher one.
    """
    if min(high, *map(abs, loop.ends)) < high * LOADED[1]:
        return NOTHING
    coulomb = coulomb_of(loop).value
    return _of_both(*(_stiffness(_loading(loop, way, low, high, coulomb)) for way in (1, -1)))


def lost_motion_of(loop: MeasuredLoop, rated: float) -> LoopFigure:
    """Compute the turn between the middles of the branches at +3 % and -3 % of a rated torque [rad]."""
    level = LOST_MOTION_SHARE * rated
    sides = [_across(loop, loop.torque, loop.deflection, way * level, LOST_MOTION_WINDOW * level) for way in (1, -1)]
    branches = [branch for side in sides if side for branch in side]
    if len(branches) < 4:
        return NOTHING
    value = 0.5 * (branches[0][0] + branches[1][0] - branches[2][0] - branches[3][0])
    away = _reach(min(one[2] for one in branches)) * 0.5 * sum(one[1] for one in branches) ** 0.5
    return LoopFigure(value, value - away, value + away)


def hysteresis_of(loop: MeasuredLoop, rated: float) -> LoopFigure:
    """Compute the turn between the branches at no torque [rad], each as it is let go: before it crosses the play.

    By the line through the points of a branch from 3 % of a rated torque down to 0.5 %, drawn on to none.
    """
    sides = []
    for way in (1, -1):
        torque, here = way * loop.torque, loop.on_the_way(-way)
        if not here.any() or not torque[here].min() < 0.0 < torque[here].max():
            return NOTHING
        near = (torque >= TO_ZERO * rated) & (torque <= LOST_MOTION_SHARE * rated)
        line = _line(loop.torque, loop.deflection, here & near)
        sides.append((*line.at(0.0), line.freedom) if line else _between(loop.torque[here], loop.deflection[here], 0.0))
    (upper, of_upper, one), (lower, of_lower, other) = sides
    away = _reach(min(one, other)) * (of_upper + of_lower) ** 0.5
    return LoopFigure(upper - lower, upper - lower - away, upper - lower + away)


def width_of(loop: MeasuredLoop) -> LoopFigure:
    """Compute the turn between the branches of a loop at no torque [rad]."""
    return _apart(loop, loop.torque, loop.deflection, 0.0)


def coulomb_of(loop: MeasuredLoop) -> LoopFigure:
    """Compute half the torque between the branches of a loop half-way up its deflection [N m]."""
    inner = loop.deflection[loop.lead :]
    value, low, high = _apart(loop, loop.deflection, loop.torque, 0.5 * float(inner.max() + inner.min()))
    return LoopFigure(-0.5 * value, -0.5 * high, -0.5 * low)


def _loading(loop: MeasuredLoop, way: int, low: float, high: float, coulomb: float) -> _Line | None:
    """Lay a line through the part of the loading branches to one side between two torques, deflection over torque."""
    carried = way * loop.torque
    loaded = (carried >= low) & (carried <= high) & ~(carried < LEAPT * coulomb)
    return _line(loop.torque, loop.deflection, loop.on_the_way(way) & loaded)


def _stiffness(line: _Line | None) -> LoopFigure:
    if line is None or line.slope <= 0.0:
        return NOTHING
    away = _reach(line.freedom) * line.of_slope**0.5
    return LoopFigure(
        1.0 / line.slope, 1.0 / (line.slope + away), 1.0 / (line.slope - away) if away < line.slope else math.inf
    )


def _of_both(positive: LoopFigure, negative: LoopFigure) -> LoopFigure:
    """Compute the stiffness whose compliance is the mean of both sides'; the interval holds both."""
    return LoopFigure(
        2.0 / (1.0 / positive.value + 1.0 / negative.value),
        min(positive.low, negative.low),
        max(positive.high, negative.high),
    )


def _play(rising: _Line | None, falling: _Line | None, coulomb: LoopFigure) -> LoopFigure:
    if rising is None or falling is None or math.isnan(coulomb.value):
        return NOTHING
    (upper, of_upper), (lower, of_lower) = rising.at(coulomb.value), falling.at(-coulomb.value)
    reach = _reach(min(rising.freedom, falling.freedom))
    by_torque = (rising.slope + falling.slope) * 0.5 * (coulomb.high - coulomb.low)
    away = math.hypot(reach * (of_upper + of_lower) ** 0.5, by_torque)
    return LoopFigure(upper - lower, upper - lower - away, upper - lower + away)


def _apart(loop: MeasuredLoop, along: Array, values: Array, level: float) -> LoopFigure:
    """Compute how far the falling branches lie above the rising ones where what is `along` is at a level."""
    sides = _across(loop, along, values, level, NEAR * float(np.ptp(along)))
    if sides is None:
        return NOTHING
    (above, of_above, one), (below, of_below, other) = sides
    away_from = _reach(min(one, other)) * (of_above + of_below) ** 0.5
    return LoopFigure(above - below, above - below - away_from, above - below + away_from)


def _across(
    loop: MeasuredLoop, along: Array, values: Array, level: float, window: float
) -> tuple[_Across, _Across] | None:
    """Compute where the falling and the rising branches pass a level, from the points within a window of it."""
    sides = []
    for way in (-1, 1):
        here = loop.on_the_way(way)
        if not here.any() or not along[here].min() < level < along[here].max():
            return None
        line = _line(along, values, here & (np.abs(along - level) <= window))
        sides.append((*line.at(level), line.freedom) if line else _between(along[here], values[here], level))
    falling, rising = sides
    return falling, rising


def _between(x: Array, y: Array, level: float) -> tuple[float, float, float]:
    """Compute y where a branch leaps past a level, its variance as of anywhere between the points, and its freedom."""
    order = np.argsort(x)
    after = int(np.searchsorted(x[order], level))
    one, other = y[order[after - 1]], y[order[after]]
    return float(np.interp(level, x[order], y[order])), float(other - one) ** 2 / 12.0, math.inf


def _line(x: Array, y: Array, chosen: Mask) -> _Line | None:
    """Lay a line through points by least squares; None through too few, or all at one place."""
    x, y = x[chosen], y[chosen]
    count, away = len(x), x - np.mean(x) if len(x) else x
    squares = float(away @ away)
    if count < FEWEST or squares <= 0.0:
        return None
    slope = float(away @ y) / squares
    left = y - np.mean(y) - slope * away
    # residuals that follow each other alike count as one
    alike = min(memory(left), count / 3.0)
    freedom = max(count / alike - 2.0, 1.0)
    noise = float(left @ left) / count * (count / alike) / freedom
    return _Line(float(np.mean(x)), float(np.mean(y)), slope, noise * alike / count, noise * alike / squares, freedom)


def _reach(freedom: float) -> float:
    """Compute how many standard errors an interval reaches to either side: Student's t."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + 0.5 * COVERED))
