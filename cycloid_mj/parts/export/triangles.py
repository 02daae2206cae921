"""Meshes as binary STL and Wavefront OBJ; the bytes of equal meshes are equal."""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.parts import Mesh

HEADER = b"binary STL by cycloid_mj".ljust(80)
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def stl_bytes(shape: Mesh, scale: float = 1.0) -> bytes:
    """Encode a mesh as binary STL, its vertices [m] times `scale`, in the single precision of the format."""
    corners = shape.vertices[shape.faces] * scale
    triangles = np.zeros(len(corners), _TRIANGLE)
    triangles["normal"] = _normals(corners)
    triangles["corners"] = corners
    return HEADER + np.uint32(len(triangles)).tobytes() + triangles.tobytes()


def read_stl(content: bytes, path: str = "the file") -> Array:
    """Read the corners of the m triangles of a binary STL file, shape (m, 3, 3), in the unit of the file.

    Parameters
    ----------
    content
        Content of the file.
    path
        Name of the file for the error.

    Raises
    ------
    DesignError
        The content is not a binary STL.
    """
    count = int.from_bytes(content[80:84], "little")
    if len(content) != 84 + count * _TRIANGLE.itemsize:
        raise DesignError(
            f"{path} is not a valid binary STL file: it has {len(content)} bytes, but its {count} triangles need "
            f"{84 + count * _TRIANGLE.itemsize}. Export it again with `cycloid-mj export --format stl`"
        )
    return np.frombuffer(content, _TRIANGLE, offset=84)["corners"].astype(np.float64)


def _normals(corners: Array) -> Array:
    """Compute the unit normals (m, 3) of triangles; zero where a triangle has no area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)


def obj_bytes(shape: Mesh, name: str, scale: float = 1.0) -> bytes:
    """Encode a mesh as OBJ with full precision, its vertices [m] times `scale`."""
    vertices = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in (shape.vertices * scale + 0.0).tolist())
    faces = "".join(f"f {a} {b} {c}\n" for a, b, c in (shape.faces + 1).tolist())
    return f"# cycloid_mj\no {name}\n{vertices}{faces}".encode()
