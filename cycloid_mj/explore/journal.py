"""The folder of a sweep: each row as soon as it is there, so that a sweep that was stopped goes on where it was."""

import errno
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

from cycloid_mj.base.atomic_write import write_whole
from cycloid_mj.base.errors import CycloidError, UsageError, reason
from cycloid_mj.base.interrupt import unbroken
from cycloid_mj.base.overwrite_guard import as_own
from cycloid_mj.explore.row import PointResult

SWEEP = "sweep"
"""Name of a study, and of its files."""


def plan_file(study: str) -> str:
    """Return the name of the file that says what a study is of."""
    return f"{study}.json"


def rows_file(study: str) -> str:
    """Return the name of the file that keeps the rows of a study."""
    return f"{study}.rows.jsonl"


def begun(into: Path, study: str) -> bool:
    """Whether a folder holds a study, whole or begun."""
    return (into / plan_file(study)).exists() or (into / rows_file(study)).exists()


def forget(into: Path, study: str) -> None:
    """Remove the plan and the rows of the study in a folder, which begins anew then.

    Raises
    ------
    UsageError
        Another process is at work in it.
    CycloidError
        They cannot be removed.
    """
    rows = into / rows_file(study)
    try:
        if rows.exists():
            with rows.open("ab") as stream:
                _lock(stream, into, study)
                rows.unlink()
        (into / plan_file(study)).unlink(missing_ok=True)
    except OSError as problem:
        raise CycloidError(f"cannot replace {rows}: {reason(problem)}; choose another folder with --out") from problem


class Journal:
    """Rows in a file, a line each, in the order they came."""

    def __init__(self, path: Path, stream: IO[bytes], rows: dict[int, PointResult]) -> None:
        self.path = path
        self.rows = rows
        self._stream = stream

    def add(self, place: int, row: PointResult) -> None:
        """Keep the row of a point, counted from 0.

        Raises
        ------
        CycloidError
            It cannot be written; the rows before it are kept.
        """
        line = json.dumps({"point": place + 1, **asdict(row)}).encode() + b"\n"
        try:
            with unbroken():
                if self._stream.write(line) != len(line):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError as problem:
            raise CycloidError(
                f"cannot write {self.path}: {reason(problem)}; its {len(self.rows)} rows are kept: make "
                "room and give the same command again"
            ) from problem
        self.rows[place] = row


@contextmanager
def journal(into: Path, plan: Mapping[str, Any], study: str = SWEEP) -> Iterator[Journal]:
    """Open the folder of a study, such as a sweep, new or begun, and give the rows that it has.

    Raises
    ------
    UsageError
        The folder is of another one, or another process is at work in it.
    CycloidError
        It cannot be read or written.
    """
    if _require_same(into, plan, study):
        as_own(into)
    path = into / rows_file(study)
    try:
        stream = path.open("ab+", buffering=0)
    except OSError as problem:
        raise CycloidError(f"cannot write {path}: {reason(problem)}; choose another folder with --out") from problem
    with stream:
        _lock(stream, into, study)
        if not (into / plan_file(study)).exists():
            write_whole({into / plan_file(study): json.dumps(plan, indent=2).encode() + b"\n"})
        yield Journal(path, stream, _read(stream))


def _require_same(into: Path, plan: Mapping[str, Any], study: str) -> bool:
    """Tell whether a folder has a study of this plan; raise UsageError where it is of another one."""
    there, rows = into / plan_file(study), into / rows_file(study)
    try:
        begun = json.loads(there.read_bytes())
    except FileNotFoundError:
        if rows.exists() and rows.stat().st_size:
            raise UsageError(f"{into} has {rows.name}, but no {there.name}: choose another folder with --out") from None
        return False
    except (OSError, ValueError) as problem:
        raise CycloidError(f"cannot read {there}: {reason(problem)}; choose another folder with --out") from problem
    other = [key for key in plan if not isinstance(begun, dict) or begun.get(key) != json.loads(json.dumps(plan[key]))]
    if other:
        raise UsageError(
            f"{into} is of another {study} (other {', '.join(other)}): choose another folder with --out, or "
            "replace it with --force"
        )
    return True


def _lock(stream: IO[bytes], into: Path, study: str) -> None:
    """Keep other processes off; the system lets go where this one ends, however it ends."""
    if not find_spec("fcntl"):
        return  # Windows
    import fcntl

    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as problem:
        raise UsageError(f"another process is at work on the {study} in {into}: wait for it, or end it") from problem


def _read(stream: IO[bytes]) -> dict[int, PointResult]:
    """Read the rows that are whole; half a line at the end, of a process that was killed or a full disk, is cut off."""
    stream.seek(0)
    rows: dict[int, PointResult] = {}
    end = 0
    for line in stream.read().split(b"\n")[:-1]:
        try:
            fields: dict[str, Any] = json.loads(line)
            place = fields.pop("point") - 1
            rows[place] = PointResult(**{**fields, **{key: tuple(fields[key]) for key in ("warnings", "assumptions")}})
        except (ValueError, AttributeError, KeyError, TypeError):
            break
        end += len(line) + 1
    stream.truncate(end)
    return rows
