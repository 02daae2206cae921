"""The bill of materials of an RV reducer: manufactured parts, then ring pins, needles and bearings.

The dimensions of needles and tapered bearings are those of the design, so they have no designation.
"""

from collections import Counter
from collections.abc import Iterator

from cycloid_mj.base import names
from cycloid_mj.base.units import in_mm
from cycloid_mj.design import stock
from cycloid_mj.parts.contour import circle_of
from cycloid_mj.parts.export.bill import BillLine, format_dimensions, format_extent, material_name
from cycloid_mj.parts.export.rv_assembly import place_rv_parts, rv_assembly_parts, rv_masses
from cycloid_mj.parts.export.rv_drawing import MAIN_BORE, MAIN_SEAT, MATERIAL_OF
from cycloid_mj.parts.part import Part
from cycloid_mj.parts.rv import NEEDLE, PIN_END_PLAY, TAPERED_BEARING
from cycloid_mj.reducer import RvReducer

BOUGHT = names.PIN, NEEDLE, TAPERED_BEARING, names.OUTPUT_BEARING
"""Bought parts, round bars and rings, in their order in the bill."""


def rv_bill(reducer: RvReducer) -> tuple[BillLine, ...]:
    """Return the bill of materials of an RV reducer, with the numbers and masses of the solids of its assembly.

    Splines, screws, seals, grease and the shaft of the sun are not included.

    Raises
    ------
    DesignError
        A part cannot be manufactured, or does not fit.
    """
    return (*_manufactured_lines(reducer), *_bought_lines(reducer))


def _manufactured_lines(reducer: RvReducer) -> Iterator[BillLine]:
    """Yield the rows of the manufactured parts: size, material and mass."""
    counts, masses = _count_parts(reducer), rv_masses(reducer)
    for name, part in rv_assembly_parts(reducer).items():
        if name not in BOUGHT:
            material = material_name(reducer.design.material_of(MATERIAL_OF.get(name, names.family(name))))
            yield BillLine(name, counts[name], format_extent(part), material, "made", mass_kg=masses[name])


def _bought_lines(reducer: RvReducer) -> Iterator[BillLine]:
    """Yield the rows of the bought parts: dimensions, designation, fit and mass."""
    counts, masses, parts = _count_parts(reducer), rv_masses(reducer), rv_assembly_parts(reducer)
    for name in BOUGHT:
        if name in parts:
            designation, fit = _designation(reducer, parts[name])
            size = format_dimensions(_round_dimensions(parts[name]))
            yield BillLine(name, counts[name], size, "", "bought", designation, fit, masses[name])


def _count_parts(reducer: RvReducer) -> Counter[str]:
    """Count the copies of each part in the assembly."""
    return Counter(placement.part for placement in place_rv_parts(reducer))


def _round_dimensions(part: Part) -> Iterator[tuple[str, float]]:
    """Yield the names and values [m] of the diameters and the length of a round bar or ring."""
    (segment,) = part.segments
    for name, contour in zip(("diameter", "bore"), (segment.outline, *segment.holes), strict=False):
        if circle := circle_of(contour):
            yield name, 2.0 * circle.radius
    yield "length", segment.z1 - segment.z0


def _designation(reducer: RvReducer, part: Part) -> tuple[str, str]:
    """Return stock designation and fit of a bought part; both are empty for a part with dimensions of its own."""
    if part.name == names.OUTPUT_BEARING and (bearing := reducer.main_bearing):
        return bearing.designation, f"{MAIN_BORE} outside, {MAIN_SEAT} on the flanges, back to back, light preload"
    if part.name == names.PIN and not reducer.design.ring.has_sleeves:
        length = part.segments[0].z1 - part.segments[0].z0
        roller = stock.free_pin(2.0 * reducer.design.ring.pin_radius, length + 2.0 * PIN_END_PLAY, PIN_END_PLAY)
        if roller and roller.count == 1:
            return roller.designation, f"cut to {in_mm(roller.cut)} mm" if roller.cut else ""
    return "", ""
