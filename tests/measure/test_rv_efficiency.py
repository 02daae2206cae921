"""Efficiency, torque and losses of RV reducers in simulations, compared with closed forms and statics."""

import numpy as np
import pytest
from rv_runs import COULOMB_RV80E

from cycloid_mj.measure import efficiency, torque
from cycloid_mj.measure.back_driving import break_away
from cycloid_mj.measure.closed_form import IDEAL_LOSSES, ideal_efficiency, ideal_limit
from cycloid_mj.measure.efficiency_map import OperatingPoint, run_backward, run_forward
from cycloid_mj.measure.loss_breakdown import loss_shares
from cycloid_mj.measure.sensitivity import friction_variants, with_common_friction
from cycloid_mj.measure.steady import averaging_periods, steady_design
from cycloid_mj.measure.torque import rated_test
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.statics.sheet import shaft_powers, solve_back_driving

RV80E = steady_design(reducer_of(COULOMB_RV80E))
RING = RV80E.but(output={"member": "ring"})
LOAD = 784.0
PERIODS = 12


def run(reducer: Reducer) -> OperatingPoint:
    return run_forward(reducer, LOAD, reducer.design.drive.speed, PERIODS, "planar")


@pytest.mark.parametrize("reducer", [RV80E, RING], ids=["carrier", "ring"])
def test_efficiency_and_losses_of_the_ideal_limit_are_those_of_the_closed_form(reducer: Reducer) -> None:
    powers = run(ideal_limit(reducer)).powers
    closed = ideal_efficiency(reducer, LOAD).efficiency
    assert powers.efficiency == pytest.approx(closed, abs=1e-3)
    crank = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)
    carrier_power = reducer.share * powers.delivered
    closed_losses = IDEAL_LOSSES["rv"](reducer, crank)
    for kind, loss in zip(("pin_gear", "crank_bearing", "planet_mesh"), closed_losses, strict=True):
        assert powers.friction[kind] / carrier_power == pytest.approx(loss, rel=0.015), kind
    more = reducer.but(friction={"pin_gear": 0.06, "pin_socket": 0.06})
    assert closed - ideal_efficiency(more, LOAD).efficiency > 0.01


def test_efficiency_in_both_directions_is_that_of_statics() -> None:
    forward = run(RV80E).powers
    backward = run_backward(RV80E, RV80E.design.drive.torque, PERIODS, "planar").powers
    statics, (static_backward, _) = shaft_powers(RV80E, LOAD), solve_back_driving(RV80E, LOAD)
    assert forward.efficiency == pytest.approx(statics.efficiency, abs=1.5e-3)
    assert backward.efficiency == pytest.approx(static_backward.efficiency, abs=1.5e-3)
    assert abs(forward.residual) < 1e-5
    shares, names = loss_shares(forward), ("teeth", "crank bearings", "planets")
    assert 1.0 - forward.efficiency == pytest.approx(sum(shares.values()), abs=1e-5)
    for name in names:
        assert shares[name] == pytest.approx(statics.friction[name] / statics.supplied, rel=0.02), name


def test_output_torque_under_the_rated_torque_of_the_sun_is_that_of_statics() -> None:
    braked = rated_test(RV80E, averaging_periods(RV80E, PERIODS))
    assert braked.input == pytest.approx(LOAD / 153.0, rel=1e-4)
    assert braked.output == pytest.approx(LOAD * shaft_powers(RV80E, LOAD).efficiency, rel=1.5e-3)
    assert braked.output == pytest.approx(LOAD * braked.powers.efficiency, rel=1e-4)


def test_window_covers_whole_periods_of_the_cranks() -> None:
    """A mesh period is a 39th of a turn of the cranks against the carrier, so 13 are a third of it."""
    assert averaging_periods(RV80E, 13) == 13
    assert averaging_periods(RV80E, 15) == 25
    # without load, the weight of the discs matters
    assert averaging_periods(RV80E, 13, 0.0) == 80


def test_friction_variants_include_planets_and_crank_bearings() -> None:
    by_pair = {(row.pair, row.friction): row.design for row in friction_variants(RV80E)}
    assert by_pair["planet_mesh", 0.1].planet.friction == 0.1
    assert by_pair["planet_mesh", 0.1].friction == RV80E.design.friction
    assert by_pair["crank_bearing, rolling", 0.003].friction.cam_rolling == 0.003
    common = with_common_friction(RV80E, 0.02).design
    assert (common.planet.friction, common.friction.pin_gear, common.friction.pin_socket) == (0.02, 0.02, 0.02)


def test_a_free_sun_turns_from_rest_under_a_small_torque() -> None:
    start = break_away(RV80E.but(environment={"gravity_y": 0.0}))
    assert not start.is_locked
    assert len(start.starts) == 1
    assert abs(start.torque) < 1e-3 * LOAD


@pytest.mark.slow
def test_measures_have_the_figures_of_the_sun() -> None:
    measured = efficiency(COULOMB_RV80E, quick=True)
    assert measured.quantities["efficiency_ideal_limit"].value == pytest.approx(
        measured.quantities["efficiency_ideal_limit"].reference, abs=0.1
    )
    assert "sun" in measured.quantities["no_load_torque"].name
    assert measured["back_driving_torque_rated"] == pytest.approx(LOAD / (1e-2 * measured["back_driving_efficiency"]))
    braked = torque(COULOMB_RV80E, quick=True)
    assert braked["efficiency_crank_held"] == pytest.approx(braked["efficiency"], abs=0.02)
    assert braked["efficiency"] == pytest.approx(measured["efficiency"], abs=0.05)
