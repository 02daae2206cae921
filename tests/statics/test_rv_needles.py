"""Crank bearings with a spring for each needle: against the lumped bearing, their own sums, and the planar solver."""

from pathlib import Path

import numpy as np
import pytest
from rv_runs import COULOMB_RV80E, FRICTIONLESS, static_loads

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.cli import main
from cycloid_mj.design import Design
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.dynamics.run import model_for, simulate
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv import compute_rv_springs, solve_rv_loads
from cycloid_mj.statics.rv_sheet import solve_rv_equilibrium
from cycloid_mj.statics.sheet import shaft_powers

RV80E = COULOMB_RV80E
LOOSE = {"needle_clearance": 5e-6}


def with_needles(**cranks: float) -> RvReducer:
    """`rv80e` with separate needles."""
    return RvReducer(RV80E.but(contact={"needles": "each"}, cranks=cranks))


def test_needles_without_clearance_are_as_stiff_as_the_lumped_bearing() -> None:
    """The squared cosines of an even number of needles on any half of the circle sum up to a quarter of it."""
    lumped, each = solve_rv_equilibrium(RvReducer(RV80E), 784.0, 61), solve_rv_equilibrium(with_needles(), 784.0, 61)
    np.testing.assert_allclose(each.cranks, lumped.cranks, atol=1e-6 * lumped.bearings.max())
    np.testing.assert_allclose(each.carrier_turn, lumped.carrier_turn, rtol=1e-6)


def test_an_odd_number_of_needles_is_stiffer_and_softer_in_turn() -> None:
    lumped, odd = (
        solve_rv_equilibrium(RvReducer(RV80E), 784.0, 61),
        solve_rv_equilibrium(with_needles(needles=5), 784.0, 61),
    )
    ratio = odd.carrier_turn / lumped.carrier_turn
    assert ratio.min() < 1.0 - 1e-4
    assert ratio.max() > 1.0 + 1e-4
    assert ratio.mean() == pytest.approx(1.0, rel=0.01)


@pytest.mark.parametrize("clearance", [5e-6, -5e-6], ids=["clearance", "preload"])
def test_crank_forces_are_sums_over_needles_in_a_rolling_cage(clearance: float) -> None:
    reducer = with_needles(needle_clearance=clearance)
    crank = np.array([0.3, 5.1])
    springs = compute_rv_springs(reducer, crank)
    loads = solve_rv_loads(springs, 784.0)
    displaced = springs.offset + np.einsum("mdnju,mu->mdnj", springs.offset_slope, loads.displacements)
    stiffness = 4.0 / 14.0 * reducer.bearing_stiffness
    for row, angle in enumerate(crank):
        disc = -angle / 39.0
        # the middle of a needle between raceways of 12 and 17 mm moves at the mean of both their speeds
        bore = 17e-3 + clearance
        cage = (12e-3 * angle + bore * disc) / (12e-3 + bore)
        total = np.zeros(2)
        for needle in range(14):
            turn = cage + 2.0 * np.pi * needle / 14.0
            direction = np.array([-np.sin(turn), np.cos(turn)])
            total += stiffness * max(displaced[row, 1, 2] @ direction - clearance, 0.0) * direction
        np.testing.assert_allclose(loads.cranks[row, 1, 2], total, rtol=1e-9)


def test_a_clearance_counts_more_than_in_the_lumped_bearing() -> None:
    """F = K (d - 4 c/pi) for d >> c: the needles beside the load close later, as their cosines average 2/pi."""
    reducers = RvReducer(RV80E), RvReducer(RV80E.but(cranks=LOOSE)), with_needles(**LOOSE)
    tight, lumped, each = (solve_rv_equilibrium(reducer, 784.0, 61).carrier_turn.mean() for reducer in reducers)
    assert (each - tight) / (lumped - tight) == pytest.approx(4.0 / np.pi, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("load", [784.0, 78.4])
@pytest.mark.parametrize("has_friction", [False, True])
def test_runs_with_separate_needles_are_those_of_statics(load: float, has_friction: bool) -> None:
    friction = {} if has_friction else FRICTIONLESS
    design = RV80E.but(drive={"ramp": 0.0, "hold": 0.16}, load={"torque": load}, ring={"pins": "fixed"})
    reducer = RvReducer(design.but(contact={"needles": "each"}, cranks=LOOSE).but(**friction))
    run = simulate(reducer.design, planar_model(reducer))
    run = run.select(run.time > 0.05)
    efficiency, run = mean_powers(run).efficiency, run.select(slice(0, None, 5))
    static = static_loads(reducer, run)
    error = run["output_angle"] - reducer.member.output_angle(run["sun_angle"])
    simulated = np.linalg.norm(run.forces("crank_bearing"), axis=2)
    assert error.mean() == pytest.approx(static.carrier_turn.mean(), rel=2e-3)
    assert simulated.mean() == pytest.approx(static.bearings.mean(), rel=3e-3)
    assert simulated.max() == pytest.approx(static.bearings.max(), rel=0.01)
    if has_friction:
        assert 100.0 * efficiency == pytest.approx(100.0 * shaft_powers(reducer, load).efficiency, abs=0.2)


def test_mujoco_refuses_the_option(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    separate: Design = with_needles().design
    with pytest.raises(DesignError, match="use --solver planar"):
        model_for("mujoco", RvReducer(separate))
    words = ["simulate", "rv80e", "--set", "contact.needles=each", "--out", str(tmp_path), "--quiet"]
    assert main(words) == 1
    assert "--solver planar" in capsys.readouterr().err
