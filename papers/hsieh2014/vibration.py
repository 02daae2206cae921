"""Figs 6-8: which design fluctuates more without load, and what decides it.

Each quantity without load is the spread over independent starts. Its value under the rated load is reported, too, but
not judged.
"""

import math
from collections.abc import Iterator, Mapping, Sequence

from cycloid_mj.base.result import Claim, Removal, Table, Value, Verdict
from cycloid_mj.comparison import StartSpread, Variation, settle_run
from cycloid_mj.reducer import Reducer
from hsieh2014.cycle import cycle_table
from hsieh2014.idle import (
    Divergence,
    Levels,
    divergence,
    idle,
    levels_of,
    nudge_gravity,
    pin_over_nonpin,
    swept,
)
from hsieh2014.plan import (
    LEFT_OPEN,
    SAMPLES,
    Plan,
    designs,
    equal_play_design,
    finer_idle_runs,
    finer_rated_runs,
    idle_runs,
    main_runs,
    ranges,
    rated_runs,
    variations,
    varied_idle_runs,
    varied_rated_runs,
)
from hsieh2014.ranking import RANKED, Ranked
from hsieh2014.run_figures import RunFigures
from hsieh2014.stage import PaperFigure, Progress, Runs, StageResult
from hsieh2014.statements import fluctuation
from hsieh2014.verdicts import POWER, SIGNIFICANCE, SUPERIORITY, chance, order_cause, order_verdict, rank_order

RATIO = "pin / nonpin"

CAPTIONS = {
    "compare_gear_speed": ("Fig. 6", "Error of the gear's speed over a turn, both designs on one scale."),
    "compare_q_path": ("Fig. 7", "Distance of q from its path over a turn, both designs on one scale."),
    "compare_q_speed": ("Fig. 8", "Error of the speed of q over a turn, both designs on one scale."),
    "compare_transmission_error": ("vibration", "Transmission error of the output over a turn, its mean left out."),
    "compare_vibration": ("vibration", "Spectra of the acceleration of gear centre and output about closed forms."),
}


def vibration(plan: Plan, runs: Runs, progress: Progress) -> StageResult:
    """Judge which design fluctuates more without load over independent starts, also with single parameters varied."""
    # requested together, so that the runs fill every core
    mains = main_runs(plan)[:2]
    pairs = [(design, nudge_gravity(design)) for design in mains]
    starts = [run for design in designs() for run in idle_runs(plan, design)]
    runs([*starts, *rated_runs(plan), *(each for pair in pairs for each in pair)], plan.solver)
    base, sweep = idle(plan, runs), swept(plan, runs)
    chaos = {each.name: divergence(*runs([each, other], plan.solver)) for each, other in pairs}
    rated = {"as it is": _rated_levels(runs.figures(rated_runs(plan), plan.solver))} | _varied_rated_levels(plan, runs)
    cases = {"as it is": base} | {each.words: levels for each, levels in sweep.items()}
    finer = {design.name: finer_idle_runs(plan, design) for design in designs()}
    halved = {"half the step": levels_of({name: runs.figures(begun, plan.solver) for name, begun in finer.items()})}
    idle_table = _idle_table(cases | (halved if plan.finer_turns else {}))
    cycles = cycle_table({"as it is": runs(rated_runs(plan), plan.solver)})
    return StageResult(
        tuple(_plates(plan, runs, cases)),
        (idle_table, _rated_table(rated), _spin_table(plan, runs), cycles),
        tuple(_claim(plan, each, base, sweep, rated["as it is"]) for each in RANKED),
        {
            "idle": {
                name: {
                    key: {design: list(spread.values) for design, spread in starts.items()}
                    for key, starts in levels.items()
                }
                for name, levels in cases.items()
            },
            "chaos": {
                name: {"foldings_per_turn": each.foldings, "turns_to_a_tenth": each.turns}
                for name, each in chaos.items()
            },
        },
        tuple(_notes(plan, chaos)),
    )


def _plates(plan: Plan, runs: Runs, cases: Mapping[str, Levels]) -> Iterator[PaperFigure]:
    """Draw one turn of each main run, and every start of every case."""
    from cycloid_mj.plots.comparison import comparison_figures
    from hsieh2014.starts_figure import starts_figure

    drawn = comparison_figures([settle_run(run) for run in runs(main_runs(plan))])
    for name, (figure, words) in CAPTIONS.items():
        yield PaperFigure(name, figure, f"{words} Left no load, right the rated load.", drawn[name])
    words = "No load: rms of every independent start, pin and nonpin, as it is and with one parameter varied."
    yield PaperFigure("compare_starts", "Figs 6-8", words, starts_figure(cases, RANKED))


def _claim(plan: Plan, quantity: Ranked, base: Levels, sweep: Mapping[Variation, Levels], rated: Levels) -> Claim:
    """Judge which design fluctuates more in a quantity without load, by its starts and by what the paper leaves open.

    The rms values are `base` as designed, `sweep` with single changes, and `rated` under the rated load (not judged).
    """
    key = quantity.key
    turned_by = {
        each.words: pin_over_nonpin(levels, key) for each, levels in sweep.items() if each.parameter in LEFT_OPEN
    }
    verdict, deciding = order_verdict(pin_over_nonpin(base, key), turned_by)
    pin, nonpin = base[key]["pin"], base[key]["nonpin"]
    ratio = pin.over(nonpin)
    words = (
        f"rms {pin.words} with pins, {nonpin.words} {quantity.unit} without ({len(pin.values)} runs each, "
        f"p = {chance(pin, nonpin):.2g}); ratio of the means {ratio.values[0]:.2f}"
    )
    return fluctuation(key, quantity.name).judge(
        ours=Value(words, ratio.values[0], RATIO, (ratio.low, ratio.high)),
        error=Value(f"spread of {len(pin.values)} runs", ratio.half, RATIO),
        verdict=verdict,
        decided_by=_cause(key, base, sweep, verdict, deciding),
        rated=_rated_value(quantity, rated[key]),
        searched=ranges(plan),
        removals=[_removal(each, levels[key], quantity.unit) for each, levels in sweep.items()],
        p=chance(pin, nonpin),
    )


def _removal(variation: Variation, spreads: Mapping[str, StartSpread], unit: str) -> Removal:
    """Judge one quantity with a single change."""
    pin, nonpin = spreads["pin"], spreads["nonpin"]
    words = f"{pin.words} with pins, {nonpin.words} {unit} without, p = {chance(pin, nonpin):.2g}"
    return Removal(variation.words, words, order_verdict(rank_order(pin, nonpin), {})[0])


def _cause(key: str, base: Levels, sweep: Mapping[Variation, Levels], verdict: Verdict, deciding: Sequence[str]) -> str:
    """Return in words which variations reverse the order, and which of them the paper leaves open."""
    orders = {each: pin_over_nonpin(levels, key) for each, levels in sweep.items() if each.parameter not in LEFT_OPEN}
    agreeing = [each.words for each, order in orders.items() if order not in (0, pin_over_nonpin(base, key))]
    words = order_cause(verdict, deciding, "none of the varied values that the paper omits")
    return f"{words}; stated by the paper: {', '.join(agreeing)}" if agreeing else words


def _rated_value(quantity: Ranked, rated: Mapping[str, StartSpread]) -> Value:
    pin, nonpin, *others = (each.mean for each in rated.values())
    ratio = rated["pin"].over(rated["nonpin"]).values[0]
    third = "".join(f"; {equal_play_design().name} {level:.3g}" for level in others)
    return Value(
        f"rms {pin:.3g} with pins, {nonpin:.3g} {quantity.unit} without, ratio {ratio:.2f}{third}", ratio, RATIO
    )


def _rated_levels(runs: Sequence[RunFigures]) -> Levels:
    """Return the levels of the rated runs of pin, nonpin and, if it ran, the third design."""
    return levels_of({each.design: [each] for each in runs})


def _varied_rated_levels(plan: Plan, runs: Runs) -> dict[str, Levels]:
    """Return the rated levels with single parameters varied and with half the step; none if quick."""
    if plan.quick:
        return {}
    cases = {variation.words: varied_rated_runs(plan, variation) for variation in variations(plan)}
    cases |= {"half the step": finer_rated_runs(plan)} if plan.finer_turns else {}
    runs([run for each in cases.values() for run in each], plan.solver)
    return {name: _rated_levels(runs.figures(each, plan.solver)) for name, each in cases.items()}


def _spin_table(plan: Plan, runs: Runs) -> Table:
    """Return the table of the mean rotational speed of pin 1 without load and under the rated load."""
    design = designs()[0]
    cases = {"as it is": (idle_runs(plan, design), rated_runs(plan)[:1])}
    for variation in variations(plan):
        if variation.of(Reducer(design)).ring.has_moving_pins:
            loaded = [] if plan.quick else varied_rated_runs(plan, variation)[:1]
            cases[variation.words] = (varied_idle_runs(plan, variation, design), loaded)
    rows = [
        (name, _spins(runs.figures(free, plan.solver)), _spins(runs.figures(loaded, plan.solver)))
        for name, (free, loaded) in cases.items()
    ]
    title = "mean spin of pin 1 [rad/s]: its range over starts, and at the rated load"
    return Table(title, ("", "no load", "rated"), tuple(rows))


def _spins(runs: Sequence[RunFigures]) -> str:
    means = StartSpread.of(each.pin_1.mean_spin for each in runs if each.pin_1)
    if not means.values:
        return ""
    return means.words if len(means.values) > 1 else f"{means.mean:.3g}"


def _idle_table(cases: Mapping[str, Levels]) -> Table:
    """Return the table of the spread of each quantity in each case."""
    head = ("no load: rms over independent starts, pin | nonpin", *cases)
    rows = [
        (
            f"{each.name} [{each.unit}]",
            *(" | ".join(spread.words for spread in levels[each.key].values()) for levels in cases.values()),
        )
        for each in RANKED
    ]
    return Table("idle fluctuations over independent starts", head, tuple(rows))


def _rated_table(cases: Mapping[str, Levels]) -> Table:
    """Return the table of rms values at the rated load and their ratio, with the third design for the base case."""
    third = equal_play_design().name
    head = (f"rated load: rms, pin | nonpin | ratio (| {third})", *cases)
    rows = [(f"{each.name} [{each.unit}]", *(_cell(levels[each.key]) for levels in cases.values())) for each in RANKED]
    title = "fluctuations under the rated load; the third design has the pin design's total play and series stiffness"
    return Table(title, head, tuple(rows))


def _cell(rated: Mapping[str, StartSpread]) -> str:
    pin, nonpin, *others = (f"{each.mean:.3g}" for each in rated.values())
    return " | ".join([pin, nonpin, f"{rated['pin'].over(rated['nonpin']).values[0]:.2f}", *others])


def _notes(plan: Plan, chaos: Mapping[str, Divergence]) -> Iterator[str]:
    """Yield starts, rank test and chaos of the runs without load, a paragraph each."""
    yield (
        f"No load: rms over {plan.turns} settled turns of each of {SAMPLES.starts} independent starts, in the sweep "
        f"over {plan.varied_turns} of each of {plan.varied_starts}. Starts differ by gravity turned through a whole "
        "number of tooth pitches, as if the crank began elsewhere in its turn."
    )
    yield (
        f"An order counts where a rank test (Mann and Whitney, two-sided) finds p < {SIGNIFICANCE:g}, and medians lie "
        f"more than 5 % apart; else it is not determined. {SAMPLES.starts} starts of each design find a difference "
        f"that {100 * SUPERIORITY:g} % of all pairs of starts show with a power of {100 * POWER:g} % (Noether 1987)."
    )
    for name, pair in chaos.items():
        if math.isfinite(pair.turns):
            yield (
                f"{name}, no load: two runs whose gravity differs by a part in 10^9 part by a factor of e "
                f"{pair.foldings:.0f} times a crank turn, and differ by a tenth of the motion after {pair.turns:.2f} "
                "turns: the motion is chaotic, and only its spread over starts means something."
            )
        elif math.isfinite(pair.foldings):
            yield (
                f"{name}, no load: two runs whose gravity differs by a part in 10^9 part by a factor of e "
                f"{pair.foldings:.1f} times a crank turn, not yet by a tenth of the motion in the turns that were run."
            )
        else:
            yield f"{name}, no load: runs whose gravity differs by a part in 10^9 stay together: no chaos was found."
