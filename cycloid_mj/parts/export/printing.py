"""Manufactured and bought parts of a reducer, and the manufactured parts as drawn for a printer."""

from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import Material
from cycloid_mj.parts import Part, Segment, Solid, lay_out_parts, output_centres, parts, sleeve_core_radius
from cycloid_mj.parts.cam_bearing import cam_radius
from cycloid_mj.parts.contour import CircleContour, Contour, TurnedContour
from cycloid_mj.parts.export.bearings import output_pin_span
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.casing_parts import casing_parts, fit_part
from cycloid_mj.parts.export.casing_rules import (
    in_one_piece,
    is_crank_manufactured,
    is_printed,
)
from cycloid_mj.parts.export.round_part import RoundPart, cut_holes
from cycloid_mj.parts.output import roller_part
from cycloid_mj.reducer import Reducer

STEEL = 7850.0
"""Density of bought parts [kg/m3]."""


@dataclass(frozen=True)
class PrintedPart:
    """A manufactured part as it is printed, the number of copies, and its exact outlines."""

    count: int
    solid: Solid
    drawn: Part


def widen_clearances(reducer: Reducer, offset: float) -> Reducer:
    """Return a reducer with all clearances increased by an offset [m]; press fits and bought parts do not change.

    The pin in a sleeve keeps its size; the offset is in the bore of the sleeve.

    Raises
    ------
    DesignError
        A clearance exceeds its limit, or no wall is left of the sleeves.
    """
    design = reducer.design
    if not offset:
        return reducer
    ring_changes = {"sleeve_thickness": design.ring.sleeve_thickness - offset} if design.ring.has_sleeves else {}
    clearances = {pair: getattr(design.clearance, pair) + offset for pair in design.pair_kinds}
    try:
        return reducer.but(clearance=clearances, ring=ring_changes)
    except DesignError as error:
        raise DesignError(
            f"{design.name}: the printer offset of {1e6 * offset:g} um is too large, because a clearance would exceed "
            "its limit or the sleeves would have no wall: choose a smaller offset (--offset-um)"
        ) from error


def material_part(reducer: Reducer, part: str) -> str:
    """Return the name of the part of the mechanism from whose material a part of the drive is manufactured.

    `part` is the name of the latter; for a cam, for example, the result is the shaft. Discs and flange of the output
    have the material of the housing if that is plastic, else that of the output.
    """
    family = names.family(part)
    if family in (names.CAM, names.SPACER, names.CRANK_RING, names.BEARING_SPACER):
        return names.SHAFT
    if family == names.PRESSED_PIN:
        return names.PIN
    if family in (*names.COVERS, names.STOP_RING):
        return names.HOUSING
    if family in (names.OUTPUT, names.FLANGE):
        return names.HOUSING if is_printed(reducer, names.HOUSING) else names.OUTPUT
    return names.OUTPUT if family in (names.OUTPUT_PIN, names.ROLLER) else family


def part_material(reducer: Reducer, part: str, casing: Casing | None) -> Material:
    """Return the material of a part of a drive; that of covers can differ from that of the ring."""
    if casing and casing.cover_material and names.family(part) in names.COVERS:
        return Material(name=casing.cover_material)
    return reducer.design.material_of(material_part(reducer, part))


def printed_parts(
    reducer: Reducer, chord_error: float, cam_seat: float = 0.0, casing: Casing | None = None
) -> dict[str, PrintedPart]:
    """Return the printed parts: the plastic parts of `manufactured_parts`, or all if none is plastic."""
    manufactured = manufactured_parts(reducer, chord_error, cam_seat, casing)
    plastic_parts = {
        name: part for name, part in manufactured.items() if is_printed(reducer, material_part(reducer, name))
    }
    return plastic_parts or manufactured


def manufactured_parts(
    reducer: Reducer, chord_error: float, cam_seat: float = 0.0, casing: Casing | None = None
) -> dict[str, PrintedPart]:
    """Return the parts to be manufactured, as solids and outlines in their own frames, with their number, by name.

    Housing, discs and output are manufactured from any material; so are a crank in one piece, or cams and spacers of
    several discs. Plain round parts (ring pins, sleeves, output pins, the shaft of several discs) are manufactured if
    they are plastic. The discs of the output have bores for separate output pins.

    Parameters
    ----------
    reducer
        The reducer; its clearances are in the outlines.
    chord_error
        Largest distance of a chord from its curve [m].
    cam_seat
        Bore radius of the cam bearing [m], which the cams fit; 0: cams with the outer radius of the bearing.
    casing
        The casing, to include covers and flanges.

    Raises
    ------
    DesignError
        A part cannot be manufactured.
    """
    design = reducer.design
    gear, ring, output = design.gear, design.ring, design.output
    new_cam_radius = _checked_cam_radius(reducer, cam_seat) if cam_seat else 0.0
    separated_parts, mechanism_parts = (
        separate_parts(reducer, new_cam_radius, casing, chord_error),
        lay_out_parts(reducer, chord_error),
    )
    counts = dict.fromkeys((names.HOUSING, *reducer.gears), 1)
    if not design.has_one_piece_crank:
        counts |= dict.fromkeys(names.all_numbered(names.CAM, gear.discs), 1) | {names.SPACER: gear.discs - 1}
    if is_crank_manufactured(reducer):
        counts[names.SHAFT] = 1
    if is_printed(reducer, names.PIN):
        counts |= {names.PIN: ring.teeth, names.PRESSED_PIN: ring.teeth}
    counts |= {names.OUTPUT: 1, names.SECOND_OUTPUT: 1}
    if is_printed(reducer, names.OUTPUT):
        counts[names.OUTPUT_PIN] = output.pins
    if casing:
        added_parts = casing_parts(reducer, casing).items()
        counts |= {name: 1 for name, part in added_parts if not part.bought and name not in mechanism_parts}
    drawn_parts = parts(reducer, chord_error)  # kept there, for what stays as it is

    def make_solid(name: str) -> Solid:
        return (
            drawn_parts[name]
            if separated_parts[name] is mechanism_parts.get(name)
            else separated_parts[name].solid(chord_error)
        )

    return {
        name: PrintedPart(count, make_solid(name), separated_parts[name])
        for name, count in counts.items()
        if name in separated_parts
    }


def separate_parts(
    reducer: Reducer, cam: float = 0.0, casing: Casing | None = None, chord_error: float | None = None
) -> dict[str, Part]:
    """Return all manufactured and bought parts of an assembly as exact outlines, each in its own frame, by name.

    Pins pressed into housing or output, and rollers, are separate parts; the discs of the output have bores for pins.

    Parameters
    ----------
    reducer
        The reducer; its clearances are in the outlines.
    cam
        Radius of the cams [m]; 0: cams with the outer radius of the cam bearing.
    casing
        The casing, to include its parts and its holes in other parts.
    chord_error
        Chord error of the balanced crank [m], see `lay_out_parts`.

    Raises
    ------
    DesignError
        A part cannot be manufactured.
    """
    parts_by_name = lay_out_parts(reducer, chord_error)
    housing = parts_by_name[names.HOUSING]
    ring_segments = housing.segments[: reducer.design.ring.halves]
    if pressed_segments := housing.segments[len(ring_segments) :]:
        parts_by_name[names.HOUSING] = housing.of(ring_segments)
        core_segment = Segment(
            names.PRESSED_PIN,
            CircleContour(sleeve_core_radius(reducer)),
            (),
            pressed_segments[0].z0,
            pressed_segments[0].z1,
        )
        parts_by_name[names.PRESSED_PIN] = parts_by_name[names.PIN].of([core_segment], names.PRESSED_PIN)
    parts_by_name |= _split_output(reducer, parts_by_name[names.OUTPUT])
    if reducer.design.output.rollers:
        parts_by_name[names.ROLLER] = roller_part(reducer)
    if cam:
        for name in (names.SHAFT, *names.all_numbered(names.CAM, reducer.design.gear.discs)):
            if name in parts_by_name:
                parts_by_name[name] = parts_by_name[name].of(
                    _resize_cam(reducer, segment, cam) for segment in parts_by_name[name].segments
                )
    if casing:
        parts_by_name = {name: fit_part(reducer, casing, name, part) for name, part in parts_by_name.items()}
    for name, part in (casing_parts(reducer, casing) if casing else {}).items():
        base_segments = parts_by_name[name].segments if name in parts_by_name else ()
        density = STEEL if part.bought else part_material(reducer, name, casing).density
        parts_by_name[name] = Part(name, cut_holes(name, part, base_segments), density)
    if names.SECOND_OUTPUT in parts_by_name:
        density = part_material(reducer, names.SECOND_OUTPUT, casing).density
        parts_by_name[names.SECOND_OUTPUT] = replace(parts_by_name[names.SECOND_OUTPUT], density=density)
    return parts_by_name


def _checked_cam_radius(reducer: Reducer, seat: float) -> float:
    """Return the radius [m] of a cam for a bearing of the bore radius `seat` [m]; raise DesignError if none fits."""
    design = reducer.design
    gear = design.gear
    min_seat = gear.eccentricity + design.shaft.radius
    if gear.bearing != "rolling":
        raise DesignError(
            "--cam-bearing-bore-mm needs a cam with a rolling bearing, but this cam slides in the disc (gear.bearing = "
            '"plain"): remove the flag, or set gear.bearing = "rolling"'
        )
    if (
        not (min_seat < seat or (design.has_one_piece_crank and seat == round(min_seat, 9)))
        or not seat < gear.bore_radius
    ):
        raise DesignError(
            f"--cam-bearing-bore-mm is {2e3 * seat:g}, which does not fit: choose a bore larger than "
            f"{2e3 * min_seat:g} mm, to clear the shaft, and smaller than {2e3 * gear.bore_radius:g} mm, the "
            "outside diameter of the bearing (twice gear.bore_radius_mm)"
        )
    return cam_radius(reducer, seat)


def _resize_cam(reducer: Reducer, segment: Segment, radius: float) -> Segment:
    """Return a segment of the crank, with another radius [m] if it is a cam."""
    if names.family(segment.name) != names.CAM:
        return segment
    cam_contour: Contour = CircleContour(radius, (0.0, reducer.design.gear.eccentricity))
    if isinstance(segment.outline, TurnedContour):
        cam_contour = replace(segment.outline, contour=cam_contour)
    return replace(segment, outline=cam_contour)


def _split_output(reducer: Reducer, output_part: Part) -> dict[str, Part]:
    """Split the output, `output_part`, into parts by name; return an empty dict if it is printed in one piece.

    They are the disc `names.OUTPUT` with bores for pins, one `OUTPUT_PIN` and, if the pins have two supports, the disc
    `SECOND_OUTPUT`.
    """
    if in_one_piece(reducer):
        return {}
    disc, *other_segments = output_part.segments
    radius = reducer.design.output.root_radius
    pressed_holes = RoundPart(names.OUTPUT, holes=((output_centres(reducer), radius, -np.inf, np.inf),))
    pin = Segment(names.OUTPUT_PIN, CircleContour(radius), (), *output_pin_span(reducer))
    pieces = {
        names.OUTPUT: output_part.of(cut_holes(names.OUTPUT, pressed_holes, [disc])),
        names.OUTPUT_PIN: output_part.of([pin], names.OUTPUT_PIN),
    }
    if reducer.design.output.support == "both_ends":
        pieces[names.SECOND_OUTPUT] = output_part.of(
            cut_holes(names.SECOND_OUTPUT, pressed_holes, other_segments[-1:]), names.SECOND_OUTPUT
        )
    return pieces
