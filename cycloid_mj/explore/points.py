"""The points of a sweep: a grid of values, samples of ranges, or a table, for any keys of the design file."""

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
from cycloid_mj.base.overwrite_guard import as_input
from cycloid_mj.design import declared

MOST_POINTS = 1_000_000

Value = float | int | str | bool
Method = Literal["sobol", "lhs", "random"]
Wanted = str | Sequence[Any]
"""Values as a user gives them: ``a,b,c``, ``lo:hi:n`` or ``lo:hi`` in words, or a sequence of values."""


@dataclass(frozen=True)
class Points:
    """Values of some keys of the design file, in the file's units, one row a point."""

    keys: tuple[str, ...]
    rows: tuple[tuple[Value, ...], ...]

    def __len__(self) -> int:
        """Count the points."""
        return len(self.rows)

    @property
    def digest(self) -> str:
        """What tells these points from others."""
        return hashlib.sha256(json.dumps([self.keys, self.rows]).encode()).hexdigest()


@dataclass(frozen=True)
class Axis:
    """What one key is varied over: `values`, or the range from `low` to `high` (of `count` values; 0: to sample)."""

    key: str
    field: FieldInfo
    values: tuple[Value, ...] = ()
    low: float = math.nan
    high: float = math.nan
    count: int = 0


def grid(vary: Mapping[str, Wanted]) -> Points:
    """List every combination of the values of each key, the last key's changing fastest.

    Raises
    ------
    UsageError
        There is no such key, it cannot have such values, or there are too many points.
    """
    axes = [axis_of(key, wanted) for key, wanted in vary.items()]
    if open_range := next((axis for axis in axes if not axis.values and not axis.count), None):
        low, high = f"{open_range.low:g}", f"{open_range.high:g}"
        raise UsageError(
            f"--vary {open_range.key}={low}:{high}: say how many values, such as {low}:{high}:5, or draw from the "
            "range with --sample sobol --points 64"
        )
    _require_few(math.prod(axis.count or len(axis.values) for axis in axes))
    return Points(tuple(vary), tuple(product(*map(all_values, axes))))


def sampled(vary: Mapping[str, Wanted], method: Method, count: int, seed: int) -> Points:
    """Draw points: each key from its range, or as likely from each of its values.

    Parameters
    ----------
    vary
        Key -> ``lo:hi``, or values as in `grid`.
    method
        ``sobol``: a scrambled Sobol sequence; ``lhs``: a Latin hypercube; ``random``: independent draws.
    count, seed
        How many points, and the seed of the draws.

    Raises
    ------
    UsageError
        As `grid`.
    """
    _require_few(count)
    axes = [axis_of(key, wanted) for key, wanted in vary.items()]
    shares = _shares(method, count, len(axes), seed)
    columns = [_drawn(axis, column) for axis, column in zip(axes, shares.T, strict=True)]
    return Points(tuple(vary), tuple(zip(*columns, strict=True)))


def tabled(rows: Iterable[Mapping[str, Any]]) -> Points:
    """List the points of rows that all have the same keys; values may be in words.

    Raises
    ------
    UsageError
        As `grid`; or there are no rows, or one has other keys.
    """
    rows = list(rows)
    if not rows:
        raise UsageError("a table of points needs rows: the keys of the design file as header, and a line a point")
    _require_few(len(rows))
    fields = {key: _field(key) for key in rows[0]}
    points = []
    for number, row in enumerate(rows, 1):
        if set(row) != set(fields) or None in row.values():
            raise UsageError(f"row {number} of the table has not a value for each of {', '.join(fields)}")
        points.append(tuple(_value(key, fields[key], row[key]) for key in fields))
    return Points(tuple(fields), tuple(points))


def read_table(path: Path) -> Points:
    """Read points from a CSV file whose header names keys of the design file; errors as `tabled`."""
    try:
        with as_input(path).open(encoding="utf-8-sig", newline="") as stream:
            header, *lines = [[cell.strip() for cell in line] for line in csv.reader(stream) if any(line)] or [[]]
    except (OSError, ValueError, csv.Error) as problem:
        raise UsageError(f"--table {path}: cannot read it: {reason(problem)}") from problem
    if twice := next((key for key in header if header.count(key) > 1), None):
        raise UsageError(f"--table {path}: the column {twice!r} is there twice")
    if uneven := next((number for number, line in enumerate(lines, 1) if len(line) != len(header)), None):
        raise UsageError(f"--table {path}: row {uneven} has {len(lines[uneven - 1])} values for {len(header)} columns")
    try:
        return tabled(dict(zip(header, line, strict=True)) for line in lines)
    except UsageError as error:
        raise UsageError(f"--table {path}: {error}") from error


def _require_few(count: int) -> None:
    if not 1 <= count <= MOST_POINTS:
        raise UsageError(f"a sweep of {count:,} points: give from 1 to {MOST_POINTS:,}")


def _field(key: str) -> FieldInfo:
    """Return the declaration of a key that holds one value."""
    field = declared(key)
    if field.annotation not in (int, float, bool, str) and not _words(field):
        raise UsageError(f"{key} holds a list or a table: only single values can be varied")
    return field


def _words(field: FieldInfo) -> tuple[str, ...]:
    """List the words of a choice; nothing for another kind of value."""
    words = getattr(field.annotation, "__args__", ())
    return tuple(words) if words and all(isinstance(word, str) for word in words) else ()


def axis_of(key: str, wanted: Wanted) -> Axis:
    """Read what a key is varied over.

    Raises
    ------
    UsageError
        There is no such key, it holds no single value, or it cannot have such values.
    """
    field = _field(key)
    if not isinstance(wanted, str):
        values = np.asarray(wanted, dtype=object).ravel().tolist()
        if not values:
            raise UsageError(f"{key}: there are no values to take")
        return Axis(key, field, tuple(_value(key, field, value) for value in values))
    parts = wanted.split(":")
    if len(parts) in (2, 3) and field.annotation in (int, float):
        return _range(key, field, wanted, parts)
    return Axis(key, field, tuple(_value(key, field, word.strip()) for word in wanted.split(",")))


def _range(key: str, field: FieldInfo, wanted: str, parts: Sequence[str]) -> Axis:
    option = f"--vary {key}={wanted}"
    try:
        low, high, count = float(parts[0]), float(parts[1]), int(parts[2]) if len(parts) == 3 else 0
    except ValueError:
        raise UsageError(f"{option}: expected LO:HI:N, such as 0.5:2:4, or LO:HI to sample") from None
    if not (math.isfinite(low) and math.isfinite(high)) or low >= high:
        raise UsageError(f"{option}: the range must go from a lower to a higher number")
    if len(parts) == 3:
        if count < 2:
            raise UsageError(f"{option}: give 2 values or more")
        _require_few(count)
    axis = Axis(key, field, low=low, high=high, count=count)
    all_values(axis)
    return axis


def all_values(axis: Axis) -> tuple[Value, ...]:
    """List the values of an axis; raise UsageError for a range that misses whole numbers where they must be."""
    if axis.values:
        return axis.values
    values = [significant(value) for value in np.linspace(axis.low, axis.high, axis.count or 2).tolist()]
    if axis.field.annotation is float:
        return tuple(values)
    if odd := next((value for value in values if not value.is_integer()), None):
        raise UsageError(
            f"--vary {axis.key}: {odd:g} is no whole number; the range {axis.low:g}:{axis.high:g} must lead to such"
        )
    return tuple(map(int, values))


def _value(key: str, field: FieldInfo, value: Any) -> Value:
    """Convert to a value of a key's kind; whether it is allowed is the design's to say, point by point."""
    kind, words = field.annotation, _words(field)
    text = str(value).strip().strip("\"'")
    try:
        if kind is float:
            return float(text)
        if kind is int and float(text).is_integer():
            return int(float(text))
        if kind is bool and text.lower() in ("true", "false"):
            return text.lower() == "true"
        if text in words or kind is str:
            return text
    except (ValueError, OverflowError):
        pass
    kinds: dict[Any, str] = {float: "a number", int: "a whole number", bool: "true or false"}
    allowed = kinds.get(kind, ", ".join(words))
    raise UsageError(f"{key}: {str(value)!r:.60} is not allowed; give {allowed}")


def _shares(method: Method, count: int, dimensions: int, seed: int) -> Array:
    """Draw points of the unit cube, shape (count, dimensions)."""
    from scipy.stats import qmc

    match method:
        case "sobol":
            drawn = qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random_base2(
                max(0, (count - 1).bit_length())
            )
            return np.asarray(drawn[:count])
        case "lhs":
            return np.asarray(qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed)).random(count))
    return np.random.default_rng(seed).random((count, dimensions))


def _drawn(axis: Axis, shares: Array) -> list[Value]:
    """List the values of an axis at shares from 0 to 1."""
    if axis.values or axis.count:
        values = all_values(axis)
        return [values[int(share * len(values))] for share in shares.tolist()]
    if axis.field.annotation is int:
        return [int(axis.low + share * (axis.high - axis.low + 1)) for share in shares.tolist()]
    return (axis.low + shares * (axis.high - axis.low)).tolist()
