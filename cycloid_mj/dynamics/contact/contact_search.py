"""Contact search between two surfaces in the plane: gap, stiffness factor, position and normal of every contact line.

The collider writes the results for MuJoCo (`mating`), the planar solver uses them directly. Contacts are written in
sequence, ``STRIDE`` bytes apart, in the format of `read_touch`. The unit normal points from the first surface to
the second: outwards from the teeth, from the inner circle to the outer one.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cycloid_mj.base import compiling
from cycloid_mj.dynamics.contact.gap import (
    PartialCircle,
    Pose,
    circle_at_edge,
    circle_in_circle,
    flank_distance,
    inwards,
    nearest_on_arc,
    outwards,
    to_frame,
    trochoid_curvature,
)
from cycloid_mj.dynamics.contact.local_gap import Start, multiple_angle, pin_distance
from cycloid_mj.dynamics.contact.memory import read_float, write_float
from cycloid_mj.dynamics.contact.ring import (
    Minimum,
    is_monotone,
    offset_root,
    root_minimum,
    root_slope,
    root_start_phase,
)
from cycloid_mj.dynamics.contact.teeth import Teeth

PRE_CONTACT = np.dtype([("dist", float), ("pos", float, 3), ("normal", float, 3), ("tangent", float, 3)])
"""An ``mjPreContact``, of which a `Touch` takes the first six numbers."""

STRIDE = PRE_CONTACT.itemsize
"""Bytes from one touch to the next."""


class RootSearchSettings(NamedTuple):
    """Settings of the search for the contacts of a disc with a root of the internal gear (`lobe_touches`)."""

    pieces: int = 64
    """Pieces of a half root that are searched separately, where the gap may have several minima in it."""
    modified_pieces: int = 20
    """The same for a disc that is not conjugate to the ring; its minima, like the pieces, crowd near the ends."""
    angle_margin: float = 0.05
    """Angle [rad] beyond the ideal range of the eccentric direction in which a root may still be touched."""
    second_order_share: float = 0.02
    """Bound on the second-order part of a gap by a displacement, as a share of the displacement."""

    @property
    def max_touches(self) -> int:
        """Largest number of contacts of a lobe: one for each piece of both half roots, and those of the arc."""
        return 2 * self.pieces + 2


SETTINGS = RootSearchSettings()


class Touch(NamedTuple):
    """Contact of two surfaces.

    Attributes
    ----------
    gap
        Their distance [m], negative where they overlap.
    x, y
        Position half-way between the surfaces [m].
    factor
        Stiffness relative to that of the pair [1].
    nx, ny
        Unit normal.
    """

    gap: float
    x: float
    y: float
    factor: float
    nx: float
    ny: float


class RingPin(NamedTuple):
    """A ring pin that mates with teeth.

    Attributes
    ----------
    radius
        Radius of the pin [m].
    sine, cosine
        Direction of its home position, clockwise from +y; both 0 for a pin on a ring that rotates about the origin.
    play, yielding, min_cosine
        Parameters of a massless pin, otherwise 0: its clearance [m]; the stiffness of a pin on a flat over that of its
        seat; and one more than the smallest cosine of the angle to its home direction at which the seat supports it.
    """

    radius: float
    sine: float
    cosine: float
    play: float
    yielding: float
    min_cosine: float


class PinTouch(NamedTuple):
    """Contact of a pin and teeth, if it `exists`; `curvature` [1/m] is that of the trochoid at the foot point."""

    exists: bool
    touch: Touch
    curvature: float


class ArcTouch(NamedTuple):
    """Contact of teeth and the arc of a lobe, if it `exists`: gap [m], stiffness factor, normal in the lobe's frame."""

    exists: bool
    gap: float
    factor: float
    nx: float
    ny: float


class HalfRoot(NamedTuple):
    """Half of a root of the internal gear next to a lobe.

    Attributes
    ----------
    own
        Whether it is on the counter-clockwise side of the lobe; the other half belongs to the next lobe.
    min_phase
        Phase at which the root begins, B0 [rad].
    start
        Phase to start the search from [rad].
    frame
        Frame of the lobe that the root belongs to, in the frame of this lobe.
    modified, monotone
        Whether the disc is not conjugate to the ring, and ``ring.is_monotone``.
    """

    own: bool
    min_phase: float
    start: float
    frame: Pose
    modified: bool
    monotone: bool


@njit(inline="always")
def write_touch(address: int, gap: float, x: float, y: float, factor: float, nx: float, ny: float) -> None:
    """Write a contact point as six doubles at a memory address: gap, position, stiffness factor and unit normal.

    The gap and the position (x, y) are in [m]; `factor` [1] multiplies the stiffness of the contact; the normal is (nx,
    ny). `read_touch` returns them as a `Touch`.
    """
    write_float(address, gap)
    write_float(address + 8, x)
    write_float(address + 16, y)
    write_float(address + 24, factor)
    write_float(address + 32, nx)
    write_float(address + 40, ny)


@njit(inline="always")
def read_touch(address: int) -> Touch:
    """Read a contact point, six doubles, at a memory address: gap, position, stiffness factor and unit normal."""
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
    """Compute the stiffness of a contact of the teeth over the nominal stiffness of such contacts [1], 2 at most.

    It is ``reference / (constant + ln curvature)`` with the parameters of `teeth`. `curvature` [1/m] is the relative
    curvature of both surfaces at the contact: a flatter contact is wider and stiffer. The result is 1 if
    `teeth.reference` is 0, which selects the nominal stiffness everywhere.
    """
    if teeth.reference == 0.0:
        return 1.0
    min_curvature = math.exp(0.5 * teeth.reference - teeth.constant)
    return teeth.reference / (teeth.constant + math.log(max(curvature, min_curvature)))


@njit(inline="always")
def pin_touch(profile: Teeth, pin: RingPin, gear: Pose, px: float, py: float, margin: float) -> PinTouch:
    """Compute the contact of the teeth and a ring pin, including clearance and seat of a massless pin.

    A massless pin is a two-force body: it moves by its clearance, then its contacts with teeth and seat act as springs
    in series. The contact with the teeth has the stiffness K f, with the factor f of their curvature, the seat has K/x,
    with x = `pin.yielding`. The factor on the stiffness K/(1 + x) of the pair is therefore f (1 + x)/(1 + x f).

    Parameters
    ----------
    profile
        Teeth of the gear.
    pin
        The pin. Its home direction is that of its centre in the middle of its seat, from the axis of the ring; if
        `sine` and `cosine` are 0, it is the direction of (px, py).
    gear
        Pose of the gear in the world.
    px, py
        Centre of the pin in the world [m].
    margin
        Largest gap of a contact [m].

    Returns
    -------
    PinTouch
        Contact in the world's frame. `exists` is False if the gap is `margin` or more, or if a massless pin is pressed
        towards the opening of its socket.
    """
    offset = profile.flank.offset
    effective_radius, compliance_ratio = pin.radius - pin.play, pin.yielding
    x, y = inwards(gear, px - gear.x, py - gear.y)
    home_sine, home_cosine = pin.sine, pin.cosine
    ring_rotates = home_sine == 0.0 and home_cosine == 0.0
    if ring_rotates:
        inverse_radius = 1.0 / math.sqrt(px * px + py * py)
        home_sine, home_cosine = px * inverse_radius, py * inverse_radius
    sin_t, cos_t = home_sine * gear.cosine + home_cosine * gear.sine, home_cosine * gear.cosine - home_sine * gear.sine
    ring_teeth = int(profile.ring.teeth)
    sin_nt, cos_nt = (
        multiple_angle(sin_t, cos_t, ring_teeth) if ring_rotates else multiple_angle(gear.sine, gear.cosine, ring_teeth)
    )
    start = Start(sin_t, cos_t, sin_nt, cos_nt)
    distance, gear_nx, gear_ny, curvature = pin_distance(x, y, profile.flank, start, margin + effective_radius - offset)
    gap = distance + offset - effective_radius
    no_touch = PinTouch(False, Touch(gap, 0.0, 0.0, 1.0, 0.0, 0.0), 0.0)
    if not gap < margin:
        return no_touch
    normal_x, normal_y = outwards(gear, gear_nx, gear_ny)
    if 1.0 + normal_x * home_sine + normal_y * home_cosine < pin.min_cosine:
        return no_touch  # pressed out of its seat's opening
    factor = _stiffness_factor(profile, curvature / (1.0 - offset * curvature) + 1.0 / pin.radius)
    factor *= (1.0 + compliance_ratio) / (1.0 + compliance_ratio * factor)
    contact_radius = effective_radius + 0.5 * gap
    return PinTouch(
        True,
        Touch(gap, px - contact_radius * normal_x, py - contact_radius * normal_y, factor, normal_x, normal_y),
        curvature,
    )


@njit(inline="always")
def _interval_edge_phase(half_start: float, half_end: float, fraction: float, is_own: bool, is_graded: bool) -> float:
    """Compute the phase B [rad] at which a search interval in half a root of the internal gear ends.

    B is the position along a root (`offset_root`), which connects the arcs of two lobes. The half root extends from the
    phase `half_start` to `half_end` [rad] and is searched in intervals. `fraction` [1] is the number of intervals from
    `half_start` to the phase of the result, divided by the number of all intervals. They are equally long unless
    `is_graded`. Graded intervals become shorter towards both ends, most of all towards the junction with the arc of the
    lobe. The junction is at `half_start` if `is_own` (`HalfRoot.own`), else at `half_end`; the other end is the middle
    of the root.
    """
    if not is_graded:
        return half_start + (half_end - half_start) * fraction
    sine = math.sin(0.5 * math.pi * (fraction if is_own else 1.0 - fraction))
    distance = (half_end - half_start) * sine * sine * sine
    return half_start + distance if is_own else half_end - distance


@njit(inline="always")
def _stays_open(dx: float, dy: float, x1: float, y1: float, x2: float, y2: float, clearance: float) -> bool:
    """Return whether a displaced disc is certainly too far from a root for a contact, by a simple bound.

    The disc's outward normals there lie in the sector from the unit vector (x1, y1) clockwise to (x2, y2). `clearance`
    is the smallest gap without displacement minus the largest gap of a contact [m], (dx, dy) the displacement of the
    disc [m]. False means that the bound does not decide.
    """
    shift = math.sqrt(dx * dx + dy * dy)
    clearance -= SETTINGS.second_order_share * shift
    if shift < clearance:
        return True
    is_between = x1 * dy - y1 * dx <= 0.0 and x2 * dy - y2 * dx >= 0.0
    return not is_between and max(dx * x1 + dy * y1, dx * x2 + dy * y2) < clearance


@njit(inline="always")
def _arc_touch(profile: Teeth, arc_radius: float, gear: Pose, sin_nt: float, cos_nt: float, margin: float) -> ArcTouch:
    """Compute the contact of the teeth of the disc with the circular arc of a lobe of the internal gear.

    The frame has its origin on the axis of the internal gear, and the lobe on +y.

    Parameters
    ----------
    profile
        Teeth of the disc.
    arc_radius
        Radius of the lobe's arc [m].
    gear
        Pose of the disc in this frame.
    sin_nt, cos_nt
        Sine and cosine of N times the rotation of the disc, for N teeth of the internal gear.
    margin
        Largest gap of a contact [m].

    Returns
    -------
    ArcTouch
        Gap, stiffness factor and normal of the disc. `exists` is False if the gap is `margin` or more, or if the normal
        points beyond an end of the arc, where the adjacent root is closer; the other fields are then not valid.
    """
    ring, offset = profile.ring, profile.flank.offset
    x, y = inwards(gear, -gear.x, ring.radius - gear.y)
    start = Start(gear.sine, gear.cosine, sin_nt, cos_nt)
    distance, gear_nx, gear_ny, curvature = pin_distance(x, y, profile.flank, start, margin + arc_radius - offset)
    gap, (normal_x, normal_y) = distance + offset - arc_radius, outwards(gear, gear_nx, gear_ny)
    exists = gap < margin and abs(normal_x) <= ring.eccentricity * ring.teeth / ring.radius
    factor = _stiffness_factor(profile, curvature / (1.0 - offset * curvature) + 1.0 / arc_radius) if exists else 1.0
    return ArcTouch(exists, gap, factor, normal_x, normal_y)


@njit(inline="always")
def _write_arc_contact(address: int, arc: ArcTouch, lobe: Pose, arc_radius: float) -> int:
    """Write the contact on the arc of a lobe at a memory address, in the world's frame; return the number, 0 or 1.

    `arc` is this contact in the frame of the lobe; nothing is written if it does not exist. `lobe` is the pose of the
    lobe in the world, `arc_radius` the radius of its arc [m].
    """
    if not arc.exists:
        return 0
    contact_radius = arc_radius + 0.5 * arc.gap
    nx, ny = outwards(lobe, arc.nx, arc.ny)
    write_touch(address, arc.gap, lobe.x - contact_radius * nx, lobe.y - contact_radius * ny, arc.factor, nx, ny)
    return 1


@njit(inline="always")
def _root_stiffness_factor(profile: Teeth, arc_radius: float, minimum: Minimum) -> float:
    """Compute the `_stiffness_factor` of a contact in a root [1] from the curvatures of flank and root there.

    The contact is at the `minimum` of the gap. `profile` are the teeth of the disc, `arc_radius` is the radius of the
    lobes' arcs [m].
    """
    offset = profile.flank.offset
    disc_curvature = trochoid_curvature(minimum.t, profile.flank.curve)
    root_curvature = offset_root(minimum.B, profile.ring)[4]
    return _stiffness_factor(
        profile, disc_curvature / (1.0 - offset * disc_curvature) - root_curvature / (1.0 - arc_radius * root_curvature)
    )


@njit(inline="always")
def _contact_separation(profile: Teeth, arc_radius: float, gear: Pose, phase: float, larger_gap: float) -> float:
    """Compute how far the contacts on arc and root of a lobe are apart, from 0 (one patch) to 1 (two patches) [1].

    It is the gap midway between both contacts minus `larger_gap` [m], the larger gap of the two, divided by the
    deflection of the teeth under working force (``profile.deflection``), and clipped to this range. `profile` are the
    teeth of the disc, `arc_radius` [m] is the radius of the lobe's arc, `gear` the pose of the teeth in the frame of
    the root's lobe, and `phase` [rad] that of the root midway between both contacts.
    """
    x, y, _, _, _ = offset_root(phase, profile.ring)
    x_in_gear, y_in_gear = inwards(gear, x - gear.x, y - gear.y)
    gap_rise = flank_distance(x_in_gear, y_in_gear, profile.flank)[1] + profile.flank.offset - arc_radius - larger_gap
    return min(1.0, max(0.0, gap_rise / profile.deflection))


@compiling.njit(inner=True)
def lobe_touches(address: int, profile: Teeth, arc_radius: float, lobe: Pose, gear: Pose, margin: float) -> int:
    """Find and write the contacts of the teeth with a lobe of the internal gear and the adjacent halves of two roots.

    Contacts are written at a memory address, in the world's frame, `STRIDE` bytes apart, with gap, position, stiffness
    factor and normal. Their number is returned, at most ``SETTINGS.max_touches``.

    Parameters
    ----------
    address
        Memory address of the first contact.
    profile, arc_radius
        Teeth of the disc, and radius of the lobe's arc [m].
    lobe, gear
        Poses of the lobe and the disc in the world.
    margin
        Largest gap of a contact [m].
    """
    flank, ring, offset = profile.flank, profile.ring, profile.flank.offset
    # The gear in the lobe's frame: axis of the ring at the origin, lobe on +y.
    gear_x, gear_y = inwards(lobe, gear.x - lobe.x, gear.y - lobe.y)
    cosine, sine = inwards(lobe, gear.cosine, gear.sine)
    gear = Pose(gear_x, gear_y + ring.radius, cosine, sine)
    sin_nt, cos_nt = multiple_angle(sine, cosine, int(ring.teeth))
    arc = _arc_touch(profile, arc_radius, gear, sin_nt, cos_nt, margin)

    max_sine = ring.eccentricity * ring.teeth / ring.radius
    is_modified = flank.curve.radius != ring.radius or flank.rotation != 0.0 or len(flank.waves) > 0
    root_is_monotone = is_monotone(ring)
    min_cosine = math.sqrt(1.0 - max_sine * max_sine)
    # Of a conjugate gear, only roots near the eccentric direction are in contact: |crank| < acos(share), plus a margin.
    is_far = gear.y < (max_sine - SETTINGS.angle_margin * min_cosine) * math.sqrt(gear.x * gear.x + gear.y * gear.y)
    if is_far and root_is_monotone and not is_modified:
        return _write_arc_contact(address, arc, lobe, arc_radius)
    # The crank is N - 1 times as far round as the gear. Most roots are open, and do not need its angle.
    crank_x, crank_y = sin_nt * cosine - cos_nt * sine, cos_nt * cosine + sin_nt * sine
    shift_x, shift_y = gear.x - ring.eccentricity * crank_x, gear.y - ring.eccentricity * crank_y
    half_pitch = math.pi / ring.teeth
    half_sine, half_cosine = math.sin(half_pitch), math.cos(half_pitch)
    count = np.int64(0)  # not a literal, for which `_write_root_contacts` would be compiled once more
    for root_side in range(2):
        # The root on the clockwise side is that of the next lobe: one pitch further clockwise.
        is_own = root_side == 0
        pitch = 0.0 if is_own else 2.0 * half_pitch
        x1, y1, x2, y2 = (
            (-half_sine, half_cosine, max_sine, min_cosine)
            if is_own
            else (-max_sine, min_cosine, half_sine, half_cosine)
        )
        if not is_modified and _stays_open(shift_x, shift_y, x1, y1, x2, y2, offset - arc_radius - margin):
            continue
        crank_turn = (ring.teeth - 1.0) * math.atan2(sine, cosine)
        crank = crank_turn - 2.0 * math.pi * math.floor(crank_turn / (2.0 * math.pi) + 0.5)
        min_phase = math.acos(max_sine)
        start_phase = root_start_phase(crank - pitch, min_phase, ring, is_modified) if root_is_monotone else math.pi
        if start_phase == 0.0:
            continue
        root_frame = Pose(0.0, 0.0, math.cos(pitch), -math.sin(pitch))
        root = HalfRoot(is_own, min_phase, start_phase, root_frame, is_modified, root_is_monotone)
        count, arc = _write_root_contacts(address, count, profile, arc_radius, root, arc, lobe, gear, margin)
    return count + _write_arc_contact(address + STRIDE * count, arc, lobe, arc_radius)


@compiling.njit(inner=True)
def _write_root_contacts(
    address: int,
    count: int,
    profile: Teeth,
    arc_radius: float,
    root: HalfRoot,
    arc: ArcTouch,
    lobe: Pose,
    gear: Pose,
    margin: float,
) -> tuple[int, ArcTouch]:
    """Find the contacts of the teeth in half a `root` of the internal gear, and append them to an array of contacts.

    `address` is the memory address of the array, which already has `count` contacts. The half root is divided into
    intervals, each of which is searched for a minimum of the gap; a minimum below `margin` [m] is a contact. If the gap
    between the contacts on arc and root is below the deflection of the teeth, both share one patch: their stiffness is
    reduced. `profile` are the teeth of the disc, `arc` is the contact on the arc of the lobe, whose radius is
    `arc_radius` [m]. `lobe` is the pose of the lobe in the world, `gear` that of the teeth in the frame of the lobe.
    Returns the new number of contacts, and `arc` with its stiffness, which is reduced if it shares a patch.
    """
    flank, ring, root_frame, min_phase = profile.flank, profile.ring, root.frame, root.min_phase
    gear_x, gear_y = inwards(root_frame, gear.x, gear.y)
    gear_cosine, gear_sine = inwards(root_frame, gear.cosine, gear.sine)
    gear_pose = Pose(gear_x, gear_y, gear_cosine, gear_sine)
    half_start, half_end = (min_phase, math.pi) if root.own else (math.pi, 2.0 * math.pi - min_phase)
    interval_count = SETTINGS.modified_pieces if root.monotone else SETTINGS.pieces
    if root.monotone and not root.modified:
        interval_count = 1
    is_graded = root.modified and root.monotone
    slope = root_slope(half_start, ring, flank, gear_pose) if interval_count > 1 else -1.0
    for interval in range(interval_count):
        interval_start = _interval_edge_phase(half_start, half_end, interval / interval_count, root.own, is_graded)
        interval_end = _interval_edge_phase(half_start, half_end, (interval + 1) / interval_count, root.own, is_graded)
        if interval_count > 1:
            was_falling = slope < 0.0
            slope = root_slope(interval_end, ring, flank, gear_pose)
            if not was_falling or slope < 0.0:
                continue
        search_start = root.start if interval_count == 1 else 0.5 * (interval_start + interval_end)
        minimum = root_minimum(interval_start, interval_end, search_start, ring, flank, gear_pose)
        gap = minimum.distance + flank.offset - arc_radius
        if not (minimum.exists and gap < margin):
            continue
        factor, arc_factor = _root_stiffness_factor(profile, arc_radius, minimum), arc.factor
        if arc.exists and profile.deflection > 0.0:
            mid_phase = 0.5 * (minimum.B + (min_phase if root.own else 2.0 * math.pi - min_phase))
            separation = _contact_separation(profile, arc_radius, gear_pose, mid_phase, max(gap, arc.gap))
            factor = (0.5 + 0.5 * separation) * (arc_factor + separation * (factor - arc_factor))
            arc = ArcTouch(arc.exists, arc.gap, arc_factor * (0.5 + 0.5 * separation), arc.nx, arc.ny)
        contact_radius = arc_radius + 0.5 * gap
        x, y, _, _, _ = offset_root(minimum.B, ring)
        # Back from the root's frame to the lobe's, and to the world.
        lobe_x, lobe_y = outwards(root_frame, x - contact_radius * minimum.nx, y - contact_radius * minimum.ny)
        lobe_nx, lobe_ny = outwards(root_frame, minimum.nx, minimum.ny)
        world_x, world_y = to_frame(lobe, lobe_x, lobe_y - ring.radius)
        world_nx, world_ny = outwards(lobe, lobe_nx, lobe_ny)
        write_touch(address + STRIDE * count, gap, world_x, world_y, factor, world_nx, world_ny)
        count += 1
    return count, arc


@compiling.njit(inner=True)
def inner_touches(
    address: int, dx: float, dy: float, x: float, y: float, inner: float, outer: PartialCircle, margin: float
) -> int:
    """Write the contacts of a circle of radius `inner` [m] in another circle at a memory address; return their number.

    The centre of the inner circle is at (x, y) [m], displaced by (dx, dy) [m] from that of the outer circle. `outer` is
    a closed circle if its `sine` is 0. Otherwise it is an arc, whose edges may be in contact, too. There are at most
    two contacts, with gaps below `margin` [m], `STRIDE` bytes apart. Each has gap, position, stiffness factor and
    normal (`read_touch`).
    """
    # Most circles are open, which needs no exact gap.
    clearance = outer.radius - inner - margin
    if clearance > 0.0 and dx * dx + dy * dy <= clearance * clearance:
        return 0
    if outer.sine == 0.0:
        gap, nx, ny = circle_in_circle(dx, dy, inner, outer.radius)
        return _write_inner_contact(address, gap, x, y, nx, ny, inner, margin)
    side, on_arc, both_edges = nearest_on_arc(dx, dy, outer)
    if on_arc:
        gap, nx, ny = circle_in_circle(dx, dy, inner, outer.radius)
    else:
        gap, nx, ny = circle_at_edge(dx, dy, inner, outer, side)
    count = _write_inner_contact(address, gap, x, y, nx, ny, inner, margin)
    if both_edges:
        gap, nx, ny = circle_at_edge(dx, dy, inner, outer, -side)
        count += _write_inner_contact(address + STRIDE * count, gap, x, y, nx, ny, inner, margin)
    return count


@njit(inline="always")
def _write_inner_contact(
    address: int, gap: float, x: float, y: float, nx: float, ny: float, radius: float, margin: float
) -> int:
    """Write a contact of a circle with the circle or arc around it at a memory address; return the number, 0 or 1.

    The circle inside has the centre (x, y) and the `radius` [m]; the unit normal (nx, ny) points outwards. A contact
    with a `gap` of `margin` [m] or more is not written.
    """
    if not gap < margin:
        return 0
    contact_radius = radius + 0.5 * gap
    write_touch(address, gap, x + contact_radius * nx, y + contact_radius * ny, 1.0, nx, ny)
    return 1
