"""``cycloid-mj report``: the review of logged runs as one HTML page."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import PointFlag, point
from cycloid_mj.cli.terminal import say
from cycloid_mj.errors import UsageError

EXAMPLES = """Examples:
  cycloid-mj report runs/pin.mcap
  cycloid-mj report runs/pin.mcap runs/nonpin.mcap --out compared.html"""

LogNames = Annotated[str, Parameter(metavar="RUN.mcap...", help="Logs of runs; several are set side by side.")]
OutFlag = Annotated[
    str | None,
    Parameter(metavar="FILE", help="HTML file; replaced if it exists. Default: the first log's path with .html."),
]


def report(*logs: LogNames, out: OutFlag = None, q: PointFlag = None) -> int:
    """Write the review of one or more logged runs as one HTML page.

    What was run, the table of findings, the paper's figures to zoom, the moving
    mechanism with its forces, load sharing, order spectrum, losses, warnings
    and provenance. The page needs no network and reads on paper too.
    """
    from cycloid_mj.log import read
    from cycloid_mj.report import report as reviewed
    from cycloid_mj.whole import write_whole

    place = point(q)
    if not logs:
        raise UsageError("no log is given: cycloid-mj report RUN.mcap...")
    if len(set(logs)) < len(logs):
        raise UsageError("a log is given twice: give each once")
    runs = {log: read(log) for log in logs}
    page = reviewed(runs, place)
    path = Path(logs[0]).with_suffix(".html") if out is None else Path(out)
    write_whole({path: page.encode()})
    say(str(path))
    return 0
