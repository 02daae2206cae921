"""The mesh of a solid as one closed surface: stacked prisms without their common faces."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.errors import DesignError
from cycloid_mj.parts.inertia import mass_properties
from cycloid_mj.parts.mesh import VOLUME_TOLERANCE, Mesh, check_watertight, crossing_error, triangulate
from cycloid_mj.parts.polygon import crossing, signed_area, within
from cycloid_mj.parts.prism import Prism, Solid

NONE = np.empty((0, 2), dtype=np.int64)


def fuse(solid: Solid) -> Mesh:
    """Return the mesh of a solid as one closed surface; separate prisms remain separate surfaces.

    Stacked outlines may share edges if their vertices there are bit-equal.

    Raises
    ------
    DesignError
        Stacked outlines cross or touch, the mesh is not watertight, or its volume is not that of the solid.
    """
    rings = [ring for prism in solid.prisms for ring in _rings(prism)]
    points, numbers = np.unique(np.concatenate(rings) + 0.0, axis=0, return_inverse=True)
    loops = iter(np.split(numbers.ravel(), np.cumsum([len(ring) for ring in rings])[:-1]))
    edges = [np.concatenate([_edges(next(loops)) for _ in _rings(prism)]) for prism in solid.prisms]
    levels = sorted({z for prism in solid.prisms for z in (prism.z0, prism.z1)})
    layers = [
        np.concatenate(
            [NONE, *(own for own, prism in zip(edges, solid.prisms, strict=True) if _spans(prism, low, high))]
        )
        for low, high in pairwise(levels)
    ]
    faces, count = [], len(points)
    for level, (below, above) in enumerate(pairwise([NONE, *layers, NONE])):
        faces += [cap + level * count for cap in _caps(points, below, above, solid.name)]
        i, j = above.T + level * count
        faces += [np.column_stack([i, j, j + count]), np.column_stack([i, j + count, i + count])]
    used, compact = np.unique(np.concatenate(faces), return_inverse=True)
    heights = np.array(levels)[used // count]
    triangles = compact.reshape(-1, 3)
    check_watertight(triangles, solid.name)
    shape = Mesh(np.column_stack([points[used % count], heights]), triangles.astype(np.int32))
    volume, true = _volume(shape), mass_properties(solid).volume
    if not abs(volume / true - 1.0) <= VOLUME_TOLERANCE:
        raise DesignError(f"{solid.name}: its mesh has the volume {volume:.9g} m3 instead of {true:.9g} m3")
    return shape


def _rings(prism: Prism) -> tuple[Array, ...]:
    """Return outline and holes with the material on their left."""
    return (prism.outline, *(hole[::-1] for hole in prism.holes))


def _edges(loop: Integers) -> Integers:
    return np.column_stack([loop, np.roll(loop, -1)])


def _spans(prism: Prism, low: float, high: float) -> bool:
    return prism.z0 <= low and prism.z1 >= high


def _caps(points: Array, below: Integers, above: Integers, name: str) -> Iterator[Integers]:
    """Yield triangles (m, 3) at a height: facing up with material only below it, down with material only above it.

    Common edges (n, 2) of both regions bound neither difference and cancel.
    """
    codes = [edges @ np.array([len(points), 1]) for edges in (below, above)]
    own = [edges[~np.isin(code, other)] for edges, code, other in zip((below, above), codes, codes[::-1], strict=True)]
    loops = _chain_loops(points, np.concatenate([own[0], own[1][:, ::-1]]), name)
    point = crossing([points[loop] for loop in loops]) if loops else None
    if point is not None:
        raise crossing_error(name, point)
    enclosing = [
        [j for j, other in enumerate(loops) if j != i and within(points[loop[:1]], points[other])[0]]
        for i, loop in enumerate(loops)
    ]
    for i, loop in enumerate(loops):
        if len(enclosing[i]) % 2:
            continue
        holes = [loops[j] for j, outer in enumerate(enclosing) if i in outer and len(outer) == len(enclosing[i]) + 1]
        up = signed_area(points[loop]) > 0.0
        rings = [ring if up else ring[::-1] for ring in (loop, *holes)]
        cap = np.concatenate(rings)[triangulate(points[np.concatenate(rings)], [points[ring] for ring in rings])]
        yield cap if up else cap[:, ::-1]


def _chain_loops(points: Array, edges: Integers, name: str) -> list[Integers]:
    """Join edges (n, 2) to closed loops."""
    following = dict(edges.tolist())
    if len(following) < len(edges):
        first, times = np.unique(edges[:, 0], return_counts=True)
        raise crossing_error(name, points[first[times > 1][0]])
    loops = []
    while following:
        start, vertex = following.popitem()
        loop = [start]
        while vertex != start:
            loop.append(vertex)
            vertex = following.pop(vertex)
        loops.append(np.array(loop))
    return loops


def _volume(shape: Mesh) -> float:
    """Compute the volume of a closed surface [m3] by the divergence theorem."""
    a, b, c = shape.vertices[shape.faces].transpose(1, 0, 2)
    return float(np.sum(np.cross(a, b) * c) / 6.0)
