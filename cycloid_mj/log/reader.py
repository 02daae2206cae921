"""Reader of logs: from an MCAP file, complete or truncated, to a `Run`."""

import os
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from mcap.opcode import Opcode

from cycloid_mj.base.array import Array, Bytes, Integers
from cycloid_mj.base.deprecated import deprecated_attribute
from cycloid_mj.base.errors import LogError, NoLogError, reason
from cycloid_mj.base.overwrite_guard import note_input
from cycloid_mj.base.record import Run
from cycloid_mj.log import container
from cycloid_mj.log.encoding import FORMAT, PACKAGE, TIME, ColumnGroup, group_of
from cycloid_mj.log.preamble import PROVENANCE, missing_contents
from cycloid_mj.log.viewer import RATE

END = f"{PACKAGE}.end"

GROWTH = 1.1
"""Growth factor of a column buffer."""


@dataclass(frozen=True)
class ViewerTopic:
    """A topic for viewers: name of its schema, number of messages, and frames per second if the log states them."""

    schema: str
    messages: int
    rate: float | None


@dataclass(frozen=True)
class Log:
    """A log as a file.

    Attributes
    ----------
    run
        The run.
    viewers
        Topics for viewers, by name.
    complete
        Whether the file is complete, that is, not truncated.
    size
        Size of the file [bytes].
    """

    run: Run
    viewers: Mapping[str, ViewerTopic]
    complete: bool
    size: int
    whole = deprecated_attribute("Log", "whole", "complete")


class _GroupSamples:
    """The samples of a group while they are read: times and columns in arrays that grow in place.

    No number is in memory twice. If `rows` (indices of samples, increasing) are given, only these samples are kept.
    """

    def __init__(self, rows: Integers | None = None) -> None:
        self.count, self._rows, self._kept = 0, rows, 0
        self._columns: list[Array] = []

    def add(self, group: ColumnGroup, block: Bytes, path: Path) -> None:
        """Append the samples of a block of message records, shape (k, bytes of a record), to the columns of a group.

        The sequence numbers must continue those of the previous block. If the constructor was called with `rows`, only
        the samples with these indices are kept.

        Raises
        ------
        LogError
            A message is malformed, or a message is missing since the previous block.
        """
        header_size = container.MESSAGE_HEAD.itemsize
        with container.convert_parse_errors(path, f"malformed messages of {group.topic}"):
            records = group.decode(block[:, header_size:])
        sequence = block[:, :header_size].view(container.MESSAGE_HEAD)["sequence"][:, 0]
        end_count = self.count + len(records)
        if (sequence != np.arange(self.count, end_count).astype(np.uint32)).any():
            raise container.corrupt_log_error(path, f"messages of {group.topic} are missing or out of order")
        if self._rows is not None:
            records = records[self._rows[(self._rows >= self.count) & (self._rows < end_count)] - self.count]
        field_names, end_row = (TIME, *group.units), self._kept + len(records)
        self._columns = self._columns or [np.empty(0) for _ in field_names]
        for name, column in zip(field_names, self._columns, strict=True):
            if column.size < end_row:
                column.resize(int(GROWTH * end_row), refcheck=False)
            column[self._kept : end_row] = records[name]
        self.count, self._kept = end_count, end_row

    def finish(self, samples: int) -> list[Array]:
        """Return the times [s] of this group and then each of its columns, all of shape (k,).

        The arrays contain the first `samples` samples of the log, or those of the selected rows with indices below
        `samples`. The arrays are read-only, so that a `Run` need not copy them.
        """
        kept_count = samples if self._rows is None else int(np.count_nonzero(self._rows < samples))
        for column in self._columns:
            column.resize(kept_count, refcheck=False)
            column.flags.writeable = False
        return self._columns


@dataclass(frozen=True)
class _Contents:
    """Contents of a file: metadata and attachments by name, the others by their ids in the file.

    Groups of the topics in `excluded_topics` are skipped, and so are samples that are not in `rows`, if these are
    given.
    """

    excluded_topics: Collection[str]
    rows: Integers | None
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    schemas: dict[int, Any] = field(default_factory=dict)
    channels: dict[int, Any] = field(default_factory=dict)
    groups: dict[int, ColumnGroup] = field(default_factory=dict)
    counts: Counter[int] = field(default_factory=Counter)
    samples: "dict[int, _GroupSamples]" = field(default_factory=dict)


def read(path: str | os.PathLike[str], without: Collection[str] = (), rows: Integers | None = None) -> Run:
    """Read the run of a log.

    If the log was truncated by a killed process or a full disk, the samples of all complete chunks are read. The run is
    then incomplete, and its note states its last time.

    Parameters
    ----------
    path
        The log, an MCAP file of `write` or of ``cycloid-mj simulate``.
    without
        Topics to skip, such as ``/forces``, which is the largest part of a long run.
    rows
        Indices of the samples to read, from 0, increasing, shape (k,); by default all.

    Returns
    -------
    Run
        Signals, forces, provenance and attachments of the run.

    Raises
    ------
    LogError
        The file does not exist, is not a log of this package or has another format version, is corrupt, or contains
        no samples.
    """
    return load(path, without, rows).run


def load(path: str | os.PathLike[str], without: Collection[str] = (), rows: Integers | None = None) -> Log:
    """Read a log: its run, its viewer topics, whether the file is complete, and its size.

    `without` are topics to skip, such as ``/forces``, and `rows` (k,) are the indices of the samples to read, by
    default all.

    Raises
    ------
    LogError
        The file does not exist, is not a log of this package or has another format version, is corrupt, or is empty.
    """
    path, contents = Path(path), _Contents(without, rows)
    try:
        with _open_existing_log(path) as stream:
            is_complete = _read_records(stream, path, contents)
            file_size = stream.seek(0, os.SEEK_END)
    except OSError as problem:
        raise LogError(
            f"cannot read log {path}: {reason(problem)}. Choose a readable log that `cycloid-mj simulate` wrote"
        ) from problem
    sample_counts = [contents.samples[channel].count for channel in contents.groups]
    sample_count = min(sample_counts, default=0)
    if is_complete:
        _check_sample_count(contents, sample_counts, path)
    if sample_count == 0:
        raise LogError(
            f"log {path} contains no samples, because the run was stopped too early: simulate the design again"
        )
    run = _make_run(contents, sample_count, is_complete, path)
    return Log(run, _viewer_topics(contents), is_complete, file_size)


def _open_existing_log(path: Path) -> BinaryIO:
    """Open a log for reading; if it is not a readable file, raise LogError, with the names of similar files."""
    if not path.exists():
        raise NoLogError(f"log {path} does not exist: {_nearest_logs_text(path)}")
    if not path.is_file():
        kind = "a folder" if path.is_dir() else "not a regular file"
        raise NoLogError(f"{path} is {kind}: choose a log file, such as run.mcap")
    if path.stat().st_size == 0:
        raise LogError(f"log {path} is empty, because the run was stopped too early: simulate the design again")
    return note_input(path).open("rb")


def _nearest_logs_text(path: Path) -> str:
    """Name the logs in the folder of a missing log whose names are nearest, for its error message."""
    if not path.parent.is_dir():
        return f"there is no folder {path.parent} either"
    log_names = sorted(entry.name for entry in path.parent.glob("*.mcap"))
    nearest_names = get_close_matches(path.name, log_names, n=3, cutoff=0.3) or log_names[:3]
    return (
        f"nearest in that folder: {', '.join(nearest_names)}"
        if nearest_names
        else "there is no .mcap file in that folder"
    )


def _read_records(stream: BinaryIO, path: Path, contents: _Contents) -> bool:
    """Read all records of an open log, `stream`, into `contents`; return whether the file is complete.

    `path` names the file in errors. If metadata records have the same name, the first is kept; if attachments have the
    same name, the last is kept.

    Raises
    ------
    LogError
        A record is malformed, or the file is not a log of this format.
    """
    is_complete = False
    for record in container.read_records(stream, path):
        if record.opcode == Opcode.METADATA:
            name, entries = container.read_metadata(record, path)
            contents.metadata.setdefault(name, entries)
        elif record.opcode == Opcode.ATTACHMENT:
            name, content = container.read_attachment(record, path)
            contents.attachments[name] = content
        elif record.opcode == Opcode.CHUNK:
            _require_log_format(contents, path)
            _add_messages(contents, container.read_chunk(record, path), path)
        is_complete = record.opcode == Opcode.DATA_END
    _require_log_format(contents, path)
    return is_complete


def _require_log_format(contents: _Contents, path: Path) -> None:
    """Raise LogError if `contents` are of an MCAP file of another program, or of an unknown format version."""
    if PACKAGE not in contents.metadata:
        raise LogError(
            f"{path} is an MCAP file, but not a log of cycloid_mj (it has no metadata {PACKAGE!r}): choose a log that "
            "`cycloid-mj simulate` wrote"
        )
    version = contents.metadata[PACKAGE].get("format")
    if version != FORMAT:
        raise LogError(
            f"log {path} has format {version!r}, but this version of cycloid_mj reads {FORMAT!r}: read it with the "
            "version that wrote it, or simulate the design again"
        )


def _add_messages(contents: _Contents, messages: container.Messages, path: Path) -> None:
    """Add schemas, channels and samples of a chunk to the contents of a log, except the samples of excluded topics.

    The messages of topics for viewers are only counted. `path` names the file in errors.

    Raises
    ------
    LogError
        A schema is malformed, or the messages of a group are malformed, missing or of different lengths.
    """
    contents.schemas.update(messages.schemas)
    contents.channels.update(messages.channels)
    contents.counts.update(messages.counts)
    for channel_id, channel in messages.channels.items():
        is_known = channel_id in contents.groups or channel.topic in contents.excluded_topics
        if "units" in channel.metadata and not is_known:
            with container.convert_parse_errors(path, f"malformed schema of {channel.topic}"):
                contents.groups[channel_id] = group_of(channel, contents.schemas[channel.schema_id])
            contents.samples[channel_id] = _GroupSamples(contents.rows)
    for channel_id, group in contents.groups.items():
        if channel_id in messages.ragged:
            raise container.corrupt_log_error(path, f"messages of {group.topic} differ in length")
        if channel_id in messages.rows:
            contents.samples[channel_id].add(group, messages.rows[channel_id], path)


def _viewer_topics(contents: _Contents) -> dict[str, ViewerTopic]:
    """Return the topics of a log for viewers: name of the topic -> schema, number of messages and frame rate.

    `contents` are those of the log file. A topic is for viewers if the metadata of its channel contain no units.
    """
    viewers = {}
    for channel_id, channel in contents.channels.items():
        if "units" not in channel.metadata:
            schema = contents.schemas.get(channel.schema_id)
            rate = _parse_float(channel.metadata.get(RATE, ""))
            viewers[channel.topic] = ViewerTopic(schema.name if schema else "", contents.counts[channel_id], rate)
    return viewers


def _parse_float(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _check_sample_count(contents: _Contents, sample_counts: list[int], path: Path) -> None:
    """Raise LogError unless each group of a complete file has the number of messages that is stated at its end."""
    stated_count = contents.metadata.get(END, {}).get("samples")
    if any(str(sample_count) != stated_count for sample_count in sample_counts):
        raise container.corrupt_log_error(path, f"it should have {stated_count} samples and has {min(sample_counts)}")


def _make_run(contents: _Contents, sample_count: int, is_complete: bool, path: Path) -> Run:
    """Return the run in a log that has been read: all columns of its topics over their common times.

    Parameters
    ----------
    contents
        Contents of the file. Each of its `groups` describes the columns of a topic.
    sample_count
        Number of samples of the log that are used from the first on: all topics have them. If only some rows were
        selected, the run has those among these samples.
    is_complete
        Whether the file is complete. The run of a truncated file is incomplete, and its note states its last time and
        what the file lacks. A run that ended early is incomplete in a complete file, too.
    path
        The file, for messages and as the name of the run.

    Raises
    ------
    LogError
        Two topics differ in their times, or have a column of the same name.
    """
    groups = contents.groups
    columns_by_group = {channel_id: contents.samples[channel_id].finish(sample_count) for channel_id in groups}
    time, *times_of_other_groups = (times for times, *_ in columns_by_group.values())
    if any((times != time).any() for times in times_of_other_groups):
        raise container.corrupt_log_error(path, "the sampling times of its topics differ")
    units = {name: unit for group in groups.values() for name, unit in group.units.items()}
    if len(units) != sum(len(group.units) for group in groups.values()):
        raise container.corrupt_log_error(path, "a column occurs in two topics")
    columns = {
        name: values
        for channel_id, (_, *group_columns) in columns_by_group.items()
        for name, values in zip(groups[channel_id].units, group_columns, strict=True)
    }
    end_entries = contents.metadata.get(END, {})
    note, is_finished = end_entries.get("note", ""), end_entries.get("complete") == "true"
    if not is_complete:
        truncation_note = f"the log is truncated: {sample_count} samples, up to {time[-1]:.9g} s, could be read"
        missing_phrases = missing_contents(contents.metadata, contents.attachments)
        note, is_finished = "; ".join(filter(None, (note, truncation_note, *missing_phrases))), False
    try:
        provenance = contents.metadata.get(PROVENANCE, {})
        topics = {group.topic: tuple(group.units) for group in groups.values()}
        return Run(time, columns, units, provenance, contents.attachments, is_finished, note, topics, str(path))
    except LogError as problem:
        raise container.corrupt_log_error(path, str(problem)) from problem
