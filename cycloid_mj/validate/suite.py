"""The validation suite: all parts of all steps, and how they run in parallel processes."""

import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from cycloid_mj.base.engine import Engine
from cycloid_mj.base.errors import CycloidError, CycloidWarning, UsageError
from cycloid_mj.base.frame import Frame, make_frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.validation import RowOutcome, ValidationPart, ValidationRow, failed_part
from cycloid_mj.validate import (
    backlash,
    balance,
    cam_load,
    energy,
    incline,
    mechanism,
    published,
    rv,
    shakedown,
    sharing,
    steps,
    symmetry,
    two_bodies,
    witness,
)
from cycloid_mj.validate.rig import FIXED, FREE, KINDS, NONPIN, SLEEVED

STEP_NAMES = (
    *("two-body", "friction", "mechanism", "backlash", "sharing", "cam"),
    *("published", "energy", "steps", "mirror", "gravity"),
    *("witness", "rv"),
)
"""Names of the steps, from simple to complex."""


def _validation_parts() -> Iterator[ValidationPart]:
    """Yield all validation parts of this package: step, function, and CPU time [s] of quick and full runs."""
    yield ValidationPart("two-body", two_bodies.rows, (1.0, 1.0))
    yield ValidationPart("friction", incline.rows, (0.2, 0.2))
    yield ValidationPart("mechanism", mechanism.rows, (9.0, 9.0))
    yield ValidationPart("mechanism", balance.rows, (9.0, 9.0))
    yield ValidationPart("backlash", backlash.rows, (4.0, 4.0))
    for kind in KINDS:
        yield ValidationPart("sharing", partial(sharing.ideal_rows, kind), (1.0, 2.0))
    yield ValidationPart("sharing", sharing.patch_rows, (1.5, 2.5))
    for kind, cost in ((FIXED, (1.0, 2.0)), (FREE, (2.0, 4.0)), (NONPIN, (7.0, 15.0))):
        yield ValidationPart("sharing", partial(sharing.clearance_rows, kind), cost)
    yield ValidationPart("cam", cam_load.rows, (6.0, 7.0))
    yield ValidationPart("published", published.hertz_rows, (0.1, 0.1))
    yield ValidationPart("published", published.efficiency_rows, (1.0, 2.0))
    yield ValidationPart("published", published.printed_drive_rows, (3.0, 3.0))
    yield ValidationPart("published", published.two_disc_rows, (0.2, 0.5))
    yield ValidationPart("published", shakedown.rows, (0.1, 0.1))
    for kind, cost in ((FIXED, (0.7, 2.0)), (FREE, (2.0, 4.0)), (NONPIN, (1.0, 3.0))):
        yield ValidationPart("energy", partial(energy.rows, kind), cost)
    yield ValidationPart("energy", energy.idle_rows, (1.0, 1.0))
    yield ValidationPart("energy", energy.jolt_rows, (2.0, 2.0))
    for kind, cost in ((FIXED, (0.4, 2.0)), (FREE, (2.5, 7.0)), (SLEEVED, (2.0, 6.0)), (NONPIN, (0.5, 2.5))):
        yield ValidationPart("steps", partial(steps.rows, kind), cost)
    for kind, cost in ((FIXED, (1.0, 1.2)), (FREE, (2.5, 4.0)), (NONPIN, (1.3, 2.0))):
        yield ValidationPart("mirror", partial(symmetry.mirror_rows, kind), cost)
    yield ValidationPart("gravity", partial(symmetry.gravity_rows, FIXED), (4.0, 4.0))
    yield ValidationPart("gravity", partial(symmetry.gravity_rows, FREE), (12.0, 12.0))
    yield ValidationPart("witness", witness.rows, (6.0, 6.0))
    yield ValidationPart("rv", rv.rows, (3.0, 30.0))


@dataclass(frozen=True, repr=False)
class Validation(Presented):
    """Rows of a validation, in the order of the steps."""

    rows: tuple[ValidationRow, ...]

    @property
    def failed(self) -> tuple[ValidationRow, ...]:
        """Rows whose difference exceeds its bound."""
        return tuple(row for row in self.rows if row.verdict is RowOutcome.FAIL)

    @property
    def frame(self) -> Frame:
        """Rows: quantity, our value, reference, difference, bound and verdict."""
        table = [row.as_json() for row in self.rows]
        return make_frame(table, table[0] if table else (), {})

    @property
    def line(self) -> str:
        """Number of rows by verdict."""
        return ", ".join(f"{sum(row.verdict is outcome for row in self.rows)} {outcome}" for outcome in RowOutcome)


PARTS = tuple(_validation_parts())
"""The parts of this package; other packages bring further parts of the same steps."""


def select_parts(only: Sequence[str] = (), other_parts: Sequence[ValidationPart] = ()) -> tuple[ValidationPart, ...]:
    """Return the validation parts of some steps, or of all, in the order of `STEP_NAMES`.

    Parameters
    ----------
    only
        Names of the steps; all if empty.
    other_parts
        Parts of other packages.

    Raises
    ------
    UsageError
        A name is not that of a step.
    """
    unknown_names = [name for name in only if name not in STEP_NAMES]
    if unknown_names:
        raise UsageError(f"--only {unknown_names[0]}: unknown validation step. Choose from {', '.join(STEP_NAMES)}")
    parts = sorted((*PARTS, *other_parts), key=lambda part: STEP_NAMES.index(part.rung))
    return tuple(part for part in parts if not only or part.rung in only)


def run_parts(
    parts: Sequence[ValidationPart], quick: bool = False, workers: int = 2
) -> Iterator[tuple[int, list[ValidationRow]]]:
    """Run validation parts in parallel processes, the longest first; yield the result of each as it ends.

    A part that cannot be run yields one failing row with the reason as its note. Warnings of the parts are issued again
    in this process. `quick` is passed to the parts; `workers` is the number of processes.

    Yields
    ------
    tuple
        Index of the part in `parts`, and its rows.
    """
    part_order = sorted(range(len(parts)), key=lambda index: parts[index].cost[not quick], reverse=True)
    tasks = [(parts[index], quick) for index in part_order]
    # a single part runs in this process
    for part_index, (rows, messages) in Engine(workers if len(tasks) > 1 else 1).stream(_run_part, tasks):
        for text in messages:
            warnings.warn(text, CycloidWarning, stacklevel=2)
        yield part_order[part_index], rows


def sort_rows(rows_of_parts: Iterable[tuple[int, list[ValidationRow]]]) -> list[ValidationRow]:
    """Return the rows of all parts of the validation, in the order of the parts."""
    return [row for _, rows in sorted(rows_of_parts, key=lambda numbered: numbered[0]) for row in rows]


def _run_part(task: tuple[ValidationPart, bool]) -> tuple[list[ValidationRow], list[str]]:
    """Run a validation part; `task` is the part and whether to run it with `quick`.

    A part that raises CycloidError has one failed row.

    Returns
    -------
    tuple
        Rows, and the texts of the warnings, which would not leave a parallel process.
    """
    part, quick = task
    with warnings.catch_warnings(record=True) as caught_warnings:
        warnings.simplefilter("always")
        try:
            rows = part.rows(quick)
        except CycloidError as error:
            rows = [failed_part(str(error))]
    return [replace(row, rung=part.rung) for row in rows], [str(warning.message) for warning in caught_warnings]
