"""How far runs are: a bar with the time left on a terminal, now and then a line elsewhere."""

import sys
from collections.abc import Callable
from threading import Event, Thread
from time import monotonic
from types import TracebackType
from typing import Any

from cycloid_mj.cli.terminal import tell

PREPARING = "preparing the model"
SECONDS_BETWEEN_LINES, SECONDS_BETWEEN_COUNTS = 10.0, 5.0


class Progress:
    """Progress of a run on stderr; a context manager.

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
        self._start = self._told = monotonic()
        self._bar: Any = None
        self._begun = Event()

    def __enter__(self) -> "Progress":
        self.tell(PREPARING)
        if not self._quiet:
            Thread(target=self._wait, daemon=True).start()
        return self

    def _wait(self) -> None:
        """Write now and then, until the first sample, that the work goes on: modules are loaded, code compiled."""
        while not self._begun.wait(SECONDS_BETWEEN_COUNTS):
            tell(f"{PREPARING}: {monotonic() - self._start:.0f} s so far")

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        self._begun.set()
        if self._bar:
            self._bar.stop()

    def tell(self, text: str) -> None:
        """Write a message that comes before the first sample."""
        if not self._quiet:
            tell(text)

    def reached(self, simulated: float) -> None:
        """Show that the run has come to `simulated` [s]."""
        self._begun.set()
        if self._quiet:
            return
        if sys.stderr.isatty():
            self._bar = self._bar or _bar(self._end)
            self._bar.update(self._bar.task_ids[0], completed=simulated)
        elif monotonic() - self._told > SECONDS_BETWEEN_LINES:
            self._told = monotonic()
            tell(self._line(simulated))

    def _line(self, simulated: float) -> str:
        share = simulated / self._end
        left = seconds_left(self._start, share)
        return f"{share:4.0%}  {simulated:.3f} of {self._end:g} s simulated, about {left:.0f} s left"


def seconds_left(start: float, share: float) -> float:
    """Compute the time [s] that the rest of some work will take, of which a share is done since `start`."""
    return (monotonic() - start) * (1.0 / share - 1.0) if share > 0.0 else float("inf")


def counted(what: str, quiet: bool) -> Callable[[int, int], None]:
    """Return what writes, not too often, how many pieces of work are done, of how many, and the time left."""
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
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    bar = Bar(
        TextColumn("simulating"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.completed:.3f} of {task.total:g} s,"),
        TimeRemainingColumn(),
        TextColumn("left"),
        console=Console(stderr=True),
        transient=True,
    )
    bar.add_task("", total=end)
    bar.start()
    return bar
