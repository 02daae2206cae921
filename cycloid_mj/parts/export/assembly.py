"""The assembled reducer: all parts in place, and one STEP file with names and colours (AP 214)."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.parts import Part, PartSection, attached_parts, output_centres
from cycloid_mj.parts.cam_bearing import cam_bearing, cam_radius, cam_seat
from cycloid_mj.parts.export.bearings import pin_pieces, roller_bearing
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.casing_parts import place_casing
from cycloid_mj.parts.export.casing_rules import (
    in_one_piece,
)
from cycloid_mj.parts.export.edges import broken_edges
from cycloid_mj.parts.export.joints import cross_holes_of
from cycloid_mj.parts.export.placement import place_discs, place_ring_pins, place_rotated, ring_pin_centres
from cycloid_mj.parts.export.printing import STEEL, part_material, separate_parts
from cycloid_mj.parts.export.round_part import cut_holes, tube
from cycloid_mj.parts.export.rv_assembly import RV_COLOURS, place_rv_parts, rv_assembly_parts
from cycloid_mj.parts.export.step import SPLINES, PlacedPart, step_assembly
from cycloid_mj.parts.parts import Colour, roller_positions, tint
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.reducer.sockets import require_one_ring

COLOURS: Mapping[str, Colour] = {
    names.HOUSING: (0.55, 0.58, 0.62, 1.0),
    names.PIN: (0.85, 0.75, 0.35, 1.0),
    names.PRESSED_PIN: (0.45, 0.45, 0.45, 1.0),
    names.GEAR: (0.25, 0.45, 0.7, 1.0),
    names.SHAFT: (0.75, 0.35, 0.3, 1.0),
    names.KEY: (0.45, 0.45, 0.45, 1.0),
    names.CAM: (0.8, 0.5, 0.35, 1.0),
    names.SPACER: (0.6, 0.6, 0.55, 1.0),
    **dict.fromkeys((names.CRANK_RING, names.BEARING_SPACER), (0.7, 0.7, 0.6, 1.0)),
    names.OUTPUT: (0.4, 0.6, 0.45, 1.0),
    names.ROLLER: (0.7, 0.8, 0.7, 1.0),
    names.OUTPUT_PIN: (0.5, 0.5, 0.5, 1.0),
    names.MOTOR_COVER: (0.6, 0.62, 0.7, 1.0),
    names.OUTPUT_COVER: (0.65, 0.62, 0.6, 1.0),
    **dict.fromkeys((names.RETAINER, names.STOP_RING), (0.7, 0.7, 0.65, 1.0)),
    names.FLANGE: (0.35, 0.55, 0.4, 1.0),
    **dict.fromkeys((names.SCREW, names.FLANGE_SCREW, names.RETAINER_SCREW), (0.2, 0.2, 0.22, 1.0)),
    names.CAM_SCREW: (0.2, 0.2, 0.22, 1.0),
    names.FLANGE_WASHER: (0.7, 0.7, 0.72, 1.0),
    names.FLANGE_DOWEL: (0.7, 0.7, 0.72, 1.0),
    names.MOTOR_SCREW: (0.2, 0.2, 0.22, 1.0),
    names.DOWEL: (0.45, 0.45, 0.45, 1.0),
    **dict.fromkeys(names.INSERTS, (0.8, 0.65, 0.3, 1.0)),
    names.SHAFT_BEARING: (0.8, 0.82, 0.85, 1.0),
    names.OUTPUT_BEARING: (0.8, 0.82, 0.85, 1.0),
    names.CAM_BEARING: (0.8, 0.82, 0.85, 1.0),
    names.ROLLER_BEARING: (0.8, 0.82, 0.85, 1.0),
    **dict.fromkeys(names.RETAINING_RINGS, (0.3, 0.3, 0.32, 1.0)),
    names.SHAFT_SEAL: (0.15, 0.15, 0.15, 1.0),
}
"""Colours by family of parts."""


def place_parts(reducer: Reducer, crank: float = 0.0, casing: Casing | None = None) -> tuple[PlacedPart, ...]:
    """Return all parts of an assembly with their positions at a crank angle [rad], with all clearances centred.

    `casing` None: the mechanism only, in which each ring pin is one piece.
    """
    return tuple(_place_parts(reducer, crank, casing))


def _place_parts(reducer: Reducer, crank: float, casing: Casing | None) -> Iterator[PlacedPart]:
    """Yield all parts of an assembly with their positions at a crank angle [rad]; `casing` None: without the casing."""
    design, origin = reducer.design, np.zeros(3)
    ring_angle, carrier_angle = float(reducer.member.ring_angle(crank)), float(reducer.member.gear_angle(crank))
    angle_by_body = {names.HOUSING: ring_angle, names.SHAFT: crank, names.OUTPUT: carrier_angle}
    for body, angle in angle_by_body.items():
        yield place_rotated(body, body, origin, angle, body)
    rollers = roller_positions(reducer) if design.output.rollers else {}
    for body, attached_by_name in ((names.SHAFT, attached_parts(reducer, names.SHAFT)), (names.OUTPUT, rollers)):
        for name, (part, position) in attached_by_name.items():
            yield place_rotated(
                name, part, position, angle_by_body[body], names.ROLLER if part == names.ROLLER else body
            )
    if casing:
        yield from _place_roller_bearings(reducer, carrier_angle)
    if not in_one_piece(reducer):
        if design.output.support == "both_ends":
            yield place_rotated(names.SECOND_OUTPUT, names.SECOND_OUTPUT, origin, carrier_angle, names.OUTPUT)
        for number, centre in enumerate(output_centres(reducer), start=1):
            position = np.array([*centre, 0.0])
            yield place_rotated(
                names.numbered_name(names.OUTPUT_PIN, number),
                names.OUTPUT_PIN,
                position,
                carrier_angle,
                names.OUTPUT,
            )
    for disc in place_discs(reducer, crank, carrier_angle):
        yield disc
        if cam_seat(reducer) < design.gear.bore_radius:
            yield from _place_cam_bearings(reducer, disc.name, disc.origin, carrier_angle)
    if design.ring.kind == "pin":
        yield from place_ring_pins(reducer, ring_angle, pin_pieces(reducer) if casing else (1, 0.0))
        yield from _place_pressed_pins(reducer, ring_angle)
    for item in place_casing(reducer, casing) if casing else ():
        yield place_rotated(item.name, item.part, np.array(item.origin), angle_by_body[item.body], item.body)


def _place_roller_bearings(reducer: Reducer, carrier_angle: float) -> Iterator[PlacedPart]:
    """Yield the positions of the needle bearings side by side in the rollers of the output pins.

    `carrier_angle` [rad] is the rotation of the output pins about the axis, counter-clockwise.
    """
    stock_bearing = roller_bearing(reducer)
    if stock_bearing is None:
        return
    bearing, count = stock_bearing
    offsets = [bearing.width * (number - 0.5 * (count - 1)) for number in range(count)]
    positions = [
        np.array([0.0, 0.0, z]) + roller_position
        for _, roller_position in roller_positions(reducer).values()
        for z in offsets
    ]
    for number, position in enumerate(positions, start=1):
        name = names.numbered_name(names.ROLLER_BEARING, number)
        yield place_rotated(name, names.ROLLER_BEARING, position, carrier_angle, names.ROLLER)


def _place_cam_bearings(
    reducer: Reducer, gear: str, centre: tuple[float, float, float], angle: float
) -> Iterator[PlacedPart]:
    """Yield the positions of the bearings of a cam, side by side in the middle of its disc.

    `gear` is the name of the disc, `centre` [m] its centre and `angle` [rad] its rotation about z.
    """
    stock_bearing, (x, y, z) = cam_bearing(reducer), centre
    width, count = (stock_bearing[0].width, stock_bearing[1]) if stock_bearing else (0.0, 1)
    name = gear.replace(names.GEAR, names.CAM_BEARING)
    for number in range(count):
        bearing_name = f"{name}_{number + 1}" if count > 1 else name
        origin = x, y, z + width * (number - 0.5 * (count - 1))
        yield PlacedPart(bearing_name, names.CAM_BEARING, origin, angle, gear)


def _place_pressed_pins(reducer: Reducer, ring_angle: float) -> Iterator[PlacedPart]:
    """Yield the positions of the pins inside sleeves, which the housing holds, in a ring at an angle [rad]."""
    if reducer.design.ring.has_sleeves:
        for number, (x, y) in enumerate(ring_pin_centres(reducer, ring_angle), start=1):
            yield PlacedPart(f"{names.PRESSED_PIN}_{number}", names.PRESSED_PIN, (x, y, 0.0), ring_angle, names.HOUSING)


def assembly_step(reducer: Reducer, crank: float = 0.0, casing: Casing | None = None) -> bytes:
    """Encode the assembled reducer at a crank angle [rad] as one STEP file of named, coloured parts, each drawn once.

    `casing` None: the mechanism only. The casing is ignored for an RV reducer.

    Raises
    ------
    DesignError
        A part cannot be manufactured, or does not fit.
    CycloidError
        The package OCP is not installed, or OpenCASCADE cannot build a part.
    """
    if isinstance(reducer, RvReducer):
        sections = {name: part.sections(SPLINES) for name, part in rv_assembly_parts(reducer).items()}
        colours = {name: tint(RV_COLOURS[names.family(name)], name) for name in sections}
        return step_assembly(reducer.design.name, sections, colours, tuple(place_rv_parts(reducer, crank)))
    parts = assembly_parts(reducer, casing)
    sections = {name: part.sections(SPLINES) for name, part in parts.items()}
    colours = {name: tint(COLOURS[names.family(name)], name) for name in parts}
    edges = {name: broken_edges(reducer, casing, part) for name, part in parts.items()} if casing else {}
    bores = {name: cross_holes_of(reducer, casing, name) for name in parts} if casing else {}
    return step_assembly(reducer.design.name, sections, colours, place_parts(reducer, crank, casing), edges, bores)


def assembly_sections(
    reducer: Reducer, casing: Casing | None = None, splines: int = SPLINES
) -> dict[str, tuple[PartSection, ...]]:
    """Return the sections of `assembly_parts`, with `splines` splines per lobe; raises the same errors."""
    return {name: part.sections(splines) for name, part in assembly_parts(reducer, casing).items()}


def assembly_parts(reducer: Reducer, casing: Casing | None = None) -> dict[str, Part]:
    """Return all parts of an assembly as exact outlines by name, with the casing if there is one.

    Pins pressed into housing or output are separate parts. Cams fit the bore of their bearing. A journal that is thick
    enough has a bore for the motor shaft.

    Raises
    ------
    DesignError
        A part cannot be manufactured or does not fit, or the ring is in two halves.
    """
    require_one_ring(reducer, "assembly")
    gear, seat, stock_bearing = reducer.design.gear, cam_seat(reducer), cam_bearing(reducer)
    has_cam_bearing = seat != gear.bore_radius
    parts = separate_parts(reducer, cam_radius(reducer) if has_cam_bearing else 0.0, casing)
    if casing and (in_rollers := roller_bearing(reducer)):
        cup = tube(0.5 * in_rollers[0].bore, 0.5 * in_rollers[0].outside, in_rollers[0].width)
        parts[names.ROLLER_BEARING] = Part(names.ROLLER_BEARING, cut_holes(names.ROLLER_BEARING, cup), STEEL)
    if not has_cam_bearing:
        return parts
    width = stock_bearing[0].width if stock_bearing else gear.face_width
    parts[names.CAM_BEARING] = Part(
        names.CAM_BEARING, cut_holes(names.CAM_BEARING, tube(seat, gear.bore_radius, width)), STEEL
    )
    return parts


def printed_materials(reducer: Reducer, casing: Casing | None, parts: Iterable[str]) -> dict[str, tuple[str, Colour]]:
    """Return the name of the material and the colour of each part."""
    return {
        part: (part_material(reducer, part, casing).name or "own", tint(COLOURS[names.family(part)], part))
        for part in parts
    }
