"""Monte Carlo study of a design within its tolerances: distributions, yield, jams, and an error budget."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from statistics import NormalDist
from typing import Any

import numpy as np

from cycloid_mj.base.arguments import require_count
from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.engine import Engine, Progress, silent
from cycloid_mj.base.errors import CycloidError, RunError, UsageError
from cycloid_mj.base.frame import Frame, Tabular
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.result import Table
from cycloid_mj.design import Design, Named, resolve
from cycloid_mj.design.zone import Zone
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.explore import rv_samples, sampling
from cycloid_mj.explore.budget import (
    SOBOL,
    Share,
    compute_shares,
    find_usable_rows,
    list_budget_sets,
    size_of_budget_sets,
)
from cycloid_mj.explore.constraints import FigureLimit, parse_limit, require_consistent
from cycloid_mj.explore.jam import JAM, PRELOADS, compute_preload_shares, explain_jams, find_jams, stops_study
from cycloid_mj.explore.verify import DynamicsCheck, table_rows, verify_design
from cycloid_mj.figures import SAMPLED, Figure, compute_sampled, figure
from cycloid_mj.figures.sampled import ANGLES, condition
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.reducer.sockets import require_one_ring
from cycloid_mj.statics.samples import Samples, identical_samples

THREADS = Engine(kind="threads")
"""Samples are balanced by compiled code that releases Python's lock."""

CONSTANT_RTOL = 1e-9
"""Relative range of a figure up to which it counts as constant: rounding errors are below."""


MAX_INTERVAL_WIDTH = 0.2
"""Width of the 95 % interval of a share above which a note recommends more samples (heuristic)."""

MAX_WORST = 5
"""Number of worst samples that are kept as designs."""

DISTRIBUTION_HEADER = ("figure", "mean", "std", "5 %", "median", "95 %", "unit")
BUDGET_HEADER = ("tolerance", "first order", "total", "95 %")
VERIFIED_HEADER = ("sample", "figure", "statics", "dynamics", "difference", "unit")


@dataclass(frozen=True)
class Distribution:
    """Mean, standard deviation, percentiles and unit of a figure; NaN for fewer than two samples."""

    mean: float
    std: float
    p05: float
    p50: float
    p95: float
    unit: str

    @classmethod
    def of_values(cls, values: Array, unit: str) -> "Distribution":
        """Compute the distribution of values, shape (n,)."""
        if len(values) < 2:
            return cls(math.nan, math.nan, math.nan, math.nan, math.nan, unit)
        p05, p50, p95 = np.percentile(values, [5.0, 50.0, 95.0]).tolist()
        return cls(float(np.mean(values)), float(np.std(values, ddof=1)), p05, p50, p95, unit)

    @property
    def cells(self) -> tuple[str, ...]:
        """The numbers as text, for a table."""
        return tuple(f"{value:.5g}" for value in (self.mean, self.std, self.p05, self.p50, self.p95))


@dataclass(frozen=True, eq=False, repr=False)
class Tolerances(Tabular):
    """Result of a tolerance study.

    Attributes
    ----------
    design, condition
        Name of the design, and the condition of its figures.
    samples, asked, seed
        Number of balanced and of requested samples, and the random seed.
    figures
        Values by key, shape (samples,) each.
    drawn
        Deviations of each sample from the design [um], by the columns of `deviation_columns`, shape (samples,) each.
    jams
        Which samples jam, shape (samples,).
    jammed_by
        Why so many of them jam that the study stopped, a sentence; empty where it did not.
    limits
        Limits on figures.
    budget_of
        The figure of the error budget.
    budget
        Shares of the tolerances in its variance, the largest first.
    no_budget
        Why there are none.
    worst
        Designs of the samples that are furthest off in `budget_of`, the worst first, of those that do not jam.
    left_out
        What their design files omit, a sentence each.
    verified
        Some of them in full dynamics.
    """

    design: str
    condition: str
    samples: int
    asked: int
    seed: int
    figures: Mapping[str, Array]
    drawn: Mapping[str, Array]
    jams: Mask
    jammed_by: str
    limits: tuple[FigureLimit, ...]
    budget_of: str
    budget: tuple[Share, ...]
    no_budget: str
    worst: tuple[Design, ...]
    left_out: tuple[str, ...]
    verified: tuple[DynamicsCheck, ...] = ()

    @property
    def good(self) -> Mask:
        """Samples that satisfy all limits and do not jam, shape (samples,)."""
        satisfied = [limit.holds(self.figures[limit.key]) for limit in self.limits]
        return np.asarray(np.all([~self.jams, *satisfied], axis=0))

    @property
    def frame(self) -> Frame:
        """A row for each sample: number, deviations [um], quantities, and whether it jams (1 or 0)."""
        units = {key: unit for key in self.figures if (unit := figure(key).unit) != "1"} | dict.fromkeys(
            self.drawn, "um"
        )
        sample_numbers, jams = np.arange(1, self.samples + 1), self.jams.astype(int)
        return Frame({"sample": sample_numbers, **self.drawn, **self.figures, "jams": jams}, units)

    @property
    def line(self) -> str:
        """Design, share of good samples, and mean and standard deviation of the quantity of the budget."""
        unit = figure(self.budget_of).unit
        values = self.figures[self.budget_of][~self.jams]
        spread_text = f"{values.mean():.4g} +- {values.std():.2g} {unit}" if values.size else "all jam"
        return f"{self.design}, {self.samples_text}; yield {self.good.mean():.2%}, {self.budget_of} {spread_text}"

    @property
    def yield_interval(self) -> tuple[float, float]:
        """Return the bounds (0 to 1) of the 95 % confidence interval of the yield.

        The yield is the share of samples that do not jam and satisfy all limits. The formula is Wilson's (J. Am. Stat.
        Assoc. 22, 1927).
        """
        sample_count, good_share = self.samples, float(self.good.mean())
        # weight of the share 1/2 in the centre, relative to that of the observed share
        weight_of_half = NormalDist().inv_cdf(0.975) ** 2 / sample_count
        centre = (good_share + 0.5 * weight_of_half) / (1.0 + weight_of_half)
        half_width = math.sqrt(weight_of_half * good_share * (1.0 - good_share) + 0.25 * weight_of_half**2) / (
            1.0 + weight_of_half
        )
        return max(centre - half_width, 0.0), min(centre + half_width, 1.0)

    @property
    def words(self) -> str:
        """Return a sentence on a tolerance study: yield, its interval, limits, share of jams, samples, seed."""
        low, high = self.yield_interval
        limits = " and ".join(map(str, self.limits)) or "no limits"
        return (
            f"yield {self.good.mean():.2%} (95 %: {low:.2%} to {high:.2%}), {limits}; {self.jams.mean():.2%} jam; "
            f"{self.samples_text}, seed {self.seed}"
        )

    @property
    def sample_count(self) -> str:
        """The number of samples, and of how many if the study was stopped."""
        return f"{self.samples}" if self.samples == self.asked else f"{self.samples} of {self.asked}"

    @property
    def samples_text(self) -> str:
        """The number of samples in words, such as "1000 samples"."""
        return f"{self.sample_count} samples"

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the study has no quantities, where too many samples jam."""
        return (self.jam_words,) if self.jammed_by else ()

    @property
    def jam_words(self) -> str:
        """Number of jammed samples, the cause and the remedy, in a sentence."""
        return (
            f"{int(self.jams.sum())} of the first {self.samples} samples jam ({JAM.max_share:.0%} or more end a "
            f"study): {self.jammed_by}; increase the clearances (table [clearance]) or reduce the tolerances (table "
            "[tolerance])"
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """Return remarks on a tolerance study, a sentence each.

        They are on missing distributions and error budget, parts that are pressed without a load, quantities that were
        computed for each sample alone, omissions in the design files of the worst samples, and failed runs.
        """
        failed_checks = [
            f"{check.design}: the run in full dynamics failed: {check.note}" for check in self.verified if check.note
        ]
        preloaded_text = ", ".join(
            f"{pair} in {share:.2%}" for pair, share in compute_preload_shares(self.figures).items()
        )
        closed_form = (rv_samples.FIGURE,)
        computed_alone = [key for key in self.figures if figure(key).sampled is None and key not in closed_form]
        usable_count = int(np.sum(~self.jams))
        return (
            *([] if usable_count > 1 else [f"no distributions: {usable_count} of {self.samples} samples do not jam"]),
            *self._budget_notes(),
            *([f"pressed without a load: {preloaded_text}"] if preloaded_text else []),
            *(
                [f"{', '.join(computed_alone)}: computed for each sample at the design's load"]
                if computed_alone
                else []
            ),
            *self.left_out,
            *failed_checks,
        )

    def _budget_notes(self) -> list[str]:
        """Return a sentence if there is no error budget, or if its intervals are wide; otherwise an empty list."""
        if self.no_budget:
            return [f"no error budget: {self.no_budget}"]
        widest_interval = max((share.ci95[1] - share.ci95[0] for share in self.budget), default=0.0)
        if widest_interval > MAX_INTERVAL_WIDTH and self.samples < SOBOL.max_samples:
            return [
                f"the error budget is uncertain (95 % intervals up to {widest_interval:.2f} wide): draw more samples, "
                f"--samples {SOBOL.max_samples}"
            ]
        return []

    @property
    def distributions(self) -> dict[str, Distribution]:
        """Key -> distribution of the quantity over the samples that do not jam; NaN if there are fewer than two."""
        return {
            key: Distribution.of_values(values[~self.jams], figure(key).unit) for key, values in self.figures.items()
        }

    def tables(self) -> tuple[Table, ...]:
        """Tabulate the distributions of a tolerance study, its error budget, and its runs in full dynamics.

        Tables without results are left out.
        """
        tables = []
        if np.sum(~self.jams) > 1:
            rows = tuple((key, *item.cells, item.unit) for key, item in self.distributions.items())
            tables.append(Table(f"{self.design}: {self.samples_text}", DISTRIBUTION_HEADER, rows))
        if self.budget:
            budget = tuple(
                (item.source, f"{item.first_order:.3f}", f"{item.total:.3f}", "{:.3f} to {:.3f}".format(*item.ci95))
                for item in self.budget
            )
            tables.append(Table(f"error budget: shares in the variance of {self.budget_of}", BUDGET_HEADER, budget))
        if comparison_rows := tuple(row for check in self.verified for row in table_rows(check)):
            solver = SOLVERS[self.verified[0].solver]
            tables.append(
                Table(f"worst samples in full dynamics, {solver}, with friction", VERIFIED_HEADER, comparison_rows)
            )
        return tuple(tables)

    def as_json(self) -> dict[str, Any]:
        """Convert a tolerance study to JSON values, without the values of single samples.

        ``samples`` of ``asked`` samples were computed. ``condition`` describes in words how (model, loads and angles),
        and ``seed`` is that of the random deviations. ``yield`` is the share of the samples [1] that do not jam and
        whose quantities are all within ``limits``, such as "backlash_arcmin<=1"; ``yield_ci95`` is its 95 % interval.
        ``jam_probability`` is the share that jams, ``pressed_unloaded`` the share in which each kind of part is
        preloaded. ``quantities`` are the distributions of the quantities, ``budget`` the shares of the variance of the
        quantity ``budget_of``, and ``verified`` the worst samples in full dynamics.
        """
        return {
            "design": self.design,
            "condition": self.condition,
            "samples": self.samples,
            "asked": self.asked,
            "seed": self.seed,
            "limits": [str(limit) for limit in self.limits],
            "yield": float(self.good.mean()),
            "yield_ci95": list(self.yield_interval),
            "jam_probability": float(self.jams.mean()),
            "pressed_unloaded": compute_preload_shares(self.figures),
            "jammed_by": self.jammed_by,
            "quantities": {key: vars(distribution) for key, distribution in self.distributions.items()},
            "budget_of": self.budget_of,
            "budget": [{**vars(share), "ci95": list(share.ci95)} for share in self.budget],
            "no_budget": self.no_budget,
            "verified": [{**vars(check), "differences": check.differences} for check in self.verified],
        }


class StudyInterrupted(KeyboardInterrupt):
    """Ctrl-C, or a signal of the same effect, stopped a study; `tolerances` has the samples and simulations so far."""

    def __init__(self, stop: KeyboardInterrupt, tolerances: Tolerances) -> None:
        super().__init__(*stop.args)
        self.tolerances = tolerances


class TooManyJams(RunError):
    """Nearly all samples of the first batch jam; `tolerances` has their figures."""

    def __init__(self, tolerances: Tolerances) -> None:
        super().__init__(tolerances.jam_words)
        self.tolerances = tolerances


@shows_progress
def tolerance(
    design: Named,
    samples: int = 10_000,
    seed: int = 0,
    limits: Sequence[FigureLimit | str] | str = (),
    progress: Progress = silent,
    engine: Engine = THREADS,
    verify: int = 0,
    solver: Solver = "planar",
) -> Tolerances:
    """Compute distributions of quantities, yield and error budget of a design within its tolerances.

    This is a Monte Carlo study: each sample is a drive with random errors, whose static equilibrium is solved. Equal
    seeds give bit-identical results, on any machine and with any number of workers.

    Parameters
    ----------
    design
        A design with a table [tolerance], or the name of a preset or a file.
    samples, seed
        Number of samples, and random seed.
    limits
        Limits on quantities of the catalogue, such as ``"backlash_arcmin<=1"``; the error budget is that of the first
        limit's quantity. Quantities that are not in `SAMPLED` take longer, because a design is made of each sample.
    progress
        Called with the numbers of solved samples and of all, including those of the budget.
    engine
        Where the equilibria of the samples are solved, such as threads or processes.
    verify, solver
        Number of the worst samples that are run in full dynamics, and the solver of these runs.

    Returns
    -------
    Share of samples that satisfy all limits and do not jam, distributions of the quantities, and the share of each
    tolerance in the variance of the budget's quantity.

    Raises
    ------
    UsageError
        The design has no tolerances, a limit is not valid or contradicts another, or an argument is out of range.
    TooManyJams
        At least 99 % of the first 200 samples jam (of all samples if there are fewer). The attribute `tolerances` of
        the error has the quantities of these samples.
    StudyInterrupted
        Ctrl-C was pressed. The attribute `tolerances` has the quantities of all samples before the first unsolved
        batch, and the finished simulations.
    """
    require_count("samples", samples, 1)
    require_count("seed", seed, 0)
    limits = [limits] if isinstance(limits, str) else limits
    if not 0 <= verify <= MAX_WORST:
        raise UsageError(
            f"--verify {verify} is out of range: give the number of worst samples to simulate, 0 to {MAX_WORST}"
        )
    reducer = reducer_of(resolve(design))
    if isinstance(reducer, RvReducer):
        tolerances = _study_rv_reducer(reducer, samples, seed, limits)
    else:
        tolerances = _run_study(_define_study(reducer, samples, seed, limits), progress, engine)
    return _verify_worst(tolerances, verify, solver, engine)


def _run_study(study: "_Study", progress: Progress, engine: Engine) -> Tolerances:
    """Solve for static equilibrium of all samples of a study; return the distributions, yield and error budget.

    `engine` runs the computations in parallel; `progress` is called with the numbers of solved and of all samples.

    Raises
    ------
    TooManyJams
        At least 99 % of the first 200 samples jam.
    StudyInterrupted
        Ctrl-C was pressed.
    """
    figures_by_batch: dict[int, dict[str, Array]] = {}
    try:
        if not _solve_batches(study, figures_by_batch, progress, engine):
            raise TooManyJams(study.result({0: figures_by_batch[0]}))
        return study.result(figures_by_batch)
    except KeyboardInterrupt as stop:
        if 0 not in figures_by_batch:
            raise
        raise StudyInterrupted(stop, study.result(figures_by_batch)) from stop


def _study_rv_reducer(reducer: RvReducer, samples: int, seed: int, limits: Sequence[FigureLimit | str]) -> Tolerances:
    """Return the tolerance study of the transmission error of an RV reducer; no sample jams.

    `samples` is the number of samples, `seed` the random seed, and `limits` are limits of quantities. Raises UsageError
    if the design has no tolerances, or a limit is not valid, or not on the transmission error (`rv_samples.FIGURE`).
    """
    parsed_limits = tuple(parse_limit(limit, reducer) if isinstance(limit, str) else limit for limit in limits)
    require_consistent(parsed_limits)
    if unsupported_keys := [limit.key for limit in parsed_limits if limit.key != rv_samples.FIGURE]:
        raise UsageError(
            f"--limit {unsupported_keys[0]}: this quantity is not computed for samples of an RV reducer. Use --limit "
            f"with {rv_samples.FIGURE} instead"
        )
    drawn_samples = rv_samples.draw_rv_samples(reducer, samples, seed, MAX_WORST)
    return Tolerances(
        design=reducer.design.name,
        condition="ring and sun fixed, over a turn of the carrier; cranks, bores and planets in closed form without "
        "clearance and load, pins by statics under the nominal torque",
        samples=samples,
        asked=samples,
        seed=seed,
        figures={rv_samples.FIGURE: drawn_samples.values},
        drawn=drawn_samples.drawn,
        jams=np.zeros(samples, dtype=bool),
        jammed_by="",
        limits=parsed_limits,
        budget_of=rv_samples.FIGURE,
        budget=drawn_samples.budget,
        no_budget="",
        worst=drawn_samples.worst,
        left_out=("the error budget states shares in the mean square of the transmission error over the turn",),
    )


def _define_study(reducer: Reducer, samples: int, seed: int, limits: Sequence[FigureLimit | str]) -> "_Study":
    """Define a tolerance study that is still to be solved: tolerances, limits, batches, sets of the error budget.

    `samples` is the number of samples, `seed` the random seed, and `limits` are limits of quantities.

    Raises
    ------
    DesignError
        The ring is in two halves, which press the discs without a load.
    UsageError
        The design has no tolerances, a limit is not valid, or limits contradict each other.
    """
    require_one_ring(reducer, "tolerances: parts that press each other without a load count as jammed")
    zones = sampling.tolerance_zones(reducer)
    if not zones:
        raise UsageError(
            f"the design {reducer.design.name!r} has no tolerances: set at least one in the table [tolerance], e.g. "
            "--set 'tolerance.cam=\"uniform 2\"'"
        )
    parsed_limits = tuple(parse_limit(limit, reducer) if isinstance(limit, str) else limit for limit in limits)
    require_consistent(parsed_limits)
    return _Study(reducer, zones, samples, seed, parsed_limits)


def _solve_batches(
    study: "_Study", figures_by_batch: dict[int, dict[str, Array]], progress: Progress, engine: Engine
) -> bool:
    """Solve for static equilibrium of all samples of a study and of its error budget, batch by batch.

    `engine` runs the computations in parallel; `progress` is called with the numbers of solved and of all samples. The
    quantities of each batch are added to `figures_by_batch`: by the index of the batch, then by key, shape (samples,)
    each. Return False if the study stops because too many samples of the first batch jam, otherwise True.
    """
    sample_count, solved_samples = sum(batch.count for batch, _ in study.work), 0
    solve_batch = partial(solve_sample_batch, study.reducer, study.zones, study.seed, ANGLES)
    for index, figures in engine.stream(solve_batch, study.work):
        figures_by_batch[index] = figures
        solved_samples += study.work[index][0].count
        progress(solved_samples, sample_count)
        if index == 0 and stops_study(find_jams(figures)):
            return False
    return True


def _verify_worst(tolerances: Tolerances, count: int, solver: Solver, engine: Engine) -> Tolerances:
    """Return a tolerance study with the simulations of its `count` worst samples in full dynamics, worst first.

    `tolerances` is the study. `solver` is "planar" or "mujoco", `engine` has the workers. Raises StudyInterrupted with
    the finished simulations if Ctrl-C is pressed.
    """
    checks: dict[int, DynamicsCheck] = {}
    worst_reducers = [reducer_of(worst) for worst in tolerances.worst[:count]]
    interruption = None
    try:
        checks.update(engine.stream(partial(verify_design, solver=solver), worst_reducers))
    except KeyboardInterrupt as interrupt:
        interruption = interrupt
    verified_study = replace(tolerances, verified=tuple(check for _, check in sorted(checks.items())))
    if interruption:
        raise StudyInterrupted(interruption, verified_study) from interruption
    return verified_study


@dataclass(frozen=True)
class _Study:
    """The batches of a study and the sets of its error budget, and the result of their figures."""

    reducer: Reducer
    zones: Mapping[str, Zone]
    samples: int
    seed: int
    limits: tuple[FigureLimit, ...]

    @property
    def budget_key(self) -> str:
        """The quantity of the budget."""
        return self.limits[0].key if self.limits else "backlash_arcmin"

    @cached_property
    def main(self) -> list[sampling.Batch]:
        return sampling.list_batches(self.samples)

    @cached_property
    def budget_sets(self) -> dict[str, sampling.Batch]:
        count = size_of_budget_sets(self.samples)
        return list_budget_sets(self.zones, count) if count and len(self.zones) > 1 else {}

    @cached_property
    def work(self) -> list[tuple[sampling.Batch, tuple[str, ...]]]:
        """All batches with the keys of their figures: those of the samples, then those of the budget."""
        keys = tuple(dict.fromkeys((self.budget_key, *PRELOADS, *PRELOADS.values())))
        budget = [(batch, keys) for batch in self.budget_sets.values()]
        return [*((batch, self.keys) for batch in self.main), *budget]

    @property
    def keys(self) -> tuple[str, ...]:
        """Quantities of the samples: all that are balanced together, and those with limits."""
        return tuple(dict.fromkeys((*SAMPLED, *(limit.key for limit in self.limits))))

    def result(self, figures_by_batch: Mapping[int, Mapping[str, Array]]) -> Tolerances:
        """Return the result of a tolerance study from its solved batches of samples, up to the first unsolved batch.

        `figures_by_batch` has the quantities by index of the batch and by key, shape (samples,) each; at least the
        first batch is solved.
        """
        batches = self.main[
            : next((index for index in range(len(self.main)) if index not in figures_by_batch), len(self.main))
        ]
        figures = {
            key: np.concatenate([figures_by_batch[index][key] for index in range(len(batches))]) for key in self.keys
        }
        jams = find_jams(figures)
        is_stopped = len(batches) == 1 and stops_study(jams)
        deviations_by_batch = [
            sampling.draw_deviations(self.reducer, self.zones, self.seed, batch) for batch in batches
        ]
        deviations = {key: np.concatenate([part[key] for part in deviations_by_batch]) for key in self.zones}
        samples = sampling.apply_deviations(self.reducer, identical_samples(self.reducer, jams.size), deviations)
        can_be_written = sampling.has_design_file(self.reducer, samples)
        budget, no_budget = (
            ((), "") if is_stopped else self._error_budget(figures_by_batch, figures[self.budget_key][~jams])
        )
        return Tolerances(
            design=self.reducer.design.name,
            condition=condition(self.reducer),
            samples=jams.size,
            asked=self.samples,
            seed=self.seed,
            figures=figures,
            drawn=sampling.deviation_columns(deviations),
            jams=jams,
            jammed_by=explain_jams(self.reducer, self.zones, self.seed, jams) if is_stopped else "",
            limits=self.limits,
            budget_of=self.budget_key,
            budget=budget,
            no_budget=no_budget,
            worst=self._worst_samples(figures[self.budget_key], ~jams & can_be_written),
            left_out=sampling.list_omissions(self.reducer, self.zones, int(np.sum(~jams & ~can_be_written))),
        )

    def _worst_samples(self, values: Array, eligible: Mask) -> tuple[Design, ...]:
        """Return the samples of a tolerance study with the worst values as designs, worst first, at most `MAX_WORST`.

        `values` has the quantity of the error budget and `eligible` whether a sample may be selected, shape (samples,)
        each. The largest values are the worst, unless the first limit is a lower bound.
        """
        sign = 1.0 if not self.limits or self.limits[0].at_most else -1.0
        ranked_numbers = np.argsort(-sign * values, kind="stable")
        numbers = ranked_numbers[eligible[ranked_numbers]][:MAX_WORST].tolist()
        return tuple(sampling.sample_design(self.reducer, self.zones, self.seed, number) for number in numbers)

    def _error_budget(
        self, figures_by_batch: Mapping[int, Mapping[str, Array]], unjammed_values: Array
    ) -> tuple[tuple[Share, ...], str]:
        """Return the error budget, the share of each tolerance in a quantity's variance, and ""; or () and the reason.

        There is no budget if the quantity is constant, the study is too small or was stopped, or too many samples jam.
        A single tolerance has the share 1. `figures_by_batch` are the quantities by index of the batch, then by key;
        `unjammed_values` are those of the budget's quantity for the n samples that do not jam, shape (n,).
        """
        key = self.budget_key
        if unjammed_values.size > 1 and np.ptp(unjammed_values) <= CONSTANT_RTOL * np.abs(unjammed_values).max():
            return (), f"{key} does not vary with these tolerances: it is {unjammed_values[0]:.6g} in every sample"
        if len(self.zones) == 1 and unjammed_values.size > 1:
            return (Share(next(iter(self.zones)), 1.0, 1.0, (1.0, 1.0)),), ""
        if not self.budget_sets:
            return (), f"it takes {SOBOL.min_samples} samples or more (--samples)"
        indices = range(len(self.main), len(self.work))
        if any(index not in figures_by_batch for index in indices):
            return (), "the study was stopped before its samples were balanced"
        figures = {name: figures_by_batch[index] for name, index in zip(self.budget_sets, indices, strict=True)}
        values_by_set = {
            name: np.where(find_jams(set_figures), np.nan, set_figures[key]) for name, set_figures in figures.items()
        }
        deviations = [
            sampling.draw_deviations(self.reducer, self.zones, self.seed, self.budget_sets[name]) for name in "AB"
        ]
        if budget := compute_shares(self.zones, deviations, values_by_set):
            return budget, ""
        usable_samples, count = find_usable_rows(values_by_set).size, self.budget_sets["A"].count
        remedy = "" if count == SOBOL.max_samples else ", or draw more samples (--samples)"
        return (), (
            f"{usable_samples} of its {count} samples do not jam in any of the sets that it compares, and it takes "
            f"{SOBOL.min_samples}: reduce the tolerances{remedy}"
        )


def solve_sample_batch(
    reducer: Reducer, zones: Mapping[str, Zone], seed: int, angles: int, work: tuple[sampling.Batch, Sequence[str]]
) -> dict[str, Array]:
    """Draw the samples of a batch, solve their static equilibrium, and compute their quantities, such as the backlash.

    Parameters
    ----------
    reducer, zones, seed
        Nominal reducer, its tolerances by key, and random seed.
    angles
        Number of crank angles at which the equilibrium is solved.
    work
        The batch, and the keys of the quantities.

    Returns
    -------
    The quantities by key, shape (samples,) each. Quantities that are not in `SAMPLED` are NaN for samples that cannot
    be written as a design.
    """
    batch, keys = work
    samples = sampling.draw_samples(reducer, zones, seed, batch)
    computed_alone = {
        key: np.array([_quantity_of_sample(reducer, samples, index, figure(key)) for index in range(len(samples))])
        for key in keys
        if figure(key).sampled is None
    }
    return compute_sampled(reducer, samples, keys, angles) | computed_alone


def _quantity_of_sample(reducer: Reducer, samples: Samples, index: int, catalogue_figure: Figure) -> float:
    """Compute a quantity of a sample as a design; NaN where there is none."""
    try:
        return catalogue_figure.value(Reducer(sampling.design_of_sample(reducer, samples, index, reducer.design.name)))
    except CycloidError:
        return math.nan
