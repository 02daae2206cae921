"""Figs 10-16: grids, and stress over a crank turn at no load, where the paper has it; the rated load stands beside."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

from cycloid_mj.comparison import STARTS, settled
from cycloid_mj.record import Run
from cycloid_mj.result import Table
from hsieh2014 import hypothesis
from hsieh2014.idle_stress import MEGAPASCAL, IdleStress, idle_stress
from hsieh2014.peaks import ENDING, pairs, peak
from hsieh2014.plan import Plan, designs, idle_runs, rated_runs
from hsieh2014.stage import Found, Plate, Progress, Runs
from hsieh2014.stated import HEIGHTS
from hsieh2014.stress_claims import stress_claims

QUICK_ANGLES = 40
"""Crank angles of a quick study: 9 deg apart, no multiple of the mesh period, so that they fall on ten phases of it."""


def stress(plan: Plan, runs: Runs, progress: Progress) -> Found:
    """Find the stress of every part under the impact peaks of an idle turn, over independent starts."""
    from cycloid_mj.stress.study import QUICK, StudySettings

    settings = replace(QUICK, angles=QUICK_ANGLES) if plan.quick else StudySettings()
    starts = {design.name: runs(idle_runs(plan, design)) for design in designs()}
    rated = {run.provenance["design"]: run for run in runs(rated_runs(plan))}
    found = {}
    for design in designs():
        name = design.name
        begins = partial(_part_begins, progress, name)
        found[name] = idle_stress(starts[name], rated[name], idle_runs(plan, design)[0], settings, begins)
    progress("hypothesis: soft contact")
    soft, wanted = hypothesis.soft_runs(plan), _needed(found, rated)
    return Found(
        tuple(_plates(found)),
        (_stress_table(found), _force_table(starts, rated), hypothesis.table(soft, wanted)),
        tuple(stress_claims(found, starts, rated)),
        {name: _numbers(one) for name, one in found.items()} | {"hypothesis": hypothesis.as_json(soft, wanted)},
        (*hypothesis.sentences(soft, wanted), *_notes(found)),
    )


def _needed(found: Mapping[str, IdleStress], rated: Mapping[str, Run]) -> dict[str, dict[str, float]]:
    """Give the forces that the paper's heights would take, from stress and largest force under the rated load."""
    forces = {}
    for name, run in rated.items():
        seats = "socket" if f"socket_1{ENDING}" in run.columns else "lobe"
        groups = {"shaft": "cam", "ring": seats}
        forces[name] = {
            part: _largest(run, [pair for pair in pairs(run) if pair.startswith(stem)]) for part, stem in groups.items()
        }
    return {
        name: hypothesis.needed({part: size.high for part, size in one.rated.items()}, forces[name], name)
        for name, one in found.items()
    }


def _largest(run: Run, names: Sequence[str]) -> float:
    """Give the largest force [N] of some pairs in the settled hold."""
    hold = settled(run).hold
    return max(float(peak(run, pair)[hold].max()) for pair in names)


def _part_begins(progress: Progress, design: str, part: str, number: int, of: int) -> None:
    progress(f"{design}, {part}, {number + 1} of {of} parts")


def _plates(found: Mapping[str, IdleStress]) -> list[Plate]:
    from cycloid_mj.plots.stress import grid_figure, map_figure, stress_figures
    from cycloid_mj.stress.study import part_map

    plates = []
    for name, one in found.items():
        study = one.study
        grids = {each.findings.part: each.grid for each in study.parts}
        maps = {each.findings.part: part_map(study.design, each) for each in study.parts}
        words = f"{name}, no load: von Mises stress on every part at the crank angle where its own is largest"
        plates.append(Plate(f"fig10_grid_{name}", "Fig. 10", f"{name}: grids of the parts.", grid_figure(grids, name)))
        plates.append(Plate(f"fig11_map_{name}", "Fig. 11", f"{words}.", map_figure(maps, name)))
    for name, drawing in stress_figures([one.study.findings for one in found.values()]).items():
        figure = f"Fig. {name[3:5]}" if name.startswith("fig") else "Figs 12-16"
        plates.append(Plate(name, figure, _caption(name), drawing))
    return plates


def _caption(name: str) -> str:
    if name == "stress_refinement":
        return "No load. Numerical error: the largest bulk stress of each part on a coarser and on a finer grid."
    part = name.split("_stress_")[1].replace("_", " ")
    return f"No load, impact peaks of one start: largest von Mises stress of {part} over a crank turn, pin and nonpin."


def _stress_table(found: Mapping[str, IdleStress]) -> Table:
    """Give the largest bulk stress of each part: over the starts at no load, the paper's, and at the rated load."""
    rows = [
        (
            f"{name}, {part}",
            one.starts[part].words,
            HEIGHTS.get((part, name), ""),
            f"{one.rated[part].high:.3g}",
        )
        for name, one in found.items()
        for part in one.starts
    ]
    head = ("largest bulk stress [MPa]", f"no load, {STARTS} starts", "the paper, no load, up to about", "rated load")
    return Table("stress by part", head, tuple(rows))


def _force_table(starts: Mapping[str, Sequence[Run]], rated: Mapping[str, Run]) -> Table:
    """Give the largest force of each kind of pair, in a sample and between samples."""
    rows = []
    for name, runs in starts.items():
        for kind in dict.fromkeys(pair.rstrip("0123456789").rstrip("_") for pair in pairs(runs[0])):
            own = [pair for pair in pairs(runs[0]) if pair.rstrip("0123456789").rstrip("_") == kind]
            between = [_largest(run, own) for run in runs]
            loaded = _largest(rated[name], own)
            rows.append((f"{name}, {kind}", f"{min(between):.3g} to {max(between):.3g}", f"{loaded:.3g}"))
    head = ("largest force of one contact pair [N]", f"no load, impact peaks of {STARTS} starts", "rated load")
    return Table("forces behind the stress", head, tuple(rows))


def _numbers(one: IdleStress) -> dict[str, dict[str, object]]:
    return {
        part.part: {
            "no_load_mpa": list(one.starts[part.part].values),
            "rated_mpa": one.rated[part.part].high,
            "angle_deg": float(part.bulk_peak.as_json()["angle_deg"]),
            "contact_no_load_mpa": part.contact_peak.stress / MEGAPASCAL,
            "change_by_refinement": part.refinement.change,
        }
        for part in one.study.findings.parts
    }


def _notes(found: Mapping[str, IdleStress]) -> tuple[str, ...]:
    from cycloid_mj.stress.findings import ASSUMPTIONS

    rough = [
        f"{name} {part.part}"
        for name, one in found.items()
        for part in one.study.findings.parts
        if not part.refinement.holds
    ]
    return (
        "Section 3.3 of the paper: stress is taken without load. Every figure and claim here is at no load; stress at "
        "the rated load is a result of ours, beside them.",
        "Impacts fall between samples: each pair acts with its largest force of all time steps in the window of a "
        "crank angle, all pairs at once. That is on the safe side, but where forces would relieve each other.",
        f"A maximum at no load is that of each of {STARTS} independent starts, at its heaviest crank angles; figures "
        "show the first. Bulk begins as far from the contacts as under the rated load.",
        *ASSUMPTIONS,
        *([f"not converged to 3 % under one more refinement: {', '.join(rough)}"] if rough else []),
    )
