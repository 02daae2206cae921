"""Worker processes of the page, so that it redraws at once whatever they are computing.

One answers the requests that follow every move of a slider, one those that take longer, so that neither waits for the
other; one runs the studies and one makes files, both of which can be stopped.

A call costs 0.09 ms here and 0.35 ms in a pool of Pebble (5.2.3, November 2026), which has no progress reports: a queue
for them stays locked when a job is stopped while it writes there, while a pipe ends with its process.
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

NICENESS = 5
"""Niceness of the slower worker processes relative to the page's own: moves of a slider have priority."""

Work = Callable[..., Any]
Progress = Callable[[Any], None]
WarmUp = Iterable[tuple[Work, tuple[Any, ...]]]


class WorkerDied(CycloidError):
    """A worker process ended during its work: it was stopped, or the memory was exhausted."""


class Worker:
    """A process that runs one function after the other; it ends with this process, however that ends."""

    def __init__(self, warm_up: WarmUp = (), nice: bool = True) -> None:
        """Start a process that runs functions for the page.

        Parameters
        ----------
        warm_up
            Functions with their arguments that are called once, so that their code is loaded before the first request.
        nice
            Whether other processes have priority (`NICENESS`).
        """
        self._nice, self._lock, self._closed = nice, threading.Lock(), False
        self._start(warm_up)

    def do(self, work: Work, *args: Any, on_progress: Progress | None = None) -> Any:
        """Call a function with arguments in the worker process of the page, and return its result.

        Parameters
        ----------
        work, args
            Function and its arguments.
        on_progress
            Called with each progress report; the function then gets a callback for these as its first argument.

        Raises
        ------
        CycloidError
            The function raised an error.
        WorkerDied
            The process ended; a new one has been started.
        """
        with self._lock:
            pipe = self._pipe
            try:
                pipe.send((work, args, on_progress is not None))
                while True:
                    kind, content = pipe.recv()
                    if kind == "progress" and on_progress:
                        on_progress(content)
                    elif kind == "failed":
                        raise CycloidError(content)
                    elif kind == "done":
                        return content
            except (EOFError, OSError) as error:
                if not self._closed:
                    self._start()
                raise WorkerDied(
                    "the job was stopped, or its process ended. Start the job again; if its process ends again, free "
                    "memory or choose fewer samples"
                ) from error

    def stop(self) -> None:
        """End the process: a call of `do` that is under way raises `WorkerDied`."""
        self._process.terminate()

    def close(self) -> None:
        """Terminate the process for good."""
        self._closed = True
        self._process.terminate()

    def _start(self, warm_up: WarmUp = ()) -> None:
        """Start the process that runs the functions of the page; `warm_up` are functions that load its code.

        A process that replaces another is not warmed up, because a request may already wait for it.
        """
        context = multiprocessing.get_context("spawn")
        self._pipe, child_end = context.Pipe()
        process = context.Process(target=_serve, args=(child_end, tuple(warm_up), self._nice), daemon=False)
        process.start()
        self._process = process  # only now, because `stop` can be called at any time
        child_end.close()


class Workers:
    """The worker processes, which all windows of the page share; each with its functions to warm up."""

    def __init__(self, quick: WarmUp = (), slower: WarmUp = (), long: WarmUp = (), files: WarmUp = ()) -> None:
        self.quick, self.slower = Worker(quick, nice=False), Worker(slower)
        self.long, self.files = Worker(long), Worker(files)

    def close(self) -> None:
        """Terminate all processes for good."""
        for worker in (self.quick, self.slower, self.long, self.files):
            worker.close()


def _serve(pipe: Connection, warm_up: WarmUp, nice: bool) -> None:
    """Run the functions that the page's process sends through a pipe, and send back ``("done", result)``.

    If a function raises an error, ``("failed", text of the error)`` is sent. `warm_up` are functions that are called
    first, to load their code. With `nice`, other processes have priority. The function returns when the page's process
    closes the pipe.
    """
    serve_parent()
    if nice and hasattr(os, "nice"):  # not on Windows
        os.nice(NICENESS)
    for function, args in warm_up:
        with suppress(CycloidError):  # the first design may be one that cannot be built
            function(*args)
    gc.freeze()  # modules and common data: a collection of the rest takes a millisecond
    while True:
        gc.collect()  # reducers contain reference cycles: 350 MB in 200 moves if left to Python's own schedule
        try:
            function, args, reports_progress = pipe.recv()
        except EOFError:
            return
        try:
            result = function(_reporter(pipe), *args) if reports_progress else function(*args)
        except CycloidError as error:
            pipe.send(("failed", str(error)))
        except Exception as error:  # a failure with one design must not end the page
            pipe.send(("failed", f"{type(error).__name__}: {error}"))
        else:
            pipe.send(("done", result))


def _reporter(pipe: Connection) -> Progress:
    return lambda content: pipe.send(("progress", content))
