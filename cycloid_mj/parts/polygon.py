"""Closed polygons in the plane: arcs and circles as polygons, and their area moments."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Mask


class AreaMoments(NamedTuple):
    """Area A [m2] of a region, with the integrals of x, y [m3] and x2, y2, xy [m4] over it."""

    area: float
    x: float
    y: float
    xx: float
    yy: float
    xy: float


def area_moments(polygon: Array) -> AreaMoments:
    """Compute the area moments about the origin of a polygon (n, 2) [m], exactly.

    Green's theorem turns each integral over the region into a sum over the edges, which is exact in any order. A
    clockwise polygon has negative moments.
    """
    return _moments(np.asarray(polygon, float).tobytes())


@lru_cache(maxsize=64)  # designs that differ in a tolerance or a load share most of their outlines, of 0.2 MB each
def _moments(vertices: bytes) -> AreaMoments:
    """Compute the area and its first and second moments of a polygon by the shoelace formula.

    `vertices` are the bytes of an array of shape (n, 2), which can be a key of a cache.
    """
    polygon = np.frombuffer(vertices).reshape(-1, 2)
    x, y = polygon.T
    next_x, next_y = np.roll(polygon, -1, axis=0).T
    weights = [
        np.ones(len(x)),
        x + next_x,
        y + next_y,
        x * x + x * next_x + next_x * next_x,
        y * y + y * next_y + next_y * next_y,
    ]
    weights.append(2 * x * y + x * next_y + next_x * y + 2 * next_x * next_y)
    return AreaMoments(
        *(_accurate_sums((x * next_y - next_x * y) * np.array(weights)) / (2, 6, 6, 12, 12, 24)).tolist()
    )


def signed_area(polygon: Array) -> float:
    """Compute the area [m2] of a polygon (n, 2) [m], exactly; negative for a clockwise polygon."""
    (x, y), (next_x, next_y) = polygon.T, np.roll(polygon, -1, axis=0).T
    return float(_accurate_sums((x * next_y - next_x * y)[np.newaxis])[0]) / 2


def arc(radius: float, start: float, end: float, chord_error: float) -> Array:
    """Compute n points (n, 2) [m] on an arc of a `radius` [m] about the origin, including both ends.

    The ends are at the polar angles `start` and `end` [rad] from +x, counter-clockwise. Chords deviate from the arc by
    at most `chord_error` [m].
    """
    angles = np.linspace(start, end, _count_chords(radius, end - start, chord_error) + 1)
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


def circle(radius: float, chord_error: float, centre: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Compute a circle as a counter-clockwise polygon (n, 2) [m] with its vertices on the circle.

    Its area is smaller than that of the circle by the share 4/3 chord_error / radius (to first order).
    """
    return np.array(centre) + arc(radius, 0.0, 2 * math.pi, chord_error)[:-1]


def circle_area(radius: float, chord_error: float) -> float:
    """Compute the area of the polygon `circle` [m2], in closed form."""
    chords = _count_chords(radius, 2.0 * math.pi, chord_error)
    return 0.5 * chords * radius**2 * math.sin(2.0 * math.pi / chords)


def rotate_points(points: Array, angle: float) -> Array:
    """Rotate points (n, 2) counter-clockwise about the origin by an angle [rad]."""
    if not angle:
        return points
    cosine, sine = math.cos(angle), math.sin(angle)
    return points @ np.array([[cosine, sine], [-sine, cosine]])


def rotate_clockwise(points: Array, angle: float) -> Array:
    """Rotate points (n, 2) clockwise about the origin by an angle [rad]."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return points @ np.array([[cosine, -sine], [sine, cosine]])


def within(points: Array, loop: Array) -> Mask:
    """Return a mask of n points (n, 2): true inside a closed polygon, the `loop` of m points (m, 2), by ray casting."""
    (start_x, start_y), (end_x, end_y) = loop.T, np.roll(loop, -1, axis=0).T
    x, y = points[:, :1], points[:, 1:]
    crosses_level = (start_y > y) != (end_y > y)
    crossing_x = start_x + (y - start_y) * (end_x - start_x) / np.where(end_y == start_y, 1.0, end_y - start_y)
    is_inside: Mask = (crosses_level & (x < crossing_x)).sum(axis=1) % 2 == 1
    return is_inside


def _accurate_sums(values: Array) -> Array:
    """Compute the sums (k,) of the k rows of values (k, n) in about twice the working precision (Knuth's two-sum)."""
    rounding_error = np.zeros(len(values))
    while (half_count := values.shape[1] // 2) > 0:
        first_half, second_half, odd_column = (
            values[:, :half_count],
            values[:, half_count : 2 * half_count],
            values[:, 2 * half_count :],
        )
        rounded_sum = first_half + second_half
        rounded_second = rounded_sum - first_half
        rounding_error += np.sum((first_half - (rounded_sum - rounded_second)) + (second_half - rounded_second), axis=1)
        values = np.concatenate([rounded_sum, odd_column], axis=1)
    return values[:, 0] + rounding_error


def _count_chords(radius: float, span: float, chord_error: float) -> int:
    """Return the number of chords for a sagitta radius (1 - cos(step / 2)); at least 8 per turn."""
    max_step = 2 * math.acos(max(1.0 - chord_error / radius, math.cos(math.pi / 8)))
    return max(1, math.ceil(abs(span) / max_step))
