"""OpenGL without a display: MuJoCo's contexts, and what to say where there is none."""

import importlib
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from cycloid_mj.base.errors import CycloidError

USUAL = {"darwin": "cgl", "win32": "glfw"}
"""Platform -> MuJoCo's module for its OpenGL; EGL elsewhere."""


def platform() -> str:
    """Return the OpenGL that ``MUJOCO_GL`` names, or else the usual one of this system."""
    return os.environ.get("MUJOCO_GL", "").lower() or USUAL.get(sys.platform, "egl")


def require_mujoco() -> None:
    """Raise CycloidError if MuJoCo cannot be imported, as where ``MUJOCO_GL`` names what is not installed."""
    try:
        importlib.import_module("mujoco")
    except Exception as problem:
        raise _missing(problem) from problem


@contextmanager
def opengl(model: Any, width: int, height: int) -> Iterator[Any]:
    """Yield MuJoCo's rendering context of a model, off-screen and of a size [pixels].

    Raises
    ------
    CycloidError
        There is no OpenGL.
    """
    mujoco = importlib.import_module("mujoco")
    try:
        # what GLFW warns of ends in an error
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            platform_context = importlib.import_module(f"mujoco.{platform()}").GLContext(width, height)
            platform_context.make_current()
        context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
    except Exception as problem:
        raise _missing(problem) from problem
    try:
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, context)
        yield context
    finally:
        context.free()
        platform_context.free()


def _missing(problem: Exception) -> CycloidError:
    reason = str(problem).splitlines()[0] if str(problem) else type(problem).__name__
    return CycloidError(
        f"there is no OpenGL ({platform()}) to render with: {reason}; install a driver (Debian: libegl1 with "
        "libgl1-mesa-dri, or libosmesa6 and MUJOCO_GL=osmesa), or draw in 2-D with `cycloid-mj animate`"
    )
