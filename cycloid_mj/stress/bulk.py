"""Where stress counts as bulk: farther than a distance from every loaded patch, and from sharp inner corners."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from cycloid_mj.stress.case import Case
from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.probe import probe
from cycloid_mj.stress.recover import von_mises

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Indices = npt.NDArray[np.int64]

RIM_POINTS = 24
"""Points on the circle about each narrow patch where the bulk begins."""


@dataclass(frozen=True)
class Bulk:
    """The bulk of a part at each of its k angles, for one distance.

    Attributes
    ----------
    distance
        From every loaded patch [m].
    near
        Nodes that are not in the bulk, for each angle.
    rim
        Points just where the bulk begins about narrow patches.
    points
        All nodes (n, d) [m].
    """

    distance: float
    near: tuple[Indices, ...]
    rim: "Rim"
    points: Array

    def largest(self, block: Indices, components: Array, stress: Array) -> tuple[Array, Array]:
        """Give the largest von Mises stress (c,) [Pa] of each angle of a block, nan without bulk, and where (c, d) [m].

        `components` and `stress` are those of all nodes, (3 or 6, n, c) and (n, c).
        """
        found = np.full(len(block), np.nan)
        place = np.full((len(block), self.points.shape[1]), np.nan)
        for column, angle in enumerate(block):
            left = stress[:, column].copy()
            left[self.near[angle]] = -1.0
            node = int(left.argmax())
            if left[node] >= 0.0:
                found[column], place[column] = left[node], self.points[node]
            on_rim, where = self.rim.stress(int(angle), components[..., column])
            if len(on_rim) and not on_rim.max() <= found[column]:
                found[column], place[column] = on_rim.max(), where[on_rim.argmax()]
        return found, place


@dataclass(frozen=True)
class Rim:
    """Points on circles of the bulk distance about narrow patches, as far as they lie in the bulk.

    There the bulk stress of a part in contact is largest; the nearest nodes would find it only by chance.

    Attributes
    ----------
    points
        In the plane (p, 2) [m], in the order of their angles.
    ends
        Where the points of each angle begin, (k + 1,).
    operator
        From values at the section's nodes to the points, sparse (p, n2).
    nodes
        The part's node over each node of the section, at h heights (h, n2), and their z [m] (h,); z is empty in a
        planar part.
    """

    points: Array
    ends: Indices
    operator: Any
    nodes: Indices
    z: Array

    def stress(self, angle: int, components: Array) -> tuple[Array, Array]:
        """Give the von Mises stress [Pa] (h p,) of components (3 or 6, n) at the points of an angle, and their places.

        Places are (h p, d) [m].
        """
        chosen = slice(self.ends[angle], self.ends[angle + 1])
        points = self.points[chosen]
        if not len(points):
            return np.zeros(0), points
        operator = self.operator[chosen]
        at_heights = np.stack([operator @ component[self.nodes].T for component in components])  # (components, p, h)
        places = points if not len(self.z) else _over(points, self.z)
        return von_mises(at_heights).T.ravel(), places


def bulk(grid: Grid, case: Case, distance: float) -> Bulk:
    """Give the bulk of a part, farther than a distance [m] from the loaded patches of its case."""
    always = _near_corners(grid, distance)
    near = [np.union1d(always, nodes) for nodes in _near(grid, case, distance)]
    return Bulk(distance, tuple(near), _rim(grid, case, distance), grid.points)


def nodes_near_patches(grid: Grid, case: Case, distance: float, angle: int) -> Indices:
    """Give the nodes that are not in the bulk at the angle of an index."""
    return np.union1d(_near_corners(grid, distance), _near(grid, case, distance)[angle])


def _near(grid: Grid, case: Case, distance: float) -> list[Indices]:
    """Nodes within a distance of the loaded patches of each angle; in a solid, of the lines that they stand for."""
    if not len(case.points):
        return [np.zeros(0, np.int64)] * len(case.resolved)
    plane = grid if grid.section is None else grid.section.grid
    order = np.argsort(case.angle, kind="stable")
    found: Any = cKDTree(plane.points).query_ball_point(case.points[order], distance, return_sorted=False)
    ends = np.searchsorted(case.angle[order], np.arange(len(case.resolved) + 1))
    close = [np.array(list(itertools.chain.from_iterable(found[a:b])), np.int64) for a, b in itertools.pairwise(ends)]
    if grid.section is None:
        return close
    above = [grid.section.nodes[:, nodes].ravel() for nodes in close]
    return [nodes[nodes >= 0] for nodes in above]


def _near_corners(grid: Grid, distance: float) -> Indices:
    if not len(grid.keep_off):
        return np.zeros(0, np.int64)
    apart, _ = cKDTree(grid.keep_off).query(grid.points)
    return np.flatnonzero(apart < distance)


def _rim(grid: Grid, case: Case, distance: float) -> Rim:
    plane = grid if grid.section is None else grid.section.grid
    nodes = np.arange(len(grid.points))[np.newaxis] if grid.section is None else grid.section.nodes
    centres, owners = case.points[case.narrow], case.angle[case.narrow]
    if not len(centres):
        return Rim(np.zeros((0, 2)), np.zeros(len(case.resolved) + 1, np.int64), None, nodes, np.zeros(0))
    turn = 2 * np.pi * np.arange(RIM_POINTS) / RIM_POINTS
    circle = distance * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    angle = np.repeat(owners, RIM_POINTS)
    points = (centres[:, np.newaxis] + circle).reshape(-1, 2)
    apart = 1e3 * float(np.ptp(plane.points))  # the angles lie on planes, one above the other
    nearest, _ = cKDTree(np.column_stack([case.points, apart * case.angle])).query(
        np.column_stack([points, apart * angle])
    )
    kept = nearest > distance * (1 - 1e-6)
    operator, inside = probe(plane, points[kept])
    inside &= np.asarray(abs(operator) @ (nodes < 0).any(axis=0)) == 0.0
    points, angle = points[kept][inside], angle[kept][inside]
    order = np.argsort(angle, kind="stable")
    ends = np.searchsorted(angle[order], np.arange(len(case.resolved) + 1))
    z = np.zeros(0) if grid.section is None else grid.points[nodes.max(axis=1), 2]
    return Rim(points[order], ends, operator[inside][order], nodes, z)


def _over(points: Array, z: Array) -> Array:
    """Put points (p, 2) at heights (h,): places (h p, 3)."""
    return np.column_stack([np.tile(points, (len(z), 1)), np.repeat(z, len(points))])
