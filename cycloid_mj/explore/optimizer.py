"""The course of an optimisation: points are searched, evaluated and kept; the best is checked."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from cycloid_mj.base.atomic_write import write_whole
from cycloid_mj.base.engine import Engine, Progress, silent, versions
from cycloid_mj.base.errors import CycloidError, DesignError, RunError, reason
from cycloid_mj.base.extras import extra
from cycloid_mj.base.frame import write_csv, write_parquet
from cycloid_mj.base.overwrite_guard import make_folder
from cycloid_mj.checks import require_sound
from cycloid_mj.design import Named, dump, resolve
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.explore.journal import journal
from cycloid_mj.explore.optimum import Checked, Optimum
from cycloid_mj.explore.points import Wanted
from cycloid_mj.explore.problem import FEASIBLE, Problem, evaluated, problem
from cycloid_mj.explore.row import PointResult
from cycloid_mj.explore.sampling import tolerances
from cycloid_mj.explore.search import NEED, Point, searched
from cycloid_mj.explore.tolerances import TooManyJams, tolerance
from cycloid_mj.explore.verify import verified
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet import Sheet, sheet

STUDY = "optimize"
HISTORY, BEST = "history.csv", "best.toml"
PARQUET = "history.parquet"

EVALUATIONS, STARTS = 600, 3
SAMPLES = 2000
"""Of the best design, where it has tolerances."""

WEIGHTS = (0.0, 1.0, 0.5, 0.25, 0.75, 0.1, 0.9)
"""Of the first objective in each search for a front: its ends first, which say how far it reaches."""

SLIGHT = 0.01
"""Weight of the sum of both objectives beside the larger one: no point of a front can be bettered in one alone."""

NARROW = 0.15
"""First standard deviation of the searches between the ends, which start from the best so far."""

FAST = 0.01
"""CPU time of a point [s] below which handing it to another process takes longer."""

PROCESSES = Engine()
"""All cores of this machine."""


def optimize(
    design: Named,
    vary: Mapping[str, Wanted],
    minimize: str | Sequence[str] = (),
    maximize: str | Sequence[str] = (),
    limits: str | Sequence[str] = (),
    *,
    evaluations: int = EVALUATIONS,
    starts: int = STARTS,
    seed: int = 0,
    strict: bool = False,
    follow: str | Sequence[str] = (),
    verify: bool = True,
    solver: Solver = "planar",
    out: str | Path | None = None,
    engine: Engine = PROCESSES,
    progress: Progress = silent,
) -> Optimum:
    """Find the best design within ranges of some keys.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file: the start.
    vary
        Key of the design file -> ``lo:hi`` or a pair, for real numbers; whole numbers are tried one by one, as values
        ``a,b,c`` of any key are.
    minimize, maximize
        Figures by their keys in the catalogue (`cycloid_mj.figures.FIGURES`), of geometry, statics and life. One in
        all, or two for a front.
    limits
        On such figures, ``"backlash_arcmin<=1"``. The checks of a design are limits of their own.
    evaluations, starts, seed
        About how many points; searches from different starts; seed of all draws.
    strict
        Whether warnings of the checks refuse a point, too.
    follow
        Keys that change with those of `vary`: ``KEY=FORMULA`` of numbers and keys, in the file's units. By themselves
        the hole of an output pin follows pin and eccentricity, and the drive's torque the ratio; ``KEY=NUMBER`` holds
        one of them.
    verify
        Whether the best is run in full dynamics, and within its tolerances where it has some.
    solver
        What takes the steps of that run.
    out
        Folder of the history, to which every point is added as it comes, and of the best design.
    engine
        Where the work is done.
    progress
        Called after each point.

    Raises
    ------
    UsageError
        There is no such key or figure, a range is none, or the folder is of another optimisation.
    DesignError
        No point keeps all checks and limits; it says what refused how many.
    CycloidError
        The folder cannot be written; what was there is kept.
    """
    design = resolve(design)
    reducer = Reducer(design)
    task = problem(reducer, vary, _several(minimize), _several(maximize), _several(limits), strict, follow)
    optimum = explored(task, evaluations, starts, seed, out, engine, progress)
    if optimum.best is None:
        raise DesignError(optimum.hopeless)
    if verify:
        optimum = checked(optimum, solver)
    if out is not None:
        write_whole({Path(out) / BEST: dump(optimum.design()).encode()})
    return optimum


def _several(words: str | Sequence[str]) -> tuple[str, ...]:
    return (words,) if isinstance(words, str) else tuple(words)


def explored(
    task: Problem, evaluations: int, starts: int, seed: int, out: str | Path | None, engine: Engine, progress: Progress
) -> Optimum:
    """Search; whatever ends it, the history in the folder is of all points that were evaluated."""
    if task.ranges:
        extra("cma", *NEED)
    with _kept(task, evaluations, starts, seed, out) as rows:
        work = _Work(task, rows, engine, progress, evaluations)
        try:
            work.rows_of([task.start])
            _search(task, work, evaluations, starts, seed)
        finally:
            optimum = Optimum(task, work.in_order, seed)
            if out is not None:
                _write_history(optimum, Path(out))
    return optimum


def checked(optimum: Optimum, solver: Solver = "planar", progress: Progress = silent) -> Optimum:
    """Check the best design of an optimisation: full statics, dynamics, and tolerances where it has some."""
    best = optimum.design()
    try:
        ranges = tolerance(best, SAMPLES, optimum.seed, progress=progress) if tolerances(Reducer(best)) else None
    except TooManyJams as jam:
        ranges = jam.tolerances
    return Optimum(
        optimum.task,
        optimum.rows,
        optimum.seed,
        Checked(_sheet(Reducer(best)), _sheet(optimum.task.reducer), verified(Reducer(best), solver), ranges),
    )


def _sheet(reducer: Reducer) -> Sheet | None:
    """Return the full statics of a design; None where it cannot be built, or has no balance in one of its states."""
    try:
        require_sound(reducer)
        return sheet(reducer)
    except CycloidError:
        return None


def _search(task: Problem, work: "_Work", evaluations: int, starts: int, seed: int) -> None:
    if len(task.objectives) == 1:
        (one,) = task.objectives
        searched(task, work.rows_of, lambda row: one.sign * float(row.values[one.key]), evaluations, starts, [seed])
        return
    each = max(1, evaluations // len(WEIGHTS))
    for place, weight in enumerate(WEIGHTS):
        figure = _weighted(task, work.in_order, weight)
        kept = [row for row in work.in_order if row.values[FEASIBLE]] if place > 1 else []
        first = _point(task, min(kept, key=figure)) if kept else None
        more = {"width": NARROW} if first else {}
        searched(task, work.rows_of, figure, each, starts if place < 2 else 1, [seed, place], first, **more)


def _weighted(task: Problem, rows: Sequence[PointResult], weight: float) -> Callable[[PointResult], float]:
    """Return both objectives as one: the larger of the two, weighted, each over its reach so far (Chebyshev's norm)."""
    kept = [row for row in rows if row.values[FEASIBLE]]

    def costs(row: PointResult) -> tuple[float, ...]:
        return tuple(objective.sign * float(row.values[objective.key]) for objective in task.objectives)

    both = [costs(row) for row in kept] or [(0.0, 0.0)]
    low = [min(cost) for cost in zip(*both, strict=True)]
    best = [min(both), min(both, key=lambda cost: cost[1])]
    reach = [abs(best[1 - i][i] - low[i]) or abs(low[i]) or 1.0 for i in (0, 1)]

    def figure(row: PointResult) -> float:
        shares = [(cost - low[i]) / reach[i] for i, cost in enumerate(costs(row))]
        weighted = [weight * shares[0], (1.0 - weight) * shares[1]]
        # at the ends of a front the other objective counts slightly
        return (max(weighted) if 0.0 < weight < 1.0 else sum(weighted)) + SLIGHT * sum(shares)

    return figure


def _point(task: Problem, row: PointResult) -> Point:
    return tuple(row.values[key] for key in task.keys)


class _Work:
    """Evaluates points, a batch at a time, and keeps every row as it comes; rows of a search that was stopped serve."""

    def __init__(self, task: Problem, rows: "_Rows", engine: Engine, progress: Progress, whole: int) -> None:
        self._task, self._rows, self._engine, self._progress, self._whole = task, rows, engine, progress, whole
        self._count = 0
        self._slow = False

    @property
    def in_order(self) -> list[PointResult]:
        """All rows up to the first that is missing."""
        return [self._rows.by_place[place] for place in range(self._count) if place in self._rows.by_place]

    def rows_of(self, points: Sequence[Point]) -> list[PointResult]:
        """List the rows of points."""
        first = self._count
        self._count += len(points)
        missing = [place for place in range(first, self._count) if not self._is_there(place, points[place - first])]
        engine = self._engine if self._slow else Engine(1)
        todo = [points[place - first] for place in missing]
        for item, row in engine.stream(partial(evaluated, self._task), todo, _lost):
            self._rows.add(missing[item], row)
            if len(self._rows.by_place) <= self._whole:  # the last generation may go beyond
                self._progress(len(self._rows.by_place), self._whole)
        rows = [self._rows.by_place[place] for place in range(first, self._count)]
        self._slow = max(row.cpu for row in rows) > FAST
        return rows

    def _is_there(self, place: int, point: Point) -> bool:
        row = self._rows.by_place.get(place)
        if row is None:
            return False
        if _point(self._task, row) != point:
            raise CycloidError(
                f"row {place + 1} of this folder is of another point than this search takes: choose another folder"
            )
        return True


def _lost(_: int, why: str) -> PointResult:
    raise RunError(f"a point could not be evaluated: {why}")


class _Rows:
    """Rows by place, in memory alone or in a file as well."""

    def __init__(self, rows: dict[int, PointResult], add: Callable[[int, PointResult], None]) -> None:
        self.by_place, self.add = rows, add


@contextmanager
def _kept(task: Problem, evaluations: int, starts: int, seed: int, out: str | Path | None) -> Iterator[_Rows]:
    if out is None:
        rows: dict[int, PointResult] = {}
        yield _Rows(rows, rows.__setitem__)
        return
    plan = {
        "design": dump(task.reducer.design),
        "vary": [asdict(variable) for variable in task.variables],
        "objectives": [str(objective) for objective in task.objectives],
        "limits": [str(limit) for limit in task.limits],
        "strict": task.strict,
        "follows": task.follows,
        "evaluations": evaluations,
        "starts": starts,
        "seed": seed,
        "versions": dict(versions()),
    }
    into = Path(out)
    try:
        make_folder(into)
    except OSError as error:
        raise CycloidError(f"cannot make the folder {into}: {reason(error)}; choose another with --out") from error
    with journal(into, plan, STUDY) as kept:
        yield _Rows(kept.rows, kept.add)


def _write_history(optimum: Optimum, into: Path) -> None:
    if not optimum.rows:
        return
    write_csv(optimum.frame, into / HISTORY)
    if find_spec("duckdb"):
        write_parquet(optimum.frame, into / PARQUET, {"seed": optimum.seed})
