"""Stress without load from impact peaks over independent starts, and stress under the rated load."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.analysis.series import DESIGN_FILE, design_of
from cycloid_mj.base.array import Array
from cycloid_mj.base.names import OUTPUT
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Value
from cycloid_mj.base.units import MEGAPASCAL
from cycloid_mj.comparison import StartSpread
from cycloid_mj.design import dump
from cycloid_mj.reducer import Reducer
from hsieh2014.peaks import at_peaks
from hsieh2014.plan import SAMPLES
from hsieh2014.stated import stress_references

if TYPE_CHECKING:
    from cycloid_mj.stress.field import PartStress
    from cycloid_mj.stress.grid import Grid
    from cycloid_mj.stress.loads import PartLoads
    from cycloid_mj.stress.study import StressStudy, StudySettings


ERROR = "comparison with a finer mesh or another distance from the contacts"
"""Source of a stress's numerical error."""


OutputPins = Mapping[str, Any]
"""Changed values of the design's output."""

NO_OTHERS: OutputPins = {}

OTHER_PINS: Mapping[str, OutputPins] = {
    "output pins of 4 mm radius, for 5 mm": {"pin_radius": 5e-3, "hole_radius": 6e-3},
    "output pins as cantilevers, for held at both ends": {"support": "both_ends"},
}
"""Alternatives to the assumed output pins, which the paper leaves open."""

RATED_ANGLES = 23
"""Crank angles under the rated load; not a divisor of the mesh periods per turn, so that all phases occur."""


@dataclass(frozen=True)
class ByForce:
    """Estimate of a part's largest stress from the largest force on it, with an offset for weight and rotation."""

    offset: float
    slope: float
    """Line through the computed cases without load [MPa], [MPa/N]."""
    reach: float
    """Largest force of these cases [N]."""
    rated: float
    """Slope for larger forces, that of the rated load [MPa/N]."""
    residual: float = 0.0
    """Rms residual of the line [MPa]."""

    @classmethod
    def through(cls, force: Array, stress: Array, rated: float) -> "ByForce":
        """Fit the line to forces [N] and stresses [MPa], shape (n,) each; the slope is at least 0.

        `rated` is the slope [MPa/N] for forces beyond the largest of these.
        """
        slope, offset = np.polyfit(force, stress, 1)
        if slope < 0.0:
            slope, offset = 0.0, np.mean(stress)
        residual = float(np.std(stress - offset - slope * force))
        return cls(float(offset), float(slope), float(force.max()), rated, residual)

    def __call__(self, force: npt.ArrayLike) -> Array:
        """Estimate the stress [MPa] under forces [N] of any shape."""
        force = np.asarray(force, float)
        within, beyond = np.minimum(force, self.reach), np.maximum(force - self.reach, 0.0)
        return np.maximum(self.offset + self.slope * within + self.rated * beyond, 0.0)


@dataclass(frozen=True, eq=False)
class IdleStress:
    """Stress of one design without load and under the rated load."""

    study: "StressStudy"
    """The full study of the first start, under its impact peaks."""
    starts: Mapping[str, StartSpread]
    """Part -> largest bulk stress of each start [MPa]."""
    rated: Mapping[str, StartSpread]
    """Part -> largest bulk stress at some crank angles under the rated load [MPa]; for the output, nominal stress times
    notch factor at the fillet of its pins, because the grid omits the fillet."""
    soft: Mapping[str, Array]
    """Part -> bulk stress over the crank angles of the study with the contact law IMPACT [MPa], of the first start."""
    outputs: Mapping[str, StartSpread]
    """Changed assumption on the output pins -> largest bulk stress of the output in each start [MPa]."""
    by_force: Mapping[str, ByForce]
    """Part -> its stress by the largest force on it."""

    def curve(self, part: str) -> tuple[Array, Array] | None:
        """Return crank angles [deg] and bulk stress [MPa] of a part in the first start; None without such a part."""
        if part not in self.starts:
            return None
        findings = self.study.findings[part]
        return np.degrees(findings.angle), findings.bulk / MEGAPASCAL

    def soft_curve(self, part: str) -> tuple[Array, Array] | None:
        """Return the same with the contact law IMPACT."""
        return (np.degrees(self.study.findings[part].angle), self.soft[part]) if part in self.soft else None

    def error(self, part: str) -> float:
        """Return the relative change of a part's maximum by one more refinement or another bulk distance."""
        findings = self.study.findings[part]
        return max(findings.refinement.change, findings.choice)


def idle_stress(
    starts: Sequence[Run], rated: Run, settings: "StudySettings", soft: Run | None = None, report: Any = lambda *_: None
) -> IdleStress:
    """Compute the stress of one design: its full first start, the heaviest angles of the others, and the rated run.

    Parameters
    ----------
    starts, rated
        Runs at no load, with the peaks of their forces, and one under the rated load.
    settings
        Grids and crank angles.
    soft
        The first start with the contact law IMPACT.
    report
        Called with each part before it begins; see `stress.study.stress_study`.
    """
    from cycloid_mj.stress.field import solve
    from cycloid_mj.stress.loads import part_loads
    from cycloid_mj.stress.study import stress_study

    design, window = design_of(starts[0]), SAMPLES.logged * SAMPLES.per_turn // settings.angles + 1
    reducer = Reducer(design)
    softly = at_peaks(soft, window) if soft else None
    study = stress_study(
        at_peaks(starts[0], window), reducer, (), settings, on_part=report, references=stress_references(design)
    )
    grids = {part_study.findings.part: part_study.grid for part_study in study.parts}
    turn = settings.turn
    parts = [*((part, NO_OTHERS) for part in grids), *((OUTPUT, pins) for pins in OTHER_PINS.values())]
    heavy = _heaviest_loads(starts, parts, turn, window)
    largest, loaded, curves, by_force = {}, {}, {}, {}
    for (part, grid), of_starts in zip(grids.items(), heavy, strict=False):
        under, loaded[part] = _under_load(rated, part, grid)
        # a single touch has no plateau of its own: bulk begins where it does under the rated load, in every start
        cases = [*of_starts, *([part_loads(softly, Reducer(design_of(softly)), part, turn)] if softly else [])]
        stress = solve(design, grid, join_loads(cases), distance=under.bulk_distance).bulk_stress / MEGAPASCAL
        split = np.split(stress, np.cumsum([len(each.angle) for each in cases])[:-1])
        largest[part] = StartSpread.of(each.max() for each in split[: len(of_starts)])
        slope = float(under.bulk_stress.max() / under.load.max()) / MEGAPASCAL
        by_force[part] = ByForce.through(largest_forces(join_loads(cases)), stress, slope)
        if softly:
            curves[part] = split[-1]
    outputs = {
        words: _with_pins(Reducer(design.but(output=pins)), settings, of_starts)
        for (words, pins), of_starts in zip(OTHER_PINS.items(), heavy[len(grids) :], strict=True)
    }
    return IdleStress(study, largest, loaded, curves, outputs, by_force)


def _heaviest_loads(
    starts: Sequence[Run], parts: Sequence[tuple[str, OutputPins]], turn: Array, window: int
) -> "list[list[PartLoads]]":
    """Return for each of several parts the loads of each start at its heaviest crank angles.

    `parts` are names of parts with changes of the output pins, `turn` the crank angles [rad]; forces are the largest in
    a `window` of samples.
    """
    from cycloid_mj.stress.loads import part_loads

    heavy: list[list[PartLoads]] = [[] for _ in parts]
    for run in starts:
        peaks = at_peaks(run, window)
        for loads, (part, pins) in zip(heavy, parts, strict=True):
            ran = with_output(peaks, pins)
            # two with the largest force, two with the largest sum
            loads.append(heaviest(part_loads(ran, Reducer(design_of(ran)), part, turn), 4))
    return heavy


def with_output(run: Run, pins: OutputPins) -> Run:
    """Return the run with changed output pins in its design; unchanged for no pins."""
    if not pins:
        return run
    design = design_of(run).but(output=pins)
    return replace(run, attachments={**run.attachments, DESIGN_FILE: dump(design).encode()})


def _under_load(rated: Run, part: str, grid: "Grid") -> "tuple[PartStress, StartSpread]":
    """Compute the stress of a part at some crank angles under the rated load, and its largest value at each [MPa]."""
    from cycloid_mj.stress.field import solve
    from cycloid_mj.stress.loads import part_loads
    from cycloid_mj.stress.study import notches_of

    reducer = Reducer(design_of(rated))
    loads = part_loads(rated, reducer, part, 2 * np.pi * np.arange(RATED_ANGLES) / RATED_ANGLES)
    under = solve(reducer.design, grid, loads)
    governing = under.bulk_stress / MEGAPASCAL
    if part == OUTPUT:
        fillet = max(notch.stress for notch in notches_of(reducer, loads, under)) / MEGAPASCAL
        governing = np.append(governing, fillet)
    return under, StartSpread.of(governing)


def _with_pins(other: Reducer, settings: "StudySettings", of_starts: "Sequence[PartLoads]") -> StartSpread:
    """Compute the output's largest stress in each start [MPa] in a design with other output pins."""
    from cycloid_mj.stress.field import solve
    from cycloid_mj.stress.part import part_grid

    grid = part_grid(other.design, OUTPUT, settings.grid(OUTPUT))
    stress = solve(other.design, grid, join_loads(of_starts)).bulk_stress / MEGAPASCAL
    return StartSpread.of(each.max() for each in np.split(stress, len(of_starts)))


def heaviest(loads: "PartLoads", count: int) -> "PartLoads":
    """Return `loads` at `count` crank angles: half have the largest single force, half the largest sum of forces."""
    from cycloid_mj.stress.study import select_angles

    size = np.nan_to_num(np.linalg.norm(loads.force, axis=2))
    rows: list[int] = []
    for weight in (size.max(axis=1), size.sum(axis=1)):
        later = [int(row) for row in np.argsort(weight)[::-1] if row not in rows]
        rows += later[: count // 2]
    return select_angles(loads, rows)


def largest_forces(loads: "PartLoads") -> Array:
    """Return the largest force at each crank angle of some loads [N], shape (n,)."""
    return np.nan_to_num(np.linalg.norm(loads.force, axis=2)).max(axis=1)


def join_loads(several: Sequence["PartLoads"]) -> "PartLoads":
    """Concatenate the loads of several runs on one part, so that one factorisation serves all."""
    first = several[0]
    arrays = [field.name for field in fields(first) if isinstance(getattr(first, field.name), np.ndarray)]
    together: dict[str, Any] = {name: np.concatenate([getattr(each, name) for each in several]) for name in arrays}
    return replace(first, **together)


def rated_value(idle_stress: IdleStress, part: str) -> Value:
    """Compute a part's largest stress under the rated load."""
    where = " at the fillet of a pin" if part == OUTPUT else ""
    return Value(f"{idle_stress.rated[part].high:.3g} MPa{where}", idle_stress.rated[part].high, "MPa")


def stress_error(idle_stress: IdleStress, parts: Sequence[str]) -> Value:
    """Compute the largest numerical error of some parts' stress at no load."""
    share, part = max((idle_stress.error(part), part) for part in parts)
    return Value(f"{part}: {ERROR}", share * idle_stress.starts[part].mean, "MPa")
