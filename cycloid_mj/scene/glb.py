"""A part as a binary glTF 2.0 file (GLB), with smooth normals where faces meet flatly."""

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.scene.shape import Piece
from cycloid_mj.solid import Mesh
from cycloid_mj.types import Array

MEDIA_TYPE = "model/gltf-binary"
CREASE = np.cos(np.radians(30.0))
"""Cosine of the angle between two faces up to which they look like one curved surface."""

_FLOAT, _UNSIGNED = 5126, 5125
_VERTICES, _INDICES = 34962, 34963
_TO_Y_UP = [-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]
"""Quaternion x, y, z, w: glTF's y is up, and viewers turn it to their z; this turns the part's frame the other way."""


def glb(pieces: Sequence[Piece], name: str) -> bytes:
    """Give the file of a part.

    Parameters
    ----------
    pieces
        Its meshes [m], in the part's frame, with their colours.
    name
        Name of its node.
    """
    blocks: list[npt.NDArray[Any]] = []
    accessors: list[dict[str, Any]] = []
    primitives = []
    for number, piece in enumerate(pieces):
        points, normals, faces = smoothed(piece.mesh)
        blocks += [points.astype("<f4"), normals.astype("<f4"), faces.astype("<u4").ravel()]
        accessors += _accessors(blocks, 3 * number)
        attributes = {"POSITION": 3 * number, "NORMAL": 3 * number + 1}
        primitives.append({"attributes": attributes, "indices": 3 * number + 2, "material": number})
    starts = np.cumsum([0, *(block.nbytes for block in blocks)]).tolist()
    described = {
        "asset": {"version": "2.0", "generator": "cycloid_mj"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0, "rotation": _TO_Y_UP}],
        "meshes": [{"name": name, "primitives": primitives}],
        "materials": [_material(piece) for piece in pieces],
        "accessors": accessors,
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": block.nbytes, "target": _target(block)}
            for start, block in zip(starts, blocks, strict=False)
        ],
        "buffers": [{"byteLength": starts[-1]}],
    }
    return _file(json.dumps(described).encode(), b"".join(block.tobytes() for block in blocks))


def _accessors(blocks: list[npt.NDArray[Any]], first: int) -> list[dict[str, Any]]:
    """Describe the points, normals and indices of a piece, which are three blocks from `first` on."""
    points, normals, faces = blocks[first : first + 3]
    bounds = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
    return [
        {"bufferView": first, "componentType": _FLOAT, "count": len(points), "type": "VEC3", **bounds},
        {"bufferView": first + 1, "componentType": _FLOAT, "count": len(normals), "type": "VEC3"},
        {"bufferView": first + 2, "componentType": _UNSIGNED, "count": faces.size, "type": "SCALAR"},
    ]


def _target(block: npt.NDArray[Any]) -> int:
    return _VERTICES if block.dtype.kind == "f" else _INDICES


def _material(piece: Piece) -> dict[str, Any]:
    *colour, opacity = piece.colour
    linear = [((part + 0.055) / 1.055) ** 2.4 if part > 0.04045 else part / 12.92 for part in colour]
    looks = {"baseColorFactor": [*linear, opacity], "metallicFactor": 0.1, "roughnessFactor": 0.6}
    blending = {"alphaMode": "BLEND"} if opacity < 1.0 else {}
    return {"name": piece.name, "pbrMetallicRoughness": looks, **blending}


def _file(description: bytes, data: bytes) -> bytes:
    """Join the two chunks; the text is filled with spaces, as every chunk's length is a multiple of four."""
    description += b" " * (-len(description) % 4)
    chunks = struct.pack("<I4s", len(description), b"JSON") + description
    chunks += struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def smoothed(mesh: Mesh) -> tuple[Array, Array, npt.NDArray[np.intp]]:
    """Give vertices (n, 3) and normals (n, 3), one for each smooth surface that a point is on, and triangles (m, 3).

    The normal at a corner is the mean, weighted by angle, over the faces at that point that differ from the corner's
    own by less than the crease.
    """
    corners = mesh.vertices[mesh.faces]
    edges = np.roll(corners, -1, axis=1) - corners
    edges /= np.linalg.norm(edges, axis=2, keepdims=True)
    face_normals = np.cross(edges[:, 0], edges[:, 1])
    face_normals /= np.linalg.norm(face_normals, axis=1, keepdims=True)
    angles = np.arccos(np.clip(-np.einsum("fik,fik->fi", edges, np.roll(edges, 1, axis=1)), -1.0, 1.0)).ravel()
    normals = _corner_normals(mesh.faces.ravel(), np.repeat(face_normals, 3, axis=0), angles)
    key = np.column_stack([mesh.faces.ravel(), np.rint(1e4 * normals)])
    _, first, index = np.unique(key, axis=0, return_index=True, return_inverse=True)
    return mesh.vertices[mesh.faces.ravel()[first]], normals[first], index.reshape(-1, 3)


def _corner_normals(vertex: npt.NDArray[np.int32], normal: Array, weight: Array) -> Array:
    """Average the faces' normals (k, 3) at each corner over the corners of the same vertex within the crease."""
    order = np.argsort(vertex, kind="stable")
    vertex, normal, weight = vertex[order], normal[order], weight[order]
    last = np.searchsorted(vertex, vertex, side="right")
    total = weight[:, np.newaxis] * normal
    for step in range(1, int((last - np.arange(last.size)).max())):
        one = np.flatnonzero(np.arange(last.size) + step < last)
        other = one + step
        smooth = np.einsum("ik,ik->i", normal[one], normal[other]) >= CREASE
        one, other = one[smooth], other[smooth]
        np.add.at(total, one, weight[other, np.newaxis] * normal[other])
        np.add.at(total, other, weight[one, np.newaxis] * normal[one])
    total /= np.linalg.norm(total, axis=1, keepdims=True)
    back = np.empty_like(total)
    back[order] = total
    return back
