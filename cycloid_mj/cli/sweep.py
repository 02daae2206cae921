"""``cycloid-mj sweep``: results of a design at many points, one row per point."""

from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.interrupt import signal_name
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.cli import flags
from cycloid_mj.cli.delivery import Destination, claim_destination, deliver
from cycloid_mj.cli.terminal import tell
from cycloid_mj.reducer import reducer_of

if TYPE_CHECKING:
    from cycloid_mj.explore.points import Points
    from cycloid_mj.explore.sweeps import Sweep

OUT, STEM = "runs/sweep", "sweep"
FILES = ("sweep.parquet", "sweep.png", "sweep.svg")
POINTS = 64
MOST_ERRORS = 5
"""Default number of drawn points, and largest number of failed points that are listed."""

EXAMPLES = """Examples:
  cycloid-mj sweep --design pin --vary clearance.cam_um=1:5:5 --measure statics
  cycloid-mj sweep --design my.toml --vary load.torque_nm=5:40:8 --vary ring.kind=pin,nonpin \
--measure simulate,mass --out loads
  cycloid-mj sweep --design pin --vary clearance.cam_um=1:5 --vary errors.pin_position_um=0:2 \
--sample sobol --points 64 --out drawn
  cycloid-mj sweep --design pin --vary gear.eccentricity_mm=0.6:1:5 \
--follow output.hole_radius_mm --measure statics --out eccentricity
  cycloid-mj sweep --design pin --vary gear.face_width_mm=8:16:5 --measure mass_kg,life_h --out widths
  cycloid-mj sweep --design pin --table points.csv --measure backlash --quick --scheduler 10.0.0.1:8786 --out table"""

VaryFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--vary",
        metavar="KEY=VALUES",
        help="Key of the design file and its values: a,b,c or LO:HI:N, with --sample also LO:HI. Several keys form a "
        "grid. May be repeated.",
    ),
]
TableFlag = Annotated[
    Path | None,
    Parameter(
        metavar="POINTS.csv", help="CSV file of points, with keys of the design file as its header; replaces --vary."
    ),
]
SampleFlag = Annotated[
    Literal["sobol", "lhs", "random"] | None,
    Parameter(
        help="Draw points from the ranges by a scrambled Sobol sequence, a Latin hypercube or independent random "
        "numbers. Words and switches are drawn from their values."
    ),
]
PointsFlag = Annotated[
    int | None,
    flags.integer_flag(f"Number of points drawn with --sample. Default: {POINTS}."),
]
SeedFlag = Annotated[
    int,
    flags.integer_flag("Random seed. Default: 0.", (0, 2**63)),
]
MeasureFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--measure",
        metavar="NAME[,NAME]",
        help="What to evaluate: statics, te, backlash, lost-motion, loads, torque, efficiency, vibration, simulate, "
        "mass, checks, keys of `cycloid-mj figures`, or figures for all of geometry and statics. With several, columns "
        "start with the measure's name. Default: statics.",
    ),
]
QuickFlag = Annotated[bool, Parameter(help="Use fewer angles and runs, as the measures' own --quick.")]
RealPinsFlag = Annotated[
    bool,
    Parameter(
        name="--real-pins",
        help="Keep the inertia of moving pins in loaded runs of `simulate`, which then take 30 to 60 times as long. "
        "Mean values and forces change by 0.2 %, speed fluctuations by up to 20 %.",
    ),
]
ShowFlag = Annotated[
    str, Parameter(metavar="COLUMN[,COLUMN]", help="Quantities to plot. Default: up to six that vary.")
]


@dataclass(frozen=True, kw_only=True)
class SweepDelivery(flags.ClusterDelivery):
    """Flags for the results."""

    out: Annotated[str | None, flags.out_flag("the rows, the tables, the figure and the page", OUT)] = None


DELIVERED = SweepDelivery()


def sweep(
    design_options: Annotated[flags.PresetOptions, flags.FLAT] = flags.PRESET,
    *,
    vary: VaryFlag = (),
    table: TableFlag = None,
    sample: SampleFlag = None,
    points: PointsFlag = None,
    seed: SeedFlag = 0,
    measure: MeasureFlag = ("statics",),
    quick: QuickFlag = False,
    real_pins: RealPinsFlag = False,
    solver: flags.StudySolverFlag = "planar",
    follow: flags.FollowFlag = (),
    show_: Annotated[ShowFlag, Parameter(name="--show")] = "",
    output_flags: Annotated[SweepDelivery, flags.FLAT] = DELIVERED,
) -> int:
    """Evaluate a design over a grid, a sample or a table of parameter values.

    Any key of the design file can be varied: numbers, words and switches. Further keys
    can be computed from the varied keys (--follow), e.g. the radius of the output holes
    from the eccentricity. Results are written to DIR/sweep.csv and DIR/sweep.parquet, one row per point: inputs,
    quantities with the unit in the column's name, the error if the point failed, CPU time
    and versions. Rows are saved as soon as they are computed. To resume an interrupted
    sweep, run the same command again.

    Loaded runs (`simulate`) neglect the inertia of moving pins, unless --real-pins is set or ring.pins is varied. With
    --quick, measurements use fewer angles and runs. The exit code is 1 if every point failed.
    """
    from cycloid_mj.cli.progress import count_progress
    from cycloid_mj.explore.journal import SWEEP, has_study, remove_study
    from cycloid_mj.explore.ranks import select_quantities
    from cycloid_mj.explore.sweeps import define_task, sweep_in_folder

    points_to_evaluate = _choose_points(vary, table, sample, points, seed)
    engine = output_flags.engine()
    task = define_task(
        reducer_of(design_options.resolve()), points_to_evaluate, measure, quick, real_pins, follow, solver
    )
    is_resumed = has_study(Path(output_flags.out or OUT), SWEEP)
    destination = claim_destination(output_flags, STEM, FILES, OUT, with_page=True, resumed=is_resumed)
    directory = destination.folder or Path(OUT)
    if output_flags.force:
        remove_study(directory, SWEEP)
    try:
        sweep_result = sweep_in_folder(
            task, points_to_evaluate, directory, engine, count_progress("sweep", output_flags.quiet)
        )
    except KeyboardInterrupt as stop:
        raise RunError(
            f"stopped by {signal_name(stop)}; the points evaluated so far are in {directory}. Run the same command "
            "again to resume"
        ) from stop
    quantities = select_quantities(sweep_result, tuple(name for name in show_.split(",") if name))
    exit_code = deliver(_outcome(sweep_result, quantities, destination), destination, output_flags)
    for error, count in list(sweep_result.errors.items())[:MOST_ERRORS]:
        tell(f"{count} of {len(sweep_result.points)} points failed: {error}")
    if (unlisted_errors := len(sweep_result.errors) - MOST_ERRORS) > 0:
        tell(f"{unlisted_errors} more types of error: see the column `error` of the files in {directory}")
    return exit_code


def _choose_points(
    vary: tuple[str, ...], table: Path | None, sample: str | None, points: int | None, seed: int
) -> "Points":
    """Return the points that the flags describe: the rows of a table, a grid, or a sample of varied keys.

    Parameters
    ----------
    vary
        Texts of ``--vary``, such as ``clearance.cam_um=1:5:5``.
    table
        CSV file with one point per row, or None.
    sample, points, seed
        Kind of the sample (None: a grid), number of its points (None: the default), and its seed.

    Raises
    ------
    UsageError
        A ``--vary`` has no values, a key is varied twice, or `choose_points` refuses the points.
    """
    from cycloid_mj.explore.points import read_table
    from cycloid_mj.explore.sweeps import choose_points

    ranges: dict[str, str] = {}
    for text in vary:
        key, equals_sign, values = text.partition("=")
        if not equals_sign or not key.strip() or not values.strip():
            raise UsageError(f"--vary {text!r} has no values: give KEY=VALUES, e.g. --vary clearance.cam_um=1:5:5")
        if key.strip() in ranges:
            raise UsageError(f"--vary {key.strip()} is repeated: list all values of this key in one --vary")
        ranges[key.strip()] = values.strip()
    if table is not None and not (vary or sample or points):
        return read_table(table)
    draw_count = (POINTS if points is None else points) if sample else (points or 0)
    return choose_points(ranges, None if table is None else [], sample, draw_count, seed)  # type: ignore[arg-type]  # cyclopts checks


def _outcome(sweep: "Sweep", quantities: tuple[str, ...], destination: Destination) -> Outcome:
    """Convert a sweep to printable results: tables and a diagram of `quantities`, numbers of points, and the page.

    `destination` has the folder in which the sweep wrote its tables, and the path of the page. Failed points are
    counted. The exit code is 1 if all points failed, else 0.
    """
    from cycloid_mj.explore.ranks import tabulate_quantities
    from cycloid_mj.explore.sweeps import PARQUET, TABLE
    from cycloid_mj.plots.explored import sweep_figure
    from cycloid_mj.plots.save import encode_figure
    from cycloid_mj.report.sweep import sweep_page

    directory = destination.folder or Path(OUT)
    table_file, parquet_file = directory / TABLE, directory / PARQUET
    encode_diagram = cache(partial(encode_figure, sweep_figure(sweep, quantities)))
    missing_parquet_note = "sweep.parquet was not written: it requires DuckDB, pip install 'cycloid-mj[parquet]'"
    return Outcome(
        title=f"sweep of {sweep.task.reducer.design.name}",
        headline={"points": str(len(sweep.points)), "failed": str(sweep.failed), "rows": str(table_file)},
        warnings=[] if parquet_file.exists() else [missing_parquet_note],
        summary=[f"{len(sweep.points)} points, {sweep.failed} failed"],
        tables=tabulate_quantities(sweep, quantities),
        notes=[f"assumed: {sentence}" for sentence in sweep.assumptions],
        pictures={STEM: encode_diagram},
        result={
            "points": len(sweep.points),
            "failed": sweep.failed,
            "table": str(table_file),
            "parquet": str(parquet_file) if parquet_file.exists() else None,
            "page": str(destination.page),
            "quantities": {name: sweep.frame.units.get(name, "1") for name in sweep.quantities},
            "assumptions": list(sweep.assumptions),
        },
        filed=False,
        page=lambda: sweep_page(sweep, quantities, encode_diagram("svg")),
        code=1 if sweep.failed == len(sweep.points) else 0,
    )
