"""Cross-sections as DXF: one spline for each lobe, arcs and circles for the rest, in millimetres."""

import io
import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain
from typing import Any, Protocol

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.extras import import_extra
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts.accuracy import SAME_LENGTH
from cycloid_mj.parts.biarcs import arcs_of
from cycloid_mj.parts.curve import Arc, Circle, Curve, LineSegment, Spline

_FORMAT = "R2000"


@dataclass(frozen=True, eq=False)
class DrilledThread:
    """Tapped holes in a drawing: the thread in words, and centres (n, 2) and radius of the drilled holes [m]."""

    words: str
    centres: Array
    radius: float


class LoopSection(Protocol):
    """A section of a part with closed loops, from `z0` to `z1` [m]."""

    @property
    def name(self) -> str: ...  # noqa: D102

    @property
    def loops(self) -> "Sequence[Loop]": ...  # noqa: D102

    @property
    def z0(self) -> float: ...  # noqa: D102

    @property
    def z1(self) -> float: ...  # noqa: D102


Loop = tuple[Curve, ...] | Array | Circle


def dxf_bytes(
    sections: Sequence[LoopSection], threads: Iterable[DrilledThread] = (), arcs: float | None = None
) -> bytes:
    """Encode the sections of a part as DXF [mm], with the layers of `layers_of`; equal sections give equal bytes.

    Parameters
    ----------
    sections
        Sections of the part.
    threads
        Tapped holes, whose layers have the name of the thread.
    arcs
        Tolerance within which arcs replace splines [m]; None: splines.
    """
    layers = layers_of(sections, tuple(threads))
    return encode_layers(
        (name, chain.from_iterable(_split_loop(loop, arcs) for loop in loops)) for name, loops in layers
    )


def layers_of(sections: Sequence[LoopSection], threads: Sequence[DrilledThread] = ()) -> list[tuple[str, list[Loop]]]:
    """Group the outlines of a part by layer of its DXF; return (name, outlines) of each layer.

    Each outline is drawn once, from its lowest to its highest end along z. Its layer has one of these names:

    - the name of its section, such as ``journal``, if the outline spans all sections with this name,
    - ``z 0.0 to 5.0``, its ends [mm], in a part whose sections all have the same name at several heights,
    - ``journal z 0.0 to 5.0`` for an outline that spans only some of the sections with this name, as in a crank,
    - ``M4 z 0.0 to 5.0`` with the thread, for tapped holes.
    """
    heights: dict[str, set[tuple[float, float]]] = {}
    spans: dict[tuple[str, object], list[tuple[float, float]]] = {}
    loops: dict[object, Loop] = {}
    for section in sections:
        heights.setdefault(section.name, set()).add((section.z0, section.z1))
        for loop in section.loops:
            key = (section.name, _loop_key(loop))
            loops[key] = loop
            spans.setdefault(key, []).append((section.z0, section.z1))
    layers: dict[str, list[Loop]] = {}
    has_segment_names = len(heights) > 1  # segments with names of their own, as those of a crank
    for key, ends in spans.items():
        name, loop = key[0], loops[key]
        thread = next((item.words for item in threads if _is_drilled(loop, item)), "")
        full_spans = _join_intervals(list(heights[name]))
        for z_start, z_end in _join_intervals(ends):
            prefix = thread or (name if has_segment_names else "")
            height_text = f"z {MILLIMETRES * z_start:.1f} to {MILLIMETRES * z_end:.1f}"
            has_full_span = not thread and (
                len(heights[name]) == 1 or (has_segment_names and (z_start, z_end) in full_spans)
            )
            layers.setdefault(name if has_full_span else f"{prefix} {height_text}".strip(), []).append(loop)
    return list(layers.items())


def _join_intervals(ends: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Join intervals (start, end) along z [m] that touch or overlap; return them in ascending order."""
    joined_intervals: list[tuple[float, float]] = []
    for interval_start, interval_end in sorted(ends):
        if joined_intervals and interval_start - joined_intervals[-1][1] < SAME_LENGTH:
            joined_intervals[-1] = joined_intervals[-1][0], interval_end
        else:
            joined_intervals.append((interval_start, interval_end))
    return joined_intervals


def _loop_key(loop: Loop) -> object:
    """Return a hashable value for an outline, `loop`; it is equal for equal outlines."""
    if isinstance(loop, np.ndarray):
        return loop.tobytes()
    curves = (loop,) if isinstance(loop, Circle) else loop
    return tuple(
        (item.knots.tobytes(), item.controls.tobytes()) if isinstance(item, Spline) else item for item in curves
    )


def _is_drilled(loop: Loop, thread: DrilledThread) -> bool:
    circle = loop if isinstance(loop, Circle) else loop[0] if len(loop) == 1 else None
    if not isinstance(circle, Circle) or abs(circle.radius - thread.radius) > SAME_LENGTH:
        return False
    return bool(np.min(np.linalg.norm(thread.centres - np.array(circle.centre), axis=1)) < SAME_LENGTH)


def _split_loop(loop: Loop, arcs: float | None) -> Iterator[Curve | Array]:
    """Yield the curves of a loop, or the loop itself if it is a polygon or a circle."""
    if isinstance(loop, np.ndarray | Circle):
        yield loop
        return
    for curve in loop:
        yield from arcs_of(curve, arcs) if arcs and isinstance(curve, Spline) else (curve,)


def encode_layers(layers: Iterable[tuple[str, Iterable[Curve | Array]]]) -> bytes:
    """Encode curves and closed polygons on named layers as DXF [mm], without time stamps and random numbers.

    `layers` are pairs of the name and the curves of a layer; a polygon has n points (n, 2) [m].

    Raises
    ------
    CycloidError
        The package ezdxf is not installed.
    """
    ezdxf = import_extra("ezdxf", "DXF", "dxf", "export svg, stl, obj or step")
    with fixed_metadata(ezdxf):
        document = ezdxf.new(_FORMAT, setup=False)
        document.units = ezdxf.units.MM
        model_space = document.modelspace()
        for name, shapes in layers:
            if name not in document.layers:
                document.layers.add(name)
            for shape in shapes:
                _add_entity(model_space, shape, {"layer": name})
        stream = io.StringIO()
        document.write(stream)
    return stream.getvalue().encode()


def _add_entity(space: Any, curve: Curve | Array, attributes: dict[str, str]) -> None:
    """Add a curve, or a closed polygon of n points (n, 2) [m], to the model space of a DXF with attributes, in mm."""
    match curve:
        case np.ndarray():
            space.add_lwpolyline((curve * MILLIMETRES).tolist(), close=True, dxfattribs=attributes)
        case Circle():
            space.add_circle(_point_in_mm(curve.centre), curve.radius * MILLIMETRES, dxfattribs=attributes)
        case Arc():
            angles = math.degrees(curve.start), math.degrees(curve.end)
            space.add_arc(_point_in_mm(curve.centre), curve.radius * MILLIMETRES, *angles, dxfattribs=attributes)
        case LineSegment():
            space.add_line(_point_in_mm(curve.start), _point_in_mm(curve.end), dxfattribs=attributes)
        case Spline():
            controls = [_point_in_mm((x, y)) for x, y in curve.controls]
            space.add_open_spline(controls, degree=3, knots=(curve.knots * MILLIMETRES).tolist(), dxfattribs=attributes)


def _point_in_mm(point: tuple[float, float]) -> tuple[float, float]:
    return float(point[0]) * MILLIMETRES, float(point[1]) * MILLIMETRES


@contextmanager
def fixed_metadata(ezdxf: Any) -> Iterator[None]:
    """Keep time stamps and random identifiers out of the files that ezdxf writes inside this context."""
    previous_setting = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = previous_setting
