"""Files for printing and buying a drive: plates, test coupon and bill of materials, with notes and warnings."""

from collections.abc import Mapping
from dataclasses import dataclass

from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import mesh
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.parts.export.assembly import printed_materials
from cycloid_mj.parts.export.bill import BillLine, bill, bill_csv, consumables, describe_consumable, out_of_stock
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.casing_rules import is_plastic
from cycloid_mj.parts.export.plate import PrintPlate, plates
from cycloid_mj.parts.export.printable import coupon_solids, coupon_words, print_warnings
from cycloid_mj.parts.export.printing import widen_clearances
from cycloid_mj.parts.export.threemf import threemf_bytes
from cycloid_mj.parts.export.triangles import stl_bytes
from cycloid_mj.reducer import Reducer

PLATE, BILL = "plate", "bom.csv"
"""Stem of the files of a plate, and the file of the bill."""


@dataclass(frozen=True)
class PrintFiles:
    """Plates by the stem of their files, files by name, bill with consumables, these in words, notes, and warnings."""

    plates: Mapping[str, PrintPlate]
    files: Mapping[str, bytes]
    bill: tuple[BillLine, ...]
    consumables: tuple[str, ...]
    notes: tuple[str, ...]
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class PrintSettings:
    """Settings of printed parts in metres.

    Attributes
    ----------
    chord_error
        Largest distance of a chord from its curve.
    offset
        Increase of all clearances, to compensate for material that the printer adds.
    cam_seat
        Radius of the bore of the cam bearing, which the cams fit; 0: cams as large as its outside.
    bed
        Length and width of the printer's bed; None: one plate, as large as needed.
    """

    chord_error: float
    offset: float = 0.0
    cam_seat: float = 0.0
    bed: tuple[float, float] | None = None


def stock_cam_seat(reducer: Reducer) -> float:
    """Return half the bore of the stock bearing on the cams [m]; 0 without one."""
    bearings = cam_bearing(reducer)
    return round(0.5 * bearings[0].bore, 9) if bearings else 0.0


def print_files(
    reducer: Reducer, casing: Casing | None, settings: PrintSettings, torques: Mapping[str, float] | None = None
) -> PrintFiles:
    """Encode all files for printing a drive (print plates, test coupon, bill of materials), with notes and warnings.

    Parameters
    ----------
    casing
        The casing; None: the mechanism only.
    settings
        Accuracy of the meshes, offset of the printer, seat of the cam bearing, and bed.
    torques
        Tightening torques [N m] by the name of the screws in the bill, such as ``flange_screw``.

    Returns
    -------
    PrintFiles
        Print plates, content of each file by its name, rows of the bill, consumables in words, notes and warnings.

    Raises
    ------
    DesignError
        A part cannot be manufactured, or is larger than the bed.
    """
    chord_error, cam_seat = settings.chord_error, settings.cam_seat
    print_plates = plates(widen_clearances(reducer, settings.offset), chord_error, cam_seat, casing, settings.bed)
    stems = [PLATE] if len(print_plates) == 1 else [f"{PLATE}_{number}" for number in range(1, len(print_plates) + 1)]
    plate_by_stem = dict(zip(stems, print_plates, strict=True))
    bill_lines, consumable_lines = (
        bill(reducer, cam_seat, casing, torques),
        tuple(consumables(reducer, casing, torques)) if casing else (),
    )
    materials = printed_materials(reducer, casing, {part for plate in print_plates for part in plate.counts})
    files, warnings = {BILL: bill_csv((*bill_lines, *consumable_lines))}, [*out_of_stock(bill_lines)]
    for stem, plate in plate_by_stem.items():
        files |= {f"{stem}.stl": stl_bytes(plate.mesh, MILLIMETRES), f"{stem}.3mf": threemf_bytes(plate, materials)}
    if is_plastic(reducer):
        files |= {
            f"{name}.stl": stl_bytes(mesh(plate), MILLIMETRES) for name, plate in coupon_solids(chord_error).items()
        }
        unsupported_areas = {name: faces for plate in print_plates for name, faces in plate.hanging.items()}
        warnings += print_warnings(reducer, unsupported_areas, chord_error, casing)
    consumable_texts = tuple(describe_consumable(line) for line in consumable_lines)
    notes = _describe_plates(plate_by_stem, consumable_texts, coupon_words() if is_plastic(reducer) else "")
    return PrintFiles(plate_by_stem, files, (*bill_lines, *consumable_lines), consumable_texts, notes, tuple(warnings))


def _describe_plates(
    plate_by_stem: Mapping[str, PrintPlate], consumable_texts: tuple[str, ...], coupon_note: str
) -> tuple[str, ...]:
    """Describe the print plates with their sizes, consumables, coupon and parts with supports, a sentence each.

    Parameters
    ----------
    plate_by_stem
        Plates by the name of their files without suffix.
    consumable_texts, coupon_note
        Consumables in words, and a sentence on the test coupon, "" without one.
    """
    notes = [
        f"{stem} of {' x '.join(f'{MILLIMETRES * length:.1f}' for length in plate.size)} mm"
        for stem, plate in plate_by_stem.items()
    ]
    notes += [f"also needed: {text}" for text in consumable_texts]
    notes += [coupon_note] if coupon_note else []
    supported_parts = [
        position.part
        for plate in plate_by_stem.values()
        for position, supports in zip(plate.places, plate.supports, strict=True)
        if supports
    ]
    if supported_parts:
        notes.append(
            "supports that break away, a layer below the faces that they hold: "
            f"{', '.join(dict.fromkeys(supported_parts))}"
        )
    return tuple(notes)
