"""The bill of materials: every part of a reducer with its count, size and material, made or bought."""

import csv
import io
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from typing import Literal

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.design import stock
from cycloid_mj.parts import parts, sleeve_core_radius
from cycloid_mj.parts.accuracy import VISUAL_CHORD_ERROR
from cycloid_mj.parts.export.casing import (
    CAM_BEARING,
    DOWEL,
    FLANGE_INSERT,
    FLANGE_SCREW,
    LOAD_INSERT,
    MOTOR_INSERT,
    MOTOR_SCREW,
    OUTPUT_BEARING,
    SCREW,
    SCREW_INSERT,
    SHAFT_BEARING,
    Casing,
    bearing_width_of,
    casing_places,
    flange_screw_length,
    insert_in,
    motor_bore,
    motor_screw,
)
from cycloid_mj.parts.export.printing import (
    OUTPUT_PIN,
    PRESSED_PIN,
    PrintedPart,
    in_one_piece,
    is_printed,
    made_parts,
    material_part,
    output_pin_length,
)
from cycloid_mj.reducer import Reducer

PRESSED, FREE = "m6 in H7", "m6, free in its socket"
"""Fits of dowels (m6, ISO 8734)."""

NEEDLES, BALLS = "N6 outside, h5 on the shaft", "H7 outside, j6 on the shaft"
BALLS_OF_HUB = "H7 outside, k6 on the hub"
"""Fits of drawn cups and the shaft under their needles (ISO 3245), and of ball bearings whose shaft turns."""

SHAFT_BEARINGS = 2


@dataclass(frozen=True)
class BillLine:
    """One line of the bill; the size says what it measures, in mm. Rolling bearings are of their maker's material.

    What is bought has a designation where it is in stock (``design.stock``), and the fit of its seat (ISO 286-1).
    """

    item: str
    count: int
    size: str
    material: str
    made_or_bought: Literal["made", "bought"]
    designation: str = ""
    fit: str = ""


def bill(reducer: Reducer, cam_seat: float = 0.0, sizes: Casing | None = None) -> tuple[BillLine, ...]:
    """List the bill of materials of a design: what is made, as `printing.made_parts` has it, then what is bought.

    `cam_seat` is the radius of the bore of the cam's bearing [m]; 0: not chosen yet. `sizes` are those of covers,
    screws and the output's bearings; None: without them.

    Seals, motor and lubricant are not part of the design. A bearing has the size of the seat that the design
    gives it; the other diameter is the catalogue's.

    Raises
    ------
    DesignError
        A part cannot be made.
    """
    return (*_manufactured(reducer, cam_seat, sizes), *_bought(reducer, cam_seat, sizes))


def bill_csv(items: tuple[BillLine, ...]) -> bytes:
    """Encode a bill of materials as CSV."""
    text = io.StringIO()
    table = csv.DictWriter(text, [field.name for field in fields(BillLine)], lineterminator="\n")
    table.writeheader()
    table.writerows(asdict(item) for item in items)
    return text.getvalue().encode()


def _manufactured(reducer: Reducer, cam_seat: float, sizes: Casing | None) -> Iterator[BillLine]:
    for name, part in made_parts(reducer, VISUAL_CHORD_ERROR, cam_seat, sizes).items():
        item = names.SLEEVE if name == names.PIN and reducer.design.ring.has_sleeves else name
        bored = _bored(reducer, sizes) if name == names.SHAFT else ""
        material = _material(reducer, material_part(reducer, name))
        yield BillLine(item, part.count, _extent(part) + bored, material, "made")


def _bought(reducer: Reducer, cam_seat: float, sizes: Casing | None) -> Iterator[BillLine]:
    yield from _pins(reducer, sizes)
    yield from _rollers(reducer)
    yield from _bearings(reducer, cam_seat)
    if sizes:
        yield from _of_casing(reducer, sizes)
    elif reducer.design.housing.support == "bolts":
        design = reducer.design
        size = f"head at most {_mm(2.0 * design.bolt_radius)} mm, circle {_mm(2.0 * design.bolt_circle_radius)} mm"
        screw = stock.bolt_under(2.0 * design.bolt_radius)
        yield BillLine("bolt", design.housing.bolts, size, "", "bought", screw.designation if screw else "")


def _of_casing(reducer: Reducer, sizes: Casing) -> Iterator[BillLine]:
    """List bearings of the output, screws, dowels and threaded inserts."""
    hub, places = sizes.hub, [place.part for place in casing_places(reducer, sizes)]
    yield BillLine(OUTPUT_BEARING, 2, _sizes_of(hub), "", "bought", hub.designation, BALLS_OF_HUB)
    flange = sizes.flange_bolt, flange_screw_length(sizes)
    screws = {SCREW: (sizes.screws.bolt, sizes.screws.length), FLANGE_SCREW: flange}
    if sizes.motor.tapped:
        screws[MOTOR_SCREW] = motor_screw(sizes.motor, sizes.wall)
    for item, (bolt, length) in screws.items():
        size = f"thread {_mm(bolt.thread)} x length {_mm(length)} mm"
        name = f"{bolt.designation} x {_mm(length)}"
        yield BillLine(item, places.count(item), size, "steel 8.8", "bought", name)
    bolt_and_motor = sizes.screws.bolt.thread, sizes.flange_bolt.thread, sizes.flange_bolt.thread, sizes.motor.thread
    for item, thread in zip((SCREW_INSERT, FLANGE_INSERT, LOAD_INSERT, MOTOR_INSERT), bolt_and_motor, strict=True):
        insert = insert_in(reducer, thread)
        if insert and item in places:
            size = f"hole {_mm(insert.hole)} x length {_mm(insert.length)} mm"
            yield BillLine(item, places.count(item), size, "brass", "bought", insert.designation)
    if dowel := sizes.dowel:
        size = _round(("diameter", 0.5 * dowel.diameter), length=dowel.length)
        yield BillLine(DOWEL, places.count(DOWEL), size, "steel", "bought", dowel.designation, PRESSED)


def _pins(reducer: Reducer, sizes: Casing | None) -> Iterator[BillLine]:
    """List ring pins, output pins and the shaft of several discs, which are round bars."""
    design = reducer.design
    ring, output, gear, shaft = design.ring, design.output, design.gear, design.shaft
    if ring.kind == "pin" and not is_printed(reducer, names.PIN):
        material = _material(reducer, names.PIN)
        if ring.has_sleeves:
            diameters = ("outside diameter", ring.pin_radius), ("bore", ring.sleeve_bore_radius)
            yield BillLine(names.SLEEVE, ring.teeth, _round(*diameters, length=gear.stack_width), material, "bought")
            core = sleeve_core_radius(reducer)
            yield _pin(PRESSED_PIN, ring.teeth, core, gear.stack_width, material, PRESSED)
        else:
            fit = FREE if ring.has_sockets else PRESSED
            yield _pin(names.PIN, ring.teeth, ring.pin_radius, gear.stack_width, material, fit)
    if not in_one_piece(reducer) and not is_printed(reducer, names.OUTPUT):
        length = output_pin_length(reducer)
        yield _pin(OUTPUT_PIN, output.pins, output.root_radius, length, _material(reducer, names.OUTPUT), PRESSED)
    if gear.discs > 1 and not is_printed(reducer, names.SHAFT):
        (drawn,) = parts(reducer)[names.SHAFT].prisms
        size = _round(("diameter", shaft.radius), length=drawn.height) + _bored(reducer, sizes)
        bar = f"ground bar {_mm(2.0 * shaft.radius)} h6" if 2.0 * shaft.radius in stock.bar_diameters() else ""
        yield BillLine(names.SHAFT, 1, size, _material(reducer, names.SHAFT), "bought", bar)


def _bored(reducer: Reducer, sizes: Casing | None) -> str:
    """Format diameter and depth of the shaft's bore for the motor's shaft; empty if there is none."""
    bore = motor_bore(reducer, sizes) if sizes else None
    if not bore:
        return ""
    radius, start, end = bore
    return f", bored {_mm(2.0 * radius)} x {_mm(end - start)} mm"


def _pin(item: str, count: int, radius: float, reach: float, material: str, fit: str) -> BillLine:
    """Return the line of round pins: of those in stock, which may stand in line or be cut, or of their own size."""
    in_stock = stock.pins(2.0 * radius, reach)
    if not in_stock:
        return BillLine(item, count, _round(("diameter", radius), length=reach), material, "bought")
    pin, in_line = in_stock
    size = _round(("diameter", radius), length=pin.length)
    if in_line * pin.length > reach + stock.ROUNDING:
        fit += f", cut to {_mm(reach / in_line)} mm"
    return BillLine(item, count * in_line, size, material, "bought", pin.designation, fit)


def _rollers(reducer: Reducer) -> Iterator[BillLine]:
    """List the rollers of the output pins: made where they turn on a core of their own, as none is in stock."""
    output, gear = reducer.design.output, reducer.design.gear
    if output.rollers:
        sizes = ("outside diameter", output.pin_radius), ("bore", output.root_radius)
        size, count = _round(*sizes, length=gear.face_width), output.pins * gear.discs
        if output.has_roller_parts:
            yield BillLine(names.ROLLER, count, size, _material(reducer, names.OUTPUT), "made")
        else:
            yield BillLine(names.ROLLER, count, size, "", "bought")


def _bearings(reducer: Reducer, cam_seat: float) -> Iterator[BillLine]:
    """List the bearings of the cams and of the shaft."""
    design = reducer.design
    gear, shaft = design.gear, design.shaft
    if gear.bearing == "rolling":
        in_stock = cam_bearing(reducer)
        if in_stock and cam_seat in (0.0, round(0.5 * in_stock[0].bore, 9)):
            bearing, count = in_stock
            size = _sizes_of(bearing)
            yield BillLine(CAM_BEARING, gear.discs * count, size, "", "bought", bearing.designation, _fit_of(bearing))
        else:
            bore = (("bore", cam_seat),) if cam_seat else ()
            size = _round(("outside diameter", gear.bore_radius), *bore, length=gear.face_width)
            yield BillLine(CAM_BEARING, gear.discs, size, "", "bought")
    if on_shaft := shaft_bearing(reducer):
        size, fit = _sizes_of(on_shaft), _fit_of(on_shaft)
        yield BillLine(SHAFT_BEARING, SHAFT_BEARINGS, size, "", "bought", on_shaft.designation, fit)
    else:
        size = _round(("bore", shaft.radius), length=bearing_width_of(reducer))
        yield BillLine(SHAFT_BEARING, SHAFT_BEARINGS, size, "", "bought")


def cam_bearing(reducer: Reducer) -> tuple[stock.StockBearing, int] | None:
    """Choose the bearing in stock for each cam, and how many stand side by side; none if none fits gear and cam."""
    design = reducer.design
    gear = design.gear
    flush = round(2.0 * (gear.eccentricity + design.shaft.radius), 9)
    wide_enough = [
        one
        for one in stock.bearings_outside(2.0 * gear.bore_radius)
        if one.bore > flush or (gear.discs == 1 and one.bore == flush)
    ]
    return stock.side_by_side(wide_enough, gear.face_width) if gear.bearing == "rolling" else None


def shaft_bearing(reducer: Reducer) -> stock.StockBearing | None:
    """Choose the bearing in stock of which two hold the shaft; none if none has its size."""
    return next(iter(stock.bearings_on(2.0 * reducer.design.shaft.radius, bearing_width_of(reducer))), None)


def _fit_of(bearing: stock.StockBearing) -> str:
    return BALLS if bearing in stock.ball_bearings() else NEEDLES


def _sizes_of(bearing: stock.StockBearing) -> str:
    sizes = ("outside diameter", 0.5 * bearing.outside), ("bore", 0.5 * bearing.bore)
    return _round(*sizes, length=bearing.width)


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
