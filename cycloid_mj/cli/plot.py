"""``cycloid-mj log plot``: draw the motion of a logged run."""

from functools import partial
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import warn
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.cli.analyze import LogName
from cycloid_mj.cli.delivery import Destination, claim_page, deliver
from cycloid_mj.cli.flags import COMMON, FLAT, CommonFlags, PointFlag, parse_point
from cycloid_mj.cli.outfile import claim_folder

EXAMPLES = """Examples:
  cycloid-mj log plot runs/pin.mcap
  cycloid-mj log plot runs/pin.mcap --q 26,0 --out figures --format svg"""

Format = Literal["png", "svg", "pdf"]
FormatFlag = Annotated[Format, Parameter(name="--format", help="File format of the figures. Default: png.")]
OutFlag = Annotated[
    str | None,
    Parameter(
        metavar="DIR",
        help="Folder of the figures; it is created if it does not exist. Default: the path of the log without .mcap.",
    ),
]


def plot(
    log: LogName,
    /,
    *,
    q: PointFlag = None,
    out: OutFlag = None,
    format_: FormatFlag = "png",
    output_flags: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Draw the motion in a logged run: crank, disc, point q, pin 1.

    The figures show the speeds of crank and disc, the path and velocity of q, and the spin and centre of pin 1, each
    together with its closed form, as in Hsieh 2014, Figs 5-9. A further figure shows the transmission error. The file
    names are printed, one per line. Only the log is read. If the run ended while the crank was still accelerated, the
    figures show the motion up to then.
    """
    point_q = parse_point(q)
    from cycloid_mj.analysis import judge, series
    from cycloid_mj.log import read
    from cycloid_mj.plots import figures
    from cycloid_mj.plots.save import encode_figure

    motion = series(read(log), point_q)
    warn(motion.design.name, judge(motion).warnings)
    figures_by_name = figures(motion)
    names = [f"{name}.{format_}" for name in figures_by_name]
    folder = claim_folder(
        str(Path(log).with_suffix("")) if out is None else out, "the figures", names, output_flags.force
    )
    stem = f"{Path(log).stem}-figures"
    destination = Destination(stem, folder, claim_page(output_flags, stem, folder))
    outcome = Outcome(
        title=f"figures: {log}",
        text=destination.paths(names),
        pictures={name: partial(encode_figure, figure) for name, figure in figures_by_name.items()},
        formats=(format_,),
        result={"files": destination.paths(names)},
        filed=False,
    )
    return deliver(outcome, destination, output_flags)
