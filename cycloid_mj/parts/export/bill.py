"""The bill of materials: each part of a reducer with count, size and material, manufactured or bought."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Literal

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.frame import make_frame
from cycloid_mj.base.units import in_mm
from cycloid_mj.design import Material, stock
from cycloid_mj.parts import Part, mass_properties, sleeve_core_radius
from cycloid_mj.parts.accuracy import EXPORT_CHORD_ERROR, VISUAL_CHORD_ERROR
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.parts.cam_bearing import cam_seat as full_cam_seat
from cycloid_mj.parts.contour import Contour, circle_of
from cycloid_mj.parts.export.assembly import assembly_parts, place_parts
from cycloid_mj.parts.export.bearings import (
    DOWEL_MATERIAL,
    FREE_FIT,
    RETAINED_FIT,
    ROLLER_FIT,
    SHAFT_BEARINGS,
    adhesive_of,
    bearing_fit,
    cup_fit,
    free_pin,
    output_pin,
    output_pin_fit,
    output_pin_length,
    pin_pieces,
    press_fit,
    roller_bearing,
    roller_tube,
    shaft_bearing,
    shaft_bearing_fit,
    shaft_seal,
    sleeve_pin_length,
)
from cycloid_mj.parts.export.cam_clamp import cam_clamp
from cycloid_mj.parts.export.casing import Casing, bearing_width_of, seat_radius
from cycloid_mj.parts.export.casing_parts import bored_shaft
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    hole_depth,
    in_one_piece,
    is_crank_manufactured,
    is_plastic,
    is_printed,
)
from cycloid_mj.parts.export.crank_joints import cam_key
from cycloid_mj.parts.export.drive import filling
from cycloid_mj.parts.export.joint import Joint, JointKind, TappedHole
from cycloid_mj.parts.export.joints import ITEMS, bought_parts, drive_joints
from cycloid_mj.parts.export.printing import STEEL, manufactured_parts, part_material
from cycloid_mj.parts.export.round_part import cut_holes
from cycloid_mj.parts.inertia import region_moments
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class ConsumableSettings:
    """Amounts of grease, adhesive and sealant.

    Attributes
    ----------
    grease_fill
        Share of the free space that is filled with grease (SKF, Rolling bearings, 2018: 30 to 50 %).
    adhesive_film
        Thickness of adhesive or sealant in a joint, with what is wiped off [m] (assumed: gaps of H7/g6 take half).
    density
        Density of grease, adhesive and sealant [kg/m3] (0.9 to 1.1, SKF and Loctite data sheets).
    """

    grease_fill: float = 1.0 / 3.0
    adhesive_film: float = 0.1e-3
    density: float = 0.95e3


CONSUMABLES = ConsumableSettings()

ADHESIVES = {False: "ISO 10123, 25 MPa", True: "3 MPa on plastics"}
"""Designation of the adhesive on metals, and on plastics."""


@dataclass(frozen=True)
class BillLine:
    """A line of the bill of materials, with named dimensions in mm, and the mass of all its parts.

    Bought parts have a designation if they are in stock (``design.stock``), and the fit of their seat (ISO 286-1).
    Rolling bearings are filled by `BEARING_FILL`.
    """

    item: str
    count: int
    size: str
    material: str
    made_or_bought: Literal["made", "bought", "consumable"]
    designation: str = ""
    fit: str = ""
    mass_kg: float = 0.0


def bill(
    reducer: Reducer,
    cam_seat: float = 0.0,
    casing: Casing | None = None,
    torques: Mapping[str, float] | None = None,
) -> tuple[BillLine, ...]:
    """Return the bill of materials of a design: manufactured parts (`printing.manufactured_parts`), then bought parts.

    The motor and the `consumables` are not included. A `BillLine` is a row of this table. Where no stock bearing fits,
    the row has the dimensions of the bearing's seats.

    Parameters
    ----------
    cam_seat
        Bore radius of the chosen cam bearing [m]; 0: the bearing that `cam_bearing` chooses.
    casing
        Casing of the drive; None: the mechanism only.
    torques
        Tightening torques [N m] by the name of the screws in the bill, such as ``flange_screw``. They replace the fit
        in the row of these screws.

    Raises
    ------
    DesignError
        A part cannot be manufactured.
    """
    lines = (*_manufactured_lines(reducer, cam_seat, casing), *_bought_lines(reducer, cam_seat, casing))
    return (
        tuple(
            replace(line, fit=f"tighten with {torques[line.item]:.2g} N m") if line.item in torques else line
            for line in lines
        )
        if torques
        else lines
    )


def consumables(reducer: Reducer, casing: Casing, torques: Mapping[str, float] | None = None) -> Iterator[BillLine]:
    """Yield bill rows of grease (a third of the free space), adhesive, motor screws and sealant that a drive needs.

    Sealant is for the metal faces of ring and covers; plastics keep grease in without it. `torques` are tightening
    torques [N m] by the name of the screws, such as ``motor_screw``.
    """
    parts, placements = assembly_parts(reducer, casing), place_parts(reducer, 0.0, casing)
    inner_placements = [
        placement
        for placement in placements
        if placement.body != names.HOUSING and casing.floor <= placement.origin[2] <= casing.top
    ]
    solid_volume = sum(
        _inner_volume(parts[placement.part], placement.origin[2], casing) for placement in inner_placements
    )
    root_radius = reducer.design.ring_root_radius
    free_space = math.pi * (
        2.0 * casing.end * root_radius**2
        + (-casing.end - casing.floor) * casing.cavity**2
        + (casing.hub_floor - casing.end) * casing.output_cavity**2
    )
    grease = CONSUMABLES.grease_fill * max(free_space - solid_volume, 0.0)
    designation = "NLGI 1 with EP additives"
    yield _consumable_line("grease", grease, "lithium soap", designation, "a third of the free space")
    glued_joints = [joint for joint in drive_joints(reducer, casing) if joint.kind is JointKind.GLUED]
    area = sum(math.pi * joint.count * joint.diameter * joint.length for joint in glued_joints)
    on_plastic = {joint.name: _has_plastic(reducer, casing, joint) for joint in glued_joints}
    if bore := casing.motor_bore:
        radius, start, end = bore
        area += 2.0 * math.pi * radius * (end - start)
        on_plastic["motor shaft in the crank"] = part_material(reducer, names.SHAFT, casing).is_plastic
    if on_plastic:
        volume, kinds = CONSUMABLES.adhesive_film * area, sorted(set(on_plastic.values()))
        material, designation = " and ".join(map(adhesive_of, kinds)), "; ".join(ADHESIVES[kind] for kind in kinds)
        places = (f"{adhesive_of(kind)}: {place}" if len(kinds) > 1 else place for place, kind in on_plastic.items())
        yield _consumable_line("adhesive", volume, material, designation, "; ".join(places))
    yield from _motor_screw_line(reducer, casing, torques or {})
    if not is_plastic(reducer):
        face_area = 2.0 * math.pi * (reducer.design.housing.outer_radius**2 - root_radius**2)
        volume = CONSUMABLES.adhesive_film * face_area
        yield _consumable_line(
            "sealant", volume, "anaerobic flange sealant", "gap up to 0.25 mm", "both faces of the ring"
        )


def _has_plastic(reducer: Reducer, casing: Casing, joint: Joint) -> bool:
    """Return whether a part of a joint of a drive is of a plastic."""
    return any(part_material(reducer, part, casing).is_plastic for part in joint.parts)


def _motor_screw_line(reducer: Reducer, casing: Casing, torques: Mapping[str, float]) -> Iterator[BillLine]:
    """Yield the row of screws through the flange of a motor into the cover, which are longer by its thickness.

    Screws into the tapped holes of a motor are bought parts of the drive. `torques` are tightening torques [N m].
    """
    motor = casing.motor
    if motor.tapped:
        return
    deepest = hole_depth(reducer, motor.thread, RULES.engagement * motor.thread)
    length = f"{in_mm(motor.thread)} to {in_mm(deepest)} mm longer than the flange of the motor is thick"
    designation, size = f"ISO 4762 - M{in_mm(motor.thread)}", f"{motor.screws} off, {length}"
    name, material, fit = names.MOTOR_SCREW, "steel 8.8", "through the flange of the motor"
    if name in torques:
        fit += f"; tighten with {torques[name]:.2g} N m"
    yield BillLine(name, motor.screws, size, material, "consumable", designation, fit)


def describe_consumable(line: BillLine) -> str:
    """Describe a consumable: what, how much, and where."""
    return f"{line.item}, {line.material} {line.designation}: {line.size}; {line.fit}"


def _consumable_line(item: str, volume: float, material: str, designation: str, application: str) -> BillLine:
    size, mass = f"{1e6 * volume:.2g} cm3", CONSUMABLES.density * volume
    return BillLine(item, 1, size, material, "consumable", designation, application, mass)


def _inner_volume(part: Part, z: float, casing: Casing) -> float:
    """Compute the volume [m3] that a part occupies in the space inside the drive that is filled with grease.

    The space extends along z from the floor of the cavity in the motor cover to the first output bearing. `z` [m] is
    the height of the origin of the part in the drive.
    """
    solid = part.solid(VISUAL_CHORD_ERROR)
    space_start, space_end = casing.floor - z, casing.hub_floor - z
    return sum(
        abs(region_moments(prism).area) * max(min(prism.z1, space_end) - max(prism.z0, space_start), 0.0)
        for prism in solid.prisms
    )


def bill_csv(items: tuple[BillLine, ...]) -> bytes:
    """Encode a bill of materials as CSV."""
    columns = [field.name for field in fields(BillLine)]
    return make_frame([asdict(item) for item in items], columns, {}).as_csv().encode()


def out_of_stock(items: Iterable[BillLine]) -> Iterator[str]:
    """Yield a warning for each part to be bought of which none in stock has the size."""
    for item in items:
        if item.made_or_bought == "bought" and not item.designation:
            yield f"{item.item}: no standard part has {item.size}; choose other dimensions, or have it custom-made"


def _manufactured_lines(reducer: Reducer, cam_seat: float, casing: Casing | None) -> Iterator[BillLine]:
    """Yield the rows of the bill of materials for the manufactured parts: size, material, threads and fits, and mass.

    Parameters
    ----------
    cam_seat
        Bore radius of the chosen cam bearing [m], which the cams fit. 0: the cams of the assembly, or without a casing,
        cams with the outer radius of the bearing.
    casing
        Casing of the drive; None: the mechanism only.
    """
    joints = drive_joints(reducer, casing) if casing else ()
    assembled_parts = assembly_parts(reducer, casing) if casing and not cam_seat else {}
    for name, part in manufactured_parts(reducer, VISUAL_CHORD_ERROR, cam_seat, casing).items():
        bore_text = _format_bore(reducer, casing) if name == names.SHAFT else ""
        material = material_name(part_material(reducer, name, casing))
        drawn_part = assembled_parts.get(name, part.drawn)
        mass = part.count * mass_properties(drawn_part.solid(EXPORT_CHORD_ERROR)).mass
        mass -= drawn_part.density * _drilled_volume(reducer, name) if casing else 0.0
        size, fit = format_extent(drawn_part) + bore_text, _describe_machining(joints, name)
        yield BillLine(name, part.count, size, material, "made", fit=fit, mass_kg=mass)


def _drilled_volume(reducer: Reducer, part: str) -> float:
    """Compute the volume [m3] that the holes of clamping screws remove from a cam, which its solid does not have."""
    clamp = cam_clamp(reducer)
    if clamp is None or names.family(part) != names.CAM:
        return 0.0
    return clamp.count * clamp.removed_volume(reducer)


def _describe_machining(joints: Iterable[Joint], part: str) -> str:
    """Describe the threads of a part, and its seats with their fits, for its row in the bill of materials.

    `joints` are all joints of the drive.
    """
    threads, seats = [], []
    for joint in joints:
        threads += [_describe_tapped_holes(thread) for thread in joint.threads if thread.part == part]
        if part in joint.parts and joint.fit and joint.diameter:
            seats.append(f"{joint.name} {in_mm(joint.diameter)} mm: {joint.fit}")
    return "; ".join((*threads, *seats))


def _describe_tapped_holes(tapped: TappedHole) -> str:
    """Describe equal tapped holes, or holes for inserts."""
    size = f"{tapped.count} x M{in_mm(tapped.thread)}, {in_mm(tapped.depth)} mm deep"
    if tapped.insert:
        return f"{size}, insert {tapped.insert}"
    return f"{size}, drilled {in_mm(stock.thread_core(tapped.thread))} mm"


def _bought_lines(reducer: Reducer, cam_seat: float, casing: Casing | None) -> Iterator[BillLine]:
    """Yield the rows of the bill of materials for bought parts: pins, rollers and bearings, then those of the casing.

    Parameters
    ----------
    cam_seat
        Bore radius of the chosen cam bearing [m]; 0: the bearing that `cam_bearing` chooses.
    casing
        Casing of the drive; None: the mechanism only.
    """
    yield from _round_bar_lines(reducer, casing)
    yield from _roller_lines(reducer, casing)
    yield from _bearing_lines(reducer, cam_seat)
    if casing:
        yield from _casing_lines(reducer, casing)
    elif reducer.design.housing.support == "bolts":
        design = reducer.design
        size = f"head at most {in_mm(2.0 * design.bolt_radius)} mm, circle {in_mm(2.0 * design.bolt_circle_radius)} mm"
        screw = stock.bolt_under(2.0 * design.bolt_radius)
        yield BillLine("bolt", design.housing.bolts, size, "", "bought", screw.designation if screw else "")


def _casing_lines(reducer: Reducer, casing: Casing) -> Iterator[BillLine]:
    """Yield the rows of the bill of materials for the bought parts of all joints: bearings, screws, inserts, dowels."""
    counts: Counter[str] = Counter()
    parts = {}
    for part in bought_parts(drive_joints(reducer, casing)):
        counts[part.item] += len(part.origins)
        parts[part.item] = part
    for item in sorted(
        parts.keys() - {names.SHAFT_BEARING}, key=lambda item: (item != names.OUTPUT_BEARING, ITEMS.index(item))
    ):
        part = parts[item]
        size, solid = (
            format_dimensions(part.dimensions),
            Part(item, cut_holes(item, part.solid), STEEL).solid(EXPORT_CHORD_ERROR),
        )
        mass = counts[item] * filling(item) * mass_properties(solid).mass
        yield BillLine(item, counts[item], size, part.material, "bought", part.designation, part.fit, mass)


def _round_bar_lines(reducer: Reducer, casing: Casing | None) -> Iterator[BillLine]:
    """Yield the rows of the bill of materials for bought round bars: ring pins, output pins, shaft of several discs.

    `casing` None: the mechanism only.
    """
    design = reducer.design
    ring, output, gear = design.ring, design.output, design.gear
    if ring.kind == "pin" and not is_printed(reducer, names.PIN):
        material = design.material_of(names.PIN)
        if ring.has_sleeves:
            count, length = pin_pieces(reducer)
            diameters = ("outside diameter", ring.pin_radius), ("bore", ring.sleeve_bore_radius)
            sleeve_line = _round_line(names.PIN, count * ring.teeth, diameters, length, material)
            yield replace(sleeve_line, designation="sleeve to measure", fit="F7 on its pin")
            core_radius = sleeve_core_radius(reducer)
            cut_length = sleeve_pin_length(reducer) if casing else gear.stack_width
            yield _pressed_pin_line(names.PRESSED_PIN, ring.teeth, core_radius, cut_length, material)
        else:
            yield _ring_pin_line(reducer, material)
    if not in_one_piece(reducer) and not is_printed(reducer, names.OUTPUT):
        length = output_pin_length(reducer)
        size, material = (output.root_radius, length), design.material_of(names.OUTPUT)
        yield _pin_line(names.OUTPUT_PIN, output.pins, output_pin(reducer), size, material, output_pin_fit(reducer))
    if not is_crank_manufactured(reducer):
        yield _shaft_line(reducer, casing)


def _shaft_line(reducer: Reducer, casing: Casing | None) -> BillLine:
    """Return the row of the bill of materials for the shaft of several discs: a ground bar with bore and keyway.

    `casing` None: the mechanism only.
    """
    diameter = 2.0 * reducer.design.shaft.radius
    shaft, material = bored_shaft(reducer, casing), reducer.design.material_of(names.SHAFT)
    length = max(segment.z1 for segment in shaft.segments) - min(segment.z0 for segment in shaft.segments)
    key = cam_key(reducer, casing) if casing else None
    bar_line = _round_line(names.SHAFT, 1, (("diameter", 0.5 * diameter),), length, material)
    keyway = (
        f"keyway {in_mm(key.bought.width)} x {in_mm(key.bought.in_shaft)} x {in_mm(key.bought.length)} mm"
        if key
        else ""
    )
    bar_text = f"ground bar {in_mm(diameter)} h6" if diameter in stock.bar_diameters() else ""
    mass = mass_properties(shaft.solid(EXPORT_CHORD_ERROR)).mass
    size = bar_line.size + _format_bore(reducer, casing)
    return replace(bar_line, size=size, designation=bar_text, fit=keyway, mass_kg=mass)


def _format_bore(reducer: Reducer, casing: Casing | None) -> str:
    """Describe the bore of the crank, for the motor or through it, such as ", bored 5 x 22 mm"; "" without a bore.

    `casing` None: the mechanism only.
    """
    bore, through_radius = casing.motor_bore if casing else None, reducer.design.shaft.bore_radius
    if through_radius:
        return f", bored through {in_mm(2.0 * through_radius)} mm"
    if not bore:
        return ""
    radius, start, end = bore
    return f", bored {in_mm(2.0 * radius)} x {in_mm(end - start)} mm"


def _pressed_pin_line(item: str, count: int, radius: float, length: float, material: Material) -> BillLine:
    """Return the line of pins that bend in their seats, each in one piece of a radius and length [m]."""
    diameter = 2.0 * radius
    pin, fit = stock.single_pin(diameter, length), press_fit(diameter, length)
    return _pin_line(item, count, pin, (radius, length), material, fit)


def _pin_line(
    item: str, count: int, pin: stock.Dowel | None, size: tuple[float, float], material: Material, fit: str
) -> BillLine:
    """Return the row of the bill of materials for `count` round pins, cut from a pin in stock, or custom-made.

    `item` is the name of the pins. `pin` is the pin in stock; None: the pins are custom-made. `size` has radius and
    length [m], `material` is that of the pins, and `fit` the fit of pins in stock.
    """
    radius, length = size
    if not pin:
        return _round_line(item, count, (("diameter", radius),), length, material)
    cut_length = length if pin.length > length + stock.ROUNDING else 0.0
    line = _round_line(item, count, (("diameter", radius),), pin.length, material, cut_length)
    fit_text = fit + (f", cut to {in_mm(cut_length)} mm" if cut_length else "")
    named_line = replace(line, designation=pin.designation, fit=fit_text)
    return replace(named_line, material=DOWEL_MATERIAL) if pin.designation.startswith(stock.DOWELS) else named_line


def _ring_pin_line(reducer: Reducer, material: Material) -> BillLine:
    """Return the row of the bill of materials for ring pins: needle rollers, pin gauges, or pins ground to size.

    `material` is the material of the pins.
    """
    ring, roller = reducer.design.ring, free_pin(reducer)
    seat_text = FREE_FIT if ring.has_sockets else RETAINED_FIT
    named_radius = (("diameter", ring.pin_radius),)
    if not roller:
        line = _round_line(names.PIN, ring.teeth, named_radius, reducer.design.gear.stack_width, material)
        return replace(line, fit=f"ground {_format_limits(stock.ROLLER_LIMITS)}, {seat_text}")
    line = _round_line(names.PIN, ring.teeth * roller.count, named_radius, roller.length, material, roller.cut)
    fit = f"{_format_limits(roller.limits)}, {seat_text}" + (f", cut to {in_mm(roller.cut)} mm" if roller.cut else "")
    return replace(line, designation=roller.designation, fit=fit)


def _format_limits(limits: tuple[float, float]) -> str:
    """Format lower and upper deviation of a size [m], such as ``0/-2 um`` or ``+-1 um``."""
    lower_text, upper_text = (f"{1e6 * limit:.3g}" for limit in limits)
    return f"+-{upper_text} um" if lower_text == f"-{upper_text}" else f"{upper_text}/{lower_text} um"


def _roller_lines(reducer: Reducer, casing: Casing | None) -> Iterator[BillLine]:
    """Yield the rows of the bill of materials for the rollers of the output pins and their needle bearings, if any.

    Rollers on a core are turned, or cut from a tube in stock for discs of plastic. Others are bought, and have no
    material in the bill. `casing` None: the mechanism only, whose rollers are drawn without bearings.
    """
    output, gear = reducer.design.output, reducer.design.gear
    if not output.rollers:
        return
    bearing_and_count, material = roller_bearing(reducer) if casing else None, reducer.design.material_of(names.OUTPUT)
    count, bore = (
        output.pins * gear.discs,
        0.5 * bearing_and_count[0].outside if bearing_and_count else output.root_radius,
    )
    diameters = ("outside diameter", output.pin_radius), ("bore", bore)
    line = _round_line(names.ROLLER, count, diameters, gear.face_width, material)
    fit = f"{cup_fit(reducer, names.OUTPUT)} around its {names.ROLLER_BEARING}" if bearing_and_count else ROLLER_FIT
    if not output.has_roller_parts:
        yield replace(line, material="", fit=fit)
    elif tube := roller_tube(reducer) if casing else None:
        fit = f"bored {fit}, cut to {in_mm(gear.face_width)} mm"
        yield replace(line, made_or_bought="made", material="steel E235+C", designation=tube.designation, fit=fit)
    else:
        yield replace(line, made_or_bought="made", fit=fit)
    if bearing_and_count:
        bearing, bearings_per_roller = bearing_and_count
        fit = f"{cup_fit(reducer, names.OUTPUT)} outside, the pin under the needles"
        yield _stock_bearing_line(names.ROLLER_BEARING, count * bearings_per_roller, bearing, fit)


def _bearing_lines(reducer: Reducer, cam_seat: float) -> Iterator[BillLine]:
    """Yield the rows of the bill of materials for the bearings of cams and shaft.

    Where no stock bearing fits, the row has the dimensions of the bearing's seats. `cam_seat` is the bore radius of the
    chosen cam bearing [m]; 0: the bearing that `cam_bearing` chooses.
    """
    gear, shaft = reducer.design.gear, reducer.design.shaft
    if gear.bearing == "rolling":
        cam_bearings = cam_bearing(reducer)
        if cam_bearings and cam_seat in (0.0, round(0.5 * cam_bearings[0].bore, 9)):
            bearing, count = cam_bearings
            yield _stock_bearing_line(
                names.CAM_BEARING, gear.discs * count, bearing, bearing_fit(reducer, bearing, names.GEAR)
            )
        else:
            diameters = ("outside diameter", gear.bore_radius), ("bore", cam_seat or full_cam_seat(reducer))
            line = _round_line(names.CAM_BEARING, gear.discs, diameters, gear.face_width)
            yield replace(line, fit="rollers in the bore of the disc")
    stock_bearing, seal = shaft_bearing(reducer), shaft_seal(reducer)
    fit = "; ".join(filter(None, (shaft_bearing_fit(reducer), seal)))
    if stock_bearing:
        yield _stock_bearing_line(names.SHAFT_BEARING, SHAFT_BEARINGS, stock_bearing, fit)
    else:
        width = bearing_width_of(reducer)
        diameters = ("outside diameter", seat_radius(reducer, width)), ("bore", shaft.radius)
        yield replace(_round_line(names.SHAFT_BEARING, SHAFT_BEARINGS, diameters, width), fit=fit)


def _stock_bearing_line(item: str, count: int, bearing: stock.StockBearing, fit: str) -> BillLine:
    diameters = ("outside diameter", 0.5 * bearing.outside), ("bore", 0.5 * bearing.bore)
    line = _round_line(item, count, diameters, bearing.width)
    return replace(line, designation=bearing.designation, fit=fit)


def _round_line(
    item: str,
    count: int,
    radii: tuple[tuple[str, float], ...],
    length: float,
    material: Material | None = None,
    cut_length: float = 0.0,
) -> BillLine:
    """Return the row of the bill of materials for `count` round bought parts, with their mass.

    Parameters
    ----------
    item
        Name of the parts.
    count
        Number of parts.
    radii
        Radii [m] with their names, the outer one first.
    length
        Length [m].
    material
        Material; None: steel, and the mass of a bearing is that of a solid ring times its share of steel (`filling`).
    cut_length
        Length to which the parts are shortened [m]; 0: not shortened.
    """
    outer_radius, inner_radius = radii[0][1], radii[1][1] if len(radii) > 1 else 0.0
    volume = math.pi * (outer_radius**2 - inner_radius**2) * (cut_length or length)
    mass = count * volume * (material.density if material else STEEL * filling(item))
    name = material_name(material) if material else ""
    dimensions = [*((name, 2.0 * radius) for name, radius in radii), ("length", length)]
    return BillLine(item, count, format_dimensions(dimensions), name, "bought", mass_kg=mass)


def material_name(material: Material) -> str:
    """Return the name of a material, or its stiffness and density if it has no name."""
    return material.name or f"E {material.youngs_modulus / 1e6:g} MPa, {material.density:g} kg/m3"


def format_extent(part: Part) -> str:
    """Format length x width x height of a manufactured part, exactly where its outlines are circles."""
    corners = np.array([_bounding_box(segment.outline) for segment in part.segments])
    sides = corners[:, 1].max(axis=0) - corners[:, 0].min(axis=0)
    height = max(segment.z1 for segment in part.segments) - min(segment.z0 for segment in part.segments)
    return " x ".join(in_mm(float(length)) for length in (*sides, height)) + " mm"


def _bounding_box(contour: Contour) -> tuple[Array, Array]:
    """Return the corners of the bounding box of a contour [m]."""
    if circle := circle_of(contour):
        return np.array(circle.centre) - circle.radius, np.array(circle.centre) + circle.radius
    points = contour.polygon(VISUAL_CHORD_ERROR)
    return points.min(axis=0), points.max(axis=0)


def format_dimensions(dimensions: Iterable[tuple[str, float]]) -> str:
    """Format named dimensions [m]."""
    return " x ".join(f"{name} {in_mm(length)}" for name, length in dimensions) + " mm"
