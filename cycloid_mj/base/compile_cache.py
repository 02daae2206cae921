"""Where compiled code is kept from one run to the next: numba's cache with a seal, by which a damaged file is seen.

Numba unpickles what it kept and runs it: an empty or cut file raises, and a flipped byte of machine code computes
something else or ends the process. Each file here ends in a digest of all before it. One whose digest is wrong is
passed over, the code compiled anew and the file replaced; what cannot be kept is compiled for this run only.

Numba keeps code until the file it is from changes, and does not see a change of another that it calls. Here it is kept
until any source in its folder changes; for what is called in other folders see ``compiling.digest``.
"""

import hashlib
import io
import logging
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.runtime import rtsys

_log = logging.getLogger(__name__)
_DIGEST_SIZE = 32


@cache
def folder() -> Path | None:
    """Return the folder of compiled code: ``NUMBA_CACHE_DIR``, next to the sources, or in the home folder; else None.

    A container often has none of them that can be written.
    """
    try:
        return Path(FunctionCache(_say_once).cache_path)
    except RuntimeError:
        return None


class SealedCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Numba cache of one function that survives damaged files and full disks by compiling again.

    A function that `counts` references to arrays needs numba's runtime for it, which takes 20 ms to load.
    """

    def __init__(self, function: Callable[..., Any], counts: bool = True) -> None:
        super().__init__(function)
        self._counts = counts
        # under a name of its own: the files that numba itself writes have no seal
        name, stamp = f"{self._impl.filename_base}.sealed", _stamp(Path(function.__code__.co_filename).parent)
        self._cache_file = _SealedFiles(cache_path=self._cache_path, filename_base=name, source_stamp=stamp)

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the code for a signature, or None if there is no valid code."""
        # numba's own would first load all that it compiles with, a third of a second; what compiles, does so itself
        if self._counts:
            rtsys.initialize(target)
        try:
            with self._guard_against_spurious_io_errors():
                return self._load_overload(signature, target)
        except Exception:  # whatever is wrong with what was kept, it can be compiled anew
            _say_damaged(self._cache_path)
            return None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep the code for a signature, if that is possible."""
        try:
            super().save_overload(signature, compiled)
        except OSError as problem:
            _say_not_kept(self._cache_path, str(problem.strerror))


class _SealedFiles(IndexDataCacheFile):  # type: ignore[misc]  # numba has no types
    """The index and the data of one function: pickles, whose readers do not mind the digest behind them."""

    def _load_index(self) -> Any:
        try:
            return super()._load_index() if self._whole(self._index_path) else {}
        except Exception:  # written for types that this release names otherwise
            _say_damaged(self._cache_path)
            return {}

    def _load_data(self, name: str) -> Any:
        return super()._load_data(name) if self._whole(self._data_path(name)) else None

    @contextmanager
    def _open_for_write(self, path: str) -> Iterator[io.BytesIO]:
        content = io.BytesIO()
        yield content
        with super()._open_for_write(path) as file:
            file.write(content.getvalue() + _digest(content.getvalue()))

    def _whole(self, path: str) -> bool:
        """Return whether a file exists and is undamaged; warn if it is damaged."""
        try:
            content = Path(path).read_bytes()
        except FileNotFoundError:
            return False
        except OSError:
            content = b""
        whole = _digest(content[:-_DIGEST_SIZE]) == content[-_DIGEST_SIZE:]
        if not whole:
            _say_damaged(self._cache_path)
        return whole


def _stamp(sources: Path) -> tuple[tuple[str, int, int], ...]:
    """List the sources in a folder: name, time of the last change [ns] and size [byte] of each."""
    with os.scandir(sources) as entries:
        states = sorted((entry.name, entry.stat()) for entry in entries if entry.name.endswith(".py"))
    return tuple((name, state.st_mtime_ns, state.st_size) for name, state in states)


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()


def say_compiling(why: str) -> None:
    """Log once in a process (level info) that code is compiled, and why."""
    _say_once("compiling", why)


def _say_damaged(folder: str) -> None:
    say_compiling(f"the compile cache in {folder} is damaged: compiling again, which takes some seconds")


def _say_not_kept(folder: str, problem: str) -> None:
    _say_once(
        "kept",
        f"compiled code cannot be stored in {folder} ({problem}) and is used for this run only: free "
        "disk space, or set NUMBA_CACHE_DIR to a writable folder",
    )


_said: set[str] = set()


def _say_once(of: str, text: str) -> None:
    if of not in _said:
        _said.add(of)
        _log.info(text)
