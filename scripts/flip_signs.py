"""Flip every single sign in `mechanism`, one at a time, and show that a test and a row of `validate` fail.

    python scripts/flip_signs.py [--sample 20] [--only gaps.py] [--workers 2]

Every unary minus and every plus and minus between two terms counts. Each flip runs in a process of its own, on a copy
of the tree in a temporary folder. A flip that no value depends on is listed in ``EQUIVALENT`` with its reason.
"""

import argparse
import ast
import contextlib
import io
import os
import queue
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ROOM = Path("cycloid_mj/mechanism")
MODEL = "reducer.py"
"""The file that models are made from; what the others hold is seen without one, and without compiling."""

SECONDS = 300
"""After which a flip counts as seen: it does not come to an end."""

SEARCH = "a way to the balance, not the balance: what is found is checked by its residual"
PHASE = "the one disc that is offered is in phase with the crank; a test on two discs sees it"
ONLY = "of the one disc that is offered, 2 and -2 are the same of four unknowns"
EQUIVALENT: dict[tuple[str, str], str] = {
    ("gaps.py", "crank[..., np.newaxis] + phases(design)[disc]"): PHASE,
    ("gaps.py", "crank + phases(design)[disc]"): PHASE,
    ("gaps.py", "angles + phase"): PHASE,
    ("gaps.py", "np.asarray(crank, dtype=np.float64)[..., np.newaxis] + np.array(phases(design))"): PHASE,
    ("gaps.py", "3 * disc + 2"): ONLY,
    ("kernel.py", "3 * disc + 2"): ONLY,
    ("limits.py", "3 * disc + 2"): ONLY,
    ("kernel.py", "k - 1"): "of one before the first, the last of its array: " + SEARCH,
    ("kernel.py", "xy += stiffness * (1.0 - around) * u * v"): SEARCH,
    ("kernel.py", "stiffness * at * at + turning * bt * bt + alone * bt"): SEARCH,
    ("kernel.py", "stiffness * ay * at + turning * by * bt"): SEARCH,
    ("kernel.py", "value -= matrix[i, m] * matrix[j, m]"): SEARCH,
    (
        "reducer.py",
        "gear.eccentricity + made.largest",
    ): "a cylinder that reaches all mates reaches farther than it must",
    ("reducer.py", "gear.pin_circle_radius + 2.0 * (gear.eccentricity + made.largest)"): (
        "within the bounding boxes that MuJoCo compares; a test sees it"
    ),
    ("reducer.py", "-ahead"): PHASE,
    ("reducer.py", "first + _angles(len(numbered))"): PHASE,
}
"""File and the expression of the sign -> why no row of `validate` depends on it."""


@dataclass(frozen=True)
class Flip:
    """One sign of a file: where it stands, in bytes, and the expression that it is in."""

    file: str
    line: int
    place: int
    old: str
    expression: str

    def __str__(self) -> str:
        """Say where it is."""
        return f"{self.file}:{self.line}  {self.expression}"


@dataclass(frozen=True)
class Found:
    """What saw a flip: a test, a row of `validate`."""

    flip: Flip
    by_test: bool
    by_row: bool


def flips(path: Path) -> Iterator[Flip]:
    """Give every sign of a file."""
    content = path.read_bytes()
    starts = [0]
    for line in content.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def at(line: int, column: int) -> int:
        return starts[line - 1] + column

    for node in ast.walk(ast.parse(content)):
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
        yield Flip(path.name, node.lineno, place, content[place : place + 1].decode(), ast.unparse(node))


def flipped(content: bytes, flip: Flip) -> bytes:
    """Give a file with one sign flipped."""
    other = b"+" if flip.old == "-" else b"-"
    return content[: flip.place] + other + content[flip.place + 1 :]


def tested(folder: Path, models: bool) -> bool:
    """Tell whether a test fails on the tree in a folder."""
    import pytest

    arguments = ["-x", "-q", "-p", "no:cacheprovider", "-o", "addopts="]
    tests = "tests/test_reducer.py" if models else "tests/test_mechanism.py"
    return pytest.main([*arguments, str(folder / tests)]) != 0


def validated(models: bool) -> bool:
    """Tell whether a row of the rung `mechanism` fails, or cannot be given."""
    from cycloid_mj.validation import mechanism

    try:
        parts = (*mechanism.STATICS, *(mechanism.MODELS if models else ()))
        return any(row.verdict == "fail" for part in parts for row in part())
    except Exception:
        return True


def see(folder: Path, models: bool) -> None:
    """Print what fails on the tree in a folder; in a process of its own."""
    sys.path[:0] = [str(folder), str(folder / "tests")]
    warnings.simplefilter("ignore")
    by_row = validated(models)
    with contextlib.redirect_stdout(io.StringIO()):
        by_test = tested(folder, models)
    print(f"row={by_row} test={by_test}")


def copied(folder: Path) -> None:
    """Copy what the tests need, with what is compiled already."""
    for name in ("cycloid_mj", "tests", "papers"):
        shutil.copytree(ROOT / name, folder / name)
    for name in ("pyproject.toml", "README.md"):
        shutil.copy2(ROOT / name, folder / name)


def judged(flip: Flip, folder: Path) -> Found:
    """Judge one flip in a copy of the tree; nothing seen for ``SECONDS`` is a search that does not come to its end."""
    path = folder / ROOM / flip.file
    shutil.copy2(ROOT / ROOM / flip.file, path)
    path.write_bytes(flipped(path.read_bytes(), flip))
    models = flip.file == MODEL
    command = [sys.executable, str(Path(__file__).resolve()), "--see", str(folder), "--only", flip.file]
    plain = os.environ | ({} if models else {"NUMBA_DISABLE_JIT": "1"})
    try:
        ended = subprocess.run(
            command, capture_output=True, text=True, timeout=SECONDS, cwd=folder, env=plain, check=False
        )
        told = ended.stdout
    except subprocess.TimeoutExpired:
        told = ""
    shutil.copy2(ROOT / ROOM / flip.file, path)
    return Found(flip, by_test="test=False" not in told, by_row="row=False" not in told)


def wanted(only: str, sample: int) -> list[Flip]:
    """Give the flips to try: all, those of one file, or so many spread evenly over them."""
    files = sorted((ROOT / ROOM).glob("*.py"))
    every = [flip for path in files for flip in flips(path) if only in ("", path.name)]
    if not 0 < sample < len(every):
        return every
    return [every[round(i * (len(every) - 1) / max(1, sample - 1))] for i in range(sample)]


def main(arguments: list[str] | None = None) -> int:
    """Try flips and report those that nothing sees; give the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="flip the signs of one file: gaps.py, kernel.py, ...")
    parser.add_argument("--sample", type=int, default=0, help="flip this many, spread over all; 0: every one")
    parser.add_argument("--see", type=Path, default=None, help=argparse.SUPPRESS)
    parser.add_argument("--workers", type=int, default=2, help="processes at a time")
    options = parser.parse_args(arguments)
    if options.see:
        see(options.see, options.only == MODEL)
        return 0
    every = wanted(options.only, options.sample)
    tried = [flip for flip in every if (flip.file, flip.expression) not in EQUIVALENT]
    survivors: list[Found] = []
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(options.workers) as pool:
        folders: queue.SimpleQueue[Path] = queue.SimpleQueue()
        for worker in range(options.workers):
            folders.put(Path(name) / str(worker))
            copied(Path(name) / str(worker))

        def in_a_copy(flip: Flip) -> Found:
            folder = folders.get()
            found = judged(flip, folder)
            folders.put(folder)
            return found

        for number, found in enumerate(pool.map(in_a_copy, tried), start=1):
            if not (found.by_test and found.by_row):
                survivors.append(found)
                missed = [what for what, by in (("test", found.by_test), ("row", found.by_row)) if not by]
                print(f"no {' and no '.join(missed)} sees  {found.flip}", flush=True)
            print(f"\r{number} of {len(tried)} signs flipped", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    for flip in every:
        if reason := EQUIVALENT.get((flip.file, flip.expression)):
            print(f"equivalent  {flip}: {reason}")
    print(f"{len(tried)} signs flipped, {len(survivors)} not seen by a test and a row of validate")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
