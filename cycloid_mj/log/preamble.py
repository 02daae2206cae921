"""Metadata at the beginning of a log: they list its contents, so that a truncated log shows what it lacks.

MCAP has no checksum for a metadata record, only one for the data section, which a truncated log lacks.
"""

import json
import zlib
from collections.abc import Iterable, Mapping

from cycloid_mj.base.atomic_write import encodable_text
from cycloid_mj.log.encoding import FORMAT, PACKAGE

PROVENANCE = "provenance"
CHECKSUM, FILES = "provenance_crc32", "attachments"

Metadata = Mapping[str, Mapping[str, str]]


def preamble(provenance: Mapping[str, str], attachments: Iterable[str]) -> dict[str, dict[str, str]]:
    """Return the metadata records at the beginning of a log: name of the record -> its entries.

    The first record, `PACKAGE`, states the format, a checksum of the provenance, and the names of the attachments; the
    second, `PROVENANCE`, is the provenance. Characters that UTF-8 cannot encode are escaped.
    """
    encodable_provenance = {encodable_text(key): encodable_text(value) for key, value in provenance.items()}
    file_names = [encodable_text(name) for name in attachments]
    entries = {"format": FORMAT, CHECKSUM: _checksum(encodable_provenance), FILES: json.dumps(file_names)}
    return {PACKAGE: entries, PROVENANCE: encodable_provenance}


def missing_contents(metadata: Metadata, attachments: Iterable[str]) -> list[str]:
    """Return a phrase for each missing or damaged part of a truncated log, such as "its provenance is missing".

    `metadata` maps the names of the log's metadata records to their values, `attachments` are the names of the
    attachments that were read. Logs of earlier versions have no checksum and no list of attachments; for these logs,
    only missing provenance is reported.
    """
    package_entries, provenance = metadata[PACKAGE], metadata.get(PROVENANCE)
    phrases = []
    if provenance is None:
        phrases.append("its provenance is missing")
    elif package_entries.get(CHECKSUM, _checksum(provenance)) != _checksum(provenance):
        phrases.append("its provenance is damaged")
    try:
        file_names = set(json.loads(package_entries.get(FILES, "[]")))
    except (ValueError, TypeError):
        return [*phrases, "its list of attachments is damaged"]
    return [*phrases, *(f"its {name} is missing" for name in sorted(map(str, file_names - set(attachments))))]


def _checksum(entries: Mapping[str, str]) -> str:
    return f"{zlib.crc32(json.dumps(dict(entries), sort_keys=True).encode()):08x}"
