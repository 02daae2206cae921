"""Powers of contacts against the motion of the parts, and the limit beyond which a gear has jumped a tooth."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from designs import unlike
from stepped import stepped

from cycloid_mj.base.errors import RunError
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics import run
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.drive_cycle import initial_state
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.reducer import Reducer

FIXED = override(PRESETS["pin"], ["ring.pins=fixed"])


@pytest.mark.parametrize("kind", ["fixed", "light"])
@pytest.mark.parametrize("spin", [5.0, -5.0])
def test_powers_equal_force_times_velocity_on_the_gear(kind: str, spin: float) -> None:
    """The ring stands still: what a tooth takes, by its normal and by friction, is -(F v + M omega) of the gear."""
    design = override(FIXED if kind == "fixed" else unlike(kind), ["clearance.cam_um=100", "clearance.output_um=300"])
    compiled = build(design)
    data = initial_state(compiled, Reducer(design))
    play, arm = getattr(design.clearance, design.tooth_pair), design.gear.eccentricity * design.lobes
    data.joint("gear_angle").qpos[0] += (1.3 * play + 3e-6) / arm
    data.joint("gear_angle").qvel[0] = spin
    data.joint("gear_x").qvel[0], data.joint("gear_y").qvel[0] = 0.02, -0.01
    compiled.model.opt.timestep *= 1e-6  # so short that no contact turns round in it
    before = motion(data)
    with install():
        found = stepped(compiled.model, data, compiled.pairs)
    middle = 0.5 * (before + motion(data))
    touched = 0
    for number, pair in enumerate(compiled.pairs):
        if pair.kind != design.tooth_pair or not found.wrench[number].any():
            continue
        touched += 1
        taken = -float(found.wrench[number] @ middle)
        assert found.normal_power[number] + found.friction_power[number] == pytest.approx(taken, rel=1e-9)
    assert touched
    # Deeper or out of the contact: a positive spin presses the flanks further in, a negative one lets them go.
    assert (found.normal_power.sum() > 0.0) == (spin > 0.0)


def motion(data: Any) -> np.ndarray:
    """Compute the gear's speeds [m/s, m/s, rad/s]."""
    return np.array([data.joint(f"gear_{axis}").qvel[0] for axis in ("x", "y", "angle")])


def without_contact(design: Design):
    """A reducer whose parts meet nowhere: its gear is where it is put."""
    compiled = build(design)
    for pair in list(compiled.spec.pairs):
        compiled.spec.delete(pair)
    return replace(compiled, model=compiled.spec.compile())


@pytest.mark.parametrize("design", [FIXED, unlike("light")], ids=lambda one: one.name)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_gear_a_quarter_of_a_lobe_off_has_jumped(design: Design, way: float, monkeypatch: pytest.MonkeyPatch) -> None:
    design = override(design, ["drive.ramp_s=0", "drive.hold_s=0.0002"])
    compiled = without_contact(design)

    def off(share: float) -> None:
        def state(*given):
            data = initial_state(*given)
            data.joint("gear_angle").qpos[0] += way * share * 2.0 * math.pi / design.lobes
            return data

        monkeypatch.setattr(run, "initial_state", state)
        list(run.blocks(compiled, Reducer(design)))

    off(0.24)
    with pytest.raises(RunError, match="skipped a tooth"):
        off(0.26)


def test_powers_of_a_run_add_up_by_kind() -> None:
    design = override(FIXED, ["drive.ramp_s=0", "drive.hold_s=0.002", "load.torque_nm=20", "load.rise_s=0.0005"])
    found = run.simulate(design)
    lost = found["pin_gear_friction_power"] + found["pin_gear_normal_power"]
    taken = np.zeros(len(found))
    for number in range(1, design.ring.teeth + 1):
        force = found[f"pin_{number}_force_x"] * found["gear_vx"] + found[f"pin_{number}_force_y"] * found["gear_vy"]
        taken -= force + found[f"pin_{number}_moment"] * found["gear_speed"]
    np.testing.assert_allclose(lost, taken, rtol=1e-6, atol=1e-6)
