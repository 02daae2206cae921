"""Heat of an RV reducer: expansion, preload of the teeth, and the thermal network."""

import math

import numpy as np
import pytest
from rv_runs import COULOMB_RV80E, static_loads

from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS
from cycloid_mj.design.model import HEATED
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.geometry.expansion import at_temperatures, expand, jam_difference, tooth_play
from cycloid_mj.life import rate
from cycloid_mj.life.checks import check_design
from cycloid_mj.life.duty import DutyPoint, constant_duty
from cycloid_mj.life.heat import heat_transfer_coefficient
from cycloid_mj.life.rv_thermal import solve_rv_losses
from cycloid_mj.life.thermal import thermal
from cycloid_mj.life.thermal_network import heat_by_node, heat_capacities
from cycloid_mj.measure.efficiency_map import run_forward
from cycloid_mj.measure.steady import steady_design
from cycloid_mj.parts.export.rv_assembly import rv_mass
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.rv_preload import preload_share
from cycloid_mj.statics.rv_sheet import friction_powers, rv_powers

RV80E = COULOMB_RV80E
FEW_ANGLES = 31


def _at(**temperatures: float) -> dict[str, float]:
    return dict.fromkeys(HEATED, 20.0) | temperatures


def test_equal_temperatures_of_equal_materials_change_no_clearance() -> None:
    warm = expand(at_temperatures(RV80E, dict.fromkeys(HEATED, 70.0)))
    assert warm.clearance == RV80E.clearance
    assert warm.modification.pin_circle == pytest.approx(0.0, abs=1e-15)
    assert warm.modification.equidistant == pytest.approx(0.0, abs=1e-15)
    assert warm.cranks is not None
    assert warm.cranks.needle_clearance == pytest.approx(0.0, abs=1e-15)


def test_a_warm_disc_grows_towards_the_pins_and_moves_its_bores() -> None:
    hot = at_temperatures(RV80E, _at(disc=30.0))
    growth = RV80E.material.expansion * 10.0
    warm, ring = expand(hot), RV80E.ring
    assert tooth_play(hot) == pytest.approx(0.2e-6 - growth * (ring.pin_circle_radius - ring.pin_radius), abs=1e-9)
    assert jam_difference(RV80E) == pytest.approx(10.0 * 0.2e-6 / (growth * 73.5e-3), rel=1e-9)
    assert warm.modification.pin_circle == pytest.approx(growth * ring.pin_circle_radius)
    assert warm.modification.equidistant == pytest.approx(growth * ring.pin_radius, rel=1e-3)
    assert warm.crank_errors is not None
    assert warm.cranks is not None
    bores = np.stack([warm.crank_errors.bore_x, warm.crank_errors.bore_y], axis=-1)
    assert np.linalg.norm(bores, axis=-1) == pytest.approx(np.full(6, growth * 42e-3))
    assert bores[0] == pytest.approx([0.0, growth * 42e-3], abs=1e-12)
    assert warm.crank_errors.eccentric_radial == pytest.approx((-growth * 1.5e-3,) * 6)
    assert warm.cranks.needle_clearance == pytest.approx(growth * 17e-3)


def test_the_housing_takes_most_of_an_interference() -> None:
    """Thick-walled ring by Lame: 17 % stiffer than the thin one, which takes 64 % of the interference of `rv80e`."""
    reducer = RvReducer(RV80E)
    share = preload_share(reducer)
    assert share == pytest.approx(0.19, abs=0.01)
    modulus, poisson = RV80E.material.youngs_modulus, RV80E.material.poisson
    inner, outer, width = RV80E.ring_root_radius, RV80E.housing.outer_radius, RV80E.gear.stack_width
    pressure = 80.0 / (2.0 * math.pi * inner * width)
    squares = (outer**2 + inner**2) / (outer**2 - inner**2)
    lame = pressure * inner / modulus * (squares + poisson)
    disc = 0.7 * 40.0 / (2.0 * math.pi * 15e-3 * modulus)
    assert share == pytest.approx(1.0 / (1.0 + 3e8 * (lame + disc)), rel=0.25)
    hot = _at(disc=30.0)
    relief = reducer.at_temperatures(hot).design.modification.equidistant
    relief -= expand(at_temperatures(RV80E, hot)).modification.equidistant
    assert relief == pytest.approx((1.0 - share) * -tooth_play(at_temperatures(RV80E, hot)), rel=1e-2)


@pytest.mark.parametrize("member", ["carrier", "ring"])
@pytest.mark.parametrize("temperatures", [{"disc": 40.0}, {"ring": 40.0, "housing": 40.0}], ids=["disc", "ring"])
def test_runs_with_temperatures_by_part_agree_with_statics(temperatures: dict[str, float], member: str) -> None:
    """Discs 20 K warmer than the ring are pressed against the pins; in a warmer ring, the teeth have clearance."""
    warm = RV80E.but(thermal=temperatures, ring={"pins": "fixed"}, output={"member": member}, load={"torque": 784.0})
    reducer = steady_design(RvReducer(warm))
    point = run_forward(reducer, 784.0, reducer.design.drive.speed, 13, "planar")
    assert point.powers.efficiency == pytest.approx(rv_powers(reducer, 784.0).efficiency, abs=1.5e-3)
    run = point.run.select(slice(0, None, 50))
    static = static_loads(point.reducer, run)
    turn = (-reducer.share if member == "ring" else 1.0) * static.carrier_turn
    error = run["output_angle"] - reducer.member.output_angle(run["sun_angle"])
    assert error.mean() == pytest.approx(turn.mean(), rel=3e-3)
    simulated = np.linalg.norm(run.forces("crank_bearing"), axis=2)
    np.testing.assert_allclose(simulated, static.bearings.reshape(len(run), -1), atol=0.01 * static.bearings.max())
    play = tooth_play(at_temperatures(RV80E, temperatures))
    assert (play < 0.0) == ("disc" in temperatures)
    cold = rv_powers(RvReducer(RV80E.but(ring={"pins": "fixed"}, output={"member": member})), 784.0)
    assert (point.powers.efficiency < cold.efficiency) == (play < 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["planar", "mujoco"])
@pytest.mark.parametrize("discs", [1, 2])
@pytest.mark.parametrize("torque", [784.0, 78.4])
def test_runs_with_free_pins_that_warm_discs_press_agree_with_statics(
    torque: float, discs: int, solver: Solver
) -> None:
    """With two discs, pins tilt: without tilt, the differences are 0.3 points at 784 N m and 2.5 at 78.4 N m."""
    warm = RV80E.but(thermal={"disc": 40.0}, load={"torque": torque}, gear={"discs": discs})
    reducer = steady_design(RvReducer(warm))
    point = run_forward(reducer, torque, reducer.design.drive.speed, 20, solver)
    assert abs(100.0 * (point.powers.efficiency - rv_powers(reducer, torque).efficiency)) < 0.2


def test_losses_at_20_degrees_are_those_of_statics_and_a_hot_disc_adds_friction_of_its_teeth() -> None:
    reducer, point = RvReducer(RV80E), DutyPoint(784.0, RV80E.drive.speed, 1.0)
    (cold,), network = solve_rv_losses(reducer, [point], _at(), FEW_ANGLES)
    assert cold == friction_powers(reducer, 784.0, FEW_ANGLES)
    (warm,), _ = solve_rv_losses(reducer, [point], _at(disc=30.0), FEW_ANGLES)
    assert warm["teeth"] > 1.3 * cold["teeth"]
    heat = heat_by_node(reducer, cold)
    assert sum(heat.values()) == pytest.approx(sum(cold.values()))
    assert network.heat_to_air(network.rises(heat)) == pytest.approx(sum(cold.values()))
    assert sum(heat_capacities(reducer).values()) == pytest.approx(1.01 * 470.0 * rv_mass(reducer), rel=1e-6)


def test_heat_of_the_network_equals_the_losses_with_film_friction() -> None:
    lubricated = RvReducer(RV80E.but(friction={"law": "film"}))
    point = DutyPoint(784.0, RV80E.drive.speed, 1.0)
    (cold,), network = solve_rv_losses(lubricated, [point], _at(), FEW_ANGLES)
    heat = heat_by_node(lubricated, cold)
    assert sum(heat.values()) == pytest.approx(sum(cold.values()), rel=1e-9)
    assert network.heat_to_air(network.rises(heat)) == pytest.approx(sum(cold.values()), rel=1e-9)
    hot, _ = solve_rv_losses(lubricated, [point], dict.fromkeys(HEATED, 60.0), FEW_ANGLES)
    assert sum(hot[0].values()) < 0.8 * sum(cold.values())


@pytest.mark.slow
def test_the_case_stays_below_60_degrees_at_the_rated_torque_on_a_robot() -> None:
    """60 W/(m2 K) stand for the arm that cools the case; the makers' manuals limit it to 60 °C."""
    cooled = RV80E.but(service={"film_coefficient": 60.0})
    state = thermal(cooled, constant_duty(784.0, RV80E.drive.speed))
    assert state.converged
    assert 40.0 < state.temperatures["housing"] < 60.0
    assert state.play < 0.0
    assert not state.jams
    assert state.torque > 784.0
    alone = thermal(RV80E, constant_duty(100.0, RV80E.drive.speed))
    assert set(alone.as_json()) == set(thermal(PRESETS["pin"]).as_json())


@pytest.mark.slow
def test_the_command_warns_of_the_preload(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["thermal", "rv80e", "--load-nm", "100"]) == 0
    assert "expand by" in capsys.readouterr().out


def test_heat_limits_the_rating_under_continuous_load_only() -> None:
    """`service.duty_share` is that of the rating: losses, and nearly the temperature rise, are in proportion to it."""
    continuous, paused = (
        rate(RV80E.but(service={"duty_share": share}), compliance=True).items["temperature"] for share in (1.0, 0.4)
    )
    assert continuous.safety is not None
    assert paused.safety is not None
    assert continuous.safety < 1.0 < paused.safety
    assert continuous.value - 20.0 == pytest.approx(2.5 * (paused.value - 20.0), rel=0.15)
    assert continuous.limit == RV80E.service.grease_temperature
    assert [item.name for item in check_design(RV80E).warnings] == ["heat"]


def test_the_note_on_the_housing_states_its_heat_transfer_coefficient_once() -> None:
    """Without a coefficient of the design, it is that of ISO/TR 14179-2 at the temperature of the housing."""
    uncooled = RV80E.but(service={"film_coefficient": 0.0})
    item = rate(uncooled, compliance=True).items["temperature"]
    coefficient = heat_transfer_coefficient(RvReducer(uncooled), item.value)
    assert coefficient > 5.0
    assert f"h = {coefficient:.3g} W/(m2 K)" in item.note
    assert item.note.count("ambient 20 °C") == 1
