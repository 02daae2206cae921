"""Progress bars in the cells of a notebook; elsewhere, functions of the library are silent."""

import sys
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass
from functools import wraps
from inspect import signature
from threading import current_thread, main_thread
from time import monotonic
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


@dataclass(frozen=True)
class BarTiming:
    """Times of a progress bar [s]."""

    delay: float = 1.0  # time before a bar appears: a shorter call needs none
    interval: float = 0.2  # minimum time between two updates


TIMING = BarTiming()

_shown: ContextVar[bool] = ContextVar("bar_is_shown", default=False)


class CellBar:
    """Progress bar in the output of a cell, which disappears at the end; a callback of done and all items."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._start = self._updated = monotonic()
        self._handle: Any = None

    def __call__(self, done: int, total: int) -> None:
        """Update the bar in the cell: share of the `total` items that are `done`, and estimated time left."""
        now = monotonic()
        if now - self._start < TIMING.delay or now - self._updated < TIMING.interval:
            return
        self._updated = now
        seconds_left = (now - self._start) * (total / done - 1.0) if done else float("inf")
        time_left = f", about {seconds_left:.0f} s left" if done else ""
        self._show(
            f'{self._name} <progress value="{done}" max="{total}"></progress> {done} of {total}{time_left}',
            f"{self._name}: {done} of {total}{time_left}",
        )

    def close(self) -> None:
        """Clear the bar."""
        if self._handle is not None:
            self._show("", "")

    def _show(self, html: str, text: str) -> None:
        bundle = {"text/html": html, "text/plain": text}
        if self._handle is None:
            display = sys.modules["IPython.display"].display
            self._handle = display(bundle, raw=True, display_id=True)
        else:
            self._handle.update(bundle, raw=True)


def in_notebook() -> bool:
    """Return whether this code runs in a cell of a notebook, and not in a script, a terminal or a worker thread."""
    if "IPython.display" not in sys.modules or current_thread() is not main_thread():
        return False
    shell = sys.modules["IPython"].get_ipython()
    return shell is not None and hasattr(shell, "kernel")


def shows_progress(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate a function with a parameter `progress` so that a notebook shows a bar unless the caller passes one.

    Functions that it calls show no bars of their own.
    """
    parameters = signature(function)

    @wraps(function)
    def with_bar(*arguments: P.args, **keyword_arguments: P.kwargs) -> R:
        """Call the function with a progress bar as its argument `progress` in a notebook, unless a caller shows one."""
        if (
            _shown.get()
            or not in_notebook()
            or "progress" in parameters.bind_partial(*arguments, **keyword_arguments).arguments
        ):
            return function(*arguments, **keyword_arguments)
        bar, token = CellBar(function.__name__), _shown.set(True)
        try:
            keyword_arguments["progress"] = bar
            return function(*arguments, **keyword_arguments)
        finally:
            _shown.reset(token)
            bar.close()

    return with_bar
