"""Drag of seals and friction of bearings: against closed forms, and in the energy balance."""

import numpy as np
import pytest

from cycloid_mj.base.powers import mean_powers
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.measure.closed_form import ideal_efficiency, ideal_limit
from cycloid_mj.measure.conditions import STEADY
from cycloid_mj.measure.steady import first_half as shorter
from cycloid_mj.measure.steady import run_steady, steady_design
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate.energy import balance

LOADED = steady_design(Reducer(override(PRESETS["nonpin"], ["load.torque_nm=36.68"])))
DRAGGED = ["drag.crank_nm=0.05", "drag.output_nm=1.0"]
PERIODS = 4


@pytest.fixture(scope="module")
def dragged():
    return run_steady(Reducer(override(LOADED.design, DRAGGED)), STEADY.settling_time, PERIODS)


def test_drag_power_is_torque_times_speed(dragged):
    crank, output = (np.abs(dragged[f"{shaft}_speed"]) for shaft in ("crank", "output"))
    assert dragged["crank_drag_friction_power"] == pytest.approx(0.05 * crank, rel=1e-9)
    assert dragged["output_drag_friction_power"] == pytest.approx(1.0 * output, rel=1e-9)


def test_balance_closes_with_drag_and_bearings(dragged):
    # 0.01 % of the input, at the log's own rate; without the drag's columns it is off by the drag's 6 %
    found = balance(dragged)
    assert found.total_output == pytest.approx(found.supplied, rel=1e-4)
    assert abs(mean_powers(dragged).residual) < 1e-4
    losses = mean_powers(dragged).friction
    assert set(losses) == {"tooth", "cam", "output", "crank_drag", "output_drag"}
    assert all(power > 0.0 for power in losses.values())
    left_out = losses["crank_drag"] + losses["output_drag"]
    assert left_out / mean_powers(dragged).supplied > 0.05


def test_a_design_without_drag_has_no_columns_of_it():
    run = run_steady(LOADED, STEADY.settling_time, 1)
    assert not [name for name in run.columns if "drag" in name]
    assert not build(LOADED.design).model.dof_frictionloss.any()


@pytest.mark.slow
def test_drag_and_bearing_losses_match_closed_form():
    # ideal sharing: fixed teeth, next to no clearance, a stiff cam
    for changes in ([], DRAGGED, ["friction.cam_rolling=0.004"]):
        design = override(LOADED.design, changes)
        found = mean_powers(run_steady(ideal_limit(Reducer(design)), STEADY.settling_time, PERIODS))
        assert found.efficiency == pytest.approx(ideal_efficiency(Reducer(design), 36.68).efficiency, abs=0.005)
    without = ideal_efficiency(Reducer(override(LOADED.design, ["friction.cam_rolling=0.0"])), 36.68).efficiency
    assert without - ideal_efficiency(LOADED, 36.68).efficiency > 0.03


def test_bearing_acts_at_the_radius_of_the_cam():
    # 0.5 mu P d of the catalogues, at the relative speed of cam and gear
    run = run_steady(LOADED, STEADY.settling_time, PERIODS)
    force = np.hypot(run["cam_force_x"], run["cam_force_y"])
    relative = np.abs(run["crank_speed"] - run["gear_speed"])
    asked = LOADED.design.friction.cam_rolling * LOADED.design.gear.bore_radius * np.mean(force * relative)
    assert np.mean(run["cam_friction_power"]) == pytest.approx(asked, rel=1e-3)


@pytest.mark.parametrize("timestep_us", [5.0, 2.5])
def test_drag_holds_at_half_the_step(timestep_us, dragged):
    design = override(LOADED.design, [*DRAGGED, f"settings.timestep_us={timestep_us}"])
    found = mean_powers(run_steady(Reducer(design), STEADY.settling_time, PERIODS))
    assert found.efficiency == pytest.approx(mean_powers(dragged).efficiency, abs=2e-4)


@pytest.mark.slow
def test_seals_hold_a_shaft_at_rest():
    # less torque than the seals': the output stays, but for the creep of the constraint
    resting = override(
        LOADED.design, ["drive.speed_rpm=0.0", "load.torque_nm=0.5", "drag.output_nm=1.0", "drive.hold_s=0.02"]
    )
    from cycloid_mj.dynamics.run import simulate

    speeds = [
        np.max(np.abs(shorter(simulate(design))["output_speed"]))
        for design in (resting, override(resting, ["drag.output_nm=0.0"]))
    ]
    assert speeds[0] < 0.1 * speeds[1]
