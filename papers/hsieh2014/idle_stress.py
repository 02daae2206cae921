"""Stress at no load: impact peaks over independent starts; and, beside it, stress under the rated load."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_mj.analysis.series import design_of
from cycloid_mj.base.names import OUTPUT
from cycloid_mj.base.record import Run
from cycloid_mj.base.types import Array
from cycloid_mj.base.units import MEGAPASCAL
from cycloid_mj.comparison import Spread
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer
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
        Part -> largest bulk stress at some crank angles under the rated load [MPa]; of the output at the fillet of its
        pins, nominal stress times notch factor, since its bulk is the edge of what is left out there.
    soft
        Part -> bulk stress over the crank angles of the study with the contact law IMPACT [MPa], of the first start.
    """

    study: "StressStudy"
    starts: Mapping[str, Spread]
    rated: Mapping[str, Spread]
    soft: Mapping[str, Array]

    def curve(self, part: str) -> tuple[Array, Array] | None:
        """Give crank angles [deg] and bulk stress [MPa] of a part in the first start; None where there is no part."""
        if part not in self.starts:
            return None
        found = self.study.findings[part]
        return np.degrees(found.angle), found.bulk / MEGAPASCAL

    def soft_curve(self, part: str) -> tuple[Array, Array] | None:
        """Give the same with the contact law IMPACT."""
        return (np.degrees(self.study.findings[part].angle), self.soft[part]) if part in self.soft else None

    def error(self, part: str) -> float:
        """Give by what share one more refinement, or the choice of where bulk begins, changes the maximum of a part."""
        found = self.study.findings[part]
        return max(found.refinement.change, found.choice)


def idle_stress(
    starts: Sequence[Run],
    rated: Run,
    design: Design,
    settings: "StudySettings",
    soft: Run | None = None,
    progress: Any = lambda *_: None,
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
    soft
        The first start with the contact law IMPACT.
    progress
        Called with each part before it begins; see `stress.study.stress_study`.
    """
    reducer = Reducer(design)
    from cycloid_mj.stress.field import solve
    from cycloid_mj.stress.loads import part_loads
    from cycloid_mj.stress.study import notches_of, stress_study

    window = LOGGED * SAMPLING // settings.angles + 1
    peaks = [at_peaks(run, window) for run in starts]
    softly = at_peaks(soft, window) if soft else None
    study = stress_study(peaks[0], reducer, (), settings, told=progress, references=stress_references(design))
    turn = 2 * np.pi * np.arange(settings.angles) / settings.angles
    under_load = 2 * np.pi * np.arange(RATED_ANGLES) / RATED_ANGLES
    largest, loaded, curves = {}, {}, {}
    for one in study.parts:
        part, grid = one.findings.part, one.grid
        rated_loads = part_loads(rated, reducer, part, under_load)
        under = solve(design, grid, rated_loads)
        governing = under.bulk_stress / MEGAPASCAL
        if part == OUTPUT:
            fillet = max(notch.stress for notch in notches_of(reducer, rated_loads, under)) / MEGAPASCAL
            governing = np.append(governing, fillet)
        loaded[part] = Spread.of(governing)
        heavy = [heaviest(part_loads(run, reducer, part, turn), HEAVIEST) for run in peaks]
        # a single touch has no plateau of its own: bulk begins where it does under the rated load, in every start
        cases = [*heavy, *([part_loads(softly, Reducer(design_of(softly)), part, turn)] if softly else [])]
        stress = solve(design, grid, joined(cases), distance=under.bulk_distance).bulk_stress / MEGAPASCAL
        parts = np.split(stress, np.cumsum([len(each.angle) for each in cases])[:-1])
        largest[part] = Spread.of(each.max() for each in parts[: len(heavy)])
        if softly:
            curves[part] = parts[-1]
    return IdleStress(study, largest, loaded, curves)


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
