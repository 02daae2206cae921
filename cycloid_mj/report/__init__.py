"""The review of logged runs: one HTML page that needs no network, for a screen, a phone or paper.

The page's numbers come from ``analysis`` and the runs; its figures are drawn by the page itself from arrays that it
carries (``page.js`` and its neighbours), so that they can be zoomed and share one cursor.
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

__all__ = ["MOST_RUNS", "ReportPage", "main", "report", "review_page"]

MOST_RUNS = len(PALETTE)
"""Runs that can be told apart in one figure."""


class ReportPage(str):
    """A page as HTML text: `repr` tells it in a line, and a notebook shows it in a frame of its own."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"<ReportPage: {len(self) // 1000} kB of HTML, to be written to a file>"

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{escape(self)}" style="width: 100%; height: 45em; border: 0"></iframe>'


def review_page(log: Path, run: Run | None = None) -> str:
    """Write the review of one logged run, which `report` names by the log's path; for the errors see there.

    Forces, most of a long run, are read of the samples alone that the page shows the mechanism in.

    Parameters
    ----------
    log
        File of the run.
    run
        The run without its forces, if it was read already.
    """
    from cycloid_mj.log import read

    (item,) = review({str(log): run or read(log, without=(FORCES,))})
    return _page([replace(item, shown=read(log, rows=frames(item.motion)))])


def report(runs: Mapping[str, Run], q: npt.ArrayLike | None = None, settle: float | None = None) -> ReportPage:
    """Write the review of runs as one self-contained HTML page; several are set side by side.

    Parameters
    ----------
    runs
        Name of the log -> run.
    q
        Point of the gear that is followed, gear frame [m]; by default the centre of hole 1, on +y.
    settle
        Time after the ramp that is not judged [s], but never more than half of the hold; by default as long as a jolt
        takes to ring out.

    Raises
    ------
    UsageError
        There is no run, or too many, or `q` is no point.
    LogError
        A run has no design, lacks a column, or has fewer than two samples.

    Warns
    -----
    CycloidWarning
        Why figures of a run are not those of its design; the page has it, too.
    """
    if not 1 <= len(runs) <= MOST_RUNS:
        raise UsageError(f"a report of {len(runs)} runs: give 1 to {MOST_RUNS} logs")
    return _page(review(runs, q, settle))


def _page(reviewed: Sequence[Reviewed]) -> ReportPage:
    """Write the page of judged runs, and warn of what is wrong with their figures."""
    for item in reviewed:
        warn(item.name, item.findings.warnings)
    return ReportPage(page(reviewed))


main = report
sys.modules[__name__].__class__ = CallableRoom
