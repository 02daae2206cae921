"""Locks on files against other processes; the operating system ends them with the process, even if it is killed."""

import errno
import os
from collections.abc import Callable
from pathlib import Path

WITHOUT_LOCKS = (errno.ENOTSUP, errno.ENOLCK, errno.ENOSYS, errno.EBADF, errno.EINVAL)
"""Errors of file systems that have no locks: files there are used without."""


def lock_file(path: Path) -> Callable[[], None]:
    """Lock an existing file, and return the function that removes the lock.

    On POSIX the file itself is locked (``flock``), which leaves no trace and works on network file systems. On Windows,
    which has no ``fcntl``, a locked file could be neither read nor replaced. There, filelock locks an empty file next
    to it, with the ending ``.lock``, and removes it at the end. filelock must not lock files with content, because up
    to version 4.0 it truncates them.

    Raises
    ------
    BlockingIOError
        Another process has locked the file.
    OSError
        The file cannot be opened.
    """
    try:
        from fcntl import LOCK_EX, LOCK_NB, flock
    except ImportError:
        return _lock_sidecar(path)
    while True:
        stream = path.open("rb")
        try:
            flock(stream, LOCK_EX | LOCK_NB)
        except OSError as problem:
            if problem.errno not in WITHOUT_LOCKS:
                stream.close()
                raise
        # another process may have replaced the file between opening and locking
        if os.path.samestat(os.fstat(stream.fileno()), path.stat()):
            return stream.close
        stream.close()


def _lock_sidecar(path: Path) -> Callable[[], None]:
    """Lock an empty file next to `path`, with the ending ``.lock``, by filelock; return the unlocking function.

    Raise BlockingIOError if another process has the lock.
    """
    from filelock import FileLock, Timeout

    lock = FileLock(f"{path}.lock", timeout=0, thread_local=False)
    try:
        lock.acquire()
    except Timeout as problem:
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN), str(path)) from problem
    return lock.release
