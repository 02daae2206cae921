"""Protection of existing files: a command never replaces a file that it reads, and an earlier result only with --force.

Both writers, `atomic_write` and `log.place`, apply the rule while a command of the command line runs: a command that
claims no file replaces none. In Python, files are replaced as the documentation of each function says.
"""

import os
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from cycloid_mj.base.errors import CycloidError, UsageError

LOG = ".mcap"
HEAD = 2048
"""Bytes at the start of a file that identify its type."""


class Kind(NamedTuple):
    """A type of file: its name, and the first bytes of every such file in small letters."""

    name: str
    start: bytes


KINDS = {
    LOG: Kind("a log", b"\x89mcap0"),
    ".html": Kind("an HTML page", b"<!doctype html"),
    ".json": Kind("a JSON file", b"{"),
    ".svg": Kind("a picture", b"<?xml"),
    ".vtu": Kind("a VTK file", b"<?xml"),
    ".png": Kind("a picture", b"\x89png"),
    ".gif": Kind("a film", b"gif8"),
    ".pdf": Kind("a PDF file", b"%pdf"),
    ".parquet": Kind("a Parquet file", b"par1"),
    ".rrd": Kind("a recording", b"rrf"),
    ".toml": Kind("a design file", b""),
    ".csv": Kind("a table", b""),
}
"""Ending of a name -> what such a file is; where there is no start, files of that kind begin with anything."""

ANY = Kind("a file", b"")

NAMED = re.compile(rb'<title>(.*?)</title>|^name = "(.*?)"|"(?:design|name)": "(.*?)"', re.MULTILINE)
"""Title or name of the content in the first bytes of a file."""


class TakenError(CycloidError):
    """Something is there already that is not to be replaced."""


@dataclass
class _Command:
    """Files of the running command.

    Attributes
    ----------
    read
        Files that it has read, by device and inode.
    replaceable
        Files that it may replace, and folders of which it may replace all files.
    made
        Folders that it has created, from the outside in.
    """

    read: dict[tuple[int, int], Path] = field(default_factory=dict)
    replaceable: set[Path] = field(default_factory=set)
    made: list[Path] = field(default_factory=list)


_command: ContextVar[_Command | None] = ContextVar("command", default=None)


@contextmanager
def command_scope() -> Iterator[None]:
    """Protect existing files from being replaced inside this block, in which a command runs.

    Inside the block, `require_replaceable` refuses files that the command must not replace. At its end, folders that
    the command created and left empty are removed.
    """
    command = _Command()
    token = _command.set(command)
    try:
        yield
    finally:
        _command.reset(token)
        remove_empty(command.made)


def make_folder(path: Path) -> bool:
    """Create a folder and its parents; return whether this call created it, False if it existed before.

    Inside a `command_scope`, folders that the command created are removed again if it leaves them empty.

    Raises
    ------
    OSError
        The folder cannot be created.
    """
    was_created = False
    for folder in reversed([folder for folder in (path, *path.parents) if not folder.exists()]):
        try:
            folder.mkdir()
        except FileExistsError:
            was_created = False
            continue
        was_created = True
        if (command := _command.get()) is not None:
            command.made.append(folder)
    if not path.is_dir():
        raise FileExistsError(f"{path} is a file")
    return was_created


def remove_empty(folders: Iterable[Path]) -> None:
    """Remove those folders that are empty, the last first."""
    for folder in reversed(tuple(folders)):
        with suppress(OSError):
            folder.rmdir()


def note_input(path: Path) -> Path:
    """Note that the command reads a file, and so never writes it; return the path."""
    if (command := _command.get()) is not None:
        with suppress(OSError, ValueError):
            command.read.setdefault(_identity(path), path)
    return path


def note_output(path: Path) -> None:
    """Note that a file, or all of a folder, is the command's own, of this call or of an earlier one."""
    if (command := _command.get()) is not None:
        command.replaceable.add(_real_path(path))
        with suppress(OSError, ValueError):
            command.read.pop(_identity(path), None)


def claim_outputs(*paths: Path, force: bool) -> None:
    """Check before the work begins that output files may be written; `force` allows replacing existing files.

    Raises
    ------
    TakenError
        A file exists, and `force` is False, or it is an input of the command, or its content is of another type than
        the ending of its name says.
    """
    command = _command.get()
    for path in paths:
        if force and command is not None:
            command.replaceable.add(_real_path(path))
        require_replaceable(path)


def require_replaceable(path: Path) -> None:
    """Raise TakenError if a file exists that the running command must not replace.

    These are files that the command reads, files that `claim_outputs` has not released for replacement, and files whose
    content is of another type than the ending of their name. Without a running command, all files may be replaced.
    """
    command = _command.get()
    if command is None or not path.is_file():
        return
    if (input_path := command.read.get(_identity(path))) is not None:
        input_text = "itself" if input_path == path else f"{input_path}, which is the same file"
        raise TakenError(
            f"cannot write {path} over {input_text}, because this command reads that file: choose another file name"
        )
    resolved_path = _real_path(path)
    if command.replaceable.isdisjoint((resolved_path, *resolved_path.parents)):
        raise TakenError(
            f"{path} already exists ({describe_file(path)}): choose another name (--out), or overwrite it with --force"
        )
    _require_same_kind(path)


def require_ending(path: Path, ending: str) -> None:
    """Raise UsageError if a file name has the extension of another kind of file than `ending`, such as ".csv"."""
    suffix = path.suffix.lower()
    if suffix in KINDS and suffix != ending:
        raise UsageError(
            f"cannot write {path}: the extension {suffix} is reserved for {KINDS[suffix].name}. Use the extension "
            f"{ending}"
        )


def describe_file(path: Path) -> str:
    """Describe a file in words: its type, the title or name in its first bytes if there is one, and when it changed."""
    first_bytes = _first_bytes(path)
    expected_kind = _kind_by_name(path)
    kind_name = (
        expected_kind.name
        if _starts_like(first_bytes, expected_kind)
        else _kind_by_content(first_bytes) or expected_kind.name
    )
    match = NAMED.search(first_bytes)
    title = next((group for group in match.groups() if group), b"").decode(errors="replace") if match else ""
    modified = datetime.fromtimestamp(path.stat().st_mtime).isoformat(" ", "minutes")
    return f"{kind_name}{f', {title!r},' if title else ''} of {modified}"


def _require_same_kind(path: Path) -> None:
    """Raise TakenError if an existing file has another type than the ending of its name says, such as a CSV named .png.

    The type is identified by the first bytes. Empty files are accepted. For types without fixed first bytes, such as
    CSV, all files are accepted whose first bytes identify no other type.
    """
    first_bytes, expected_kind = _first_bytes(path), _kind_by_name(path)
    if not first_bytes or (expected_kind.start and _starts_like(first_bytes, expected_kind)):
        return
    if (kind := _kind_by_content(first_bytes)) or expected_kind.start:
        raise TakenError(
            f"cannot write {path}: the existing file is {kind or f'not {expected_kind.name}'}, and only files of the "
            "same type are replaced. Choose another file name"
        )


def _kind_by_name(path: Path) -> Kind:
    """Return the type of a file by its name."""
    return KINDS.get(path.suffix.lower(), ANY)


def _starts_like(head: bytes, kind: Kind) -> bool:
    return head.lower().startswith(kind.start)


def _kind_by_content(head: bytes) -> str:
    """Return the type of a file in words by its first bytes; empty if no type with a fixed start matches."""
    return next((kind.name for kind in KINDS.values() if kind.start and _starts_like(head, kind)), "")


def _first_bytes(path: Path) -> bytes:
    """Read the start of a file, without blanks before it."""
    try:
        with path.open("rb") as stream:
            return stream.read(HEAD).lstrip()
    except OSError:
        return b""


def _identity(path: Path) -> tuple[int, int]:
    """Return device and inode of a file, which are the same under all of its names; raise OSError without a file."""
    status = path.stat()
    return status.st_dev, status.st_ino


def _real_path(path: Path) -> Path:
    return Path(os.path.realpath(path))
