"""Work in threads of this process, which all end soon after the first error.

Threads are enough where the work releases Python's lock, as MuJoCo does while it steps.
"""

import ctypes
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from cycloid_mj.engine.results import handed_on

T = TypeVar("T")
R = TypeVar("R")


def in_threads(work: Callable[[T], R], items: Iterable[T], workers: int) -> Iterator[tuple[int, R]]:
    """Do a piece of work for each item; give the places of the items with their results, as they are done.

    The first error, or Ctrl-C, ends it: pieces not begun are left, those under way are stopped at their next step.
    """
    from joblib import Parallel, delayed

    at_work = _AtWork()
    pieces = (delayed(at_work.do)(work, place, item) for place, item in enumerate(items))
    try:
        yield from handed_on(Parallel(workers, backend="threading", return_as="generator_unordered")(pieces))
    except BaseException:
        at_work.stop()
        raise


class _AtWork:
    """Threads that are at work, and how to stop them."""

    def __init__(self) -> None:
        self._threads: set[int] = set()
        self._lock = threading.Lock()
        self._stopped = False

    def do(self, work: Callable[[T], R], place: int, item: T) -> tuple[int, R]:
        """Do a piece of work, unless all are to stop."""
        thread = threading.get_ident()
        with self._lock:
            if self._stopped:
                raise KeyboardInterrupt
            self._threads.add(thread)
        try:
            return place, work(item)
        finally:
            with self._lock:
                self._threads.discard(thread)

    def stop(self) -> None:
        """Raise KeyboardInterrupt in every thread at work: a run takes thousands of steps in Python, and many seconds.

        Under the lock, so that no thread leaves its work meanwhile and is hit in another piece. Gives back when all
        have ended.
        """
        with self._lock:
            self._stopped = True
            for thread in self._threads:
                ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(KeyboardInterrupt))
        while self._threads:
            time.sleep(1e-3)
