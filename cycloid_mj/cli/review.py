"""``cycloid-mj report``: the review of logged runs as one HTML page."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.replacing import claim, require_ending
from cycloid_mj.cli.flags import ForceFlag, JsonFlag, PointFlag, QuietFlag, point
from cycloid_mj.cli.terminal import printable, say_files

EXAMPLES = """Examples:
  cycloid-mj report runs/pin.mcap
  cycloid-mj report runs/pin.mcap runs/nonpin.mcap --out compared.html"""

LogNames = Annotated[str, Parameter(metavar="RUN.mcap...", help="Logs of runs; several are set side by side.")]
OutFlag = Annotated[
    str | None,
    Parameter(metavar="FILE", help="HTML file. Default: the first log's path with .html."),
]


def report(
    *logs: LogNames,
    out: OutFlag = None,
    q: PointFlag = None,
    json: JsonFlag = False,
    force: ForceFlag = False,
    _quiet: QuietFlag = False,
) -> int:
    """Write the review of one or more logged runs as one HTML page.

    What was run, the table of findings, the paper's figures to zoom, the moving
    mechanism with its forces, load sharing, order spectrum, losses, warnings
    and provenance. The page needs no network and reads on paper too.
    """
    from cycloid_mj.base.whole import write_whole
    from cycloid_mj.log import read
    from cycloid_mj.report import report as reviewed

    place = point(q)
    if not logs:
        raise UsageError("no log is given: cycloid-mj report RUN.mcap...")
    if len(set(logs)) < len(logs):
        raise UsageError("a log is given twice: give each once")
    # a page is UTF-8, which names of files need not be
    runs = {printable(log): read(log) for log in logs}
    path = Path(logs[0]).with_suffix(".html") if out is None else Path(out)
    require_ending(path, ".html")
    claim(path, force=force)
    page = reviewed(runs, place)
    write_whole({path: page.encode()})
    say_files([path], json)
    return 0
