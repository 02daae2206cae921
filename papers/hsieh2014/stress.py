"""Figs 10-16: grids, and stress over a crank turn without load, as in the paper, and under the rated load."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from cycloid_mj.base.names import KINDS
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Table
from cycloid_mj.base.units import MEGAPASCAL
from hsieh2014 import hypothesis
from hsieh2014.idle_stress import IdleStress, idle_stress
from hsieh2014.peaks import largest_force, pairs_on
from hsieh2014.plan import (
    IMPACT,
    SAMPLES,
    Plan,
    contact_ranges,
    designs,
    idle_runs,
    ranges,
    rated_runs,
    variations,
    varied_idle_runs,
)
from hsieh2014.stage import PaperFigure, Progress, Runs, StageResult
from hsieh2014.stated import FIGURES, HEIGHTS, ORDER, SHAFT_PEAKS
from hsieh2014.stress_claims import stress_claims
from hsieh2014.stress_evidence import Searched

if TYPE_CHECKING:
    from cycloid_mj.stress.study import StudySettings

MAP_ANGLE = math.radians(74.0)
"""Crank angle of the maps [rad]: the paper's Fig. 11."""


def stress(plan: Plan, runs: Runs, progress: Progress) -> StageResult:
    """Compute the stress of every part under the impact peaks of a turn without load, over independent starts."""
    starts = {design.name: runs(idle_runs(plan, design), plan.solver) for design in designs()}
    rated = {run.provenance["design"]: run for run in runs(rated_runs(plan))}
    studies = {}
    for design in designs():
        name = design.name
        begins = partial(_part_begins, progress, name)
        impact = runs(varied_idle_runs(plan, IMPACT, design), plan.solver)[0]
        studies[name] = idle_stress(starts[name], rated[name], settings(plan), impact, begins)
    varied = {
        variation: {
            design.name: runs.figures(varied_idle_runs(plan, variation, design), plan.solver) for design in designs()
        }
        for variation in variations(plan)
    }
    progress("hypothesis: soft contact")
    soft = hypothesis.soft_runs(plan)
    by_force = {name: each.by_force for name, each in studies.items()}
    searched = Searched(ranges(plan), varied, hypothesis.stress_by_case(soft, by_force), contact_ranges(plan))
    judged = {design.name: runs.figures(idle_runs(plan, design), plan.solver) for design in designs()}
    wanted = {name: _needed(name, each, rated[name]) for name, each in studies.items()}
    return StageResult(
        tuple(_plates(studies)),
        (_stress_table(studies), _force_table(starts, rated), hypothesis.table(soft, wanted)),
        tuple(stress_claims(studies, judged, rated, searched)),
        {name: _numbers(each) for name, each in studies.items()} | {"hypothesis": hypothesis.as_json(soft, wanted)},
        (*hypothesis.sentences(soft, wanted), *_notes(studies)),
    )


def _needed(name: str, idle_stress: IdleStress, rated: Run) -> dict[str, float]:
    """Compute the forces that would cause the paper's stress, from stress and largest force under the rated load."""
    forces = {part: largest_force(rated, pairs_on(rated, part)) for part in ORDER}
    return hypothesis.needed({part: size.high for part, size in idle_stress.rated.items()}, forces, name)


def _part_begins(progress: Progress, design: str, part: str, number: int, total: int) -> None:
    progress(f"{design}, {part}, {number + 1} of {total} parts")


def _plates(studies: Mapping[str, IdleStress]) -> Iterator[PaperFigure]:
    """Draw grids, maps and stress curves, and the change of stress with the grid."""
    from cycloid_mj.plots.stress import grid_figure, map_figure, refinement_figure

    for name, study in studies.items():
        parts = {each.findings.part: each for each in study.study.parts}
        grids = {part: each.grid for part, each in parts.items()}
        maps = {part: each.map for part, each in parts.items()}
        words = f"{name}, no load: von Mises stress on every part at the paper's crank angle, 74 deg."
        yield PaperFigure(f"fig10_grid_{name}", "Fig. 10", f"{name}: grids of the parts.", grid_figure(grids, name))
        yield PaperFigure(f"fig11_map_{name}", "Fig. 11", words, map_figure(maps, f"{name}, no load"))
    findings = [each.study.findings for each in studies.values()]
    yield from height_plates(studies)
    words = "No load. Numerical error: the largest bulk stress of each part on a coarser and on a finer grid."
    yield PaperFigure("stress_refinement", "Figs 12-16", words, refinement_figure(findings))


def height_plates(studies: Mapping[str, IdleStress]) -> Iterator[PaperFigure]:
    """Draw Figs 12-16 with both contact laws and the paper's maxima."""
    from hsieh2014.paper_figures import heights_figure

    for number, (part, figure) in enumerate(FIGURES.items(), start=12):
        words = f"No load, impact peaks of one start: largest von Mises stress of {part.replace('_', ' ')} over a crank"
        words += " turn, by line contacts of steel and, short dashes, by the soft contact of motion solvers (IMPACT)"
        curves = {
            f"{name}, {law}": curve
            for name, study in studies.items()
            for law, curve in (("line contacts", study.curve(part)), ("IMPACT", study.soft_curve(part)))
            if curve is not None
        }
        heights = {name: HEIGHTS[part, name] for name in studies if (part, name) in HEIGHTS}
        words += "; long dashes: up to about where the paper's curve reaches." if heights else "."
        marks = SHAFT_PEAKS if part == "shaft" else ()
        yield PaperFigure(f"fig{number}_stress_{part}", figure, words, heights_figure(curves, heights, marks))


def settings(plan: Plan) -> "StudySettings":
    """Return the settings of a stress study."""
    from cycloid_mj.stress.study import QUICK, StudySettings

    # 9 deg apart, not a multiple of the mesh period, so that ten phases occur
    chosen = replace(QUICK, angles=40) if plan.quick else StudySettings()
    return replace(chosen, map_angle=MAP_ANGLE)


def _stress_table(studies: Mapping[str, IdleStress]) -> Table:
    """Return the table of the largest bulk stress of each part: without load, in the paper, at the rated load."""
    rows = [
        (f"{name}, {part}", study.starts[part].words, HEIGHTS.get((part, name), ""), f"{study.rated[part].high:.3g}")
        for name, study in studies.items()
        for part in study.starts
    ]
    conditions = f"no load, {SAMPLES.starts} starts", "the paper, no load, up to about", "rated load"
    return Table("stress by part", ("largest bulk stress [MPa]", *conditions), tuple(rows))


def _force_table(starts: Mapping[str, Sequence[Run]], rated: Mapping[str, Run]) -> Table:
    """Return the table of the largest force of each kind of pair, at samples and between them."""
    rows = []
    for name, runs in starts.items():
        between, loaded = [_largest_forces(run) for run in runs], _largest_forces(rated[name])
        for stem in loaded:
            sizes = [forces[stem] for forces in between]
            rows.append((f"{name}, {stem}", f"{min(sizes):.3g} to {max(sizes):.3g}", f"{loaded[stem]:.3g}"))
    head = ("largest force of one contact pair [N]", f"no load, impact peaks of {SAMPLES.starts} starts", "rated load")
    return Table("forces behind the stress", head, tuple(rows))


def _largest_forces(run: Run) -> dict[str, float]:
    """Return the largest force of each kind of pair in a run [N]."""
    return {stem: largest_force(run, among) for stem, kind in KINDS.items() if (among := run.pairs(kind))}


def _numbers(idle_stress: IdleStress) -> dict[str, dict[str, object]]:
    """Convert the stress of each part without load and under the rated load to JSON values."""
    return {
        part.part: {
            "no_load_mpa": list(idle_stress.starts[part.part].values),
            "rated_mpa": idle_stress.rated[part.part].high,
            "angle_deg": float(part.bulk_peak.as_json()["angle_deg"]),
            "contact_no_load_mpa": part.contact_peak.stress / MEGAPASCAL,
            "change_by_refinement": part.refinement.change,
        }
        for part in idle_stress.study.findings.parts
    }


def _notes(studies: Mapping[str, IdleStress]) -> tuple[str, ...]:
    """List conditions and assumptions of the stress studies, a sentence each."""
    from cycloid_mj.stress.findings import ASSUMPTIONS

    parts = [(name, part) for name, each in studies.items() for part in each.study.findings.parts]
    rough = [f"{name} {part.part}" for name, part in parts if not part.refinement.is_converged]
    missed = [
        f"{name} {part} {each.by_force[part].residual:.2g} MPa" for name, each in studies.items() for part in ORDER
    ]
    return (
        "Section 3.3 of the paper: stress is taken without load. Every figure and claim here is at no load; stress at "
        "the rated load is a result of ours, beside them.",
        "Impacts fall between samples: each pair acts with its largest force of all time steps in the window of a "
        "crank angle, all pairs at once. That is on the safe side, but where forces would relieve each other.",
        f"A maximum at no load is that of each of {SAMPLES.starts} independent starts, at its heaviest crank angles; "
        "figures show the first. Bulk begins as far from the contacts as under the rated load.",
        "Where a stress was not solved for, over a turn and with something varied, it is that of a line over the "
        f"largest force on its part, through all idle cases that were; rms of what that misses: {', '.join(missed)}.",
        *ASSUMPTIONS,
        *([f"not converged to 3 % under one more refinement: {', '.join(rough)}"] if rough else []),
    )
