"""Several runs at once.

Threads are enough: MuJoCo lets go of Python's lock while it steps.
"""

import ctypes
import os
import threading
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import TypeVar

K = TypeVar("K")
T = TypeVar("T")
R = TypeVar("R")
Progress = Callable[[int, int], None]
"""Called after each piece of work: how many are done, and how many there are."""


def silent(done: int, whole: int) -> None:
    """Report no progress."""


def each(
    work: Callable[[T], R], items: Iterable[T], progress: Progress = silent, workers: int | None = None
) -> list[R]:
    """Do a piece of work for each item, several at a time; give the results in order.

    The first error, or Ctrl-C, ends it: pieces not begun are left, those under way are stopped at their next step.
    """
    items = list(items)
    at_work = _AtWork()
    with ThreadPoolExecutor(workers or os.cpu_count() or 1) as pool:
        tasks = [pool.submit(at_work.do, work, item) for item in items]
        try:
            for done, task in enumerate(as_completed(tasks), start=1):
                task.result()
                progress(done, len(items))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            at_work.stop()
            raise
        return [task.result() for task in tasks]


def run_all(tasks: Mapping[K, Callable[[], R]], progress: Progress = silent) -> dict[K, R]:
    """Run tasks as `each` does; give what each of them gave by its key. The longest had better come first."""
    return dict(zip(tasks, each(lambda task: task(), tasks.values(), progress), strict=True))


class _AtWork:
    """Threads that are at work, and how to stop them."""

    def __init__(self) -> None:
        self._threads: set[int] = set()
        self._lock = threading.Lock()
        self._stopped = False

    def do(self, work: Callable[[T], R], item: T) -> R:
        """Do a piece of work, unless all are to stop."""
        thread = threading.get_ident()
        with self._lock:
            if self._stopped:
                raise KeyboardInterrupt
            self._threads.add(thread)
        try:
            return work(item)
        finally:
            with self._lock:
                self._threads.discard(thread)

    def stop(self) -> None:
        """Raise KeyboardInterrupt in every thread at work: a run takes thousands of steps in Python, and many seconds.

        Under the lock, so that no thread leaves its work meanwhile: the executor could not bear it outside.
        """
        with self._lock:
            self._stopped = True
            for thread in self._threads:
                ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(KeyboardInterrupt))
