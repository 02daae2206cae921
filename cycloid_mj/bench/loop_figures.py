"""Figures of a hysteresis loop, computed from its points alone; measured and modelled loops alike.

Each has an interval of 95 % from the scatter of the points about straight lines.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple, Self

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.statistics import student_half_width
from cycloid_mj.base.units import DEGREE
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.uncertainty import INTERVAL, autocorrelation_time
from cycloid_mj.statics.windup import LOST_MOTION_SHARE


@dataclass(frozen=True)
class ReadingSettings:
    """Ranges over which the figures of a measured loop are read."""

    loaded: tuple[float, float] = (0.5, 0.98)
    """Straight part of a loading branch, as shares of the torque at its end; beyond it parts creep."""
    loaded_coulomb: float = 1.2
    """Torque from which a branch is loaded, over the Coulomb torque; below, it crosses the play."""
    level_window: float = 0.05
    """Half the width of the window about a level, as a share of the range."""
    lost_motion_window: float = 0.2
    """Half the width of the window about 3 % of the rated torque, as a share of that torque."""
    min_unloaded: float = 0.005
    """Share of the rated torque down to which a branch that is unloaded has not begun to cross its play."""
    min_points: int = 5
    """Smallest number of points of a straight line."""


READING = ReadingSettings()


DEFINITIONS = {
    "play_deg": "rotation between straight lines through both loading branches, from 50 to 98 % of the torque at their "
    "ends, each extended to the Coulomb torque of its side; of the loop with the largest torque",
    "width_deg": "rotation between the branches at zero torque, of the lowest loop; some authors state this opening as "
    "the play",
    "stiffness_nm_per_rad": "mean slope of both loading branches from 50 to 98 % of the torque at their ends, and "
    "beyond 1.2 times the Coulomb torque, of the loop with the largest torque; the interval covers both sides",
    "stiffness_positive_nm_per_rad": "slope of the branch on which the torque rises, from 50 to 98 % of its end",
    "stiffness_negative_nm_per_rad": "slope of the branch on which the torque falls, from 50 to 98 % of its end",
    "coulomb_nm": "half the torque between the branches halfway up the deflection of the lowest loop, where the teeth "
    "carry no load",
}
"""Definition of each figure of a loop, by its key in JSON."""


_Crossing = tuple[float, float, float]
"""Value of a branch at a level, its variance and its degrees of freedom."""


class LoopFigure(NamedTuple):
    """A figure of a loop and the ends of its interval; NaN where the loop does not show it."""

    value: float
    low: float
    high: float

    @classmethod
    def about(cls, value: float, half_width: float = 0.0) -> Self:
        """Return a quantity with an interval of this half width about its value."""
        return cls(value, value - half_width, value + half_width)

    def scale(self, factor: float) -> Self:
        """Return the quantity and its interval times a factor, as for another unit."""
        return type(self)(*(factor * item for item in self))


NO_FIGURE = LoopFigure(math.nan, math.nan, math.nan)


@dataclass(frozen=True)
class LoopFigures:
    """Figures of the loops of one drive (`DEFINITIONS`): rotations [rad], stiffness [N m/rad], torque [N m]."""

    play: LoopFigure
    width: LoopFigure
    stiffness: LoopFigure
    stiffness_positive: LoopFigure
    stiffness_negative: LoopFigure
    coulomb: LoopFigure

    def in_units(self) -> dict[str, LoopFigure]:
        """Return play, width, stiffness and Coulomb torque of the loops with their 95 % intervals, by key.

        A key, such as ``play_deg`` or ``stiffness_nm_per_rad``, ends in the unit of its value. There is also a
        stiffness for each sign of torque.
        """
        return {
            "play_deg": self.play.scale(1.0 / DEGREE),
            "width_deg": self.width.scale(1.0 / DEGREE),
            "stiffness_nm_per_rad": self.stiffness,
            "stiffness_positive_nm_per_rad": self.stiffness_positive,
            "stiffness_negative_nm_per_rad": self.stiffness_negative,
            "coulomb_nm": self.coulomb,
        }


class _Line(NamedTuple):
    """A fitted line y = value + slope (x - middle), with the variances of value and slope, and degrees of freedom."""

    middle: float
    value: float
    slope: float
    value_variance: float
    slope_variance: float
    freedom: float

    def at(self, x: float) -> tuple[float, float]:
        """Compute the value of the line at the abscissa x, and its variance."""
        distance = x - self.middle
        return self.value + self.slope * distance, self.value_variance + self.slope_variance * distance**2


def loop_figures(loops: Sequence[MeasuredLoop]) -> LoopFigures:
    """Compute play, width, stiffness and Coulomb torque of the loops of one drive, with 95 % intervals.

    `DEFINITIONS` defines them: the width is the rotation between the branches at zero torque. Play and stiffness are
    those of the loop with the largest torque. Width and Coulomb torque are those of the loop with the smallest range of
    deflection. A quantity is NaN if its loop does not allow it, for example with too few points.
    """
    largest_loop, smallest_loop = max(loops, key=attrgetter("most")), min(loops, key=attrgetter("height"))
    coulomb = loop_coulomb_torque(smallest_loop)
    low_share, high_share = READING.loaded
    lowest_torque, highest_torque = largest_loop.ends
    positive_line = _fit_loading_line(
        largest_loop, 1, low_share * highest_torque, high_share * highest_torque, coulomb.value
    )
    negative_line = _fit_loading_line(
        largest_loop, -1, -low_share * lowest_torque, -high_share * lowest_torque, coulomb.value
    )
    positive_stiffness, negative_stiffness = _line_stiffness(positive_line), _line_stiffness(negative_line)
    mean_stiffness = _mean_stiffness(positive_stiffness, negative_stiffness)
    return LoopFigures(
        _compute_play(positive_line, negative_line, coulomb),
        loop_width(smallest_loop),
        mean_stiffness,
        positive_stiffness,
        negative_stiffness,
        coulomb,
    )


def stiffness_between(loop: MeasuredLoop, low: float, high: float) -> LoopFigure:
    """Compute the stiffness [N m/rad] of a loop between two torques, with its 95 % interval.

    It is the mean of the stiffnesses at positive and negative torque. Lines are fitted to the loading branches, from
    `low` to `high` [N m] in magnitude, without torques below `READING.loaded_coulomb` times the Coulomb torque. NaN if
    a side of the loop ends below 98 % of `high`, or has too few points.
    """
    if min(high, *map(abs, loop.ends)) < high * READING.loaded[1]:
        return NO_FIGURE
    coulomb = loop_coulomb_torque(loop).value
    return _mean_stiffness(
        *(_line_stiffness(_fit_loading_line(loop, direction, low, high, coulomb)) for direction in (1, -1))
    )


def loop_lost_motion(loop: MeasuredLoop, rated_torque: float) -> LoopFigure:
    """Compute the lost motion of a loop [rad], with its 95 % interval.

    It is the rotation between the torques +3 % and -3 % of `rated_torque` [N m], each averaged over the rising and the
    falling branch. NaN if a branch does not cross one of these torques.
    """
    level = LOST_MOTION_SHARE * rated_torque
    crossings = [
        _find_crossings(loop, loop.torque, loop.deflection, direction * level, READING.lost_motion_window * level)
        for direction in (1, -1)
    ]
    branch_crossings = [crossing for side in crossings if side for crossing in side]
    if len(branch_crossings) < 4:
        return NO_FIGURE
    value = 0.5 * (branch_crossings[0][0] + branch_crossings[1][0] - branch_crossings[2][0] - branch_crossings[3][0])
    half_width = (
        _quantile(min(branch_crossing[2] for branch_crossing in branch_crossings))
        * 0.5
        * sum(branch_crossing[1] for branch_crossing in branch_crossings) ** 0.5
    )
    return LoopFigure.about(value, half_width)


def loop_hysteresis(loop: MeasuredLoop, rated_torque: float) -> LoopFigure:
    """Compute the hysteresis loss of a loop [rad], with its 95 % interval.

    It is the distance in rotation between the two unloading branches at zero torque. Each branch is extrapolated to
    zero torque by a line through its points between 3 % and 0.5 % of `rated_torque` [N m], before it crosses the play.
    With too few points there, the branch is interpolated at zero torque. NaN if a branch does not cross zero torque.
    """
    zero_crossings = []
    for direction in (1, -1):
        torque, is_unloading = direction * loop.torque, loop.moving(-direction)
        if not is_unloading.any() or not torque[is_unloading].min() < 0.0 < torque[is_unloading].max():
            return NO_FIGURE
        is_near_zero = (torque >= READING.min_unloaded * rated_torque) & (torque <= LOST_MOTION_SHARE * rated_torque)
        line = _fit_line(loop.torque, loop.deflection, is_unloading & is_near_zero)
        zero_crossings.append(
            (*line.at(0.0), line.freedom)
            if line
            else _interpolate_crossing(loop.torque[is_unloading], loop.deflection[is_unloading], 0.0)
        )
    (upper_value, upper_variance, upper_freedom), (lower_value, lower_variance, lower_freedom) = zero_crossings
    return LoopFigure.about(
        upper_value - lower_value,
        _quantile(min(upper_freedom, lower_freedom)) * (upper_variance + lower_variance) ** 0.5,
    )


def loop_width(loop: MeasuredLoop) -> LoopFigure:
    """Compute the rotation between falling and rising branch of a loop at zero torque [rad], with its 95 % interval."""
    return _branch_distance(loop, loop.torque, loop.deflection, 0.0)


def loop_coulomb_torque(loop: MeasuredLoop) -> LoopFigure:
    """Compute the Coulomb torque of a loop [N m], with its 95 % interval.

    It is half the torque between the rising and the falling branch at the middle deflection. NaN if a branch does not
    cross that deflection.
    """
    loop_deflection = loop.deflection[loop.points_left_out :]
    value, low, high = _branch_distance(
        loop, loop.deflection, loop.torque, 0.5 * float(loop_deflection.max() + loop_deflection.min())
    )
    return LoopFigure(-0.5 * value, -0.5 * high, -0.5 * low)


def _fit_loading_line(
    loop: MeasuredLoop, direction: int, low: float, high: float, coulomb_torque: float
) -> _Line | None:
    """Fit a line, deflection [rad] as a function of torque [N m], to the loading branches of one side of a loop.

    `direction` is 1 for the side of positive torque, -1 for negative torque. Points with a torque from `low` to `high`
    [N m] in magnitude are used, except those below `READING.loaded_coulomb` times `coulomb_torque` [N m]; if that is
    NaN, all are used. Return None if there are too few points.
    """
    signed_torque = direction * loop.torque
    is_in_interval = (
        (signed_torque >= low) & (signed_torque <= high) & ~(signed_torque < READING.loaded_coulomb * coulomb_torque)
    )
    return _fit_line(loop.torque, loop.deflection, loop.moving(direction) & is_in_interval)


def _line_stiffness(line: _Line | None) -> LoopFigure:
    """Return the stiffness [N m/rad] from a line through a loading branch, the inverse slope, with its 95 % interval.

    Stiffness and interval are NaN without a line, or if its slope is not positive. The upper end is infinite if the
    interval of the slope includes 0.
    """
    if line is None or line.slope <= 0.0:
        return NO_FIGURE
    half_width = _quantile(line.freedom) * line.slope_variance**0.5
    return LoopFigure(
        1.0 / line.slope,
        1.0 / (line.slope + half_width),
        1.0 / (line.slope - half_width) if half_width < line.slope else math.inf,
    )


def _mean_stiffness(positive: LoopFigure, negative: LoopFigure) -> LoopFigure:
    """Compute the stiffness whose compliance is the mean of both sides'; the interval covers both."""
    mean_stiffness = 2.0 / (1.0 / positive.value + 1.0 / negative.value)
    return LoopFigure(mean_stiffness, min(positive.low, negative.low), max(positive.high, negative.high))


def _compute_play(positive_line: _Line | None, negative_line: _Line | None, coulomb: LoopFigure) -> LoopFigure:
    """Compute the play [rad] from lines through both loading branches of a loop, with its 95 % interval.

    It is the rotation of `positive_line` at the torque +Tc minus that of `negative_line` at -Tc, where Tc is the
    Coulomb torque [N m]. NaN if a line is missing. The interval includes the scatter about both lines and the
    uncertainty of the Coulomb torque.
    """
    if positive_line is None or negative_line is None or math.isnan(coulomb.value):
        return NO_FIGURE
    (upper_angle, upper_variance), (lower_angle, lower_variance) = (
        positive_line.at(coulomb.value),
        negative_line.at(-coulomb.value),
    )
    quantile = _quantile(min(positive_line.freedom, negative_line.freedom))
    coulomb_part = (positive_line.slope + negative_line.slope) * 0.5 * (coulomb.high - coulomb.low)
    half_width = math.hypot(quantile * (upper_variance + lower_variance) ** 0.5, coulomb_part)
    return LoopFigure.about(upper_angle - lower_angle, half_width)


def _branch_distance(loop: MeasuredLoop, abscissa: Array, values: Array, level: float) -> LoopFigure:
    """Compute the distance of the branches of a loop at a level: the value on the falling minus that on the rising one.

    It has a 95 % interval. Both values are read where `abscissa` equals `level`. `abscissa` and `values` are torque and
    deflection of the loop, or vice versa, shape (n,). NaN if a branch does not cross the level.
    """
    crossings = _find_crossings(loop, abscissa, values, level, READING.level_window * float(np.ptp(abscissa)))
    if crossings is None:
        return NO_FIGURE
    (falling_value, upper_variance, upper_freedom), (rising_value, lower_variance, lower_freedom) = crossings
    return LoopFigure.about(
        falling_value - rising_value,
        _quantile(min(upper_freedom, lower_freedom)) * (upper_variance + lower_variance) ** 0.5,
    )


def _find_crossings(
    loop: MeasuredLoop, abscissa: Array, values: Array, level: float, window: float
) -> tuple[_Crossing, _Crossing] | None:
    """Compute the `values` at which the falling and the rising branches of a loop cross a level of `abscissa`.

    A line is fitted to the points of a branch within `window` of the level. With too few points, the branch is
    interpolated. `abscissa` and `values` have shape (n,) for n points.

    Returns
    -------
    tuple or None
        Value, variance and degrees of freedom for the falling, then the rising branches; None if a branch does not
        cross the level.
    """
    crossings = []
    for direction in (-1, 1):
        is_on_branch = loop.moving(direction)
        if not is_on_branch.any() or not abscissa[is_on_branch].min() < level < abscissa[is_on_branch].max():
            return None
        line = _fit_line(abscissa, values, is_on_branch & (np.abs(abscissa - level) <= window))
        crossings.append(
            (*line.at(level), line.freedom)
            if line
            else _interpolate_crossing(abscissa[is_on_branch], values[is_on_branch], level)
        )
    falling_crossing, rising_crossing = crossings
    return falling_crossing, rising_crossing


def _interpolate_crossing(x: Array, y: Array, level: float) -> _Crossing:
    """Interpolate y of a branch of n points, (n,), between the two points on both sides of a level of x.

    Return value, variance and degrees of freedom. The variance is that of a uniform distribution between both points;
    the degrees of freedom are infinite.
    """
    order = np.argsort(x)
    upper_index = int(np.searchsorted(x[order], level))
    lower_value, upper_value = y[order[upper_index - 1]], y[order[upper_index]]
    return (float(np.interp(level, x[order], y[order])), float(upper_value - lower_value) ** 2 / 12.0, math.inf)


def _fit_line(x: Array, y: Array, mask: Mask) -> _Line | None:
    """Fit a line to those of n points (x, y) that a mask (n,) selects, by least squares, with its uncertainty.

    The line has a value at the mean x, a slope, their variances, and degrees of freedom. These depend on the number of
    independent points: the number of points divided by their `autocorrelation_time`. Return None for fewer than
    `READING.min_points`, or if all have the same x.
    """
    x, y = x[mask], y[mask]
    point_count, offsets = len(x), x - np.mean(x) if len(x) else x
    sum_of_squares = float(offsets @ offsets)
    if point_count < READING.min_points or sum_of_squares <= 0.0:
        return None
    slope = float(offsets @ y) / sum_of_squares
    residuals = y - np.mean(y) - slope * offsets
    # correlated residuals count as one
    correlation_time = min(autocorrelation_time(residuals), point_count / 3.0)
    freedom = max(point_count / correlation_time - 2.0, 1.0)
    noise = float(residuals @ residuals) / point_count * (point_count / correlation_time) / freedom
    variances = noise * correlation_time / point_count, noise * correlation_time / sum_of_squares
    return _Line(float(np.mean(x)), float(np.mean(y)), slope, *variances, freedom)


def _quantile(freedom: float) -> float:
    """Compute the half width of the interval `INTERVAL.confidence` in standard errors, by Student's t."""
    return student_half_width(freedom, INTERVAL.confidence)
