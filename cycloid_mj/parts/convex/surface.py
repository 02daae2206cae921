"""A working surface as a few convex slices, each placed many times."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.parts import Prism
from cycloid_mj.parts.polygon import rotate_clockwise


@dataclass(frozen=True)
class Slice:
    """The cross-section of one convex slice.

    Attributes
    ----------
    outline
        Counter-clockwise convex polygon (n, 2) [m].
    width
        Width of its working face [m]; infinite for a hull that carries a full contact.
    curvature
        Relative curvature of the contact [1/m]: that of the part plus that of its mate, convex positive.
    radius, play
        For a facet of a round hole its radius and the radial play of the part in it [m]; otherwise 0.
    """

    outline: Array
    width: float
    curvature: float
    radius: float = 0.0
    play: float = 0.0


@dataclass(frozen=True)
class SlicePlacement:
    """Position of a slice: mirrored at x = 0, rotated clockwise about z by `angle` [rad], moved to `centre` [m].

    `slice` is its index; `member` the lobe, hole or socket that it belongs to, from 1, clockwise from +y.
    """

    slice: int
    member: int
    angle: float
    centre: tuple[float, float] = (0.0, 0.0)
    mirrored: bool = False


@dataclass(frozen=True)
class ConvexSurface:
    """A working surface of a part (disc, ring or pins) as convex slices of its full width.

    Attributes
    ----------
    name
        ``teeth``, ``lobe``, ``bore``, ``hole`` or ``socket``.
    slices, places
        The slices, and their positions in the frame of the part.
    half_width
        The slices reach from -half_width to half_width along z [m].
    points, normals
        Points (k, 2) [m] of the true surface, equally spaced, and its unit normals out of the material.
    strip_area
        True area between the surface and the far ends of the slices [m2].
    depth
        Minimum thickness of the slices along the normal [m].
    overfill_bound, underfill_bound
        Allowed deviation of the slices from the true surface, out of the material and into it [m].
    disc
        Index of the disc if its surface differs from that of the first disc; 0 for all others.
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
        """Its name among all surfaces of a design, also in files: ``teeth``, or ``gear_2_teeth`` if they differ."""
        return names.column(names.numbered_name(names.GEAR, self.disc + 1), self.name) if self.disc else self.name


def prism(surface: ConvexSurface, number: int) -> Prism:
    """Return slice `number` as a prism in its own frame."""
    return Prism(surface.slices[number].outline, (), -surface.half_width, surface.half_width)


def placed_outline(surface: ConvexSurface, placement: SlicePlacement) -> Array:
    """Compute the outline of a placed slice, counter-clockwise, in the frame of the part (n, 2) [m]."""
    points = surface.slices[placement.slice].outline
    if placement.mirrored:
        points = (points * [-1.0, 1.0])[::-1]
    return rotate_clockwise(points, placement.angle) + placement.centre


def convex_slice(
    name: str, outline: Array, width: float, curvature: float, radius: float = 0.0, play: float = 0.0
) -> Slice:
    """Return a slice of a contact surface with a convex outline, its corners sorted counter-clockwise.

    Parameters
    ----------
    name
        Name of the surface, for the error.
    outline
        Corners (n, 2) [m].
    width, curvature
        Width of its working face [m], and relative curvature of the contact [1/m], convex positive.
    radius, play
        For a facet of a round hole its radius and the radial play of the part in it [m]; otherwise 0.

    Raises
    ------
    DesignError
        The outline is not strictly convex.
    """
    edges = np.roll(outline, -1, axis=0) - outline
    next_edges = np.roll(edges, -1, axis=0)
    cross_products = edges[:, 0] * next_edges[:, 1] - edges[:, 1] * next_edges[:, 0]
    if not ((cross_products > 0.0).all() or (cross_products < 0.0).all()):
        raise DesignError(
            f"a slice of the {name} is not convex, but only convex slices can be simulated: reduce ConvexSettings.depth"
        )
    return Slice(outline if cross_products[0] > 0.0 else outline[::-1], width, curvature, radius, play)
