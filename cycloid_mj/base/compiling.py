"""Compilation of numerical code by numba: cached where possible, logged where it takes time."""

import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import numba
from numba.core import event, sigutils
from numba.core.ccallback import CFunc
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

from cycloid_mj.base.compile_cache import SealedCache, folder, say_compiling
from cycloid_mj.base.interrupt import defer_signals

Function = Callable[..., Any]


def njit(
    *, cache: bool = False, allocates: bool = True, inner: bool = False, **options: Any
) -> Callable[[Function], Any]:
    """Compile a function for Python and other kernels, as ``numba.njit`` does; `cache` keeps it in a `SealedCache`.

    One that never `allocates` an array, nor what it calls, need not count references to those that it is given, which
    costs it time. An `inner` one is for kernels alone, and must not raise: it is kept with those that call it.
    """
    if inner:
        options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": _InnerCompiler}

    def compiled(function: Function) -> Any:
        wrapped = numba.njit(**options, _nrt=allocates)(function)
        if cache:
            wrapped._cache = SealedCache(function, counts=allocates)
        return wrapped

    return compiled


class _InnerCompiler(Compiler):  # type: ignore[misc]  # numba has no types
    """Numba's compiler, up to the code that is linked into that of callers."""

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *rest: Any) -> None:
        super().__init__(typingctx, targetctx, library or _InnerCode(targetctx.codegen(), "inner"), *rest)


class _InnerCode(JITCodeLibrary):  # type: ignore[misc]  # numba has no types
    """Code without machine code of its own: callers compile it into theirs, which saves a third of a compilation."""

    @property
    def codegen(self) -> Any:
        """Return the environment for Python objects and errors in the machine code."""
        return _NoEnvironment()

    def get_pointer_to_function(self, name: str) -> int:
        """Return no pointer, because Python does not call this code."""
        self._ensure_finalized()
        return 0

    def _optimize_final_module(self) -> None:
        """Leave that to callers."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True


class _NoEnvironment:
    def set_env(self, name: str, environment: Any) -> None:
        """Nothing needs it."""


def cfunc(signature: Any, *, cache: bool = False) -> Callable[[Function], Any]:
    """Compile a function that C can call, as ``numba.cfunc`` does; `cache` keeps it in a `SealedCache`."""

    def compiled(function: Function) -> Any:
        compiled_function: Any = CFunc(function, sigutils.normalize_signature(signature), locals={}, options={})
        if cache:
            compiled_function._cache = SealedCache(function)
        with announce_compilation():
            compiled_function.compile()
        return compiled_function

    return compiled


def cacheable() -> bool:
    """Return whether compiled code can be stored."""
    return folder() is not None


def digest(*modules: ModuleType) -> int:
    """Return a digest of the sources of modules whose code is compiled into that of another folder.

    A `SealedCache` does not follow them there: with the digest among what a function closes over, it does.
    """
    return zlib.crc32(b"".join(Path(module.__file__).read_bytes() for module in modules if module.__file__))


@contextmanager
def announce_compilation() -> Iterator[None]:
    """Log once (level info) that code is being compiled, if it is in this block, and not loaded from the cache.

    Signals that end the program wait until the block is done: raised within LLVM, they would be lost.
    """
    with defer_signals(), event.install_listener("numba:compile", _Announcer()):
        yield


class _Announcer(event.Listener):  # type: ignore[misc]  # numba has no types
    def on_start(self, event: Any) -> None:
        """Print once that code is being compiled."""
        if cacheable():
            say_compiling("compiling the contact code, once per installation; this takes some seconds")
        else:
            say_compiling(
                "compiling the contact code for this run only, because no cache folder is writable: set "
                "NUMBA_CACHE_DIR to a writable folder"
            )

    def on_end(self, event: Any) -> None:
        """Nothing more is to be said."""
