"""Interruption of work: SIGTERM and SIGHUP end it as Ctrl-C does, never in the middle of a file; threads stop too."""

import ctypes
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

STOPPING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""The signals that ask a program to end; Windows has no SIGHUP."""

SIGACTION_SIZE = 1024
"""Bytes, more than any system's `struct sigaction` has."""

_to_stop: ContextVar[threading.Event | None] = ContextVar("to_stop", default=None)


class Stopped(KeyboardInterrupt):
    """A signal other than Ctrl-C requested the end of the program; the text is its name, such as "SIGTERM"."""


def signal_name(stop: KeyboardInterrupt) -> str:
    """Return what stopped the program, for a message "stopped by ..."."""
    return str(stop) or "Ctrl-C"


def exit_code(stop: BaseException | None) -> int:
    """Return the exit code for an exception: 128 + the number of the signal that it stands for, or else 1."""
    if not isinstance(stop, KeyboardInterrupt):
        return 1
    return 128 + (signal.Signals[str(stop)] if str(stop) in signal.Signals.__members__ else signal.SIGINT)


def raise_on_signals() -> None:
    """Make SIGTERM and SIGHUP raise `Stopped`; an ignored signal, as by nohup, stays ignored."""
    for signal_number in STOPPING:
        if signal_number != signal.SIGINT and signal.getsignal(signal_number) is not signal.SIG_IGN:
            signal.signal(signal_number, _stop)


def end_on_signals() -> None:
    """Make every such signal end this process at once."""
    for signal_number in STOPPING:
        if signal.getsignal(signal_number) is not signal.SIG_IGN:
            signal.signal(signal_number, signal.SIG_DFL)


@contextmanager
def preserve_handlers() -> Iterator[None]:
    """Restore the handlers of SIGINT, SIGTERM and SIGHUP after the block, in which gmsh may replace them at its start.

    It can be used in any thread, unlike Python's own `signal.signal`.
    """
    if sys.platform == "win32":
        yield
        return
    libc = ctypes.CDLL(None)
    saved_handlers = {signal_number: ctypes.create_string_buffer(SIGACTION_SIZE) for signal_number in STOPPING}
    for signal_number, saved_handler in saved_handlers.items():
        libc.sigaction(signal_number, None, saved_handler)
    try:
        yield
    finally:
        for signal_number, saved_handler in saved_handlers.items():
            libc.sigaction(signal_number, saved_handler, None)


@contextmanager
def defer_signals() -> Iterator[None]:
    """Defer Ctrl-C, SIGTERM and SIGHUP until the block ends, so that it is not interrupted in the middle of a file.

    The first deferred signal is raised again after the block. Outside of the main thread nothing is deferred.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    deferred_signals: list[int] = []
    previous_handlers: dict[int, Any] = {}
    try:
        for signal_number in STOPPING:
            if signal.getsignal(signal_number) not in (signal.SIG_IGN, None):
                previous_handlers[signal_number] = signal.signal(
                    signal_number, lambda signal_number, _: deferred_signals.append(signal_number)
                )
        yield
    finally:
        for signal_number, handler in previous_handlers.items():
            signal.signal(signal_number, handler)
        if deferred_signals:
            signal.raise_signal(deferred_signals[0])


@contextmanager
def interrupt_on_event(event: threading.Event) -> Iterator[None]:
    """Make `check_interrupt` raise inside this block, in its thread, when the event is set."""
    token = _to_stop.set(event)
    try:
        yield
    finally:
        _to_stop.reset(token)


def check_interrupt() -> None:
    """Raise KeyboardInterrupt if the current thread has been asked to stop; long computations call this periodically.

    The request is the event of `interrupt_on_event`. Threads test it instead of being interrupted from outside, because
    an exception that another thread raises in them at an arbitrary line could leave a lock acquired forever.
    """
    stop_event = _to_stop.get()
    if stop_event is not None and stop_event.is_set():
        raise KeyboardInterrupt


def _stop(signal_number: int, _: Any) -> None:
    raise Stopped(signal.Signals(signal_number).name)
