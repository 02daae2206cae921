"""The least-squares problem of a calibration: residuals of measured loops by scaled values, and their minimisation.

Each loop has an offset of its own in torque and in deflection, which does not belong to the drive. The unknowns are a
vector of "scaled values", shape (v,) with v = parameters + 2 loops: first the parameters in their order, then torque
offset and deflection offset of each loop. All are scaled so that a change of 1 matters: parameters by
`Parameter.to_scale`, offsets by `offset_scales`.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from operator import itemgetter
from typing import Any, Literal

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.engine import Progress, silent
from cycloid_mj.base.errors import RunError
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.overlay import Branches, LoopCondition, branch_distances, interpolate_deflections, model_branches
from cycloid_mj.bench.parameters import Model, Parameter

MODEL_ERROR = 0.03
"""Assumed error of the model, rms, as a share of a loop's ranges (heuristic). All intervals include it: the fitted
models miss the measured loops of printed drives by 2 to 7 %."""


@dataclass(frozen=True)
class LeastSquaresSettings:
    """Settings of the robust least squares: trust region with soft L1 loss (`scipy.optimize.least_squares`)."""

    failed_residual: float = 1.0
    """Residual of every point where the model has no static equilibrium."""
    outlier: float = 0.03
    """Residual, as a share of a loop's range, from which a point counts less (scale of the soft L1 loss)."""
    difference_step: float = 0.05
    """Step of the finite differences, of scaled values."""
    max_steps_from_start: int = 12
    """Largest number of steps from each of the starts."""
    max_steps: int = 60
    """Largest number of steps of the search that continues from the best of them."""
    fixed_width: float = 1e-6
    """Distance between both bounds of a scaled value below which it is fixed."""
    offset_share: float = 0.02
    """Offset of a loop that matters, as a share of its ranges: a scaled value of 1."""
    deflection_rtol: float = 1e-3
    """Relative gain in squares at which the search for the nearest deflections stops: half as much of their rms."""


SETTINGS = LeastSquaresSettings()

START_FACTORS: tuple[dict[str, float], ...] = (
    {},
    {"friction": 2.5, "drag": 0.5},
    {"hysteresis": 3.0, "hysteresis_travel": 3.0},
    {"hysteresis": 3.0, "drag": 0.5},
)
"""Starts of the searches, as factors on what a loop suggests. Constant friction, friction of the contacts and
hysteresis widen a loop nearly alike, so that the cost has a long valley in which a single search stops."""

TYPICAL_STEPS = {"starts": 8, "again": 3, "long": 14, "ends": 9, "nearest": 14}
"""Measured number of steps of the searches of a fit, for the progress bar: from each start, again without an offset of
torque, the search that continues, all searches for an end of an interval, and that for the nearest deflections."""


class Trials:
    """Counts the evaluations of a fit, and reports them to a progress with the number expected in all."""

    def __init__(self, progress: Progress = silent) -> None:
        self.done, self.later, self._total, self._progress = 0, 0.0, 0.0, progress

    def expect(self, evaluations: float) -> None:
        """Set how many evaluations of this fit follow; the `later` evaluations, of other fits, are added."""
        self._total = self.done + evaluations + self.later

    def __call__(self) -> None:
        """Count one evaluation. None is reported as the last, since a search does not know."""
        self.done += 1
        self._progress(self.done, max(round(self._total), self.done + 1))


@dataclass(frozen=True, eq=False)
class FitProblem:
    """Residuals of a model and their slopes as functions of the scaled values.

    These are a vector (v,): the scaled parameters, then the scaled torque and deflection offsets of each loop.
    """

    model: Model
    parameters: tuple[Parameter, ...]
    loops: tuple[MeasuredLoop, ...]
    condition: LoopCondition
    """The model, its fitted parameters, the measured loops, and the condition under which they were measured."""
    trials: Trials
    """Counter of the model's evaluations."""
    torque_offset: bool = True
    """Whether each loop has a zero offset of torque that is fitted; else all of them are 0."""

    @cached_property
    def prior_weights(self) -> Array:
        """1 over the standard deviation of the prior of each scaled value; 0 without a prior."""
        deviations = [parameter.scaled_deviation for parameter in self.parameters]
        return 1.0 / np.array([*deviations, *([np.inf] * (2 * len(self.loops)))])

    @cached_property
    def prior_means(self) -> Array:
        """Mean of the prior of each scaled value."""
        start_values = [parameter.to_scale(parameter.start) for parameter in self.parameters]
        return np.array([*start_values, *([0.0] * (2 * len(self.loops)))])

    @cached_property
    def point_weights(self) -> Array:
        """1 over the number of points in the loop of each residual; 1 for residuals of priors, shape of `residuals`."""
        lengths = [len(loop.torque) - loop.points_left_out for loop in self.loops]
        weights = [np.full(length, 1.0 / length) for length in lengths]
        return np.concatenate([*weights, np.ones(np.count_nonzero(self.prior_weights))])

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the scaled values, shape (v,) each; equal where a value is fixed."""
        offset_bounds = np.tile([np.inf if self.torque_offset else 0.0, np.inf], len(self.loops))
        lower_values = [parameter.to_scale(parameter.lower) for parameter in self.parameters]
        upper_values = [parameter.to_scale(parameter.upper) for parameter in self.parameters]
        return np.concatenate([lower_values, -offset_bounds]), np.concatenate([upper_values, offset_bounds])

    def expected_trials(self, **searches: int) -> float:
        """Estimate the evaluations of some searches, given the number of each kind of `TYPICAL_STEPS`."""
        trials_per_step = 1 + 2 * (len(self.parameters) + 2 * len(self.loops))
        return float(
            trials_per_step * sum(TYPICAL_STEPS[search_kind] * count for search_kind, count in searches.items())
        )

    @cached_property
    def start_factors(self) -> list[dict[str, float]]:
        """Those of `START_FACTORS` whose values are all fitted."""
        keys = {parameter.key for parameter in self.parameters}
        return [factors for factors in START_FACTORS if set(factors) <= keys]

    def usual_trials(self, intervals: bool) -> float:
        """Estimate the evaluations of a fit from all starts, with or without intervals."""
        start_count, end_count = len(self.start_factors), 2 * len(self.parameters)
        searches = {"ends": end_count, "nearest": 1} if intervals else {}
        return self.expected_trials(starts=start_count, again=start_count, long=1, **searches)

    @cached_property
    def _cached_models(self) -> Callable[[tuple[float, ...]], Model]:
        """Return a cached function from the values of the first k parameters to the model with these values.

        The values are in units of their scales, k is their number; other parameters are as in the attribute `model`.
        """

        @lru_cache(maxsize=8 * len(self.parameters))
        def with_leading_values(scaled_values: tuple[float, ...]) -> Model:
            if not scaled_values:
                return self.model
            parameter = self.parameters[len(scaled_values) - 1]
            return parameter.apply(with_leading_values(scaled_values[:-1]), parameter.from_scale(scaled_values[-1]))

        return with_leading_values

    @cached_property
    def _cached_branches(self) -> Callable[[tuple[float, ...], int, float], Branches | None]:
        """Return a cached function that computes torque [N m] and rotation [rad] of the model along branches of a loop.

        Its arguments are the parameters in units of their scales, the index of the loop, and the loop's offset of
        torque [N m]. It returns None where the model has no static equilibrium.
        """

        @lru_cache(maxsize=4 * len(self.loops))
        def branches(scaled_values: tuple[float, ...], loop: int, torque_offset: float) -> Branches | None:
            try:
                return model_branches(
                    self._cached_models(scaled_values), self.condition, self.loops[loop], torque_offset
                )
            except RunError:
                return None

        return branches

    def residuals_by_loop(self, scaled: Array) -> list[Array]:
        """Compute the signed distances [1] of the points from the model's curves, an array (points,) for each loop.

        `scaled` are v parameters and offsets in units of their scales, shape (v,). Torque and deflection are divided by
        the loop's ranges. Points that only lead from rest to the loop are omitted. Without a static equilibrium of the
        model, residuals are `SETTINGS.failed_residual`.
        """
        residuals = []
        for loop, branches, (torque_offset, deflection_offset) in self._modelled_loops(scaled):
            failed_residuals = np.full(len(loop.torque) - loop.points_left_out, SETTINGS.failed_residual)
            residuals.append(
                failed_residuals
                if branches is None
                else branch_distances(loop, branches, torque_offset, deflection_offset)
            )
        return residuals

    def _modelled_loops(self, scaled: Array) -> Iterator[tuple[MeasuredLoop, Branches | None, tuple[float, float]]]:
        """Yield each measured loop, the model's curves for it, and its offsets of torque [N m] and deflection [rad].

        The curves are torque and rotation of the model along each branch between two reversals; None if the model has
        no static equilibrium. `scaled` are v parameters and offsets in units of their scales, shape (v,).
        """
        parameter_count = len(self.parameters)
        values = tuple(scaled[:parameter_count].tolist())
        for index, loop in enumerate(self.loops):
            torque_offset, deflection_offset = (
                offset_scales(loop) * scaled[parameter_count + 2 * index : parameter_count + 2 * index + 2]
            ).tolist()
            yield loop, self._cached_branches(values, index, torque_offset), (torque_offset, deflection_offset)

    def residuals(self, scaled: Array) -> Array:
        """Compute the residuals [1] of all loops' points, then those of the priors, shape (points + priors,).

        `scaled` are v parameters and offsets in units of their scales, shape (v,). Residuals of a loop are divided by
        the root of their number, so that all loops have the same weight. A value that differs from its prior by one
        standard deviation contributes as much to the sum of squares as a loop with an rms residual of `MODEL_ERROR`.
        """
        self.trials()
        prior_residuals = MODEL_ERROR * (self.prior_weights * (scaled - self.prior_means))[self.prior_weights > 0.0]
        return np.concatenate(
            [
                *(loop_residuals / np.sqrt(len(loop_residuals)) for loop_residuals in self.residuals_by_loop(scaled)),
                prior_residuals,
            ]
        )

    def deflection_errors(self, scaled_values: Array) -> Array:
        """Compute the deflection errors of the model, relative to the range of deflection [1], at each measured torque.

        `scaled_values` are v parameters and offsets in units of their scales, shape (v,). The errors are concatenated,
        shape (points,), without the points that only lead from rest to a loop. Those of a loop are divided by the
        square root of their number, so that all loops have the same weight in the sum of squares.
        """
        self.trials()
        errors = []
        for loop, branches, (torque_offset, deflection_offset) in self._modelled_loops(scaled_values):
            if branches is None:
                error = np.full(len(loop.torque), SETTINGS.failed_residual * loop.height)
            else:
                shifted_branches = [(torque + torque_offset, deflection) for torque, deflection in branches]
                error = interpolate_deflections(loop, shifted_branches) - loop.deflection + deflection_offset
            errors.append(error[loop.points_left_out :] / (loop.height * np.sqrt(len(error) - loop.points_left_out)))
        return np.concatenate(errors)

    def slopes(
        self,
        scaled: Array,
        indices: Sequence[int],
        central: bool = False,
        limits: tuple[Array, Array] | None = None,
        residuals: Callable[[Array], Array] | None = None,
    ) -> Array:
        """Compute the derivatives of the residuals with respect to some scaled values, by finite differences.

        Parameters
        ----------
        scaled
            The v parameters and offsets in units of their scales, shape (v,).
        indices
            Indices of the values by which to differentiate.
        central
            Whether differences are central, not forward.
        limits
            Bounds within which the steps stay; by default those of the problem.
        residuals
            Function to differentiate, from scaled values (v,) to a vector (r,); by default `FitProblem.residuals`.

        Returns
        -------
        Array
            Shape (r, len(indices)).
        """
        low, high = limits or self.bounds
        compute_residuals, columns = residuals or self.residuals, []
        for index in indices:
            step_ends = np.stack([scaled, scaled])
            step_ends[1, index] += SETTINGS.difference_step
            step_ends[0, index] -= SETTINGS.difference_step if central else 0.0
            if step_ends[1, index] > high[index]:
                step_ends[:, index] = scaled[index] - SETTINGS.difference_step, scaled[index]
            step_ends[:, index] = np.clip(step_ends[:, index], low[index], high[index])
            step_width = step_ends[1, index] - step_ends[0, index]
            residual_change = compute_residuals(step_ends[1]) - compute_residuals(step_ends[0])
            columns.append(residual_change / step_width if step_width else np.zeros_like(residual_change))
        return np.stack(columns, axis=1)

    def starts(self) -> list[Array]:
        """Return the initial values of each search: v parameters and offsets in units of their scales, (v,) each.

        There is a search for each dict of `start_factors`. It starts from the values `Parameter.start` times these
        factors; the offsets start at the torque and deflection in the middle of each loop's ranges. If stiffness or
        play is fitted, several further factors are tried for them, and those with the smallest residuals are used.
        """
        keys = {parameter.key for parameter in self.parameters}
        centres = [0.5 * float(loop.deflection.max() + loop.deflection.min()) for loop in self.loops]
        offset_starts = [
            [0.5 * sum(loop.ends), centre] / offset_scales(loop)
            for loop, centre in zip(self.loops, centres, strict=True)
        ]
        play_factors = (1.0, 2.0, 0.5, 4.0) if {"mesh_play", "play", "output_play"} & keys else (1.0,)
        stiffness_factors = (
            (1.0, 0.3, 0.1, 0.03, 0.01, 3.0) if {"tooth_stiffness", "structure_stiffness"} & keys else (1.0,)
        )
        starts = []
        for start_factors in self.start_factors:
            candidates = []
            for play_factor, stiffness_factor in product(play_factors, stiffness_factors):
                factors = {
                    "mesh_play": play_factor,
                    "output_play": play_factor,
                    "play": play_factor,
                    "tooth_stiffness": stiffness_factor,
                }
                factors |= {"structure_stiffness": stiffness_factor} | start_factors
                values = [
                    min(max(item.start * factors.get(item.key, 1.0), item.lower), item.upper)
                    for item in self.parameters
                ]
                scaled_start = [item.to_scale(value) for item, value in zip(self.parameters, values, strict=True)]
                scaled_values = np.concatenate([scaled_start, *offset_starts])
                self.trials()
                cost = sum(float(np.mean(np.abs(residuals))) for residuals in self.residuals_by_loop(scaled_values))
                candidates.append((cost, scaled_values))
            starts.append(min(candidates, key=itemgetter(0))[1])
        return starts

    def minimise(
        self, start: Array, max_steps: int, method: Literal["trf", "dogbox"], fixed: int | None = None
    ) -> tuple[float, Array]:
        """Minimise the robust sum of squares of the residuals (soft L1 loss); return the cost and the scaled values.

        Values whose bounds coincide keep their start.

        Parameters
        ----------
        start
            The v scaled parameters and offsets, shape (v,); clipped to the bounds.
        max_steps, method
            Largest number of steps, and trust-region method of `scipy.optimize.least_squares`.
        fixed
            Index of a value that keeps its start.

        Returns
        -------
        tuple
            Cost, and scaled values (v,).
        """
        from scipy.optimize import least_squares

        low, high = self.bounds
        start = np.clip(start, low, high)
        free_indices = [index for index in np.flatnonzero(high - low > SETTINGS.fixed_width).tolist() if index != fixed]
        insert_free = _make_filler(start, free_indices)

        def residuals(free_values: Array) -> Array:
            return self.residuals(insert_free(free_values))

        def slopes(free_values: Array) -> Array:
            return self.slopes(insert_free(free_values), free_indices)

        def soft_l1_loss(squares: Array) -> Array:
            """Compute the soft L1 loss and its first and second derivative by the squares of residuals, shape (3, n).

            `squares` are the n squared residuals, shape (n,). The threshold applies to residuals without the weight of
            their loop.
            """
            root = np.sqrt(1.0 + squares / self.point_weights)
            weights = self.point_weights
            return np.stack([2.0 * weights * (root - 1.0), 1.0 / root, -0.5 / (weights * root**3)])

        loss: Any = soft_l1_loss  # the stubs ask for a protocol with a name of theirs
        solution = least_squares(
            residuals,
            np.clip(start, low + 1e-9, high - 1e-9)[free_indices],
            jac=slopes,
            bounds=(low[free_indices], high[free_indices]),
            method=method,
            loss=loss,
            f_scale=SETTINGS.outlier,
            xtol=1e-6,
            ftol=1e-6,
            gtol=1e-9,
            max_nfev=max_steps,
        )
        return float(solution.cost), np.clip(insert_free(solution.x), low, high)

    def fit_deflections(self, start: Array, low: Array, high: Array) -> Array:
        """Fit the scaled parameters to the measured deflections, within their 95 % intervals; return them, (v,).

        The rms difference between measured and computed deflections is minimised. `start` are the initial scaled
        parameters, `low` and `high` the ends of their 95 % intervals, shape (v,) each. Parameters on which the
        deflections hardly depend remain near their start, because changes are penalised: a change by a quarter of the
        interval, about a standard deviation, contributes as much as a loop with an rms residual of `MODEL_ERROR`.
        """
        from scipy.optimize import least_squares

        free_indices = np.flatnonzero(high - low > SETTINGS.fixed_width)
        weights = np.zeros_like(start)
        weights[free_indices] = MODEL_ERROR * (4.0 / (high - low)[free_indices])
        insert_free = _make_filler(np.clip(start, low, high), free_indices)

        def residuals(scaled_values: Array) -> Array:
            return np.concatenate([self.deflection_errors(scaled_values), weights * (scaled_values - start)])

        def slopes(values: Array) -> Array:
            return self.slopes(insert_free(values), free_indices.tolist(), limits=(low, high), residuals=residuals)

        def filled_residuals(values: Array) -> Array:
            return residuals(insert_free(values))

        solution = least_squares(
            filled_residuals,
            np.clip(start, low + 1e-9, high - 1e-9)[free_indices],
            jac=slopes,
            bounds=(low[free_indices], high[free_indices]),
            xtol=SETTINGS.deflection_rtol,
            ftol=SETTINGS.deflection_rtol,
            max_nfev=SETTINGS.max_steps,
        )
        return insert_free(solution.x)


def _make_filler(start: Array, indices: Sequence[int] | Integers) -> Callable[[Array], Array]:
    """Return a function from values at some `indices` to a copy of `start` with these values inserted."""

    def fill(values: Array) -> Array:
        scaled_values = start.copy()
        scaled_values[indices] = values
        return scaled_values

    return fill


def offset_scales(loop: MeasuredLoop) -> Array:
    """Compute the scales of a loop's offsets in torque [N m] and deflection [rad], as shares of its ranges, (2,)."""
    return SETTINGS.offset_share * np.array([float(np.ptp(loop.torque)), loop.height])
