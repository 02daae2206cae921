"""Exact gaps between conjugate surfaces: a pin against the cycloid gear, a circle inside a circle.

Compiled by numba, so that the collider and the tests call the same functions. Angles are clockwise from +y as in
the paper's geometry (Hsieh 2014, Eqs 2-7); lengths in metres.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cycloid_mj.base.array import Array


class TrochoidFootSettings(NamedTuple):
    """Settings of the foot point on a trochoid: Newton's method from a closed-form start (`trochoid_distance`)."""

    max_iterations: int = 30
    tolerance: float = 3e-7
    """Newton step [rad] after which the error, its square times the number of teeth, is below rounding."""
    grid: int = 64
    """Points of the curve from which the search starts again if the first foot point is far away."""
    min_straightness: float = 0.1
    """Smallest distance of a point from the centre of curvature at its foot, over the radius there."""


SETTINGS = TrochoidFootSettings()

NO_WAVES: Array = np.zeros((0, 2))
"""Waves of an unmodified profile."""


class Trochoid(NamedTuple):
    """The curve T(t) = E u(t) - c u(N t): pin-circle radius E and eccentricity c [m], and N teeth of the ring."""

    radius: float
    eccentricity: float
    teeth: float


class Pose(NamedTuple):
    """Position [m] and rotation of a body in a frame: its point p is at (x, y) + rotated(p)."""

    x: float
    y: float
    cosine: float
    sine: float


@njit(inline="always")
def inwards(pose: Pose, x: float, y: float) -> tuple[float, float]:
    """Return the components in the body of a vector of the frame."""
    return pose.cosine * x + pose.sine * y, pose.cosine * y - pose.sine * x


@njit(inline="always")
def outwards(pose: Pose, x: float, y: float) -> tuple[float, float]:
    """Return the components in the frame of a vector of the body."""
    return pose.cosine * x - pose.sine * y, pose.cosine * y + pose.sine * x


@njit(inline="always")
def to_frame(pose: Pose, x: float, y: float) -> tuple[float, float]:
    """Return the position in the frame of a point of the body [m]."""
    return pose.x + pose.cosine * x - pose.sine * y, pose.y + pose.cosine * y + pose.sine * x


@njit(inline="always")
def _rotate_angle(sine: float, cosine: float, angle: float) -> tuple[float, float]:
    """Compute sine and cosine of the sum of two angles: one with `sine` and `cosine`, the other is `angle` [rad].

    For a small `angle`, a series that is exact to rounding replaces the sine and cosine functions.
    """
    if abs(angle) > 0.05:
        small_sine, small_cosine = math.sin(angle), math.cos(angle)
    else:
        squared_angle = angle * angle
        small_sine = angle * (1.0 - squared_angle / 6.0 * (1.0 - squared_angle / 20.0 * (1.0 - squared_angle / 42.0)))
        small_cosine = 1.0 - squared_angle / 2.0 * (
            1.0 - squared_angle / 12.0 * (1.0 - squared_angle / 30.0 * (1.0 - squared_angle / 56.0))
        )
    return sine * small_cosine + cosine * small_sine, cosine * small_cosine - sine * small_sine


@njit(inline="always")
def trochoid_start(x: float, y: float, curve: Trochoid) -> tuple[float, float, float]:
    """Compute a start for the search of the foot point of (x, y) [m] on a trochoid `curve`, in closed form.

    With the symbols of `Trochoid`, the radius r of T(t) satisfies r^2 = E^2 + c^2 - 2 E c cos((N-1) t), and its polar
    angle is t - atan2(c sin((N-1) t), E - c cos((N-1) t)).

    Returns
    -------
    tuple of float
        Parameter of the start [rad], and its sine and cosine.
    """
    radius, eccentricity, teeth = curve
    squared_distance = x * x + y * y
    polar_angle = math.atan2(x, y)
    cosine = (radius * radius + eccentricity * eccentricity - squared_distance) / (2.0 * radius * eccentricity)
    cosine = min(1.0, max(-1.0, cosine))
    lobe_turns = (teeth - 1.0) * polar_angle / (2.0 * math.pi)
    sine = math.sqrt(1.0 - cosine * cosine)
    if lobe_turns - math.floor(lobe_turns) > 0.5:
        sine = -sine
    tan_tilt = eccentricity * sine / (radius - eccentricity * cosine)
    length = math.sqrt(squared_distance * (1.0 + tan_tilt * tan_tilt))
    return polar_angle + math.atan(tan_tilt), (x + tan_tilt * y) / length, (y - tan_tilt * x) / length


@njit
def trochoid_foot(
    x: float, y: float, curve: Trochoid, start: float, sin_t: float, cos_t: float
) -> tuple[float, float, float, float, bool]:
    """Solve for the foot point of (x, y) [m] on a trochoid `curve` by Newton's method.

    Parameters
    ----------
    x, y
        Position of the point [m].
    curve
        The trochoid.
    start, sin_t, cos_t
        Parameter of the trochoid at which the iteration starts [rad], its sine and cosine.

    Returns
    -------
    t
        Parameter of the trochoid at the foot point [rad].
    distance
        Signed distance from the trochoid [m], positive outside.
    normal_x, normal_y
        Outward unit normal at the foot point.
    has_converged
        Whether the last step was below the tolerance.
    """
    radius, eccentricity, teeth = curve
    t = start
    sin_nt, cos_nt = math.sin(teeth * t), math.cos(teeth * t)
    pitch_radius = eccentricity * teeth
    max_increment = 0.5 / teeth
    has_converged = False
    for _ in range(SETTINGS.max_iterations):
        dx = radius * sin_t - eccentricity * sin_nt - x
        dy = radius * cos_t - eccentricity * cos_nt - y
        tangent_x, tangent_y = radius * cos_t - pitch_radius * cos_nt, pitch_radius * sin_nt - radius * sin_t
        tangent_rate_x, tangent_rate_y = (
            pitch_radius * teeth * sin_nt - radius * sin_t,
            pitch_radius * teeth * cos_nt - radius * cos_t,
        )
        squared_speed = tangent_x * tangent_x + tangent_y * tangent_y
        second_derivative = squared_speed + dx * tangent_rate_x + dy * tangent_rate_y
        # Gauss-Newton where the point is beyond a centre of curvature: always a descent direction.
        increment = -(dx * tangent_x + dy * tangent_y) / (
            second_derivative if second_derivative > 0.1 * squared_speed else squared_speed
        )
        increment = min(max_increment, max(-max_increment, increment))
        t += increment
        sin_t, cos_t = _rotate_angle(sin_t, cos_t, increment)
        sin_nt, cos_nt = _rotate_angle(sin_nt, cos_nt, teeth * increment)
        if abs(increment) < SETTINGS.tolerance:
            has_converged = True
            break
    tangent_x, tangent_y = radius * cos_t - pitch_radius * cos_nt, pitch_radius * sin_nt - radius * sin_t
    speed = math.sqrt(tangent_x * tangent_x + tangent_y * tangent_y)
    nx, ny = -tangent_y / speed, tangent_x / speed
    dx = radius * sin_t - eccentricity * sin_nt - x
    dy = radius * cos_t - eccentricity * cos_nt - y
    return t, -(dx * nx + dy * ny), nx, ny, has_converged


@njit
def trochoid_distance(x: float, y: float, curve: Trochoid) -> tuple[float, float, float, float]:
    """Compute the signed distance of a point (x, y) [m] from a trochoid `curve`.

    Newton's method starts in closed form. Far from the curve, where it may converge to another foot point, it starts
    again from the nearest of equally spaced points of the curve.

    Returns
    -------
    tuple of float
        Parameter of the foot point [rad], distance [m], positive outside, and outward unit normal (x, y).
    """
    radius, eccentricity, ring_teeth = curve
    closed_form_start, sin_t, cos_t = trochoid_start(x, y, curve)
    t, distance, nx, ny, has_converged = trochoid_foot(x, y, curve, closed_form_start, sin_t, cos_t)
    if has_converged and abs(distance) < 0.1 * eccentricity:
        return t, distance, nx, ny
    pitch = 2.0 * math.pi / (ring_teeth - 1.0)
    best_start, min_squared_distance = closed_form_start, math.inf
    for i in range(SETTINGS.grid):
        candidate = closed_form_start + pitch * (i / SETTINGS.grid - 0.5) * 2.0
        dx = radius * math.sin(candidate) - eccentricity * math.sin(ring_teeth * candidate) - x
        dy = radius * math.cos(candidate) - eccentricity * math.cos(ring_teeth * candidate) - y
        if dx * dx + dy * dy < min_squared_distance:
            best_start, min_squared_distance = candidate, dx * dx + dy * dy
    t, distance, nx, ny, has_converged = trochoid_foot(
        x, y, curve, best_start, math.sin(best_start), math.cos(best_start)
    )
    return t, distance, nx, ny


@njit(inline="always")
def trochoid_curvature(t: float, curve: Trochoid) -> float:
    """Compute the signed curvature [1/m] of a trochoid `curve` at the parameter `t` [rad], positive where it is convex.

    It is (E^2 + c^2 N^3 - E c N (N+1) cos B)/l^3 with l^2 = E^2 + c^2 N^2 - 2 E c N cos B, B = (N-1) t, and the symbols
    of `Trochoid`.
    """
    radius, eccentricity, teeth = curve
    pitch_radius = eccentricity * teeth
    product = radius * pitch_radius * math.cos((teeth - 1.0) * t)
    squared_pitch_distance = radius * radius + pitch_radius * pitch_radius - 2.0 * product
    return (radius * radius + pitch_radius * pitch_radius * teeth - (teeth + 1.0) * product) / (
        squared_pitch_distance * math.sqrt(squared_pitch_distance)
    )


class Flank(NamedTuple):
    """The disc's flanks.

    Attributes
    ----------
    curve
        The trochoid that the gear is generated with.
    offset
        Distance of the flank from the trochoid, inwards [m].
    rotation
        Rotation of each flank towards the middle of its lobe [rad].
    tip, tip_radius, valley, valley_radius
        Ends of a rotated flank, see ``modification.FlankEnds``; 0 without rotation.
    waves
        Offset of the flank inwards, ``deviations.profile_error``: amplitudes of cos(k t) and sin(k t) [m] of the
        orders k = 1, 2, ... in a turn of the gear, shape (orders, 2).
    """

    curve: Trochoid
    offset: float
    rotation: float
    tip: float
    tip_radius: float
    valley: float
    valley_radius: float
    waves: Array


@njit
def wave_offset(t: float, waves: Array) -> tuple[float, float, float]:
    """Compute the inward offset [m] of a waved flank at the parameter t [rad], and its first and second derivative.

    The derivatives are with respect to t. `waves` (orders, 2) [m] are the amplitudes of cos(k t) and sin(k t) for the
    orders k = 1, 2, ...
    """
    offset, first_derivative, second_derivative = 0.0, 0.0, 0.0
    sine, cosine = math.sin(t), math.cos(t)
    sine_k, cosine_k = 0.0, 1.0
    for k in range(1, len(waves) + 1):
        sine_k, cosine_k = sine_k * cosine + cosine_k * sine, cosine_k * cosine - sine_k * sine
        by_cosine, by_sine = waves[k - 1, 0], waves[k - 1, 1]
        term = by_cosine * cosine_k + by_sine * sine_k
        offset += term
        first_derivative += k * (by_sine * cosine_k - by_cosine * sine_k)
        second_derivative -= k * k * term
    return offset, first_derivative, second_derivative


@njit(inline="always")
def _speed_squared(t: float, curve: Trochoid) -> float:
    """Compute the square of the trochoid's arc rate [m2/rad2]."""
    radius, eccentricity, teeth = curve
    pitch_radius = eccentricity * teeth
    return radius * radius + pitch_radius * pitch_radius - 2.0 * radius * pitch_radius * math.cos((teeth - 1.0) * t)


@njit
def _waved_distance(x: float, y: float, flank: Flank) -> tuple[float, float, float, float]:
    """Compute the signed distance of a point (x, y) [m] from a flank with waves: its trochoid offset inwards by w(t).

    For a foot point at t on the trochoid, w(t) is added to the distance, and the normal is that of the waved curve. The
    relative error of the distance is below 1e-4.

    Returns
    -------
    tuple of float
        Parameter [rad] of the foot point, distance [m], positive outside, and outward unit normal (x, y).
    """
    t, distance, nx, ny = trochoid_distance(x, y, flank.curve)
    offset, offset_rate, _ = wave_offset(t, flank.waves)
    straightness = max(SETTINGS.min_straightness, 1.0 + trochoid_curvature(t, flank.curve) * distance)
    normal_tilt = offset_rate / (straightness * math.sqrt(_speed_squared(t, flank.curve)))
    norm = math.sqrt(1.0 + normal_tilt * normal_tilt)
    return t, distance + offset, (nx + normal_tilt * ny) / norm, (ny - normal_tilt * nx) / norm


@njit(inline="always")
def _unrotated_distance(x: float, y: float, flank: Flank) -> tuple[float, float, float, float]:
    if len(flank.waves) == 0:
        return trochoid_distance(x, y, flank.curve)
    return _waved_distance(x, y, flank)


@njit
def flank_curvature(t: float, flank: Flank) -> float:
    """Compute the signed curvature [1/m] of the trochoid with the flank's waves at t [rad], positive where convex."""
    curvature = trochoid_curvature(t, flank.curve)
    if len(flank.waves) == 0:
        return curvature
    return curvature + wave_offset(t, flank.waves)[2] / _speed_squared(t, flank.curve)


@njit
def _rotated_flank_distance(x: float, y: float, flank: Flank) -> tuple[float, float, float, float, bool]:
    """Compute the distance of a point (x, y) [m] from the two rotated flanks of a lobe, minus `flank.offset`.

    The distance is the larger of those from both flanks, or that from the corner at which the flanks meet if the foot
    point is cut away by the other flank. The results are those of `flank_distance`: trochoid parameter [rad], distance
    [m], outward unit normal x and y, and whether the nearest point is a corner.
    """
    sine, cosine = math.sin(flank.rotation), math.cos(flank.rotation)
    # The flank before a tip, clockwise, is turned clockwise, that after it counter-clockwise.
    side = 1.0
    t, distance, nx, ny = _unrotated_distance(cosine * x - sine * y, cosine * y + sine * x, flank)
    other_side = _unrotated_distance(cosine * x + sine * y, cosine * y - sine * x, flank)
    if other_side[1] > distance:
        side, sine = -1.0, -sine
        t, distance, nx, ny = other_side
    pitch = 2.0 * math.pi / (flank.curve.teeth - 1.0)
    lobe_turns = side * t / pitch
    beyond_valley = pitch * (lobe_turns - math.floor(lobe_turns))
    if beyond_valley <= 0.5 * pitch - flank.tip or beyond_valley >= pitch - flank.valley:
        return t, distance, cosine * nx + sine * ny, cosine * ny - sine * nx, False
    is_tip = beyond_valley < 0.75 * pitch
    middle_angle = side * pitch * (math.floor(lobe_turns) + (0.5 if is_tip else 1.0))
    corner_radius = flank.tip_radius if is_tip else flank.valley_radius
    dx, dy = x - corner_radius * math.sin(middle_angle), y - corner_radius * math.cos(middle_angle)
    corner_distance = math.sqrt(dx * dx + dy * dy)
    end_parameter = middle_angle - side * (flank.tip if is_tip else flank.valley)
    return (
        end_parameter,
        corner_distance - flank.offset + wave_offset(end_parameter, flank.waves)[0],
        dx / corner_distance,
        dy / corner_distance,
        True,
    )


@njit(inline="always")
def flank_distance(x: float, y: float, flank: Flank) -> tuple[float, float, float, float, bool]:
    """Compute the distance of a point (x, y) [m] near the trochoid from the gear's flanks, minus `flank.offset`.

    With rotated flanks the disc is the intersection of its profile rotated to either side. The distance is then the
    larger of those from both flanks or, where the foot point is cut away, that from the corner between the flanks.

    Returns
    -------
    t
        Trochoid parameter [rad] of the foot point, as for `flank_curvature`; at a corner, that of the flank's end.
    distance
        Distance from the surface, positive outside, minus `flank.offset` [m]. Without rotation and waves it is the
        signed distance from the trochoid.
    normal_x, normal_y
        Outward unit normal.
    at_corner
        Whether the nearest point is a corner.
    """
    if flank.rotation == 0.0:
        t, distance, nx, ny = _unrotated_distance(x, y, flank)
        return t, distance, nx, ny, False
    return _rotated_flank_distance(x, y, flank)


@njit(inline="always")
def circle_in_circle(dx: float, dy: float, inner: float, outer: float) -> tuple[float, float, float]:
    """Compute gap [m] and unit normal (x, y) between two circles with the radii `inner` and `outer` [m].

    The vector (dx, dy) [m] leads from the outer to the inner centre. The normal points from the inner to the outer
    circle where the gap is smallest.
    """
    distance = math.sqrt(dx * dx + dy * dy)
    if distance == 0.0:
        return outer - inner, 0.0, 1.0
    return outer - inner - distance, dx / distance, dy / distance


class PartialCircle(NamedTuple):
    """Arc of an open circle: radius [m], unit vector to its centre, cosine and sine of half of its angle."""

    radius: float
    x: float
    y: float
    cosine: float
    sine: float


@njit(inline="always")
def arc_edge(arc: PartialCircle, side: float) -> tuple[float, float]:
    """Compute the edge of an arc [m] from its circle's centre; side 1.0 is clockwise of the middle, -1.0 before it."""
    signed_sine = side * arc.sine
    return arc.radius * (arc.cosine * arc.x + signed_sine * arc.y), arc.radius * (
        arc.cosine * arc.y - signed_sine * arc.x
    )


@njit(inline="always")
def circle_at_edge(dx: float, dy: float, inner: float, arc: PartialCircle, side: float) -> tuple[float, float, float]:
    """Compute gap [m] and unit normal (x, y) from a circle of radius `inner` [m] to an edge of an arc.

    The vector (dx, dy) [m] leads from the centre of the arc to that of the circle. `side` selects the edge: that at the
    clockwise end of the arc if 1.0, at the counter-clockwise end if -1.0.
    """
    x, y = arc_edge(arc, side)
    x, y = x - dx, y - dy
    distance = math.sqrt(x * x + y * y)
    return distance - inner, x / distance, y / distance


@njit(inline="always")
def nearest_on_arc(dx: float, dy: float, arc: PartialCircle) -> tuple[float, bool, bool]:
    """Return which points of an arc may be nearest to a position (dx, dy) relative to its circle's centre [m].

    Returns
    -------
    side
        Side of the arc's middle on which the position is: 1.0 clockwise, -1.0 counter-clockwise.
    on_arc
        Whether the nearest point is on the arc; else it is the edge on this side.
    other
        Whether the edge on the other side may be in contact, too, because the position is towards the opening.
    """
    along_axis, across_axis = dx * arc.x + dy * arc.y, dx * arc.y - dy * arc.x
    side = 1.0 if across_axis >= 0.0 else -1.0
    arc_side, edge_side = arc.sine * along_axis, arc.cosine * abs(across_axis)
    return side, arc_side >= edge_side, arc_side < -edge_side
