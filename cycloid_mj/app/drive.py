"""The drive with its covers for a motor: size, bill of materials, order of assembly, and all files to build it."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, cast, get_args

from cycloid_mj.app.limits import REQUESTS
from cycloid_mj.base.errors import CycloidError, DesignError, UsageError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.life.joints import tightening_torques
from cycloid_mj.parts.export import (
    CHORD_ERROR,
    BillLine,
    assembly_order,
    assembly_step,
    bill,
    drive_files,
    export,
    widen_clearances,
)
from cycloid_mj.parts.export.bill import consumables, describe_consumable
from cycloid_mj.parts.export.casing import Casing, casing_or_none
from cycloid_mj.parts.export.casing_rules import is_plastic, is_printed
from cycloid_mj.parts.export.motors import MOTORS, MotorName
from cycloid_mj.parts.export.print_files import PrintSettings, print_files, stock_cam_seat
from cycloid_mj.parts.export.printing import material_part
from cycloid_mj.reducer import Reducer, reducer_of

MOTOR_WORDS: Mapping[str, str] = {
    "auto": "smallest NEMA frame that suits",
    **{name: motor.name for name, motor in MOTORS.items()},
    "circle": "bolt circle only, coupled shaft",
}
"""Motors of the page and their words."""

BEDS = ("", "180x180", "220x220", "256x256", "300x300")
"""Beds of printers [mm]; empty: one plate, as large as needed."""


@dataclass(frozen=True)
class PriceRule:
    """Price of a part: a rate for its mass [EUR/kg], and a minimum [EUR]."""

    rate: float
    minimum: float


PRICES: Mapping[str, PriceRule] = {
    "printed": PriceRule(30.0, 0.1),
    "made": PriceRule(300.0, 40.0),
    "bearing": PriceRule(100.0, 3.0),
    "pin": PriceRule(50.0, 0.3),
    "screw": PriceRule(20.0, 0.1),
}
"""Kind of part -> its price in small numbers, assumed: filament; turned, milled or ground parts of a workshop; rolling
bearings; needle rollers, dowels and bars; screws and threaded inserts. Good for a class, not for a quotation."""

PRICE_CLASSES = ((1.0, "below 1 EUR"), (10.0, "1 to 10 EUR"), (100.0, "10 to 100 EUR"), (math.inf, "above 100 EUR"))
"""Upper limits [EUR] of the price of a piece, and their words."""


@dataclass(frozen=True)
class BuildOptions:
    """Choices of the page that are not in the design file.

    Attributes
    ----------
    motor
        Motor whose flange and shaft the drive fits, a key of `MOTOR_WORDS`.
    offset
        Printer offset: increase of all clearances of printed parts [m].
    bed
        Length and width of the printer's bed [m]; None: one plate, as large as needed.
    """

    motor: MotorName = "auto"
    offset: float = 0.0
    bed: tuple[float, float] | None = None


def parse_options(content: Any) -> BuildOptions:
    """Parse the options in a request of the page: ``motor``, ``offset_um`` [um] and ``bed`` (in `BEDS`).

    Missing options have the defaults of `BuildOptions`. If `content` is not a mapping, all options have them.

    Raises
    ------
    UsageError
        A value is not among those allowed.
    """
    options = content if isinstance(content, Mapping) else {}
    motor, offset, bed = options.get("motor") or "auto", options.get("offset_um") or 0.0, options.get("bed") or ""
    if motor not in get_args(MotorName):
        raise UsageError(f"unknown motor {motor!r}: choose one of {', '.join(MOTOR_WORDS)}")
    if type(offset) not in (int, float) or not 0.0 <= offset <= REQUESTS.offset_um:
        raise UsageError(
            f"the printer offset is {offset!r} um, which is out of range: choose a value from 0 to "
            f"{REQUESTS.offset_um:g} um"
        )
    if bed not in BEDS:
        raise UsageError(f"unknown printer bed {bed!r}: choose one of {', '.join(BEDS[1:])} (length x width in mm)")
    length, _, width = bed.partition("x")
    return BuildOptions(
        cast("MotorName", motor), 1e-6 * offset, (1e-3 * float(length), 1e-3 * float(width)) if bed else None
    )


def reducer_at_reference(reducer: Reducer) -> Reducer:
    """Return the reducer with the sizes of manufactured parts: at 20 °C, with an undivided ring without preload.

    Raises
    ------
    DesignError
        The design file belongs to a log. It states the sizes of warm parts, from which those at 20 °C do not follow.
    """
    design = reducer.design.at_reference
    if design.ring.halves > 1:
        design = design.but(ring={"halves": 1, "preload": 0.0})
    return reducer if design == reducer.design else reducer_of(design)


def describe_drive(reducer: Reducer, options: BuildOptions) -> dict[str, Any]:
    """Describe the drive with its covers for the motor of `options` as JSON values.

    Returns
    -------
    dict
        ``bill`` (rows of the bill of materials), ``mass_kg``, ``consumables``, ``order`` (steps of the assembly) and
        ``printed`` (whether the parts are of plastic); with covers also ``motor``, ``diameter_mm`` and ``length_mm``.
        If the covers do not fit, ``reason`` says why, the bill is that of the mechanism, and there are no consumables
        and no order.

    Raises
    ------
    DesignError
        The chosen motor does not fit, or a part cannot be manufactured.
    """
    reducer = reducer_at_reference(reducer)
    casing, reason = casing_or_none(reducer, options.motor)
    rows = bill_rows(reducer, casing)
    needs = consumables(reducer, casing, tightening_torques(reducer)) if casing else ()
    description = {
        "reason": reason,
        "bill": rows,
        "mass_kg": sum(row["mass_g"] for row in rows) / 1000.0,
        "consumables": list(map(describe_consumable, needs)),
        "order": list(assembly_order(reducer, casing)) if casing else [],
        "printed": is_plastic(reducer),
    }
    if casing:
        lower_end, upper_end = casing.ends
        description |= {
            "motor": casing.motor.name,
            "diameter_mm": 2.0 * MILLIMETRES * casing.outer,
            "length_mm": MILLIMETRES * (upper_end - lower_end),
        }
    return description


def bill_rows(reducer: Reducer, casing: Casing | None) -> list[dict[str, Any]]:
    """Return the bill of materials with source (printed, bought or made), mass [g] and price class of each line."""
    lines = bill(reducer, stock_cam_seat(reducer), casing, tightening_torques(reducer) if casing else None)
    return [_bill_row(reducer, line) for line in lines]


def _bill_row(reducer: Reducer, line: BillLine) -> dict[str, Any]:
    """Convert a row of the bill of materials to JSON values.

    ``source`` is "printed", "bought" or "made"; ``mass_g`` [g] is the mass of all pieces of the row; ``price`` is the
    price class of a single piece in words (`PRICE_CLASSES`). The other keys are those of the row, `line`.
    """
    source = "bought"
    if line.made_or_bought == "made":
        source = "printed" if is_printed(reducer, material_part(reducer, line.item)) else "made"
    rule = PRICES[_price_kind(line.item, source)]
    price_of_piece = max(rule.minimum, rule.rate * line.mass_kg / max(line.count, 1))
    return {
        "item": line.item.replace("_", " "),
        "count": line.count,
        "size": line.size,
        "material": line.material,
        "source": source,
        "designation": line.designation,
        "fit": line.fit,
        "mass_g": 1000.0 * line.mass_kg,
        "price": next(words for limit, words in PRICE_CLASSES if price_of_piece < limit),
    }


def _price_kind(item: str, source: str) -> str:
    """Return the kind of a part in `PRICES`."""
    if source != "bought":
        return source
    if item.endswith("bearing"):
        return "bearing"
    return "screw" if "screw" in item or item == "bolt" else "pin"


def build_files(reducer: Reducer, options: BuildOptions, on_step: Callable[[str, float], None]) -> dict[str, bytes]:
    """Create all files to build a drive, as ``cycloid-mj export --plate --assembly --drawings`` does.

    They are plates and test coupon, meshes of the printed parts, bill of materials, drawings, order of assembly with an
    exploded view, and the assembly in STEP.

    Parameters
    ----------
    options
        Motor, printer offset and bed.
    on_step
        Called with a description of the next step and the completed fraction of the work, 0 to 1.

    Returns
    -------
    dict
        Path in the zip file -> content. Meshes are written for plastic parts only. ``notes.txt`` lists the warnings,
        and the STEP assembly if it is missing because the extra ``cad`` is not installed.

    Raises
    ------
    DesignError
        The chosen motor does not fit, or a part cannot be manufactured.
    CycloidError
        No covers fit the design, or an extra that a drawing needs is not installed.
    """
    from cycloid_mj.plots.drawings import drawing_files
    from cycloid_mj.plots.exploded import ASSEMBLY, instruction_files

    reducer = reducer_at_reference(reducer)
    casing, reason = casing_or_none(reducer, options.motor)
    if casing is None:
        raise CycloidError(
            f"{reducer.design.name}: the files of the complete drive cannot be written, because no covers fit: "
            f"{reason}. Individual parts can still be downloaded"
        )
    settings = PrintSettings(CHORD_ERROR, options.offset, stock_cam_seat(reducer), options.bed)
    on_step("laying out the plate and the bill", 0.0)
    print_result = print_files(reducer, casing, settings, tightening_torques(reducer))
    files, notes = dict(print_result.files), [*print_result.notes, *print_result.warnings]
    if is_plastic(reducer):
        on_step("meshing the parts", 0.3)
        widened_reducer = widen_clearances(reducer, options.offset)
        meshes = export(reducer.design, "stl", CHORD_ERROR, options.offset, options.motor).files
        meshes |= drive_files(widened_reducer, "stl", casing, CHORD_ERROR, settings.cam_seat)
        files |= {f"stl/{name}": content for name, content in meshes.items()}
    on_step("drawing the parts", 0.5)
    files |= {f"drawings/{name}": content for name, content in drawing_files(reducer, casing).items()}
    on_step("drawing the exploded view", 0.75)
    files |= instruction_files(reducer, casing)
    on_step("modelling the assembly in STEP", 0.8)
    try:
        files[ASSEMBLY] = assembly_step(reducer, 0.0, casing)
    except DesignError:
        raise
    except CycloidError as error:  # the extra cad is not installed: the drive can be built without it
        notes.append(f"{ASSEMBLY} is missing: {error}")
    return files | {"notes.txt": "".join(f"{note}\n" for note in notes).encode()}
