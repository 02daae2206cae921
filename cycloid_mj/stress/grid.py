"""Grids of quadratic elements: their settings, and triangles on any planar region."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse import csgraph

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.stress.outline import QuadraticOutline, Sizing, divide_outline
from cycloid_mj.stress.packages import import_package, open_mesher
from cycloid_mj.stress.region import Region

BULK_DISTANCE = 0.5
"""Distance from loaded patches at which bulk begins, over the ring's pin radius (heuristic)."""

MAX_REMESHES = 4
"""Largest number of remeshes with shorter edges (heuristic)."""


class FoldedError(CycloidError):
    """Curved edges fold elements: `folds` (k, d + 1) [m] are their middles and longest edges."""

    def __init__(self, part: str, corners: Array) -> None:
        """Create the error of a finite-element mesh with elements that are folded over (with negative volume).

        Centres and longest edges of these k elements (`folds`) follow from their `corners` (k, d + 1, d) [m] in d
        dimensions. `part` is the name of the part.
        """
        super().__init__(
            f"cannot generate a finite-element mesh of the {part}: a curved edge folds its element; increase the "
            "refinement"
        )
        edges = np.linalg.norm(corners[:, :, np.newaxis] - corners[:, np.newaxis], axis=-1)
        self.folds: Array = np.column_stack([corners.mean(axis=1), edges.max(axis=(1, 2))])


@dataclass(frozen=True)
class GridSettings:
    """Settings of a grid. Lengths are shares of the ring's pin radius.

    `refinement` divides all of them except `bulk_distance`, which must not change in a convergence study.

    Attributes
    ----------
    refinement
        Refinement factor.
    contact_edge, wide_edge, free_edge, inner_edge
        Edges of outlines with line contacts, with wide contacts (the bore), without contacts, and the longest inside.
    turn
        Longest edge over the radius of curvature.
    growth
        Growth of the edges inwards as a power of the depth: the smaller, the slower at first.
    solid_edge
        Longest edge of the tetrahedra of the shaft, over its own radius.
    layer_edge
        Largest layer height of the other parts as solids.
    bulk_distance
        Distance from loaded patches beyond which stress counts as bulk.
    solid
        Whether parts other than the shaft are solid bodies as well, on coarser sections.
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
        """Raise UsageError if a number among the settings is not positive; `solid`, a yes or no, is exempt."""
        for name, value in vars(self).items():
            if name != "solid" and not value > 0.0:
                raise UsageError(
                    f"the mesh setting {name} is {value}, which is out of range: choose a value greater than 0, such "
                    "as 1"
                )


@dataclass(frozen=True)
class Grid:
    """A part as quadratic elements.

    Attributes
    ----------
    part
        Name of the part.
    mesh
        The scikit-fem mesh. Its nodes (`points`) are the vertices, then the middles of the edges.
    thickness
        Thickness of a planar part [m]; 1 for a solid one.
    loops
        Outlines with contacts, each (e, 3): start, middle and end node of each edge, in order.
    fixed_nodes
        Fixed nodes; empty for a free part.
    bulk_distance
        Distance from loaded patches beyond which stress counts as bulk [m].
    singular_points, corner_distance
        Points (n, d) [m] on sharp inner corners without their fillets, and their distance that the bulk excludes [m].
    section
        Planar grid of an extruded solid, on which contact forces act; None for others.
    """

    part: str
    mesh: Any
    thickness: float
    loops: tuple[Integers, ...]
    fixed_nodes: Integers
    bulk_distance: float
    singular_points: Array
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
    """The planar grid from which a solid grid is extruded.

    Attributes
    ----------
    grid
        The planar grid, of n2 nodes.
    nodes
        The solid's node over each node of the section (h, n2) at the heights where contact forces act; -1 for none.
    distributions
        For each disc, the sparse matrix (n, 2 n2) that distributes loads on the section (2 n2,) to the solid's unknowns
        in the plane of this disc. A part that belongs to one disc has a single matrix.
    """

    grid: Grid
    nodes: Integers
    distributions: tuple[Any, ...]


def planar_grid(
    region: Region, settings: GridSettings, length: float, focus: npt.ArrayLike | None = None, section: bool = False
) -> Grid:
    """Mesh a planar region by finite elements: quadratic triangles whose edges follow the curved outlines.

    Where a curved edge would turn an element inside out, the region is meshed again with shorter edges there.

    Parameters
    ----------
    region
        The region.
    settings
        Edge lengths relative to `length`, and their growth.
    length
        Unit of the lengths in the settings [m].
    focus
        Positions with short edges, rows (x, y, edge length) [m].
    section
        Whether the vertices keep the mesher's order, because the grid will be extruded.

    Raises
    ------
    CycloidError
        The region does not mesh, or a package of the extra ``fem`` is missing.
    """
    short_edges = np.zeros((0, 3)) if focus is None else np.asarray(focus, float).reshape(-1, 3)
    short_edges = np.concatenate([short_edges, _clamped_circles(region)])
    for _ in range(MAX_REMESHES):
        try:
            return _mesh_region(region, settings, length, short_edges, section)
        except FoldedError as folded:
            short_edges = np.concatenate([short_edges, folded.folds * (1.0, 1.0, 0.5)])
    return _mesh_region(region, settings, length, short_edges, section)


def _mesh_region(region: Region, settings: GridSettings, length: float, short_edges: Array, section: bool) -> Grid:
    """Mesh a planar region once by second-order triangles.

    `length` is the unit of the edge lengths in the settings [m]; `short_edges` (n, 3) [m] are n positions x, y with
    their edge lengths. `section` is whether the grid is to be extruded.

    Raises
    ------
    FoldedError
        A curved edge turns an element inside out.
    """
    unit_edge = length / settings.refinement
    loops = []
    for boundary in region.boundaries:
        edge = (
            unit_edge
            * {"line": settings.contact_edge, "wide": settings.wide_edge, "": settings.free_edge}[boundary.contact]
        )
        loops.append(
            divide_outline(boundary.polygon, Sizing(edge, settings.turn / settings.refinement, edge / 10, short_edges))
        )
    points, triangles = _triangulate(region, loops, unit_edge * settings.inner_edge, settings.growth)
    first_nodes = np.cumsum([0, *(len(loop.nodes) for loop in loops)])
    loop_nodes = [start + np.arange(len(loop.nodes)) for start, loop in zip(first_nodes, loops, strict=False)]
    edge_ends = np.concatenate([np.column_stack([nodes, np.roll(nodes, -1)]) for nodes in loop_nodes])
    middles = np.concatenate([loop.middles for loop in loops])
    mesh, vertex, edge_middles = quadratic_mesh(points, triangles, edge_ends, middles, region.part, section)
    edge_tables = [
        np.column_stack([vertex[nodes], edge_middles[nodes], vertex[np.roll(nodes, -1)]]) for nodes in loop_nodes
    ]
    boundary_tables = list(zip(region.boundaries, edge_tables, strict=True))
    clamped_nodes = [table[:, :2].ravel() for boundary, table in boundary_tables if boundary.is_fixed]
    return Grid(
        part=region.part,
        mesh=mesh,
        thickness=region.thickness,
        loops=tuple(table for boundary, table in boundary_tables if boundary.contact),
        fixed_nodes=np.unique(np.concatenate([np.zeros(0, np.int64), *clamped_nodes])),
        bulk_distance=settings.bulk_distance * length,
        singular_points=np.zeros((0, 2)),
    )


def _clamped_circles(region: Region) -> Array:
    """Compute the middles of clamped circles within a region and the edge length there, rows (x, y, edge) [m]."""
    circles = [each.polygon for each in region.boundaries if each.is_fixed and each.role == "inset"]
    # a longer arc than a quarter of the radius would cut into the circle
    rows = [(*circle.mean(axis=0), 0.25 * float(np.ptp(circle[:, 0])) / 2.0) for circle in circles]
    return np.array(rows).reshape(-1, 3)


def quadratic_mesh(
    points: Array, cells: Integers, edge_ends: Integers, middles: Array, part: str, keep_order: bool = False
) -> tuple[Any, Integers, Integers]:
    """Return a quadratic scikit-fem mesh with edges that pass through prescribed middles.

    Parameters
    ----------
    points, cells
        The p vertices in d dimensions (p, d) [m], and the corners of each of m triangles or tetrahedra, (m, d + 1).
    edge_ends, middles
        Vertices at both ends of e edges, (e, 2), and the points in their middles, (e, d) [m].
    part
        Name of the part, for errors.
    keep_order
        Whether the vertices keep their order; otherwise they are renumbered so that neighbours have close numbers.

    Returns
    -------
    mesh, vertices, middle_nodes
        The mesh, the index of its node at each point (p,), and the index of its node in the middle of each edge (e,).

    Raises
    ------
    FoldedError
        Elements are turned inside out by their curved edges: the grid is too coarse there.
    CycloidError
        An edge of the outline is missing.
    """
    skfem = import_package("skfem")
    is_planar = points.shape[1] == 2
    new_numbers = np.arange(len(points)) if keep_order else _reverse_cuthill_mckee(len(points), cells)
    cells = new_numbers[cells]
    cells = cells[np.argsort(cells.min(axis=1), kind="stable")]
    points = points[np.argsort(new_numbers)]
    straight_mesh = (skfem.MeshTri1 if is_planar else skfem.MeshTet1)(points.T.copy(), cells.T.copy())
    mesh = (skfem.MeshTri2 if is_planar else skfem.MeshTet2).from_mesh(straight_mesh)
    middle_nodes = find_edge_nodes(mesh, new_numbers[edge_ends])
    if middle_nodes.min(initial=0) < 0:
        raise CycloidError(
            f"cannot generate a finite-element mesh of the {part}: an edge of its outline is missing. Use a finer "
            "mesh: omit --quick or, in Python, increase GridSettings.refinement"
        )
    mesh.doflocs[:, middle_nodes] = middles.T
    determinants = mapping_of(mesh).detDF(np.eye(mesh.dim(), mesh.dim() + 1, 1))
    is_folded = np.any(determinants * np.sign(determinants[:, :1]) <= 0.0, axis=1)
    if is_folded.any():
        raise FoldedError(part, points[cells[is_folded]])
    return mesh, new_numbers, middle_nodes


def mapping_of(mesh: Any) -> Any:
    """Return a temporary mapping of a mesh from straight to curved elements.

    The mesh's own mapping caches its derivatives at all quadrature points, which is 75 MB of the peak memory for the
    finer output of the preset.
    """
    return import_package("skfem").MappingIsoparametric(mesh, mesh.elem(), mesh.bndelem)


def _reverse_cuthill_mckee(count: int, cells: Integers) -> Integers:
    """Return new numbers of `count` points such that neighbours have close numbers (reverse Cuthill-McKee method).

    The data that sparse products need are then in the processor's cache, which halves their time. `cells` (m, corners)
    are the points of each of m elements.
    """
    cell_rows = np.repeat(np.arange(len(cells)), cells.shape[1])
    links = sparse.csr_matrix((np.ones(cells.size), (cell_rows, cells.ravel())), shape=(len(cells), count))
    new_numbers = np.empty(count, np.int64)
    new_numbers[csgraph.reverse_cuthill_mckee((links.T @ links).tocsr(), symmetric_mode=True)] = np.arange(count)
    return new_numbers


def find_edge_nodes(mesh: Any, edge_ends: Integers) -> Integers:
    """Return the middle node (...) of each edge of a quadratic mesh by its end vertices (..., 2); -1 for no edge."""
    known_edges = np.sort(mesh.facets if mesh.dim() == 2 else mesh.edges, axis=0).astype(np.int64)
    key, wanted_key = (
        known_edges[0] * mesh.nvertices + known_edges[1],
        np.sort(edge_ends, axis=-1) @ np.array([mesh.nvertices, 1]),
    )
    order = np.argsort(key)
    candidates = order[np.searchsorted(key[order], wanted_key).clip(max=len(order) - 1)]
    return np.where(key[candidates] == wanted_key, mesh.nvertices + candidates, -1)


def _triangulate(
    region: Region, loops: list[QuadraticOutline], inner_edge: float, growth: float
) -> tuple[Array, Integers]:
    """Mesh a region by straight triangles with gmsh.

    Parameters
    ----------
    region
        The region.
    loops
        Divided outlines of the region, in the order of its boundaries.
    inner_edge, growth
        Longest edge, far from the outlines [m], and exponent of the power law by which edges grow to it with the
        distance from the outlines.

    Returns
    -------
    tuple
        The p points (p, 2) [m], first the points of the loops in order, and the corners of m triangles (m, 3).

    Raises
    ------
    CycloidError
        The outlines cross each other.
    """
    with open_mesher(region.part, inner_edge) as gmsh:
        geometry = gmsh.model.geo
        curve_loops, edges = [], []
        for loop in loops:
            tags = [
                geometry.addPoint(x, y, 0.0, edge_length)
                for (x, y), edge_length in zip(loop.nodes * MILLIMETRES, loop.sizes * MILLIMETRES, strict=True)
            ]
            lines = [geometry.addLine(start, end) for start, end in zip(tags, [*tags[1:], tags[0]], strict=True)]
            for line in lines:
                geometry.mesh.setTransfiniteCurve(line, 2)
            curve_loops.append(geometry.addCurveLoop(lines))
            edges += lines
        geometry.addPlaneSurface(curve_loops)
        for boundary, curve in zip(region.boundaries, curve_loops, strict=True):
            if boundary.role == "inset":
                geometry.addPlaneSurface([curve])
        geometry.synchronize()
        _set_edge_growth(gmsh.model.mesh.field, edges, inner_edge * MILLIMETRES, growth)
        gmsh.model.mesh.generate(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, corners = gmsh.model.mesh.getElementsByType(2)
    if not len(corners):
        raise CycloidError(
            f"cannot generate a finite-element mesh of the {region.part}: one of its outlines crosses itself or "
            "another outline. Change the dimensions that define it"
        )
    point_index = np.zeros(int(tags.max()) + 1, np.int64)
    tag_order = np.argsort(tags)
    point_index[tags[tag_order].astype(np.int64)] = np.arange(len(tags))
    points = coordinates.reshape(-1, 3)[tag_order, :2] / MILLIMETRES
    outline_points = sum(len(loop.nodes) for loop in loops)
    points[:outline_points] = np.concatenate([loop.nodes for loop in loops])
    return points, point_index[corners.astype(np.int64)].reshape(-1, 3)


def _set_edge_growth(field: Any, edges: list[int], longest: float, growth: float) -> None:
    """Set gmsh's size field so that edges grow with the distance from the outlines.

    `edges` are gmsh's tags of the edges of the outlines, `longest` is the longest edge [mm], and `growth` is the
    exponent of gmsh's field "Extend".
    """
    extend_field = field.add("Extend")
    field.setNumbers(extend_field, "CurvesList", edges)
    field.setNumber(extend_field, "SizeMax", longest)
    field.setNumber(extend_field, "DistMax", longest / 0.6)  # the mean growth per length
    field.setNumber(extend_field, "Power", growth)
    field.setAsBackgroundMesh(extend_field)
