"""Contacts of two mating geoms of ours, written as MuJoCo's narrow phase wants them.

Each function takes the places of MuJoCo's arrays, the addresses of ``mjModel``, ``mjData`` and of the contacts to fill
(``mjPreContact``), two geoms, the sign of the normal (it leads from the first geom of MuJoCo's pair to the second) and
the margin [m]; it gives the number of contacts.
"""

from numba import njit

from cycloid_mj.base import compiling
from cycloid_mj.dynamics.contact.contact_search import (
    STRIDE,
    RingPin,
    Touch,
    inner_touches,
    lobe_touches,
    pin_touch,
    read_touch,
)
from cycloid_mj.dynamics.contact.gap import PartialCircle, Pose
from cycloid_mj.dynamics.contact.memory import read_address, read_float, read_int, write_float
from cycloid_mj.dynamics.contact.teeth import Teeth, read_teeth

SIZE, PRIORITY, USER, XPOS, XMAT, NUMBERS = range(6)
"""What the places are of; the last of how many numbers each geom has in ``geom user``."""

Places = tuple[int, int, int, int, int, int, int]


@njit(inline="always")
def write_contact(out: int, gap: float, x: float, y: float, z: float, nx: float, ny: float) -> None:
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
def _place(data: int, at: Places, geom: int) -> tuple[float, float, float]:
    """Return the place of a geom in the world [m]."""
    xpos = read_address(data + at[XPOS]) + 24 * geom
    return read_float(xpos), read_float(xpos + 8), read_float(xpos + 16)


@njit(inline="always")
def _pose(data: int, at: Places, geom: int) -> Pose:
    """Return the pose of a geom in the plane of the world."""
    x, y, _ = _place(data, at, geom)
    xmat = read_address(data + at[XMAT]) + 72 * geom
    return Pose(x, y, read_float(xmat), read_float(xmat + 24))


@njit(inline="always")
def _user(model: int, at: Places, geom: int) -> int:
    """Return the address of the ``geom user`` of a geom."""
    return read_address(model + at[USER]) + 8 * read_int(model + at[NUMBERS]) * geom


@njit(inline="always")
def _teeth(model: int, at: Places, geom: int) -> Teeth:
    return read_teeth(_user(model, at, geom), read_int(model + at[NUMBERS]))


@njit(inline="always")
def _radius(model: int, at: Places, geom: int) -> float:
    return read_float(read_address(model + at[SIZE]) + 24 * geom)


@njit(inline="always")
def _pressed(gap: float, factor: float) -> float:
    """Compute the gap that makes MuJoCo's constant stiffness act as ``factor`` times as much on a penetration."""
    return factor * gap if gap < 0.0 else gap


@njit(inline="always")
def _write(out: int, touch: Touch, z: float, sign: float) -> None:
    """Write the contact of a touch in the plane at z [m], in its place or elsewhere."""
    gap = _pressed(touch.gap, touch.factor)
    write_contact(out, gap, touch.x, touch.y, z, sign * touch.nx, sign * touch.ny)


@compiling.njit(inner=True)
def pin_on_teeth(at: Places, model: int, data: int, out: int, teeth: int, pin: int, sign: float, margin: float) -> int:
    """Bring a pin and the gear's teeth in contact."""
    user = _user(model, at, pin)
    seated = RingPin(
        _radius(model, at, pin),
        read_float(user),
        read_float(user + 8),
        read_float(user + 16),
        read_float(user + 24),
        read_float(user + 32),
    )
    px, py, _ = _place(data, at, pin)
    touch = pin_touch(_teeth(model, at, teeth), seated, _pose(data, at, teeth), px, py, margin)
    if not touch.touches:
        return 0
    line = Touch(touch.gap, touch.x, touch.y, touch.factor, touch.nx, touch.ny)
    _write(out, line, _place(data, at, teeth)[2], sign)
    return 1


@compiling.njit(inner=True)
def lobe_on_teeth(
    at: Places, model: int, data: int, out: int, teeth: int, geom: int, sign: float, margin: float
) -> int:
    """Bring a lobe of the internal gear, with half a root on either side, and the gear's teeth in contact."""
    lobe, gear, z = _pose(data, at, geom), _pose(data, at, teeth), _place(data, at, teeth)[2]
    count = lobe_touches(out, _teeth(model, at, teeth), _radius(model, at, geom), lobe, gear, margin)
    for place in range(out, out + STRIDE * count, STRIDE):
        _write(place, read_touch(place), z, sign)
    return count


@compiling.njit(inner=True)
def inner_in_outer(
    at: Places, model: int, data: int, out: int, inner: int, outer: int, sign: float, margin: float
) -> int:
    """Bring a circle and the circle around it in contact, which may be open."""
    # a pin through all discs meets the hole of one where that disc is
    (x, y, _), (outer_x, outer_y, z) = _place(data, at, inner), _place(data, at, outer)
    user, seat = _user(model, at, outer), _pose(data, at, outer)
    around = PartialCircle(_radius(model, at, outer), -seat.sine, seat.cosine, read_float(user), read_float(user + 8))
    count = inner_touches(out, x - outer_x, y - outer_y, x, y, _radius(model, at, inner), around, margin)
    for place in range(out, out + STRIDE * count, STRIDE):
        _write(place, read_touch(place), z, sign)
    return count
