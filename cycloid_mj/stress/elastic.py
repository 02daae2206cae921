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

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.memory import return_free_memory
from cycloid_mj.design.model import Material
from cycloid_mj.stress.grid import Grid, mapping_of
from cycloid_mj.stress.packages import import_package

ORDERING = {2: "amd", 3: "metis"}
"""Ordering of the unknowns in rslab by dimension: in a plane, nested dissection takes longer than it saves."""


@dataclass(frozen=True)
class ElasticBody:
    """Assembled and factorised part.

    Attributes
    ----------
    hold
        Rows of the stiffness of the fixed unknowns, sparse (f, n) [N/m].
    fixed, free
        Unknowns that are fixed at zero, and the others.
    motions
        Rigid motions (n, r): along each axis [m], then turning about each axis through the origin [m/rad].
    mass
        Sparse mass matrix [kg] of the nodes, the same for each axis.
    loose
        Columns of `motions` that no support fixes; out-of-balance loads along them are distributed over the mass.
    carried
        Mass matrix times these motions (n, l).
    factor
        Function from right-hand sides (n_free, c) to the free unknowns.
    springs
        Sparse (n, n) [N/m] of elastic supports, or None.
    """

    hold: Any
    fixed: Integers
    free: Integers
    motions: Array
    mass: Any
    loose: tuple[int, ...]
    carried: Array
    factor: Callable[[Array], Array]
    springs: Any = None


def assemble_body(
    grid: Grid, material: Material, springs: Any = None, loose: tuple[int, ...] | None = None
) -> ElasticBody:
    """Assemble the stiffness and mass matrices of a part, and factorise the stiffness.

    Parameters
    ----------
    grid
        Finite-element grid of the part, with n unknowns. Without `fixed_nodes` and springs the part is free. As many
        unknowns as it has rigid motions are then fixed, so that the solution is unique; these supports have no
        reaction, since the loads are in equilibrium.
    material
        Young's modulus, Poisson's ratio and density.
    springs
        Sparse (n, n) [N/m] of elastic supports, added to the stiffness.
    loose
        Indices of the rigid motions that no support fixes, in the order of `rigid_motions`. The default is all for a
        free part, none for a supported part.

    Raises
    ------
    CycloidError
        The grid has several pieces, a rigid motion is free, or the matrix cannot be factorised.
    """
    motions = rigid_motions(grid.points)
    if loose is None:
        loose = () if len(grid.fixed_nodes) or springs is not None else tuple(range(motions.shape[1]))
    fixed_unknowns = np.union1d(unknowns(grid.fixed_nodes, grid.dimension), _auxiliary_supports(motions, loose))
    _require_supports(grid, motions, fixed_unknowns, springs)
    free_unknowns = np.setdiff1d(np.arange(grid.unknowns), fixed_unknowns)
    assembler = _Assembler(grid)
    mass = _mass(grid, material.density, assembler)
    factorised_system, lower_triangle = _split(
        assemble_stiffness(grid, material, assembler), springs, fixed_unknowns, free_unknowns
    )
    del assembler  # some hundred bytes an unknown, which the factor needs
    return ElasticBody(
        hold=factorised_system,
        fixed=fixed_unknowns,
        free=free_unknowns,
        motions=motions,
        mass=mass,
        loose=loose,
        carried=mass_product(mass, motions[:, list(loose)]),
        factor=_factorise(lower_triangle, grid.part, grid.dimension),
        springs=springs,
    )


def equilibrate_loads(part: ElasticBody, loads: Array) -> tuple[Array, Array]:
    """Bring the loads on a part that is free to move into equilibrium with its inertia forces (d'Alembert).

    Parameters
    ----------
    part
        The part, with its loose motions: the rigid motions that no support fixes.
    loads
        Nodal forces on n unknowns in c load cases (n, c) [N].

    Returns
    -------
    tuple
        Loads with inertia forces (n, c) [N]; and the imbalance (c, r), the resultants of the loads without them: forces
        [N] and moments [N m] in the order of the r `rigid_motions`, 0 along motions that supports fix.
    """
    accelerations, imbalance = solve_accelerations(part, loads)
    return loads - part.carried @ accelerations, imbalance


def solve_accelerations(part: ElasticBody, loads: Any) -> tuple[Array, Array]:
    """Solve for the accelerations of a part that its supports do not prevent, under c load cases (d'Alembert).

    Parameters
    ----------
    part
        The part, with its l loose motions: the rigid motions that no support fixes.
    loads
        Nodal forces on n unknowns (n, c) [N], dense or sparse.

    Returns
    -------
    tuple
        Accelerations (l, c) [m/s^2 or rad/s^2], and the imbalance (c, r): the resultants [N or N m] of the loads along
        the r rigid motions, 0 along motions that supports fix.
    """
    imbalance = np.zeros((loads.shape[1], part.motions.shape[1]))
    loose_motions = list(part.loose)
    motions = part.motions[:, loose_motions]
    resultant = loads.T @ motions
    imbalance[:, loose_motions] = resultant
    return np.linalg.solve(motions.T @ part.carried, resultant.T), imbalance


def mass_product(mass: Any, fields: Array) -> Array:
    """Compute the mass matrix times fields (n, c) of all unknowns."""
    return np.asarray(mass @ fields.reshape(mass.shape[0], -1)).reshape(fields.shape)


def displacements(part: ElasticBody, loads: Array) -> Array:
    """Solve for the displacements [m] of n unknowns of a part under nodal `loads` [N] in c load cases, (n, c) each.

    The displacements of fixed unknowns are 0.
    """
    displacement = np.zeros(loads.shape)
    block_size = 32  # right-hand sides: more would need memory without saving time
    for first_column in range(0, loads.shape[1], block_size):
        columns = slice(first_column, first_column + block_size)
        displacement[part.free, columns] = part.factor(np.ascontiguousarray(loads[part.free, columns]))
    return displacement


def reactions(part: ElasticBody, displacement: Array, loads: Array) -> Array:
    """Compute the resultants (c, r) of all support forces on a part: forces [N], then moments about the origin [N m].

    Supports are fixed nodes and elastic supports. The resultants are in the order of the r `rigid_motions`.

    Parameters
    ----------
    part
        The part with its supports.
    displacement, loads
        Displacements [m] and nodal forces [N] of n unknowns in c load cases, shape (n, c) each.
    """
    support_forces = part.hold @ displacement - loads[part.fixed]
    resultants = support_forces.T @ part.motions[part.fixed]
    if part.springs is not None:
        resultants = resultants - (part.springs @ displacement).T @ part.motions
    return np.asarray(resultants)


def mass_loads(part: ElasticBody, points: Array) -> Array:
    """Compute the nodal forces [N] of four unit fields of acceleration on the mass of a part, shape (unknowns, 4).

    The fields at a position (x, y) [m] are (1, 0), (0, 1), (x, y) and (y, -x), in m/s2: two translations, the radial
    and the tangential field. Their linear combinations are the inertia forces of any plane motion. `points` are the p
    nodes of the part in d = 2 or 3 dimensions, shape (p, d) [m].
    """
    x, y = points[:, 0], points[:, 1]
    fields = np.zeros((*points.shape, 4))
    fields[:, 0, 0] = 1.0
    fields[:, 1, 1] = 1.0
    fields[:, 0, 2], fields[:, 1, 2] = x, y
    fields[:, 0, 3], fields[:, 1, 3] = y, -x
    return mass_product(part.mass, fields.reshape(-1, 4))


def rigid_motions(points: Array) -> Array:
    """Compute the displacements of the nodes of a grid in each of its r rigid motions, shape (p d, r).

    `points` are the p nodes in d = 2 or 3 dimensions, shape (p, d) [m]. In the plane, the motions are 1 m along x and y
    and 1 rad about z. In space, they are 1 m along x, y and z and 1 rad about x, y and z. Rotations are linearised,
    about the origin.
    """
    nodes, dimension = points.shape
    rotations = 1 if dimension == 2 else 3
    motions = np.zeros((nodes, dimension, dimension + rotations))
    motions[:, np.arange(dimension), np.arange(dimension)] = 1.0
    positions = np.column_stack([points, np.zeros(nodes)]) if dimension == 2 else points
    for rotation in range(rotations):
        axis = np.eye(3)[2 if dimension == 2 else rotation]
        motions[:, :, dimension + rotation] = np.cross(axis, positions)[:, :dimension]
    return motions.reshape(nodes * dimension, -1)


def unknowns(nodes: Integers, dimension: int) -> Integers:
    """Return the indices of the unknowns of nodes, all axes of a node after each other."""
    return (dimension * nodes[:, np.newaxis] + np.arange(dimension)).ravel()


def basis_of(grid: Grid, vector: bool, order: int) -> Any:
    """Return the scikit-fem basis of the quadratic elements of a finite-element mesh.

    It is a basis for displacements if `vector` is true, otherwise for scalars. Its quadrature is exact up to the
    polynomial degree `order`. `grid` is the finite-element mesh.
    """
    skfem = import_package("skfem")
    element = skfem.ElementTriP2() if grid.dimension == 2 else skfem.ElementTetP2()
    mapping = mapping_of(grid.mesh)
    return skfem.Basis(grid.mesh, skfem.ElementVector(element) if vector else element, mapping, intorder=order)


def lame_parameters(material: Material, dimension: int) -> tuple[float, float]:
    """Compute Lame's lambda and mu [Pa]; in the plane those of plane stress."""
    modulus, poisson = material.youngs_modulus, material.poisson
    bulk = modulus * poisson / ((1 - poisson**2) if dimension == 2 else (1 + poisson) * (1 - 2 * poisson))
    return bulk, modulus / (2 * (1 + poisson))


def assemble_stiffness(grid: Grid, material: Material, assembler: "_Assembler | None" = None) -> Any:
    """Assemble the stiffness matrix of a linear elastic part without supports, sparse, n unknowns: (n, n) [N/m].

    A planar part is in plane stress. An `assembler` of the same grid, if there is one, is reused to save time.
    `material` has Young's modulus and Poisson's ratio.
    """
    dimension = grid.dimension
    basis = basis_of(grid, vector=False, order=dimension)
    gradients = np.stack([shape[0].grad for shape in basis.basis])
    volumes = grid.thickness * basis.dx
    lame, shear = lame_parameters(material, dimension)
    gradients_along = [np.ascontiguousarray(gradients[:, axis].transpose(1, 2, 0)) for axis in range(dimension)]
    weighted_gradients = [(gradient * volumes[..., np.newaxis]).transpose(0, 2, 1) for gradient in gradients_along]
    laplacian = shear * sum(weighted_gradients[axis] @ gradients_along[axis] for axis in range(dimension))
    assembler = assembler or _Assembler(grid)
    blocks = np.empty((assembler.pair_count, dimension, dimension))
    for i, j in zip(*np.triu_indices(dimension), strict=True):
        product = weighted_gradients[i] @ gradients_along[j]
        element_matrices = lame * product + shear * product.transpose(0, 2, 1) + (laplacian if i == j else 0.0)
        blocks[:, i, j] = assembler.sum_pairs(element_matrices)
        if i != j:
            blocks[:, j, i] = assembler.sum_pairs(element_matrices.transpose(0, 2, 1))
    return assembler.matrix(blocks)


def _split(matrix: Any, springs: Any, fixed_unknowns: Integers, free_unknowns: Integers) -> tuple[Any, Any]:
    """Return the rows of the fixed unknowns, and the lower triangle of the free unknowns; the full matrix is freed."""
    if springs is not None:
        matrix = matrix + springs
    return matrix[fixed_unknowns], sparse.triu(matrix, format="csr")[free_unknowns][
        :, free_unknowns
    ].T  # it is symmetric


def _mass(grid: Grid, density: float, assembler: "_Assembler") -> Any:
    basis = basis_of(grid, vector=False, order=4)  # products of quadratic shape functions
    shape = np.stack([np.broadcast_to(each[0], basis.dx.shape)[0] for each in basis.basis])
    mass = density * grid.thickness * np.tensordot(basis.dx, np.einsum("aq,bq->qab", shape, shape), 1)
    return assembler.matrix(assembler.sum_pairs(mass)[:, np.newaxis, np.newaxis])


class _Assembler:
    """Sums matrices of elements (m, a, a) over the pairs of nodes that share an element, in the order of the rows."""

    def __init__(self, grid: Grid) -> None:
        """Find all pairs of nodes that share an element of `grid`: the nonzero entries of its stiffness matrix.

        The attribute `pair_count` is their number.
        """
        cells, self._nodes = grid.cells, len(grid.points)
        pair_keys = (cells[:, :, np.newaxis] * self._nodes + cells[:, np.newaxis]).ravel()
        pairs, self._slot = np.unique(pair_keys, return_inverse=True)
        self._columns = pairs % self._nodes
        self._starts = np.searchsorted(pairs, np.arange(self._nodes + 1) * self._nodes)
        self.pair_count = len(pairs)

    def sum_pairs(self, element: Array) -> Array:
        """Sum the entries of element matrices (m, a, a) that belong to the same pair of nodes, shape (pairs,)."""
        return np.asarray(np.bincount(self._slot.ravel(), element.ravel(), self.pair_count), np.float64)

    def matrix(self, blocks: Array) -> Any:
        """Return the sparse matrix (n, n) of the blocks (pairs, d, d)."""
        size = self._nodes * blocks.shape[1]
        return sparse.bsr_matrix((blocks, self._columns, self._starts), shape=(size, size)).tocsr()


def _auxiliary_supports(motions: Array, loose: tuple[int, ...]) -> Integers:
    """Choose unknowns to fix, far from each other, which prevent the rigid motions with the indices `loose`.

    `motions` are the displacements of the n unknowns in all r rigid motions, shape (n, r). Returns the index of one
    unknown for each loose motion. In each step, it is the unknown that moves most in the motions that the previous
    unknowns leave free.
    """
    remaining_motions = motions[:, list(loose)]
    remaining_motions = remaining_motions / np.abs(remaining_motions).max(axis=0, initial=np.finfo(float).tiny)
    chosen_unknowns = []
    for _ in loose:
        unknown_index = int(np.argmax(np.linalg.norm(remaining_motions, axis=1)))
        chosen_unknowns.append(unknown_index)
        direction = remaining_motions[unknown_index] / np.linalg.norm(remaining_motions[unknown_index])
        remaining_motions = remaining_motions - np.outer(remaining_motions @ direction, direction)
    return np.array(chosen_unknowns, np.int64)


def _require_supports(grid: Grid, motions: Array, fixed_unknowns: Integers, springs: Any) -> None:
    """Raise CycloidError unless the grid of a part is in one piece and its supports prevent all rigid motions.

    `motions` are the displacements of `rigid_motions`, `fixed_unknowns` the indices of the fixed unknowns, and
    `springs` the stiffness of elastic supports.
    """
    cells = grid.mesh.t
    pairs = np.concatenate([np.stack([cells[0], corner]) for corner in cells[1:]], axis=1)
    graph = sparse.coo_matrix((np.ones(pairs.shape[1]), pairs), shape=(grid.mesh.nvertices,) * 2)
    piece_count = csgraph.connected_components(graph, directed=False)[0]
    if piece_count != 1:
        raise CycloidError(
            f"the finite-element mesh of the {grid.part} consists of {piece_count} separate pieces, but it must be "
            "in one piece. Export this part with `cycloid-mj export`, find the holes that separate it, and reduce or "
            "move them"
        )
    scaled_motions = motions / np.linalg.norm(motions, axis=0)
    support_matrix = scaled_motions[fixed_unknowns].T @ scaled_motions[fixed_unknowns]
    if springs is not None:
        support_stiffness = scaled_motions.T @ (springs @ scaled_motions)
        support_matrix = support_matrix + support_stiffness / max(
            float(np.abs(support_stiffness).max()), np.finfo(float).tiny
        )
    eigenvalues = np.linalg.eigvalsh(support_matrix) if len(support_matrix) else np.zeros(1)
    if not eigenvalues[0] > 1e-12 * max(eigenvalues[-1], np.finfo(float).tiny):
        raise CycloidError(
            f"the finite-element mesh of the {grid.part} can move as a rigid body, because all its supported nodes lie "
            "at one point: support nodes at two or more different points"
        )


def _factorise(lower_triangle: Any, part: str, dimension: int) -> Callable[[Array], Array]:
    """Factorise a symmetric stiffness matrix; return a function that solves for displacements under loads.

    The function maps loads on n unknowns in c load cases, (n, c) [N], to displacements (n, c) [m]. The method is LDL^T
    of rslab if that is installed, or else LU of SuperLU, which is much slower.

    Parameters
    ----------
    lower_triangle
        Lower triangle of the matrix, sparse, shape (n, n).
    part
        Name of the part, for errors.
    dimension
        2 for a planar grid, 3 for a solid; it determines the order of elimination.

    Raises
    ------
    CycloidError
        The matrix is singular, or the memory does not suffice.
    """
    return_free_memory()  # a factor needs its memory in one piece
    try:
        ldlt = importlib.import_module("rslab").ldlt
    except (ImportError, OSError, AttributeError):  # it is young: a later release may have other names
        return _factorise_by_superlu(lower_triangle, part)
    try:
        solver = ldlt(lower_triangle, threads=1, ordering=ORDERING[dimension])
    except (RuntimeError, ValueError, MemoryError) as error:
        raise _not_factorised(part, error) from error
    return lambda loads: np.asarray(solver.solve_many(loads))


def _factorise_by_superlu(lower_triangle: Any, part: str) -> Callable[[Array], Array]:
    """Factorise a symmetric stiffness matrix by SuperLU; return the function of `_factorise`.

    `lower_triangle` is the lower triangle of the matrix, and `part` the name of the part for messages.
    """
    matrix = (lower_triangle + sparse.tril(lower_triangle, -1).T).tocsc()
    try:
        solver = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except (RuntimeError, MemoryError) as error:
        raise _not_factorised(part, error) from error
    return lambda loads: np.asarray(solver.solve(loads))


def _not_factorised(part: str, error: Exception) -> CycloidError:
    return CycloidError(
        f"the stiffness matrix of the {part} cannot be factorised ({error}): check that its supports prevent rigid "
        "motion, and export the part with `cycloid-mj export` to check its outline"
    )
