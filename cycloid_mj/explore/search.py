"""The search for a best point: evolution strategies over real numbers, one combination of the other values at a time.

CMA-ES (Hansen 2016, The CMA Evolution Strategy: A Tutorial, arXiv 1604.00772) through the package ``cma``: it looks at
ranks alone, so that any point that keeps all checks and limits is better than any that does not, and of two that do not
the one that is less far off. Combinations compete: after each round the better half goes on. Then starts do.
"""

import math
from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, significant
from cycloid_mj.base.extras import extra
from cycloid_mj.explore.points import Value
from cycloid_mj.explore.problem import FEASIBLE, VIOLATION, Problem
from cycloid_mj.explore.row import PointResult

WIDTH, LOCAL_WIDTH = 0.25, 0.03
"""First standard deviation of a search, and of one about the best point, as shares of the ranges."""

SHARPNESS = 1e-6
"""Shares of the ranges below which a search has come to its end."""

LEAST_DIMENSIONS = 2
"""Of an evolution strategy; a search for one number has an idle second one."""

COMPETING = 0.5
"""Share of the evaluations, or of those left, for the rounds in which combinations compete, and then starts."""

MOST_REPEATS = 5
"""Searches about the best point, after the last one has come to its end: as long as they better it."""

NEED = "optimize", "optimize", "try points with `cycloid-mj sweep`"
"""Who needs the package ``cma``, of which extra, and what else can be done."""

WORST = 1e20
"""Score of points that break something, times their violation; no figure is so large."""

Point = tuple[Value, ...]
Evaluate = Callable[[Sequence[Point]], list[PointResult]]
Score = Callable[[PointResult], float]


class EvolutionSearch:
    """One evolution strategy at one combination of values."""

    def __init__(self, task: Problem, combination: Point, start: Array, width: float, seed: Sequence[int]) -> None:
        self.combination, self.best, self.used = combination, math.inf, 0
        self._ranges, self._done, self._strategy = task.ranges, False, None
        if task.ranges:
            self._strategy = _strategy(start, width, np.random.default_rng(list(seed)))
        self._asked: list[Any] = []

    @property
    def done(self) -> bool:
        """Whether it has come to its end."""
        return self._done

    def ask(self) -> list[Point]:
        """List the points of the next generation."""
        if self._strategy is None:
            self._asked = [np.zeros(0)]
        else:
            self._asked = self._strategy.ask()
        return [(*point_at(self._ranges, one), *self.combination) for one in self._asked]

    def tell(self, scores: Sequence[float]) -> None:
        """Take the scores of the points that were asked for, the least being the best."""
        self.used += len(scores)
        self.best = min(self.best, *scores)
        if self._strategy is not None:
            self._strategy.tell(self._asked, list(scores))
        self._done = self._strategy is None or bool(self._strategy.stop())


def _strategy(start: Array, width: float, generator: np.random.Generator) -> Any:
    cma = extra("cma", *NEED)
    idle = np.full(max(0, LEAST_DIMENSIONS - start.size), 0.5)
    options = {
        "bounds": [0.0, 1.0],
        "randn": lambda *shape: generator.standard_normal(shape),
        "seed": math.nan,  # it has its own generator
        "tolx": SHARPNESS,
        "verbose": -9,
    }
    return cma.CMAEvolutionStrategy(np.concatenate([start, idle]), width, options)


def point_at(ranges: Sequence[Any], shares: Array) -> tuple[float, ...]:
    """Compute the real numbers at shares of their ranges."""
    return tuple(
        significant(one.low + (one.high - one.low) * float(share)) for one, share in zip(ranges, shares, strict=False)
    )


def shares_of(ranges: Sequence[Any], values: Sequence[Value]) -> Array:
    """Compute the shares of their ranges at which real numbers lie; what is outside counts as at the bound."""
    pairs = zip(ranges, values, strict=False)
    return np.clip([(float(value) - one.low) / (one.high - one.low) for one, value in pairs], 0.0, 1.0)


def score(row: PointResult, figure: Callable[[PointResult], float]) -> float:
    """Compute a row's score: its figure, where it keeps all; else by how much it does not."""
    if row.values[FEASIBLE]:
        return figure(row)
    return WORST * (1.0 + float(row.values[VIOLATION]))


def searched(
    task: Problem,
    evaluate: Evaluate,
    figure: Callable[[PointResult], float],
    budget: int,
    starts: int,
    seed: Sequence[int],
    first: Point | None = None,
    width: float = WIDTH,
) -> None:
    """Search for the point with the least figure; what was evaluated is what `evaluate` keeps.

    Parameters
    ----------
    task
        What may change.
    evaluate
        Gives the rows of points.
    figure
        What a row is to be judged by, the less the better.
    budget
        Evaluations, about.
    starts
        Searches at the best combination: one where the rounds left it, others anywhere.
    seed
        Of all draws.
    first
        Where the first searches start; by default at the design's own values.
    width
        Their standard deviation.
    """
    here = first or task.start
    used = repeats = 0
    best: tuple[float, Point] | None = None

    def generation(searches: Sequence[EvolutionSearch]) -> None:
        nonlocal used, best
        asked = [one.ask() for one in searches]
        rows = evaluate([point for points in asked for point in points])
        used += len(rows)
        scores = [score(row, figure) for row in rows]
        place = 0
        for search, points in zip(searches, asked, strict=True):
            batch = scores[place : place + len(points)]
            place += len(points)
            search.tell(batch)
            least = min(range(len(batch)), key=batch.__getitem__)
            if best is None or batch[least] < best[0]:
                best = batch[least], points[least]

    def run(searches: Sequence[EvolutionSearch], until: int, each: float = math.inf) -> None:
        begun = {id(search): search.used for search in searches}
        while live := [search for search in searches if not search.done and search.used - begun[id(search)] < each]:
            generation(live)
            if used >= until:
                break

    combinations = list(product(*(choice.values for choice in task.choices)))
    at = shares_of(task.ranges, here)
    live = [
        EvolutionSearch(task, combination, at, width, [*seed, place, 0])
        for place, combination in enumerate(combinations)
    ]
    rounds = math.ceil(math.log2(len(live))) if len(live) > 1 else 0
    for number in range(rounds):
        run(live, round(COMPETING * budget * (number + 1) / rounds), COMPETING * budget / rounds / len(live))
        live = sorted(live, key=lambda one: one.best)[: -(-len(live) // 2)]
    if not task.ranges:
        run(live, budget)
        return
    anywhere = np.random.default_rng([*seed, len(combinations)]).random((max(starts, 1), len(task.ranges)))
    chosen = live[0].combination
    others = [EvolutionSearch(task, chosen, x, WIDTH, [*seed, 0, 1 + i]) for i, x in enumerate(anywhere[: starts - 1])]
    rivals = [live[0], *others]
    if others:
        run(rivals, used + round(COMPETING * (budget - used)))
    run([min(rivals, key=lambda one: one.best)], budget)
    while best is not None and used < budget and repeats < MOST_REPEATS:
        repeats += 1
        last, before = best[1], best[0]
        near = shares_of(task.ranges, last)
        run([EvolutionSearch(task, last[len(task.ranges) :], near, LOCAL_WIDTH, [*seed, 0, starts + repeats])], budget)
        if best[0] >= before:
            break
