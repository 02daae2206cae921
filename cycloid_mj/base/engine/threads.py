"""Work in threads of this process, which all end soon after the first error.

Threads are enough where the work releases Python's lock, as MuJoCo does while it steps.
"""

import threading
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from cycloid_mj.base.engine.housekeeping import handed_on
from cycloid_mj.base.interrupt import check_interrupt, interrupt_on_event

T = TypeVar("T")
R = TypeVar("R")


def in_threads(work: Callable[[T], R], items: Iterable[T], workers: int) -> Iterator[tuple[int, R]]:
    """Apply a function to each item in threads; yield index and result in the order of completion.

    The first error, or Ctrl-C, ends it: pieces not begun are left, others stop at their next check for an interrupt.
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
    """Items in progress, and how to stop them."""

    def __init__(self) -> None:
        self._under_way = 0
        self._changed = threading.Condition()
        self._stopped = threading.Event()

    def do(self, work: Callable[[T], R], place: int, item: T) -> tuple[int, R]:
        """Do a piece of work, unless all are to stop."""
        with self._changed:
            self._under_way += 1
        try:
            with interrupt_on_event(self._stopped):
                check_interrupt()
                return place, work(item)
        finally:
            with self._changed:
                self._under_way -= 1
                self._changed.notify_all()

    def stop(self) -> None:
        """Stop every item at its next `check_interrupt`; return when all have ended."""
        self._stopped.set()
        with self._changed:
            self._changed.wait_for(lambda: not self._under_way)
