"""What a log holds besides samples, as its first record tells: so a cut log knows what it has lost.

MCAP has no checksum for a metadata record, only one for the whole data section, which a cut log does not have.
"""

import json
import zlib
from collections.abc import Iterable, Mapping

from cycloid_mj.base.atomic_write import storable
from cycloid_mj.log.encoding import FORMAT, PACKAGE

PROVENANCE = "provenance"
CHECKSUM, FILES = "provenance_crc32", "attachments"

Metadata = Mapping[str, Mapping[str, str]]


def preamble(provenance: Mapping[str, str], attachments: Iterable[str]) -> dict[str, dict[str, str]]:
    """Return the metadata that a log begins with: name of the record -> entries, of text that UTF-8 can hold."""
    stored = {storable(key): storable(value) for key, value in provenance.items()}
    names = [storable(name) for name in attachments]
    entries = {"format": FORMAT, CHECKSUM: _checksum(stored), FILES: json.dumps(names)}
    return {PACKAGE: entries, PROVENANCE: stored}


def lost(metadata: Metadata, attachments: Iterable[str]) -> list[str]:
    """Name what a cut log should hold and does not; a log of an earlier version can lack its provenance alone."""
    package, stored = metadata[PACKAGE], metadata.get(PROVENANCE)
    missing = []
    if stored is None:
        missing.append("its provenance is missing")
    elif package.get(CHECKSUM, _checksum(stored)) != _checksum(stored):
        missing.append("its provenance is damaged")
    try:
        names = set(json.loads(package.get(FILES, "[]")))
    except (ValueError, TypeError):
        return [*missing, "which files it should hold is damaged"]
    return [*missing, *(f"its {name} is missing" for name in sorted(map(str, names - set(attachments))))]


def _checksum(entries: Mapping[str, str]) -> str:
    return f"{zlib.crc32(json.dumps(dict(entries), sort_keys=True).encode()):08x}"
