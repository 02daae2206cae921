"""MuJoCo's interactive viewer on a model or a logged run."""

import os
import sys
import time
from typing import Any

import mujoco

from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.dynamics.contact.collider import installed
from cycloid_mj.scene.replay import aim, replay_model, set_sample

FRAME = 1.0 / 60.0
"""Time from one picture to the next [s]."""


def require_display() -> None:
    """Raise UsageError where a window cannot be opened."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise UsageError(
            "there is no display to open a window on: use `cycloid-mj render` or `cycloid-mj animate`, which need none"
        )


def show_model(model: Any) -> None:
    """Open the viewer on a model with our contacts, and return when its window is closed.

    Raises
    ------
    CycloidError
        The window cannot be opened.
    """
    viewer = _viewer()
    with installed():
        _opened(viewer.launch, model)


def show_run(run: Run, slow: float) -> None:
    """Replay a run in the viewer over and over, `slow` times slower than it was, until its window is closed.

    Raises
    ------
    LogError
        The run carries no model.
    CycloidError
        The window cannot be opened.
    """
    model = replay_model(run)
    data = mujoco.MjData(model)
    set_sample(model, data, run, 0)
    start = time.monotonic()
    with _opened(_viewer().launch_passive, model, data) as window:
        aim(window.cam, model)
        while window.is_running():
            played = (time.monotonic() - start) / slow
            span = float(run.time[-1] - run.time[0]) or 1.0
            set_sample(model, data, run, int(run.time.searchsorted(run.time[0] + played % span)))
            window.sync()
            time.sleep(FRAME)


def _viewer() -> Any:
    import mujoco.viewer

    return mujoco.viewer


def _opened(open_window: Any, *args: Any) -> Any:
    try:
        return open_window(*args)
    except Exception as problem:
        reason = str(problem).splitlines()[0] if str(problem) else type(problem).__name__
        raise CycloidError(
            f"MuJoCo's viewer cannot open a window: {reason}; use `cycloid-mj render` or `cycloid-mj animate`"
        ) from problem
