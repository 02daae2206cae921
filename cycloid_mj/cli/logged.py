"""What the package logs by Python's `logging`, on stderr: that something takes time, and why."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from cycloid_mj.cli.terminal import tell

_PACKAGE = "cycloid_mj"


@contextmanager
def log_told(quiet: bool) -> Iterator[None]:
    """Write every message of level info and above as a line on stderr inside this block, or none if it is `quiet`."""
    log, handler = logging.getLogger(_PACKAGE), _Teller()
    level = log.level
    if not quiet:
        log.addHandler(handler)
        log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)


class _Teller(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        tell(record.getMessage())
