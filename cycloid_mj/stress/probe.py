"""Fields of a planar grid at any points: which triangle each lies in, and its quadratic shape functions there."""

from typing import Any

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from cycloid_mj.stress.grid import Grid
from cycloid_mj.types import Array, Integers, Mask

Indices = Integers
Flags = Mask

NEIGHBOURS = 10
"""Triangles with the nearest middles that are searched."""

OUTSIDE = -0.02
"""A point with a smaller barycentric coordinate lies outside: a curved edge reaches beyond its chord by less."""


def probe(grid: Grid, points: Array) -> tuple[Any, Flags]:
    """Give the operator from nodal values (n,) to points (p, 2) [m], sparse (p, n), and which points lie in the part.

    The rows of points outside are zero.
    """
    cells, corners = grid.cells, grid.points[grid.cells[:, :3]]
    _, near = cKDTree(corners.mean(axis=1)).query(points, k=min(NEIGHBOURS, len(cells)))
    near = near.reshape(len(points), -1)
    shares = _barycentric(corners[near], points[:, np.newaxis])
    best = shares.min(axis=2).argmax(axis=1)
    rows = np.arange(len(points))
    share, cell = shares[rows, best], near[rows, best]
    inside = share.min(axis=1) > OUTSIDE
    shape = np.hstack([share * (2 * share - 1), 4 * share * np.roll(share, -1, axis=1)]) * inside[:, np.newaxis]
    ends = cells[cell]
    index = np.broadcast_to(rows[:, np.newaxis], ends.shape)
    operator = sparse.coo_matrix((shape.ravel(), (index.ravel(), ends.ravel())), shape=(len(points), len(grid.points)))
    return operator.tocsr(), inside


def _barycentric(corners: Array, points: Array) -> Array:
    """Barycentric coordinates (..., 3) of points (..., 2) in triangles (..., 3, 2)."""
    a, b, c = corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]
    first, second, to = b - a, c - a, points - a
    area = _cross(first, second)
    u, v = _cross(to, second) / area, _cross(first, to) / area
    return np.stack([1 - u - v, u, v], axis=-1)


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
