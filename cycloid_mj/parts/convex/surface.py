"""The value of the room: a working surface as few convex slices, each placed many times."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.parts import Prism


@dataclass(frozen=True)
class Slice:
    """The cross-section of one convex slice.

    Attributes
    ----------
    outline
        Counter-clockwise convex polygon (n, 2) [m].
    width
        Width of its working face [m]; infinite for a hull that carries a whole contact alone.
    curvature
        Relative curvature of the contact there [1/m]: the part's plus its mate's, convex positive.
    radius, play
        Of a facet of a round hole: the hole's radius, and by how much it exceeds that of the part in it [m]; else 0.
    """

    outline: Array
    width: float
    curvature: float
    radius: float = 0.0
    play: float = 0.0


@dataclass(frozen=True)
class SlicePlacement:
    """Where a slice stands: mirrored at x = 0 first, turned clockwise about z by `angle` [rad], moved to `centre` [m].

    `slice` is its index; `member` the lobe, hole or socket it belongs to, from 1, clockwise from +y.
    """

    slice: int
    member: int
    angle: float
    centre: tuple[float, float] = (0.0, 0.0)
    mirrored: bool = False


@dataclass(frozen=True)
class ConvexSurface:
    """One working surface of a part, as convex slices of its whole width: a disc's own, or that of ring and pins.

    Attributes
    ----------
    name
        ``teeth``, ``lobe``, ``bore``, ``hole`` or ``socket``.
    slices, places
        The slices, and where they stand in the part's frame.
    half_width
        The slices reach from -half_width to half_width along z [m].
    points, normals
        Points (k, 2) [m] of the true surface, equally spaced, and its unit normals out of the material.
    strip_area
        True area between the surface and the slices' far ends [m2].
    depth
        Least thickness of the slices along the normal [m].
    overfill_bound, underfill_bound
        How far the slices may leave the true surface, out of the material and into it [m].
    disc
        Index of the one disc whose surface it is, where that differs from the first disc's; 0: of all others.
    """

    name: str
    slices: tuple[Slice, ...]
    places: tuple[SlicePlacement, ...]
    half_width: float
    points: Array
    normals: Array
    strip_area: float
    depth: float
    overfill_bound: float
    underfill_bound: float
    disc: int = 0

    @property
    def key(self) -> str:
        """Its name among all surfaces of a design, in files, too: ``teeth``, and ``gear_2_teeth`` where they differ."""
        return names.column(names.numbered(names.GEAR, self.disc + 1), self.name) if self.disc else self.name


def prism(surface: ConvexSurface, number: int) -> Prism:
    """Build the solid of slice `number` in its own frame."""
    return Prism(surface.slices[number].outline, (), -surface.half_width, surface.half_width)


def placed_outline(surface: ConvexSurface, place: SlicePlacement) -> Array:
    """Compute the outline of a placed slice, counter-clockwise, in the part's frame (n, 2) [m]."""
    points = surface.slices[place.slice].outline
    if place.mirrored:
        points = (points * [-1.0, 1.0])[::-1]
    return turned(points, place.angle) + place.centre


def turned(points: Array, angle: float) -> Array:
    """Turn points (n, 2) clockwise about the origin by an angle [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    return points @ np.array([[cos, -sin], [sin, cos]])


def convex_slice(
    name: str, outline: Array, width: float, curvature: float, radius: float = 0.0, play: float = 0.0
) -> Slice:
    """Return a slice, its outline made counter-clockwise.

    Raises
    ------
    DesignError
        The outline is not strictly convex.
    """
    edges = np.roll(outline, -1, axis=0) - outline
    after = np.roll(edges, -1, axis=0)
    bends = edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0]
    if not ((bends > 0.0).all() or (bends < 0.0).all()):
        raise DesignError(f"a slice of the {name} is not convex: make ConvexSettings.depth smaller")
    return Slice(outline if bends[0] > 0.0 else outline[::-1], width, curvature, radius, play)
