"""Figures of the catalogue that finite elements give: the largest stress of each kind of part in a run of its own."""

import math
from collections.abc import Mapping
from functools import partial

from cycloid_mj.base import names
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Quantity
from cycloid_mj.base.units import MEGAPASCAL
from cycloid_mj.comparison import settling
from cycloid_mj.design import Design, Friction
from cycloid_mj.figures import figure
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.reducer.sockets import require_one_ring
from cycloid_mj.stress.findings import PartFindings, StressFindings
from cycloid_mj.stress.given import given
from cycloid_mj.stress.loads import part_names
from cycloid_mj.stress.mounts import Mounts
from cycloid_mj.stress.study import QUICK, part_study

SAMPLES = 720
"""Least samples of a run in a crank turn: two for each degree."""


def for_one_turn(design: Design, load: float | None = None) -> Design:
    """Return a design that runs from full speed for one settled turn.

    The load [N m] is that given, else the design's own, or its rated torque where that is 0.
    """
    require_one_ring(Reducer(design), "stress by finite elements")
    load = load if load is not None else design.load.torque or round(design.rated_torque, 9)
    design = design.but(drive={"ramp": 0.0}, load={"torque": load})
    if design.drive.speed == 0.0:
        return design
    rate = max(design.settings.log_rate, SAMPLES * abs(design.drive.speed) / (2.0 * math.pi))
    reducer = Reducer(design)
    return design.steady(settling(reducer), 1.0 / reducer.share, samples=3.0, settings={"log_rate": rate})


@once
def _ran(reducer: Reducer) -> tuple[Reducer, Run]:
    from cycloid_mj.dynamics.run import simulate

    design = for_one_turn(reducer.design)
    return Reducer(design), simulate(design)


@once
def _studied(reducer: Reducer, part: str) -> PartFindings:
    ran, run = _ran(reducer)
    return part_study(run, ran, part, QUICK).findings


def _stress(reducer: Reducer, kind: str) -> float:
    """Compute the largest stress of the parts of a kind [MPa], NaN where there is none; errors as `stress_study`."""
    there = [part for part in part_names(reducer) if names.family(part) == kind]
    return max((_studied(reducer, part).governing / MEGAPASCAL for part in there), default=math.nan)


KINDS = ("shaft", "gear", "ring", "output", "pin")

shaft_stress, gear_stress, ring_stress, output_stress, pin_stress = (partial(_stress, kind=kind) for kind in KINDS)


def wind_up_by_part(reducer: Reducer, mounts: Mounts | None = None) -> dict[str, float]:
    """Compute by how much each part turns the output per torque on it [rad/(N m)], under the design's own load.

    Beside the parts stands what mounts tell of a drawing, as in `given.given`.

    Raises
    ------
    CycloidError
        The run cannot be followed, a part cannot be meshed, a package of the extra ``fem`` is missing, or mounts are
        told of another kind of drive.
    """
    smooth = reducer.but(friction=dict.fromkeys(Friction.model_fields, 0.0))
    ran, run = _ran(smooth)
    return given(run, ran, mounts=mounts)


def of_study(findings: StressFindings) -> Mapping[str, Quantity]:
    """Pick the catalogue's figures from the findings of a study, by their keys."""
    figures = {}
    for kind in KINDS:
        row = figure(f"{kind}_stress_mpa")
        stresses = [part.governing / MEGAPASCAL for part in findings.parts if names.family(part.part) == kind]
        if stresses:
            figures[row.key] = Quantity(row.key, row.name, max(stresses), row.unit)
    return figures
