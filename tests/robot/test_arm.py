"""The arm of models/arm: its files, its reducers, and its motion in MuJoCo and MJX."""

from pathlib import Path

import build_arm
import mujoco
import numpy as np
import pytest

import cycloid_mj as cm

FOLDER = Path(__file__).parents[2] / "models" / "arm"

GOAL = (0.6, 0.4, 0.8)
"""Angles of the joints after a second [rad]."""


def targets(model: mujoco.MjModel) -> np.ndarray:
    """Return smooth targets of the servos over one second [rad], shape (steps, 3)."""
    time = np.arange(round(1.0 / model.opt.timestep)) * model.opt.timestep
    return model.key_ctrl[0] + np.subtract(GOAL, model.key_ctrl[0]) * (0.5 - 0.5 * np.cos(np.pi * time[:, np.newaxis]))


def start(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    return data


def tip_path(model: mujoco.MjModel) -> np.ndarray:
    """Return time [s] and positions of the tip [m], shape (steps, 4)."""
    data, path = start(model), []
    for target in targets(model):
        data.ctrl[:] = target
        mujoco.mj_step(model, data)
        path.append((data.time, *data.site("tip").xpos))
    return np.array(path)


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(FOLDER / "scene.xml"))


@pytest.fixture(scope="module")
def reduced() -> cm.ReducedJoint:
    return cm.reduce(build_arm.DESIGN, "backlash")


def test_the_folder_is_the_one_of_its_script(model: mujoco.MjModel, reduced: cm.ReducedJoint, tmp_path: Path) -> None:
    for name, content in build_arm.arm_files(reduced).items():
        (tmp_path / name).write_bytes(content)
        if not name.startswith("arm"):  # the figures of the reducer depend on the processor in their last digits
            assert (FOLDER / name).read_bytes() == content, f"run scripts/build_arm.py: {name}"
    rebuilt = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    for field in ("body_mass", "body_pos", "dof_armature", "tendon_stiffness", "tendon_lengthspring", "actuator_gear"):
        np.testing.assert_allclose(getattr(rebuilt, field), getattr(model, field), rtol=1e-4, err_msg=field)


def test_servos_reach_their_targets_within_backlash_and_gain(model: mujoco.MjModel) -> None:
    data = start(model)
    data.ctrl[:] = GOAL
    for _ in range(round(2.0 / model.opt.timestep)):
        mujoco.mj_step(model, data)
    kp = model.actuator_gainprm[:, 0]
    sag = np.abs(data.actuator_force) / kp
    for number, joint in enumerate(build_arm.JOINTS):
        limits = model.tendon_lengthspring[model.tendon(f"{joint}_reducer_4").id]
        error = abs(data.joint(joint).qpos[0] - GOAL[number])
        assert error < sag[number] + limits[1], joint
    assert data.ncon == 0


def test_an_attached_model_is_the_same_after_saving(reduced: cm.ReducedJoint) -> None:
    """`MjSpec.to_xml` leaves out the inertia of a body whose position of the mass is not set."""
    spec = mujoco.MjSpec.from_string(build_arm.bare_arm(cm.Reducer(cm.load("printed")), 10.0, 1e-3))
    cm.attach_reducer(spec, "elbow", reduced)
    compiled = spec.compile()
    saved = mujoco.MjModel.from_xml_string(spec.to_xml())
    np.testing.assert_allclose(saved.body_mass, compiled.body_mass, rtol=1e-6)
    np.testing.assert_allclose(saved.body_inertia, compiled.body_inertia, rtol=1e-5)


@pytest.mark.slow
def test_mjx_moves_the_tip_as_mujoco_does(model: mujoco.MjModel) -> None:
    jax = pytest.importorskip("jax", reason="JAX is no requirement of the tests: see pyproject.toml")
    from mujoco import mjx

    half_step = mujoco.MjModel.from_xml_path(str(FOLDER / "scene_mjx.xml"))
    data, tip = start(half_step), half_step.site("tip").id
    mujoco.mj_forward(half_step, data)
    mjx_model, first = mjx.put_model(half_step), mjx.put_data(half_step, data)

    def step(state, target):
        state = mjx.step(mjx_model, state.replace(ctrl=target))
        return state, state.site_xpos[tip]

    _, path = jax.jit(lambda state, control: jax.lax.scan(step, state, control))(first, targets(half_step))
    reference = tip_path(model)
    deviation = np.linalg.norm(np.asarray(path)[1::2] - reference[:, 1:], axis=1)
    travel = np.linalg.norm(np.diff(reference[:, 1:], axis=0), axis=1).sum()
    assert deviation.max() < 0.01 * travel
