"""Stream joblib results; close quietly when abandoned."""

from collections.abc import Generator, Iterator
from contextlib import suppress
from typing import TypeVar

R = TypeVar("R")


class _Left(Exception):
    """Nobody waits for what is left."""


def handed_on(results: Generator[R, None, None]) -> Iterator[R]:
    """Yield the results of a `joblib.Parallel` as they come.

    Where they are closed early, as by an interrupted loop, joblib's own generator would warn of pieces that are lost.
    """
    try:
        for result in results:  # noqa: UP028  # `yield from` would close it itself
            yield result
    except GeneratorExit:
        with suppress(_Left):
            results.throw(_Left())
        raise
