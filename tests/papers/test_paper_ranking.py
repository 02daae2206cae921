"""The paper's question put to compared runs: verdicts on known levels, and what decides them."""

import json
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hsieh2014.decisions import Varied, decisions
from hsieh2014.ranking import FEWEST_TURNS, SIGNIFICANCE, Ranking, rankings, summary
from hsieh2014.rivals import judged_runs
from hsieh2014.stated import FLUCTUATIONS
from trials import pair, started_pair, trial_of, waving

from cycloid_mj.comparison import STARTS, SWEEP, StartSpread, Variation
from cycloid_mj.comparison.fluctuation import Level


def ranking(pin: tuple[float, ...], nonpin: tuple[float, ...], figure: str = "Fig. 6", load: float = 36.0) -> Ranking:
    levels = [Level(float(np.sqrt(np.mean(np.square(values)))), values) for values in (pin, nonpin)]
    starts = (StartSpread.of([level.rms]) for level in levels)
    return Ranking("disc speed", figure, "rad/s", load, "pin", "nonpin", *levels, *starts)


def idle_ranking(pin: Sequence[float], nonpin: Sequence[float]) -> Ranking:
    """Starts without load; their turns, of which none is like another's, must not matter."""
    levels = Level(9.0, (9.0, 9.1, 9.2, 9.3)), Level(1.0, (1.0, 1.1, 1.2, 1.3))
    return Ranking(
        "disc speed", "Fig. 6", "rad/s", 0.0, "pin", "nonpin", *levels, StartSpread.of(pin), StartSpread.of(nonpin)
    )


def eight(low: float, high: float, count: int = STARTS) -> list[float]:
    return list(np.linspace(low, high, count))


@pytest.mark.parametrize(
    ("pin", "nonpin", "verdict"),
    [
        (eight(2.0, 3.0), eight(1.0, 1.9), "confirmed"),
        (eight(1.0, 1.9), eight(2.0, 3.0), "contradicted"),
        # the spreads exceed the difference, by one start or by the 5 % that the time step may change
        (eight(2.0, 3.0), eight(1.0, 2.1), "not determined"),
        (eight(2.0, 3.0), eight(1.0, 1.95), "not determined"),
        # too few starts, far apart though they are, and one that is copied
        (eight(20.0, 30.0, STARTS - 1), eight(1.0, 1.9), "not determined"),
        ([20.0], [1.0], "not determined"),
        ([20.0] * STARTS, [1.0] * STARTS, "not determined"),
        (eight(20.0, 30.0), [1.0] * STARTS, "not determined"),
    ],
)
def test_an_idle_verdict_rests_on_independent_starts(pin, nonpin, verdict):
    found = idle_ranking(pin, nonpin)
    assert found.verdict == verdict
    assert found.ratio == pytest.approx(np.mean(pin) / np.mean(nonpin))


def test_idle_sentences_state_the_starts():
    confirmed = idle_ranking(eight(2.0, 3.0), eight(1.0, 1.9)).sentence
    assert confirmed == (
        "no load, disc speed (Fig. 6): CONFIRMED, pin fluctuates more: rms pin 2 to 3 rad/s (mean 2.5), "
        "nonpin 1 to 1.9 rad/s (mean 1.45), ratio of the means 1.72"
    )
    overlapping = idle_ranking(eight(2.0, 3.0), eight(1.0, 2.5)).sentence
    assert "NOT DETERMINED, 8 starts spread by more than their difference" in overlapping
    assert "NOT DETERMINED, 1 start of the 8" in idle_ranking([20.0] * STARTS, [1.0] * STARTS).sentence
    assert "NOT DETERMINED, 2 starts of the 8" in idle_ranking([20.0, 21.0], [1.0, 2.0]).sentence
    unnamed = replace(idle_ranking([2.0], [1.0]), figure="").sentence
    assert "(not in the paper): 1 start of the 8" in unnamed


@pytest.mark.parametrize(
    ("pin", "nonpin", "verdict"),
    [
        ((2.0, 2.1, 2.2, 2.3), (1.0, 1.1, 1.2, 1.9), "confirmed"),
        ((1.0, 1.1, 1.2, 1.9), (2.0, 2.1, 2.2, 2.3), "contradicted"),
        ((1.0, 1.0, 1.0, 1.0), (1.04, 1.04, 1.04, 1.04), "alike"),
        ((2.0, 2.1, 2.2, 2.3), (1.0, 1.1, 1.2, 2.01), "undecided"),
        ((2.0, 2.1, 2.2), (1.0, 1.1, 1.2), "undecided"),
        ((3.0, 3.1, 3.2, 3.3, 3.4, 1.55), (1.0, 1.1, 1.2, 1.3, 1.4, 2.0), "confirmed"),
        ((1.0, 1.1, 1.2, 1.3), (0.0,) * 4, "confirmed"),
    ],
)
def test_verdict(pin, nonpin, verdict):
    assert ranking(pin, nonpin).verdict == verdict


def test_chance_counts_orders_of_the_turns():
    """Without a difference all C(2n, n) orders of n and n turns are equally likely, and two of them are extreme."""
    for n in (FEWEST_TURNS - 1, FEWEST_TURNS):
        chance = ranking(tuple(range(n, 2 * n)), tuple(range(n))).chance
        assert chance == pytest.approx(2 / math.comb(2 * n, n))
        assert (chance < SIGNIFICANCE) == (n == FEWEST_TURNS)


def test_sentences_state_verdict_and_numbers():
    confirmed = ranking((2.0,) * 4, (1.0,) * 4)
    assert confirmed.sentence.startswith("36 N m, disc speed (Fig. 6): CONFIRMED, pin fluctuates more: rms pin 2 rad/s")
    assert confirmed.sentence.endswith("ratio 2.00")
    contradicted = ranking((1.0,) * 4, (2.0,) * 4)
    assert "36 N m, disc speed (Fig. 6): NOT CONFIRMED, nonpin fluctuates more" in contradicted.sentence
    assert "(not in the paper): nonpin fluctuates more" in ranking((1.0,) * 4, (2.0,) * 4, figure="").sentence
    assert "NOT CONFIRMED, both are alike" in ranking((1.0,) * 4, (1.0,) * 4).sentence
    assert "UNDECIDED" in ranking((1.0,), (2.0,)).sentence


def test_summary_states_for_each_load_what_is_confirmed():
    ranked = [
        idle_ranking(eight(2.0, 3.0), eight(1.0, 1.9)),
        replace(idle_ranking([2.0], [1.0]), figure="Fig. 7"),
        ranking((1.0,) * 4, (2.0,) * 4, "Fig. 6"),
        ranking((2.0,) * 4, (1.0,) * 4, "Fig. 7"),
        ranking((2.0,) * 4, (1.0,) * 4, ""),
        ranking((2.0,), (1.0,), "Fig. 8"),
    ]
    assert summary(ranked) == [
        "no load, pin fluctuates more than nonpin: confirmed for disc speed (Fig. 6); "
        "not determined for disc speed (Fig. 7)",
        "36 N m, pin fluctuates more than nonpin: confirmed for disc speed (Fig. 7); "
        "not confirmed for disc speed (Fig. 6); undecided for disc speed (Fig. 8)",
    ]


def test_rankings_carry_the_figures_of_the_paper():
    judged = judged_runs(pair(20.0), {SWEEP[0]: pair(20.0)}).content
    for ranked in (judged["rankings"], judged["sweep"][0]["rankings"]):
        assert [one["figure"] for one in ranked] == ["Fig. 6", "Fig. 7", "Fig. 8", "", ""]
    assert FLUCTUATIONS.keys() < {one["quantity"] for one in judged["rankings"]}


def test_runs_are_judged_load_by_load():
    verdicts = {(r.quantity, r.load_nm): r.verdict for r in rankings(pair(20.0) + pair(0.0, pin=0.001, nonpin=0.002))}
    assert verdicts["disc speed", 20.0] == "confirmed"
    assert verdicts["disc speed", 0.0] == "not determined"
    assert verdicts["acceleration of the output", 20.0] == "alike"


def test_idle_runs_are_judged_by_their_starts():
    found = rankings([*started_pair(), *pair(20.0)])
    verdicts = {(r.quantity, r.load_nm): (r.verdict, r.starts) for r in found}
    assert verdicts["disc speed", 0.0] == ("confirmed", STARTS)
    assert verdicts["disc speed", 20.0] == ("confirmed", 1)
    # the same motion of every start in both designs
    assert verdicts["acceleration of the disc's centre", 0.0] == ("not determined", 1)
    assert len(found[0].pin_starts.values) == STARTS


def test_json_of_what_is_judged_is_plain_and_complete():
    trials = pair(20.0)
    found = judged_runs(trials, dict.fromkeys(SWEEP, trials)).content
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found["rankings"][0]["verdict"] == "confirmed"
    assert len(found["sweep"]) == len(SWEEP)
    assert len(found["decisions"]) == len(found["rankings"])


def test_designs_of_one_kind_are_not_judged():
    found = judged_runs([trial_of("pin"), trial_of("pin", "name=rough", gear_speed=waving(0.001))], {})
    assert found.content == {"rankings": [], "summary": [], "sweep": [], "decisions": []}
    assert (len(found.notes), found.summary) == (1, ())


def test_every_pin_design_is_ranked_against_every_nonpin_design():
    fixed = trial_of("pin", "name=fixed", 'ring.pins="fixed"')
    ranked = rankings([*pair(), fixed])
    assert {(r.pin, r.nonpin) for r in ranked} == {("pin", "nonpin"), ("fixed", "nonpin")}


def test_an_undetermined_order_has_no_determined_cause():
    ranked = rankings(pair(0.0))
    found = decisions(ranked, [Varied("damping", "0.1", tuple(ranked))])
    assert all(words.endswith("not determined, as the order of the designs is not") for words in found)


def test_decisions_name_what_closes_the_gap():
    """The ratio is 2; damping leaves 1.9, the fixed pins 1.1: log 1.1 / log 2 = 0.14 of the difference."""
    base = rankings(pair(20.0))
    damped, fixed = (tuple(rankings(pair(20.0, pin=size))) for size in (0.0019, 0.0011))
    points = [Varied("damping", "1.0", damped), Varied("pins", "fixed", fixed)]
    found = decisions(base, points)
    decision = next(text for text in found if "disc speed" in text)
    assert decision == (
        "20 N m, disc speed, pin / nonpin: ratio 2.00; damping 1.0: 1.90; pins fixed: 1.10: decided by pins"
    )
    assert decisions(base, []) == []
    assert "decided by none" in decisions(base, points[:1])[0]
    alike = next(text for text in found if "acceleration of the output" in text)
    assert alike.endswith("the designs are alike")


def test_the_figure_of_what_decides_marks_every_ratio():
    base, fixed = pair(20.0) + pair(0.0), pair(20.0, pin=0.0011) + pair(0.0, pin=0.003)
    found = judged_runs(base, {Variation("pins", "fixed", ()): fixed})
    panels = found.figures["compare_sweep"]().axes
    assert [panel.get_title(loc="left") for panel in panels] == ["no load, 1666.67 rpm", "20 N m, 1666.67 rpm"]
    marks = sorted(line.get_ydata()[0] for panel in panels for line in panel.lines if line.get_marker() != "None")
    ratios = [r.ratio for r in (*rankings(base), *rankings(fixed)) if math.isfinite(r.ratio)]
    assert marks == pytest.approx(sorted(ratios))
    assert len(marks) > 4
