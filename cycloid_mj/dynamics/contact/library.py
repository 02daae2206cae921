"""MuJoCo's own shared library, as loaded by its Python bindings, and its table of collision functions."""

import ctypes
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import mujoco

from cycloid_mj.base.errors import ContactError

KNOWN = ("3.17.0", "4.0.0", "4.0.1")
"""Releases of MuJoCo that pass the tests of the contact (``scripts/test_mujoco_versions.py``), oldest first.

The contact code accesses MuJoCo's own structures, which may change between releases. Newer releases may be installed;
``contact.selftest`` checks them.
"""


def incompatible_error(why: str) -> ContactError:
    """Return the error for an incompatible release."""
    return ContactError(
        f"MuJoCo {mujoco.__version__} is not compatible with this version of cycloid_mj ({why}). Tested releases: "
        f"{', '.join(KNOWN)}. Install one with: pip install 'mujoco=={KNOWN[0]}'"
    )


CYLINDER = int(mujoco.mjtGeom.mjGEOM_CYLINDER)
TYPES = int(mujoco.mjtGeom.mjNGEOMTYPES)

# The precision is one for the process, and a spec can be written by one thread at a time.
_precision = threading.Lock()


@cache
def library() -> ctypes.CDLL:
    """Load and return the shared library of MuJoCo that its Python bindings use.

    Raises
    ------
    ContactError
        There is no such library.
    """
    folders = [Path(folder) for folder in mujoco.__path__]
    candidates = [
        path for folder in folders for name in ("libmujoco*", "mujoco.dll") for path in sorted(folder.rglob(name))
    ]
    for path in candidates:
        shared_library = ctypes.CDLL(str(path))
        shared_library.mj_versionString.restype = ctypes.c_char_p
        if shared_library.mj_versionString().decode() == mujoco.mj_versionString():
            return shared_library
    raise ContactError(
        f"the shared library of MuJoCo {mujoco.__version__} was not found in {', '.join(map(str, folders))}. Reinstall "
        "it with: pip install --force-reinstall mujoco"
    )


def collision_table() -> Any:
    """Return ``mjCOLLISIONFUNC`` as a writable array of ``TYPES * TYPES`` addresses."""
    return (ctypes.c_void_p * (TYPES * TYPES)).in_dll(library(), "mjCOLLISIONFUNC")


def callback(name: str) -> ctypes.c_void_p:
    """Return one of MuJoCo's global callbacks as a writable address; none: 0."""
    return ctypes.c_void_p.in_dll(library(), name)


def set_callback(name: str, address: int) -> None:
    """Set a global callback of MuJoCo, such as ``mjcb_sensor``, to the address of a compiled function; 0 removes it.

    Raises
    ------
    ContactError
        The callback is already in use.
    """
    if callback(name).value:
        raise ContactError(
            f"MuJoCo's callback {name} is already in use, but the simulation needs it: call mujoco.set_{name}(None) "
            "first"
        )
    callback(name).value = address


def function_address(name: str) -> int:
    """Return the address of a function of MuJoCo's C API."""
    function = getattr(library(), name, None)
    address = function and ctypes.cast(function, ctypes.c_void_p).value
    if not address:
        raise incompatible_error(f"it lacks the function {name}")
    return address


@contextmanager
def exact_xml() -> Iterator[None]:
    """Make MuJoCo write MJCF with all digits of a double inside this ``with`` block.

    The default is six digits, coarser than 1 um. Raises ContactError if this release of MuJoCo cannot change it.
    """
    setter = getattr(library(), "_mjPRIVATE__set_xml_precision", None)
    getter = getattr(library(), "_mjPRIVATE__get_xml_precision", None)
    if setter is None or getter is None:
        raise incompatible_error("it cannot write exact XML")
    with _precision:
        previous_precision = getter()
        setter(17)
        try:
            yield
        finally:
            setter(previous_precision)
