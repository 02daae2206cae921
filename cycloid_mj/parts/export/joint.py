"""The records of a joint: mating parts, holes, threads, fit, and the bought parts that make it."""

from dataclasses import dataclass
from enum import StrEnum

from cycloid_mj.parts.export.round_part import Hole, RoundPart

Point = tuple[float, float, float]


class JointKind(StrEnum):
    """The function of a joint; the value is the word for people and programs."""

    SCREWED = "screwed"
    DOWELLED = "dowelled"
    BEARING = "rolling bearing"
    LOCATED = "located"
    """One part centres the other."""
    PRESSED = "pressed"
    GLUED = "glued"
    KEYED = "keyed"
    SPLINED = "splined"
    CLAMPED = "clamped"
    """A slotted hub is clamped on its shaft by screws."""
    CLEARANCE = "clearance"
    """Parts move in a cavity without touching it."""


@dataclass(frozen=True, eq=False)
class BoughtPart:
    """Equal bought parts of a joint: a solid and its positions, and a line of the bill of materials.

    Attributes
    ----------
    item
        Its name in the bill; the n-th part of all joints is ``item_n``.
    solid
        The part in its own frame.
    body
        Body of the mechanism that it moves with.
    origins
        Its positions [m].
    dimensions
        Names and values [m] of its dimensions.
    material, designation, fit
        As in the bill; empty if the catalogue or the shop decides.
    first
        Number of the part at the first position.
    """

    item: str
    solid: RoundPart
    body: str
    origins: tuple[Point, ...]
    dimensions: tuple[tuple[str, float], ...]
    material: str = ""
    designation: str = ""
    fit: str = ""
    first: int = 1


@dataclass(frozen=True)
class CrossHole:
    """A hole across the axis of a part: start of its axis (x, y, z) [m], direction, radius and length [m]."""

    start: Point
    direction: Point
    radius: float
    length: float


@dataclass(frozen=True)
class TappedHole:
    """Equal threads in a part: number, nominal diameter and depth [m], and the insert in a plastic (else empty)."""

    part: str
    count: int
    thread: float
    depth: float
    insert: str = ""


@dataclass(frozen=True, eq=False)
class Joint:
    """A connection of parts.

    Attributes
    ----------
    name, kind
        What it connects, in words, and how.
    parts
        Mating parts by name.
    holes
        Holes of the joint, each with the name of the part that it is cut into.
    bought
        The bought parts that make it.
    fit
        Fit of its parts by ISO 286-1, or in words; empty for screws.
    count, diameter, length
        Number of equal seats, and diameter and length of each [m]; 0 where a joint has none.
    threads
        Its tapped holes.
    cross_holes
        Holes across the axis, each with the name of its part. Only STEP files and drawings have them.
    """

    name: str
    kind: JointKind
    parts: tuple[str, ...]
    holes: tuple[tuple[str, Hole], ...] = ()
    bought: tuple[BoughtPart, ...] = ()
    fit: str = ""
    count: int = 1
    diameter: float = 0.0
    length: float = 0.0
    threads: tuple[TappedHole, ...] = ()
    cross_holes: tuple[tuple[str, CrossHole], ...] = ()

    def holes_in(self, part: str) -> tuple[Hole, ...]:
        """Return the holes of the joint in one of its parts."""
        return tuple(hole for name, hole in self.holes if name == part)
