"""Distances of the parts of a drive that move against each other, by OpenCASCADE, at any crank angle.

All parts are stacks of prisms along z. The distance of two prisms is the hypotenuse of that of their ends along z and
that of their sections in the plane, which OpenCASCADE measures on the curves of STEP files.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.design import stock
from cycloid_mj.parts import PartSection
from cycloid_mj.parts.accuracy import SAME_LENGTH
from cycloid_mj.parts.curve import Circle
from cycloid_mj.parts.export import Casing, PlacedPart, place_parts
from cycloid_mj.parts.export.assembly import assembly_sections
from cycloid_mj.parts.export.bearings import shaft_bearing
from cycloid_mj.parts.export.casing_rules import (
    shoulder_radius,
)
from cycloid_mj.parts.export.step import occ, planar_face
from cycloid_mj.parts.polygon import rotate_points
from cycloid_mj.reducer import Reducer

NEEDLES_ON = {names.SHAFT, names.CAM, names.OUTPUT_PIN}
"""Families of parts on which needles roll: the bearing is drawn down to them, without a gap."""

ON_RACEWAYS = {names.CAM_BEARING, names.SHAFT_BEARING, names.ROLLER_BEARING, names.SHAFT_SEAL}
"""Families of parts that roll or slide on `NEEDLES_ON`."""

SPACING = 1e-4
"""Largest distance of points along a curve, for bounds of a distance [m]: a wider one leaves more to OpenCASCADE."""


OBLIQUE = 1.0
"""Angle [rad] by which outlines are rotated so that rays do not pass through the corners of symmetric parts."""


@dataclass(frozen=True)
class Distance:
    """The smallest distance of two parts [m], and whether it is along the axis."""

    part: str
    other: str
    value: float
    axial: bool

    def keeps(self, play: float) -> bool:
        """Return whether the parts do not touch; along the axis, whether their gap is at least the axial play [m]."""
        return self.value >= (play if self.axial else 0.0) - SAME_LENGTH and self.value > 0.0


@dataclass(frozen=True, eq=False)
class Outline:
    """Edges of a plane face in its own frame, points along them (n, 2) [mm], and the edge of each point (n,)."""

    edges: tuple[Any, ...]
    points: Array
    owners: Array

    @cached_property
    def tree(self) -> cKDTree:
        """Tree of its points."""
        return cKDTree(self.points)

    @cached_property
    def chords(self) -> tuple[Array, Array]:
        """Start and end points of the chords along all edges, shape (m, 2) each [mm], rotated by `OBLIQUE`."""
        is_chord, points = self.owners[1:] == self.owners[:-1], rotate_points(self.points, OBLIQUE)
        return points[:-1][is_chord], points[1:][is_chord]

    def covers(self, point: Array) -> bool:
        """Return whether its polygon covers a point (2,) [mm] (even-odd rule)."""
        ((at_x, at_y),) = rotate_points(point[np.newaxis], OBLIQUE)
        (x, y), (end_x, end_y) = (ends.T for ends in self.chords)
        crosses = (y > at_y) != (end_y > at_y)
        x, y, end_x, end_y = x[crosses], y[crosses], end_x[crosses], end_y[crosses]
        return bool(np.count_nonzero(x + (at_y - y) / (end_y - y) * (end_x - x) > at_x) % 2)


@dataclass(frozen=True, eq=False)
class Face:
    """A plane face in place: its outline, rotated by an angle [rad], then moved to an origin (2,) [mm]."""

    outline: Outline
    angle: float = 0.0
    origin: tuple[float, float] = (0.0, 0.0)

    def moved(self, placement: PlacedPart) -> "Face":
        """Return the face at the position of a part."""
        return Face(
            self.outline, placement.angle, (MILLIMETRES * placement.origin[0], MILLIMETRES * placement.origin[1])
        )

    @cached_property
    def points(self) -> Array:
        """Points along its edges (n, 2) [mm]."""
        return rotate_points(self.outline.points, self.angle) + np.array(self.origin)

    @cached_property
    def box(self) -> tuple[Array, Array]:
        """Corners of a box around it [mm]."""
        margin = MILLIMETRES * SPACING
        return self.points.min(axis=0) - margin, self.points.max(axis=0) + margin

    def edge(self, number: int) -> Any:
        """Return an edge in place."""
        motion = occ.gp_Trsf()
        motion.SetRotation(occ.gp_Ax1(occ.gp_Pnt(), occ.gp_Dir(0.0, 0.0, 1.0)), self.angle)
        motion.SetTranslationPart(occ.gp_Vec(*self.origin, 0.0))
        return self.outline.edges[number].Moved(occ.TopLoc_Location(motion))

    def to_frame(self, points: Array) -> Array:
        """Return points (n, 2) [mm] in the frame of its outline."""
        return rotate_points(points - np.array(self.origin), -self.angle)

    def gaps(self, points: Array) -> Array:
        """Compute the distances of points (n, 2) from its points [mm], shape (n,)."""
        return np.asarray(self.outline.tree.query(self.to_frame(points))[0])


@dataclass(frozen=True, eq=False)
class Prism:
    """A prism of a part in place: its part and body, face, and ends along z [m]."""

    part: str
    body: str
    face: Face
    low: float
    high: float


def smallest_distances(reducer: Reducer, casing: Casing, cranks: Iterable[float]) -> tuple[Distance, ...]:
    """Compute the smallest distance between any two kinds of parts of different bodies over crank angles [rad].

    For parts that are separated along the axis by the axial play, it is the distance along the axis: a lower bound.
    """
    smallest: dict[tuple[str, ...], Distance] = {}
    faces = {part: [(face_of(one), one) for one in stack] for part, stack in assembly_sections(reducer, casing).items()}
    for crank in cranks:
        for one, other in combinations(_prisms(reducer, casing, crank, faces), 2):
            key = tuple(sorted((names.family(one.part), names.family(other.part))))
            if one.body == other.body or one.part == other.part or _is_raceway(key):
                continue
            gap = max(one.low - other.high, other.low - one.high)
            limit = smallest[key].value if key in smallest else math.inf
            if gap >= limit:
                continue
            aside = 0.0 if gap >= casing.play - SAME_LENGTH else planar_distance(one.face, other.face, limit)
            distance = math.hypot(max(gap, 0.0), aside)
            if distance < limit:
                smallest[key] = Distance(one.part, other.part, distance, aside < gap)
    return tuple(smallest.values())


def planar_distance(first: Face, second: Face, limit: float = math.inf) -> float:
    """Compute the distance between two plane faces [m], 0 if they overlap, inf if it is larger than a limit [m]."""
    (low, high), (other_low, other_high) = first.box, second.box
    if np.hypot(*np.maximum(np.maximum(low - other_high, other_low - high), 0.0)) >= MILLIMETRES * limit:
        return math.inf
    may_contain = bool(np.all(low <= other_low) and np.all(high >= other_high))
    if not may_contain and np.all(low >= other_low) and np.all(high <= other_high):
        first, second, may_contain = second, first, True
    gaps = first.gaps(second.points)
    if may_contain and first.outline.covers(first.to_frame(second.points[[np.argmax(gaps)]])[0]):
        return 0.0
    reach = min(float(gaps.min()), MILLIMETRES * limit) + MILLIMETRES * SPACING
    near = np.flatnonzero(gaps <= reach)
    neighbours = first.outline.tree.query_ball_point(first.to_frame(second.points[near]), reach)
    owners, others = first.outline.owners, second.outline.owners[near]
    pairs = {(owner, other) for found, other in zip(neighbours, others, strict=True) for owner in {*owners[found]}}
    values = [occ.BRepExtrema_DistShapeShape(first.edge(i), second.edge(j)).Value() for i, j in pairs]
    return min(values, default=math.inf) / MILLIMETRES


def _is_raceway(families: tuple[str, ...]) -> bool:
    """Return whether needles of a bearing roll on a part, or the lip of a seal slides on it."""
    return bool(ON_RACEWAYS & {*families} and NEEDLES_ON & {*families})


def face_of(section: PartSection) -> Face:
    """Return the plane face of a part's section."""
    shape = planar_face(section)
    edges: list[Any] = []
    points: list[list[float]] = []
    owners: list[int] = []
    explorer = occ.TopExp_Explorer(shape, occ.TopAbs_ShapeEnum.TopAbs_EDGE)
    while explorer.More():
        edge = occ.TopoDS.Edge(explorer.Current())
        curve = occ.BRepAdaptor_Curve(edge)
        count = 2 + int(occ.GCPnts_AbscissaPoint.Length_s(curve) / (MILLIMETRES * SPACING))
        along = occ.GCPnts_UniformAbscissa(curve, count)
        values = [curve.Value(along.Parameter(number)) for number in range(1, along.NbPoints() + 1)]
        points += [[value.X(), value.Y()] for value in values]
        owners += [len(edges)] * len(values)
        edges.append(edge)
        explorer.Next()
    return Face(Outline(tuple(edges), np.array(points), np.array(owners)))


def _prisms(
    reducer: Reducer, casing: Casing, crank: float, faces: Mapping[str, Sequence[tuple[Face, PartSection]]]
) -> Iterator[Prism]:
    """Yield the prisms of all parts at a crank angle [rad]; a bearing has the prisms of its rings.

    `faces` are the faces and sections of each part by name.
    """
    for place in place_parts(reducer, crank, casing):
        z = place.origin[2]
        for face, section in faces[place.part]:
            ends = section.z0 + z, section.z1 + z
            if names.family(place.part) in (names.SHAFT_BEARING, names.OUTPUT_BEARING):
                for body, ring in _rings(reducer, casing, place, section):
                    yield Prism(place.name, body, ring, *ends)
            else:
                yield Prism(place.name, place.body, face.moved(place), *ends)


def _rings(reducer: Reducer, casing: Casing, placement: PlacedPart, drawn: PartSection) -> Iterator[tuple[str, Face]]:
    """Yield the outer ring of a bearing with its body, and its inner ring unless it is a drawn cup."""
    (outside,), (bore,) = drawn.loops
    assert isinstance(outside, Circle)
    assert isinstance(bore, Circle)
    on_shaft = names.family(placement.part) == names.SHAFT_BEARING
    around = names.OUTPUT if on_shaft and casing.far and placement.origin[2] > 0.0 else names.HOUSING
    if on_shaft and shaft_bearing(reducer) in stock.needle_bearings():
        yield around, _annulus(outside.radius, bore.radius)
        return
    inner, outer = (
        (shoulder_radius(bore.radius, outside.radius), shoulder_radius(outside.radius, bore.radius))
        if on_shaft
        else casing.hub.shoulders
    )
    yield around, _annulus(outside.radius, outer)
    yield names.SHAFT if on_shaft else names.OUTPUT, _annulus(inner, bore.radius)


def _annulus(outer: float, inner: float) -> Face:
    """Return the face of a ring about the axis by its radii [m]."""
    loops = (Circle((0.0, 0.0), outer),), (Circle((0.0, 0.0), inner),)
    return face_of(PartSection("ring", loops, 0.0, 1.0))
