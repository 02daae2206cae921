"""Linear elasticity on a grid: stiffness, loads of the mass, supports, one factorisation for many right-hand sides.

Displacements are ordered node by node: unknown d i + a is the displacement of node i along axis a.
"""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.sparse.linalg import splu

from cycloid_mj.design.model import Material
from cycloid_mj.errors import CycloidError
from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.packages import package
from cycloid_mj.types import Array, Integers

Indices = Integers

INDEPENDENT = 1e-6
"""Supports hold a rigid motion whose share at them is larger than this, relatively."""

CHUNK = 6
"""Right-hand sides that the solver takes at once; with more, their columns no longer stay in the cache."""


@dataclass(frozen=True)
class Body:
    """A part ready to be solved.

    Attributes
    ----------
    stiffness
        Sparse (n, n) [N/m], springs of the supports included.
    fixed, free
        Unknowns that are held at zero, and the others.
    motions
        Rigid motions (n, r): along each axis [m], then turning about each axis through the origin [m/rad].
    inertia
        Sparse (n, n) mass matrix [kg].
    loose
        Columns of `motions` that no real support holds; out-of-balance loads along them are spread over the mass.
    factor
        Solves the free unknowns for right-hand sides (n_free, c).
    springs
        Sparse (n, n) [N/m] of elastic supports, or None.
    """

    stiffness: Any
    fixed: Indices
    free: Indices
    motions: Array
    inertia: Any
    loose: tuple[int, ...]
    factor: Callable[[Array], Array]
    springs: Any = None


def body(grid: Grid, material: Material, springs: Any = None, loose: tuple[int, ...] | None = None) -> Body:
    """Assemble and factorise a part.

    Parameters
    ----------
    grid
        Its grid; nodes in `held` do not move. Without them a planar part is free: three unknowns are fixed so that the
        solution is unique, and since its loads are in balance they feel no force.
    material
        Young's modulus, Poisson's ratio and density.
    springs
        Sparse (n, n) [N/m] of elastic supports, added to the stiffness.
    loose
        Rigid motions that nothing real holds; by default all of a free part.

    Raises
    ------
    CycloidError
        The supports leave a rigid motion free, the part is in pieces, or scikit-fem is missing.
    """
    stiffness = _stiffness(grid, material) + (0.0 if springs is None else springs)
    motions = rigid_motions(grid.points)
    if loose is None:
        loose = () if len(grid.held) or springs is not None else tuple(range(motions.shape[1]))
    fixed = np.union1d(unknowns(grid.held, grid.dimension), _pinned(motions, loose))
    _require_hold(grid, motions, fixed, springs)
    free = np.setdiff1d(np.arange(grid.unknowns), fixed)
    return Body(
        stiffness=stiffness.tocsr(),
        fixed=fixed,
        free=free,
        motions=motions,
        inertia=_inertia(grid, material.density),
        loose=loose,
        factor=_factor(stiffness.tocsc()[free][:, free], grid.part),
        springs=springs,
    )


def balanced(part: Body, loads: Array) -> tuple[Array, Array]:
    """Spread what is out of balance in loads (n, c) [N] over the mass, as an acceleration along the loose motions.

    Give the balanced loads and the imbalance (c, r) along all rigid motions: forces [N], then moments [N m]; zero along
    the motions that supports hold.
    """
    imbalance = np.zeros((loads.shape[1], part.motions.shape[1]))
    if not part.loose:
        return loads, imbalance
    loose = list(part.loose)
    motions = part.motions[:, loose]
    carried = part.inertia @ motions
    resultant = motions.T @ loads
    imbalance[:, loose] = resultant.T
    return loads - carried @ np.linalg.solve(motions.T @ carried, resultant), imbalance


def displacements(part: Body, loads: Array) -> Array:
    """Solve for the displacements (n, c) [m] under loads (n, c) [N]."""
    found = np.zeros(loads.shape)
    found[part.free] = part.factor(np.ascontiguousarray(loads[part.free]))
    return found


def reactions(part: Body, found: Array, loads: Array) -> Array:
    """Give the resultants (c, r) of the forces of all supports on the part: [N], then [N m] about the origin.

    They are what fixed nodes must add for equilibrium, and what springs push back.
    """
    held = part.stiffness[part.fixed] @ found - loads[part.fixed]
    resultants = held.T @ part.motions[part.fixed]
    if part.springs is not None:
        resultants = resultants - (part.springs @ found).T @ part.motions
    return np.asarray(resultants)


def mass_loads(part: Body, points: Array) -> Array:
    """Give the loads (n, 4) [N] of unit body forces per mass: along x, along y, r, and -z x r (r in the plane)."""
    x, y = points[:, 0], points[:, 1]
    fields = np.zeros((*points.shape, 4))
    fields[:, 0, 0] = 1.0
    fields[:, 1, 1] = 1.0
    fields[:, 0, 2], fields[:, 1, 2] = x, y
    fields[:, 0, 3], fields[:, 1, 3] = y, -x
    return np.asarray(part.inertia @ fields.reshape(-1, 4))


def rigid_motions(points: Array) -> Array:
    """Give the rigid motions (n d, 3 or 6) of nodes (n, d): along each axis, then turning about z, or x, y, z."""
    nodes, dimension = points.shape
    turns = 1 if dimension == 2 else 3
    motions = np.zeros((nodes, dimension, dimension + turns))
    motions[:, np.arange(dimension), np.arange(dimension)] = 1.0
    space = np.column_stack([points, np.zeros(nodes)]) if dimension == 2 else points
    for turn in range(turns):
        axis = np.eye(3)[2 if dimension == 2 else turn]
        motions[:, :, dimension + turn] = np.cross(axis, space)[:, :dimension]
    return motions.reshape(nodes * dimension, -1)


def unknowns(nodes: Indices, dimension: int) -> Indices:
    """Give the unknowns of nodes."""
    return (dimension * nodes[:, np.newaxis] + np.arange(dimension)).ravel()


def basis_of(grid: Grid, vector: bool, order: int) -> Any:
    """Give the scikit-fem basis of a grid: quadratic, and right for polynomials of an order on straight elements."""
    skfem = package("skfem")
    element = skfem.ElementTriP2() if grid.dimension == 2 else skfem.ElementTetP2()
    return skfem.Basis(grid.mesh, skfem.ElementVector(element) if vector else element, intorder=order)


def _stiffness(grid: Grid, material: Material) -> Any:
    elasticity = package("skfem.models.elasticity")
    modulus, poisson = material.youngs_modulus, material.poisson
    lame = elasticity.plane_stress if grid.dimension == 2 else elasticity.lame_parameters
    form = elasticity.linear_elasticity(*lame(modulus, poisson))
    return grid.thickness * form.assemble(basis_of(grid, vector=True, order=4 if grid.dimension == 2 else 3))


def _inertia(grid: Grid, density: float) -> Any:
    skfem = package("skfem")

    @skfem.BilinearForm
    def product(u: Any, v: Any, _: Any) -> Any:
        return u * v

    scalar = density * grid.thickness * product.assemble(basis_of(grid, vector=False, order=4))
    return sparse.kron(scalar, sparse.eye(grid.dimension), format="csr")


def _pinned(motions: Array, loose: tuple[int, ...]) -> Indices:
    """Choose one unknown for each loose motion, far from each other: the largest left after those already chosen."""
    left = motions[:, list(loose)]
    left = left / np.abs(left).max(axis=0, initial=np.finfo(float).tiny)
    chosen = []
    for _ in loose:
        row = int(np.argmax(np.linalg.norm(left, axis=1)))
        chosen.append(row)
        direction = left[row] / np.linalg.norm(left[row])
        left = left - np.outer(left @ direction, direction)
    return np.array(chosen, np.int64)


def _require_hold(grid: Grid, motions: Array, fixed: Indices, springs: Any) -> None:
    """Raise CycloidError unless the part is in one piece and each of its rigid motions meets a support."""
    cells = grid.mesh.t
    pairs = np.concatenate([np.stack([cells[0], corner]) for corner in cells[1:]], axis=1)
    graph = sparse.coo_matrix((np.ones(pairs.shape[1]), pairs), shape=(grid.mesh.nvertices,) * 2)
    pieces = csgraph.connected_components(graph, directed=False)[0]
    if pieces != 1:
        raise CycloidError(f"the grid of the {grid.part} is in {pieces} pieces; check the design")
    scaled = motions / np.linalg.norm(motions, axis=0)
    hold = scaled[fixed].T @ scaled[fixed]
    if springs is not None:
        stiff = scaled.T @ (springs @ scaled)
        hold = hold + stiff / max(float(np.abs(stiff).max()), np.finfo(float).tiny)
    values = np.linalg.eigvalsh(hold) if len(hold) else np.zeros(1)
    if not values[0] > INDEPENDENT**2 * max(values[-1], np.finfo(float).tiny):
        raise CycloidError(
            f"the support of the {grid.part} is singular: it leaves a rigid motion free; hold nodes that do not "
            "lie in one point"
        )


def _factor(matrix: Any, part: str) -> Callable[[Array], Array]:
    """Factorise a symmetric matrix: by cholespy where it is installed (a third of the time a side), else by SuperLU."""
    try:
        cholespy = importlib.import_module("cholespy")
    except (ImportError, OSError):
        return _superlu(matrix, part)
    entries = matrix.tocoo()
    rows, columns = entries.row.astype(np.int32), entries.col.astype(np.int32)
    try:
        solver = cholespy.CholeskySolverD(matrix.shape[0], rows, columns, entries.data, cholespy.MatrixType.COO)
    except (RuntimeError, ValueError, MemoryError) as error:
        raise _not_factorised(part, error) from error

    def solve(loads: Array) -> Array:
        found = np.zeros(loads.shape)
        for start in range(0, loads.shape[1], CHUNK):
            some = np.ascontiguousarray(loads[:, start : start + CHUNK])
            into = np.zeros_like(some)
            solver.solve(some, into)
            found[:, start : start + CHUNK] = into
        return found

    return solve


def _superlu(matrix: Any, part: str) -> Callable[[Array], Array]:
    try:
        solver = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except (RuntimeError, MemoryError) as error:
        raise _not_factorised(part, error) from error

    def solve(loads: Array) -> Array:
        chunks = [solver.solve(loads[:, start : start + CHUNK]) for start in range(0, loads.shape[1], CHUNK)]
        return np.concatenate(chunks, axis=1)

    return solve


def _not_factorised(part: str, error: Exception) -> CycloidError:
    return CycloidError(f"the stiffness of the {part} cannot be factorised ({error}); check its supports and its grid")
