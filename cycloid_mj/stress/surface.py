"""Integrals over the curved faces of a solid grid: tractions.

scikit-fem's own bases on facets invert the map of curved elements by a Newton iteration that need not converge; a face
of six nodes needs no inverse.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.packages import package
from cycloid_mj.types import Array, Integers, Mask

Indices = Integers

ORDER = 6
"""Polynomials that the quadrature integrates exactly on a flat face."""


@dataclass(frozen=True)
class Surface:
    """Some faces on the surface of a solid grid, with q quadrature points each.

    Attributes
    ----------
    nodes
        Nodes (f, 6) of each face: corners, then middles.
    shape
        Shape functions (q, 6) of these nodes at the quadrature points.
    points, normals
        Places (f, q, 3) [m] and unit normals (f, q, 3) out of the part.
    area
        Weights (f, q) [m2].
    unknowns
        Unknowns of the whole grid.
    """

    nodes: Indices
    shape: Array
    points: Array
    normals: Array
    area: Array
    unknowns: int


def surface(grid: Grid, test: Callable[[Array], Mask]) -> Surface:
    """Give the faces on the surface of a grid whose middles (3, f) [m] pass a test."""
    skfem, quadrature = package("skfem"), package("skfem.quadrature")
    mesh = grid.mesh
    faces = mesh.boundary_facets()
    faces = faces[test(mesh.doflocs[:, mesh.facets[:, faces]].mean(axis=1))]
    corners = mesh.facets[:, faces].T.astype(np.int64)
    nodes = np.hstack([corners, _middles(mesh, corners)])
    places = grid.points[nodes]
    (xi, eta), weight = quadrature.get_quadrature(skfem.refdom.RefTri, ORDER)
    along = np.einsum("qa,fax->fqx", _slope_xi(xi, eta), places)
    across = np.einsum("qa,fax->fqx", _slope_eta(xi, eta), places)
    normal = np.cross(along, across)
    inside = mesh.doflocs[:, mesh.t[:, mesh.f2t[0, faces]]].mean(axis=1).T
    outward = np.sign(np.sum(normal.mean(axis=1) * (places[:, :3].mean(axis=1) - inside), axis=1))
    size = np.linalg.norm(normal, axis=2)
    return Surface(
        nodes=nodes,
        shape=_shape(xi, eta),
        points=np.einsum("qa,fax->fqx", _shape(xi, eta), places),
        normals=normal * (outward[:, np.newaxis] / size)[..., np.newaxis],
        area=size * weight,
        unknowns=grid.unknowns,
    )


def traction_loads(face: Surface, traction: Array) -> Array:
    """Give the nodal forces (n,) [N] of a traction (f, q, 3) [Pa]."""
    forces = np.einsum("fq,qa,fqx->fax", face.area, face.shape, traction)
    rows = 3 * face.nodes[..., np.newaxis] + np.arange(3)
    return np.asarray(np.bincount(rows.ravel(), weights=forces.ravel(), minlength=face.unknowns), np.float64)


def _middles(mesh: Any, corners: Indices) -> Indices:
    """Nodes in the middle of the edges 01, 12, 02 of faces (f, 3)."""
    known = np.sort(mesh.edges, axis=0).astype(np.int64)
    key = known[0] * mesh.nvertices + known[1]
    order = np.argsort(key)
    ends = np.sort(np.stack([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [0, 2]]], axis=1), axis=2)
    wanted = ends[..., 0] * mesh.nvertices + ends[..., 1]
    return np.asarray(mesh.nvertices + order[np.searchsorted(key[order], wanted)], np.int64)


def _shape(xi: Array, eta: Array) -> Array:
    """Quadratic shape functions (q, 6) on the triangle of corners (0, 0), (1, 0), (0, 1)."""
    rest = 1 - xi - eta
    return np.stack(
        [rest * (2 * rest - 1), xi * (2 * xi - 1), eta * (2 * eta - 1), 4 * rest * xi, 4 * xi * eta, 4 * eta * rest],
        axis=1,
    )


def _slope_xi(xi: Array, eta: Array) -> Array:
    rest = 1 - xi - eta
    return np.stack([1 - 4 * rest, 4 * xi - 1, 0 * xi, 4 * (rest - xi), 4 * eta, -4 * eta], axis=1)


def _slope_eta(xi: Array, eta: Array) -> Array:
    rest = 1 - xi - eta
    return np.stack([1 - 4 * rest, 0 * xi, 4 * eta - 1, -4 * xi, 4 * xi, 4 * (rest - eta)], axis=1)
