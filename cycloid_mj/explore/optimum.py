"""What came of an optimisation: every point, the best of them or the front of two objectives, and why others failed."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.frame import Cell, Frame, Tabular, framed
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.result import Quantity, Table
from cycloid_mj.checks import check
from cycloid_mj.design import Design, declared
from cycloid_mj.design.units import unit_of
from cycloid_mj.explore.problem import FEASIBLE, REFUSED, VIOLATION, Problem
from cycloid_mj.explore.row import PointResult
from cycloid_mj.explore.tolerances import VERIFIED_HEADER, Tolerances
from cycloid_mj.explore.verify import Verified, table_rows
from cycloid_mj.figures import figure
from cycloid_mj.statics.sheet import Sheet

AT_END = 0.01
"""Share of a range, or of a limit's bound, within which a point lies at it."""

UNMOVED = 1e-9
"""Relative range of an objective up to which it counts as constant: rounding errors are below."""

TINY = 1e-12
"""Bound below which a limit counts as one of 0."""


@dataclass(frozen=True, eq=False)
class Checked:
    """The best design by full statics, beside the `start`, in dynamics, and as it is made; None where there is none."""

    sheet: Sheet | None
    start: Sheet | None
    dynamics: Verified
    tolerances: Tolerances | None = None

    @property
    def notes(self) -> tuple[str, ...]:
        """What is missing, and the yield; a sentence each."""
        lost = [f"not run in full dynamics: {self.dynamics.note}"] if self.dynamics.note else []
        sheets = [] if self.sheet else ["the best design has no full statics: friction jams it in one of its states"]
        return (*sheets, *lost, *([self.tolerances.words] if self.tolerances else []))


@dataclass(frozen=True, eq=False, repr=False)
class Optimum(Tabular):
    """What came of an optimisation, or of a part of it.

    Attributes
    ----------
    task
        What was optimised.
    rows
        Every evaluation, in order: values of the keys, figures, whether it keeps all, and what refused it.
    seed
        Of the searches.
    checked
        What the best design is beyond its figures.
    """

    task: Problem
    rows: Sequence[PointResult]
    seed: int
    checked: Checked | None = None

    @property
    def evaluations(self) -> int:
        """How many points were evaluated."""
        return len(self.rows)

    @property
    def line(self) -> str:
        """How many points were evaluated, and the best of them."""
        head = f"{self.task.reducer.design.name}, {self.evaluations} points, {len(self.feasible)} keep all"
        if self.best is None:
            return head
        told: dict[str, Cell] = {one.key: self.figures(self.best)[one.key] for one in self.task.objectives}
        told |= self.values(self.best)
        return f"{head}; best: {', '.join(f'{key} {_short(value)}' for key, value in told.items())}"

    @property
    def feasible(self) -> list[int]:
        """Places of the points that keep every check and limit."""
        return [place for place, row in enumerate(self.rows) if row.values[FEASIBLE]]

    @property
    def refused(self) -> dict[str, int]:
        """What refused points: names of checks, limits as written; the most frequent first."""
        counted = Counter(name for row in self.rows for name in str(row.values[REFUSED]).split("; ") if name)
        return dict(counted.most_common())

    @cached_property
    def front(self) -> tuple[int, ...]:
        """Places of the points that no other one betters in all objectives, in the order of the first objective."""
        costs = {place: self._costs(self.rows[place]) for place in self.feasible}
        front: list[int] = []
        for place in sorted(costs, key=lambda one: costs[one]):
            if not front or costs[place][-1] < costs[front[-1]][-1]:
                front.append(place)
        return tuple(front) if len(self.task.objectives) > 1 else tuple(front[:1])

    @property
    def best(self) -> int | None:
        """Place of the best point: of a front the one whose worse objective, over the front's reach, is least."""
        if not self.front:
            return None
        ends = list(zip(*(self._costs(self.rows[place]) for place in self.front), strict=True))

        def worse(place: int) -> float:
            pairs = zip(self._costs(self.rows[place]), ends, strict=True)
            return max((cost - min(end)) / ((max(end) - min(end)) or 1.0) for cost, end in pairs)

        return min(self.front, key=worse)

    @property
    def start(self) -> PointResult:
        """The design that it started from, as it was judged."""
        return self.rows[0]

    def values(self, place: int) -> dict[str, Cell]:
        """Collect the values of the keys at a point [unit of the file]."""
        return {key: self.rows[place].values[key] for key in self.task.keys}

    def figures(self, place: int) -> dict[str, float]:
        """Compute the figures of a point that matter: objectives, then those with limits."""
        return {key: float(self.rows[place].values[key]) for key in self.task.wanted}

    def design(self, place: int | None = None, name: str = "") -> Design:
        """Return the design at a point, by default the best.

        Raises
        ------
        DesignError
            No point keeps all.
        """
        place = self.best if place is None else place
        if place is None:
            raise DesignError(self.hopeless)
        design = self.task.at(tuple(self.values(place).values()))
        return design.but(name=(name or f"{self.task.reducer.design.name}-best")[:64])

    @property
    def hopeless(self) -> str:
        """Why there is no best point, and what to do."""
        whole = max(self.evaluations, 1)
        reasons = "; ".join(f"{name}: {count} ({count / whole:.0%})" for name, count in self.refused.items())
        nearest = min(self.rows, key=lambda row: float(row.values[VIOLATION]))
        at = ", ".join(f"{key} = {_short(nearest.values[key])}" for key in self.task.keys)
        return (
            f"none of {self.evaluations} points keeps every check and limit. Refused by: {reasons}; the nearest, {at}, "
            f"fails {nearest.error or nearest.values[REFUSED]}. Widen the ranges, let more keys vary, or loosen the "
            "limits that refuse most"
        )

    @cached_property
    def frame(self) -> Frame:
        """One row an evaluation."""
        units = {key: unit_of(declared(key)).suffix for key in self.task.keys}
        names = ("evaluation", *self.task.keys, *self.task.wanted, FEASIBLE, VIOLATION, REFUSED, "error", "cpu_s")
        rows = [
            {"evaluation": number, **row.values, "error": row.error, "cpu_s": row.cpu}
            for number, row in enumerate(self.rows, 1)
        ]
        return framed(rows, names, {key: unit for key, unit in units.items() if unit} | {"cpu_s": "s"})

    def as_json(self) -> dict[str, Any]:
        """Convert all of it to JSON values, but the history."""
        place, objectives = self.best, self.task.objectives
        reached = None if place is None else [self.figures(place)[objective.key] for objective in objectives]
        return {
            "best": {} if place is None else self.values(place),
            "objective": reached[0] if reached and len(objectives) == 1 else reached,
            "objectives": [
                {"key": objective.key, "sense": "least" if objective.sign > 0 else "largest"}
                for objective in objectives
            ],
            "evaluations": self.evaluations,
            "design": "" if place is None else f"{self.task.reducer.design.name}-best",
            "figures": {} if place is None else self.figures(place),
            "start": {"best": self.values(0), "figures": self.start_figures, "refused": self.start.values[REFUSED]},
            "limits": [str(limit) for limit in self.task.limits],
            "front": [{**self.values(one), **self.figures(one)} for one in self.front] if len(objectives) > 1 else [],
            "feasible": len(self.feasible),
            "refused": self.refused,
            "follows": self.task.follows,
            "seed": self.seed,
            "verified": None if self.checked is None else self._checked_json(self.checked),
        }

    @property
    def start_figures(self) -> dict[str, float]:
        """Figures of the start that matter; none where it is refused before they are known."""
        return {key: float(self.start.values[key]) for key in self.task.wanted if key in self.start.values}

    @property
    def best_figures(self) -> dict[str, float]:
        """Figures of the best that matter; none where there is no best."""
        return {} if self.best is None else self.figures(self.best)

    def change(self, key: str) -> float:
        """Compute by how much a figure of the best differs from the start's, as a share; NaN where one is not known."""
        before = self.start_figures.get(key, math.nan)
        return self.best_figures[key] / before - 1.0 if before else math.nan

    @property
    def words(self) -> str:
        """What was sought and found, in a sentence."""
        aims = " and ".join(map(str, self.task.objectives))
        limits = f", {' and '.join(map(str, self.task.limits))}" if self.task.limits else ""
        front = f", a front of {len(self.front)}" if len(self.task.objectives) > 1 else ""
        return (
            f"{aims}{limits}: {len(self.feasible)} of {self.evaluations} points keep all{front}; "
            f"start {self.task.reducer.design.name}, seed {self.seed}"
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """Objectives that do not change from point to point, a sentence each."""
        known = [row for row in self.rows if all(key in row.values for key in self.task.wanted)]
        unmoved = []
        for key in (objective.key for objective in self.task.objectives):
            values = [value for row in known if math.isfinite(value := float(row.values[key]))]
            if len(values) > 1 and max(values) - min(values) <= UNMOVED * max(map(abs, values)):
                unmoved.append(
                    f"the objective {key} does not depend on {', '.join(self.task.keys)}: it is {values[0]:.6g} at all "
                    f"{len(values)} points, so the best point is arbitrary. Vary other keys or choose another objective"
                )
        return tuple(unmoved)

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader should know, a sentence each."""
        followed = [f"{key} follows: {how}" for key, how in self.task.follows.items()]
        warned = [f"the best design: {one}" for one in check(self.design()) if not one.passed]
        return (*followed, *warned, *(self.checked.notes if self.checked else ()))

    @property
    def ran_into(self) -> tuple[str, ...]:
        """The ends of ranges, and the limits, that the best point lies at, a sentence each."""
        if self.best is None:
            return ()
        values, figures = self.values(self.best), self.best_figures
        reaches = {one.key: (one.low, one.high) for one in self.task.ranges}
        for one in self.task.choices:
            numbers = [value for value in one.values if isinstance(value, (int, float)) and not isinstance(value, bool)]
            if len(numbers) == len(one.values) > 1:
                reaches[one.key] = min(numbers), max(numbers)
        ends = []
        for key, (low, high) in reaches.items():
            share = (float(values[key]) - low) / (high - low)
            if min(share, 1.0 - share) < AT_END:
                end, bound = ("lower", low) if share < 0.5 else ("upper", high)
                ends.append(f"{key} ran into the {end} end of its range, {bound:g}: more may lie beyond")
        limits = [
            f"{one.key} ran into its limit, {one}: it is {figures[one.key]:.5g}"
            for one in self.task.limits
            if abs(figures[one.key] - one.bound) < AT_END * max(abs(one.bound), TINY)
        ]
        return (*ends, *limits)

    def _checked_json(self, checked: Checked) -> dict[str, Any]:
        dynamics = checked.dynamics
        return {
            "statics": {key: quantity.value for key, quantity in checked.sheet.quantities.items()}
            if checked.sheet
            else None,
            "dynamics": {**vars(dynamics), "differences": dynamics.differences},
            "tolerances": None if checked.tolerances is None else checked.tolerances.as_json(),
        }

    def _costs(self, row: PointResult) -> tuple[float, ...]:
        return tuple(objective.sign * float(row.values[objective.key]) for objective in self.task.objectives)


def _short(value: Cell) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def tables(optimum: Optimum) -> tuple[Table, ...]:
    """List the best point and its figures beside the start's, what refused points, the front, and what was checked."""
    assert optimum.best is not None
    start, best = optimum.values(0), optimum.values(optimum.best)
    keys = tuple((key, _short(start[key]), _short(best[key])) for key in optimum.task.keys)
    figures = tuple(
        (
            figure(key).name,
            _number(optimum.start_figures.get(key)),
            _number(value),
            _percent(optimum.change(key)),
            figure(key).unit,
        )
        for key, value in optimum.best_figures.items()
    )
    whole = optimum.evaluations
    refused = tuple((name, str(count), f"{count / whole:.1%}") for name, count in optimum.refused.items())
    tables = [
        Table("best design", ("key", "start", "best"), keys),
        Table("figures", ("figure", "start", "best", "change", "unit"), figures),
    ]
    if refused:
        tables.append(Table(f"what refused points, of {whole}", ("check or limit", "points", "share"), refused))
    if len(optimum.task.objectives) > 1:
        header = (*optimum.task.keys, *optimum.task.wanted)
        front = ({**optimum.values(place), **optimum.figures(place)} for place in optimum.front)
        tables.append(Table("front", header, tuple(tuple(_short(one[key]) for key in header) for one in front)))
    if optimum.checked is not None:
        tables += _checked_tables(optimum.checked)
    return tuple(tables)


def _checked_tables(checked: Checked) -> list[Table]:
    """Tabulate the full statics of best and start, the dynamics of the best, and its yield."""
    tables = []
    if checked.sheet is not None:
        before = checked.start.quantities if checked.start else {}
        rows = tuple(_compared(quantity, before.get(quantity.key)) for quantity in checked.sheet.quantities.values())
        header = ("quantity", "start", "best", "change", "unit")
        tables.append(Table(f"statics: {checked.sheet.condition}", header, rows))
    if checked.dynamics.dynamics:
        title = f"the best design in full dynamics {SOLVERS[checked.dynamics.solver]}"
        tables.append(Table(title, VERIFIED_HEADER, tuple(table_rows(checked.dynamics))))
    return [*tables, *(checked.tolerances.tables()[:2] if checked.tolerances else ())]


def _compared(best: Quantity, start: Quantity | None) -> tuple[str, ...]:
    """List a quantity of the best beside the start's."""
    before = start.value if start else math.nan
    change = best.value / before - 1.0 if before else math.nan
    return best.name, _number(before), _number(best.value), _percent(change), best.unit


def _number(value: float | None) -> str:
    return "-" if value is None or math.isnan(value) else f"{value:.6g}"


def _percent(share: float) -> str:
    return "" if math.isnan(share) else f"{100.0 * share:+.1f} %"
