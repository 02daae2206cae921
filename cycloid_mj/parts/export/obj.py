"""Meshes as Wavefront OBJ: every digit of every vertex, the same mesh always as the same text."""

from cycloid_mj.parts import Mesh


def obj_bytes(shape: Mesh, name: str, scale: float = 1.0) -> bytes:
    """Encode a mesh as OBJ, its vertices [m] times `scale`."""
    vertices = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in (shape.vertices * scale + 0.0).tolist())
    faces = "".join(f"f {a} {b} {c}\n" for a, b, c in (shape.faces + 1).tolist())
    return f"# cycloid_mj\no {name}\n{vertices}{faces}".encode()
