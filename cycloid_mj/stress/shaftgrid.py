"""The eccentric shaft as a solid body: a grid of tetrahedra by gmsh's OpenCASCADE."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts.crank import ShaftDimensions, shaft_measures
from cycloid_mj.reducer import Reducer
from cycloid_mj.stress.grid import Grid, GridSettings, quadratic
from cycloid_mj.stress.packages import mesher

CORNER_DISTANCE = 0.15
"""Distance from sharp inner corners that the bulk excludes, over the shaft's radius; real shafts have fillets."""


def shaft_grid(reducer: Reducer, settings: GridSettings) -> Grid:
    """Build the grid of the shaft in the frame of its solid: the reducer axis, cam towards +y."""
    shaft = shaft_measures(reducer)
    edge = settings.solid_edge * shaft.radius / settings.refinement
    return Grid(
        part="shaft",
        mesh=_tetrahedra(shaft, edge),
        thickness=1.0,
        loops=(),
        fixed_nodes=np.zeros(0, np.int64),
        bulk_distance=CORNER_DISTANCE * shaft.radius,
        corner_distance=CORNER_DISTANCE * shaft.radius,
        keep_off=_inner_corners(shaft),
    )


def _inner_corners(shaft: ShaftDimensions) -> Array:
    """List points along the sharp inner edges: both faces and the flats of the counterweight, and the cam's faces."""
    step = CORNER_DISTANCE * shaft.radius / 8
    turn = np.linspace(0, 2 * np.pi, int(np.ceil(2 * np.pi * shaft.radius / step)))
    x, y = shaft.radius * np.cos(turn), shaft.radius * np.sin(turn)
    z0, z1 = shaft.counterweight
    faces = [face for cam in shaft.cams for face in cam]
    solid = faces if shaft.straddles else faces[:-1]
    half = [(z0, y <= 0), (z1, y <= 0)] if shaft.weighted else []
    rings = [
        np.column_stack([x[keep], y[keep], np.full(keep.sum(), z)])
        for z, keep in (*half, *((z, y < np.inf) for z in solid))
    ]
    if not shaft.weighted:
        return np.concatenate(rings)
    z = np.linspace(z0, z1, int(np.ceil((z1 - z0) / step)) + 1)
    flats = [np.column_stack([np.full(len(z), side * shaft.radius), np.zeros(len(z)), z]) for side in (-1, 1)]
    return np.concatenate([*rings, *flats])


def _tetrahedra(shaft: ShaftDimensions, edge: float) -> Any:
    """Merge the shaft's cylinders with OpenCASCADE and mesh them with gmsh; edges are finer at the inner corners."""
    with mesher("shaft", edge) as gmsh:
        occ = gmsh.model.occ
        middle = (0.0, 0.0)
        first = _cylinder(occ, middle, shaft.radius, shaft.end, shaft.cams[0][0])
        joined = []
        if shaft.weighted:
            weight = _cylinder(occ, middle, shaft.counterweight_radius, *shaft.counterweight, angle=np.pi)
            occ.rotate([(3, weight)], 0, 0, 0, 0, 0, 1, np.pi)
            joined.append(weight)
        for centre, cam in zip(shaft.cam_centres.tolist(), shaft.cams, strict=True):
            joined.append(_cylinder(occ, centre, shaft.cam_radius, *cam))
        joined += [_cylinder(occ, middle, shaft.radius, item[1], two[0]) for item, two in pairwise(shaft.cams)]
        if shaft.straddles:
            joined.append(_cylinder(occ, middle, shaft.radius, shaft.cams[-1][1], shaft.far_end))
        solids, _ = occ.fuse([(3, first)], [(3, item) for item in joined])
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
    return _from_gmsh(tags, coordinates.reshape(-1, 3) / MILLIMETRES, nodes.reshape(-1, 10))


def _cylinder(occ: Any, centre: Sequence[float], radius: float, z0: float, z1: float, angle: float = 2 * np.pi) -> int:
    mm = MILLIMETRES
    x, y = centre
    return int(occ.addCylinder(x * mm, y * mm, z0 * mm, 0, 0, (z1 - z0) * mm, radius * mm, angle=angle))


def _refine_near(gmsh: Any, positions: Array, edge: float) -> None:
    """Set the size field: edges grow from a share of the longest near points to the longest at that distance."""
    field, longest = gmsh.model.mesh.field, edge * MILLIMETRES
    near = field.add("Distance")
    points = [gmsh.model.geo.addPoint(*position) for position in positions[::8] * MILLIMETRES]
    gmsh.model.geo.synchronize()
    field.setNumbers(near, "PointsList", points)
    grow = field.add("Threshold")
    for name, value in (
        ("InField", near),
        ("SizeMin", 1 / 3 * longest),
        ("SizeMax", longest),
        ("DistMin", 0.0),
        ("DistMax", 2 * longest),
    ):
        field.setNumber(grow, name, value)
    field.setAsBackgroundMesh(grow)


def _from_gmsh(tags: Any, points: Array, nodes: Any) -> Any:
    """Make the quadratic mesh from gmsh's tetrahedra of ten nodes."""
    position = np.zeros(int(tags.max()) + 1, np.int64)
    position[tags.astype(np.int64)] = np.arange(len(tags))
    cells = position[nodes.astype(np.int64)]
    corners, index = np.unique(cells[:, :4], return_inverse=True)
    cell = index.reshape(-1, 4)
    pairs = [(0, 1), (1, 2), (2, 0), (3, 0), (3, 2), (3, 1)]
    ends = np.concatenate([cell[:, list(pair)] for pair in pairs])
    mesh, _, _ = quadratic(points[corners], cell, ends, points[cells[:, 4:].T.ravel()], "shaft")
    return mesh
