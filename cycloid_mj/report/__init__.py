"""Reports of logged runs: one HTML page that needs no network, for a screen, a phone or paper.

Its numbers come from ``analysis`` and the runs. Its charts are drawn by scripts of the page (``page.js``, ``chart.js``)
from arrays that the page contains, so that they can be zoomed and share a cursor.
"""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy.typing as npt

from cycloid_mj.base.errors import UsageError, warn
from cycloid_mj.base.names import FORCES
from cycloid_mj.base.notebook_display import CallableRoom
from cycloid_mj.base.record import Run
from cycloid_mj.report.page import page
from cycloid_mj.report.reviewed import PALETTE, Reviewed, frames, review

__all__ = ["MAX_RUNS", "ReportPage", "main", "report", "review_page"]

MAX_RUNS = len(PALETTE)
"""Runs of one report: as many as there are distinguishable colours."""


class ReportPage(str):
    """HTML text of a page, with a short `repr`; a notebook shows the page in a frame."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"<ReportPage: {len(self) // 1000} kB of HTML; write it to a file to open it in a browser>"

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{escape(self)}" style="width: 100%; height: 45em; border: 0"></iframe>'


def review_page(log: Path, run: Run | None = None) -> str:
    """Return the report of one logged run as an HTML page.

    Forces are most of a long log. They are read only for the samples at which the page shows the mechanism.

    Parameters
    ----------
    log
        File of the run.
    run
        The run without its forces, if it has been read already.

    Raises
    ------
    LogError
        The run has no design, lacks a column, or has fewer than two samples.
    """
    from cycloid_mj.log import read

    (reviewed_run,) = review({str(log): run or read(log, without=(FORCES,))})
    return _page([replace(reviewed_run, shown=read(log, rows=frames(reviewed_run.motion)))])


def report(runs: Mapping[str, Run], q: npt.ArrayLike | None = None, settle: float | None = None) -> ReportPage:
    """Return the report of runs as a self-contained HTML page; several runs are compared side by side.

    Parameters
    ----------
    runs
        Name of the log -> run.
    q
        Point of the disc whose path is shown, in the frame of the disc [m]. Default: centre of hole 1, on +y.
    settle
        Time after the ramp of the crank speed that is not evaluated [s], at most half of the simulated time at constant
        speed. Default: an estimate.

    Returns
    -------
    ReportPage
        HTML text; a notebook shows the page.

    Raises
    ------
    UsageError
        There is no run, there are too many, or `q` is not a point.
    LogError
        A run has no design, lacks a column, or has fewer than two samples.

    Warns
    -----
    CycloidWarning
        Why results of a run are not representative of its design; the page lists the same warnings.
    """
    if not 1 <= len(runs) <= MAX_RUNS:
        raise UsageError(
            f"the number of logs is {len(runs)}, but a report shows 1 to {MAX_RUNS}: give fewer logs, or make several "
            "reports"
        )
    return _page(review(runs, q, settle))


def _page(reviewed: Sequence[Reviewed]) -> ReportPage:
    """Return the page of evaluated runs, and issue their warnings."""
    for item in reviewed:
        warn(item.name, item.findings.warnings)
    return ReportPage(page(reviewed))


main = report
sys.modules[__name__].__class__ = CallableRoom
