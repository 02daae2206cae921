"""MuJoCo's lift of what slides, and how it is taken off."""

from typing import Any

import mujoco
import numpy as np
import pytest

from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.contact import collider
from cycloid_mj.dynamics.contact.teeth import USER_DATA
from cycloid_mj.dynamics.law import COUPLED, contact_law, solver_parameters
from cycloid_mj.dynamics.run import simulate

MASS, GRAVITY, SPEED, STEP = 0.25, 9.8, 1.0, 1e-5
WEIGHT = MASS * GRAVITY
CREEP_SPEED = 0.02


def block(friction: float, impratio: float, ours: bool = True, island: str = "enable", speed: float = SPEED) -> Any:
    """Put a block at rest across a plane that it slides along, pressed by its weight; give model and data."""
    law = contact_law(1e8, 0.5, MASS, friction, friction * WEIGHT / CREEP_SPEED, STEP)
    parameters = solver_parameters(law, 1.0 / MASS, impratio)
    words = {name: " ".join(map(repr, getattr(parameters, name))) for name in ("solref", "solreffriction", "solimp")}
    model = mujoco.MjModel.from_xml_string(f"""<mujoco>
      <size nuserdata="{int(ours)}" nuser_geom="{USER_DATA if ours else 0}"/>
      <option timestep="{STEP}" gravity="0 {-GRAVITY} 0" impratio="{impratio}" cone="elliptic" tolerance="1e-14">
        <flag island="{island}"/></option>
      <worldbody>
        <geom name="plane" type="plane" size="1 1 1" zaxis="0 1 0"/>
        <body pos="0 0.02 0">
          <joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
          <inertial pos="0 0 0" mass="{MASS}" diaginertia="1e-4 1e-4 1e-4"/>
          <geom name="foot" type="sphere" size="0.02"/></body>
      </worldbody>
      <contact><pair geom1="plane" geom2="foot" condim="{parameters.condim}" friction="{friction} {friction}"
        solref="{words["solref"]}" solreffriction="{words["solreffriction"]}" solimp="{words["solimp"]}"/></contact>
    </mujoco>""")
    data = mujoco.MjData(model)
    data.qpos[1] = -WEIGHT / law.stiffness
    data.qvel[0] = speed
    return model, data


def forces(model: Any, data: Any) -> tuple[float, float]:
    """Compute normal force and friction of the one contact after a step [N]."""
    mujoco.mj_step(model, data)
    normal, *friction = data.efc_force
    return normal, float(np.sum(friction))


@pytest.mark.parametrize("friction", [0.05, 0.3])
@pytest.mark.parametrize("island", ["enable", "disable"])
@pytest.mark.parametrize("speed", [SPEED, -SPEED])
def test_a_sliding_block_presses_by_its_weight(friction: float, island: str, speed: float) -> None:
    ratio = friction**2 / COUPLED
    stock = forces(*block(friction, ratio, island=island, speed=speed))
    assert stock[0] > 2.0 * WEIGHT, "stock MuJoCo lifts it"
    with collider.installed():
        normal, along = forces(*block(friction, ratio, island=island, speed=speed))
    # what is left is mu times the added mass times how fast it is braked, mu g
    braked = friction**2 * contact_law(1e8, 0.5, MASS, friction, 1.0, STEP).added_mass * GRAVITY
    assert normal == pytest.approx(WEIGHT, rel=1e-9, abs=2.0 * braked)
    assert abs(along) == pytest.approx(friction * normal, rel=1e-9)


def test_what_does_not_slide_or_does_not_press_is_left_alone() -> None:
    creeping = 0.5 * CREEP_SPEED
    stock = forces(*block(0.3, 2.0, speed=creeping))
    with collider.installed():
        assert forces(*block(0.3, 2.0, speed=creeping)) == stock
        model, data = block(0.3, 2.0)
        data.qvel[1] = 1.0  # flies off: damping alone would pull
        assert forces(model, data)[0] == pytest.approx(0.0, abs=1e-6 * WEIGHT)


def test_a_foreign_model_is_left_as_it_is() -> None:
    stock = forces(*block(0.3, 2.0, ours=False))
    with collider.installed():
        assert forces(*block(0.3, 2.0, ours=False)) == stock
    assert forces(*block(0.3, 2.0)) == stock


@pytest.mark.slow
def test_no_figure_follows_impratio(monkeypatch: pytest.MonkeyPatch) -> None:
    """At a friction of 0.3 the rms of the gear's speed was 70 % too large by the lift at the `impratio` of 10."""
    drive = ["drive.ramp_s=0", "drive.hold_s=0.03", "load.torque_nm=36", "settings.log_rate_hz=50000"]
    design = override(PRESETS["pin"], ["ring.pins=fixed", "friction.pin_gear=0.3", *drive])
    found = []
    for ratio in (None, 10.0, 100.0):
        if ratio:
            monkeypatch.setattr("cycloid_mj.dynamics.mjcf.model.impratio", lambda *_, ratio=ratio: ratio)
        late = (run := simulate(design)).select(run.time > 0.0117)
        swaying = late["gear_speed"] + late["crank_speed"] / design.lobes
        power = late["crank_torque"] * late["crank_speed"]
        found.append([np.sqrt(np.mean(swaying**2)), power.mean()])
    np.testing.assert_allclose(found[0], found[2], rtol=0.01)
    np.testing.assert_allclose(found[1], found[2], rtol=0.01)
    assert found[0][1] == pytest.approx(found[2][1], rel=1e-4)
