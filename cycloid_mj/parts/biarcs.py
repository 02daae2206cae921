"""Splines as arcs within a tolerance: biarcs, pairs of arcs with a common tangent, which match both ends and tangents.

The middle point is that of equal distances from both ends along their tangents (Bolton 1975, Comput. Aided Des. 7).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.parts.curve import Arc, LineSegment, Spline

if TYPE_CHECKING:
    from scipy.interpolate import BSpline


@dataclass(frozen=True)
class BiarcFit:
    """Settings of the approximation of splines by biarcs."""

    checks: int = 9  # points of a spline between the ends of a biarc at which its deviation is measured
    min_height: float = 1e-12  # height of an arc over its chord below which it is a line [m]


FIT = BiarcFit()


def arcs_of(spline: Spline, tolerance: float) -> tuple[Arc | LineSegment, ...]:
    """Return consecutive arcs, and lines where they are straight, within a tolerance [m] of a spline."""
    from scipy.interpolate import BSpline

    curve = BSpline(spline.knots, spline.controls, 3)
    return tuple(_fit_arcs(curve, curve.derivative(), spline.knots[0], spline.knots[-1], tolerance))


def _fit_arcs(
    curve: "BSpline", derivative: "BSpline", start_parameter: float, end_parameter: float, tolerance: float
) -> Iterator[Arc | LineSegment]:
    """Yield arcs and lines that approximate a spline between two of its parameters within a tolerance [m].

    A biarc replaces the spline; if it deviates by more than the tolerance, the interval is halved.

    Parameters
    ----------
    curve, derivative
        The spline [m], and its derivative.
    start_parameter, end_parameter
        Parameters of both ends.
    tolerance
        Largest distance from the spline [m].
    """
    (start, end), tangents = curve([start_parameter, end_parameter]), derivative([start_parameter, end_parameter])
    tangents = tangents / np.linalg.norm(tangents, axis=1)[:, np.newaxis]
    pieces = _make_biarc(start, tangents[0], end, tangents[1])
    points = curve(np.linspace(start_parameter, end_parameter, FIT.checks + 2)[1:-1])
    if np.min([_deviation(piece, points) for piece in pieces], axis=0).max() <= tolerance:
        yield from pieces
        return
    midpoint = 0.5 * (start_parameter + end_parameter)
    yield from _fit_arcs(curve, derivative, start_parameter, midpoint, tolerance)
    yield from _fit_arcs(curve, derivative, midpoint, end_parameter, tolerance)


def _make_biarc(start: Array, start_tangent: Array, end: Array, end_tangent: Array) -> tuple[Arc | LineSegment, ...]:
    """Return the biarc between two points: two arcs (or lines) with a common tangent at their junction.

    Parameters
    ----------
    start, end
        Both points (2,) [m].
    start_tangent, end_tangent
        Unit tangents (2,) there.
    """
    chord, turning_measure = end - start, 1.0 - float(start_tangent @ end_tangent)
    chord_component = float(chord @ (start_tangent + end_tangent))
    squared_chord = float(chord @ chord)
    tangent_length = squared_chord / (
        chord_component + math.sqrt(chord_component**2 + 2.0 * turning_measure * squared_chord)
    )
    junction = 0.5 * (start + end + tangent_length * (start_tangent - end_tangent))
    return _make_arc(start, start_tangent, junction), _make_arc(end, -end_tangent, junction)


def _make_arc(start: Array, tangent: Array, end: Array) -> Arc | LineSegment:
    """Return the arc from `start` to `end` (2,) [m] with the unit `tangent` at the start; a line if it is flat.

    An `Arc` is counter-clockwise, so a clockwise arc is returned as the same arc from `end` to `start`.
    """
    chord, normal = end - start, np.array([-tangent[1], tangent[0]])
    height = float(normal @ chord)
    if abs(height) < FIT.min_height:
        return LineSegment((float(start[0]), float(start[1])), (float(end[0]), float(end[1])))
    radius = float(chord @ chord) / (2.0 * height)
    centre = start + radius * normal
    start_angle, end_angle = (math.atan2(*(point - centre)[::-1]) for point in (start, end))
    min_angle, max_angle = (start_angle, end_angle) if radius > 0.0 else (end_angle, start_angle)
    return Arc(
        (float(centre[0]), float(centre[1])),
        abs(radius),
        min_angle,
        min_angle + (max_angle - min_angle) % (2.0 * math.pi),
    )


def _deviation(piece: Arc | LineSegment, points: Array) -> Array:
    """Compute the distances of points from an arc's circle, or from a line [m]."""
    if isinstance(piece, Arc):
        return np.asarray(np.abs(np.linalg.norm(points - np.array(piece.centre), axis=1) - piece.radius))
    start, chord = np.array(piece.start), np.subtract(piece.end, piece.start)
    x, y = (points - start).T
    return np.asarray(np.abs(x * chord[1] - y * chord[0]) / np.linalg.norm(chord))
