"""The start of a log: its file, and what is written to it before the first sample."""

from collections.abc import Mapping
from pathlib import Path, PurePath
from typing import BinaryIO

from mcap.writer import Writer

from cycloid_mj.log.encoding import PACKAGE
from cycloid_mj.log.place import Place, unwritable

MEDIA_TYPES = {".json": "application/json", ".toml": "application/toml", ".xml": "application/xml"}
WHOLE_CHUNKS_ONLY = 1 << 62  # mcap's own limit on chunks, out of the way: chunks end here, between two samples


def started(
    path: Path,
    force: bool,
    hidden: bool,
    preamble: Mapping[str, Mapping[str, str]],
    attachments: Mapping[str, bytes],
) -> tuple[Place, Writer]:
    """Open the log and write what comes before the samples; leave no trace if that fails."""
    place = Place(path, force, hidden)
    try:
        return place, _begun(place.stream, preamble, attachments)
    except BaseException as problem:
        place.drop()
        if isinstance(problem, OSError):
            raise unwritable(path, problem) from problem
        raise


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
