"""The process ``cycloid-mj``: what it does with signals, from its first moment to its last, and with closed streams."""

import atexit
import gc
import os
import sys
from collections.abc import Sequence
from io import StringIO

from cycloid_mj.interrupt import cause, end_on_signals, raise_on_signals

FAILURE = 1

_RARELY = 100_000, 20, 100
"""Objects made until Python looks for circles of them, and how much more rarely it looks among older ones."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command, by default that of ``sys.argv``, and give its exit code; see `cycloid_mj.cli.app`."""
    from cycloid_mj.cli import app

    return app.main(argv)


def run() -> None:
    """Run the command of ``sys.argv`` and end the process with its exit code."""
    # a stream that was closed before the start is None
    sys.stdout = sys.stdout or StringIO()
    sys.stderr = sys.stderr or StringIO()
    code = FAILURE
    _collect_rarely()
    try:
        raise_on_signals()
        code = main()
        sys.stdout.flush()
    except KeyboardInterrupt as stop:
        # before `main` could tell it, such as while modules were loaded
        sys.stderr.write(f"error: stopped by {cause(stop)}\n")
    except OSError:
        # the pipe is closed: what is left must not be flushed again, and complained about, when Python ends
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    end_on_signals()
    sys.exit(code)


def _collect_rarely() -> None:
    """Have Python look for circles of objects rarely, and not at its end.

    Modules and classes are a hundred thousand objects that stay: to look among them, while they are loaded and once
    more before all memory is given back, takes a quarter of a short command.
    """
    gc.set_threshold(*_RARELY)
    atexit.register(_leave_circles)


def _leave_circles() -> None:
    """Take all objects from the last search, but where duckdb, whose nanobind would tell of each as a leak, is one."""
    if "duckdb" not in sys.modules:
        gc.freeze()
