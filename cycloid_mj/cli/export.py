"""``cycloid-mj export``: the parts of a design as files for CAD and printing."""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError, warn
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.result import Table
from cycloid_mj.cli.delivery import Destination, claim_page, deliver
from cycloid_mj.cli.flags import COMMON, FLAT, CommonFlags, DesignOptions, integer_flag, number_flag
from cycloid_mj.cli.outfile import claim_folder
from cycloid_mj.cli.ranges import RANGES
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.reducer.sockets import require_one_ring

if TYPE_CHECKING:
    from cycloid_mj.parts.export import Casing, Export, Format, Motor, PrintPlate
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
    number_flag(
        "Maximum distance between straight edges and the true outline [um], for stl, obj, svg and "
        "--polylines. Default: 1.",
        RANGES.chord_error_um,
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
        "(the drive assembled and exploded) and assembly.txt (assembly instructions in ten steps). For an RV reducer: "
        "assembly.step and bom.csv, the bill of materials.",
    ),
]
OffsetFlag = Annotated[
    float,
    number_flag(
        "Increase of every clearance of the outlines [um], to compensate for material that the printer "
        "adds; press fits are unchanged. Default: 0.",
        RANGES.offset_um,
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
    number_flag(
        "Bore of the rolling bearing on the cam, from its catalogue [mm]; with --plate, the cams have "
        "this diameter. Default: the bore of the stock bearing with the outer diameter 2 "
        "gear.bore_radius_mm; without one, 2 gear.bore_radius_mm.",
        RANGES.cam_bearing_bore_mm,
        name="--cam-bearing-bore-mm",
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
        help="Material of both covers, if the ring is of metal: a metal of the material library, such as "
        "'aluminium 7075' or 'tempered steel'. Default: auto, which is aluminium 6061 on a ring of a heavier metal "
        "such as steel, and the material of the ring otherwise.",
    ),
]
ArcsFlag = Annotated[
    float | None,
    number_flag(
        "With --format dxf: arcs within this distance of the outline [um] instead of splines, for machines that "
        "mill arcs only. Default: splines.",
        RANGES.chord_error_um,
        name="--arcs",
        metavar="TOL",
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


def _motor_flag(dimension: str) -> Parameter:
    return number_flag(f"{dimension} [mm]. Default: that of --motor.", RANGES.motor_mm)


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
        integer_flag("Number of motor screws. Default: that of --motor.", RANGES.motor_screws),
    ] = None

    def choose_motor(self) -> "Motor":
        """Return the motor of the flags: the name of ``--motor``, or a `MotorFlange` if a flag sets a dimension.

        Dimensions without a flag are those of ``--motor``. With the names "auto" and "circle", which have no
        dimensions, the flange is a custom bolt circle: without flags for them, the pilot has 0.6 times the diameter of
        the circle, and there is no motor shaft.

        Raises
        ------
        UsageError
            A custom bolt circle lacks its diameter or the thread, or no screw in stock has the thread.
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
        custom = MotorFlange("own bolt circle", 0.6 * changes.get("circle", 0.0), 0.0, 0.0)
        motor = replace(MOTORS.get(self.motor, custom), **changes)
        if not (motor.circle and motor.thread):
            raise UsageError(
                "a custom motor size needs both --motor-circle-mm and --motor-thread-mm: give both, or choose a listed "
                "motor with --motor"
            )
        threads = [bolt.thread for bolt in stock.bolts()]
        if not any(abs(thread - motor.thread) < stock.ROUNDING for thread in threads):
            sizes = ", ".join(f"{1e3 * thread:g}" for thread in threads)
            raise UsageError(
                f"--motor-thread-mm {1e3 * motor.thread:g} is not an available thread size: choose one of {sizes} mm"
            )
        return motor


MOTOR = MotorInterface()


@dataclass(frozen=True, kw_only=True)
class ExportFlags:
    """Flags of an export: its contents and their accuracy."""

    polylines: PolylinesFlag = False
    chord_error_um: ChordFlag = 1.0
    plate: PlateFlag = False
    assembly: AssemblyFlag = False
    offset_um: OffsetFlag = 0.0
    interface: Annotated[MotorInterface, FLAT] = MOTOR
    cam_bearing_bore_mm: CamFlag = None
    bed: BedFlag = None
    cover_material: CoverMaterialFlag = "auto"
    arcs: ArcsFlag = None
    drawings: DrawingsFlag = False

    @property
    def offset(self) -> float:
        """Increase of every clearance [m]."""
        return 1e-6 * self.offset_um

    @property
    def chord_error(self) -> float:
        """Largest distance between straight edges and the outline [m]."""
        return 1e-6 * self.chord_error_um

    @property
    def arc_error(self) -> float | None:
        """Largest distance between arcs and the outline [m]; None for splines."""
        return None if self.arcs is None else 1e-6 * self.arcs

    @property
    def has_casing(self) -> bool:
        """True if files of the whole drive, with covers and flanges, are requested."""
        return self.plate or self.assembly or self.drawings

    def require_consistent(self, file_format: str) -> None:
        """Raise UsageError for a flag that needs another flag or file format, or excludes another flag.

        `file_format` is the value of ``--format``. For example, ``--bed`` needs ``--plate``, and ``--arcs`` the format
        dxf.
        """
        if self.cam_bearing_bore_mm is not None and not self.plate:
            raise UsageError(
                "--cam-bearing-bore-mm applies only with --plate: add --plate, or remove --cam-bearing-bore-mm"
            )
        if self.cover_material != "auto" and not self.has_casing:
            raise UsageError(
                "--cover-material applies only with --plate, --assembly or --drawings: add one of them, or remove "
                "--cover-material"
            )
        if self.bed is not None and not self.plate:
            raise UsageError("--bed applies only with --plate: add --plate, or remove --bed")
        if (self.polylines or self.arcs is not None) and file_format != "dxf":
            name = "--polylines" if self.polylines else "--arcs"
            raise UsageError(
                f"{name} applies only with --format dxf, not with {file_format}: remove {name}, or use --format dxf"
            )
        if self.polylines and self.arcs is not None:
            raise UsageError("--polylines and --arcs cannot be used together: remove one of the two")

    def require_supported(self, reducer: Reducer) -> None:
        """Raise UsageError for a flag that does not support the layout of the reducer, such as RV."""
        if not isinstance(reducer, RvReducer):
            return
        if self.plate:
            raise UsageError(
                f'--plate does not support layout = "rv" ({reducer.design.name}): an RV reducer has no printed casing '
                "with covers, and its cranks and gears are steel parts. Use --format stl without --plate, which "
                "writes a file for each part"
            )
        if self.interface != MOTOR or self.cover_material != "auto":
            raise UsageError(
                f'--motor, its dimensions and --cover-material do not support layout = "rv" ({reducer.design.name}): '
                "an RV reducer has neither a motor flange nor covers. Remove these flags"
            )

    def print_settings(self, reducer: Reducer) -> "PrintSettings":
        """Return accuracy, offset, seat of the cam bearing and bed size of a print plate [m]."""
        from cycloid_mj.parts.export.print_files import PrintSettings, stock_cam_seat

        bore = self.cam_bearing_bore_mm
        seat_radius = round(0.5e-3 * bore, 9) if bore else stock_cam_seat(reducer)
        return PrintSettings(self.chord_error, self.offset, seat_radius, _bed_size(self.bed))


EXPORT = ExportFlags()


def export(
    design_options: Annotated[DesignOptions, FLAT],
    *,
    format_: FormatFlag = "stl",
    out: OutFlag = None,
    flags: Annotated[ExportFlags, FLAT] = EXPORT,
    output_flags: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Write the parts of a design for CAD or 3-D printing.

    Parts are housing, shaft, gear (the disc), output, and pin if the ring has pins. A ring in two halves is housing_1
    and housing_2. Several discs are gear_1, gear_2, ..., on a crank of shaft, cam_1, cam_2, ... and spacer. With
    output.core_radius_mm, the rollers of the output pins are output_roller; otherwise pin and roller are one cylinder.
    The outlines contain the clearances of the design, which are measured and printed. If a part is not watertight, or
    has a wrong volume or clearance, the command fails and writes nothing.

    --plate and --assembly complete the drive: the ring gets holes for screws and dowels and a cover on each side. One
    cover has the motor flange and the shaft bearing, the other both bearings of the output hub. If covers do not fit, a
    warning states the reason, and only the mechanism is written.

    On a plate, each part stands on its larger end. Round parts of metal are not printed but bought. For plastics, a
    test coupon is added (coupon_block.stl, coupon_pin.stl): the first socket in which the pin turns states the value
    for --offset-um. Overhanging faces get break-away supports, 0.2 mm below and 0.4 mm next to them; ends of holes up
    to 8 mm are bridged. Thin walls, small holes and faces that cannot be supported cause warnings.

    JSON: files, clearances (pair, asked, least, most [m]), offset [m]; with --plate also plate (file, size [m], parts:
    name -> count), plates (the same of each), bom (item, count, size, material, made_or_bought, designation, fit,
    mass_kg) and consumables.
    """
    flags.require_consistent(format_)
    design, motor = design_options.resolve_checked().at_reference, flags.interface.choose_motor()
    reducer = reducer_of(design)
    flags.require_supported(reducer)
    if flags.has_casing:
        require_one_ring(reducer, "print plates, assemblies and drawings")
    settings = flags.print_settings(reducer)
    outlines = _export_outlines(design, format_, motor, flags)
    casing = _find_casing(reducer, motor, flags.cover_material) if flags.has_casing else None
    plates = _make_print_plates(reducer, casing, settings) if flags.plate else None
    files = {**outlines.files, **_encode_casing_files(reducer, format_, casing, settings, flags)}
    if plates:
        files |= plates.files
    if flags.assembly:
        files |= _assembly_files(reducer, casing)
    if flags.drawings:
        files |= _drawing_files(reducer, casing)
    directory = claim_folder(f"{design.name}-{format_}" if out is None else out, "the parts", files, output_flags.force)
    stem = f"{design.name}-parts"
    destination = Destination(stem, directory, claim_page(output_flags, stem, directory))
    return deliver(_outcome(design.name, outlines, plates, files, flags.offset, destination), destination, output_flags)


def _export_outlines(design: Design, file_format: "Format", motor: "Motor", flags: ExportFlags) -> "Export":
    """Compute the files of the mechanism's parts in a file format, with the clearances measured in their outlines.

    `motor` is the motor whose shaft fits the drive, `flags` are those of the command.
    """
    from cycloid_mj.parts.export import export

    return export(
        design,
        file_format,
        flags.chord_error,
        flags.offset,
        motor,
        polylines=flags.polylines,
        cover_material=flags.cover_material,
        arcs=flags.arc_error,
    )


def _encode_casing_files(
    reducer: Reducer, file_format: "Format", casing: "Casing | None", settings: "PrintSettings", flags: ExportFlags
) -> Mapping[str, bytes]:
    """Return the files of the parts of a drive with covers and flanges, by name; empty without a `casing`.

    `file_format` is their format, `settings` are those of printing. ``--offset-um`` among the `flags` increases the
    clearances.
    """
    from cycloid_mj.parts.export import drive_files, widen_clearances

    if casing is None:
        return {}
    widened_reducer = widen_clearances(reducer, flags.offset)
    return drive_files(
        widened_reducer,
        file_format,
        casing,
        flags.chord_error,
        settings.cam_seat,
        polylines=flags.polylines,
        arcs=flags.arc_error,
    )


def _outcome(
    name: str,
    outlines: "Export",
    plates: "_Plates | None",
    files: Mapping[str, bytes],
    offset: float,
    destination: Destination,
) -> Outcome:
    """Convert exported parts to printable results: files, clearances, print plates and bill of materials.

    Parameters
    ----------
    name
        Name of the design.
    outlines, plates
        Exported parts of the mechanism, and print plates; None without plates.
    files
        All files, name -> content.
    offset
        Increase of the clearances [m].
    destination
        Where the files are written.
    """
    paths = destination.paths(files)
    clearances = [asdict(clearance) for clearance in outlines.clearances]
    result = {"files": paths, "clearances": clearances, "offset": offset}
    return Outcome(
        title=f"parts: {name}",
        text=paths,
        tables=[_tabulate_clearances(outlines, offset), *(plates.tables if plates else ())],
        summary=plates.notes if plates else [],
        files=files,
        result=result | (plates.result(destination.folder or Path()) if plates else {}),
        filed=False,
    )


def _bed_size(text: str | None) -> tuple[float, float] | None:
    """Parse the size of a printer's bed, ``LxW`` in mm, to length and width [m]; return None for None.

    Raises UsageError if the text is not two positive numbers with an x between them.
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


def _tabulate_clearances(outlines: "Export", offset: float) -> Table:
    """Tabulate the clearance of each pair of parts [um]: required, smallest and largest.

    `offset` [m] is the clearance that ``--offset-um`` adds, a further column.
    """
    rows = tuple(
        (
            clearance.pair,
            *(f"{1e6 * value:.4f}" for value in (clearance.asked, offset, clearance.least, clearance.most)),
        )
        for clearance in outlines.clearances
    )
    return Table(
        "clearance of the exported outlines [um]", ("pair", "requested", "offset", "smallest", "largest"), rows
    )


@dataclass(frozen=True)
class _Plates:
    """Results of --plate: plates by file, files, notes, tables and entries of the JSON object."""

    plates: "dict[str, PrintPlate]"
    files: dict[str, bytes]
    notes: list[str]
    tables: tuple[Table, ...]
    entries: dict[str, Any]

    def result(self, directory: Path) -> dict[str, Any]:
        """Return the entries of the JSON object for files in a folder."""
        plates = [
            {"file": str(directory / file), "size": item.size, "parts": item.counts}
            for file, item in self.plates.items()
        ]
        return {"plate": plates[0], "plates": plates, **self.entries}


def _make_print_plates(reducer: Reducer, casing: "Casing | None", settings: "PrintSettings") -> _Plates:
    """Return the files of print plates and of the bill of materials, with the tables and notes about them.

    `settings` are those of printing. Warnings report parts that cannot be bought or printed. `casing` None: the
    mechanism only.
    """
    from cycloid_mj.life.joints import tightening_torques
    from cycloid_mj.parts.export.print_files import print_files

    print_output = print_files(reducer, casing, settings, tightening_torques(reducer) if casing else None)
    warn(reducer.design.name, print_output.warnings)
    counts: Counter[str] = sum((Counter(plate.counts) for plate in print_output.plates.values()), Counter())
    columns = ("item", "count", "size", "material", "made or bought", "designation")
    bill_lines = (item for item in print_output.bill if item.made_or_bought != "consumable")  # these are notes
    bill_rows = tuple(tuple(str(value) for value in asdict(item).values())[:-2] for item in bill_lines)
    tables = (
        Table("parts on the plate", ("part", "count"), tuple((part, str(count)) for part, count in counts.items())),
        Table("bill of materials", columns, bill_rows, words=(2, 3, 4, 5)),
    )
    json_entries = {"bom": [asdict(item) for item in print_output.bill], "consumables": list(print_output.consumables)}
    plate_by_file = {f"{stem}.stl": plate for stem, plate in print_output.plates.items()}
    return _Plates(plate_by_file, dict(print_output.files), list(print_output.notes), tables, json_entries)


def _find_casing(reducer: Reducer, motor: "Motor", cover_material: str) -> "Casing | None":
    """Return the casing (covers and flanges), or None if it does not fit; warn of the reason and of weak joints.

    `motor` is the motor that is attached, `cover_material` the name of the covers' material. An RV reducer has no
    covers.
    """
    from cycloid_mj.parts.export import casing_or_none
    from cycloid_mj.parts.export.rules import describe_violations

    if isinstance(reducer, RvReducer):
        return None
    casing, reason = casing_or_none(reducer, motor, cover_material)
    if casing:
        warn(reducer.design.name, describe_violations(reducer, casing))
    else:
        warn(reducer.design.name, (f"without covers: {reason}",))
    return casing


def _drawing_files(reducer: Reducer, casing: "Casing | None") -> dict[str, bytes]:
    """Draw all manufactured parts: one PDF, and a DXF of each part."""
    from cycloid_mj.plots.drawings import drawing_files

    return drawing_files(reducer, casing)


def _assembly_files(reducer: Reducer, casing: "Casing | None") -> dict[str, bytes]:
    """Return the assembly as STEP, and with covers also its exploded view and the assembly instructions."""
    from cycloid_mj.plots.exploded import assembly_files

    return assembly_files(reducer, casing)
