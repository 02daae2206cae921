"""Vertex normals of a mesh whose nearly flat edges look smooth."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.parts import Mesh
from cycloid_mj.parts.mesh import Faces

CREASE = np.radians(30.0)
"""Angle between two faces up to which they look like one curved surface [rad]."""


@dataclass(frozen=True)
class ShadedMesh:
    """A mesh in which a point has a vertex, with its normal, for each smooth surface that it is on.

    Vertices and unit normals have shape (n, 3), [m] and 1; faces have shape (m, 3).
    """

    vertices: Array
    normals: Array
    faces: Faces


def shade(mesh: Mesh) -> ShadedMesh:
    """Return a watertight mesh with its vertices split at creases, and normals weighted by the angles of the faces."""
    corners = mesh.vertices[mesh.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1, keepdims=True)
    flat = np.divide(across, area, out=np.zeros_like(across), where=area > 0.0)
    pairs = _adjacent_faces(mesh.faces)
    smooth = np.einsum("ij,ij->i", flat[pairs[:, 0]], flat[pairs[:, 1]]) >= np.cos(CREASE)
    surface = _components(pairs[smooth], len(mesh.faces))
    key = surface[:, np.newaxis] * len(mesh.vertices) + mesh.faces
    used, numbers = np.unique(key, return_inverse=True)
    faces = numbers.reshape(-1, 3)
    weighted = (_corner_angles(corners)[..., np.newaxis] * flat[:, np.newaxis]).reshape(-1, 3)
    sums = np.stack([np.bincount(faces.ravel(), weights=part, minlength=len(used)) for part in weighted.T], axis=1)
    normals = sums / np.linalg.norm(sums, axis=1, keepdims=True)
    return ShadedMesh(mesh.vertices[used % len(mesh.vertices)], normals, faces.astype(np.int32))


def _adjacent_faces(faces: Faces) -> Integers:
    """Return the pairs of faces (k, 2) that share an edge of a watertight mesh."""
    start, end = faces.ravel().astype(np.int64), np.roll(faces, -1, axis=1).ravel().astype(np.int64)
    edge = np.minimum(start, end) * (int(faces.max()) + 1) + np.maximum(start, end)
    order = np.argsort(edge, kind="stable")
    return (order // 3).reshape(-1, 2)


def _components(pairs: Integers, count: int) -> Integers:
    """Return for each of `count` nodes the smallest node that pairs (k, 2) connect it with.

    Each round hooks roots onto smaller neighbours and then shortens all paths (Shiloach & Vishkin 1982).
    """
    root = np.arange(count)
    a, b = pairs.T
    while True:
        low, high = np.minimum(root[a], root[b]), np.maximum(root[a], root[b])
        if (low == high).all():
            return root
        np.minimum.at(root, high, low)
        while (shorter := root[root]).tolist() != root.tolist():
            root = shorter


def _corner_angles(corners: Array) -> Array:
    """Return the angle at each corner of triangles, shape (m, 3), from their corners (m, 3, 3)."""
    angles = np.empty(corners.shape[:2])
    for corner in range(3):
        first = corners[:, (corner + 1) % 3] - corners[:, corner]
        second = corners[:, (corner + 2) % 3] - corners[:, corner]
        crossed = np.linalg.norm(np.cross(first, second), axis=1)
        angles[:, corner] = np.arctan2(crossed, np.einsum("ij,ij->i", first, second))
    return angles
