"""Closed polygons in the plane: arcs and circles as polygons, area moments, edges that cross."""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

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
    polygon = np.frombuffer(vertices).reshape(-1, 2)
    x, y = polygon.T
    u, v = np.roll(polygon, -1, axis=0).T
    weights = [np.ones(len(x)), x + u, y + v, x * x + x * u + u * u, y * y + y * v + v * v]
    weights.append(2 * x * y + x * v + u * y + 2 * u * v)
    return AreaMoments(*(_sums((x * v - u * y) * np.array(weights)) / (2, 6, 6, 12, 12, 24)).tolist())


def signed_area(polygon: Array) -> float:
    """Compute the area [m2] of a polygon (n, 2) [m], exactly; negative for a clockwise polygon."""
    (x, y), (u, v) = polygon.T, np.roll(polygon, -1, axis=0).T
    return float(_sums((x * v - u * y)[np.newaxis])[0]) / 2


def arc(radius: float, start: float, end: float, chord_error: float) -> Array:
    """Compute points on an arc about the origin, including both ends.

    Parameters
    ----------
    radius
        Radius of the arc [m].
    start, end
        Polar angles from +x, counter-clockwise [rad].
    chord_error
        Largest distance of a chord from the arc (the sagitta) [m].
    """
    angle = np.linspace(start, end, _segments(radius, end - start, chord_error) + 1)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def circle(radius: float, chord_error: float, centre: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Compute a circle as a counter-clockwise polygon (n, 2) [m] with its vertices on the circle.

    Its area is smaller than that of the circle by the share 4/3 chord_error / radius (to first order).
    """
    return np.array(centre) + arc(radius, 0.0, 2 * math.pi, chord_error)[:-1]


def rotate_points(points: Array, angle: float) -> Array:
    """Rotate points (n, 2) counter-clockwise about the origin by an angle [rad]."""
    if not angle:
        return points
    cos, sin = math.cos(angle), math.sin(angle)
    return points @ np.array([[cos, sin], [-sin, cos]])


def rotate_clockwise(points: Array, angle: float) -> Array:
    """Rotate points (n, 2) clockwise about the origin by an angle [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    return points @ np.array([[cos, -sin], [sin, cos]])


def within(points: Array, loop: Array) -> Mask:
    """Return which points (n, 2) are inside a closed polygon (m, 2), by ray casting along x."""
    (ax, ay), (bx, by) = loop.T, np.roll(loop, -1, axis=0).T
    x, y = points[:, :1], points[:, 1:]
    across = (ay > y) != (by > y)
    crossing_x = ax + (y - ay) * (bx - ax) / np.where(by == ay, 1.0, by - ay)
    inside: Mask = (across & (x < crossing_x)).sum(axis=1) % 2 == 1
    return inside


def crossing(rings: Sequence[Array]) -> Array | None:
    """Compute a point (2,) [m] near which two edges of closed polygons touch or cross, or None.

    Consecutive edges share a vertex and are not tested. A sweep along x tests only pairs of edges with overlapping
    bounding boxes.
    """
    start = np.concatenate(rings)
    end = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    following = _following(rings)
    i, j = _overlapping_pairs(np.minimum(start, end), np.maximum(start, end))
    separate = (following[i] != j) & (following[j] != i)
    i, j = i[separate], j[separate]
    intersect = _sides_differ(start[i], end[i], start[j], end[j]) & _sides_differ(start[j], end[j], start[i], end[i])
    return (start[i[intersect][0]] + end[i[intersect][0]]) / 2 if intersect.any() else None


def _sums(values: Array) -> Array:
    """Sum each row of values (k, n) in about twice the working precision, by Knuth's two-sum."""
    left_out = np.zeros(len(values))
    while (half := values.shape[1] // 2) > 0:
        a, b, odd = values[:, :half], values[:, half : 2 * half], values[:, 2 * half :]
        total = a + b
        of_b = total - a
        left_out += np.sum((a - (total - of_b)) + (b - of_b), axis=1)
        values = np.concatenate([total, odd], axis=1)
    return values[:, 0] + left_out


def _segments(radius: float, span: float, chord_error: float) -> int:
    """Return the number of chords for a sagitta radius (1 - cos(step / 2)); at least 8 per turn."""
    step = 2 * math.acos(max(1.0 - chord_error / radius, math.cos(math.pi / 8)))
    return max(1, math.ceil(abs(span) / step))


def _following(rings: Sequence[Array]) -> npt.NDArray[np.intp]:
    """Return the index of the next edge of each edge, in the concatenation of the rings."""
    first = np.cumsum([0, *(len(ring) for ring in rings)])
    return np.concatenate(
        [start + np.roll(np.arange(len(ring)), -1) for start, ring in zip(first, rings, strict=False)]
    )


def _overlapping_pairs(low: Array, high: Array) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return index pairs (i, j) of boxes low..high (n, 2) that overlap or touch, each pair once."""
    order = np.argsort(low[:, 0])
    low, high = low[order], high[order]
    rank = np.arange(len(order))
    count = np.searchsorted(low[:, 0], high[:, 0], side="right") - rank - 1
    i = np.repeat(rank, count)
    j = i + 1 + np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    overlap = (low[i, 1] <= high[j, 1]) & (low[j, 1] <= high[i, 1])
    return order[i[overlap]], order[j[overlap]]


def _sides_differ(a: Array, b: Array, p: Array, q: Array) -> Mask:
    """Return for each row whether p and q are not strictly on one side of the line a b."""
    return _side(a, b, p) * _side(a, b, q) <= 0.0


def _side(a: Array, b: Array, p: Array) -> Array:
    along, to = b - a, p - a
    return np.sign(along[:, 0] * to[:, 1] - along[:, 1] * to[:, 0])
