"""The constraint solver of a model: which one is taken, and that both find the same motion."""

import copy
from typing import Any

import mujoco
import numpy as np
import pytest
from designs import unlike

from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.contact.each_step import EachStep
from cycloid_mj.dynamics.contact.forces import pair_index
from cycloid_mj.dynamics.drive_cycle import initial_state, ramp_and_hold
from cycloid_mj.dynamics.mjcf import build, unused
from cycloid_mj.dynamics.run import disc_freedoms, schedule, simulate
from cycloid_mj.reducer import Reducer

NEWTON, CG = mujoco.mjtSolver.mjSOL_NEWTON, mujoco.mjtSolver.mjSOL_CG
NO_ISLANDS = int(mujoco.mjtDisableBit.mjDSBL_ISLAND)


@pytest.mark.parametrize(
    ("design", "step", "solver"),
    [
        (PRESETS["pin"], 0.5, CG),
        (PRESETS["pin"], 1.0, NEWTON),
        (PRESETS["pin"], 0.0, NEWTON),
        (PRESETS["nonpin"], 0.5, NEWTON),
        (unlike("few"), 0.5, CG),
        (unlike("large"), 0.5, CG),
        (unlike("large"), 5.0, NEWTON),
        (unlike("printed"), 0.5, NEWTON),
    ],
    ids=lambda value: value.name if isinstance(value, Design) else str(value),
)
def test_gradients_are_taken_where_the_step_resolves_moving_pins(design: Design, step: float, solver: int) -> None:
    option = build(override(design, [f"settings.timestep_us={step}"])).model.opt
    assert option.solver == solver
    assert (option.jacobian == mujoco.mjtJacobian.mjJAC_SPARSE) == design.ring.has_moving_pins


@pytest.mark.parametrize(
    ("design", "load", "islands"),
    [
        (PRESETS["pin"], 0.0, False),
        (PRESETS["pin"], 10.0, True),
        (unlike("large"), -10.0, True),
        (PRESETS["nonpin"], 10.0, False),
    ],
    ids=lambda value: value.name if isinstance(value, Design) else str(value),
)
def test_islands_are_used_only_if_unloaded_pins_can_be_omitted(design: Design, load: float, islands: bool) -> None:
    flags = build(override(design, [f"load.torque_nm={load}"])).model.opt.disableflags
    assert bool(flags & NO_ISLANDS) != islands


@pytest.mark.parametrize("name", ["pin", "few", "large"])
def test_both_solvers_compute_the_same_forces_with_and_without_islands(name: str) -> None:
    """From one state: a run between flanks is chaotic, and two that differ by a rounding part ways."""
    design = PRESETS["pin"] if name == "pin" else unlike(name)
    load = design.drive.torque * design.lobes
    changes = ["drive.ramp_s=0", "load.rise_s=0.0005", f"load.torque_nm={load}", "settings.timestep_us=0.5"]
    design = override(design, changes)
    compiled = build(design)
    course = ramp_and_hold(compiled, Reducer(design))
    data = initial_state(compiled, Reducer(design), course)
    model, worst, loaded, islands = compiled.model, 0.0, 0, 0
    with install():
        for step, command in enumerate(course.commands(compiled.model.opt.timestep * np.arange(2000))):
            data.ctrl[:] = command
            mujoco.mj_step(model, data)
            if step % 100 == 99 and data.nefc:
                known, *others = (
                    _forces(model, data, *how) for how in ((NEWTON, NO_ISLANDS), (CG, NO_ISLANDS), (NEWTON, 0))
                )
                scale = np.abs(known).max()
                loaded += scale > 1.0
                islands = max(islands, data.nisland)
                worst = max(worst, *(float(np.abs(forces - known).max()) / scale for forces in others))
    assert loaded > 10
    assert islands > 1
    assert worst < 1e-9


def _forces(model: Any, data: Any, solver: int, islands: int) -> Any:
    """Find the constraint forces of a state with a solver, on a copy that does not start from the known answer."""
    option, other = model.opt, copy.copy(data)
    before = option.solver, option.disableflags
    other.qacc_warmstart[:] = 0.0
    option.solver, option.disableflags = solver, (option.disableflags & ~NO_ISLANDS) | islands
    mujoco.mj_forward(model, other)
    option.solver, option.disableflags = before
    return other.efc_force.copy()


def test_a_run_leaves_out_what_its_model_has_nothing_for() -> None:
    dragged = build(override(PRESETS["nonpin"], ["drag.crank_nm=0.05"])).model
    plain = build(PRESETS["nonpin"]).model
    friction = int(mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS)
    assert unused.unused_flags(plain) == unused.unused_flags(dragged) | friction
    assert not unused.unused_flags(dragged) & friction
    damper = int(mujoco.mjtDisableBit.mjDSBL_DAMPER)
    before = plain.opt.disableflags
    with unused.disable_unused(plain), unused.disable_unused(plain):
        assert plain.opt.disableflags & damper
    assert plain.opt.disableflags == before
    plain.dof_damping[0] = 1.0
    with unused.disable_unused(plain):
        assert not plain.opt.disableflags & damper


@pytest.mark.parametrize("name", ["pin", "nonpin"])
def test_omitted_islands_change_no_result(name: str) -> None:
    changes = ["drive.ramp_s=0", "drive.hold_s=0.002", "load.torque_nm=20", "load.rise_s=0.0005"]
    design = override(PRESETS[name], [*changes, "settings.log_rate_hz=20000"])
    run, compiled = simulate(design), build(design)
    course, plan = ramp_and_hold(compiled, Reducer(design)), schedule(Reducer(design))
    data = initial_state(compiled, Reducer(design), course)
    last = (plan.samples - 1) * plan.stride
    # what corrects the references of circling discs needs to know which freedoms these have
    index = pair_index(compiled.model, compiled.pairs)
    kept = EachStep(compiled.model, data, index, orbit_dofs=disc_freedoms(compiled.model, Reducer(design)))
    with install():
        for command in course.commands(plan.timestep * np.arange(last + 1)):
            data.ctrl[:] = command
            mujoco.mj_step(compiled.model, data)
    assert run["gear_angle"][-1] == data.sensor("gear_angle").data[0]
    assert run["crank_torque"][-1] == data.sensor("crank_torque").data[0]
    del kept  # MuJoCo has its address
