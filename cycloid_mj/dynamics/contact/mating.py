"""Contacts of two mating geoms, in the format of MuJoCo's narrow phase.

Each function takes the layout, the addresses of ``mjModel``, ``mjData`` and of the contacts to fill
(``mjPreContact``), two geoms, the sign of the normal (which points from the first to the second geom of MuJoCo's pair)
and the margin [m]; it returns the number of contacts.
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
from cycloid_mj.dynamics.contact.crank_train import flank_normal, planet_flanks, read_mesh
from cycloid_mj.dynamics.contact.gap import PartialCircle, Pose, circle_in_circle
from cycloid_mj.dynamics.contact.layout import Layout
from cycloid_mj.dynamics.contact.memory import read_address, read_float, read_int, write_float
from cycloid_mj.dynamics.contact.teeth import Teeth, read_teeth


@njit(inline="always")
def write_contact(address: int, gap: float, x: float, y: float, z: float, nx: float, ny: float) -> None:
    """Write one contact as MuJoCo's ``mjPreContact`` at a memory address: dist, pos[3], normal[3], tangent[3].

    `gap` [m] is negative in contact, the point is (x, y, z) [m], the unit normal (nx, ny) in the plane.
    """
    write_float(address, gap)
    write_float(address + 8, x)
    write_float(address + 16, y)
    write_float(address + 24, z)
    write_float(address + 32, nx)
    write_float(address + 40, ny)
    write_float(address + 48, 0.0)
    write_float(address + 56, -ny)
    write_float(address + 64, nx)
    write_float(address + 72, 0.0)


@njit(inline="always")
def _position(data: int, layout: Layout, geom: int) -> tuple[float, float, float]:
    """Return the position of a geom in the world [m]."""
    xpos = read_address(data + layout.geom_xpos) + 24 * geom
    return read_float(xpos), read_float(xpos + 8), read_float(xpos + 16)


@njit(inline="always")
def _centre_at(data: int, layout: Layout, geom: int, z: float) -> tuple[float, float]:
    """Return the point of the axis of a geom, which may be tilted, at a position z of the world [m]."""
    x, y, middle = _position(data, layout, geom)
    xmat = read_address(data + layout.geom_xmat) + 72 * geom
    height = (z - middle) / read_float(xmat + 64)
    return x + height * read_float(xmat + 16), y + height * read_float(xmat + 40)


@njit(inline="always")
def _pose(data: int, layout: Layout, geom: int) -> Pose:
    """Return the pose of a geom in the plane of the world."""
    x, y, _ = _position(data, layout, geom)
    xmat = read_address(data + layout.geom_xmat) + 72 * geom
    return Pose(x, y, read_float(xmat), read_float(xmat + 24))


@njit(inline="always")
def _user_address(model: int, layout: Layout, geom: int) -> int:
    """Return the address of the ``geom user`` of a geom."""
    return read_address(model + layout.geom_user) + 8 * read_int(model + layout.nuser_geom) * geom


@njit(inline="always")
def _teeth(model: int, layout: Layout, geom: int) -> Teeth:
    return read_teeth(_user_address(model, layout, geom), read_int(model + layout.nuser_geom))


@njit(inline="always")
def _radius(model: int, layout: Layout, geom: int) -> float:
    return read_float(read_address(model + layout.geom_size) + 24 * geom)


@njit(inline="always")
def _scaled_gap(gap: float, factor: float) -> float:
    """Return the gap that scales the stiffness of a penetration by ``factor``, at the constant stiffness of MuJoCo."""
    return factor * gap if gap < 0.0 else gap


@njit(inline="always")
def _write_touch(address: int, touch: Touch, z: float, sign: float) -> None:
    """Write a contact point at the height z [m] as MuJoCo's ``mjPreContact``; it may have been read from there."""
    gap = _scaled_gap(touch.gap, touch.factor)
    write_contact(address, gap, touch.x, touch.y, z, sign * touch.nx, sign * touch.ny)


@compiling.njit(inner=True)
def write_pin_contact(
    layout: Layout, model: int, data: int, address: int, teeth: int, pin: int, sign: float, margin: float
) -> int:
    """Write the contact of a ring pin and the teeth at a memory address, and return the number of contacts, 0 or 1.

    `layout` has the offsets of MuJoCo's arrays. `model`, `data` and `address` are the memory addresses of ``mjModel``,
    ``mjData`` and the ``mjPreContact``, `teeth` and `pin` the indices of the geoms. `sign` is 1 if `teeth` is the first
    geom, else -1, which reverses the normal; contacts have gaps below `margin` [m].
    """
    user_data = _user_address(model, layout, pin)
    ring_pin = RingPin(
        _radius(model, layout, pin),
        read_float(user_data),
        read_float(user_data + 8),
        read_float(user_data + 16),
        read_float(user_data + 24),
        read_float(user_data + 32),
    )
    z = _position(data, layout, teeth)[2]
    px, py = _centre_at(data, layout, pin, z)
    contact = pin_touch(_teeth(model, layout, teeth), ring_pin, _pose(data, layout, teeth), px, py, margin)
    if not contact.exists:
        return 0
    _write_touch(address, contact.touch, z, sign)
    return 1


@compiling.njit(inner=True)
def write_lobe_contacts(
    layout: Layout, model: int, data: int, contacts: int, teeth: int, geom: int, sign: float, margin: float
) -> int:
    """Write the contacts of the teeth with a lobe of the internal gear and its roots; return their number.

    `layout` has the offsets of MuJoCo's arrays. `model`, `data` and `contacts` are the memory addresses of ``mjModel``,
    ``mjData`` and an array of ``mjPreContact``, `teeth` and `geom` the indices of the geoms of the teeth and of the
    lobe. `sign` is 1 if `teeth` is the first geom, else -1, which reverses the normal; contacts have gaps below
    `margin` [m].
    """
    lobe, gear, z = _pose(data, layout, geom), _pose(data, layout, teeth), _position(data, layout, teeth)[2]
    count = lobe_touches(contacts, _teeth(model, layout, teeth), _radius(model, layout, geom), lobe, gear, margin)
    for address in range(contacts, contacts + STRIDE * count, STRIDE):
        _write_touch(address, read_touch(address), z, sign)
    return count


@compiling.njit(inner=True)
def write_round_contacts(
    layout: Layout, model: int, data: int, contacts: int, inner: int, outer: int, sign: float, margin: float
) -> int:
    """Write the contacts of a circle in the circle or arc around it for MuJoCo, and return their number.

    `layout` has the offsets of MuJoCo's arrays. `model`, `data` and `contacts` are the memory addresses of ``mjModel``,
    ``mjData`` and an array of ``mjPreContact``, `inner` and `outer` the indices of the geoms. `sign` is 1 if `inner` is
    the first geom, else -1, which reverses the normal; contacts have gaps below `margin` [m]. They are in the middle
    plane of the outer geom, or in two planes on both sides of it if one of the geoms is a tilting pin.
    """
    middle_z = _position(data, layout, outer)[2]
    user_data, outer_pose = _user_address(model, layout, outer), _pose(data, layout, outer)
    outer_arc = PartialCircle(
        _radius(model, layout, outer),
        -outer_pose.sine,
        outer_pose.cosine,
        read_float(user_data),
        read_float(user_data + 8),
    )
    plane_distance, count = read_float(user_data + 16) if read_int(model + layout.nuser_geom) > 2 else 0.0, 0
    for plane in range(2 if plane_distance > 0.0 else 1):
        z = middle_z + (plane_distance if plane else -plane_distance)
        x, y = _centre_at(data, layout, inner, z)
        outer_x, outer_y = _centre_at(data, layout, outer, z)
        dx, dy, first_address = x - outer_x, y - outer_y, contacts + STRIDE * count
        new_contacts = inner_touches(first_address, dx, dy, x, y, _radius(model, layout, inner), outer_arc, margin)
        for address in range(first_address, first_address + STRIDE * new_contacts, STRIDE):
            _write_touch(address, read_touch(address), z, sign)
        count += new_contacts
    return count


@compiling.njit(inner=True)
def write_bearing_contacts(
    layout: Layout, model: int, data: int, contacts: int, eccentric: int, bore: int, sign: float, margin: float
) -> int:
    """Write the contacts of an eccentric in its bore for MuJoCo, and return their number.

    `layout` has the offsets of MuJoCo's arrays. `model`, `data` and `contacts` are the memory addresses of ``mjModel``,
    ``mjData`` and an array of ``mjPreContact``, `eccentric` and `bore` the indices of the geoms. `sign` is 1 if
    `eccentric` is the first geom, else -1, which reverses the normal; contacts have gaps below `margin` [m]. With a
    preload the bore is smaller than the eccentric, and needles on the opposite side have a contact, too, until their
    gap opens.
    """
    (x, y, _), (bore_x, bore_y, z) = _position(data, layout, eccentric), _position(data, layout, bore)
    inner_radius, outer_radius = _radius(model, layout, eccentric), _radius(model, layout, bore)
    gap, nx, ny = circle_in_circle(x - bore_x, y - bore_y, inner_radius, outer_radius)
    count = 0
    for side, side_gap in ((1.0, gap), (-1.0, 2.0 * (outer_radius - inner_radius) - gap)):
        if side_gap < margin and (side > 0.0 or outer_radius < inner_radius):
            contact_x, contact_y = x + side * inner_radius * nx, y + side * inner_radius * ny
            normal_sign = sign * side
            write_contact(
                contacts + STRIDE * count, side_gap, contact_x, contact_y, z, normal_sign * nx, normal_sign * ny
            )
            count += 1
    return count


@compiling.njit(inner=True)
def write_planet_contacts(
    layout: Layout, model: int, data: int, contacts: int, sun: int, planet: int, sign: float, margin: float
) -> int:
    """Write the contacts of both flanks of sun and planet for MuJoCo, and return their number.

    `layout` has the offsets of MuJoCo's arrays. `model`, `data` and `contacts` are the memory addresses of ``mjModel``,
    ``mjData`` and an array of ``mjPreContact``, `sun` and `planet` the indices of the geoms. `sign` is 1 if `sun` is
    the first geom, else -1, which reverses the normal; contacts have gaps below `margin` [m].
    """
    mesh, sun_pose = read_mesh(_user_address(model, layout, planet)), _pose(data, layout, sun)
    flanks, z = planet_flanks(mesh, sun_pose, _pose(data, layout, planet)), _position(data, layout, planet)[2]
    pitch_x, pitch_y = sun_pose.x + flanks.pitch_radius * flanks.x, sun_pose.y + flanks.pitch_radius * flanks.y
    count = 0
    for side, gap in ((1.0, flanks.gap), (-1.0, flanks.opposite)):
        if gap < margin:
            nx, ny = flank_normal(flanks, side)
            contact_x, contact_y = pitch_x + mesh.arm * nx, pitch_y + mesh.arm * ny
            write_contact(contacts + STRIDE * count, gap, contact_x, contact_y, z, sign * nx, sign * ny)
            count += 1
    return count
