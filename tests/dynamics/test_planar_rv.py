"""RV reducers by the planar solver: against statics, MuJoCo, closed form, its own energy and its own time step."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rv_runs import COULOMB_RV80E, FRICTIONLESS, static_loads

from cycloid_mj.analysis import analyze
from cycloid_mj.base.array import Array
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.base.record import Run
from cycloid_mj.base.units import ARCSECOND
from cycloid_mj.cli.app import main
from cycloid_mj.design.model import HEATED
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.dynamics.planar.rv_system import input_inertia, make_rv_system
from cycloid_mj.dynamics.planar.state import start_state
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.log import read
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.sheet import shaft_powers

HOLD, SETTLED = 0.26, 0.05
"""Duration of the runs, and time after which they are evaluated: two turns of the cranks [s]."""


def rv(load: float = 784.0, **changes: Any) -> RvReducer:
    """An RV-80E at full speed under a load [N m]."""
    design = COULOMB_RV80E.but(drive={"ramp": 0.0, "hold": HOLD}, load={"torque": load})
    return RvReducer(design.but(**changes))


def settled(reducer: RvReducer, timestep: float = 0.0) -> Run:
    run = simulate(reducer.design, planar_model(reducer, timestep=timestep))
    return run.select(run.time > SETTLED)


def output_error(reducer: RvReducer, run: Run) -> Array:
    return run["output_angle"] - reducer.member.output_angle(run["sun_angle"])


@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_inertia_of_all_parts_is_that_seen_from_the_sun(member: str) -> None:
    reducer = rv(output={"member": member}, ring={"pins": "fixed"})
    system = make_rv_system(reducer)
    _, speeds = start_state(reducer, 0.7, 3.0)
    assert np.sum(system.inertia * speeds**2) == pytest.approx(input_inertia(reducer) * 3.0**2, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("load", [784.0, 78.4])
@pytest.mark.parametrize(
    "changes",
    [
        pytest.param({}, id="preset"),
        pytest.param({"output": {"member": "ring"}}, id="ring"),
        pytest.param({"cranks": {"needle_clearance": 5e-6}}, id="clearance"),
        pytest.param({"cranks": {"needle_clearance": -6e-5}}, id="preload"),
        pytest.param({"cranks": {"count": 2}}, id="two cranks"),
        pytest.param({"planet": {"friction": 0.0, "sun_support": "fixed", "backlash": 2e-5}}, id="fixed sun"),
        pytest.param({"drive": {"ramp": 0.0, "hold": HOLD, "speed": -240.0}}, id="backwards"),
    ],
)
def test_forces_and_wind_up_without_friction_are_those_of_statics(load: float, changes: dict[str, Any]) -> None:
    """Statics has neither weight nor inertia: 1 % of the largest force at a tenth of the load."""
    reducer = rv(load, **(FRICTIONLESS | changes))
    run = settled(reducer).select(slice(0, None, 10))
    static = static_loads(reducer, run)
    turn = (-reducer.share if reducer.design.output.turns_ring else 1.0) * static.carrier_turn
    assert output_error(reducer, run).mean() == pytest.approx(turn.mean(), rel=2e-3)
    bearings = static.bearings.reshape(len(run), -1)
    simulated = np.linalg.norm(run.forces("crank_bearing"), axis=2)
    np.testing.assert_allclose(simulated, bearings, atol=(5e-3 if load > 100.0 else 1.5e-2) * bearings.max())
    assert simulated.mean() == pytest.approx(bearings.mean(), rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    "error",
    [
        {"bore_x": (1e-5, 0.0, 0.0, 0.0, 0.0, 0.0)},
        {"eccentric_radial": (1e-5, 0.0, 0.0, 0.0, 0.0, 0.0)},
        {"eccentric_tangential": (1e-5, 0.0, 0.0, 0.0, 0.0, 0.0)},
    ],
    ids=lambda error: next(iter(error)),
)
def test_transmission_error_of_part_errors_is_that_of_statics(error: dict[str, tuple[float, ...]]) -> None:
    reducer = rv(crank_errors=error, **FRICTIONLESS)
    run = settled(reducer).select(slice(0, None, 5))
    static = static_loads(reducer, run).carrier_turn
    assert np.ptp(static) > 10.0 * ARCSECOND
    assert np.ptp(output_error(reducer, run)) == pytest.approx(np.ptp(static), rel=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [240.0, -240.0])
@pytest.mark.parametrize("load", [784.0, 78.4])
def test_running_drives_have_the_figures_of_statics_with_friction(load: float, speed: float) -> None:
    """Transmission error of a bore error of 10 um, wind-up, crank forces and efficiency."""
    drive = {"ramp": 0.0, "hold": HOLD, "speed": speed}
    reducer = rv(load, crank_errors={"bore_x": (0.0, 1e-5, 0.0, 0.0, 0.0, 0.0)}, drive=drive)
    run = settled(reducer)
    efficiency = mean_powers(run).efficiency
    run = run.select(slice(0, None, 5))
    error, forces, static = output_error(reducer, run), run.forces("crank_bearing"), static_loads(reducer, run)
    simulated = np.linalg.norm(forces, axis=2)
    assert np.ptp(static.carrier_turn) > 10.0 * ARCSECOND
    assert np.ptp(error) == pytest.approx(np.ptp(static.carrier_turn), rel=5e-3)
    assert error.mean() == pytest.approx(static.carrier_turn.mean(), rel=2e-3)
    assert simulated.mean() == pytest.approx(static.bearings.mean(), rel=2e-3)
    assert simulated.max() == pytest.approx(static.bearings.max(), rel=5e-3)
    assert 100.0 * efficiency == pytest.approx(100.0 * shaft_powers(reducer, load).efficiency, abs=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("temperature", [20.0, 40.0, 60.0])
@pytest.mark.parametrize("speed", [240.0, 120.0, 60.0])
@pytest.mark.parametrize("pins", ["free", "fixed"])
@pytest.mark.parametrize("load", [784.0, 392.0, 78.4])
def test_efficiency_with_film_friction_is_that_of_statics(
    load: float, pins: str, speed: float, temperature: float
) -> None:
    drive = {"ramp": 0.0, "hold": HOLD * 240.0 / speed, "speed": speed}
    thermal = dict.fromkeys(HEATED, temperature)
    reducer = rv(load, drive=drive, ring={"pins": pins}, friction={"law": "film"}, thermal=thermal)
    run = simulate(reducer.design, planar_model(reducer))
    powers = mean_powers(run.select(run.time > SETTLED * 240.0 / speed))
    assert 100.0 * powers.efficiency == pytest.approx(100.0 * shaft_powers(reducer, load).efficiency, abs=0.2)


@pytest.mark.parametrize("pins", ["free", "massless"])
@pytest.mark.parametrize("load", [784.0, 78.4])
def test_pins_that_both_discs_press_have_the_efficiency_of_statics(load: float, pins: str) -> None:
    """Discs at 40 °C in a ring at 20 °C preload the teeth: pins that cannot tilt miss it by 0.5 and 2.4 points."""
    reducer = rv(load, ring={"pins": pins}, friction={"law": "film"}, thermal={"disc": 40.0})
    efficiency = mean_powers(settled(reducer)).efficiency
    assert 100.0 * efficiency == pytest.approx(100.0 * shaft_powers(reducer, load).efficiency, abs=0.2)


def test_pins_that_three_discs_press_are_reported() -> None:
    """They do not tilt; those of two discs do, and massless pins have a seat for each disc."""
    three = rv(thermal={"disc": 40.0}, gear={"discs": 3})
    (text,) = (text for text in planar_model(three).warnings if text.startswith("ring.pins"))
    assert "set ring.pins to massless" in text
    for other in (rv(), rv(thermal={"disc": 40.0}), three.but(ring={"pins": "massless"})):
        assert not any(text.startswith("ring.pins") for text in planar_model(other).warnings)


@pytest.mark.slow
@pytest.mark.parametrize("pins", ["free", "fixed"])
@pytest.mark.parametrize("load", [784.0, 78.4])
def test_energy_balance_closes_and_the_ratio_is_that_of_the_teeth(load: float, pins: str) -> None:
    run = settled(rv(load, ring={"pins": pins}))
    powers = mean_powers(run)
    assert powers.residual == pytest.approx(0.0, abs=1e-5)
    assert np.ptp(run["sun_angle"]) / np.ptp(run["output_angle"]) == pytest.approx(153.0, rel=1e-6)


@pytest.mark.slow
def test_half_the_step_has_the_same_forces_and_losses() -> None:
    reducer = rv(crank_errors={"bore_x": (1e-5, 0.0, 0.0, 0.0, 0.0, 0.0)})
    figures = []
    for timestep in (0.0, 0.5 * planar_model(reducer).timestep):
        run = settled(reducer, timestep)
        forces = np.linalg.norm(run.forces("crank_bearing"), axis=2)
        error = output_error(reducer, run)
        figures.append([forces.mean(), forces.max(), error.mean(), np.ptp(error), mean_powers(run).efficiency])
    np.testing.assert_allclose(figures[0], figures[1], rtol=1e-3)


@pytest.mark.slow
def test_planar_solver_and_mujoco_agree() -> None:
    reducer = rv(drive={"ramp": 0.0, "hold": 0.03}, ring={"pins": "fixed"}).but(load={"rise": 0.004})
    means = []
    for model in (planar_model(reducer), build(reducer.design)):
        run = simulate(reducer.design, model)
        late = run.select(run.time > 0.02)
        forces = np.linalg.norm(late.forces("crank_bearing"), axis=2)
        means.append([output_error(reducer, late).mean(), forces.mean(), forces.max(), mean_powers(late).efficiency])
    np.testing.assert_allclose(means[0], means[1], rtol=5e-3)


@pytest.mark.slow
def test_simulate_writes_a_log_that_analyze_reads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ("--design", "rv80e", "--solver", "planar", "--ramp-s", "0", "--hold-s", "0.15")
    words += ("--set", "friction.law=coulomb")
    assert main(["simulate", *words, "--json", "--quiet", "--out", "."]) == 0
    findings = json.loads(capsys.readouterr().out)
    assert findings["driven_shaft"] == "sun"
    assert findings["crank"]["speed_rad_s"] / findings["output_speed"]["mean_rad_s"] == pytest.approx(153.0, rel=1e-5)
    assert findings["efficiency"] == pytest.approx(0.888, abs=0.002)
    run = read("rv80e.mcap")
    assert run.provenance["solver"] == "planar"
    columns = ("sun_angle", "sun_torque", "crank_3_angle", "gear_2_angle", "output_speed", "gear_1_crank_1_force_x")
    assert set(columns) <= set(run.columns)
    assert analyze(run).crank_bearings is not None
    assert main(["analyze", "rv80e.mcap"]) == 0
    assert main(["report", "rv80e.mcap", "--out", "page.html"]) == 0
    assert "sun torque, mean" in Path("page.html").read_text()
