"""Distance at which contact stress ends and bulk stress begins: the plateau of the largest stress over the distance.

Near a narrow patch stress falls as 1/distance (Flamant), so the largest stress beyond a fixed distance from the patches
would depend on that distance. The stress of the part itself is a plateau of that maximum over a ladder of distances.
Conformal patches, over which stress is distributed, belong to the bulk; sharp inner corners do not.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.stress.case import LoadCase
from cycloid_mj.stress.grid import Grid

RUNGS_PER_OCTAVE = 2
"""Rungs of the ladder of distances to twice a distance."""

MAX_PLATEAU_DROP = 0.05
"""Relative drop of the largest stress to the next rung below which it is on a plateau."""


@dataclass(frozen=True)
class Distances:
    """Distance of each node of a part from narrow patches at k angles, and which nodes are at sharp corners.

    Attributes
    ----------
    points
        Nodes (n, d) [m].
    outside
        Distance of each node along z from the heights at which contact forces act (n,) [m]; 0 in a plane.
    patches, ends
        Centres of narrow patches (p, 2) [m] in the order of their angles, and first index of each angle (k + 1,).
    at_corner
        Whether each node is so near to a sharp corner that it is never in the bulk (n,).
    vertices
        Number of nodes, the first, that are corners of elements.
    """

    points: Array
    outside: Array
    patches: Array
    ends: Integers
    at_corner: Mask
    vertices: int

    def at(self, angle: int, nodes: Integers) -> Array:
        """Compute the distance [m] of nodes from narrow patches at an angle, inf without patches; 0 at corners."""
        here = self.patches[self.ends[angle] : self.ends[angle + 1]]
        squared = cdist(here, self.points[nodes, :2], "sqeuclidean").min(axis=0, initial=np.inf)
        return np.where(self.at_corner[nodes], 0.0, np.sqrt(squared + self.outside[nodes] ** 2))

    def farthest(self) -> float:
        """Compute the largest distance [m] beyond which one of the part's vertices is left at every angle."""
        vertices = np.arange(self.vertices)
        return min(float(self.at(angle, vertices).max()) for angle in range(len(self.ends) - 1))


def distances_of(grid: Grid, case: LoadCase) -> Distances:
    """Compute the distances of a part's nodes from the patches of its case, at all of its angles, and its corners."""
    points = grid.points
    outside = np.zeros(len(points))
    if grid.section is not None:
        heights = points[grid.section.nodes.max(axis=1), 2]
        outside = np.maximum(0.0, np.maximum(heights.min() - points[:, 2], points[:, 2] - heights.max()))
    at_corner = np.zeros(len(points), bool)
    if len(grid.keep_off):
        at_corner = np.asarray(cKDTree(grid.keep_off).query(points)[0]) < grid.corner_distance
    order = np.argsort(case.angle, kind="stable")
    ends = np.searchsorted(case.angle[order], np.arange(case.angles + 1))
    return Distances(points, outside, case.points[order, :2], ends, at_corner, grid.mesh.nvertices)


def ladder(distances: Distances, start: float) -> Array:
    """Return the distances [m] (s,), from half the start on, beyond which a part has nodes at each angle.

    If the farthest such distance is below the start, it is the last.
    """
    rungs = start / 2.0 * np.sqrt(2.0) ** np.arange(16)
    rungs_with_nodes = rungs[rungs <= distances.farthest()]
    return (
        rungs_with_nodes
        if len(rungs_with_nodes) > RUNGS_PER_OCTAVE
        else np.append(rungs_with_nodes, distances.farthest() * (1.0 - 1e-9))
    )


def largest(node_distances: Distances, distances: Array, angle: int, stress: Array) -> tuple[Array, Integers]:
    """Compute the largest von Mises stress [Pa] (s,) beyond each distance at an angle, and its node (s,).

    `stress` is that of all nodes, (n,). Nodes with the largest stress are searched first, in bands, and others only for
    distances beyond which there is none of these.
    """
    chosen, missing = np.zeros(len(distances), np.int64), np.arange(len(distances))
    top = np.inf
    for bottom in np.append(0.35 ** np.arange(1, 5), 0.0) * stress.max():
        nodes = np.flatnonzero((stress >= bottom) & (stress < top))
        beyond = node_distances.at(angle, nodes) >= distances[missing, np.newaxis]
        found = beyond.any(axis=1)
        if len(nodes):
            chosen[missing] = nodes[np.where(beyond, stress[nodes], -1.0).argmax(axis=1)]
        missing, top = missing[~found], bottom
        if not len(missing):
            break
    return stress[chosen], chosen


def plateau(sizes: Array, first: int) -> int:
    """Return the rung, from the first on, at which the largest stresses (s,) of a turn reach a plateau.

    It is the first rung with a drop below `MAX_PLATEAU_DROP` to the next, or that before the smallest drop.
    """
    first = min(first, len(sizes) - 1)
    falls = 1.0 - sizes[first + 1 :] / np.maximum(sizes[first:-1], np.finfo(float).tiny)
    flat = np.flatnonzero(falls < MAX_PLATEAU_DROP)
    if len(flat):
        return first + int(flat[0])
    return first + int(falls.argmin()) if len(falls) else first


def fall(sizes: Array, rung: int) -> float:
    """Compute how far the largest stress falls from a rung to twice its distance, as a share; 1 for nothing left."""
    beyond = sizes[rung + RUNGS_PER_OCTAVE] if rung + RUNGS_PER_OCTAVE < len(sizes) else 0.0
    return float(1.0 - beyond / sizes[rung]) if sizes[rung] > 0.0 else 0.0
