"""Distance at which contact stress ends and bulk stress begins: the plateau of the largest stress over the distance.

Near a narrow patch stress falls as 1/distance (Flamant), so the largest stress beyond a fixed distance from the patches
would depend on that distance. The stress of the part itself is a plateau of that maximum over increasing distances.
Conformal patches, over which stress is distributed, belong to the bulk; sharp inner corners do not.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.stress.case import LoadCase
from cycloid_mj.stress.grid import Grid

DISTANCES_PER_OCTAVE = 2
"""Number of search distances from a distance to twice that distance (heuristic)."""

MAX_PLATEAU_DROP = 0.05
"""Relative drop of the largest stress to the next distance below which it is on a plateau (heuristic)."""


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

    def from_patches(self, angle_index: int, nodes: Integers) -> Array:
        """Compute the distance [m] of nodes from the nearest narrow contact patch at one crank angle.

        `angle_index` is the index of the angle, `nodes` are indices of nodes; the result has the shape of `nodes`. It
        is inf without patches. It is 0 for nodes next to sharp corners, whose stress is never bulk stress.
        """
        centres = self.patches[self.ends[angle_index] : self.ends[angle_index + 1]]
        squared_distance = cdist(centres, self.points[nodes, :2], "sqeuclidean").min(axis=0, initial=np.inf)
        return np.where(self.at_corner[nodes], 0.0, np.sqrt(squared_distance + self.outside[nodes] ** 2))

    def farthest(self) -> float:
        """Compute the largest distance [m] beyond which one of the part's vertices is left at every angle."""
        vertices = np.arange(self.vertices)
        return min(float(self.from_patches(angle, vertices).max()) for angle in range(len(self.ends) - 1))


def measure_distances(grid: Grid, case: LoadCase) -> Distances:
    """Return distances [m] of the nodes of `grid` from narrow contact patches of a loaded part, per crank angle.

    `grid` is the finite-element mesh of the part, and `case` has the contact patches at each crank angle.
    """
    points = grid.points
    axial_distance = np.zeros(len(points))
    if grid.section is not None:
        heights = points[grid.section.nodes.max(axis=1), 2]
        axial_distance = np.maximum(0.0, np.maximum(heights.min() - points[:, 2], points[:, 2] - heights.max()))
    is_at_corner = np.zeros(len(points), bool)
    if len(grid.singular_points):
        is_at_corner = np.asarray(cKDTree(grid.singular_points).query(points)[0]) < grid.corner_distance
    angle_order = np.argsort(case.angle, kind="stable")
    patch_ends = np.searchsorted(case.angle[angle_order], np.arange(case.angles + 1))
    return Distances(
        points, axial_distance, case.points[angle_order, :2], patch_ends, is_at_corner, grid.mesh.nvertices
    )


def search_distances(distances: Distances, start: float) -> Array:
    """Return s increasing distances from contact patches [m], shape (s,), at which the largest stress is evaluated.

    They serve to find the distance from which on the largest stress is nearly constant. The first distance is half of
    `start` [m], and each next distance is larger by the factor sqrt(2). The series ends at the limit
    `distances.farthest`, beyond which no vertex of the part is left at some crank angle. If there are fewer than three
    distances up to the limit, the limit itself is appended.
    """
    candidates = start / 2.0 * np.sqrt(2.0) ** np.arange(16)
    reached_distances = candidates[candidates <= distances.farthest()]
    return (
        reached_distances
        if len(reached_distances) > DISTANCES_PER_OCTAVE
        else np.append(reached_distances, distances.farthest() * (1.0 - 1e-9))
    )


def largest_beyond(node_distances: Distances, distances: Array, angle: int, stress: Array) -> tuple[Array, Integers]:
    """Compute the largest von Mises stress farther than each of s distances from contact patches, at a crank angle.

    Parameters
    ----------
    node_distances
        Distances of the nodes from patches and corners.
    distances
        Distances [m], shape (s,).
    angle
        Index of the crank angle.
    stress
        Von Mises stress of all n nodes [Pa], shape (n,).

    Returns
    -------
    tuple
        Largest stress [Pa] and index of its node, shape (s,) each.
    """
    largest_nodes, pending = np.zeros(len(distances), np.int64), np.arange(len(distances))
    upper_stress = np.inf
    for lower_stress in np.append(0.35 ** np.arange(1, 5), 0.0) * stress.max():
        nodes = np.flatnonzero((stress >= lower_stress) & (stress < upper_stress))
        is_beyond = node_distances.from_patches(angle, nodes) >= distances[pending, np.newaxis]
        has_node = is_beyond.any(axis=1)
        if len(nodes):
            largest_nodes[pending] = nodes[np.where(is_beyond, stress[nodes], -1.0).argmax(axis=1)]
        pending, upper_stress = pending[~has_node], lower_stress
        if not len(pending):
            break
    return stress[largest_nodes], largest_nodes


def find_plateau(stress_by_distance: Array, first_index: int) -> int:
    """Return the index of the distance at which the largest stress reaches a plateau, searched from `first_index` on.

    `stress_by_distance` [Pa], shape (s,), is the largest stress beyond each of the s distances of `search_distances`.
    The result is the first index with a relative drop below `MAX_PLATEAU_DROP` to the next distance, or else the index
    with the smallest drop.
    """
    first_index = min(first_index, len(stress_by_distance) - 1)
    relative_drops = 1.0 - stress_by_distance[first_index + 1 :] / np.maximum(
        stress_by_distance[first_index:-1], np.finfo(float).tiny
    )
    flat_steps = np.flatnonzero(relative_drops < MAX_PLATEAU_DROP)
    if len(flat_steps):
        return first_index + int(flat_steps[0])
    return first_index + int(relative_drops.argmin()) if len(relative_drops) else first_index


def relative_drop(stress_by_distance: Array, index: int) -> float:
    """Compute the relative drop [1] of the largest stress between a distance and twice that distance.

    Parameters
    ----------
    stress_by_distance
        Largest stress [Pa] beyond each of the s distances from patches of `search_distances`, shape (s,).
    index
        Index of the distance.

    Returns
    -------
    float
        The drop; 1 if no node is left at twice the distance, 0 without stress.
    """
    stress_beyond = (
        stress_by_distance[index + DISTANCES_PER_OCTAVE]
        if index + DISTANCES_PER_OCTAVE < len(stress_by_distance)
        else 0.0
    )
    return float(1.0 - stress_beyond / stress_by_distance[index]) if stress_by_distance[index] > 0.0 else 0.0
