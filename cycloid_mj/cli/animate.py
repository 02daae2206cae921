"""``cycloid-mj animate``: an animation of a logged run, drawn in its plane."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.base.animation import ANIMATION
from cycloid_mj.cli.analyze import LogName
from cycloid_mj.cli.delivery import claim_page, deliver_files
from cycloid_mj.cli.flags import COMMON, FLAT, CommonFlags, integer_flag, number_flag
from cycloid_mj.cli.outfile import claim_file
from cycloid_mj.cli.ranges import RANGES

EXAMPLES = """Examples:
  cycloid-mj animate runs/pin.mcap pin.gif
  cycloid-mj animate runs/pin.mcap pin.mp4 --magnify 200 --turns 3 --frames 600"""

MovieName = Annotated[str, Parameter(name="--out", metavar="FILE", help="Animation to write, .gif or .mp4.")]
MagnifyFlag = Annotated[
    float,
    Parameter(metavar="X", help="Scale of gaps and clearances in the drawing (1 um is invisible). Default: 1."),
]
FramesFlag = Annotated[
    int,
    integer_flag(f"Maximum number of frames. Default: {ANIMATION.frames}.", RANGES.frames),
]
TurnsFlag = Annotated[
    float,
    number_flag("Number of crank turns, from the start of the steady part of the run. Default: 1.", RANGES.turns),
]
RateFlag = Annotated[
    int,
    integer_flag(
        f"Frames per second, {ANIMATION.rates[0]} to {ANIMATION.rates[1]}. Default: {ANIMATION.rate}.",
        ANIMATION.rates,
        name="--fps",
    ),
]
DiscFlag = Annotated[
    int,
    integer_flag(
        "Number of the disc that is drawn with its forces; other discs are outlines. Default: 1.", (1, 4), name="--disc"
    ),
]
WidthFlag = Annotated[
    int,
    integer_flag(
        f"Width [pixels], {ANIMATION.widths[0]} to {ANIMATION.widths[1]}. Default: {ANIMATION.width}.", ANIMATION.widths
    ),
]


def animate(
    log: LogName,
    /,
    out: MovieName,
    *,
    magnify: MagnifyFlag = 1.0,
    frames: FramesFlag = ANIMATION.frames,
    turns: TurnsFlag = 1.0,
    fps: RateFlag = ANIMATION.rate,
    width: WidthFlag = ANIMATION.width,
    disc: DiscFlag = 1,
    output_flags: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Draw an animation of a logged run with forces and loads.

    No display is needed. --magnify enlarges each gap between the disc and the parts that touch it; overlaps show the
    elastic deflection of contacts. MP4 requires pip install 'cycloid-mj[video]'.
    """
    from cycloid_mj.log import read
    from cycloid_mj.plots.animation import draw_frames, select_samples
    from cycloid_mj.plots.movie import write_movie

    scene = select_samples(read(log), magnify, frames, turns, disc - 1)
    claim_file(Path(out), output_flags.force)
    page = claim_page(output_flags, f"{Path(out).stem}-film")
    write_movie(draw_frames(scene, width), out, fps)
    return deliver_files(f"film: {log}", [out], page, output_flags)
