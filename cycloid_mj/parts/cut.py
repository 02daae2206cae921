"""Section of a prism by the plane x = 0 through the axis: rectangles along z."""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.parts.accuracy import SAME_LENGTH
from cycloid_mj.parts.prism import Prism


def cut_prism(prism: Prism, centre: tuple[float, float] = (0.0, 0.0)) -> list[tuple[float, float]]:
    """Cut a prism by the plane x = 0; return the intervals of y [m] inside its material: (start, end), in order.

    `centre` is the position (x, y) [m] of the prism's origin. The plane is shifted by `SAME_LENGTH`, so that a vertex
    or an edge on it counts once.
    """
    x, y = centre
    crossings = np.sort(
        np.concatenate([_crossings(polygon + np.array([x - SAME_LENGTH, y])) for polygon in _polygons(prism)])
    )
    return [(float(y_start), float(y_end)) for y_start, y_end in zip(crossings[::2], crossings[1::2], strict=True)]


def _polygons(prism: Prism) -> tuple[Array, ...]:
    return (prism.outline, *prism.holes)


def _crossings(polygon: Array) -> Array:
    """Compute y where the edges of a closed polygon (n, 2) cross x = 0."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    is_crossing = (start[:, 0] < 0.0) != (end[:, 0] < 0.0)
    (start_x, start_y), (end_x, end_y) = start[is_crossing].T, end[is_crossing].T
    return np.asarray(start_y - start_x * (end_y - start_y) / (end_x - start_x))
