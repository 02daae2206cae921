"""A picture of a logged run by MuJoCo's own renderer, without a display."""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene.force import ARROW, FORCE_COLOURS, THICKNESS, arrow_heights, on_gear
from cycloid_mj.scene.opengl import opengl
from cycloid_mj.scene.replay import AZIMUTH, ELEVATION, aim, replay_model, set_sample

Image = npt.NDArray[np.uint8]

WIDTH, HEIGHT = 1280, 960
LEAST, LARGEST = 64, 8192
MOST_GEOMS = 5000
PART_DISTANCE = 2.6
"""Of the camera from a part by itself, in radii of the sphere round it."""
VISUAL_GROUP = 2
"""Of the geoms that are drawn, not touched."""
SAMPLES = 8
"""Samples of a pixel, so that edges are smooth."""


def render(
    run: Run,
    reducer: Reducer,
    sample: int,
    size: tuple[int, int] = (WIDTH, HEIGHT),
    view: tuple[float, float] = (AZIMUTH, ELEVATION),
) -> Image:
    """Draw a picture of a sample, shape (height, width, 3), with the forces on the gear as arrows.

    Parameters
    ----------
    run, reducer
        The run, with its ``model.xml``, and its reducer.
    sample
        Number of the sample.
    size
        Width and height [pixels].
    view
        Azimuth and elevation of the camera [deg], as MuJoCo has them.

    Raises
    ------
    CycloidError
        There is no OpenGL here.
    LogError
        The run carries no model, or one that does not fit it.
    UsageError
        The size is not possible.
    """
    model = replay_model(run)
    data = mujoco.MjData(model)
    set_sample(model, data, run, sample)
    camera = mujoco.MjvCamera()
    aim(camera, model, *view)
    return _drawn(model, data, camera, size, _arrows(run, reducer, sample))


def render_part(
    run: Run,
    bodies: Sequence[str],
    size: tuple[int, int] = (WIDTH, HEIGHT),
    view: tuple[float, float] = (AZIMUTH, ELEVATION),
) -> Image:
    """Render some bodies of a run's model alone, as they stand at its start; parameters and errors as of `render`."""
    model = replay_model(run)
    data = mujoco.MjData(model)
    set_sample(model, data, run, 0)
    shown = np.isin([model.body(body).name for body in model.geom_bodyid], bodies)
    if not shown.any():
        raise UsageError(f"the model has no body of {', '.join(bodies)}")
    model.geom_rgba[:, 3] = np.where(shown, 1.0, 0.0)
    camera = mujoco.MjvCamera()
    aim(camera, model, *view)
    seen = shown & (model.geom_group == VISUAL_GROUP)
    camera.lookat[:] = data.geom_xpos[seen].mean(axis=0)
    away = np.linalg.norm(data.geom_xpos[seen] - camera.lookat, axis=1)
    camera.distance = PART_DISTANCE * float((away + model.geom_rbound[seen]).max())
    return _drawn(model, data, camera, size, [])


def _drawn(model: Any, data: Any, camera: Any, size: tuple[int, int], arrows: list[dict[str, Any]]) -> Image:
    width, height = size
    if not (LEAST <= width <= LARGEST and LEAST <= height <= LARGEST):
        raise UsageError(f"a picture of {width} x {height} pixels: give {LEAST} to {LARGEST} each")
    model.vis.global_.offwidth, model.vis.global_.offheight = width, height
    model.vis.quality.offsamples = SAMPLES
    scene = mujoco.MjvScene(model, MOST_GEOMS)
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, mujoco.mjtCatBit.mjCAT_ALL, scene)
    for arrow in arrows:
        _add_arrow(scene, **arrow)
    with opengl(model, width, height) as context:
        frame = mujoco.MjrRect(0, 0, width, height)
        picture = np.empty((height, width, 3), dtype=np.uint8)
        mujoco.mjr_render(frame, scene, context)
        mujoco.mjr_readPixels(picture, None, frame, context)
    return picture[::-1].copy()


def _arrows(run: Run, reducer: Reducer, sample: int) -> list[dict[str, Any]]:
    """List tail, tip, width [m] and colour of each force's arrow, on a face of its disc."""
    columns = {name: values[sample : sample + 1] for name, values in run.columns.items()}
    acting, reach, faces = on_gear(reducer, columns), reducer.design.ring.pin_circle_radius, arrow_heights(reducer)
    arrows = []
    for kind in dict.fromkeys(acting.kinds):
        these = acting.of(kind)
        scale = ARROW * reach / max(float(these.size.max()), 1e-9)
        for point, force, disc in zip(these.point[0], these.force[0], these.discs, strict=True):
            if force.any():
                tip, tail = np.array([*point, faces[disc]]), np.array([*(point - scale * force), faces[disc]])
                arrows.append({"tail": tail, "tip": tip, "width": THICKNESS * reach, "colour": FORCE_COLOURS[kind]})
    return arrows


def _add_arrow(scene: Any, tail: Any, tip: Any, width: float, colour: Any) -> None:
    if scene.ngeom >= scene.maxgeom:
        return
    geom, arrow = scene.geoms[scene.ngeom], mujoco.mjtGeom.mjGEOM_ARROW
    rgba = np.array(colour, dtype=np.float32)
    mujoco.mjv_initGeom(geom, arrow, np.zeros(3), np.zeros(3), np.zeros(9), rgba)
    # MuJoCo draws an arrow half as long as the connector that it is given
    mujoco.mjv_connector(geom, arrow, 0.6 * width, tail, 2.0 * tip - tail)
    scene.ngeom += 1
