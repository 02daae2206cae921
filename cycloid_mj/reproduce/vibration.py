"""Figs 6-8 side by side: which design fluctuates more, at no load and under load, and what decides it."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from cycloid_mj.comparison import (
    Comparison,
    Ranking,
    Trial,
    Varied,
    compare,
    load_words,
    measure,
    rankings,
    settled,
    varied,
)
from cycloid_mj.comparison.fluctuation import Level
from cycloid_mj.measure import Table
from cycloid_mj.record import Run
from cycloid_mj.reproduce.claims import Claim, judged
from cycloid_mj.reproduce.cycle import cycle_table
from cycloid_mj.reproduce.plan import Plan, finer_runs, main_runs, variations, varied_runs
from cycloid_mj.reproduce.stage import Found, Plate, Runs, Told

FIGURES = {"compare_gear_speed": "Fig. 6", "compare_q_path": "Fig. 7", "compare_q_speed": "Fig. 8"}
CAPTIONS = {
    "compare_gear_speed": "Error of the gear's speed over a turn, both designs on one scale.",
    "compare_q_path": "Distance of q from its path over a turn, both designs on one scale.",
    "compare_q_speed": "Error of the speed of q over a turn, both designs on one scale.",
    "compare_transmission_error": "Transmission error of the gear over a turn.",
    "compare_vibration": "Vibration: spectra of the acceleration of gear centre and output about their closed forms.",
}
VIBRATION = "vibration"


def vibration(plan: Plan, runs: Runs, told: Told) -> Found:
    """Rank the fluctuations of both designs, and vary damping, friction and the pins' freedom."""
    from cycloid_mj.plots.comparison import comparison_figures
    from cycloid_mj.plots.sweep import sweep_figure

    motions = [settled(run) for run in runs(main_runs(plan))]
    trials = [Trial(motion.design, measure(motion)) for motion in motions]
    sweep = variations(plan)
    runs([design for variation in sweep for design in varied_runs(plan, variation)])
    parts = [_trials(runs(varied_runs(plan, variation))) for variation in sweep]
    swept = [varied(variation, part) for variation, part in zip(sweep, parts, strict=True)]
    found = compare(trials, swept)
    cycles = {"as it is": runs(main_runs(plan))}
    cycles |= {f"{one.parameter} {one.value}": runs(varied_runs(plan, one)) for one in sweep}
    finer = rankings(_trials(runs(finer_runs(plan)))) if plan.finer_turns else []
    drawn = comparison_figures(motions)
    plates = [Plate(name, FIGURES.get(name, VIBRATION), words, drawn[name]) for name, words in CAPTIONS.items()]
    plates.append(
        Plate(
            "compare_sweep",
            "Figs 6-8",
            "What decides: rms of pin over rms of nonpin as damping, friction and the pins' freedom change, one at a "
            "time. Above 1, the paper is right.",
            sweep_figure(found),
        )
    )
    return Found(
        tuple(plates),
        (_sweep_table(found), _spin_table(swept, parts), cycle_table(cycles)),
        tuple(_claims(found, finer)),
        {
            "rankings": [_ranked(one) for one in found.rankings],
            "sweep": [
                {"parameter": one.parameter, "value": one.value, "rankings": [_ranked(each) for each in one.rankings]}
                for one in swept
            ],
        },
        (*_windows(plan), *found.decisions),
    )


def _windows(plan: Plan) -> tuple[str, ...]:
    """Tell over how many turns the rms values are taken."""
    told = f"rms over {plan.turns} settled turns; in the sweep over {plan.varied_turns}"
    note = "; an idle gear takes some turns to its rattling, so at no load that matters"
    return (told + (note if plan.varied_turns < plan.turns else ""),)


def _trials(found: Sequence[Run]) -> list[Trial]:
    motions = [settled(run) for run in found]
    return [Trial(motion.design, measure(motion)) for motion in motions]


def _ranked(one: Ranking) -> dict[str, float | str]:
    return {
        "quantity": one.quantity,
        "load_nm": one.load_nm,
        "unit": one.unit,
        "verdict": one.verdict,
        "pin_rms": one.pin_level.rms,
        "nonpin_rms": one.nonpin_level.rms,
        "ratio": one.ratio,
    }


def _claims(found: Comparison, finer: Sequence[Ranking]) -> Iterator[Claim]:
    """Judge each quantity over both loads; the sweep tells whether another damping or friction would turn it round."""
    for quantity in dict.fromkeys(ranking.quantity for ranking in found.rankings):
        cases = [ranking for ranking in found.rankings if ranking.quantity == quantity]
        points = [(one, each) for one in found.sweep for each in one.rankings if each.quantity == quantity]
        verdict = judged([one.verdict == "confirmed" for one in cases], [_rougher(each) for _, each in points])
        yield Claim(
            cases[0].figure or VIBRATION,
            f"{quantity} fluctuates more with pins than without",
            "more" if cases[0].figure else "more vibration",
            "; ".join(_levels(one) for one in cases),
            "; ".join(_error(one, finer) for one in cases),
            verdict,
            _on(cases, points),
            "; ".join(_answers(one, points) for one in cases),
            {f"{_at(one)}_{kind}": level.rms for one in cases for kind, level in _each(one)}
            | {f"{_at(one)}_ratio": one.ratio for one in cases},
        )


def _rougher(ranking: Ranking) -> bool:
    """Whether the pin design fluctuates more, beyond what counts as alike."""
    from cycloid_mj.comparison.ranking import ALIKE

    return ranking.ratio > ALIKE


def _each(ranking: Ranking) -> tuple[tuple[str, Level], tuple[str, Level]]:
    return ("pin", ranking.pin_level), ("nonpin", ranking.nonpin_level)


def _at(ranking: Ranking) -> str:
    return "loaded" if ranking.load_nm else "unloaded"


def _levels(one: Ranking) -> str:
    pin, nonpin = one.pin_level.rms, one.nonpin_level.rms
    return f"{load_words(one.load_nm)}: rms {pin:.3g} against {nonpin:.3g} {one.unit}, ratio {one.ratio:.2f}"


def _error(one: Ranking, finer: Sequence[Ranking]) -> str:
    """Give the error of the ratio: by how far the turns differ, or what half the step changes, whichever is more."""
    scatter = math.hypot(*(_scatter(level) for _, level in _each(one)))
    same = [each for each in finer if _case(each) == _case(one)]
    step = max((abs(each.ratio / one.ratio - 1.0) for each in same if one.ratio), default=0.0)
    source = "half the step" if step > scatter else "turn to turn"
    return f"{100 * max(scatter, step):.2g} % of {one.ratio:.2f} ({source})"


def _scatter(level: Level) -> float:
    """Give half the range of the turns' rms, relative: turns of an idle gear are not independent of each other."""
    return float(np.ptp(level.by_turn)) / 2.0 / level.rms if level.rms else 0.0


def _on(cases: Sequence[Ranking], points: Sequence[tuple[Varied, Ranking]]) -> str:
    """Name what turns the ranking round: the load, or parameters of the sweep."""
    base = {one.load_nm: _rougher(one) for one in cases}
    turned = dict.fromkeys(
        f"{'freedom of the pins' if one.parameter == 'pins' else one.parameter} ({load_words(each.load_nm)})"
        for one, each in points
        if _rougher(each) != base[each.load_nm]
    )
    load = ["load"] if len(set(base.values())) > 1 else []
    return ", ".join([*load, *turned]) or "none of what was varied"


def _answers(case: Ranking, points: Sequence[tuple[Varied, Ranking]]) -> str:
    told = (f"{one.parameter} {one.value}: {each.ratio:.2f}" for one, each in points if each.load_nm == case.load_nm)
    return f"{load_words(case.load_nm)}: " + ", ".join(told)


def _case(ranking: Ranking) -> tuple[str, float]:
    return ranking.quantity, ranking.load_nm


def _sweep_table(found: Comparison) -> Table:
    """Give pin over nonpin for each quantity and load, as it is and varied."""
    head = ("pin / nonpin, rms", "as it is", *(f"{one.parameter} {one.value}" for one in found.sweep))
    rows: list[tuple[str | float, ...]] = []
    for one in found.rankings:
        same = [next(each for each in point.rankings if _case(each) == _case(one)) for point in found.sweep]
        rows.append((f"{one.quantity}, {load_words(one.load_nm)}", one.ratio, *(each.ratio for each in same)))
    return Table("the sweep in numbers", head, tuple(rows))


def _spin_table(swept: Sequence[Varied], parts: Sequence[Sequence[Trial]]) -> Table:
    """Give the mean spin of pin 1 in each run of the sweep that has free pins."""
    rows: list[tuple[str | float, ...]] = []
    for one, trials in zip(swept, parts, strict=True):
        spins = [trial.measures.findings.pin1 for trial in trials if trial.measures.findings.pin1]
        if spins:
            rows.append((f"{one.parameter} {one.value}", *(spin.mean_spin_rad_s for spin in spins)))
    return Table("mean spin of pin 1 [rad/s]", ("", "no load", "rated load"), tuple(rows))
