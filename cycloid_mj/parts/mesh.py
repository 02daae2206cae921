"""Triangle meshes of solids by manifold3d: closed surfaces, outward oriented, with the volume of the solid."""

from dataclasses import dataclass
from functools import lru_cache

import manifold3d
import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts.inertia import mass_properties, region_moments
from cycloid_mj.parts.prism import Prism, Solid

Faces = npt.NDArray[np.int32]

VOLUME_TOLERANCE = 1e-9
"""Relative tolerance of areas and volumes: rounding is below, and a wrong triangle above it."""


@dataclass(frozen=True)
class Grids:
    """Grids on which manifold3d works [m], powers of two."""

    unit: float = 2.0**-24  # unit of length, 60 nm; sections round vertices to 1e-8 units
    # grid of vertices in the plane, 1.4e-14 m: protects the areas of slices of 0.1 mm to VOLUME_TOLERANCE
    plane: float = 2.0**-46
    # grid on which faces of stacked prisms are compared, 2^-20 mm: faces that meet are one face
    height: float = 2.0**-30


GRIDS = Grids()


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
    """Triangulate the surface of a `part`, a prism or a solid; prisms that touch or overlap become one body.

    Raises
    ------
    DesignError
        An outline crosses itself or a hole, or the volume of the mesh is not that of the solid.
    """
    solid = part if isinstance(part, Solid) else Solid("prism", (part,), 1.0)
    z_of_level = {round(z / GRIDS.height): z for prism in solid.prisms for z in (prism.z0, prism.z1)}
    pieces = [_extrude(prism, solid.name) for prism in solid.prisms]
    united_mesh = manifold3d.Manifold.batch_boolean(pieces, manifold3d.OpType.Add).to_mesh64()
    vertices = np.array(united_mesh.vert_properties) * GRIDS.unit
    levels = sorted(z_of_level)
    vertices[:, 2] = np.interp(vertices[:, 2] / GRIDS.height, levels, [z_of_level[level] for level in levels])
    shape = Mesh(vertices, np.array(united_mesh.tri_verts, dtype=np.int32))
    volume, expected_volume = _volume(shape), mass_properties(solid).volume
    if not abs(volume / expected_volume - 1.0) <= VOLUME_TOLERANCE:
        raise DesignError(
            f"the mesh of the {solid.name} has a volume of {volume:.9g} m3 instead of {expected_volume:.9g} m3, so it "
            "is not written: please report this design"
        )
    return shape


def _extrude(prism: Prism, name: str) -> manifold3d.Manifold:
    """Extrude the outlines of a prism to a manifold; raise DesignError if they touch or cross.

    Heights are rounded to `GRIDS.height`. `name` is the name of the part, for the error message.
    """
    polygons = [np.round(polygon / GRIDS.plane) for polygon in (prism.outline, *(hole[::-1] for hole in prism.holes))]
    scale = GRIDS.plane / GRIDS.unit
    section = manifold3d.CrossSection([polygon * scale for polygon in polygons])
    new_corners = np.setdiff1d(
        _corners([np.round(polygon / scale) for polygon in section.to_polygons()]), _corners(polygons)
    )
    if new_corners.size:
        x, y = np.array([new_corners[0].real, new_corners[0].imag]) * GRIDS.plane * MILLIMETRES
        raise _contact_error(name, f" near x = {x:.6g} mm, y = {y:.6g} mm")
    area, expected_area = section.area() * GRIDS.unit**2, region_moments(prism).area
    if not abs(area - expected_area) <= VOLUME_TOLERANCE * area:
        raise DesignError(
            f"the mesh of the {name} has a volume of {area * prism.height:.9g} m3 instead of "
            f"{expected_area * prism.height:.9g} m3, because a hole lies outside the outline or inside another hole: "
            "reduce the radii of the holes of this part in the design"
        )
    if section.num_contour() != len(polygons):
        raise _contact_error(name, "")
    lower_level, upper_level = (round(z / GRIDS.height) * GRIDS.height / GRIDS.unit for z in (prism.z0, prism.z1))
    return section.extrude(upper_level - lower_level).translate((0.0, 0.0, lower_level))


def _corners(polygons: list[Array]) -> npt.NDArray[np.complex128]:
    """Return the vertices of polygons (n, 2) as complex numbers."""
    x, y = np.concatenate([np.empty((0, 2)), *polygons]).T
    return x + 1j * y


def _contact_error(name: str, position_text: str) -> DesignError:
    """Return the error of a part whose outlines touch or cross."""
    return DesignError(
        f"two outlines of the {name} touch or cross{position_text}, so the part is not in one piece: change the "
        "dimensions of the holes and teeth that meet there"
    )


def _volume(shape: Mesh) -> float:
    """Compute the volume of a closed surface [m3] by the divergence theorem."""
    a, b, c = shape.vertices[shape.faces].transpose(1, 0, 2)
    return float(np.sum(np.cross(a, b) * c) / 6.0)
