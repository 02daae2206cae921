"""A sweep: a design measured at many points, each a row of one table, on disk as soon as it is there."""

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
from cycloid_mj.base.errors import CycloidError, UsageError, reason
from cycloid_mj.base.frame import Cell, Frame, Tabular, framed, write_csv, write_parquet
from cycloid_mj.base.overwrite_guard import make_folder
from cycloid_mj.design import Named, declared, dump, resolve
from cycloid_mj.design.units import unit_of
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.explore.journal import journal
from cycloid_mj.explore.linked_keys import following
from cycloid_mj.explore.measured import MeasureSettings, require_measures
from cycloid_mj.explore.points import Method, Points, Wanted, grid, sampled, tabled
from cycloid_mj.explore.row import PointResult, Task, measured_row
from cycloid_mj.reducer import Reducer

POINT, WARNINGS, ERROR, CPU, VERSIONS = "point", "warnings", "error", "cpu_s", "versions"
"""Columns that every sweep has."""

TABLE, PARQUET = "sweep.csv", "sweep.parquet"

SECONDS_BETWEEN_TABLES = 10.0
"""At least, between two writings of the table while the sweep runs."""

MOST_SHARE_OF_TABLES = 20.0
"""Times as long as a writing of the table took, before the next one: large tables cost little then, too."""

PROCESSES = Engine()
"""All cores of this machine."""


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Tabular):
    """What came of a sweep, or of a part of it.

    Attributes
    ----------
    task, points
        What was measured, and where.
    rows
        Place of a point, counted from 0 -> what came of it; points that are not done yet are missing.
    """

    task: Task
    points: Points
    rows: Mapping[int, PointResult]

    @property
    def line(self) -> str:
        """How many points there are, of what, and how many failed."""
        done = f"{len(self.points)}" if self.complete else f"{len(self.rows)} of {len(self.points)}"
        failed = f", {self.failed} failed" if self.failed else ""
        varied, measured = ", ".join(self.task.keys), ", ".join(self.quantities[:4])
        return f"{self.task.reducer.design.name}, {done} points of {varied}{failed}; {measured}"

    @property
    def failed(self) -> int:
        """How many of the rows have an error."""
        return sum(bool(row.error) for row in self.rows.values())

    @property
    def errors(self) -> dict[str, int]:
        """Errors, the most frequent first, and how many points have each."""
        counted = Counter(row.error for row in self.rows.values() if row.error)
        return dict(counted.most_common())

    @property
    def complete(self) -> bool:
        """Whether every point has its row."""
        return len(self.rows) == len(self.points)

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What the figures stand on, as the first point that went well has it; a sentence each."""
        return next((row.assumptions for _, row in sorted(self.rows.items()) if row.assumptions), ())

    @property
    def quantities(self) -> tuple[str, ...]:
        """Columns of what was measured, in the order of the measures."""
        quantities: dict[str, None] = {}
        for place in sorted(self.rows):
            quantities.update(dict.fromkeys(self.rows[place].values))
        of_measure = {name: place for place, name in enumerate(self.task.measures)}
        return tuple(sorted(quantities, key=lambda column: of_measure.get(column.partition(".")[0], 0)))

    @cached_property
    def frame(self) -> Frame:
        """One row a point: its number, inputs, quantities, warnings, error, CPU time [s], and versions."""
        made_by = ", ".join(f"{name} {version}" for name, version in versions())
        follows = tuple(follower.key for follower in self.task.followers)
        units = {key: unit_of(declared(key)).suffix for key in (*self.task.keys, *follows)} | {CPU: "s"}
        rows: list[dict[str, Cell]] = []
        for place, row in sorted(self.rows.items()):
            units |= row.units
            columns: dict[str, Cell] = {
                WARNINGS: " ".join(row.warnings),
                ERROR: row.error,
                CPU: row.cpu,
                VERSIONS: made_by,
            }
            inputs = dict(zip(self.task.keys, self.points.rows[place], strict=True))
            rows.append({POINT: place + 1, **inputs, **row.followed, **row.values, **columns})
        names = (POINT, *self.task.keys, *follows, *self.quantities, WARNINGS, ERROR, CPU, VERSIONS)
        return framed(rows, dict.fromkeys(names), {name: unit for name, unit in units.items() if unit})


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
    """Measure a design at many points.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file: what the points change.
    vary
        Key of the design file -> its values: a sequence, or in words ``a,b,c``, ``lo:hi:n``, or ``lo:hi`` to sample.
    measure
        Names of one or more measures, see `MEASURED`, or keys of figures, see `cycloid_mj.figures.FIGURES`.
    table
        The points themselves, in place of `vary`: rows of key -> value.
    sample, points, seed
        Draw so many points from the ranges: ``sobol``, ``lhs`` or ``random``. Without `sample`: the whole grid.
    quick
        Whether measures take fewer angles and runs, as by their own option of that name.
    real_pins
        Whether loaded runs of `simulate` keep the inertia of moving pins, as they do where ``ring.pins`` is varied.
    solver
        What takes the steps of runs.
    follow
        Keys that change with those of the points: ``KEY=FORMULA`` of numbers and keys, in the file's units, or ``KEY``
        of one that knows how: `output.hole_radius_mm`, which leaves the room that the design has, and
        `drive.torque_nm`, which keeps the rated torque on the output. They are columns of their own.
    out
        Folder for the rows as they come; a sweep that was stopped goes on there. None: nothing is written.
    engine
        Where the work is done.
    progress
        Called after each point.

    Returns
    -------
    The sweep, a table that pandas, polars and DuckDB take; a point that failed has its error there.

    Raises
    ------
    UsageError
        There is no such key or measure, a value is none of the key, or the folder is of another sweep.
    CycloidError
        The folder cannot be written; rows that were there are kept.
    RunError
        The engine's workers are lost, or of other versions.
    """
    design = resolve(design)
    reducer = Reducer(design)
    where = chosen(vary, table, sample, points, seed)
    task = task_of(reducer, where, [measure] if isinstance(measure, str) else measure, quick, real_pins, follow, solver)
    if out is None:
        rows: dict[int, PointResult] = {}
        _fill(task, where, rows, rows.__setitem__, engine, progress)
        return Sweep(task, where, rows)
    return in_folder(task, where, _created(Path(out)), engine, progress)


def task_of(
    reducer: Reducer,
    points: Points,
    measures: Iterable[str],
    quick: bool,
    real_pins: bool,
    follow: str | Sequence[str] = (),
    solver: Solver = "planar",
) -> Task:
    """Return what is done at each point; measures are named one by one or as ``a,b``."""
    names = require_measures(name.strip() for words in measures for name in words.split(","))
    options = MeasureSettings(quick, real_pins or "ring.pins" in points.keys, solver)
    return Task(reducer, points.keys, names, options, following(reducer, follow, points.keys))


def in_folder(task: Task, points: Points, into: Path, engine: Engine, progress: Progress) -> Sweep:
    """Measure the points that a folder lacks; its tables are written now and then, and whatever ends the sweep.

    Raises
    ------
    UsageError
        The folder is of another sweep, or another process is at work in it.
    CycloidError
        It cannot be written; rows that were there are kept.
    RunError
        The engine's workers are lost, or of other versions.
    """
    with journal(into, _plan(task, points)) as kept:
        due = monotonic() + SECONDS_BETWEEN_TABLES

        def keep(place: int, row: PointResult) -> None:
            nonlocal due
            # they are much the same in all rows
            kept.add(place, replace(row, assumptions=()) if any(one.assumptions for one in kept.rows.values()) else row)
            if (start := monotonic()) > due:
                write_csv(Sweep(task, points, kept.rows).frame, into / TABLE)
                due = monotonic() + max(SECONDS_BETWEEN_TABLES, MOST_SHARE_OF_TABLES * (monotonic() - start))

        try:
            _fill(task, points, kept.rows, keep, engine, progress)
        except BaseException:
            with suppress(CycloidError):
                write_tables(Sweep(task, points, kept.rows), into)
            raise
        swept = Sweep(task, points, kept.rows)
        write_tables(swept, into)
    return swept


def _fill(
    task: Task,
    points: Points,
    rows: Mapping[int, PointResult],
    keep: Callable[[int, PointResult], None],
    engine: Engine,
    progress: Progress,
) -> None:
    """Measure the points that have no row yet."""
    missing = [place for place in range(len(points)) if place not in rows]
    work = partial(measured_row, task)
    stream = engine.stream(work, [points.rows[place] for place in missing], lambda _, why: PointResult(error=why))
    for done, (item, row) in enumerate(stream, 1):
        keep(missing[item], row)
        progress(done, len(missing))


def write_tables(sweep: Sweep, into: Path) -> None:
    """Write the table of a sweep as CSV, and as Parquet where DuckDB is installed; raise CycloidError if that fails."""
    write_csv(sweep.frame, into / TABLE)
    if find_spec("duckdb"):
        write_parquet(sweep.frame, into / PARQUET, {"assumptions": list(sweep.assumptions)})


def _plan(task: Task, points: Points) -> dict[str, Any]:
    """Collect what tells a sweep from others: rows of another one do not belong in its folder."""
    return {
        "design": dump(task.reducer.design),
        "keys": list(task.keys),
        "points": {"count": len(points), "digest": points.digest},
        "measures": list(task.measures),
        "options": asdict(task.options),
        "follows": {follower.key: follower.words for follower in task.followers},
        "versions": dict(versions()),
    }


def _created(into: Path) -> Path:
    try:
        make_folder(into)
    except OSError as problem:
        raise CycloidError(
            f"cannot make the folder {into} for the sweep: {reason(problem)}; choose another with --out"
        ) from problem
    return into


def chosen(
    vary: Mapping[str, Wanted] | None,
    table: Iterable[Mapping[str, Any]] | None,
    sample: Method | None,
    points: int,
    seed: int,
) -> Points:
    """List the points that a call or command asks for; raise UsageError if it asks for none, or for two kinds."""
    if bool(vary) == (table is not None):
        raise UsageError("give the points of a sweep by --vary KEY=VALUES, or by --table POINTS.csv")
    if table is not None:
        if sample is not None:
            raise UsageError("--sample draws from the ranges of --vary: leave it out with --table")
        return tabled(table)
    vary = vary or {}
    if sample is None:
        if points:
            raise UsageError("--points says how many to draw: give --sample sobol, lhs or random as well")
        return grid(vary)
    return sampled(vary, sample, points, seed)
