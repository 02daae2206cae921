"""A point of a sweep: the design with the point's values, and its measured quantities or the error."""

import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field

from cycloid_mj.base.errors import CycloidError, CycloidWarning
from cycloid_mj.base.frame import Cell
from cycloid_mj.design import override
from cycloid_mj.explore.linked_keys import Link, apply_links, linked_values
from cycloid_mj.explore.measured import MEASURED, MeasuredFigures, MeasureSettings, measure_design
from cycloid_mj.explore.points import Value
from cycloid_mj.reducer import Reducer, reducer_of


@dataclass(frozen=True)
class Task:
    """Task of each point: the design, its keys and measures."""

    reducer: Reducer
    """The drive that the points change."""
    keys: tuple[str, ...]
    """Keys of the design file that the points have values of."""
    measures: tuple[str, ...]
    """Names of measures, or keys of figures."""
    options: MeasureSettings
    """Settings of the measures."""
    links: tuple[Link, ...] = ()
    """Keys that follow those of the points."""

    def column(self, measure: str, name: str) -> str:
        """Return the name of a column: ``measure.name`` where there are several measures, the key of a quantity."""
        return name if len(self.measures) == 1 or measure not in MEASURED else f"{measure}.{name}"


@dataclass(frozen=True)
class PointResult:
    """Result of a point."""

    values: dict[str, Cell] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    """Units by column."""
    error: str = ""
    """Why the point, or one of its measures, failed; empty where all succeeded."""
    warnings: tuple[str, ...] = ()
    assumptions: tuple[str, ...] = ()
    """Sentences of all its measures."""
    cpu: float = 0.0
    """CPU time [s]."""
    followed: dict[str, Cell] = field(default_factory=dict)
    """Values of the keys that follow."""


def evaluate_row(task: Task, values: Sequence[Value]) -> PointResult:
    """Compute the results of a sweep at one point, with the `values` of the task's keys in their order.

    `task` has the design, the keys and the measures. Measures are groups of results, such as ``statics``. An error of a
    value or a measure is recorded in the result, since other points may succeed. If a value fails, the result has no
    quantities; if a measure fails, it has those of the others.
    """
    start_time = time.thread_time()
    try:
        changed_design = override(task.reducer.design, dict(zip(task.keys, values, strict=True)))
        design = apply_links(task.reducer, reducer_of(changed_design), task.links)
    except CycloidError as error:
        return PointResult(error=error_line(error), cpu=time.thread_time() - start_time)
    results: dict[str, MeasuredFigures] = {}
    errors = []
    for name in task.measures:
        try:
            results[name] = _compute_measure(name, reducer_of(design), task.options)
        except Exception as error:
            line = error_line(error)
            text = line if isinstance(error, CycloidError) else f"{type(error).__name__}: {line}"
            errors.append(text if len(task.measures) == 1 else f"{name}: {text}")
    return PointResult(
        values={
            task.column(name, key): cell for name, result in results.items() for key, cell in result.values.items()
        },
        units={task.column(name, key): unit for name, result in results.items() for key, unit in result.units.items()},
        error="; ".join(errors),
        warnings=tuple(dict.fromkeys(text for result in results.values() for text in result.warnings)),
        assumptions=tuple(dict.fromkeys(text for result in results.values() for text in result.assumptions)),
        cpu=time.thread_time() - start_time,
        followed=dict(linked_values(reducer_of(design), task.links)),
    )


def _compute_measure(name: str, reducer: Reducer, options: MeasureSettings) -> MeasuredFigures:
    """Compute a measure of a reducer, a group of results such as ``statics``, by its name.

    Python warnings are suppressed, because the result lists them. `options` are those of simulations. Raise
    CycloidError if the reducer cannot be built, except for the measure ``checks``.
    """
    from cycloid_mj.checks import require_sound

    if name != "checks":
        require_sound(reducer)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CycloidWarning)
        return measure_design(name, reducer, options)


def error_line(error: BaseException) -> str:
    """Return the text of an error in one line; the name of its class where it has none."""
    return " ".join(str(error).split()) or type(error).__name__
