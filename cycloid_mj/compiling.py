"""How number-crunching code is compiled: kept in numba's cache where that has a place, and told when it takes time."""

import logging
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from numba import njit
from numba.core import event

from cycloid_mj.interrupt import unbroken

_log = logging.getLogger(__name__)


@cache
def cacheable() -> bool:
    """Tell whether numba can keep what it compiles: in ``NUMBA_CACHE_DIR``, beside the sources, or in the home folder.

    A container often has none of them that can be written.
    """
    try:
        njit(cache=True)(_probe)
    except RuntimeError:
        return False
    return True


def digest(*modules: ModuleType) -> int:
    """Give a digest of the sources of modules whose code is compiled into another's.

    Numba does not follow them into other files: with the digest among what a function closes over, its cache does.
    """
    return zlib.crc32(b"".join(Path(module.__file__).read_bytes() for module in modules if module.__file__))


@contextmanager
def announced() -> Iterator[None]:
    """Log once (level info) that code is being compiled, if it is in this block, and not loaded from the cache.

    Signals that end the program wait until the block is done: raised within LLVM, they would be lost.
    """
    with unbroken(), event.install_listener("numba:compile", _Announcer()):
        yield


class _Announcer(event.Listener):  # type: ignore[misc]  # numba has no types
    def on_start(self, event: Any) -> None:
        _announce()

    def on_end(self, event: Any) -> None:
        """Nothing more is to be said."""


@cache
def _announce() -> None:
    if cacheable():
        _log.info("compiling the contact code, once per installation; this takes some seconds")
    else:
        _log.info(
            "compiling the contact code, for this run only, since there is no folder to keep it in: "
            "set NUMBA_CACHE_DIR to one that can be written"
        )


def _probe() -> None:
    """Be a function to ask for a place in the cache."""
