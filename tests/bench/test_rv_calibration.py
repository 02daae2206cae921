"""Calibration of RV reducers: values of a drive from its loops, simulated by another method."""

import json
from pathlib import Path

import numpy as np
import pytest
from rv_runs import COULOMB_RV80E

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.units import DEGREE
from cycloid_mj.bench import MeasuredLoop, calibrate, compare_losses, measured_loop
from cycloid_mj.bench.protocol import compute_model_loop
from cycloid_mj.cli import main
from cycloid_mj.design import Design, dump, load, loads
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.locked import SlipElements, locked_branches, solve_locked_curve
from cycloid_mj.statics.rv import compute_rv_springs, solve_rv_loads

RV80E = COULOMB_RV80E
CRANKS = RvReducer(RV80E).cranks
SOFT = {"needle_stiffness": 0.8 * CRANKS.needle_stiffness, "taper_stiffness": 0.8 * CRANKS.taper_stiffness}
DRIVE = RV80E.but(cranks=SOFT, clearance={"pin_gear": 1.5e-6, "pin_socket": 1.5e-6})
"""A drive with softer crank bearings and 3 um of play between disc and ring."""


def loop_of_statics(design: Design, drag: float) -> MeasuredLoop:
    """A loop of the design at +-784 N m with constant friction [N m] that is fully developed after 1e-6 rad."""
    curve = solve_locked_curve(RvReducer(design), 784.0, 0.0)
    elements = SlipElements(np.array([drag]), np.array([drag / 1e-6]))
    branches = locked_branches(curve, elements, [0.0, -784.0, 784.0, -784.0, 784.0])[1:]
    torque, turn = (np.concatenate([branch[axis] for branch in branches]) for axis in (0, 1))
    fine = np.linspace(0.0, len(torque) - 1.0, 600)
    index = np.arange(len(torque))
    return measured_loop("statics", np.interp(fine, index, torque), np.interp(fine, index, turn) / DEGREE)


@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_the_curve_of_a_locked_sun_is_that_of_statics(member: str) -> None:
    reducer = RvReducer(DRIVE.but(output={"member": member}))
    curve = solve_locked_curve(reducer, 784.0, 0.3)
    springs = compute_rv_springs(reducer, np.full(2, 0.3))
    turns = reducer.share * solve_rv_loads(springs, reducer.share * np.array([-512.0, 512.0])).carrier_turn
    np.testing.assert_allclose(np.interp([-512.0, 512.0], curve.torque, curve.turn), turns, rtol=1e-6)
    without_torque = np.interp([-1e-3, 1e-3], curve.torque, curve.turn)
    # 6.8 arcsec of the output per micrometre of play, on both sides together
    assert np.ptp(without_torque) * 648000.0 / np.pi == pytest.approx(3.0 * 6.8, rel=0.15)
    assert np.all(np.diff(curve.turn) > 0.0)


def test_drag_of_a_loop_becomes_the_drag_of_the_output() -> None:
    calibration = calibrate(RV80E, [loop_of_statics(DRIVE, 12.0)], ("play", "bearing_stiffness", "drag", "drag_travel"))
    values = {key: item.value for key, item in calibration.estimates.items()}
    assert values["bearing_stiffness"] == pytest.approx(0.8, rel=0.01)  # the shortest travel is 1 % of the height
    assert values["play"] == pytest.approx(3.0, abs=0.3)
    assert values["drag"] == pytest.approx(12.0, rel=0.05)
    written = loads(dump(calibration.design), "calibrated")
    assert written.drag.output == pytest.approx(values["drag"])
    cranks = RvReducer(written).cranks
    assert cranks.taper_stiffness == pytest.approx(values["bearing_stiffness"] * CRANKS.taper_stiffness)
    assert "springs" not in dump(calibration.design)


@pytest.mark.slow
def test_values_of_a_simulated_loop_come_back() -> None:
    """The loop is simulated by the planar solver, with friction in all contacts, which the default model does not have.

    That model does not identify the stiffness: its hysteresis and stiffness compensate each other. The Bayesian
    criterion prefers friction in proportion to the torque, with which the values are those of the drive. Its share is
    half of the loop's width over its deflection, 1.5 %.
    """
    loop = compute_model_loop(RvReducer(DRIVE).working_at(784.0), 784.0, 0.0)
    calibration = calibrate(RV80E, [loop])
    assert calibration.rms < 0.015 * loop.height
    assert not calibration.estimates["bearing_stiffness"].identified
    preferred = calibration.preferred
    assert preferred is not None
    assert preferred.key == "load"
    assert preferred.values["bearing_stiffness"] == pytest.approx(0.8, rel=0.01)
    assert preferred.values["play"] == pytest.approx(3.0, abs=0.3)
    assert preferred.values["load_friction"] == pytest.approx(0.015, rel=0.1)
    with pytest.raises(UsageError, match="remove --losses"):
        compare_losses(calibration)


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        (("play", "friction"), "friction cannot be fitted for an RV reducer"),
        (("structure_stiffness",), "Choose from play, bearing_stiffness, drag"),
        (("springs.friction_nm",), "springs.friction_nm"),
    ],
)
def test_values_that_an_rv_reducer_does_not_have_are_refused(keys: tuple[str, ...], told: str) -> None:
    with pytest.raises(UsageError, match=told):
        calibrate(RV80E, [loop_of_statics(RV80E, 10.0)], keys)


@pytest.mark.slow
def test_the_command_writes_a_design_that_can_be_simulated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    loop = loop_of_statics(DRIVE, 12.0)
    rows = [f"{torque},{turn / DEGREE}" for torque, turn in zip(loop.torque, loop.deflection, strict=True)]
    Path("loop.csv").write_text("\n".join(["torque_output_Nm,deflection_deg", *rows]))
    words = [
        "calibrate",
        "rv80e",
        "--loop",
        "loop.csv",
        "--fit",
        "planet.backlash_um,bearing_stiffness,drag,drag_travel",
    ]
    assert main([*words, "--out", "made", "--json", "--quiet"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["parameters"]["bearing_stiffness"]["value"] == pytest.approx(0.8, rel=0.02)
    # 4.6 arcsec per 30 um of backlash at the planets represent the play of the teeth, 6.8 arcsec per micrometre
    assert result["parameters"]["planet.backlash_um"]["value"] == pytest.approx(30.0 / 4.6 * 6.8 * 2.8, rel=0.2)
    assert load(Path("made/rv80e-calibrated.toml")).drag.output > 5.0
    assert Path("made/rv80e-calibrated-loops.png").stat().st_size > 1000
