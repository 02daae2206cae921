"""Load sharing of springs with clearance, against a root finder and closed forms."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from cycloid_mj.statics.load_sharing import protruding_forces, share_torque

CLEARANCE, ERROR = 2e-6, 1.5e-6


def test_springs_without_clearance_share_as_their_lever_arms() -> None:
    arms = np.array([[0.01, 0.02, 0.03]])
    forces, torsional = share_torque(arms, np.array([2.0]), np.array([1e8]), 0.0, np.array([5.0]))
    squares = 2.0 * float((arms**2).sum())
    assert torsional[0] == pytest.approx(1e8 * squares, rel=1e-12)
    assert forces[0] == pytest.approx(5.0 * arms[0] / squares, rel=1e-12)


def test_a_protruding_spring_carries_what_balances_the_torque_with_all_others() -> None:
    random = np.random.default_rng(4)
    arms = random.uniform(-0.01, 0.03, (20, 12))
    weights, stiffness = random.uniform(0.5, 3.0, 20), 10.0 ** random.uniform(7.0, 9.0, 20)
    torque = 10.0 ** random.uniform(-1.0, 2.0, 20)
    forces, _ = share_torque(arms, weights, stiffness, CLEARANCE, torque)
    protruding = protruding_forces(arms, weights, stiffness, CLEARANCE, torque, ERROR)

    def moment(turn: float, row: int, extra: int | None) -> float:
        pressed = np.maximum(turn * arms[row] - CLEARANCE, 0.0)
        alone = 0.0 if extra is None else arms[row, extra] * max(turn * arms[row, extra] - CLEARANCE + ERROR, 0.0)
        return float(stiffness[row] * (weights[row] * (arms[row] * pressed).sum() + alone) - torque[row])

    for row in range(len(arms)):
        turn = brentq(moment, 0.0, 1.0, args=(row, None), xtol=1e-16)
        assert forces[row] == pytest.approx(stiffness[row] * np.maximum(turn * arms[row] - CLEARANCE, 0.0), rel=1e-6)
        for column in np.flatnonzero(arms[row] > 0.0):
            turn = brentq(moment, 0.0, 1.0, args=(row, column), xtol=1e-16)
            force = stiffness[row] * max(turn * arms[row, column] - CLEARANCE + ERROR, 0.0)
            assert protruding[row, column] == pytest.approx(force, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("error", [ERROR, 2.0 * CLEARANCE])
def test_a_small_torque_is_carried_by_the_protruding_spring_alone(error: float) -> None:
    """A spring that protrudes by more than its clearance turns the part backwards, until it carries only the torque."""
    arms = np.array([[0.01, 0.02]])
    protruding = protruding_forces(arms, np.ones(1), np.array([1e8]), CLEARANCE, np.array([1e-3]), error)
    assert protruding[0, 1] == pytest.approx(1e-3 / 0.02, rel=1e-12)
    assert math.isclose(protruding[0, 0], 1e-3 / 0.01, rel_tol=1e-12)
