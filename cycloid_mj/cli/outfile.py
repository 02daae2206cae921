"""Files for the user: CSV tables written completely or not at all, folders, and errors if they cannot be written."""

import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TextIO

from cyclopts import Parameter

from cycloid_mj.base.atomic_write import atomic_file
from cycloid_mj.base.errors import CycloidError, UsageError, reason
from cycloid_mj.base.overwrite_guard import claim_outputs, make_folder, require_ending

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
    """Check before the work that a CSV file may be written.

    `file` is the value of `flag`; stdout and devices are always accepted, an existing file with `force` only.

    Raises
    ------
    UsageError
        The value is another flag, or has the ending of another kind of file.
    CycloidError
        It cannot be written in its folder (`claim_file`).
    """
    if file == STDOUT:
        return
    if file.startswith("-") or not file:
        problem = "begins with a dash, as flags do" if file else "is empty"
        raise UsageError(f"the file name after {flag}, {file!r}, {problem}: give another file name, or - for stdout")
    path = Path(file)
    require_ending(path, ".csv")
    if not _is_device(path):
        claim_file(path, force)


def claim_file(path: Path, force: bool) -> None:
    """Check before the work that a named file can be written in an existing folder.

    Raises
    ------
    CycloidError
        The folder does not exist or is not writable, or the name is that of a folder or a device.
    TakenError
        The file exists, and either `force` is not set or the command reads this file.
    """
    if not path.parent.is_dir():
        raise CycloidError(
            f"cannot write {path}: there is no folder {path.parent}. Create it, or choose another file name"
        )
    if path.exists() and not path.is_file():
        raise CycloidError(f"cannot write {path}: it is not a regular file. Choose another file name")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise CycloidError(f"cannot write {path}: permission denied. Choose a file in another folder")
    claim_outputs(path, force=force)


def write_csv(file: str, columns: Columns) -> None:
    """Write columns of n numbers, shape (n,) each, as CSV with all digits, to a file or stdout.

    Raises
    ------
    CycloidError
        The file cannot be written; an existing file is unchanged.
    """
    from cycloid_mj.base.frame import write_rows  # which takes NumPy, that no help page needs

    if file == STDOUT:
        write_rows(columns, sys.stdout, "nan")
        return
    with _open_output(file) as stream:
        write_rows(columns, stream, "nan")


def claim_folder(name: str, contents: str, files: Iterable[str], force: bool) -> Path:
    """Create a folder unless it exists, check before the work that files in it may be written, and return its path.

    `files` are the names of the files. `contents` describes them in messages, for example "the logs".

    Raises
    ------
    CycloidError
        The folder cannot be created, or is not writable.
    TakenError
        One of the files exists, and either `force` is not set or the command reads this file.
    """
    path = Path(name)
    if create_folder(name, contents) is None and not path.is_dir():
        raise CycloidError(f"cannot write {contents} to {name}: it is a file, not a folder. Choose a folder with --out")
    if not os.access(path, os.W_OK | os.X_OK):
        raise CycloidError(f"cannot write {contents} to {name}: permission denied. Choose another folder with --out")
    claim_outputs(*(path / file for file in files), force=force)
    if force:
        claim_outputs(path, force=True)
    return path


def create_folder(name: str, contents: str) -> Path | None:
    """Create a folder and return its path; return None if a file or folder has this name.

    Raises
    ------
    CycloidError
        It cannot be created; `contents` describes its files in the message, for example "the logs".
    """
    path = Path(name)
    try:
        if path.exists() or not make_folder(path):
            return None
    except OSError as problem:
        raise CycloidError(
            f"cannot create the folder {name} for {contents}: {reason(problem)}. Choose another folder with --out"
        ) from problem
    return path


def _is_device(path: Path) -> bool:
    return path.exists() and not path.is_file() and not path.is_dir()


@contextmanager
def _open_output(file: str) -> Iterator[TextIO]:
    """Open a text file for writing, so that an incomplete file never has its final name.

    A device is written directly. Raises CycloidError if the file cannot be written.
    """
    path = Path(file)
    try:
        if _is_device(path):
            with path.open("w", encoding="utf-8", newline="\n") as stream:
                yield stream
            return
        with atomic_file(path) as temporary, temporary.open("w", encoding="utf-8", newline="\n") as stream:
            yield stream
    except (OSError, ValueError) as problem:
        raise CycloidError(
            f"cannot write {file}: {reason(problem)}. Choose a file in a writable folder with free disk space"
        ) from problem
