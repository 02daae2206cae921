"""Compilation of numerical code by numba: cached where possible, logged where it takes time."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numba
from numba.core import event, sigutils
from numba.core.ccallback import CFunc
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

from cycloid_mj.base.compile_cache import KernelCache, cache_folder, log_compilation
from cycloid_mj.base.interrupt import defer_signals

Function = Callable[..., Any]


def njit(
    *, cache: bool = False, allocates: bool = True, inner: bool = False, **options: Any
) -> Callable[[Function], Any]:
    """Return a decorator that compiles a function for calls from Python and from other kernels, as ``numba.njit`` does.

    With `cache` the machine code is stored in a `KernelCache`. With `allocates` False, neither the function nor the
    functions that it calls may allocate arrays; numba then omits the costly reference counting. An `inner` function can
    be called by kernels only and must not raise; its code is stored with the code of its callers. Further `options`
    are passed to numba.
    """
    if inner:
        options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": _InnerCompiler}

    def compile_kernel(function: Function) -> Any:
        compiled_function = numba.njit(**options, _nrt=allocates)(function)
        if cache:
            compiled_function._cache = KernelCache(function)
        return compiled_function

    return compile_kernel


def cfunc(signature: Any, *, cache: bool = False) -> Callable[[Function], Any]:
    """Return a decorator that compiles a function which C can call, as ``numba.cfunc`` does, with a numba `signature`.

    With `cache` the machine code is stored in a `KernelCache`.
    """

    def compile_callback(function: Function) -> Any:
        compiled_function: Any = CFunc(function, sigutils.normalize_signature(signature), locals={}, options={})
        if cache:
            compiled_function._cache = KernelCache(function)
        with announce_compilation():
            compiled_function.compile()
        return compiled_function

    return compile_callback


class _InnerLibrary(JITCodeLibrary):  # type: ignore[misc]  # numba has no types
    """LLVM code of an inner function, which is optimized and translated only as a part of the kernels that call it.

    By default numba does both for each function, and again in each function that calls it.
    """

    @property
    def codegen(self) -> "_InnerLibrary":
        """Object whose `set_env` numba calls after the compilation of a function."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: there is no machine code with a variable `name` for the `environment`, which only errors need."""

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0, since no function called `name` exists as machine code."""
        self._ensure_finalized()
        return 0

    def _optimize_final_module(self) -> None:
        """Do nothing: the code is optimized with that of the caller."""

    def _finalize_final_module(self) -> None:
        """Omit the translation to machine code."""
        self._finalize_dynamic_globals()
        self._finalized = True


class _InnerCompiler(Compiler):  # type: ignore[misc]  # numba has no types
    """Compiler of inner functions: numba's, with an `_InnerLibrary`."""

    def __init__(self, typing_context: Any, target_context: Any, library: Any, *arguments: Any) -> None:
        """Ignore `library`, which is None for every new function; the other arguments are those of the base class."""
        super().__init__(typing_context, target_context, _InnerLibrary(target_context.codegen(), "inner"), *arguments)


def cacheable() -> bool:
    """Return whether compiled code can be stored."""
    return cache_folder() is not None


@contextmanager
def announce_compilation() -> Iterator[None]:
    """Log once (level info) if code is compiled in this block, and not loaded from the cache.

    Signals that end the program wait until the block is done: raised within LLVM, they would be lost.
    """
    with defer_signals(), event.install_listener("numba:compile", _Announcer()):
        yield


class _Announcer(event.Listener):  # type: ignore[misc]  # numba has no types
    def on_start(self, event: Any) -> None:
        """Log once that code is being compiled, with the reason; numba calls it with an `event` for each function."""
        if cacheable():
            log_compilation("compiling the contact code, once per installation; this takes some seconds")
        else:
            log_compilation(
                "compiling the contact code for this run only, because no cache folder is writable: set "
                "NUMBA_CACHE_DIR to a writable folder"
            )

    def on_end(self, event: Any) -> None:
        """Do nothing at the end of a compilation; numba calls it with an `event`."""
