"""Values at the nodes from values at quadrature points: quadratic polynomials fitted round each vertex.

Zienkiewicz and Zhu 1992, superconvergent patch recovery: the stress of quadratic elements is better at their Gauss
points than anywhere else, and a polynomial through those of the elements round a vertex keeps that.
"""

from typing import Any

import numpy as np
from scipy import sparse

from cycloid_mj.stress.grid import Grid
from cycloid_mj.types import Array, Integers, Mask

Indices = Integers

RIDGE = 0.03
"""Weight on the quadratic terms, of monomials of size 1: it decides where a patch has few points, as at a surface."""


def nodal_fit(grid: Grid, points: Array) -> Any:
    """Give the operator, sparse (n, p), from quadrature points (p, d) [m], element by element, to nodes.

    A vertex has the value of its own polynomial, the middle of an edge the mean of those of its ends.
    """
    table, used = _points_round(grid, len(points))
    vertices = grid.mesh.nvertices
    places = grid.points[:vertices]
    apart = np.where(used[..., np.newaxis], points[table] - places[:, np.newaxis], 0.0)
    size = np.linalg.norm(apart, axis=2).max(axis=1)
    terms = _terms(apart / size[:, np.newaxis, np.newaxis]) * used[..., np.newaxis]
    ridge = np.diag((np.arange(terms.shape[2]) > grid.dimension) * RIDGE)
    fit = np.linalg.solve(terms.transpose(0, 2, 1) @ terms + ridge, terms.transpose(0, 2, 1))
    ends = np.asarray(grid.mesh.facets if grid.dimension == 2 else grid.mesh.edges)
    middles = vertices + np.arange(ends.shape[1])
    blocks = [(np.arange(vertices), np.arange(vertices), 1.0), *((middles, end, 0.5) for end in ends)]
    values, rows, columns = [], [], []
    for nodes, centres, share in blocks:
        at = _terms((grid.points[nodes] - places[centres]) / size[centres, np.newaxis])
        weights = share * np.einsum("nt,ntp->np", at, fit[centres])
        kept = used[centres]
        values.append(weights[kept])
        rows.append(np.broadcast_to(nodes[:, np.newaxis], kept.shape)[kept])
        columns.append(table[centres][kept])
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.coo_matrix(entries, shape=(len(grid.points), len(points))).tocsr()


def _points_round(grid: Grid, count: int) -> tuple[Indices, Mask]:
    """Give the quadrature points (v, w) of the elements round each vertex, padded, and which are no padding."""
    corners = grid.mesh.t.T
    each = count // len(corners)
    order = np.argsort(corners.ravel(), kind="stable")
    valence = np.bincount(corners.ravel(), minlength=grid.mesh.nvertices)
    slot = np.arange(corners.size) - np.repeat(np.cumsum(valence) - valence, valence)
    cells = np.full((grid.mesh.nvertices, valence.max()), -1, np.int64)
    cells[corners.ravel()[order], slot] = order // corners.shape[1]
    table = (each * cells[..., np.newaxis] + np.arange(each)).reshape(len(cells), -1)
    used = np.repeat(cells >= 0, each, axis=1)
    return np.where(used, table, 0), used


def _terms(x: Array) -> Array:
    """Monomials up to the second degree (..., 6 or 10) of places (..., d)."""
    i, j = np.triu_indices(x.shape[-1])
    return np.concatenate([np.ones((*x.shape[:-1], 1)), x, x[..., i] * x[..., j]], axis=-1)
