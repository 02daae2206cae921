"""Cache of compiled code between runs: numba's cache, in a folder named after its sources.

Numba compiles a function again when its own file changes, but not when a function of another file changes that it
calls. A change of any source with compiled code leads to another folder.
"""

import hashlib
import logging
import shutil
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

from numba import config
from numba.core.caching import FunctionCache
from numba.np import linalg

_log = logging.getLogger(__name__)
PACKAGE = Path(__file__).parents[1]
SOURCES = (
    *("base/compiling.py", "dynamics/contact/*.py", "dynamics/planar/*.py", "statics/kernel/*.py"),
    *("dynamics/film_table.py", "reducer/bodies.py", "reducer/impact.py", "reducer/roller_needles.py"),
)
"""Files with compiled functions, and with what is compiled into them."""

MAX_FOLDERS = 3
"""Folders of compiled code that are kept: that of the current sources, and two of earlier ones."""


@cache
def cache_folder() -> Path | None:
    """Return a writable folder for the machine code of the current sources; None if there is no writable folder.

    The folder is created if needed. It is in ``NUMBA_CACHE_DIR`` if that is set, else next to the sources or in the
    home folder. Folders of earlier versions of the sources are removed, except for the latest two.
    """
    folder_name = f"kernels-{_digest_of_sources()}"
    for folder in [config.CACHE_DIR] if config.CACHE_DIR else [f"{PACKAGE}/__pycache__", "~/.cache/cycloid_mj"]:
        with suppress(OSError, RuntimeError):  # a user may have no home folder
            parent = Path(folder).expanduser()
            if not (parent / folder_name).exists():
                (parent / folder_name).mkdir(parents=True, exist_ok=True)
                _remove_old_folders(parent)
            with TemporaryFile(dir=parent / folder_name):
                return parent / folder_name
    return None


def _remove_old_folders(parent: Path) -> None:
    """Remove all but the `MAX_FOLDERS` latest folders of compiled code; another process may do so at the same time."""
    with suppress(OSError):
        for old_folder in sorted(parent.glob("kernels-*"), key=lambda path: path.stat().st_mtime)[:-MAX_FOLDERS]:
            shutil.rmtree(old_folder, ignore_errors=True)


class KernelCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Numba's cache of one function in `cache_folder`.

    A file that cannot be read, such as an empty or cut one, or written, as on a full disk, costs a compilation and one
    line; with numba's own it ends the program. A changed byte within machine code is not seen.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        previous_folder, config.CACHE_DIR = config.CACHE_DIR, str(cache_folder())
        try:
            super().__init__(function)
        finally:
            config.CACHE_DIR = previous_folder

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the cached machine code for a numba `signature`; None if there is none, or if the cache is damaged.

        A damaged cache is emptied, with a message. `target` is the compiler's context.
        """
        _import_array_functions()
        try:
            return super().load_overload(signature, target)
        except Exception:  # whatever a damaged pickle raises
            log_compilation(
                f"the compile cache in {cache_folder()} is damaged: compiling again, which takes some seconds"
            )
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Store the machine code of a `compiled` function for a signature; log once if that is not possible."""
        try:
            super().save_overload(signature, compiled)
        except OSError as problem:
            _log_once(
                "storage",
                f"compiled code cannot be stored in {cache_folder()} ({problem.strerror}) and is used for this run "
                "only: free disk space, or set NUMBA_CACHE_DIR to a writable folder",
            )


@cache
def _import_array_functions() -> None:
    """Import numba's array functions without ``scipy.linalg``, which takes 0.2 s of CPU per process.

    numba imports it at this point only to find out whether there is a BLAS, and again when a compiled function uses the
    BLAS. SciPy is a dependency of this package, so the first import is left out.
    """
    ensure_blas, linalg.ensure_blas = linalg.ensure_blas, lambda: None
    try:
        import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = ensure_blas


def _digest_of_sources() -> str:
    sources = [path.read_bytes() for pattern in SOURCES for path in sorted(PACKAGE.glob(pattern))]
    return hashlib.sha256(b"".join(sources)).hexdigest()[:16]


def log_compilation(why: str) -> None:
    """Log once in a process (level info) that code is compiled, with the text `why`."""
    _log_once("compiling", why)


_logged_topics: set[str] = set()


def _log_once(topic: str, text: str) -> None:
    if topic not in _logged_topics:
        _logged_topics.add(topic)
        _log.info(text)
