"""The designs with a name: their checks pass, their energy balances, and the printed drive is the published one."""

import json
import math

import pytest
from designs import CENTRAL, cases, unlike

from cycloid_mj.analysis import Findings, analyze
from cycloid_mj.base.record import Run
from cycloid_mj.checks import check, summarize
from cycloid_mj.cli import main
from cycloid_mj.comparison.forces import forces
from cycloid_mj.comparison.measures import settle_run
from cycloid_mj.design import PRESETS, dump, load, loads, preset_reasons
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.dynamics.timestep import timestep
from cycloid_mj.figures import quantity
from cycloid_mj.measure import bench, rigid_backlash
from cycloid_mj.measure.backlash import press_to_stops
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.statics import powers
from cycloid_mj.statics.film_spread import boundary_range
from cycloid_mj.validate.energy import balance

PRINTED = PRESETS["printed"]
PLAY = 0.669
"""Backlash of the printed drive by its drawn clearances [deg]."""


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_passes_its_checks_and_is_restored_from_its_file(name: str) -> None:
    design = PRESETS[name]
    assert design.name == name
    assert [one.name for one in check(design) if not one.passed and one.severity == "error"] == []
    assert loads(dump(design, preset_reasons(name, design))) == design


def test_the_printed_drive_has_no_warnings_and_is_not_the_test_design_of_that_name() -> None:
    assert [one.name for one in check(PRINTED) if not one.passed] == []
    assert unlike("printed").lobes == 11
    assert PRINTED.lobes == 13


def test_values_of_a_preset_have_reasons_until_they_are_changed(tmp_path) -> None:
    assert preset_reasons("printed", PRINTED)["output.core_radius"] == "the pin in the needle roller HK0509"
    changed = PRINTED.but(output={"core_radius": 0.002})
    assert "output.core_radius" not in preset_reasons("printed", changed)
    assert "gear.face_width" in preset_reasons("printed", changed)
    assert preset_reasons("pin", PRESETS["pin"]) == {}
    file = tmp_path / "mine.toml"
    file.write_text(dump(PRINTED, preset_reasons("printed", PRINTED)))
    assert "the needle roller HK0509" in file.read_text()
    assert load(file) == PRINTED


@pytest.mark.slow
def test_the_printed_drive_has_the_backlash_of_its_drawing() -> None:
    assert math.degrees(summarize(Reducer(PRINTED)).backlash) == pytest.approx(PLAY, rel=0.01)
    _, turn = rigid_backlash.backlash_over_turn(Reducer(PRINTED))
    assert math.degrees(turn.mean()) == pytest.approx(PLAY, rel=0.01)


@pytest.mark.slow
def test_the_printed_drive_is_pressed_to_its_backlash() -> None:
    angles = [float(angle) for angle in bench.crank_angles(Reducer(PRINTED), 2)]
    found = [
        press_to_stops(bench.without_friction(Reducer(PRINTED)), angle, time_factor=2.0).backlash for angle in angles
    ]
    assert found == pytest.approx(rigid_backlash.total_backlash(Reducer(PRINTED), angles).tolist(), rel=0.005)


@pytest.fixture(scope="module")
def at_speed() -> dict[float, Run]:
    """Run the printed drive at 100 rpm and 10 N m, at its own step and at half of it, over four mesh periods."""
    period = 2.0 * math.pi / (PRINTED.ring.teeth * PRINTED.drive.speed)
    design = PRINTED.but(drive={"ramp": 0.0, "hold": 0.08 + 4.0 * period})
    assert (design.load.torque, design.drive.speed) == (10.0, pytest.approx(100.0 * math.pi / 30.0))
    step = timestep(Reducer(design))
    return {share: simulate(design.but(settings={"timestep": share * step})) for share in (1.0, 0.5)}


def figures(run: Run) -> dict[str, float]:
    """Compute what anyone would report of a run."""
    found: Findings = analyze(run, settle=0.08)
    pressed = forces(settle_run(run))
    return {
        "transmission error, p-p": found.output_transmission_error.peak_to_peak_arcsec,
        "transmission error, mean": found.output_transmission_error.mean_arcsec,
        "transmission error of the gear, p-p": found.gear_transmission_error.peak_to_peak_arcsec,
        "gear speed, rms": found.gear_speed.rms_error_rad_s,
        "output speed, rms": found.output_speed.rms_error_rad_s,
        "efficiency": found.efficiency,
        "tooth, peak": pressed.tooth_peak_n,
        "cam, peak": pressed.cam_peak_n,
        "output pin, peak": pressed.output_pin_peak_n,
        "q path, rms": found.q_path.rms_error_um,
        "penetration": found.contact_summary.max_penetration_um,
    }


@pytest.mark.slow
def test_the_printed_drives_figures_hold_at_half_the_step(at_speed) -> None:
    own, half = (figures(at_speed[share]) for share in (1.0, 0.5))
    assert own == pytest.approx(half, rel=0.03)
    assert own["efficiency"] == pytest.approx(powers(Reducer(PRINTED), PRINTED.load.torque).efficiency, abs=0.01)


@pytest.mark.parametrize("name", cases(PRESETS, *CENTRAL, "rv80e"))
def test_the_input_energy_of_a_preset_is_output_lost_or_stored(name: str, at_speed) -> None:
    design = PRESETS[name]
    loaded = design.but(drive={"ramp": 0.01, "hold": 0.01}, load={"torque": design.rated_torque})
    found = balance(at_speed[1.0] if name == "printed" else simulate(loaded))
    assert found.supplied == pytest.approx(found.total_output, rel=0.01)
    assert found.friction > 0.01 * found.supplied
    assert found.supplied - found.friction != pytest.approx(found.total_output, rel=0.01)


def test_rollers_roll_on_a_core_that_is_given() -> None:
    dry = PRINTED.but(friction={"law": "coulomb"})
    own, rim = dry.friction.output_rolling, dry.but(output={"core_radius": 0.0})
    assert rim.friction_of("output") == own
    assert dry.friction_of("output") == pytest.approx(own * 2.5 / 4.5)
    assert dry.but(output={"rollers": False}).friction_of("output") == dry.friction.output
    lost = [powers(Reducer(one), 10.0).friction["output"] for one in (dry, rim)]
    assert lost[0] == pytest.approx(lost[1] * 2.5 / 4.5, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_all_commands_run_with_the_printed_drive(member: str, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    chosen = ["--set", f"output.member={member}"]
    quick = [*chosen, "--ramp-s", "0", "--hold-s", "0.75"]
    for line in (
        ["design", "check", "printed", *chosen],
        ["design", "new", "mine", "--from", "printed", *chosen],
        ["design", "kinematics", "--design", "mine.toml", "--until-s", "0.1", "--csv", "q.csv"],
        ["simulate", "--design", "printed", *quick, "--out", "runs", "--quiet"],
        ["analyze", "runs/printed.mcap"],
        ["log", "plot", "runs/printed.mcap"],
        ["report", "runs/printed.mcap"],
        ["export", "--design", "mine.toml", "--format", "dxf", "--out", "parts"],
    ):
        assert main(line) == 0, line
    capsys.readouterr()
    assert main(["statics", "--design", "mine.toml", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["quantities"]
    share = 13.0 / 14.0 if member == "ring" else 1.0
    assert found["backlash"]["value"] == pytest.approx(60.0 * PLAY * share, rel=0.01)
    assert load(tmp_path / "mine.toml").reduction == (14 if member == "ring" else 13)


@pytest.mark.parametrize("name", PRESETS)
def test_all_presets_but_those_of_the_paper_have_film_friction_and_a_stated_lubricant(name: str) -> None:
    """The efficiency of a lubricated drive is an interval."""
    design = PRESETS[name]
    assert design.has_film == (name not in ("pin", "nonpin"))
    if design.has_film:
        assert "friction.law" in preset_reasons(name, design)
        assert quantity(reducer_of(design), "efficiency_percent").low is not None


def test_interval_of_a_plastic_drive_covers_greased_plastics() -> None:
    """VDI 2736-2: 0.05 to 0.12 for greased plastics, where greased steel has 0.08 to 0.14."""
    printed, steel = (boundary_range(Reducer(PRESETS[name])) for name in ("printed", "twodisc"))
    boundary = PRINTED.friction.boundary
    assert (printed.low * boundary, printed.high * boundary) == pytest.approx((0.05, 0.12))
    assert (0.11 * steel.low, 0.11 * steel.high) == pytest.approx((0.08, 0.14), abs=1e-3)
