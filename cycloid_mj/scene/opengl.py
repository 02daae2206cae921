"""OpenGL without a display: MuJoCo's contexts, and the error if there is none."""

import importlib
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from cycloid_mj.base.errors import CycloidError

USUAL = {"darwin": "cgl", "win32": "glfw"}
"""MuJoCo's OpenGL module by platform; EGL on all others."""


def platform() -> str:
    """Return the OpenGL that ``MUJOCO_GL`` names, by default that of the operating system."""
    return os.environ.get("MUJOCO_GL", "").lower() or USUAL.get(sys.platform, "egl")


def require_mujoco() -> None:
    """Raise CycloidError if MuJoCo cannot be imported, for example if ``MUJOCO_GL`` names a missing library."""
    try:
        importlib.import_module("mujoco")
    except Exception as problem:
        raise _missing(problem) from problem


@contextmanager
def opengl(model: Any, width: int, height: int) -> Iterator[Any]:
    """Yield MuJoCo's off-screen rendering context (``MjrContext``) of a model, and free it afterwards.

    `width` and `height` are the size of the image [pixels].

    Raises
    ------
    CycloidError
        OpenGL is not available.
    """
    mujoco = importlib.import_module("mujoco")
    try:
        # the warnings of GLFW precede an error
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
        f"OpenGL ({platform()}) cannot render images: {reason}. Install a driver (Debian: libegl1 with "
        "libgl1-mesa-dri, or libosmesa6 with the environment variable MUJOCO_GL=osmesa), or draw in 2-D with "
        "`cycloid-mj animate`"
    )
