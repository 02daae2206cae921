"""Memory of a process: how rarely Python looks for circles of objects, and freed memory handed back to the system."""

import gc
import sys

_RARELY = 100_000, 20, 100
"""Objects made until Python looks for circles of them, and how much more rarely it looks among older ones.

Modules and classes are a hundred thousand objects that stay.
"""


def look_rarely() -> None:
    """Have this process look for circles of objects rarely: it takes a quarter of a short command, else a twentieth."""
    gc.set_threshold(*_RARELY)


def give_back() -> None:
    """Hand free memory back to the system, where the C library can."""
    import ctypes

    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform != "win32" else None
    if trim:
        trim(0)


def leave_circles() -> None:
    """Take all objects from the last search, but where duckdb is one, whose nanobind tells of what is left as leaks."""
    if "duckdb" not in sys.modules:
        gc.freeze()
