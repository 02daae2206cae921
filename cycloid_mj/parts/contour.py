"""Closed contours, each told once: as exact curves for CAD, and as a polygon for meshes, masses and pictures."""

from dataclasses import dataclass
from typing import Protocol

from cycloid_mj.base.array import Array
from cycloid_mj.parts.curve import Circle, Curve, turned_curve
from cycloid_mj.parts.polygon import circle, turned


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
    """A whole circle [m]."""

    radius: float
    centre: tuple[float, float] = (0.0, 0.0)

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return the circle."""
        return (Circle(self.centre, self.radius),)

    def polygon(self, chord_error: float) -> Array:
        """Draw it with its vertices on the circle, the first of them towards +x."""
        return circle(self.radius, chord_error, self.centre)


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


def circles_at(radius: float, centres: Array) -> tuple[CircleContour, ...]:
    """Place equal circles of a radius [m] at centres (n, 2) [m]."""
    return tuple(CircleContour(radius, (float(x), float(y))) for x, y in centres)
