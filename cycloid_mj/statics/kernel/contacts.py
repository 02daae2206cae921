"""Springs of all contacts at some crank angles, and the gap of each: how wide it is and how it changes.

The curve of a tooth is taken to the third order about its ideal contact; where that may not be relied on, or for every
tooth where a search asks for it, the foot point on the trochoid is found.
"""

import math
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.compiling import cacheable, njit

YES: bool = np.bool_(True)  # type: ignore[assignment]
NO: bool = np.bool_(False)  # type: ignore[assignment]
FIRST: int = np.int64(0)  # type: ignore[assignment]
"""Arguments: for a literal, Python's own, numba would compile what is called once more."""


_VALLEY, _BOTTOM = 1e-3, 0.5
"""Twist of a curve, over the square of its largest curvature, from which it counts as a valley, which is no circle; and
curvature, over the largest, from which it is a valley's bottom, where there is no twist."""


_FAR, _SMALL = 0.7, 4e-4
"""Way along a curve, over its least radius and over E, beyond which its foot point is looked for."""


_FARTHEST_FOOT, _LONGEST = 1.5, 0.5
"""How far from its contact the search for a foot point begins, at most, and its longest step, in the generating
circle's turn N t [rad]: within the half lobe, 1.57, next to which another flank begins, and a third of that."""


_ROUNDS, _LAST, _SETTLED = 60, 1e-7, 1e-12
"""Most steps to a foot point, as halvings of a lobe down to rounding need them; the step of Newton's method that is the
last, as convergence is quadratic, so that the foot is then known to rounding; and the last of the others [rad]."""


_SURELY = 1e-4
"""Most that a gap's third order narrows it, as a share of the way along the curve."""


class KernelSprings(NamedTuple):
    """Springs at k crank angles, n at each, on the unknowns of D discs and an output, u = 3 D + 1.

    For the meaning of most of them see ``gaps.Gaps``; `room` [m] has the play of the pins in it. Shapes: `room` (n,)
    [m]; `distance`, `shift`, `bend`, `twist`, `phase`, `stiffness` (k, n) [m, m, 1/m, 1/m2, rad, N/m]; `slope`,
    `shift_slope` (k, n, u) [1].

    `radius` [m] is that of the circle of output pins: an unknown of turning is the angle times that. `trochoid`, on
    which ideal pins have their centres, is E u(t) - c u(N t): E and c [m], and N. `disc` (n,) is that of a contact, and
    `turning` (n,) tells whether its curve turns with the disc: the teeth do, round holes need not. `cam_place`
    (k, D, 2) [m], `cam_clearance` [m] and `cam_stiffness` [N/m] are those of the cams; a cam of negative clearance
    presses on both sides. `rubbing` (k, n, u) and `cam_rubbing` [1] are the generalised friction per normal force, of
    the cam on its disc's turn; k is 0 in `rubbing` without friction.

    `bending` (D, D) [m/N] is by how much an output pin that carries several discs gives way to each along its own push,
    for the force of each: off the diagonal alone, which is in `stiffness`; the last D `pins` contacts are those of the
    output pins, disc after disc. Where no disc's force moves another's contact it is None, of which numba leaves out
    what hangs on it, a fifth of what there is to compile, and `pins` 0.
    """

    radius: float
    disc: Integers
    turning: Mask
    room: Array
    distance: Array
    slope: Array
    shift: Array
    shift_slope: Array
    bend: Array
    twist: Array
    phase: Array
    trochoid: tuple[float, float, float]
    stiffness: Array
    cam_place: Array
    cam_clearance: float
    cam_stiffness: float
    rubbing: Array
    cam_rubbing: float
    bending: Array | None
    pins: int


class Curved(NamedTuple):
    """A gap at some departures: its `width` [m] and derivatives by x, y and turn of its disc and turn of the output.

    `ahead` is the gradient [1], `aside` the rate at which the contact moves along the surface, `rate` [1/m] how fast
    the normal turns with that.
    """

    width: float
    ahead: tuple[float, float, float, float]
    aside: tuple[float, float, float, float]
    rate: float


class _Pose(NamedTuple):
    """Departures of a disc in x and y, by its turn and by the output's [m], and both turns, phi and psi [rad]."""

    x: float
    y: float
    t: float
    o: float
    phi: float
    psi: float


class _Apart(NamedTuple):
    """How far two curves are apart at their ideal contact [m]: across it, q, and along it, p.

    `arm_q` and `arm_p` [m] are that of what turns with the disc: of a curve that turns, less its turn's second order;
    of a round hole's middle, as it is made.
    """

    q: float
    p: float
    arm_q: float
    arm_p: float


@njit(nogil=True, error_model="numpy", inline="always")
def largest_play(springs: KernelSprings) -> float:
    """Compute the largest play of all contacts and cams [m]."""
    play = max(abs(springs.cam_clearance), 1e-6)
    for i in range(springs.disc.size):
        play = max(play, springs.room[i])
    return play


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def opened_by(springs: KernelSprings, share: float, room: Array) -> KernelSprings:
    """Return springs with a share of their play; its contacts' is written into `room` (n,) [m]."""
    for i in range(room.size):
        room[i] = share * springs.room[i]
    return KernelSprings(
        springs.radius,
        springs.disc,
        springs.turning,
        room,
        springs.distance,
        springs.slope,
        springs.shift,
        springs.shift_slope,
        springs.bend,
        springs.twist,
        springs.phase,
        springs.trochoid,
        springs.stiffness,
        springs.cam_place,
        springs.cam_clearance * (share if springs.cam_clearance > 0.0 else 1.0),
        springs.cam_stiffness,
        springs.rubbing,
        springs.cam_rubbing,
        springs.bending,
        springs.pins,
    )


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def gap(springs: KernelSprings, k: int, i: int, z: Array) -> Curved:
    """Compute a gap at departures z [m], shape (u,)."""
    pose = pose_of(springs, springs.disc[i], z)
    return curved(springs, k, i, pose, apart_of(springs, k, i, pose), NO)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def is_open(springs: KernelSprings, k: int, i: int, z: Array) -> bool:
    """Tell whether a gap is surely open at departures z [m], shape (u,), without its width."""
    return least_width(springs, k, i, apart_of(springs, k, i, pose_of(springs, springs.disc[i], z)), NO) > 0.0


# Arrays are read before any branch: numba counts references to those that are read in one. It counts those to all of
# them where a loop calls what is not inlined: what `assemble` calls at every contact is.


@njit(nogil=True, error_model="numpy", inline="always")
def pose_of(springs: KernelSprings, disc: int, z: Array) -> _Pose:
    """Compute where a disc and the output are at departures z [m], shape (u,)."""
    x, radius = 3 * disc, springs.radius
    turned, output = z[x + 2], z[z.size - 1]
    return _Pose(z[x], z[x + 1], turned, output, turned / radius, output / radius)


@njit(nogil=True, error_model="numpy", inline="always")
def apart_of(springs: KernelSprings, k: int, i: int, pose: _Pose) -> _Apart:
    """Compute how far two curves are apart.

    Finite turns count to the second order: a curve that turns with its disc by phi sees its mate's place turn the other
    way, q + i p as e^(i phi); a round hole only moves, its middle about the disc's and the pin's about the output's.
    """
    x, o = 3 * springs.disc[i], springs.slope.shape[2] - 1
    y, t, turning, phi, psi = x + 1, x + 2, springs.turning[i], pose.phi, pose.psi
    q, p = springs.distance[k, i], springs.shift[k, i]
    turned_q, turned_p = springs.slope[k, i, t] * pose.t, springs.shift_slope[k, i, t] * pose.t
    out_q, out_p = springs.slope[k, i, o] * pose.o, springs.shift_slope[k, i, o] * pose.o
    moved_q = springs.slope[k, i, x] * pose.x + springs.slope[k, i, y] * pose.y
    moved_p = springs.shift_slope[k, i, x] * pose.x + springs.shift_slope[k, i, y] * pose.y
    if turning:
        all_q, all_p = q + moved_q + turned_q, p + moved_p + turned_p
        return _Apart(all_q - phi * (all_p - 0.5 * turned_p), all_p + phi * (all_q - 0.5 * turned_q), all_q, all_p)
    second_q = phi * (p + 0.5 * turned_p) + 0.5 * psi * out_p
    second_p = phi * (q + 0.5 * turned_q) + 0.5 * psi * out_q
    return _Apart(q + moved_q + turned_q + out_q + second_q, p + moved_p + turned_p + out_p - second_p, q, p)


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def curved(springs: KernelSprings, k: int, i: int, pose: _Pose, apart: _Apart, exact: bool) -> Curved:
    """Compute a gap and its derivatives from what `apart_of` gives."""
    x, o = 3 * springs.disc[i], springs.slope.shape[2] - 1
    y, t, turning, phi, psi = x + 1, x + 2, springs.turning[i], pose.phi, pose.psi
    qx, px = springs.slope[k, i, x], springs.shift_slope[k, i, x]
    qy, py = springs.slope[k, i, y], springs.shift_slope[k, i, y]
    qt, pt = springs.slope[k, i, t], springs.shift_slope[k, i, t]
    qo, po = springs.slope[k, i, o], springs.shift_slope[k, i, o]
    bend, twist, room = springs.bend[k, i], springs.twist[k, i], springs.room[i]
    phase, trochoid = springs.phase[k, i], springs.trochoid
    arm_q, arm_p = apart.arm_q / springs.radius, apart.arm_p / springs.radius
    if turning:
        # the rate of w + i phi (w - v phi/2), with w, the arm, linear in the turn phi at the rate v, is v + i w
        qt, pt = qt - arm_p, pt + arm_q
        qx, px, qy, py = qx - phi * px, px + phi * qx, qy - phi * py, py + phi * qy
    else:
        qt, pt = qt + arm_p + phi * pt, pt - arm_q - phi * qt
        qo, po = qo + psi * po, po - psi * qo
    q, p = apart.q, apart.p
    width, c, s, rate = _rounded(trochoid, phase, bend, twist, q, p, turning, exact)
    ahead = (c * qx + s * px, c * qy + s * py, c * qt + s * pt, c * qo + s * po)
    aside = (c * px - s * qx, c * py - s * qy, c * pt - s * qt, c * po - s * qo)
    return Curved(room + width, ahead, aside, rate)


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def _rounded(
    trochoid: tuple[float, float, float],
    phase: float,
    bend: float,
    twist: float,
    q: float,
    p: float,
    turning: bool,
    exact: bool,
) -> tuple[float, float, float, float]:
    """Compute the distance of two round curves [m], cosine and sine of their normal's turn, and the rate of that [1/m].

    Where the third order may not be relied on, the foot point on the trochoid is looked for; where there is none near,
    as of parts that are far apart, the curve counts as its circle.
    """
    along, across, gentle = 1.0 + bend * q, bend * p, _is_gentle(trochoid, bend, twist, p)
    if turning and (exact or not gentle):
        found, distance, nq, np_, rate = _foot(trochoid, phase, q, p, along)
        if found:
            return distance, nq, np_, rate
        twist = 0.0
    reach = math.sqrt(along * along + across * across)
    if not reach > 0.0 or (turning and along <= 0.0):  # a hole is a whole circle, a valley is open beyond its middle
        return q, 1.0, 0.0, 0.0
    share = 1.0 / reach
    # (reach - 1) / bend without its cancellation, and what makes the circle a curve of third order
    beyond = q + across * p / (reach + along) if along > 0.0 else (reach - 1.0) / bend
    width = beyond + twist * p * p * p / 6.0
    return width, along * share, across * share + 0.5 * twist * p * p, bend * share + twist * p


@njit(nogil=True, error_model="numpy", inline="always")
def _is_gentle(trochoid: tuple[float, float, float], bend: float, twist: float, p: float) -> bool:
    """Tell whether the trochoid is known well enough by its curvature and the rate of that, so far along [m]."""
    sharpest = _sharpest(trochoid)
    if abs(sharpest * p) >= _FAR or abs(p) >= _SMALL * trochoid[0]:
        return False
    return abs(twist) <= _VALLEY * sharpest * sharpest and bend >= min(_BOTTOM * sharpest, 0.0)


@njit(nogil=True, error_model="numpy", inline="always")
def _sharpest(trochoid: tuple[float, float, float]) -> float:
    """Compute the curvature in the middle of a valley [1/m]: nowhere is the trochoid more concave."""
    E, c, N = trochoid
    return (E - c * N * N) / (E - c * N) ** 2


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def _foot(
    trochoid: tuple[float, float, float], phase: float, q: float, p: float, along: float
) -> tuple[bool, float, float, float, float]:
    """Tell whether a point has a foot on the trochoid nearby, and give what `_rounded` does of it, exactly.

    The point is q across and p along from the curve's point at the `phase` (N - 1) t, where the normal is at the angle
    t - alpha: tan(alpha) = c N sin(phase)/(E - c N cos(phase)). Its foot is found by Newton's method, from that on the
    circle of curvature, where the curve is p over `along` away.
    """
    E, c, N = trochoid
    sine, cosine = math.sin(phase), math.cos(phase)
    sa, ca = c * N * sine, E - c * N * cosine
    rate = math.sqrt(sa * sa + ca * ca)
    sa, ca = sa / rate, ca / rate
    sb, cb = sine * ca + cosine * sa, cosine * ca - sine * sa
    # the curve goes on at that rate by t, and at another one farther on
    t = p / (rate * max(along, 0.5))
    t -= 0.5 * E * c * N * (N - 1.0) * sine / (rate * rate) * t * t
    t = min(max(t, -_FARTHEST_FOOT / N), _FARTHEST_FOOT / N)
    before, beyond, settled = -math.inf, math.inf, NO
    for _ in range(_ROUNDS):
        # sine, and cosine less 1, of t and N t, whose halves are less than a right angle
        half, wide = math.sin(0.5 * t), math.sin(0.5 * N * t)
        st, ct = 2.0 * half * math.sqrt(1.0 - half * half), -2.0 * half * half
        sw, cw = 2.0 * wide * math.sqrt(1.0 - wide * wide), -2.0 * wide * wide
        # how far the curve has come from its point, then its rate and the rate of that, by t; each across and along
        uq, up = E * (ca * ct - sa * st), E * (sa * ct + ca * st)
        wq, wp = c * (cb * cw - sb * sw), c * (sb * cw + cb * sw)
        xq, xp = uq - wq, up - wp
        vq, vp = -up - E * sa + N * (wp + c * sb), uq + E * ca - N * (wq + c * cb)
        aq, ap = -uq - E * ca + N * N * (wq + c * cb), -up - E * sa + N * N * (wp + c * sb)
        square = vq * vq + vp * vp
        nearer = (q - xq) * vq + (p - xp) * vp
        if nearer > 0.0:
            before = t
        else:
            beyond = t
        bowl = square - (q - xq) * aq - (p - xp) * ap
        step = nearer / max(bowl, 0.1 * square)
        step = min(max(step, -_LONGEST / N), _LONGEST / N)
        by_newton = bowl > 0.1 * square and before <= t + step <= beyond
        if not before <= t + step <= beyond:
            step = 0.5 * (before + beyond) - t
        settled = abs(step) < (_LAST if by_newton else _SETTLED)
        if settled:
            break
        t += step
    # the last step is so short that place and rate follow it by what is known where it begins
    xq, xp = xq + step * (vq + 0.5 * step * aq), xp + step * (vp + 0.5 * step * ap)
    vq, vp = vq + step * aq, vp + step * ap
    square = vq * vq + vp * vp
    speed = math.sqrt(square)
    nq, np_ = vp / speed, -vq / speed
    distance, curvature = (q - xq) * nq + (p - xp) * np_, -(aq * nq + ap * np_) / square
    bent = 1.0 + curvature * distance
    return settled and bent > 0.0, distance, nq, np_, curvature / bent


@njit(nogil=True, error_model="numpy", inline="always")
def least_width(springs: KernelSprings, k: int, i: int, apart: _Apart, exact: bool) -> float:
    """Compute how wide a gap is at least [m], by what `apart_of` gives; 0 where it may be closed.

    Most are open, and their roots need not be taken.
    """
    q, p = apart.q, apart.p
    bend, twist, trochoid = springs.bend[k, i], springs.twist[k, i], springs.trochoid
    room, turning = springs.room[i] - _SURELY * abs(p), springs.turning[i]
    if room + q <= 0.0:
        return 0.0
    if turning and (exact or not _is_gentle(trochoid, bend, twist, p)):
        bend = _sharpest(trochoid)  # a circle as sharp as the curve is anywhere lies within it
    if bend > 0.0:
        return room + q
    along, across, rim = 1.0 + bend * q, bend * p, 1.0 - bend * room
    square = along * along + across * across
    return (math.sqrt(square) - rim) / bend if square < rim * rim else 0.0
