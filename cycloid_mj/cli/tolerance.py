"""``cycloid-mj tolerance``: what becomes of a design within its tolerances, and which of them to tighten first."""

import json as text_of
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.interrupt import cause
from cycloid_mj.base.whole import write_whole
from cycloid_mj.cli.flags import FLAT, HERE, PRESET, EngineOptions, ForceFlag, JsonFlag, PresetOptions, QuietFlag, whole
from cycloid_mj.cli.terminal import finite, say, say_json, show, tell
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.explore.tolerances import Tolerances

OUT = "runs/tolerance"
FILES = ("worst-1.toml", "samples.csv", "tolerance.json", "tolerance.html")
"""What every study of a design leaves, after the design's name."""
MOST_SAMPLES = 1_000_000

SamplesFlag = Annotated[int, Parameter(converter=whole, help="How many are drawn.")]
SeedFlag = Annotated[int, Parameter(converter=whole, help="Of the random draws: the same seed gives the same samples.")]
LimitFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--limit",
        metavar="'KEY<=NUMBER'",
        help="A figure, any of geometry, statics or life that `cycloid-mj figures` lists, is to be at most, or at "
        "least (>=), a number; repeatable.",
    ),
]
VerifyFlag = Annotated[
    int, Parameter(metavar="K", converter=whole, help="Run so many of the five worst samples in full dynamics.")
]
OutFlag = Annotated[
    Path, Parameter(metavar="DIR", help="Folder of the samples, the JSON file, the page and the worst designs.")
]

EXAMPLES = """Examples:
  cycloid-mj tolerance --design printed --set 'tolerance.cam="H8/f7"' --set 'tolerance.pin_position="normal 10"'
  cycloid-mj tolerance --design my.toml --samples 10000 --seed 1 --limit 'backlash_arcmin<=1' --out made
  cycloid-mj tolerance --design nonpin --set 'tolerance.profile="2: normal 0.2, 35: uniform 0.3"' --verify 1"""


def tolerance(
    chosen: Annotated[PresetOptions, FLAT] = PRESET,
    *,
    samples: SamplesFlag = 10_000,
    seed: SeedFlag = 0,
    limit: LimitFlag = (),
    verify: VerifyFlag = 0,
    out: OutFlag = Path(OUT),
    where: Annotated[EngineOptions, FLAT] = HERE,
    force: ForceFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Draw samples of a design within its tolerances, and tell yield, distributions and an error budget.

    Tolerances stand in the table [tolerance] of the design file, as "normal 2",
    "uniform 5", "between -1 4" (um), as a grade "IT6", or for clearances as a fit
    "H7/g6"; waves of the gear's profile by order, "2: normal 1, 35: uniform 2".
    Every sample is balanced at 360 crank angles: to both stops, and under the
    rated torque without friction. The budget shares the variance of the first
    limit's figure (else of the backlash) out to the tolerances, by Sobol indices:
    the one to tighten first comes first. A sample jams where its parts press each
    other without a load, teeth, output pins or cam: it is in the yield alone. Where
    the first 200 samples all jam, that is the end: which pair interferes by how
    much is told. The five worst of those that go together are written as design
    files; --verify runs them at speed under the rated torque, with friction and
    inertia, and tells how far statics are from that. The samples' CSV has what was
    drawn, in um beside the design's value (drawn_cam_um, drawn_pin_position_1_x_um),
    and the figures. Ctrl-C writes what the samples so far give, as fewer --samples
    would have.
    """
    from cycloid_mj.cli.outfile import folder
    from cycloid_mj.cli.progress import counted
    from cycloid_mj.explore.limit import limit as read
    from cycloid_mj.explore.tolerances import AllJam, Unfinished
    from cycloid_mj.explore.tolerances import tolerance as found_in

    if not 2 <= samples <= MOST_SAMPLES:
        raise UsageError(f"--samples {samples}: give from 2 to {MOST_SAMPLES}")
    if seed < 0:
        raise UsageError(f"--seed {seed}: give 0 or more")
    engine = where.engine("threads")
    design = chosen.sound()
    limits = [read(text, Reducer(design)) for text in limit]
    into = folder(str(out), "the samples", [f"{design.name}-{rest}" for rest in FILES], force)
    try:
        tolerances = found_in(design, samples, seed, limits, counted("tolerance", quiet), engine, verify)
    except Unfinished as stop:
        _deliver(stop.found, into, json, quiet)
        raise RunError(f"stopped by {cause(stop)}; {stop.found.told_samples} are in {into}") from stop
    except AllJam as jam:
        _deliver(jam.found, into, json, quiet)
        raise RunError(f"{jam}; they are in {into}") from jam
    _deliver(tolerances, into, json, quiet)
    return 0


def _deliver(tolerances: "Tolerances", into: Path, json: bool, quiet: bool) -> None:
    """Write the files, and tell what was found."""
    files = _files(tolerances, into)
    write_whole(files)
    if not quiet:
        tell(f"wrote {', '.join(map(str, files))}")
    if json:
        say_json(tolerances.as_json())
        return
    for table in tolerances.tables():
        show(table)
    for note in tolerances.notes:
        say(note)
    say(tolerances.words)


def _files(tolerances: "Tolerances", into: Path) -> dict[Path, bytes]:
    """Collect what is written, by path: the worst designs first, the page last."""
    from cycloid_mj.cli.outfile import csv_bytes
    from cycloid_mj.design import dump
    from cycloid_mj.plots.tolerance import tolerance_figures
    from cycloid_mj.report.study import PageSection, study_page

    figures = tolerance_figures(tolerances)
    shared = {
        "Shares of the variance, alone and with all that a tolerance acts together with (Sobol indices).": "budget"
    }
    ranked = {caption: figures[name] for caption, name in shared.items() if name in figures}
    spread, *others = tolerances.tables()
    tighten, checked = (others[:1], others[1:]) if tolerances.budget else ([], others)
    low, high = tolerances.yield_interval
    numbers = {
        "yield": f"{tolerances.good.mean():.2%}",
        "95 % confidence": f"{low:.2%} to {high:.2%}",
        "jam": f"{tolerances.jams.mean():.2%}",
        "samples": tolerances.told_count,
        **({"tighten first": tolerances.budget[0].source} if tolerances.budget else {}),
    }
    parts = [
        *(PageSection("Tighten this first", figures=ranked, tables=[table]) for table in tighten),
        PageSection(
            "Distributions", figures={"Over the samples that do not jam.": figures["distributions"]}, tables=[spread]
        ),
        *(PageSection("In full dynamics", tables=[table]) for table in checked),
        PageSection("What the numbers stand on", notes=[tolerances.condition, *tolerances.notes]),
    ]
    page = study_page(
        f"cycloid_mj: tolerances of {tolerances.design}", [tolerances.words, tolerances.condition], numbers, parts
    )
    name = tolerances.design
    return {
        **{into / f"{name}-worst-{i}.toml": dump(one).encode() for i, one in enumerate(tolerances.worst, 1)},
        into / f"{name}-samples.csv": csv_bytes(tolerances.frame.columns),
        into / f"{name}-tolerance.json": (text_of.dumps(finite(tolerances.as_json()), indent=2) + "\n").encode(),
        into / f"{name}-tolerance.html": page.encode(),
    }
