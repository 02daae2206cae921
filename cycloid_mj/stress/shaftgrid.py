"""The eccentric shaft as a solid body: a grid of tetrahedra by gmsh's OpenCASCADE."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts.crank import ShaftDimensions, shaft_dimensions
from cycloid_mj.reducer import Reducer
from cycloid_mj.stress.grid import Grid, GridSettings, quadratic_mesh
from cycloid_mj.stress.packages import open_mesher

CORNER_DISTANCE = 0.15
"""Distance from sharp inner corners that the bulk excludes, over the shaft's radius (heuristic); real shafts have
fillets."""


def shaft_grid(reducer: Reducer, settings: GridSettings) -> Grid:
    """Mesh the shaft by solid finite elements (quadratic tetrahedra), in the frame of its solid.

    `settings` are the edge lengths. The origin is on the reducer's axis, and the first cam is offset towards +y.
    """
    shaft = shaft_dimensions(reducer)
    longest_edge = settings.solid_edge * shaft.radius / settings.refinement
    return Grid(
        part="shaft",
        mesh=_mesh_shaft(shaft, longest_edge),
        thickness=1.0,
        loops=(),
        fixed_nodes=np.zeros(0, np.int64),
        bulk_distance=CORNER_DISTANCE * shaft.radius,
        corner_distance=CORNER_DISTANCE * shaft.radius,
        singular_points=_inner_corners(shaft),
    )


def _inner_corners(shaft: ShaftDimensions) -> Array:
    """Return n points (n, 3) [m] along the sharp inner edges of a shaft, where its mesh cannot resolve the stress.

    The edges are at the faces of the cams, and at both faces and the flats of the counterweight.
    """
    spacing = CORNER_DISTANCE * shaft.radius / 8
    angles = np.linspace(0, 2 * np.pi, int(np.ceil(2 * np.pi * shaft.radius / spacing)))
    x, y = shaft.radius * np.cos(angles), shaft.radius * np.sin(angles)
    z0, z1 = shaft.counterweight
    faces = [face for cam_faces in shaft.cams for face in cam_faces]
    full_circles = faces if shaft.straddles else faces[:-1]
    half_circles = [(z0, y <= 0), (z1, y <= 0)] if shaft.weighted else []
    circle_points = [
        np.column_stack([x[is_edge], y[is_edge], np.full(is_edge.sum(), z)])
        for z, is_edge in (*half_circles, *((z, y < np.inf) for z in full_circles))
    ]
    if not shaft.weighted:
        return np.concatenate(circle_points)
    z = np.linspace(z0, z1, int(np.ceil((z1 - z0) / spacing)) + 1)
    flat_points = [np.column_stack([np.full(len(z), side * shaft.radius), np.zeros(len(z)), z]) for side in (-1, 1)]
    return np.concatenate([*circle_points, *flat_points])


def _mesh_shaft(shaft: ShaftDimensions, edge: float) -> Any:
    """Mesh the shaft by gmsh; return a scikit-fem mesh of quadratic tetrahedra [m].

    Its cylinders are merged to one solid; raise CycloidError if they do not touch. `edge` is the longest edge [m];
    edges are shorter near the inner corners.
    """
    with open_mesher("shaft", edge) as gmsh:
        occ = gmsh.model.occ
        axis = (0.0, 0.0)
        journal = _cylinder(occ, axis, shaft.radius, shaft.end, shaft.cams[0][0])
        sections = []
        if shaft.weighted:
            counterweight = _cylinder(occ, axis, shaft.counterweight_radius, *shaft.counterweight, angle=np.pi)
            occ.rotate([(3, counterweight)], 0, 0, 0, 0, 0, 1, np.pi)
            sections.append(counterweight)
        for centre, cam_faces in zip(shaft.cam_centres.tolist(), shaft.cams, strict=True):
            sections.append(_cylinder(occ, centre, shaft.cam_radius, *cam_faces))
        sections += [
            _cylinder(occ, axis, shaft.radius, previous_cam[1], next_cam[0])
            for previous_cam, next_cam in pairwise(shaft.cams)
        ]
        if shaft.straddles:
            sections.append(_cylinder(occ, axis, shaft.radius, shaft.cams[-1][1], shaft.far_end))
        solids, _ = occ.fuse([(3, journal)], [(3, section) for section in sections])
        if shaft.bore_radius:
            bore_cylinder = _cylinder(occ, axis, shaft.bore_radius, shaft.end, shaft.far_end)
            solids, _ = occ.cut(solids, [(3, bore_cylinder)])
        occ.synchronize()
        if len(solids) != 1:
            raise CycloidError(
                "cannot generate a finite-element mesh of the shaft: its sections do not form one solid. Change the "
                "dimensions that define it (shaft.* in the design)"
            )
        _refine_near(gmsh, _inner_corners(shaft), edge)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, nodes = gmsh.model.mesh.getElementsByType(11)
    return _convert_mesh(tags, coordinates.reshape(-1, 3) / MILLIMETRES, nodes.reshape(-1, 10))


def _cylinder(occ: Any, centre: Sequence[float], radius: float, z0: float, z1: float, angle: float = 2 * np.pi) -> int:
    mm = MILLIMETRES
    x, y = centre
    return int(occ.addCylinder(x * mm, y * mm, z0 * mm, 0, 0, (z1 - z0) * mm, radius * mm, angle=angle))


def _refine_near(gmsh: Any, positions: Array, edge: float) -> None:
    """Set gmsh's target edge length near n `positions` (n, 3) [m].

    It is a third of `edge` [m] at the positions, and rises to `edge` at a distance of 2 `edge`. Only every eighth
    position is used.
    """
    field, longest_edge = gmsh.model.mesh.field, edge * MILLIMETRES
    distance = field.add("Distance")
    points = [gmsh.model.geo.addPoint(*position) for position in positions[::8] * MILLIMETRES]
    gmsh.model.geo.synchronize()
    field.setNumbers(distance, "PointsList", points)
    threshold = field.add("Threshold")
    for name, setting in (
        ("InField", distance),
        ("SizeMin", 1 / 3 * longest_edge),
        ("SizeMax", longest_edge),
        ("DistMin", 0.0),
        ("DistMax", 2 * longest_edge),
    ):
        field.setNumber(threshold, name, setting)
    field.setAsBackgroundMesh(threshold)


def _convert_mesh(tags: Any, points: Array, nodes: Any) -> Any:
    """Return a quadratic scikit-fem mesh of gmsh's tetrahedra of ten nodes.

    `tags` (p,) are gmsh's numbers of the p `points` (p, 3) [m]. `nodes` (m, 10) are the numbers of the ten nodes of
    each of m tetrahedra.
    """
    node_index = np.zeros(int(tags.max()) + 1, np.int64)
    node_index[tags.astype(np.int64)] = np.arange(len(tags))
    cells = node_index[nodes.astype(np.int64)]
    corners, index = np.unique(cells[:, :4], return_inverse=True)
    cell_corners = index.reshape(-1, 4)
    pairs = [(0, 1), (1, 2), (2, 0), (3, 0), (3, 2), (3, 1)]
    edge_ends = np.concatenate([cell_corners[:, list(pair)] for pair in pairs])
    mesh, _, _ = quadratic_mesh(points[corners], cell_corners, edge_ends, points[cells[:, 4:].T.ravel()], "shaft")
    return mesh
