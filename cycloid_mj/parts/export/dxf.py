"""Cross-sections as DXF: one spline for each lobe, arcs and circles for the rest, in millimetres."""

import io
import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import chain
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.extras import extra
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import PartSection
from cycloid_mj.parts.curve import Arc, Circle, Curve, LineSegment, Spline

_FORMAT = "R2000"


def dxf_bytes(sections: tuple[PartSection, ...]) -> bytes:
    """Encode the sections of a part as DXF, each on a layer of its name, [mm]; equal sections give equal bytes."""
    return encode_layers((section.name, chain.from_iterable(section.loops)) for section in sections)


def encode_layers(layers: Iterable[tuple[str, Iterable[Curve | Array]]]) -> bytes:
    """Encode curves and closed polygons (n, 2) [m] on named layers as DXF [mm], without time stamps and random numbers.

    Raises
    ------
    CycloidError
        The package ezdxf is not installed.
    """
    ezdxf = extra("ezdxf", "DXF", "dxf", "export svg, stl, obj or step")
    with _fixed_metadata(ezdxf):
        document = ezdxf.new(_FORMAT, setup=False)
        document.units = ezdxf.units.MM
        space = document.modelspace()
        for name, shapes in layers:
            if name not in document.layers:
                document.layers.add(name)
            for shape in shapes:
                _add(space, shape, {"layer": name})
        text = io.StringIO()
        document.write(text)
    return text.getvalue().encode()


def _add(space: Any, curve: Curve | Array, attributes: dict[str, str]) -> None:
    """Add a curve or a closed polygon to the drawing."""
    match curve:
        case np.ndarray():
            space.add_lwpolyline((curve * MILLIMETRES).tolist(), close=True, dxfattribs=attributes)
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
