"""Closed contours, each told once: as exact curves for CAD, and as a polygon for meshes, masses and pictures."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, repeat
from typing import Protocol

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.parts.curve import Circle, Curve, turned_curve
from cycloid_mj.parts.polygon import circle, turned

SAME_RADIUS = 1e-9
"""Radii that differ by less are the same [m]: rounding makes 1e-17, and nothing is manufactured to a nanometre."""


class Contour(Protocol):
    """A closed contour in the plane of a part, counter-clockwise."""

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """List its curves, which follow each other; a lobe or a root is made of so many splines."""
        ...

    def polygon(self, chord_error: float) -> Array:
        """Draw it by chords that leave it by no more than so much [m], (n, 2) [m]."""
        ...


@dataclass(frozen=True)
class CircleContour:
    """A full circle [m].

    Its polygon has the angles of a circle of `polygon_radius` [m], if that is given: circles about one centre with the
    same angles do not cross, however little their radii differ.
    """

    radius: float
    centre: tuple[float, float] = (0.0, 0.0)
    polygon_radius: float = 0.0

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return the circle."""
        return (Circle(self.centre, self.radius),)

    def polygon(self, chord_error: float) -> Array:
        """Return its polygon, the vertices on the circle, the first of them towards +x."""
        if not self.polygon_radius:
            return circle(self.radius, chord_error, self.centre)
        return np.array(self.centre) + self.radius / self.polygon_radius * circle(self.polygon_radius, chord_error)


@dataclass(frozen=True)
class TurnedContour:
    """A contour turned counter-clockwise about the origin by an angle [rad]."""

    contour: Contour
    angle: float

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """List the curves, turned."""
        return tuple(turned_curve(curve, -self.angle) for curve in self.contour.curves(splines))

    def polygon(self, chord_error: float) -> Array:
        """Draw the polygon, turned."""
        return turned(self.contour.polygon(chord_error), self.angle)


def with_matching_circles(contours: Sequence[Contour], chord_error: float) -> Sequence[Contour]:
    """Return contours of one part whose polygons of a chord error [m] do not cross where their circles do not.

    Circles about one centre whose radii differ by rounding alone get the first of these radii: faces that coincide
    must coincide exactly. Circles that are closer to each other than chords may leave them get the same angles.
    """
    centres: dict[tuple[float, float], set[float]] = defaultdict(set)
    for contour in contours:
        if type(contour) is CircleContour:
            centres[contour.centre].add(contour.radius)
    matched = {
        (centre, radius): CircleContour(same, centre, 0.0 if same == group[-1] else group[-1])
        for centre, radii in centres.items()
        for group in _groups(sorted(radii), 2.0 * chord_error)
        if len(group) > 1
        for same_group in _groups(group, SAME_RADIUS)
        for radius, same in zip(same_group, repeat(same_group[0]))
    }
    if not matched:
        return contours
    return [matched.get((one.centre, one.radius), one) if type(one) is CircleContour else one for one in contours]


def _groups(values: Sequence[float], apart: float) -> list[list[float]]:
    """Split rising values where neighbours differ by more than `apart`."""
    ends = [0, *(np.flatnonzero(np.diff(values) > apart) + 1).tolist(), len(values)]
    return [list(values[low:high]) for low, high in pairwise(ends)]


def circle_of(contour: Contour) -> Circle | None:
    """Return the circle that a contour is, or None if it has another shape."""
    if isinstance(contour, TurnedContour):
        inner = circle_of(contour.contour)
        turned_inner = turned_curve(inner, -contour.angle) if inner else None
        return turned_inner if isinstance(turned_inner, Circle) else None
    return Circle(contour.centre, contour.radius) if isinstance(contour, CircleContour) else None


def circles_at(radius: float, centres: Array) -> tuple[CircleContour, ...]:
    """Place equal circles of a radius [m] at centres (n, 2) [m]."""
    return tuple(CircleContour(radius, (float(x), float(y))) for x, y in centres)
