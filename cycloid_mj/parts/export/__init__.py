"""Parts as files for CAD and printing: STL and OBJ meshes, DXF outlines, STEP solids; in millimetres.

Housing, shaft, cams and output are in the frame of the reducer axis, other parts in frames of their own.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.arguments import require_choice, require_number
from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.base.frame import Cell, Frame, make_frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.design import Named, resolve
from cycloid_mj.parts import Mesh, Part, PartSection, Solid, lay_out_parts, mass_properties, mesh, part_sections, parts
from cycloid_mj.parts.accuracy import EXPORT_CHORD_ERROR, SAME_LENGTH, mass_chord_error
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.parts.curve import Arc, Circle, Curve, LineSegment, Spline
from cycloid_mj.parts.export.assembly import assembly_parts, assembly_step, place_parts
from cycloid_mj.parts.export.bearings import shaft_bearing
from cycloid_mj.parts.export.bill import BillLine, bill, bill_csv
from cycloid_mj.parts.export.casing import (
    Casing,
    casing,
    casing_or_none,
)
from cycloid_mj.parts.export.casing_parts import bored_shaft
from cycloid_mj.parts.export.casing_rules import (
    core_radius,
)
from cycloid_mj.parts.export.clearance import OutlineClearance, measure_all, measure_rings
from cycloid_mj.parts.export.dxf import DrilledThread, dxf_bytes
from cycloid_mj.parts.export.edges import broken_edges
from cycloid_mj.parts.export.joints import cross_holes_of, drive_joints
from cycloid_mj.parts.export.motor_mount import Motor
from cycloid_mj.parts.export.motors import MotorFlange, MotorName
from cycloid_mj.parts.export.order import assembly_order
from cycloid_mj.parts.export.plate import PrintPlate, plate, plates
from cycloid_mj.parts.export.polylines import polyline_sections, svg_bytes
from cycloid_mj.parts.export.printing import manufactured_parts, widen_clearances
from cycloid_mj.parts.export.step import SPLINES, PlacedPart, read_volume, step_part
from cycloid_mj.parts.export.threemf import threemf_bytes
from cycloid_mj.parts.export.triangles import obj_bytes, read_stl, stl_bytes
from cycloid_mj.parts.housing import SLIT_SHARE
from cycloid_mj.parts.rv import rv_parts
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.reducer.sockets import require_one_ring, require_open_sockets

__all__ = [
    "CHORD_ERROR",
    "FORMATS",
    "Arc",
    "BillLine",
    "Casing",
    "Circle",
    "Export",
    "Format",
    "LineSegment",
    "Motor",
    "OutlineClearance",
    "PartSection",
    "PlacedPart",
    "PrintPlate",
    "Spline",
    "assembly_order",
    "assembly_step",
    "bill",
    "bill_csv",
    "cam_bearing",
    "casing",
    "casing_or_none",
    "drive_files",
    "dxf_bytes",
    "export",
    "obj_bytes",
    "part_sections",
    "place_parts",
    "plate",
    "plates",
    "read_stl",
    "read_volume",
    "shaft_bearing",
    "step_part",
    "stl_bytes",
    "threemf_bytes",
    "widen_clearances",
]

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import MILLIMETRES

Format = Literal["stl", "obj", "dxf", "svg", "step"]
FORMATS: tuple[Format, ...] = ("stl", "obj", "dxf", "svg", "step")

CHORD_ERROR = EXPORT_CHORD_ERROR

VOLUME_TOLERANCE = 1e-3
"""Relative tolerance of volumes, the accuracy of OpenCASCADE on splines; a lost hole changes far more."""


@dataclass(frozen=True, repr=False)
class Export(Presented):
    """Files by name, and the clearances measured on their contents."""

    files: dict[str, bytes]
    clearances: tuple[OutlineClearance, ...]

    @property
    def frame(self) -> Frame:
        """The files, a row each."""
        rows: list[dict[str, Cell]] = [{"file": name, "bytes": len(content)} for name, content in self.files.items()]
        return make_frame(rows, ("file", "bytes"), {"bytes": "B"})

    @property
    def line(self) -> str:
        """The files with their size."""
        return f"{', '.join(self.files)}; {sum(map(len, self.files.values())) / 1000.0:.4g} kB"


def export(
    design: Named,
    file_format: Format,
    chord_error: float = CHORD_ERROR,
    offset: float = 0.0,
    motor: Motor = "auto",
    *,
    polylines: bool = False,
    cover_material: str = "auto",
    arcs: float | None = None,
) -> Export:
    """Export all parts of a design in a format, one file per part.

    Parameters
    ----------
    design
        A design, or the name of a preset or of a design file; its clearances are in the outlines.
    file_format
        ``stl`` (binary), ``obj``, ``dxf`` (cross-sections: one spline a lobe, arcs, circles; needs the extra ``dxf``),
        ``svg`` (cross-sections as closed paths) or ``step`` (solids; needs the extra ``cad``).
    chord_error
        Largest distance of chords from the curve [m], in meshes and polylines; splines have their own error, 0.01 um.
    offset
        Increase of all clearances of the outlines [m], for a printer; see `widen_clearances`.
    motor
        Motor whose shaft the crank is bored for; ``auto``: the smallest for its torque and speed, or none.
    polylines
        For ``dxf``: closed polylines within the chord error in place of splines, arcs and lines, for programs that
        ignore splines. Full circles stay circles.
    cover_material
        Material of the covers, see ``casing.casing``.
    arcs
        For ``dxf``: tolerance of arcs that replace the splines [m]; None: splines.

    Returns
    -------
    Export
        Content of each file by its name, and the clearances of the exported parts.

    Raises
    ------
    DesignError
        A part cannot be manufactured, is not watertight, or its exported volume or clearance is not that of the design;
        the motor does not fit; or the sockets are closed, or the ring of several discs is in two halves.
    UsageError
        The format or the motor is unknown, or the tolerance of arcs is not positive.
    CycloidError
        The extra for DXF or STEP is not installed.
    """
    design = resolve(design).at_reference
    require_choice("file_format", file_format, FORMATS)
    if not isinstance(motor, MotorFlange):
        require_choice("motor", motor, get_args(MotorName))
    if arcs is not None:
        require_number("arcs", arcs, "m", above=0.0)
    encoding = _Encoding(file_format, chord_error, polylines, arcs)
    reducer = reducer_of(design)
    require_open_sockets(design, "files of its parts")
    if isinstance(reducer, RvReducer):
        return _encode_rv(RvReducer(widen_clearances(reducer, offset).design), encoding)
    if reducer.design.gear.discs > 1:
        require_one_ring(reducer, "files of its parts with several discs")
    casing = casing_or_none(reducer, motor, cover_material)[0]
    exported = _encode_with_halves(widen_clearances(reducer, offset), encoding, casing)
    design_clearance = design.clearance
    clearances = (replace(item, asked=getattr(design_clearance, item.pair)) for item in exported.clearances)
    return Export(exported.files, tuple(clearances))


def drive_files(
    reducer: Reducer,
    file_format: Format,
    casing: Casing,
    chord_error: float = CHORD_ERROR,
    cam_seat: float = 0.0,
    *,
    polylines: bool = False,
    arcs: float | None = None,
) -> dict[str, bytes]:
    """Encode all manufactured parts of an assembled drive, one file per part; return the contents by file name.

    These are the parts of ``printing.manufactured_parts``, including covers and flange.

    Parameters
    ----------
    file_format
        Format of the files.
    casing
        Casing of the drive: covers, bearings, screws and flanges.
    chord_error
        Largest distance of chords from the curve [m], in meshes and polylines.
    cam_seat
        Bore radius of the cam bearing [m], which the cams in meshes fit; 0: cams with the outer radius of the bearing.
        In other formats the cams are those of the assembly.
    polylines, arcs
        Closed polylines in place of splines, and tolerance of arcs that replace the splines [m], as in `export`.

    Raises
    ------
    DesignError
        A part cannot be manufactured.
    CycloidError
        The extra for DXF or STEP is not installed.
    """
    encoding = _Encoding(file_format, chord_error, polylines, arcs)
    parts_by_name = manufactured_parts(reducer, chord_error, cam_seat, casing)
    if encoding.is_mesh:
        return {f"{name}.{file_format}": encoding.mesh(name, mesh(part.solid)) for name, part in parts_by_name.items()}
    assembled_parts = assembly_parts(reducer, casing)
    drawn_parts = {name: assembled_parts[name] for name in parts_by_name}
    if encoding.is_polylines:
        return {
            f"{name}.{file_format}": encoding.polylines_of(part, drilled_threads(reducer, casing, name))
            for name, part in drawn_parts.items()
        }
    if file_format == "dxf":
        return {
            f"{name}.dxf": dxf_bytes(part.sections(1), drilled_threads(reducer, casing, name), encoding.arcs)
            for name, part in drawn_parts.items()
        }
    return {f"{name}.step": _encode_drive_part(reducer, casing, name, part) for name, part in drawn_parts.items()}


def _encode_drive_part(reducer: Reducer, casing: Casing, name: str, part: Part) -> bytes:
    """Encode a part of a drive as a STEP file, with its broken edges and the holes across its axis."""
    edges, bores = broken_edges(reducer, casing, part), cross_holes_of(reducer, casing, name)
    return step_part(name, part.sections(SPLINES), edges=edges, bores=bores)


def drilled_threads(reducer: Reducer, casing: Casing, part: str) -> Iterator[DrilledThread]:
    """Yield the tapped holes of a part with the name of their thread, for the layers of its DXF.

    `part` is the name of the part, `casing` the casing of the drive. Each item has thread, centres [m] and core radius
    [m] of a group of equal holes.
    """
    for joint in drive_joints(reducer, casing):
        for thread in joint.threads:
            radius = core_radius(reducer, thread.thread)
            for centres, drilled, *_ in joint.holes_in(part):
                if thread.part == part and abs(drilled - radius) < SAME_LENGTH:
                    yield DrilledThread(f"M{MILLIMETRES * thread.thread:g}", centres, radius)


@dataclass(frozen=True)
class _Encoding:
    """Encoding of parts: format, chord error [m], whether DXF has polylines or `arcs` [m] instead of splines."""

    file_format: Format
    chord_error: float
    polylines: bool
    arcs: float | None = None

    def __post_init__(self) -> None:
        """Raise UsageError if arcs or polylines do not apply to the file format."""
        if self.arcs is not None and (self.polylines or self.file_format != "dxf"):
            raise UsageError(
                "arcs can be used only with the format dxf, and not together with polylines: choose dxf without "
                "polylines, or omit arcs"
            )
        if self.polylines and self.file_format != "dxf":
            raise UsageError(
                f"polylines can be used only with the format dxf, not with {self.file_format}: choose dxf, or omit "
                "polylines"
            )

    @property
    def is_mesh(self) -> bool:
        return self.file_format in ("stl", "obj")

    @property
    def is_polylines(self) -> bool:
        return self.polylines or self.file_format == "svg"

    def mesh(self, name: str, shape: Mesh) -> bytes:
        """Encode a mesh as STL or OBJ."""
        if self.file_format == "stl":
            return stl_bytes(shape, MILLIMETRES)
        return obj_bytes(shape, name, MILLIMETRES)

    def polylines_of(self, part: Part, threads: Iterable[DrilledThread] = ()) -> bytes:
        """Encode the sections of a part as SVG or DXF of polylines."""
        sections = polyline_sections(part, self.chord_error)
        return svg_bytes(sections) if self.file_format == "svg" else dxf_bytes(sections, threads)


def _encode_with_halves(reducer: Reducer, encoding: _Encoding, casing: Casing | None) -> Export:
    """Encode all parts of a drive as files; a ring in two halves becomes two files, with ring pins as long as a half.

    `casing` None: the mechanism only. `encoding` has the file format and its settings.
    """
    ring, file_format = reducer.design.ring, encoding.file_format
    if ring.halves == 1:
        return _encode_parts(reducer, encoding, casing)
    undivided_reducer = reducer.but(ring={"halves": 1, "preload": 0.0})
    encoded_files = _encode_parts(undivided_reducer, encoding, casing)
    half_width = 0.5 * (1.0 - SLIT_SHARE) * reducer.design.gear.face_width
    half_files = _encode_parts(undivided_reducer.but(gear={"face_width": half_width}), encoding, None).files
    housing_file = f"{names.HOUSING}.{file_format}"
    files: dict[str, bytes] = {}
    for name, content in encoded_files.files.items():
        if name == housing_file:
            files |= {
                f"{names.numbered_name(names.HOUSING, number)}.{file_format}": half_files[name] for number in (1, 2)
            }
        else:
            files[name] = half_files[name] if name.startswith((names.PIN, names.PRESSED_PIN)) else content
    return Export(files, encoded_files.clearances)


def _encode_parts(reducer: Reducer, encoding: _Encoding, casing: Casing | None) -> Export:
    """Encode all parts of a drive in the file format of `encoding`, and measure the clearances of their exact outlines.

    The motor of the `casing` decides on the bore of the crank; None: no bore.
    """
    file_format = encoding.file_format
    if encoding.is_mesh or encoding.is_polylines:
        return _encode_polygons(reducer, encoding, casing)
    shaft = bored_shaft(reducer, casing)
    splines = SPLINES if file_format == "step" else 1
    sections = part_sections(reducer, splines) | {names.SHAFT: shaft.sections(splines)}
    discs = [[_loop_points(loop) for loop in sections[gear][0].loops] for gear in reducer.gears]
    clearances = measure_all(reducer, discs, _loop_points(sections["housing"][0].loops[1]))
    if file_format == "dxf":
        return Export(
            {f"{name}.dxf": dxf_bytes(segments, (), encoding.arcs) for name, segments in sections.items()}, clearances
        )
    solids = parts(reducer) | {names.SHAFT: shaft.solid(mass_chord_error(reducer))}
    return Export(
        {f"{name}.step": _encode_step(reducer, solids[name], sections[name]) for name in sections}, clearances
    )


def _encode_polygons(reducer: Reducer, encoding: _Encoding, casing: Casing | None) -> Export:
    """Encode all parts of a drive as meshes or polylines, and measure the clearances between the polygons.

    The motor of the `casing` decides on the bore of the crank; None: no bore. `encoding` has the file format and its
    settings.
    """
    chord_error = encoding.chord_error
    shaft = bored_shaft(reducer, casing, chord_error)
    solids = parts(reducer, chord_error) | {names.SHAFT: shaft.solid(chord_error)}
    discs = [solids[gear].prisms[0] for gear in reducer.gears]
    loops = [[disc.outline, *disc.holes] for disc in discs]
    clearances = measure_all(reducer, loops, solids["housing"].prisms[0].holes[0])
    if encoding.is_polylines:
        drawn_parts = lay_out_parts(reducer, chord_error) | {names.SHAFT: shaft}
        contents = {name: encoding.polylines_of(part) for name, part in drawn_parts.items()}
    else:
        contents = {
            name: encoding.mesh(name, mesh(solid)) for name, solid in _separate_pressed_pins(reducer, solids).items()
        }
    return Export({f"{name}.{encoding.file_format}": content for name, content in contents.items()}, clearances)


def _separate_pressed_pins(reducer: Reducer, solids: dict[str, Solid]) -> dict[str, Solid]:
    """Return the solids by name, with one pressed-in pin of a sleeved ring as an extra solid `PRESSED_PIN`."""
    if not reducer.design.ring.has_sleeves:
        return solids
    housing = solids[names.HOUSING]
    wheel, core, *_ = (Solid(housing.name, (prism,), housing.density) for prism in housing.prisms)
    return {**solids, names.HOUSING: wheel, names.PRESSED_PIN: replace(core, name=names.PRESSED_PIN)}


def _encode_rv(reducer: RvReducer, encoding: _Encoding) -> Export:
    """Encode all parts of an RV reducer as files; measure the clearances of the discs in the ring.

    `encoding` has the file format and its settings.
    """
    parts_by_name = rv_parts(reducer)
    chord_error = encoding.chord_error

    def encode(name: str, part: Part) -> bytes:
        """Return the content of the file of the part `name` in the format of `encoding`."""
        if encoding.is_mesh:
            return encoding.mesh(name, mesh(part.solid(chord_error)))
        if encoding.is_polylines:
            return encoding.polylines_of(part)
        if encoding.file_format == "dxf":
            return dxf_bytes(part.sections(1), (), encoding.arcs)
        return _encode_step(reducer, part.solid(EXPORT_CHORD_ERROR), part.sections(SPLINES))

    discs = [parts_by_name[disc].solid(chord_error).prisms[0].outline for disc in reducer.gears]
    ring_outline = parts_by_name[names.HOUSING].solid(chord_error).prisms[0].holes[0]
    files = {f"{name}.{encoding.file_format}": encode(name, part) for name, part in parts_by_name.items()}
    return Export(files, measure_rings(reducer, discs, ring_outline))


def _encode_step(reducer: Reducer, solid: Solid, segments: tuple[PartSection, ...]) -> bytes:
    """Encode a part as STEP; raise DesignError if the volume of the solid read back is not that of the part.

    `segments` are its sections, `solid` the same part as prisms.
    """
    pins = reducer.design.ring.teeth if solid.name == names.HOUSING and reducer.design.ring.has_sleeves else 0
    content = step_part(solid.name, segments, 1 + pins)
    volume, expected_volume = read_volume(content), mass_properties(solid).volume
    if not abs(volume / expected_volume - 1.0) <= VOLUME_TOLERANCE:
        raise DesignError(
            f"the STEP solid of the {solid.name} has a volume of {volume:.6g} m3 instead of {expected_volume:.6g} m3, "
            "so it is not written: export STL (--format stl) instead, and please report this design"
        )
    return content


def _loop_points(loop: tuple[Curve, ...]) -> Array:
    return np.concatenate([_curve_points(curve) for curve in loop])


def _curve_points(curve: Curve, count: int = 200) -> Array:
    """Compute points along a curve, (count, 2) [m]; of a line only the two ends."""
    match curve:
        case Spline():
            return curve.points(count)
        case LineSegment():
            return np.array([curve.start, curve.end])
        case _:
            start, end = (curve.start, curve.end) if isinstance(curve, Arc) else (0.0, 2.0 * np.pi)
            angles = np.linspace(start, end, count)
            return np.array(curve.centre) + curve.radius * np.column_stack([np.cos(angles), np.sin(angles)])
