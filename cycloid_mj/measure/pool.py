"""Several runs of a measure at once, in threads: MuJoCo lets go of Python's lock while it steps."""

from collections.abc import Callable, Iterable, Mapping
from typing import TypeVar

from cycloid_mj.base.engine import Engine, Progress, silent

__all__ = ["Progress", "each", "run_all", "silent"]

K = TypeVar("K")
T = TypeVar("T")
R = TypeVar("R")


def each(work: Callable[[T], R], items: Iterable[T], progress: Progress = silent, workers: int = 0) -> list[R]:
    """Do a piece of work for each item, several at a time; give the results in order; see `Engine`."""
    return Engine(workers, "threads").each(work, items, progress)


def run_all(tasks: Mapping[K, Callable[[], R]], progress: Progress = silent) -> dict[K, R]:
    """Run tasks as `each` does; give what each of them gave by its key. The longest had better come first."""
    return dict(zip(tasks, each(lambda task: task(), tasks.values(), progress), strict=True))
