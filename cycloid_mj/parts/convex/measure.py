"""Quality of the decomposition of a prism by CoACD, measured in three dimensions along the normals of its walls."""

import math

import numpy as np
from scipy.spatial import ConvexHull

from cycloid_mj.base.array import Array
from cycloid_mj.parts import Mesh, Prism
from cycloid_mj.parts.convex.quality import Quality, hull_body, summarize_quality, union_heights
from cycloid_mj.parts.convex.settings import METHOD
from cycloid_mj.parts.inertia import region_moments


def pieces_quality(region: Prism, pieces: tuple[Mesh, ...], points: Array, normals: Array) -> Quality:
    """Measure how far convex pieces of a prism protrude from its walls (overfill) or stay below them (underfill) [m].

    Deviations are measured along the wall normals at half the height of the prism; see `Quality` for their statistics,
    the number of pieces and the error of their volume.

    Parameters
    ----------
    region
        The true prism.
    pieces
        Its pieces.
    points, normals
        The k points (k, 2) [m] on its true walls, and unit normals out of the material.
    """
    mid_height = 0.5 * (region.z0 + region.z1)
    points_3d, normals_3d = np.insert(points, 2, mid_height, axis=1), np.insert(normals, 2, 0.0, axis=1)
    bodies = [hull_body(piece.vertices) for piece in pieces]
    union_ends = union_heights(
        points_3d,
        normals_3d,
        bodies,
        METHOD.depth,
        METHOD.reach,
        seam=METHOD.coacd_grid * float(np.ptp(region.outline)),
    )
    piece_volume = math.fsum(float(ConvexHull(piece.vertices).volume) for piece in pieces)
    true_volume = region_moments(region).area * region.height
    return summarize_quality(
        np.minimum(union_ends, free_distance(region, points, normals)), len(pieces), piece_volume / true_volume - 1.0
    )


def wall_samples(region: Prism) -> tuple[Array, Array]:
    """Compute k points on the walls of a prism, `region`, at most `METHOD.spacing` apart, and the normals there.

    The walls are those of outline and holes.

    Returns
    -------
    tuple of Array
        Points (k, 2) [m], and unit normals out of the material (k, 2).
    """
    points, normals = [], []
    for polygon in (region.outline, *(hole[::-1] for hole in region.holes)):
        edges = np.roll(polygon, -1, axis=0) - polygon
        for corner, edge, edge_length in zip(polygon, edges, np.linalg.norm(edges, axis=1), strict=True):
            count = math.ceil(edge_length / METHOD.spacing)
            points.append(corner + (np.arange(count)[:, np.newaxis] + 0.5) / count * edge)
            normals.append(np.tile([edge[1] / edge_length, -edge[0] / edge_length], (count, 1)))
    return np.concatenate(points), np.concatenate(normals)


def free_distance(region: Prism, points: Array, normals: Array) -> Array:
    """Compute the distance [m] from k points on the walls of a prism, along the normals, to the opposite wall, (k,).

    It is at most `METHOD.reach`, also where there is no opposite wall. `region` is the prism; `points` (k, 2) [m] are
    on its walls, and the unit `normals` (k, 2) point out of the material.
    """
    polygons = (region.outline, *region.holes)
    starts = np.concatenate(polygons)
    edges = np.concatenate([np.roll(polygon, -1, axis=0) - polygon for polygon in polygons])
    return np.array(
        [_first_crossing(starts - point, edges, normal) for point, normal in zip(points, normals, strict=True)]
    )


def _first_crossing(corners: Array, edges: Array, normal: Array) -> float:
    """Compute the distance [m] along a unit normal (2,) from the origin to the nearest edge, at most `METHOD.reach`.

    Edge i extends from `corners[i]` by the vector `edges[i]`; there are m edges, and both arrays have the shape (m, 2)
    [m]. Crossings nearer than `METHOD.depth` do not count.
    """
    determinant = normal[0] * edges[:, 1] - normal[1] * edges[:, 0]
    determinant = np.where(determinant == 0.0, np.inf, determinant)
    distance = (corners[:, 0] * edges[:, 1] - corners[:, 1] * edges[:, 0]) / determinant
    edge_position = (corners[:, 0] * normal[1] - corners[:, 1] * normal[0]) / determinant
    is_hit = (distance > METHOD.depth) & (edge_position >= 0.0) & (edge_position <= 1.0)
    return float(distance[is_hit].min(initial=METHOD.reach))
