"""``cycloid-mj animate``: an animation of a logged run, drawn in its plane."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.base.animation import ANIMATION
from cycloid_mj.base.overwrite_guard import claim_outputs
from cycloid_mj.cli.analyze import LogName
from cycloid_mj.cli.delivery import claim_page, deliver_files
from cycloid_mj.cli.flags import COMMON, FLAT, CommonFlags, whole, within
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
    Parameter(
        metavar="N",
        converter=whole,
        validator=within(*RANGES.frames),
        help=f"Maximum number of frames. Default: {ANIMATION.frames}.",
    ),
]
TurnsFlag = Annotated[
    float,
    Parameter(
        metavar="X",
        validator=within(*RANGES.turns),
        help="Number of crank turns, from the start of the steady part of the run. Default: 1.",
    ),
]
RateFlag = Annotated[
    int,
    Parameter(
        name="--fps",
        metavar="N",
        converter=whole,
        validator=within(*ANIMATION.rates),
        help=f"Frames per second, {ANIMATION.rates[0]} to {ANIMATION.rates[1]}. Default: {ANIMATION.rate}.",
    ),
]
DiscFlag = Annotated[
    int,
    Parameter(
        name="--disc",
        metavar="N",
        converter=whole,
        validator=within(1, 4),
        help="Number of the disc that is drawn with its forces; other discs are outlines. Default: 1.",
    ),
]
WidthFlag = Annotated[
    int,
    Parameter(
        metavar="N",
        converter=whole,
        validator=within(*ANIMATION.widths),
        help=f"Width [pixels], {ANIMATION.widths[0]} to {ANIMATION.widths[1]}. Default: {ANIMATION.width}.",
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
    delivery: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Draw an animation of a logged run with forces and loads.

    No display is needed. --magnify enlarges each gap between the disc and the parts that touch it; overlaps show the
    elastic deflection of contacts. MP4 requires pip install 'cycloid-mj[video]'.
    """
    from cycloid_mj.log import read
    from cycloid_mj.plots.animation import draw_frames, select_samples
    from cycloid_mj.plots.movie import write_movie

    scene = select_samples(read(log), magnify, frames, turns, disc - 1)
    claim_outputs(Path(out), force=delivery.force)
    page = claim_page(delivery, f"{Path(out).stem}-film")
    write_movie(draw_frames(scene, width), out, fps)
    return deliver_files(f"film: {log}", [out], page, delivery)
