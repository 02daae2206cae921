"""What a log holds besides samples, as its first record tells: so a cut log knows what it has lost.

MCAP has no checksum for a metadata record, only one for the whole data section, which a cut log does not have.
"""

import json
import zlib
from collections.abc import Iterable, Mapping

from cycloid_mj.log.encoding import FORMAT, PACKAGE

PROVENANCE = "provenance"
CHECKSUM, FILES = "provenance_crc32", "attachments"

Metadata = Mapping[str, Mapping[str, str]]


def preamble(provenance: Mapping[str, str], attachments: Iterable[str]) -> dict[str, dict[str, str]]:
    """Return the metadata that a log begins with: name of the record -> entries, of text that UTF-8 can hold."""
    own = {storable(key): storable(value) for key, value in provenance.items()}
    names = [storable(name) for name in attachments]
    told = {"format": FORMAT, CHECKSUM: _checksum(own), FILES: json.dumps(names)}
    return {PACKAGE: told, PROVENANCE: own}


def lost(metadata: Metadata, attachments: Iterable[str]) -> list[str]:
    """Name what a cut log should hold and does not; a log of an earlier version can lack its provenance alone."""
    told, own = metadata[PACKAGE], metadata.get(PROVENANCE)
    found = []
    if own is None:
        found.append("its provenance is missing")
    elif told.get(CHECKSUM, _checksum(own)) != _checksum(own):
        found.append("its provenance is damaged")
    try:
        names = set(json.loads(told.get(FILES, "[]")))
    except (ValueError, TypeError):
        return [*found, "which files it should hold is damaged"]
    return [*found, *(f"its {name} is missing" for name in sorted(map(str, names - set(attachments))))]


def storable(text: str) -> str:
    """Return text that UTF-8 can hold: odd bytes of a command line come as lone surrogates."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def _checksum(entries: Mapping[str, str]) -> str:
    return f"{zlib.crc32(json.dumps(dict(entries), sort_keys=True).encode()):08x}"
