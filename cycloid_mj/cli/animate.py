"""``cycloid-mj animate``: a logged run as a film, drawn in its plane."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.base.overwrite_guard import claim
from cycloid_mj.cli.analyze import LogName
from cycloid_mj.cli.delivery import claimed_page, deliver_files
from cycloid_mj.cli.flags import COMMON, FLAT, CommonFlags, whole, within

EXAMPLES = """Examples:
  cycloid-mj animate runs/pin.mcap pin.gif
  cycloid-mj animate runs/pin.mcap pin.mp4 --magnify 200 --turns 3 --frames 600"""

FRAMES, RATE, WIDTH = 90, 25, 640
MOST_FRAMES, MOST_TURNS = 20_000, 10_000.0

MovieName = Annotated[str, Parameter(name="--out", metavar="FILE", help="Film to write, .gif or .mp4.")]
MagnifyFlag = Annotated[
    float,
    Parameter(
        metavar="X", help="How many times as wide gaps and clearances are drawn: 1 um cannot be seen. Default: 1."
    ),
]
FramesFlag = Annotated[
    int,
    Parameter(
        metavar="N", converter=whole, validator=within(1, MOST_FRAMES), help=f"Frames at the most. Default: {FRAMES}."
    ),
]
TurnsFlag = Annotated[
    float,
    Parameter(
        metavar="X", validator=within(1e-3, MOST_TURNS), help="Crank turns, from the settled hold on. Default: 1."
    ),
]
RateFlag = Annotated[
    int,
    Parameter(
        name="--fps",
        metavar="N",
        converter=whole,
        validator=within(1, 50),
        help=f"Frames per second, 1 to 50. Default: {RATE}.",
    ),
]
DiscFlag = Annotated[
    int,
    Parameter(
        name="--disc",
        metavar="N",
        converter=whole,
        validator=within(1, 4),
        help="Which of several discs is shown with its forces; the others are outlines. Default: 1.",
    ),
]
WidthFlag = Annotated[
    int,
    Parameter(
        metavar="N",
        converter=whole,
        validator=within(200, 4000),
        help=f"Width [pixels], 200 to 4000. Default: {WIDTH}.",
    ),
]


def animate(
    log: LogName,
    /,
    out: MovieName,
    *,
    magnify: MagnifyFlag = 1.0,
    frames: FramesFlag = FRAMES,
    turns: TurnsFlag = 1.0,
    fps: RateFlag = RATE,
    width: WidthFlag = WIDTH,
    disc: DiscFlag = 1,
    delivery: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Draw a logged run in motion, with forces and loads.

    It needs no display. With --magnify each gap between the gear and what
    touches it is drawn that many times as wide; an overlap is elastic approach.
    MP4 needs: pip install 'cycloid-mj[video]'.
    """
    from cycloid_mj.log import read
    from cycloid_mj.plots.animation import film, take
    from cycloid_mj.plots.movie import write_movie

    scene = take(read(log), magnify, frames, turns, disc - 1)
    claim(Path(out), force=delivery.force)
    page = claimed_page(delivery, f"{Path(out).stem}-film")
    write_movie(film(scene, width), out, fps)
    return deliver_files(f"film: {log}", [out], page, delivery)
