"""Contact forces as elliptical pressure patches on the outlines of a planar grid.

A patch is a weighted set of points (Gauss-Chebyshev: exact for the ellipse) along the outline about its centre. Each
point is handed to the three nodes of its edge by their shape functions, which add up to one: the force is exact however
wide the edges are.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.spatial import cKDTree

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.loads import PartLoads


@dataclass(frozen=True)
class Patches:
    """Loads of all patches at k angles.

    Attributes
    ----------
    loads
        Sparse (n, k) [N].
    angle
        Index of the angle (p,) that each narrow patch belongs to.
    points
        Centres (p, 2) [m] of narrow patches.
    """

    loads: Any
    angle: Integers
    points: Array


@dataclass(frozen=True)
class _Edges:
    """The outlines edge by edge: nodes (e, 3) and their places (e, 3, 2), start and length along the outline [m] (e,).

    `start` runs on from outline to outline; `first`, `length_of_loop` (e,) are those of the edge's own outline.
    """

    nodes: Integers
    positions: Array
    start: Array
    length: Array
    first: Array
    length_of_loop: Array


def distribute_contacts(grid: Grid, loads: PartLoads) -> Patches:
    """Compute the nodal forces of the contacts of a part on its planar grid at k crank angles, as `Patches`.

    Each force is distributed as elliptical pressure over its patch, which covers at most half of its outline.

    Raises
    ------
    CycloidError
        The loads belong to another part, or a contact is not on the part's surface.
    """
    _require_match(grid, loads)
    edges = _collect_edges(grid)
    tree, tree_edge, tree_xi = _sample_edges(edges)
    magnitude = np.linalg.norm(loads.force, axis=2)
    is_active = np.isfinite(loads.position).all(axis=2) & (magnitude > 1e-12 * np.nanmax(magnitude, initial=0.0))
    rows, columns, values, patch_angles, patch_points = [], [], [], [], []
    for contact, name in enumerate(loads.labels):
        active_angles = np.flatnonzero(is_active[:, contact])
        if not len(active_angles):
            continue
        query: Any = tree.query(loads.position[active_angles, contact])
        distance, nearest = query
        if distance.max() > grid.bulk_distance:
            raise CycloidError(
                f"contact {name} of the {grid.part} lies {distance.max() * 1e3:.3g} mm off its surface, so the loads "
                "belong to another design: use the loads of this design"
            )
        edge = tree_edge[nearest]
        centre = _nearest_arc(edges, edge, tree_xi[nearest], loads.position[active_angles, contact])
        # a nearly conformal patch covers at most half of the outline
        half_width = np.minimum(loads.half_width[active_angles, contact], 0.25 * edges.length_of_loop[edge])
        nodes, forces = _distribute_pressure(edges, edge, centre, half_width, loads.force[active_angles, contact])
        rows.append(2 * nodes[..., np.newaxis] + np.arange(2))
        columns.append(np.broadcast_to(active_angles[:, np.newaxis, np.newaxis, np.newaxis], rows[-1].shape))
        values.append(forces)
        is_narrow = loads.narrow[active_angles, contact]
        patch_angles.append(active_angles[is_narrow])
        patch_points.append(loads.position[active_angles, contact][is_narrow])
    flat_arrays = [
        np.concatenate([block.ravel() for block in blocks] or [np.zeros(0)]) for blocks in (values, rows, columns)
    ]
    shape = (grid.unknowns, len(loads.angle))
    matrix = sparse.csc_matrix(
        (flat_arrays[0], (flat_arrays[1].astype(np.int64), flat_arrays[2].astype(np.int64))), shape=shape
    )
    return Patches(
        loads=matrix,
        angle=np.concatenate([np.zeros(0, np.int64), *patch_angles]),
        points=np.concatenate([np.zeros((0, 2)), *patch_points]),
    )


def _distribute_pressure(
    edges: _Edges, edge: Integers, centre: Array, half_width: Array, force: Array
) -> tuple[Integers, Array]:
    """Distribute forces as elliptical pressure over patches, by Gauss-Chebyshev quadrature at q points of each patch.

    The direction of the pressure rotates along the patch with the normal of the outline, as in a bearing; on a narrow
    patch it is practically that of the force. Plane vectors are represented by complex numbers in this function.

    Parameters
    ----------
    edges
        Edges of all outlines with contacts.
    edge, centre, half_width
        Index of the edge, arc length of the centre [m] and half width [m] of each patch, (a,).
    force
        Force on each patch, (a, 2) [N].

    Returns
    -------
    nodes, forces
        Nodes (a, q, 3) of the edges under the q points of each patch, and forces on them (a, q, 3, 2) [N].
    """
    shortest_edge = float(np.min(edges.length[edge]))
    point_count = 8 + 4 * int(np.ceil(half_width.max() / shortest_edge))
    quadrature_angle = np.arange(1, point_count + 1) * np.pi / (point_count + 1)
    weight = 2 / (point_count + 1) * np.sin(quadrature_angle) ** 2
    loop_start, loop_length = edges.first[edge][:, np.newaxis], edges.length_of_loop[edge][:, np.newaxis]
    arc = loop_start + np.mod(
        centre[:, np.newaxis] + half_width[:, np.newaxis] * np.cos(quadrature_angle) - loop_start, loop_length
    )
    edge_at_arc = np.searchsorted(edges.start, arc, side="right") - 1
    xi = (arc - edges.start[edge_at_arc]) / edges.length[edge_at_arc]
    shape_values, shape_slopes = _shape(xi), _slope(xi)
    tangent = _complex(np.einsum("aqi,aqix->aqx", shape_slopes, edges.positions[edge_at_arc]))
    centre_tangent = _unit_tangent(edges, edge, centre)
    relative_direction = tangent / np.abs(tangent) * np.conj(centre_tangent)[:, np.newaxis]
    resultant = relative_direction @ weight
    pressure = weight * relative_direction * (_complex(force) / resultant)[:, np.newaxis]
    point_force = np.stack([pressure.real, pressure.imag], axis=-1)
    return edges.nodes[edge_at_arc], shape_values[..., np.newaxis] * point_force[:, :, np.newaxis, :]


def _unit_tangent(edges: _Edges, edge: Integers, centre: Array) -> npt.NDArray[np.complex128]:
    """Compute the unit tangent of the outline at an arc length [m] of an edge, as a complex number, shape (a,)."""
    xi = (centre - edges.start[edge]) / edges.length[edge]
    tangent = _complex(np.einsum("ai,aix->ax", _slope(xi), edges.positions[edge]))
    return tangent / np.abs(tangent)


def _nearest_arc(edges: _Edges, edge: Integers, xi: Array, position: Array) -> Array:
    """Compute the arc length [m] (a,) along the outline of the point nearest to each `position` (a, 2) [m].

    `edges` are those of all outlines, `edge` and `xi` (a,) are the index of the edge on which the nearest sample of the
    outline is, and the sample's parameter on this edge. The outline is replaced by its tangent at this sample.
    """
    sample_position = np.einsum("ai,aix->ax", _shape(xi), edges.positions[edge])
    tangent = np.einsum("ai,aix->ax", _slope(xi), edges.positions[edge])
    xi_step = np.sum((position - sample_position) * tangent, axis=1) / np.sum(tangent**2, axis=1)
    return edges.start[edge] + edges.length[edge] * np.clip(xi + xi_step, 0.0, 1.0)


def _collect_edges(grid: Grid) -> _Edges:
    """Return nodes, positions [m] and arc lengths [m] of the element edges of `grid` along outlines with contacts."""
    nodes = np.concatenate(grid.loops)
    positions = grid.points[nodes]
    gauss_point, weight = np.polynomial.legendre.leggauss(4)
    arc_rate = np.linalg.norm(np.einsum("gi,eix->egx", _slope((gauss_point + 1) / 2), positions), axis=2)
    length = arc_rate @ weight / 2
    start = np.concatenate([[0.0], np.cumsum(length)[:-1]])
    counts = [len(loop) for loop in grid.loops]
    first_edges = np.cumsum([0, *counts[:-1]])
    loop_lengths = np.add.reduceat(length, first_edges)
    return _Edges(
        nodes, positions, start, length, np.repeat(start[first_edges], counts), np.repeat(loop_lengths, counts)
    )


def _sample_edges(edges: _Edges) -> tuple[cKDTree, Integers, Array]:
    """Return a tree of points along all edges, with the edge and the parameter of each."""
    xi = (np.arange(8) + 0.5) / 8
    points = np.einsum("si,eix->esx", _shape(xi), edges.positions).reshape(-1, 2)
    return cKDTree(points), np.repeat(np.arange(len(edges.nodes)), xi.size), np.tile(xi, len(edges.nodes))


def _shape(xi: Array) -> Array:
    """Compute quadratic shape functions (..., 3) of start, middle and end at the parameter xi of an edge, 0 to 1."""
    return np.stack([(1 - xi) * (1 - 2 * xi), 4 * xi * (1 - xi), xi * (2 * xi - 1)], axis=-1)


def _slope(xi: Array) -> Array:
    return np.stack([4 * xi - 3, 4 - 8 * xi, 4 * xi - 1], axis=-1)


def _complex(vectors: Array) -> npt.NDArray[np.complex128]:
    return vectors[..., 0] + 1j * vectors[..., 1]


def _require_match(grid: Grid, loads: PartLoads) -> None:
    if loads.part != grid.part:
        raise CycloidError(
            f"the loads act on the {loads.part}, but the mesh is that of the {grid.part}: use the loads and the "
            "mesh of the same part"
        )
