"""MuJoCo's interactive viewer for a model or a logged run."""

import os
import sys
import time
from typing import Any

import mujoco

from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.scene.messages import RATE
from cycloid_mj.scene.replay import aim_camera, replay_model, set_sample


def require_display() -> None:
    """Raise UsageError if there is no display for a window."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise UsageError(
            "there is no display on which to open a window: use `cycloid-mj render` or `cycloid-mj animate`, which "
            "need none"
        )


def show_model(model: Any) -> None:
    """Open MuJoCo's viewer for a model, with this package's contact laws, and return when its window is closed.

    Raises
    ------
    CycloidError
        The window cannot be opened.
    """
    viewer = _viewer()
    with install():
        _open_viewer_window(viewer.launch, model)


def show_run(run: Run, slowdown: float) -> None:
    """Replay a run in a loop in MuJoCo's viewer, `slowdown` times slower than real time, until the window is closed.

    Raises
    ------
    LogError
        The run has no model.
    CycloidError
        The window cannot be opened.
    """
    model = replay_model(run)
    data = mujoco.MjData(model)
    set_sample(model, data, run, 0)
    start_time = time.monotonic()
    with _open_viewer_window(_viewer().launch_passive, model, data) as window:
        aim_camera(window.cam, model)
        while window.is_running():
            played_time = (time.monotonic() - start_time) / slowdown
            run_duration = float(run.time[-1] - run.time[0]) or 1.0
            set_sample(model, data, run, int(run.time.searchsorted(run.time[0] + played_time % run_duration)))
            window.sync()
            time.sleep(1.0 / RATE)


def _viewer() -> Any:
    import mujoco.viewer

    return mujoco.viewer


def _open_viewer_window(open_window: Any, *args: Any) -> Any:
    """Call `open_window`, which opens a window, with `args`; return its result, or raise CycloidError if it fails."""
    try:
        return open_window(*args)
    except Exception as problem:
        reason = str(problem).splitlines()[0] if str(problem) else type(problem).__name__
        raise CycloidError(
            f"the MuJoCo viewer cannot open a window: {reason}. Use `cycloid-mj render` or `cycloid-mj animate` instead"
        ) from problem
