"""Chamfers and fillets of manufactured parts, in STEP files and on drawings: seats, journals and shoulders.

A convex edge of a seat gets a chamfer, which leads its mate in; the shoulders of the crank get the fillet that the
fatigue of the shaft assumes. Meshes, outlines and masses have sharp edges, which is below 1 % of a drive's volume.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array, Mask
from cycloid_mj.design.model import BEARING_CORNER, SHARES
from cycloid_mj.parts import Part, Segment
from cycloid_mj.parts.accuracy import SAME_LENGTH, VISUAL_CHORD_ERROR
from cycloid_mj.parts.cam_bearing import cam_radius
from cycloid_mj.parts.contour import circle_of
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.joint import JointKind
from cycloid_mj.parts.export.joints import drive_joints
from cycloid_mj.parts.export.step import BrokenEdge
from cycloid_mj.parts.polygon import within
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class EdgeSettings:
    """Sizes of broken edges, and settings of the search for them.

    Attributes
    ----------
    chamfer
        Width of a chamfer at 45 deg [m]: within the 0.2 to 0.5 mm of unmarked edges on the drawings; of bearings
        their smallest corner, which clears an equal fillet.
    share
        Largest width of a chamfer over the radius of its edge: that of the fillet of a thin shaft.
    room
        Width of a face that a chamfer or fillet needs, over its own.
    rays
        Number of directions in which the material around an edge is compared.
    """

    chamfer: float = BEARING_CORNER
    share: float = SHARES.fillet
    room: float = 1.2
    rays: int = 24


EDGES = EdgeSettings()

BEARINGS = names.CAM_BEARING, names.SHAFT_BEARING, names.OUTPUT_BEARING
"""Parts whose corners clear the fillets of shoulders."""

SEATS = {JointKind.BEARING, JointKind.PRESSED}
"""Kinds of joints whose mates are pressed in or on along the axis."""


def broken_edges(reducer: Reducer, casing: Casing, part: Part) -> tuple[BrokenEdge, ...]:
    """Return the edges of a part of a drive that have a chamfer or a fillet; a bearing has its corners."""
    radii = _seat_radii(reducer, casing, part)
    return tuple(_break_edges(reducer, part, radii)) if radii.size else ()


def _seat_radii(reducer: Reducer, casing: Casing, part: Part) -> Array:
    """Return the radii of the n seats of a part [m], (n,); edges next to these seats get chamfers or fillets.

    The seats are the surfaces at which the joints of the drive fit the part to another. For a bearing, they are its
    bore and its outside.
    """
    name, diameters = part.name, set[float]()
    if name in BEARINGS:
        (bearing_segment,) = part.segments
        circles = [
            circle for contour in (bearing_segment.outline, *bearing_segment.holes) if (circle := circle_of(contour))
        ]
        return np.array([circle.radius for circle in circles])
    for joint in drive_joints(reducer, casing):
        if joint.kind in SEATS and name in joint.parts:
            diameters |= {
                joint.diameter,
                *(dict(bought_part.dimensions).get("outside diameter", 0.0) for bought_part in joint.bought),
            }
    if names.family(name) in (names.SHAFT, names.CAM):
        diameters.add(2.0 * cam_radius(reducer))
    return 0.5 * np.array(sorted(diameters - {0.0}))


def _break_edges(reducer: Reducer, part: Part, radii: Array) -> Iterator[BrokenEdge]:
    """Yield a chamfer for each convex edge of a seat, and a fillet for each shoulder of a shaft, if they fit.

    Chamfers are `EDGES.chamfer` wide, but at most a share of the radius; fillets have the radius of the design. `radii`
    (n,) [m] are the radii of the n seats of the `part`.
    """
    for segment in part.segments:
        for contour, side in ((segment.outline, 1.0), *((hole, -1.0) for hole in segment.holes)):
            circle = circle_of(contour)
            if circle is None or np.abs(radii - circle.radius).min() > SAME_LENGTH:
                continue
            for z in (segment.z0, segment.z1):
                adjacent_segments = [
                    neighbour for neighbour in part.segments if neighbour is not segment and _touches(neighbour, z)
                ]
                edge = _Edge(circle.centre, circle.radius, side, segment, adjacent_segments)
                fillet_size = reducer.design.shaft.shoulder_fillet
                chamfer_size = min(EDGES.chamfer, EDGES.share * circle.radius)
                if edge.is_convex(chamfer_size):
                    yield BrokenEdge(circle.centre, circle.radius, z, chamfer_size)
                elif part.name == names.SHAFT and side > 0.0 and edge.is_shoulder(fillet_size):
                    yield BrokenEdge(circle.centre, circle.radius, z, fillet_size, is_fillet=True)


def _touches(segment: Segment, z: float) -> bool:
    """Return whether a segment ends at a height [m]."""
    return min(abs(segment.z0 - z), abs(segment.z1 - z)) <= SAME_LENGTH


@dataclass(frozen=True)
class _Edge:
    """A circular edge: centre and radius [m], side of the air (1: outside, -1: inside), its segment, those beyond."""

    centre: tuple[float, float]
    radius: float
    side: float
    own: Segment
    beyond: Sequence[Segment]

    def is_convex(self, size: float) -> bool:
        """Return whether the edge is convex and has room for a chamfer of a `size` [m].

        Close to the edge, only the segment to which the edge belongs may have material, none of the adjacent segments.
        """
        width = EDGES.room * size
        if (
            self.own.z1 - self.own.z0 < 2.0 * width
            or not _covered_points([self.own], self._points(-self.side * width)).all()
        ):
            return False
        return not any(_covered_points(self.beyond, self._points(distance)).any() for distance in (-width, width))

    def is_shoulder(self, size: float) -> bool:
        """Return whether a fillet of a `size` [m] fits: the segment beyond is wider, and the own one long enough."""
        width = EDGES.room * size
        return self.own.z1 - self.own.z0 > width and bool(
            _covered_points(self.beyond, self._points(self.side * width)).all()
        )

    def _points(self, distance: float) -> Array:
        """Return points around the edge, at a distance outside of its radius [m], shape (rays, 2)."""
        angles = 2.0 * np.pi * (np.arange(EDGES.rays) + 0.5) / EDGES.rays
        return np.array(self.centre) + (self.radius + distance) * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _covered_points(segments: Iterable[Segment], points: Array) -> Mask:
    """Return a mask of the n `points` (n, 2) [m] that are inside the cross-section of one or more segments, (n,)."""
    is_covered = np.zeros(len(points), dtype=bool)
    for segment in segments:
        is_inside = within(points, segment.outline.polygon(VISUAL_CHORD_ERROR))
        for hole in segment.holes:
            is_inside &= ~within(points, hole.polygon(VISUAL_CHORD_ERROR))
        is_covered |= is_inside
    return is_covered
