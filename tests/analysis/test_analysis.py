"""Findings of synthetic runs: the closed form, written here in complex numbers, plus known perturbations."""

import json
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from ideal import ideal_mechanism

from cycloid_mj import analysis
from cycloid_mj.analysis import analyze, series, table, window
from cycloid_mj.analysis.window import turn_by_turn
from cycloid_mj.base.errors import DesignError, LogError, UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.design import PRESETS, Design, dump, override
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.dynamics.timestep import timestep
from cycloid_mj.reducer import Reducer

ARCSEC = math.pi / 180 / 3600
DT = 1e-4
DEGREE_PER_SAMPLE = "drive.speed_rpm=1666.6666666666667"  # 1 deg of crank in 0.1 ms: turns and meshes end on samples
SPEED = math.radians(1.0) / DT
TURN = 360
LOBES, ECCENTRICITY, HOLE = 35, 1e-3, 26e-3
KEYS = {
    "crank": ["speed_rad_s", "max_relative_error"],
    "gear_speed": ["theory_rad_s", "mean_rad_s", "rms_error_rad_s", "peak_error_rad_s"],
    "q_path": ["q_mm", "rms_error_um", "max_error_um"],
    "q_speed": ["rms_error_mm_s", "max_error_mm_s"],
    "transmission_error": ["peak_to_peak_arcsec", "mean_arcsec"],
    "contact_summary": ["mean_active", "max_penetration_um", "peak_force_n"],
    "pin1": ["max_radial_um", "mean_spin_rad_s"],
}
PLAIN = ["design", "contact", "log", "timestep_s", "timestep", "steps", "wall_s"]


def designed(*changes: str, turns: float = 2, ramp: float = 0.0, preset: str = "pin") -> Design:
    hold = turns * TURN * DT
    drive = [DEGREE_PER_SAMPLE, f"drive.ramp_s={ramp!r}", f"drive.hold_s={hold!r}"]
    return override(PRESETS[preset], [*drive, *changes])


def ideal(design: Design, **added) -> Run:
    return replace(
        ideal_mechanism(design, **added),
        provenance={"design": design.name, "contact": "profile", "timestep_s": "4e-06"},
    )


def wave(design: Design, order: float) -> np.ndarray:
    """Compute cos(order * crank angle) for a design without ramp."""
    return np.cos(order * math.radians(1.0) * np.arange(round(design.drive.hold / DT)))


def near(value: float, rel: float = 1e-9, abs: float = 1e-9):
    """Rounding only: runs and findings are a few hundred operations of doubles."""
    return pytest.approx(value, rel=rel, abs=abs)


# --- the ideal mechanism, and every sign


@pytest.mark.parametrize("ramp", [0.0, 0.05])
@pytest.mark.parametrize("speed", [DEGREE_PER_SAMPLE, "drive.speed_rpm=-1640"])
def test_the_ideal_mechanism_has_no_error(ramp, speed):
    design = designed(speed, ramp=ramp)
    found = analyze(ideal(design), q=(3e-3, -7e-3))
    assert found.crank.speed_rad_s == near(design.drive.speed)
    assert found.crank.max_relative_error == near(0)
    for part in (found.gear_speed, found.output_speed):
        assert part.theory_rad_s == near(-design.drive.speed / 35)
        assert part.mean_rad_s == near(-design.drive.speed / 35)
        assert [part.rms_error_rad_s, part.peak_error_rad_s] == near([0, 0])
    phases = [found] + ([found.ramp] if ramp else [])
    for phase in phases:
        assert [phase.q_path.rms_error_um, phase.q_path.max_error_um] == near([0, 0], abs=1e-8)
        assert [phase.q_speed.rms_error_mm_s, phase.q_speed.max_error_mm_s] == near([0, 0], abs=1e-8)
    for error in (found.gear_transmission_error, found.output_transmission_error):
        assert [error.peak_to_peak_arcsec, error.mean_arcsec] == near([0, 0])
    assert (found.ramp is None) == (ramp == 0)


FLIPPED = [
    ("gear_angle", "gear_transmission_error", "mean_arcsec", 1e4),
    ("gear_speed", "gear_speed", "peak_error_rad_s", 1.0),
    ("gear_speed", "q_speed", "max_error_mm_s", 10.0),
    ("gear_x", "q_path", "max_error_um", 1e3),
    ("gear_y", "q_path", "max_error_um", 1e3),
    ("gear_vx", "q_speed", "max_error_mm_s", 100.0),
    ("gear_vy", "q_speed", "max_error_mm_s", 100.0),
    ("crank_speed", "crank", "max_relative_error", 1.0),
    ("crank_speed", "gear_speed", "peak_error_rad_s", 1.0),
    ("crank_angle", "q_path", "max_error_um", 1e3),
    ("output_angle", "output_transmission_error", "mean_arcsec", 1e4),
    ("output_speed", "output_speed", "peak_error_rad_s", 1.0),
]


@pytest.mark.parametrize(("column", "part", "key", "at_least"), FLIPPED)
def test_a_wrong_sign_shows(column, part, key, at_least):
    design = designed()
    run = ideal(design)
    flipped = ideal(design, **{column: -2 * run[column]})
    assert abs(getattr(getattr(analyze(run), part), key)) < 1e-6 * at_least
    assert abs(getattr(getattr(analyze(flipped), part), key)) > at_least


# --- each number has its exact value


def test_speed_errors_of_gear_and_output():
    design = designed()
    run = ideal(design, gear_speed=0.003 + 0.004 * wave(design, 1), output_speed=0.001 * wave(design, 2))
    found = analyze(run, settle=0.0)
    assert found.gear_speed.mean_rad_s == near(-SPEED / 35 + 0.003)
    assert found.gear_speed.theory_rad_s == near(-SPEED / 35)
    assert found.gear_speed.rms_error_rad_s == near(math.sqrt(0.003**2 + 0.004**2 / 2))
    assert found.gear_speed.peak_error_rad_s == near(0.007)
    assert found.output_speed.rms_error_rad_s == near(0.001 / math.sqrt(2))


def test_gear_speed_is_compared_with_the_measured_crank_at_each_sample():
    design = designed()
    ripple = 0.5 * wave(design, 3)
    found = analyze(ideal(design, crank_speed=ripple, gear_speed=-ripple / 35), settle=0.0)
    assert found.gear_speed.peak_error_rad_s == near(0)
    assert found.crank.max_relative_error == near(0.5 / SPEED)
    unmatched = analyze(ideal(design, crank_speed=ripple), settle=0.0)
    assert unmatched.gear_speed.peak_error_rad_s == near(0.5 / 35)


def test_transmission_error_of_gear_and_output():
    design = designed()
    gear, output = 45 + 0.25 * wave(design, 36), -96 + 0.5 * wave(design, 36)  # 36 deg of phase a sample: both extremes
    found = analyze(ideal(design, gear_angle=ARCSEC * gear, output_angle=ARCSEC * output), settle=0.0)
    assert found.gear_transmission_error.peak_to_peak_arcsec == near(0.5)
    assert found.gear_transmission_error.mean_arcsec == near(45)
    assert found.output_transmission_error.peak_to_peak_arcsec == near(1.0)
    assert found.output_transmission_error.mean_arcsec == near(-96)


def test_peak_to_peak_is_the_mean_of_the_turns_and_not_their_largest():
    design = designed()
    swing = np.where(np.arange(2 * TURN) < TURN, 0.5, 2.0) * wave(design, 36)
    found = analyze(ideal(design, gear_angle=ARCSEC * swing, output_angle=ARCSEC * 2 * swing), settle=0.0)
    assert found.gear_transmission_error.peak_to_peak_arcsec == near((1.0 + 4.0) / 2)
    assert found.output_transmission_error.peak_to_peak_arcsec == near((2.0 + 8.0) / 2)


def test_q_path_is_the_distance_of_two_points():
    design = designed()
    shifted = analyze(ideal(design, gear_x=3e-6, gear_y=-4e-6))
    assert [shifted.q_path.rms_error_um, shifted.q_path.max_error_um] == near([5.0, 5.0], abs=1e-7)
    assert shifted.q_path.q_mm == near((0.0, 26.0))
    turned = ideal(design, gear_angle=1e-3)
    assert analyze(turned).q_path.max_error_um == near(1e6 * 2 * HOLE * math.sin(0.5e-3), rel=1e-8)
    assert analyze(turned, q=(0.0, 0.0)).q_path.max_error_um == near(0.0, abs=1e-8)
    assert analyze(turned, q=(-3e-3, 4e-3)).q_path.max_error_um == near(1e6 * 2 * 5e-3 * math.sin(0.5e-3), rel=1e-8)


def test_rms_and_maximum_of_the_q_path_differ_as_expected():
    design = designed()
    found = analyze(ideal(design, gear_x=2e-6 * wave(design, 1)), settle=0.0)
    assert found.q_path.rms_error_um == near(2 / math.sqrt(2), abs=1e-7)
    assert found.q_path.max_error_um == near(2.0, abs=1e-7)


def test_q_speed_is_the_size_of_the_velocity_error():
    design = designed()
    shifted = analyze(ideal(design, gear_vx=3e-3, gear_vy=4e-3))
    assert [shifted.q_speed.rms_error_mm_s, shifted.q_speed.max_error_mm_s] == near([5.0, 5.0], abs=1e-8)
    spun = analyze(ideal(design, gear_speed=0.1), q=(-3e-3, 4e-3))
    assert spun.q_speed.max_error_mm_s == near(0.1 * 5.0, abs=1e-8)
    assert shifted.q_speed_magnitude.max_error_mm_s < shifted.q_speed.max_error_mm_s


def test_a_rotated_velocity_is_an_error_of_velocity_only():
    run = ideal(designed())
    centre, turn = run["gear_vx"] + 1j * run["gear_vy"], np.exp(0.01j)
    turned = {"gear_vx": ((turn - 1) * centre).real, "gear_vy": ((turn - 1) * centre).imag}
    found = analyze(ideal(designed(), **turned), q=(0.0, 0.0))
    assert found.q_speed.max_error_mm_s == near(1e3 * 2 * ECCENTRICITY * SPEED * math.sin(0.005), rel=1e-7)
    assert found.q_speed_magnitude.max_error_mm_s == near(0.0, abs=1e-7)


def test_acceleration_of_q_holds_to_the_order_of_its_differences_in_hold_and_ramp():
    # a velocity difference over the crank angle h is the acceleration half-way to h^2/24, 1.3e-5 at 1 deg
    bound = 1.1 * math.radians(1.0) ** 2 / 24 * ECCENTRICITY * SPEED**2
    found = analyze(ideal(designed(ramp=0.05)))
    assert 0 < found.q_acceleration.max_error_m_s2 < bound
    assert 0 < found.ramp.q_acceleration.max_error_m_s2 < 2 * bound
    tangential = ECCENTRICITY * SPEED / 0.05
    assert tangential > 1000 * bound  # so that Eqs 19 and 20 without it would not pass
    double = [analyze(ideal(designed(f"drive.speed_rpm={rpm}"))).q_acceleration.max_error_m_s2 for rpm in (500, 1000)]
    assert math.log2(double[1] / double[0]) == pytest.approx(4.0, abs=0.02)  # h^2 and, in the acceleration, speed^2


def test_coarse_samples_have_no_acceleration():
    run = ideal(designed())
    assert analyze(run.select(slice(0, None, 4))).q_acceleration is not None
    coarse = analyze(run.select(slice(0, None, 6)))
    assert coarse.q_acceleration is None
    assert coarse.q_path.max_error_um == near(0, abs=1e-8)


def test_the_crank_is_judged_over_the_whole_run():
    design = designed(ramp=0.05)
    slip = np.zeros(500 + 720)
    slip[100], slip[1100] = -0.02 * SPEED, 0.01 * SPEED
    found = analyze(ideal(design, crank_speed=slip))
    assert found.crank.max_relative_error == near(0.02)
    assert found.crank.speed_rad_s == near(SPEED)  # sample 1100 is after the one whole turn


def test_contacts_and_pin_1():
    design = designed()
    added = {
        "contacts": 40 + 4 * wave(design, 36),
        "penetration": 0.4e-6 + 0.1e-6 * wave(design, 1),
        "peak_force": 100 - 20 * wave(design, 1),
        "pin_1_x": 0.6e-6 * wave(design, 1),
        "pin_1_y": 0.8e-6 * wave(design, 1),
        "pin_1_speed": -3 + wave(design, 1),
    }
    found = analyze(ideal(design, **added), settle=0.0)
    assert vars(found.contact_summary) == near({"mean_active": 40, "max_penetration_um": 0.5, "peak_force_n": 120})
    assert vars(found.pin1) == near({"max_radial_um": 1.0, "mean_spin_rad_s": -3})


@pytest.mark.parametrize(("preset", "change"), [("nonpin", "ring.teeth=36"), ("pin", 'ring.pins="fixed"')])
def test_without_free_pins_there_is_no_pin_1(preset, change):
    found = analyze(ideal(designed(change, preset=preset)))
    assert found.pin1 is None
    assert found.as_json()["pin1"] is None


@pytest.mark.parametrize("direction", [1, -1])
def test_efficiency_and_power(direction):
    speed = f"drive.speed_rpm={direction * 5000 / 3!r}"
    design = designed(speed, "load.torque_nm=35.0", turns=2.4)
    torque = direction * (1.25 + 0.5 * wave(design, 0.5))  # a ripple of a whole turn or longer: 0 over two turns
    powers = {"pin_gear_friction_power": 30.0, "pin_gear_normal_power": 2.0, "tooth_friction_power": 0.0}
    found = analyze(ideal(design, crank_torque=torque, load_torque=direction * 35.0, **powers), settle=0.0)
    assert found.efficiency == near(0.8)
    assert found.power.input_w == near(1.25 * SPEED)
    assert found.power.output_w == near(1.0 * SPEED)
    assert found.power.crank_torque_nm == near(direction * 1.25)
    assert found.power.ideal_crank_torque_nm == near(direction * 1.0)
    assert [vars(loss) for loss in found.losses] == [{"pair": "pin_gear", "friction_w": 30.0, "normal_w": 2.0}]


def test_without_load_there_is_no_efficiency():
    assert analyze(ideal(designed(), crank_torque=0.01)).efficiency is None


def test_a_crank_at_rest_has_no_relative_error():
    found = analyze(ideal(designed("drive.speed_rpm=0.0")))
    assert found.crank.max_relative_error is None
    assert found.q_path.max_error_um == near(0)


# --- which samples count


def test_means_cover_whole_turns_and_extremes_the_whole_run():
    design = designed(turns=1.5)
    found = analyze(ideal(design, gear_angle=10 * ARCSEC * wave(design, 0.75)), settle=0.0)
    first_turn = 10 * np.mean(wave(design, 0.75)[:TURN])
    assert found.gear_transmission_error.mean_arcsec == near(first_turn)
    everything = np.ptp(10 * wave(design, 0.75))
    assert found.gear_transmission_error.peak_to_peak_arcsec == near(everything)


def test_a_hold_shorter_than_a_turn_is_averaged_over_whole_mesh_periods():
    design = designed(turns=0.87)  # 313 deg: 31 meshes of 10 deg
    odd_part = np.where(np.arange(313) >= 310, 1e3, 0.0)
    last_mesh = np.where(np.arange(313) >= 300, 31.0, 0.0)
    found = analyze(ideal(design, gear_angle=ARCSEC * (wave(design, 36) + odd_part + last_mesh)), settle=0.0)
    assert found.gear_transmission_error.mean_arcsec == near(1.0)
    assert found.gear_transmission_error.peak_to_peak_arcsec > 900


def test_a_hold_shorter_than_a_mesh_period_is_averaged_completely():
    found = analyze(ideal(designed(turns=7 / 360), contacts=np.arange(7.0)), settle=0.0)
    assert found.contact_summary.mean_active == near(3.0)


def settled_from(design: Design, settle: float | None = None) -> float:
    return analyze(ideal(design), settle=settle).window.start_s


def test_the_start_up_is_left_out_but_never_more_than_half_of_the_hold():
    long = designed(turns=5)
    assert settled_from(long) == near(window.SETTLING.min_time)
    assert settled_from(long, 0.0) == 0.0
    assert settled_from(long, 0.02) == near(0.02)
    assert settled_from(long, 1e9) == near(DT * 900)  # 1800 samples, the last at 1799 DT
    loaded = designed("load.torque_nm=36.0", "load.rise_s=0.01", turns=5)
    assert settled_from(loaded) == near(0.01 + window.SETTLING.min_time)
    ramped = designed("load.torque_nm=36.0", "load.rise_s=0.01", turns=5, ramp=0.05)
    assert settled_from(ramped) == near(0.05 + window.SETTLING.min_time)


def test_a_slow_drive_settles_over_a_share_of_its_turn():
    fast, slow = (override(PRESETS["pin"], [f"drive.speed_rpm={rpm}"]) for rpm in (-5000.0, 60.0))
    assert window.settling(Reducer(fast)) == window.SETTLING.min_time
    assert window.settling(Reducer(slow)) == near(1.0 / 8.0)
    time, ramp = np.linspace(0.0, 2.0, 2001), slow.drive.ramp
    assert time[window.in_hold(Reducer(slow), time)][0] == near(ramp + 1.0 / 8.0)


def test_the_settling_time_is_not_judged():
    design = designed(turns=5)
    jolt = np.where(np.arange(1800) < 50, 1.0, 0.0)
    run = ideal(design, gear_speed=jolt, peak_force=1e4 * jolt, penetration=1e-3 * jolt, pin_1_x=1e-3 * jolt)
    found = analyze(run)
    assert found.contact_summary.max_penetration_um == 0.0
    assert found.pin1.max_radial_um == 0.0
    assert found.gear_speed.peak_error_rad_s == near(0)
    assert found.contact_summary.peak_force_n == 0.0
    assert analyze(run, settle=0.0).gear_speed.peak_error_rad_s == near(1.0)


def test_ramp_and_hold_are_distinguished():
    design = designed(ramp=0.05)
    ramping = np.arange(500 + 720) < 500
    found = analyze(ideal(design, gear_x=np.where(ramping, 7e-6, 2e-6), gear_vx=np.where(ramping, 7e-3, 2e-3)))
    assert found.q_path.max_error_um == near(2.0, abs=1e-7)
    assert found.ramp.q_path.max_error_um == near(7.0, abs=1e-7)
    assert found.ramp.q_speed.rms_error_mm_s == near(7.0, abs=1e-7)
    assert found.ramp.samples == 500
    jolted = analyze(ideal(design, gear_vx=np.where(np.arange(1220) == 100, 1e-3, 0.0)))
    assert jolted.q_acceleration == analyze(ideal(design)).q_acceleration
    assert jolted.ramp.q_acceleration.max_error_m_s2 == pytest.approx(1e-3 / DT, rel=0.01)
    assert found.window.samples == 670
    assert found.window.crank_turns == near(669 / 360)


def test_one_turn_starts_at_crank_angle_zero_where_it_can():
    design = designed(turns=3)
    degrees = np.rint(np.degrees(series(ideal(design)).crank_angle))
    assert np.array_equal(degrees[series(ideal(design)).one_turn], np.arange(360, 721))
    short = series(ideal(designed(turns=1.5)))
    assert np.array_equal(degrees[short.one_turn], np.arange(50, 411))
    shorter = series(ideal(designed(turns=0.5)))
    assert np.array_equal(degrees[shorter.one_turn], np.arange(50, 180))
    back = series(ideal(designed("drive.speed_rpm=-1666.6666666666667", turns=3)))
    assert np.array_equal(degrees[back.one_turn], np.arange(360, 721))


# --- the series


def test_series_are_locked_and_agree_with_the_findings():
    design = designed()
    run = ideal(design, gear_x=2e-6 * wave(design, 1), gear_angle=ARCSEC * wave(design, 36))
    motion = series(run)
    with pytest.raises(ValueError, match="read-only"):
        motion.q_position.theory[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        motion.q[0] = 1.0
    found = analysis.judge(motion, log="run.mcap")
    assert found == analyze(run, log="run.mcap")
    assert found.q_path.max_error_um == 1e6 * motion.q_position.error_size[motion.hold].max()
    assert found.gear_transmission_error.peak_to_peak_arcsec == near(
        np.ptp(motion.gear_angle.error[motion.hold]) / ARCSEC
    )


def test_the_path_starts_at_q_and_is_that_of_eq_16():
    q = np.array([2e-3, 11e-3])
    motion = series(ideal(designed()), q=q)
    assert motion.q_position.theory[0] == near(q)
    assert motion.q_position.simulated[0] == near(q)
    theta = motion.crank_angle
    point = 1j * ECCENTRICITY * (np.exp(1j * theta) - 1) + np.exp(-1j * theta / LOBES) * complex(*q)
    assert motion.q_position.theory == near(np.stack([point.real, point.imag], axis=1), abs=1e-15)


# --- what is handed on, and how


def test_json_has_exactly_the_agreed_keys_first():
    found = analyze(ideal(designed(ramp=0.05)), log="here/run.mcap").as_json()
    assert list(found)[:14] == [*PLAIN, *KEYS]
    for part, keys in KEYS.items():
        assert list(found[part]) == keys
    assert found["log"] == "here/run.mcap"
    assert found["q_path"]["q_mm"] == [0.0, 26.0]
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_provenance_is_handed_on():
    run = ideal(designed())
    plain = analyze(run)
    assert (plain.design, plain.contact, plain.timestep_s) == ("pin", "profile", 4e-6)
    assert (plain.log, plain.steps, plain.wall_s, plain.complete, plain.note) == (None, None, None, True, "")
    full = replace(
        run, provenance={"timestep_s": "2e-06", "steps": "1800", "wall_s": "3.5"}, complete=False, note="cut"
    )
    told = analyze(full)
    assert (told.contact, told.timestep_s, told.steps, told.wall_s) == (None, 2e-6, 1800, 3.5)
    assert (told.complete, told.note) == (False, "cut")
    bare = analyze(replace(run, provenance={}))
    assert bare.timestep_s == timestep(Reducer(designed()))
    assert pickle.loads(pickle.dumps(told)) == told


def test_the_output_comes_first_and_the_headline_is_its_own():
    design = designed()
    run = ideal(design, output_angle=0.5 * ARCSEC * wave(design, 36), gear_angle=2.0 * ARCSEC * wave(design, 36))
    found = analyze(run, settle=0.0)
    assert found.transmission_error == found.output_transmission_error
    assert found.transmission_error.peak_to_peak_arcsec == near(1.0)
    assert found.gear_transmission_error.peak_to_peak_arcsec == near(4.0)
    groups = analysis.groups(found)
    assert [group.name for group in groups][:5] == ["output", "gear", "path of q", "contacts", "pin 1"]
    assert groups[0].rows[0].quantity == "transmission error of the output, peak to peak"
    assert groups[2].detail == "= (0, 26) mm"
    assert [row for group in groups for row in group.rows] == table(found)


def test_the_table_has_the_values_of_the_findings():
    design = designed("load.torque_nm=35.0", ramp=0.05)
    run = ideal(design, crank_torque=1.25, load_torque=35.0, gear_x=3e-6, gear_y=4e-6, cam_friction_power=0.5)
    rows = {row.quantity: row for row in table(analyze(run))}
    assert rows["gear speed, mean"] == (
        "gear speed, mean",
        "-4.9867",
        "-4.9867",
        rows["gear speed, mean"].error,
        "rad/s",
    )
    assert rows["path of q, hold, largest error"].error == "5"
    assert rows["path of q, ramp, rms error"][3:] == ("5", "um")
    # friction's share and elastic wind-up are no errors
    assert rows["efficiency"][1:] == ("80", "", "", "%")
    assert rows["crank torque, mean"][1:] == ("1.25", "", "", "N m")
    assert rows["crank torque without losses, load / ratio"][1:] == ("", "1", "", "N m")
    assert rows["transmission error of the output, mean (play and wind-up)"].error == ""
    assert rows["loss by friction, cam"].simulated == "0.5"
    without = {row.quantity for row in table(analyze(ideal(designed(preset="nonpin"))))}
    assert not any("pin 1" in name or "efficiency" in name or "ramp" in name for name in without)


# --- runs that cannot be judged, and runs that went wrong


def test_a_run_without_design_is_refused():
    run = ideal(designed())
    with pytest.raises(LogError, match=r"lacks the attached file design.toml"):
        analyze(replace(run, attachments={}))
    with pytest.raises(LogError, match="is not UTF-8 text"):
        analyze(replace(run, attachments={"design.toml": b"\xff\xfe"}))
    with pytest.raises(DesignError, match=r"the run's design\.toml"):
        analyze(replace(run, attachments={"design.toml": b"[ring]\nteeth = 1\n"}))


@pytest.mark.parametrize("missing", ["gear_vx", "load_torque", "pin_1_speed"])
def test_a_run_without_a_needed_column_is_refused(missing):
    run = ideal(designed())
    columns = {name: values for name, values in run.columns.items() if name != missing}
    with pytest.raises(LogError, match=rf"lacks 1 of the 18 columns .*: {missing}\."):
        analyze(replace(run, columns=columns, units=dict.fromkeys(columns, "1"), topics={}))


def test_a_run_that_ended_in_its_ramp_is_judged_over_the_ramp():
    design = designed("load.torque_nm=35.0", ramp=0.05)
    whole = ideal(design, gear_x=3e-6, gear_angle=ARCSEC * 7, crank_torque=2.0, load_torque=35.0)
    for samples in (400, 500, 501):
        cut = replace(whole.select(slice(0, samples)), complete=False, note="stopped by Ctrl-C")
        found = analyze(cut, q=(0.0, 0.0))
        assert (found.window.phase, found.window.start_s, found.window.samples) == ("ramp", 0.0, samples)
        assert found.q_path.rms_error_um == near(3.0, abs=1e-7)
        assert found.gear_transmission_error.mean_arcsec == near(7.0)
        assert found.efficiency is None
        assert "the run is incomplete: stopped by Ctrl-C" in found.warnings
        assert any("ended during the ramp" in warning and "missing" in warning for warning in found.warnings)
        assert not any("hold" in row.quantity for row in table(found))
        json.dumps(found.as_json(), allow_nan=False)
    assert series(whole.select(slice(0, 400))).one_turn.stop == 400
    reached = analyze(whole.select(slice(0, 502)))
    assert (reached.window.phase, reached.window.samples >= 1) == ("hold", True)
    for samples in (0, 1):
        with pytest.raises(LogError, match="usable samples"):
            analyze(whole.select(slice(0, samples)))


def test_a_hold_of_less_than_a_turn_is_warned_of():
    assert analyze(ideal(designed(turns=1)), settle=0.0).warnings == ()
    (warning,) = analyze(ideal(designed(turns=0.9)), settle=0.0).warnings
    assert warning.startswith("only 0.90 crank turns")


def test_findings_name_their_condition():
    found = analyze(ideal(designed("load.torque_nm=35.0", "drive.speed_rpm=-1640")))
    assert found.as_json()["condition"] == {"load_nm": 35.0, "speed_rpm": -1640.0, "friction_law": "coulomb"}
    assert str(found.condition) == "35 N m, -1640 rpm"
    assert str(analyze(ideal(designed("drive.speed_rpm=1640"))).condition) == "no load, 1640 rpm"


@pytest.mark.parametrize("column", ["gear_x", "crank_speed", "pin_1_angle"])
@pytest.mark.filterwarnings("error")
def test_absurd_numbers_are_left_out_without_a_warning_of_numpy(column):
    design = designed(turns=3)
    found = analyze(ideal(design, **{column: np.where(np.arange(1080) >= 700, 1e308, 0.0)}))
    assert found.window.end_s == near(DT * 699)
    assert "left out" in found.note


def test_the_completed_part_of_a_broken_run_is_judged():
    design = designed(turns=3)
    broken = np.where(np.arange(1080) >= 700, np.nan, 0.0)
    run = replace(ideal(design, gear_vx=broken), complete=False, note="stopped: not a number")
    found = analyze(run)
    assert found.window.end_s == near(DT * 699)
    assert found.q_speed.max_error_mm_s == near(0, abs=1e-8)
    assert (
        found.note
        == "stopped: not a number; samples from 0.07 s on were left out: values are not finite or exceed 1e+30"
    )
    json.dumps(found.as_json(), allow_nan=False)
    power = analyze(ideal(design, cam_friction_power=broken))
    assert power.window.end_s == found.window.end_s


@pytest.mark.parametrize("settle", [-1e-9, math.nan])
def test_a_senseless_settling_time_is_refused(settle):
    with pytest.raises(UsageError, match="settling time"):
        analyze(ideal(designed()), settle=settle)


@pytest.mark.parametrize("q", [(0.0,), (0.0, math.inf), 3.0, ((0.0, 1.0), (2.0, 3.0))])
def test_a_senseless_point_is_refused(q):
    with pytest.raises(UsageError, match="the point q is"):
        analyze(ideal(designed()), q=q)


# --- a real run


def test_a_simulated_run_stays_within_its_clearances():
    # closed sockets: out of half-open ones idle pins come farther than their clearance
    design = override(PRESETS["pin"], ["ring.socket=closed", "drive.ramp_s=0.0", "drive.hold_s=0.01"])
    run = simulate(design)
    found = analyze(replace(run, attachments={"design.toml": dump(design).encode()}))
    clearance = design.clearance
    play = 1e6 * (clearance.pin_gear + clearance.pin_socket + clearance.cam)
    touched = found.contact_summary.max_penetration_um
    assert found.crank.max_relative_error < 1e-4
    assert found.gear_speed.theory_rad_s == near(-found.crank.speed_rad_s / 35)
    # the gear turns within its play about the ring, by at most 2 delta / (c (N-1)), and its centre shifts by the cam's
    assert found.q_path.max_error_um < play + (play + touched) * HOLE / (ECCENTRICITY * LOBES)
    assert found.pin1.max_radial_um <= 1e6 * clearance.pin_socket + touched + 1e-9
    assert found.q_speed.max_error_mm_s < 0.01 * 1e3 * ECCENTRICITY * design.drive.speed


@pytest.mark.parametrize("miss", [0.0, 3e-8, -3e-8])
def test_turns_are_complete_if_samples_fall_on_their_ends_except_for_the_servo(miss):
    crank = np.radians(np.arange(3 * 360 + 1.0))
    crank[1:] += miss
    assert [turn.stop - turn.start for turn in turn_by_turn(crank)] == [360] * 3
