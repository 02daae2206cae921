"""The paper as its authors may have run it: which of the two changes brings which feature."""

from types import SimpleNamespace

import numpy as np
import pytest
from hsieh2014 import authors, command
from hsieh2014.authors import BOTH, FACETS, OURS, SOFT, brought_by
from hsieh2014.command import ReproduceDelivery
from hsieh2014.peaks import BINS, by_angle, maxima, middle
from hsieh2014.plan import IMPACT, at_speed, designs
from hsieh2014.run import AUTHORS, STEPS
from hsieh2014.soft_contact import GENERIC, soft_idle

from cycloid_mj.comparison import gravity_turn, settle_run
from cycloid_mj.design import PRESETS
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.reducer import Reducer


@pytest.mark.parametrize(
    ("holding", "words"),
    [
        ((OURS, SOFT, FACETS, BOTH), "neither: ours has it"),
        ((OURS,), "both together remove it"),
        ((SOFT, BOTH), SOFT),
        ((FACETS, BOTH), FACETS),
        ((SOFT, FACETS, BOTH), f"{SOFT} or {FACETS}"),
        ((BOTH,), "neither alone"),
        ((SOFT,), "the other change removes it"),
        ((), "neither, nor both"),
    ],
)
def test_the_cause_of_a_feature_is_identified_by_removing_each_change(holding, words):
    assert words in brought_by({name: name in holding for name in authors.CHANGES})


def test_a_torque_is_explained_by_the_law_that_causes_it():
    told = [authors.torque_brought_by(line, impact, 34.7) for line in (34.5, 32.0) for impact in (34.9, 30.0)]
    assert told[:2] == ["neither: ours has it", "neither: ours has it; IMPACT removes it"]
    assert told[2:] == [SOFT, "neither: friction decides it (claims on Fig. 19)"]


def test_maxima_of_a_turn_are_counted_without_ripple():
    angle = np.radians([middle(place) for place in range(BINS)])
    two = 3.0 + np.cos(2.0 * (angle - np.radians(75.0))) + 0.3 * np.cos(12.0 * angle)
    assert maxima(two) == (75.0, 255.0)
    assert len(maxima(3.0 + np.cos(4.0 * angle))) == 4
    assert maxima(np.ones(BINS)) == ()


def test_a_feature_is_looked_for_in_both_designs():
    angle = np.radians([middle(place) for place in range(BINS)])
    two, four = (3.0 + size * np.cos(order * (angle - np.radians(75.0))) for size, order in ((1.0, 2), (0.5, 4)))

    def starts(curve, rms, **more):
        """Five starts, each a little rougher than the last."""
        sizes = {"tooth": 1.0, "seat": 1.0, "cam": 4.0} | more
        return [
            SimpleNamespace(curve=tuple(curve), rms=rms * grown, q_rms=5e-3 * rms * grown, **sizes)
            for grown in np.linspace(1.0, 1.1, len(authors.PHASES))
        ]

    forces = {"pin": starts(two, 0.05, reach=1e-6), "nonpin": starts(four, 0.04, reach=0.0)}
    found = authors._features(
        {name: dict.fromkeys(("shaft", "ring", "gear"), lambda force: 40.0 * force) for name in forces}
    )
    told = {one.words: one.holds(forces) for one in found}
    assert [told[one.words] for one in found[:5]] == [True] * 5
    assert [one.figure for one in found[:5]] == ["Fig. 12", "Fig. 12", "Fig. 6", "Fig. 8", "Fig. 9"]
    assert found[2].tell(forces) == "0.05 to 0.055 against 0.04 to 0.044 rad/s, p = 0.0079"
    # starts that overlap have no order, whatever their means
    alike = forces | {"nonpin": starts(four, 0.049)}
    assert [one.holds(alike) for one in found[2:4]] == [False, False]
    forces["pin"][0].reach = 1.2e-6
    assert not found[4].holds(forces)
    assert found[4].tell(forces) == "1 to 1.2 um"
    # 4 N at 40 MPa a newton are 160 MPa at the shaft: the paper's of pin, beyond that of nonpin
    assert told["pin: the shaft stressed as high as in the paper"]
    assert not told["nonpin: the shaft stressed as high as in the paper"]
    assert "75, 255 deg" in found[0].tell(forces)


def test_the_separate_stage_runs_by_its_flag(tmp_path, monkeypatch):
    assert AUTHORS.key == "authors"
    assert AUTHORS not in STEPS
    chosen = []
    monkeypatch.setattr("hsieh2014.run.run_steps", lambda plan, runs, report, only: chosen.extend(only) or [])
    command.reproduce(quick=True, as_the_authors=True, delivery=ReproduceDelivery(out=str(tmp_path), quiet=True))
    assert chosen == ["authors"]


@pytest.mark.slow
@pytest.mark.parametrize("design", designs(), ids=["pin", "nonpin"])
def test_the_torque_by_soft_contacts_has_settled(design):
    soft = authors.torques_by_turn(IMPACT.of(Reducer(design)))
    assert soft[-1] == pytest.approx(soft[-2], rel=1e-3)
    # at first it is far off
    assert soft[0] < 0.7 * soft[-1]
    # by line contacts it is there from the start, and is that of `measure torque`
    line = authors.torques_by_turn(design, 1)[0]
    assert line == pytest.approx(32.0, rel=0.02)


@pytest.mark.slow
def test_two_solvers_find_the_papers_two_peaks_with_the_soft_contact():
    design = PRESETS["pin"]
    planar = authors.mean_curve([soft_idle(design, GENERIC, 0.0, 1, 0, phase) for phase in authors.PHASES])
    assert len(maxima(planar)) == 2
    assert maxima(planar) == pytest.approx((75.0, 255.0), abs=10.0)
    run = simulate(
        at_speed(IMPACT.of(Reducer(design)).but(friction=dict.fromkeys(("pin_gear", "pin_socket"), 0.0)), 0.0, 1)
    )
    assert gravity_turn(Reducer(settle_run(run).design)) == 0.0
    curve = by_angle(run, ["cam"])
    assert len(maxima(curve)) == 2
    assert maxima(curve) == pytest.approx((75.0, 255.0), abs=25.0)
    assert curve.max() == pytest.approx(planar.max(), rel=0.2)
