"""The collider: exact conjugate contact at MuJoCo's extension point for collision functions.

MuJoCo looks up ``mjCOLLISIONFUNC[type][type]`` for each pair of geoms. All parts in contact stand in the model as
cylinders, so one entry is replaced, [cylinder][cylinder]. A geom of ours carries its role as its ``priority`` (which
MuJoCo does not use for explicit pairs); every other pair goes on to the original function. The collider keeps no
state: all it needs stands in the ``mjModel`` and ``mjData`` that it is called with.
"""

import math
import zlib
from contextlib import AbstractContextManager
from enum import IntEnum
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding
from numba import cfunc, njit, types

from cycloid_mj.contact import gap, memory, ring
from cycloid_mj.contact.gap import circle_in_circle, trochoid_curvature, trochoid_distance
from cycloid_mj.contact.layout import Layout, discover
from cycloid_mj.contact.library import CYLINDER, TYPES, collision_table
from cycloid_mj.contact.memory import read_address, read_float, read_int, write_float
from cycloid_mj.contact.ring import is_monotone, offset_root, root_minimum, root_start
from cycloid_mj.contact.shared import Shared
from cycloid_mj.errors import ContactError

USER_DATA = 7
"""Numbers of ``geom user`` in a model of ours, given for the teeth.

E [m], c [m], N, the inward offset of the flank from the trochoid [m]; then what makes the stiffness follow the relative
curvature, ``law.CurvatureLaw``: reference and constant of the compliance [1]; the deflection at working force [m].
"""

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
_CONTACT = 80
_SIZE, _PRIORITY, _USER, _XPOS, _XMAT = range(5)
_Places = tuple[int, int, int, int, int, int]
_SCAN = 64


@njit(inline="always")
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


@njit(inline="always")
def _stiffness_factor(curvature: float, reference: float, constant: float) -> float:
    """Give the factor on the stiffness at a relative curvature [1/m]; 1 where the law is switched off."""
    if reference == 0.0:
        return 1.0
    least = math.exp(0.5 * reference - constant)
    return reference / (constant + math.log(max(curvature, least)))


@njit(inline="always")
def _pressed(gap: float, factor: float) -> float:
    """Give the gap that makes MuJoCo's constant stiffness act as ``factor`` times as much on a penetration."""
    return factor * gap if gap < 0.0 else gap


@njit
def _pin_on_teeth(
    at: _Places, model: int, data: int, out: int, teeth: int, pin: int, sign: float, margin: float
) -> int:
    user = read_address(model + at[_USER]) + 8 * USER_DATA * teeth
    radius, eccentricity = read_float(user), read_float(user + 8)
    number, offset = read_float(user + 16), read_float(user + 24)
    pin_radius = read_float(read_address(model + at[_SIZE]) + 24 * pin)
    xpos, xmat = read_address(data + at[_XPOS]), read_address(data + at[_XMAT]) + 72 * teeth
    px, py = read_float(xpos + 24 * pin), read_float(xpos + 24 * pin + 8)
    dx, dy = px - read_float(xpos + 24 * teeth), py - read_float(xpos + 24 * teeth + 8)
    cosine, sine = read_float(xmat), read_float(xmat + 24)
    x, y = cosine * dx + sine * dy, cosine * dy - sine * dx
    t, distance, nx, ny = trochoid_distance(x, y, radius, eccentricity, number)
    gap = distance + offset - pin_radius
    if not gap < margin:
        return 0
    bend = trochoid_curvature(t, radius, eccentricity, number)
    relative = bend / (1.0 - offset * bend) + 1.0 / pin_radius
    factor = _stiffness_factor(relative, read_float(user + 32), read_float(user + 40))
    wx, wy = cosine * nx - sine * ny, sine * nx + cosine * ny
    depth = pin_radius + 0.5 * gap
    z = read_float(xpos + 24 * teeth + 16)
    _write_contact(out, _pressed(gap, factor), px - depth * wx, py - depth * wy, z, sign * wx, sign * wy)
    return 1


@njit
def _lobe_on_teeth(
    at: _Places, model: int, data: int, out: int, teeth: int, lobe: int, sign: float, margin: float
) -> int:
    user = read_address(model + at[_USER]) + 8 * USER_DATA * teeth
    radius, eccentricity = read_float(user), read_float(user + 8)
    number, offset = read_float(user + 16), read_float(user + 24)
    reference, constant, deflection = read_float(user + 32), read_float(user + 40), read_float(user + 48)
    ring_radius = read_float(read_address(model + at[_SIZE]) + 24 * lobe)
    xpos, xmat = read_address(data + at[_XPOS]), read_address(data + at[_XMAT])
    px, py = read_float(xpos + 24 * lobe), read_float(xpos + 24 * lobe + 8)
    z = read_float(xpos + 24 * teeth + 16)
    # The gear in the lobe's frame: axis of the ring at the origin, lobe on +y.
    lc, ls = read_float(xmat + 72 * lobe), read_float(xmat + 72 * lobe + 24)
    gc, gs = read_float(xmat + 72 * teeth), read_float(xmat + 72 * teeth + 24)
    dx, dy = read_float(xpos + 24 * teeth) - px, read_float(xpos + 24 * teeth + 8) - py
    gx, gy = lc * dx + ls * dy, lc * dy - ls * dx + radius
    cosine, sine = lc * gc + ls * gs, lc * gs - ls * gc

    ax, ay = -gx, radius - gy
    t, distance, nx, ny = trochoid_distance(
        cosine * ax + sine * ay, cosine * ay - sine * ax, radius, eccentricity, number
    )
    arc_gap = distance + offset - ring_radius
    wx, wy = cosine * nx - sine * ny, sine * nx + cosine * ny
    share = eccentricity * number / radius
    # Beyond the fan of its normals the arc ends: the gap goes on falling along the flank of the root.
    has_arc = abs(wx) <= share and arc_gap < margin
    bend = trochoid_curvature(t, radius, eccentricity, number)
    arc_factor = _stiffness_factor(bend / (1.0 - offset * bend) + 1.0 / ring_radius, reference, constant)
    arc_x, arc_y = wx, wy

    count = 0
    turn = (number - 1.0) * math.atan2(sine, cosine)
    crank = turn - 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
    monotone = is_monotone(radius, eccentricity, number)
    low = math.acos(share)
    high = 2.0 * math.pi - low
    for side in range(2):
        # The root on the clockwise side is that of the next lobe: one pitch further clockwise.
        own = side == 0
        pitch = 0.0 if own else 2.0 * math.pi / number
        start = root_start(crank - pitch, radius, eccentricity, number) if monotone else math.pi
        if start == 0.0:
            continue
        pc, ps = math.cos(pitch), -math.sin(pitch)
        rx, ry = pc * gx + ps * gy, pc * gy - ps * gx
        rc, rs = pc * cosine + ps * sine, pc * sine - ps * cosine
        bottom, top = (low, math.pi) if own else (math.pi, high)
        pieces = 1 if monotone else _SCAN
        for piece in range(pieces):
            left = bottom + (top - bottom) * piece / pieces
            right = bottom + (top - bottom) * (piece + 1) / pieces
            found, phase, distance, t, wx, wy = root_minimum(
                left,
                right,
                start if monotone else 0.5 * (left + right),
                radius,
                eccentricity,
                number,
                rc,
                rs,
                rx,
                ry,
            )
            gap = distance + offset - ring_radius
            if not (found and gap < margin):
                continue
            x, y, _, _, curvature = offset_root(phase, radius, eccentricity, number)
            bend = trochoid_curvature(t, radius, eccentricity, number)
            relative = bend / (1.0 - offset * bend) - curvature / (1.0 - ring_radius * curvature)
            factor = _stiffness_factor(relative, reference, constant)
            if has_arc and deflection > 0.0:
                # Lines with less than a deflection of gap between them are one patch, shared half and half.
                between = 0.5 * (phase + (low if own else high))
                mx, my, _, _, _ = offset_root(between, radius, eccentricity, number)
                ex, ey = mx - rx, my - ry
                _, middle, _, _ = trochoid_distance(rc * ex + rs * ey, rc * ey - rs * ex, radius, eccentricity, number)
                rise = middle + offset - ring_radius - max(gap, arc_gap)
                apart = min(1.0, max(0.0, rise / deflection))
                factor = (0.5 + 0.5 * apart) * (arc_factor + apart * (factor - arc_factor))
                arc_factor *= 0.5 + 0.5 * apart
            depth = ring_radius + 0.5 * gap
            qx, qy = x - depth * wx, y - depth * wy
            # Back from the root's frame to the lobe's, and to the world.
            fx, fy = pc * qx - ps * qy, pc * qy + ps * qx - radius
            vx, vy = pc * wx - ps * wy, pc * wy + ps * wx
            _write_contact(
                out + _CONTACT * count,
                _pressed(gap, factor),
                px + lc * fx - ls * fy,
                py + lc * fy + ls * fx,
                z,
                sign * (lc * vx - ls * vy),
                sign * (lc * vy + ls * vx),
            )
            count += 1
    if has_arc:
        depth = ring_radius + 0.5 * arc_gap
        vx, vy = lc * arc_x - ls * arc_y, lc * arc_y + ls * arc_x
        _write_contact(
            out + _CONTACT * count,
            _pressed(arc_gap, arc_factor),
            px - depth * vx,
            py - depth * vy,
            z,
            sign * vx,
            sign * vy,
        )
        count += 1
    return count


@njit
def _inner_in_outer(
    at: _Places, model: int, data: int, out: int, inner: int, outer: int, sign: float, margin: float
) -> int:
    size, xpos = read_address(model + at[_SIZE]), read_address(data + at[_XPOS])
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


def _compile(layout: Layout) -> Any:
    """Compile the collider for a layout, or load it from numba's cache.

    The cache's key holds the places that the function closes over; with them stands a digest of the sources compiled
    into it, which numba does not follow into other files.
    """
    sources = [Path(module.__file__).read_bytes() for module in (gap, memory, ring) if module.__file__]
    digest = zlib.crc32(b"".join(sources))
    at = (layout.geom_size, layout.geom_priority, layout.geom_user, layout.geom_xpos, layout.geom_xmat, digest)

    @cfunc(_SIGNATURE, cache=True)
    def collide(model: int, data: int, out: int, geom1: int, geom2: int, margin: float) -> int:
        priority = read_address(model + at[_PRIORITY])
        role1, role2 = read_int(priority + 4 * geom1), read_int(priority + 4 * geom2)
        if role1 == _TEETH and role2 == _PIN:
            return _pin_on_teeth(at, model, data, out, geom1, geom2, 1.0, margin)
        if role1 == _PIN and role2 == _TEETH:
            return _pin_on_teeth(at, model, data, out, geom2, geom1, -1.0, margin)
        if role1 == _TEETH and role2 == _LOBE:
            return _lobe_on_teeth(at, model, data, out, geom1, geom2, 1.0, margin)
        if role1 == _LOBE and role2 == _TEETH:
            return _lobe_on_teeth(at, model, data, out, geom2, geom1, -1.0, margin)
        if role2 == _OUTER and role1 in (_INNER, _PIN):
            return _inner_in_outer(at, model, data, out, geom1, geom2, 1.0, margin)
        if role1 == _OUTER and role2 in (_INNER, _PIN):
            return _inner_in_outer(at, model, data, out, geom2, geom1, -1.0, margin)
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
