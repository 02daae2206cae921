"""Apply a function to many items in threads, in processes or on a cluster; results arrive in order of completion."""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import partial
from typing import Literal, TypeVar

K = TypeVar("K")
T = TypeVar("T")
R = TypeVar("R")
Progress = Callable[[int, int], None]
"""Called after each piece of work: how many are done, and how many there are."""

Lost = Callable[[int, str], R]
"""Called for an item whose worker died each time, with its index and the cause: returns a result for it, or raises."""


_within_a_piece = ContextVar("within_a_piece", default=False)
_most_workers = ContextVar("most_workers", default=0)


@contextmanager
def at_most(workers: int | None) -> Iterator[None]:
    """Limit the workers of every engine inside this block that has no number of its own; None sets no limit."""
    token = _most_workers.set(workers or 0)
    try:
        yield
    finally:
        _most_workers.reset(token)


def cores() -> int:
    """Count the cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def silent(done: int, total: int) -> None:
    """Report no progress."""


@dataclass(frozen=True)
class Engine:
    """Choice of threads, processes or a cluster, and the number of workers.

    Attributes
    ----------
    workers
        Workers on this machine; 0: as many as `at_most` allows, or one for each core that this process may use.
    kind
        Whether they are processes, or threads, for work that releases Python's lock.
    scheduler
        Instead of workers here: ``HOST:PORT`` of the scheduler of a running Dask cluster.
    """

    workers: int = 0
    kind: Literal["processes", "threads"] = "processes"
    scheduler: str = ""

    @property
    def local_workers(self) -> int:
        """Number of workers on this machine; 1 inside a worker."""
        return 1 if _within_a_piece.get() else self.workers or _most_workers.get() or cores()

    def stream(
        self, function: Callable[[T], R], items: Iterable[T], on_lost: Lost[R] | None = None
    ) -> Iterator[tuple[int, R]]:
        """Apply a function to each item of a sequence in parallel; yield the results in the order of completion.

        With processes or a cluster, `function` must be picklable: a function of a module, or a `functools.partial` of
        such a function. Items and results should be small. The results do not depend on the worker. The first error of
        the function ends all work. On Ctrl-C, or if the iterator is closed, waiting items are cancelled and running
        ones stopped.

        Parameters
        ----------
        function, items
            The function, and its arguments.
        on_lost
            Function that returns the result for an item whose worker died at each attempt; by default a `RunError` is
            raised.

        Yields
        ------
        tuple
            Index of the item, and result.

        Raises
        ------
        RunError
            Workers died repeatedly, have other versions of the packages, or cannot be reached.
        UsageError
            The scheduler's address is invalid, or Dask is not installed.
        """
        from cycloid_mj.base.engine.cluster import run_on_cluster
        from cycloid_mj.base.engine.processes import run_in_processes
        from cycloid_mj.base.engine.threads import run_in_threads

        run_function = partial(_run_item, function)
        if self.scheduler:
            return run_on_cluster(run_function, items, self.scheduler, on_lost)
        if self.local_workers == 1:
            return ((index, run_function(item)) for index, item in enumerate(items))
        if self.kind == "threads":
            return run_in_threads(run_function, items, self.local_workers)
        return run_in_processes(run_function, items, self.local_workers, on_lost)

    def each(self, function: Callable[[T], R], items: Iterable[T], progress: Progress = silent) -> list[R]:
        """Apply a function to each item of a sequence in parallel; return the results in the order of the items.

        `progress` is called with the number of finished items and the number of all items.
        """
        items = list(items)
        results: dict[int, R] = {}
        for index, result in self.stream(function, items):
            results[index] = result
            progress(len(results), len(items))
        return [results[index] for index in range(len(items))]


def each_in_threads(
    function: Callable[[T], R], items: Iterable[T], progress: Progress = silent, workers: int = 0
) -> list[R]:
    """Apply a function to each item in threads; return the results in order; see `Engine`."""
    return Engine(workers, "threads").each(function, items, progress)


def all_in_threads(tasks: Mapping[K, Callable[[], R]], progress: Progress = silent) -> dict[K, R]:
    """Run tasks in threads; return their results by key. Put the longest task first."""
    return dict(zip(tasks, each_in_threads(lambda task: task(), tasks.values(), progress), strict=True))


def _run_item(function: Callable[[T], R], item: T) -> R:
    """Apply the function to one item; nested work runs serially, because all cores are in use."""
    token = _within_a_piece.set(True)
    try:
        return function(item)
    finally:
        _within_a_piece.reset(token)
