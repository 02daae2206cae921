"""Where a log is written, and the name that it gets: an old log of that name stays until the new one is whole.

Writers of one log keep each other out by a lock on the file that bears its name (``flock``). The system lets go of the
lock when a process ends, however it ends.
"""

import errno
import os
from collections.abc import Iterator
from contextlib import suppress
from itertools import count
from pathlib import Path
from typing import BinaryIO

from cycloid_mj.base.atomic_write import hidden_beside
from cycloid_mj.base.errors import LogError, reason
from cycloid_mj.base.overwrite_guard import LOG, claim, require_ending


class LogTakenError(LogError):
    """There is a log of this name already."""


class LogFile:
    """A log's file while it is written.

    Attributes
    ----------
    path
        The name that the log has once it is complete.
    at
        Where it is now: at `path` from the start if no log was there; else at a name of its own.
    stream
        Takes the log's bytes.
    hidden
        Whether nobody is to see the log before it is whole, as one that is written anew from memory.

    Raises
    ------
    LogTakenError
        There is a log at `path`, and it is not to be replaced.
    LogError
        Another run is writing the log at `path`, or it cannot be written.
    TakenError
        The running command reads the file at `path`, or that is no log.
    UsageError
        The name has the ending of another kind of file.
    """

    def __init__(self, path: Path, force: bool, hidden: bool) -> None:
        require_ending(path, LOG)
        if force:
            claim(path, force=True)
        self.path, self.hidden = path, hidden
        self._replaces = force and path.is_file()
        self._old: BinaryIO | None = None
        try:
            if path.exists() and not self._replaces:
                raise FileExistsError
            self._old = _locked(path) if self._replaces else None
            self.at, self.stream = self._opened()
        except BlockingIOError:
            raise LogError(
                f"another run is writing log {path}: wait until it has ended, or give another folder"
            ) from None
        except FileExistsError:
            raise _taken(path) from None
        except OSError as problem:
            self._let_go()
            raise unwritable(path, problem) from problem

    def finish(self, complete: bool) -> None:
        """Close the file; give it the log's name if it is `complete` and does not have it yet.

        Raises
        ------
        LogTakenError
            Meanwhile a log of that name has come that was not to be replaced.
        OSError
            The disk takes no more, or the file cannot be renamed.
        """
        self.stream.close()
        if complete and self.at != self.path:
            if not self._replaces:
                self._claim()
            os.replace(self.at, self.path)
            self.at = self.path
        self._let_go()

    def drop(self) -> None:
        """Close the file and remove it; an old log stays."""
        self.leave()
        with suppress(OSError):
            self.at.unlink()

    def leave(self) -> None:
        """Close the file as it is, whatever becomes of what was not written yet."""
        with suppress(OSError):
            self.stream.close()
        self._let_go()

    def _opened(self) -> tuple[Path, BinaryIO]:
        if self.hidden:
            at = hidden_beside(self.path)
            return at, at.open("xb")
        for at in _partial_names(self.path) if self._replaces else [self.path]:
            try:
                stream = at.open("xb")
            except FileExistsError:
                if self._replaces:
                    continue
                raise
            _lock(stream)
            return at, stream
        raise AssertionError("there is always another number")

    def _claim(self) -> None:
        try:
            self.path.open("xb").close()
        except FileExistsError:
            raise _taken(self.path) from None

    def _let_go(self) -> None:
        if self._old:
            self._old.close()


def _partial_names(path: Path) -> Iterator[Path]:
    """Yield names for the samples of a log that is not complete: those of an earlier one are kept."""
    yield path.with_name(f"{path.stem}.partial{path.suffix}")
    for number in count(2):
        yield path.with_name(f"{path.stem}.partial-{number}{path.suffix}")


def _locked(path: Path) -> BinaryIO:
    """Open the log that is to be replaced, and lock it; raise BlockingIOError if another run writes or replaces it."""
    while True:
        stream = path.open("rb")
        try:
            _lock(stream)
            # another run may have replaced it between the two calls before
            if os.path.samestat(os.fstat(stream.fileno()), path.stat()):
                return stream
        except OSError:
            stream.close()
            raise
        stream.close()


def _lock(stream: BinaryIO) -> None:
    """Lock a file, as long as it is open; where the file system has no locks, do without."""
    try:
        from fcntl import LOCK_EX, LOCK_NB, flock
    except ImportError:  # Windows: there a file that is open cannot be replaced by another process
        return
    try:
        flock(stream, LOCK_EX | LOCK_NB)
    except BlockingIOError:
        raise
    except OSError as problem:
        if problem.errno not in (errno.ENOTSUP, errno.ENOLCK, errno.ENOSYS, errno.EBADF, errno.EINVAL):
            raise


def _taken(path: Path) -> LogError:
    if path.is_file():
        return LogTakenError(f"log {path} exists already: choose another name, or replace it with --force")
    return LogError(f"cannot write log {path}: it is no regular file; give the name of a file, such as run.mcap")


def unwritable(path: Path, problem: OSError) -> LogError:
    """Return the error for a log that cannot be written."""
    return LogError(
        f"cannot write log {path}: {reason(problem)}; choose a folder that exists, can be written and has room"
    )
