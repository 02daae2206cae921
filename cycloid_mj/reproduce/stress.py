"""Figs 10-16: grids, stress over a crank turn, and the assumed dimensions that decide it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from cycloid_mj.design import Design, override
from cycloid_mj.measure import Table
from cycloid_mj.reproduce.claims import Claim, Verdict
from cycloid_mj.reproduce.plan import Plan, main_runs
from cycloid_mj.reproduce.stage import Found, Plate, Runs, Told

if TYPE_CHECKING:
    from cycloid_mj.stress.findings import StressFindings
    from cycloid_mj.stress.paper import Claim as StressClaim
    from cycloid_mj.stress.study import StressStudy, StudySettings

MEGAPASCAL = 1e6
DIMENSIONS = {
    "shaft": ("shaft.radius_mm", (4.5, 6.0)),
    "gear": ("gear.face_width_mm", (5.0, 20.0, 30.0)),
    "ring": ("housing.outer_radius_mm", (44.0, 55.0)),
}
"""Assumed dimensions of the sweep, within what such a reducer could have: one for each part of which the paper tells a
range. Loads stay those of the run.
"""

BELOW = "'s stress stays below"
PAPER = {
    "two peaks": "74 (highest), 75, 255 deg",
    "shaft > ring > gear": "160 > 65 > 20 MPa, 60 > 50 > 10",
    "low and regular": "low, regular",
    "loaded again": "0, 10, 350 deg",
}
"""What the paper has for statements of its own kind: words of the statement -> numbers."""

QUICK_ANGLES = 40
"""Crank angles of a quick study: 9 deg apart, no multiple of the mesh period, so that they fall on ten phases of it."""

SWEPT_ANGLES = 6
"""Crank angles of the sweep, that of the maximum first."""


def stress(plan: Plan, runs: Runs, told: Told) -> Found:
    """Find the stress of every part under the rated load, and vary the dimensions that the paper leaves open."""
    from cycloid_mj.plots.stress import grid_figure, map_figure, stress_figures
    from cycloid_mj.stress.field import stress_map
    from cycloid_mj.stress.paper import claims
    from cycloid_mj.stress.study import QUICK, StudySettings, stress_study

    settings = replace(QUICK, angles=QUICK_ANGLES) if plan.quick else StudySettings()
    cases = [design for design in main_runs(plan) if design.load.torque]
    studies = [
        stress_study(run, design, (), settings, told=partial(_part_begins, told, design.name))
        for design, run in zip(cases, runs(cases), strict=True)
    ]
    findings = [study.findings for study in studies]
    told("assumed dimensions")
    swept = {(study.design.name, part): _swept(study, part, settings) for study in studies for part in DIMENSIONS}
    drawn = stress_figures(findings)
    plates = []
    for study in studies:
        name, angle = study.design.name, study["shaft"].findings.bulk_peak.angle
        grids = {one.findings.part: one.grid for one in study.parts}
        maps = {
            one.findings.part: stress_map(study.design, one.grid, one.loads, one.nearest(angle)) for one in study.parts
        }
        words = f"{name}: von Mises stress on every part where that of the shaft is largest"
        plates.append(Plate(f"fig10_grid_{name}", "Fig. 10", f"{name}: grids of the parts.", grid_figure(grids, name)))
        plates.append(Plate(f"fig11_map_{name}", "Fig. 11", f"{words}.", map_figure(maps, name)))
    for name, drawing in drawn.items():
        figure = f"Fig. {name[3:5]}" if name.startswith("fig") else "Figs 12-16"
        plates.append(Plate(name, figure, _caption(name), drawing))
    return Found(
        tuple(plates),
        (_sweep_table(studies, swept),),
        tuple(_judged(claim, findings, swept) for claim in claims(findings)),
        {
            each.design: {
                part.part: {
                    "bulk_mpa": part.bulk_peak.stress / MEGAPASCAL,
                    "angle_deg": math.degrees(part.bulk_peak.angle),
                    "contact_mpa": part.contact_peak.stress / MEGAPASCAL,
                    "change_by_refinement": part.refinement.change,
                }
                for part in each.parts
            }
            for each in findings
        },
        _notes(findings),
    )


def _part_begins(told: Told, design: str, part: str, number: int, of: int) -> None:
    told(f"{design}, {part}, {number + 1} of {of} parts")


def _caption(name: str) -> str:
    if name == "stress_refinement":
        return "Numerical error: the largest bulk stress of each part on a coarser and on a finer grid."
    part = name.split("_stress_")[1].replace("_", " ")
    return f"Largest von Mises stress of {part} over a crank turn, pin and nonpin; the paper's range is dashed."


def _notes(findings: "Sequence[StressFindings]") -> tuple[str, ...]:
    from cycloid_mj.stress.findings import ASSUMPTIONS

    rough = [f"{each.design} {part.part}" for each in findings for part in each.parts if not part.refinement.holds]
    return (*ASSUMPTIONS, *([f"not converged to 3 % under one more refinement: {', '.join(rough)}"] if rough else []))


def _swept(study: "StressStudy", part: str, settings: "StudySettings") -> dict[float, float]:
    """Give dimension [mm] -> largest bulk stress [MPa] of some crank angles, with the loads of the run."""
    from cycloid_mj.stress.field import solve
    from cycloid_mj.stress.part import part_grid
    from cycloid_mj.stress.study import at_angles

    key, values = DIMENSIONS[part]
    one, own = study[part], _own(study.design, part)
    found = {own: one.findings.bulk_peak.stress / MEGAPASCAL}
    if part == "gear":
        # plane stress under given forces goes with the inverse of the width
        return dict(sorted((found | {value: found[own] * own / value for value in values}).items()))
    count = one.loads.angle.size
    steps = np.arange(SWEPT_ANGLES) * count // SWEPT_ANGLES
    some = at_angles(one.loads, (int(np.argmax(one.stress.bulk_stress)) + steps) % count)
    for value in values:
        changed = override(study.design, [f"{key}={value!r}"])
        grid = part_grid(changed, part, settings.grid(part))
        found[value] = float(solve(changed, grid, some).bulk_stress.max()) / MEGAPASCAL
    return dict(sorted(found.items()))


def _own(design: Design, part: str) -> float:
    table, _, name = DIMENSIONS[part][0].removesuffix("_mm").partition(".")
    return round(1e3 * float(getattr(getattr(design, table), name)), 9)


Swept = Mapping[tuple[str, str], Mapping[float, float]]


def _sweep_table(studies: "Sequence[StressStudy]", swept: Swept) -> Table:
    from cycloid_mj.stress.paper import RANGES

    rows = [
        (f"{study.design.name}, {part}", DIMENSIONS[part][0], value, size, RANGES[part, study.design.ring.kind])
        for study in studies
        for part in DIMENSIONS
        for value, size in swept[study.design.name, part].items()
    ]
    return Table(
        "largest bulk stress by a dimension that the paper leaves open (some crank angles, loads as in the run)",
        ("part", "dimension", "[mm]", "ours [MPa]", "the paper's range [MPa]"),
        tuple(rows),
    )


def _judged(claim: "StressClaim", findings: "Sequence[StressFindings]", swept: Swept) -> Claim:
    """Make a verdict of the study a claim: where the sweep of a dimension reaches the paper's range, it depends."""
    about = [
        (each, part) for each in findings for part in each.parts if _is_about(claim.statement, each.design, part.part)
    ]
    error = max((part.refinement.change for _, part in about), default=math.nan)
    verdict: Verdict = "agree" if claim.verdict == "agrees" else "disagree"
    shown, ours = "maxima over the crank turn: Figs 12-16", claim.found
    if BELOW in claim.statement:
        each, part = about[0]
        shown, reached = _reaches(each, part.part, swept)
        verdict = "depends" if verdict == "disagree" and reached else verdict
    elif "loaded again" in claim.statement:
        shown = "Fig. 16; what damping, friction, clearance and stiffness make of it: table of pin 1's cycle"
    elif "ranges" in claim.statement:
        pin, nonpin = (part.bulk_peak.stress for _, part in about)
        verdict = verdict if abs(nonpin / pin - 1.0) > error else "disagree"
        ours += ", the order" if verdict == "agree" else ""
    return Claim(
        claim.figure,
        claim.statement.replace(BELOW, "'s stress reaches up to about"),
        _paper(claim.statement),
        ours,
        f"{100 * error:.2g} % (one more refinement)",
        verdict,
        claim.decided_by,
        shown,
    )


def _reaches(each: "StressFindings", part: str, swept: Swept) -> tuple[str, bool]:
    """Tell the sweep of a part's dimension, and whether the paper's range lies within what it reaches."""
    from cycloid_mj.stress.paper import RANGES

    sizes = swept[each.design, part]
    told = ", ".join(f"{value:g} mm: {size:.3g}" for value, size in sizes.items())
    needed = giving(sizes, RANGES[part, each.ring])
    reached = math.isfinite(needed)
    words = f"; the paper's would take {needed:.3g} mm" if reached else "; none gives the paper's"
    return f"{DIMENSIONS[part][0].removesuffix('_mm')} {told} MPa{words}", reached


def giving(sizes: Mapping[float, float], wanted: float) -> float:
    """Interpolate the dimension that gives a stress, both by their logarithms; not a number where none encloses it."""
    for (low, below), (high, above) in pairwise(sorted(sizes.items())):
        if min(below, above) <= wanted <= max(below, above) and below != above:
            share = math.log(wanted / below) / math.log(above / below)
            return low * (high / low) ** share
    return math.nan


def _is_about(statement: str, design: str, part: str) -> bool:
    """Whether a statement is on a part of a design, or compares it between designs."""
    words = part.replace("_", " ")
    if statement.startswith(f"{words}:"):
        return True
    if not statement.startswith(f"{design}:"):
        return False
    order = "shaft > ring > gear" in statement and part in DIMENSIONS
    cycle = ("two peaks" in statement and part == "shaft") or statement.startswith(f"{design}: {words} ")
    return f"the {words}'s" in statement or order or cycle


def _paper(statement: str) -> str:
    """Give what the paper has for a statement."""
    for words, told in PAPER.items():
        if words in statement:
            return told
    return statement.rpartition(" (ranges ")[2].rstrip(")") if "ranges" in statement else statement.split("stays ")[1]
