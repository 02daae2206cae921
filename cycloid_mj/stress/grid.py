"""Grids of quadratic elements: what a grid is, how fine, and triangles on any planar region."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse import csgraph

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.stress.outline import QuadraticOutline, Sizing, divide
from cycloid_mj.stress.packages import mesher, package
from cycloid_mj.stress.region import Region

BULK_DISTANCE = 0.5
"""Where bulk begins: so far from every loaded patch, as a share of the ring's pin radius. The one definition."""

CLAMPED = 0.25
"""Edges of outlines at a clamped circle over its radius, however coarse the grid: a longer arc would cut into it."""

SHORTER = 0.5
"""Edges of an outline where a curved one folded an element, over that element's longest."""

MENDED = 4
"""Times that a grid is made anew so."""

DEPTH_GROWTH = 0.6
"""How fast edges grow inwards on the whole, per length: slowly at first, within the bulk distance, then faster."""


class FoldedError(CycloidError):
    """Elements are turned inside out by curved edges: `places` (k, d + 1) [m], their middles and longest edges."""

    def __init__(self, part: str, corners: Array) -> None:
        super().__init__(f"the {part} does not mesh: a curved edge folds its element; raise the refinement")
        edges = np.linalg.norm(corners[:, :, np.newaxis] - corners[:, np.newaxis], axis=-1)
        self.places: Array = np.column_stack([corners.mean(axis=1), edges.max(axis=(1, 2))])


@dataclass(frozen=True)
class GridSettings:
    """How fine a grid is. Lengths are shares of the ring's pin radius.

    `refinement` divides all of them but `bulk_distance`, which must not change in a refinement study.

    Attributes
    ----------
    refinement
        One number for a refinement study.
    contact_edge, wide_edge, free_edge, inner_edge
        Edges of outlines that other parts touch along lines, or widely (the bore), of other outlines, and the longest
        inside.
    turn
        Longest edge as a share of the radius of curvature.
    growth
        How edges grow inwards, as a power of the depth: the smaller it is, the slower at first.
    solid_edge
        Longest edge of the tetrahedra of the shaft, as a share of its own radius.
    layer_edge
        Highest layer of the other parts as solids.
    bulk_distance
        Distance from loaded patches beyond which stress counts as bulk.
    solid
        Whether parts other than the shaft, which always is, are solid bodies too, on coarser sections.
    """

    refinement: float = 1.0
    contact_edge: float = 0.07
    wide_edge: float = 0.2
    free_edge: float = 0.6
    inner_edge: float = 0.6
    turn: float = 0.5
    growth: float = 0.25
    solid_edge: float = 0.4
    layer_edge: float = 2.3
    bulk_distance: float = BULK_DISTANCE
    solid: bool = False

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if name != "solid" and not value > 0.0:
                raise UsageError(f"the grid's {name} is {value}; it must be positive, e.g. 1")


@dataclass(frozen=True)
class Grid:
    """A part as quadratic elements.

    Attributes
    ----------
    part
        Its name.
    mesh
        The scikit-fem mesh. Its nodes (`points`) are the vertices, then the middles of the edges.
    thickness
        Thickness of a planar part [m]; 1 for a solid one.
    loops
        The outlines that other parts touch, each (e, 3): start, middle and end node of every edge, in order.
    held
        Nodes that do not move; empty for a free part.
    bulk_distance
        Distance from loaded patches beyond which stress counts as bulk [m].
    keep_off, corner_distance
        Points (n, d) [m] on sharp inner corners without their fillets, and how far the bulk always keeps off them [m].
    section
        Of a solid that is drawn out along z: its planar grid, which contact forces act on; None of others.
    """

    part: str
    mesh: Any
    thickness: float
    loops: tuple[Integers, ...]
    held: Integers
    bulk_distance: float
    keep_off: Array
    corner_distance: float = 0.0
    section: "SectionGrid | None" = None

    @property
    def points(self) -> Array:
        """Nodes (n, d) [m]."""
        return np.asarray(self.mesh.doflocs.T)

    @property
    def dimension(self) -> int:
        """2 for a planar part, 3 for a solid one."""
        return int(self.mesh.dim())

    @property
    def cells(self) -> Integers:
        """Nodes (m, 6) of each triangle, or (m, 10) of each tetrahedron: corners, then middles."""
        middles = self.mesh.t2f if self.dimension == 2 else self.mesh.t2e
        return np.vstack([self.mesh.t, self.mesh.nvertices + middles]).T.astype(np.int64)

    @property
    def unknowns(self) -> int:
        """Displacements of all nodes."""
        return int(self.mesh.doflocs.size)


@dataclass(frozen=True)
class SectionGrid:
    """The planar grid that a solid grid is drawn out from.

    Attributes
    ----------
    grid
        The planar grid, of n2 nodes.
    nodes
        The solid's node over each node of the section (h, n2) at the heights where contact forces act; -1 for none.
    lifts
        Each hands loads on the section (2 n2,) on to the solid's unknowns, sparse (n, 2 n2): those of one disc, in its
        plane. Of a part that belongs to a disc there is one.
    """

    grid: Grid
    nodes: Integers
    lifts: tuple[Any, ...]


def planar_grid(
    region: Region, settings: GridSettings, length: float, focus: npt.ArrayLike | None = None, section: bool = False
) -> Grid:
    """Build the grid of any planar region; the lengths of the settings are shares of ``length`` [m].

    Where an outline's curved edges fold elements beside them, they are made shorter. A section, to be drawn out along
    z, keeps the mesher's order of vertices, by which its prisms are cut.

    Raises
    ------
    CycloidError
        The region does not mesh, or a package of the extra ``fem`` is missing.
    """
    places = np.zeros((0, 3)) if focus is None else np.asarray(focus, float).reshape(-1, 3)
    places = np.concatenate([places, _clamped(region)])
    for _ in range(MENDED):
        try:
            return _planar_grid(region, settings, length, places, section)
        except FoldedError as folded:
            places = np.concatenate([places, folded.places * (1.0, 1.0, SHORTER)])
    return _planar_grid(region, settings, length, places, section)


def _planar_grid(region: Region, settings: GridSettings, length: float, places: Array, section: bool) -> Grid:
    """Build a grid with short edges of outlines at some places, rows (x, y, edge) [m]."""
    unit = length / settings.refinement
    loops = []
    for boundary in region.boundaries:
        edge = (
            unit * {"line": settings.contact_edge, "wide": settings.wide_edge, "": settings.free_edge}[boundary.touched]
        )
        loops.append(divide(boundary.polygon, Sizing(edge, settings.turn / settings.refinement, edge / 10, places)))
    points, triangles = _triangulated(region, loops, unit * settings.inner_edge, settings.growth)
    first = np.cumsum([0, *(len(loop.nodes) for loop in loops)])
    rings = [start + np.arange(len(loop.nodes)) for start, loop in zip(first, loops, strict=False)]
    ends = np.concatenate([np.column_stack([ring, np.roll(ring, -1)]) for ring in rings])
    middles = np.concatenate([loop.middles for loop in loops])
    mesh, vertex, middle = quadratic(points, triangles, ends, middles, region.part, section)
    tables = [np.column_stack([vertex[ring], middle[ring], vertex[np.roll(ring, -1)]]) for ring in rings]
    pairs = list(zip(region.boundaries, tables, strict=True))
    clamped = [table[:, :2].ravel() for boundary, table in pairs if boundary.held]
    return Grid(
        part=region.part,
        mesh=mesh,
        thickness=region.thickness,
        loops=tuple(table for boundary, table in pairs if boundary.touched),
        held=np.unique(np.concatenate([np.zeros(0, np.int64), *clamped])),
        bulk_distance=settings.bulk_distance * length,
        keep_off=np.zeros((0, 2)),
    )


def _clamped(region: Region) -> Array:
    """Compute the middles of clamped circles within a region and the edge length there, rows (x, y, edge) [m]."""
    circles = [each.polygon for each in region.boundaries if each.held and each.role == "inset"]
    rows = [(*circle.mean(axis=0), CLAMPED * float(np.ptp(circle[:, 0])) / 2.0) for circle in circles]
    return np.array(rows).reshape(-1, 3)


def quadratic(
    points: Array, cells: Integers, ends: Integers, middles: Array, part: str, in_order: bool = False
) -> tuple[Any, Integers, Integers]:
    """Make a quadratic scikit-fem mesh whose edges ``ends`` (e, 2) pass through ``middles`` (e, d) [m].

    Return the mesh, the node at each of the points, and that in the middle of each of these edges. Unless the points
    are to keep their order, they are numbered such that neighbours are near each other.

    Raises
    ------
    FoldedError
        Elements are turned inside out by their curved edges: the grid is too coarse there.
    CycloidError
        An edge of the outline is missing.
    """
    skfem = package("skfem")
    planar = points.shape[1] == 2
    at = np.arange(len(points)) if in_order else _near_together(len(points), cells)
    cells = at[cells]
    cells = cells[np.argsort(cells.min(axis=1), kind="stable")]
    points = points[np.argsort(at)]
    straight = (skfem.MeshTri1 if planar else skfem.MeshTet1)(points.T.copy(), cells.T.copy())
    mesh = (skfem.MeshTri2 if planar else skfem.MeshTet2).from_mesh(straight)
    nodes = middles_of(mesh, at[ends])
    if nodes.min(initial=0) < 0:
        raise CycloidError(f"the {part} does not mesh: an edge of its outline is missing; change the refinement")
    mesh.doflocs[:, nodes] = middles.T
    shape = mapping_of(mesh).detDF(np.eye(mesh.dim(), mesh.dim() + 1, 1))
    folded = np.any(shape * np.sign(shape[:, :1]) <= 0.0, axis=1)
    if folded.any():
        raise FoldedError(part, points[cells[folded]])
    return mesh, at, nodes


def mapping_of(mesh: Any) -> Any:
    """Return a mapping of a mesh from straight to curved elements, which is let go with all that it keeps.

    The mesh's own keeps its derivatives at all quadrature points that it is ever asked for: 75 MB of the peak that the
    factor of the preset's finer output is.
    """
    return package("skfem").MappingIsoparametric(mesh, mesh.elem(), mesh.bndelem)


def _near_together(count: int, cells: Integers) -> Integers:
    """Compute new numbers of points (count,), such that neighbours are near each other.

    Sparse products with fields of a grid then find what they need in the processor's cache, and take half the time.
    """
    rows = np.repeat(np.arange(len(cells)), cells.shape[1])
    corners = sparse.csr_matrix((np.ones(cells.size), (rows, cells.ravel())), shape=(len(cells), count))
    at = np.empty(count, np.int64)
    at[csgraph.reverse_cuthill_mckee((corners.T @ corners).tocsr(), symmetric_mode=True)] = np.arange(count)
    return at


def middles_of(mesh: Any, ends: Integers) -> Integers:
    """Compute the node in the middle of each edge (..., 2) of a quadratic mesh; -1 where there is no such edge."""
    known = np.sort(mesh.facets if mesh.dim() == 2 else mesh.edges, axis=0).astype(np.int64)
    key, wanted = known[0] * mesh.nvertices + known[1], np.sort(ends, axis=-1) @ np.array([mesh.nvertices, 1])
    order = np.argsort(key)
    places = order[np.searchsorted(key[order], wanted).clip(max=len(order) - 1)]
    return np.where(key[places] == wanted, mesh.nvertices + places, -1)


def _triangulated(
    region: Region, loops: list[QuadraticOutline], inner_edge: float, growth: float
) -> tuple[Array, Integers]:
    """Let gmsh fill the region; the loops' nodes come first, in order."""
    with mesher(region.part, inner_edge) as gmsh:
        geo = gmsh.model.geo
        curves, edges = [], []
        for loop in loops:
            tags = [
                geo.addPoint(x, y, 0.0, size)
                for (x, y), size in zip(loop.nodes * MILLIMETRES, loop.sizes * MILLIMETRES, strict=True)
            ]
            lines = [geo.addLine(a, b) for a, b in zip(tags, [*tags[1:], tags[0]], strict=True)]
            for line in lines:
                geo.mesh.setTransfiniteCurve(line, 2)
            curves.append(geo.addCurveLoop(lines))
            edges += lines
        geo.addPlaneSurface(curves)
        for boundary, curve in zip(region.boundaries, curves, strict=True):
            if boundary.role == "inset":
                geo.addPlaneSurface([curve])
        geo.synchronize()
        _grow_inwards(gmsh.model.mesh.field, edges, inner_edge * MILLIMETRES, growth)
        gmsh.model.mesh.generate(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, corners = gmsh.model.mesh.getElementsByType(2)
    if not len(corners):
        raise CycloidError(f"the {region.part} does not mesh: an outline crosses itself or another; check the design")
    index = np.zeros(int(tags.max()) + 1, np.int64)
    order = np.argsort(tags)
    index[tags[order].astype(np.int64)] = np.arange(len(tags))
    points = coordinates.reshape(-1, 3)[order, :2] / MILLIMETRES
    count = sum(len(loop.nodes) for loop in loops)
    points[:count] = np.concatenate([loop.nodes for loop in loops])
    return points, index[corners.astype(np.int64)].reshape(-1, 3)


def _grow_inwards(field: Any, edges: list[int], longest: float, growth: float) -> None:
    """Let edges grow with the distance from the outlines, up to the longest [mm]."""
    extend = field.add("Extend")
    field.setNumbers(extend, "CurvesList", edges)
    field.setNumber(extend, "SizeMax", longest)
    field.setNumber(extend, "DistMax", longest / DEPTH_GROWTH)
    field.setNumber(extend, "Power", growth)
    field.setAsBackgroundMesh(extend)
