"""The start of a log: its file, and what is written to it before the first sample."""

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path, PurePath
from typing import BinaryIO

from mcap.writer import Writer

from cycloid_mj.errors import LogError
from cycloid_mj.log.encoding import PACKAGE

MEDIA_TYPES = {".json": "application/json", ".toml": "application/toml", ".xml": "application/xml"}
WHOLE_CHUNKS_ONLY = 1 << 62  # mcap's own limit on chunks, out of the way: chunks end here, between two samples


def started(
    path: Path, force: bool, preamble: Mapping[str, Mapping[str, str]], attachments: Mapping[str, bytes]
) -> tuple[BinaryIO, Writer]:
    """Open the log and write what comes before the samples; leave no trace if that fails."""
    beside = path.with_name(f".{path.name}.{os.getpid()}.new")
    try:
        replace = force and path.is_file()
        stream = beside.open("wb") if replace else path.open("xb")
    except FileExistsError:
        raise LogError(_exists(path)) from None
    except OSError as problem:
        raise LogError(_unwritable(path, problem)) from problem
    try:
        mcap = _begun(stream, preamble, attachments)
        if replace:
            os.replace(beside, path)
    except BaseException as problem:
        with suppress(OSError):
            stream.close()
        with suppress(OSError):
            (beside if replace else path).unlink()
        if isinstance(problem, OSError):
            raise LogError(_unwritable(path, problem)) from problem
        raise
    return stream, mcap


def _begun(stream: BinaryIO, preamble: Mapping[str, Mapping[str, str]], attachments: Mapping[str, bytes]) -> Writer:
    """Write metadata and attachments, and see them leave for the disk."""
    mcap = Writer(stream, chunk_size=WHOLE_CHUNKS_ONLY, enable_data_crcs=True)
    mcap.start(library=PACKAGE)
    for name, entries in preamble.items():
        mcap.add_metadata(name, {storable(key): storable(value) for key, value in entries.items()})
    attach(mcap, attachments)
    mcap.flush()
    return mcap


def attach(mcap: Writer, attachments: Mapping[str, bytes]) -> None:
    """Write files that are kept with the run: name -> content."""
    for name, content in attachments.items():
        mcap.add_attachment(0, 0, storable(name), _media_type(name), content)


def _media_type(name: str) -> str:
    return MEDIA_TYPES.get(PurePath(name).suffix, "application/octet-stream")


def storable(text: str) -> str:
    """Give text that UTF-8 can hold: odd bytes of a command line come as lone surrogates."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def _exists(path: Path) -> str:
    if path.is_file():
        return f"log {path} exists already: choose another name, or replace it with --force"
    return f"cannot write log {path}: it is no regular file; give the name of a file, such as run.mcap"


def _unwritable(path: Path, problem: OSError) -> str:
    return f"cannot write log {path}: {problem.strerror or problem}; choose a folder that exists and can be written"
