"""A run of a report: series, findings and log, with its short name and colour."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePath

import numpy as np
import numpy.typing as npt

from cycloid_mj.analysis import Findings, Series, judge, series
from cycloid_mj.base.array import Integers
from cycloid_mj.base.record import Run

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Colours of the runs (Okabe and Ito)."""

MAX_FRAMES = 360
"""Frames of the animated mechanism."""


@dataclass(frozen=True, eq=False)
class Reviewed:
    """A run of a report, with its short name and colour; `shown` is the run at the `frames` of its mechanism."""

    log: str
    motion: Series
    findings: Findings
    name: str
    colour: str
    shown: Run


def frames(motion: Series) -> Integers:
    """Return the indices of the samples in which the mechanism is shown: evenly spaced over a settled crank turn."""
    turn = motion.one_turn
    return np.unique(np.linspace(turn.start, turn.stop - 1, MAX_FRAMES).round().astype(np.int64))


def review(runs: Mapping[str, Run], q: npt.ArrayLike | None = None, settle: float | None = None) -> list[Reviewed]:
    """Return the evaluation of each run: its series, findings, short name and colour.

    `runs` are the runs by the names of their logs. `q` is a point of the disc [m], by default the centre of its hole 1,
    and `settle` the time after the speed ramp [s] that is not evaluated; see `analysis.series`, also for errors.
    """
    motions = [series(run, q, settle) for run in runs.values()]
    names = _names(list(runs), [motion.design.name for motion in motions])
    shown_runs = [motion.run.select(np.isin(np.arange(len(motion.run)), frames(motion))) for motion in motions]
    fields_by_run = zip(runs, motions, map(judge, motions, runs), names, PALETTE, shown_runs, strict=False)
    return [Reviewed(*fields) for fields in fields_by_run]


def _names(logs: Sequence[str], designs: Sequence[str]) -> Sequence[str]:
    """Return a short name for each run: that of its design, or of its log if designs share a name."""
    stems = [PurePath(log).stem for log in logs]
    return next(names for names in (designs, stems, logs) if len(set(names)) == len(names))
