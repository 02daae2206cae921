"""Contours of joints of shaft and hub: keyways and keys, straight-sided splines, and slotted hubs."""

import math
from collections.abc import Iterator
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
        edges = [LineSegment((*start,), (*end,)) for start, end in pairwise(corners)]
        return Arc((0.0, 0.0), self.radius, *self._arc_ends), *edges

    def polygon(self, chord_error: float) -> Array:
        """Return the outline of a bore with a keyway as a polygon (n, 2) [m], counter-clockwise, the arc first.

        `chord_error` [m] is the largest distance of a chord from the arc.
        """
        return np.concatenate([arc(self.radius, *self._arc_ends, chord_error), self._corners()[1:-1]])

    @property
    def _half_angle(self) -> float:
        return math.asin(0.5 * self.width / self.radius)

    @property
    def _arc_ends(self) -> tuple[float, float]:
        """Angles of the ends of the arc from one edge of the keyway to the other [rad]."""
        start = self.angle + self._half_angle
        return start, start + 2.0 * (math.pi - self._half_angle)

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
        return tuple(LineSegment((*start,), (*end,)) for start, end in pairwise([*corners, corners[0]]))

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
        """Return the outline of a straight-sided spline joint: its arcs, each after the flank that leads to it.

        The argument `splines` has no effect, because lines and arcs are exact.
        """
        arcs = list(self._joint_arcs())
        return tuple(
            curve
            for previous, (radius, start, end) in zip([arcs[-1], *arcs[:-1]], arcs, strict=True)
            for curve in (
                LineSegment(_polar(previous[0], previous[2]), _polar(radius, start)),
                Arc((0.0, 0.0), radius, start, end),
            )
        )

    def polygon(self, chord_error: float) -> Array:
        """Return the outline of a straight-sided spline joint as a polygon (n, 2) [m], counter-clockwise.

        `chord_error` [m] is the largest distance of a chord from an arc.
        """
        return np.concatenate([arc(*arc_of_outline, chord_error) for arc_of_outline in self._joint_arcs()])

    def _joint_arcs(self) -> Iterator[tuple[float, float, float]]:
        """Yield radius [m], start and end [rad] of all arcs of the spline joint: tops of splines, and arcs between."""
        half_root, half_top = (math.asin(0.5 * self.width / radius) for radius in (self.minor, self.major))
        pitch = 2.0 * math.pi / self.count
        for number in range(self.count):
            middle = self.angle + 2.0 * math.pi * number / self.count
            yield self.major, middle - half_top, middle + half_top
            yield self.minor, middle + half_root, middle + pitch - half_root


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
        half_slot = 0.5 * self.slot
        outer_end, inner_end = (
            self.eccentricity + math.sqrt(self.radius**2 - half_slot**2),
            math.sqrt(self.bore**2 - half_slot**2),
        )
        return (
            Arc((0.0, self.eccentricity), self.radius, *self._arc_ends(self.radius)),
            LineSegment((half_slot, outer_end), (half_slot, inner_end)),
            Arc((0.0, 0.0), self.bore, *self._arc_ends(self.bore)),
            LineSegment((-half_slot, inner_end), (-half_slot, outer_end)),
        )

    def polygon(self, chord_error: float) -> Array:
        """Return the outline of a slotted eccentric as a polygon of n points (n, 2) [m].

        The outer arc is counter-clockwise, then that of the bore clockwise; the sides of the slot join them.
        `chord_error` [m] is the largest distance of a chord from an arc.
        """
        outer_arc, bore_arc = (arc(radius, *self._arc_ends(radius), chord_error) for radius in (self.radius, self.bore))
        return np.concatenate([outer_arc + np.array([0.0, self.eccentricity]), bore_arc[::-1]])

    def _arc_ends(self, radius: float) -> tuple[float, float]:
        """Compute the angles [rad] between which a circle of a radius [m] is not cut by the slot, which is on +y."""
        half_angle = math.asin(0.5 * self.slot / radius)
        return 0.5 * math.pi + half_angle, 2.5 * math.pi - half_angle


def _polar(radius: float, angle: float) -> tuple[float, float]:
    return radius * math.cos(angle), radius * math.sin(angle)
