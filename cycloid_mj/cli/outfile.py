"""Files for the user: CSV tables written whole or not at all, folders, and what to say when they cannot be written."""

import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TextIO

from cyclopts import Parameter

from cycloid_mj.base.atomic_write import atomic_file
from cycloid_mj.base.errors import CycloidError, UsageError, reason
from cycloid_mj.base.overwrite_guard import claim, make_folder, require_ending

if TYPE_CHECKING:
    import numpy.typing as npt

STDOUT = "-"

CsvFlag = Annotated[
    str,
    Parameter(
        name=("--csv", "--out"),
        metavar="FILE",
        allow_leading_hyphen=True,
        help="CSV file to write; - writes to stdout.",
    ),
]

Columns = Mapping[str, "npt.NDArray[Any]"]


def claim_csv(file: str, force: bool, flag: str = "--csv") -> None:
    """Claim the name of a table, the value of `flag`, before the work; stdout and devices need no claim.

    Raises
    ------
    UsageError
        It is another flag, or has the ending of another kind of file.
    TakenError
        The file exists, and `force` is not set.
    """
    if file == STDOUT:
        return
    if file.startswith("-") or not file:
        raise UsageError(f"{flag} {file!r} is not a file name: give a file name, or - for stdout")
    require_ending(Path(file), ".csv")
    claim(Path(file), force=force)


def write_csv(file: str, columns: Columns) -> None:
    """Write columns, shape (n,) each, with every digit of every number.

    Raises
    ------
    CycloidError
        The file cannot be written; one that was there before is as it was.
    """
    from cycloid_mj.base.frame import write_rows  # which takes NumPy, that no help page needs

    if file == STDOUT:
        write_rows(columns, sys.stdout, "nan")
        return
    with _written(file) as stream:
        write_rows(columns, stream, "nan")


def folder(name: str, what: str, files: Iterable[str], force: bool) -> Path:
    """Return the folder `name`, created if it does not exist, for `files` that are written after the work.

    Raises
    ------
    CycloidError
        The folder cannot be created, or is not writable.
    TakenError
        One of the files exists, and the command reads it, or `force` is not set.
    """
    path = Path(name)
    if new_folder(name, what) is None and not path.is_dir():
        raise CycloidError(f"cannot write {what} to {name}: it is a file, not a folder. Choose a folder with --out")
    if not os.access(path, os.W_OK | os.X_OK):
        raise CycloidError(f"cannot write {what} to {name}: permission denied. Choose another folder with --out")
    claim(*(path / file for file in files), force=force)
    if force:
        claim(path, force=True)
    return path


def new_folder(name: str, what: str) -> Path | None:
    """Create the folder `name` and return it; None if the name exists. Raise CycloidError if it cannot be created."""
    path = Path(name)
    try:
        if path.exists() or not make_folder(path):
            return None
    except OSError as problem:
        raise CycloidError(
            f"cannot create the folder {name} for {what}: {reason(problem)}. Choose another folder with --out"
        ) from problem
    return path


@contextmanager
def _written(file: str) -> Iterator[TextIO]:
    """Open a file that gets its name when it is complete; a device is written directly."""
    path = Path(file)
    try:
        if path.exists() and not path.is_file() and not path.is_dir():
            with path.open("w", encoding="utf-8", newline="\n") as stream:
                yield stream
            return
        with atomic_file(path) as beside, beside.open("w", encoding="utf-8", newline="\n") as stream:
            yield stream
    except (OSError, ValueError) as problem:
        raise CycloidError(
            f"cannot write {file}: {reason(problem)}. Choose a file in a writable folder with free disk space"
        ) from problem
