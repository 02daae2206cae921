"""The step of the static measures: chosen from mass and force of the pins, halved where a run goes wrong, and named."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from designs import unlike

from cycloid_mj.analysis.warnings import balance_warnings
from cycloid_mj.base.errors import ContactError, RunError
from cycloid_mj.base.record import Run
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.regime import lowest_log_rate
from cycloid_mj.dynamics.settling import swing_period
from cycloid_mj.dynamics.timestep import timestep
from cycloid_mj.measure import bench, hysteresis
from cycloid_mj.measure.steady import REMEDY, run_steady, steady_design
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.friction_path import Losses, follow_torque_path

TEETH21 = unlike("teeth21")
CRANK = float(bench.crank_angles(Reducer(TEETH21), 2)[1])


def test_sticking_pins_allow_a_longer_limited_step_than_sliding_pins():
    rated = TEETH21.rated_torque
    held, sliding = (
        bench.bench_timestep(one, rated, "mujoco")
        for one in (Reducer(TEETH21), bench.without_friction(Reducer(TEETH21)))
    )
    # the least force that friction holds is none: no limit but the longest
    assert sliding < held < bench.BENCH.max_step
    assert bench.bench_timestep(Reducer(TEETH21), 4.0 * rated, "mujoco") < held
    heavier = override(TEETH21, ["material.density_kg_m3=15700"])
    # the weight adds its own to what the pins bear
    assert bench.bench_timestep(Reducer(heavier), rated, "mujoco") == pytest.approx(np.sqrt(2.0) * held, rel=0.01)


def test_planar_steps_grow_with_the_swing_of_a_soft_drive_unless_pins_move():
    soft = Reducer(unlike("nonpin-n33-d2-ring-60um"))
    assert bench.bench_timestep(soft, 1.0) == pytest.approx(swing_period(soft) / bench.BENCH.steps_per_swing)
    assert bench.bench_timestep(soft, 1.0) > 10.0 * bench.BENCH.max_planar_step
    moving = Reducer(override(soft.design, ['ring.kind="pin"', 'ring.pins="free"']))
    assert bench.bench_timestep(moving, 1.0) == bench.BENCH.max_planar_step


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nonpin-n33-d2-ring-60um", "fixed-n31-d1-carrier-250um"])
def test_loops_of_soft_drives_are_those_of_statics_with_friction(name):
    design = unlike(name)
    reducer = Reducer(design).working_at(design.rated_torque)
    crank = float(bench.crank_angles(reducer, 2)[1])
    loop = hysteresis.run_loop(
        reducer, crank, design.rated_torque, hysteresis.quasi_static_period(reducer, design.rated_torque)
    )
    course = np.linspace(0.0, 1.25, 1200)
    torque = design.rated_torque * np.sin(2.0 * np.pi * course) ** hysteresis.LOOP.power
    when, turn = follow_torque_path(reducer, torque, crank, Losses())
    phase = np.interp(when, np.arange(len(course)), course)
    within = phase >= hysteresis.LOOP.lead
    statics = replace(
        loop,
        phase=phase[within],
        torque=np.interp(when, np.arange(len(course)), torque)[within],
        turn=turn[within],
    )
    assert loop.lost_motion == pytest.approx(statics.lost_motion, rel=0.06)
    assert loop.stiffness == pytest.approx(statics.stiffness, rel=0.12)


@pytest.mark.slow
def test_a_run_that_fails_is_repeated_at_half_the_step_and_names_it():
    # 21 free pins of 0.55 g at their rated load: 16 us ends with a contact more than 50 um deep
    rated = TEETH21.rated_torque
    period = hysteresis.quasi_static_period(Reducer(TEETH21), rated)
    finer = bench.bench_timestep(Reducer(TEETH21), rated, "mujoco") / 16e-6
    torque, duration = hysteresis.loop_torque(rated, period), 0.3 * period
    too_long = bench.prepare_bench(Reducer(TEETH21), rated, duration, 100, finer, "mujoco")
    with pytest.raises(RunError, match="penetrates by"):
        bench.locked_run(too_long, CRANK, torque, "mujoco")
    run = bench.run_with_step_retries(Reducer(TEETH21), CRANK, torque, rated, duration, 100, finer, "mujoco")
    halvings = np.log2(16e-6 / bench.timestep_of(run))
    assert halvings == pytest.approx(round(halvings), abs=1e-9)
    assert 1 <= round(halvings) <= bench.BENCH.max_halvings
    assert run["penetration"].max() < 10e-6


@pytest.mark.parametrize("problem", [RunError, ContactError])
def test_the_step_is_halved_so_often_and_then_the_cause_is_named(problem, monkeypatch):
    steps = []

    def failing(benched, crank, torque, solver):
        steps.append(benched.design.settings.timestep)
        raise problem("a contact is deep")

    monkeypatch.setattr(bench, "locked_run", failing)
    with pytest.raises(
        RunError, match=r"57\.3 deg and up to 5 N m .* 3 times to 0\.5 us: a contact is deep\. Reduce the torque"
    ):
        bench.run_with_step_retries(
            Reducer(override(PRESETS["pin"], ["settings.timestep_us=4"])), 1.0, np.zeros_like, 5.0, 0.01, 10
        )
    assert steps == pytest.approx([4e-6, 2e-6, 1e-6, 0.5e-6])


def test_steps_are_named_longest_first():
    runs = [Run(np.zeros(1), {}, {}, {"timestep_s": step}) for step in ("5e-06", "1e-05", "5e-06")]
    assert bench.timesteps_text(runs) == "10 us and 5 us"


def test_runs_of_measures_are_logged_densely_enough_at_any_speed() -> None:
    """At 12 000 rpm 7000 teeth pass a second: 20 kHz would be 3 samples of each, and a warning none could follow."""
    fast = Reducer(override(PRESETS["pin"], ['ring.pins="fixed"', "drive.speed_rpm=12000"]))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = run_steady(steady_design(fast), 1e-3, 4)
    assert not [str(one.message) for one in caught if "log_rate_hz" in str(one.message)]
    rate = 1.0 / float(np.mean(np.diff(run.time)))
    assert rate >= 0.99 * min(lowest_log_rate(fast), 1.0 / timestep(fast))
    own = override(PRESETS["pin"], ["settings.log_rate_hz=50000"])
    assert steady_design(Reducer(own)).design.settings.log_rate == 50e3


def test_the_remedy_of_an_open_balance_is_valid_for_a_measure() -> None:
    """A measure takes no drive.hold_s: its warning names the log rate, which it does take."""
    reducer = Reducer(override(PRESETS["pin"], ['ring.pins="fixed"', "load.torque_nm=30"]))
    run = run_steady(steady_design(reducer), 0.01, 8)
    spoiled = replace(run, columns={**run.columns, "load_torque": 1.5 * run["load_torque"]})
    said = balance_warnings(spoiled, reducer, REMEDY)
    assert said
    assert all("drive.hold_s" not in one for one in said)
    assert any("settings.log_rate_hz to 40000" in one for one in said)
