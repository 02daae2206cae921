"""Progress of runs: a bar with the time left on a terminal, a line every few seconds elsewhere."""

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from threading import Event, Thread
from time import monotonic
from types import TracebackType
from typing import Any

from cycloid_mj.cli.terminal import tell

PREPARING, JUDGING = "preparing the model", "evaluating the run"
MIN_BAR_WIDTH = 60
"""Columns of a terminal below which progress is a percentage alone."""
SECONDS_BETWEEN_LINES, SECONDS_BETWEEN_COUNTS = 10.0, 5.0
"""Least time between lines of progress [s]: of a simulation, and of counted items."""


@contextmanager
def show_activity(activity: str, quiet: bool = False) -> Iterator[None]:
    """Print the text `activity` on stderr now, and every few seconds with the elapsed time until the context closes.

    With `quiet` nothing is printed.
    """
    if quiet:
        yield
        return
    is_finished = Event()
    tell(activity)
    Thread(target=_repeat_activity, args=(activity, is_finished), daemon=True).start()
    try:
        yield
    finally:
        is_finished.set()


def _repeat_activity(activity: str, finished: Event) -> None:
    start = monotonic()
    while not finished.wait(SECONDS_BETWEEN_COUNTS):
        tell(f"{activity}: {monotonic() - start:.0f} s so far")


class Progress:
    """Progress of a run on stderr, from its preparation to its evaluation; a context manager.

    Parameters
    ----------
    end
        Simulated time of the whole run [s].
    quiet
        Whether to write nothing.
    """

    def __init__(self, end: float, quiet: bool = False) -> None:
        self._end = end
        self._quiet = quiet
        self._last_print = monotonic()
        self._first: tuple[float, float] | None = None
        self._bar: Any = None
        self._waiting = ExitStack()

    def __enter__(self) -> "Progress":
        self._waiting.enter_context(show_activity(PREPARING, self._quiet))  # modules are loaded, code is compiled
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        self._waiting.close()
        if self._bar:
            self._bar.stop()

    def tell(self, text: str) -> None:
        """Write a message that comes before the first sample."""
        if not self._quiet:
            tell(text)

    def report_time(self, simulated_time: float) -> None:
        """Report that the simulation has reached the time `simulated_time` [s].

        On a terminal a bar is updated; otherwise a line is printed on stderr every few seconds.
        """
        self._waiting.close()
        if self._quiet:
            return
        if self._first is None:
            self._first = monotonic(), simulated_time
        if sys.stderr.isatty():
            self._bar = self._bar or _start_bar(self._end)
            self._bar.update(self._bar.task_ids[0], completed=simulated_time)
        elif monotonic() - self._last_print > SECONDS_BETWEEN_LINES:
            self._last_print = monotonic()
            tell(self._progress_text(simulated_time))

    def judging(self) -> None:
        """Show that the last sample is there, and is judged with all others."""
        if self._bar:
            self._bar.stop()
            self._bar = None
        self._waiting.enter_context(show_activity(JUDGING, self._quiet))

    def _progress_text(self, simulated_time: float) -> str:
        """Return a line of text with the finished share of a run and the time left, at `simulated_time` [s].

        The time left is estimated from the speed since the first sample.
        """
        line = f"{simulated_time / self._end:4.0%}  {simulated_time:.3f} of {self._end:g} s simulated"
        start, start_time = self._first or (0.0, simulated_time)
        if simulated_time <= start_time:
            return line
        remaining_time = seconds_left(start, (simulated_time - start_time) / (self._end - start_time))
        return f"{line}, about {remaining_time:.0f} s left"


def seconds_left(start: float, share: float) -> float:
    """Estimate the remaining time [s] of work of which a share is done since `start`."""
    return (monotonic() - start) * (1.0 / share - 1.0) if share > 0.0 else float("inf")


def count_progress(activity: str, quiet: bool) -> Callable[[int, int], None]:
    """Return a callback that prints progress; it takes the numbers of finished and of all work items.

    It prints `activity` with both numbers and the estimated time left, every few seconds at most; nothing if `quiet`.
    Before the first item is finished, no time is estimated.
    """
    start = monotonic()
    last_print = [start]

    def progress(finished: int, total: int) -> None:
        now = monotonic()
        if quiet or (now - last_print[0] < SECONDS_BETWEEN_COUNTS and finished < total):
            return
        last_print[0] = now
        time_text = f", about {seconds_left(start, finished / total):.0f} s left" if finished else ""
        tell(f"{activity}: {finished} of {total}{time_text}")

    return progress


def _start_bar(end: float) -> Any:
    """Start a progress bar on stderr for a run of `end` simulated seconds, and return it."""
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    console = Console(stderr=True)
    columns = (
        TextColumn("simulating"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.completed:.3f} of {task.total:g} s,"),
        TimeRemainingColumn(),
        TextColumn("left"),
    )
    shown_columns = columns if console.width >= MIN_BAR_WIDTH else (TaskProgressColumn(),)
    bar = Bar(*shown_columns, console=console, transient=True)
    bar.add_task("", total=end)
    bar.start()
    return bar
