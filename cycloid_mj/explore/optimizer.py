"""Optimisation: search, evaluation and record of points, and the checks of the best."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from cycloid_mj.base.atomic_write import write_files
from cycloid_mj.base.engine import Engine, Progress, silent, versions
from cycloid_mj.base.errors import CycloidError, DesignError, RunError
from cycloid_mj.base.extras import extra
from cycloid_mj.base.frame import write_csv, write_parquet
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.checks import require_sound
from cycloid_mj.design import Named, dump, resolve
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.explore.journal import create_folder, open_journal
from cycloid_mj.explore.optimum import BestChecks, Optimum
from cycloid_mj.explore.points import Wanted
from cycloid_mj.explore.problem import FEASIBLE, Problem, define_problem, evaluate_point
from cycloid_mj.explore.row import PointResult
from cycloid_mj.explore.sampling import tolerance_zones
from cycloid_mj.explore.search import CMA, REQUIREMENT, Point, search_minimum
from cycloid_mj.explore.tolerances import TooManyJams, tolerance
from cycloid_mj.explore.verify import verify_design
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet import Sheet, sheet

STUDY = "optimize"
HISTORY, BEST = "history.csv", "best.toml"
PARQUET = "history.parquet"


@dataclass(frozen=True)
class OptimizerSettings:
    """Defaults of an optimization, and the searches for a front (augmented Chebyshev, Steuer and Choo 1983)."""

    evaluations: int = 600
    starts: int = 3
    """Evaluations, and independent starts."""
    tolerance_samples: int = 2000
    """Samples of the tolerance study of the best design."""
    weights: tuple[float, ...] = (0.0, 1.0, 0.5, 0.25, 0.75, 0.1, 0.9)
    """Weights of the first objective in the searches for a front; the ends come first, as they scale the others."""
    sum_weight: float = 0.01
    """Weight of the sum in the augmented Chebyshev scalarization, which excludes weakly optimal points."""
    front_sigma: float = 0.15
    """First standard deviation of the searches between the ends, relative to the ranges; they start at the best so
    far."""
    min_point_cpu: float = 0.01
    """CPU time of a point [s] below which sending it to another process takes longer than evaluating it."""


OPTIMIZER = OptimizerSettings()


PROCESSES = Engine()
"""All cores of this machine."""


@shows_progress
def optimize(
    design: Named,
    vary: Mapping[str, Wanted],
    minimize: str | Sequence[str] = (),
    maximize: str | Sequence[str] = (),
    limits: str | Sequence[str] = (),
    *,
    evaluations: int = OPTIMIZER.evaluations,
    starts: int = OPTIMIZER.starts,
    seed: int = 0,
    strict: bool = False,
    follow: str | Sequence[str] = (),
    verify: bool = True,
    solver: Solver = "planar",
    out: str | Path | None = None,
    engine: Engine = PROCESSES,
    progress: Progress = silent,
) -> Optimum:
    """Find the best design within ranges of some keys, or a Pareto front of two objectives.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file: the start.
    vary
        Key of the design file -> ``lo:hi`` or a pair, for real numbers; whole numbers are tried one by one, as values
        ``a,b,c`` of any key are.
    minimize, maximize
        Figures by their keys in the catalogue (`cycloid_mj.figures.FIGURES`), of geometry, statics and life: one in
        total, or two for a front.
    limits
        Limits on such figures, ``"backlash_arcmin<=1"``. The checks of a design always apply.
    evaluations, starts, seed
        Approximate number of points; number of independent searches; random seed.
    strict
        Whether warnings of the checks reject a point, too.
    follow
        Keys that follow those of `vary`: ``KEY=FORMULA`` of numbers and keys, in the file's units. By default the hole
        of an output pin follows pin and eccentricity, and the drive's torque follows the ratio; ``KEY=NUMBER`` fixes
        one of them.
    verify
        Whether the best design is run in full dynamics, and studied within its tolerances where it has some.
    solver
        Solver of that run.
    out
        Folder of the history, to which every point is added at once, and of the best design.
    engine
        Where the points are evaluated.
    progress
        Called after each point.

    Returns
    -------
    Optimum
        Evaluated points, and the best point or the Pareto front with its designs.

    Raises
    ------
    UsageError
        There is no such key or figure, a range is not valid, or the folder belongs to another optimisation.
    DesignError
        No point satisfies all checks and limits; it states how many each of them rejects.
    CycloidError
        The folder cannot be written; its rows are kept.
    """
    reducer = Reducer(resolve(design))
    task = define_problem(reducer, vary, _as_tuple(minimize), _as_tuple(maximize), _as_tuple(limits), strict, follow)
    optimum = run_search(task, evaluations, starts, seed, out, engine, progress)
    if optimum.best is None:
        raise DesignError(optimum.infeasible_words)
    if verify:
        optimum = check_best(optimum, solver)
    if out is not None:
        write_files({Path(out) / BEST: dump(optimum.design()).encode()})
    return optimum


def _as_tuple(words: str | Sequence[str]) -> tuple[str, ...]:
    return (words,) if isinstance(words, str) else tuple(words)


def run_search(
    task: Problem, evaluations: int, starts: int, seed: int, out: str | Path | None, engine: Engine, progress: Progress
) -> Optimum:
    """Run the searches; however they end, the history in the folder has all points that were evaluated."""
    if task.ranges:
        extra("cma", *REQUIREMENT)
    with _recorded_rows(task, evaluations, starts, seed, out) as rows:
        work = _Work(task, rows, engine, progress, evaluations)
        try:
            work.rows_of([task.start])
            _search(task, work, evaluations, starts, seed)
        finally:
            optimum = Optimum(task, work.in_order, seed)
            if out is not None:
                _write_history(optimum, Path(out))
    return optimum


def check_best(optimum: Optimum, solver: Solver = "planar", progress: Progress = silent) -> Optimum:
    """Return the optimisation with checks of its best design: statics, dynamics, and tolerances where it has some."""
    best = optimum.design()
    try:
        zones, samples = tolerance_zones(Reducer(best)), OPTIMIZER.tolerance_samples
        ranges = tolerance(best, samples, optimum.seed, progress=progress) if zones else None
    except TooManyJams as jam:
        ranges = jam.tolerances
    sheets = _sheet(Reducer(best)), _sheet(optimum.task.reducer)
    checks = BestChecks(*sheets, verify_design(Reducer(best), solver), ranges)
    return Optimum(optimum.task, optimum.rows, optimum.seed, checks)


def _sheet(reducer: Reducer) -> Sheet | None:
    """Return the static sheet of a design; None where it cannot be built or balanced."""
    try:
        require_sound(reducer)
        return sheet(reducer)
    except CycloidError:
        return None


def _search(task: Problem, work: "_Work", evaluations: int, starts: int, seed: int) -> None:
    """Search for the best point, or in turn for several points of the front."""
    if len(task.objectives) == 1:
        search_minimum(task, work.rows_of, lambda row: task.costs(row)[0], evaluations, starts, [seed])
        return
    each = max(1, evaluations // len(OPTIMIZER.weights))
    for number, weight in enumerate(OPTIMIZER.weights):
        figure = _weighted(task, work.in_order, weight)
        feasible = [row for row in work.in_order if row.values[FEASIBLE]] if number > 1 else []
        first = _point(task, min(feasible, key=figure)) if feasible else None
        sigma = OPTIMIZER.front_sigma if first else CMA.initial_sigma
        search_minimum(task, work.rows_of, figure, each, starts if number < 2 else 1, [seed, number], first, sigma)


def _weighted(task: Problem, rows: Sequence[PointResult], weight: float) -> Callable[[PointResult], float]:
    """Return the augmented weighted Chebyshev scalarization of both objectives, normalized by their ranges so far.

    Steuer and Choo 1983 (Math. Program. 26, 326-344); `weight` is that of the first objective.
    """
    feasible = [row for row in rows if row.values[FEASIBLE]]
    both = [task.costs(row) for row in feasible] or [(0.0, 0.0)]
    low = [min(cost) for cost in zip(*both, strict=True)]
    best = [min(both), min(both, key=lambda cost: cost[1])]
    reach = [abs(best[1 - i][i] - low[i]) or abs(low[i]) or 1.0 for i in (0, 1)]

    def figure(row: PointResult) -> float:
        shares = [(cost - low[i]) / reach[i] for i, cost in enumerate(task.costs(row))]
        weighted = [weight * shares[0], (1.0 - weight) * shares[1]]
        return (max(weighted) if 0.0 < weight < 1.0 else sum(weighted)) + OPTIMIZER.sum_weight * sum(shares)

    return figure


def _point(task: Problem, row: PointResult) -> Point:
    return tuple(row.values[key] for key in task.keys)


class _Work:
    """Evaluates batches of points and records each row; rows of an interrupted search are used again."""

    def __init__(self, task: Problem, rows: "_Rows", engine: Engine, progress: Progress, total: int) -> None:
        self._task, self._rows, self._engine, self._progress, self._total = task, rows, engine, progress, total
        self._count = 0
        self._slow = False

    @property
    def in_order(self) -> list[PointResult]:
        """All rows of the points requested so far, in their order."""
        return [self._rows.by_index[index] for index in range(self._count) if index in self._rows.by_index]

    def rows_of(self, points: Sequence[Point]) -> list[PointResult]:
        """Evaluate points; return their rows."""
        first = self._count
        self._count += len(points)
        missing = [index for index in range(first, self._count) if not self._is_known(index, points[index - first])]
        engine = self._engine if self._slow else Engine(1)
        remaining = [points[index - first] for index in missing]
        for item, row in engine.stream(partial(evaluate_point, self._task), remaining, _raise_lost):
            self._rows.add(missing[item], row)
            if len(self._rows.by_index) <= self._total:  # the last generation may go beyond
                self._progress(len(self._rows.by_index), self._total)
        rows = [self._rows.by_index[index] for index in range(first, self._count)]
        self._slow = max(row.cpu for row in rows) > OPTIMIZER.min_point_cpu
        return rows

    def _is_known(self, index: int, point: Point) -> bool:
        """Return whether the row of a point is recorded; raise CycloidError where it is that of another point."""
        row = self._rows.by_index.get(index)
        if row is None:
            return False
        if _point(self._task, row) != point:
            raise CycloidError(
                f"row {index + 1} of the results in the output folder belongs to another search: choose another folder "
                "with --out"
            )
        return True


def _raise_lost(_: int, why: str) -> PointResult:
    raise RunError(
        f"a point of the search could not be evaluated: {why}. Run the same command again to resume, with fewer "
        "--workers"
    )


class _Rows:
    """Rows by index, in memory or in a file as well."""

    def __init__(self, rows: dict[int, PointResult], add: Callable[[int, PointResult], None]) -> None:
        self.by_index, self.add = rows, add


@contextmanager
def _recorded_rows(task: Problem, evaluations: int, starts: int, seed: int, out: str | Path | None) -> Iterator[_Rows]:
    """Open the rows of a search, in the folder `out` or in memory, as a context."""
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
    with open_journal(create_folder(Path(out)), plan, STUDY) as journal:
        yield _Rows(journal.rows, journal.add)


def _write_history(optimum: Optimum, into: Path) -> None:
    if not optimum.rows:
        return
    write_csv(optimum.frame, into / HISTORY)
    if find_spec("duckdb"):
        write_parquet(optimum.frame, into / PARQUET, {"seed": optimum.seed})
