"""Flip every single sign of `reducer` and of the static balance, one at a time, and show that a test fails.

    python scripts/flip_signs.py [--sample 20] [--only gaps.py] [--lines 400-900] [--workers 2]

Every unary minus and every plus and minus between two terms counts. Each flip is tried in a process of its own, forked
from one that has loaded the libraries, which reads the file with its sign flipped instead of the file: nothing is
written, and the kernel runs uncompiled. The tree as it is comes first: nothing may fail there.
"""

import argparse
import ast
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import os
import signal
import sys
import types
import warnings
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = Path("cycloid_mj")
KERNEL = tuple(
    f"statics/kernel/{name}.py"
    for name in ("contacts", "system", "newton", "continuation", "search", "samples", "hysteresis")
)
"""The static balance."""

FILES = ("reducer/bodies.py", "reducer/gaps.py", "reducer/limits.py", *KERNEL)
MODEL = "reducer/bodies.py"
"""The file from which models are built; the signs of the others are tested without a model, and uncompiled."""

KERNEL_TESTS = ("reducer/test_mechanism.py", "statics/test_kernel.py")
TESTS = ("reducer/test_limits.py", *KERNEL_TESTS)
MODEL_TESTS = ("reducer/test_reducer.py",)

SECONDS = 30
"""CPU time of tests after which they count as failed: they do not come to an end."""


@dataclass(frozen=True)
class Flip:
    """A sign of a file: where it stands, in bytes, and the expression that it is in."""

    file: str
    line: int
    place: int
    old: str
    expression: str

    def __str__(self) -> str:
        """Say where it is."""
        return f"{self.file}:{self.line}  {self.expression}"


def name_in_package(path: Path) -> str:
    """Return a file of the package from its root on, any other by its name."""
    return path.relative_to(ROOT / PACKAGE).as_posix() if path.is_relative_to(ROOT / PACKAGE) else path.name


def find_signs(path: Path) -> Iterator[Flip]:
    """Yield every plus or minus sign in the expressions of a Python file, as a flip."""
    content = path.read_bytes()
    starts = [0]
    for line in content.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def begin(node: ast.expr) -> int:
        return starts[node.lineno - 1] + node.col_offset

    def end(node: ast.expr) -> int:
        return starts[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)

    for node in ast.walk(ast.parse(content)):
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            first, last = begin(node), begin(node.operand)
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
            first, last = end(node.left), begin(node.right)
        elif isinstance(node, ast.AugAssign) and isinstance(node.op, ast.Add | ast.Sub):
            first, last = end(node.target), begin(node.value)
        else:
            continue
        place = next(i for i in range(first, last) if content[i : i + 1] in (b"+", b"-"))
        yield Flip(name_in_package(path), node.lineno, place, content[place : place + 1].decode(), ast.unparse(node))


def flip_sign(content: bytes, flip: Flip) -> bytes:
    """Encode a file with one sign flipped."""
    other = b"+" if flip.old == "-" else b"-"
    return content[: flip.place] + other + content[flip.place + 1 :]


class Flipped(importlib.abc.Loader):
    """Loads the module of a flip with its sign flipped; it stands before all other finders of modules."""

    def __init__(self, flip: Flip) -> None:
        self._flip, self._path = flip, ROOT / PACKAGE / flip.file
        self._name = ".".join((PACKAGE / flip.file).with_suffix("").parts)

    def find_spec(self, name: str, path: object, target: object = None) -> importlib.machinery.ModuleSpec | None:
        """Find the one module."""
        if name != self._name:
            return None
        return importlib.util.spec_from_file_location(name, self._path, loader=self)

    def exec_module(self, module: types.ModuleType) -> None:
        """Run it."""
        content = flip_sign(self._path.read_bytes(), self._flip)
        exec(compile(content, str(self._path), "exec"), module.__dict__)


def fails_a_test(file: str) -> bool:
    """Return whether a test fails that may see a sign of a file."""
    import pytest

    arguments = ["-x", "-q", "-p", "no:cacheprovider", "-o", "addopts=", "--noconftest", f"--rootdir={ROOT}"]
    tests = MODEL_TESTS if file == MODEL else KERNEL_TESTS if file in KERNEL else TESTS
    return pytest.main([*arguments, *(str(ROOT / "tests" / test) for test in tests)]) != 0


def warm() -> None:
    """Load the libraries, and nothing of the project, so that processes forked afterwards start with them."""
    for library in ("jinja2", "mujoco", "numba", "numpy", "pydantic", "pytest", "scipy.optimize", "scipy.spatial"):
        importlib.import_module(library)


def run_flip(flip: Flip | None, file: str, pipe: int) -> None:
    """Run the tests of a file with one sign flipped, or none, and write to a pipe whether a test fails.

    It runs in its own process.
    """
    import resource  # which Windows lacks

    import numba

    resource.setrlimit(resource.RLIMIT_CPU, (3 * SECONDS, 3 * SECONDS))  # where Python has no say
    signal.signal(signal.SIGPROF, out_of_time)
    numba.config.DISABLE_JIT = file != MODEL
    warnings.simplefilter("ignore")
    sys.path[:0] = [str(ROOT), str(ROOT / "tests")]
    if flip:
        sys.meta_path.insert(0, Flipped(flip))
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    os.write(pipe, b"yes" if fails_a_test(file) else b"no")


def out_of_time(*_: object) -> None:
    """Make fail what does not come to an end."""
    raise TimeoutError


@dataclass(frozen=True)
class Trial:
    """A flip, or none, that is being tried in a process of its own."""

    flip: Flip | None
    child: int
    pipe: int

    @classmethod
    def start(cls, flip: Flip | None, file: str) -> "Trial":
        """Fork a process that runs the tests with a flip, and return its trial."""
        pipe, tell = os.pipe()
        child = os.fork()
        if not child:
            try:
                run_flip(flip, file, tell)
            finally:
                os._exit(0)
        os.close(tell)
        return cls(flip, child, pipe)

    def end(self) -> bool:
        """Wait for the process, and return whether a test failed; a process that exceeded its time counts as failed."""
        with open(self.pipe, encoding="ascii") as pipe:
            seen = pipe.read() != "no"
        os.waitpid(self.child, 0)
        return seen


def try_flips(chosen: list[Flip], workers: int) -> Iterator[tuple[Flip, bool]]:
    """Try flips in parallel processes, in their order; yield each flip with whether a test fails."""
    running: deque[tuple[Flip, Trial]] = deque()
    for flip in chosen:
        if len(running) == workers:
            first, trial = running.popleft()
            yield first, trial.end()
        running.append((flip, Trial.start(flip, flip.file)))
    for first, trial in running:
        yield first, trial.end()


def choose_flips(only: str, lines: str, sample: int) -> list[Flip]:
    """Select the flips to try: all, those of one file or some of its lines, or `sample` flips evenly spread."""
    files = [ROOT / PACKAGE / file for file in FILES if not only or f"/{file}".endswith(f"/{only}")]
    of_files = (sorted(find_signs(path), key=lambda flip: flip.place) for path in files)
    every = [flip for of_file in of_files for flip in of_file]
    if lines:
        first, last = (int(end) for end in lines.split("-"))
        every = [flip for flip in every if first <= flip.line <= last]
    if not 0 < sample < len(every):
        return every
    return [every[round(i * (len(every) - 1) / max(1, sample - 1))] for i in range(sample)]


def main(arguments: list[str] | None = None) -> int:
    """Try flips and report those that no test detects; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="flip the signs of one file: gaps.py, kernel/search.py, ...")
    parser.add_argument("--lines", default="", help="flip those of some lines: 400-900")
    parser.add_argument("--sample", type=int, default=0, help="flip this many, spread over all; 0: every one")
    parser.add_argument("--workers", type=int, default=2, help="processes at a time")
    options = parser.parse_args(arguments)
    every = choose_flips(options.only, options.lines, options.sample)
    warm()
    for file in sorted({flip.file for flip in every}):
        if Trial.start(None, file).end():
            print("a test fails as it is: nothing can be said of any sign")
            return 1
    missed = 0
    for number, (flip, seen) in enumerate(try_flips(every, options.workers), start=1):
        missed += not seen
        if not seen:
            print(f"no test sees  {flip}", flush=True)
        print(f"\r{number} of {len(every)} signs flipped", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    print(f"{len(every)} signs flipped: {len(every) - missed} seen by a test", end="")
    print(f", {missed} not seen" if missed else "")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
