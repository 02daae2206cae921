"""Gap of a pin near its place in the ideal mesh: a local expansion instead of a search.

In the ideal mesh a pin's centre stands on the trochoid T(t) = E u(t) - c u(N t) at t = home angle - gear turn, where
u(N t) is the same for all pins: N home angles make whole turns. A displaced pin lies micrometres from there: a
Newton step or two lead so near to its foot point that the osculating circle has its distance to rounding. Angles
and lengths as in ``gap``.
"""

import math
from typing import NamedTuple

from numba import njit

from cycloid_mj.dynamics.contact.gap import Flank, Trochoid, flank_distance, trochoid_curvature, trochoid_distance


class OsculatingCircleSettings(NamedTuple):
    """Settings of the local expansion: Newton steps to the foot point, the last by the osculating circle."""

    max_iterations: int = 6
    circle_angle: float = 3e-4
    """Angle [rad] of the curve between expansion point and foot below which the curve is its osculating circle: the
    error is a sixth of its square, as a share of their distance."""
    max_tangent_change: float = 0.3
    """Share by which the tangent may change on the way to the foot, and as far beyond it as that is from the point;
    up to this share twice the distance by which the curve leaves its tangent is an upper limit."""
    max_rotation: float = 0.02
    """Largest Newton step, times the number of teeth [rad]; beyond it the foot point is searched."""


SETTINGS = OsculatingCircleSettings()


class Start(NamedTuple):
    """Sine and cosine of t, and of N t, at a point of the trochoid near a foot; the first two 0 where none is known."""

    sin_t: float
    cos_t: float
    sin_nt: float
    cos_nt: float


@njit(inline="always")
def multiple_angle(sine: float, cosine: float, factor: int) -> tuple[float, float]:
    """Compute sine and cosine of `factor` times an angle, for an integer `factor`, by repeated doubling.

    `sine` and `cosine` are those of the angle.
    """
    multiple_sine, multiple_cosine = 0.0, 1.0
    while factor > 0:
        if factor & 1:
            multiple_sine, multiple_cosine = (
                multiple_sine * cosine + multiple_cosine * sine,
                multiple_cosine * cosine - multiple_sine * sine,
            )
        sine, cosine = 2.0 * sine * cosine, (cosine - sine) * (cosine + sine)
        factor >>= 1
    return multiple_sine, multiple_cosine


@njit(inline="always")
def _rotate_small(sine: float, cosine: float, angle: float) -> tuple[float, float]:
    """Compute sine and cosine of an angle increased by less than ``SETTINGS.max_rotation``."""
    square = angle * angle
    small_sine = angle * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0))))
    small_cosine = 1.0 - square * (0.5 - square * (1.0 / 24.0 - square * (1.0 / 720.0)))
    return sine * small_cosine + cosine * small_sine, cosine * small_cosine - sine * small_sine


@njit(inline="always")
def local_distance(
    x: float, y: float, curve: Trochoid, start: Start, max_distance: float
) -> tuple[float, float, float, float]:
    """Compute the signed distance of a point (x, y) [m] from a trochoid `curve`, from a start near its foot point.

    Returns distance [m], outward unit normal (x, y) and curvature [1/m] at the foot point. A distance that exceeds
    `max_distance` [m] may be returned as any larger value, with zeros for normal and curvature.
    """
    radius, eccentricity, teeth = curve
    sin_t, cos_t, sin_nt, cos_nt = start
    pitch_radius, pitch_rate = eccentricity * teeth, eccentricity * teeth * teeth
    for _ in range(SETTINGS.max_iterations):
        dx, dy = x - radius * sin_t + eccentricity * sin_nt, y - radius * cos_t + eccentricity * cos_nt
        tangent_x, tangent_y = radius * cos_t - pitch_radius * cos_nt, pitch_radius * sin_nt - radius * sin_t
        tangent_rate_x, tangent_rate_y = pitch_rate * sin_nt - radius * sin_t, pitch_rate * cos_nt - radius * cos_t
        squared_speed = tangent_x * tangent_x + tangent_y * tangent_y
        speed = math.sqrt(squared_speed)
        inverse_speed = 1.0 / speed
        offset = (dy * tangent_x - dx * tangent_y) * inverse_speed
        increment = (dx * tangent_x + dy * tangent_y) / squared_speed
        curvature_term = (tangent_rate_x * tangent_y - tangent_rate_y * tangent_x) * inverse_speed
        curvature = curvature_term / squared_speed
        radius_ratio = 1.0 + curvature * offset
        tangent_rate_norm = math.sqrt(tangent_rate_x * tangent_rate_x + tangent_rate_y * tangent_rate_y)
        # Sag below the tangent: curvature_term * increment^2 / 2, within pitch_rate * teeth * increment^3 / 6.
        max_sag = (abs(curvature_term) + pitch_rate * abs(teeth * increment)) * increment * increment
        if (
            offset - max_sag > max_distance
            and (abs(increment) + abs(offset) * inverse_speed) * tangent_rate_norm < SETTINGS.max_tangent_change * speed
        ):
            return offset, 0.0, 0.0, 0.0
        if abs(increment) * tangent_rate_norm < SETTINGS.circle_angle * speed and radius_ratio > 0.5:
            arc = increment * speed
            arc_angle = curvature * arc
            foot_norm = math.sqrt(radius_ratio * radius_ratio + arc_angle * arc_angle)
            distance = (2.0 * offset + curvature * (offset * offset + arc * arc)) / (foot_norm + 1.0)
            along_normal, along_tangent = (
                radius_ratio * inverse_speed / foot_norm,
                arc_angle * inverse_speed / foot_norm,
            )
            # cos B at the foot, B = (N - 1) t, to second order of the last increment.
            cosine = cos_nt * cos_t + sin_nt * sin_t - (teeth - 1.0) * increment * (sin_nt * cos_t - cos_nt * sin_t)
            product = radius * pitch_radius * cosine
            squared_pitch_distance = radius * radius + pitch_radius * pitch_radius - 2.0 * product
            foot_curvature = (radius * radius + pitch_radius * pitch_radius * teeth - (teeth + 1.0) * product) / (
                squared_pitch_distance * math.sqrt(squared_pitch_distance)
            )
            return (
                distance,
                along_tangent * tangent_x - along_normal * tangent_y,
                along_normal * tangent_x + along_tangent * tangent_y,
                foot_curvature,
            )
        increment /= max(radius_ratio, 0.5)
        if not abs(teeth * increment) < SETTINGS.max_rotation:
            break
        sin_t, cos_t = _rotate_small(sin_t, cos_t, increment)
        sin_nt, cos_nt = _rotate_small(sin_nt, cos_nt, teeth * increment)
    t, distance, nx, ny = trochoid_distance(x, y, curve)
    return distance, nx, ny, trochoid_curvature(t, curve)


@njit(inline="always")
def pin_distance(
    x: float, y: float, flank: Flank, start: Start, max_distance: float
) -> tuple[float, float, float, float]:
    """Compute the distance of a point (x, y) [m] from the flanks of a disc, from a start near the foot point.

    A full search, `flank_distance`, replaces `local_distance` if the flanks are rotated or have waves, or if there is
    no start (its `sin_t` and `cos_t` are 0). A distance that exceeds `max_distance` [m] may be returned as any larger
    value.

    Returns
    -------
    tuple of float
        Distance [m], unit normal (x, y) and curvature [1/m].
    """
    if flank.rotation == 0.0 and len(flank.waves) == 0 and (start.sin_t != 0.0 or start.cos_t != 0.0):
        return local_distance(x, y, flank.curve, start, max_distance)
    t, distance, nx, ny, _ = flank_distance(x, y, flank)
    return distance, nx, ny, trochoid_curvature(t, flank.curve)
