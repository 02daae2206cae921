"""Samples of a design within its tolerances: distributions, yield, jams, and an error budget by Sobol indices."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from statistics import NormalDist
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.engine import Engine, Progress, silent
from cycloid_mj.base.errors import CycloidError, RunError, UsageError
from cycloid_mj.base.frame import Frame, Tabular
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.result import Table
from cycloid_mj.design import Design, Named, resolve
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.explore.budget import SOBOL, Share, budget_blocks, budget_samples, shares, usable_rows
from cycloid_mj.explore.constraints import FigureLimit, limit, require_consistent
from cycloid_mj.explore.jam import MAX_JAM_SHARE, PRELOADS, cause, jams_of, jams_too_often, pressed_pairs
from cycloid_mj.explore.sampling import (
    Batch,
    as_design,
    blocks,
    departures,
    drawn,
    drawn_columns,
    filed,
    left_out,
    put,
    sample_design,
    tolerances,
)
from cycloid_mj.explore.verify import Verified, table_rows, verified
from cycloid_mj.explore.zone import Zone
from cycloid_mj.figures import SAMPLED, Figure, compute_sampled, figure
from cycloid_mj.figures.sampled import ANGLES, condition
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import require_one_ring
from cycloid_mj.statics.samples import Samples, alike

THREADS = Engine(kind="threads")
"""Samples are balanced by compiled code that releases Python's lock."""

UNVARIED = 1e-9
"""Range of a figure, relative to its largest value, up to which it counts as constant: rounding errors are below."""

WIDE_INTERVAL = 0.2
"""Width of the widest 95 % interval of a budget above which the study recommends more samples."""

WORST = 5
"""Samples that are kept as designs."""

BUDGET_HEADER = ("tolerance", "first order", "total", "95 %")
VERIFIED_HEADER = ("sample", "figure", "statics", "dynamics", "difference", "unit")


@dataclass(frozen=True)
class Distribution:
    """The distribution of one figure: mean, standard deviation, percentiles, and unit."""

    mean: float
    std: float
    p05: float
    p50: float
    p95: float
    unit: str


@dataclass(frozen=True, eq=False, repr=False)
class Tolerances(Tabular):
    """What came of the samples of one design.

    Attributes
    ----------
    design, condition
        Its name, and under what the figures hold.
    samples, asked, seed
        How many, of how many that were asked for, and from which seed.
    figures
        Values by key, shape (samples,) each.
    drawn
        How far each sample departs from the design [um], by the columns of `drawn_columns`, shape (samples,) each.
    jams
        Which samples go together under force only, shape (samples,).
    jammed_by
        Why so many of them jam that the study stopped, a sentence; empty where it did not.
    limits
        What was asked for.
    budget
        Shares in the variance of the figure `budget_of`, the largest first.
    no_budget
        Why there are none.
    worst
        Designs of the samples that are furthest out in `budget_of`, the worst first, of those that do not jam.
    left_out
        What the design files of these lack, a sentence each.
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
    verified: tuple[Verified, ...] = ()

    @property
    def good(self) -> Mask:
        """Which samples keep every limit and do not jam."""
        kept = [limit.holds(self.figures[limit.key]) for limit in self.limits]
        return np.asarray(np.all([~self.jams, *kept], axis=0))

    @property
    def frame(self) -> Frame:
        """The samples, a row each."""
        units = {key: unit for key in self.figures if (unit := figure(key).unit) != "1"} | dict.fromkeys(
            self.drawn, "um"
        )
        number, jams = np.arange(1, self.samples + 1), self.jams.astype(int)
        return Frame({"sample": number, **self.drawn, **self.figures, "jams": jams}, units)

    @property
    def line(self) -> str:
        """Design, yield, and the figure that the budget is of."""
        unit = figure(self.budget_of).unit
        values = self.figures[self.budget_of][~self.jams]
        spread = f"{values.mean():.4g} +- {values.std():.2g} {unit}" if values.size else "all jam"
        return f"{self.design}, {self.samples_text}; yield {self.good.mean():.2%}, {self.budget_of} {spread}"

    @property
    def yield_interval(self) -> tuple[float, float]:
        """The yield with 95 % confidence (Wilson, J. Am. Stat. Assoc. 22, 1927)."""
        count, share = self.samples, float(self.good.mean())
        weight = NormalDist().inv_cdf(0.975) ** 2 / count
        middle = (share + 0.5 * weight) / (1.0 + weight)
        half = math.sqrt(weight * share * (1.0 - share) + 0.25 * weight**2) / (1.0 + weight)
        return max(middle - half, 0.0), min(middle + half, 1.0)

    @property
    def words(self) -> str:
        """The yield and the chance of a jam, in a sentence."""
        low, high = self.yield_interval
        asked = " and ".join(map(str, self.limits)) or "no limit but that the parts go together"
        return (
            f"yield {self.good.mean():.2%} (95 %: {low:.2%} to {high:.2%}), {asked}; {self.jams.mean():.2%} jam; "
            f"{self.samples_text}, seed {self.seed}"
        )

    @property
    def sample_count(self) -> str:
        """How many samples there are, and of how many, if not all."""
        return f"{self.samples}" if self.samples == self.asked else f"{self.samples} of {self.asked}"

    @property
    def samples_text(self) -> str:
        """The same, in words."""
        return f"{self.sample_count} samples"

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the study has no figures, where too many samples jam."""
        return (self.jam_words,) if self.jammed_by else ()

    @property
    def jam_words(self) -> str:
        """How many samples jam, why, and what to do, in a sentence."""
        return (
            f"{int(self.jams.sum())} of the first {self.samples} samples jam ({MAX_JAM_SHARE:.0%} or more end a "
            f"study): {self.jammed_by}; increase the clearances (table [clearance]) or reduce the tolerances (table "
            "[tolerance])"
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader should know of the samples, a sentence each."""
        lost = [f"{one.design}: not run in full dynamics: {one.note}" for one in self.verified if one.note]
        pressed = pressed_pairs(self.figures)
        jammed = [f"pressed without a load: {', '.join(f'{pair} in {share:.2%}' for pair, share in pressed.items())}"]
        each = [key for key in self.figures if figure(key).sampled is None]
        fit = int(np.sum(~self.jams))
        alone = [f"{', '.join(each)}: of each sample as a design of its own, at the load of the design"] if each else []
        return (
            *([] if fit > 1 else [f"no distributions: {fit} of {self.samples} samples do not jam"]),
            *self._budget_notes(),
            *(jammed if pressed else []),
            *alone,
            *self.left_out,
            *lost,
        )

    def _budget_notes(self) -> list[str]:
        """Why there is no error budget, or that its intervals are wide."""
        if self.no_budget:
            return [f"no error budget: {self.no_budget}"]
        widest = max((share.ci95[1] - share.ci95[0] for share in self.budget), default=0.0)
        if widest > WIDE_INTERVAL and self.samples < SOBOL.max_samples:
            return [
                f"the error budget is uncertain (95 % intervals up to {widest:.2f} wide): draw more samples, "
                f"--samples {SOBOL.max_samples}"
            ]
        return []

    @property
    def distributions(self) -> dict[str, Distribution]:
        """The distribution of every figure over the samples that do not jam; NaN where fewer than two do not."""
        return {key: _distribution(values[~self.jams], figure(key).unit) for key, values in self.figures.items()}

    def tables(self) -> tuple[Table, ...]:
        """Tabulate distributions, and where there are some budget and dynamics."""
        header = ("figure", "mean", "std", "5 %", "median", "95 %", "unit")
        rows = tuple(
            (
                key,
                *(
                    f"{value:.5g}"
                    for value in (
                        distribution.mean,
                        distribution.std,
                        distribution.p05,
                        distribution.p50,
                        distribution.p95,
                    )
                ),
                distribution.unit,
            )
            for key, distribution in self.distributions.items()
        )
        shares = tuple(
            (one.source, f"{one.first_order:.3f}", f"{one.total:.3f}", f"{one.ci95[0]:.3f} to {one.ci95[1]:.3f}")
            for one in self.budget
        )
        fit = int(np.sum(~self.jams))
        tables = [Table(f"{self.design}: {self.samples_text}", header, rows)] if fit > 1 else []
        if shares:
            tables.append(Table(f"tighten this first: variance of {self.budget_of}", BUDGET_HEADER, shares))
        if compared := tuple(row for one in self.verified for row in table_rows(one)):
            by = SOLVERS[self.verified[0].solver]
            tables.append(
                Table(f"the worst samples in full dynamics, {by}, at speed, with friction", VERIFIED_HEADER, compared)
            )
        return tuple(tables)

    def as_json(self) -> dict[str, Any]:
        """Convert all of it to JSON values."""
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
            "pressed_unloaded": pressed_pairs(self.figures),
            "jammed_by": self.jammed_by,
            "quantities": {key: vars(distribution) for key, distribution in self.distributions.items()},
            "budget_of": self.budget_of,
            "budget": [{**vars(one), "ci95": list(one.ci95)} for one in self.budget],
            "no_budget": self.no_budget,
            "verified": [{**vars(one), "differences": one.differences} for one in self.verified],
        }


class Unfinished(KeyboardInterrupt):
    """Ctrl-C, or a signal of the same effect, came when some samples were done: `found` is what came of them."""

    def __init__(self, stop: KeyboardInterrupt, tolerances: Tolerances) -> None:
        super().__init__(*stop.args)
        self.tolerances = tolerances


class TooManyJams(RunError):
    """Nearly all samples of the first block jam; `tolerances` holds their figures."""

    def __init__(self, tolerances: Tolerances) -> None:
        super().__init__(tolerances.jam_words)
        self.tolerances = tolerances


def tolerance(
    design: Named,
    samples: int = 10_000,
    seed: int = 0,
    limits: Sequence[FigureLimit | str] = (),
    progress: Progress = silent,
    engine: Engine = THREADS,
    verify: int = 0,
    solver: Solver = "planar",
) -> Tolerances:
    """Draw samples within the design's tolerances, balance them all round, and share out the variance.

    The same seed gives the same bits, wherever and by however many workers.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file: what has tolerances, in its table of that name.
    samples, seed
        How many are drawn, and from which seed.
    limits
        On figures of the catalogue, such as ``"backlash_arcmin<=1"``; the first one's figure is that of the budget.
        Those not in `SAMPLED` are computed of each sample as a design of its own, which takes longer.
    progress
        Called with how many samples are balanced, and how many there are, those of the budget included.
    engine
        Where the work is done.
    verify
        How many of the worst samples are run in full dynamics.
    solver
        What takes the steps of these runs.

    Raises
    ------
    UsageError
        The design has no tolerances, a limit is not valid, or limits contradict each other.
    DesignError
        A tolerance is not of a known form.
    TooManyJams
        99 % or more of the first 200 samples jam, or of all, where there are fewer; it holds their figures.
    Unfinished
        Ctrl-C: it has the figures of the first samples, as many as were balanced without a gap.
    """
    design = resolve(design)
    reducer = Reducer(design)
    require_one_ring(reducer, "tolerances: parts that press each other without a load count as jammed")
    zones = tolerances(reducer)
    if not zones:
        raise UsageError(
            f"the design {reducer.design.name!r} has no tolerances: give some in its table [tolerance], "
            "e.g. --set 'tolerance.cam=\"uniform 2\"'"
        )
    if not 0 <= verify <= WORST:
        raise UsageError(f"cannot verify {verify} samples: give from 0 to {WORST}, the worst that are kept")
    asked = tuple(limit(one, reducer) if isinstance(one, str) else one for one in limits)
    require_consistent(asked)
    study = _Study(reducer, zones, samples, seed, asked)
    done: dict[int, dict[str, Array]] = {}
    checked: dict[int, Verified] = {}
    try:
        if not _balance(study, done, progress, engine):
            raise TooManyJams(study.result({0: done[0]}))
        result = study.result(done)
        checked.update(engine.stream(partial(verified, solver=solver), [Reducer(one) for one in result.worst[:verify]]))
    except KeyboardInterrupt as stop:
        if 0 not in done:
            raise
        raise Unfinished(stop, _with_dynamics(study.result(done), checked)) from stop
    return _with_dynamics(result, checked)


def _balance(study: "_Study", done: dict[int, dict[str, Array]], progress: Progress, engine: Engine) -> bool:
    """Balance the samples of a study, and the sets of its budget; `done` takes their figures by place in its work.

    Returns
    -------
    Whether all is done: the study ends where too many samples of its first block jam.
    """
    whole, count = sum(block.count for block, _ in study.work), 0
    work = partial(balanced, study.reducer, study.zones, study.seed, ANGLES)
    for place, figures in engine.stream(work, study.work):
        done[place] = figures
        count += study.work[place][0].count
        progress(count, whole)
        if place == 0 and jams_too_often(jams_of(figures)):
            return False
    return True


def _with_dynamics(tolerances: Tolerances, checked: Mapping[int, Verified]) -> Tolerances:
    return replace(tolerances, verified=tuple(one for _, one in sorted(checked.items())))


@dataclass(frozen=True)
class _Study:
    """Samples that are asked for, block by block, with the sets that their budget compares."""

    reducer: Reducer
    zones: Mapping[str, Zone]
    samples: int
    seed: int
    limits: tuple[FigureLimit, ...]

    @property
    def of(self) -> str:
        """The figure of the budget."""
        return self.limits[0].key if self.limits else "backlash_arcmin"

    @cached_property
    def main(self) -> list[Batch]:
        return blocks(self.samples)

    @cached_property
    def compared(self) -> dict[str, Batch]:
        count = budget_samples(self.samples)
        return budget_blocks(self.zones, count) if count and len(self.zones) > 1 else {}

    @cached_property
    def work(self) -> list[tuple[Batch, tuple[str, ...]]]:
        """Every block with the figures that it is balanced for: those of the samples, then those of the budget."""
        keys = tuple(dict.fromkeys((self.of, *PRELOADS, *PRELOADS.values())))
        budget = [(block, keys) for block in self.compared.values()]
        return [*((block, self.keys) for block in self.main), *budget]

    @property
    def keys(self) -> tuple[str, ...]:
        """Figures of the samples: all that are balanced together, and those with limits."""
        return tuple(dict.fromkeys((*SAMPLED, *(limit.key for limit in self.limits))))

    def result(self, done: Mapping[int, Mapping[str, Array]]) -> Tolerances:
        """Gather the result from the figures of all work, or of so much as is `done`: its first block at least."""
        main = self.main[: next((place for place in range(len(self.main)) if place not in done), len(self.main))]
        figures = {key: np.concatenate([done[place][key] for place in range(len(main))]) for key in self.keys}
        jams, parts = jams_of(figures), [departures(self.reducer, self.zones, self.seed, block) for block in main]
        stopped = len(main) == 1 and jams_too_often(jams)
        changed = {key: np.concatenate([part[key] for part in parts]) for key in self.zones}
        budget, no_budget = ((), "") if stopped else self._budget(done, figures[self.of][~jams])
        has_file = filed(self.reducer, put(self.reducer, alike(self.reducer, jams.size), changed))
        outwards = 1.0 if not self.limits or self.limits[0].at_most else -1.0
        ranked = np.argsort(-outwards * figures[self.of], kind="stable")
        worst = ranked[(~jams & has_file)[ranked]][:WORST].tolist()
        return Tolerances(
            design=self.reducer.design.name,
            condition=condition(self.reducer),
            samples=jams.size,
            asked=self.samples,
            seed=self.seed,
            figures=figures,
            drawn=drawn_columns(changed),
            jams=jams,
            jammed_by=cause(self.reducer, self.zones, self.seed, jams) if stopped else "",
            limits=self.limits,
            budget_of=self.of,
            budget=budget,
            no_budget=no_budget,
            worst=tuple(sample_design(self.reducer, self.zones, self.seed, number) for number in worst),
            left_out=left_out(self.reducer, self.zones, int(np.sum(~jams & ~has_file))),
        )

    def _budget(self, done: Mapping[int, Mapping[str, Array]], values: Array) -> tuple[tuple[Share, ...], str]:
        """Return the error budget, or none and the reason; `values` are those of the samples that do not jam."""
        if values.size > 1 and np.ptp(values) <= UNVARIED * np.abs(values).max():
            return (), f"{self.of} does not vary with these tolerances: it is {values[0]:.6g} in every sample"
        if len(self.zones) == 1 and values.size > 1:
            return (Share(next(iter(self.zones)), 1.0, 1.0, (1.0, 1.0)),), ""
        if not self.compared:
            return (), f"it takes {SOBOL.min_samples} samples or more (--samples)"
        places = range(len(self.main), len(self.work))
        if any(place not in done for place in places):
            return (), "the study was stopped before its samples were balanced"
        balanced = {name: done[place] for name, place in zip(self.compared, places, strict=True)}
        sets = {name: np.where(jams_of(figures), np.nan, figures[self.of]) for name, figures in balanced.items()}
        drawn = [departures(self.reducer, self.zones, self.seed, self.compared[name]) for name in "AB"]
        if found := shares(self.zones, drawn, sets):
            return found, ""
        used, count = usable_rows(sets).size, self.compared["A"].count
        return (), (
            f"{used} of its {count} samples fit in all sets that it compares, and it takes {SOBOL.min_samples}: reduce "
            "the tolerances" + ("" if count == SOBOL.max_samples else ", or draw more samples (--samples)")
        )


def balanced(
    reducer: Reducer, zones: Mapping[str, Zone], seed: int, angles: int, work: tuple[Batch, Sequence[str]]
) -> dict[str, Array]:
    """Balance the samples of a block; give the figures that are asked for by key, shape (samples,) each."""
    block, keys = work
    made = drawn(reducer, zones, seed, block)
    alone = {key: _each(reducer, made, figure(key)) for key in keys if figure(key).sampled is None}
    return compute_sampled(reducer, made, keys, angles) | alone


def _each(reducer: Reducer, made: Samples, row: Figure) -> Array:
    """Compute a figure of each sample as a design of its own, shape (samples,); NaN where there is none."""
    return np.array([_of_sample(reducer, made, number, row) for number in range(len(made))])


def _of_sample(reducer: Reducer, made: Samples, number: int, row: Figure) -> float:
    try:
        return row.value(Reducer(as_design(reducer, made, number, reducer.design.name)))
    except CycloidError:
        return math.nan


def _distribution(values: Array, unit: str) -> Distribution:
    if len(values) < 2:
        values = np.full(2, np.nan)
    low, middle, high = np.percentile(values, [5.0, 50.0, 95.0]).tolist()
    return Distribution(float(np.mean(values)), float(np.std(values, ddof=1)), low, middle, high, unit)
