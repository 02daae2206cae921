"""A picture of a logged run by MuJoCo's own renderer, without a display."""

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
SAMPLES = 8
"""Samples of a pixel, so that edges are smooth."""


def render(
    run: Run,
    reducer: Reducer,
    sample: int,
    size: tuple[int, int] = (WIDTH, HEIGHT),
    view: tuple[float, float] = (AZIMUTH, ELEVATION),
) -> Image:
    """Give a picture of a sample, shape (height, width, 3), with the forces on the gear as arrows.

    Parameters
    ----------
    run, design
        The run, with its ``model.xml``, and its design.
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
    width, height = size
    if not (LEAST <= width <= LARGEST and LEAST <= height <= LARGEST):
        raise UsageError(f"a picture of {width} x {height} pixels: give {LEAST} to {LARGEST} each")
    model = replay_model(run)
    data = mujoco.MjData(model)
    set_sample(model, data, run, sample)
    model.vis.global_.offwidth, model.vis.global_.offheight = width, height
    model.vis.quality.offsamples = SAMPLES
    scene = _scene(model, data, _arrows(run, reducer, sample), view)
    with opengl(model, width, height) as context:
        frame = mujoco.MjrRect(0, 0, width, height)
        picture = np.empty((height, width, 3), dtype=np.uint8)
        mujoco.mjr_render(frame, scene, context)
        mujoco.mjr_readPixels(picture, None, frame, context)
    return picture[::-1].copy()


def _scene(model: Any, data: Any, arrows: list[dict[str, Any]], view: tuple[float, float]) -> Any:
    scene, camera = mujoco.MjvScene(model, MOST_GEOMS), mujoco.MjvCamera()
    aim(camera, model, *view)
    everything = mujoco.mjtCatBit.mjCAT_ALL
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, everything, scene)
    for arrow in arrows:
        _add_arrow(scene, **arrow)
    return scene


def _arrows(run: Run, reducer: Reducer, sample: int) -> list[dict[str, Any]]:
    """Give tail, tip, width [m] and colour of each force's arrow, on a face of its disc."""
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
