"""Files that are written whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from cycloid_mj.errors import CycloidError


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give the name of a new hidden file beside `path`, which takes its place when the block ends without an error.

    Raises
    ------
    CycloidError
        It cannot be written; a file that was there before is as it was.
    """
    path = Path(path)
    beside = path.with_name(f".{path.stem}.{os.getpid()}.new{path.suffix}")
    try:
        if path.exists() and not path.is_file():
            raise CycloidError(f"cannot write {path}: it is no regular file; give the name of a file")
        with beside.open("xb"):
            pass
        yield beside
        os.replace(beside, path)
    except OSError as problem:
        reason = problem.strerror or problem
        raise CycloidError(
            f"cannot write {path}: {reason}; give a file in a folder that exists and can be written"
        ) from problem
    finally:
        with suppress(OSError):
            beside.unlink()
