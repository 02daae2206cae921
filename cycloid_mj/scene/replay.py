"""Replay of a logged run in MuJoCo: its model in the poses of its samples, without time steps or contacts."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mujoco

from cycloid_mj.base.errors import LogError
from cycloid_mj.base.record import Run

MODEL_FILE = "model.xml"
COLUMNS = {"crank": "crank_angle", "output": "output_angle"}
"""Columns of joints with other names."""


@dataclass(frozen=True)
class CameraView:
    """Default view of the mechanism in MuJoCo."""

    output_opacity: float = 0.35
    """Opacity of the output, which is in front of the mechanism."""
    azimuth: float = 90.0
    elevation: float = -62.0
    distance: float = 1.35
    """Distance of the camera, as a share of the model's extent."""


VIEW = CameraView()


_SKY = {"rgb1": [1.0, 1.0, 1.0], "rgb2": [0.86, 0.9, 0.94], "width": 64, "height": 64}


def replay_model(run: Run) -> Any:
    """Return the MuJoCo model of a run, compiled anew from the XML in its log, with a light background.

    Raises
    ------
    LogError
        The run has no model, or this version of MuJoCo does not compile it.
    """
    if MODEL_FILE not in run.attachments:
        raise LogError(
            f"{run.label} lacks the attached file {MODEL_FILE}, the MuJoCo model of the run: simulate the design again "
            "with --solver mujoco"
        )
    try:
        spec = mujoco.MjSpec.from_string(run.attachments[MODEL_FILE].decode(), assets=dict(run.attachments))
        sky, gradient = mujoco.mjtTexture.mjTEXTURE_SKYBOX, mujoco.mjtBuiltin.mjBUILTIN_GRADIENT
        spec.add_texture(name="sky", type=sky, builtin=gradient, **_SKY)
        model = spec.compile()
    except (ValueError, UnicodeDecodeError) as problem:
        version = run.provenance.get("mujoco", mujoco.__version__)
        advice = "" if version == mujoco.__version__ else f"install MuJoCo {version}, which simulated the run, or "
        raise LogError(
            f"MuJoCo {mujoco.__version__} cannot load the {MODEL_FILE} attached to {run.label} ({problem}): {advice}"
            "simulate the design again"
        ) from problem
    model.vis.headlight.ambient[:], model.vis.headlight.diffuse[:] = 0.3, 0.4
    model.light_diffuse[:] = 0.35
    _make_output_transparent(model)
    return model


def aim_camera(camera: Any, model: Any, azimuth: float = VIEW.azimuth, elevation: float = VIEW.elevation) -> None:
    """Point a free camera at the reducer, by default from the output side, where x points right; angles in [deg]."""
    camera.azimuth, camera.elevation = azimuth, elevation
    camera.distance, camera.lookat[:] = VIEW.distance * model.stat.extent, model.stat.center


def set_sample(model: Any, data: Any, run: Run, sample: int) -> None:
    """Set all joints in MuJoCo's `data` of a `model` to a sample of a run; joints without a column are unchanged.

    `sample` is the index of the sample.

    Raises
    ------
    LogError
        The run has columns for none of the joints.
    """
    column_by_joint = _joint_columns(model, run)
    for joint, column in column_by_joint.items():
        data.joint(joint).qpos[0] = run[column][sample]
    data.time = run.time[sample]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)


def _joint_columns(model: Any, run: Run) -> Mapping[str, str]:
    """Return the joints of a run's model that have a column: joint name -> column name; raise LogError if none has."""
    joints = [model.joint(number).name for number in range(model.njnt)]
    column_by_joint = {joint: COLUMNS.get(joint, joint) for joint in joints if COLUMNS.get(joint, joint) in run.columns}
    if not column_by_joint:
        raise LogError(
            f"{run.label} lacks the columns with the joint positions of its model: simulate the design again"
        )
    return column_by_joint


def _make_output_transparent(model: Any) -> None:
    output_body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "output")
    for geom in range(model.ngeom):
        if model.geom_bodyid[geom] == output_body:
            model.geom_rgba[geom, 3] = VIEW.output_opacity
