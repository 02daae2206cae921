"""Work in threads of this process, which all end soon after the first error.

Threads are enough where the work releases Python's lock, as MuJoCo does while it steps.
"""

import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import TypeVar

from cycloid_mj.base.interrupt import check_interrupt, interrupt_on_event

T = TypeVar("T")
R = TypeVar("R")


def run_in_threads(work: Callable[[T], R], items: Iterable[T], workers: int) -> Iterator[tuple[int, R]]:
    """Apply the function `work` to each item in `workers` threads; yield the results in the order of completion.

    After the first error or Ctrl-C, items in progress stop at their next `check_interrupt` and no further one begins.

    Yields
    ------
    tuple
        Index of the item, and result.
    """
    stop_requested = threading.Event()

    def run_item(index: int, item: T) -> tuple[int, R]:
        with interrupt_on_event(stop_requested):
            check_interrupt()
            return index, work(item)

    with ThreadPoolExecutor(workers) as pool:
        try:
            for future in as_completed([pool.submit(run_item, index, item) for index, item in enumerate(items)]):
                yield future.result()
        finally:
            stop_requested.set()
            pool.shutdown(cancel_futures=True)
