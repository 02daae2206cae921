"""``cycloid-mj tolerance``: what becomes of a design within its tolerances, and which of them to tighten first."""

import json as text_of
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import FLAT, HERE, PRESET, DesignOptions, EngineOptions, JsonFlag, QuietFlag
from cycloid_mj.cli.terminal import finite, say, say_json, show, tell
from cycloid_mj.errors import UsageError
from cycloid_mj.whole import write_whole

OUT = "runs/tolerance"
MOST_SAMPLES = 1_000_000

SamplesFlag = Annotated[int, Parameter(help="How many are drawn.")]
SeedFlag = Annotated[int, Parameter(help="Of the random draws: the same seed gives the same samples.")]
LimitFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--limit",
        metavar="'KEY<=NUMBER'",
        help="A figure is to be at most, or at least (>=), a number; repeatable.",
    ),
]
OutFlag = Annotated[Path, Parameter(metavar="DIR", help="Folder of the samples, the JSON file and the worst designs.")]

EXAMPLES = """Examples:
  cycloid-mj tolerance --design pin --set 'tolerance.cam="H7/g6"' --set 'tolerance.pin_position="normal 2"'
  cycloid-mj tolerance --design my.toml --samples 10000 --seed 1 --limit 'backlash_arcmin<=1' --out made"""


def tolerance(
    *,
    chosen: Annotated[DesignOptions, FLAT] = PRESET,
    samples: SamplesFlag = 10_000,
    seed: SeedFlag = 0,
    limit: LimitFlag = (),
    out: OutFlag = Path(OUT),
    where: Annotated[EngineOptions, FLAT] = HERE,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Draw samples of a design within its tolerances, and tell yield, distributions and an error budget.

    Tolerances stand in the table [tolerance] of the design file, as "normal 2",
    "uniform 5", "between -1 4" (um), as a grade "IT6", or for clearances as a fit
    "H7/g6". Every sample is balanced at 360 crank angles: to both stops, and
    under the rated torque without friction. The budget shares the variance of the
    first limit's figure (else of the backlash) out to the tolerances, by Sobol
    indices: the one to tighten first comes first. The five worst samples are
    written as design files.
    """
    from cycloid_mj.cli.outfile import folder
    from cycloid_mj.cli.progress import counted
    from cycloid_mj.design import dump
    from cycloid_mj.explore.limit import limit as read
    from cycloid_mj.explore.tolerances import FIGURES
    from cycloid_mj.explore.tolerances import tolerance as found_in

    if not 2 <= samples <= MOST_SAMPLES:
        raise UsageError(f"--samples {samples}: give from 2 to {MOST_SAMPLES}")
    if seed < 0:
        raise UsageError(f"--seed {seed}: give 0 or more")
    engine = where.engine("threads")
    limits = [read(text, FIGURES) for text in limit]
    design = chosen.sound()
    into = folder(str(out), "the samples")
    found = found_in(design, samples, seed, limits, counted("tolerance", quiet), engine)
    rows = zip(*found.figures.values(), strict=True)
    lines = [
        ",".join(("sample", *found.figures)),
        *(",".join(map(repr, (i, *map(float, row)))) for i, row in enumerate(rows, 1)),
    ]
    files = {
        into / f"{design.name}-samples.csv": "\n".join(lines) + "\n",
        into / f"{design.name}-tolerance.json": text_of.dumps(finite(found.as_json()), indent=2) + "\n",
        **{into / f"{design.name}-worst-{i}.toml": dump(one) for i, one in enumerate(found.worst, 1)},
    }
    write_whole({path: text.encode() for path, text in files.items()})
    if not quiet:
        tell(f"wrote {', '.join(map(str, files))}")
    if json:
        say_json(found.as_json())
        return 0
    for table in found.tables():
        show(table)
    low, high = found.yield_interval
    asked = " and ".join(map(str, limits)) or "no limit but that the parts go together"
    say(f"yield {found.good.mean():.2%} (95 %: {low:.2%} to {high:.2%}), {asked}; {found.jams.mean():.2%} jam")
    return 0
