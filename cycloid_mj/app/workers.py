"""Processes beside the page's own that solve and make: it redraws at once whatever they are busy with.

One is for what follows every move of a slider, one for what takes a moment longer, so that neither waits for the other,
and one for long work, which can be stopped.
"""

import gc
import multiprocessing
import os
import threading
from collections.abc import Callable, Iterable
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

from cycloid_mj.base.engine.housekeeping import serve_parent
from cycloid_mj.base.errors import CycloidError

BEHIND = 5
"""How much nicer than the page's own the processes are whose answers take a moment: moves of a slider go first."""

Work = Callable[..., Any]
Told = Callable[[Any], None]
Warm = Iterable[tuple[Work, tuple[Any, ...]]]


class Died(CycloidError):
    """A process ended while it was at work, as for want of memory or because it was stopped."""


class Worker:
    """One process, which does one work after the other; it ends with this one, however that ends."""

    def __init__(self, warm: Warm = (), behind: bool = True) -> None:
        """Start it; it does the `warm` works once, for their code to be loaded when somebody waits.

        One that stands `behind` leaves the processor to others that want it.
        """
        self._warm, self._behind, self._lock = tuple(warm), behind, threading.Lock()
        self._closed = False
        self._start()

    def do(self, work: Work, *args: Any, told: Told | None = None) -> Any:
        """Run a job in the worker; with `told`, the job gets a callback for its progress as first argument.

        Raises
        ------
        CycloidError
            What the work raises.
        Died
            The process ended; another one stands ready.
        """
        with self._lock:
            pipe = self._pipe
            try:
                pipe.send((work, args, told is not None))
                while True:
                    kind, content = pipe.recv()
                    if kind == "told" and told:
                        told(content)
                    elif kind == "failed":
                        raise CycloidError(content)
                    elif kind == "done":
                        return content
            except (EOFError, OSError) as error:
                if not self._closed:
                    self._start()
                raise Died("the work was stopped, or its process ended, as for want of memory") from error

    def stop(self) -> None:
        """Abort the current job: `do` raises then."""
        self._process.terminate()

    def close(self) -> None:
        """Terminate the process for good."""
        self._closed = True
        self._process.terminate()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(target=_serve, args=(other, self._warm, self._behind), daemon=False)
        self._process.start()
        other.close()


class Workers:
    """The processes, which all windows share; each does those works once first that it is given to warm up."""

    def __init__(self, quick: Warm = (), slower: Warm = ()) -> None:
        self.quick, self.slower, self.long = Worker(quick, behind=False), Worker(slower), Worker()

    def close(self) -> None:
        """Terminate the workers at once; what they do is needed no more."""
        for worker in (self.quick, self.slower, self.long):
            worker.close()


def _serve(pipe: Connection, warm: Warm, behind: bool) -> None:
    """Serve the page's process, and load what the works need."""
    serve_parent()
    if behind and hasattr(os, "nice"):  # Windows has none
        os.nice(BEHIND)
    for work, args in warm:
        with suppress(CycloidError):  # the page may begin with a design that cannot be built
            work(*args)
    gc.freeze()  # modules, and what all questions share: the rest is searched for circles in a millisecond
    while True:
        gc.collect()  # values of a design refer to each other: 350 MB of them in 200 moves, left to Python
        try:
            work, args, tells = pipe.recv()
        except EOFError:
            return
        try:
            done = work(_teller(pipe), *args) if tells else work(*args)
        except CycloidError as error:
            pipe.send(("failed", str(error)))
        except Exception as error:  # whatever goes wrong with one design, the page goes on
            pipe.send(("failed", f"{type(error).__name__}: {error}"))
        else:
            pipe.send(("done", done))


def _teller(pipe: Connection) -> Told:
    return lambda content: pipe.send(("told", content))
