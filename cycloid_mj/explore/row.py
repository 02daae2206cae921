"""One point of a sweep: the design changed to it, measured, and what came of it or why nothing did."""

import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field

from cycloid_mj.base.errors import CycloidError, CycloidWarning
from cycloid_mj.base.frame import Cell
from cycloid_mj.design import override
from cycloid_mj.explore.linked_keys import Follower, followed, values_of
from cycloid_mj.explore.measured import MEASURED, Measured, MeasureSettings, measured
from cycloid_mj.explore.points import Value
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class Task:
    """What is done at each point.

    Attributes
    ----------
    design
        What is changed at the points.
    keys
        Keys of the design file that the points have values of.
    measures
        What is measured.
    options
        How.
    followers
        Keys that change with those of the points.
    """

    reducer: Reducer
    keys: tuple[str, ...]
    measures: tuple[str, ...]
    options: MeasureSettings
    followers: tuple[Follower, ...] = ()

    def column(self, measure: str, name: str) -> str:
        """Name the column of a number: by its measure, too, where there are several; that of a figure is its key."""
        return name if len(self.measures) == 1 or measure not in MEASURED else f"{measure}.{name}"


@dataclass(frozen=True)
class PointResult:
    """What came of a point.

    Attributes
    ----------
    values, units
        By column.
    followed
        What the keys that follow came to.
    error
        Why the point, or one of its measures, failed; empty where all went well.
    warnings, assumptions
        Of all its measures, a sentence each.
    cpu
        CPU time that it took [s].
    """

    values: dict[str, Cell] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    error: str = ""
    warnings: tuple[str, ...] = ()
    assumptions: tuple[str, ...] = ()
    cpu: float = 0.0
    followed: dict[str, Cell] = field(default_factory=dict)


def measured_row(task: Task, values: Sequence[Value]) -> PointResult:
    """Measure the design at a point; whatever goes wrong is told in its row, since other points may go well."""
    start = time.thread_time()
    try:
        changed = override(task.reducer.design, dict(zip(task.keys, values, strict=True)))
        design = followed(task.reducer, Reducer(changed), task.followers)
    except CycloidError as error:
        return PointResult(error=one_line(error), cpu=time.thread_time() - start)
    measured: dict[str, Measured] = {}
    errors = []
    for name in task.measures:
        try:
            measured[name] = _measured(name, Reducer(design), task.options)
        except Exception as error:
            words = one_line(error) if isinstance(error, CycloidError) else f"{type(error).__name__}: {one_line(error)}"
            errors.append(words if len(task.measures) == 1 else f"{name}: {words}")
    return PointResult(
        values={task.column(name, key): cell for name, one in measured.items() for key, cell in one.values.items()},
        units={task.column(name, key): unit for name, one in measured.items() for key, unit in one.units.items()},
        error="; ".join(errors),
        warnings=tuple(dict.fromkeys(text for one in measured.values() for text in one.warnings)),
        assumptions=tuple(dict.fromkeys(text for one in measured.values() for text in one.assumptions)),
        cpu=time.thread_time() - start,
        followed=dict(values_of(Reducer(design), task.followers)),
    )


def _measured(name: str, reducer: Reducer, options: MeasureSettings) -> Measured:
    from cycloid_mj.checks import require_sound

    if name != "checks":
        require_sound(reducer)
    with warnings.catch_warnings():
        # they are in the row
        warnings.simplefilter("ignore", CycloidWarning)
        return measured(name, reducer, options)


def one_line(error: BaseException) -> str:
    """Write the text of an error in one line."""
    return " ".join(str(error).split()) or type(error).__name__
