"""One run of a report: its series and findings, with the log they came from."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import PurePath

from cycloid_mj.analysis import Findings, Series

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Okabe and Ito's colours, one for each run."""


@dataclass(frozen=True, eq=False)
class Reviewed:
    """A run of a report."""

    log: str
    motion: Series
    findings: Findings


def labels(reviewed: Sequence[Reviewed]) -> list[str]:
    """Give a short name for each run: its design's, or its log's where designs share a name."""
    designs = [item.motion.design.name for item in reviewed]
    if len(set(designs)) == len(designs):
        return designs
    logs = [PurePath(item.log).stem for item in reviewed]
    return logs if len(set(logs)) == len(logs) else [item.log for item in reviewed]
