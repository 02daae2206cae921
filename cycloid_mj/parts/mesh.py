"""Triangle meshes of solids: watertight, outward oriented, checked."""

from dataclasses import dataclass
from functools import lru_cache

import mapbox_earcut
import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts.inertia import region_moments
from cycloid_mj.parts.polygon import crossing
from cycloid_mj.parts.prism import Prism, Solid

Faces = npt.NDArray[np.int32]

VOLUME_TOLERANCE = 1e-9
"""Relative; triangulations of one polygon differ by rounding only, a wrong one by whole triangles."""

SHAKE = 1e-11
"""Relative to the size of the part; well above rounding, and its slivers well below VOLUME_TOLERANCE."""


@dataclass(frozen=True)
class Mesh:
    """Vertices (n, 3) [m] and triangles (m, 3), counter-clockwise seen from outside; read-only."""

    vertices: Array
    faces: Faces

    def __post_init__(self) -> None:
        """Lock the arrays."""
        self.vertices.setflags(write=False)
        self.faces.setflags(write=False)


@lru_cache(maxsize=12)  # the parts of one design: they hold their outlines
def mesh(part: Prism | Solid) -> Mesh:
    """Build the mesh of a prism, or of a solid: one closed surface for each of its prisms.

    Raises
    ------
    DesignError
        An outline crosses itself or a hole, or the mesh is not watertight or has not the prism's volume.
    """
    name, prisms = (part.name, part.prisms) if isinstance(part, Solid) else ("prism", (part,))
    meshes = [_prism_mesh(prism, name) for prism in prisms]
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        vertices=np.concatenate([mesh.vertices for mesh in meshes]),
        faces=np.concatenate([mesh.faces + np.int32(start) for mesh, start in zip(meshes, first, strict=False)]),
    )


def _prism_mesh(prism: Prism, name: str) -> Mesh:
    """Two caps and the side walls; every ring runs with the material on its left."""
    rings = [prism.outline, *(hole[::-1] for hole in prism.holes)]
    place = crossing(rings)
    if place is not None:
        raise crossed(name, place)
    points = np.concatenate(rings)
    cap = triangulated(points, rings)
    _check_cap(cap, points, prism, name)
    faces = np.concatenate([cap[:, ::-1], cap + len(points), _walls(rings)])
    check_watertight(faces, name)
    bottom = np.column_stack([points, np.full(len(points), prism.z0)])
    top = np.column_stack([points, np.full(len(points), prism.z1)])
    return Mesh(np.concatenate([bottom, top]), faces.astype(np.int32))


def crossed(name: str, place: Array) -> DesignError:
    """Return the error of a part whose outlines cross or touch at a point (2,) [m]."""
    x, y = place * MILLIMETRES
    return DesignError(
        f"{name}: two of its outlines touch or cross near x = {x:.6g} mm, y = {y:.6g} mm, so the part is not one "
        "piece; change the dimensions of the features that meet there"
    )


def triangulated(points: Array, rings: list[Array]) -> Integers:
    """Compute the cap's triangles (m, 3), counter-clockwise.

    The earcut drops a vertex that lies exactly between its neighbours, which leaves the mesh open: it gets the
    vertices shaken, far below every feature, so that no three are in line.
    """
    ends = np.cumsum([len(ring) for ring in rings]).astype(np.uint32)
    shake = SHAKE * np.ptp(points) * np.random.default_rng(0).uniform(-1.0, 1.0, points.shape)
    return mapbox_earcut.triangulate_float64(points + shake, ends).reshape(-1, 3).astype(np.int64)


def _walls(rings: list[Array]) -> Integers:
    """Compute two triangles for every edge i -> j of the rings, between the bottom vertices and the top ones."""
    total = sum(len(ring) for ring in rings)
    last = np.cumsum([len(ring) for ring in rings])
    i = np.arange(total)
    j = i + 1
    j[last - 1] = last - [len(ring) for ring in rings]
    return np.concatenate([np.column_stack([i, j, j + total]), np.column_stack([i, j + total, i + total])])


def _check_cap(cap: Integers, points: Array, prism: Prism, name: str) -> None:
    """Refuse a cap whose triangles overlap or leave a gap: their areas, all positive, add up to the region's."""
    a, b, c = points[cap].transpose(1, 2, 0)
    covered = np.abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).sum() / 2
    area = region_moments(prism).area
    if not abs(covered - area) <= VOLUME_TOLERANCE * area:
        raise DesignError(
            f"{name}: its mesh has the volume {covered * prism.height:.9g} m3 instead of {area * prism.height:.9g} m3; "
            "a hole lies outside the outline or inside another hole: change their radii"
        )


def check_watertight(faces: Integers, name: str) -> None:
    """Refuse a mesh in which some edge is not passed exactly once in each direction."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    size = int(faces.max()) + 1
    there = np.sort(start * size + end)
    back = np.sort(end * size + start)
    if not (np.array_equal(there, back) and (np.diff(there) > 0).all()):
        raise DesignError(f"{name}: its mesh is not watertight; choose another chord error")
