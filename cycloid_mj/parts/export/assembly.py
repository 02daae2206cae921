"""A reducer put together: every part in its place, and one STEP file of them, named and coloured (AP 214)."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.design.stock import bearings_on
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts import carried, crank_stretches, pin_radius, sleeve_core_radius
from cycloid_mj.parts.export.curve import Circle
from cycloid_mj.parts.export.printing import PRESSED_PIN
from cycloid_mj.parts.export.section import PartSection, part_sections
from cycloid_mj.parts.export.step import SPLINES, step_part
from cycloid_mj.parts.parts import Colour, tinted
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.member import gear_angle, ring_angle

COLOURS: Mapping[str, Colour] = {
    names.HOUSING: (0.55, 0.58, 0.62, 1.0),
    names.PIN: (0.85, 0.75, 0.35, 1.0),
    PRESSED_PIN: (0.45, 0.45, 0.45, 1.0),
    names.GEAR: (0.25, 0.45, 0.7, 1.0),
    names.SHAFT: (0.75, 0.35, 0.3, 1.0),
    names.CAM: (0.8, 0.5, 0.35, 1.0),
    names.SPACER: (0.6, 0.6, 0.55, 1.0),
    names.OUTPUT: (0.4, 0.6, 0.45, 1.0),
    names.ROLLER: (0.7, 0.8, 0.7, 1.0),
}
"""Part by its family -> colour."""

USUAL_OUTSIDE = 1.4
"""Radius of a shaft's bearing outside over the shaft's, where none in stock has its size (as its rollers are rated)."""

TOUCHING = 1e-9
"""Within which faces are the same [m]."""

_NUMBER = re.compile(r"#(\d+)")


@dataclass(frozen=True)
class Place:
    """Where one part stands: its name there, the part, its origin [m] and how far it is turned about z [rad]."""

    name: str
    part: str
    origin: tuple[float, float, float]
    angle: float


def places(reducer: Reducer, crank: float = 0.0) -> tuple[Place, ...]:
    """Place every part at a crank angle [rad], all clearances even: teeth, cams and rollers touch nothing."""
    return tuple(_places(reducer, crank))


def _places(reducer: Reducer, crank: float) -> Iterator[Place]:
    design = reducer.design
    ring, carrier = float(ring_angle(design, crank)), float(gear_angle(design, crank))
    yield Place(names.HOUSING, names.HOUSING, (0.0, 0.0, 0.0), ring)
    yield Place(names.SHAFT, names.SHAFT, (0.0, 0.0, 0.0), crank)
    for name, (part, place) in carried(reducer, names.SHAFT).items():
        yield _carried(name, part, place, crank)
    discs = zip(names.gears(design.gear.discs), reducer.phases, design.gear.disc_planes, strict=True)
    for gear, phase, plane in discs:
        x, y = design.gear.eccentricity * unit(-(crank + phase))  # unit turns clockwise, the crank the other way
        yield Place(gear, gear, (float(x), float(y), plane), carrier)
    yield Place(names.OUTPUT, names.OUTPUT, (0.0, 0.0, 0.0), carrier)
    for name, (part, place) in carried(reducer, names.OUTPUT).items():
        yield _carried(name, part, place, carrier)
    if design.ring.kind == "pin":
        angles = 2.0 * np.pi * np.arange(design.ring.teeth) / design.ring.teeth - ring
        for number, (x, y) in enumerate(design.ring.pin_circle_radius * unit(angles), start=1):
            at = float(x), float(y), 0.0
            yield Place(names.pin(number), names.PIN, at, ring)
            if design.ring.has_sleeves:
                yield Place(f"{PRESSED_PIN}_{number}", PRESSED_PIN, at, ring)


def _carried(name: str, part: str, place: Array, angle: float) -> Place:
    cos, sin = np.cos(angle), np.sin(angle)
    x, y, z = place
    return Place(name, part, (float(cos * x - sin * y), float(sin * x + cos * y), float(z)), angle)


def assembly_step(reducer: Reducer, crank: float = 0.0) -> bytes:
    """Encode the whole reducer as one STEP file: an assembly of named, coloured parts, each drawn once.

    Raises
    ------
    DesignError
        A part cannot be made.
    CycloidError
        The package gmsh is not installed, or OpenCASCADE cannot make a part.
    """
    drawn = {name: step_part(name, sections) for name, sections in assembly_sections(reducer).items()}
    return _assembled(reducer.design.name, drawn, places(reducer, crank))


def assembly_sections(reducer: Reducer) -> dict[str, tuple[PartSection, ...]]:
    """Build the sections of every part as it is put together.

    Pins that are pressed into the housing are parts of their own, and the output disc has the seat of the bearing in
    its hub, where a shaft straddles the discs.

    Raises
    ------
    DesignError
        A part cannot be made.
    """
    sections = part_sections(reducer, SPLINES)
    if reducer.design.ring.has_sleeves:
        wheel, core, *_ = sections[names.HOUSING]
        circle = Circle((0.0, 0.0), sleeve_core_radius(reducer))
        sections[names.HOUSING] = (wheel,)
        sections[PRESSED_PIN] = (PartSection(PRESSED_PIN, ((circle,),), core.z0, core.z1),)
    if reducer.design.shaft.mounting == "straddle":
        sections[names.OUTPUT] = tuple(_with_seat(reducer, sections[names.OUTPUT]))
    return sections


def _with_seat(reducer: Reducer, output: tuple[PartSection, ...]) -> Iterator[PartSection]:
    """Yield the sections of the output, its disc beyond the gears with a hole for the bearing at the shaft's end."""
    low, high = bearing_seats(reducer, crank_stretches(reducer))[0]
    seat = Circle((0.0, 0.0), _seat_radius(reducer, high - low))
    for section in output:
        if section.z0 < low - TOUCHING or section.z0 > high:
            yield section
            continue
        end = min(high, section.z1)
        yield PartSection(section.name, (*section.loops, (seat,)), section.z0, end)
        if end < section.z1 - TOUCHING:
            yield PartSection(section.name, section.loops, end, section.z1)


def _seat_radius(reducer: Reducer, width: float) -> float:
    """Find the radius of the seat in the hub [m]: of the bearing in stock, or as thick as its rollers usually are."""
    design = reducer.design
    stocked = bearings_on(2.0 * design.shaft.radius, width)
    outside = 0.5 * stocked[0].outside if stocked else USUAL_OUTSIDE * design.shaft.radius
    room = design.output.pin_circle_radius - pin_radius(reducer)
    return min(outside, 0.5 * (design.shaft.radius + room) if outside >= room else outside)


@dataclass(frozen=True)
class _DrawnPart:
    """Entities of a part in the file, by number: its definition, representation, frame, solid and context."""

    definition: int
    representation: int
    frame: int
    solid: int
    context: int


class _Entities:
    """The data section of a STEP file, entity after entity."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.last = 0

    def add(self, text: str) -> int:
        """Write an entity, such as ``DIRECTION('',(0.,0.,1.))``, and return its number."""
        self.last += 1
        self.lines.append(f"#{self.last} = {text};")
        return self.last

    def include(self, name: str, content: bytes) -> _DrawnPart:
        """Take in a part's file, its entities renumbered."""
        data = content.decode().split("DATA;", 1)[1].split("ENDSEC;", 1)[0]
        data = data.replace("MANIFOLD_SOLID_BREP('',", f"MANIFOLD_SOLID_BREP('{name}',")
        shift = self.last
        self.last += max(map(int, _NUMBER.findall(data)))
        self.lines.append(_NUMBER.sub(lambda match: f"#{int(match[1]) + shift}", data).strip())

        def found(pattern: str) -> tuple[int, ...]:
            match = re.search(pattern, data)
            assert match, pattern  # OpenCASCADE writes a part as one product with one solid
            return tuple(int(number) + shift for number in match.groups())

        (definition,) = found(r"#(\d+) = PRODUCT_DEFINITION\('design'")
        numbers = found(r"#(\d+) = ADVANCED_BREP_SHAPE_REPRESENTATION\('',\(#(\d+),#(\d+)\),#(\d+)\)")
        representation, frame, solid, context = numbers
        return _DrawnPart(definition, representation, frame, solid, context)

    def frame(self, origin: tuple[float, float, float], angle: float) -> int:
        """Write a frame at an origin [m], turned about z [rad]."""
        x, y, z = (MILLIMETRES * value for value in origin)
        at = self.add(f"CARTESIAN_POINT('',({x:.9f},{y:.9f},{z:.9f}))")
        axis = self.add("DIRECTION('',(0.,0.,1.))")
        along = self.add(f"DIRECTION('',({np.cos(angle):.15f},{np.sin(angle):.15f},0.))")
        return self.add(f"AXIS2_PLACEMENT_3D('',#{at},#{axis},#{along})")

    def colour(self, part: _DrawnPart, colour: Colour) -> int:
        """Colour the solid of a part."""
        red, green, blue, _ = colour
        rgb = self.add(f"COLOUR_RGB('',{red:.6f},{green:.6f},{blue:.6f})")
        fill = self.add(f"FILL_AREA_STYLE_COLOUR('',#{rgb})")
        area = self.add(f"FILL_AREA_STYLE('',(#{fill}))")
        surface = self.add(f"SURFACE_STYLE_FILL_AREA(#{area})")
        side = self.add(f"SURFACE_SIDE_STYLE('',(#{surface}))")
        usage = self.add(f"SURFACE_STYLE_USAGE(.BOTH.,#{side})")
        style = self.add(f"PRESENTATION_STYLE_ASSIGNMENT((#{usage}))")
        item = self.add(f"STYLED_ITEM('',(#{style}),#{part.solid})")
        of = "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION"
        return self.add(f"{of}('',(#{item}),#{part.context})")


def _assembled(name: str, drawn: Mapping[str, bytes], placed: tuple[Place, ...]) -> bytes:
    """Put files of parts together as one product with an occurrence of its part at each place."""
    entities = _Entities()
    parts = {part: entities.include(part, content) for part, content in drawn.items()}
    for part, found in parts.items():
        entities.colour(found, tinted(COLOURS[names.family(part)], part))
    context = entities.add("APPLICATION_CONTEXT('core data for automotive mechanical design processes')")
    of_product = entities.add(f"PRODUCT_CONTEXT('',#{context},'mechanical')")
    product = entities.add(f"PRODUCT('{name}','{name}','',(#{of_product}))")
    formation = entities.add(f"PRODUCT_DEFINITION_FORMATION('','',#{product})")
    of_definition = entities.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',#{context},'design')")
    whole = entities.add(f"PRODUCT_DEFINITION('design','',#{formation},#{of_definition})")
    shape = entities.add(f"PRODUCT_DEFINITION_SHAPE('','',#{whole})")
    origin = entities.frame((0.0, 0.0, 0.0), 0.0)
    frames = [entities.frame(place.origin, place.angle) for place in placed]
    items = ",".join(f"#{frame}" for frame in (origin, *frames))
    units = next(iter(parts.values())).context
    representation = entities.add(f"SHAPE_REPRESENTATION('',({items}),#{units})")
    entities.add(f"SHAPE_DEFINITION_REPRESENTATION(#{shape},#{representation})")
    for number, (place, frame) in enumerate(zip(placed, frames, strict=True), start=1):
        used = parts[place.part]
        turn = entities.add(f"ITEM_DEFINED_TRANSFORMATION('','',#{used.frame},#{frame})")
        relation = entities.add(
            f"( REPRESENTATION_RELATIONSHIP('','',#{used.representation},#{representation}) "
            f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{turn}) SHAPE_REPRESENTATION_RELATIONSHIP() )"
        )
        usage = entities.add(
            f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{number}','{place.name}','',#{whole},#{used.definition},$)"
        )
        occurrence = entities.add(f"PRODUCT_DEFINITION_SHAPE('Placement','of {place.name}',#{usage})")
        entities.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relation},#{occurrence})")
    header = (
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('assembly'),'2;1');\n"
        f"FILE_NAME('{name}.step','',(''),(''),'','cycloid_mj','');\n"
        "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"
    )
    return (header + "\n".join(entities.lines) + "\nENDSEC;\nEND-ISO-10303-21;\n").encode()
