"""Optimisation problem: the design, the keys that vary, the objectives, and the limits that a point must satisfy."""

import math
import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cycloid_mj.base.errors import CycloidError, CycloidWarning, DesignError, UsageError
from cycloid_mj.checks import WALLS, check, soundness
from cycloid_mj.design import Design, declaration_of, override, value_of
from cycloid_mj.explore.constraints import MIN_BOUND, FigureLimit, parse_limit, require_consistent
from cycloid_mj.explore.linked_keys import Link, apply_links, default_links, parse_links
from cycloid_mj.explore.points import Value, Wanted, axis_values, parse_axis
from cycloid_mj.explore.row import PointResult, error_line
from cycloid_mj.figures import COMPUTED, compute, figure
from cycloid_mj.reducer import Reducer, reducer_of

MAX_COMBINATIONS = 2000
"""Combinations of whole numbers and words at most, which are tried one by one."""

FEASIBLE, REJECTED_BY, VIOLATION = "feasible", "refused", "violation"
"""Columns of every evaluation: whether the point is feasible, what rejects it, and its total violation."""

LIMIT_VIOLATION, CHECK_VIOLATION, NO_FIGURE, INVALID_VALUE = 1.0, 1e3, 1e6, 1e9
"""Offsets of violations: of limits, of checks, where a figure has no value, where the design file refuses a value."""

FILE, STATICS, RANGES = "design file", "statics", "ranges"
"""Reasons of rejection besides checks and limits."""


@dataclass(frozen=True)
class Objective:
    """A figure to minimize, by its key; to maximize it, `sign` is -1."""

    key: str
    sign: float = 1.0

    def __str__(self) -> str:
        """Write the objective in words."""
        return f"{'minimize' if self.sign > 0 else 'maximize'} {self.key}"


@dataclass(frozen=True)
class SearchRange:
    """Bounds of a real number [unit of the file]."""

    key: str
    low: float
    high: float


@dataclass(frozen=True)
class Choice:
    """A key and the values that are tried for it."""

    key: str
    values: tuple[Value, ...]


@dataclass(frozen=True)
class Problem:
    """A design, and the variables, objectives and limits of its optimisation."""

    reducer: Reducer
    """The start."""
    ranges: tuple[SearchRange, ...]
    choices: tuple[Choice, ...]
    """Keys that vary: real numbers, which are searched; whole numbers and words, which are tried one by one."""
    objectives: tuple[Objective, ...]
    """One or two."""
    limits: tuple[FigureLimit, ...]
    """Limits on figures."""
    strict: bool
    """Whether warnings of the checks reject a point, too."""
    links: tuple[Link, ...] = ()
    """Keys that follow those of the points."""

    @property
    def variables(self) -> tuple[SearchRange | Choice, ...]:
        """All variables, real numbers first."""
        return (*self.ranges, *self.choices)

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of a point's values, in order."""
        return tuple(variable.key for variable in self.variables)

    @property
    def figures(self) -> tuple[str, ...]:
        """Keys of the quantities to compute: objectives first, then those with limits."""
        return tuple(
            dict.fromkeys([*(objective.key for objective in self.objectives), *(limit.key for limit in self.limits)])
        )

    @property
    def follows(self) -> dict[str, str]:
        """Keys that follow, and their formulas or rules."""
        return {link.key: link.words for link in self.links}

    def design_at(self, values: Sequence[Value]) -> Design:
        """Return the design at a point; raise DesignError where the design file does not allow a value."""
        design = override(self.reducer.design, dict(zip(self.keys, values, strict=True)))
        return apply_links(self.reducer, reducer_of(design), self.links)

    def costs(self, row: PointResult) -> tuple[float, ...]:
        """Return the objectives of a feasible point, all to be minimized: those to maximize have the sign changed."""
        return tuple(objective.sign * float(row.values[objective.key]) for objective in self.objectives)

    @property
    def combinations(self) -> int:
        """Number of combinations of the choices."""
        return math.prod(len(choice.values) for choice in self.choices)

    def allows(self, values: Sequence[Value]) -> bool:
        """Return whether the values of a point lie within the ranges and choices of the problem.

        The start design may lie outside.
        """
        return all(
            variable.low <= float(value) <= variable.high
            if isinstance(variable, SearchRange)
            else value in variable.values
            for variable, value in zip(self.variables, values, strict=True)
        )

    @property
    def start(self) -> tuple[Value, ...]:
        """Values of the keys in the design at the start [unit of the file]."""
        return tuple(value_of(self.reducer.design, key) for key in self.keys)


def define_problem(
    reducer: Reducer,
    vary: Mapping[str, Wanted],
    minimize: str | Sequence[str] = (),
    maximize: str | Sequence[str] = (),
    limits: str | Sequence[str] = (),
    strict: bool = False,
    follow: str | Sequence[str] = (),
) -> Problem:
    """Return the optimisation problem of a reducer, with variables, objectives, limits and linked keys.

    `vary` maps keys of the design file to ranges or lists of values. `minimize` and `maximize` are keys of quantities,
    `limits` are limits on quantities. `strict` is whether warnings of checks reject a point, too. `follow` are formulas
    of keys that depend on others. `optimize` states their forms.

    Raises
    ------
    UsageError
        There is no such key or quantity, a range or formula is not valid, limits contradict each other, or there are no
        or too many objectives.
    """
    if not vary:
        raise UsageError(
            "no key is varied: name at least one with --vary KEY=LO:HI, e.g. --vary gear.eccentricity_mm=0.5:1.1"
        )
    variables = [_parse_variable(key, range_text) for key, range_text in vary.items()]
    ranges = tuple(variable for variable in variables if isinstance(variable, SearchRange))
    choices = tuple(variable for variable in variables if isinstance(variable, Choice))
    objectives = (
        *(Objective(key) for key in _as_tuple(minimize)),
        *(Objective(key, -1.0) for key in _as_tuple(maximize)),
    )
    if not 1 <= len(objectives) <= 2:
        raise UsageError(
            f"a search needs one objective (two for a Pareto front), but {len(objectives)} are given: name "
            "quantities with --minimize or --maximize (`cycloid-mj figures` lists them)"
        )
    for objective in objectives:
        figure(objective.key, COMPUTED, reducer)
    parsed_limits = tuple(parse_limit(text, reducer) for text in _as_tuple(limits))
    require_consistent(parsed_limits)
    requested_links = parse_links(reducer, follow, vary)
    links = (*requested_links, *default_links(reducer, requested_links, vary))
    task = Problem(reducer, ranges, choices, objectives, parsed_limits, strict, links)
    if task.combinations > MAX_COMBINATIONS:
        raise UsageError(
            f"--vary: the keys whose values are whole numbers or words have {task.combinations:,} combinations, but at "
            f"most {MAX_COMBINATIONS:,} are allowed. Narrow their ranges, or vary fewer keys"
        )
    return task


def _as_tuple(words: str | Sequence[str]) -> tuple[str, ...]:
    return (words,) if isinstance(words, str) else tuple(words)


def _parse_variable(key: str, values: Wanted) -> SearchRange | Choice:
    """Parse the values of a key as a variable of the search: a range of real numbers, or a list of single values.

    A pair of numbers is a range if the key has a real number. A range of whole numbers becomes the list of all of them,
    and a range ``lo:hi:n`` the list of its n values. Raises UsageError if there is no such key, it is not a single
    value, or it cannot have such values.
    """
    if declaration_of(key).annotation is float and not isinstance(values, str) and len(values) == 2:
        values = f"{values[0]}:{values[1]}"
    axis = parse_axis(key, values)
    if axis.values or axis.count:
        return Choice(key, axis_values(axis))
    if axis.field.annotation is int:
        return Choice(key, tuple(range(int(axis.low), int(axis.high) + 1)))
    return SearchRange(key, axis.low, axis.high)


def evaluate_point(task: Problem, values: Sequence[Value]) -> PointResult:
    """Evaluate the design at a point of an optimisation problem, `task`.

    `values` are those of the problem's keys, in order. The result has the objectives and limited quantities, whether
    the point is feasible, its violation, and the checks and limits that reject it; an error is recorded in it.
    """
    start_time = time.thread_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CycloidWarning)
        figures, rejecting_checks, violation_offset, error = _compute_violations(task, values)
    violation = violation_offset + sum(rejecting_checks.values()) if rejecting_checks else 0.0
    inputs = dict(zip(task.keys, values, strict=True))
    cells = {
        **inputs,
        **figures,
        FEASIBLE: not rejecting_checks,
        VIOLATION: violation,
        REJECTED_BY: "; ".join(rejecting_checks),
    }
    return PointResult(values=cells, error=error, cpu=time.thread_time() - start_time)


def _compute_violations(
    task: Problem, values: Sequence[Value]
) -> tuple[dict[str, float], dict[str, float], float, str]:
    """Compute objectives and limited quantities at a point of a problem, `task`, and its violations.

    `values` are those of the keys of the problem.

    Returns
    -------
    tuple
        Quantities by key; relative violations by the name of the check or limit; a constant to add to their sum; text
        of an error, empty if none occurred. The constant ranks rejected points by cause: it is smallest for a violated
        limit, then follow a failed check, a quantity without a value, and a value that the design file does not allow.
    """
    try:
        design = task.design_at(values)
    except DesignError as error:
        return {}, {FILE: 1.0}, INVALID_VALUE, error_line(error)
    try:
        if failed_checks := compute_rejections(reducer_of(design), task.strict):
            return {}, failed_checks, CHECK_VIOLATION, ""
        figures = compute(reducer_of(design), task.figures)
    except CycloidError as error:
        return {}, {STATICS: 1.0}, NO_FIGURE, error_line(error)
    violations = {str(limit): excess for limit in task.limits if (excess := limit.excess(figures[limit.key])) > 0.0}
    if not task.allows(values):
        violations[RANGES] = 1.0
    if missing_keys := [objective.key for objective in task.objectives if not math.isfinite(figures[objective.key])]:
        return figures, dict.fromkeys(missing_keys, 1.0), NO_FIGURE, f"no value of {', '.join(missing_keys)}"
    return figures, violations, LIMIT_VIOLATION, ""


def compute_rejections(reducer: Reducer, strict: bool) -> dict[str, float]:
    """Return by how much a design violates the checks that reject it, relative to their bounds, by name of the check.

    A design is rejected by checks with the severity error, because it cannot be built, and by the checks `WALLS`,
    because a wall is thinner than the model assumes. With `strict`, warnings reject it, too.
    """
    checks = check(reducer.design) if strict else soundness(reducer)
    failed_checks = [
        failed_check
        for failed_check in checks
        if not failed_check.passed and (strict or failed_check.severity == "error" or failed_check.name in WALLS)
    ]
    return {failed_check.name: _excess(failed_check.value, failed_check.bound) for failed_check in failed_checks}


def _excess(value: float | None, bound: float | None) -> float:
    """Compute by how much a value misses its bound, relative to the larger of both; 1 if either is not finite."""
    if value is None or bound is None or not math.isfinite(value - bound):
        return 1.0
    return abs(value - bound) / max(abs(value), abs(bound), MIN_BOUND)
