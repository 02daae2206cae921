"""Measured parts: the table ``[measured]`` of the design file, and the CSV files that it names.

The values of a file are read into the table. A design is complete without the file, so that a log that records it can
be reviewed elsewhere.
"""

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from cycloid_mj.base.errors import DesignError, reason
from cycloid_mj.base.overwrite_guard import note_input
from cycloid_mj.design import units as u
from cycloid_mj.design.section import Section
from cycloid_mj.design.units import choice, list_quantity


@dataclass(frozen=True)
class MeasuredFileLimits:
    """Limits of files of measurements."""

    rows: int = 10_000  # as many as a list of the design file may have values
    size: int = 5_000_000  # bytes, ten times those of as many rows


LIMITS = MeasuredFileLimits()

Angles = tuple[Annotated[float, Field(ge=-100.0, le=100.0, allow_inf_nan=False)], ...]
Lengths = tuple[Annotated[float, Field(ge=-5.0, le=5.0, allow_inf_nan=False)], ...]
Deviations = tuple[Annotated[float, Field(ge=-1e-3, le=1e-3, allow_inf_nan=False)], ...]

Columns = dict[str, tuple[float, ...]]
"""Columns of a file by name."""

ANGLES = ("angle_deg", "deviation_um")
POINTS = ("x_mm", "y_mm")
PIN_COLUMNS = ("pin", "radial_um", "tangential_um", "radius_um")


def _column(text: str, unit: u.Unit) -> Any:
    return list_quantity(f"{text}; from the file", unit, "", source="")


class Measured(Section):
    """Measured parts, from CSV files; their deviations are added to the errors.

    A path is relative to the folder of the design file. Lists hold the values of a file: where they are set, the file
    is not read.
    """

    gear: str = choice(
        "",
        "CSV of the profile of all discs: angle_deg,deviation_um, or points x_mm,y_mm, which are aligned by least "
        "squares",
        source="",
        max_length=4096,
    )
    pins: str = choice("", f"CSV of the ring pins: {','.join(PIN_COLUMNS)}", source="", max_length=4096)
    gear_angle: Angles = _column("angle about the disc's axis, clockwise from the valley on +y", u.DEGREE)
    gear_deviation: Deviations = _column(
        "deviation along the outward normal, positive where material is added", u.MICROMETRE
    )
    gear_x: Lengths = _column("points of the profile along x, in the frame of the measurement", u.MILLIMETRE)
    gear_y: Lengths = _column("points of the profile along y", u.MILLIMETRE)
    pins_radial: Deviations = _column("displacement of each ring pin outwards, pin 1 on +y, clockwise", u.MICROMETRE)
    pins_tangential: Deviations = _column("displacement of each ring pin clockwise", u.MICROMETRE)
    pins_radius: Deviations = _column("radius of each ring pin minus ring.pin_radius_mm", u.MICROMETRE)

    @classmethod
    def merge_change(cls, values: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values of the table with some of them changed; a new file replaces the lists of the old one."""
        replaced = [key for part in READERS if part in change for key in values if key.startswith(f"{part}_")]
        return {**{key: value for key, value in values.items() if key not in replaced}, **change}

    @model_validator(mode="after")
    def _check_lists(self) -> Self:
        """Raise ValueError for lists of measured deviations that are inconsistent.

        They are inconsistent if lists of the same surface differ in length, if a file is named whose values were not
        read, or if a profile is stated both in polar and in Cartesian coordinates.
        """
        groups = {
            "gear_angle_deg and gear_deviation_um": (self.gear_angle, self.gear_deviation),
            "gear_x_mm and gear_y_mm": (self.gear_x, self.gear_y),
            "pins_radial_um, pins_tangential_um and pins_radius_um": (
                self.pins_radial,
                self.pins_tangential,
                self.pins_radius,
            ),
        }
        for keys, lists in groups.items():
            if len({len(values) for values in lists}) > 1:
                counts = ", ".join(str(len(values)) for values in lists)
                raise ValueError(f"measured.{keys} must have equal lengths, but have {counts} values")
        for part, values in (("gear", self.gear_angle or self.gear_x), ("pins", self.pins_radial)):
            if (name := getattr(self, part)) and not values:
                raise ValueError(
                    f'measured.{part} = "{name}" was not read: load the design from its file, or override the key'
                )
        if self.gear_x and self.gear_angle:
            raise ValueError("measured.gear_angle_deg and measured.gear_x_mm both describe the profile: remove one")
        return self

    @property
    def is_empty(self) -> bool:
        """True if no part is measured."""
        return not (self.gear_angle or self.gear_x or self.pins_radial)


def read_measurements(table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Read the files that the table ``[measured]`` names; return the table with their values added as lists.

    The lists are in the units of the file; their keys are those of the file.

    Parameters
    ----------
    table
        The table. If it already has lists of the values of a file, this file is not read.
    folder
        Folder to which relative paths refer.

    Raises
    ------
    DesignError
        A file cannot be read, or a line of it is wrong.
    """
    values: dict[str, Any] = {}
    for part, read_file in READERS.items():
        name = table.get(part)
        is_listed = any(key.startswith(f"{part}_") and value for key, value in table.items())
        if isinstance(name, str) and name and not is_listed:
            values |= {f"{part}_{key}": list(column) for key, column in read_file(folder / name).items()}
    return {**table, **values}


def _read_disc_profile(path: Path) -> Columns:
    """Read the measured profile of a disc from a CSV file; return its columns by name, in the units of the names.

    The header names angle and deviation (`ANGLES`), or x and y (`POINTS`). Without a header, the columns are x, y and
    optionally z [mm], which is ignored. Raises DesignError for any other header, for a value that is not a number or
    out of range, and for a wrong number of cells.
    """
    numbered_rows = list(_read_rows(path))
    line_number, header_cells = numbered_rows[0]
    header = tuple(cell.lower() for cell in header_cells)
    if all(_number(cell) is not None for cell in header_cells) and len(header_cells) in (2, 3):
        names = POINTS
    elif header == ANGLES:
        names, numbered_rows = ANGLES, numbered_rows[1:]
    elif header[:2] in (POINTS, ("x", "y")) and len(header) in (2, 3):
        names, numbered_rows = POINTS, numbered_rows[1:]
    else:
        raise _wrong_header(path, line_number, header_cells, [ANGLES, POINTS])
    return _parse_columns(path, names, numbered_rows)


def _read_pins(path: Path) -> Columns:
    """Read the deviations of measured ring pins [um] by column, from a CSV file with the columns `PIN_COLUMNS`.

    The rows may have any order, the result has that of the pins. Raises DesignError if a pin is missing or listed
    twice, for another header, and for the errors that `_parse_columns` describes.
    """
    numbered_rows = list(_read_rows(path))
    line_number, header_cells = numbered_rows[0]
    if tuple(cell.lower() for cell in header_cells) != PIN_COLUMNS:
        raise _wrong_header(path, line_number, header_cells, [PIN_COLUMNS])
    columns = _parse_columns(path, PIN_COLUMNS, numbered_rows[1:])
    index_of_pin = {pin: index for index, pin in enumerate(columns["pin"])}
    for pin in range(1, len(columns["pin"]) + 1):
        if pin not in index_of_pin:
            raise DesignError(
                f"{path}: pin {pin} is missing, or another pin is listed twice: list each pin once, beginning with pin "
                "1 on the +y axis"
            )
    return {name: tuple(columns[name][index_of_pin[pin]] for pin in sorted(index_of_pin)) for name in PIN_COLUMNS[1:]}


READERS = {"gear": _read_disc_profile, "pins": _read_pins}
"""Reader of each file by its key; the lists that it returns have the key as a prefix."""


def _read_rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Yield each line of a CSV file that is neither empty nor a comment (#).

    Yields
    ------
    tuple
        Number of the line, and its cells.

    Raises
    ------
    DesignError
        The file cannot be read, has no line below its header, or exceeds `LIMITS`.
    """
    try:
        if note_input(path).stat().st_size > LIMITS.size:
            raise DesignError(
                f"{path} is larger than {LIMITS.size:,} bytes. Delete rows until it has at most {LIMITS.size:,} bytes "
                f"and {LIMITS.rows:,} rows"
            )
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, ValueError) as error:
        raise DesignError(
            f"cannot read the measurement file {path}: {reason(error)}. Check that it is a CSV file with UTF-8 text, "
            "and check the path: it is relative to the design file or, if given with --set, to the current folder"
        ) from error
    lines = [(line_number, line.strip()) for line_number, line in enumerate(text.splitlines(), 1)]
    lines = [(line_number, line) for line_number, line in lines if line and not line.startswith("#")]
    if len(lines) < 2:
        raise DesignError(
            f"{path} has no measurements: write a header, such as {','.join(ANGLES)}, and one row per measured point"
        )
    if len(lines) > LIMITS.rows + 1:
        raise DesignError(f"{path} has {len(lines) - 1:,} rows: at most {LIMITS.rows:,} are allowed. Remove some rows")
    for line_number, line in lines:
        yield line_number, _cells(line)


def _cells(line: str) -> list[str]:
    """Split a line at its semicolons, tabs, commas or spaces; next to the first two, a comma is a decimal sign."""
    for separator in (";", "\t"):
        if separator in line:
            return [cell.strip().replace(",", ".") for cell in line.split(separator)]
    return [cell.strip() for cell in (line.split(",") if "," in line else re.split(r"\s+", line))]


def _parse_columns(path: Path, names: tuple[str, ...], numbered_rows: Iterable[tuple[int, list[str]]]) -> Columns:
    """Convert the rows of a file to columns of numbers by name; a third coordinate of points is left out.

    `names` are the names of the columns. `numbered_rows` has the line number and the cells of each row. Raises
    DesignError, with the number of the line, for a value that is not a number or out of range, and for a wrong number
    of cells.
    """
    rows = []
    for line_number, cells in numbered_rows:
        max_cells = len(names) + (names == POINTS)
        values = [value for cell in cells if (value := _number(cell)) is not None]
        if len(values) != len(cells) or not len(names) <= len(cells) <= max_cells:
            raise DesignError(
                f"{path}, line {line_number}: {','.join(cells)[:60]!r} is not valid. Write {len(names)} numbers: "
                f"{','.join(names)}"
            )
        if (range_error := _describe_out_of_range(dict(zip(names, values, strict=False)))) is not None:
            raise DesignError(f"{path}, line {line_number}: {range_error}")
        rows.append(values[: len(names)])
    return dict(zip(names, zip(*rows, strict=True), strict=True))


def _describe_out_of_range(row: Mapping[str, float]) -> str | None:
    """Describe the first measured value of a row that exceeds the limit of its unit; None if none does.

    `row` maps column names, which end in their unit (um, mm or deg), to values.
    """
    limits = {"um": 1000.0, "mm": 5000.0, "deg": 3600.0}
    for name, value in row.items():
        limit = limits.get(name.rsplit("_", 1)[-1], LIMITS.rows)
        if abs(value) > limit:
            return f"{name} is {value:g}, but must be from {-limit:g} to {limit:g}. Check its unit"
    return None


def _number(cell: str) -> float | None:
    """Return a finite number; None for any other text."""
    try:
        value = float(cell)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _wrong_header(path: Path, line_number: int, cells: list[str], allowed: list[tuple[str, ...]]) -> DesignError:
    headers = " or ".join(",".join(names) for names in allowed)
    return DesignError(
        f"{path}, line {line_number}: the header {','.join(cells)[:60]!r} is not valid. Change it to {headers}"
    )
