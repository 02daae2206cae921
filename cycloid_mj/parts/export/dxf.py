"""Cross-sections as DXF: one spline for each lobe, arcs and circles for the rest, in millimetres."""

import io
import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from cycloid_mj.base.extras import extra
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import PartSection
from cycloid_mj.parts.curve import Arc, Circle, Curve, LineSegment, Spline

_FORMAT = "R2000"


def dxf_bytes(sections: tuple[PartSection, ...]) -> bytes:
    """Encode the sections of a part as DXF, each on a layer of its name, [mm]; equal sections give equal bytes."""
    with dxf_document() as document:
        space = document.modelspace()
        for section in sections:
            if section.name not in document.layers:
                document.layers.add(section.name)
            for loop in section.loops:
                for curve in loop:
                    _add(space, curve, {"layer": section.name})
        text = io.StringIO()
        document.write(text)
    return text.getvalue().encode()


@contextmanager
def dxf_document() -> Iterator[Any]:
    """Yield a new document of ezdxf in millimetres, without time stamps and random identifiers.

    Raises
    ------
    CycloidError
        The package ezdxf is not installed.
    """
    ezdxf = extra("ezdxf", "DXF", "dxf", "export svg, stl, obj or step")
    with _fixed_metadata(ezdxf):
        document = ezdxf.new(_FORMAT, setup=False)
        document.units = ezdxf.units.MM
        yield document


def _add(space: Any, curve: Curve, attributes: dict[str, str]) -> None:
    """Add a curve to the drawing."""
    match curve:
        case Circle():
            space.add_circle(_point(curve.centre), curve.radius * MILLIMETRES, dxfattribs=attributes)
        case Arc():
            angles = math.degrees(curve.start), math.degrees(curve.end)
            space.add_arc(_point(curve.centre), curve.radius * MILLIMETRES, *angles, dxfattribs=attributes)
        case LineSegment():
            space.add_line(_point(curve.start), _point(curve.end), dxfattribs=attributes)
        case Spline():
            controls = [_point((x, y)) for x, y in curve.controls]
            space.add_open_spline(controls, degree=3, knots=(curve.knots * MILLIMETRES).tolist(), dxfattribs=attributes)


def _point(point: tuple[float, float]) -> tuple[float, float]:
    return float(point[0]) * MILLIMETRES, float(point[1]) * MILLIMETRES


@contextmanager
def _fixed_metadata(ezdxf: Any) -> Iterator[None]:
    """Keep time stamps and random identifiers out of the file."""
    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before
