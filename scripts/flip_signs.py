"""Flip every single sign in `mechanism`, one at a time, and show that a test and a row of `validate` fail.

    python scripts/flip_signs.py [--sample 20] [--only gaps.py] [--lines 400-900] [--workers 2]

Every unary minus and every plus and minus between two terms counts. Each flip is tried in a process of its own, forked
from one that has loaded the libraries, which reads the file with its sign flipped instead of the file: nothing is
written, and the kernel runs uncompiled. The tree as it is comes first: nothing may fail there. A sign that no row can
see is told with the reason: what leads to a balance (``ON_THE_WAY``) costs only time where a test alone sees it.
"""

import argparse
import ast
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import os
import resource
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
"""The balance: the rows of gaps and stops, and the search that they are held against, add nothing to its own."""

FILES = ("reducer/bodies.py", "reducer/gaps.py", "reducer/limits.py", *KERNEL)
MODEL = "reducer/bodies.py"
"""The file that models are made from; what the others hold is seen without one, and without compiling."""

KERNEL_TESTS = ("reducer/test_mechanism.py", "statics/test_kernel.py")
TESTS = ("reducer/test_limits.py", *KERNEL_TESTS)
MODEL_TESTS = ("reducer/test_reducer.py",)

SECONDS = 30
"""CPU time of tests or rows after which they count as failed: they do not come to an end."""

TIME = "costs only time: a way to the balance, which is found by its residual; a test counts the steps"
"""Why no row sees some signs."""

ALL: frozenset[str] = frozenset()
"""Of whatever a function makes, its decisions too."""

ON_THE_WAY: dict[str, dict[str, frozenset[str]]] = {
    "contacts": {"largest_play": ALL, "surely_open": frozenset({"rim"})},
    "system": {"assemble": frozenset({"assembled"})},
    "newton": dict.fromkeys(("newton", "solve", "solve_stable", "roll_off"), ALL),
    "continuation": dict.fromkeys(
        ("by_continuation", "_shares", "_along", "_give", "_direct", "_step_on", "_across", "_corner"), ALL
    ),
    "search": {
        **dict.fromkeys(("_lead", "_search", "_hardest", "_depth"), ALL),
        "balance": frozenset({"near"}),
        "balance_along": frozenset({"z"}),
    },
    "hysteresis": {**dict.fromkeys(("_leap", "_settle", "_renew"), ALL), "_weigh": frozenset({"work"})},
}
"""What only leads to a balance, by file, function and what is made there: where no row sees a sign, it costs time.

Where to begin and Newton's steps lead there; the forces that are left over decide."""


@dataclass(frozen=True)
class Flip:
    """One sign of a file: where it stands, in bytes, the expression that it is in, the function, and what that makes.

    What is made is the name that a value is given, or the word for what becomes of it: return, if.
    """

    file: str
    line: int
    place: int
    old: str
    expression: str
    within: str
    makes: str

    @property
    def leads(self) -> bool:
        """Whether it only leads to a balance."""
        ways = ON_THE_WAY.get(Path(self.file).stem if self.file in KERNEL else "", {}).get(self.within, frozenset())
        return ways is ALL or self.makes in ways

    def __str__(self) -> str:
        """Say where it is."""
        return f"{self.file}:{self.line}  {self.expression}"


@dataclass(frozen=True)
class Found:
    """What saw a flip: a test, a row of `validate`."""

    by_test: bool
    by_row: bool


def of_package(path: Path) -> str:
    """Return a file of the package from its root on, any other by its name."""
    return path.relative_to(ROOT / PACKAGE).as_posix() if path.is_relative_to(ROOT / PACKAGE) else path.name


def flips(path: Path) -> Iterator[Flip]:
    """Yield every sign of a file."""
    content = path.read_bytes()
    starts = [0]
    for line in content.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def at(line: int, column: int) -> int:
        return starts[line - 1] + column

    tree = ast.parse(content)
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    for makes, part in parts_made(tree):
        for node in ast.walk(part):
            if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
                first, last = at(node.lineno, node.col_offset), at(node.operand.lineno, node.operand.col_offset)
            elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
                first = at(node.left.end_lineno or 0, node.left.end_col_offset or 0)
                last = at(node.right.lineno, node.right.col_offset)
            elif isinstance(node, ast.AugAssign) and isinstance(node.op, ast.Add | ast.Sub):
                first = at(node.target.end_lineno or 0, node.target.end_col_offset or 0)
                last = at(node.value.lineno, node.value.col_offset)
            else:
                continue
            place = next(i for i in range(first, last) if content[i : i + 1] in (b"+", b"-"))
            around = [
                function.name for function in functions if function.lineno <= node.lineno <= (function.end_lineno or 0)
            ]
            sign, within = content[place : place + 1].decode(), around[-1] if around else ""
            yield Flip(of_package(path), node.lineno, place, sign, ast.unparse(node), within, makes)


def parts_made(tree: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Yield the parts of all statements with what each makes, as in `Flip`; every expression is in one of them."""
    for node in ast.walk(tree):
        match node:
            case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)) if len(names) == len(values):
                for name, value in zip(names, values, strict=True):
                    yield from ((named(name), part) for part in (name, value))
            case ast.Assign(targets=[target, *_]) | ast.AugAssign(target=target):
                yield named(target), node
            case ast.For(target=target, iter=iterated):
                yield named(target), iterated
            case ast.If(test=test) | ast.While(test=test):
                yield "if", test
            case ast.Return():
                yield "return", node
            case ast.stmt():
                inside = ast.stmt | ast.excepthandler | ast.match_case
                yield from (("", part) for part in ast.iter_child_nodes(node) if not isinstance(part, inside))


def named(target: ast.expr) -> str:
    """Return the name of what is given a value, without the object that it belongs to and its place there."""
    match target:
        case ast.Tuple(elts=targets):
            return ", ".join(map(named, targets))
        case ast.Subscript(value=whole):
            return named(whole)
        case ast.Attribute(attr=name):
            return name
    return ast.unparse(target)


def flipped(content: bytes, flip: Flip) -> bytes:
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
        content = flipped(self._path.read_bytes(), self._flip)
        exec(compile(content, str(self._path), "exec"), module.__dict__)


def tested(file: str) -> bool:
    """Tell whether a test fails that may see a sign of a file."""
    import pytest

    arguments = ["-x", "-q", "-p", "no:cacheprovider", "-o", "addopts=", "--noconftest", f"--rootdir={ROOT}"]
    tests = MODEL_TESTS if file == MODEL else KERNEL_TESTS if file in KERNEL else TESTS
    return pytest.main([*arguments, *(str(ROOT / "tests" / test) for test in tests)]) != 0


def validated(file: str) -> bool:
    """Tell whether a row of the rung `mechanism` fails that may see a sign of a file, or cannot be given."""
    from cycloid_mj.validate import balance, mechanism

    if file == MODEL:
        parts = mechanism.MODELS
    elif file in KERNEL:
        parts = (*balance.STATICS, *mechanism.RUBBED)
    else:
        parts = (*mechanism.STATICS, *balance.STATICS)
    try:
        return any(row.verdict == "fail" for part in parts for row in part())
    except Exception:
        return True


def warm() -> None:
    """Load the libraries, and nothing of the project, so that what is forked from here begins with them."""
    for library in ("jinja2", "mujoco", "numba", "numpy", "pydantic", "pytest", "scipy.optimize", "scipy.spatial"):
        importlib.import_module(library)


def see(flip: Flip | None, file: str, pipe: int) -> None:
    """Write what fails to a pipe, with a sign of a file flipped or none; in a process of its own."""
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
    for question in (validated, tested):
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
        os.write(pipe, b"yes " if question(file) else b"no ")


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
        """Fork the process."""
        pipe, tell = os.pipe()
        child = os.fork()
        if not child:
            try:
                see(flip, file, tell)
            finally:
                os._exit(0)
        os.close(tell)
        return cls(flip, child, pipe)

    def end(self) -> Found:
        """Wait for what it finds; a process that is stopped for its time has seen what it had not judged yet."""
        with open(self.pipe, encoding="ascii") as pipe:
            row, test, *_ = [*pipe.read().split(), "yes", "yes"]
        os.waitpid(self.child, 0)
        return Found(by_test=test == "yes", by_row=row == "yes")


def tried(chosen: list[Flip], workers: int) -> Iterator[tuple[Flip, Found]]:
    """Try flips, so many at a time, in their order."""
    running: deque[tuple[Flip, Trial]] = deque()
    for flip in chosen:
        if len(running) == workers:
            first, trial = running.popleft()
            yield first, trial.end()
        running.append((flip, Trial.start(flip, flip.file)))
    for first, trial in running:
        yield first, trial.end()


def wanted(only: str, lines: str, sample: int) -> list[Flip]:
    """List the flips to try: all, those of one file or of some of its lines, or so many spread evenly over them."""
    files = [ROOT / PACKAGE / file for file in FILES if not only or f"/{file}".endswith(f"/{only}")]
    of_files = (sorted(flips(path), key=lambda flip: flip.place) for path in files)
    every = [flip for of_file in of_files for flip in of_file]
    if lines:
        first, last = (int(end) for end in lines.split("-"))
        every = [flip for flip in every if first <= flip.line <= last]
    if not 0 < sample < len(every):
        return every
    return [every[round(i * (len(every) - 1) / max(1, sample - 1))] for i in range(sample)]


def main(arguments: list[str] | None = None) -> int:
    """Try flips and report those that nothing sees; give the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="flip the signs of one file: gaps.py, kernel/search.py, ...")
    parser.add_argument("--lines", default="", help="flip those of some lines: 400-900")
    parser.add_argument("--sample", type=int, default=0, help="flip this many, spread over all; 0: every one")
    parser.add_argument("--workers", type=int, default=2, help="processes at a time")
    options = parser.parse_args(arguments)
    every = wanted(options.only, options.lines, options.sample)
    warm()
    for file in sorted({flip.file for flip in every}):
        unspoiled = Trial.start(None, file).end()
        if unspoiled.by_test or unspoiled.by_row:
            print(f"a {'test' if unspoiled.by_test else 'row'} fails as it is: nothing can be said of any sign")
            return 1
    slower, missed = 0, 0
    for number, (flip, outcome) in enumerate(tried(every, options.workers), start=1):
        unseen = [what for what, by in (("test", outcome.by_test), ("row", outcome.by_row)) if not by]
        excused = unseen == ["row"] and flip.leads
        slower, missed = slower + excused, missed + (bool(unseen) and not excused)
        if unseen:
            print(f"no {' and no '.join(unseen)} sees  {flip}{': ' + TIME if excused else ''}", flush=True)
        print(f"\r{number} of {len(every)} signs flipped", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    both = len(every) - slower - missed
    print(f"{len(every)} signs flipped: {both} seen by a test and a row of validate, {slower} cost only time", end="")
    print(f", {missed} not seen" if missed else "")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
