"""Figures of the catalogue by finite elements: stress and contact pressure of each kind of part, from a run."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

from cycloid_mj.base import names
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Quantity
from cycloid_mj.base.units import MEGAPASCAL
from cycloid_mj.comparison import settling_time
from cycloid_mj.design import Design
from cycloid_mj.design.model import NO_FRICTION
from cycloid_mj.figures import figure
from cycloid_mj.reducer import Reducer, RvReducer, once, reducer_of
from cycloid_mj.reducer.sockets import require_one_ring
from cycloid_mj.stress.findings import PartFindings, StressFindings
from cycloid_mj.stress.loads import part_names, turn_of
from cycloid_mj.stress.mounts import Mounts
from cycloid_mj.stress.part_compliance import compute_part_compliance
from cycloid_mj.stress.study import QUICK, part_study


def for_one_turn(design: Design, load: float | None = None) -> Design:
    """Return a copy of a design whose simulation lasts for one crank turn relative to the ring, after transients.

    It runs at full speed from the start, and logs at least 720 samples per turn. `load` is the output torque [N m]; by
    default the design's own, or its rated torque if that is 0. With a speed of 0, the duration does not change. An RV
    reducer is not simulated, so only its load changes.

    Raises
    ------
    DesignError
        The ring is in two halves.
    """
    load = load if load is not None else design.load.torque or round(design.rated_torque, 9)
    design = design.but(load={"torque": load})
    if design.layout == RvReducer.LAYOUT:
        return design
    require_one_ring(Reducer(design), "stress by finite elements")
    design = design.but(drive={"ramp": 0.0})
    if design.drive.speed == 0.0:
        return design
    log_rate = max(design.settings.log_rate, 720 * abs(design.drive.speed) / (2.0 * math.pi))
    reducer = Reducer(design)
    return design.steady(settling_time(reducer), 1.0 / reducer.share, samples=3.0, settings={"log_rate": log_rate})


def run_for_one_turn(design: Design, load: float | None = None) -> tuple[Reducer, Run | None]:
    """Simulate the design that `for_one_turn` returns; return its reducer, and the run, None for an RV reducer."""
    from cycloid_mj.dynamics.run import simulate

    reducer = reducer_of(for_one_turn(design, load))
    return reducer, None if isinstance(reducer, RvReducer) else simulate(reducer.design)


@once
def _run_of(reducer: Reducer) -> tuple[Reducer, Run | None]:
    return run_for_one_turn(reducer.design)


@once
def _study_part(reducer: Reducer, part: str) -> PartFindings:
    ran, run = _run_of(reducer)
    return part_study(turn_of(run, ran, QUICK.turn), ran, part, QUICK).findings


def _largest(values: Iterable[float]) -> float:
    """Return the largest number, NaN where there is none."""
    return max((value for value in values if not math.isnan(value)), default=math.nan)


KINDS = ("shaft", "gear", "ring", "output", "pin")

FIGURES_OF_PARTS: Mapping[str, Callable[[Sequence[PartFindings]], float]] = {
    "stress_mpa": lambda parts: _largest(part.governing / MEGAPASCAL for part in parts),
    "contact_pressure_mpa": lambda parts: _largest(part.largest_pressure / MEGAPASCAL for part in parts),
    "contact_safety": lambda parts: -_largest(-part.shakedown for part in parts),
}
"""End of a figure's key, after one of `KINDS` -> its value from the findings of all parts of that kind.

The largest stress, the largest contact pressure, and the smallest safety factor against shakedown; NaN without any.
"""


def part_figure(reducer: Reducer, kind: str, name: str) -> float:
    """Compute the largest stress or contact pressure [MPa], or the smallest safety factor [1], of the parts of a kind.

    They follow from a run of one turn. `kind` is the kind of part, such as "gear". `name` is the quantity, a key of
    `FIGURES_OF_PARTS`: "stress_mpa" (away from contacts), "contact_pressure_mpa" or "contact_safety" (against
    shakedown).

    Raises
    ------
    CycloidError
        The run failed, a part does not mesh, its support is singular, or a package of the extra ``fem`` is missing.
    """
    parts = [part for part in part_names(reducer) if names.family(part) == kind]
    return FIGURES_OF_PARTS[name]([_study_part(reducer, part) for part in parts])


def wind_up_by_part(reducer: Reducer, mounts: Mounts | None = None) -> dict[str, float]:
    """Compute the torsional compliance that each part adds at the output [rad/(N m)], by name of the part.

    The forces on the parts are taken from a run without friction under the design's load, or its rated torque if that
    is 0. `mounts` are the seats of output pins and crank in plates; with them, the result also has their compliances,
    see `part_compliance.compute_part_compliance`.

    Raises
    ------
    CycloidError
        The run failed, a part does not mesh, a package of the extra ``fem`` is missing, or the mounts do not fit the
        design.
    """
    frictionless_reducer = reducer.but(friction=NO_FRICTION)
    simulated_reducer, run = _run_of(frictionless_reducer)
    return compute_part_compliance(run, simulated_reducer, mounts=mounts)


def study_quantities(findings: StressFindings) -> Mapping[str, Quantity]:
    """Return stress, contact pressure and safety factor of each kind of part, by the keys of the data-sheet catalogue.

    The safety factor is that of the contacts against shakedown. `findings` are the results of a stress study. Values
    that are NaN are left out.
    """
    figures = {}
    for kind in KINDS:
        parts = [part for part in findings.parts if names.family(part.part) == kind]
        for name, compute in FIGURES_OF_PARTS.items():
            if not math.isnan(value := compute(parts)):
                entry = figure(f"{kind}_{name}")
                figures[entry.key] = Quantity(entry.key, entry.name, value, entry.unit)
    return figures
