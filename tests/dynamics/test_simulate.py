"""The run: laws, self-checks, physics at locked crank, other designs, determinism, step independence."""

import mujoco
import numpy as np
import pytest
from designs import cases

from cycloid_mj.analysis import analyze
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.names import gears
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics import drive_cycle
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.drive_cycle import initial_state, load_torque
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import blocks, schedule, simulate
from cycloid_mj.dynamics.timestep import timestep
from cycloid_mj.geometry.kinematics import CrankLaw
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate import rig

QUICK = ["drive.ramp_s=0.0", "drive.hold_s=0.006"]


def changed(*changes: str) -> Design:
    return override(PRESETS["pin"], changes)


def test_schedule_samples_at_the_log_rate() -> None:
    plan = schedule(Reducer(changed("settings.timestep_us=2.0", "drive.ramp_s=0.001", "drive.hold_s=0.001")))
    assert (plan.steps, plan.stride, plan.samples) == (1000, 50, 20)


def test_the_load_rises_without_a_jolt_and_opposes_the_output() -> None:
    design = changed("load.torque_nm=10.0", "load.rise_s=0.01")
    assert load_torque(Reducer(design), [0.0, 0.005, 0.01, 1.0]) == pytest.approx([0.0, 5.0, 10.0, 10.0])
    assert load_torque(Reducer(override(design, ["drive.speed_rpm=-1640.0"])), 1.0) == pytest.approx(-10.0)


def test_the_crank_follows_the_ramp_and_the_gear_follows_the_crank() -> None:
    design = changed("drive.ramp_s=0.02", "drive.hold_s=0.01")
    run = simulate(design)
    law = CrankLaw(design.drive.speed, design.drive.ramp)
    error = run["crank_speed"] - law.speed_at(run.time)
    assert np.abs(error).max() < 2e-4 * design.drive.speed
    slip = run["gear_angle"] + run["crank_angle"] / design.lobes
    backlash = 2e-6 / (design.gear.eccentricity * design.lobes)
    assert 0.0 < np.abs(slip).max() < 3.0 * backlash
    assert run["penetration"].max() < 0.25e-6  # 0.05 um; idle free pins are chaotic


def test_two_runs_are_the_same_bit_for_bit() -> None:
    first, second = (simulate(changed(*QUICK)) for _ in range(2))
    for name in first.columns:
        np.testing.assert_array_equal(first[name], second[name], err_msg=name)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        ("ring.teeth=10", "ring.pin_radius_mm=4.0", "gear.eccentricity_mm=1.5", "output.hole_radius_mm=5.5"),
        ("ring.teeth=20", "ring.pin_radius_mm=3.0"),
        (
            "ring.teeth=60",
            "ring.pin_circle_radius_mm=80.0",
            "housing.outer_radius_mm=95.0",
            "output.pin_circle_radius_mm=50.0",
            "output.pins=12",
        ),
    ],
)
def test_other_designs_run_by_their_own_ratio(changes: tuple[str, ...]) -> None:
    design = changed(*QUICK, *changes)
    run = simulate(design)
    slip = run["gear_angle"] + run["crank_angle"] / design.lobes
    assert np.abs(slip).max() < 6.0 * 2e-6 / (design.gear.eccentricity * design.lobes)
    # backlash and the first jerk of a few degrees: up to 0.14 %, and 0.04 % where closed sockets keep the pins in place
    assert run["gear_angle"][-1] == pytest.approx(-design.drive.speed * run.time[-1] / design.lobes, rel=2e-3)
    assert run["penetration"].max() < 2e-6


@pytest.mark.slow
@pytest.mark.parametrize("pins", cases(["fixed", "free"], "fixed"))
def test_backlash_at_locked_crank(pins: str) -> None:
    """The gear turns by 2 delta/(c (N-1)) from one stop to the other; delta is the sum of clearances in series."""
    clearances = {"fixed": 1e-6, "free": 2e-6}
    design = changed(
        f'ring.pins="{pins}"',
        "clearance.cam_um=0.001",
        "clearance.output_um=100.0",
        "environment.gravity_y_m_s2=0.0",
        "friction.pin_gear=0.0",
        "friction.pin_socket=0.0",
        "drive.rotor_inertia_kg_m2=10.0",
    )
    compiled = build(design)
    stops = []
    for torque in (0.02, -0.02):
        data = mujoco.MjData(compiled.model)
        data.joint("gear_angle").qfrc_applied[0] = torque
        with install():
            for part in range(20):
                # Settled by stopping it now and then, as a hand would.
                data.qvel[:] *= 0.1 if part > 4 else 1.0
                mujoco.mj_step(compiled.model, data, 800)
        stops.append(data.joint("gear_angle").qpos[0])
    expected = 2.0 * clearances[pins] / (design.gear.eccentricity * design.lobes)
    # the torque presses the teeth in: 0.43 % (fixed) and 0.30 % (free)
    assert stops[0] - stops[1] == pytest.approx(expected, rel=0.013)


def test_friction_power_explains_the_loss() -> None:
    """Fixed pins under load: input minus output power is what sliding and contact damping take."""
    design = changed('ring.pins="fixed"', "drive.ramp_s=0.0", "drive.hold_s=0.03", "load.torque_nm=36.0")
    run = simulate(design)
    steady = run.select(run.time > 0.01)
    power_in = np.mean(steady["crank_torque"] * steady["crank_speed"])
    power_out = -np.mean(steady["load_torque"] * steady["output_speed"])
    lost = sum(np.mean(steady[f"{kind}_friction_power"]) for kind in ("pin_gear", "cam", "output"))
    assert power_in - power_out > 0.05 * power_in
    # what is left is stored: the window ends within a mesh period; 0.009 %
    assert lost == pytest.approx(power_in - power_out, rel=3e-4)


def test_no_friction_loses_nothing() -> None:
    design = changed(
        'ring.pins="fixed"',
        "drive.ramp_s=0.0",
        "drive.hold_s=0.03",
        "load.torque_nm=36.0",
        *rig.without_friction(),
    )
    run = simulate(design)
    steady = run.select(run.time > 0.01)
    power_in = np.mean(steady["crank_torque"] * steady["crank_speed"])
    power_out = -np.mean(steady["load_torque"] * steady["output_speed"])
    assert power_out / power_in == pytest.approx(1.0, abs=6e-5)  # 2e-5: damping, and a mesh period that is cut


def ended(design: Design) -> tuple[int, str]:
    """Samples given before the end, and the error."""
    compiled = build(design)
    given: list[int] = []
    with pytest.raises(RunError) as error:
        given.extend(len(block.time) for block in blocks(compiled, Reducer(design)))
    return sum(given), str(error.value)


def test_a_deep_contact_ends_the_run() -> None:
    samples, message = ended(changed(*QUICK, "load.torque_nm=36.0", "contact.max_penetration_um=1.0"))
    assert samples > 1
    assert "max_penetration_um" in message


def test_a_jumped_tooth_ends_the_run() -> None:
    changes = [
        *QUICK,
        "load.torque_nm=20000.0",
        "contact.working_force_n=100",
        "load.rise_s=0.001",
        "contact.max_penetration_um=1000.0",
        'ring.pins="fixed"',
    ]
    samples, message = ended(changed(*changes))
    assert samples > 1
    assert "skipped a tooth" in message or "penetrates" in message


def test_a_step_too_long_ends_the_run(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    _, message = ended(
        changed("drive.ramp_s=0.0", "drive.hold_s=0.2", "settings.timestep_us=60.0", "load.torque_nm=36")
    )
    assert "timestep_us" in message
    assert not list(tmp_path.iterdir()), "MuJoCo's own log file is not wanted"


def test_a_nan_ends_the_run(monkeypatch) -> None:
    monkeypatch.setattr(drive_cycle, "servo_target", lambda compiled, law, time: np.where(time > 1e-3, np.nan, 0.0))
    samples, message = ended(changed(*QUICK))
    assert samples > 1
    assert "NaN" in message or "issued a warning" in message


def measured(design: Design) -> dict[str, float]:
    """Figures that must not depend on the step."""
    found = analyze(simulate(design))
    assert found.efficiency is not None
    error = found.gear_transmission_error
    return {
        "efficiency": found.efficiency,
        "mean": error.mean_arcsec,
        "peak_to_peak": error.peak_to_peak_arcsec,
        "rms": found.gear_speed.rms_error_rad_s,
    }


@pytest.mark.slow
@pytest.mark.parametrize(("load", "hold", "points", "share"), [(36.0, 0.2, 1.7e-4, 0.066), (1.0, 0.8, 1.7e-4, 0.19)])
def test_figures_do_not_change_with_half_the_time_step(load: float, hold: float, points: float, share: float) -> None:
    """Pins chatter: 5.6e-5 and 4.4e-5 of efficiency, 2.2 and 6.3 % of the rms speed error, the others 0.4 %."""
    changes = ["drive.ramp_s=0.0", f"drive.hold_s={hold}", f"load.torque_nm={load}"]
    step = timestep(Reducer(changed(*changes)))
    whole, half = (measured(changed(*changes, f"settings.timestep_us={1e6 * step / k!r}")) for k in (1, 2))
    assert whole["efficiency"] == pytest.approx(half["efficiency"], abs=points)
    for name in ("mean", "peak_to_peak", "rms"):
        assert whole[name] == pytest.approx(half[name], rel=share if name == "rms" else 0.012), name


def test_initial_state_without_a_ramp_is_the_closed_form() -> None:
    design = changed(*QUICK)
    data = initial_state(build(design), Reducer(design))
    assert data.joint("gear_x").qvel[0] == pytest.approx(-design.gear.eccentricity * design.drive.speed)
    assert data.joint("output").qvel[0] == pytest.approx(-design.drive.speed / design.lobes)


@pytest.mark.parametrize("preset", ["pin", "twodisc"])
def test_the_log_has_the_point_q(preset):
    """Where the gear carries the middle of its first output hole, and as fast as that place changes."""
    design = override(PRESETS[preset], ["drive.ramp_s=0", "drive.hold_s=0.002", "settings.log_rate_hz=100000"])
    run = simulate(design)
    gear = gears(design.gear.discs)[0]
    arm, turn = design.output.pin_circle_radius, run[f"{gear}_angle"]
    assert run["q_x"] == pytest.approx(run[f"{gear}_x"] - arm * np.sin(turn), abs=1e-15)
    assert run["q_y"] == pytest.approx(run[f"{gear}_y"] + arm * np.cos(turn), abs=1e-15)
    for axis in "xy":
        place, speed = run[f"q_{axis}"], run[f"q_v{axis}"]
        # between two samples, but where an impact falls between them
        off = np.diff(place) / np.diff(run.time) - 0.5 * (speed[1:] + speed[:-1])
        assert np.median(np.abs(off)) < 1e-3 * np.abs(speed).max()
    assert [run.units[name] for name in ("q_x", "q_y", "q_vx", "q_vy")] == ["m", "m", "m/s", "m/s"]
    assert {"q_x", "q_y", "q_vx", "q_vy"} <= set(run.topics["/reducer"])
