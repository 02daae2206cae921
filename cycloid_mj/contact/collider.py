"""The collider: exact conjugate contact at MuJoCo's extension point for collision functions.

MuJoCo looks up ``mjCOLLISIONFUNC[type][type]`` for each pair of geoms. All parts in contact stand in the model as
cylinders, so one entry is replaced, [cylinder][cylinder]. A geom of ours carries its role as its ``priority`` (which
MuJoCo does not use for explicit pairs); every other pair goes on to the original function. The collider keeps no
state: all it needs stands in the ``mjModel`` and ``mjData`` that it is called with.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum
from functools import cache
from typing import Any

import llvmlite.binding
from numba import cfunc, njit, types

from cycloid_mj.contact.gap import circle_in_circle, trochoid_distance
from cycloid_mj.contact.layout import Layout, discover
from cycloid_mj.contact.library import CYLINDER, TYPES, collision_table
from cycloid_mj.contact.memory import read_address, read_float, read_int, write_float
from cycloid_mj.errors import ContactError

USER_DATA = 4
"""Numbers of ``geom user`` in a model of ours: for teeth E [m], c [m], N and the inward offset of the flank [m]."""

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


_PIN, _TEETH, _INNER, _OUTER = (int(role) for role in Role)


@njit(cache=True, inline="always")
def _write_contact(out: int, gap: float, x: float, y: float, z: float, nx: float, ny: float) -> None:
    """Fill one ``mjPreContact``: dist, pos[3], normal[3], tangent[3]."""
    write_float(out, gap)
    write_float(out + 8, x)
    write_float(out + 16, y)
    write_float(out + 24, z)
    write_float(out + 32, nx)
    write_float(out + 40, ny)
    write_float(out + 48, 0.0)
    write_float(out + 56, -ny)
    write_float(out + 64, nx)
    write_float(out + 72, 0.0)


def _compile(layout: Layout) -> Any:
    at_size, at_priority, at_user = layout.geom_size, layout.geom_priority, layout.geom_user
    at_xpos, at_xmat = layout.geom_xpos, layout.geom_xmat

    @njit(cache=True)
    def pin_on_teeth(model: int, data: int, out: int, teeth: int, pin: int, sign: float, margin: float) -> int:
        user = read_address(model + at_user) + 8 * USER_DATA * teeth
        radius, eccentricity = read_float(user), read_float(user + 8)
        number, offset = read_float(user + 16), read_float(user + 24)
        pin_radius = read_float(read_address(model + at_size) + 24 * pin)
        xpos, xmat = read_address(data + at_xpos), read_address(data + at_xmat) + 72 * teeth
        px, py = read_float(xpos + 24 * pin), read_float(xpos + 24 * pin + 8)
        dx, dy = px - read_float(xpos + 24 * teeth), py - read_float(xpos + 24 * teeth + 8)
        cosine, sine = read_float(xmat), read_float(xmat + 24)
        x, y = cosine * dx + sine * dy, cosine * dy - sine * dx
        _, distance, nx, ny = trochoid_distance(x, y, radius, eccentricity, number)
        gap = distance + offset - pin_radius
        if not gap < margin:
            return 0
        wx, wy = cosine * nx - sine * ny, sine * nx + cosine * ny
        depth = pin_radius + 0.5 * gap
        z = read_float(xpos + 24 * teeth + 16)
        _write_contact(out, gap, px - depth * wx, py - depth * wy, z, sign * wx, sign * wy)
        return 1

    @njit(cache=True)
    def inner_in_outer(model: int, data: int, out: int, inner: int, outer: int, sign: float, margin: float) -> int:
        size, xpos = read_address(model + at_size), read_address(data + at_xpos)
        inner_radius, outer_radius = read_float(size + 24 * inner), read_float(size + 24 * outer)
        x, y = read_float(xpos + 24 * inner), read_float(xpos + 24 * inner + 8)
        dx, dy = x - read_float(xpos + 24 * outer), y - read_float(xpos + 24 * outer + 8)
        gap, nx, ny = circle_in_circle(dx, dy, inner_radius, outer_radius)
        if not gap < margin:
            return 0
        depth = inner_radius + 0.5 * gap
        z = read_float(xpos + 24 * inner + 16)
        _write_contact(out, gap, x + depth * nx, y + depth * ny, z, sign * nx, sign * ny)
        return 1

    @cfunc(_SIGNATURE, cache=True)
    def collide(model: int, data: int, out: int, geom1: int, geom2: int, margin: float) -> int:
        priority = read_address(model + at_priority)
        role1, role2 = read_int(priority + 4 * geom1), read_int(priority + 4 * geom2)
        if role1 == _TEETH and role2 == _PIN:
            return pin_on_teeth(model, data, out, geom1, geom2, 1.0, margin)
        if role1 == _PIN and role2 == _TEETH:
            return pin_on_teeth(model, data, out, geom2, geom1, -1.0, margin)
        if role2 == _OUTER and role1 in (_INNER, _PIN):
            return inner_in_outer(model, data, out, geom1, geom2, 1.0, margin)
        if role1 == _OUTER and role2 in (_INNER, _PIN):
            return inner_in_outer(model, data, out, geom2, geom1, -1.0, margin)
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


_lock = threading.Lock()
_users = 0


@contextmanager
def installed() -> Iterator[None]:
    """Run MuJoCo with exact conjugate contact inside this ``with`` block; nested and parallel blocks are allowed."""
    global _users
    with _lock:
        original, collider = _collider()
        collision_table()[_ENTRY] = collider.address
        _users += 1
    try:
        yield
    finally:
        with _lock:
            _users -= 1
            if not _users:
                collision_table()[_ENTRY] = original
