"""Fit of a model to measured loops, with intervals by profile likelihood.

An interval ends where the residuals become too large even with all other values fitted again: profile likelihood
(Venzon and Moolgavkar, Appl. Statist. 37, 1988, 87-94). Where the cost has a long bent valley, as between friction of
contacts and constant friction, intervals of the linearised model would be far too narrow. Several valleys may explain
the loops equally well: an interval covers all that the searches reached.

A model has an error besides noise. An error of rms d, whatever its course, moves a value by at most d times the root of
its inverse curvature (Cauchy-Schwarz, for a linear model). Intervals are wider by that, with d = `MODEL_ERROR`. A
prior, such as a clearance with a tolerance in the design, counts as a residual of that size at one standard deviation.

Loops do not distinguish between values within such intervals. The values that are returned are those whose deflections
are nearest to the measured ones at the same torque (`FitProblem.nearest_deflections`). They differ from the likeliest
where the model has an error: the fit measures the distance from a branch, in which a leap across the play that comes a
little early counts little, and an outlier less.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from operator import itemgetter

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.statistics import rms
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.overlay import Branches, LoopCondition, apply_values, deflections, model_branches
from cycloid_mj.bench.parameters import Model, Parameter
from cycloid_mj.bench.search import (
    FAILED_RESIDUAL,
    MODEL_ERROR,
    SETTINGS,
    FitProblem,
    Trials,
    offset_scales,
)
from cycloid_mj.bench.uncertainty import FitUncertainty, autocorrelation_time, estimate_uncertainty


@dataclass(frozen=True)
class ProfileSettings:
    """Settings of the intervals by profile likelihood."""

    max_steps: int = 4
    """Largest number of steps of the search for all other values with one of them fixed."""
    max_doublings: int = 4
    """How often the distance of the fixed value is doubled; an interval that does not end by then is unbounded."""
    improvement_rtol: float = 1e-3
    """Relative improvement at which the fit restarts from a point that such a search reached."""
    max_restarts: int = 3
    """How often the fit may start from there."""
    bound_distance: float = 1e-3
    """Distance from a bound, of a scaled value, at which the value counts as at the bound."""


PROFILE = ProfileSettings()


@dataclass(frozen=True, eq=False)
class Fitted:
    """A model fitted to loops."""

    model: Model
    parameters: tuple[Parameter, ...]
    bench: LoopCondition
    loops: tuple[MeasuredLoop, ...]
    """The model before the fit, its parameters, and the loops with the condition under which they were measured."""
    likeliest: Array
    """Scaled values with the smallest residuals: parameters, then offsets of torque and deflection of each loop."""
    scaled: Array
    """Scaled values within the intervals whose deflections are nearest to the measured ones."""
    residuals: tuple[Array, ...]
    """Residuals of each loop's points at `likeliest`, as shares of its ranges."""
    slopes: Array
    """Slopes of all residuals by all scaled values there, shape (points, values)."""
    uncertainty: FitUncertainty
    """Uncertainty of the scaled values; 0 of those at a bound, which are no measurement."""
    at_bound: Mask
    """Which values are at a bound, shape (values,)."""
    ends: Array
    """Ends of the 95 % interval of each scaled value (`uncertainty.CONFIDENCE`), shape (values, 2); one-sided at a
    bound."""
    prior_share: Array
    """Share of the knowledge of each value that is the prior's and not the loops', from 0 to 1, shape (values,)."""
    torque_offset: bool = True
    """Whether the loops have zero offsets of torque; else these are 0."""
    offset_gain: float = math.nan
    """Bayesian information criterion without such offsets less that with them: positive where the loops support
    them."""

    @property
    def values(self) -> Array:
        """Fitted values of the parameters, in their units."""
        return self.values_at(self.scaled)

    @cached_property
    def calibrated_model(self) -> Model:
        """The model with the fitted values."""
        return apply_values(self.model, self.parameters, self.values)

    @property
    def offsets(self) -> Array:
        """Offsets of each loop in torque [N m] and deflection [rad], shape (loops, 2)."""
        shares = self.scaled[len(self.parameters) :].reshape(-1, 2)
        return shares * np.array([offset_scales(loop) for loop in self.loops])

    @cached_property
    def branches(self) -> tuple[Branches, ...]:
        """Torque [N m] and deflection [rad] of the model along each branch of each loop, with the loop's offsets."""
        lines = []
        for loop, (torque, deflection) in zip(self.loops, self.offsets, strict=True):
            branches = model_branches(self.calibrated_model, self.bench, loop, float(torque))
            lines.append([(loads + torque, turns + deflection) for loads, turns in branches])
        return tuple(lines)

    @cached_property
    def turns(self) -> tuple[Array, ...]:
        """Deflection of the model at every measured point [rad]: that of its branch at the measured torque."""
        return tuple(deflections(loop, branches) for loop, branches in zip(self.loops, self.branches, strict=True))

    @property
    def independent(self) -> tuple[float, ...]:
        """Number of independent residuals of each loop (`autocorrelation_time`)."""
        return tuple(len(residual) / autocorrelation_time(residual) for residual in self.residuals)

    @property
    def free_values(self) -> int:
        """Number of values that were fitted, offsets included."""
        return len(self.scaled) - (0 if self.torque_offset else len(self.loops))

    def bayesian_criterion(self, independent: Sequence[float]) -> float:
        """Compute the Bayesian information criterion, given the number of independent residuals of each loop.

        Criteria of models compare only where that number is the same: a model that leaves something out has correlated
        residuals, and by its own count would have less to explain.
        """
        return _misfit(self.residuals, independent) + self.free_values * float(np.log(sum(independent)))

    def akaike_criterion(self, independent: Sequence[float]) -> float:
        """Compute Akaike's information criterion by the same residuals."""
        return _misfit(self.residuals, independent) + 2.0 * self.free_values

    def values_at(self, scaled: Array) -> Array:
        """Compute the parameters' values from scaled ones."""
        return np.array([parameter.from_scale(item) for parameter, item in zip(self.parameters, scaled, strict=False)])

    def rms(self, number: int) -> float:
        """Compute the rms difference of a loop's deflection from the model's at the same torque [rad]."""
        loop = self.loops[number]
        return rms((self.turns[number] - loop.deflection)[loop.points_left_out :])

    def rms_without_offset(self, number: int) -> float:
        """Compute that difference for an offset of torque of 0, as in a scene, and the best of deflection [rad]."""
        loop = self.loops[number]
        turn = deflections(loop, model_branches(self.calibrated_model, self.bench, loop))
        return float(np.std((turn - loop.deflection)[loop.points_left_out :]))


class FitStopped(KeyboardInterrupt):
    """Ctrl-C, or an equivalent signal, after at least one search ended: `fitted` is the best fit by then."""

    def __init__(self, stop: KeyboardInterrupt, fitted: Fitted) -> None:
        super().__init__(*stop.args)
        self.fitted = fitted


def fit(
    model: Model,
    parameters: Sequence[Parameter],
    loops: Sequence[MeasuredLoop],
    bench: LoopCondition,
    trials: Trials | None = None,
    start: Array | None = None,
    intervals: bool = True,
    torque_offset: bool | None = None,
) -> Fitted:
    """Fit parameters of a model to loops by robust least squares.

    Parameters
    ----------
    model, parameters, loops, bench
        What is fitted to what.
    trials
        Counter of evaluations.
    start
        Scaled values of a single start; by default several starts (`FitProblem.starts`).
    intervals
        Whether intervals are by profile likelihood. Else they are those of the linearised model, which take no further
        search, and the values are the likeliest.
    torque_offset
        Whether each loop has a zero offset of torque; by default chosen by the Bayesian information criterion.

    Raises
    ------
    RunError
        No static balance exists.
    FitStopped
        Ctrl-C: it has the best values by then, with intervals of the linearised model where there are no others.
    """
    search = FitProblem(model, tuple(parameters), tuple(loops), bench, trials or Trials(), torque_offset is not False)
    searches = {"ends": 2 * len(search.parameters), "nearest": 1} if intervals else {}
    ended: list[tuple[float, Array]] = []
    fits: list[Fitted] = []
    try:
        search.trials.expect(search.usual_trials(intervals))
        starts = search.starts() if start is None else [start]
        again = len(starts) if torque_offset is None else 0
        for number, item in enumerate(starts):
            search.trials.expect(search.expected_trials(starts=len(starts) - number, again=again, long=1, **searches))
            ended.append(search.minimise(item, SETTINGS.max_steps_from_start, "trf"))
        ended.sort(key=itemgetter(0))
        gain = math.nan
        if torque_offset is None:
            search, gain, ended = _choose_offset(search, ended)
        scaled = _refine(search, ended, fits, gain, searches)
        if not intervals:
            return fits[-1]
        return replace(fits[-1], scaled=search.nearest_deflections(scaled, *fits[-1].ends.T))
    except KeyboardInterrupt as stop:
        if not ended:
            raise
        so_far = fits[-1] if fits else evaluate_fit(search, min(ended, key=itemgetter(0))[1])
        raise FitStopped(stop, so_far) from stop


def _refine(
    search: FitProblem, ended: list[tuple[float, Array]], fits: list[Fitted], gain: float, searches: dict[str, int]
) -> Array:
    """Search again from the best of the ends, and from each lower cost found for an interval; return the last values.

    Adds the ends to `ended` and the fits to `fits`, whose intervals are set if `searches` has searches for them.
    """
    best, *others = ended
    scaled = best[1]
    for _ in range(PROFILE.max_restarts):
        search.trials.expect(search.expected_trials(long=1, **searches))
        cost, scaled = search.minimise(scaled, SETTINGS.max_steps, "trf")
        ended.append((cost, scaled))
        fits.append(replace(evaluate_fit(search, scaled), offset_gain=gain))
        better = widen_intervals(search, fits[-1], [(cost, scaled), *others]) if searches else None
        if better is None:
            break
        others.append((cost, scaled))
        scaled = better
    return scaled


def evaluate_fit(search: FitProblem, scaled: Array) -> Fitted:
    """Compute the fit at scaled values, with the intervals of the linearised model.

    Raises
    ------
    RunError
        A loop has no model there.
    """
    low, high = search.bounds
    parts = search.residuals_by_loop(scaled)
    failed = [loop.name for loop, part in zip(search.loops, parts, strict=True) if np.all(part == FAILED_RESIDUAL)]
    if failed:
        raise RunError(
            f"{' and '.join(failed)}: the model has no static equilibrium for any parameters near the design. Reduce "
            "the friction coefficients of the design (friction.*), or set its clearances closer to those of the drive"
        )
    # the residuals of the priors are last
    slopes = search.slopes(scaled, range(len(scaled)), central=True)[: sum(map(len, parts))]
    prior = MODEL_ERROR * search.prior_weights
    at_bound = ~((scaled > low + PROFILE.bound_distance) & (scaled < high - PROFILE.bound_distance))
    by_loop = np.split(slopes, np.cumsum([len(part) for part in parts])[:-1])
    weighted = [part / np.sqrt(len(part)) for part in parts]
    free = estimate_uncertainty(by_loop, weighted, ~at_bound, prior)
    every = estimate_uncertainty(by_loop, weighted, np.ones_like(at_bound), prior) if at_bound.any() else free
    each = (every if bound else free for bound in at_bound.tolist())
    half_width = np.array(
        [item.half_widths[index] + MODEL_ERROR * item.inverse[index, index] ** 0.5 for index, item in enumerate(each)]
    )
    ends = np.clip(scaled[:, np.newaxis] + np.outer(half_width, [-1.0, 1.0]), low[:, np.newaxis], high[:, np.newaxis])
    return Fitted(
        model=search.model,
        parameters=search.parameters,
        bench=search.bench,
        loops=search.loops,
        likeliest=scaled,
        scaled=scaled,
        residuals=tuple(parts),
        slopes=slopes,
        uncertainty=free,
        at_bound=at_bound,
        ends=ends,
        prior_share=prior**2 * np.diag(free.inverse),
        torque_offset=search.torque_offset,
    )


def _misfit(residuals: Sequence[Array], independent: Sequence[float]) -> float:
    """Compute n log(mean square) over the loops: twice the negative log-likelihood, except for a constant."""
    each = zip(independent, residuals, strict=True)
    return sum(count * float(np.log(np.mean(item**2))) for count, item in each)


def _choose_offset(
    search: FitProblem, ended: list[tuple[float, Array]]
) -> tuple[FitProblem, float, list[tuple[float, Array]]]:
    """Choose by the Bayesian information criterion whether the loops have zero offsets of torque.

    `search` is the problem with offsets, `ended` has cost and scaled values at the ends of its searches, the best
    first. Return the chosen problem, by how much the criterion is lower with offsets, and the ends of its searches.
    """
    without = replace(search, torque_offset=False)
    steps = SETTINGS.max_steps_from_start
    again = sorted((without.minimise(scaled, steps, "trf") for _, scaled in ended), key=itemgetter(0))
    parts, fixed = search.residuals_by_loop(ended[0][1]), without.residuals_by_loop(again[0][1])
    independent = [len(part) / autocorrelation_time(part) for part in parts]
    gain = _misfit(fixed, independent) - _misfit(parts, independent) - len(search.loops) * math.log(sum(independent))
    return (search, gain, ended) if gain > 0.0 else (without, gain, again)


def widen_intervals(search: FitProblem, fitted: Fitted, valleys: Sequence[tuple[float, Array]]) -> Array | None:
    """Set the ends of each interval by profile likelihood.

    Parameters
    ----------
    search
        The problem.
    fitted
        Its solution; `ends` is changed in place.
    valleys
        Cost and scaled values where searches ended, the solution first. An end is computed from each valley that
        explains the loops as well as the interval allows, and the farthest counts.

    Returns
    -------
    Array or None
        Scaled values with a lower cost than the solution, if a search reached some.
    """
    inverse, lowest_cost = fitted.uncertainty.inverse, valleys[0][0]
    is_distinct = [np.any(np.abs(item - fitted.likeliest) > fitted.uncertainty.errors) for _, item in valleys[1:]]
    valleys = [valleys[0], *(valley for valley, other in zip(valleys[1:], is_distinct, strict=True) if other)]
    unknown = np.all(fitted.ends == np.stack(search.bounds, axis=1), axis=1)
    open_values = np.flatnonzero(~(fitted.at_bound | unknown)[: len(search.parameters)])
    trials_before, done, usual = search.trials.done, 0, search.expected_trials(ends=1)
    for index in open_values:
        for side, end in enumerate(fitted.ends[index].tolist()):
            each = (search.trials.done - trials_before + usual) / (done + 1)
            search.trials.expect((2 * len(open_values) - done) * each + search.expected_trials(nearest=1))
            done += 1
            linear = end - fitted.likeliest[index]
            # rise of the sum of squares there, if it is a paraboloid
            allowed, reached = 0.5 * linear**2 / inverse[index, index], []
            for cost, middle in valleys:
                if (remaining := allowed - (cost - lowest_cost)) <= 0.0:
                    continue
                distance, better = _profile_distance(search, fitted, (cost, middle), int(index), side, remaining)
                if better is not None and better[0] < (1.0 - PROFILE.improvement_rtol) * lowest_cost:
                    return better[1]
                reached.append(float(middle[index]) + distance)
            fitted.ends[index, side] = max(reached) if side else min(reached)
    return None


def _profile_distance(
    search: FitProblem, fitted: Fitted, valley: tuple[float, Array], index: int, side: int, allowed: float
) -> tuple[float, tuple[float, Array] | None]:
    """Compute the signed distance of a value from a valley at which the profile cost has risen by what is allowed.

    Also return cost and scaled values of a point that is lower than the valley, if one was reached.
    """
    (cost, middle), inverse = valley, fitted.uncertainty.inverse
    direction = inverse[:, index] / inverse[index, index]
    limit = float(search.bounds[side][index] - middle[index])
    distance = (2.0 * allowed * float(inverse[index, index])) ** 0.5
    distance = min(distance, limit) if side else max(-distance, limit)
    rise_before = reached = rise = 0.0
    better = None
    for _ in range(PROFILE.max_doublings):
        start = np.clip(middle + distance * direction, *search.bounds)
        new_cost, trial = search.minimise(start, PROFILE.max_steps, "dogbox", fixed=index)
        if new_cost < cost:
            better = new_cost, trial
        rise = max(new_cost - cost, 0.0)
        if rise >= allowed or distance == limit:
            break
        reached, rise_before = distance, rise
        distance = min(2.0 * distance, limit) if side else max(2.0 * distance, limit)
    else:
        # nothing that was tried ends the interval
        distance = limit
    if rise > allowed:
        ratio = (allowed**0.5 - rise_before**0.5) / (rise**0.5 - rise_before**0.5)
        distance = reached + ratio * (distance - reached)
    return distance, better
