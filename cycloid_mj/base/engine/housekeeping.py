"""Housekeeping of workers: ignore Ctrl-C and exit with the parent; close abandoned results quietly."""

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Generator, Iterator
from contextlib import suppress
from multiprocessing.connection import wait
from typing import TypeVar

R = TypeVar("R")

PARENT_CHECK_INTERVAL = 1.0
"""Interval of checks whether the parent process exists [s]; on POSIX, joblib's workers cannot wait for it."""


def serve_parent() -> None:
    """Leave Ctrl-C to the parent, which ends its workers, and end where the parent was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_exit_with_parent, args=(os.getppid(),), daemon=True).start()


def _exit_with_parent(parent_pid: int) -> None:
    """Wait until the parent process with the id `parent_pid` ends, then terminate this process.

    On POSIX `os.getppid` changes when the parent ends. On Windows it does not change, so the handle of the parent
    process (`sentinel`), which becomes ready at its end, is tested instead.
    """
    sentinel = getattr(multiprocessing.parent_process(), "sentinel", None)
    while os.getppid() == parent_pid:
        if sentinel is None:
            time.sleep(PARENT_CHECK_INTERVAL)
        elif wait([sentinel], PARENT_CHECK_INTERVAL):
            break
    os.kill(os.getpid(), signal.SIGTERM)


class _ResultsAbandoned(Exception):
    """The caller does not need the remaining results."""


def forward_results(results: Generator[R, None, None]) -> Iterator[R]:
    """Yield the results of a ``joblib.Parallel`` as they arrive, without joblib's warning if the caller stops early.

    The generator of joblib warns of unfinished work when it is closed, for example because a loop over it was
    interrupted.
    """
    try:
        for result in results:  # noqa: UP028  # `yield from` would close it itself
            yield result
    except GeneratorExit:
        with suppress(_ResultsAbandoned):
            results.throw(_ResultsAbandoned())
        raise
