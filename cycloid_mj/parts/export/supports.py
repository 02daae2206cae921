"""Break-away supports on the plate: a ring or disc one layer below each overhanging face."""

from collections.abc import Iterator
from dataclasses import dataclass

import manifold3d
import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.parts import Mesh, Prism, Solid, circle, mesh
from cycloid_mj.parts.mesh import GRIDS
from cycloid_mj.parts.polygon import signed_area, within


@dataclass(frozen=True)
class SupportSettings:
    """Settings of supports for a nozzle of 0.4 mm and layers of 0.2 mm (assumed)."""

    gap_below: float = 0.2e-3  # gap of a support below its face, a layer [m]
    gap_aside: float = 0.4e-3  # gap of a support next to walls, a line of the nozzle [m]
    max_bridge: float = 8e-3  # largest diameter of the end of a hole that is printed as a bridge [m]
    max_ledge: float = 0.5e-3  # largest width of a ledge that is printed without support [m]
    sliver_area: float = 1e-12  # twice the area below which a triangle has no direction [m2]
    circle_tolerance: float = 1e-8  # largest difference of the radii of the vertices of a circle [m]


SUPPORTS = SupportSettings()


@dataclass(frozen=True, eq=False)
class Overhang:
    """An overhanging face: its height [m], outline, outlines of its holes, and area [m2]."""

    z: float
    outline: Array
    holes: tuple[Array, ...]
    area: float


def find_overhangs(shape: Mesh) -> Iterator[Overhang]:
    """Yield the level faces of a part above the plate that need a support when it is printed.

    `shape` is the mesh of the part as it lies on the plate. Small ends of holes, which are printed as bridges, and
    narrow ledges need none (`SUPPORTS`).
    """
    corners = shape.vertices[shape.faces]
    corner_a, corner_b, corner_c = corners.transpose(1, 0, 2)
    is_level = np.ptp(corners[..., 2], axis=1) == 0.0
    is_overhanging = (
        is_level
        & (np.cross(corner_b - corner_a, corner_c - corner_a)[:, 2] < -SUPPORTS.sliver_area)
        & (corner_a[:, 2] > 0.0)
    )
    for z in np.unique(corner_a[is_overhanging, 2]):
        triangles = corners[is_overhanging & (corner_a[:, 2] == z)][:, ::-1, :2] / GRIDS.unit
        for region in manifold3d.CrossSection(list(triangles)).decompose():
            outline, *holes = sorted(
                (GRIDS.unit * polygon for polygon in region.to_polygons()), key=signed_area, reverse=True
            )
            face = Overhang(float(z), outline, tuple(hole[::-1] for hole in holes), region.area() * GRIDS.unit**2)
            if not _is_bridged(face):
                yield face


def build_support(solid: Solid, overhang: Overhang, chord_error: float) -> Mesh | None:
    """Return the mesh of the support under an overhanging round face, standing on the plate or on the part.

    Parameters
    ----------
    solid
        The part as it lies on the plate.
    overhang
        The face.
    chord_error
        Largest distance of a chord from its curve [m].

    Returns
    -------
    Mesh or None
        None if the face is not round, is too narrow or low, or has faces at several heights below it.
    """
    outer_circle = _circle_of(overhang.outline)
    if not outer_circle:
        return None
    (centre, radius), inner_circle = outer_circle, _largest_hole(overhang.holes)
    width = radius - (inner_circle[1] if inner_circle else 0.0)
    gap = min(SUPPORTS.gap_aside, 0.25 * width)
    outline = circle(radius - gap, chord_error, centre)
    holes: tuple[Array, ...] = ()
    if inner_circle:
        (x, y), hole_radius = inner_circle
        if np.hypot(x - centre[0], y - centre[1]) + hole_radius + 3.0 * gap > radius:
            return None
        holes = (circle(hole_radius + gap, chord_error, inner_circle[0]),)
    floors = _floor_heights(solid, np.concatenate([outline, *holes]), overhang.z)
    if len(floors) > 1:
        return None
    floor_height = floors.pop()
    support_base = floor_height + SUPPORTS.gap_below if floor_height else 0.0
    return (
        mesh(Prism(outline, holes, support_base, overhang.z - SUPPORTS.gap_below))
        if support_base < overhang.z - SUPPORTS.gap_below
        else None
    )


def _is_bridged(face: Overhang) -> bool:
    """Return whether a face is printed without support: the end of a small hole, or a narrow ledge."""
    outer_circle, inner_circle = _circle_of(face.outline), _largest_hole(face.holes)
    if not outer_circle:
        return False
    return (
        outer_circle[1] - inner_circle[1] <= SUPPORTS.max_ledge
        if inner_circle
        else 2.0 * outer_circle[1] <= SUPPORTS.max_bridge
    )


def _largest_hole(holes: tuple[Array, ...]) -> tuple[tuple[float, float], float] | None:
    """Return centre and radius of the largest round hole of a face [m]; supports continue under smaller holes."""
    circles = [circle for hole in holes if (circle := _circle_of(hole))]
    return max(circles, key=lambda circle: circle[1], default=None)


def _circle_of(loop: Array) -> tuple[tuple[float, float], float] | None:
    """Return centre and radius of a closed loop [m] if it is a circle, else None."""
    x, y = loop.mean(axis=0)  # corners of circles are even
    radii = np.hypot(loop[:, 0] - x, loop[:, 1] - y)
    return ((float(x), float(y)), float(radii.mean())) if np.ptp(radii) < SUPPORTS.circle_tolerance else None


def _floor_heights(solid: Solid, points: Array, z: float) -> set[float]:
    """Return the heights [m] of the first faces below n points (n, 2) [m] at the height `z` [m] of a printed part.

    They are faces of the part, or the plate (0); points above the same face share a height. `solid` is the part.
    """
    heights = np.zeros(len(points))
    for prism in solid.prisms:
        if prism.z1 <= z:
            is_covered = within(points, prism.outline) & ~np.any([within(points, hole) for hole in prism.holes], axis=0)
            heights[is_covered] = np.maximum(heights[is_covered], prism.z1)
    return set(heights.tolist())
