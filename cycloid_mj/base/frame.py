"""Named columns with units: the result of a sweep, tolerance study or optimisation, for files and for pandas.

A frame is handed on through Arrow's C stream, which pandas, polars, pyarrow and DuckDB read without a copy by hand:
``polars.DataFrame(frame)``, ``pandas.DataFrame.from_arrow(frame)``, ``duckdb.sql("from frame")``. `columns` is a dict
of arrays for all else: ``pandas.DataFrame(frame.columns)``.
"""

import csv
import importlib
import io
import json
import math
import os
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any, TextIO

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.atomic_write import atomic_file
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.notebook_display import Presented

Cell = float | int | str | bool
Column = npt.NDArray[Any]


class Tabular(Presented):
    """Base class of results with a `frame`."""

    @property
    def frame(self) -> "Frame":
        """The result as a table (`Frame`)."""
        raise NotImplementedError

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """Return the rows as a stream of Arrow; raise CycloidError if DuckDB, which makes it, is not installed."""
        with _duckdb("a table for other packages", "take the arrays of its columns").connect() as database:
            database.register("frame", dict(self.frame.columns))
            return database.table("frame").__arrow_c_stream__(requested_schema)

    def __len__(self) -> int:
        """Count the rows."""
        return self.frame.rows

    def __getitem__(self, name: str) -> Column:
        """Return a column, shape (rows,)."""
        return self.frame.columns[name]


@dataclass(frozen=True, eq=False, repr=False)
class Frame(Tabular):
    """Columns of one length.

    Attributes
    ----------
    columns
        Name -> values, shape (rows,) each: numbers (NaN where there is none), text or switches.
    units
        Name -> unit; columns without one, such as text, are left out.
    """

    columns: Mapping[str, Column]
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def frame(self) -> "Frame":
        """The frame itself."""
        return self

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.columns.values()), ()))

    def as_csv(self) -> str:
        """Return the rows as CSV with all digits; NaN is an empty cell."""
        return csv_text(self.columns)

    @property
    def numbers(self) -> dict[str, Column]:
        """The columns that are numbers, as floats."""
        return {name: column.astype(float) for name, column in self.columns.items() if column.dtype.kind in "fiu"}


def make_frame(rows: Sequence[Mapping[str, Cell]], names: Iterable[str], units: Mapping[str, str]) -> Frame:
    """Build a frame from rows; missing values are NaN, or empty text."""
    return Frame({name: _column([row.get(name) for row in rows]) for name in names}, units)


def _column(cells: list[Cell | None]) -> Column:
    kinds = {type(cell) for cell in cells}
    if any(issubclass(kind, str) for kind in kinds):
        return np.array(["" if cell is None else str(cell) for cell in cells], dtype=object)
    if kinds == {bool} or kinds == {int}:
        return np.array(cells)
    return np.array([math.nan if cell is None else float(cell) for cell in cells])


def write_csv(frame: Frame, path: str | os.PathLike[str]) -> None:
    """Write a table with named columns (`frame`) as CSV with all digits; NaN is an empty cell.

    Raises
    ------
    CycloidError
        The file cannot be written; an existing file is unchanged.
    """
    with atomic_file(path) as temporary_path, temporary_path.open("w", encoding="utf-8", newline="") as stream:
        write_rows(frame.columns, stream)


def csv_text(columns: Mapping[str, Column], missing: str = "") -> str:
    """Return columns, shape (rows,) each, as CSV with all digits; NaN is written as `missing`."""
    text = io.StringIO()
    write_rows(columns, text, missing)
    return text.getvalue()


def write_rows(columns: Mapping[str, Column], stream: TextIO, missing: str = "") -> None:
    """Write columns to a stream, 10 000 rows at once; see `csv_text`."""
    lines = csv.writer(stream, lineterminator="\n")
    lines.writerow(columns)
    for start in range(0, len(next(iter(columns.values()), ())), 10_000):
        block = (_format_cells(column[start : start + 10_000], missing) for column in columns.values())
        lines.writerows(zip(*block, strict=True))


def _format_cells(column: Column, missing: str) -> list[str]:
    """Format the values of a column of a table as text: floats with all digits, NaN as the text `missing`."""
    match column.dtype.kind:
        case "f":
            # the sum turns -0.0 into 0.0
            return [missing if math.isnan(value) else repr(value) for value in (column + 0.0).tolist()]
        case "b":
            return [str(value).lower() for value in column.tolist()]
    return list(map(str, column.tolist()))


def write_parquet(
    frame: Frame,
    path: str | os.PathLike[str],
    metadata: Mapping[str, Any],
    error: Callable[[str], CycloidError] = CycloidError,
) -> None:
    """Write a table with named columns (`frame`) as a Parquet file with units and other metadata, by DuckDB.

    The file appears when it is complete.

    Raises
    ------
    CycloidError
        The file cannot be written. Errors of DuckDB, or its absence, are of the type `error`.
    """
    duckdb = _duckdb("Parquet", "write CSV", error)
    all_metadata = {"units": dict(frame.units), **metadata}
    metadata_text = ", ".join(f"{key}: {_quote(json.dumps(value))}" for key, value in all_metadata.items())
    copy_options = f"FORMAT parquet, COMPRESSION zstd, KV_METADATA {{{metadata_text}}}"
    with atomic_file(path) as temporary_path, duckdb.connect() as database, TemporaryDirectory() as temporary_folder:
        database.register("frame", dict(frame.columns))
        # DuckDB takes names in UTF-8 alone
        parquet_path = temporary_path if str(temporary_path).isprintable() else Path(temporary_folder) / "frame.parquet"
        try:
            database.execute(f"COPY (SELECT * FROM frame) TO {_quote(str(parquet_path))} ({copy_options})")
        except duckdb.Error as problem:
            raise error(f"cannot write {path}: {problem}; choose another file") from problem
        if parquet_path != temporary_path:
            shutil.copyfile(parquet_path, temporary_path)


def _duckdb(what: str, instead: str, error: Callable[[str], CycloidError] = CycloidError) -> ModuleType:
    try:
        return importlib.import_module("duckdb")
    except ImportError as problem:
        raise error(f"{what} needs DuckDB ({problem}): pip install 'cycloid-mj[parquet]', or {instead}") from problem


def _quote(text: str) -> str:
    """Quote text as SQL does."""
    return "'" + text.replace("'", "''") + "'"
