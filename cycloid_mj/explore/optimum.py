"""Result of an optimisation: all points, the best or the Pareto front, and what rejected the others."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from cycloid_mj.base.deprecated import deprecated_attribute
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.frame import Cell, Frame, Tabular, make_frame
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.result import Quantity, Table
from cycloid_mj.base.text import four_digits
from cycloid_mj.checks import check
from cycloid_mj.design import Design, declaration_of
from cycloid_mj.design.units import unit_of
from cycloid_mj.explore.constraints import MIN_BOUND
from cycloid_mj.explore.problem import FEASIBLE, REJECTED_BY, VIOLATION, Problem
from cycloid_mj.explore.row import PointResult
from cycloid_mj.explore.tolerances import CONSTANT_RTOL, VERIFIED_HEADER, Tolerances
from cycloid_mj.explore.verify import DynamicsCheck, table_rows
from cycloid_mj.figures import figure
from cycloid_mj.statics.sheet import Sheet

AT_END = 0.01
"""Distance to an end of a range, or to a limit, relative to the range or the bound, within which a point lies at it
(heuristic)."""


@dataclass(frozen=True, eq=False)
class BestChecks:
    """Checks of the best design."""

    sheet: Sheet | None
    start: Sheet | None
    """Static sheets of the best design and of the start; None where it cannot be built or balanced."""
    dynamics: DynamicsCheck
    """Its run in full dynamics."""
    tolerances: Tolerances | None = None
    """Its tolerance study; None where it has no tolerances."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about missing results, and about the yield."""
        failed_run = [f"the run in full dynamics failed: {self.dynamics.note}"] if self.dynamics.note else []
        no_sheet = [] if self.sheet else ["the best design has no static sheet: friction jams it in one of its states"]
        return (*no_sheet, *failed_run, *([self.tolerances.words] if self.tolerances else []))


@dataclass(frozen=True, eq=False, repr=False)
class Optimum(Tabular):
    """Result of an optimisation, finished or not.

    Attributes
    ----------
    task
        The problem.
    rows
        All evaluations, in order: values of the keys, figures, feasibility, and what rejects the point.
    seed
        Random seed of the searches.
    checked
        Checks of the best design.
    """

    task: Problem
    rows: Sequence[PointResult]
    seed: int
    checked: BestChecks | None = None

    @property
    def evaluations(self) -> int:
        """Number of evaluated points."""
        return len(self.rows)

    @property
    def line(self) -> str:
        """Return a one-line summary of an optimisation: design, numbers of all and feasible points, best values."""
        summary = f"{self.task.reducer.design.name}, {self.evaluations} points, {len(self.feasible)} feasible"
        if self.best is None:
            return summary
        shown_figures: dict[str, Cell] = {
            objective.key: self.figures(self.best)[objective.key] for objective in self.task.objectives
        }
        shown_figures |= self.values(self.best)
        return f"{summary}; best: {', '.join(f'{key} {_format_cell(value)}' for key, value in shown_figures.items())}"

    @property
    def feasible(self) -> list[int]:
        """Indices of the points that satisfy all checks and limits."""
        return [index for index, row in enumerate(self.rows) if row.values[FEASIBLE]]

    @property
    def refused(self) -> dict[str, int]:
        """Number of points that each check or limit rejects, the largest first; a point may count several times."""
        counted = Counter(name for row in self.rows for name in str(row.values[REJECTED_BY]).split("; ") if name)
        return dict(counted.most_common())

    @cached_property
    def front(self) -> tuple[int, ...]:
        """Return the indices of the points on the Pareto front in the order of the first objective.

        With one objective, it is the best point alone.
        """
        costs = {index: self.task.costs(self.rows[index]) for index in self.feasible}
        front: list[int] = []
        for index in sorted(costs, key=costs.__getitem__):
            if not front or costs[index][-1] < costs[front[-1]][-1]:
                front.append(index)
        return tuple(front) if len(self.task.objectives) > 1 else tuple(front[:1])

    @property
    def best(self) -> int | None:
        """Return the index of the best evaluated point; None if no point is feasible.

        On a Pareto front it is the point with the smallest Chebyshev distance to the ideal point, with objectives
        normalized by their ranges on the front.
        """
        if not self.front:
            return None
        columns = list(zip(*(self.task.costs(self.rows[index]) for index in self.front), strict=True))

        def chebyshev_distance(index: int) -> float:
            costs_and_columns = zip(self.task.costs(self.rows[index]), columns, strict=True)
            return max(
                (cost - min(column)) / ((max(column) - min(column)) or 1.0) for cost, column in costs_and_columns
            )

        return min(self.front, key=chebyshev_distance)

    @property
    def start(self) -> PointResult:
        """Result of the design at the start."""
        return self.rows[0]

    def values(self, index: int) -> dict[str, Cell]:
        """Collect the values of the keys at a point [unit of the file]."""
        return {key: self.rows[index].values[key] for key in self.task.keys}

    def figures(self, index: int) -> dict[str, float]:
        """Collect the quantities of a point: objectives, then those with limits."""
        return {key: float(self.rows[index].values[key]) for key in self.task.figures}

    def design(self, index: int | None = None, name: str = "") -> Design:
        """Return the design at the evaluated point with an `index`, by default the best point, named `name`.

        Raises
        ------
        DesignError
            No point is feasible.
        """
        index = self.best if index is None else index
        if index is None:
            raise DesignError(self.infeasible_words)
        design = self.task.design_at(tuple(self.values(index).values()))
        return design.but(name=(name or f"{self.task.reducer.design.name}-best")[:64])

    @property
    def infeasible_words(self) -> str:
        """Return sentences on why no point is feasible, which point violates limits least, and what to do."""
        point_count = max(self.evaluations, 1)
        reasons = "; ".join(f"{name}: {count} ({count / point_count:.0%})" for name, count in self.refused.items())
        nearest_row = min(self.rows, key=lambda row: float(row.values[VIOLATION]))
        values = ", ".join(f"{key} = {_format_cell(nearest_row.values[key])}" for key in self.task.keys)
        return (
            f"none of {self.evaluations} points satisfies all checks and limits. Points rejected by {reasons}. The "
            f"nearest point ({values}) violates {nearest_row.error or nearest_row.values[REJECTED_BY]}. Widen the "
            "ranges, vary more keys, or relax the limits that reject most"
        )

    @cached_property
    def frame(self) -> Frame:
        """Return a table with named columns, a row for each evaluated point.

        The columns are values, quantities, feasibility, rejections, error and CPU time [s].
        """
        units = {key: unit_of(declaration_of(key)).suffix for key in self.task.keys}
        names = ("evaluation", *self.task.keys, *self.task.figures, FEASIBLE, VIOLATION, REJECTED_BY, "error", "cpu_s")
        rows = [
            {"evaluation": number, **row.values, "error": row.error, "cpu_s": row.cpu}
            for number, row in enumerate(self.rows, 1)
        ]
        return make_frame(rows, names, {key: unit for key, unit in units.items() if unit} | {"cpu_s": "s"})

    def as_json(self) -> dict[str, Any]:
        """Convert the result of an optimisation to JSON values, without the list of evaluations.

        ``best`` and ``start`` have values by keys of the design file, in its units; ``figures`` are by key of the
        quantity. ``front`` is the Pareto front if there are several objectives. ``refused`` is the number of points
        rejected by each check or limit, ``feasible`` and ``evaluations`` are numbers of points. ``objective`` is the
        best value, or a list of both values; ``objectives`` are dicts with ``key`` and ``sense``. ``verified`` are the
        results of statics, full dynamics and tolerance study of the best design.
        """
        best, objectives = self.best, self.task.objectives
        objective_values = None if best is None else [self.figures(best)[objective.key] for objective in objectives]
        return {
            "best": {} if best is None else self.values(best),
            "objective": objective_values[0] if objective_values and len(objectives) == 1 else objective_values,
            "objectives": [
                {"key": objective.key, "sense": "least" if objective.sign > 0 else "largest"}
                for objective in objectives
            ],
            "evaluations": self.evaluations,
            "design": "" if best is None else f"{self.task.reducer.design.name}-best",
            "figures": {} if best is None else self.figures(best),
            "start": {"best": self.values(0), "figures": self.start_figures, "refused": self.start.values[REJECTED_BY]},
            "limits": [str(limit) for limit in self.task.limits],
            "front": [{**self.values(index), **self.figures(index)} for index in self.front]
            if len(objectives) > 1
            else [],
            "feasible": len(self.feasible),
            "refused": self.refused,
            "follows": self.task.follows,
            "seed": self.seed,
            "verified": None if self.checked is None else self._checks_as_json(self.checked),
        }

    @property
    def start_figures(self) -> dict[str, float]:
        """Quantities of the start; none where it is rejected before they are computed."""
        return {key: float(self.start.values[key]) for key in self.task.figures if key in self.start.values}

    @property
    def best_figures(self) -> dict[str, float]:
        """Quantities of the best point; none where there is none."""
        return {} if self.best is None else self.figures(self.best)

    def change(self, key: str) -> float:
        """Compute the relative change of a quantity from the start to the best; NaN if the start has no value, or 0."""
        start = self.start_figures.get(key, math.nan)
        return self.best_figures[key] / start - 1.0 if start else math.nan

    @property
    def words(self) -> str:
        """Return a sentence that summarises an optimisation: objectives, limits, numbers of points, start, seed."""
        objectives = " and ".join(map(str, self.task.objectives))
        limits = f", {' and '.join(map(str, self.task.limits))}" if self.task.limits else ""
        front = f", {len(self.front)} on the front" if len(self.task.objectives) > 1 else ""
        return (
            f"{objectives}{limits}: {len(self.feasible)} of {self.evaluations} points are feasible{front}; "
            f"start {self.task.reducer.design.name}, seed {self.seed}"
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return sentences about objectives of an optimisation that have the same value at every evaluated point."""
        evaluated_rows = [row for row in self.rows if all(key in row.values for key in self.task.figures)]
        sentences = []
        for key in (objective.key for objective in self.task.objectives):
            values = [value for row in evaluated_rows if math.isfinite(value := float(row.values[key]))]
            if len(values) > 1 and max(values) - min(values) <= CONSTANT_RTOL * max(map(abs, values)):
                sentences.append(
                    f"the objective {key} does not depend on {', '.join(self.task.keys)}: it is {values[0]:.6g} at all "
                    f"{len(values)} points, so the best point is arbitrary. Vary other keys or choose another objective"
                )
        return tuple(sentences)

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about keys that follow, failed checks of the best design, and its further checks."""
        linked = [f"{key} follows: {rule}" for key, rule in self.task.follows.items()]
        failed = [f"the best design: {item}" for item in check(self.design()) if not item.passed]
        return (*linked, *failed, *(self.checked.notes if self.checked else ()))

    @property
    def active_bounds(self) -> tuple[str, ...]:
        """Return sentences that name the ends of ranges and the limits which the best point reaches.

        The point reaches an end of a range at a distance below the fraction `AT_END` of the range, and a limit at a
        distance below the same fraction of its bound. The range of a list of numbers is from the smallest to the
        largest; a list of words or booleans has no range.
        """
        if self.best is None:
            return ()
        values, figures = self.values(self.best), self.best_figures
        ranges = {key_range.key: (key_range.low, key_range.high) for key_range in self.task.ranges}
        for choice in self.task.choices:
            numbers = [
                value for value in choice.values if isinstance(value, (int, float)) and not isinstance(value, bool)
            ]
            if len(numbers) == len(choice.values) > 1:
                ranges[choice.key] = min(numbers), max(numbers)
        sentences = []
        for key, (low, high) in ranges.items():
            position = (float(values[key]) - low) / (high - low)
            if min(position, 1.0 - position) < AT_END:
                side, bound = ("lower", low) if position < 0.5 else ("upper", high)
                sentences.append(
                    f"{key} is at the {side} end of its range, {bound:g}: a wider range may allow a better design"
                )
        limits = [
            f"{limit.key} is at its limit {limit}: {figures[limit.key]:.5g}"
            for limit in self.task.limits
            if abs(figures[limit.key] - limit.bound) < AT_END * max(abs(limit.bound), MIN_BOUND)
        ]
        return (*sentences, *limits)

    ran_into = deprecated_attribute("Optimum", "ran_into", "active_bounds")

    def _checks_as_json(self, best_checks: BestChecks) -> dict[str, Any]:
        """Convert the results that verify the best design to JSON values.

        `best_checks` are these results. ``statics`` are quantities by key, ``dynamics`` those of a run with their
        differences, and ``tolerances`` a study of tolerances. ``statics`` and ``tolerances`` are None if missing.
        """
        dynamics = best_checks.dynamics
        return {
            "statics": {key: quantity.value for key, quantity in best_checks.sheet.quantities.items()}
            if best_checks.sheet
            else None,
            "dynamics": {**vars(dynamics), "differences": dynamics.differences},
            "tolerances": None if best_checks.tolerances is None else best_checks.tolerances.as_json(),
        }


def _format_cell(value: Cell) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def tables(optimum: Optimum) -> tuple[Table, ...]:
    """Tabulate the best point of an optimisation next to its start, rejections, Pareto front, and verification.

    The rejections are the numbers of points that each check or limit rejected. The verification of the best design is
    by statics, a run in full dynamics and its tolerance study, if they were computed (`BestChecks`). Tables without
    rows are left out. The optimum must have a best point.
    """
    assert optimum.best is not None
    start, best = optimum.values(0), optimum.values(optimum.best)
    keys = tuple((key, _format_cell(start[key]), _format_cell(best[key])) for key in optimum.task.keys)
    start_figures, change = optimum.start_figures, optimum.change
    figures = tuple(
        (
            figure(key).name,
            _format_number(start_figures.get(key)),
            _format_number(value),
            _format_change(change(key)),
            figure(key).unit,
        )
        for key, value in optimum.best_figures.items()
    )
    evaluation_count = optimum.evaluations
    rejections = tuple((name, str(count), f"{count / evaluation_count:.1%}") for name, count in optimum.refused.items())
    tables = [
        Table("best design", ("key", "start", "best"), keys),
        Table("figures", ("figure", "start", "best", "change", "unit"), figures),
    ]
    if rejections:
        tables.append(
            Table(f"rejections, of {evaluation_count} points", ("check or limit", "points", "share"), rejections)
        )
    if len(optimum.task.objectives) > 1:
        header = (*optimum.task.keys, *optimum.task.figures)
        front = ({**optimum.values(index), **optimum.figures(index)} for index in optimum.front)
        cells = tuple(tuple(_format_cell(point[key]) for key in header) for point in front)
        tables.append(Table("Pareto front", header, cells))
    if optimum.checked is not None:
        tables += _tabulate_checks(optimum.checked)
    return tuple(tables)


def _tabulate_checks(best_checks: BestChecks) -> list[Table]:
    """Tabulate the verification of the best design of an optimisation by statics, full dynamics and tolerances.

    `best_checks` are these results. The first table compares the statics of the best design with those of the start.
    Tables of the best design in full dynamics, of its distributions within the tolerances, and of its error budget
    follow. Tables without results are left out.
    """
    tables = []
    if best_checks.sheet is not None:
        start = best_checks.start.quantities if best_checks.start else {}
        rows = tuple(
            _comparison_row(quantity, start.get(quantity.key)) for quantity in best_checks.sheet.quantities.values()
        )
        header = ("quantity", "start", "best", "change", "unit")
        tables.append(Table(f"statics: {best_checks.sheet.condition}", header, rows))
    if best_checks.dynamics.dynamics:
        title = f"best design in full dynamics {SOLVERS[best_checks.dynamics.solver]}"
        tables.append(Table(title, VERIFIED_HEADER, tuple(table_rows(best_checks.dynamics))))
    return [*tables, *(best_checks.tolerances.tables()[:2] if best_checks.tolerances else ())]


def _comparison_row(best: Quantity, start: Quantity | None) -> tuple[str, ...]:
    """Format name, value at the start, value of the best design, relative change and unit of a quantity.

    A value that is not available at the start is a dash.
    """
    start_value = start.value if start else math.nan
    change = best.value / start_value - 1.0 if start_value else math.nan
    return best.name, _format_number(start_value), _format_number(best.value), _format_change(change), best.unit


def _format_number(value: float | None) -> str:
    return "-" if value is None or math.isnan(value) else four_digits(value)


def _format_change(share: float) -> str:
    return "" if math.isnan(share) else f"{100.0 * share:+.1f} %"
