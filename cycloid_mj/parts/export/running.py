"""Distances of parts that move against each other, in the half-section through the axis of an assembled drive.

A part that turns about the axis sweeps annuli, which its radii and its ends along z bound; a disc, on its eccentric,
sweeps wider ones. Where the annuli of two bodies are apart, the parts neither touch nor rub at any crank angle. Pairs
that overlap along z by design, as disc and pins, have a clearance of their own (`clearance.measure`); of them only the
faces are compared.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.design import stock
from cycloid_mj.parts import Segment
from cycloid_mj.parts.accuracy import SAME_LENGTH, VISUAL_CHORD_ERROR
from cycloid_mj.parts.contour import Contour, circle_of
from cycloid_mj.parts.export.assembly import assembly_parts, place_parts
from cycloid_mj.parts.export.bearings import shaft_bearing
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.casing_rules import (
    shoulder_radius,
)
from cycloid_mj.parts.export.joints import MOTOR
from cycloid_mj.parts.export.step import PlacedPart
from cycloid_mj.reducer import Reducer

PILOT_HEIGHT = 2.0e-3
"""Height of the pilot of a NEMA motor [m] (NEMA ICS 16)."""

ROLLING_ELEMENTS = "rolling elements"
"""Body of the space between the rings of a bearing, which no other part may touch."""

_MATES = (
    {names.GEAR, names.SHAFT, names.CAM, names.CAM_SCREW, names.CAM_BEARING},
    {names.GEAR, names.PIN, names.HOUSING, names.PRESSED_PIN},
    {names.GEAR, names.ROLLER, names.ROLLER_BEARING, names.OUTPUT_PIN, names.OUTPUT},
    {ROLLING_ELEMENTS, names.SHAFT_BEARING, names.OUTPUT_BEARING},
    {names.SHAFT, names.SHAFT_BEARING},
    {names.SHAFT, names.SHAFT_SEAL},
)
"""Families that overlap along z with a clearance of their own, or none."""


@dataclass(frozen=True)
class Annulus:
    """Space that a segment of a part sweeps: radii and ends along z [m], with its part and the body it moves with."""

    part: str
    body: str
    inner: float
    outer: float
    low: float
    high: float

    def distances(self, other: "Annulus") -> tuple[float, float]:
        """Return the distances along z and along the radius [m]; negative where they overlap."""
        axial = max(other.low - self.high, self.low - other.high)
        return axial, max(other.inner - self.outer, self.inner - other.outer)


@dataclass(frozen=True)
class RunningGap:
    """The smallest distance [m] of two parts that move against each other, and whether it is along the axis."""

    part: str
    other: str
    distance: float
    axial: bool

    def keeps(self, play: float) -> bool:
        """Return whether it is at least the axial play [m], or across the axis, where parts are located, open."""
        return self.distance >= (play - SAME_LENGTH if self.axial else SAME_LENGTH)


def running_gaps(reducer: Reducer, casing: Casing) -> tuple[RunningGap, ...]:
    """Return the smallest distance [m] of each pair of parts that move relative to each other; 0 or less if they touch.

    Where parts overlap along z by design, such as a cam and its disc, their distance is ignored.

    Raises
    ------
    DesignError
        A part cannot be manufactured, or does not fit.
    """
    smallest_gaps: dict[tuple[str, str], RunningGap] = {}
    for annulus, other_annulus in combinations(swept_annuli(reducer, casing), 2):
        axial, radial = annulus.distances(other_annulus)
        if (
            annulus.body == other_annulus.body
            or annulus.part == other_annulus.part
            or _are_mates(annulus, other_annulus, axial, radial)
        ):
            continue
        distance = math.hypot(max(axial, 0.0), max(radial, 0.0)) or max(axial, radial)
        gap = RunningGap(annulus.part, other_annulus.part, distance, axial > radial)
        key = min((annulus.part, other_annulus.part), (other_annulus.part, annulus.part))
        if key not in smallest_gaps or gap.distance < smallest_gaps[key].distance:
            smallest_gaps[key] = gap
    return tuple(smallest_gaps.values())


def _are_mates(annulus: Annulus, other: Annulus, axial: float, radial: float) -> bool:
    """Return whether two parts are close to each other by design, so that their distance is not a running gap.

    These are parts that overlap along z by design, and rolling elements next to the shoulder of a ring. `annulus` and
    `other` are the ring-shaped spaces that the parts sweep; `axial` and `radial` are their distances [m], negative
    where they overlap.
    """
    families = {names.family(annulus.part), names.family(other.part)}
    if ROLLING_ELEMENTS in families and (
        radial > -SAME_LENGTH or families & {names.SHAFT_SEAL, *names.RETAINING_RINGS}
    ):
        return True  # they are inside of the faces of the bearing
    if {annulus.body, other.body} == {names.PIN, names.HOUSING} and axial < -SAME_LENGTH:
        return True  # pins stay in their sockets
    return axial < -SAME_LENGTH and any(families <= mates for mates in _MATES)


def swept_annuli(reducer: Reducer, casing: Casing) -> tuple[Annulus, ...]:
    """Return the annuli that all parts of a drive and its motor sweep, each once."""
    motor = () if reducer.design.shaft.bore_radius else _motor_annuli(casing)  # none is on the axis of a hollow shaft
    return tuple(dict.fromkeys((*_part_annuli(reducer, casing), *motor)))


def _part_annuli(reducer: Reducer, casing: Casing) -> Iterator[Annulus]:
    """Yield the ring-shaped space (annulus) that each segment of each part of a drive sweeps as it turns.

    A rolling bearing has an annulus each for its inner ring, rolling elements and outer ring.
    """
    parts = assembly_parts(reducer, casing)
    for placement in place_parts(reducer, 0.0, casing):
        for segment in parts[placement.part].segments:
            annulus = _swept_ring(placement, segment)
            if names.family(placement.part) in (names.SHAFT_BEARING, names.OUTPUT_BEARING):
                yield from _split_bearing(reducer, casing, annulus)
            else:
                yield annulus


def _swept_ring(placement: PlacedPart, segment: Segment) -> Annulus:
    """Return the ring-shaped space (annulus) that a segment of a part sweeps as it turns about the axis or orbits.

    `placement` is the position of the part. A part of a disc orbits about the axis with it.
    """
    x, y, z = placement.origin
    orbit_radius = math.hypot(x, y) if names.family(placement.body) == names.GEAR else 0.0
    centre = np.zeros(2) if orbit_radius else np.array([x, y])
    inner_radius, outer_radius = _radii(segment.outline, centre)
    inner_radius = max(
        (_radii(hole, centre)[0] for hole in segment.holes if _surrounds_axis(hole, centre)), default=inner_radius
    )
    is_solid = _surrounds_axis(segment.outline, centre) and inner_radius == _radii(segment.outline, centre)[0]
    radii = 0.0 if is_solid else max(inner_radius - orbit_radius, 0.0), outer_radius + orbit_radius
    ends = segment.z0 + z, segment.z1 + z
    return Annulus(placement.part, placement.body, *(round(length, 10) for length in (*radii, *ends)))


def _radii(contour: Contour, centre: Array) -> tuple[float, float]:
    """Return the smallest and largest distance [m] from the axis of a contour with its origin at `centre` (2,) [m]."""
    if circle := circle_of(contour):
        distance = math.dist(circle.centre, (-centre).tolist())
        return abs(distance - circle.radius), distance + circle.radius
    radii = np.linalg.norm(contour.polygon(VISUAL_CHORD_ERROR) + centre, axis=1)
    return float(radii.min()), float(radii.max())


def _surrounds_axis(contour: Contour, centre: Array) -> bool:
    """Return whether a contour whose origin is at `centre` (2,) [m] encloses the axis."""
    if circle := circle_of(contour):
        return math.dist(circle.centre, (-centre).tolist()) < circle.radius
    x, y = (contour.polygon(VISUAL_CHORD_ERROR) + centre).T
    steps = np.diff(np.unwrap(np.arctan2([*y, y[0]], [*x, x[0]])))
    return bool(abs(steps.sum()) > math.pi)


def _split_bearing(reducer: Reducer, casing: Casing, bearing: Annulus) -> Iterator[Annulus]:
    """Yield the annuli of a bearing's inner ring, rolling elements and outer ring, from that of the entire bearing.

    A drawn cup has no inner ring and stays one annulus.
    """
    is_on_shaft = bearing.part == names.SHAFT_BEARING
    ends = bearing.low, bearing.high
    is_in_hub = is_on_shaft and casing.far is not None and bearing.low > 0.0
    outer_body = names.OUTPUT if is_in_hub else names.HOUSING
    if is_on_shaft and shaft_bearing(reducer) in stock.needle_bearings():
        yield Annulus(bearing.part, outer_body, bearing.inner, bearing.outer, *ends)
        return
    inner_radius, outer_radius = (
        (shoulder_radius(bearing.inner, bearing.outer), shoulder_radius(bearing.outer, bearing.inner))
        if is_on_shaft
        else casing.hub.shoulders
    )
    yield Annulus(bearing.part, names.SHAFT if is_on_shaft else names.OUTPUT, bearing.inner, inner_radius, *ends)
    yield Annulus(ROLLING_ELEMENTS, ROLLING_ELEMENTS, inner_radius, outer_radius, *ends)
    yield Annulus(bearing.part, outer_body, outer_radius, bearing.outer, *ends)


def _motor_annuli(casing: Casing) -> Iterator[Annulus]:
    """Yield the annuli of the motor: body, pilot and shaft."""
    motor, face = casing.motor, casing.face
    yield Annulus(MOTOR, names.HOUSING, 0.0, motor.circle, face - motor.circle, face)
    yield Annulus(MOTOR, names.HOUSING, motor.shaft, motor.pilot, face, face + PILOT_HEIGHT)
    if motor.shaft:
        yield Annulus(MOTOR, names.SHAFT, 0.0, motor.shaft, face, face + motor.shaft_length)
