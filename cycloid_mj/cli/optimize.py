"""``cycloid-mj optimize``: the best design within ranges that satisfies all checks and limits."""

from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.atomic_write import write_files
from cycloid_mj.base.errors import DesignError, RunError, UsageError
from cycloid_mj.base.interrupt import signal_name
from cycloid_mj.base.outcome import MOST_FIGURES, Outcome
from cycloid_mj.cli import flags
from cycloid_mj.cli.delivery import claim_destination, deliver
from cycloid_mj.cli.ranges import RANGES
from cycloid_mj.reducer import reducer_of

if TYPE_CHECKING:
    from cycloid_mj.explore.optimum import Optimum

OUT = "runs/optimize"
STEM, FIGURE = "optimize", "tradeoff.png"
FIGURE_CAPTION = (
    "Evaluated points: the objective over the evaluations or over the second objective; below, over each key."
)

VaryFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--vary",
        metavar="KEY=LO:HI",
        help="Key of the design file and its range. Whole numbers in a range and values a,b,c of any key are tried one "
        "by one. May be repeated.",
    ),
]
FIGURES = "any of geometry, statics or life that `cycloid-mj figures` lists"
MinimizeFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--minimize",
        metavar="QUANTITY",
        help=f"Quantity to minimize: {FIGURES}. Two objectives yield a Pareto front.",
    ),
]
MaximizeFlag = Annotated[
    tuple[str, ...],
    Parameter(name="--maximize", metavar="QUANTITY", help="Quantity to maximize; counts as an objective."),
]
LimitFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--limit",
        metavar="'KEY<=NUMBER'",
        help="Upper (<=) or lower (>=) limit of a quantity. May be repeated. The design checks always apply.",
    ),
]
StrictFlag = Annotated[
    bool, Parameter(help="Reject points with any warning of the checks, not only with errors and thin walls.")
]
EvaluationsFlag = Annotated[
    int,
    flags.integer_flag("Approximate number of points. Default: 600.", RANGES.evaluations),
]
StartsFlag = Annotated[
    int,
    flags.integer_flag("Number of independent searches. Default: 3.", RANGES.starts),
]
SeedFlag = Annotated[
    int,
    flags.integer_flag("Random seed. Default: 0.", (0, 2**63)),
]
QuickFlag = Annotated[bool, Parameter(help="Skip the full dynamics and the tolerance study of the best design.")]
EXAMPLES = """Examples:
  cycloid-mj optimize --vary gear.eccentricity_mm=0.5:1.1 --vary ring.pin_radius_mm=1.2:3.2 \
--minimize pin_gear_pressure_mpa --limit 'backlash_arcmin<=0.97' --out better
  cycloid-mj optimize --design my.toml --vary output.pins=6:10 --vary output.pin_radius_mm=2:5 \
--minimize mass_kg --minimize output_pressure_mpa --quick"""


@dataclass(frozen=True, kw_only=True)
class OptimizeDelivery(flags.ClusterDelivery):
    """Flags for the results."""

    out: Annotated[str | None, flags.out_flag("the history, the best design, figure and page", OUT)] = None


DELIVERED = OptimizeDelivery()


def optimize(
    design_options: Annotated[flags.PresetOptions, flags.FLAT] = flags.PRESET,
    *,
    vary: VaryFlag = (),
    minimize: MinimizeFlag = (),
    maximize: MaximizeFlag = (),
    limit: LimitFlag = (),
    strict: StrictFlag = False,
    follow: flags.FollowFlag = (),
    evaluations: EvaluationsFlag = 600,
    starts: StartsFlag = 3,
    seed: SeedFlag = 0,
    quick: QuickFlag = False,
    solver: flags.StudySolverFlag = "planar",
    output_flags: Annotated[OptimizeDelivery, flags.FLAT] = DELIVERED,
) -> int:
    """Find the best design within ranges, or a Pareto front.

    Real numbers are searched by CMA-ES (extra optimize) from several starts. There is a separate search for every
    combination of the whole numbers and words; after each round the worse half of the searches is dropped. A point must
    satisfy the checks of `design check` and all limits; the report lists how many points each of them rejected. The
    hole of an output pin follows the pin and the eccentricity, and drive.torque_nm follows the ratio, unless they are
    varied or linked by --follow.

    All points are written to DIR/history.csv (and .parquet) as soon as they are evaluated. To resume an interrupted
    search, run the same command again. The best design is DIR/best.toml. The report compares its statics with those of
    the design at the start. Unless --quick is set, it adds a run in full dynamics and, if the design has tolerances,
    its yield. The exit code is 1 if no point satisfies all checks and limits.
    """
    from cycloid_mj.cli.progress import count_progress
    from cycloid_mj.design import dump
    from cycloid_mj.explore.journal import has_study, remove_study
    from cycloid_mj.explore.optimizer import BEST, HISTORY, PARQUET, STUDY, add_checks_of_best, run_search
    from cycloid_mj.explore.problem import define_problem

    engine = output_flags.engine()
    task = define_problem(
        reducer_of(design_options.resolve()), _parse_ranges(vary), minimize, maximize, limit, strict, follow
    )
    is_resumed = has_study(Path(output_flags.out or OUT), STUDY)
    destination = claim_destination(
        output_flags, STEM, (HISTORY, PARQUET, BEST, FIGURE), OUT, with_page=True, resumed=is_resumed
    )
    directory = destination.folder or Path(OUT)
    if output_flags.force:
        remove_study(directory, STUDY)
    try:
        optimum = run_search(
            task, evaluations, starts, seed, directory, engine, count_progress("optimize", output_flags.quiet)
        )
        if optimum.best is None:
            raise DesignError(f"{optimum.infeasible_words} (all points evaluated are in {directory})")
        write_files({directory / BEST: dump(optimum.design()).encode()})
        optimum = optimum if quick else add_checks_of_best(optimum, solver)
    except KeyboardInterrupt as stop:
        raise RunError(
            f"stopped by {signal_name(stop)}; the points evaluated so far are in {directory}. Run the same command "
            "again to resume"
        ) from stop
    return deliver(_outcome(optimum, directory / BEST), destination, output_flags)


def _parse_ranges(vary: tuple[str, ...]) -> dict[str, str]:
    """Split the texts of ``--vary`` into key -> range; raise UsageError for a wrong form or a repeated key."""
    ranges: dict[str, str] = {}
    for text in vary:
        key, equals_sign, range_text = text.partition("=")
        key = key.strip()
        if not equals_sign or not key or not range_text.strip():
            raise UsageError(
                f"--vary {text!r} is not a range: give KEY=LO:HI, e.g. --vary gear.eccentricity_mm=0.5:1.1"
            )
        if key in ranges:
            raise UsageError(f"--vary {key} is repeated: give one range for this key")
        ranges[key] = range_text.strip()
    return ranges


def _outcome(optimum: "Optimum", best: Path) -> Outcome:
    """Convert the result of an optimisation to printable output: tables, diagram and notes.

    `optimum` is the result, and `best` the file of the best design.
    """
    from cycloid_mj.explore.optimum import tables
    from cycloid_mj.plots.optimum import tradeoff_figure
    from cycloid_mj.plots.save import encode_figure

    picture = Path(FIGURE).stem
    headline_texts = {"evaluations": str(optimum.evaluations), "feasible": str(len(optimum.feasible))}
    headline_texts |= {key: f"{value:.5g}" for key, value in optimum.best_figures.items()}
    return Outcome(
        title=f"optimization of {optimum.task.reducer.design.name}",
        headline=dict(islice(headline_texts.items(), MOST_FIGURES)),
        summary=[optimum.words, *optimum.active_bounds, f"best design: {best}"],
        tables=tables(optimum),
        warnings=optimum.warnings,
        notes=optimum.notes,
        pictures={picture: partial(encode_figure, tradeoff_figure(optimum))},
        formats=("png",),
        captions={picture: FIGURE_CAPTION},
        result={**optimum.as_json(), "design": str(best)},
        filed=False,
    )
