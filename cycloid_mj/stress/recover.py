"""Stress from displacements: components at quadrature points and at nodes, von Mises, principal, and where it peaks."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from cycloid_mj.design.model import Material
from cycloid_mj.stress import elastic
from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.patchfit import nodal_fit
from cycloid_mj.types import Array, Integers

PLANE = ((0, 0), (1, 1), (0, 1))
SPACE = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Order of the stress components: xx, yy, xy, or xx, yy, zz, yz, xz, xy."""

GAUSS = 2
"""Order of the quadrature whose points have the best stress: 3 Gauss points a triangle, 4 a tetrahedron."""


@dataclass(frozen=True)
class Recovery:
    """Operators from nodal values (n,) to derivatives along each axis.

    `at_points` at the quadrature points, element by element (m q, n); `at_nodes` (n, n), by ``patchfit``.
    `points` (m q, d) [m] are the quadrature points.
    """

    at_points: tuple[Any, ...]
    at_nodes: tuple[Any, ...]
    points: Array


def recovery(grid: Grid) -> Recovery:
    """Give the recovery operators of a grid."""
    basis = elastic.basis_of(grid, vector=False, order=GAUSS)
    # (m, q, a, x): derivative of shape function a along x at point q of element m
    slopes = np.stack([shape[0].grad for shape in basis.basis]).transpose(2, 3, 0, 1)
    points = np.asarray(basis.global_coordinates()).transpose(1, 2, 0).reshape(-1, grid.dimension)
    at_points = tuple(_matrix(slopes[..., x], grid.cells, grid) for x in range(grid.dimension))
    fit = nodal_fit(grid, points)
    return Recovery(at_points, tuple((fit @ operator).tocsr() for operator in at_points), points)


def stresses(operators: tuple[Any, ...], found: Array, material: Material) -> Array:
    """Give the stress components [Pa] (components, points, c) of displacements (n d, c) [m], by Hooke's law.

    In the plane this is plane stress.
    """
    dimension = len(operators)
    moved = [found[axis::dimension] for axis in range(dimension)]
    lame, shear = elastic.lame_parameters(material, dimension)
    normal = [operators[axis] @ moved[axis] for axis in range(dimension)]
    pressure = lame * sum(normal)
    return np.stack(
        [
            2 * shear * normal[i] + pressure if i == j else shear * (operators[i] @ moved[j] + operators[j] @ moved[i])
            for i, j in (PLANE if dimension == 2 else SPACE)
        ]
    )


def von_mises(stress: Array) -> Array:
    """Give the von Mises stress [Pa] of components (3 or 6, ...)."""
    if len(stress) == 3:
        xx, yy, xy = stress
        return np.sqrt(xx * xx - xx * yy + yy * yy + 3 * xy * xy)
    xx, yy, zz, yz, xz, xy = stress
    differences = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(differences / 2 + 3 * (yz * yz + xz * xz + xy * xy)))


def principal(stress: Array) -> Array:
    """Give the principal stresses [Pa] (..., d), the largest first, of components (3 or 6, ...)."""
    pairs = PLANE if len(stress) == 3 else SPACE
    dimension = 2 if len(stress) == 3 else 3
    tensor = np.zeros((*stress.shape[1:], dimension, dimension))
    for component, (i, j) in zip(stress, pairs, strict=True):
        tensor[..., i, j] = tensor[..., j, i] = component
    return np.asarray(np.linalg.eigvalsh(tensor)[..., ::-1])


def _matrix(slopes: Array, cells: Integers, grid: Grid) -> Any:
    """Assemble the blocks (m, q, a) of the elements into a sparse matrix (m q, n)."""
    rows = np.arange(slopes.shape[0] * slopes.shape[1]).reshape(slopes.shape[:2])
    i = np.broadcast_to(rows[:, :, np.newaxis], slopes.shape).ravel()
    j = np.broadcast_to(cells[:, np.newaxis, :], slopes.shape).ravel()
    return sparse.coo_matrix((slopes.ravel(), (i, j)), shape=(rows.size, len(grid.points))).tocsr()
