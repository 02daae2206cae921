"""A locked crank under a slow torque: springs behind a play, and friction beside them that remembers."""

import numpy as np
import pytest
from designs import UNLIKE, unlike

from cycloid_mj.design import Design, resolve
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import loads, springs_of
from cycloid_mj.statics.locked import (
    ELEMENTS,
    LockedCurve,
    SlipElements,
    follow_locked_path,
    load_friction,
    locked_branches,
    slip_elements,
    solve_locked_curve,
)

SPRING = LockedCurve(np.array([-1.0, 1.0]), np.array([-0.01, 0.01]))
"""100 N m/rad, without a play."""


@pytest.mark.parametrize("name", ["printed", *UNLIKE])
def test_without_friction_the_turn_is_that_of_the_balance(name: str) -> None:
    design = unlike(name) if name in UNLIKE else resolve(name)
    design = design.but(environment={"gravity_x": 0.0, "gravity_y": 0.0}, drive={"speed": 0.0})
    reducer, torque = Reducer(design), np.array([0.7, -0.3]) * design.rated_torque
    curve = solve_locked_curve(reducer, design.rated_torque, 0.3)
    springs = springs_of(reducer, [0.3], friction=False)
    turn = follow_locked_path(curve, slip_elements(reducer), torque)
    expected = [loads(reducer, springs, one).output_turn[0] for one in torque.tolist()]
    assert turn == pytest.approx(expected, rel=0.02)


def test_compliance_behind_the_contacts_adds_to_the_rotation() -> None:
    design = Design(structure="springs")
    soft = design.but(springs={"housing": 1e4})
    turns = [solve_locked_curve(Reducer(one), 100.0, 0.0).turn[-1] for one in (design, soft)]
    reducer = Reducer(soft)
    expected = loads(reducer, springs_of(reducer, [0.0], friction=False), 128.0).output_turn[0]
    assert turns[1] == pytest.approx(expected, rel=1e-3)
    assert turns[1] > 2.0 * turns[0]


def test_elements_share_the_friction_and_slip_over_its_travel() -> None:
    design = resolve("printed").but(springs={"friction": 3.0, "friction_travel": 1e-3})
    elements = slip_elements(Reducer(design))
    assert len(elements.limits) == ELEMENTS
    assert elements.limits.sum() == pytest.approx(3.0)
    slip = elements.limits / elements.stiffness
    assert 0.2e-3 < slip.min() < 2e-3 < slip.max() < 5e-3
    assert not slip_elements(Reducer(resolve("printed"))).limits.size


def test_a_loop_dissipates_the_work_of_its_friction() -> None:
    """Friction that acts at once takes twice its torque times the turn from one end to the other."""
    elements = SlipElements(np.array([2.0]), np.array([2e5]))
    torque = np.concatenate([np.linspace(0, 20, 300), np.linspace(20, -20, 600), np.linspace(-20, 20, 600)])
    turn = follow_locked_path(SPRING, elements, torque)
    work = abs(float(np.trapezoid(turn[300:], torque[300:])))
    assert work == pytest.approx(2.0 * 2.0 * float(np.ptp(turn[300:])), rel=0.02)


def test_a_small_loop_inside_is_forgotten_once_it_closes() -> None:
    elements = SlipElements(np.array([2.0, 1.0]), np.array([2e3, 300.0]))
    plain = follow_locked_path(SPRING, elements, np.array([20.0, -20.0, 20.0]))
    nested = follow_locked_path(SPRING, elements, np.array([20.0, -20.0, 10.0, 4.0, 10.0, 20.0]))
    assert nested[-1] == pytest.approx(plain[-1], rel=1e-9)
    assert nested[4] == pytest.approx(nested[2], rel=1e-9)


def test_equal_neighbours_of_a_path_do_not_change_its_rotation() -> None:
    elements = SlipElements(np.array([2.0, 1.0]), np.array([2e3, 300.0]))
    torque = np.array([5.0, 20.0, -3.0, 12.0])
    with_pauses = np.array([0.0, 5.0, 5.0, 20.0, 20.0, 20.0, -3.0, 12.0, 12.0])
    expected = follow_locked_path(SPRING, elements, torque)
    rotation = follow_locked_path(SPRING, elements, with_pauses)
    assert rotation == pytest.approx(np.concatenate([[0.0], np.repeat(expected, [2, 3, 1, 2])]), rel=1e-12, abs=1e-15)


def test_points_that_turn_back_are_left_out_of_a_curve() -> None:
    curve = LockedCurve(np.array([-2.0, -1.0, 0.0, 1.0, 2.0]), np.array([0.0, 2e-3, 1e-3, 1.5e-3, 3e-3]))
    none = SlipElements(np.zeros(0), np.zeros(0))
    (torque, rotation), *_ = locked_branches(curve, none, [-2.0, 2.0])
    assert rotation.tolist() == [0.0, 2e-3, 3e-3]
    assert torque.tolist() == [-2.0, -1.0, 2.0]


def test_load_friction_has_a_slope_each_way_in_proportion_to_the_load() -> None:
    """T = K x (1 + mu) while the torque grows and K x (1 - mu) while it falls, and the branches meet at no torque."""
    none = SlipElements(np.zeros(0), np.zeros(0))
    share, most = 0.3, 10.0
    branches = locked_branches(SPRING, none, [0.0, -most, most, -most], load_friction(share, 1e-5))
    for (torque, turn), way in zip(branches[1:], (1.0, -1.0), strict=True):
        for level, slope in ((-5.0, 100.0 * (1.0 + way * -share)), (5.0, 100.0 * (1.0 + way * share))):
            order = np.argsort(torque)
            assert np.interp(level, torque[order], turn[order]) == pytest.approx(level / slope, rel=1e-3)
