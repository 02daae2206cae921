"""A plate of all manufactured parts for a printer: side by side, flat on z = 0, as one mesh."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import Mesh, Prism, Solid, mesh
from cycloid_mj.parts.accuracy import RELATIVE_ROUNDING
from cycloid_mj.parts.export.casing import (
    Casing,
)
from cycloid_mj.parts.export.casing_rules import (
    is_printed,
)
from cycloid_mj.parts.export.printing import material_part, printed_parts
from cycloid_mj.parts.export.supports import build_support, find_overhangs
from cycloid_mj.parts.inertia import region_moments
from cycloid_mj.reducer import Reducer

GAP = 5e-3
"""Distance between the bounding boxes of neighbouring parts [m], for a brim (heuristic)."""


@dataclass(frozen=True)
class PlatePosition:
    """Position of a part on the plate.

    Attributes
    ----------
    part
        Its name.
    low, high
        Corners (x, y, z) of its bounding box on the plate [m].
    origin
        Position of the origin of its own frame on the plate (x, y) [m].
    turned_over
        True if it lies on its upper face in that frame, rotated about the x axis.
    """

    part: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    origin: tuple[float, float]
    turned_over: bool


@dataclass(frozen=True)
class PrintPlate:
    """The meshes of all parts on the plate [m], their positions and supports.

    `hanging` has the area of overhanging faces without a possible support [m2], by part and height [m].
    """

    meshes: tuple[Mesh, ...]
    places: tuple[PlatePosition, ...]
    supports: tuple[tuple[Mesh, ...], ...]
    hanging: Mapping[str, Mapping[float, float]]

    @property
    def mesh(self) -> Mesh:
        """Return the surface of all parts on a print plate and of their supports, as one mesh [m]."""
        meshes = [*self.meshes, *(item for supports in self.supports for item in supports)]
        vertex_offsets = np.cumsum([0, *(len(item.vertices) for item in meshes)])
        return Mesh(
            np.concatenate([item.vertices for item in meshes]),
            np.concatenate(
                [item.faces + np.int32(offset) for item, offset in zip(meshes, vertex_offsets, strict=False)]
            ),
        )

    @property
    def size(self) -> tuple[float, float, float]:
        """Length, width and height of the occupied part of the plate [m]."""
        x, y, z = self.mesh.vertices.max(axis=0).tolist()
        return x, y, z

    @property
    def counts(self) -> dict[str, int]:
        """Number of copies by part."""
        parts = [placement.part for placement in self.places]
        return {part: parts.count(part) for part in dict.fromkeys(parts)}


def plate(reducer: Reducer, chord_error: float, cam_seat: float = 0.0, casing: Casing | None = None) -> PrintPlate:
    """Place all printed parts on one plate of any size, as `plates` does."""
    (single,) = plates(reducer, chord_error, cam_seat, casing)
    return single


def plates(
    reducer: Reducer,
    chord_error: float,
    cam_seat: float = 0.0,
    casing: Casing | None = None,
    bed: tuple[float, float] | None = None,
) -> tuple[PrintPlate, ...]:
    """Lay out all printed parts on plates that fit on the bed of a printer, as many plates as necessary.

    Each part lies on its larger end face; plastic parts have supports.

    Parameters
    ----------
    reducer
        The reducer; its clearances are in the outlines.
    chord_error
        Largest distance of a chord from its curve [m].
    cam_seat
        Bore radius of the cam bearing [m], which the cams fit; 0: cams with the outer radius of the bearing.
    casing
        Casing, to include covers and flanges.
    bed
        Length and width of the bed [m]; None: one plate of any size.

    Raises
    ------
    DesignError
        A part cannot be manufactured, its mesh is not watertight, or it is larger than the bed.
    """
    parts_to_print = printed_parts(reducer, chord_error, cam_seat, casing)
    flat_parts = [(name, part.count, *_lay_flat(part.solid)) for name, part in parts_to_print.items()]
    shapes = {name: mesh(solid) for name, _, solid, _ in flat_parts}
    supports, unsupported_areas = _build_supports(
        reducer, {name: solid for name, _, solid, _ in flat_parts}, shapes, chord_error
    )
    copies = [(name, is_turned_over) for name, count, _, is_turned_over in flat_parts for _ in range(count)]
    boxes = [np.stack([shapes[name].vertices.min(axis=0), shapes[name].vertices.max(axis=0)]) for name, _ in copies]
    positions = _pack_plates([name for name, _ in copies], [box[1, :2] - box[0, :2] for box in boxes], bed)
    plate_indices = sorted({plate_index for plate_index, _ in positions})
    return tuple(
        _build_plate(
            [
                (*copy, box, np.array([*corner_position, 0.0]) - box[0])
                for copy, box, (index_of_plate, corner_position) in zip(copies, boxes, positions, strict=True)
                if index_of_plate == plate_index
            ],
            shapes,
            supports,
            unsupported_areas,
        )
        for plate_index in plate_indices
    )


def _build_plate(
    copies: Sequence[tuple[str, bool, Array, Array]],
    shapes: Mapping[str, Mesh],
    supports: Mapping[str, Sequence[Mesh]],
    unsupported_areas: Mapping[str, Mapping[float, float]],
) -> PrintPlate:
    """Return a print plate with copies of parts at their positions, with their supports.

    Parameters
    ----------
    copies
        For each copy the name of its part, whether it is turned over, two corners (2, 3) [m] of its bounding box, and
        its shift (3,) [m].
    shapes, supports
        Mesh, and meshes of the supports, of each part.
    unsupported_areas
        For each part, height [m] -> area [m2] of faces that cannot have a support.
    """
    positions = tuple(
        PlatePosition(
            name, _corner(low + shift), _corner(high + shift), (float(shift[0]), float(shift[1])), is_turned_over
        )
        for name, is_turned_over, (low, high), shift in copies
    )
    meshes = tuple(_translate_mesh(shapes[name], shift) for name, _, _, shift in copies)
    plate_supports = tuple(
        tuple(_translate_mesh(item, shift) for item in supports[name]) for name, _, _, shift in copies
    )
    laid_parts = {name for name, *_ in copies}
    return PrintPlate(
        meshes,
        positions,
        plate_supports,
        {name: faces for name, faces in unsupported_areas.items() if name in laid_parts},
    )


def _translate_mesh(shape: Mesh, shift: Array) -> Mesh:
    return Mesh(shape.vertices + shift, shape.faces)


def _pack_plates(
    parts: Sequence[str], sizes: Sequence[Array], bed: tuple[float, float] | None
) -> list[tuple[int, tuple[float, float]]]:
    """Pack rectangles in rows on print plates; return for each the index of its plate and its lower left corner [m].

    Parameters
    ----------
    parts
        Name of each rectangle, for the error.
    sizes
        Length and width of each [m], shape (2,).
    bed
        Length and width of the plates [m]; None: one plate of any size.

    Raises
    ------
    DesignError
        A rectangle is larger than the bed.
    """
    footprints = [(float(width), float(depth)) for width, depth in sizes]
    if bed is None:
        return [(0, corner_position) for corner_position in pack_rows(footprints, GAP)]
    length, width = bed
    for part, (part_length, part_depth) in zip(parts, footprints, strict=True):
        if part_length > length or part_depth > width:
            size, bed_size = (
                " x ".join(f"{MILLIMETRES * item:.4g}" for item in footprint)
                for footprint in ((part_length, part_depth), bed)
            )
            raise DesignError(
                f"{part} measures {size} mm, but the bed measures only {bed_size} mm: choose a larger bed (--bed), or "
                "manufacture this part by another process"
            )
    corner_positions = [(0, (0.0, 0.0))] * len(footprints)
    plate_index, x, y, row_depth = 0, 0.0, 0.0, 0.0
    for index in sorted(range(len(footprints)), key=lambda index: (-footprints[index][1], -footprints[index][0])):
        part_length, part_depth = footprints[index]
        if x > 0.0 and x + part_length > length:
            x, y, row_depth = 0.0, y + row_depth + GAP, 0.0
        if y > 0.0 and y + part_depth > width:
            plate_index, x, y, row_depth = plate_index + 1, 0.0, 0.0, 0.0
        corner_positions[index] = plate_index, (x, y)
        x, row_depth = x + part_length + GAP, max(row_depth, part_depth)
    return corner_positions


def _build_supports(
    reducer: Reducer, solids: Mapping[str, Solid], shapes: Mapping[str, Mesh], chord_error: float
) -> tuple[dict[str, list[Mesh]], dict[str, dict[float, float]]]:
    """Build supports under the overhanging faces of plastic parts, as the parts lie on the plate.

    Return the meshes of the supports by name of the part; and by name, the areas [m2] of faces that cannot have a
    support, by their height [m]. `solids` and `shapes` are the parts and their meshes by name, `chord_error` [m] is the
    largest distance of a chord from its curve.
    """
    supports: dict[str, list[Mesh]] = {name: [] for name in solids}
    unsupported_areas: dict[str, dict[float, float]] = {}
    for name, solid in solids.items():
        faces = find_overhangs(shapes[name]) if is_printed(reducer, material_part(reducer, name)) else ()
        for face in faces:
            if support := build_support(solid, face, chord_error):
                supports[name].append(support)
            else:
                unsupported_areas.setdefault(name, {})[face.z] = face.area
    return supports, unsupported_areas


def pack_rows(sizes: Sequence[tuple[float, float]], gap: float) -> list[tuple[float, float]]:
    """Pack rectangles (length, depth) [m] in rows, the deepest first (shelf packing); return their lower left corners.

    The `sizes` are in [m]; rows and rectangles are a `gap` [m] apart. The row length minimizes the longer side of the
    plate.
    """
    order = sorted(range(len(sizes)), key=lambda i: (-sizes[i][1], -sizes[i][0]))
    max_width = max(width for width, _ in sizes)
    lengths = np.cumsum([sizes[i][0] + gap for i in order]) - gap
    candidates = [_pack_rows_of_length(sizes, order, max(float(length), max_width), gap) for length in lengths]
    return min(candidates, key=lambda corners: max(_upper_end(corners, sizes, 0), _upper_end(corners, sizes, 1)))


def _pack_rows_of_length(
    sizes: Sequence[tuple[float, float]], order: Sequence[int], max_length: float, gap: float
) -> list[tuple[float, float]]:
    """Pack rectangles in rows of at most `max_length` [m], a `gap` [m] apart; return their lower left corners.

    `sizes` are length and depth [m] of each. They are placed in the `order` of their indices. The result has the corner
    (x, y) [m] of each rectangle, in the order of `sizes`.
    """
    corners = [(0.0, 0.0)] * len(sizes)
    x = y = row_depth = 0.0
    for index in order:
        if x > 0.0 and x + sizes[index][0] > max_length * (1.0 + RELATIVE_ROUNDING):
            x, y, row_depth = 0.0, y + row_depth + gap, 0.0
        corners[index] = (x, y)
        x, row_depth = x + sizes[index][0] + gap, max(row_depth, sizes[index][1])
    return corners


def _upper_end(corners: Sequence[tuple[float, float]], sizes: Sequence[tuple[float, float]], axis: int) -> float:
    return max(corner[axis] + size[axis] for corner, size in zip(corners, sizes, strict=True))


def _lay_flat(solid: Solid) -> tuple[Solid, bool]:
    """Return the part `solid` as it lies on the print bed, on its larger end face, and whether it is turned over."""
    min_z, max_z = min(prism.z0 for prism in solid.prisms), max(prism.z1 for prism in solid.prisms)
    lower_area = sum(region_moments(prism).area for prism in solid.prisms if prism.z0 == min_z)
    upper_area = sum(region_moments(prism).area for prism in solid.prisms if prism.z1 == max_z)
    is_turned_over = upper_area > lower_area
    prisms = tuple(
        Prism(
            _mirror_polygon(prism.outline),
            tuple(_mirror_polygon(hole) for hole in prism.holes),
            max_z - prism.z1,
            max_z - prism.z0,
        )
        if is_turned_over
        else Prism(prism.outline, prism.holes, prism.z0 - min_z, prism.z1 - min_z)
        for prism in solid.prisms
    )
    return Solid(solid.name, prisms, solid.density), is_turned_over


def _mirror_polygon(polygon: Array) -> Array:
    """Return a polygon (n, 2) mirrored in y, counter-clockwise again."""
    return polygon[::-1] * np.array([1.0, -1.0])


def _corner(point: Array) -> tuple[float, float, float]:
    x, y, z = point.tolist()
    return x, y, z
