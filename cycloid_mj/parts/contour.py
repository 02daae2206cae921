"""Closed contours, as exact curves for CAD and as polygons for meshes, masses and pictures."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.parts.accuracy import SAME_LENGTH
from cycloid_mj.parts.curve import Circle, Curve, rotate_curve
from cycloid_mj.parts.polygon import circle, rotate_points


class Contour(Protocol):
    """A closed contour in the plane of a part, counter-clockwise."""

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return its consecutive curves, with `splines` splines per lobe or root."""
        ...

    def polygon(self, chord_error: float) -> Array:
        """Return it as a polygon (n, 2) [m] with a chord error [m]."""
        ...


@dataclass(frozen=True)
class CircleContour:
    """A full circle [m].

    Its polygon has the vertex angles of a circle of `polygon_radius` [m] if that is not 0: concentric polygons with
    equal angles do not cross, however close their radii are.
    """

    radius: float
    centre: tuple[float, float] = (0.0, 0.0)
    polygon_radius: float = 0.0

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return the circle."""
        return (Circle(self.centre, self.radius),)

    def polygon(self, chord_error: float) -> Array:
        """Return its polygon, with vertices on the circle and the first one towards +x."""
        if not self.polygon_radius:
            return circle(self.radius, chord_error, self.centre)
        return np.array(self.centre) + self.radius / self.polygon_radius * circle(self.polygon_radius, chord_error)


@dataclass(frozen=True)
class TurnedContour:
    """A contour rotated counter-clockwise about the origin by an angle [rad]."""

    contour: Contour
    angle: float

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return the rotated curves."""
        return tuple(rotate_curve(curve, -self.angle) for curve in self.contour.curves(splines))

    def polygon(self, chord_error: float) -> Array:
        """Return the rotated polygon."""
        return rotate_points(self.contour.polygon(chord_error), self.angle)


def with_matching_circles(contours: Sequence[Contour], chord_error: float) -> Sequence[Contour]:
    """Return contours of a part whose polygons of a chord error [m] cross only if their circles do.

    Concentric circles whose radii differ by rounding get equal radii, so that coincident faces coincide exactly.
    Circles closer to each other than the chord error get equal vertex angles.
    """
    centres: dict[tuple[float, float], set[float]] = defaultdict(set)
    for contour in contours:
        if type(contour) is CircleContour:
            centres[contour.centre].add(contour.radius)
    matched = {
        (centre, radius): CircleContour(same[0], centre, 0.0 if same[0] == group[-1] else group[-1])
        for centre, radii in centres.items()
        for group in _groups(sorted(radii), 2.0 * chord_error)
        if len(group) > 1
        for same in _groups(group, SAME_LENGTH)
        for radius in same
    }
    if not matched:
        return contours
    return [matched.get((one.centre, one.radius), one) if type(one) is CircleContour else one for one in contours]


def _groups(values: Sequence[float], distance: float) -> list[list[float]]:
    """Split increasing values where neighbours differ by more than a distance."""
    ends = [0, *(np.flatnonzero(np.diff(values) > distance) + 1).tolist(), len(values)]
    return [list(values[low:high]) for low, high in pairwise(ends)]


def circle_of(contour: Contour) -> Circle | None:
    """Return a contour as a circle, or None if it has another shape."""
    if isinstance(contour, TurnedContour):
        inner = circle_of(contour.contour)
        turned_inner = rotate_curve(inner, -contour.angle) if inner else None
        return turned_inner if isinstance(turned_inner, Circle) else None
    return Circle(contour.centre, contour.radius) if isinstance(contour, CircleContour) else None


def circles_at(radius: float, centres: Array) -> tuple[CircleContour, ...]:
    """Return equal circles of a radius [m] at centres (n, 2) [m]."""
    return tuple(CircleContour(radius, (float(x), float(y))) for x, y in centres)
