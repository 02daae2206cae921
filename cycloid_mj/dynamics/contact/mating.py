"""Contacts of two mating geoms of ours, written as MuJoCo's narrow phase wants them.

Each function takes the places of MuJoCo's arrays, the addresses of ``mjModel``, ``mjData`` and of the contacts to fill
(``mjPreContact``), two geoms, the sign of the normal (it leads from the first geom of MuJoCo's pair to the second) and
the margin [m]; it gives the number of contacts.
"""

import math
from typing import NamedTuple

from numba import njit

from cycloid_mj.dynamics.contact.gap import (
    Arc,
    Pose,
    circle_at_edge,
    circle_in_circle,
    flank_distance,
    inwards,
    outwards,
    placed,
    places_in_arc,
    trochoid_curvature,
)
from cycloid_mj.dynamics.contact.memory import read_address, read_float, read_int, write_float
from cycloid_mj.dynamics.contact.near import Start, pin_distance, turned_times
from cycloid_mj.dynamics.contact.ring import is_monotone, offset_root, root_minimum, root_slope, root_start
from cycloid_mj.dynamics.contact.teeth import Teeth, read_teeth

CONTACT = 80
"""Bytes of an ``mjPreContact``."""

SIZE, PRIORITY, USER, XPOS, XMAT, NUMBERS = range(6)
"""What the places are of; the last of how many numbers each geom has in ``geom user``."""

Places = tuple[int, int, int, int, int, int, int]

_SCAN = 64
"""Pieces of a root that are searched apart, where the gap may have several minima in it."""

_MODIFIED_SCAN = 20
"""The same for a gear that is not conjugate to the ring: the minima crowd beside junction and middle, as the pieces."""

_BEYOND = 0.05
"""Angle [rad] that a root may lie from the eccentric direction beyond its ideal range and still be touched."""

_SECOND_ORDER = 0.02
"""Bound on what a displacement adds to a gap beyond its normal part, as a share of it."""


class Line(NamedTuple):
    """A line of contact: its gap [m], the factor on its stiffness, and the outward normal of the gear."""

    gap: float
    factor: float
    nx: float
    ny: float


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
    """Give the place of a geom in the world [m]."""
    xpos = read_address(data + at[XPOS]) + 24 * geom
    return read_float(xpos), read_float(xpos + 8), read_float(xpos + 16)


@njit(inline="always")
def _pose(data: int, at: Places, geom: int) -> Pose:
    """Give the pose of a geom in the plane of the world."""
    x, y, _ = _place(data, at, geom)
    xmat = read_address(data + at[XMAT]) + 72 * geom
    return Pose(x, y, read_float(xmat), read_float(xmat + 24))


@njit(inline="always")
def _user(model: int, at: Places, geom: int) -> int:
    """Give the address of the ``geom user`` of a geom."""
    return read_address(model + at[USER]) + 8 * read_int(model + at[NUMBERS]) * geom


@njit(inline="always")
def _teeth(model: int, at: Places, geom: int) -> Teeth:
    return read_teeth(_user(model, at, geom), read_int(model + at[NUMBERS]))


@njit(inline="always")
def _radius(model: int, at: Places, geom: int) -> float:
    return read_float(read_address(model + at[SIZE]) + 24 * geom)


@njit(inline="always")
def _stiffness_factor(teeth: Teeth, curvature: float) -> float:
    """Give the factor on the stiffness at a relative curvature [1/m]; 1 where the law is switched off."""
    if teeth.reference == 0.0:
        return 1.0
    least = math.exp(0.5 * teeth.reference - teeth.constant)
    return teeth.reference / (teeth.constant + math.log(max(curvature, least)))


@njit(inline="always")
def _pressed(gap: float, factor: float) -> float:
    """Give the gap that makes MuJoCo's constant stiffness act as ``factor`` times as much on a penetration."""
    return factor * gap if gap < 0.0 else gap


@njit
def pin_on_teeth(at: Places, model: int, data: int, out: int, teeth: int, pin: int, sign: float, margin: float) -> int:
    """Bring a pin and the gear's teeth in contact; a massless pin with its play and the compliance of its seat.

    A massless pin is a two-force body: it gives way by its play, then both of its contacts carry the same force, and
    their compliances add up. With the stiffness K f of a pin on the gear, f = 1 on a flat, and K/x of the seat, the
    pair's stiffness K/(1 + x) acts f (1 + x)/(1 + x f) times as much. A pin that has no home is carried by a ring that
    turns about the world's origin. A massless pin that is pressed towards the opening of its socket carries nothing.
    """
    profile = _teeth(model, at, teeth)
    offset = profile.flank.offset
    pin_radius = _radius(model, at, pin)
    own = _user(model, at, pin)
    reach, yielding = pin_radius - read_float(own + 16), read_float(own + 24)
    gear, (px, py, _) = _pose(data, at, teeth), _place(data, at, pin)
    x, y = inwards(gear, px - gear.x, py - gear.y)
    hs, hc = read_float(own), read_float(own + 8)
    carried = hs == 0.0 and hc == 0.0
    if carried:
        away = 1.0 / math.sqrt(px * px + py * py)
        hs, hc = px * away, py * away
    st, ct = hs * gear.cosine + hc * gear.sine, hc * gear.cosine - hs * gear.sine
    times = int(profile.ring.teeth)
    sn, cn = turned_times(st, ct, times) if carried else turned_times(gear.sine, gear.cosine, times)
    start = Start(st, ct, sn, cn)
    distance, nx, ny, bend = pin_distance(x, y, profile.flank, start, margin + reach - offset)
    gap = distance + offset - reach
    if not gap < margin:
        return 0
    wx, wy = outwards(gear, nx, ny)
    if 1.0 + wx * hs + wy * hc < read_float(own + 32):
        return 0  # pressed out of its seat's opening
    factor = _stiffness_factor(profile, bend / (1.0 - offset * bend) + 1.0 / pin_radius)
    factor *= (1.0 + yielding) / (1.0 + yielding * factor)
    depth = reach + 0.5 * gap
    z = _place(data, at, teeth)[2]
    write_contact(out, _pressed(gap, factor), px - depth * wx, py - depth * wy, z, sign * wx, sign * wy)
    return 1


@njit(inline="always")
def _edge(bottom: float, top: float, share: float, own: bool, crowded: bool) -> float:
    """Give the phase at a share of a half root, the lobe's own or the next lobe's.

    Where crowded, the edges are dense at the middle of the root and denser at its junction.
    """
    if not crowded:
        return bottom + (top - bottom) * share
    wave = math.sin(0.5 * math.pi * (share if own else 1.0 - share))
    away = (top - bottom) * wave * wave * wave
    return bottom + away if own else top - away


@njit(inline="always")
def _opens(dx: float, dy: float, x1: float, y1: float, x2: float, y2: float, clear: float) -> bool:
    """Tell whether a displacement leaves a gap where the gear's normal lies between two directions, less than pi apart.

    They are (x1, y1) and, clockwise from it, (x2, y2); ``clear`` is the least gap [m] of the undisplaced gear there.
    """
    size = math.sqrt(dx * dx + dy * dy)
    clear -= _SECOND_ORDER * size
    if size < clear:
        return True
    within = x1 * dy - y1 * dx <= 0.0 and x2 * dy - y2 * dx >= 0.0
    return not within and max(dx * x1 + dy * y1, dx * x2 + dy * y2) < clear


@njit(inline="always")
def _write_arc(out: int, has_arc: bool, arc: Line, lobe: Pose, z: float, reach: float, sign: float) -> int:
    """Write the contact on the arc of a lobe, if there is one: round the lobe's own place."""
    if not has_arc:
        return 0
    depth = reach + 0.5 * arc.gap
    nx, ny = outwards(lobe, arc.nx, arc.ny)
    write_contact(out, _pressed(arc.gap, arc.factor), lobe.x - depth * nx, lobe.y - depth * ny, z, sign * nx, sign * ny)
    return 1


@njit
def lobe_on_teeth(
    at: Places, model: int, data: int, out: int, teeth: int, geom: int, sign: float, margin: float
) -> int:
    """Bring a lobe of the internal gear, with half a root on either side, and the gear's teeth in contact."""
    profile = _teeth(model, at, teeth)
    flank, ring, offset = profile.flank, profile.ring, profile.flank.offset
    arc_radius = _radius(model, at, geom)
    lobe, gear, z = _pose(data, at, geom), _pose(data, at, teeth), _place(data, at, teeth)[2]
    # The gear in the lobe's frame: axis of the ring at the origin, lobe on +y.
    gx, gy = inwards(lobe, gear.x - lobe.x, gear.y - lobe.y)
    cosine, sine = inwards(lobe, gear.cosine, gear.sine)
    gear = Pose(gx, gy + ring.radius, cosine, sine)

    x, y = inwards(gear, -gear.x, ring.radius - gear.y)
    sn, cn = turned_times(sine, cosine, int(ring.teeth))
    distance, nx, ny, bend = pin_distance(x, y, flank, Start(sine, cosine, sn, cn), margin + arc_radius - offset)
    arc_x, arc_y = outwards(gear, nx, ny)
    arc = Line(distance + offset - arc_radius, 1.0, arc_x, arc_y)
    share = ring.eccentricity * ring.teeth / ring.radius
    # Beyond the fan of its normals the arc ends: the gap goes on falling along the flank of the root.
    has_arc = arc.gap < margin and abs(arc.nx) <= share
    arc_factor = 1.0
    if has_arc:
        arc_factor = _stiffness_factor(profile, bend / (1.0 - offset * bend) + 1.0 / arc_radius)

    count = 0
    modified = flank.curve.radius != ring.radius or flank.rotation != 0.0 or len(flank.waves) > 0
    monotone = is_monotone(ring)
    aside = math.sqrt(1.0 - share * share)
    # Of a conjugate gear, only roots near the eccentric direction are in touch: |crank| < acos(share) and a bit.
    far = gear.y < (share - _BEYOND * aside) * math.sqrt(gear.x * gear.x + gear.y * gear.y)
    if far and monotone and not modified:
        return _write_arc(out, has_arc, Line(arc.gap, arc_factor, arc.nx, arc.ny), lobe, z, arc_radius, sign)
    crowded = modified and monotone
    pieces = 1 if monotone and not modified else (_MODIFIED_SCAN if monotone else _SCAN)
    # The crank is N - 1 times as far round as the gear. Most roots are open, and need not know its angle.
    crank_x, crank_y = sn * cosine - cn * sine, cn * cosine + sn * sine
    shift_x, shift_y = gear.x - ring.eccentricity * crank_x, gear.y - ring.eccentricity * crank_y
    half_pitch = math.pi / ring.teeth
    half_x, half_y = math.sin(half_pitch), math.cos(half_pitch)
    for side in range(2):
        # The root on the clockwise side is that of the next lobe: one pitch further clockwise.
        own = side == 0
        pitch = 0.0 if own else 2.0 * half_pitch
        x1, y1, x2, y2 = (-half_x, half_y, share, aside) if own else (-share, aside, half_x, half_y)
        if not modified and _opens(shift_x, shift_y, x1, y1, x2, y2, offset - arc_radius - margin):
            continue
        turn = (ring.teeth - 1.0) * math.atan2(sine, cosine)
        crank = turn - 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
        low = math.acos(share)
        high = 2.0 * math.pi - low
        start = root_start(crank - pitch, low, ring, modified) if monotone else math.pi
        if start == 0.0:
            continue
        next_lobe = Pose(0.0, 0.0, math.cos(pitch), -math.sin(pitch))
        rx, ry = inwards(next_lobe, gear.x, gear.y)
        rc, rs = inwards(next_lobe, cosine, sine)
        posed = Pose(rx, ry, rc, rs)
        bottom, top = (low, math.pi) if own else (math.pi, high)
        slope = -1.0
        if pieces > 1:
            slope = root_slope(bottom, ring, flank, posed)
        for piece in range(pieces):
            left = _edge(bottom, top, piece / pieces, own, crowded)
            right = _edge(bottom, top, (piece + 1) / pieces, own, crowded)
            if pieces > 1:
                falling = slope < 0.0
                slope = root_slope(right, ring, flank, posed)
                if not falling or slope < 0.0:
                    continue
            least = root_minimum(left, right, start if pieces == 1 else 0.5 * (left + right), ring, flank, posed)
            gap = least.distance + offset - arc_radius
            if not (least.found and gap < margin):
                continue
            x, y, _, _, curvature = offset_root(least.B, ring)
            bend = trochoid_curvature(least.t, flank.curve)
            relative = bend / (1.0 - offset * bend) - curvature / (1.0 - arc_radius * curvature)
            factor = _stiffness_factor(profile, relative)
            if has_arc and profile.deflection > 0.0:
                # Lines with less than a deflection of gap between them are one patch, shared half and half.
                mx, my, _, _, _ = offset_root(0.5 * (least.B + (low if own else high)), ring)
                ex, ey = inwards(posed, mx - posed.x, my - posed.y)
                rise = flank_distance(ex, ey, flank)[1] + offset - arc_radius - max(gap, arc.gap)
                apart = min(1.0, max(0.0, rise / profile.deflection))
                factor = (0.5 + 0.5 * apart) * (arc_factor + apart * (factor - arc_factor))
                arc_factor *= 0.5 + 0.5 * apart
            depth = arc_radius + 0.5 * gap
            # Back from the root's frame to the lobe's, and to the world.
            fx, fy = outwards(next_lobe, x - depth * least.nx, y - depth * least.ny)
            vx, vy = outwards(next_lobe, least.nx, least.ny)
            px, py = placed(lobe, fx, fy - ring.radius)
            qx, qy = outwards(lobe, vx, vy)
            place = out + CONTACT * count
            write_contact(place, _pressed(gap, factor), px, py, z, sign * qx, sign * qy)
            count += 1
    place = out + CONTACT * count
    return count + _write_arc(place, has_arc, Line(arc.gap, arc_factor, arc.nx, arc.ny), lobe, z, arc_radius, sign)


@njit
def inner_in_outer(
    at: Places, model: int, data: int, out: int, inner: int, outer: int, sign: float, margin: float
) -> int:
    """Bring a circle and the circle around it in contact, which may be open: the circle meets its edges there."""
    inner_radius, outer_radius = _radius(model, at, inner), _radius(model, at, outer)
    # a pin through all discs meets the hole of one where that disc is
    (x, y, _), (outer_x, outer_y, z) = _place(data, at, inner), _place(data, at, outer)
    dx, dy = x - outer_x, y - outer_y
    # Most circles are apart: their gap need not be known for that.
    play = outer_radius - inner_radius - margin
    if play > 0.0 and dx * dx + dy * dy <= play * play:
        return 0
    own = _user(model, at, outer)
    half_sine = read_float(own + 8)
    if half_sine == 0.0:
        gap, nx, ny = circle_in_circle(dx, dy, inner_radius, outer_radius)
        return _write_inner(out, gap, Pose(x, y, nx, ny), z, inner_radius, sign, margin)
    seat = _pose(data, at, outer)
    arc = Arc(outer_radius, -seat.sine, seat.cosine, read_float(own), half_sine)
    side, on_arc, other = places_in_arc(dx, dy, arc)
    if on_arc:
        gap, nx, ny = circle_in_circle(dx, dy, inner_radius, outer_radius)
    else:
        gap, nx, ny = circle_at_edge(dx, dy, inner_radius, arc, side)
    count = _write_inner(out, gap, Pose(x, y, nx, ny), z, inner_radius, sign, margin)
    if other:
        gap, nx, ny = circle_at_edge(dx, dy, inner_radius, arc, -side)
        count += _write_inner(out + CONTACT * count, gap, Pose(x, y, nx, ny), z, inner_radius, sign, margin)
    return count


@njit(inline="always")
def _write_inner(out: int, gap: float, at: Pose, z: float, radius: float, sign: float, margin: float) -> int:
    """Write the contact of a circle with what is around it, if there is one; `at` is its centre, and the normal."""
    if not gap < margin:
        return 0
    depth, nx, ny = radius + 0.5 * gap, at.cosine, at.sine
    write_contact(out, gap, at.x + depth * nx, at.y + depth * ny, z, sign * nx, sign * ny)
    return 1
