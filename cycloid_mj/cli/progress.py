"""How far runs are: a bar with the time left on a terminal, now and then a line elsewhere."""

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


@contextmanager
def show_activity(words: str, quiet: bool = False) -> Iterator[None]:
    """Print the current activity, and from time to time that it continues; nothing if `quiet`."""
    if quiet:
        yield
        return
    over = Event()
    tell(words)
    Thread(target=_goes_on, args=(words, over), daemon=True).start()
    try:
        yield
    finally:
        over.set()


def _goes_on(words: str, over: Event) -> None:
    start = monotonic()
    while not over.wait(SECONDS_BETWEEN_COUNTS):
        tell(f"{words}: {monotonic() - start:.0f} s so far")


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
        self._told = monotonic()
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

    def report_time(self, simulated: float) -> None:
        """Show that the run has come to `simulated` [s]."""
        self._waiting.close()
        if self._quiet:
            return
        if self._first is None:
            self._first = monotonic(), simulated
        if sys.stderr.isatty():
            self._bar = self._bar or _bar(self._end)
            self._bar.update(self._bar.task_ids[0], completed=simulated)
        elif monotonic() - self._told > SECONDS_BETWEEN_LINES:
            self._told = monotonic()
            tell(self._line(simulated))

    def judging(self) -> None:
        """Show that the last sample is there, and is judged with all others."""
        if self._bar:
            self._bar.stop()
            self._bar = None
        self._waiting.enter_context(show_activity(JUDGING, self._quiet))

    def _line(self, simulated: float) -> str:
        """Return the progress and the estimated time left, from the pace since the first sample."""
        line = f"{simulated / self._end:4.0%}  {simulated:.3f} of {self._end:g} s simulated"
        start, first = self._first or (0.0, simulated)
        if simulated <= first:
            return line
        left = seconds_left(start, (simulated - first) / (self._end - first))
        return f"{line}, about {left:.0f} s left"


def seconds_left(start: float, share: float) -> float:
    """Estimate the remaining time [s] of work of which a share is done since `start`."""
    return (monotonic() - start) * (1.0 / share - 1.0) if share > 0.0 else float("inf")


def count_progress(what: str, quiet: bool) -> Callable[[int, int], None]:
    """Return a callback that prints how many items are done and the time left, at most every few seconds."""
    start = monotonic()
    last = [start]

    def progress(done: int, whole: int) -> None:
        now = monotonic()
        if quiet or (now - last[0] < SECONDS_BETWEEN_COUNTS and done < whole):
            return
        last[0] = now
        tell(f"{what}: {done} of {whole}, about {seconds_left(start, done / whole):.0f} s left")

    return progress


def _bar(end: float) -> Any:
    """Start a progress bar of a run of `end` simulated seconds."""
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
    shown = columns if console.width >= MIN_BAR_WIDTH else (TaskProgressColumn(),)
    bar = Bar(*shown, console=console, transient=True)
    bar.add_task("", total=end)
    bar.start()
    return bar
