"""Atomic file writing: every result file is written completely or not at all.

Several files are replaced together, with signals deferred. The packages atomicwrites (1.4.1, July 2022, no longer
maintained) and safer (6.1) replace files one by one: a signal between two of them leaves a mixture.
"""

import io
import os
import secrets
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from cycloid_mj.base.errors import CycloidError, UsageError, reason
from cycloid_mj.base.interrupt import defer_signals
from cycloid_mj.base.overwrite_guard import LOG, note_output, require_replaceable

EPOCH = (1980, 1, 1, 0, 0, 0)
"""Time of all files in a package."""


def encodable_text(text: str) -> str:
    """Return text that UTF-8 can encode: undecodable bytes of a command line (lone surrogates) are escaped."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


@contextmanager
def atomic_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield the path of a new hidden file that replaces `path` if the block ends without an error.

    Raises
    ------
    CycloidError
        The file cannot be written; an existing file is unchanged.
    """
    with atomic_files([path]) as (new_path,):
        yield new_path


@contextmanager
def atomic_files(paths: Sequence[str | os.PathLike[str]]) -> Iterator[list[Path]]:
    """Yield paths of new hidden files, which replace `paths` all together if the block ends without an error.

    Files that belong together, such as the parts of a model, are never left as a mixture of old and new files. Of a
    symbolic link, the file that it points to is replaced.

    Raises
    ------
    UsageError
        A path has the extension of logs.
    TakenError
        A file exists, and the running command reads it or may not replace it.
    CycloidError
        A file cannot be written; all existing files are unchanged.
    """
    replacements: list[tuple[Path, Path]] = []
    user_path = Path()
    try:
        for user_path in map(Path, paths):
            target = Path(os.path.realpath(user_path))
            with defer_signals():
                replacements.append((_create_hidden_file(target, user_path), target))
        user_path = user_path if len(replacements) == 1 else user_path.parent
        yield [new_path for new_path, _ in replacements]
        with defer_signals():
            for new_path, target in replacements:
                os.replace(new_path, target)
                note_output(target)
    except OSError as problem:
        raise CycloidError(
            f"cannot write {user_path}: {reason(problem)}. Choose a file in a writable folder with free disk space"
        ) from problem
    finally:
        with defer_signals():
            for new_path, _ in replacements:
                with suppress(OSError):
                    new_path.unlink()


def write_files(files: Mapping[Path, bytes]) -> None:
    """Write contents to files by path, all of them or none.

    Raises
    ------
    CycloidError
        A file cannot be written.
    """
    with atomic_files(list(files)) as new_paths:
        for new_path, content in zip(new_paths, files.values(), strict=True):
            new_path.write_bytes(content)


def hidden_path(path: Path) -> Path:
    """Return a hidden name in the folder of `path`, with its ending, that no file has."""
    # not the process's number: in containers the next process has the same one, and a killed one's file may be there
    return path.with_name(f".{path.stem}.{secrets.token_hex(4)}.new{path.suffix}")


def _create_hidden_file(path: Path, user_path: Path) -> Path:
    """Create a hidden file next to `path`, to replace it later, and return the path of the hidden file.

    Errors name the file by `user_path`, as the user wrote it. Raise UsageError for the extension of logs, TakenError if
    the running command must not replace the file, and CycloidError if it is no regular file.
    """
    if path.suffix.lower() == LOG:
        raise UsageError(
            f"cannot write {user_path}: the extension {LOG} is reserved for logs. Choose another extension, such as "
            ".json"
        )
    require_replaceable(user_path)
    if path.exists() and not path.is_file():
        raise CycloidError(f"cannot write {user_path}: it is not a regular file. Choose another file name")
    new_path = hidden_path(path)
    with new_path.open("xb"):
        return new_path


def zip_files(files: Mapping[str, bytes]) -> bytes:
    """Zip files by name, in their order; equal files make equal bytes."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as package:
        for name, file in files.items():
            package.writestr(zipfile.ZipInfo(name, EPOCH), file, zipfile.ZIP_DEFLATED)
    return content.getvalue()
