"""A part as a binary glTF 2.0 file (GLB), with smooth normals where faces meet flatly."""

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

from cycloid_mj.scene.shading import shade
from cycloid_mj.scene.shape import Piece

MEDIA_TYPE = "model/gltf-binary"

TO_Y_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""glTF's y is up, and viewers turn it to their z; this turns the part's frame the other way."""

METALLIC, ROUGHNESS = 0.1, 0.6
"""Factors of the material: dull, so that no part mirrors the light."""

_FLOAT, _UNSIGNED, _VERTICES, _INDICES, _TRIANGLES = 5126, 5125, 34962, 34963, 4
"""Types of components, targets of buffer views, and mode of a primitive, by glTF 2.0, 3.6 and 3.7."""


def encode_glb(pieces: Sequence[Piece]) -> bytes:
    """Encode the file of a part: its meshes [m], in the part's frame, with their colours."""
    file = _File()
    for piece in pieces:
        mesh = shade(piece.mesh)
        file.add(piece, mesh.vertices.astype("<f4"), mesh.normals.astype("<f4"), mesh.faces.astype("<u4"))
    return file.encode()


class _File:
    """The description and the buffer of a glTF file, piece after piece."""

    def __init__(self) -> None:
        self._buffer = b""
        self._sections: dict[str, list[Any]] = {
            key: [] for key in ("nodes", "meshes", "materials", "accessors", "bufferViews")
        }

    def add(self, piece: Piece, points: Any, normals: Any, faces: Any) -> None:
        """Add the mesh of a `piece`, with its name and colour, to a glTF file.

        `points` [m] and `normals` have the shape (n, 3), as 32-bit floats; `faces` (m, 3), 32-bit integers, are the
        indices of the corners of m triangles.
        """
        attributes = {"POSITION": self._append_array(points, "VEC3"), "NORMAL": self._append_array(normals, "VEC3")}
        indices = self._append_array(faces.ravel(), "SCALAR")
        piece_index = len(self._sections["meshes"])
        primitive = {"attributes": attributes, "indices": indices, "material": piece_index, "mode": _TRIANGLES}
        self._sections["meshes"].append({"name": piece.name, "primitives": [primitive]})
        self._sections["materials"].append(_material(piece))
        self._sections["nodes"].append({"name": piece.name, "mesh": piece_index, "matrix": TO_Y_UP.T.ravel().tolist()})

    def encode(self) -> bytes:
        """Return a glTF file as bytes: header, JSON chunk with the description, binary chunk with the buffer."""
        description = {
            "asset": {"version": "2.0", "generator": "cycloid_mj"},
            "scene": 0,
            "scenes": [{"nodes": list(range(len(self._sections["nodes"])))}],
            **self._sections,
            "buffers": [{"byteLength": len(self._buffer)}],
        }
        description_bytes = json.dumps(description, separators=(",", ":")).encode()
        description_bytes += b" " * (-len(description_bytes) % 4)
        chunks = struct.pack("<I4s", len(description_bytes), b"JSON") + description_bytes
        chunks += struct.pack("<I4s", len(self._buffer), b"BIN\x00") + self._buffer
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def _append_array(self, values: Any, kind: str) -> int:
        """Append `values` to the buffer of a glTF file, with the buffer view and the accessor that glTF requires.

        `kind` is the type of an element: "SCALAR" for indices, "VEC3" for points and normals. Return the accessor's
        index.
        """
        is_index = kind == "SCALAR"
        buffer_view = {"buffer": 0, "byteOffset": len(self._buffer), "byteLength": values.nbytes}
        self._sections["bufferViews"].append(buffer_view | {"target": _INDICES if is_index else _VERTICES})
        self._buffer += values.tobytes()
        flat_values = values.reshape(len(values), -1)
        self._sections["accessors"].append(
            {
                "bufferView": len(self._sections["bufferViews"]) - 1,
                "componentType": _UNSIGNED if is_index else _FLOAT,
                "count": len(values),
                "type": kind,
                "min": flat_values.min(axis=0).tolist(),
                "max": flat_values.max(axis=0).tolist(),
            }
        )
        return len(self._sections["accessors"]) - 1


def _material(piece: Piece) -> dict[str, Any]:
    """Describe the material of a piece; glTF's colours are linear, those of a piece sRGB (IEC 61966-2-1)."""
    *colour, opacity = piece.colour
    linear_colour = [
        ((component + 0.055) / 1.055) ** 2.4 if component > 0.04045 else component / 12.92 for component in colour
    ]
    factors = {"baseColorFactor": [*linear_colour, opacity], "metallicFactor": METALLIC, "roughnessFactor": ROUGHNESS}
    return {"name": piece.name, "pbrMetallicRoughness": factors} | ({"alphaMode": "BLEND"} if opacity < 1.0 else {})
