"""The collider: exact conjugate contact at MuJoCo's extension point for collision functions.

MuJoCo looks up ``mjCOLLISIONFUNC[type][type]`` for each pair of geoms. All parts in contact stand in the model as
cylinders, so one entry is replaced, [cylinder][cylinder]. A geom of ours carries its role as its ``priority`` (which
MuJoCo does not use for explicit pairs); every other pair goes on to the original function. The collider keeps no
state: all it needs stands in the ``mjModel`` and ``mjData`` that it is called with.
"""

import zlib
from contextlib import AbstractContextManager
from enum import IntEnum
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding
from numba import cfunc, types

from cycloid_mj.contact import gap, mating, memory, near, ring, teeth
from cycloid_mj.contact.layout import Layout, discover
from cycloid_mj.contact.library import CYLINDER, TYPES, collision_table
from cycloid_mj.contact.mating import PRIORITY, inner_in_outer, lobe_on_teeth, pin_on_teeth
from cycloid_mj.contact.memory import read_address, read_int
from cycloid_mj.contact.shared import Shared
from cycloid_mj.errors import ContactError

_SIGNATURE = types.int32(types.intp, types.intp, types.intp, types.int32, types.int32, types.float64)
_ENTRY = CYLINDER * TYPES + CYLINDER
_ORIGINAL = "cycloid_mj_original_cylinder_collider"
_original = types.ExternalFunction(_ORIGINAL, _SIGNATURE)


class Role(IntEnum):
    """What a geom is to the collider; the numbers are unlikely as a priority in anybody else's model."""

    PIN = 0x63796D01
    TEETH = 0x63796D02
    INNER = 0x63796D03
    OUTER = 0x63796D04
    LOBE = 0x63796D05


_PIN, _TEETH, _INNER, _OUTER, _LOBE = (int(role) for role in Role)


def _compile(layout: Layout) -> Any:
    """Compile the collider for a layout, or load it from numba's cache.

    The cache's key holds the places that the function closes over; with them stands a digest of the sources compiled
    into it, which numba does not follow into other files.
    """
    compiled = (gap, mating, memory, near, ring, teeth)
    sources = [Path(module.__file__).read_bytes() for module in compiled if module.__file__]
    digest = zlib.crc32(b"".join(sources))
    at = (layout.geom_size, layout.geom_priority, layout.geom_user, layout.geom_xpos, layout.geom_xmat, digest)

    @cfunc(_SIGNATURE, cache=True)
    def collide(model: int, data: int, out: int, geom1: int, geom2: int, margin: float) -> int:
        priority = read_address(model + at[PRIORITY])
        role1, role2 = read_int(priority + 4 * geom1), read_int(priority + 4 * geom2)
        if role1 == _TEETH and role2 == _PIN:
            return pin_on_teeth(at, model, data, out, geom1, geom2, 1.0, margin)
        if role1 == _PIN and role2 == _TEETH:
            return pin_on_teeth(at, model, data, out, geom2, geom1, -1.0, margin)
        if role1 == _TEETH and role2 == _LOBE:
            return lobe_on_teeth(at, model, data, out, geom1, geom2, 1.0, margin)
        if role1 == _LOBE and role2 == _TEETH:
            return lobe_on_teeth(at, model, data, out, geom2, geom1, -1.0, margin)
        if role2 == _OUTER and role1 in (_INNER, _PIN):
            return inner_in_outer(at, model, data, out, geom1, geom2, 1.0, margin)
        if role1 == _OUTER and role2 in (_INNER, _PIN):
            return inner_in_outer(at, model, data, out, geom2, geom1, -1.0, margin)
        return _original(model, data, out, geom1, geom2, margin)

    return collide


@cache
def _collider() -> Any:
    """Compile the collider, or load it from numba's cache; the original's address is bound by name."""
    original = collision_table()[_ENTRY]
    if not original:
        raise ContactError("MuJoCo has no collision function for two cylinders to pass foreign pairs on to")
    llvmlite.binding.add_symbol(_ORIGINAL, original)
    return original, _compile(discover())


def _install() -> None:
    _, collider = _collider()
    collision_table()[_ENTRY] = collider.address


def _uninstall() -> None:
    original, _ = _collider()
    collision_table()[_ENTRY] = original


_installation = Shared(_install, _uninstall)


def installed() -> AbstractContextManager[None]:
    """Run MuJoCo with exact conjugate contact inside this ``with`` block; nested and parallel blocks are allowed."""
    return _installation.made()
