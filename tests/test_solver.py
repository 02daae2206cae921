"""The constraint solver of a model: which one is taken, and that both find the same motion."""

import copy
from typing import Any

import mujoco
import numpy as np
import pytest
from designs import unlike

from cycloid_mj.contact.collider import installed
from cycloid_mj.course import initial_state, ramp_and_hold
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.mjcf import build

NEWTON, CG = mujoco.mjtSolver.mjSOL_NEWTON, mujoco.mjtSolver.mjSOL_CG
NO_ISLANDS = int(mujoco.mjtDisableBit.mjDSBL_ISLAND)


@pytest.mark.parametrize(
    ("design", "step", "solver"),
    [
        (PRESETS["pin"], 0.5, CG),
        (PRESETS["pin"], 1.0, NEWTON),
        (PRESETS["pin"], 0.0, NEWTON),
        (PRESETS["nonpin"], 0.0, CG),
        (PRESETS["twodisc"], 0.0, CG),
        (unlike("few"), 0.5, CG),
        (unlike("large"), 0.5, CG),
        (unlike("large"), 5.0, NEWTON),
        (unlike("printed"), 0.0, CG),
    ],
    ids=lambda value: value.name if isinstance(value, Design) else str(value),
)
def test_gradients_are_taken_for_few_bodies_and_where_the_step_resolves_moving_pins(
    design: Design, step: float, solver: int
) -> None:
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
def test_islands_are_found_where_pins_that_do_not_carry_can_be_left_out(
    design: Design, load: float, islands: bool
) -> None:
    flags = build(override(design, [f"load.torque_nm={load}"])).model.opt.disableflags
    assert bool(flags & NO_ISLANDS) != islands


@pytest.mark.parametrize("name", ["pin", "few", "large", "nonpin", "twodisc", "printed"])
def test_both_solvers_find_the_same_forces_with_islands_and_without(name: str) -> None:
    """From one state: a run between flanks is chaotic, and two that differ by a rounding part ways."""
    design = PRESETS[name] if name in ("pin", "nonpin", "twodisc") else unlike(name)
    load = design.drive.torque * design.lobes
    step = 0.5 if design.ring.has_moving_pins else 0.0
    changes = ["drive.ramp_s=0", "load.rise_s=0.0005", f"load.torque_nm={load}", f"settings.timestep_us={step}"]
    design = override(design, changes)
    reducer = build(design)
    course = ramp_and_hold(reducer, design)
    data = initial_state(reducer, design, course)
    model, worst, loaded, islands = reducer.model, 0.0, 0, 0
    with installed():
        for step, command in enumerate(course.commands(reducer.model.opt.timestep * np.arange(2000))):
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
    assert (islands > 1) == design.ring.has_moving_pins
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
