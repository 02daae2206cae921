"""Quality of a convex decomposition, measured along the normals of the true surface."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.statistics import rms
from cycloid_mj.parts.convex.settings import METHOD
from cycloid_mj.parts.convex.surface import ConvexSurface, placed_outline
from cycloid_mj.parts.polygon import area_moments


@dataclass(frozen=True)
class Quality:
    """Deviation of the union of convex pieces from the true surface, along its normals.

    Attributes
    ----------
    parts
        Number of convex pieces.
    max_overfill, rms_overfill
        Beyond the surface, out of the material [m].
    max_underfill, rms_underfill
        Short of the surface, into the material [m].
    volume_error
        Sum of the volumes of the pieces relative to the true volume, less 1.
    samples
        Number of measured normals.
    """

    parts: int
    max_overfill: float
    rms_overfill: float
    max_underfill: float
    rms_underfill: float
    volume_error: float
    samples: int


@dataclass(frozen=True)
class ConvexRegion:
    """A convex region as half spaces, `normals` (m, d) . x <= `offsets` (m,), within the ball `centre`, `radius`."""

    normals: Array
    offsets: Array
    centre: Array
    radius: float


def polygon_body(outline: Array) -> ConvexRegion:
    """Build the half planes of a counter-clockwise convex polygon (n, 2)."""
    edges = np.roll(outline, -1, axis=0) - outline
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1)[:, np.newaxis]
    centre = outline.mean(axis=0)
    radius = float(np.linalg.norm(outline - centre, axis=1).max())
    return ConvexRegion(normals, np.sum(normals * outline, axis=1), centre, radius)


def hull_body(vertices: Array) -> ConvexRegion:
    """Return the convex hull of n points `vertices` (n, 3) [m] as an intersection of half spaces."""
    from scipy.spatial import ConvexHull

    scale = np.ptp(vertices, axis=0)
    planes = ConvexHull((vertices - vertices[0]) / scale).equations
    normals = planes[:, :3] / scale
    normal_length = np.linalg.norm(normals, axis=1)
    normals /= normal_length[:, np.newaxis]
    centre = vertices.mean(axis=0)
    radius = float(np.linalg.norm(vertices - centre, axis=1).max())
    return ConvexRegion(normals, normals @ vertices[0] - planes[:, 3] / normal_length, centre, radius)


def union_heights(
    points: Array, normals: Array, bodies: Sequence[ConvexRegion], start: float, reach: float, seam: float = METHOD.seam
) -> Array:
    """Compute the height above the surface [m] at which the union of convex bodies ends along each normal, shape (k,).

    It is -`start` where no body covers the start of the search, and at most `reach`.

    Parameters
    ----------
    points, normals
        The k points of the true surface in d dimensions (k, d) [m], and unit normals out of the material.
    bodies
        Convex bodies, of the same dimension.
    start
        Depth below the surface at which the outward search starts [m]; gaps above it are detected.
    reach
        Height above the surface at which the search ends [m].
    seam
        Width up to which a gap between two bodies is ignored [m], because it is due to rounding or to a grid.
    """
    line_index, line_start, line_end = _inside_intervals(points, normals, bodies, max(start, reach))
    heights = np.full(len(points), -start)
    while True:
        is_joined = line_start <= heights[line_index] + seam
        extended_end = heights.copy()
        np.maximum.at(extended_end, line_index[is_joined], line_end[is_joined])
        if not (extended_end > heights).any():
            return np.minimum(heights, reach)
        heights = extended_end


def surface_quality(surface: ConvexSurface) -> Quality:
    """Measure how far convex slices protrude from a working surface (overfill) or stay below it (underfill) [m].

    Raises
    ------
    DesignError
        A deviation exceeds `overfill_bound` or `underfill_bound` of the surface.
    """
    outlines = [placed_outline(surface, placement) for placement in surface.places]
    search_depth, max_height = 0.5 * surface.depth, surface.depth
    heights = union_heights(
        surface.points, surface.normals, [polygon_body(outline) for outline in outlines], search_depth, max_height
    )
    area = math.fsum(area_moments(outline).area for outline in outlines)
    quality = summarize_quality(heights, len(outlines), area / surface.strip_area - 1.0)
    require_within(surface.name, quality, surface.overfill_bound, surface.underfill_bound)
    return quality


def summarize_quality(heights: Array, parts: int, volume_error: float) -> Quality:
    """Return maximum and RMS of the deviations of convex pieces from a surface, with number and volume error.

    `heights` (k,) [m] are the deviations at k points, positive above the surface. `parts` is the number of pieces.
    `volume_error` is the sum of their volumes over the true volume, minus 1.
    """
    overfill, underfill = np.maximum(heights, 0.0), np.maximum(-heights, 0.0)
    return Quality(
        parts=parts,
        max_overfill=float(overfill.max()),
        rms_overfill=rms(overfill),
        max_underfill=float(underfill.max()),
        rms_underfill=rms(underfill),
        volume_error=volume_error,
        samples=len(heights),
    )


def require_within(name: str, quality: Quality, overfill: float, underfill: float) -> None:
    """Raise DesignError if convex pieces overfill or underfill a surface by more than the bounds [m].

    `name` is the name of the surface, for the message; `overfill` and `underfill` are the bounds. `quality` has the
    deviations.
    """
    sides = (
        ("extend beyond its outline", quality.max_overfill, overfill),
        ("fall short of its outline", quality.max_underfill, underfill),
    )
    for verb, deviation, bound in sides:
        if not deviation <= bound:
            raise DesignError(
                f"convex pieces of the {name} {verb} by {1e6 * deviation:.4g} um, but at most {1e6 * bound:.4g} um are "
                "allowed: reduce chord_error or depth of ConvexSettings"
            )


def _inside_intervals(
    points: Array, normals: Array, bodies: Sequence[ConvexRegion], max_distance: float
) -> tuple[npt.NDArray[np.intp], Array, Array]:
    """Compute the intervals in which lines along the surface normals are inside convex bodies.

    Parameters
    ----------
    points, normals
        The k points in d dimensions (k, d) [m], and unit normals (k, d).
    bodies
        Convex bodies, of the same dimension.
    max_distance
        Distance [m] from a point beyond which bodies are skipped.

    Returns
    -------
    tuple of Array
        For each interval of a line inside a body: index of the line, and start and end along the normal [m].
    """
    intervals = []
    for body in bodies:
        near_points = np.flatnonzero(np.linalg.norm(points - body.centre, axis=1) <= body.radius + max_distance)
        if not len(near_points):
            continue
        slope = normals[near_points] @ body.normals.T
        plane_distance = body.offsets - points[near_points] @ body.normals.T
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = plane_distance / slope
        line_start = np.where(slope < -METHOD.parallel, crossing, -np.inf).max(axis=1)
        line_end = np.where(slope > METHOD.parallel, crossing, np.inf).min(axis=1)
        is_outside = ((np.abs(slope) <= METHOD.parallel) & (plane_distance < -METHOD.seam)).any(axis=1)
        is_inside = (line_start <= line_end) & ~is_outside
        intervals.append((near_points[is_inside], line_start[is_inside], line_end[is_inside]))
    line_index, line_start, line_end = (np.concatenate(column) for column in zip(*intervals, strict=True))
    return line_index, line_start, line_end
