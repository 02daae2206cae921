"""A run as a Parquet file, through DuckDB."""

import importlib
import json
import os
from collections.abc import Sequence
from types import ModuleType

from cycloid_mj.errors import LogError
from cycloid_mj.log.encoding import TIME
from cycloid_mj.record import Run
from cycloid_mj.whole import whole_file


def write_parquet(run: Run, path: str | os.PathLike[str], columns: Sequence[str] | None = None) -> None:
    """Write the time [s] and the columns of a run, all of them or some; units and provenance are its metadata.

    The file takes its name only once it is whole.

    Raises
    ------
    LogError
        There is no such column, or DuckDB is not installed.
    CycloidError
        The file cannot be written.
    """
    duckdb = _duckdb()
    names = list(run.columns) if columns is None else list(columns)
    table = {TIME: run.time, **{name: run[name] for name in names}}
    units = {TIME: "s", **{name: run.units[name] for name in names}}
    metadata = f"units: {_quoted(json.dumps(units))}, provenance: {_quoted(json.dumps(dict(run.provenance)))}"
    options = f"FORMAT parquet, COMPRESSION zstd, KV_METADATA {{{metadata}}}"
    with whole_file(path) as beside, duckdb.connect() as database:
        database.register("run", table)
        try:
            database.execute(f"COPY (SELECT * FROM run) TO {_quoted(str(beside))} ({options})")
        except duckdb.Error as problem:
            raise LogError(f"cannot write {path}: {problem}; choose another place for it") from problem


def _duckdb() -> ModuleType:
    try:
        return importlib.import_module("duckdb")
    except ImportError as problem:
        raise LogError(
            f"Parquet needs DuckDB ({problem}): pip install 'cycloid-mj[parquet]', or write CSV"
        ) from problem


def _quoted(text: str) -> str:
    """Give text as SQL has it."""
    return "'" + text.replace("'", "''") + "'"
