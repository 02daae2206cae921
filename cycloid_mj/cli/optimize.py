"""``cycloid-mj optimize``: the best design within ranges that passes its checks and limits."""

from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.atomic_write import write_whole
from cycloid_mj.base.errors import DesignError, RunError, UsageError
from cycloid_mj.base.interrupt import cause
from cycloid_mj.base.outcome import MOST_FIGURES, Outcome
from cycloid_mj.cli.delivery import claimed, deliver
from cycloid_mj.cli.flags import (
    FLAT,
    PRESET,
    ClusterDelivery,
    FollowFlag,
    PresetOptions,
    StudySolverFlag,
    out_flag,
    whole,
    within,
)
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.explore.optimum import Optimum

OUT = "runs/optimize"
STEM, FIGURE = "optimize", "tradeoff.png"
SEARCHED = (
    "Every point whose figures are known: over the evaluations or over the other objective; below, over each key."
)
MOST_EVALUATIONS, MOST_STARTS = 1_000_000, 1000

VaryFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--vary",
        metavar="KEY=LO:HI",
        help="A key of the design file and its range; whole numbers in it, and values a,b,c of any key, are tried one "
        "by one. Repeatable.",
    ),
]
FIGURES = "any of geometry, statics or life that `cycloid-mj figures` lists"
MinimizeFlag = Annotated[
    tuple[str, ...],
    Parameter(name="--minimize", metavar="QUANTITY", help=f"Figure to make small: {FIGURES}. Two give a front."),
]
MaximizeFlag = Annotated[
    tuple[str, ...], Parameter(name="--maximize", metavar="QUANTITY", help="Figure to make large; counts as one.")
]
LimitFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--limit",
        metavar="'KEY<=NUMBER'",
        help="A figure is to be at most, or at least (>=), a number; repeatable. Checks are limits of their own.",
    ),
]
StrictFlag = Annotated[
    bool, Parameter(help="All warnings of the checks refuse a point, not only errors and thin walls.")
]
EvaluationsFlag = Annotated[
    int,
    Parameter(metavar="N", converter=whole, validator=within(1, MOST_EVALUATIONS), help="Points, about. Default: 600."),
]
StartsFlag = Annotated[
    int,
    Parameter(
        metavar="N", converter=whole, validator=within(1, MOST_STARTS), help="Searches that compete. Default: 3."
    ),
]
SeedFlag = Annotated[
    int, Parameter(metavar="N", converter=whole, validator=within(0, 2**63), help="Of all draws. Default: 0.")
]
QuickFlag = Annotated[bool, Parameter(help="Do not run the best design in full dynamics, nor within its tolerances.")]
EXAMPLES = """Examples:
  cycloid-mj optimize --vary gear.eccentricity_mm=0.5:1.1 --vary ring.pin_radius_mm=1.2:3.2 \
--minimize pin_gear_pressure_mpa --limit 'backlash_arcmin<=0.97' --out better
  cycloid-mj optimize --design my.toml --vary output.pins=6:10 --vary output.pin_radius_mm=2:5 \
--minimize mass_kg --minimize output_pressure_mpa --quick"""


@dataclass(frozen=True, kw_only=True)
class OptimizeDelivery(ClusterDelivery):
    """Where the search goes."""

    out: Annotated[str | None, out_flag("the history, the best design, figure and page", OUT)] = None


DELIVERED = OptimizeDelivery()


def optimize(
    chosen: Annotated[PresetOptions, FLAT] = PRESET,
    *,
    vary: VaryFlag = (),
    minimize: MinimizeFlag = (),
    maximize: MaximizeFlag = (),
    limit: LimitFlag = (),
    strict: StrictFlag = False,
    follow: FollowFlag = (),
    evaluations: EvaluationsFlag = 600,
    starts: StartsFlag = 3,
    seed: SeedFlag = 0,
    quick: QuickFlag = False,
    solver: StudySolverFlag = "planar",
    delivery: Annotated[OptimizeDelivery, FLAT] = DELIVERED,
) -> int:
    """Find the best design within ranges, or a front of two aims.

    Real numbers are searched by CMA-ES (extra optimize), from several starts; whole numbers and words
    are tried one by one, the better half of the combinations going on. A point must
    pass the checks of `design check` and keep the limits: what refused how many is
    told. The hole of an output pin follows pin and eccentricity, and the torque of
    the drive the ratio, unless they vary themselves or --follow says otherwise.

    Every point is in DIR/history.csv (and .parquet) and on disk as it comes: the same
    command goes on where it was stopped. The best is DIR/best.toml; its full statics
    stand beside the start's, a run in full dynamics beside them, and its yield where
    the design has tolerances. The exit code is 1 if no point keeps all.
    """
    from cycloid_mj.cli.progress import counted
    from cycloid_mj.explore.journal import begun, forget
    from cycloid_mj.explore.optimizer import BEST, HISTORY, PARQUET, STUDY, checked, explored
    from cycloid_mj.explore.problem import problem

    engine = delivery.engine()
    task = problem(Reducer(chosen.resolved()), _ranges(vary), minimize, maximize, limit, strict, follow)
    resumed = begun(Path(delivery.out or OUT), STUDY)
    place = claimed(delivery, STEM, (HISTORY, PARQUET, BEST, FIGURE), OUT, paged=True, resumed=resumed)
    into = place.folder or Path(OUT)
    if delivery.force:
        forget(into, STUDY)
    try:
        optimum = explored(task, evaluations, starts, seed, into, engine, counted("optimize", delivery.quiet))
        if optimum.best is None:
            raise DesignError(f"{optimum.hopeless} (all points are in {into})")
        write_whole({into / BEST: _best(optimum)})
        optimum = optimum if quick else checked(optimum, solver)
    except KeyboardInterrupt as stop:
        raise RunError(
            f"stopped by {cause(stop)}; the points so far are in {into}: the same command goes on from there"
        ) from stop
    return deliver(_outcome(optimum, into / BEST), place, delivery)


def _ranges(vary: tuple[str, ...]) -> dict[str, str]:
    """Collect keys and ranges as they were written, once each."""
    ranges: dict[str, str] = {}
    for text in vary:
        key, equals, wanted = text.partition("=")
        key = key.strip()
        if not equals or not key or not wanted.strip():
            raise UsageError(f"--vary {text!r}: expected KEY=LO:HI, e.g. gear.eccentricity_mm=0.5:1.1")
        if key in ranges:
            raise UsageError(f"--vary {key}: it is there twice")
        ranges[key] = wanted.strip()
    return ranges


def _best(optimum: "Optimum") -> bytes:
    from cycloid_mj.design import dump

    return dump(optimum.design()).encode()


def _outcome(optimum: "Optimum", best: Path) -> Outcome:
    from cycloid_mj.explore.optimum import tables
    from cycloid_mj.plots.optimum import tradeoff_figure
    from cycloid_mj.plots.save import drawn

    picture = Path(FIGURE).stem
    numbers = {"evaluations": str(optimum.evaluations), "keep all": str(len(optimum.feasible))}
    numbers |= {key: f"{value:.5g}" for key, value in optimum.best_figures.items()}
    return Outcome(
        title=f"{optimum.task.reducer.design.name} optimised",
        headline=dict(islice(numbers.items(), MOST_FIGURES)),
        summary=[optimum.words, *optimum.ran_into, f"the best: {best}"],
        tables=tables(optimum),
        warnings=optimum.warnings,
        notes=optimum.notes,
        pictures={picture: partial(drawn, tradeoff_figure(optimum))},
        formats=("png",),
        captions={picture: SEARCHED},
        result={**optimum.as_json(), "design": str(best)},
        filed=False,
    )
