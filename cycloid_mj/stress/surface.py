"""Integrals over the curved faces of a solid grid: tractions.

scikit-fem's own bases on facets invert the map of curved elements by a Newton iteration that need not converge; a face
of six nodes needs no inverse.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.stress.grid import Grid, find_edge_nodes
from cycloid_mj.stress.packages import import_package


@dataclass(frozen=True)
class SolidSurface:
    """Some faces on the surface of a solid grid, with q quadrature points each.

    Attributes
    ----------
    nodes
        Nodes (f, 6) of each face: corners, then middles.
    shape
        Shape functions (q, 6) of these nodes at the quadrature points.
    points, normals
        Positions (f, q, 3) [m] and outward unit normals (f, q, 3).
    area
        Weights (f, q) [m2].
    unknowns
        Number of unknowns of the grid.
    """

    nodes: Integers
    shape: Array
    points: Array
    normals: Array
    area: Array
    unknowns: int


def select_surface(grid: Grid, is_selected: Callable[[Array], Mask]) -> SolidSurface:
    """Return nodes, normals and quadrature points (order 6) of selected faces on the surface of a solid mesh.

    `is_selected` maps the centres (3, f) [m] of all f surface faces to a mask (f,): true for the faces to select.
    `grid` is the finite-element mesh.
    """
    skfem, quadrature = import_package("skfem"), import_package("skfem.quadrature")
    mesh = grid.mesh
    faces = mesh.boundary_facets()
    faces = faces[is_selected(mesh.doflocs[:, mesh.facets[:, faces]].mean(axis=1))]
    corners = mesh.facets[:, faces].T.astype(np.int64)
    nodes = np.hstack([corners, find_edge_nodes(mesh, corners[:, [[0, 1], [1, 2], [0, 2]]])])
    positions = grid.points[nodes]
    points, weight = quadrature.get_quadrature(skfem.refdom.RefTri, 6)  # exact on a flat face
    terms = [skfem.ElementTriP2().lbasis(points, shape_index) for shape_index in range(nodes.shape[1])]
    shape = np.stack([value for value, _ in terms], axis=1)
    first_edge, second_edge = (
        np.einsum("qa,fax->fqx", np.stack([slope[axis] for _, slope in terms], axis=1), positions) for axis in range(2)
    )
    normal = np.cross(first_edge, second_edge)
    cell_centres = mesh.doflocs[:, mesh.t[:, mesh.f2t[0, faces]]].mean(axis=1).T
    outward_sign = np.sign(np.sum(normal.mean(axis=1) * (positions[:, :3].mean(axis=1) - cell_centres), axis=1))
    normal_length = np.linalg.norm(normal, axis=2)
    return SolidSurface(
        nodes=nodes,
        shape=shape,
        points=np.einsum("qa,fax->fqx", shape, positions),
        normals=normal * (outward_sign[:, np.newaxis] / normal_length)[..., np.newaxis],
        area=normal_length * weight,
        unknowns=grid.unknowns,
    )


def traction_loads(face: SolidSurface, traction: Array) -> Array:
    """Compute the nodal forces (n,) [N] of a traction (f, q, 3) [Pa]."""
    forces = np.einsum("fq,qa,fqx->fax", face.area, face.shape, traction)
    rows = 3 * face.nodes[..., np.newaxis] + np.arange(3)
    return np.asarray(np.bincount(rows.ravel(), weights=forces.ravel(), minlength=face.unknowns), np.float64)
