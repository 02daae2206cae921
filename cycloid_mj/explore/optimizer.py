"""Optimisation: search, evaluation and record of points, and the checks of the best."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from cycloid_mj.base.atomic_write import write_files
from cycloid_mj.base.engine import Engine, Progress, silent, versions
from cycloid_mj.base.errors import CycloidError, RunError
from cycloid_mj.base.extras import import_extra
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
from cycloid_mj.explore.search import CMA, REQUIREMENT, Point, search_minimum
from cycloid_mj.explore.tolerance_zones import has_tolerances
from cycloid_mj.explore.tolerances import TooManyJams, tolerance
from cycloid_mj.explore.verify import verify_design
from cycloid_mj.reducer import Reducer, reducer_of
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
    """Find the best design within ranges of some keys, or a Pareto front of two objectives, by CMA-ES.

    Parameters
    ----------
    design
        The start: a design, or the name of a preset or a file.
    vary
        Range ``lo:hi`` (or a pair of numbers) or list of values ``a,b,c`` of each key of the design file. A range of a
        whole number stands for all whole numbers in it.
    minimize, maximize
        Keys of `cycloid_mj.figures.FIGURES`, of geometry, statics and life: one in total, or two for a front.
    limits
        Limits on such quantities, ``"backlash_arcmin<=1"``, in addition to the checks of a design.
    strict
        Whether failed checks with the severity warning reject a point, too.
    evaluations, starts, seed
        Approximate number of points; number of independent searches; random seed.
    follow
        Keys computed from others: ``KEY=FORMULA`` of numbers and keys, in the file's units; ``KEY=NUMBER`` fixes a key.
        By default the hole of an output pin follows pin and eccentricity, and the drive's torque follows the ratio.
    verify, solver
        Whether to simulate the best design and to study its tolerances, if it has any; solver of the simulation.
    out
        Folder of the history, to which every point is added at once, and of the best design.
    engine, progress
        Where the points are evaluated; called after each point with the numbers of finished and of all points.

    Returns
    -------
    Evaluated points, and the best point or the Pareto front with its designs.

    Raises
    ------
    UsageError
        A key or quantity does not exist, a range is invalid, or the folder belongs to another optimisation.
    DesignError
        No point satisfies all checks and limits; it states how many each of them rejects.
    """
    task = define_problem(reducer_of(resolve(design)), vary, minimize, maximize, limits, strict, follow)
    optimum = run_search(task, evaluations, starts, seed, out, engine, progress)
    write_best(optimum, out)
    return add_checks_of_best(optimum, solver) if verify else optimum


def run_search(
    task: Problem, evaluations: int, starts: int, seed: int, out: str | Path | None, engine: Engine, progress: Progress
) -> Optimum:
    """Run the searches of an optimisation by CMA-ES; return all evaluated points with the best of them.

    The history in the folder `out` has all points that were evaluated, also if the search is interrupted or fails.

    Parameters
    ----------
    evaluations, starts, seed
        Approximate number of points; number of independent searches; random seed.
    out
        Folder of the history; None keeps it in memory.
    engine, progress
        Where the points are evaluated; called after each point with the numbers of finished and of all points.
    """
    if task.ranges:
        import_extra("cma", *REQUIREMENT)
    with _open_record(task, evaluations, starts, seed, out) as rows:
        evaluator = _PointEvaluator(task, rows, engine, progress, evaluations)
        try:
            evaluator.evaluate_points([task.start])
            _run_searches(task, evaluator, evaluations, starts, seed)
        finally:
            optimum = Optimum(task, evaluator.in_order, seed)
            if out is not None:
                _write_history(optimum, Path(out))
    return optimum


def write_best(optimum: Optimum, out: str | Path | None) -> None:
    """Write the best design into the folder `out`, unless it is None; raise DesignError if no point is feasible."""
    file_content = dump(optimum.design()).encode()
    if out is not None:
        write_files({Path(out) / BEST: file_content})


def add_checks_of_best(optimum: Optimum, solver: Solver = "planar") -> Optimum:
    """Return a copy of the result of an optimisation with further evaluations of its best design.

    The evaluations are the static data sheets of the best design and of the start, a run in full dynamics with
    `solver`, and a tolerance study if the design has tolerances.
    """
    best_reducer = reducer_of(optimum.design())
    try:
        sample_count = OPTIMIZER.tolerance_samples
        tolerance_study = (
            tolerance(best_reducer.design, sample_count, optimum.seed) if has_tolerances(best_reducer) else None
        )
    except TooManyJams as error:
        tolerance_study = error.tolerances
    sheets = _compute_sheet(best_reducer), _compute_sheet(optimum.task.reducer)
    checks = BestChecks(*sheets, verify_design(best_reducer, solver), tolerance_study)
    return Optimum(optimum.task, optimum.rows, optimum.seed, checks)


def _compute_sheet(reducer: Reducer) -> Sheet | None:
    """Return the static sheet of a design; None where it cannot be built or balanced."""
    try:
        require_sound(reducer)
        return sheet(reducer)
    except CycloidError:
        return None


def _run_searches(task: Problem, evaluator: "_PointEvaluator", evaluations: int, starts: int, seed: int) -> None:
    """Search for the best point of a problem by CMA-ES, with two objectives one search for each weight of the first.

    `task` is the problem. The `evaluations` are divided equally among the weights `OptimizerSettings.weights`. The
    first two weights are those of a single objective; their searches start at the design. The other searches start at
    the best point so far, with a smaller standard deviation and a single start. `evaluator` records the evaluated
    points. `starts` is the number of independent searches, `seed` the random seed.
    """
    if len(task.objectives) == 1:
        search_minimum(task, evaluator.evaluate_points, lambda row: task.costs(row)[0], evaluations, starts, [seed])
        return
    evaluations_per_weight = max(1, evaluations // len(OPTIMIZER.weights))
    for search_number, weight in enumerate(OPTIMIZER.weights):
        cost = _chebyshev_cost(task, evaluator.in_order, weight)
        feasible = [row for row in evaluator.in_order if row.values[FEASIBLE]] if search_number > 1 else []
        start_point = _values_of_row(task, min(feasible, key=cost)) if feasible else None
        sigma = OPTIMIZER.front_sigma if start_point else CMA.initial_sigma
        search_minimum(
            task,
            evaluator.evaluate_points,
            cost,
            evaluations_per_weight,
            starts if search_number < 2 else 1,
            [seed, search_number],
            start_point,
            sigma,
        )


def _chebyshev_cost(task: Problem, rows: Sequence[PointResult], weight: float) -> Callable[[PointResult], float]:
    """Return the cost function that merges two objectives: the augmented weighted Chebyshev scalarization.

    Steuer and Choo 1983 (Math. Program. 26, 326-344). Objectives are normalized by their ranges between the best points
    of either objective.

    Parameters
    ----------
    rows
        The points evaluated so far.
    weight
        Weight of the first objective, 0 to 1. At the ends, 0 and 1, the cost is that of one objective.
    """
    feasible_rows = [row for row in rows if row.values[FEASIBLE]]
    costs = [task.costs(row) for row in feasible_rows] or [(0.0, 0.0)]
    ideal_point = [min(column) for column in zip(*costs, strict=True)]
    front_ends = [min(costs), min(costs, key=lambda costs_of_row: costs_of_row[1])]
    ranges = [abs(front_ends[1 - i][i] - ideal_point[i]) or abs(ideal_point[i]) or 1.0 for i in (0, 1)]

    def scalarized_cost(row: PointResult) -> float:
        normalized_costs = [(cost - ideal_point[i]) / ranges[i] for i, cost in enumerate(task.costs(row))]
        weighted_costs = [weight * normalized_costs[0], (1.0 - weight) * normalized_costs[1]]
        return (max(weighted_costs) if 0.0 < weight < 1.0 else sum(weighted_costs)) + OPTIMIZER.sum_weight * sum(
            normalized_costs
        )

    return scalarized_cost


def _values_of_row(task: Problem, row: PointResult) -> Point:
    return tuple(row.values[key] for key in task.keys)


class _PointEvaluator:
    """Evaluates batches of points and records each row; rows of an interrupted search are used again."""

    def __init__(self, task: Problem, rows: "_Rows", engine: Engine, progress: Progress, total: int) -> None:
        self._task, self._rows, self._engine, self._progress, self._total = task, rows, engine, progress, total
        self._count = 0
        self._slow = False

    @property
    def in_order(self) -> list[PointResult]:
        """All rows of the points requested so far, in their order."""
        return [self._rows.by_index[index] for index in range(self._count) if index in self._rows.by_index]

    def evaluate_points(self, points: Sequence[Point]) -> list[PointResult]:
        """Evaluate points of an optimisation, record their results, and return these in order.

        Recorded points are not evaluated again.

        Raises
        ------
        RunError
            The process that evaluates a point was lost.
        CycloidError
            The record has other points, or cannot be written.
        """
        first_index = self._count
        self._count += len(points)
        missing_indices = [
            index for index in range(first_index, self._count) if not self._is_known(index, points[index - first_index])
        ]
        engine = self._engine if self._slow else Engine(1)
        missing_points = [points[index - first_index] for index in missing_indices]

        def raise_lost(position: int, cause: str) -> PointResult:
            keys_and_values = zip(self._task.keys, missing_points[position], strict=True)
            values = ", ".join(f"{key} = {value}" for key, value in keys_and_values)
            raise RunError(
                f"point {missing_indices[position] + 1} of the search ({values}) could not be evaluated: {cause}. "
                "Run the same command again with fewer processes, such as --workers 1, to resume"
            )

        for position, row in engine.stream(partial(evaluate_point, self._task), missing_points, raise_lost):
            self._rows.add(missing_indices[position], row)
            if len(self._rows.by_index) <= self._total:  # the last generation may go beyond
                self._progress(len(self._rows.by_index), self._total)
        rows = [self._rows.by_index[index] for index in range(first_index, self._count)]
        self._slow = max(row.cpu for row in rows) > OPTIMIZER.min_point_cpu
        return rows

    def _is_known(self, index: int, point: Point) -> bool:
        """Return whether the point of this index is already recorded.

        Raises CycloidError if the record has another point at this index.
        """
        row = self._rows.by_index.get(index)
        if row is None:
            return False
        if _values_of_row(self._task, row) != point:
            raise CycloidError(
                f"row {index + 1} of the results in the output folder belongs to another search, because its parameter "
                "values differ from those of this search: choose another folder with --out"
            )
        return True


class _Rows:
    """Rows by index, in memory or in a file as well."""

    def __init__(self, rows: dict[int, PointResult], add: Callable[[int, PointResult], None]) -> None:
        self.by_index, self.add = rows, add


@contextmanager
def _open_record(task: Problem, evaluations: int, starts: int, seed: int, out: str | Path | None) -> Iterator[_Rows]:
    """Open the record of evaluated points as a context that yields it: in memory, or in the folder `out`.

    The record has the known results by index of the point, and a function that adds one. A search in a folder is
    resumed if the `task`, that is the problem, the number of evaluations, starts, seed and package versions are the
    same.
    """
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


def _write_history(optimum: Optimum, folder: Path) -> None:
    if not optimum.rows:
        return
    write_csv(optimum.frame, folder / HISTORY)
    if find_spec("duckdb"):
        write_parquet(optimum.frame, folder / PARQUET, {"seed": optimum.seed})
