"""Contours of joints of shaft and hub: keyways and keys, straight-sided splines, and slotted hubs."""

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
        """Return the outline of a bore with a keyway as a polygon (n, 2) [m], counter-clockwise, the arc first.

        `chord_error` [m] is the largest distance of a chord from the arc.
        """
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
        """Return the four edges of a key; `splines` has no effect."""
        corners = self.polygon(0.0).tolist()
        return tuple(LineSegment((*one,), (*other,)) for one, other in pairwise([*corners, corners[0]]))

    def polygon(self, chord_error: float) -> Array:
        """Return the four corners of a key (4, 2) [m], counter-clockwise; `chord_error` has no effect."""
        half, inner, outer = 0.5 * self.width, self.inner, self.outer
        return rotate_points(np.array([[inner, -half], [outer, -half], [outer, half], [inner, half]]), self.angle)


@dataclass(frozen=True)
class SplineContour:
    """The section of a straight-sided spline (ISO 14) about the axis, of the shaft as of the hub.

    Minor and major radius and width of a spline are in [m]; `angle` is that of the middle of a spline from +x [rad].
    """

    count: int
    minor: float
    major: float
    width: float
    angle: float

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return the outline of a straight-sided spline joint: for each tooth its flanks, its top and the arc after it.

        The argument `splines` has no effect, because lines and arcs are exact.
        """
        half_foot, half_top = self._half_angles
        step, loop = 2.0 * math.pi / self.count, list[Curve]()
        for middle in self._middles:
            rising_flank, falling_flank = (
                [(radius * math.cos(angle), radius * math.sin(angle)) for radius, angle in ends]
                for ends in (
                    ((self.minor, middle - half_foot), (self.major, middle - half_top)),
                    ((self.major, middle + half_top), (self.minor, middle + half_foot)),
                )
            )
            loop += [
                LineSegment(rising_flank[0], rising_flank[1]),
                Arc((0.0, 0.0), self.major, middle - half_top, middle + half_top),
                LineSegment(falling_flank[0], falling_flank[1]),
                Arc((0.0, 0.0), self.minor, middle + half_foot, middle + step - half_foot),
            ]
        return tuple(loop)

    def polygon(self, chord_error: float) -> Array:
        """Return the outline of a straight-sided spline joint as a polygon (n, 2) [m], counter-clockwise.

        `chord_error` [m] is the largest distance of a chord from an arc.
        """
        half_foot, half_top = self._half_angles
        step, pieces = 2.0 * math.pi / self.count, list[Array]()
        for middle in self._middles:
            pieces.append(arc(self.major, middle - half_top, middle + half_top, chord_error))
            pieces.append(arc(self.minor, middle + half_foot, middle + step - half_foot, chord_error))
        return np.concatenate(pieces)

    @property
    def _middles(self) -> tuple[float, ...]:
        return tuple(self.angle + 2.0 * math.pi * number / self.count for number in range(self.count))

    @property
    def _half_angles(self) -> tuple[float, float]:
        """Half the angles of a spline at the minor and at the major circle [rad]."""
        return math.asin(0.5 * self.width / self.minor), math.asin(0.5 * self.width / self.major)


@dataclass(frozen=True)
class SlottedContour:
    """An eccentric with a bore about the axis, slotted from the bore through its thick side, towards +y [m]."""

    radius: float
    eccentricity: float
    bore: float
    slot: float

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return the outline of a slotted eccentric: outer arc, one side of the slot, bore, and the other side.

        The argument `splines` has no effect, because lines and arcs are exact.
        """
        half, (outer, inner) = 0.5 * self.slot, self._ends
        start, low = math.acos(-half / self.radius), math.acos(half / self.bore)
        return (
            Arc((0.0, self.eccentricity), self.radius, start, start + 2.0 * math.pi - 2.0 * (start - 0.5 * math.pi)),
            LineSegment((half, outer), (half, inner)),
            Arc((0.0, 0.0), self.bore, math.pi - low, low + 2.0 * math.pi),
            LineSegment((-half, inner), (-half, outer)),
        )

    def polygon(self, chord_error: float) -> Array:
        """Return the outline of a slotted eccentric as a polygon (n, 2) [m]: outer arc, then the arc of the bore.

        The outer arc is counter-clockwise, that of the bore clockwise; the sides of the slot join them. `chord_error`
        [m] is the largest distance of a chord from an arc.
        """
        half = 0.5 * self.slot
        start, low = math.acos(-half / self.radius), math.acos(half / self.bore)
        end = start + 2.0 * math.pi - 2.0 * (start - 0.5 * math.pi)
        around = arc(self.radius, start, end, chord_error) + np.array([0.0, self.eccentricity])
        bore = arc(self.bore, math.pi - low, low + 2.0 * math.pi, chord_error)
        return np.concatenate([around, bore[::-1]])

    @property
    def _ends(self) -> tuple[float, float]:
        """Heights along y of the ends of the slot: at the outer circle, and at the bore [m]."""
        half = 0.5 * self.slot
        return self.eccentricity + math.sqrt(self.radius**2 - half**2), math.sqrt(self.bore**2 - half**2)
