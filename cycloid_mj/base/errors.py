"""Errors and warnings for the user: each states what is wrong, where, what is allowed and what to do."""

import warnings
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from cycloid_mj.base.text import legible


class CycloidError(Exception):
    """Base class of every error that this package raises on purpose.

    Parameters
    ----------
    message
        One sentence for the user. Control characters are escaped and very long words shortened, so that a hostile file
        name or key can be quoted.
    details
        Lines below the message, such as one for each failed check. ``str`` joins them to the message; the command line
        prints each on a line of its own.
    """

    exit_code = 1

    def __init__(self, message: object = "", details: Iterable[str] = ()) -> None:
        lines = tuple(legible(line) for line in details)
        super().__init__(legible(str(message)), *([lines] if lines else []))

    @property
    def message(self) -> str:
        """The message without its details."""
        return str(self.args[0])

    @property
    def details(self) -> tuple[str, ...]:
        """The lines below the message."""
        return self.args[1] if len(self.args) > 1 else ()

    def __str__(self) -> str:
        """Return message and details in one line."""
        return f"{self.message} {'; '.join(self.details)}" if self.details else self.message


class UsageError(CycloidError):
    """A wrong name, flag or value on the command line."""

    exit_code = 2


class DesignError(CycloidError):
    """A design that cannot be read, is not valid, or cannot be built."""


class LogError(CycloidError):
    """A log that cannot be written or read."""


class NoLogError(LogError, UsageError):
    """A wrong name of a log, or of a file that is not a log."""


def reason(problem: Exception) -> str:
    """Return the reason of an OSError or parse error, without its number and file name."""
    return getattr(problem, "strerror", None) or str(problem)


class ContactError(CycloidError):
    """Contact parameters that MuJoCo cannot represent, or a MuJoCo build whose structures are not as expected."""


class RunError(CycloidError):
    """A simulation that failed and was stopped; its log contains the samples before."""


class CycloidWarning(UserWarning):
    """The work continues, but some of its results are not those of the design."""


_suppressed: ContextVar[Collection[str]] = ContextVar("suppressed", default=())


@contextmanager
def suppress_warnings(texts: Collection[str]) -> Iterator[None]:
    """Suppress these warnings inside this ``with`` block, in this thread, because the caller reports them."""
    token = _suppressed.set(texts)
    try:
        yield
    finally:
        _suppressed.reset(token)


def warn(design: str, texts: Iterable[str]) -> None:
    """Issue warnings about a design of this name, except those inside `suppress_warnings`."""
    for text in texts:
        if text not in _suppressed.get():
            warnings.warn(legible(f"{design}: {text}"), CycloidWarning, stacklevel=3)
