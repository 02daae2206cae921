"""What is optimised: the design and the keys that may change, the objectives, and what a point must keep."""

import math
import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cycloid_mj.base.errors import CycloidError, CycloidWarning, DesignError, UsageError
from cycloid_mj.checks import WALLS, check, soundness
from cycloid_mj.design import Design, declared, override, value_of
from cycloid_mj.explore.constraints import FigureLimit, limit, require_consistent
from cycloid_mj.explore.linked_keys import Follower, by_themselves, followed, following
from cycloid_mj.explore.points import Value, Wanted, all_values, axis_of
from cycloid_mj.explore.row import PointResult, one_line
from cycloid_mj.figures import COMPUTED, compute, figure
from cycloid_mj.reducer import Reducer

MOST_OBJECTIVES = 2
MOST_COMBINATIONS = 2000
"""Of values that are tried one by one."""

FEASIBLE, REFUSED, VIOLATION = "feasible", "refused", "violation"
"""Columns of every evaluation: whether the point keeps all, what it breaks, and by how much in all."""

BROKEN, UNBUILT, UNSOLVED, NO_DESIGN = 1.0, 1e3, 1e6, 1e9
"""Violations begin here: of limits, of checks, where no figure was found, where the file itself refuses a value."""

FILE, STATICS, RANGES = "design file", "statics", "ranges"
"""Names of what refuses a point besides checks and limits."""


@dataclass(frozen=True)
class Objective:
    """A figure by its key, to be as small as can be, or as large: then `sign` is -1."""

    key: str
    sign: float = 1.0

    def __str__(self) -> str:
        """Tell it in words."""
        return f"{'least' if self.sign > 0 else 'largest'} {self.key}"


@dataclass(frozen=True)
class SearchRange:
    """A real number between two bounds [unit of the file]."""

    key: str
    low: float
    high: float


@dataclass(frozen=True)
class Choice:
    """A key that takes one of some values."""

    key: str
    values: tuple[Value, ...]


@dataclass(frozen=True)
class Problem:
    """A design, and what may become of it.

    Attributes
    ----------
    design
        The start.
    ranges, choices
        Keys that vary: real numbers, searched; whole numbers and words, tried one by one.
    objectives
        One or two.
    limits
        On figures.
    strict
        Whether warnings of the checks refuse a point, too.
    followers
        Keys that change with those of the points.
    """

    reducer: Reducer
    ranges: tuple[SearchRange, ...]
    choices: tuple[Choice, ...]
    objectives: tuple[Objective, ...]
    limits: tuple[FigureLimit, ...]
    strict: bool
    followers: tuple[Follower, ...] = ()

    @property
    def variables(self) -> tuple[SearchRange | Choice, ...]:
        """What varies: real numbers first."""
        return (*self.ranges, *self.choices)

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of a point's values, in order."""
        return tuple(variable.key for variable in self.variables)

    @property
    def wanted(self) -> tuple[str, ...]:
        """Keys of the figures that matter: objectives first, then those with limits."""
        return tuple(
            dict.fromkeys([*(objective.key for objective in self.objectives), *(limit.key for limit in self.limits)])
        )

    @property
    def follows(self) -> dict[str, str]:
        """Keys that change with those of the points, and how."""
        return {follower.key: follower.words for follower in self.followers}

    def at(self, values: Sequence[Value]) -> Design:
        """Return the design at a point; raise DesignError where its file does not allow a value."""
        design = override(self.reducer.design, dict(zip(self.keys, values, strict=True)))
        return followed(self.reducer, Reducer(design), self.followers)

    @property
    def combinations(self) -> int:
        """How many combinations of values are tried one by one."""
        return math.prod(len(choice.values) for choice in self.choices)

    def allows(self, values: Sequence[Value]) -> bool:
        """Tell whether values lie in their ranges, as those of the start need not."""
        pairs = zip(self.variables, values, strict=True)
        return all(
            one.low <= float(value) <= one.high if isinstance(one, SearchRange) else value in one.values
            for one, value in pairs
        )

    @property
    def start(self) -> tuple[Value, ...]:
        """Values of the keys in the design that it starts from [unit of the file]."""
        return tuple(value_of(self.reducer.design, key) for key in self.keys)


def problem(
    reducer: Reducer,
    vary: Mapping[str, Wanted],
    minimize: Sequence[str] = (),
    maximize: Sequence[str] = (),
    limits: Sequence[str] = (),
    strict: bool = False,
    follow: str | Sequence[str] = (),
) -> Problem:
    """Put a problem together; see `optimize` for the arguments.

    Raises
    ------
    UsageError
        There is no such key or figure, a range or formula is not valid, limits contradict each other, or there are no
        or too many objectives.
    """
    if not vary:
        raise UsageError("nothing may change: name a key with --vary KEY=LO:HI, e.g. gear.eccentricity_mm=0.5:1.1")
    variables = [_variable(key, wanted) for key, wanted in vary.items()]
    ranges = tuple(variable for variable in variables if isinstance(variable, SearchRange))
    choices = tuple(variable for variable in variables if isinstance(variable, Choice))
    objectives = (*(Objective(key) for key in minimize), *(Objective(key, -1.0) for key in maximize))
    if not 1 <= len(objectives) <= MOST_OBJECTIVES:
        raise UsageError(
            f"{len(objectives)} objectives: name one figure, or two for a front, with --minimize or --maximize; "
            "`cycloid-mj figures` lists them"
        )
    for objective in objectives:
        figure(objective.key, COMPUTED, reducer)
    asked = tuple(limit(text, reducer) for text in limits)
    require_consistent(asked)
    following_keys = following(reducer, follow, vary)
    followers = (*following_keys, *by_themselves(following_keys, vary))
    task = Problem(reducer, ranges, choices, objectives, asked, strict, followers)
    if task.combinations > MOST_COMBINATIONS:
        raise UsageError(
            f"{task.combinations:,} combinations of whole numbers and words: at most {MOST_COMBINATIONS:,} are tried; "
            "narrow their ranges"
        )
    return task


def _variable(key: str, wanted: Wanted) -> SearchRange | Choice:
    """Read what a key may be: a range of real numbers, or values one by one."""
    if declared(key).annotation is float and not isinstance(wanted, str) and len(wanted) == 2:
        wanted = f"{wanted[0]}:{wanted[1]}"
    axis = axis_of(key, wanted)
    if axis.values or axis.count:
        return Choice(key, all_values(axis))
    if axis.field.annotation is int:
        return Choice(key, tuple(range(int(axis.low), int(axis.high) + 1)))
    return SearchRange(key, axis.low, axis.high)


def evaluated(task: Problem, values: Sequence[Value]) -> PointResult:
    """Judge one point: its figures, and what it breaks. Whatever goes wrong there is told in its row."""
    start = time.thread_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CycloidWarning)
        figures, broken, level, error = _judged(task, values)
    violation = level + sum(broken.values()) if broken else 0.0
    inputs = dict(zip(task.keys, values, strict=True))
    cells = {**inputs, **figures, FEASIBLE: not broken, VIOLATION: violation, REFUSED: "; ".join(broken)}
    return PointResult(values=cells, error=error, cpu=time.thread_time() - start)


def _judged(task: Problem, values: Sequence[Value]) -> tuple[dict[str, float], dict[str, float], float, str]:
    """Return figures, what is broken and by how much, where that begins, and the words of an error."""
    try:
        design = task.at(values)
    except DesignError as error:
        return {}, {FILE: 1.0}, NO_DESIGN, one_line(error)
    try:
        if broken := refusals(Reducer(design), task.strict):
            return {}, broken, UNBUILT, ""
        wanted = compute(Reducer(design), task.wanted)
    except CycloidError as error:
        return {}, {STATICS: 1.0}, UNSOLVED, one_line(error)
    broken = {
        str(limit): limit.excess(wanted[limit.key]) for limit in task.limits if limit.excess(wanted[limit.key]) > 0.0
    }
    if not task.allows(values):
        broken[RANGES] = 1.0
    if lacking := [objective.key for objective in task.objectives if not math.isfinite(wanted[objective.key])]:
        return wanted, dict.fromkeys(lacking, 1.0), UNSOLVED, f"no number: {', '.join(lacking)}"
    return wanted, broken, BROKEN, ""


def refusals(reducer: Reducer, strict: bool) -> dict[str, float]:
    """Compute the failed checks of a design by name, each with how far it is off, as a share of its bound.

    Those that make it impossible to build, and walls thinner than is assumed; `strict`: all warnings, too.
    """
    checks = check(reducer.design) if strict else soundness(reducer)
    failed = [one for one in checks if not one.passed and (strict or one.severity == "error" or one.name in WALLS)]
    return {one.name: _excess(one.value, one.bound) for one in failed}


def _excess(value: float | None, bound: float | None) -> float:
    """Compute by how much a value misses its bound, relative; 1 where that is no number."""
    if value is None or bound is None or not math.isfinite(value - bound):
        return 1.0
    return abs(value - bound) / max(abs(value), abs(bound), 1e-12)
