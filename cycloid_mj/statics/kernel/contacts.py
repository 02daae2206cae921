"""Contact springs at some crank angles, and the gap of each: its width and gradients.

The profile of a tooth is expanded to the third order about its ideal contact. Where this is not accurate enough, or if
the solver requests it, the foot point on the trochoid is computed.
"""

import math
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.compiling import cacheable, njit

TRUE: bool = np.bool_(True)  # type: ignore[assignment]
FALSE: bool = np.bool_(False)  # type: ignore[assignment]
FIRST: int = np.int64(0)  # type: ignore[assignment]
"""Arguments of a single type: numba would compile a function once more for a literal of Python."""


class ExpansionSettings(NamedTuple):
    """Validity of the third-order expansion of a tooth's profile about its ideal contact (`_is_expansion_valid`).

    Attributes
    ----------
    valley_twist
        Rate of the curvature, over the square of the largest curvature, from which on a profile counts as a valley.
    bottom_curvature
        Curvature, over the largest, from which on it is the bottom of a valley, where its rate vanishes.
    max_arc
        Largest arc along the profile, over the smallest radius of curvature.
    max_shift
        Largest arc along the profile, over the pin-circle radius.
    third_order
        Bound of the third-order term of the gap, over the arc along the profile.
    """

    valley_twist: float = 1e-3
    bottom_curvature: float = 0.5
    max_arc: float = 0.7
    max_shift: float = 4e-4
    third_order: float = 1e-4


class FootPointSettings(NamedTuple):
    """Settings of Newton's method with bisection for the foot point on a trochoid (`_find_foot_point`).

    Angles are N t [rad].

    Attributes
    ----------
    max_start
        Largest distance of the start from the ideal contact: within the half lobe, 1.57, beyond which another flank
        begins.
    max_step
        Largest step.
    max_iterations
        As bisections of a lobe down to rounding need.
    newton_tolerance
        Largest last step of Newton's method: with quadratic convergence, the foot is then known to rounding.
    bisection_tolerance
        Largest last step of a bisection.
    """

    max_start: float = 1.5
    max_step: float = 0.5
    max_iterations: int = 60
    newton_tolerance: float = 1e-7
    bisection_tolerance: float = 1e-12


_EXPANSION, _FOOT_POINT = ExpansionSettings(), FootPointSettings()


class KernelSprings(NamedTuple):
    """Springs at k crank angles, n at each, on the u = 3 D + 1 displacements of D discs and an output.

    Displacements z (u,) [m] are departures from the ideal pose: x, y and rotation of each disc, then the rotation of
    the output. Rotations are arc lengths: angles times `radius` [m], that of the circle of output pins
    (``reducer.gaps``).

    For most attributes see ``gaps.Gaps``; `clearance` [m] includes the clearance of the pins. Shapes: `clearance` (n,)
    [m]; `distance`, `shift`, `curvature`, `curvature_rate`, `phase`, `stiffness` (k, n) [m, m, 1/m, 1/m2, rad, N/m];
    `slope`, `shift_slope` (k, n, u) [1].

    `trochoid`, the path of ideal pin centres, is E u(t) - c u(N t): E is the pin-circle radius [m], c the eccentricity
    [m], N the number of ring pins, and u(t) the unit vector at the angle t. `disc` (n,) is the disc of a contact;
    `rotates` (n,) marks contacts whose profile rotates with the disc: teeth, but not round holes. `cam_position` (k, D,
    2) [m], `cam_clearance` [m] and `cam_stiffness` [N/m] are those of the cams; a cam with negative clearance is in
    contact on both sides. `friction_per_force` (k, n, u) and `cam_friction_per_force` [1] are the generalised friction
    per normal force, the latter on the rotation of the cam's disc; k is 0 in `friction_per_force` without friction.
    `cam_lateral` [1] is the friction force of a sliding cam across its normal, per normal force; rollers exert none.

    `bending` (D, D) [m/N] is the deflection of an output pin at each disc, along its own force, per force of each other
    disc; the diagonal is part of `stiffness`. The last D `pins` contacts are those of the output pins, disc by disc;
    `pins` is 0 if no disc's force moves another's contact.
    """

    radius: float
    disc: Integers
    rotates: Mask
    clearance: Array
    distance: Array
    slope: Array
    shift: Array
    shift_slope: Array
    curvature: Array
    curvature_rate: Array
    phase: Array
    trochoid: tuple[float, float, float]
    stiffness: Array
    cam_position: Array
    cam_clearance: float
    cam_stiffness: float
    friction_per_force: Array
    cam_friction_per_force: float
    cam_lateral: float
    bending: Array
    pins: int


class Gap(NamedTuple):
    """A gap at some displacements: `width` [m] and derivatives by x, y and rotation of its disc and by the output's.

    `normal` is the gradient of the width [1], `tangential` the rate at which the contact moves along the surface [1],
    and `rate` the rotation of the normal per distance along the surface [1/m].
    """

    width: float
    normal: tuple[float, float, float, float]
    tangential: tuple[float, float, float, float]
    rate: float


class _Pose(NamedTuple):
    """Displacements of a disc and of the output from the ideal pose.

    `x`, `y` are the position of the disc; `t` and `o` the rotations of disc and output as arc lengths (`KernelSprings`)
    [m], and `phi` and `psi` the same rotations as angles [rad].
    """

    x: float
    y: float
    t: float
    o: float
    phi: float
    psi: float


class _CurveOffset(NamedTuple):
    """Offset of the points of two curves that touch in the ideal mesh: `q` along its normal, `p` along its tangent [m].

    `arm_q` and `arm_p` [m] are the lever arms of the rotation of the disc. For a tooth profile they are the offset
    without the second order of the rotation, for a round hole the nominal offset of its centre.
    """

    q: float
    p: float
    arm_q: float
    arm_p: float


@njit(nogil=True, error_model="numpy", inline="always")
def largest_play(springs: KernelSprings) -> float:
    """Return the largest clearance of all contacts and cams [m], in magnitude for a cam, and at least 1 um."""
    play = max(abs(springs.cam_clearance), 1e-6)
    for i in range(springs.disc.size):
        play = max(play, springs.clearance[i])
    return play


@njit(nogil=True, error_model="numpy", inline="always")
def scale_clearances(springs: KernelSprings, share: float, scaled_clearance: Array) -> KernelSprings:
    """Return contact springs with clearances multiplied by `share` [1], except the preload (negative) of a cam.

    The clearances of the n contacts are written to `scaled_clearance` (n,) [m], a workspace of the new springs, which
    share all other arrays with `springs`.
    """
    for i in range(scaled_clearance.size):
        scaled_clearance[i] = share * springs.clearance[i]
    return KernelSprings(
        springs.radius,
        springs.disc,
        springs.rotates,
        scaled_clearance,
        springs.distance,
        springs.slope,
        springs.shift,
        springs.shift_slope,
        springs.curvature,
        springs.curvature_rate,
        springs.phase,
        springs.trochoid,
        springs.stiffness,
        springs.cam_position,
        springs.cam_clearance * (share if springs.cam_clearance > 0.0 else 1.0),
        springs.cam_stiffness,
        springs.friction_per_force,
        springs.cam_friction_per_force,
        springs.cam_lateral,
        springs.bending,
        springs.pins,
    )


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def gap(springs: KernelSprings, k: int, i: int, z: Array) -> Gap:
    """Compute the gap of contact `i` and its gradients, at crank angle index `k` and displacements `z` (u,) [m]."""
    pose = disc_pose(springs, springs.disc[i], z)
    return gap_at(springs, k, i, pose, curve_offset(springs, k, i, pose), FALSE)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def is_open(springs: KernelSprings, k: int, i: int, z: Array) -> bool:
    """Return whether a lower bound of the gap of contact `i` is positive, at the crank angle of index `k`.

    `z` (u,) [m] are the u unknown displacements. The contact is open if the result is true, and may be open or closed
    if not.
    """
    return bound_width(springs, k, i, curve_offset(springs, k, i, disc_pose(springs, springs.disc[i], z)), FALSE) > 0.0


# Arrays are read before any branch, and functions that `assemble` calls at every contact are inlined: otherwise numba
# counts references to the arrays.


@njit(nogil=True, error_model="numpy", inline="always")
def disc_pose(springs: KernelSprings, disc: int, z: Array) -> _Pose:
    """Return the displacements of the disc of index `disc` and of the output, from all displacements `z` (u,) [m]."""
    index, radius = 3 * disc, springs.radius
    rotation, output_rotation = z[index + 2], z[z.size - 1]
    return _Pose(z[index], z[index + 1], rotation, output_rotation, rotation / radius, output_rotation / radius)


@njit(nogil=True, error_model="numpy", inline="always")
def curve_offset(springs: KernelSprings, k: int, i: int, pose: _Pose) -> _CurveOffset:
    """Compute the offset between the two points of a contact that touch in the ideal mesh, at displaced parts.

    Its components are q along the normal and p along the tangent of the ideal contact [m], with rotations to the second
    order. For a tooth, both are components in the frame that rotates with the disc.

    Parameters
    ----------
    springs
        Contact springs at all crank angles.
    k, i
        Indices of the crank angle and of the contact.
    pose
        Displacements of the contact's disc and of the output, from `disc_pose`.
    """
    x, output_dof = 3 * springs.disc[i], springs.slope.shape[2] - 1
    y, t, rotates, phi, psi = x + 1, x + 2, springs.rotates[i], pose.phi, pose.psi
    q, p = springs.distance[k, i], springs.shift[k, i]
    rotated_q, rotated_p = springs.slope[k, i, t] * pose.t, springs.shift_slope[k, i, t] * pose.t
    output_q, output_p = springs.slope[k, i, output_dof] * pose.o, springs.shift_slope[k, i, output_dof] * pose.o
    moved_q = springs.slope[k, i, x] * pose.x + springs.slope[k, i, y] * pose.y
    moved_p = springs.shift_slope[k, i, x] * pose.x + springs.shift_slope[k, i, y] * pose.y
    if rotates:
        all_q, all_p = q + moved_q + rotated_q, p + moved_p + rotated_p
        return _CurveOffset(
            all_q - phi * (all_p - 0.5 * rotated_p), all_p + phi * (all_q - 0.5 * rotated_q), all_q, all_p
        )
    second_q = phi * (p + 0.5 * rotated_p) + 0.5 * psi * output_p
    second_p = phi * (q + 0.5 * rotated_q) + 0.5 * psi * output_q
    return _CurveOffset(
        q + moved_q + rotated_q + output_q + second_q, p + moved_p + rotated_p + output_p - second_p, q, p
    )


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def gap_at(springs: KernelSprings, k: int, i: int, pose: _Pose, offset: _CurveOffset, use_foot_point: bool) -> Gap:
    """Compute width and gradients of the gap of a contact at displaced parts.

    The width [m] is negative if surfaces overlap. Gradients are by the displacements of the disc and the rotation of
    the output.

    Parameters
    ----------
    springs
        Contact springs at all crank angles.
    k, i
        Indices of the crank angle and of the contact.
    pose, offset
        Displacements of the contact's disc and of the output, and the result of `curve_offset` for them.
    use_foot_point
        Whether the foot point on the tooth profile is always computed. If not, it is computed only where an expansion
        of the profile to the third order is not accurate.
    """
    x, output_dof = 3 * springs.disc[i], springs.slope.shape[2] - 1
    y, t, rotates, phi, psi = x + 1, x + 2, springs.rotates[i], pose.phi, pose.psi
    # derivatives of q and p by x, y and rotation t of the disc, and by the rotation o of the output
    q_x, p_x = springs.slope[k, i, x], springs.shift_slope[k, i, x]
    q_y, p_y = springs.slope[k, i, y], springs.shift_slope[k, i, y]
    q_t, p_t = springs.slope[k, i, t], springs.shift_slope[k, i, t]
    q_o, p_o = springs.slope[k, i, output_dof], springs.shift_slope[k, i, output_dof]
    curvature, curvature_rate, clearance = springs.curvature[k, i], springs.curvature_rate[k, i], springs.clearance[i]
    phase, trochoid = springs.phase[k, i], springs.trochoid
    arm_q, arm_p = offset.arm_q / springs.radius, offset.arm_p / springs.radius
    if rotates:
        # the rate of w + i phi (w - v phi/2), with w, the arm, linear in the turn phi at the rate v, is v + i w
        q_t, p_t = q_t - arm_p, p_t + arm_q
        q_x, p_x, q_y, p_y = q_x - phi * p_x, p_x + phi * q_x, q_y - phi * p_y, p_y + phi * q_y
    else:
        q_t, p_t = q_t + arm_p + phi * p_t, p_t - arm_q - phi * q_t
        q_o, p_o = q_o + psi * p_o, p_o - psi * q_o
    q, p = offset.q, offset.p
    width, cosine, sine, rate = _curve_distance(
        trochoid, phase, curvature, curvature_rate, q, p, rotates, use_foot_point
    )
    normal_gradient = (
        cosine * q_x + sine * p_x,
        cosine * q_y + sine * p_y,
        cosine * q_t + sine * p_t,
        cosine * q_o + sine * p_o,
    )
    tangential_gradient = (
        cosine * p_x - sine * q_x,
        cosine * p_y - sine * q_y,
        cosine * p_t - sine * q_t,
        cosine * p_o - sine * q_o,
    )
    return Gap(clearance + width, normal_gradient, tangential_gradient, rate)


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def _curve_distance(
    trochoid: tuple[float, float, float],
    phase: float,
    curvature: float,
    curvature_rate: float,
    q: float,
    p: float,
    rotates: bool,
    use_foot_point: bool,
) -> tuple[float, float, float, float]:
    """Compute the distance of two curves in contact, whose points of ideal contact are offset from each other.

    The distance is expanded to the third order. Where the expansion is not valid, the foot point on the trochoid is
    used. If there is none nearby, as for parts that are far apart, the profile is approximated by its circle of
    curvature.

    Parameters
    ----------
    trochoid, phase
        Pin circle radius [m], eccentricity [m] and number of ring pins; and the phase of the pin [rad]. They are used
        only for a tooth profile.
    curvature, curvature_rate
        Relative curvature at the ideal contact [1/m], and its rate along the arc [1/m2].
    q, p
        Offset along the normal and along the tangent [m].
    rotates
        True for a tooth profile, which rotates with the disc; False for a round hole.
    use_foot_point
        Whether the foot point of a profile is always computed.

    Returns
    -------
    tuple of float
        Distance [m], cosine and sine of the angle by which the normal rotates, and rate of this angle by p [1/m].
    """
    normal_component, tangent_component = 1.0 + curvature * q, curvature * p
    is_accurate = _is_expansion_valid(trochoid, curvature, curvature_rate, p)
    if rotates and (use_foot_point or not is_accurate):
        has_foot, distance, cosine, sine, rate = _find_foot_point(trochoid, phase, q, p, normal_component)
        if has_foot:
            return distance, cosine, sine, rate
        curvature_rate = 0.0
    distance_ratio = math.sqrt(normal_component * normal_component + tangent_component * tangent_component)
    # a hole is a full circle, a valley is open beyond its centre
    if not distance_ratio > 0.0 or (rotates and normal_component <= 0.0):
        return q, 1.0, 0.0, 0.0
    inverse = 1.0 / distance_ratio
    # (distance_ratio - 1) / curvature without cancellation, and the third-order term
    circle_distance = (
        q + tangent_component * p / (distance_ratio + normal_component)
        if normal_component > 0.0
        else (distance_ratio - 1.0) / curvature
    )
    distance = circle_distance + curvature_rate * p * p * p / 6.0
    return (
        distance,
        normal_component * inverse,
        tangent_component * inverse + 0.5 * curvature_rate * p * p,
        curvature * inverse + curvature_rate * p,
    )


@njit(nogil=True, error_model="numpy", inline="always")
def _is_expansion_valid(
    trochoid: tuple[float, float, float], curvature: float, curvature_rate: float, p: float
) -> bool:
    """Return whether the third-order expansion of a tooth profile is accurate at a distance p along it [m].

    Parameters
    ----------
    trochoid
        Pin-circle radius [m], eccentricity [m] and number of ring pins.
    curvature, curvature_rate
        Relative curvature at the ideal contact [1/m], and its rate along the arc [1/m2].
    p
        Offset along the tangent of the ideal contact [m].
    """
    max_curvature = _valley_curvature(trochoid)
    if abs(max_curvature * p) >= _EXPANSION.max_arc or abs(p) >= _EXPANSION.max_shift * trochoid[0]:
        return False
    return abs(curvature_rate) <= _EXPANSION.valley_twist * max_curvature * max_curvature and curvature >= min(
        _EXPANSION.bottom_curvature * max_curvature, 0.0
    )


@njit(nogil=True, error_model="numpy", inline="always")
def _valley_curvature(trochoid: tuple[float, float, float]) -> float:
    """Return the curvature at the bottom of a valley of the `trochoid` (`KernelSprings`), negative [1/m]."""
    E, c, N = trochoid
    return (E - c * N * N) / (E - c * N) ** 2


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def _find_foot_point(
    trochoid: tuple[float, float, float], phase: float, q: float, p: float, start_arc_ratio: float
) -> tuple[bool, float, float, float, float]:
    """Find the foot point of a displaced point on a trochoid, by Newton's method with bisection.

    `trochoid` is (E, c, N): pin-circle radius [m], eccentricity [m] and number of ring pins (`KernelSprings`). The
    ideal contact is at the `phase` (N - 1) t [rad]. The point is displaced from it by q along the outward normal and p
    along the tangent [m]. `start_arc_ratio` is 1 + curvature q there: arc length at the distance q per arc length on
    the trochoid. The curvature is positive on the tips of the lobes.

    Returns whether there is a foot point nearby; distance of the point from it [m], positive outwards; cosine and sine
    of the angle by which the normal rotates, and rate of this angle by p [1/m].
    """
    E, c, N = trochoid
    # angles: a of the velocity, b = a + phase, t, and w = N t
    sine, cosine = math.sin(phase), math.cos(phase)
    sin_a, cos_a = c * N * sine, E - c * N * cosine
    start_speed = math.sqrt(sin_a * sin_a + cos_a * cos_a)
    sin_a, cos_a = sin_a / start_speed, cos_a / start_speed
    sin_b, cos_b = sine * cos_a + cosine * sin_a, cosine * cos_a - sine * sin_a
    # first and second order of the arc by t
    t = p / (start_speed * max(start_arc_ratio, 0.5))
    t -= 0.5 * E * c * N * (N - 1.0) * sine / (start_speed * start_speed) * t * t
    t = min(max(t, -_FOOT_POINT.max_start / N), _FOOT_POINT.max_start / N)
    min_t, max_t, converged = -math.inf, math.inf, FALSE
    for _ in range(_FOOT_POINT.max_iterations):
        # without cancellation for small angles; the halves of t and w are less than a right angle
        sin_half_t, sin_half_w = math.sin(0.5 * t), math.sin(0.5 * N * t)
        sin_t, cos_t_minus_1 = (
            2.0 * sin_half_t * math.sqrt(1.0 - sin_half_t * sin_half_t),
            -2.0 * sin_half_t * sin_half_t,
        )
        sin_w, cos_w_minus_1 = (
            2.0 * sin_half_w * math.sqrt(1.0 - sin_half_w * sin_half_w),
            -2.0 * sin_half_w * sin_half_w,
        )
        # position x = u - w relative to the start, first (v) and second (a) derivative by t, along normal and tangent
        u_q, u_p = E * (cos_a * cos_t_minus_1 - sin_a * sin_t), E * (sin_a * cos_t_minus_1 + cos_a * sin_t)
        w_q, w_p = c * (cos_b * cos_w_minus_1 - sin_b * sin_w), c * (sin_b * cos_w_minus_1 + cos_b * sin_w)
        x_q, x_p = u_q - w_q, u_p - w_p
        v_q, v_p = -u_p - E * sin_a + N * (w_p + c * sin_b), u_q + E * cos_a - N * (w_q + c * cos_b)
        a_q, a_p = -u_q - E * cos_a + N * N * (w_q + c * cos_b), -u_p - E * sin_a + N * N * (w_p + c * sin_b)
        speed_squared = v_q * v_q + v_p * v_p
        residual = (q - x_q) * v_q + (p - x_p) * v_p
        if residual > 0.0:
            min_t = t
        else:
            max_t = t
        derivative = speed_squared - (q - x_q) * a_q - (p - x_p) * a_p
        step = residual / max(derivative, 0.1 * speed_squared)
        step = min(max(step, -_FOOT_POINT.max_step / N), _FOOT_POINT.max_step / N)
        by_newton = derivative > 0.1 * speed_squared and min_t <= t + step <= max_t
        if not min_t <= t + step <= max_t:
            step = 0.5 * (min_t + max_t) - t
        converged = abs(step) < (_FOOT_POINT.newton_tolerance if by_newton else _FOOT_POINT.bisection_tolerance)
        if converged:
            break
        t += step
    # the last step is so short that its Taylor expansion is exact to rounding
    x_q, x_p = x_q + step * (v_q + 0.5 * step * a_q), x_p + step * (v_p + 0.5 * step * a_p)
    v_q, v_p = v_q + step * a_q, v_p + step * a_p
    speed_squared = v_q * v_q + v_p * v_p
    speed = math.sqrt(speed_squared)
    n_q, n_p = v_p / speed, -v_q / speed
    distance, curvature = (q - x_q) * n_q + (p - x_p) * n_p, -(a_q * n_q + a_p * n_p) / speed_squared
    arc_ratio = 1.0 + curvature * distance
    return converged and arc_ratio > 0.0, distance, n_q, n_p, curvature / arc_ratio


@njit(nogil=True, error_model="numpy", inline="always")
def bound_width(springs: KernelSprings, k: int, i: int, offset: _CurveOffset, use_foot_point: bool) -> float:
    """Compute a lower bound of the width of a contact's gap [m]; 0 if the gap may be closed.

    `springs` are the contact springs, `k` and `i` the indices of crank angle and contact, and `offset` is the
    displacement of the contact point from `curve_offset`. If `use_foot_point` is true, the bound is valid for the gap
    that `gap_at` computes at the foot point.
    """
    q, p = offset.q, offset.p
    curvature, curvature_rate, trochoid = springs.curvature[k, i], springs.curvature_rate[k, i], springs.trochoid
    clearance, rotates = springs.clearance[i] - _EXPANSION.third_order * abs(p), springs.rotates[i]
    if clearance + q <= 0.0:
        return 0.0
    if rotates and (use_foot_point or not _is_expansion_valid(trochoid, curvature, curvature_rate, p)):
        curvature = _valley_curvature(trochoid)  # a circle of the largest curvature lies inside the profile
    if curvature > 0.0:
        return clearance + q
    normal_component, tangent_component, rim = 1.0 + curvature * q, curvature * p, 1.0 - curvature * clearance
    square = normal_component * normal_component + tangent_component * tangent_component
    return (math.sqrt(square) - rim) / curvature if square < rim * rim else 0.0
