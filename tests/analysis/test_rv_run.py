"""Findings of a run of an RV reducer, from columns that follow from closed-form kinematics."""

import numpy as np
import pytest

from cycloid_mj.analysis import analyze, explain, table
from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.design import PRESETS, dump
from cycloid_mj.reducer import RvReducer, reducer_of
from cycloid_mj.reducer.rv_bodies import rv_motion
from cycloid_mj.report import report

LAG, FORCE = 2e-5, 5000.0
"""Lag of the output [rad], and force of each crank on each disc [N]."""


def made_run(reducer: RvReducer) -> Run:
    """Ideal motion over four output degrees, but with a lag of the output and constant forces of the cranks."""
    design = reducer.design
    time = np.linspace(0.0, 0.3, 3001)
    states = [rv_motion(reducer, design.drive.speed * each, design.drive.speed) for each in time]
    joints = {joint: np.array([position[joint] for position, _ in states]) for joint in states[0][0]}
    rates = {joint: np.array([velocity[joint] for _, velocity in states]) for joint in states[0][1]}
    columns: dict[str, Array] = {"sun_angle": joints["sun_angle"], "sun_speed": rates["sun_angle"]}
    columns |= {"output_angle": joints["output"] - LAG, "output_speed": rates["output"]}
    for gear in reducer.gears:
        for joint, speed in zip(names.planar_joints(gear), names.planar_speeds(gear), strict=True):
            columns |= {joint: joints[joint], speed: rates[joint]}
    pairs = [pair.name for pair in reducer.mechanism.pairs if pair.kind == "crank_bearing"]
    constant = {"sun_torque": 5.5, "load_torque": -784.0, "contacts": 90.0, "penetration": 5e-5, "peak_force": FORCE}
    constant |= {
        f"{pair}_{part}": 0.6 * FORCE if part == "force_x" else 0.8 * FORCE
        for pair in pairs
        for part in ("force_x", "force_y")
    }
    columns |= {name: np.full(time.size, value) for name, value in constant.items()}
    return Run(time, columns, dict.fromkeys(columns, "1"), attachments={"design.toml": dump(design).encode()})


@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_findings_compare_with_the_kinematics_of_the_sun(member: str) -> None:
    design = PRESETS["rv80e"].but(drive={"ramp": 0.0, "hold": 0.3}, output={"member": member}, ring={"pins": "fixed"})
    reducer = reducer_of(design)
    assert isinstance(reducer, RvReducer)
    findings = analyze(made_run(reducer))
    assert findings.driven_shaft == "sun"
    assert findings.transmission_error.mean_arcsec == pytest.approx(-np.degrees(LAG) * 3600.0)
    assert findings.transmission_error.peak_to_peak_arcsec == pytest.approx(0.0, abs=1e-6)
    assert findings.output_speed.theory_rad_s == pytest.approx(design.drive.speed / design.ratio)
    assert [disc.q_path.max_error_um for disc in findings.discs] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert findings.q_path.q_mm == (0.0, pytest.approx(42.0))
    assert findings.crank_bearings is not None
    assert findings.crank_bearings.max_force_n == pytest.approx(FORCE)
    assert findings.crank_bearings.mean_force_n == pytest.approx(FORCE)
    assert findings.power.input_w == pytest.approx(5.5 * design.drive.speed)
    turns = abs(reducer.orbit_speed) / (2.0 * np.pi) * (findings.window.end_s - findings.window.start_s)
    assert findings.window.crank_turns == pytest.approx(turns)


def test_words_name_the_sun_and_the_crank_bearings() -> None:
    reducer = RvReducer(PRESETS["rv80e"].but(drive={"ramp": 0.0, "hold": 0.3}, ring={"pins": "fixed"}))
    findings = analyze(made_run(reducer))
    quantities = [row.quantity for row in table(findings)]
    assert "sun torque, mean" in quantities
    assert "force of a crank on a disc, largest" in quantities
    assert not any("crank torque" in words or "crank speed" in words for words in quantities)
    assert "crank bearings carry up to 5000 N" in explain(findings)[-1]


def test_a_report_of_a_run_has_charts_and_tables_without_the_animated_mechanism() -> None:
    reducer = RvReducer(PRESETS["rv80e"].but(drive={"ramp": 0.0, "hold": 0.3}, ring={"pins": "fixed"}))
    page = report({"rv80e": made_run(reducer)})
    assert "sun torque, mean" in page
    assert 'id="figure-torque"' in page
    assert 'id="mechanism-0"' not in page
