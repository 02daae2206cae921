"""Memory of a process: how rarely Python collects reference cycles, and freed memory returned to the system."""

import gc
import sys
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class MemorySettings:
    """Settings of Python's garbage collector and of the memory allocation of glibc.

    Attributes
    ----------
    thresholds
        Allocations between garbage collections, and how much rarer those of older generations are. Modules and classes
        are a hundred thousand objects that stay.
    first
        Allocations before the first collection: a short command keeps what it loads, and searching it takes 30 ms for
        each hundred thousand.
    mallopt
        Parameter of ``mallopt`` -> value in bytes, the largest that it may have: free memory to keep
        (M_TRIM_THRESHOLD), and size from which an array is allocated separately (M_MMAP_THRESHOLD).
    """

    thresholds: tuple[int, int, int] = (100_000, 20, 100)
    first: int = 400_000
    mallopt: tuple[tuple[int, int], ...] = ((-1, 2**31 - 1), (-3, 2**25))


MEMORY = MemorySettings()


def collect_rarely() -> None:
    """Make the garbage collector run rarely (`MEMORY`), which saves up to a quarter of a short command."""
    gc.set_threshold(MEMORY.first, *MEMORY.thresholds[1:])
    gc.callbacks.append(_set_usual_thresholds)


def _set_usual_thresholds(phase: str, _: object) -> None:
    """Set the usual thresholds once the first collection has begun; a callback of `gc`."""
    gc.set_threshold(*MEMORY.thresholds)
    gc.callbacks.remove(_set_usual_thresholds)


def keep_freed_memory() -> None:
    """Make the C library keep freed memory, where possible: new pages from the system cost time."""
    if set_option := _c_function("mallopt"):
        for parameter, value in MEMORY.mallopt:
            set_option(parameter, value)


def return_free_memory() -> None:
    """Return free memory to the system, where the C library can (glibc's ``malloc_trim``)."""
    if return_memory := _c_function("malloc_trim"):
        return_memory(0)


def _c_function(name: str) -> Any:
    """Find a function of the C library; None where it has no such function."""
    import ctypes

    return getattr(ctypes.CDLL(None), name, None) if sys.platform != "win32" else None


def freeze_objects() -> None:
    """Exempt all objects from the last garbage collection, unless duckdb is loaded, which would report leaks."""
    if "duckdb" not in sys.modules:
        gc.freeze()
