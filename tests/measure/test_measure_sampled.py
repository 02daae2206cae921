"""Errors of means and extremes over few crank angles: against the turn they are taken from."""

import numpy as np
import pytest
from designs import unlike

from cycloid_mj.measure import bench, rigid_backlash
from cycloid_mj.measure.sampled import ClosedForm, add_errors, error_of_extreme, error_of_mean
from cycloid_mj.reducer import Reducer

TURN = np.linspace(0.0, 2.0 * np.pi, 721)


def test_a_closed_form_gives_the_error_of_the_samples():
    shape = 3.0 + np.cos(TURN)
    sampled = shape[[0, 90]]
    known = ClosedForm(sampled, shape)
    measured = 1.1 + sampled  # a closed form that is off by the same everywhere explains all of the change
    assert error_of_mean(measured, known) == pytest.approx(abs(shape.mean() - sampled.mean()), rel=1e-9)
    assert error_of_extreme(measured, True, known) == pytest.approx(0.0, abs=1e-12)
    assert error_of_extreme(measured, False, known) == pytest.approx(sampled.min() - 2.0, rel=1e-9)


def test_the_error_without_a_closed_form_follows_from_scatter_and_count():
    # Student's t at 68.3 %: 1.84 for two values, near 1 for many
    assert error_of_mean([1.0, 3.0]) == pytest.approx(1.84, abs=0.01)
    many = np.tile([1.0, 3.0], 5000)
    assert error_of_mean(many) == pytest.approx(1.0 / 100.0, rel=0.01)
    assert error_of_extreme([1.0, 3.0, 2.0, 1.5], True) == pytest.approx(0.5)


def test_a_single_value_has_no_error_estimate():
    assert error_of_mean([1.0]) is None
    assert error_of_extreme([1.0], True) is None
    assert error_of_mean([1.0], ClosedForm(np.array([1.0]), np.array([1.0, 2.0]))) == pytest.approx(0.5)
    assert add_errors(1.0, None) is None
    assert add_errors(1.0, 2.0) == 3.0


@pytest.mark.parametrize("count", [2, 3, 6, 8])
@pytest.mark.parametrize("harmonics", [(1,), (2, 5), (1, 36)])
def test_the_error_of_a_mean_covers_what_sampling_leaves_out_of_ripples_most_of_the_time(count, harmonics):
    random = np.random.default_rng(3)
    covered = []
    for _ in range(400):
        phases = random.uniform(0.0, 2.0 * np.pi, len(harmonics))
        start = random.uniform(0.0, 2.0 * np.pi)
        angles = start + random.uniform(0.0, 2.0 * np.pi, count)
        values = sum(np.cos(k * angles + phase) for k, phase in zip(harmonics, phases, strict=True))
        covered.append(abs(values.mean()) <= error_of_mean(values))
    assert 0.6 < np.mean(covered) < 0.8


@pytest.mark.slow
def test_backlash_at_two_angles_agrees_with_a_turn_within_its_error():
    """The closed form stands for the simulation here: it differs from it by less than its scatter."""
    design = unlike("few")
    cranks = bench.crank_angles(Reducer(design), 2)
    turn = rigid_backlash.backlash_over_turn(Reducer(design))[1]
    known = ClosedForm(rigid_backlash.total_backlash(Reducer(design), cranks), turn)
    simulated = known.sampled * (1.0 + 1e-3)
    assert abs(simulated.mean() - turn.mean()) <= error_of_mean(simulated, known) + 1.1e-3 * turn.mean()
    assert error_of_mean(simulated, known) > 1e-3 * turn.mean()


def test_a_coarse_polygon_is_near_the_fine_one():
    design = unlike("few")
    cranks = np.linspace(0.0, 6.0, 7)
    fine, coarse = (
        rigid_backlash.total_backlash(Reducer(design), cranks),
        rigid_backlash.total_backlash(Reducer(design), cranks, rigid_backlash.COARSE_SIDES),
    )
    assert np.all((coarse >= fine * (1.0 - 1e-9)) & (coarse < fine * (1.0 + 1.6e-4)))
