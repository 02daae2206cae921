"""Contacts of two mating geoms of ours, written as MuJoCo's narrow phase wants them.

Each function takes the places of MuJoCo's arrays, the addresses of ``mjModel``, ``mjData`` and of the contacts to fill
(``mjPreContact``), two geoms, the sign of the normal (it leads from the first geom of MuJoCo's pair to the second) and
the margin [m]; it gives the number of contacts.
"""

import math

from numba import njit

from cycloid_mj.contact.gap import circle_in_circle, flank_distance, trochoid_curvature
from cycloid_mj.contact.memory import read_address, read_float, write_float
from cycloid_mj.contact.near import pin_distance, turned_times
from cycloid_mj.contact.ring import is_monotone, offset_root, root_minimum, root_slope, root_start
from cycloid_mj.contact.teeth import USER_DATA, flank_of, read_teeth

CONTACT = 80
"""Bytes of an ``mjPreContact``."""

SIZE, PRIORITY, USER, XPOS, XMAT = range(5)
"""What the places are of."""

Places = tuple[int, int, int, int, int, int]

_SCAN = 64
"""Pieces of a root that are searched apart, where the gap may have several minima in it."""

_MODIFIED_SCAN = 20
"""The same for a gear that is not conjugate to the ring: the minima crowd beside junction and middle, as the pieces."""

_BEYOND = 0.05
"""Angle [rad] that a root may lie from the eccentric direction beyond its ideal range and still be touched."""

_SECOND_ORDER = 0.02
"""Bound on what a displacement adds to a gap beyond its normal part, as a share of it."""


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
def pin_on_teeth(at: Places, model: int, data: int, out: int, teeth: int, pin: int, sign: float, margin: float) -> int:
    """Bring a pin and the gear's teeth in contact; a massless pin with its play and the compliance of its seat.

    A massless pin is a two-force body: it gives way by its play, then both of its contacts carry the same force, and
    their compliances add up. With the stiffness K f of a pin on the gear, f = 1 on a flat, and K/x of the seat, the
    pair's stiffness K/(1 + x) acts f (1 + x)/(1 + x f) times as much.
    """
    users = read_address(model + at[USER])
    profile = read_teeth(users + 8 * USER_DATA * teeth)
    offset = profile.offset
    pin_radius = read_float(read_address(model + at[SIZE]) + 24 * pin)
    own = users + 8 * USER_DATA * pin
    reach, yielding = pin_radius - read_float(own + 16), read_float(own + 24)
    xpos, xmat = read_address(data + at[XPOS]), read_address(data + at[XMAT]) + 72 * teeth
    px, py = read_float(xpos + 24 * pin), read_float(xpos + 24 * pin + 8)
    dx, dy = px - read_float(xpos + 24 * teeth), py - read_float(xpos + 24 * teeth + 8)
    cosine, sine = read_float(xmat), read_float(xmat + 24)
    x, y = cosine * dx + sine * dy, cosine * dy - sine * dx
    hs, hc = read_float(own), read_float(own + 8)
    st, ct = hs * cosine + hc * sine, hc * cosine - hs * sine
    sn, cn = turned_times(sine, cosine, int(profile.teeth))
    distance, nx, ny, bend = pin_distance(x, y, flank_of(profile), st, ct, sn, cn, margin + reach - offset)
    gap = distance + offset - reach
    if not gap < margin:
        return 0
    relative = bend / (1.0 - offset * bend) + 1.0 / pin_radius
    factor = _stiffness_factor(relative, profile.reference, profile.constant)
    factor *= (1.0 + yielding) / (1.0 + yielding * factor)
    wx, wy = cosine * nx - sine * ny, sine * nx + cosine * ny
    depth = reach + 0.5 * gap
    z = read_float(xpos + 24 * teeth + 16)
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
def _opens(dx: float, dy: float, first: float, last: float, clear: float) -> bool:
    """Tell whether a displacement leaves a gap where the gear's normal lies between two angles, ``last - first`` < pi.

    ``clear`` is the gap [m] of the undisplaced gear there, at least.
    """
    size = math.sqrt(dx * dx + dy * dy)
    clear -= _SECOND_ORDER * size
    if size < clear:
        return True
    x1, y1, x2, y2 = math.sin(first), math.cos(first), math.sin(last), math.cos(last)
    within = x1 * dy - y1 * dx <= 0.0 and x2 * dy - y2 * dx >= 0.0
    return not within and max(dx * x1 + dy * y1, dx * x2 + dy * y2) < clear


@njit(inline="always")
def write_arc(
    out: int,
    has_arc: bool,
    gap: float,
    factor: float,
    nx: float,
    ny: float,
    ring_radius: float,
    px: float,
    py: float,
    z: float,
    lc: float,
    ls: float,
    sign: float,
) -> int:
    """Write the contact on the arc of a lobe, if there is one; the normal is given in the lobe's frame."""
    if not has_arc:
        return 0
    depth = ring_radius + 0.5 * gap
    vx, vy = lc * nx - ls * ny, lc * ny + ls * nx
    write_contact(out, _pressed(gap, factor), px - depth * vx, py - depth * vy, z, sign * vx, sign * vy)
    return 1


@njit
def lobe_on_teeth(
    at: Places, model: int, data: int, out: int, teeth: int, lobe: int, sign: float, margin: float
) -> int:
    """Bring a lobe of the internal gear, with half a root on either side, and the gear's teeth in contact."""
    profile = read_teeth(read_address(model + at[USER]) + 8 * USER_DATA * teeth)
    flank = flank_of(profile)
    radius, eccentricity, number = profile.ring_radius, profile.eccentricity, profile.teeth
    offset, reference, constant = profile.offset, profile.reference, profile.constant
    ring_radius = read_float(read_address(model + at[SIZE]) + 24 * lobe)
    xpos, xmat = read_address(data + at[XPOS]), read_address(data + at[XMAT])
    px, py = read_float(xpos + 24 * lobe), read_float(xpos + 24 * lobe + 8)
    z = read_float(xpos + 24 * teeth + 16)
    # The gear in the lobe's frame: axis of the ring at the origin, lobe on +y.
    lc, ls = read_float(xmat + 72 * lobe), read_float(xmat + 72 * lobe + 24)
    gc, gs = read_float(xmat + 72 * teeth), read_float(xmat + 72 * teeth + 24)
    dx, dy = read_float(xpos + 24 * teeth) - px, read_float(xpos + 24 * teeth + 8) - py
    gx, gy = lc * dx + ls * dy, lc * dy - ls * dx + radius
    cosine, sine = lc * gc + ls * gs, lc * gs - ls * gc

    ax, ay = -gx, radius - gy
    sn, cn = turned_times(sine, cosine, int(number))
    most = margin + ring_radius - offset
    distance, nx, ny, bend = pin_distance(
        cosine * ax + sine * ay, cosine * ay - sine * ax, flank, sine, cosine, sn, cn, most
    )
    arc_gap = distance + offset - ring_radius
    arc_x, arc_y = cosine * nx - sine * ny, sine * nx + cosine * ny
    share = eccentricity * number / radius
    # Beyond the fan of its normals the arc ends: the gap goes on falling along the flank of the root.
    has_arc = arc_gap < margin and abs(arc_x) <= share
    arc_factor = 1.0
    if has_arc:
        arc_factor = _stiffness_factor(bend / (1.0 - offset * bend) + 1.0 / ring_radius, reference, constant)

    count = 0
    modified = profile.radius != radius or profile.rotation != 0.0
    monotone = is_monotone(radius, eccentricity, number)
    aside = math.sqrt(1.0 - share * share)
    # Of a conjugate gear, only roots near the eccentric direction are in touch: |crank| < acos(share) and a bit.
    far = gy < (share - _BEYOND * aside) * math.sqrt(gx * gx + gy * gy)
    if far and monotone and not modified:
        return write_arc(out, has_arc, arc_gap, arc_factor, arc_x, arc_y, ring_radius, px, py, z, lc, ls, sign)
    turn = (number - 1.0) * math.atan2(sine, cosine)
    crank = turn - 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
    crowded = modified and monotone
    pieces = 1 if monotone and not modified else (_MODIFIED_SCAN if monotone else _SCAN)
    shift_x, shift_y = gx - eccentricity * math.sin(crank), gy - eccentricity * math.cos(crank)
    half_pitch, fan = math.pi / number, math.asin(share)
    low = math.acos(share)
    high = 2.0 * math.pi - low
    for side in range(2):
        # The root on the clockwise side is that of the next lobe: one pitch further clockwise.
        own = side == 0
        pitch = 0.0 if own else 2.0 * half_pitch
        edges = (-half_pitch, fan) if own else (-fan, half_pitch)
        if not modified and _opens(shift_x, shift_y, edges[0], edges[1], offset - ring_radius - margin):
            continue
        start = root_start(crank - pitch, radius, eccentricity, number, modified) if monotone else math.pi
        if start == 0.0:
            continue
        pc, ps = math.cos(pitch), -math.sin(pitch)
        rx, ry = pc * gx + ps * gy, pc * gy - ps * gx
        rc, rs = pc * cosine + ps * sine, pc * sine - ps * cosine
        bottom, top = (low, math.pi) if own else (math.pi, high)
        slope = -1.0
        if pieces > 1:
            slope = root_slope(bottom, radius, eccentricity, number, flank, rc, rs, rx, ry)
        for piece in range(pieces):
            left = _edge(bottom, top, piece / pieces, own, crowded)
            right = _edge(bottom, top, (piece + 1) / pieces, own, crowded)
            if pieces > 1:
                falling = slope < 0.0
                slope = root_slope(right, radius, eccentricity, number, flank, rc, rs, rx, ry)
                if not falling or slope < 0.0:
                    continue
            found, phase, distance, t, wx, wy = root_minimum(
                left,
                right,
                start if pieces == 1 else 0.5 * (left + right),
                radius,
                eccentricity,
                number,
                flank,
                rc,
                rs,
                rx,
                ry,
            )
            gap = distance + offset - ring_radius
            if not (found and gap < margin):
                continue
            x, y, _, _, curvature = offset_root(phase, radius, eccentricity, number)
            bend = trochoid_curvature(t, profile.radius, eccentricity, number)
            relative = bend / (1.0 - offset * bend) - curvature / (1.0 - ring_radius * curvature)
            factor = _stiffness_factor(relative, reference, constant)
            if has_arc and profile.deflection > 0.0:
                # Lines with less than a deflection of gap between them are one patch, shared half and half.
                between = 0.5 * (phase + (low if own else high))
                mx, my, _, _, _ = offset_root(between, radius, eccentricity, number)
                ex, ey = mx - rx, my - ry
                _, middle, _, _, _ = flank_distance(rc * ex + rs * ey, rc * ey - rs * ex, flank)
                rise = middle + offset - ring_radius - max(gap, arc_gap)
                apart = min(1.0, max(0.0, rise / profile.deflection))
                factor = (0.5 + 0.5 * apart) * (arc_factor + apart * (factor - arc_factor))
                arc_factor *= 0.5 + 0.5 * apart
            depth = ring_radius + 0.5 * gap
            qx, qy = x - depth * wx, y - depth * wy
            # Back from the root's frame to the lobe's, and to the world.
            fx, fy = pc * qx - ps * qy, pc * qy + ps * qx - radius
            vx, vy = pc * wx - ps * wy, pc * wy + ps * wx
            write_contact(
                out + CONTACT * count,
                _pressed(gap, factor),
                px + lc * fx - ls * fy,
                py + lc * fy + ls * fx,
                z,
                sign * (lc * vx - ls * vy),
                sign * (lc * vy + ls * vx),
            )
            count += 1
    place = out + CONTACT * count
    arcs = write_arc(place, has_arc, arc_gap, arc_factor, arc_x, arc_y, ring_radius, px, py, z, lc, ls, sign)
    return count + arcs


@njit
def inner_in_outer(
    at: Places, model: int, data: int, out: int, inner: int, outer: int, sign: float, margin: float
) -> int:
    """Bring a circle and the circle around it in contact."""
    size, xpos = read_address(model + at[SIZE]), read_address(data + at[XPOS])
    inner_radius, outer_radius = read_float(size + 24 * inner), read_float(size + 24 * outer)
    x, y = read_float(xpos + 24 * inner), read_float(xpos + 24 * inner + 8)
    dx, dy = x - read_float(xpos + 24 * outer), y - read_float(xpos + 24 * outer + 8)
    # Most circles are apart: their gap need not be known for that.
    play = outer_radius - inner_radius - margin
    if play > 0.0 and dx * dx + dy * dy <= play * play:
        return 0
    gap, nx, ny = circle_in_circle(dx, dy, inner_radius, outer_radius)
    if not gap < margin:
        return 0
    depth = inner_radius + 0.5 * gap
    z = read_float(xpos + 24 * inner + 16)
    write_contact(out, gap, x + depth * nx, y + depth * ny, z, sign * nx, sign * ny)
    return 1
