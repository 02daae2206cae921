"""Sweep: a design evaluated at many points, each a row of a table that is written to disk at once."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from importlib.util import find_spec
from pathlib import Path
from time import monotonic
from typing import Any

from cycloid_mj.base.engine import Engine, Progress, silent, versions
from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.base.frame import Cell, Frame, Tabular, make_frame, write_csv, write_parquet
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.design import Named, declaration_of, dump, resolve
from cycloid_mj.design.units import unit_of
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.explore.journal import create_folder, open_journal
from cycloid_mj.explore.linked_keys import parse_links
from cycloid_mj.explore.measured import MeasureSettings, require_measures
from cycloid_mj.explore.points import Method, Points, Wanted, draw_points, grid_points, list_rows
from cycloid_mj.explore.row import PointResult, Task, evaluate_row
from cycloid_mj.reducer import Reducer, reducer_of

POINT, WARNINGS, ERROR, CPU, VERSIONS = "point", "warnings", "error", "cpu_s", "versions"
"""Columns of every sweep."""

TABLE, PARQUET = "sweep.csv", "sweep.parquet"

SECONDS_BETWEEN_TABLES = 10.0
"""Shortest time between two writings of the table while the sweep runs [s]."""

MAX_WRITE_SHARE = 0.05
"""Largest share of the time for writing the table while the sweep runs."""

PROCESSES = Engine()
"""All cores of this machine."""

Rows = Mapping[int, PointResult]
"""Index of a point, counted from 0 -> its result; points that are not evaluated yet are missing."""


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Tabular):
    """Result of a sweep, finished or not.

    Attributes
    ----------
    task, points
        What is measured, and where.
    rows
        Its results so far.
    """

    task: Task
    points: Points
    rows: Rows

    @property
    def line(self) -> str:
        """Number of points and of failures, varied keys, and the first quantities."""
        finished = f"{len(self.points)}" if self.complete else f"{len(self.rows)} of {len(self.points)}"
        failed = f", {self.failed} failed" if self.failed else ""
        key_text, quantity_text = ", ".join(self.task.keys), ", ".join(self.quantities[:4])
        return f"{self.task.reducer.design.name}, {finished} points of {key_text}{failed}; {quantity_text}"

    @property
    def failed(self) -> int:
        """Number of rows with an error."""
        return sum(bool(row.error) for row in self.rows.values())

    @property
    def errors(self) -> dict[str, int]:
        """Number of points with each error, the most frequent first."""
        counted = Counter(row.error for row in self.rows.values() if row.error)
        return dict(counted.most_common())

    @property
    def complete(self) -> bool:
        """True if every point has a row."""
        return len(self.rows) == len(self.points)

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Assumptions of the first point that has any, a sentence each."""
        return next((row.assumptions for _, row in sorted(self.rows.items()) if row.assumptions), ())

    @property
    def quantities(self) -> tuple[str, ...]:
        """Columns of measured quantities of all rows, in the order of the measures."""
        columns: dict[str, None] = {}
        for index in sorted(self.rows):
            columns.update(dict.fromkeys(self.rows[index].values))
        order = {measure: position for position, measure in enumerate(self.task.measures)}
        return tuple(sorted(columns, key=lambda column: order.get(column.partition(".")[0], 0)))

    @cached_property
    def frame(self) -> Frame:
        """Return a table with named columns, a row per point of the sweep.

        The columns are number, inputs, quantities, warnings, error, CPU time [s] and versions.
        """
        packages = ", ".join(f"{name} {version}" for name, version in versions())
        linked_keys = tuple(link.key for link in self.task.links)
        units = {key: unit_of(declaration_of(key)).suffix for key in (*self.task.keys, *linked_keys)} | {CPU: "s"}
        rows: list[dict[str, Cell]] = []
        for index, row in sorted(self.rows.items()):
            units |= row.units
            outcome: dict[str, Cell] = {
                WARNINGS: " ".join(row.warnings),
                ERROR: row.error,
                CPU: row.cpu,
                VERSIONS: packages,
            }
            inputs = dict(zip(self.task.keys, self.points.rows[index], strict=True))
            rows.append({POINT: index + 1, **inputs, **row.followed, **row.values, **outcome})
        names = (POINT, *self.task.keys, *linked_keys, *self.quantities, WARNINGS, ERROR, CPU, VERSIONS)
        return make_frame(rows, dict.fromkeys(names), {name: unit for name, unit in units.items() if unit})


@shows_progress
def sweep(
    design: Named,
    vary: Mapping[str, Wanted] | None = None,
    measure: str | Sequence[str] = "statics",
    *,
    table: Iterable[Mapping[str, Any]] | None = None,
    sample: Method | None = None,
    points: int = 0,
    seed: int = 0,
    quick: bool = False,
    real_pins: bool = False,
    solver: Solver = "planar",
    follow: str | Sequence[str] = (),
    out: str | Path | None = None,
    engine: Engine = PROCESSES,
    progress: Progress = silent,
) -> Sweep:
    """Evaluate a design over a grid, a sample or a table of parameter values.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file, which the points change.
    vary
        Values of each key of the design file: a sequence, or ``a,b,c``, ``lo:hi:n``, or ``lo:hi`` to sample.
    measure
        Names of one or more measures, see `MEASURED`, or keys of quantities, see `cycloid_mj.figures.FIGURES`.
    table
        The points, in place of `vary`: rows of key -> value.
    sample, points, seed
        Sampling method (``sobol``, ``lhs``, ``random``, or None for the full grid), number of points, random seed.
    quick, solver
        Whether measures use fewer angles and runs; solver of the runs.
    real_pins
        Whether loaded runs of `simulate` keep the inertia of moving pins, as they always do if ``ring.pins`` is varied.
    follow
        Keys computed from others: ``KEY=FORMULA`` of numbers and keys, in the file's units, or ``KEY`` with a rule:
        `output.hole_radius_mm` keeps the clearance of the design, `drive.torque_nm` the nominal torque on the output.
    out
        Folder to which each row is written at once, and from which an interrupted sweep is resumed; None for no files.
    engine, progress
        Where the points are evaluated; called after each point with the numbers of finished and of all points.

    Returns
    -------
    The sweep, a table for pandas, polars and DuckDB; a point that failed has its error in the table.

    Raises
    ------
    UsageError
        There is no such key or measure, the key cannot have a value, or the folder belongs to another sweep.
    CycloidError
        The folder cannot be written; its rows are kept.
    """
    reducer, points_to_evaluate = reducer_of(resolve(design)), choose_points(vary, table, sample, points, seed)
    task = define_task(reducer, points_to_evaluate, measure, quick, real_pins, follow, solver)
    if out is not None:
        return sweep_in_folder(task, points_to_evaluate, create_folder(Path(out)), engine, progress)
    return _sweep_in_memory(task, points_to_evaluate, engine, progress)


def _sweep_in_memory(task: Task, points: Points, engine: Engine, progress: Progress) -> Sweep:
    """Evaluate all points, and return the sweep without writing files."""
    rows: dict[int, PointResult] = {}
    _evaluate_missing(task, points, rows, rows.__setitem__, engine, progress)
    return Sweep(task, points, rows)


def define_task(
    reducer: Reducer,
    points: Points,
    measures: str | Iterable[str],
    quick: bool,
    real_pins: bool,
    follow: str | Sequence[str] = (),
    solver: Solver = "planar",
) -> Task:
    """Return what a sweep computes at each point: the measures, their settings, and keys that follow others.

    Parameters
    ----------
    reducer, points
        The reducer that the points change, and the points.
    measures
        Names of measures or keys of quantities, or lists ``a,b`` of them.
    quick, real_pins
        Whether measures use fewer angles and runs; whether loaded runs keep the inertia of moving pins.
    follow, solver
        Formulas ``KEY=FORMULA`` of keys that follow others; and the solver of runs, "planar" or "mujoco".

    Raises
    ------
    UsageError
        There is no such measure or quantity, or a formula is not valid.
    """
    texts = [measures] if isinstance(measures, str) else measures
    names = require_measures(reducer, (name.strip() for text in texts for name in text.split(",")))
    options = MeasureSettings(quick, real_pins or "ring.pins" in points.keys, solver)
    return Task(reducer, points.keys, names, options, parse_links(reducer, follow, points.keys))


def sweep_in_folder(task: Task, points: Points, folder: Path, engine: Engine, progress: Progress) -> Sweep:
    """Evaluate the points of a sweep that have no result in a folder yet; write results and tables; return it.

    `task` has the design, the keys and the measures; `engine` runs the computations in parallel. `progress` is called
    with the numbers of finished and of all points. Each result is written at once. The tables are written at intervals
    and at the end, even if the sweep fails or is interrupted.

    Raises
    ------
    UsageError
        The folder belongs to another sweep, or another process is working in it.
    CycloidError
        The folder cannot be written; rows written before are kept.
    RunError
        The workers of the engine are lost, or have other package versions.
    """
    with open_journal(folder, _describe_sweep(task, points)) as journal:
        next_write = monotonic() + SECONDS_BETWEEN_TABLES

        def record(index: int, row: PointResult) -> None:
            """Add a result, by the `index` of its point, to the journal; rewrite the table after `next_write`."""
            nonlocal next_write
            # assumptions hardly differ between rows: those of the first are enough
            has_assumptions = any(known_row.assumptions for known_row in journal.rows.values())
            journal.add(index, replace(row, assumptions=()) if has_assumptions else row)
            if (start := monotonic()) > next_write:
                write_csv(Sweep(task, points, journal.rows).frame, folder / TABLE)
                write_time = monotonic() - start
                next_write = monotonic() + max(SECONDS_BETWEEN_TABLES, write_time / MAX_WRITE_SHARE)

        try:
            _evaluate_missing(task, points, journal.rows, record, engine, progress)
        except BaseException:
            with suppress(CycloidError):
                write_tables(Sweep(task, points, journal.rows), folder)
            raise
        result = Sweep(task, points, journal.rows)
        write_tables(result, folder)
    return result


def _evaluate_missing(
    task: Task, points: Points, rows: Rows, record: Callable[[int, PointResult], None], engine: Engine, report: Progress
) -> None:
    """Evaluate the points of a sweep that have no result yet, and call `record` with index and result of each.

    `task` has the design, the keys and the measures; `engine` runs the computations in parallel. `rows` are existing
    results. `report` is called with the numbers of finished and of missing points.
    """
    missing_indices = [index for index in range(len(points)) if index not in rows]
    evaluate = partial(evaluate_row, task)
    stream = engine.stream(
        evaluate, [points.rows[index] for index in missing_indices], lambda _, cause: PointResult(error=cause)
    )
    for count, (position, row) in enumerate(stream, 1):
        record(missing_indices[position], row)
        report(count, len(missing_indices))


def write_tables(sweep: Sweep, folder: Path) -> None:
    """Write the table of a sweep as CSV, and as Parquet where DuckDB is installed; raise CycloidError if that fails."""
    write_csv(sweep.frame, folder / TABLE)
    if find_spec("duckdb"):
        write_parquet(sweep.frame, folder / PARQUET, {"assumptions": list(sweep.assumptions)})


def _describe_sweep(task: Task, points: Points) -> dict[str, Any]:
    """Return JSON values that identify a sweep: its design, swept keys, points, computed quantities and options.

    ``design`` has the values of the design file. ``keys`` are the keys of the design file that are swept, ``measures``
    the quantities computed at each point. ``points`` has the number and a digest of the points, ``follows`` the formula
    of each key that is computed from the swept keys (a linked key), ``versions`` the versions of the packages.
    """
    return {
        "design": dump(task.reducer.design),
        "keys": list(task.keys),
        "points": {"count": len(points), "digest": points.digest},
        "measures": list(task.measures),
        "options": asdict(task.options),
        "follows": {link.key: link.words for link in task.links},
        "versions": dict(versions()),
    }


def choose_points(
    vary: Mapping[str, Wanted] | None,
    table: Iterable[Mapping[str, Any]] | None,
    sample: Method | None,
    points: int,
    seed: int,
) -> Points:
    """Return the points of a sweep: rows of a table, a full grid of values, or a sample of ranges.

    `vary` maps keys of the design file to values or ranges, and `table` has rows of values by key. `sample` is the
    sampling method, without which the points are the full grid; `points` and `seed` are number and random seed of drawn
    points.

    Raises
    ------
    UsageError
        There are neither values nor a table, or both; see also `grid_points`, `draw_points` and `list_rows`.
    """
    if bool(vary) == (table is not None):
        raise UsageError("a sweep needs either --vary KEY=VALUES or --table POINTS.csv: give one of the two")
    if table is not None:
        if sample is not None:
            raise UsageError(
                "--sample draws from the ranges of --vary and cannot be used with --table: remove --sample, or replace "
                "--table with --vary"
            )
        return list_rows(table)
    vary = vary or {}
    if sample is None:
        if points:
            raise UsageError(
                "--points is the number of points to draw and needs --sample: add --sample sobol, lhs or random"
            )
        return grid_points(vary)
    return draw_points(vary, sample, points, seed)
