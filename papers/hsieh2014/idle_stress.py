"""Stress at no load: impact peaks over independent starts; and, beside it, stress under the rated load."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_mj.comparison import Spread
from cycloid_mj.design import Design
from cycloid_mj.record import Run
from cycloid_mj.units import MEGAPASCAL
from hsieh2014.peaks import at_peaks
from hsieh2014.plan import LOGGED, SAMPLING
from hsieh2014.stated import stress_references

if TYPE_CHECKING:
    from cycloid_mj.stress.loads import PartLoads
    from cycloid_mj.stress.study import StressStudy, StudySettings


HEAVIEST = 4
"""Crank angles of each further start whose stress is solved for: two of the largest force, two of the largest sum."""

RATED_ANGLES = 23
"""Crank angles under the rated load: no divisor of the mesh periods in a turn, so that they fall on all its phases."""


@dataclass(frozen=True, eq=False)
class IdleStress:
    """Stress of one design at no load, and under the rated load.

    Attributes
    ----------
    study
        The whole study of the first start, under its impact peaks.
    starts
        Part -> largest bulk stress of each start [MPa].
    rated
        Part -> largest bulk stress at some crank angles under the rated load [MPa].
    """

    study: "StressStudy"
    starts: Mapping[str, Spread]
    rated: Mapping[str, Spread]

    def error(self, part: str) -> float:
        """Give by what share one more refinement, or the choice of where bulk begins, changes the maximum of a part."""
        found = self.study.findings[part]
        return max(found.refinement.change, found.choice)


def idle_stress(
    starts: Sequence[Run], rated: Run, design: Design, settings: "StudySettings", progress: Any = lambda *_: None
) -> IdleStress:
    """Study one design: its first start in whole, the heaviest angles of the others, and the rated run.

    Parameters
    ----------
    starts, rated
        Runs at no load, with the peaks of their forces, and one under the rated load.
    design
        The design that ran.
    settings
        How much is computed.
    progress
        Called with each part before it begins; see `stress.study.stress_study`.
    """
    from cycloid_mj.stress.field import solve
    from cycloid_mj.stress.loads import part_loads
    from cycloid_mj.stress.study import stress_study

    peaks = [at_peaks(run, LOGGED * SAMPLING // settings.angles + 1) for run in starts]
    study = stress_study(peaks[0], design, (), settings, told=progress, references=stress_references(design))
    turn = 2 * np.pi * np.arange(settings.angles) / settings.angles
    under_load = 2 * np.pi * np.arange(RATED_ANGLES) / RATED_ANGLES
    largest, loaded = {}, {}
    for one in study.parts:
        part, grid = one.findings.part, one.grid
        under = solve(design, grid, part_loads(rated, design, part, under_load))
        loaded[part] = Spread.of(under.bulk_stress / MEGAPASCAL)
        heavy = [heaviest(part_loads(run, design, part, turn), HEAVIEST) for run in peaks]
        # a single touch has no plateau of its own: bulk begins where it does under the rated load, in every start
        solved = solve(design, grid, joined(heavy), distance=under.bulk_distance)
        largest[part] = Spread.of(solved.bulk_stress.reshape(len(heavy), HEAVIEST).max(axis=1) / MEGAPASCAL)
    return IdleStress(study, largest, loaded)


def heaviest(loads: "PartLoads", count: int) -> "PartLoads":
    """Give the loads at the crank angles of the largest single force, and of the largest sum, half of each."""
    from cycloid_mj.stress.study import at_angles

    size = np.nan_to_num(np.linalg.norm(loads.force, axis=2))
    rows: list[int] = []
    for weight in (size.max(axis=1), size.sum(axis=1)):
        later = [int(row) for row in np.argsort(weight)[::-1] if row not in rows]
        rows += later[: count // 2]
    return at_angles(loads, rows)


def joined(several: Sequence["PartLoads"]) -> "PartLoads":
    """Put the loads of several runs on one part behind each other, so that one factorisation serves all."""
    first = several[0]
    together: dict[str, Any] = {
        field.name: np.concatenate([getattr(each, field.name) for each in several])
        for field in fields(first)
        if isinstance(getattr(first, field.name), np.ndarray)
    }
    return replace(first, **together)
