"""Contours of keyed joints: shafts and hubs with a keyway, and the key between them."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.parts.curve import Arc, Curve, LineSegment
from cycloid_mj.parts.polygon import arc, rotate_points


@dataclass(frozen=True)
class KeywayContour:
    """A circle about the axis with a keyway: of a hub if its `depth` [m] is positive, of a shaft if it is negative.

    `angle` is that of the middle of the keyway from +x [rad].
    """

    radius: float
    width: float
    depth: float
    angle: float

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return the arc from one edge of the keyway to the other, and the three faces of the keyway."""
        corners = self._corners().tolist()
        edges = [LineSegment((*one,), (*other,)) for one, other in pairwise(corners)]
        start = self.angle + self._half_angle
        return Arc((0.0, 0.0), self.radius, start, start + 2.0 * (math.pi - self._half_angle)), *edges

    def polygon(self, chord_error: float) -> Array:
        """Return its polygon, the arc first."""
        start = self.angle + self._half_angle
        around = arc(self.radius, start, start + 2.0 * (math.pi - self._half_angle), chord_error)
        return np.concatenate([around, self._corners()[1:-1]])

    @property
    def _half_angle(self) -> float:
        return math.asin(0.5 * self.width / self.radius)

    def _corners(self) -> Array:
        """Return the corners of the keyway (4, 2) [m], counter-clockwise."""
        edge, bottom, half = self.radius * math.cos(self._half_angle), self.radius + self.depth, 0.5 * self.width
        return rotate_points(np.array([[edge, -half], [bottom, -half], [bottom, half], [edge, half]]), self.angle)


@dataclass(frozen=True)
class KeyContour:
    """The section of a parallel key between two radii [m], along its `angle` from +x [rad]."""

    inner: float
    outer: float
    width: float
    angle: float

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return its four edges."""
        corners = self.polygon(0.0).tolist()
        return tuple(LineSegment((*one,), (*other,)) for one, other in pairwise([*corners, corners[0]]))

    def polygon(self, chord_error: float) -> Array:
        """Return its four corners (4, 2) [m], counter-clockwise."""
        half, inner, outer = 0.5 * self.width, self.inner, self.outer
        return rotate_points(np.array([[inner, -half], [outer, -half], [outer, half], [inner, half]]), self.angle)
