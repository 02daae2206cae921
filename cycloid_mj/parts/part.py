"""A part as segments of exact outlines along z, from which its solid and its sections for CAD follow."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from cycloid_mj.parts.contour import Contour, contour_area
from cycloid_mj.parts.curve import Curve
from cycloid_mj.parts.prism import Prism, Solid


@dataclass(frozen=True)
class PartSection:
    """A section of a part: closed loops of curves from `z0` to `z1` [m], the outline first, then its holes.

    The curves of a loop are consecutive and counter-clockwise; so is the direction of the first curve.
    """

    name: str
    loops: tuple[tuple[Curve, ...], ...]
    z0: float
    z1: float


@dataclass(frozen=True)
class Segment:
    """A segment of a part: an outline with holes, from `z0` to `z1` [m]."""

    name: str
    outline: Contour
    holes: tuple[Contour, ...]
    z0: float
    z1: float

    def prism(self, chord_error: float) -> Prism:
        """Return it as a prism of polygons with a chord error [m]."""
        holes = tuple(hole.polygon(chord_error) for hole in self.holes)
        return Prism(self.outline.polygon(chord_error), holes, self.z0, self.z1)

    def volume(self, chord_error: float) -> float:
        """Compute the volume of `prism` [m3], without building it."""
        area = contour_area(self.outline, chord_error) - sum(contour_area(hole, chord_error) for hole in self.holes)
        return area * (self.z1 - self.z0)

    def section(self, splines: int) -> PartSection:
        """Return it as curves, with `splines` splines per lobe of a disc or root of the internal gear."""
        loops = tuple(outline.curves(splines) for outline in (self.outline, *self.holes))
        return PartSection(self.name, loops, self.z0, self.z1)


@dataclass(frozen=True)
class Part:
    """A part of the reducer: segments without common volume, of one density [kg/m3]."""

    name: str
    segments: tuple[Segment, ...]
    density: float

    def solid(self, chord_error: float) -> Solid:
        """Return the part as prisms of polygons; see `Segment.prism`."""
        return Solid(self.name, tuple(segment.prism(chord_error) for segment in self.segments), self.density)

    def mass(self, chord_error: float) -> float:
        """Compute the mass of `solid` [kg], without building it."""
        return self.density * sum(segment.volume(chord_error) for segment in self.segments)

    def sections(self, splines: int) -> tuple[PartSection, ...]:
        """Return the part as curves; see `Segment.section`."""
        return tuple(segment.section(splines) for segment in self.segments)

    def of(self, segments: Iterable[Segment], name: str = "") -> "Part":
        """Return a part of the same material with other segments and, unless empty, another name."""
        return replace(self, name=name or self.name, segments=tuple(segments))
