"""Work in processes of this machine; a process that dies is replaced, and its work is repeated.

By joblib (loky), which runs functions of scripts without ``if __name__ == "__main__"`` and of notebooks, and limits the
threads of its workers. With Pebble (5.2.3, November 2026) such a script ends with BrokenProcessPool.
"""

import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

from cycloid_mj.base.engine.housekeeping import forward_results, serve_parent
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.memory import collect_rarely

T = TypeVar("T")
R = TypeVar("R")

TRIES = 3
"""Times that an item may be under way when a process dies, before it is tried alone to see whether it is the cause."""


def run_in_processes(
    work: Callable[[T], R], items: Iterable[T], workers: int, on_lost: Callable[[int, str], R] | None = None
) -> Iterator[tuple[int, R]]:
    """Apply the function `work` to each item in processes of this machine; yield results in the order of completion.

    An item whose process died `TRIES` times is tried once more alone. `workers` is the number of processes. `on_lost`
    returns the result for an item whose process died then, too, from its index and the cause in words.

    Yields
    ------
    tuple
        Index of the item, and result.

    Raises
    ------
    RunError
        Such a process died, and there is no `on_lost`.
    """
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    waiting_items = dict(enumerate(items))
    death_counts: Counter[int] = Counter()
    while waiting_items:
        started_indices: set[int] = set()
        repeated_index = next((index for index in waiting_items if death_counts[index] >= TRIES), None)
        submitted_items = waiting_items if repeated_index is None else {repeated_index: waiting_items[repeated_index]}
        try:
            for index, result in _run_pool(work, dict(submitted_items), workers, started_indices):
                del waiting_items[index]
                yield index, result
        except TerminatedWorkerError as death:
            if repeated_index is not None:
                death_count = death_counts[repeated_index] + 1
                cause = f"its worker process died {death_count} times, the last time while it was the only one"
                if on_lost is None:
                    raise RunError(
                        f"job {repeated_index + 1} failed: {cause}. The computer may have run out of memory. Use fewer "
                        "parallel processes (--workers)"
                    ) from death
                del waiting_items[repeated_index]
                yield repeated_index, on_lost(repeated_index, cause)
            death_counts.update(started_indices & waiting_items.keys())


def _run_pool(
    work: Callable[[T], R], items: dict[int, T], workers: int, started_indices: set[int]
) -> Iterator[tuple[int, R]]:
    """Apply the function `work` to items by index in a pool of `workers` processes; yield in the order of completion.

    The indices of items that were handed to a process are added to the set `started_indices`.

    Yields
    ------
    tuple
        Index of the item, and result.

    Raises
    ------
    TerminatedWorkerError
        A process died (loky's error); its item is not tried again.
    """
    from joblib import Parallel, delayed, parallel_config

    def delayed_items() -> Iterator[Any]:
        for index, item in items.items():
            started_indices.add(index)
            yield delayed(_run_with_index)(work, index, item)

    # The thread of joblib that replaces a worker which ended, idle or grown, warns of it first: where warnings are
    # errors that ends the thread, and the work waits for ever.
    warnings.filterwarnings("ignore", "A worker stopped while some jobs were given", UserWarning)
    with parallel_config("loky", inner_max_num_threads=1, initializer=_initialize_worker):
        pool = Parallel(max(2, workers), batch_size=1, return_as="generator_unordered")
    yield from forward_results(pool(delayed_items()))


def _initialize_worker() -> None:
    serve_parent()
    collect_rarely()


def _run_with_index(work: Callable[[T], R], index: int, item: T) -> tuple[int, R]:
    return index, work(item)
