"""The bill of materials of an RV reducer: manufactured parts, then ring pins, needles and bearings.

A pin, needle or crank bearing whose dimensions are not in stock is a special part, made by the drawing of its maker.
"""

from collections import Counter
from collections.abc import Iterator

from cycloid_mj.base import names
from cycloid_mj.base.units import in_mm
from cycloid_mj.design import stock
from cycloid_mj.parts.contour import circle_of
from cycloid_mj.parts.export.bill import BillLine, format_dimensions, format_extent, material_name
from cycloid_mj.parts.export.rv_assembly import place_rv_parts, rv_assembly_parts, rv_masses
from cycloid_mj.parts.export.rv_drawing import INNER_RING, MAIN_BORE, MAIN_SEAT, MATERIAL_OF, OUTER_RING
from cycloid_mj.parts.part import Part
from cycloid_mj.parts.rv import NEEDLE, PIN_END_PLAY, TAPERED_BEARING
from cycloid_mj.reducer import RvReducer

BOUGHT = names.PIN, NEEDLE, TAPERED_BEARING, names.OUTPUT_BEARING
"""Bought parts, round bars and rings, in their order in the bill."""


def rv_bill(reducer: RvReducer, crank_ratings: tuple[float, float] = (0.0, 0.0)) -> tuple[BillLine, ...]:
    """Return the bill of materials of an RV reducer, with the numbers and masses of the solids of its assembly.

    Splines, screws, seals, grease, needle cages and the shaft of the sun are not included. `crank_ratings` are the
    dynamic and the static load rating that special crank bearings need [N]; 0 if unknown.

    Raises
    ------
    DesignError
        A part cannot be manufactured, or does not fit.
    """
    return (*_manufactured_lines(reducer), *_bought_lines(reducer, crank_ratings))


def _manufactured_lines(reducer: RvReducer) -> Iterator[BillLine]:
    """Yield the rows of the manufactured parts: size, material and mass."""
    counts, masses = _count_parts(reducer), rv_masses(reducer)
    for name, part in rv_assembly_parts(reducer).items():
        if name not in BOUGHT:
            material = material_name(reducer.design.material_of(MATERIAL_OF.get(name, names.family(name))))
            yield BillLine(name, counts[name], format_extent(part), material, "made", mass_kg=masses[name])


def _bought_lines(reducer: RvReducer, crank_ratings: tuple[float, float]) -> Iterator[BillLine]:
    """Yield the rows of the bought parts: dimensions, designation, fit and mass; `crank_ratings` as `rv_bill`."""
    counts, masses, parts = _count_parts(reducer), rv_masses(reducer), rv_assembly_parts(reducer)
    for name in BOUGHT:
        if name in parts:
            designation, fit = _designation(reducer, parts[name], crank_ratings)
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


def _designation(reducer: RvReducer, part: Part, crank_ratings: tuple[float, float]) -> tuple[str, str]:
    """Return stock designation and fit of a bought part; the designation is ``names.SPECIAL`` if it is not in stock.

    `crank_ratings` are the load ratings C and C0 that special crank bearings need [N]; 0 if unknown.
    """
    if part.name == names.OUTPUT_BEARING and (bearing := reducer.main_bearing):
        return bearing.designation, f"{MAIN_BORE} outside, {MAIN_SEAT} on the flanges, back to back, light preload"
    if part.name == TAPERED_BEARING:
        fit = f"{OUTER_RING} outside, {INNER_RING} on the crank, face to face"
        if crank_bearing := reducer.crank_bearing:
            return crank_bearing.designation, fit
        ratings = [
            f"{name} at least {1e-3 * value:.3g} kN"
            for name, value in zip(("C", "C0"), crank_ratings, strict=True)
            if value
        ]
        return names.SPECIAL, "; ".join((fit, *ratings))
    if part.name == names.PIN and reducer.design.ring.has_sleeves:
        return "", ""
    (segment,) = part.segments
    diameter = 2.0 * (reducer.cranks.needle_radius if part.name == NEEDLE else reducer.design.ring.pin_radius)
    roller = stock.free_pin(diameter, segment.z1 - segment.z0 + 2.0 * PIN_END_PLAY, PIN_END_PLAY)
    if roller is None or roller.count > 1:
        return names.SPECIAL if part.name == NEEDLE else "", ""
    return roller.designation, f"cut to {in_mm(roller.cut)} mm" if roller.cut else ""
