"""Work on a running Dask cluster; Dask itself repeats the work of a lost worker.

An item that kills its worker each time is reported. With joblib's Dask backend (1.6.0, November 2026) such an item
hangs the program: it had not ended after 45 s, twice.
"""

import logging
import re
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice
from typing import Any, TypeVar

from cycloid_mj.base.engine.packages import Versions, require_same_versions, versions
from cycloid_mj.base.errors import CycloidError, RunError, UsageError

T = TypeVar("T")
R = TypeVar("R")

AHEAD = 1000
"""Items that are with the scheduler at once, at least: what comes later waits here, where it costs nothing."""

SECONDS_TO_CONNECT = 20.0
"""Time to connect to the scheduler of a cluster, after which it counts as unreachable."""


def run_on_cluster(
    work: Callable[[T], R], items: Iterable[T], scheduler: str, on_lost: Callable[[int, str], R] | None = None
) -> Iterator[tuple[int, R]]:
    """Apply the function `work` to each item on a Dask cluster; yield the results in the order of completion.

    `scheduler` is the address of the cluster. `on_lost` returns the result for an item whose workers died, from its
    index and the cause in words.

    Yields
    ------
    tuple
        Index of the item, and result.

    Raises
    ------
    RunError
        Workers died and there is no `on_lost`, have other versions of the packages, or cannot be reached.
    UsageError
        The address is invalid, or Dask is not installed.
    """
    with _connect_client(scheduler) as client, _connect(scheduler):
        from distributed import KilledWorker, as_completed

        _require_workers(client, scheduler)
        waiting_items = iter(enumerate(items))
        index_of_future: dict[Any, int] = {}

        def submit_work(count: int) -> list[Any]:
            futures = {
                client.submit(_run_with_versions, work, item, pure=False): index
                for index, item in islice(waiting_items, count)
            }
            index_of_future.update(futures)
            return list(futures)

        completed_futures = as_completed(submit_work(max(AHEAD, 4 * sum(client.nthreads().values()))), loop=client.loop)
        for future in completed_futures:
            index = index_of_future.pop(future)
            if future.status == "finished":
                worker_versions, result = future.result()
                require_same_versions(worker_versions, f"a worker of {scheduler}")
            elif future.status == "error" and isinstance(future.exception(), KilledWorker):
                cause = "every worker of the cluster that computed it died"
                if on_lost is None:
                    raise RunError(
                        f"job {index + 1} on the cluster {scheduler} failed: {cause}. It may have run out of "
                        "memory. Use fewer workers per machine"
                    ) from future.exception()
                result = on_lost(index, cause)
            else:
                raise _worker_error(future, scheduler)
            future.release()
            yield index, result
            completed_futures.update(submit_work(1))


def _run_with_versions(work: Callable[[T], R], item: T) -> tuple[Versions, R]:
    return versions(), work(item)


@contextmanager
def _connect_client(scheduler: str) -> Iterator[Any]:
    """Yield a Dask client of the scheduler at an address; cancel unfinished work when the block ends.

    Raise UsageError for an invalid address or without Dask, RunError if no scheduler answers.
    """
    if not re.fullmatch(r"(\w+://)?\S+:\d+", scheduler):
        raise UsageError(f"--scheduler {scheduler!r} is not an address: give HOST:PORT, e.g. 10.0.0.1:8786")
    try:
        from distributed import Client
    except ImportError as problem:
        raise UsageError(
            f"--scheduler needs Dask, which is not installed ({problem}): run pip install 'cycloid-mj[cluster]'"
        ) from problem
    with _silent_loggers():
        try:
            client = Client(scheduler, timeout=SECONDS_TO_CONNECT, set_as_default=False)
        except (OSError, ValueError) as problem:
            raise RunError(
                f"--scheduler: no Dask scheduler answers at {scheduler} ({problem}). Start one with `dask scheduler`, "
                "or use local processes with --workers"
            ) from problem
        try:
            yield client
        finally:
            client.close()


@contextmanager
def _silent_loggers() -> Iterator[None]:
    """Silence the loggers of Dask inside this block; its errors are raised anyway."""
    levels = {name: logging.getLogger(name).level for name in [*logging.root.manager.loggerDict] if _of_dask(name)}
    for name in levels:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)


def _of_dask(name: str) -> bool:
    return name.partition(".")[0] in ("distributed", "tornado")


@contextmanager
def _connect(scheduler: str) -> Iterator[None]:
    """Convert errors of Dask about a lost scheduler to RunError."""
    try:
        yield
    except (OSError, CancelledError) as problem:
        raise _connection_error(scheduler) from problem


def _connection_error(scheduler: str) -> RunError:
    return RunError(
        f"the connection to the scheduler {scheduler} was lost: restart the scheduler, then run the same command again"
    )


def _require_workers(client: Any, scheduler: str) -> None:
    """Raise RunError if a cluster has no workers, or workers with other versions of the packages.

    `client` is a client of Dask, `scheduler` the address of the cluster, for messages.
    """
    try:
        client.wait_for_workers(1, timeout=SECONDS_TO_CONNECT)
    except TimeoutError as problem:
        raise RunError(
            f"the Dask cluster at {scheduler} has no workers: start at least one with `dask worker {scheduler}`"
        ) from problem
    try:
        worker_versions = client.run(versions)
    except Exception as problem:  # whatever a worker fails with, such as a missing package
        local_version = dict(versions())["cycloid_mj"]
        raise RunError(
            f"a worker of the cluster {scheduler} cannot import cycloid_mj ({problem}): install cycloid-mj "
            f"{local_version} on all workers"
        ) from problem
    for address, versions_of_worker in worker_versions.items():
        require_same_versions(versions_of_worker, f"the worker {address}")


def _worker_error(future: Any, scheduler: str) -> BaseException:
    """Return the error to raise for work that failed on a cluster: its own error, or that the cluster is lost.

    `future` is Dask's handle of the work, `scheduler` the address of the cluster, for messages.
    """
    if future.status != "error":
        return _connection_error(scheduler)
    error: BaseException = future.exception()
    if isinstance(error, CycloidError):
        return error
    return RunError(
        f"a worker of the cluster {scheduler} failed: {type(error).__name__}: {error}. Check the log of that worker, "
        "then run the same command again"
    )
