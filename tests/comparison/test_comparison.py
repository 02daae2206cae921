"""Measures of synthetic runs with known waves, and every comparison that must be refused."""

import json
import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from ideal import ideal_mechanism
from trials import (
    DT,
    HOLE,
    LOBES,
    SPEED,
    TURNS,
    designed,
    motion_of,
    pair,
    started_pair,
    trial_of,
    waving,
)

from cycloid_mj.base.errors import LogError, UsageError
from cycloid_mj.comparison import (
    STARTS,
    SWEEP,
    Trial,
    apply_conditions,
    compare,
    gravity_turn,
    independent_starts,
    measure_run,
    settle_run,
    settling_time,
)
from cycloid_mj.comparison.conditions import conditions, differences
from cycloid_mj.comparison.fluctuation import Level, compute_level, full_turns, remove_steady_shifts
from cycloid_mj.comparison.forces import cam_force, tooth_forces
from cycloid_mj.comparison.sensitivity import ASSUMPTIONS, Sensitivity, SensitivityPoint, sensitivities
from cycloid_mj.comparison.vibration import acceleration, spectrum
from cycloid_mj.design import PRESETS, override
from cycloid_mj.reducer import Reducer

# --- fluctuation


def test_settling_is_the_loads_rise_its_ringing_and_a_turn():
    design = designed("pin")
    assert settling_time(Reducer(design)) == pytest.approx(0.005 + 0.005 + 360 * DT)
    assert settling_time(Reducer(override(design, ["drive.ramp_s=0.1"]))) == pytest.approx(0.005 + 360 * DT)


def test_turns_are_whole_and_follow_one_another():
    parts = full_turns(motion_of())
    assert len(parts) == TURNS
    assert [part.stop - part.start for part in parts] == [360] * TURNS
    assert all(one.stop == other.start for one, other in pairwise(parts))


def test_a_hold_of_less_than_a_turn_is_not_divided():
    motion = settle_run(ideal_mechanism(designed("pin", turns=0.5)))
    (part,) = full_turns(motion)
    assert part == slice(int(np.argmax(motion.hold)), len(motion.run))


def test_level_of_parts_and_of_vectors():
    parts = [slice(0, 2), slice(2, 4)]
    found = compute_level(np.array([3.0, -3.0, 4.0, 4.0, 99.0]), parts)
    assert found == Level(pytest.approx(math.sqrt(12.5)), (pytest.approx(3.0), pytest.approx(4.0)))
    assert compute_level(np.array([[3.0, 4.0]] * 4), parts) == Level(5.0, (5.0, 5.0))


def test_steady_shifts_are_no_fluctuation_but_waves_are():
    """The three frames are removed but for rounding; the mesh order is kept but for an end effect of 1/36.

    It is orthogonal over whole turns to two of the frames, and nearly so to the slow one of the gear.
    """
    theta = np.radians(np.arange(0.0, 5 * 360.0))
    shifts = 2 + 1j - 3j * np.exp(1j * theta) + 0.5 * np.exp(-1j * theta / LOBES)
    wave = 0.01 * np.exp(36j * theta)
    for found, left, tolerance in ((shifts, 0 * wave, 1e-12), (shifts + wave, wave, 0.01 / 36)):
        result = remove_steady_shifts(np.stack([found.real, found.imag], axis=1), theta, -theta / LOBES)
        assert result == pytest.approx(np.stack([left.real, left.imag], axis=1), abs=tolerance)


def test_measures_of_known_waves():
    """Each rms value has its closed form; a wave on the gear's angle moves q by its arm."""
    amplitude = 1e-6
    found = measure_run(
        motion_of(
            gear_speed=lambda theta: 0.003 * np.cos(7 * theta),
            gear_angle=lambda theta: amplitude * np.cos(40 * theta),
            gear_vx=lambda theta: 1e-3 * np.cos(50 * theta),
        )
    ).fluctuation
    assert found.gear_speed_rad_s.rms == pytest.approx(0.003 / math.sqrt(2), rel=1e-6)
    assert len(found.gear_speed_rad_s.by_turn) == TURNS
    assert found.q_path_um.rms == pytest.approx(1e6 * amplitude * HOLE / math.sqrt(2), rel=1e-3)
    speed_of_q = math.hypot(0.003 * HOLE, 1e-3) / math.sqrt(2)
    assert found.q_velocity_mm_s.rms == pytest.approx(1e3 * speed_of_q, rel=0.01)


def test_a_rough_turn_shows():
    def burst(theta):
        settled_turn = (theta - SPEED * settling_time(Reducer(designed("pin")))) / (2 * np.pi)
        return np.where((settled_turn >= 2) & (settled_turn < 3), 0.01, 0.001) * np.cos(10 * theta)

    found = measure_run(motion_of(gear_speed=burst)).fluctuation.gear_speed_rad_s
    calm, rough = 0.001 / math.sqrt(2), 0.01 / math.sqrt(2)
    assert found.by_turn == pytest.approx([calm, calm, rough, calm, calm, calm], rel=0.01)


# --- vibration


def test_acceleration_is_zero_on_the_closed_form_and_exact_on_a_ramp_of_the_error():
    """The difference of a linear error is its slope; the closed form itself leaves rounding."""
    none = acceleration(motion_of())
    assert np.abs(none.centre).max() < 1e-9
    assert np.abs(none.output).max() < 1e-9
    found = acceleration(motion_of(gear_vy=lambda theta: 0.25 * theta / SPEED, output_speed=lambda t: 3 * t / SPEED))
    assert found.centre == pytest.approx(np.broadcast_to([0.0, 0.25], found.centre.shape), abs=1e-9)
    assert found.output == pytest.approx(np.full_like(found.output, 3.0), abs=1e-9)


def test_vibration_of_a_wave_and_its_spectrum():
    """Mean acceleration over a sample is that of the wave times sinc; the density makes it good and adds up."""
    order = 36
    omega = order * SPEED
    motion = motion_of(gear_vx=lambda theta: 0.01 * np.sin(order * theta), output_speed=lambda t: 0.2 * np.sin(4 * t))
    found, density = measure_run(motion).vibration, spectrum(motion)
    sinc = math.sin(omega * DT / 2) / (omega * DT / 2)
    expected = 0.01 * omega * sinc / math.sqrt(2)
    assert found.gear_centre_m_s2.rms == pytest.approx(expected, rel=1e-3)
    assert found.band_hz == pytest.approx(0.5 / DT)
    width = density.frequency[1] - density.frequency[0]
    assert math.sqrt(width * density.centre.sum()) == pytest.approx(expected / sinc, rel=5e-3)
    assert density.frequency[-1] <= 0.4 / DT
    assert density.frequency[np.argmax(density.centre)] == pytest.approx(omega / (2 * np.pi), abs=width)
    assert density.frequency[np.argmax(density.output)] == pytest.approx(4 * SPEED / (2 * np.pi), abs=width)


def test_octave_bands_hold_the_wave_that_lies_in_them():
    motion = motion_of(gear_vx=lambda theta: 0.01 * np.sin(36 * theta))
    found = measure_run(motion).vibration
    loudest = max(found.octaves, key=lambda band: band.gear_centre_m_s2)
    assert loudest.centre_hz == 1000.0  # 36 * 27.8 Hz
    assert loudest.gear_centre_m_s2 == pytest.approx(0.01 * 36 * SPEED / math.sqrt(2), rel=0.01)
    assert found.octaves[-1].centre_hz * math.sqrt(2) < found.band_hz


# --- forces


def test_forces_of_known_columns():
    """Half of the samples have two loaded teeth, the others one; a force of 3 and 4 N has the size 5 N."""

    def half(theta):
        return (np.arange(theta.size) % 2).astype(float)

    forces = {"pin_3_force_x": 3.0, "pin_3_force_y": -4.0, "pin_30_force_y": lambda theta: 10.0 * half(theta)}
    motion = motion_of(**forces, cam_force_x=7.0, output_pin_8_force_y=-2.0)
    found = measure_run(motion).forces
    assert (found.teeth_mean, found.teeth_least, found.teeth_most) == (1.5, 1, 2)
    assert (found.tooth_mean_n, found.tooth_peak_n) == (pytest.approx(7.5), 10.0)
    assert (found.cam_mean_n, found.cam_peak_n, found.output_pin_peak_n) == (7.0, 7.0, 2.0)
    assert tooth_forces(motion).shape == (len(motion.run), 36)
    assert (cam_force(motion) == 7.0).all()


def test_forces_of_a_ring_are_those_of_its_lobes():
    assert measure_run(motion_of("nonpin", lobe_36_force_y=-9.0)).forces.tooth_peak_n == 9.0


def test_a_run_without_forces_is_refused():
    run = ideal_mechanism(designed("pin"))
    columns = {name: values for name, values in run.columns.items() if not name.startswith("cam")}
    bare = replace(run, columns=columns, units={name: run.units[name] for name in columns}, topics={})
    with pytest.raises(LogError, match="no contact forces of kind 'cam'"):
        measure_run(settle_run(bare))


# --- conditions


def test_under_changes_conditions_only():
    first = designed("pin", "settings.timestep_us=3.0", "environment.gravity_y_m_s2=0.0", "load.rise_s=0.01")
    other = override(PRESETS["nonpin"], ["contact.damping_ratio=0.2", "drive.torque_nm=5.0"])
    found = apply_conditions(Reducer(other), conditions(Reducer(first)), 12.5)
    assert conditions(Reducer(found)) == conditions(Reducer(first))
    assert found.load.torque == 12.5
    assert found.drive.torque == 5.0
    assert (found.ring, found.contact, found.gear) == (other.ring, other.contact, other.gear)


def test_differences_are_reported_in_the_words_of_the_file():
    first, second = designed("pin"), designed("nonpin", "clearance.tooth_um=2.0", "load.torque_nm=3.0")
    assert differences([first, second]) == {"ring.kind": ("pin", "nonpin"), "clearance.tooth_um": (1.0, 2.0)}


# --- comparison


def test_comparison_orders_its_runs():
    trials = pair(20.0) + pair(0.0, pin=0.001, nonpin=0.002)
    found = compare(trials)
    assert found.designs == ("pin", "nonpin")
    assert found.loads == (0.0, 20.0)
    assert [(trial.load, trial.name) for trial in found.trials] == [
        (load, name) for load in (0.0, 20.0) for name in ("pin", "nonpin")
    ]
    assert found.differences == {"ring.kind": ("pin", "nonpin")}


def test_idle_figures_are_stated_over_the_starts():
    found = compare([*started_pair(), *pair(20.0)])
    rows = found.tables[0].cells
    least, mean, most = (value / math.sqrt(2) for value in (0.004, 0.00435, 0.0047))
    words = next(row[1] for row in rows if row[0] == "gear speed error, rms")
    assert words == f"{least:.3g} to {most:.3g} ({mean:.3g})"
    idle, loaded = (found.as_json()["runs"][place] for place in (0, 2))
    (spread,) = (each for each in idle["spreads"] if each["quantity"] == "gear speed error, rms")
    assert (spread["unit"], len(spread["values"])) == ("rad/s", STARTS)
    assert [spread[key] for key in ("least", "mean", "largest")] == pytest.approx([least, mean, most])
    assert (idle["starts"], loaded["starts"], loaded["spreads"]) == (STARTS, 1, [])


def test_idle_runs_may_be_shorter_if_all_runs_of_a_load_are():
    longer = designed("pin", turns=TURNS + 2).drive.hold
    assert compare([*pair(0.0), *(with_hold(trial, longer) for trial in pair(20.0))]).loads == (0.0, 20.0)
    first, second = pair(20.0)
    with pytest.raises(UsageError, match=r"drive\.hold_s"):
        compare([*pair(0.0), first, with_hold(second, longer)])


def by_planar(trial: Trial) -> Trial:
    return replace(trial, measures=replace(trial.measures, findings=replace(trial.measures.findings, solver="planar")))


def with_hold(trial: Trial, hold: float) -> Trial:
    return replace(trial, design=override(trial.design, [f"drive.hold_s={hold!r}"]))


# --- starts


@pytest.mark.parametrize("teeth", [36, STARTS, 5])
def test_starts_differ_only_in_the_direction_of_gravity(teeth):
    design = override(PRESETS["pin"], [f"ring.teeth={teeth}"])
    found = independent_starts(Reducer(design))
    assert len(found) == STARTS
    assert found[0] == design
    pull = design.environment
    for one in found[1:]:
        assert set(differences([design, one])) <= {"environment.gravity_x_m_s2", "environment.gravity_y_m_s2"}
        turned = one.environment
        assert math.hypot(turned.gravity_x, turned.gravity_y) == pytest.approx(
            math.hypot(pull.gravity_x, pull.gravity_y)
        )
    angles = np.array([gravity_turn(Reducer(one)) for one in found])
    # to the next whole pitch, where there are as many
    within = math.pi / teeth + 1e-9 if teeth > STARTS else 1e-9
    assert angles == pytest.approx(2 * math.pi * np.arange(STARTS) / STARTS, abs=within)


def test_without_gravity_in_its_plane_a_design_has_one_start():
    design = override(PRESETS["pin"], ["environment.gravity_x_m_s2=0.0", "environment.gravity_y_m_s2=0.0"])
    assert independent_starts(Reducer(design)) == (design,)


def test_json_of_a_comparison_is_plain_and_complete():
    found = compare(pair(20.0)).as_json()
    again = json.loads(json.dumps(found, allow_nan=False))
    assert again == found
    run = found["runs"][0]
    assert (run["design"], run["load_nm"], run["findings"]["log"]) == ("pin", 20.0, "pin.mcap")
    assert run["fluctuation"]["gear_speed_rad_s"]["rms"] == pytest.approx(0.002 / math.sqrt(2), rel=1e-6)
    assert {"gear_centre_m_s2", "output_rad_s2", "band_hz", "octaves"} == set(run["vibration"])


def test_table_has_a_column_for_each_design_and_no_empty_row():
    found = compare(pair(20.0))
    (told,) = found.tables
    rows = told.cells
    assert told.header == ("quantity", "pin", "nonpin", "unit")
    by_name = {row[0]: row[1:] for row in rows}
    assert by_name["gear speed error, rms"] == ["0.001414", "0.0007071", "rad/s"]
    assert "efficiency" not in by_name
    assert all(any(row[1:-1]) for row in rows)


def test_designs_of_one_kind_are_compared():
    other = trial_of("pin", "name=rough", "friction.pin_gear=0.1", gear_speed=waving(0.001))
    found = compare([trial_of("pin"), other])
    assert found.differences == {"friction.pin_gear": (0.05, 0.1)}


@pytest.mark.parametrize(
    ("trials", "words"),
    [
        (lambda: pair()[:1], "needs at least two designs"),
        (lambda: [*pair(), pair()[0]], "2 times"),
        (lambda: [*pair(0.0), pair(20.0)[0]], "nonpin at 20 N m is missing"),
        (lambda: [pair()[0], trial_of("nonpin", "settings.timestep_us=4.0")], "settings.timestep_us"),
        (lambda: [pair()[0], trial_of("nonpin", "load.rise_s=0.004")], "load.rise_s"),
        (lambda: [pair()[0], by_planar(pair()[1])], "pin by MuJoCo and nonpin by the planar solver"),
        (lambda: [*pair(), trial_of("pin", "load.torque_nm=5.0", "gear.face_width_mm=9.0")], "two designs are named"),
    ],
)
def test_incomparable_trials_are_refused(trials, words):
    with pytest.raises(UsageError, match=words):
        compare(trials())


# --- sensitivity


def test_sensitivity_states_the_change_with_each_assumption():
    base = pair(20.0)
    creep, damping = ASSUMPTIONS
    found = sensitivities(base, {creep: pair(20.0, pin=0.0029, nonpin=0.0012), damping: pair(20.0, pin=0.005)})
    (speed,) = (each for each in found if (each.design, each.quantity) == ("pin", "gear speed error, rms"))
    assert [(one.parameter, one.value) for one in speed.responses] == [
        ("creep speed", "20 mm/s"),
        ("damping ratio", "0.1"),
    ]
    assert speed.changes == pytest.approx((0.45, 1.5))
    assert not speed.is_determined  # 0.005 is more than twice 0.002
    (other,) = (each for each in found if (each.design, each.quantity) == ("nonpin", "gear speed error, rms"))
    assert other.changes == pytest.approx((0.2, 0.0))
    assert other.is_determined
    table = compare(base, sensitivity=found).tables[-1]
    assert table.header == ("quantity", "pin", "nonpin")
    told = {row[0]: row[1:] for row in table.cells}
    assert told["gear speed error, rms"] == ["not determined: x 1.4, 2.5", "+20 %, +0 %"]
    as_json = compare(base, sensitivity=found).as_json()["sensitivity"]
    assert as_json == json.loads(json.dumps(as_json, allow_nan=False))


@pytest.mark.parametrize(
    ("figure", "changed", "determined"),
    [(1.0, 1.9, True), (1.0, 0.55, True), (1.0, 2.1, False), (1.0, -0.9, False), (0.0, 0.0, True), (0.0, 1.0, False)],
)
def test_a_figure_is_determined_within_a_factor_of_two_and_by_its_sign(figure, changed, determined):
    responses = (SensitivityPoint("creep speed", "1 mm/s", changed),)
    assert Sensitivity("spin", "rad/s", "pin", 36.0, figure, responses).is_determined == determined


def test_a_figure_that_the_repeated_runs_lack_has_no_changes():
    alone = Sensitivity("efficiency", "%", "pin", 36.0, 90.0, ())
    assert (alone.changes, alone.is_determined) == ((), True)


def test_assumptions_change_what_they_name_only():
    for variation, key in zip(ASSUMPTIONS, ("contact.creep_speed_mm_s", "contact.damping_ratio"), strict=True):
        assert list(differences([PRESETS["pin"], variation.of(Reducer(PRESETS["pin"]))])) == [key]


# --- sweep


def test_variations_change_what_they_name_only():
    pin, nonpin = PRESETS["pin"], PRESETS["nonpin"]
    assert {variation.parameter for variation in SWEEP} == {"damping", "friction", "pins"}
    for variation in SWEEP:
        changed = differences([pin, variation.of(Reducer(pin))])
        assert changed
        assert all(key.startswith(("contact.damping", "friction.", "ring.pins")) for key in changed)
        assert (variation.of(Reducer(nonpin)) == nonpin) == (variation.parameter == "pins")
