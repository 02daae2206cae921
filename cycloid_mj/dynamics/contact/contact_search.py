"""Contact search between two surfaces in the plane: gap, stiffness factor, position and normal of every contact line.

The collider writes the results for MuJoCo (`mating`), the planar solver uses them directly. Contacts are written one
after the other, ``STRIDE`` bytes apart, in the format of `read_touch`. The unit normal points from the first surface to
the second: outwards from the teeth, from the inner circle to the outer one.
"""

import math
from typing import NamedTuple

from numba import njit

from cycloid_mj.base import compiling
from cycloid_mj.dynamics.contact.gap import (
    PartialCircle,
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
from cycloid_mj.dynamics.contact.local_gap import Start, pin_distance, turned_times
from cycloid_mj.dynamics.contact.memory import read_float, write_float
from cycloid_mj.dynamics.contact.ring import is_monotone, offset_root, root_minimum, root_slope, root_start
from cycloid_mj.dynamics.contact.teeth import Teeth

STRIDE = 80
"""Bytes from one touch to the next: those of an ``mjPreContact``, of which a touch takes the first six numbers."""

_SCAN = 64
"""Pieces of a root that are searched apart, where the gap may have several minima in it."""

_MODIFIED_SCAN = 20
"""The same for a gear that is not conjugate to the ring: the minima crowd beside junction and middle, as the pieces."""

_BEYOND = 0.05
"""Angle [rad] that a root may lie from the eccentric direction beyond its ideal range and still be touched."""

_SECOND_ORDER = 0.02
"""Bound on what a displacement adds to a gap beyond its normal part, as a share of it."""


class Touch(NamedTuple):
    """A touch of two surfaces.

    Attributes
    ----------
    gap
        Their distance [m], negative where they overlap.
    x, y
        Its place [m].
    factor
        On the stiffness of the pair [1].
    nx, ny
        Its normal.
    """

    gap: float
    x: float
    y: float
    factor: float
    nx: float
    ny: float


class RingPin(NamedTuple):
    """A pin as an opponent of teeth.

    Attributes
    ----------
    radius
        Of the pin [m].
    sine, cosine
        Of its home angle, clockwise from +y; both 0 of one that a ring carries round the origin.
    play, yielding, held
        Of a massless one, else 0: by how much it gives way [m]; the stiffness of a pin on a flat over that of its seat;
        and one more than the least cosine of the angle to its home at which its seat holds it.
    """

    radius: float
    sine: float
    cosine: float
    play: float
    yielding: float
    held: float


class PinTouch(NamedTuple):
    """Contact of a pin and teeth, if it `exists`; `curvature` [1/m] is that of the trochoid at the foot point."""

    exists: bool
    touch: Touch
    curvature: float


class Line(NamedTuple):
    """A line of contact: its gap [m], the factor on its stiffness, and the outward normal of the gear."""

    gap: float
    factor: float
    nx: float
    ny: float


@njit(inline="always")
def write_touch(out: int, gap: float, x: float, y: float, factor: float, nx: float, ny: float) -> None:
    """Write a touch at an address."""
    write_float(out, gap)
    write_float(out + 8, x)
    write_float(out + 16, y)
    write_float(out + 24, factor)
    write_float(out + 32, nx)
    write_float(out + 40, ny)


@njit(inline="always")
def read_touch(address: int) -> Touch:
    """Read a touch at an address."""
    return Touch(
        read_float(address),
        read_float(address + 8),
        read_float(address + 16),
        read_float(address + 24),
        read_float(address + 32),
        read_float(address + 40),
    )


@njit(inline="always")
def _stiffness_factor(teeth: Teeth, curvature: float) -> float:
    """Compute the factor on the stiffness at a relative curvature [1/m]; 1 where the law is switched off."""
    if teeth.reference == 0.0:
        return 1.0
    least = math.exp(0.5 * teeth.reference - teeth.constant)
    return teeth.reference / (teeth.constant + math.log(max(curvature, least)))


@njit(inline="always")
def pin_touch(profile: Teeth, pin: RingPin, gear: Pose, px: float, py: float, margin: float) -> PinTouch:
    """Compute the contact of the teeth and a pin at (px, py) [m], including clearance and seat of a massless pin.

    A massless pin is a two-force body: it gives way by its play, then both of its contacts carry the same force, and
    their compliances add up. With the stiffness K f of a pin on the gear, f = 1 on a flat, and K/x of the seat, the
    pair's stiffness K/(1 + x) acts f (1 + x)/(1 + x f) times as much. A pin that has no home is where a ring has
    turned it to, about the world's origin. A massless pin that is pressed towards the opening of its socket carries
    nothing.
    """
    offset = profile.flank.offset
    reach, yielding = pin.radius - pin.play, pin.yielding
    x, y = inwards(gear, px - gear.x, py - gear.y)
    hs, hc = pin.sine, pin.cosine
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
    none = PinTouch(False, Touch(gap, 0.0, 0.0, 1.0, 0.0, 0.0), 0.0)
    if not gap < margin:
        return none
    wx, wy = outwards(gear, nx, ny)
    if 1.0 + wx * hs + wy * hc < pin.held:
        return none  # pressed out of its seat's opening
    factor = _stiffness_factor(profile, bend / (1.0 - offset * bend) + 1.0 / pin.radius)
    factor *= (1.0 + yielding) / (1.0 + yielding * factor)
    depth = reach + 0.5 * gap
    return PinTouch(True, Touch(gap, px - depth * wx, py - depth * wy, factor, wx, wy), bend)


@njit(inline="always")
def _edge(bottom: float, top: float, share: float, own: bool, crowded: bool) -> float:
    """Compute the phase at a share of a half root, of the lobe itself or of the next one.

    Where crowded, the edges are dense at the middle of the root and denser at its junction.
    """
    if not crowded:
        return bottom + (top - bottom) * share
    wave = math.sin(0.5 * math.pi * (share if own else 1.0 - share))
    away = (top - bottom) * wave * wave * wave
    return bottom + away if own else top - away


@njit(inline="always")
def _opens(dx: float, dy: float, x1: float, y1: float, x2: float, y2: float, clear: float) -> bool:
    """Return whether a displacement leaves a gap where the normal lies between two directions, less than pi apart.

    They are (x1, y1) and, clockwise from it, (x2, y2); ``clear`` is the least gap [m] of the undisplaced gear there.
    """
    size = math.sqrt(dx * dx + dy * dy)
    clear -= _SECOND_ORDER * size
    if size < clear:
        return True
    within = x1 * dy - y1 * dx <= 0.0 and x2 * dy - y2 * dx >= 0.0
    return not within and max(dx * x1 + dy * y1, dx * x2 + dy * y2) < clear


@njit(inline="always")
def _write_arc(out: int, has_arc: bool, arc: Line, lobe: Pose, reach: float) -> int:
    """Write the contact on the arc of a lobe, if there is one, at the pose of the lobe."""
    if not has_arc:
        return 0
    depth = reach + 0.5 * arc.gap
    nx, ny = outwards(lobe, arc.nx, arc.ny)
    write_touch(out, arc.gap, lobe.x - depth * nx, lobe.y - depth * ny, arc.factor, nx, ny)
    return 1


@compiling.njit(inner=True)
def lobe_touches(out: int, profile: Teeth, arc_radius: float, lobe: Pose, gear: Pose, margin: float) -> int:
    """Write the contacts of the teeth and a lobe of the internal gear, with half a root on either side."""
    flank, ring, offset = profile.flank, profile.ring, profile.flank.offset
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
        return _write_arc(out, has_arc, Line(arc.gap, arc_factor, arc.nx, arc.ny), lobe, arc_radius)
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
            if not (least.exists and gap < margin):
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
            write_touch(out + STRIDE * count, gap, px, py, factor, qx, qy)
            count += 1
    place = out + STRIDE * count
    return count + _write_arc(place, has_arc, Line(arc.gap, arc_factor, arc.nx, arc.ny), lobe, arc_radius)


@compiling.njit(inner=True)
def inner_touches(
    out: int, dx: float, dy: float, x: float, y: float, inner: float, outer: PartialCircle, margin: float
) -> int:
    """Write the touches of a circle of radius `inner` at (x, y), (dx, dy) from the middle of the circle around it [m].

    That may be open, an arc: there the inner circle meets its edges. Of a whole one the sine is 0.
    """
    # Most circles are apart: their gap need not be known for that.
    play = outer.radius - inner - margin
    if play > 0.0 and dx * dx + dy * dy <= play * play:
        return 0
    if outer.sine == 0.0:
        gap, nx, ny = circle_in_circle(dx, dy, inner, outer.radius)
        return _write_inner(out, gap, x, y, nx, ny, inner, margin)
    side, on_arc, other = places_in_arc(dx, dy, outer)
    if on_arc:
        gap, nx, ny = circle_in_circle(dx, dy, inner, outer.radius)
    else:
        gap, nx, ny = circle_at_edge(dx, dy, inner, outer, side)
    count = _write_inner(out, gap, x, y, nx, ny, inner, margin)
    if other:
        gap, nx, ny = circle_at_edge(dx, dy, inner, outer, -side)
        count += _write_inner(out + STRIDE * count, gap, x, y, nx, ny, inner, margin)
    return count


@njit(inline="always")
def _write_inner(out: int, gap: float, x: float, y: float, nx: float, ny: float, radius: float, margin: float) -> int:
    """Write the contact of a circle at (x, y) with the surrounding circle, if there is one."""
    if not gap < margin:
        return 0
    depth = radius + 0.5 * gap
    write_touch(out, gap, x + depth * nx, y + depth * ny, 1.0, nx, ny)
    return 1
