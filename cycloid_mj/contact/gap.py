"""Exact gaps between conjugate surfaces: a pin against the cycloid gear, a circle inside a circle.

Compiled by numba, so that the collider and the tests call the same functions. Angles are clockwise from +y as in
the paper's geometry (Hsieh 2014, Eqs 2-7); lengths in metres.
"""

import math

from numba import njit

MAX_ROUNDS = 30
CONVERGED = 1e-13
_SCAN = 64


@njit(cache=True, inline="always")
def trochoid_start(x: float, y: float, radius: float, eccentricity: float, teeth: float) -> float:
    """Give the parameter of the trochoid point that lies nearest to (x, y) in distance from the gear centre.

    On T(t), r^2 = E^2 + c^2 - 2 E c cos((N-1) t), and the polar angle is t - atan2(c sin, E - c cos) of that phase.
    Both invert in closed form; the sign of the phase is that of (N-1) times the polar angle.
    """
    polar = math.atan2(x, y)
    cosine = (radius * radius + eccentricity * eccentricity - x * x - y * y) / (2.0 * radius * eccentricity)
    cosine = min(1.0, max(-1.0, cosine))
    sine = math.copysign(math.sqrt(1.0 - cosine * cosine), math.sin((teeth - 1.0) * polar))
    return polar + math.atan2(eccentricity * sine, radius - eccentricity * cosine)


@njit(cache=True)
def trochoid_foot(
    x: float, y: float, radius: float, eccentricity: float, teeth: float, start: float
) -> tuple[float, float, float, float, bool]:
    """Solve for the foot point of (x, y) on T(t) = E u(t) - c u(N t) by Newton's method.

    Returns
    -------
    t
        Parameter of the foot point [rad].
    distance
        Signed distance from the trochoid [m], positive outside.
    normal_x, normal_y
        Outward unit normal at the foot point.
    converged
        Whether the last step was below ``CONVERGED`` radians.
    """
    t = start
    converged = False
    for _ in range(MAX_ROUNDS):
        st, ct = math.sin(t), math.cos(t)
        sn, cn = math.sin(teeth * t), math.cos(teeth * t)
        dx = radius * st - eccentricity * sn - x
        dy = radius * ct - eccentricity * cn - y
        tx = radius * ct - eccentricity * teeth * cn
        ty = -radius * st + eccentricity * teeth * sn
        ax = -radius * st + eccentricity * teeth * teeth * sn
        ay = -radius * ct + eccentricity * teeth * teeth * cn
        slope = dx * tx + dy * ty
        curvature = tx * tx + ty * ty + dx * ax + dy * ay
        speed2 = tx * tx + ty * ty
        # Gauss-Newton where the point is beyond a centre of curvature: always a descent direction.
        step = slope / curvature if curvature > 0.1 * speed2 else slope / speed2
        limit = 0.5 / teeth
        t -= min(limit, max(-limit, step))
        if abs(step) < CONVERGED:
            converged = True
            break
    # The last step moved t by less than 1e-13 rad: the sines of that round serve.
    speed = math.sqrt(speed2)
    nx, ny = -ty / speed, tx / speed
    return t, -(dx * nx + dy * ny), nx, ny, converged


@njit(cache=True)
def trochoid_distance(
    x: float, y: float, radius: float, eccentricity: float, teeth: float
) -> tuple[float, float, float, float]:
    """Give the foot parameter, the signed distance and the outward normal of any point near the trochoid.

    Starts in closed form; a point far from the curve, where that may lead to another foot, is searched.
    """
    start = trochoid_start(x, y, radius, eccentricity, teeth)
    t, distance, nx, ny, converged = trochoid_foot(x, y, radius, eccentricity, teeth, start)
    if converged and abs(distance) < 0.1 * eccentricity:
        return t, distance, nx, ny
    pitch = 2.0 * math.pi / (teeth - 1.0)
    best, nearest = start, math.inf
    for k in range(_SCAN):
        candidate = start + pitch * (k / _SCAN - 0.5) * 2.0
        ex = radius * math.sin(candidate) - eccentricity * math.sin(teeth * candidate) - x
        ey = radius * math.cos(candidate) - eccentricity * math.cos(teeth * candidate) - y
        if ex * ex + ey * ey < nearest:
            best, nearest = candidate, ex * ex + ey * ey
    t, distance, nx, ny, converged = trochoid_foot(x, y, radius, eccentricity, teeth, best)
    return t, distance, nx, ny


@njit(cache=True, inline="always")
def trochoid_curvature(t: float, radius: float, eccentricity: float, teeth: float) -> float:
    """Give the signed curvature of the trochoid [1/m], positive where it is convex.

    From l^2 = E^2 + c^2 N^2 - 2 E c N cos B: kappa = (E^2 + c^2 N^3 - E c N (N+1) cos B) / l^3 with B = (N-1) t.
    """
    base = eccentricity * teeth
    product = radius * base * math.cos((teeth - 1.0) * t)
    l2 = radius * radius + base * base - 2.0 * product
    return (radius * radius + base * base * teeth - (teeth + 1.0) * product) / (l2 * math.sqrt(l2))


@njit(cache=True, inline="always")
def circle_in_circle(dx: float, dy: float, inner: float, outer: float) -> tuple[float, float, float]:
    """Give gap [m] and unit normal from inner to outer circle; (dx, dy) leads from outer to inner centre."""
    distance = math.sqrt(dx * dx + dy * dy)
    if distance == 0.0:
        return outer - inner, 0.0, 1.0
    return outer - inner - distance, dx / distance, dy / distance
