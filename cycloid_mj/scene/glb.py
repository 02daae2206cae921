"""A part as a binary glTF 2.0 file (GLB), with smooth normals where faces meet flatly."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from cycloid_mj.scene.shape import Piece

MEDIA_TYPE = "model/gltf-binary"
CREASE = np.radians(30.0)
"""Angle between two faces up to which they look like one curved surface [rad]."""

TO_Y_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""glTF's y is up, and viewers turn it to their z; this turns the part's frame the other way."""


def glb(pieces: Sequence[Piece]) -> bytes:
    """Encode the file of a part: its meshes [m], in the part's frame, with their colours."""
    from trimesh import Scene

    scene = Scene()
    for piece in pieces:
        scene.add_geometry(smoothed(piece), node_name=piece.name, geom_name=piece.name, transform=TO_Y_UP)
    return bytes(scene.export(file_type="glb", include_normals=True))


def smoothed(piece: Piece) -> Any:
    """Return a piece as a ``trimesh.Trimesh`` with a vertex, and its normal, for each smooth surface a point is on."""
    from trimesh import Trimesh
    from trimesh.graph import smooth_shade
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    mesh = smooth_shade(Trimesh(piece.mesh.vertices, piece.mesh.faces, process=False), angle=CREASE, facet_minarea=None)
    *colour, opacity = piece.colour
    linear = [((part + 0.055) / 1.055) ** 2.4 if part > 0.04045 else part / 12.92 for part in colour]
    looks = {"baseColorFactor": [*linear, opacity], "metallicFactor": 0.1, "roughnessFactor": 0.6}
    material = PBRMaterial(name=piece.name, alphaMode="BLEND" if opacity < 1.0 else None, **looks)
    mesh.visual = TextureVisuals(material=material)
    return mesh
