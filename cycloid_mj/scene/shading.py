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
    """Return a watertight mesh with vertex normals, after splitting vertices at creases (edges sharper than `CREASE`).

    The normals are means of the face normals, weighted by corner angles.
    """
    corners = mesh.vertices[mesh.faces]
    cross_products = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    cross_lengths = np.linalg.norm(cross_products, axis=1, keepdims=True)
    face_normals = np.divide(
        cross_products, cross_lengths, out=np.zeros_like(cross_products), where=cross_lengths > 0.0
    )
    adjacent_faces = _adjacent_faces(mesh.faces)
    is_smooth = np.einsum("ij,ij->i", face_normals[adjacent_faces[:, 0]], face_normals[adjacent_faces[:, 1]]) >= np.cos(
        CREASE
    )
    smooth_component_labels = _connected_components(adjacent_faces[is_smooth], len(mesh.faces))
    vertex_keys = smooth_component_labels[:, np.newaxis] * len(mesh.vertices) + mesh.faces
    unique_keys, vertex_indices = np.unique(vertex_keys, return_inverse=True)
    faces = vertex_indices.reshape(-1, 3)
    weighted_normals = (_corner_angles(corners)[..., np.newaxis] * face_normals[:, np.newaxis]).reshape(-1, 3)
    normal_sums = np.stack(
        [np.bincount(faces.ravel(), weights=component, minlength=len(unique_keys)) for component in weighted_normals.T],
        axis=1,
    )
    normals = normal_sums / np.linalg.norm(normal_sums, axis=1, keepdims=True)
    return ShadedMesh(mesh.vertices[unique_keys % len(mesh.vertices)], normals, faces.astype(np.int32))


def _adjacent_faces(faces: Faces) -> Integers:
    """Return the pairs of faces (k, 2) that share an edge of a watertight mesh."""
    start_nodes, end_nodes = faces.ravel().astype(np.int64), np.roll(faces, -1, axis=1).ravel().astype(np.int64)
    edge = np.minimum(start_nodes, end_nodes) * (int(faces.max()) + 1) + np.maximum(start_nodes, end_nodes)
    order = np.argsort(edge, kind="stable")
    return (order // 3).reshape(-1, 2)


def _connected_components(pairs: Integers, node_count: int) -> Integers:
    """Label the connected components of a graph: return for each node the smallest node of its component.

    `pairs` (k, 2) are the connected nodes, numbered from 0 to `node_count` - 1. Each round hooks roots onto smaller
    neighbours and then shortens all paths (Shiloach & Vishkin 1982).
    """
    root = np.arange(node_count)
    first_nodes, second_nodes = pairs.T
    while True:
        first_roots, second_roots = root[first_nodes], root[second_nodes]
        smaller_roots, larger_roots = np.minimum(first_roots, second_roots), np.maximum(first_roots, second_roots)
        if (smaller_roots == larger_roots).all():
            return root
        np.minimum.at(root, larger_roots, smaller_roots)
        while (shortened_root := root[root]).tolist() != root.tolist():
            root = shortened_root


def _corner_angles(corners: Array) -> Array:
    """Return the angle [rad] at each corner of m triangles, shape (m, 3), from their corners in space, (m, 3, 3)."""
    angles = np.empty(corners.shape[:2])
    for corner in range(3):
        next_edge = corners[:, (corner + 1) % 3] - corners[:, corner]
        previous_edge = corners[:, (corner + 2) % 3] - corners[:, corner]
        cross_length = np.linalg.norm(np.cross(next_edge, previous_edge), axis=1)
        angles[:, corner] = np.arctan2(cross_length, np.einsum("ij,ij->i", next_edge, previous_edge))
    return angles
