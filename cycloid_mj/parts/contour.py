"""Closed contours, as exact curves for CAD and as polygons for meshes, masses and pictures."""

from dataclasses import dataclass
from typing import Protocol

from cycloid_mj.base.array import Array
from cycloid_mj.parts.curve import Circle, Curve, rotate_curve
from cycloid_mj.parts.polygon import circle, circle_area, rotate_points, signed_area


class Contour(Protocol):
    """A closed contour in the plane of a part, counter-clockwise."""

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return the consecutive curves of the contour, with `splines` splines per lobe or root."""
        ...

    def polygon(self, chord_error: float) -> Array:
        """Return the contour as a polygon (n, 2) [m] with a chord error [m]."""
        ...


@dataclass(frozen=True)
class CircleContour:
    """A full circle [m]."""

    radius: float
    centre: tuple[float, float] = (0.0, 0.0)

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return the circle, the only curve of this contour."""
        return (Circle(self.centre, self.radius),)

    def polygon(self, chord_error: float) -> Array:
        """Return the polygon (n, 2) [m] with a chord error [m]; vertices are on the circle, the first is towards +x."""
        return circle(self.radius, chord_error, self.centre)


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


def circle_of(contour: Contour) -> Circle | None:
    """Return a contour as a circle, or None if it has another shape."""
    if isinstance(contour, TurnedContour):
        unturned_circle = circle_of(contour.contour)
        turned_circle = rotate_curve(unturned_circle, -contour.angle) if unturned_circle else None
        return turned_circle if isinstance(turned_circle, Circle) else None
    return Circle(contour.centre, contour.radius) if isinstance(contour, CircleContour) else None


def contour_area(contour: Contour, chord_error: float) -> float:
    """Compute the area of the polygon of a contour with a chord error [m2]; that of a circle in closed form."""
    if isinstance(contour, TurnedContour):
        return contour_area(contour.contour, chord_error)
    if type(contour) is CircleContour:  # others have their own polygons
        return circle_area(contour.radius, chord_error)
    return signed_area(contour.polygon(chord_error))


def circles_at(radius: float, centres: Array) -> tuple[CircleContour, ...]:
    """Return equal circles of a radius [m] at centres (n, 2) [m]."""
    return tuple(CircleContour(radius, (float(x), float(y))) for x, y in centres)
