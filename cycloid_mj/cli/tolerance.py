"""``cycloid-mj tolerance``: Monte Carlo study of a design within its tolerances, with an error budget."""

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.interrupt import signal_name
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.cli.delivery import Destination, claim_destination, deliver, write
from cycloid_mj.cli.flags import (
    FLAT,
    PRESET,
    ClusterDelivery,
    PresetOptions,
    StudySolverFlag,
    integer_flag,
    out_flag,
    whole,
)
from cycloid_mj.cli.ranges import RANGES
from cycloid_mj.reducer import reducer_of

if TYPE_CHECKING:
    from cycloid_mj.explore.tolerances import StudyInterrupted, Tolerances

OUT = "runs/tolerance"
CAPTIONS = {
    "distributions": "Distributions of the samples that do not jam.",
    "budget": "Share of each tolerance in the variance, alone and with its interactions (Sobol indices).",
}

SamplesFlag = Annotated[int, integer_flag("Number of samples. Default: 10000.")]
SeedFlag = Annotated[
    int,
    integer_flag("Random seed; equal seeds draw equal samples. Default: 0."),
]
LimitFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--limit",
        metavar="'KEY<=NUMBER'",
        help="Upper (<=) or lower (>=) limit of a quantity of geometry, statics or life listed by `cycloid-mj "
        "figures`. May be repeated.",
    ),
]
VerifyFlag = Annotated[
    int,
    Parameter(
        metavar="K", converter=whole, help="Number of the five worst samples to run in full dynamics. Default: 0."
    ),
]
EXAMPLES = """Examples:
  cycloid-mj tolerance --design printed --set 'tolerance.cam="H8/f7"' --set 'tolerance.pin_position="normal 10"'
  cycloid-mj tolerance --design my.toml --samples 10000 --seed 1 --limit 'backlash_arcmin<=1' --out made
  cycloid-mj tolerance --design nonpin --set 'tolerance.profile="2: normal 0.2, 35: uniform 0.3"' --verify 1"""


@dataclass(frozen=True, kw_only=True)
class ToleranceDelivery(ClusterDelivery):
    """Flags for the results."""

    out: Annotated[str | None, out_flag("the samples, the JSON file, the page and the worst designs", OUT)] = None


DELIVERED = ToleranceDelivery()


def tolerance(
    design_options: Annotated[PresetOptions, FLAT] = PRESET,
    *,
    samples: SamplesFlag = 10_000,
    seed: SeedFlag = 0,
    limit: LimitFlag = (),
    verify: VerifyFlag = 0,
    solver: StudySolverFlag = "planar",
    output_flags: Annotated[ToleranceDelivery, FLAT] = DELIVERED,
) -> int:
    """Estimate yield and error budget from random samples within the tolerances.

    Tolerances are read from the table [tolerance] of the design file. They are deviations from the design in um:
    "normal 2" (standard deviation 2), "uniform 5" (from -5 to 5) or "between -1 4" (uniform, too); or they are a grade,
    "IT6". For clearances, a fit "H7/g6" is allowed too. Waves of the disc's profile are listed with their orders, "2:
    normal 1, 35: uniform 2". An RV reducer has its tolerances in [crank_tolerance]; its samples are computed in closed
    form and never jam.

    Every sample is solved by statics at 360 crank angles: at both ends of its backlash, and under the nominal torque
    without friction. A sample jams if its parts press against each other without a load. Jammed samples count in the
    yield only. If 99 % or more of the first 200 samples jam, the command names the pair that interferes and ends with
    exit code 1.

    The error budget ("tighten first") is the share of each tolerance in the variance of a quantity, by Sobol indices.
    The quantity is that of the first --limit, or the backlash. The budget needs at least 64 samples.

    The five worst samples that do not jam are written as design files. --verify K simulates the K worst of them with
    --solver: at speed, under the nominal torque, with friction and inertia. The CSV file has the deviations of each
    sample in um (drawn_cam_um, ...) and its quantities. Ctrl-C writes the samples that are finished.
    """
    from cycloid_mj.cli.progress import count_progress
    from cycloid_mj.explore.constraints import parse_limit
    from cycloid_mj.explore.tolerances import StudyInterrupted, TooManyJams
    from cycloid_mj.explore.tolerances import tolerance as run_study

    _require_in_range(samples, seed)
    engine = output_flags.engine("threads")
    design = design_options.resolve_checked()
    limits = [parse_limit(text, reducer_of(design)) for text in limit]
    files = [f"{design.name}-worst-1.toml", f"{design.name}-samples.csv"]
    destination = claim_destination(output_flags, f"{design.name}-tolerance", files, OUT, with_page=True)
    progress = count_progress("tolerance", output_flags.quiet)
    try:
        tolerances = run_study(design, samples, seed, limits, progress, engine, verify, solver)
    except StudyInterrupted as stop:
        raise _deliver_part(stop, destination, output_flags) from stop
    except TooManyJams as jam:
        # without --json the error is enough: a table of a yield of 0 % repeats it
        (deliver if output_flags.json else write)(_outcome(jam.tolerances), destination, output_flags)
        raise RunError(f"{jam}; these samples are in {destination.folder}") from jam
    return deliver(_outcome(tolerances), destination, output_flags)


def _deliver_part(stop: "StudyInterrupted", destination: Destination, output_flags: ToleranceDelivery) -> RunError:
    """Print and write the samples of an interrupted study, and return the error that says where they are."""
    deliver(_outcome(stop.tolerances), destination, output_flags)
    return RunError(
        f"stopped by {signal_name(stop)}; the results of the {stop.tolerances.samples_text} so far are in "
        f"{destination.folder}. Run the command again for all samples"
    )


def _require_in_range(samples: int, seed: int) -> None:
    """Raise UsageError if the number of samples or the seed is out of range."""
    low, high = RANGES.tolerance_samples
    if not low <= samples <= high:
        raise UsageError(f"--samples {samples} is out of range: give a number from {low} to {high}")
    if seed < 0:
        raise UsageError(f"--seed {seed} is out of range: give an integer of 0 or more")


def _outcome(tolerances: "Tolerances") -> Outcome:
    """Convert a tolerance study to printable results: yield, tables, figures, files of samples and worst designs."""
    from cycloid_mj.base.frame import csv_text
    from cycloid_mj.design import dump
    from cycloid_mj.plots.save import encode_figure
    from cycloid_mj.plots.tolerance import tolerance_figures

    name, (low, high) = tolerances.design, tolerances.yield_interval
    return Outcome(
        title=f"tolerances of {name}",
        condition=tolerances.condition,
        headline={
            "yield": f"{tolerances.good.mean():.2%}",
            "95 % confidence": f"{low:.2%} to {high:.2%}",
            "jam": f"{tolerances.jams.mean():.2%}",
            "samples": tolerances.sample_count,
            **({"tighten first": tolerances.budget[0].source} if tolerances.budget else {}),
        },
        summary=[tolerances.words],
        tables=tolerances.tables(),
        warnings=tolerances.warnings,
        notes=tolerances.notes,
        pictures={key: partial(encode_figure, figure) for key, figure in tolerance_figures(tolerances).items()},
        formats=(),
        captions=CAPTIONS,
        files={
            **{
                f"{name}-worst-{rank}.toml": dump(worst_design).encode()
                for rank, worst_design in enumerate(tolerances.worst, 1)
            },
            f"{name}-samples.csv": csv_text(tolerances.frame.columns, "nan").encode(),
        },
        result=tolerances.as_json(),
    )
