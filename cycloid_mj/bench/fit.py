"""Fit of a model to measured loops, with intervals by profile likelihood.

An interval ends where the residuals become too large even with all other values fitted again: profile likelihood
(Venzon and Moolgavkar, Appl. Statist. 37, 1988, 87-94). Where the cost has a long bent valley, as between friction of
contacts and constant friction, intervals of the linearised model would be far too narrow. Several valleys may explain
the loops equally well: an interval covers all that the searches reached.

A model has an error besides noise. An error of rms d, whatever its course, moves a value by at most d times the root of
its inverse curvature (Cauchy-Schwarz, for a linear model). Intervals are wider by that, with d = `MODEL_ERROR`. A
prior, such as a clearance with a tolerance in the design, counts as a residual of that size at one standard deviation.

Loops do not distinguish between values within such intervals. The values that are returned are those whose deflections
are nearest to the measured ones at the same torque (`FitProblem.fit_deflections`). They differ from the likeliest
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
from cycloid_mj.bench.overlay import Branches, LoopCondition, apply_values, interpolate_deflections, model_branches
from cycloid_mj.bench.parameters import Model, Parameter
from cycloid_mj.bench.search import (
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
    """Largest number of doublings of the distance of the fixed value; beyond, the interval is unbounded."""
    improvement_rtol: float = 1e-3
    """Relative improvement at which the fit restarts from a point that such a search reached."""
    max_restarts: int = 3
    """Largest number of restarts from such points."""
    bound_distance: float = 1e-3
    """Distance from a bound, of a scaled value, at which the value counts as at the bound."""


PROFILE = ProfileSettings()


@dataclass(frozen=True, eq=False)
class Fitted:
    """A model fitted to loops."""

    model: Model
    parameters: tuple[Parameter, ...]
    condition: LoopCondition
    loops: tuple[MeasuredLoop, ...]
    """The model before the fit, its parameters, and the loops with the condition under which they were measured."""
    likeliest: Array
    """Scaled values with the smallest residuals: parameters, then offsets of torque and deflection of each loop."""
    scaled: Array
    """Scaled values within the intervals whose deflections are nearest to the measured ones."""
    residuals: tuple[Array, ...]
    """Residuals of each loop's points at `likeliest`, as shares of its ranges."""
    slopes: Array
    """Derivatives of all residuals with respect to all scaled values at `likeliest`, shape (points, values)."""
    uncertainty: FitUncertainty
    """Uncertainty of the scaled values; 0 of those at a bound, which are no measurement."""
    at_bound: Mask
    """True for values at a bound, shape (values,)."""
    ends: Array
    """Ends of the 95 % interval of each scaled value (`uncertainty.CONFIDENCE`), shape (values, 2); one-sided at a
    bound."""
    prior_share: Array
    """Share of the knowledge of each value that is the prior's and not the loops', from 0 to 1, shape (values,)."""
    torque_offset: bool = True
    """Whether the loops have zero offsets of torque; else these are 0."""
    offset_gain: float = math.nan
    """Bayesian information criterion without such offsets minus that with them; it is positive if the loops support
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
        scaled_offsets = self.scaled[len(self.parameters) :].reshape(-1, 2)
        return scaled_offsets * np.array([offset_scales(loop) for loop in self.loops])

    @cached_property
    def branches(self) -> tuple[Branches, ...]:
        """Return torque [N m] and deflection [rad] of the model along each branch of each loop, offsets included."""
        branches_by_loop = []
        for loop, (torque, deflection) in zip(self.loops, self.offsets, strict=True):
            branches = model_branches(self.calibrated_model, self.condition, loop, float(torque))
            branches_by_loop.append([(loads + torque, turns + deflection) for loads, turns in branches])
        return tuple(branches_by_loop)

    @cached_property
    def turns(self) -> tuple[Array, ...]:
        """Deflection of the model at every measured point [rad]: that of its branch at the measured torque."""
        return tuple(
            interpolate_deflections(loop, branches) for loop, branches in zip(self.loops, self.branches, strict=True)
        )

    @property
    def independent(self) -> tuple[float, ...]:
        """Number of independent residuals of each loop (`autocorrelation_time`)."""
        return tuple(len(residual) / autocorrelation_time(residual) for residual in self.residuals)

    @property
    def free_values(self) -> int:
        """Number of values that were fitted, offsets included."""
        return len(self.scaled) - (0 if self.torque_offset else len(self.loops))

    def bayesian_criterion(self, independent_counts: Sequence[float]) -> float:
        """Compute the Bayesian information criterion [1] from the number of independent residuals of each loop.

        Models are comparable only by criteria with the same numbers. The numbers of `independent` differ between
        models, since a model without a relevant effect has correlated residuals.
        """
        return _deviance(self.residuals, independent_counts) + self.free_values * float(np.log(sum(independent_counts)))

    def akaike_criterion(self, independent: Sequence[float]) -> float:
        """Compute Akaike's information criterion by the same residuals."""
        return _deviance(self.residuals, independent) + 2.0 * self.free_values

    def values_at(self, scaled: Array) -> Array:
        """Compute the parameters' values from scaled ones."""
        return np.array([parameter.from_scale(item) for parameter, item in zip(self.parameters, scaled, strict=False)])

    def rms(self, loop_index: int) -> float:
        """Return the rms difference of a loop's deflection from the model's at the same torque [rad]."""
        loop = self.loops[loop_index]
        return rms((self.turns[loop_index] - loop.deflection)[loop.points_left_out :])

    def rms_without_offset(self, loop_index: int) -> float:
        """Return the rms difference of a loop [rad] without a torque offset, with the best deflection offset."""
        loop = self.loops[loop_index]
        turn = interpolate_deflections(loop, model_branches(self.calibrated_model, self.condition, loop))
        return float(np.std((turn - loop.deflection)[loop.points_left_out :]))


class FitStopped(KeyboardInterrupt):
    """Ctrl-C, or an equivalent signal, after at least one search ended: `fitted` is the best fit by then."""

    def __init__(self, stop: KeyboardInterrupt, fitted: Fitted) -> None:
        super().__init__(*stop.args)
        self.fitted = fitted


def fit_loops(
    model: Model,
    parameters: Sequence[Parameter],
    loops: Sequence[MeasuredLoop],
    condition: LoopCondition,
    trials: Trials | None = None,
    start: Array | None = None,
    intervals: bool = True,
    torque_offset: bool | None = None,
) -> Fitted:
    """Fit parameters of a model to measured loops by robust least squares; return values, intervals and residuals.

    Parameters
    ----------
    model, parameters, loops, condition
        The model, its parameters to fit, the measured loops, and their locked shaft and crank angle.
    trials
        Counter of evaluations; by default a new counter.
    start
        Start of a single search: v parameters and offsets over their scales, shape (v,); by default several starts.
    intervals
        Whether to compute intervals by profile likelihood, by further searches; else those of the linearised model.
    torque_offset
        Whether to fit an offset of the zero of torque for each loop; by default the Bayesian criterion decides.

    Raises
    ------
    RunError
        The model has no static equilibrium.
    FitStopped
        Ctrl-C was pressed. Its `fitted` has the best values so far, some with intervals of the linearised model.
    """
    problem = FitProblem(
        model, tuple(parameters), tuple(loops), condition, trials or Trials(), torque_offset is not False
    )
    interval_searches = {"ends": 2 * len(problem.parameters), "nearest": 1} if intervals else {}
    solutions: list[tuple[float, Array]] = []
    fits: list[Fitted] = []
    try:
        problem.trials.expect(problem.usual_trials(intervals))
        starts = problem.starts() if start is None else [start]
        repeat_count = len(starts) if torque_offset is None else 0
        for index, start_values in enumerate(starts):
            problem.trials.expect(
                problem.expected_trials(starts=len(starts) - index, again=repeat_count, long=1, **interval_searches)
            )
            solutions.append(problem.minimise(start_values, SETTINGS.max_steps_from_start, "trf"))
        solutions.sort(key=itemgetter(0))
        offset_gain = math.nan
        if torque_offset is None:
            problem, offset_gain, solutions = _choose_offset(problem, solutions)
        scaled_values = _continue_search(problem, solutions, fits, offset_gain, interval_searches)
        if not intervals:
            return fits[-1]
        return replace(fits[-1], scaled=problem.fit_deflections(scaled_values, *fits[-1].ends.T))
    except KeyboardInterrupt as stop:
        if not solutions:
            raise
        partial_fit = fits[-1] if fits else evaluate_fit(problem, min(solutions, key=itemgetter(0))[1])
        raise FitStopped(stop, partial_fit) from stop


def _continue_search(
    problem: FitProblem,
    solutions: list[tuple[float, Array]],
    fits: list[Fitted],
    offset_gain: float,
    interval_searches: dict[str, int],
) -> Array:
    """Continue the search from the best solution, and compute the intervals of the fitted values.

    The intervals are those of profile likelihood (`widen_intervals`). If the search for one of them reaches a lower
    cost, both are repeated from there, with at most `PROFILE.max_restarts` searches in all. Scaled values are
    parameters and offsets in units of their scales.

    Parameters
    ----------
    problem
        The least-squares problem.
    solutions
        Cost and scaled values of the searches so far, sorted by cost. Those of the new searches are appended in the
        order in which they end.
    fits
        List to which the fit of each new search is appended, with its intervals.
    offset_gain
        Advantage of fitting torque offsets: Bayesian information criterion without them minus that with them. It is
        stored in the fits.
    interval_searches
        Expected number of searches for the intervals, by the names in `TYPICAL_STEPS`, for the progress display. If the
        dictionary is empty, no intervals are searched for: they are those of the linearised model.

    Returns
    -------
    Array
        Scaled values of the best solution, shape (v,). The intervals refer to them, unless the last repetition reached
        a lower cost.
    """
    best_solution, *other_solutions = solutions
    scaled_values = best_solution[1]
    for _ in range(PROFILE.max_restarts):
        problem.trials.expect(problem.expected_trials(long=1, **interval_searches))
        cost, scaled_values = problem.minimise(scaled_values, SETTINGS.max_steps, "trf")
        solutions.append((cost, scaled_values))
        fits.append(replace(evaluate_fit(problem, scaled_values), offset_gain=offset_gain))
        better_values = (
            widen_intervals(problem, fits[-1], [(cost, scaled_values), *other_solutions]) if interval_searches else None
        )
        if better_values is None:
            break
        other_solutions.append((cost, scaled_values))
        scaled_values = better_values
    return scaled_values


def evaluate_fit(problem: FitProblem, scaled_values: Array) -> Fitted:
    """Return residuals, uncertainties and intervals of a fit to loops at fixed parameter values, without a search.

    `scaled_values` (v,) are those of the v parameters and offsets of the `problem`, in units of their scales. The
    intervals are those of the linearised model and include `MODEL_ERROR`. Raises RunError if the model has no static
    equilibrium for a loop at these values.
    """
    low, high = problem.bounds
    loop_residuals = problem.residuals_by_loop(scaled_values)
    failed_loops = [
        loop.name
        for loop, residuals in zip(problem.loops, loop_residuals, strict=True)
        if np.all(residuals == SETTINGS.failed_residual)
    ]
    if failed_loops:
        raise RunError(
            f"{' and '.join(failed_loops)}: the model has no static equilibrium for any parameters near those of the "
            "design. Reduce the friction coefficients (friction.*), or set the clearances (clearance.*) closer to "
            "those measured"
        )
    # the residuals of the priors are last
    slopes = problem.slopes(scaled_values, range(len(scaled_values)), central=True)[: sum(map(len, loop_residuals))]
    prior_slopes = MODEL_ERROR * problem.prior_weights
    is_at_bound = ~((scaled_values > low + PROFILE.bound_distance) & (scaled_values < high - PROFILE.bound_distance))
    slopes_by_loop = np.split(slopes, np.cumsum([len(residuals) for residuals in loop_residuals])[:-1])
    weighted_residuals = [residuals / np.sqrt(len(residuals)) for residuals in loop_residuals]
    uncertainty = estimate_uncertainty(slopes_by_loop, weighted_residuals, ~is_at_bound, prior_slopes)
    uncertainty_unbounded = (
        estimate_uncertainty(slopes_by_loop, weighted_residuals, np.ones_like(is_at_bound), prior_slopes)
        if is_at_bound.any()
        else uncertainty
    )
    estimates = (uncertainty_unbounded if bound else uncertainty for bound in is_at_bound.tolist())
    half_width = np.array(
        [
            estimate.half_widths[index] + MODEL_ERROR * estimate.inverse[index, index] ** 0.5
            for index, estimate in enumerate(estimates)
        ]
    )
    ends = np.clip(
        scaled_values[:, np.newaxis] + np.outer(half_width, [-1.0, 1.0]), low[:, np.newaxis], high[:, np.newaxis]
    )
    return Fitted(
        model=problem.model,
        parameters=problem.parameters,
        condition=problem.condition,
        loops=problem.loops,
        likeliest=scaled_values,
        scaled=scaled_values,
        residuals=tuple(loop_residuals),
        slopes=slopes,
        uncertainty=uncertainty,
        at_bound=is_at_bound,
        ends=ends,
        prior_share=prior_slopes**2 * np.diag(uncertainty.inverse),
        torque_offset=problem.torque_offset,
    )


def _deviance(residuals: Sequence[Array], independent_counts: Sequence[float]) -> float:
    """Compute the deviance of a fit: twice its negative log-likelihood, without a constant.

    It is the sum over all loops of n times the logarithm of the mean square of the loop's residuals [1]. `residuals`
    has the array of each loop, `independent_counts` the number n of its independent residuals.
    """
    return sum(
        independent_count * float(np.log(np.mean(loop_residuals**2)))
        for independent_count, loop_residuals in zip(independent_counts, residuals, strict=True)
    )


def _choose_offset(
    problem: FitProblem, solutions: list[tuple[float, Array]]
) -> tuple[FitProblem, float, list[tuple[float, Array]]]:
    """Decide by the Bayesian information criterion whether an offset of the zero of torque is fitted for each loop.

    `problem` is that with offsets. `solutions` are cost and scaled values (v,) of its searches, the best first; scaled
    values are v parameters and offsets in units of their scales.

    Returns
    -------
    tuple
        The chosen problem, the criterion without offsets minus that with them [1], and the solutions of the chosen
        problem.
    """
    problem_without_offset = replace(problem, torque_offset=False)
    max_steps = SETTINGS.max_steps_from_start
    solutions_without = sorted(
        (problem_without_offset.minimise(scaled_values, max_steps, "trf") for _, scaled_values in solutions),
        key=itemgetter(0),
    )
    residuals_with, residuals_without = (
        problem.residuals_by_loop(solutions[0][1]),
        problem_without_offset.residuals_by_loop(solutions_without[0][1]),
    )
    independent_counts = [
        len(loop_residuals) / autocorrelation_time(loop_residuals) for loop_residuals in residuals_with
    ]
    gain = (
        _deviance(residuals_without, independent_counts)
        - _deviance(residuals_with, independent_counts)
        - len(problem.loops) * math.log(sum(independent_counts))
    )
    return (problem, gain, solutions) if gain > 0.0 else (problem_without_offset, gain, solutions_without)


def widen_intervals(problem: FitProblem, fitted: Fitted, minima: Sequence[tuple[float, Array]]) -> Array | None:
    """Replace the ends of the intervals in `fitted` by those of profile likelihood (Venzon and Moolgavkar 1988).

    Values at a bound, and those on which no residual depends, keep their ends. The function returns early if a search
    reaches a lower cost than the solution. Scaled values are parameters and offsets in units of their scales.

    Parameters
    ----------
    problem
        The least-squares problem.
    fitted
        Its solution; `ends` is changed in place.
    minima
        Cost and scaled values of local minima at which searches ended, the solution first. An end is computed from each
        minimum whose cost is within the limit of the interval; the farthest of these ends is used.

    Returns
    -------
    Array or None
        Scaled values (v,) with a lower cost than the solution; None if no search reached any.
    """
    inverse_information, lowest_cost = fitted.uncertainty.inverse, minima[0][0]
    is_distinct = [np.any(np.abs(values - fitted.likeliest) > fitted.uncertainty.errors) for _, values in minima[1:]]
    minima = [minima[0], *(minimum for minimum, distinct in zip(minima[1:], is_distinct, strict=True) if distinct)]
    is_unknown = np.all(fitted.ends == np.stack(problem.bounds, axis=1), axis=1)
    indices = np.flatnonzero(~(fitted.at_bound | is_unknown)[: len(problem.parameters)])
    trials_before, ends_done, usual_trials = problem.trials.done, 0, problem.expected_trials(ends=1)
    for index in indices:
        for side, end in enumerate(fitted.ends[index].tolist()):
            trials_per_end = (problem.trials.done - trials_before + usual_trials) / (ends_done + 1)
            problem.trials.expect((2 * len(indices) - ends_done) * trials_per_end + problem.expected_trials(nearest=1))
            ends_done += 1
            linear_distance = end - fitted.likeliest[index]
            # rise of the sum of squares there, if it is a paraboloid
            allowed_rise, reached_distances = 0.5 * linear_distance**2 / inverse_information[index, index], []
            for cost, minimum_values in minima:
                if (remaining_rise := allowed_rise - (cost - lowest_cost)) <= 0.0:
                    continue
                distance, better_values = _profile_distance(
                    problem, fitted, (cost, minimum_values), int(index), side, remaining_rise
                )
                if better_values is not None and better_values[0] < (1.0 - PROFILE.improvement_rtol) * lowest_cost:
                    return better_values[1]
                reached_distances.append(float(minimum_values[index]) + distance)
            fitted.ends[index, side] = max(reached_distances) if side else min(reached_distances)
    return None


def _profile_distance(
    problem: FitProblem, fitted: Fitted, minimum: tuple[float, Array], index: int, side: int, allowed_rise: float
) -> tuple[float, tuple[float, Array] | None]:
    """Compute how far a fitted value can move from its value at a minimum until the cost rises by `allowed_rise`.

    The value is fixed at distances that double, and all others are fitted again each time. The distance is then
    interpolated. Values and distance are in units of the scales of parameters and offsets.

    Parameters
    ----------
    problem, fitted
        The least-squares problem and its solution.
    minimum
        Cost and scaled values of v parameters and offsets (v,) at a local minimum of the cost, from which distances are
        counted.
    index, side
        Index of the value; 0 for its lower end, 1 for its upper end.
    allowed_rise
        Rise of the cost at the end of the interval.

    Returns
    -------
    distance, better_values
        The signed distance. Cost and scaled values of a point with a lower cost than the minimum, if a search reached
        one, else None.
    """
    (cost, minimum_values), inverse_information = minimum, fitted.uncertainty.inverse
    direction = inverse_information[:, index] / inverse_information[index, index]
    limit = float(problem.bounds[side][index] - minimum_values[index])
    distance = (2.0 * allowed_rise * float(inverse_information[index, index])) ** 0.5
    distance = min(distance, limit) if side else max(-distance, limit)
    last_rise = last_distance = rise = 0.0
    better_values = None
    for _ in range(PROFILE.max_doublings):
        start = np.clip(minimum_values + distance * direction, *problem.bounds)
        new_cost, trial_values = problem.minimise(start, PROFILE.max_steps, "dogbox", fixed=index)
        if new_cost < cost:
            better_values = new_cost, trial_values
        rise = max(new_cost - cost, 0.0)
        if rise >= allowed_rise or distance == limit:
            break
        last_distance, last_rise = distance, rise
        distance = min(2.0 * distance, limit) if side else max(2.0 * distance, limit)
    else:
        # nothing that was tried ends the interval
        distance = limit
    if rise > allowed_rise:
        ratio = (allowed_rise**0.5 - last_rise**0.5) / (rise**0.5 - last_rise**0.5)
        distance = last_distance + ratio * (distance - last_distance)
    return distance, better_values
