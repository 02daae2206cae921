"""Points of a sweep: a grid of values, a sample of ranges, or a table, for any keys of the design file."""

import csv
import hashlib
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic.fields import FieldInfo

from cycloid_mj.base.array import Array, significant
from cycloid_mj.base.errors import UsageError, reason
from cycloid_mj.base.overwrite_guard import note_input
from cycloid_mj.design import declaration_of

MAX_POINTS = 1_000_000
"""Points of a sweep at most: a larger count is a slip of the pen."""

Value = float | int | str | bool
Method = Literal["sobol", "lhs", "random"]
Wanted = str | Sequence[Any]
"""Values in the words of a user, ``a,b,c``, ``lo:hi:n`` or ``lo:hi``, or a sequence of values."""


@dataclass(frozen=True)
class Points:
    """Values of some keys of the design file, in the file's units, one row for each point."""

    keys: tuple[str, ...]
    rows: tuple[tuple[Value, ...], ...]

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.rows)

    @property
    def digest(self) -> str:
        """Hash of keys and values, which identifies the points."""
        return hashlib.sha256(json.dumps([self.keys, self.rows]).encode()).hexdigest()


@dataclass(frozen=True)
class Axis:
    """Values of a key: `values`, or the range from `low` to `high` with `count` values (0: to be sampled)."""

    key: str
    field: FieldInfo
    values: tuple[Value, ...] = ()
    low: float = math.nan
    high: float = math.nan
    count: int = 0


def grid_points(vary: Mapping[str, Wanted]) -> Points:
    """List all combinations of the values of each key (full factorial); those of the last key change fastest.

    `vary` maps a key of the design file to its values: a sequence, or ``a,b,c``, or ``lo:hi:n``.

    Raises
    ------
    UsageError
        There is no such key, it cannot have such values, or there are too many points.
    """
    axes = [parse_axis(key, values) for key, values in vary.items()]
    if open_range := next((axis for axis in axes if not axis.values and not axis.count), None):
        low_text, high_text = f"{open_range.low:g}", f"{open_range.high:g}"
        raise UsageError(
            f"--vary {open_range.key}={low_text}:{high_text} does not specify the number of values: add it, e.g. "
            f"{low_text}:{high_text}:5, or sample the range with --sample sobol --points 64"
        )
    _require_few(math.prod(axis.count or len(axis.values) for axis in axes))
    return Points(tuple(vary), tuple(product(*map(axis_values, axes))))


def draw_points(vary: Mapping[str, Wanted], method: Method, count: int, seed: int) -> Points:
    """Draw points by a sampling method: a value of each key from its range, or with equal probability from its values.

    Parameters
    ----------
    vary
        Range ``lo:hi``, or a list of values, by key of the design file.
    method
        ``sobol``: a scrambled Sobol sequence; ``lhs``: a Latin hypercube; ``random``: independent draws.
    count, seed
        Number of points, and random seed.

    Raises
    ------
    UsageError
        There is no such key, it cannot have such values, or there are too many points.
    """
    _require_few(count)
    axes = [parse_axis(key, range_text) for key, range_text in vary.items()]
    unit_points = _draw_in_unit_cube(method, count, len(axes), seed)
    columns = [_scale_to_axis(axis, column) for axis, column in zip(axes, unit_points.T, strict=True)]
    return Points(tuple(vary), tuple(zip(*columns, strict=True)))


def list_rows(rows: Iterable[Mapping[str, Any]]) -> Points:
    """Convert rows of a table to points; the values get the types of their keys.

    A row maps each key of the design file to a value or its text. All rows must have the same keys.

    Raises
    ------
    UsageError
        There is no such key, it cannot have such values, there are too many or no rows, or their keys differ.
    """
    rows = list(rows)
    if not rows:
        raise UsageError(
            "the table of points (--table) is empty: add a header with keys of the design file, and one row per point"
        )
    _require_few(len(rows))
    fields = {key: _scalar_field(key) for key in rows[0]}
    points = []
    for row_number, row in enumerate(rows, 1):
        if set(row) != set(fields) or None in row.values():
            raise UsageError(
                f"row {row_number} of the table of points (--table) does not have the same keys as row 1: give one "
                f"value for each of {', '.join(fields)}, and no others"
            )
        points.append(tuple(_parse_value(key, fields[key], row[key]) for key in fields))
    return Points(tuple(fields), tuple(points))


def read_table(path: Path) -> Points:
    """Read points from a CSV file with keys of the design file in its header, and a row of values for each point.

    Raises
    ------
    UsageError
        The file cannot be read, a column is repeated, a row has too many or too few values, there are no rows or too
        many, or the design file has no such key or cannot have such a value.
    """
    try:
        with note_input(path).open(encoding="utf-8-sig", newline="") as stream:
            header, *lines = [[cell.strip() for cell in line] for line in csv.reader(stream) if any(line)] or [[]]
    except (OSError, ValueError, csv.Error) as problem:
        raise UsageError(
            f"cannot read --table {path}: {reason(problem)}. Choose a CSV file whose header contains keys of the "
            "design file"
        ) from problem
    if repeated_column := next((key for key in header if header.count(key) > 1), None):
        raise UsageError(f"--table {path}: the column {repeated_column!r} is repeated. Remove one of the two columns")
    if bad_line := next((number for number, line in enumerate(lines, 1) if len(line) != len(header)), None):
        raise UsageError(
            f"--table {path}: row {bad_line} has {len(lines[bad_line - 1])} values, but the header has {len(header)} "
            "columns. Give one value per column"
        )
    try:
        return list_rows(dict(zip(header, line, strict=True)) for line in lines)
    except UsageError as error:
        raise UsageError(f"--table {path}: {error}") from error


def _require_few(count: int) -> None:
    if not 1 <= count <= MAX_POINTS:
        raise UsageError(
            f"a sweep may have 1 to {MAX_POINTS:,} points, but this one has {count:,}: change the number of values in "
            "--vary, or --points"
        )


def _scalar_field(key: str) -> FieldInfo:
    """Return the declaration (type and bounds) of a design file key with a single value; else raise UsageError."""
    field = declaration_of(key)
    if field.annotation not in (int, float, bool, str) and not _words(field):
        raise UsageError(
            f"{key} of the design file is a list or a table and cannot be varied: choose a key whose value is a "
            "number, a word or true/false"
        )
    return field


def _words(field: FieldInfo) -> tuple[str, ...]:
    """Return the words of a choice; an empty tuple for another kind of value."""
    words = getattr(field.annotation, "__args__", ())
    return tuple(words) if words and all(isinstance(word, str) for word in words) else ()


def parse_axis(key: str, requested_values: Wanted) -> Axis:
    """Parse the values of a varied design key: a sequence, a list ``1,2,3``, or a range ``low:high[:count]``.

    `requested_values` are in the unit of the design file, as values or text.

    Raises
    ------
    UsageError
        There is no such key, it is not a single value, or it cannot have such values.
    """
    field = _scalar_field(key)
    if not isinstance(requested_values, str):
        values = np.asarray(requested_values, dtype=object).ravel().tolist()
        if not values:
            raise UsageError(f"{key}: the list of values is empty. Give at least one value, e.g. {key}=1,2,3")
        return Axis(key, field, tuple(_parse_value(key, field, value) for value in values))
    parts = requested_values.split(":")
    if len(parts) in (2, 3) and field.annotation in (int, float):
        return _parse_range(key, field, requested_values, parts)
    return Axis(key, field, tuple(_parse_value(key, field, word.strip()) for word in requested_values.split(",")))


def _parse_range(key: str, field: FieldInfo, text: str, parts: Sequence[str]) -> Axis:
    """Parse a range ``lo:hi`` (to be sampled) or ``lo:hi:n`` (n values) of a key of the design file.

    Parameters
    ----------
    key, field
        The key, and its declaration.
    text, parts
        The user's text for messages, and its parts between the colons.

    Raises
    ------
    UsageError
        It is not a valid range of the key.
    """
    option = f"--vary {key}={text}"
    try:
        low, high, count = float(parts[0]), float(parts[1]), int(parts[2]) if len(parts) == 3 else 0
    except ValueError:
        raise UsageError(
            f"{option} is not a range: give LO:HI:N (two numbers and the number of values), e.g. 0.5:2:4, or LO:HI "
            "with --sample"
        ) from None
    if not (math.isfinite(low) and math.isfinite(high)) or low >= high:
        raise UsageError(
            f"{option}: the range {low:g} to {high:g} is not valid. Give two finite numbers, the smaller one first"
        )
    if len(parts) == 3:
        if count < 2:
            raise UsageError(
                f"{option}: the number of values is {count}, but a range needs at least 2. Increase it, or give a "
                "single value"
            )
        _require_few(count)
    axis = Axis(key, field, low=low, high=high, count=count)
    axis_values(axis)
    return axis


def axis_values(axis: Axis) -> tuple[Value, ...]:
    """Return the values of a varied key of the design file; `axis` is the list or the range of the key.

    A range has `Axis.count` evenly spaced values. With a count of 0, the values are both ends of the range; this
    applies to a range ``lo:hi``, of which `draw_points` draws samples.

    Raises
    ------
    UsageError
        A range of a whole number contains fractions.
    """
    if axis.values:
        return axis.values
    values = [significant(value) for value in np.linspace(axis.low, axis.high, axis.count or 2).tolist()]
    if axis.field.annotation is float:
        return tuple(values)
    if fraction := next((value for value in values if not value.is_integer()), None):
        raise UsageError(
            f"--vary {axis.key}: {fraction:g} is not a whole number, but this key takes only whole numbers. Change "
            f"the limits of the range {axis.low:g}:{axis.high:g}, or its number of values, so that all values are "
            "whole numbers"
        )
    return tuple(map(int, values))


def _parse_value(key: str, field: FieldInfo, value: Any) -> Value:
    """Convert a value to the type of a key: float, int, bool, text, or one of the words that the key allows.

    `field` is the declaration of the key. Limits of numbers are checked later, by the design. Raises UsageError if the
    value cannot be converted, or is none of the allowed words.
    """
    value_type, words = field.annotation, _words(field)
    text = str(value).strip().strip("\"'")
    try:
        if value_type is float:
            return float(text)
        if value_type is int and float(text).is_integer():
            return int(float(text))
        if value_type is bool and text.lower() in ("true", "false"):
            return text.lower() == "true"
        if text in words or value_type is str:
            return text
    except (ValueError, OverflowError):
        pass
    descriptions: dict[Any, str] = {float: "a number", int: "a whole number", bool: "true or false"}
    allowed_text = descriptions.get(value_type, ", ".join(words))
    raise UsageError(f"{key}: {str(value)!r:.60} is not allowed; give {allowed_text}")


def _draw_in_unit_cube(method: Method, count: int, dimensions: int, seed: int) -> Array:
    """Draw points in the unit cube (coordinates from 0 to 1) by a sampling method, shape (count, dimensions).

    `seed` is the random seed. A Sobol sequence is balanced for powers of two only: its first `count` points are
    returned.
    """
    from scipy.stats import qmc

    match method:
        case "sobol":
            sequence = qmc.Sobol(dimensions, rng=np.random.default_rng(seed))
            return np.asarray(sequence.random_base2(max(0, (count - 1).bit_length()))[:count])
        case "lhs":
            return np.asarray(qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed)).random(count))
    return np.random.default_rng(seed).random((count, dimensions))


def _scale_to_axis(axis: Axis, coordinates: Array) -> list[Value]:
    """Convert coordinates from 0 to 1, shape (n,), to n values of a key of the design file.

    `axis` is the list or the range of the key. A range of real numbers is scaled linearly. Each value of a list, and
    each integer of a range, has an interval of coordinates of equal length.
    """
    if axis.values or axis.count:
        values = axis_values(axis)
        return [values[int(coordinate * len(values))] for coordinate in coordinates.tolist()]
    if axis.field.annotation is int:
        return [int(axis.low + coordinate * (axis.high - axis.low + 1)) for coordinate in coordinates.tolist()]
    return (axis.low + coordinates * (axis.high - axis.low)).tolist()
