"""Content of the drawings of manufactured parts: views, dimensions with tolerances, roughness, hardness and datums.

Symbols follow ISO GPS: sizes with zones of ISO 286 and their deviations, datum A the axis of the finest seat, datum B
the face at the lower end; general tolerances of ISO 22081 and ISO 2768-m. Eccentricities, and sizes and positions of
output holes, have the limits of the tolerance study.
"""

import io
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.extras import import_extra
from cycloid_mj.base.units import MICROMETRES, MILLIMETRES, in_mm
from cycloid_mj.design import Design, Material, fits
from cycloid_mj.design.zone import parse_zone
from cycloid_mj.parts import Part
from cycloid_mj.parts.accuracy import SAME_LENGTH, VISUAL_CHORD_ERROR
from cycloid_mj.parts.cam_bearing import cam_radius
from cycloid_mj.parts.contour import circle_of
from cycloid_mj.parts.cut import cut_prism
from cycloid_mj.parts.export.assembly import assembly_parts
from cycloid_mj.parts.export.bearings import roller_bore
from cycloid_mj.parts.export.cam_notes import describe_cam_joint
from cycloid_mj.parts.export.casing import (
    Casing,
)
from cycloid_mj.parts.export.casing_rules import (
    is_printed,
)
from cycloid_mj.parts.export.dxf import fixed_metadata
from cycloid_mj.parts.export.edges import broken_edges
from cycloid_mj.parts.export.joint import Joint, JointKind
from cycloid_mj.parts.export.joints import drive_joints
from cycloid_mj.parts.export.printing import manufactured_parts, material_part, part_material
from cycloid_mj.parts.export.step import BrokenEdge
from cycloid_mj.parts.shaft import COUNTERWEIGHT
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import wall_radius

ROUGHNESS = {"seat": "Ra 0.8", "raceway": "Ra 0.2", "teeth": "Ra 0.4", "other": "Ra 3.2"}
"""Roughness by kind of surface [um]: seats of bearings and pins (SKF, Rolling bearings, 2018, IT6 and IT7), raceways of
needles, ground teeth, and all others."""

HARDNESS = (
    ("bearing steel", "60 to 64 HRC"),
    ("case-hardened", "case-hardened, 58 to 62 HRC, depth 0.8 to 1.0 mm"),
    ("nitrided", "nitrided, 600 HV minimum, depth 0.3 mm"),
    ("tempered", "quenched and tempered, 280 to 320 HB"),
)
"""Heat treatment by the name of the material."""

EDGES = "edges without indication: chamfer 0.2 to 0.5 mm; inside corners: radius 0.3 mm at most (ISO 13715)"
GENERAL = "general tolerances ISO 2768-m, geometry ISO 22081: profile 0.1 mm to A and B; sizes ISO 8015"
PRINTED = "printed: general tolerance 0.2 mm in place of ISO 2768; ream seats after printing"
SOFT_THREADS = "protect threads from carburizing"

ECCENTRICITY_TOLERANCE = 5e-6
"""Half of the tolerance of an eccentricity [m] without a tolerance study (assumed)."""

SPACERS, SPACER_ZONES = (names.SPACER, names.BEARING_SPACER, names.CRANK_RING), ("F8", "f7")
"""Rings on the crank and in the motor cover, and the zones of bore and outside that slide on their seats (usual)."""

_ZONE = re.compile(r"\b([A-Z]{1,2}|[a-z]{1,2})(\d{1,2})\b")


@dataclass(frozen=True)
class Dimension:
    """A dimension of a section: its text, its ends along z [m], and for a diameter its radius [m], else 0."""

    text: str
    low: float
    high: float
    radius: float = 0.0


@dataclass(frozen=True, eq=False)
class PartDrawing:
    """The drawing of a part.

    Attributes
    ----------
    name, title
        Its name, and what the title block says, line by line.
    section
        Rectangles of the section through the axis: ends along z and along y [m].
    front
        Closed polygons of the view along the axis, each once [m].
    diameters, lengths
        Dimensions of the section.
    notes
        Threads, holes, geometric tolerances, roughness and general tolerances.
    """

    name: str
    title: tuple[str, ...]
    section: tuple[tuple[float, float, float, float], ...]
    front: tuple[Array, ...]
    diameters: tuple[Dimension, ...]
    lengths: tuple[Dimension, ...]
    notes: tuple[str, ...]


def part_drawings(reducer: Reducer, casing: Casing) -> tuple[PartDrawing, ...]:
    """Return the drawings of all manufactured parts of a drive.

    Raises
    ------
    DesignError
        A part cannot be manufactured.
    """
    parts, joints = assembly_parts(reducer, casing), drive_joints(reducer, casing)
    parts_by_name = manufactured_parts(reducer, VISUAL_CHORD_ERROR, 0.0, casing)
    counts = {name: part.count for name, part in parts_by_name.items()}
    if reducer.design.output.has_roller_parts:
        counts[names.ROLLER] = reducer.design.output.pins * reducer.design.gear.discs
    return tuple(_draw_part(reducer, casing, parts[name], name, count, joints) for name, count in counts.items())


def _draw_part(
    reducer: Reducer, casing: Casing, part: Part, name: str, count: int, joints: Sequence[Joint]
) -> PartDrawing:
    """Return the drawing of a part: section, front view, dimensions, notes and title block.

    Parameters
    ----------
    reducer, casing
        The reducer and its casing.
    part, name
        The part and its name.
    count
        Number of copies of the part in a drive.
    joints
        All joints of the drive, for fits and threads.
    """
    material, is_printed_part = part_material(reducer, name, casing), is_printed(reducer, material_part(reducer, name))
    diameters = section_diameters(
        part,
        names.CAM,
        lambda radius, inner: _tolerance_zone(reducer, casing, name, joints, radius, inner=inner),
        _eccentricity_tolerance(reducer.design),
    )
    notes = (
        *_describe_holes(name, joints),
        *describe_cam_joint(reducer, casing, name),
        *_describe_counterweight(reducer, part),
        *_describe_tolerances(reducer, name, diameters, joints),
        *(() if is_printed_part else _describe_widths(casing, part)),
        *_describe_broken_edges(broken_edges(reducer, casing, part)),
        *([SOFT_THREADS] if "case-hardened" in material.name and _has_threads(name, joints) else ()),
        *describe_surface(name, material, is_printed_part),
    )
    return lay_out_drawing(part, name, title_block(reducer, name, count, material), diameters, notes)


def title_block(reducer: Reducer, name: str, count: int, material: Material) -> tuple[str, ...]:
    """Return the lines of the title block: design and part, number of copies with the material, and heat treatment."""
    count_line = f"{count} off, {material.name or 'own material'}"
    treatment = next((text for key, text in HARDNESS if key in material.name), "no heat treatment")
    return f"{reducer.design.name}: {name}", count_line, treatment


def lay_out_drawing(
    part: Part, name: str, title: tuple[str, ...], diameters: tuple[Dimension, ...], notes: tuple[str, ...]
) -> PartDrawing:
    """Return the drawing of a part with its section, its front view, and its lengths from the lower face.

    `name` is the name of the part, `title` are the lines of the title block, `diameters` the dimensions of
    `section_diameters`, and `notes` the lines of text.
    """
    prisms = part.solid(VISUAL_CHORD_ERROR).prisms
    front = {polygon.tobytes(): polygon for prism in prisms for polygon in (prism.outline, *prism.holes)}
    section = tuple((prism.z0, prism.z1, y_start, y_end) for prism in prisms for y_start, y_end in cut_prism(prism))
    faces = sorted({round(face, 9) for prism in prisms for face in (prism.z0, prism.z1)})
    lengths = tuple(Dimension(in_mm(face - faces[0]), faces[0], face) for face in faces[1:])
    return PartDrawing(name, title, section, tuple(front.values()), diameters, lengths, notes)


def section_diameters(
    part: Part, eccentric: str, zone_of: Callable[[float, bool], tuple[str, float]], eccentricity_tolerance: float
) -> tuple[Dimension, ...]:
    """Return each diameter of a part about its axis or about an eccentric, with its ends along z and tolerance zone.

    Parameters
    ----------
    part
        The part.
    eccentric
        Word in the names of segments that are cylinders about an eccentric axis.
    zone_of
        Function of a radius [m] and a flag that is true for a bore. It returns the tolerance zone, such as ``H7``, or
        an empty string if the diameter has none, and the nominal diameter [m] of the zone.
    eccentricity_tolerance
        Half of the tolerance of an eccentricity [m].
    """
    spans: dict[tuple[float, bool, tuple[float, float]], list[float]] = {}
    for segment in part.segments:
        for contour, inner in ((segment.outline, False), *((hole, True) for hole in segment.holes)):
            circle = circle_of(contour)
            centre = (0.0, 0.0) if circle is None else circle.centre
            if circle and (np.hypot(*centre) <= SAME_LENGTH or (not inner and eccentric in segment.name)):
                key = round(circle.radius, 9), inner, centre
                spans.setdefault(key, []).extend((segment.z0, segment.z1))
    dimensions = []
    for (radius, inner, centre), ends in spans.items():
        eccentricity, (zone, size) = float(np.hypot(*centre)), zone_of(radius, inner)
        limits = f" ({_format_deviations(zone, size)})" if zone.rstrip("0123456789").lower() in fits.LETTERS else ""
        text = f"⌀{in_mm(size)}" + (f" {zone}{limits}" if zone else "")
        if eccentricity > SAME_LENGTH:
            half_width = f"{MILLIMETRES * eccentricity_tolerance:.2g}"
            text += f", eccentric by {MILLIMETRES * eccentricity:.4f} ± {half_width}"
        dimensions.append(Dimension(text, min(ends), max(ends), radius))
    return tuple(dimensions)


def _tolerance_zone(
    reducer: Reducer, casing: Casing, name: str, joints: Sequence[Joint], radius: float, *, inner: bool
) -> tuple[str, float]:
    """Return the tolerance zone of a surface, such as ``H7``, and its nominal diameter [m].

    The zone is that of the joint that the surface belongs to, or a tolerance such as ``± 0.001`` [mm] of the diameter
    of a roller; empty without a joint. The surface belongs to the part `name`, has a `radius` [m] and is a bore if
    `inner`.
    """
    diameter, is_on_crank = 2.0 * radius, name == names.SHAFT or names.family(name) == names.CAM
    if not inner and is_on_crank and abs(radius - cam_radius(reducer)) < SAME_LENGTH:
        return "h5", diameter
    if names.family(name) == names.ROLLER and not inner:
        return f"± {_size_tolerance(reducer.design)}", diameter
    seat_radius = reducer.design.shaft.radius if inner else casing.seat
    if names.family(name) in SPACERS and abs(radius - seat_radius) < SAME_LENGTH:
        return SPACER_ZONES[0 if inner else 1], diameter
    for joint in joints:
        for size in _joint_sizes(reducer, joint, name, inner):
            if name in joint.parts and abs(0.5 * size - radius) < SAME_LENGTH:
                for letters, grade in _ZONE.findall(joint.fit):
                    if letters.isupper() == inner:
                        return f"{letters}{grade}", joint.diameter if names.family(name) == names.ROLLER else size
    return "", diameter


def _joint_sizes(reducer: Reducer, joint: Joint, name: str, inner: bool) -> Iterator[float]:
    """Yield the diameters [m] that a surface of the part `name` may have at a joint.

    They are those of the joint, the outside diameters of its bought parts, and, if the surface is a bore (`inner`), its
    diameters as drawn.
    """
    if joint.diameter:
        yield joint.diameter
        if names.family(name) == names.ROLLER and inner:
            yield 2.0 * roller_bore(reducer)
    for part in joint.bought:
        yield from (size for dimension, size in part.dimensions if "outside" in dimension)
    if inner and name in joint.parts and names.CAM_BEARING in joint.parts:
        yield 2.0 * (reducer.design.gear.bore_radius + reducer.design.clearance.cam)
    if joint.kind is JointKind.LOCATED and inner:
        yield from (2.0 * hole_radius for _, hole_radius, *_ in joint.holes_in(name))


def _format_deviations(zone: str, size: float) -> str:
    """Format the deviations of a zone [um]."""
    lower, upper = (round(MICROMETRES * deviation) for deviation in fits.limits(zone, size))
    return f"{upper:+d}/{lower:+d} µm"


def _describe_holes(name: str, joints: Sequence[Joint]) -> Iterator[str]:
    """Yield a note for the drawing for each group of holes of a part off its axis, from the joints that need them.

    `name` is the name of the part, `joints` are all joints of the drive. A note has number, diameter or thread, depth,
    circle and first angle.
    """
    for joint in joints:
        threads = [item.thread for item in joint.threads if item.part == name]
        for centres, radius, z_start, z_end in joint.holes_in(name):
            radii = np.hypot(*centres.T)
            if radii.max() <= SAME_LENGTH:
                continue
            circle, angle = 2.0 * float(radii.mean()), first_angle(centres)
            zone = f" {joint.fit}" if joint.kind in (JointKind.DOWELLED, JointKind.PRESSED) else ""
            thread = next((f"M{in_mm(item)} in it, " for item in threads if radius < 0.75 * item), "")
            position_text = (
                f"on ⌀{in_mm(circle)}, the first at {angle:.4g}°, position ⌀{'0.05' if zone else '0.2'} to A and B"
            )
            size = f"{len(centres)} x ⌀{in_mm(2.0 * radius)}{zone}, {in_mm(z_end - z_start)} deep"
            yield f"{size}, {thread}{position_text} ({joint.name})"


def _has_threads(name: str, joints: Sequence[Joint]) -> bool:
    """Return whether a part has threads of its own, without inserts."""
    return any(item.part == name and not item.insert for joint in joints for item in joint.threads)


def _describe_counterweight(reducer: Reducer, part: Part) -> Iterator[str]:
    """Yield the note on the counterweight of a crank: its radius and its position; none for other parts."""
    if any(segment.name == COUNTERWEIGHT for segment in part.segments):
        radius = in_mm(reducer.design.shaft.counterweight_radius)
        yield f"counterweight: half disc R{radius}, opposite to the eccentric within 1°"


def _describe_widths(casing: Casing, part: Part) -> Iterator[str]:
    """Yield the note on the tolerance of a width that the axial play of the discs depends on; none for other parts."""
    family, (start, end) = names.family(part.name), (part.segments[0].z0, part.segments[-1].z1)
    limits = {names.GEAR: "0/-{}", names.ROLLER: "0/-{}", names.HOUSING: "+{}/0"}.get(family)
    if limits:
        tolerance = in_mm(0.5 * casing.play)
        yield f"width {in_mm(end - start)} {limits.format(tolerance)}; faces parallel within 0.01"


def first_angle(centres: Array) -> float:
    """Return the angle of the first of some centres (n, 2) about the axis, from +x [deg], without a rounding error."""
    return round(float(np.degrees(np.arctan2(centres[0, 1], centres[0, 0]))), 6) + 0.0


def _describe_tolerances(
    reducer: Reducer, name: str, diameters: Sequence[Dimension], joints: Sequence[Joint]
) -> Iterator[str]:
    """Yield the notes of a drawing on datums, run-out of seats, and position and profile of teeth and pin holes.

    `name` is the name of the part, `diameters` are the dimensions of its section, and `joints` all joints of the drive.
    """
    design, output = reducer.design, reducer.design.output
    seats = [item for item in diameters if " " in item.text and "eccentric" not in item.text]
    datum = min(seats, key=_grade) if seats else max(diameters, key=lambda item: item.radius, default=None)
    if datum:
        yield f"datum A: axis of {datum.text.partition(' ')[0]}; datum B: the face at z = 0 of the lengths"
    if seats:
        yield "total run-out of all seats to A: 0.01; perpendicularity of their shoulders to A: 0.01"
    circle_text = f"⌀{in_mm(2.0 * output.pin_circle_radius)}"
    if names.family(name) == names.GEAR:
        yield describe_lobes(design, "A")
        hole_text = (
            f"⌀{MILLIMETRES * 2.0 * (output.hole_radius + design.clearance.output):.4f} ± {_size_tolerance(design)}"
        )
        yield f"{output.pins} x {hole_text} on {circle_text}, position ⌀{_hole_position_tolerance(design)} to A"
    if name == names.HOUSING:
        yield describe_ring_teeth(design, "A")
    pin_joints = (joint for joint in joints if joint.kind is JointKind.PRESSED and names.OUTPUT_PIN in joint.parts)
    pin_fits = [joint.fit for joint in pin_joints if name in joint.parts]
    for letters, grade in _ZONE.findall(pin_fits[0] if pin_fits else ""):
        if letters.isupper():
            hole_text = f"⌀{in_mm(2.0 * output.root_radius)} {letters}{grade}"
            yield f"{output.pins} x {hole_text} on {circle_text}, position ⌀0.01 to A"


def _grade(dimension: Dimension) -> int:
    """Return the grade of the tolerance zone of a diameter, such as 6 for ``N6``; a large number without a zone."""
    match = _ZONE.search(dimension.text)
    return int(match[2]) if match else max(fits.GRADES)


def largest_deviation(text: str, key: str, size: float, default: float) -> float:
    """Return the largest deviation [m] of a tolerance of the design file; `default` without one."""
    zone = parse_zone(text, key, size, 0.0)
    return max(map(abs, zone.limits)) if zone else default


def _eccentricity_tolerance(design: Design) -> float:
    """Return half of the tolerance of the eccentricity [m]: that of the tolerance study, or 5 um."""
    size = 2.0 * design.gear.bore_radius
    return largest_deviation(design.tolerance.eccentricity, "eccentricity", size, ECCENTRICITY_TOLERANCE)


def _size_tolerance(design: Design) -> str:
    """Return half of the tolerance of the diameters of output holes and rollers [mm], as text.

    Hole and roller share the variation of the radial clearance in the tolerance study equally, or half of the
    clearance.
    """
    clearance, size = design.clearance.output, 2.0 * design.output.hole_radius
    zone = parse_zone(design.tolerance.output, "output", size, clearance)
    half_width = 0.5 * (zone.limits[1] - zone.limits[0]) if zone else 0.5 * clearance
    return f"{MILLIMETRES * half_width:.2g}"


def _hole_position_tolerance(design: Design) -> str:
    """Return the diameter of the zone of an output hole's axis [mm]: that of the tolerance study, or of the teeth."""
    text, size = design.tolerance.hole_position, 2.0 * design.output.hole_radius
    default = _profile_tolerance(design) / MILLIMETRES
    return f"{MILLIMETRES * 2.0 * largest_deviation(text, 'hole_position', size, default):.4f}"


def _profile_tolerance(design: Design) -> float:
    """Return the profile tolerance of the teeth [mm]: half of their clearance."""
    return MILLIMETRES * 0.5 * float(getattr(design.clearance, design.tooth_pair))


def describe_lobes(design: Design, datum: str) -> str:
    """Return the note on the outline of a disc, with its tolerance relative to a datum, such as "A"."""
    return (
        f"{design.lobes} lobes, N = {design.ring.teeth}, E = {in_mm(design.ring.pin_circle_radius)}, "
        f"c = {in_mm(design.gear.eccentricity)}, rho = {in_mm(design.ring.pin_radius)}: outline from the DXF, "
        f"profile of a line {_profile_tolerance(design):.4f} to {datum}"
    )


def describe_ring_teeth(design: Design, datum: str) -> str:
    """Return the note on the sockets or teeth of the ring, with their tolerance relative to a datum, such as "A"."""
    ring, tooth_text, bore_text = design.ring, "teeth", ""
    if ring.kind == "pin":
        tooth_text = f"sockets ⌀{MILLIMETRES * 2.0 * (ring.pin_radius + design.socket_play):.4f}"
        bore_text = f", open to the bore ⌀{in_mm(2.0 * wall_radius(design))}"
    return (
        f"{ring.teeth} {tooth_text} on ⌀{in_mm(2.0 * ring.pin_circle_radius)}{bore_text}: outline from the DXF, "
        f"profile {_profile_tolerance(design):.4f} to {datum}"
    )


def describe_surface(name: str, material: Material, is_printed_part: bool) -> Iterator[str]:
    """Yield the notes of a drawing on roughness, edges and general tolerances, by material and process.

    `name` is the name of the part. `is_printed_part` is whether it is printed from a plastic.
    """
    if is_printed_part:
        yield PRINTED
    else:
        tooth_text = f"; teeth {ROUGHNESS['teeth']}" if names.family(name) in (names.GEAR, names.HOUSING) else ""
        is_turned = names.family(name) in (names.SHAFT, names.CAM, names.CRANK)
        raceway_text = f"; raceways {ROUGHNESS['raceway']}" if is_turned and not material.is_plastic else ""
        yield f"{ROUGHNESS['other']} µm, seats {ROUGHNESS['seat']}{tooth_text}{raceway_text}"
    yield EDGES
    if not is_printed_part:
        yield GENERAL


def _describe_broken_edges(edges: Sequence[BrokenEdge]) -> Iterator[str]:
    """Yield a note for each size of chamfers and fillets among the broken `edges` of a part."""
    for is_fillet, size in sorted({(edge.is_fillet, edge.size) for edge in edges}):
        radii = {edge.radius for edge in edges if (edge.is_fillet, edge.size) == (is_fillet, size)}
        diameters = ", ".join(f"⌀{in_mm(2.0 * radius)}" for radius in sorted(radii))
        yield (
            f"shoulders next to {diameters}: fillet R{in_mm(size)}"
            if is_fillet
            else f"{diameters}: chamfer {in_mm(size)} x 45°"
        )


@dataclass(frozen=True)
class SheetLayout:
    """Sizes of a drawing relative to the larger extent of the part."""

    spacing: float = 0.06  # distance of neighbouring dimension lines
    text_height: float = 0.018  # height of the text in the DXF file


SHEET = SheetLayout()

Line = tuple[tuple[float, float], tuple[float, float], Dimension]


def dimension_lines(drawing: PartDrawing) -> tuple[Line, ...]:
    """Return the dimension lines of a drawing: for each, both ends (x, y) [mm] and its `Dimension`.

    Lengths are below the section, diameters on its right.
    """
    spacing, _, lower_end, right_end = _section_layout(drawing)
    lengths = [
        ((MILLIMETRES * item.low, y), (MILLIMETRES * item.high, y), item)
        for y, item in ((lower_end - (number + 1.0) * spacing, item) for number, item in enumerate(drawing.lengths))
    ]
    diameters = [
        ((x, -MILLIMETRES * item.radius), (x, MILLIMETRES * item.radius), item)
        for x, item in ((right_end + (number + 1.0) * spacing, item) for number, item in enumerate(drawing.diameters))
    ]
    return (*lengths, *diameters)


def sheet_ends(drawing: PartDrawing) -> tuple[float, float, float, float]:
    """Return the left, right, lower and upper end of the section with its dimensions [mm]."""
    spacing, left, lower, right = _section_layout(drawing)
    right_end, lower_end = (
        right + (len(drawing.diameters) + 1.0) * spacing,
        lower - (len(drawing.lengths) + 1.0) * spacing,
    )
    return left - spacing, right_end, lower_end, spacing - lower


def drawing_dxf(drawing: PartDrawing) -> bytes:
    """Encode a drawing as DXF [mm]: layers section, front, dimensions and text; equal drawings give equal bytes.

    Raises
    ------
    CycloidError
        The package ezdxf is not installed.
    """
    ezdxf = import_extra("ezdxf", "DXF", "dxf", "use drawings.pdf")
    spacing, left, lower, right = _section_layout(drawing)
    height = SHEET.text_height / SHEET.spacing * spacing
    with fixed_metadata(ezdxf):
        document = ezdxf.new("R2000", setup=["dimstyles", "linetypes", "styles"])
        document.units = ezdxf.units.MM
        for layer in ("section", "front", "dimensions", "text"):
            document.layers.add(layer)
        model_space = document.modelspace()
        for z0, z1, y0, y1 in (np.array(drawing.section) * MILLIMETRES).tolist():
            corners = [(z0, y0), (z1, y0), (z1, y1), (z0, y1)]
            model_space.add_lwpolyline(corners, close=True, dxfattribs={"layer": "section"})
        right_edge = (
            right
            + (len(drawing.diameters) + 2.0) * spacing
            - MILLIMETRES * min(polygon[:, 0].min() for polygon in drawing.front)
        )
        for polygon in drawing.front:
            points = (MILLIMETRES * polygon + np.array([right_edge, 0.0])).tolist()
            model_space.add_lwpolyline(points, close=True, dxfattribs={"layer": "front"})
        dimension_style = {"dimtxt": height, "dimasz": height, "dimexe": 0.5 * height, "dimexo": 0.5 * height}
        for start, end, item in dimension_lines(drawing):
            direction = {"base": start, "angle": 90.0 if item.radius else 0.0, "text": item.text.replace("⌀", "%%c")}
            dimension_mark = model_space.add_linear_dim(
                p1=start,
                p2=end,
                dimstyle="EZDXF",
                override=dimension_style,
                dxfattribs={"layer": "dimensions"},
                **direction,
            )
            dimension_mark.render()
        text_top = lower - (len(drawing.lengths) + 2.0) * spacing
        for number, text in enumerate((*drawing.title, *drawing.notes)):
            dxf_text = text.replace("⌀", "%%c").replace("°", "%%d").replace("±", "%%p")
            insert = {"layer": "text", "height": height, "insert": (left, text_top - 1.6 * number * height)}
            model_space.add_text(dxf_text, dxfattribs=insert)
        stream = io.StringIO()
        document.write(stream)
    return stream.getvalue().encode()


def _section_layout(drawing: PartDrawing) -> tuple[float, float, float, float]:
    """Return the spacing of dimension lines, and the left, lower and right end of the section [mm]."""
    ends = MILLIMETRES * np.array(drawing.section)
    left, right, lower = float(ends[:, 0].min()), float(ends[:, 1].max()), float(ends[:, 2].min())
    return SHEET.spacing * max(right - left, -2.0 * lower), left, lower, right
