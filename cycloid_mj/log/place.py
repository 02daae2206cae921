"""File and name of a log while it is written: an old log of the same name stays until the new one is complete.

A lock on the file of that name excludes other writers.
"""

import os
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from itertools import count
from pathlib import Path
from typing import BinaryIO

from cycloid_mj.base.atomic_write import hidden_path
from cycloid_mj.base.errors import LogError, reason
from cycloid_mj.base.file_lock import lock_file
from cycloid_mj.base.overwrite_guard import LOG, claim_outputs, require_ending


class LogTakenError(LogError):
    """A log of this name exists already."""


class LogFile:
    """A log's file while it is written.

    Attributes
    ----------
    path
        Path of the complete log.
    at
        Its path now: `path` from the beginning if there was no log, otherwise that of a partial file.
    stream
        Stream of the file.
    hidden
        Whether the log appears only when it is complete, as one that is written from memory.

    Raises
    ------
    LogTakenError
        A log exists at `path`, without `force`.
    LogError
        Another run is writing the log at `path`, or it cannot be written.
    TakenError
        The file at `path` is an input of the running command, or not a log.
    UsageError
        The name has the extension of another kind of file.
    """

    def __init__(self, path: Path, force: bool, hidden: bool) -> None:
        """Open a new file for the log, and lock it against other writers.

        `path` is the name of the log. With `force` an existing log is replaced; a `hidden` log has a hidden name until
        it is complete.

        Raises
        ------
        LogError
            The file exists, another process writes it, or it cannot be created.
        """
        require_ending(path, LOG)
        if force:
            claim_outputs(path, force=True)
        self.path, self.hidden = path, hidden
        self._replaces = force and path.is_file()
        self._locks = ExitStack()
        try:
            if path.exists() and not self._replaces:
                raise FileExistsError
            if self._replaces:
                self._locks.callback(lock_file(path))
            self.at, self.stream = self._open_new()
        except BlockingIOError:
            raise LogError(
                f"another run is writing the log {path}: wait until it ends, or choose another folder with --out"
            ) from None
        except FileExistsError:
            raise _taken_error(path) from None
        except OSError as problem:
            self._locks.close()
            raise unwritable(path, problem) from problem

    def finish(self, complete: bool) -> None:
        """Close the file of a log and, if the log is `complete`, rename the file to the name of the log.

        Raises
        ------
        LogTakenError
            Another process has written a log of that name in the meantime, and it is not to be replaced.
        OSError
            The disk is full, or the file cannot be renamed.
        """
        self.stream.close()
        if complete and self.at != self.path:
            if not self._replaces:
                self._claim()
            os.replace(self.at, self.path)
            self.at = self.path
        self._locks.close()

    def drop(self) -> None:
        """Close the file and remove it; an old log stays."""
        self.leave()
        with suppress(OSError):
            self.at.unlink()

    def leave(self) -> None:
        """Close the file as it is, even if some of it cannot be written."""
        with suppress(OSError):
            self.stream.close()
        self._locks.close()

    def _open_new(self) -> tuple[Path, BinaryIO]:
        """Create the file in which a new log is written, and lock it.

        A log that replaces another log is written under the first unused name of `_partial_names`, such as
        ``run.partial.mcap``. A hidden log is written under a hidden name, which is unique and needs no lock. Any other
        log has its final name from the beginning.

        Returns
        -------
        tuple
            Path and stream of the file.

        Raises
        ------
        FileExistsError
            There is a log already, and it is not to be replaced.
        OSError
            The file cannot be created.
        """
        if self.hidden:
            partial_path = hidden_path(self.path)
            return partial_path, partial_path.open("xb")
        for partial_path in _partial_names(self.path) if self._replaces else [self.path]:
            try:
                stream = partial_path.open("xb")
            except FileExistsError:
                if self._replaces:
                    continue
                raise
            self._locks.callback(lock_file(partial_path))
            return partial_path, stream
        raise AssertionError("there is always another number")

    def _claim(self) -> None:
        try:
            self.path.open("xb").close()
        except FileExistsError:
            raise _taken_error(self.path) from None


def _partial_names(path: Path) -> Iterator[Path]:
    """Yield names for an incomplete log: ``run.partial.mcap``, ``run.partial-2.mcap``, and so on."""
    yield path.with_name(f"{path.stem}.partial{path.suffix}")
    for number in count(2):
        yield path.with_name(f"{path.stem}.partial-{number}{path.suffix}")


def _taken_error(path: Path) -> LogError:
    if path.is_file():
        return LogTakenError(f"log {path} already exists: choose another name with --out, or overwrite it with --force")
    return LogError(f"cannot write log {path}: it is not a regular file. Choose another file name, such as run.mcap")


def unwritable(path: Path, problem: OSError) -> LogError:
    """Return the error for a log that cannot be written."""
    return LogError(f"cannot write log {path}: {reason(problem)}. Choose a writable folder with free disk space")
