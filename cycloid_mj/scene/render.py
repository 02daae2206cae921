"""Images of a logged run by MuJoCo's renderer, without a display."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.dynamics.mjcf.bodies import VISUAL_GROUP
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene.force import ARROWS, FORCE_COLOURS, arrow_heights, shown_forces
from cycloid_mj.scene.opengl import opengl
from cycloid_mj.scene.replay import VIEW, aim_camera, replay_model, set_sample

Image = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class ImageSettings:
    """Settings of rendered images."""

    width: int = 1280
    height: int = 960
    min_pixels: int = 64
    max_pixels: int = 8192
    max_geoms: int = 5000
    part_distance: float = 2.6
    """Distance of the camera from a single part, in radii of its bounding sphere."""
    samples_per_pixel: int = 8
    """Samples per pixel for smooth edges."""


IMAGE = ImageSettings()


def render(
    run: Run,
    reducer: Reducer,
    sample: int,
    size: tuple[int, int] = (IMAGE.width, IMAGE.height),
    view: tuple[float, float] = (VIEW.azimuth, VIEW.elevation),
) -> Image:
    """Render a sample of a run as an RGB image, shape (height, width, 3), with the forces on the disc as arrows.

    Parameters
    ----------
    run, reducer
        The run, with its ``model.xml``, and its reducer.
    sample
        Index of the sample.
    size
        Width and height [pixels].
    view
        Azimuth and elevation of the camera [deg], as in MuJoCo.

    Raises
    ------
    CycloidError
        OpenGL is not available.
    LogError
        The run has no model, or its model does not fit its columns.
    UsageError
        The size is out of range.
    """
    model = replay_model(run)
    data = mujoco.MjData(model)
    set_sample(model, data, run, sample)
    camera = mujoco.MjvCamera()
    aim_camera(camera, model, *view)
    return render_model(model, data, camera, size, _force_arrows(run, reducer, sample))


def render_part(
    run: Run,
    bodies: Sequence[str],
    size: tuple[int, int] = (IMAGE.width, IMAGE.height),
    view: tuple[float, float] = (VIEW.azimuth, VIEW.elevation),
) -> Image:
    """Render only some bodies of a run's model as an RGB image (height, width, 3), in their poses at its start.

    `bodies` are their names. The camera points at the middle of the bodies, from a distance of `IMAGE.part_distance`
    times their radius. `size` is width and height of the image [pixels]. `view` is azimuth and elevation of the camera
    [deg].

    Raises
    ------
    UsageError
        The model has none of the bodies, or the size is out of range; further errors as of `render`.
    """
    model = replay_model(run)
    data = mujoco.MjData(model)
    set_sample(model, data, run, 0)
    is_shown = np.isin([model.body(body).name for body in model.geom_bodyid], bodies)
    if not is_shown.any():
        raise UsageError(
            f"the model of {run.label} has no body named {', '.join(bodies)}: choose from "
            f"{', '.join(model.body(number).name for number in range(1, model.nbody))}"
        )
    model.geom_rgba[:, 3] = np.where(is_shown, 1.0, 0.0)
    camera = mujoco.MjvCamera()
    aim_camera(camera, model, *view)
    is_visible = is_shown & (model.geom_group == VISUAL_GROUP)
    camera.lookat[:] = data.geom_xpos[is_visible].mean(axis=0)
    distance = np.linalg.norm(data.geom_xpos[is_visible] - camera.lookat, axis=1)
    camera.distance = IMAGE.part_distance * float((distance + model.geom_rbound[is_visible]).max())
    return render_model(model, data, camera, size)


def render_model(
    model: Any, data: Any, camera: Any, size: tuple[int, int], arrows: Sequence[dict[str, Any]] = ()
) -> Image:
    """Render a MuJoCo model with arrows as an image, shape (height, width, 3) of colours from 0 to 255.

    `data` is its ``MjData``, `camera` an ``MjvCamera``, `size` is width and height [pixels], and `arrows` has tail,
    tip, width and colour of each arrow.

    Raises
    ------
    UsageError
        The size of the image is out of range.
    CycloidError
        OpenGL is not available.
    """
    width, height = size
    if not (IMAGE.min_pixels <= width <= IMAGE.max_pixels and IMAGE.min_pixels <= height <= IMAGE.max_pixels):
        raise UsageError(
            f"the image size {width} x {height} is out of range: choose {IMAGE.min_pixels} to {IMAGE.max_pixels} "
            "pixels for width and height"
        )
    model.vis.global_.offwidth, model.vis.global_.offheight = width, height
    model.vis.quality.offsamples = IMAGE.samples_per_pixel
    scene = mujoco.MjvScene(model, IMAGE.max_geoms)
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, mujoco.mjtCatBit.mjCAT_ALL, scene)
    for arrow in arrows:
        _add_arrow(scene, **arrow)
    with opengl(model, width, height) as context:
        viewport = mujoco.MjrRect(0, 0, width, height)
        picture = np.empty((height, width, 3), dtype=np.uint8)
        mujoco.mjr_render(viewport, scene, context)
        mujoco.mjr_readPixels(picture, None, viewport, context)
    return picture[::-1].copy()


def _force_arrows(run: Run, reducer: Reducer, sample: int) -> list[dict[str, Any]]:
    """Return the arrows of the contact forces in a sample of a run, each as a dict.

    The keys are "tail" and "tip" (positions [m]), "width" [m] and "colour". `sample` is the index of the sample,
    `reducer` the reducer of the run. The tip is at the contact, on a face of the disc. The longest arrow of each kind
    of contact has the length `ARROWS.length` times the radius of the pin circle. Forces of zero have no arrow.
    """
    columns = {name: values[sample : sample + 1] for name, values in run.columns.items()}
    forces, ring_radius, arrow_z = (
        shown_forces(reducer, columns),
        reducer.design.ring.pin_circle_radius,
        arrow_heights(reducer),
    )
    arrows = []
    for kind in dict.fromkeys(forces.kinds):
        forces_of_kind = forces.of(kind)
        scale = ARROWS.length * ring_radius / max(float(forces_of_kind.size.max()), 1e-9)
        for point, force, disc in zip(
            forces_of_kind.point[0], forces_of_kind.force[0], forces_of_kind.discs, strict=True
        ):
            if force.any():
                tip, tail = np.array([*point, arrow_z[disc]]), np.array([*(point - scale * force), arrow_z[disc]])
                arrows.append(
                    {"tail": tail, "tip": tip, "width": ARROWS.thickness * ring_radius, "colour": FORCE_COLOURS[kind]}
                )
    return arrows


def _add_arrow(scene: Any, tail: Any, tip: Any, width: float, colour: Any) -> None:
    """Add an arrow from tail to tip [m], shape (3,), to a MuJoCo scene; do nothing if the scene is full.

    `width` is that of its shaft [m], `colour` is RGBA from 0 to 1.
    """
    if scene.ngeom >= scene.maxgeom:
        return
    geom, arrow = scene.geoms[scene.ngeom], mujoco.mjtGeom.mjGEOM_ARROW
    rgba = np.array(colour, dtype=np.float32)
    mujoco.mjv_initGeom(geom, arrow, np.zeros(3), np.zeros(3), np.zeros(9), rgba)
    # MuJoCo draws an arrow of half the length of the connector
    mujoco.mjv_connector(geom, arrow, 0.6 * width, tail, 2.0 * tip - tail)
    scene.ngeom += 1
