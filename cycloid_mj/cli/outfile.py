"""Files for the user: CSV tables written whole or not at all, folders, and what to say when they cannot be written."""

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TextIO

from cyclopts import Parameter

from cycloid_mj.errors import CycloidError, UsageError
from cycloid_mj.whole import whole_file

if TYPE_CHECKING:
    import numpy.typing as npt

CHUNK = 10_000
STDOUT = "-"

CsvFlag = Annotated[
    str,
    Parameter(
        name="--csv",
        metavar="FILE",
        allow_leading_hyphen=True,
        help="CSV file to write; replaced if it exists. - is stdout.",
    ),
]

Columns = Mapping[str, "npt.NDArray[Any]"]


def write_csv(file: str, columns: Columns) -> None:
    """Write columns, shape (n,) each, with every digit of every number.

    Raises
    ------
    UsageError
        `file` is another flag, not a name.
    CycloidError
        The file cannot be written; one that was there before is as it was.
    """
    if file == STDOUT:
        sys.stdout.writelines(_lines(columns))
        return
    if file.startswith("-") or not file:
        raise UsageError(f"--csv {file!r}: expected a file name, or - for stdout")
    with _written(file) as stream:
        stream.writelines(_lines(columns))


def csv_bytes(columns: Columns) -> bytes:
    """Give what `write_csv` writes, for files that are written together."""
    return "".join(_lines(columns)).encode()


def folder(name: str, what: str) -> Path:
    """Give the folder `name`, made if there is none; raise CycloidError if that cannot be."""
    path = Path(name)
    if new_folder(name, what) or path.is_dir():
        return path
    raise CycloidError(f"cannot write {what} to {name}: it is a file; give a folder with --out")


def new_folder(name: str, what: str) -> Path | None:
    """Make the folder `name` and give it, or None if something has that name; raise CycloidError if that cannot be."""
    path = Path(name)
    try:
        path.mkdir(parents=True)
    except FileExistsError:
        return None
    except OSError as problem:
        raise CycloidError(
            f"cannot make the folder {name} for {what}: {problem.strerror or problem}; choose another with --out"
        ) from problem
    return path


def _lines(columns: Columns) -> Iterator[str]:
    yield ",".join(columns) + "\n"
    rows = len(next(iter(columns.values())))
    for start in range(0, rows, CHUNK):
        block = (_words(column[start : start + CHUNK]) for column in columns.values())
        yield from (",".join(row) + "\n" for row in zip(*block, strict=True))


def _words(values: "npt.NDArray[Any]") -> list[str]:
    # the sum turns -0.0 into 0.0
    numbers = (values + 0.0).tolist() if values.dtype.kind == "f" else values.tolist()
    return [repr(value) if isinstance(value, float) else str(value) for value in numbers]


@contextmanager
def _written(file: str) -> Iterator[TextIO]:
    """Open a file that takes its name only once it is whole; a device is written to as it is."""
    path = Path(file)
    try:
        if path.exists() and not path.is_file() and not path.is_dir():
            with path.open("w", encoding="utf-8", newline="\n") as stream:
                yield stream
            return
        with whole_file(path) as beside, beside.open("w", encoding="utf-8", newline="\n") as stream:
            yield stream
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or problem
        raise CycloidError(
            f"cannot write {file}: {reason}; give a file in a folder that exists and can be written"
        ) from problem
