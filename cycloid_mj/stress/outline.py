"""Closed outlines divided into the edges of a grid: finer where they are tight, where bodies touch, or near a focus.

An outline comes as a polygon so fine that its chords do not matter; the nodes of the grid, and the middles of its
quadratic edges, lie on it.
"""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Mask


@dataclass(frozen=True)
class Sizing:
    """Target edge lengths of an outline.

    `edge` is the longest edge [m], `turn` the longest as a share of the radius of curvature, and `finest` the shortest
    that curvature may request [m]. `focus` (n, 3) are rows (x, y, edge) [m]: positions where edges are that short.
    `growth` is the growth of edges along the outline and away from a focus, per length.
    """

    edge: float
    turn: float
    finest: float
    focus: Array
    growth: float = 0.25


@dataclass(frozen=True)
class QuadraticOutline:
    """A closed outline as quadratic edges: edge i runs from `nodes[i]` over `middles[i]` to `nodes[i + 1]` [m].

    `sizes` (n,) [m] is the target edge length at each node.
    """

    nodes: Array
    middles: Array
    sizes: Array


def divide_outline(polygon: Array, sizing: Sizing) -> QuadraticOutline:
    """Divide a closed polygon of n points [m] into quadratic edges; return their nodes, middles and lengths [m].

    `polygon` has the shape (n, 2). `sizing` determines the target lengths; corners of the polygon are nodes. The number
    of edges between two corners is the integral of 1/(target length) along the outline, rounded up. An outline has at
    least 12 edges.
    """
    points, is_corner, radius = _subdivide_polygon(polygon, sizing)
    arcs = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1))])
    edge_length = _limit_growth(_target_edges(points, radius, sizing), arcs, sizing.growth)
    closed_lengths = np.append(edge_length, edge_length[0])
    edge_count = np.concatenate(
        [[0.0], np.cumsum((1 / closed_lengths[1:] + 1 / closed_lengths[:-1]) / 2 * np.diff(arcs))]
    )
    corner_indices = np.flatnonzero(is_corner) if is_corner.any() else np.array([0])
    start_counts = edge_count[corner_indices]
    end_counts = np.append(start_counts[1:], start_counts[0] + edge_count[-1])
    min_edges = max(1, math.ceil(12 / len(corner_indices)))  # a circle keeps its shape
    node_counts = np.concatenate(
        [
            np.linspace(start_count, end_count, max(min_edges, math.ceil(end_count - start_count)) + 1)[:-1]
            for start_count, end_count in zip(start_counts, end_counts, strict=True)
        ]
    )
    node_arcs = np.interp(np.append(node_counts, node_counts[0] + edge_count[-1]) % edge_count[-1], edge_count, arcs)
    next_arcs = np.where(node_arcs[1:] > node_arcs[:-1], node_arcs[1:], node_arcs[1:] + arcs[-1])
    return QuadraticOutline(
        nodes=_along(points, arcs, node_arcs[:-1]),
        middles=_along(points, arcs, (node_arcs[:-1] + next_arcs) / 2 % arcs[-1]),
        sizes=np.interp(node_arcs[:-1], arcs, closed_lengths),
    )


def _target_edges(points: Array, radius: Array, sizing: Sizing) -> Array:
    """Compute the target edge length [m] at each point (n, 2) with a radius of curvature [m] (n,), before grading."""
    size = np.minimum(sizing.edge, np.maximum(sizing.turn * radius, sizing.finest))
    for x, y, edge in sizing.focus:
        size = np.minimum(size, edge + sizing.growth * np.hypot(points[:, 0] - x, points[:, 1] - y))
    return size


def _subdivide_polygon(polygon: Array, sizing: Sizing) -> tuple[Array, Mask, Array]:
    """Halve the edges of a closed polygon of n points (n, 2) [m] until each has at most half its target length.

    `sizing` determines the target lengths.

    Returns
    -------
    points, is_corner, radius
        The m points of the divided polygon (m, 2) [m], whether each is a corner, and the radius of curvature [m] there,
        inf at corners; (m,) each.
    """
    edge_before, edge_after = polygon - np.roll(polygon, 1, axis=0), np.roll(polygon, -1, axis=0) - polygon
    cross = edge_before[:, 0] * edge_after[:, 1] - edge_before[:, 1] * edge_after[:, 0]
    turn_angle = np.abs(np.arctan2(cross, np.sum(edge_before * edge_after, axis=1)))
    mean_length = (np.linalg.norm(edge_before, axis=1) + np.linalg.norm(edge_after, axis=1)) / 2
    is_corner = turn_angle > 0.15  # rad: edges of a polygon that approximates an arc turn by less
    radius = np.where(is_corner, np.inf, mean_length / np.maximum(turn_angle, 1e-300))
    points = polygon
    while True:
        next_points = np.roll(points, -1, axis=0)
        edge_radius = np.minimum(radius, np.roll(radius, -1))
        midpoints = (points + next_points) / 2
        is_too_long = np.linalg.norm(next_points - points, axis=1) > _target_edges(midpoints, edge_radius, sizing) / 2
        if not is_too_long.any():
            return points, is_corner, radius
        insertions = np.flatnonzero(is_too_long) + 1
        points = np.insert(points, insertions, midpoints[is_too_long], axis=0)
        is_corner = np.insert(is_corner, insertions, False)
        radius = np.insert(radius, insertions, edge_radius[is_too_long])


def _limit_growth(edge_length: Array, arc: Array, growth: float) -> Array:
    """Reduce n edge lengths [m] so that their growth along a closed outline is at most `growth` in both directions.

    Parameters
    ----------
    edge_length
        Edge lengths at the n points before the limitation [m].
    arc
        Arc length at each point, then the length of the closed outline [m], (n + 1,).
    growth
        Largest growth of the edge length per length of the outline [1].
    """
    repeated_lengths, repeated_arc = np.tile(edge_length, 2), np.concatenate([arc[:-1], arc[:-1] + arc[-1]])
    forward_limit = np.minimum.accumulate(repeated_lengths - growth * repeated_arc) + growth * repeated_arc
    backward_limit = (
        np.minimum.accumulate((repeated_lengths + growth * repeated_arc)[::-1])[::-1] - growth * repeated_arc
    )
    return np.minimum(forward_limit[len(edge_length) :], backward_limit[: len(edge_length)])


def _along(points: Array, arc: Array, positions: Array) -> Array:
    closed_points = np.vstack([points, points[:1]])
    return np.column_stack(
        [np.interp(positions, arc, closed_points[:, 0]), np.interp(positions, arc, closed_points[:, 1])]
    )
