"""The bill of materials: every part of a reducer with its count, size and material, made or bought."""

import csv
import io
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from typing import Literal

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import crank_stretches, parts, sleeve_core_radius
from cycloid_mj.parts.accuracy import VISUAL_CHORD_ERROR
from cycloid_mj.parts.export.printing import (
    OUTPUT_PIN,
    PRESSED_PIN,
    PrintedPart,
    in_one_piece,
    is_printed,
    output_pin_length,
    printed_parts,
)
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer

MADE_OF = {
    names.CAM: names.SHAFT,
    names.SPACER: names.SHAFT,
    OUTPUT_PIN: names.OUTPUT,
    PRESSED_PIN: names.PIN,
}
"""Part -> the one whose material it has, where that is another."""


@dataclass(frozen=True)
class BillLine:
    """One line of the bill; the size says what it measures, in mm. Rolling bearings are of their maker's material."""

    item: str
    count: int
    size: str
    material: str
    made_or_bought: Literal["made", "bought"]


def bill(reducer: Reducer, cam_seat: float = 0.0) -> tuple[BillLine, ...]:
    """List the bill of materials of a design: what is made, as `printing.printed_parts` has it, then what is bought.

    `cam_seat` is the radius of the bore of the cam's bearing [m]; 0: not chosen yet.

    Covers, seals, motor and lubricant are not part of the design. A bearing has the size of the seat that the design
    gives it; the other diameter is the catalogue's.

    Raises
    ------
    DesignError
        A part cannot be made.
    """
    return (*_manufactured(reducer, cam_seat), *_bought(reducer, cam_seat))


def bill_csv(items: tuple[BillLine, ...]) -> bytes:
    """Encode a bill of materials as CSV."""
    text = io.StringIO()
    table = csv.DictWriter(text, [field.name for field in fields(BillLine)], lineterminator="\n")
    table.writeheader()
    table.writerows(asdict(item) for item in items)
    return text.getvalue().encode()


def _manufactured(reducer: Reducer, cam_seat: float) -> Iterator[BillLine]:
    for name, part in printed_parts(reducer, VISUAL_CHORD_ERROR, cam_seat).items():
        family = "output" if name.startswith(f"{names.OUTPUT}_") and name != OUTPUT_PIN else names.family(name)
        material = _material(reducer, MADE_OF.get(family, family))
        item = names.SLEEVE if name == names.PIN and reducer.design.ring.has_sleeves else name
        yield BillLine(item, part.count, _extent(part), material, "made")


def _bought(reducer: Reducer, cam_seat: float) -> Iterator[BillLine]:
    design = reducer.design
    ring, output, gear, shaft = design.ring, design.output, design.gear, design.shaft
    if ring.kind == "pin" and not is_printed(reducer, names.PIN):
        material = _material(reducer, names.PIN)
        if ring.has_sleeves:
            sizes = ("outside diameter", ring.pin_radius), ("bore", ring.sleeve_bore_radius)
            yield BillLine(names.SLEEVE, ring.teeth, _round(*sizes, length=gear.stack_width), material, "bought")
            size = _round(("diameter", sleeve_core_radius(reducer)), length=gear.stack_width)
            yield BillLine(PRESSED_PIN, ring.teeth, size, material, "bought")
        else:
            size = _round(("diameter", ring.pin_radius), length=gear.stack_width)
            yield BillLine(names.PIN, ring.teeth, size, material, "bought")
    if not in_one_piece(reducer) and not is_printed(reducer, names.OUTPUT):
        size = _round(("diameter", output.root_radius), length=output_pin_length(reducer))
        yield BillLine(OUTPUT_PIN, output.pins, size, _material(reducer, names.OUTPUT), "bought")
    if gear.discs > 1 and not is_printed(reducer, names.SHAFT):
        (bar,) = parts(reducer)[names.SHAFT].prisms
        size = _round(("diameter", shaft.radius), length=bar.height)
        yield BillLine(names.SHAFT, 1, size, _material(reducer, names.SHAFT), "bought")
    if output.rollers:
        sizes = ("outside diameter", output.pin_radius), ("bore", output.root_radius)
        size = _round(*sizes, length=gear.face_width)
        yield BillLine(names.ROLLER, output.pins * gear.discs, size, "", "bought")
    if gear.bearing == "rolling":
        bore = (("bore", cam_seat),) if cam_seat else ()
        size = _round(("outside diameter", gear.bore_radius), *bore, length=gear.face_width)
        yield BillLine("cam_bearing", gear.discs, size, "", "bought")
    seats = bearing_seats(reducer, crank_stretches(reducer))
    size = _round(("bore", shaft.radius), length=seats[0][1] - seats[0][0])
    yield BillLine("shaft_bearing", len(seats), size, "", "bought")
    if design.housing.support == "bolts":
        size = f"head at most {_mm(2.0 * design.bolt_radius)} mm, circle {_mm(2.0 * design.bolt_circle_radius)} mm"
        yield BillLine("bolt", design.housing.bolts, size, "", "bought")


def _material(reducer: Reducer, part: str) -> str:
    """Name what a part is made of, or tell it by its stiffness and density where the design gives numbers alone."""
    material = reducer.design.material_of(part)
    return material.name or f"E {material.youngs_modulus / 1e6:g} MPa, {material.density:g} kg/m3"


def _extent(part: PrintedPart) -> str:
    """Format length x width x height of a part that is made."""
    outlines = np.concatenate([prism.outline for prism in part.solid.prisms])
    height = max(prism.z1 for prism in part.solid.prisms) - min(prism.z0 for prism in part.solid.prisms)
    return " x ".join(f"{MILLIMETRES * length:.4g}" for length in (*np.ptp(outlines, axis=0), height)) + " mm"


def _round(*radii: tuple[str, float], length: float) -> str:
    """Format diameters, each with what it measures, and the length of a round part."""
    return " x ".join([*(f"{what} {_mm(2.0 * radius)}" for what, radius in radii), f"length {_mm(length)}"]) + " mm"


def _mm(length: float) -> str:
    return f"{MILLIMETRES * length:.5g}"
