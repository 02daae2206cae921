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
"""Relative tolerance of volumes: correct triangulations of a polygon differ by rounding, wrong ones by triangles."""

PERTURBATION = 1e-11
"""Perturbation of vertices relative to the size of the part: above rounding, its slivers below VOLUME_TOLERANCE."""


@dataclass(frozen=True)
class Mesh:
    """Vertices (n, 3) [m] and triangles (m, 3), counter-clockwise seen from outside; read-only."""

    vertices: Array
    faces: Faces

    def __post_init__(self) -> None:
        """Lock the arrays."""
        self.vertices.setflags(write=False)
        self.faces.setflags(write=False)


@lru_cache(maxsize=12)  # the parts of one design, which own their outlines
def mesh(part: Prism | Solid) -> Mesh:
    """Return the mesh of a prism, or of a solid as one closed surface per prism.

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
    """Return two caps and the side walls; each ring has the material on its left."""
    rings = [prism.outline, *(hole[::-1] for hole in prism.holes)]
    point = crossing(rings)
    if point is not None:
        raise crossing_error(name, point)
    points = np.concatenate(rings)
    cap = triangulate(points, rings)
    _check_cap(cap, points, prism, name)
    faces = np.concatenate([cap[:, ::-1], cap + len(points), _walls(rings)])
    check_watertight(faces, name)
    bottom = np.column_stack([points, np.full(len(points), prism.z0)])
    top = np.column_stack([points, np.full(len(points), prism.z1)])
    return Mesh(np.concatenate([bottom, top]), faces.astype(np.int32))


def crossing_error(name: str, point: Array) -> DesignError:
    """Return the error of a part whose outlines cross or touch at a point (2,) [m]."""
    x, y = point * MILLIMETRES
    return DesignError(
        f"{name}: two of its outlines touch or cross near x = {x:.6g} mm, y = {y:.6g} mm, so the part is not one "
        "piece; change the dimensions of the features that meet there"
    )


def triangulate(points: Array, rings: list[Array]) -> Integers:
    """Triangulate a cap (m, 3), counter-clockwise.

    The library omits a vertex exactly between its neighbours, which would leave the mesh open. A perturbation far below
    the size of any feature avoids three vertices in line.
    """
    ends = np.cumsum([len(ring) for ring in rings]).astype(np.uint32)
    perturbation = PERTURBATION * np.ptp(points) * np.random.default_rng(0).uniform(-1.0, 1.0, points.shape)
    return mapbox_earcut.triangulate_float64(points + perturbation, ends).reshape(-1, 3).astype(np.int64)


def _walls(rings: list[Array]) -> Integers:
    """Compute two triangles for every edge i -> j of the rings, between the bottom vertices and the top ones."""
    total = sum(len(ring) for ring in rings)
    last = np.cumsum([len(ring) for ring in rings])
    i = np.arange(total)
    j = i + 1
    j[last - 1] = last - [len(ring) for ring in rings]
    return np.concatenate([np.column_stack([i, j, j + total]), np.column_stack([i, j + total, i + total])])


def _check_cap(cap: Integers, points: Array, prism: Prism, name: str) -> None:
    """Raise DesignError if the triangles of a cap overlap or leave gaps: the sum of areas must equal the region."""
    a, b, c = points[cap].transpose(1, 2, 0)
    covered = np.abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).sum() / 2
    area = region_moments(prism).area
    if not abs(covered - area) <= VOLUME_TOLERANCE * area:
        raise DesignError(
            f"{name}: its mesh has the volume {covered * prism.height:.9g} m3 instead of {area * prism.height:.9g} m3; "
            "a hole lies outside the outline or inside another hole: change their radii"
        )


def check_watertight(faces: Integers, name: str) -> None:
    """Raise DesignError unless each edge of a mesh is traversed exactly once in each direction."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    size = int(faces.max()) + 1
    there = np.sort(start * size + end)
    back = np.sort(end * size + start)
    if not (np.array_equal(there, back) and (np.diff(there) > 0).all()):
        raise DesignError(f"{name}: its mesh is not watertight; choose another chord error")
