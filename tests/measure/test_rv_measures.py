"""Measures of RV reducers by the planar solver, compared with statics."""

import json
from pathlib import Path

import numpy as np
import pytest
from rv_runs import COULOMB_RV80E, FRICTIONLESS, static_loads

from cycloid_mj.base.record import Run
from cycloid_mj.base.units import ARCSECOND
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.dynamics.massless import massless
from cycloid_mj.dynamics.run import model_for
from cycloid_mj.measure import Measurement, backlash, loads, lost_motion, te, te_table
from cycloid_mj.measure.backlash import press_to_stops, with_single_clearance
from cycloid_mj.measure.orders import causes
from cycloid_mj.measure.steady import run_steady, steady_design
from cycloid_mj.measure.trace import Trace, TraceCondition, run_trace
from cycloid_mj.reducer import RvReducer, reducer_of
from cycloid_mj.statics import transmission_error
from cycloid_mj.statics.rv import runout_error
from cycloid_mj.statics.rv_motion import rv_backlash
from cycloid_mj.statics.sheet import sheet_part

BORE_ERROR = {"crank_errors": {"bore_x": (1e-5, 0.0, 0.0, 0.0, 0.0, 0.0)}}
PLAY = {
    "cranks": {"needle_clearance": 2e-6, "taper_clearance": 1e-6},
    "planet": {"backlash": 2e-5},
    "clearance": {"pin_gear": 3e-6, "pin_socket": 2e-6},
}


def rv80e(**changes: object) -> Design:
    return COULOMB_RV80E.but(**changes)


def require_agreement(measured: Measurement, keys: tuple[str, ...], rtol: float = 5e-3) -> None:
    for key in keys:
        quantity = measured.quantities[key]
        assert quantity.value == pytest.approx(quantity.reference, rel=rtol), key


@pytest.mark.slow
@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_transmission_error_of_a_bore_error_is_that_of_statics(member: str) -> None:
    measured = te(rv80e(**BORE_ERROR, output={"member": member}), quick=True)
    conditions = ("loaded_forward_speed", "loaded_reverse_speed")
    levels = [f"output_{level}_{condition}" for level in ("peak_to_peak", "rms") for condition in conditions]
    require_agreement(measured, (*levels, "output_wind_up", "gear_wind_up"))
    assert measured["output_peak_to_peak_loaded_forward_speed"] > 10.0
    rows = measured.details["orders"]["cases"]["loaded_forward_speed"]
    base = 1.0 if member == "ring" else 40.0 / 39.0
    strongest = max((row for row in rows if row["cause"] == "cranks"), key=lambda row: row["amplitude_arcsec"])
    assert strongest["order"] == pytest.approx(base)


def test_orders_of_the_cranks_are_those_of_their_rotation_against_the_carrier() -> None:
    reducer = reducer_of(COULOMB_RV80E)
    by_key = {cause.key: cause for cause in causes(reducer)}
    assert by_key["cranks"].has(40.0 / 39.0)
    assert not by_key["ring"].has(40.0 / 39.0)
    assert by_key["planet_mesh"].has(38.0 * 40.0 / 39.0)
    assert by_key["mesh"].has(40.0)
    ring = {cause.key: cause for cause in causes(reducer.but(output={"member": "ring"}))}
    assert ring["cranks"].has(1.0)
    assert ring["mesh"].has(39.0)


ORDERS_PER_OUTPUT_TURN = {1: "output_runout", 40: "cranks", 80: "cranks", 120: "cranks", 160: "cranks"}
"""Orders of the measured RV-80E (Yang et al. 2021), in cycles per turn of the output, and their causes."""


@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_the_table_of_orders_has_the_run_out_of_the_output(member: str) -> None:
    """A curve with the closed form of the run-out, and a cosine of a known amplitude at each of the other orders."""
    reducer = reducer_of(rv80e(crank_errors={"output_x": 1e-5}, output={"member": member}))
    assert isinstance(reducer, RvReducer)
    turns = reducer.design.lobes
    crank = reducer.mesh_turn * np.arange(turns * 480) / 480.0
    output = reducer.member.output_angle(reducer.member.driven_angle(crank))
    amplitudes = {1: 1e-5 / 77.5e-3 / ARCSECOND, 40: 8.0, 80: 4.0, 120: 2.0, 160: 1.0}
    error = runout_error(reducer, output) / ARCSECOND
    error += sum(amplitudes[order] * np.cos(order * output) for order in (40, 80, 120, 160))
    trace = Trace(crank, np.zeros_like(error), error, Run(np.zeros(1), {}, {}))
    conditions = [
        TraceCondition(load, direction, "speed", 784.0, reducer.design.drive.speed)
        for load, direction in (("loaded", "forward"), ("unloaded", "forward"), ("unloaded", "reverse"))
    ]
    traces = dict.fromkeys(conditions, trace)
    rows = {row.key: row for row in te_table.quantities(reducer, traces, {}, traces, turns)}
    runout = rows["output_runout_orders_rms_loaded_forward_speed"]
    assert runout.value == pytest.approx(amplitudes[1] / np.sqrt(2.0), rel=1e-9)
    found = te_table.order_details(reducer, traces, turns)["cases"]["loaded_forward_speed"]
    crank_turns = reducer.member.crank_angle(float(reducer.kinematics.ratio))
    by_order = {round(row["order"] * abs(float(crank_turns))): row for row in found if row["cause"] != "between"}
    for order, cause in ORDERS_PER_OUTPUT_TURN.items():
        assert by_order[order]["amplitude_arcsec"] == pytest.approx(amplitudes[order], rel=1e-9)
        assert by_order[order]["cause"] == cause
    # over one turn of the cranks, order 1 cannot be resolved
    first_turn = Trace(*(values[:480] for values in (trace.crank, trace.gear, trace.output)), trace.run)
    shorter = dict.fromkeys(conditions, first_turn)
    assert not [row for row in te_table.quantities(reducer, shorter, {}, shorter, 1) if "runout" in row.key]


def test_a_run_over_a_quarter_turn_has_the_angles_and_the_wind_up_of_statics() -> None:
    reducer = reducer_of(rv80e(**BORE_ERROR)).working_at(784.0)
    condition = TraceCondition("loaded", "forward", "speed", 784.0, reducer.design.drive.speed)
    trace = run_trace(reducer, model_for("planar", reducer), 0.25, condition)
    assert trace.crank[0] == pytest.approx(1.5 * np.pi)  # the cranks turn against the sun
    assert np.ptp(trace.crank) == pytest.approx(0.5 * np.pi, rel=0.01)
    static = -transmission_error(reducer, trace.crank, 784.0) * 648000.0 / np.pi
    np.testing.assert_allclose(trace.output, static[:, 1], atol=0.3)
    np.testing.assert_allclose(trace.gear, static[:, 0], atol=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pin_gear", "pin_socket", "crank_bearing", "planet_mesh"])
def test_backlash_of_a_single_clearance_is_that_of_statics(kind: str) -> None:
    reducer = reducer_of(rv80e(**PLAY)).at_rated_load
    single = massless(with_single_clearance(reducer, kind))
    assert isinstance(single, RvReducer)
    (static,) = rv_backlash(single, [0.7], 0.0025 * 784.0)
    assert press_to_stops(single, 0.7).backlash == pytest.approx(static, rel=5e-3)


@pytest.mark.slow
def test_backlash_with_all_clearances_is_that_of_statics() -> None:
    require_agreement(backlash(rv80e(), angles=2), ("backlash", "backlash_min", "backlash_max", "backlash_pin_gear"))
    measured = backlash(rv80e(**PLAY), angles=1)
    (row,) = measured.details["angles"]
    assert row["backlash_arcmin"]["all"] == pytest.approx(row["closed_form_arcmin"]["all"], rel=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rv80e", "rv64"])
def test_stiffness_and_lost_motion_are_those_of_statics(name: str) -> None:
    measured = lost_motion(PRESETS[name], quick=True)
    require_agreement(measured, ("stiffness_ideal", "lost_motion_ideal", "lost_motion"))
    assert measured["stiffness"] > measured["stiffness_ideal"]  # friction holds the parts
    assert not [key for key in measured.quantities if key.startswith("compliance")]


@pytest.mark.slow
def test_loads_are_those_of_statics() -> None:
    """Statics has the forces of a whole turn of the carrier, the run those of two mesh periods."""
    measured = loads(COULOMB_RV80E, quick=True)
    statics = sheet_part(RvReducer(COULOMB_RV80E), "loads", 784.0)
    assert measured["pin_gear_peak_force"] == pytest.approx(statics["pin_gear_peak_force"].value, rel=0.01)
    assert measured["pin_gear_carrying"] == pytest.approx(statics["pin_gear_carrying"].value, rel=0.02)
    assert measured["crank_bearing_peak_force"] <= statics["crank_bearing_running_force"].value
    assert measured.quantities["pin_gear_peak_force"].reference == pytest.approx(649.0, rel=5e-3)
    assert measured["planet_mesh_peak_force"] == pytest.approx(statics["planet_mesh_force"].value, rel=0.02)
    assert measured["capacity"] > 10.0 * 784.0
    # the crank bearings deflect too far before the teeth reach shakedown
    assert "the run at" in measured.quantities["capacity_shakedown"].note
    assert "crank_bearing_pressure" not in measured.quantities


@pytest.mark.slow
def test_the_command_measures_an_rv_reducer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "te")
    assert main(["measure", "te", "rv80e", "--quick", "--no-log", "--html", "--quiet", "--json", "--out", out]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["figures"]["simulated_te_loaded_arcsec"]["unit"] == "arcsec"
    assert list(tmp_path.rglob("*.html"))


def test_transmission_error_of_ideal_parts_is_that_of_statics_at_a_low_speed() -> None:
    """At full speed, inertia raises the orders of the mesh: by 10 % at 390 Hz, by 80 % at 780 Hz."""
    design = rv80e(**FRICTIONLESS, load={"torque": 784.0}).but(ring={"pins": "fixed"})
    errors = {}
    for share in (1.0, 0.1):
        reducer = steady_design(reducer_of(design.but(drive={"speed": share * design.drive.speed})))
        run = run_steady(reducer, 0.02, 6).select(slice(0, None, 10))
        simulated = run["output_angle"] - reducer.member.output_angle(run["sun_angle"])
        errors[share] = np.ptp(simulated), np.ptp(static_loads(reducer, run).carrier_turn)
    simulated, static = errors[0.1]
    assert static * 648000.0 / np.pi == pytest.approx(0.0125, rel=0.02)
    assert simulated == pytest.approx(static, rel=0.01)
    assert errors[1.0][0] > 1.15 * static
