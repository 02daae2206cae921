"""Loads of the parts: against ideal sharing and full statics, and the capacity against its definition."""

import json
import math
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from designs import unlike

from cycloid_mj.base.errors import UsageError
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, override
from cycloid_mj.measure.contact_pressure import contact_pressures, relative_curvature
from cycloid_mj.measure.loads import LOADS, UNDECIDED, UNPRESSED, YIELD_PRESSURE, loads
from cycloid_mj.measure.steady import run_steady
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.ideal import ideal_peak
from cycloid_mj.statics.kernel import CARRYING_SHARE
from cycloid_mj.statics.sheet import UNLOADED

FIXED = override(PRESETS["pin"], ['ring.pins="fixed"', "settings.timestep_us=5.0"])
IDEAL = [
    *(f"friction.{kind}=0.0" for kind in ("pin_gear", "tooth", "cam", "output", "cam_rolling", "output_rolling")),
    *(f"clearance.{kind}_um=1e-5" for kind in ("pin_gear", "tooth", "cam", "output")),
    "environment.gravity_y_m_s2=0.0",
    'contact.stiffness_law="uniform"',
    "contact.stiffness_n_m=1e7",
    "stiffness.cam_n_m=2e11",
    "settings.timestep_us=2.0",
    "drive.ramp_s=0.0",
    "drive.speed_rpm=100.0",
    "load.torque_nm=1.0",
    "settings.log_rate_hz=2500.0",
]


@pytest.fixture(scope="module")
def found():
    return loads(FIXED, quick=True)


def test_ideal_loads_are_those_of_statics() -> None:
    """F_i = T l_i / sum l^2 on the pins, their like on the output pins, and both together on the cam, within 1 %."""
    design = override(FIXED, IDEAL)
    run = run_steady(Reducer(design), 0.008, 1)
    for kind, one in contact_pressures(run, Reducer(design)).items():
        expected = ideal_peak(Reducer(design), kind, one.angle)
        assert one.peak_force == pytest.approx(expected, rel=0.01), kind
    spoiled = override(design, ["load.torque_nm=1.05"])
    assert contact_pressures(run, Reducer(design))["cam"].peak_force != pytest.approx(
        ideal_peak(Reducer(spoiled), "cam", run["crank_angle"]), rel=0.01
    )


@pytest.mark.slow
def test_at_capacity_the_weakest_contact_yields(found) -> None:
    kind, capacity = found.details["weakest"], found["capacity"]
    again = loads(FIXED, capacity, quick=True)
    allowed = 1e-6 * YIELD_PRESSURE * FIXED.material.yield_strength
    assert again[f"{kind}_pressure"] == pytest.approx(allowed, rel=0.01)
    assert again[f"{kind}_margin"] == pytest.approx(1.0, rel=0.01)


@pytest.mark.slow
def test_an_unloaded_kind_of_contact_has_no_margin(monkeypatch) -> None:
    def idle(kinds: set[str]) -> None:
        def lifted(*args) -> dict:
            return {
                kind: replace(one, vector=0.0 * one.vector, pressure=0.0 * one.pressure) if kind in kinds else one
                for kind, one in contact_pressures(*args).items()
            }

        monkeypatch.setattr(import_module("cycloid_mj.measure.loads"), "contact_pressures", lifted)

    idle({"output"})
    measured = loads(FIXED, quick=True)
    assert measured["output_pressure"] == 0.0
    assert math.isnan(measured["output_margin"])
    assert [measured.quantities[f"output_{name}"].note for name in ("pressure", "margin")] == [UNPRESSED] * 2
    assert measured.details["weakest"] in {"pin_gear", "cam"}
    assert "output" not in measured.details["capacity_by_kind_nm"]
    idle({"output", "pin_gear", "cam"})
    measured = loads(FIXED, quick=True)
    assert math.isnan(measured["capacity"])
    assert measured.details["weakest"] == ""


def test_half_the_step_changes_little(found) -> None:
    """5 us serves fixed pins: the largest forces hold within 1 % at half of it.

    Of an output pin ideal sharing says that the turn holds forces that are 2 % larger than in two mesh periods.
    """
    for key, one in found.quantities.items():
        if key.endswith("_peak_force"):
            assert one.error < (0.03 if key == "output_peak_force" else 0.01) * one.value


def test_pressure_grows_with_curvature() -> None:
    """A pin on the sharpest part of a lobe is pressed harder than a pin in its socket under the same force."""
    crank = np.linspace(0.0, 0.17, 20)
    design = PRESETS["pin"]
    on_gear = relative_curvature(Reducer(design), "pin_gear", crank)
    assert on_gear.shape == (20, 36)
    assert on_gear.max() == pytest.approx(1.0 / 0.357950e-3 + 1.0 / 2.25e-3, rel=0.01)
    assert relative_curvature(Reducer(design), "pin_socket", crank)[0] < 1.0 < on_gear.max()


def test_a_plain_cam_presses_the_bore_and_a_rolling_one_a_roller() -> None:
    crank, gear = np.zeros(1), PRESETS["pin"].gear
    plain = override(PRESETS["pin"], ['gear.bearing="plain"'])
    play = plain.clearance.cam
    conformal = 1.0 / gear.bore_radius - 1.0 / (gear.bore_radius + play)
    assert relative_curvature(Reducer(plain), "cam", crank) == pytest.approx(conformal, rel=1e-12)
    assert relative_curvature(Reducer(PRESETS["pin"]), "cam", crank) > 2.0 / gear.bore_radius


@pytest.mark.parametrize("torque", [0.0, -5.0, float("nan")])
def test_no_torque_is_a_usage_error(torque: float) -> None:
    with pytest.raises(UsageError, match="greater than 0"):
        loads(FIXED, torque)


def test_command_writes_figure_json_and_log(tmp_path, capsys) -> None:
    arguments = ["--set", 'ring.pins="fixed"', "--set", "settings.timestep_us=5.0", "--quick", "--quiet", "--json"]
    assert main(["measure", "loads", "--design", "pin", "--out", str(tmp_path), "--figure", *arguments]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["weakest"] in printed["capacity_by_kind_nm"]
    assert printed["quantities"]["pin_gear_peak_force"]["numerical_error"] is not None
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"loads-pin.png", "loads-pin.svg", "loads-pin.json", "loads-pin-loaded.mcap"}
    assert json.loads((tmp_path / "loads-pin.json").read_text()) == printed


def test_the_error_of_a_peak_states_what_two_mesh_periods_leave_out(found) -> None:
    one = found.quantities["output_peak_force"]
    turn = np.linspace(0.0, 2.0 * np.pi, 2000)
    swept = next(curve.x for curve in found.curves if curve.panel.startswith("output"))
    loaded = override(FIXED, [f"load.torque_nm={found.details['load_torque_nm']!r}"])
    missed = (
        ideal_peak(Reducer(loaded), "output", turn) / ideal_peak(Reducer(loaded), "output", np.radians(swept)) - 1.0
    )
    assert missed > 0.01
    assert one.error > 0.99 * missed * one.value
    assert found.quantities["capacity"].error > 0.0


def test_contacts_that_are_drawn_carry_and_the_most_loaded_is_among_them(found) -> None:
    for kind in ("pin_gear", "output"):
        drawn = [one for one in found.curves if one.panel.startswith(f"{kind}: force on") and one.style == "line"]
        assert 2 <= len(drawn) <= LOADS.shown
        assert max(one.y.max() for one in drawn) == found[f"{kind}_peak_force"]
        assert all(one.y.max() > CARRYING_SHARE * found[f"{kind}_peak_force"] for one in drawn)
    ideal = next(one for one in found.curves if one.name == "ideal sharing")
    assert ideal.of in {one.name for one in found.curves}
    assert ideal.y.max() > 0.0


@pytest.mark.slow
def test_the_capacity_of_a_soft_material_is_computed_or_has_no_deciding_contact() -> None:
    """Contacts of a printed reducer grow deeper than its own limit before they yield."""
    found = loads(unlike("printed"), quick=True)
    capacity = found.quantities["capacity"]
    if found.details["weakest"]:
        assert capacity.value > found.details["load_torque_nm"]
        assert 0.0 < capacity.error < 0.3 * capacity.value
    else:
        assert np.isnan(capacity.value)
        assert capacity.note == UNDECIDED


def test_discs_whose_parts_cross_their_play_share_nothing() -> None:
    """Two discs with 120 um of play under 1 % of the load carry nothing at times: no shares then, not 0/0."""
    loose = override(PRESETS["twodisc"], [f"clearance.{kind}_um=120" for kind in ("pin_gear", "cam", "output")])
    measured = loads(loose, 0.01 * loose.rated_torque, quick=True)
    shares = [measured.quantities[f"disc_{disc}_share"] for disc in (1, 2)]
    values = [one.value for one in shares]
    if any(map(math.isnan, values)):
        assert {one.note for one in shares} == {UNLOADED}
    else:
        assert sum(values) == pytest.approx(1.0)
    assert not any("nan" in one.note for one in shares)
