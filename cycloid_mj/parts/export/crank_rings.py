"""Rings on the crank of an assembled drive: they keep its bearings off cams and counterweight, and locate it axially.

The ring next to the motor touches the inner ring of its bearing, or stands back from a drawn cup, whose whole face is
at rest. The far ring stands back by the axial play, so that the length of the drive does not preload the bearings. On a
crank in one piece the rings are its collars; on the plain shaft of several discs they are separate parts.

Two rings of equal length keep both ball bearings of an overhung crank apart: one between their outer rings in the
cover, one between their inner rings on the journal. So the cover's shoulder takes axial loads of both.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from cycloid_mj.base import names
from cycloid_mj.design import stock
from cycloid_mj.parts import Segment, crank_segments
from cycloid_mj.parts.accuracy import SAME_LENGTH
from cycloid_mj.parts.cam_bearing import cam_radius
from cycloid_mj.parts.export.bearings import shaft_bearing
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.casing_rules import RULES, shoulder_radius
from cycloid_mj.parts.shaft import COUNTERWEIGHT, bearing_seats
from cycloid_mj.reducer import Reducer

FILLETED_NECK = 2.5
"""Length of a neck between two shoulders over the fillet at each of them, with the room that `edges` requires
(heuristic)."""


@dataclass(frozen=True)
class CrankRing:
    """A ring about the axis: its name, outer radius, ends along z and bore radius [m], and body that it moves with."""

    name: str
    radius: float
    low: float
    high: float
    bore: float
    body: str = names.SHAFT


def crank_rings(reducer: Reducer, casing: Casing) -> tuple[CrankRing, ...]:
    """Return the rings on a shaft with separate cams: before the first cam, beyond the last of a straddled shaft."""
    if reducer.design.has_one_piece_crank:
        return ()
    return tuple(_crank_rings(reducer, casing, crank_segments(reducer)))


def bearing_spacers(reducer: Reducer, casing: Casing) -> tuple[CrankRing, ...]:
    """Return the outer and the inner spacer ring between the two bearings of an overhung crank.

    The result is empty for a straddled crank, for bearings without a gap between them, and for needle bearings (drawn
    cups).
    """
    far_seat, near_seat = bearing_seats(reducer, crank_segments(reducer))
    if casing.far or near_seat[0] - far_seat[1] < SAME_LENGTH or shaft_bearing(reducer) in stock.needle_bearings():
        return ()
    outer_name, inner_name = names.all_numbered(names.BEARING_SPACER, 2)
    ends, shaft_radius = (far_seat[1], near_seat[0]), reducer.design.shaft.radius
    return (
        CrankRing(outer_name, casing.seat, *ends, shoulder_radius(casing.seat, shaft_radius), names.HOUSING),
        CrankRing(inner_name, shoulder_radius(shaft_radius, casing.seat), *ends, shaft_radius),
    )


def crank_collars(reducer: Reducer, casing: Casing, segments: Iterable[Segment]) -> tuple[CrankRing, ...]:
    """Return the collars of a crank in one piece: next to its motor-side bearing, and beyond the cams if straddled.

    `segments` are those of the crank, whose counterweight balances exact outlines or polygons.
    """
    return tuple(_crank_rings(reducer, casing, {segment.name: segment for segment in segments}))


def counterweight_shift(reducer: Reducer) -> float:
    """Compute by how much the counterweight is moved towards the disc to make room for the ring next to it [m]."""
    offset = reducer.design.shaft.bearing_offset
    return max(RULES.collar - offset, 0.0) if reducer.design.gear.discs == 1 else 0.0


def disc_collar_neck(reducer: Reducer, casing: Casing) -> float:
    """Compute the length [m] of the necks between cams and collar of a crank in one piece for two discs.

    There is room for the fillets at both ends of a neck, if this leaves a collar; otherwise, a neck is as long as the
    axial play.
    """
    length = max(casing.play, FILLETED_NECK * reducer.design.shaft.shoulder_fillet)
    return length if reducer.design.gear.disc_gap - 2.0 * length >= RULES.min_wall else casing.play


def hub_radius(reducer: Reducer, casing: Casing) -> float:
    """Compute the largest radius [m] of a ring that touches the cams, but not the bearings on them."""
    return cam_radius(reducer) - reducer.design.gear.eccentricity - casing.play


def _crank_rings(reducer: Reducer, casing: Casing, segments: Mapping[str, Segment]) -> Iterator[CrankRing]:
    """Yield the spacer rings and collars of a crank, from the motor on, except those thinner than `RULES.min_wall`.

    `segments` are the segments of the crank by name.
    """
    shaft = reducer.design.shaft
    near_radius = min(shoulder_radius(shaft.radius, casing.seat), casing.crank_end.max_collar - casing.play)
    if COUNTERWEIGHT not in segments:
        near_radius = min(near_radius, hub_radius(reducer, casing))
    cams = [segment for name, segment in segments.items() if names.family(name) == names.CAM]
    ring_end = segments[COUNTERWEIGHT].z0 + counterweight_shift(reducer) if COUNTERWEIGHT in segments else cams[0].z0
    gap = casing.play if shaft_bearing(reducer) in stock.needle_bearings() else 0.0
    min_radius, far_radius = shaft.radius + RULES.min_wall, min(near_radius, hub_radius(reducer, casing))
    if near_radius >= min_radius:
        yield CrankRing(
            names.numbered_name(names.CRANK_RING, 1), near_radius, casing.near[1] + gap, ring_end, shaft.radius
        )
    if casing.far and far_radius >= min_radius:
        ends = cams[-1].z1, casing.far[0] - casing.play
        yield CrankRing(names.numbered_name(names.CRANK_RING, 2), far_radius, *ends, shaft.radius)
