"""A run as a Parquet file."""

import os
from collections.abc import Sequence

from cycloid_mj.base.errors import LogError
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.frame import write_parquet as write_frame
from cycloid_mj.base.record import Run
from cycloid_mj.log.encoding import TIME


def write_parquet(run: Run, path: str | os.PathLike[str], columns: Sequence[str] | None = None) -> None:
    """Write the time [s] and the `columns` of a run, by default all, to a Parquet file.

    Units and provenance are metadata of the file. The file appears under its name only when it is complete.

    Raises
    ------
    LogError
        A column does not exist, or DuckDB is not installed.
    CycloidError
        The file cannot be written.
    """
    column_names = list(run.columns) if columns is None else list(columns)
    table = Frame(
        {TIME: run.time, **{name: run[name] for name in column_names}},
        {TIME: "s", **{name: run.units[name] for name in column_names}},
    )
    write_frame(table, path, {"provenance": dict(run.provenance)}, LogError)
