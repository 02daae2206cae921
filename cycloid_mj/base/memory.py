"""Memory of a process: how rarely Python looks for circles of objects, and freed memory handed back to the system."""

import gc
import sys
from typing import Any

_RARELY = 100_000, 20, 100
"""Allocations between garbage collections, and how much rarer the collections of older generations are.

Modules and classes are a hundred thousand objects that stay.
"""

_FIRST = 400_000
"""Allocations before the first collection: a short command keeps what it loads, and searching it takes 30 ms for
each hundred thousand."""

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
"""Numbers of two of glibc's parameters: how much free memory it keeps, and from what size on arrays are no part of it
(`mallopt`)."""

_NEVER, _LARGEST_KEPT = 2**31 - 1, 2**25
"""Their values here, in bytes: the largest that each may have."""


def look_rarely() -> None:
    """Make the garbage collector run rarely, which saves up to a quarter of a short command."""
    gc.set_threshold(_FIRST, *_RARELY[1:])
    gc.callbacks.append(_after_the_first)


def _after_the_first(phase: str, _: object) -> None:
    """Look as often as is to be, once the first look has begun."""
    gc.set_threshold(*_RARELY)
    gc.callbacks.remove(_after_the_first)


def keep_freed() -> None:
    """Make the C library keep freed memory, where possible: new pages from the system cost time."""
    if tune := _of_c_library("mallopt"):
        tune(_TRIM_THRESHOLD, _NEVER)
        tune(_MMAP_THRESHOLD, _LARGEST_KEPT)


def give_back() -> None:
    """Hand free memory back to the system, where the C library can."""
    if trim := _of_c_library("malloc_trim"):
        trim(0)


def _of_c_library(name: str) -> Any:
    """Find a function of the C library; None where it has no such function."""
    import ctypes

    return getattr(ctypes.CDLL(None), name, None) if sys.platform != "win32" else None


def leave_circles() -> None:
    """Exempt all objects from the last garbage collection, unless duckdb is loaded, which would report leaks."""
    if "duckdb" not in sys.modules:
        gc.freeze()
