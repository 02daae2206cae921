"""Image of a run by MuJoCo's renderer."""

import numpy as np
from PIL.Image import Image, fromarray

from cycloid_mj.analysis.series import design_of
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.reducer import reducer_of
from cycloid_mj.scene.opengl import require_mujoco
from cycloid_mj.scene.render import IMAGE
from cycloid_mj.scene.render import render as render_sample
from cycloid_mj.scene.replay import VIEW


def render(
    run: Run,
    time_s: float | None = None,
    size: tuple[int, int] = (IMAGE.width, IMAGE.height),
    azimuth: float = VIEW.azimuth,
    elevation: float = VIEW.elevation,
) -> Image:
    """Render an image of a run with MuJoCo; public as ``cycloid_mj.render``.

    Parameters
    ----------
    run
        The run, with its model.
    time_s
        Time of the image [s]; by default the end of the run.
    size
        Width and height [pixels].
    azimuth, elevation
        Direction of the camera [deg]; a negative elevation shows the output side.

    Returns
    -------
    PIL.Image.Image
        The image; ``.save("drive.png")`` writes it.

    Raises
    ------
    CycloidError
        OpenGL is not available.
    LogError
        The run has no model.
    UsageError
        The time is outside of the run, or the size is out of range.
    """
    if time_s is not None and not run.time[0] <= time_s <= run.time[-1]:
        raise UsageError(
            f"time_s = {time_s:g} s is outside the run {run.label}: choose a time from {run.time[0]:.6g} to "
            f"{run.time[-1]:.6g} s"
        )
    require_mujoco()
    sample = len(run) - 1 if time_s is None else int(np.argmin(np.abs(run.time - time_s)))
    return fromarray(render_sample(run, reducer_of(design_of(run)), sample, size, (azimuth, elevation)))
