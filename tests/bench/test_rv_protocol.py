"""Standard test figures of an RV reducer: loops in simulations against statics, torques of the sun, notes."""

import json
from pathlib import Path

import numpy as np
import pytest
from rv_runs import COULOMB_RV80E

from cycloid_mj.bench.loop import measured_loop
from cycloid_mj.bench.loop_figures import loop_lost_motion, stiffness_between
from cycloid_mj.bench.protocol import INTERVALS, BenchFiles, compute_model_loop, protocol
from cycloid_mj.cli import main
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.rv import compute_rv_springs, solve_rv_loads

RV80E = RvReducer(COULOMB_RV80E)


def lines(reducer: Reducer) -> dict[str, float]:
    return {key: item.value for key, item in protocol(reducer, BenchFiles(), 784.0, angles=1).model.items()}


def test_loops_without_friction_have_the_stiffness_and_lost_motion_of_statics() -> None:
    """The rotation by statics along the torque of the loop, evaluated by the same functions."""
    friction = {"pin_gear": 0.0, "pin_socket": 0.0, "cam_rolling": 0.0}
    level = {"gravity_x": 0.0, "gravity_y": 0.0}
    reducer = RV80E.but(friction=friction, planet={"friction": 0.0}, environment=level)
    loop = compute_model_loop(reducer.working_at(784.0), 784.0, 0.0)
    torques = 784.0 * np.concatenate([np.linspace(-1.0, -0.002, 120), np.linspace(0.002, 1.0, 120)])
    turns = solve_rv_loads(compute_rv_springs(RV80E, np.zeros(len(torques))), torques).carrier_turn
    static = measured_loop("statics", loop.torque, np.degrees(np.interp(loop.torque, torques, turns)))
    for low, high in INTERVALS.values():
        measured, expected = (stiffness_between(item, low * 784.0, high * 784.0).value for item in (loop, static))
        assert measured == pytest.approx(expected, rel=2e-3)
    assert loop_lost_motion(loop, 784.0).value == pytest.approx(loop_lost_motion(static, 784.0).value, rel=2e-3)


def test_friction_widens_the_loop_and_the_law_film_has_torques_without_load() -> None:
    found = lines(RV80E)
    assert found["hysteresis_loss_arcmin"] > 0.02
    assert "running_torque_nm" not in found
    sheet = protocol(RV80E.but(friction={"law": "film"}), BenchFiles(), 784.0, angles=1)
    starting, running = (sheet.model[f"{name}_torque_nm"].value for name in ("starting", "running"))
    assert 0.0 < starting < running < 0.2
    assert "back_driving_torque_nm" not in sheet.model
    assert any("film friction" in note for note in sheet.notes)
    assert not any("Coulomb friction" in note for note in sheet.notes)


def test_the_transmission_error_is_that_of_a_displaced_bore() -> None:
    reducer = RV80E.but(crank_errors={"bore_x": (1e-5, 0.0, 0.0, 0.0, 0.0, 0.0)})
    # 11.4 arcsec from closed forms with rigid bearings and firm contact
    assert 4.0 < lines(reducer)["te_arcsec"] < 12.0


def test_the_command_evaluates_files_of_a_bench_and_names_the_sun(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    angle = np.linspace(0.0, 10.0, 200)
    start = tmp_path / "start.csv"
    rows = [
        f"{0.0 if torque < 0.3 else value:.4f},{torque:.4f}" for value, torque in zip(angle, 0.05 * angle, strict=True)
    ]
    start.write_text("\n".join(["crank_deg,torque_crank_Nm", *rows]))
    words = [
        "protocol",
        "rv80e",
        "--set",
        "friction.law=coulomb",
        "--angles",
        "1",
        "--starting",
        str(start),
        "--json",
        "--quiet",
    ]
    assert main(words) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["lines"]["starting_torque_nm"]["bench"]["value"] == pytest.approx(0.3, abs=0.01)
    assert result["lines"]["starting_torque_nm"]["model"] is None
    assert any("the sun" in note for note in result["notes"])
