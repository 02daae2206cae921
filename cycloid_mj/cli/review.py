"""``cycloid-mj report``: the review of logged runs as one HTML page."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.cli.delivery import Destination, claim_page, deliver
from cycloid_mj.cli.flags import COMMON, FLAT, CommonFlags, PointFlag, parse_point
from cycloid_mj.cli.terminal import printable

EXAMPLES = """Examples:
  cycloid-mj report runs/pin.mcap
  cycloid-mj report runs/pin.mcap runs/nonpin.mcap --out compared.html"""

LogNames = Annotated[str, Parameter(metavar="RUN.mcap...", help="Logs of runs; several are shown side by side.")]
OutFlag = Annotated[
    str | None,
    Parameter(metavar="FILE", help="HTML file, the same as --html. Default: the path of the first log with .html."),
]


def report(
    *logs: LogNames,
    out: OutFlag = None,
    q: PointFlag = None,
    output_flags: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Write an HTML report of one or more logged runs.

    The report contains run conditions, a table of measured values, zoomable diagrams (among them Figs 5-9 of Hsieh
    2014), the animated mechanism with forces, load sharing, order spectrum, losses, warnings and provenance. The page
    needs no network and can be printed.
    """
    from cycloid_mj.log import read
    from cycloid_mj.report import report as write_report

    point_q = parse_point(q)
    if not logs:
        raise UsageError("no log is given: name at least one log, e.g. cycloid-mj report runs/pin.mcap")
    repeated_log = next((log for index, log in enumerate(logs) if log in logs[:index]), None)
    if repeated_log is not None:
        raise UsageError(f"log {repeated_log} is given twice: name each log once")
    # a page is UTF-8, which names of files need not be
    runs = {printable(log): read(log) for log in logs}
    page_names = tuple(dict.fromkeys((*([out] if out else ()), *(output_flags.html or ()))))
    page_names = page_names or (str(Path(logs[0]).with_suffix(".html")),)
    destination = Destination("report", None, claim_page(replace(output_flags, html=page_names), "report"))
    review = write_report(runs, point_q)
    outcome = Outcome(title="review", text=page_names, result={"files": list(page_names)}, page=lambda: review)
    return deliver(outcome, destination, output_flags)
