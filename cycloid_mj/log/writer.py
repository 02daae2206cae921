"""The writer of logs: samples go to disk as the run goes, chunk by chunk."""

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path, PurePath
from types import TracebackType
from typing import BinaryIO

import numpy as np
import numpy.typing as npt
from mcap.writer import Writer

from cycloid_mj.errors import LogError
from cycloid_mj.log.encoding import FORMAT, PACKAGE, Group

Array = npt.NDArray[np.float64]
Groups = Mapping[str, Sequence[tuple[str, str]]]

MEDIA_TYPES = {".json": "application/json", ".toml": "application/toml", ".xml": "application/xml"}
WHOLE_CHUNKS_ONLY = 1 << 62  # mcap's own limit on chunks, out of the way: chunks end here, between two samples


class LogWriter:
    """A log that is being written; a context manager.

    An exception that leaves the ``with`` block closes the log as incomplete and goes on.
    With `force`, the new log is started in a hidden file beside the old one and takes its place only once its
    attachments and metadata are on disk: if that fails, the old log is as it was.

    Parameters
    ----------
    path
        File to write. Refused if it exists, unless `force`.
    groups
        Topic -> (column, unit) pairs; a column name occurs once in all groups.
    provenance
        Flat text about the run.
    attachments
        File name -> content.
    chunk_size
        Uncompressed bytes after which samples are compressed and pushed to the operating system.
    force
        Whether to replace an existing log.

    Raises
    ------
    LogError
        The file exists or cannot be written, or names of columns are wrong or occur twice.
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
    ) -> None:
        self.path = Path(path)
        self.samples = 0
        self._groups = _checked(groups)
        self._on_disk = 0
        self._last = -np.inf
        self._open = True
        size = sum(group.zeros.size for group in self._groups)
        self._chunk = max(1, chunk_size // size)
        preamble = {PACKAGE: {"format": FORMAT}, "provenance": dict(provenance or {})}
        self._stream, self._mcap = _started(self.path, force, preamble, attachments or {})
        self._channels = [
            self._mcap.register_channel(
                group.topic,
                "protobuf",
                self._mcap.register_schema(group.message, "protobuf", group.schema()),
                group.metadata(),
            )
            for group in self._groups
        ]

    def write(self, time: Array, values: Mapping[str, Array]) -> None:
        """Append k samples.

        Parameters
        ----------
        time
            Shape (k,), [s], not negative, increasing on from the last sample written.
        values
            Topic -> shape (k, columns), for every group.

        Raises
        ------
        LogError
            Shapes, topics or times are wrong, or the disk takes no more: the log keeps every chunk before.
        """
        if not self._open:
            raise LogError(f"log {self.path} is closed: open another to write more samples")
        self._check(time, values)
        messages = [group.encode(time, values[group.topic]) for group in self._groups]
        nanoseconds = np.rint(time * 1e9).astype(np.uint64)
        start = 0
        while start < time.size:
            stop = min(time.size, start + self._chunk - self.samples % self._chunk)
            self._append(nanoseconds[start:stop], [block[start:stop] for block in messages])
            start = stop
        self._last = float(time[-1]) if time.size else self._last

    def close(self, note: str = "", complete: bool = True) -> None:
        """Finish the log; `note` says why the run ended early if it is not `complete`. A second call does nothing."""
        if not self._open:
            return
        end = {"complete": "true" if complete else "false", "note": _text(note), "samples": str(self.samples)}
        try:
            self._mcap.flush()
            self._mcap.add_metadata(f"{PACKAGE}.end", end)
            self._mcap.finish()
            self._stream.close()
        except OSError as problem:
            raise self._failed(problem) from problem
        self._open = False

    def __enter__(self) -> "LogWriter":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        if error is None:
            self.close()
            return
        with suppress(LogError):
            self.close(note=f"{type(error).__name__}: {error}".removesuffix(": "), complete=False)

    def _append(self, nanoseconds: npt.NDArray[np.uint64], messages: list[npt.NDArray[np.uint8]]) -> None:
        """Append samples that fit into the chunk being filled."""
        times = nanoseconds.tolist()
        rows = zip(*(_rows(block) for block in messages), strict=True)
        try:
            for time, row in zip(times, rows, strict=True):
                sequence = self.samples & 0xFFFFFFFF
                for channel, message in zip(self._channels, row, strict=True):
                    self._mcap.add_message(channel, time, message, time, sequence)
                self.samples += 1
            if self.samples % self._chunk == 0:
                self._mcap.flush()
                self._on_disk = self.samples
        except OSError as problem:
            raise self._failed(problem) from problem

    def _check(self, time: Array, values: Mapping[str, Array]) -> None:
        topics = [group.topic for group in self._groups]
        if sorted(values) != sorted(topics):
            raise LogError(f"samples for topics {sorted(values)}: log {self.path} takes {sorted(topics)}, all of them")
        if time.ndim != 1:
            raise LogError(f"time of samples has shape {time.shape}: give shape (k,)")
        for group in self._groups:
            if values[group.topic].shape != (time.size, len(group.units)):
                raise LogError(
                    f"samples of {group.topic} have shape {values[group.topic].shape}: "
                    f"give ({time.size}, {len(group.units)}), one row for each time"
                )
        if not (np.isfinite(time).all() and (time >= 0.0).all() and (np.diff(time, prepend=self._last) > 0.0).all()):
            raise LogError(f"times of samples after {self._last} s are not finite, not negative and increasing")

    def _failed(self, problem: OSError) -> LogError:
        self._open = False
        with suppress(OSError):
            self._stream.close()
        return LogError(
            f"cannot write log {self.path}: {problem.strerror or problem}; its first {self._on_disk} samples are on "
            "disk and can be read; make room or choose another folder, then run again"
        )


def _started(
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
        mcap.add_metadata(name, {_text(key): _text(value) for key, value in entries.items()})
    for name, content in attachments.items():
        mcap.add_attachment(0, 0, _text(name), _media_type(name), content)
    mcap.flush()
    return mcap


def _checked(groups: Groups) -> list[Group]:
    """Give the groups in order; raise LogError if there is none or a column occurs twice."""
    if not groups:
        raise LogError("a log needs at least one group of columns: give {'/topic': [(column, unit), ...]}")
    seen: dict[str, str] = {}
    for topic, columns in groups.items():
        for name, _ in columns:
            if name in seen:
                raise LogError(f"column {name!r} of {topic} is in {seen[name]} too: give each column its own name")
            seen[name] = topic
    return [Group(topic, dict(columns)) for topic, columns in groups.items()]


def _rows(block: npt.NDArray[np.uint8]) -> list[bytes]:
    count, size = block.shape
    joined = block.tobytes()
    return [joined[i : i + size] for i in range(0, count * size, size)]


def _media_type(name: str) -> str:
    return MEDIA_TYPES.get(PurePath(name).suffix, "application/octet-stream")


def _text(text: str) -> str:
    """Give text that UTF-8 can hold: odd bytes of a command line come as lone surrogates."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def _exists(path: Path) -> str:
    if path.is_file():
        return f"log {path} exists already: choose another name, or replace it with --force"
    return f"cannot write log {path}: it is no regular file; give the name of a file, such as run.mcap"


def _unwritable(path: Path, problem: OSError) -> str:
    return f"cannot write log {path}: {problem.strerror or problem}; choose a folder that exists and can be written"
