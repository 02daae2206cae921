"""Cross-sections of parts as closed polylines and circles: DXF without splines, and SVG, in millimetres.

Several programs drop the entity SPLINE of a DXF file without a message. A polyline follows the outline within a chord
error; a full circle stays a circle.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import Part
from cycloid_mj.parts.contour import Contour, circle_of
from cycloid_mj.parts.curve import Circle

STROKE_MM, MARGIN_MM = 0.1, 1.0
"""Width of the lines, and the margin around a part, in an SVG file [mm]; both change no coordinate."""


@dataclass(frozen=True, eq=False)
class PolylineSection:
    """A section of a part: its name, and closed loops, the first its outline, the others its holes.

    A loop is a polygon, shape (n, 2) [m], or a full circle. The section is from `z0` to `z1` [m].
    """

    name: str
    loops: tuple[Array | Circle, ...]
    z0: float
    z1: float


def polyline_sections(part: Part, chord_error: float) -> tuple[PolylineSection, ...]:
    """Return the sections of a part as polygons and circles, with chord errors of at most `chord_error` [m]."""
    return tuple(
        PolylineSection(
            segment.name,
            tuple(_loop(contour, chord_error) for contour in (segment.outline, *segment.holes)),
            segment.z0,
            segment.z1,
        )
        for segment in part.segments
    )


def svg_bytes(sections: tuple[PolylineSection, ...]) -> bytes:
    """Encode the sections of a part as SVG: one path each, holes cut out by the even-odd rule; the unit is 1 mm.

    The y axis of SVG points downwards, so y is negated and the picture is not mirrored.
    """
    (min_x, min_y), (max_x, max_y) = (np.array(_extent(sections)) * MILLIMETRES).tolist()
    x, y = min_x - MARGIN_MM, -max_y - MARGIN_MM
    width, height = max_x - min_x + 2.0 * MARGIN_MM, max_y - min_y + 2.0 * MARGIN_MM
    paths = [
        f'<path id="{section.name}_{number}" d="{" ".join(map(_path_data, section.loops))}"/>'
        for number, section in enumerate(sections, start=1)
    ]
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.6f}mm" height="{height:.6f}mm" '
            f'viewBox="{x:.6f} {y:.6f} {width:.6f} {height:.6f}">',
            f'<g fill="none" fill-rule="evenodd" stroke="black" stroke-width="{STROKE_MM:g}">',
            *paths,
            "</g>",
            "</svg>",
            "",
        ]
    ).encode()


def _loop(contour: Contour, chord_error: float) -> Array | Circle:
    return circle_of(contour) or contour.polygon(chord_error)


def _extent(sections: tuple[PolylineSection, ...]) -> tuple[Array, Array]:
    """Return the smallest and the largest coordinates (x, y) of sections [m]."""
    corners = np.concatenate([np.vstack(list(_corners(loop))) for section in sections for loop in section.loops])
    return corners.min(axis=0), corners.max(axis=0)


def _corners(loop: Array | Circle) -> Iterator[Array]:
    if isinstance(loop, Circle):
        yield np.array(loop.centre) - loop.radius
        yield np.array(loop.centre) + loop.radius
    else:
        yield loop.min(axis=0)
        yield loop.max(axis=0)


def _path_data(loop: Array | Circle) -> str:
    """Format a closed loop as path data [mm]: a polygon, or a circle as two half circles."""
    if isinstance(loop, Circle):
        (x, y), radius = (MILLIMETRES * coordinate for coordinate in loop.centre), loop.radius * MILLIMETRES
        half_arc = f"A{radius:.6f} {radius:.6f} 0 0 0"
        return f"M{x + radius:.6f} {-y:.6f} {half_arc} {x - radius:.6f} {-y:.6f} {half_arc} {x + radius:.6f} {-y:.6f} Z"
    return "M" + " ".join(f"{x:.6f} {-y:.6f}" for x, y in (loop * MILLIMETRES).tolist()) + " Z"
