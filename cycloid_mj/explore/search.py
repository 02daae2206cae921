"""Search for a best point: CMA-ES over real numbers, with successive halving over combinations of the other values.

CMA-ES (Hansen 2016, The CMA Evolution Strategy: A Tutorial, arXiv 1604.00772) comes from the package ``cma``. It uses
ranks only: every feasible point ranks before every infeasible one, and those rank by their violation. Combinations, and
then starts, compete by successive halving (Jamieson and Talwalkar 2016, AISTATS): after each round the better half
continues.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, significant
from cycloid_mj.base.extras import import_extra
from cycloid_mj.explore.points import Value
from cycloid_mj.explore.problem import FEASIBLE, VIOLATION, Problem, SearchRange
from cycloid_mj.explore.row import PointResult


@dataclass(frozen=True)
class CmaSettings:
    """Settings of the searches; lengths are relative to the ranges."""

    initial_sigma: float = 0.25
    local_sigma: float = 0.03
    """First standard deviation of a search, and of a restart about the best point (Hansen recommends 0.2 to 0.5 of a
    range for the first)."""
    tolerance: float = 1e-6
    """Step length at which a search ends (``tolx``): far below the accuracy of any part."""
    min_dimensions: int = 2
    """Smallest number of dimensions of a search: CMA-ES requires two. Over a single number the second one is idle."""
    selection_share: float = 0.5
    """Share of the evaluations for the rounds of combinations, and of those left for the rounds of starts."""
    max_restarts: int = 5
    """Restarts about the best point at most, while they improve it."""


CMA = CmaSettings()

REQUIREMENT = "optimize", "optimize", "try points with `cycloid-mj sweep`"
"""Command that needs the package ``cma``, its extra, and the alternative."""


INFEASIBLE_SCORE = 1e20
"""Lowest score of an infeasible point: no figure is as large, so that every feasible point ranks before it."""

Point = tuple[Value, ...]
Evaluate = Callable[[Sequence[Point]], list[PointResult]]
Cost = Callable[[PointResult], float]


class EvolutionSearch:
    """Evolution strategy over the ranges, at one combination of the choices.

    Attributes
    ----------
    combination
        Values of the choices.
    best
        Lowest score so far.
    used
        Evaluations so far.
    done
        Whether the search has converged.
    """

    def __init__(
        self, ranges: Sequence[SearchRange], combination: Point, start: Array, sigma: float, seed: Sequence[int]
    ) -> None:
        self.combination, self.best, self.used, self.done = combination, math.inf, 0, False
        self._ranges = ranges
        self._strategy = _new_strategy(start, sigma, np.random.default_rng(list(seed))) if ranges else None
        self._generation: list[Any] = []

    def ask(self) -> list[Point]:
        """Return the points of the next generation."""
        self._generation = [np.zeros(0)] if self._strategy is None else self._strategy.ask()
        return [(*values_in_ranges(self._ranges, positions), *self.combination) for positions in self._generation]

    def tell(self, scores: Sequence[float]) -> None:
        """Record the scores of the points of `ask`, the lowest being the best."""
        self.used += len(scores)
        self.best = min(self.best, *scores)
        if self._strategy is not None:
            self._strategy.tell(self._generation, list(scores))
        self.done = self._strategy is None or bool(self._strategy.stop())


def _new_strategy(start: Array, sigma: float, generator: np.random.Generator) -> Any:
    """Create a CMA-ES strategy of the package ``cma`` in the unit cube, with random numbers from `generator`.

    `start` is the first mean, shape (ranges,), and `sigma` the first standard deviation, relative to the ranges. A
    single range is padded to `CmaSettings.min_dimensions` by an idle coordinate.
    """
    cma = import_extra("cma", *REQUIREMENT)
    padding = np.full(max(0, CMA.min_dimensions - start.size), 0.5)
    options = {
        "bounds": [0.0, 1.0],
        "randn": lambda *shape: generator.standard_normal(shape),
        "seed": math.nan,  # the generator is the strategy's own
        "tolx": CMA.tolerance,
        "verbose": -9,
    }
    return cma.CMAEvolutionStrategy(np.concatenate([start, padding]), sigma, options)


def values_in_ranges(ranges: Sequence[SearchRange], positions: Array) -> tuple[float, ...]:
    """Compute the real numbers at relative positions (0 to 1) in their ranges; further positions are ignored."""
    return tuple(
        significant(key_range.low + (key_range.high - key_range.low) * float(position))
        for key_range, position in zip(ranges, positions, strict=False)
    )


def positions_in_ranges(ranges: Sequence[SearchRange], values: Sequence[Value]) -> Array:
    """Compute the relative positions [1] of real numbers in their ranges, clipped to 0 to 1, shape (ranges,).

    `values` are those of a point: the real numbers come first, and the values of the choices after them are ignored.
    """
    ranges_and_values = zip(ranges, values, strict=False)
    positions = [
        (float(value) - key_range.low) / (key_range.high - key_range.low) for key_range, value in ranges_and_values
    ]
    return np.clip(positions, 0.0, 1.0)


def rank_score(row: PointResult, cost: Cost) -> float:
    """Compute the score of a row: its cost if it is feasible, else `INFEASIBLE_SCORE` or more, by its violation."""
    if row.values[FEASIBLE]:
        return cost(row)
    return INFEASIBLE_SCORE * (1.0 + float(row.values[VIOLATION]))


def search_minimum(
    task: Problem,
    evaluate: Evaluate,
    cost: Cost,
    budget: int,
    starts: int,
    seed: Sequence[int],
    start_point: Point | None = None,
    sigma: float = CMA.initial_sigma,
) -> None:
    """Search for the point of lowest cost by CMA-ES; successive halving selects the combination of discrete values.

    A combination has one value of each key with a list of values. At the selected combination, the ranges of real
    numbers are searched from several starts, then again from the best point. Nothing is returned, because `evaluate`
    records the results.

    Parameters
    ----------
    evaluate
        Evaluates and records points, and returns their results in order.
    cost
        Function from the result of a feasible point to its cost.
    budget
        Approximate number of evaluations.
    starts
        Number of searches at the selected combination: that by which it was selected, and others from random starts.
    seed
        Random seed.
    start_point
        Start point of the first search of each combination; by default the values of the design.
    sigma
        Initial standard deviation of these first searches, relative to the ranges.
    """
    search_run = _SearchRun(task, evaluate, cost, budget, seed)
    remaining_searches = search_run.select_combination(start_point or task.start, sigma)
    if not task.ranges:
        search_run.advance(remaining_searches, budget)
        return
    search_run.select_start(remaining_searches[0], starts)
    search_run.restart_locally(starts)


class _SearchRun:
    """The generations of all searches of one call of `search_minimum`, and the best point so far."""

    def __init__(self, task: Problem, evaluate: Evaluate, cost: Cost, budget: int, seed: Sequence[int]) -> None:
        self._task, self._evaluate, self._cost, self._budget, self._seed = task, evaluate, cost, budget, seed
        self._used = 0
        self._best: tuple[float, Point] | None = None

    def _new_search(self, combination: Point, start: Array, sigma: float, stream: Sequence[int]) -> EvolutionSearch:
        return EvolutionSearch(self._task.ranges, combination, start, sigma, [*self._seed, *stream])

    def advance(self, searches: Sequence[EvolutionSearch], until: int, per_search: float = math.inf) -> None:
        """Run generations of the searches until `until` points are evaluated in total, or `per_search` by each search.

        The searches are changed in place. Converged searches stop earlier; a generation that has begun is completed.
        """
        evaluations_before = {id(search): search.used for search in searches}
        while active_searches := [
            search
            for search in searches
            if not search.done and search.used - evaluations_before[id(search)] < per_search
        ]:
            self._evaluate_generation(active_searches)
            if self._used >= until:
                break

    def _evaluate_generation(self, searches: Sequence[EvolutionSearch]) -> None:
        """Evaluate the next generation of points of all CMA-ES searches, and update the searches and the best point."""
        generations = [search.ask() for search in searches]
        rows = self._evaluate([point for points in generations for point in points])
        self._used += len(rows)
        scores = iter([rank_score(row, self._cost) for row in rows])
        for search, points in zip(searches, generations, strict=True):
            batch_scores = [next(scores) for _ in points]
            search.tell(batch_scores)
            best_index = min(range(len(batch_scores)), key=batch_scores.__getitem__)
            if self._best is None or batch_scores[best_index] < self._best[0]:
                self._best = batch_scores[best_index], points[best_index]

    def select_combination(self, start_point: Point, sigma: float) -> list[EvolutionSearch]:
        """Select a combination of discrete values by successive halving; return a list with its search.

        After each round, the worse half of the searches is dropped. `start_point` is the start point of all searches,
        `sigma` their first standard deviation, relative to the ranges. A single combination is returned without any
        evaluation.
        """
        start = positions_in_ranges(self._task.ranges, start_point)
        remaining_searches = [
            self._new_search(combination, start, sigma, [round_number, 0])
            for round_number, combination in enumerate(self._combinations)
        ]
        round_count = math.ceil(math.log2(len(remaining_searches))) if len(remaining_searches) > 1 else 0
        selection_budget = CMA.selection_share * self._budget
        for round_number in range(round_count):
            self.advance(
                remaining_searches,
                round(selection_budget * (round_number + 1) / round_count),
                selection_budget / round_count / len(remaining_searches),
            )
            remaining_searches = sorted(remaining_searches, key=lambda search: search.best)[
                : -(-len(remaining_searches) // 2)
            ]
        return remaining_searches

    @property
    def _combinations(self) -> list[Point]:
        return list(product(*(choice.values for choice in self._task.choices)))

    def select_start(self, search: EvolutionSearch, starts: int) -> None:
        """Continue a search together with searches from random starts, then continue only the best of them.

        All searches together use `CmaSettings.selection_share` of the remaining evaluations, the best search uses the
        rest. `starts` is the number of searches.
        """
        shape = max(starts, 1), len(self._task.ranges)
        random_starts = np.random.default_rng([*self._seed, len(self._combinations)]).random(shape)
        random_searches = [
            self._new_search(search.combination, start, CMA.initial_sigma, [0, 1 + number])
            for number, start in enumerate(random_starts[: starts - 1])
        ]
        candidates = [search, *random_searches]
        if random_searches:
            self.advance(candidates, self._used + round(CMA.selection_share * (self._budget - self._used)))
        self.advance([min(candidates, key=lambda candidate: candidate.best)], self._budget)

    def restart_locally(self, starts: int) -> None:
        """Restart CMA-ES at the best point with a small standard deviation, until a restart does not improve the point.

        Restarts also end with the budget of evaluations. `starts` is the number of searches before; it makes the random
        seeds of the restarts differ from theirs.
        """
        restart_count = 0
        while self._best is not None and self._used < self._budget and restart_count < CMA.max_restarts:
            restart_count += 1
            best_cost, point = self._best
            ranges = self._task.ranges
            search = self._new_search(
                point[len(ranges) :],
                positions_in_ranges(ranges, point),
                CMA.local_sigma,
                [0, starts + restart_count],
            )
            self.advance([search], self._budget)
            if self._best[0] >= best_cost:
                break
