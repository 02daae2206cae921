"""``cycloid-mj export``: the parts of a design as files for CAD and printing."""

import math
from collections import Counter
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError, warn
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.result import Table
from cycloid_mj.cli.delivery import Destination, claim_page, deliver
from cycloid_mj.cli.flags import COMMON, FLAT, CommonFlags, DesignOptions, whole, within
from cycloid_mj.cli.outfile import folder
from cycloid_mj.cli.ranges import RANGES
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.reducer.sockets import require_one_ring

if TYPE_CHECKING:
    from cycloid_mj.parts.export import Casing, Export, Motor, PrintPlate
    from cycloid_mj.parts.export.print_files import PrintSettings

EXAMPLES = """Examples:
  cycloid-mj export --design pin --format stl
  cycloid-mj export --design nonpin --format dxf --out drawings
  cycloid-mj export --design my.toml --set clearance.tooth_um=20 --format step
  cycloid-mj export --design printed --plate --offset-um 80 --out print"""

FormatFlag = Annotated[
    Literal["stl", "obj", "dxf", "svg", "step"],
    Parameter(
        name="--format",
        help="stl, obj: meshes; dxf: exact outlines with one spline per lobe (extra dxf; some programs ignore splines: "
        "add --polylines, or use svg); svg: outlines as closed paths; step: solids (extra cad: "
        "pip install 'cycloid-mj[cad]'). All in mm. Default: stl.",
    ),
]
PolylinesFlag = Annotated[
    bool,
    Parameter(
        negative=(),
        help="With --format dxf: closed polylines (LWPOLYLINE) within --chord-error-um, and circles, instead of "
        "splines, for programs that ignore splines.",
    ),
]
OutFlag = Annotated[
    str | None,
    Parameter(
        metavar="DIR",
        help="Folder of the parts; it is created if it does not exist. Default: <design>-<format>.",
    ),
]
ChordFlag = Annotated[
    float,
    Parameter(
        metavar="X",
        validator=within(*RANGES.chord_error_um),
        help="Maximum distance between straight edges and the true outline [um], for stl, obj, svg and "
        "--polylines. Default: 1.",
    ),
]
PlateFlag = Annotated[
    bool,
    Parameter(
        negative=(),
        help="Also write plate.stl and plate.3mf, all plastic parts (all manufactured parts, if none is of "
        "plastic) next to each other and flat on z = 0 for a printer, in plate.3mf with their names; "
        "and bom.csv, the bill of materials with item, count, size, material, made or "
        "bought, designation, fit and mass.",
    ),
]
AssemblyFlag = Annotated[
    bool,
    Parameter(
        negative=(),
        help="Also write assembly.step (every part in its position at crank angle 0, with name and colour "
        "and the design's own clearances, without --offset-um; requires the extra cad), exploded.png "
        "(the drive assembled and exploded) and assembly.txt (assembly instructions in ten steps).",
    ),
]
OffsetFlag = Annotated[
    float,
    Parameter(
        metavar="X",
        validator=within(*RANGES.offset_um),
        help="Increase of every clearance of the outlines [um], to compensate for material that the printer "
        "adds; press fits are unchanged. Default: 0.",
    ),
]
MotorFlag = Annotated[
    Literal["auto", "nema17", "nema23", "nema34", "bldc16", "bldc19", "bldc25", "circle"],
    Parameter(
        help="Motor: nema17, nema23 or nema34; bldc16, bldc19 or bldc25 (four M3 on a circle of that diameter); or "
        "circle (a bolt circle, no motor shaft). The input shaft gets a bore for the motor shaft if it is thick "
        "enough; --plate and --assembly add the motor flange. Default: auto, the smallest NEMA frame that is strong "
        "enough for drive.torque_nm at drive.speed_rpm and fits, else circle."
    ),
]
CamFlag = Annotated[
    float | None,
    Parameter(
        name="--cam-bearing-bore-mm",
        metavar="X",
        validator=within(*RANGES.cam_bearing_bore_mm),
        help="Bore of the rolling bearing on the cam, from its catalogue [mm]; with --plate, the cams have "
        "this diameter. Default: the bore of the stock bearing with the outer diameter 2 "
        "gear.bore_radius_mm; without one, 2 gear.bore_radius_mm.",
    ),
]


BedFlag = Annotated[
    str | None,
    Parameter(
        metavar="LxW",
        help="Size of the printer's bed [mm], such as 220x220: with --plate, as many plates as the parts need, "
        "plate_1, plate_2, ...; a part that is larger is an error. Default: one plate, as large as needed.",
    ),
]
CoverMaterialFlag = Annotated[
    str,
    Parameter(
        metavar="NAME",
        help="Metal of both covers, of the library of materials, such as 'aluminium 7075' or 'tempered steel', for a "
        "ring of a metal. Default: auto, aluminium 6061 on a ring of steel; plastic as the ring.",
    ),
]
ArcsFlag = Annotated[
    float | None,
    Parameter(
        name="--arcs",
        metavar="TOL",
        validator=within(*RANGES.chord_error_um),
        help="With --format dxf: arcs within this distance of the outline [um] instead of splines, for machines that "
        "mill arcs only. Default: splines.",
    ),
]
DrawingsFlag = Annotated[
    bool,
    Parameter(
        negative=(),
        help="Also write drawings.pdf, a page for each manufactured part with its section, dimensions, fits, threads, "
        "roughness, hardness and datums, and NAME-drawing.dxf of each.",
    ),
]


def _motor_flag(what: str) -> Parameter:
    return Parameter(metavar="X", validator=within(*RANGES.motor_mm), help=f"{what} [mm]. Default: that of --motor.")


@dataclass(frozen=True, kw_only=True)
class MotorInterface:
    """Motor, and dimensions that replace those of its interface."""

    motor: MotorFlag = "auto"
    motor_circle_mm: Annotated[float | None, _motor_flag("Diameter of the bolt circle of the motor")] = None
    motor_thread_mm: Annotated[float | None, _motor_flag("Thread of the motor screws, such as 3 for M3")] = None
    motor_pilot_mm: Annotated[float | None, _motor_flag("Diameter of the pilot of the motor")] = None
    motor_shaft_mm: Annotated[float | None, _motor_flag("Diameter of the motor shaft")] = None
    motor_shaft_length_mm: Annotated[float | None, _motor_flag("Length of the motor shaft from its flange")] = None
    motor_screws: Annotated[
        int | None,
        Parameter(
            metavar="N",
            converter=whole,
            validator=within(*RANGES.motor_screws),
            help="Number of motor screws. Default: that of --motor.",
        ),
    ] = None

    def chosen(self) -> "Motor":
        """Return the name of the motor, or its interface with other dimensions.

        Raises
        ------
        UsageError
            The bolt circle or the thread is missing, or no screw in stock has the thread.
        """
        from cycloid_mj.design import stock
        from cycloid_mj.parts.export.motors import MOTORS, MotorFlange

        diameters = {"circle": self.motor_circle_mm, "pilot": self.motor_pilot_mm, "shaft": self.motor_shaft_mm}
        lengths = {"thread": self.motor_thread_mm, "shaft_length": self.motor_shaft_length_mm}
        changes: dict[str, Any] = {key: 0.5e-3 * value for key, value in diameters.items() if value is not None}
        changes |= {key: 1e-3 * value for key, value in lengths.items() if value is not None}
        if self.motor_screws is not None:
            changes["screws"] = self.motor_screws
        if not changes:
            return self.motor
        own = MotorFlange("own bolt circle", 0.6 * changes.get("circle", 0.0), 0.0, 0.0)
        motor = replace(MOTORS.get(self.motor, own), **changes)
        if not (motor.circle and motor.thread):
            raise UsageError(
                "a motor of another size needs both --motor-circle-mm and --motor-thread-mm: give both, or choose a "
                "motor with --motor"
            )
        threads = [bolt.thread for bolt in stock.bolts()]
        if not any(abs(thread - motor.thread) < stock.ROUNDING for thread in threads):
            sizes = ", ".join(f"{1e3 * thread:g}" for thread in threads)
            raise UsageError(
                f"--motor-thread-mm {1e3 * motor.thread:g} is not a thread in stock: choose one of {sizes} mm"
            )
        return motor


MOTOR = MotorInterface()


def export(
    chosen: Annotated[DesignOptions, FLAT],
    *,
    format_: FormatFlag = "stl",
    out: OutFlag = None,
    polylines: PolylinesFlag = False,
    chord_error_um: ChordFlag = 1.0,
    plate: PlateFlag = False,
    assembly: AssemblyFlag = False,
    offset_um: OffsetFlag = 0.0,
    interface: Annotated[MotorInterface, FLAT] = MOTOR,
    cam_bearing_bore_mm: CamFlag = None,
    bed: BedFlag = None,
    cover_material: CoverMaterialFlag = "auto",
    arcs: ArcsFlag = None,
    drawings: DrawingsFlag = False,
    delivery: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Write the parts of a design for CAD or 3-D printing.

    Parts: housing, shaft, gear (the disc), output, and pin (one of N) if the ring has pins. A ring in two halves is
    housing_1 and housing_2, with pins of half the length. Several discs are gear_1, gear_2, ..., on a crank of shaft,
    cam_1, cam_2, ... and spacer. Rollers of output pins are output_roller (one for each pin and disc) if
    output.core_radius_mm is set; otherwise pin and roller are one cylinder of the output. The outlines contain the
    clearances of the design; the actual clearances are measured and reported. A part that is not watertight, or has
    a wrong volume or clearance, is an error, and nothing is written.

    With --plate or --assembly, the parts can be assembled: the ring gets holes for screws and dowels, and a cover on
    each side (one with motor flange and shaft bearing, one with both bearings of the output hub, to which the output
    flange is screwed). If these do not fit, a warning states the reason and the mechanism is written without them.
    On the plate, each part stands on its larger end; round parts are included if they are of plastic, otherwise they
    are bought; bought output pins are pressed into bores. For plastics, coupon_block.stl and coupon_pin.stl are added:
    the first of three sockets in which the pin turns gives --offset-um. Overhanging plastic faces get break-away
    supports, 0.2 mm below and 0.4 mm next to them; ends of holes up to 8 mm are bridged. Thin walls, small holes and
    faces that cannot be supported are warnings.

    JSON: files, clearances (pair, asked, least, most [m]), offset [m]; with --plate also plate (file, size [m],
    parts: name -> count), plates (the same of each), bom (item, count, size, material, made_or_bought, designation,
    fit, mass_kg) and consumables.
    """
    from cycloid_mj.parts.export import drive_files, widen_clearances
    from cycloid_mj.parts.export import export as exported
    from cycloid_mj.parts.export.print_files import PrintSettings, stock_cam_seat

    _require_flags(format_, polylines=polylines, arcs=arcs, plate=plate, bore=cam_bearing_bore_mm, bed=bed)
    bed_size = _bed_size(bed)
    design, offset, chord_error = chosen.resolve_checked().at_reference, offset_um * 1e-6, chord_error_um * 1e-6
    reducer, motor = reducer_of(design), interface.chosen()
    _require_layout(reducer, plate=plate, drawings=drawings)
    drive = plate or assembly or drawings
    if drive:
        require_one_ring(reducer, "print plates, assemblies and drawings")
    seat = round(0.5e-3 * cam_bearing_bore_mm, 9) if cam_bearing_bore_mm else stock_cam_seat(reducer)
    arc_error = None if arcs is None else arcs * 1e-6
    outlines = exported(
        design,
        format_,
        chord_error,
        offset,
        motor,
        polylines=polylines,
        cover_material=cover_material,
        arcs=arc_error,
    )
    sizes = _casing(reducer, motor, cover_material) if drive else None
    parts = dict(outlines.files)
    if sizes:
        wide = widen_clearances(reducer, offset)
        parts |= drive_files(wide, format_, sizes, chord_error, seat, polylines=polylines, arcs=arc_error)
    settings = PrintSettings(chord_error, offset, seat, bed_size)
    printed = _plate(reducer, sizes, settings) if plate else None
    if printed:
        parts |= printed.files
    if assembly:
        parts |= _assembly(reducer, sizes)
    if drawings and sizes:
        parts |= _drawings(reducer, sizes)
    into = folder(f"{design.name}-{format_}" if out is None else out, "the parts", parts, delivery.force)
    stem = f"{design.name}-parts"
    place = Destination(stem, into, claim_page(delivery, stem, into))
    clearances = [asdict(clearance) for clearance in outlines.clearances]
    result = {"files": place.paths(parts), "clearances": clearances, "offset": offset}
    outcome = Outcome(
        title=f"parts: {design.name}",
        text=place.paths(parts),
        tables=[_clearance_table(outlines, offset), *(printed.tables if printed else ())],
        summary=printed.notes if printed else [],
        files=parts,
        result=result | (printed.result(into) if printed else {}),
        filed=False,
    )
    return deliver(outcome, place, delivery)


def _require_flags(
    file_format: str, *, polylines: bool, arcs: float | None, plate: bool, bore: float | None, bed: str | None
) -> None:
    """Raise an error of usage for options that the others rule out."""
    if bore is not None and not plate:
        raise UsageError("--cam-bearing-bore-mm applies to --plate only: add --plate, or remove --cam-bearing-bore-mm")
    if bed is not None and not plate:
        raise UsageError("--bed applies to --plate only: add --plate, or remove --bed")
    if (polylines or arcs is not None) and file_format != "dxf":
        name = "--polylines" if polylines else "--arcs"
        raise UsageError(
            f"{name} applies to --format dxf only, not to {file_format}: remove {name}, or use --format dxf"
        )
    if polylines and arcs is not None:
        raise UsageError("--polylines and --arcs cannot be used together: remove one of the two")


def _require_layout(reducer: Reducer, *, plate: bool, drawings: bool) -> None:
    """Raise an error of usage for options that the layout of the reducer does not support."""
    if isinstance(reducer, RvReducer) and (plate or drawings):
        name = "--plate" if plate else "--drawings"
        raise UsageError(f'{name} does not support layout = "rv" ({reducer.design.name}): remove it')


def _bed_size(text: str | None) -> tuple[float, float] | None:
    """Return length and width of a bed [m].

    Raises
    ------
    UsageError
        The text is not two positive numbers with an x between them.
    """
    if text is None:
        return None
    try:
        length, width = (1e-3 * float(side) for side in text.lower().split("x"))
    except ValueError:
        length = width = 0.0
    if not (0.0 < length < math.inf and 0.0 < width < math.inf):
        raise UsageError(
            f"--bed {text} is not a valid size: give length and width in mm, both greater than 0, e.g. --bed 220x220"
        )
    return length, width


def _clearance_table(outlines: "Export", offset: float) -> Table:
    rows = tuple(
        (
            clearance.pair,
            *(f"{1e6 * value:.4f}" for value in (clearance.asked, offset, clearance.least, clearance.most)),
        )
        for clearance in outlines.clearances
    )
    return Table("clearance in the outlines [um]", ("pair", "asked for", "offset", "least", "most"), rows)


@dataclass(frozen=True)
class _Printed:
    """What --plate adds: plates by file, files, notes, tables and entries of the JSON object."""

    plates: "dict[str, PrintPlate]"
    files: dict[str, bytes]
    notes: list[str]
    tables: tuple[Table, ...]
    entries: dict[str, Any]

    def result(self, into: Path) -> dict[str, Any]:
        """Return the entries of the JSON object for files in a folder."""
        each = [
            {"file": str(into / file), "size": item.size, "parts": item.counts} for file, item in self.plates.items()
        ]
        return {"plate": each[0], "plates": each, **self.entries}


def _plate(reducer: Reducer, sizes: "Casing | None", settings: "PrintSettings") -> _Printed:
    """Lay out the plates and the bill; warn of what is not in stock and of what a printer cannot make."""
    from cycloid_mj.life.joints import tightening_torques
    from cycloid_mj.parts.export.print_files import print_files

    printed = print_files(reducer, sizes, settings, tightening_torques(reducer) if sizes else None)
    warn(reducer.design.name, printed.warnings)
    counts: Counter[str] = sum((Counter(one.counts) for one in printed.plates.values()), Counter())
    columns = ("item", "count", "size", "material", "made or bought", "designation")
    parts = (item for item in printed.bill if item.made_or_bought != "consumable")  # these are notes
    lines = tuple(tuple(str(value) for value in asdict(item).values())[:-2] for item in parts)
    tables = (
        Table("parts on the plate", ("part", "count"), tuple((part, str(count)) for part, count in counts.items())),
        Table("bill of materials", columns, lines, words=(2, 3, 4, 5)),
    )
    entries = {"bom": [asdict(item) for item in printed.bill], "consumables": list(printed.consumables)}
    by_file = {f"{stem}.stl": one for stem, one in printed.plates.items()}
    return _Printed(by_file, dict(printed.files), list(printed.notes), tables, entries)


def _casing(reducer: Reducer, motor: "Motor", cover_material: str) -> "Casing | None":
    """Return the sizes of covers and flanges; warn if they do not fit, and of what their joints do not allow.

    An RV reducer has none.
    """
    from cycloid_mj.parts.export import casing_or_none
    from cycloid_mj.parts.export.rules import broken_rules

    if isinstance(reducer, RvReducer):
        return None
    sizes, reason = casing_or_none(reducer, motor, cover_material)
    if sizes:
        warn(reducer.design.name, broken_rules(reducer, sizes))
    else:
        warn(reducer.design.name, (f"without covers: {reason}",))
    return sizes


def _drawings(reducer: Reducer, sizes: "Casing") -> dict[str, bytes]:
    """Draw all manufactured parts: one PDF, and a DXF of each."""
    from cycloid_mj.plots.drawings import drawing_files

    return drawing_files(reducer, sizes)


def _assembly(reducer: Reducer, sizes: "Casing | None") -> dict[str, bytes]:
    """Encode the assembly, and where there are covers its picture and the order of its steps."""
    from cycloid_mj.plots.exploded import assembly_files

    return assembly_files(reducer, sizes)
