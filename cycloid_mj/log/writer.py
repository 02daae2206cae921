"""Writer of logs: chunk by chunk during a run, or an entire run at once."""

import os
import sys
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path, PurePath
from types import TracebackType
from typing import BinaryIO

import numpy as np
import numpy.typing as npt
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import Writer

from cycloid_mj.base.array import Array, Bytes
from cycloid_mj.base.atomic_write import encodable_text
from cycloid_mj.base.errors import LogError, reason
from cycloid_mj.base.interrupt import defer_signals
from cycloid_mj.base.record import Run
from cycloid_mj.log.encoding import PACKAGE, ColumnGroup
from cycloid_mj.log.place import LogFile, LogTakenError, unwritable
from cycloid_mj.log.preamble import Metadata, preamble
from cycloid_mj.log.viewer import RATE, Message, Viewer, select_frames

MEDIA_TYPES = {".json": "application/json", ".toml": "application/toml", ".xml": "application/xml"}

Groups = Mapping[str, Mapping[str, str] | Sequence[tuple[str, str]]]


class LogWriter:
    """A log that is being written; a context manager.

    An exception that leaves the ``with`` block closes the log as incomplete and propagates. With `force`, the new log
    is written next to the old one, to ``<name>.partial.mcap`` (or ``<name>.partial-2.mcap``, ...), and replaces it when
    it is closed as complete. An incomplete log stays there, and the old one remains unchanged.

    Parameters
    ----------
    path
        File to write. It must not exist, unless `force`.
    groups
        Columns with their units, by topic; a column name occurs once in all groups.
    provenance
        Flat text about the run.
    attachments
        Contents of files, by name.
    chunk_size
        Uncompressed size [bytes] at which samples are compressed and written.
    force
        Whether to replace an existing log.
    viewer
        Source of the messages for viewers, such as ``scene.Scene``.
    hidden
        Whether the log appears only when it is closed, complete or not: for a log that is written from memory. A log
        that is not closed leaves no file.

    Raises
    ------
    LogTakenError
        The file exists, without `force`.
    LogError
        Another run is writing the file, it cannot be written, or column names are invalid or occur twice.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        groups: Groups,
        provenance: Mapping[str, str] | None = None,
        attachments: Mapping[str, bytes] | None = None,
        *,
        chunk_size: int = 512 * 1024,
        force: bool = False,
        viewer: Viewer | None = None,
        hidden: bool = False,
    ) -> None:
        """Open the file of a log, and write everything that precedes the samples.

        Parameters
        ----------
        path, groups
            File of the log, and its columns by topic, with units.
        provenance, attachments
            Texts about the run by name, and contents of attached files by name.
        chunk_size
            Approximate size of a chunk [bytes].
        force
            Whether an existing log is replaced.
        viewer
            Source of messages for viewers; None without them.
        hidden
            Whether the file has a hidden name until it is complete.

        Raises
        ------
        LogError
            The file exists or cannot be written, or a topic or column name is invalid.
        """
        self.samples = 0
        self._groups = _column_groups(groups)
        self._flushed_samples = 0
        self._last_time = -np.inf
        self._is_open = True
        message_size = sum(group.zeros.size for group in self._groups)
        self._samples_per_chunk = max(1, chunk_size // message_size)
        metadata = preamble(provenance or {}, attachments or {})
        self._file, self._mcap = _create_log(Path(path), force, hidden, metadata, attachments or {})
        self._channels = [
            _add_channel(
                self._mcap, group.topic, _add_schema(self._mcap, group.message, group.schema()), group.metadata()
            )
            for group in self._groups
        ]
        self._viewer = viewer
        self._frames: Counter[str] = Counter()
        self._viewer_channels = _viewer_channels(self._mcap, viewer) if viewer else {}

    @property
    def path(self) -> Path:
        """Path of the log: the requested one, or another one next to an old log until the log is complete."""
        return self._file.at

    @property
    def name(self) -> Path:
        """The requested path."""
        return self._file.path

    def write(self, time: Array, values: Mapping[str, Array]) -> None:
        """Append k samples of a run to the log.

        Parameters
        ----------
        time
            Shape (k,) [s], not negative and increasing, after the last sample written.
        values
            Values of every group, by topic, shape (k, columns).

        Raises
        ------
        LogError
            Shapes, topics or times are wrong, or the disk is full: the log keeps all chunks written before.
        """
        if not self._is_open:
            raise LogError(f"log {self.path} is closed: open a new log to write more samples")
        self._check_samples(time, values)
        messages = [group.encode(time, values[group.topic]) for group in self._groups]
        nanoseconds = np.rint(time * 1e9).astype(np.uint64)
        viewer_messages = self._viewer_messages(time, values)
        first_row = 0
        while first_row < time.size:
            end_row = min(time.size, first_row + self._samples_per_chunk - self.samples % self._samples_per_chunk)
            self._append_samples(
                nanoseconds[first_row:end_row], [block[first_row:end_row] for block in messages], viewer_messages
            )
            self._last_time = float(time[end_row - 1])
            first_row = end_row

    def flush(self) -> None:
        """Write all samples to the file of the log, so that it can be read to the end; raise LogError on failure."""
        if not self._is_open:
            return
        try:
            self._mcap.flush()
        except OSError as problem:
            raise self._write_error(problem) from problem
        self._flushed_samples = self.samples

    def close(self, note: str = "", complete: bool = True, attachments: Mapping[str, bytes] | None = None) -> None:
        """Finish the log of a run and close its file; a second call does nothing.

        An incomplete log without samples is removed.

        Parameters
        ----------
        note
            Why the run ended early, if it is not `complete`.
        complete
            Whether the run reached its end.
        attachments
            Contents of files that exist only after the run, by name, such as ``findings.json``.

        Raises
        ------
        LogError
            The disk is full: the log keeps all chunks written before. Or the log cannot be renamed.
        """
        if not self._is_open:
            return
        with defer_signals():
            if not complete and not self.samples:
                self._abandon()
                return
            self.flush()
            self._finish_log(note, complete, attachments or {})

    def __enter__(self) -> "LogWriter":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        """Close the log as complete; after an `error`, close it as incomplete, or remove it if it is hidden."""
        if error is None:
            self.close()
            return
        if self._file.hidden:
            self._abandon()
            return
        with suppress(LogError):
            self.close(note=f"{type(error).__name__}: {error}".removesuffix(": "), complete=False)

    def _viewer_messages(self, time: Array, values: Mapping[str, Array]) -> dict[int, list[Message]]:
        """Compute the messages for viewers that belong to k samples, as a mapping from time [ns] to messages.

        `time` has shape (k,) [s], `values` maps topics to arrays of shape (k, columns). Only the samples at the frame
        rate of the viewer have messages. The result is empty if there is no such sample, or no viewer. At the first
        sample of the log, the messages of `Viewer.opening`, which occur once, come first.
        """
        rows = select_frames(time, self._last_time, self._viewer.rate) if self._viewer else ()
        if not (self._viewer and len(rows)):
            return {}
        columns = {
            name: values[group.topic][rows, column] for group in self._groups for column, name in enumerate(group.units)
        }
        opening = self._viewer.opening(float(time[0])) if self.samples == 0 else ()
        messages_by_time: dict[int, list[Message]] = defaultdict(list)
        for message in chain(opening, self._viewer.frames(time[rows], columns)):
            messages_by_time[message[1]].append(message)
        return messages_by_time

    def _append_samples(
        self, nanoseconds: npt.NDArray[np.uint64], messages: list[Bytes], viewer_messages: Mapping[int, list[Message]]
    ) -> None:
        """Append k samples that fit into the current chunk; flush the chunk if it is full.

        `nanoseconds` are the times of the samples [ns], shape (k,). `messages` has an array (k, bytes of a message) for
        each group. `viewer_messages` maps times [ns] to messages for viewers, which are written before the sample.
        """
        for sample, time in enumerate(nanoseconds.tolist()):
            for topic, _, content in viewer_messages.get(time, ()):
                self._add_message(self._viewer_channels[topic], time, content, self._frames[topic])
                self._frames[topic] += 1
            for channel, block in zip(self._channels, messages, strict=True):
                self._add_message(channel, time, block[sample].tobytes(), self.samples)
            self.samples += 1
        if self.samples % self._samples_per_chunk == 0:
            self.flush()

    def _add_message(self, channel: int, time: int, content: bytes, sequence: int) -> None:
        self._mcap.add_message(channel, time, content, time, sequence & 0xFFFFFFFF)

    def _check_samples(self, time: Array, values: Mapping[str, Array]) -> None:
        """Raise LogError unless topics, shapes and times of the samples to be logged are valid.

        `time` (k,) [s] are the times of k samples. `values` are their values by topic, of shape (k, columns).
        """
        topics = [group.topic for group in self._groups]
        if sorted(values) != sorted(topics):
            raise LogError(
                f"the samples have the topics {sorted(values)}, but the log {self.path} has {sorted(topics)}: pass "
                "samples with exactly the topics of the log"
            )
        if time.ndim != 1:
            raise LogError(
                f"the sample times have shape {time.shape}: pass a 1-D array of shape (k,) with one time per sample"
            )
        for group in self._groups:
            if values[group.topic].shape != (time.size, len(group.units)):
                raise LogError(
                    f"the samples of {group.topic} have shape {values[group.topic].shape}: pass an array of shape "
                    f"({time.size}, {len(group.units)}) with one row per sample"
                )
        self._check_order(time)

    def _check_order(self, time: Array) -> None:
        """Raise LogError unless sample times (k,) [s] are finite, strictly increasing and later than those before."""
        if invalid_indices := np.flatnonzero(~np.isfinite(time)).tolist():
            raise LogError(
                f"the sample time at index {invalid_indices[0]} is {time[invalid_indices[0]]:g}: pass finite times in "
                "seconds"
            )
        if time.size and (time[0] < 0.0 or time[0] <= self._last_time):
            condition = "of at least 0 s" if self._last_time < 0.0 else f"later than {self._last_time:g} s"
            raise LogError(f"the first sample time, {time[0]:g} s, is too early: pass times {condition}")
        if unordered_indices := np.flatnonzero(np.diff(time) <= 0.0).tolist():
            raise LogError(
                f"the sample time at index {unordered_indices[0] + 1}, {time[unordered_indices[0] + 1]:g} s, is not "
                f"later than the time before it, {time[unordered_indices[0]]:g} s: pass strictly increasing times"
            )

    def _finish_log(self, note: str, complete: bool, attachments: Mapping[str, bytes]) -> None:
        """Write the attached files and the metadata at the end of the log, and rename the file to its final name.

        `note` states why the run ended early, unless it is `complete`; `attachments` are the contents by name.
        """
        end_entries = {
            "complete": "true" if complete else "false",
            "note": encodable_text(note),
            "samples": str(self.samples),
        }
        try:
            _attach(self._mcap, attachments)
            self._mcap.add_metadata(f"{PACKAGE}.end", end_entries)
            self._mcap.finish()
            self._file.finish(complete or self._file.hidden)
        except OSError as problem:
            raise self._write_error(problem) from problem
        except LogTakenError:
            self._abandon()
            raise
        self._is_open = False

    def _abandon(self) -> None:
        self._is_open = False
        self._file.drop()

    def _write_error(self, problem: OSError) -> LogError:
        """Close the log after a failed write and return the error for the user.

        The error states the `problem` and the number of samples on disk.
        """
        if self._file.hidden:
            self._abandon()
            return LogError(
                f"cannot write log {self._file.path}: {reason(problem)}. Free disk space, or choose another folder "
                "with --out"
            )
        self._is_open = False
        self._file.leave()
        return LogError(
            f"cannot write log {self.path}: {reason(problem)}. Its first {self._flushed_samples} samples can be read. "
            "Free disk space, or choose another folder with --out, then simulate the design again"
        )


def write(run: Run, path: str | os.PathLike[str], viewer: Viewer | None = None, *, force: bool = False) -> None:
    """Write an entire run as a log: all topics, the provenance and all attachments.

    The file appears when it is complete.

    Parameters
    ----------
    run
        Run from memory or from a log; an incomplete run stays incomplete, with its note.
    path
        File to write. It must not exist, unless `force`.
    viewer
        Source of the messages for viewers; without it the log has none.
    force
        Whether to replace an existing log.

    Raises
    ------
    LogError
        The file exists or cannot be written.
    """
    with LogWriter(path, run.groups, run.provenance, run.attachments, force=force, viewer=viewer, hidden=True) as log:
        log.write(run.time, {topic: run.block(names) for topic, names in run.topics.items()})
        log.close(run.note, run.complete)


def _create_log(
    path: Path,
    force: bool,
    hidden: bool,
    metadata: Metadata,
    attachments: Mapping[str, bytes],
) -> tuple[LogFile, Writer]:
    """Open the file of a log and write metadata and attachments; return the file and its MCAP writer.

    If that fails, the file is removed. `path`, `force`, `hidden` and `attachments` are as in `LogWriter`; `metadata` is
    the result of `preamble`.

    Raises
    ------
    LogError
        The file exists, another process writes it, or it cannot be written.
    """
    log_file = LogFile(path, force, hidden)
    try:
        return log_file, _write_preamble(log_file.stream, metadata, attachments)
    except BaseException as problem:
        log_file.drop()
        if isinstance(problem, OSError):
            raise unwritable(path, problem) from problem
        raise


def _write_preamble(stream: BinaryIO, metadata: Metadata, attachments: Mapping[str, bytes]) -> Writer:
    """Write metadata and attachments to a stream; return the MCAP writer, whose chunks end only at its `flush`."""
    mcap = Writer(stream, chunk_size=sys.maxsize, enable_data_crcs=True)
    mcap.start(library=PACKAGE)
    for name, entries in metadata.items():
        mcap.add_metadata(name, dict(entries))
    _attach(mcap, attachments)
    mcap.flush()
    return mcap


def _attach(mcap: Writer, attachments: Mapping[str, bytes]) -> None:
    """Write attachments, contents by name."""
    for name, content in attachments.items():
        media_type = MEDIA_TYPES.get(PurePath(name).suffix, "application/octet-stream")
        mcap.add_attachment(0, 0, encodable_text(name), media_type, content)


def _viewer_channels(mcap: Writer, viewer: Viewer) -> dict[str, int]:
    """Add the topics of a viewer and return their channels."""
    schemas = {name: _add_schema(mcap, name, schema) for name, schema in viewer.schemas.values()}
    metadata = {RATE: repr(viewer.rate)}
    return {topic: _add_channel(mcap, topic, schemas[name], metadata) for topic, (name, _) in viewer.schemas.items()}


def _add_schema(mcap: Writer, name: str, schema: bytes) -> int:
    schema_id: int = mcap.register_schema(name, SchemaEncoding.Protobuf, schema)
    return schema_id


def _add_channel(mcap: Writer, topic: str, schema: int, metadata: dict[str, str]) -> int:
    channel_id: int = mcap.register_channel(topic, MessageEncoding.Protobuf, schema, metadata)
    return channel_id


def _column_groups(groups: Groups) -> list[ColumnGroup]:
    """Convert logged topics with their columns and units to groups of columns, in order.

    Raises
    ------
    LogError
        There is no group, a column name occurs twice, or a topic or column name is invalid.
    """
    if not groups:
        raise LogError("the log has no columns: pass at least one group of columns, {'/topic': [(column, unit), ...]}")
    topic_by_column: dict[str, str] = {}
    for topic, columns in groups.items():
        for name in columns if isinstance(columns, Mapping) else [name for name, _ in columns]:
            if name in topic_by_column:
                raise LogError(
                    f"column {name!r} occurs in {topic} and in {topic_by_column[name]}, but column names must be "
                    "unique: rename one of the two"
                )
            topic_by_column[name] = topic
    return [ColumnGroup(topic, dict(columns)) for topic, columns in groups.items()]
