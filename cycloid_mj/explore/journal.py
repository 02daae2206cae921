"""Folder of a sweep, to which each row is written at once, so that an interrupted sweep can be resumed."""

import errno
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import IO, Any

from cycloid_mj.base.atomic_write import write_files
from cycloid_mj.base.errors import CycloidError, UsageError, reason
from cycloid_mj.base.file_lock import lock_file
from cycloid_mj.base.interrupt import defer_signals
from cycloid_mj.base.overwrite_guard import make_folder, note_output
from cycloid_mj.explore.row import PointResult

SWEEP = "sweep"
"""Name of the study, and stem of its files."""


def plan_file(study: str) -> str:
    """Return the name of the file with the plan of a study."""
    return f"{study}.json"


def rows_file(study: str) -> str:
    """Return the name of the file with the rows of a study."""
    return f"{study}.rows.jsonl"


def has_study(folder: Path, study: str) -> bool:
    """Return whether a folder contains a study, finished or not."""
    return (folder / plan_file(study)).exists() or (folder / rows_file(study)).exists()


def remove_study(folder: Path, study: str) -> None:
    """Delete the plan and the results of a study ("sweep" or "optimize") in a folder, so that it can start again.

    Raises
    ------
    UsageError
        Another process is working in the folder.
    CycloidError
        The files cannot be removed.
    """
    rows_path = folder / rows_file(study)
    try:
        if rows_path.exists():
            with _lock_study(rows_path, folder, study):
                rows_path.unlink()
        (folder / plan_file(study)).unlink(missing_ok=True)
    except OSError as problem:
        raise CycloidError(
            f"cannot replace {rows_path}: {reason(problem)}. Choose another folder with --out"
        ) from problem


def create_folder(folder: Path) -> Path:
    """Create the folder of a sweep or optimisation unless it exists; return its path, raise CycloidError on failure."""
    try:
        make_folder(folder)
    except OSError as problem:
        raise CycloidError(
            f"cannot create the folder {folder}: {reason(problem)}. Choose another folder with --out"
        ) from problem
    return folder


class Journal:
    """File of rows, a line for each, in the order of their arrival."""

    def __init__(self, path: Path, stream: IO[bytes], rows: dict[int, PointResult]) -> None:
        self.path = path
        self.rows = rows
        self._stream = stream

    def add(self, index: int, row: PointResult) -> None:
        """Append the result of a point of a sweep or optimisation to its file of rows.

        Parameters
        ----------
        index
            Index of the point, counted from 0.
        row
            Result of the point.

        Raises
        ------
        CycloidError
            The row cannot be written; rows written before are kept.
        """
        line = json.dumps({"point": index + 1, **asdict(row)}).encode() + b"\n"
        try:
            with defer_signals():
                if self._stream.write(line) != len(line):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError as problem:
            raise CycloidError(
                f"cannot write {self.path}: {reason(problem)}. The {len(self.rows)} rows written before are complete; "
                "free disk space and run the same command again"
            ) from problem
        self.rows[index] = row


@contextmanager
def open_journal(folder: Path, plan: Mapping[str, Any], study: str = SWEEP) -> Iterator[Journal]:
    """Open the record of a study in a folder, new or interrupted; a context manager that yields its `Journal`.

    A study is a sweep or an optimisation. The record has a row for each evaluated point. The folder gets the study's
    plan, and a lock against other processes for as long as the context is open.

    Parameters
    ----------
    folder
        Folder of the study; it exists.
    plan
        Design, points and settings that identify the study: JSON values by name.
    study
        Name of the study, and stem of its files.

    Raises
    ------
    UsageError
        The folder belongs to another study, or another process is working in it.
    CycloidError
        The files cannot be read or written.
    """
    if _is_same_study(folder, plan, study):
        note_output(folder)
    path = folder / rows_file(study)
    try:
        stream = path.open("ab+", buffering=0)
    except OSError as problem:
        raise CycloidError(f"cannot write {path}: {reason(problem)}. Choose another folder with --out") from problem
    with stream, _lock_study(path, folder, study):
        if not (folder / plan_file(study)).exists():
            write_files({folder / plan_file(study): json.dumps(plan, indent=2).encode() + b"\n"})
        yield Journal(path, stream, _read_rows(stream))


def _is_same_study(folder: Path, plan: Mapping[str, Any], study: str) -> bool:
    """Return whether a folder already has this sweep or optimisation: True for the same plan, False without a plan.

    `plan` identifies the study by its inputs and versions, and `study` is its name for messages.

    Raises
    ------
    UsageError
        The folder has a study with another plan.
    CycloidError
        The plan in the folder cannot be read.
    """
    plan_path, rows_path = folder / plan_file(study), folder / rows_file(study)
    try:
        recorded_study = json.loads(plan_path.read_bytes())
    except FileNotFoundError:
        if rows_path.exists() and rows_path.stat().st_size:
            raise UsageError(
                f"{folder} contains {rows_path.name}, but the file {plan_path.name} that describes it is missing, so "
                f"the {study} cannot be resumed: choose another folder with --out"
            ) from None
        return False
    except (OSError, ValueError) as problem:
        raise CycloidError(f"cannot read {plan_path}: {reason(problem)}. Choose another folder with --out") from problem
    differing_keys = [
        key
        for key in plan
        if not isinstance(recorded_study, dict) or recorded_study.get(key) != json.loads(json.dumps(plan[key]))
    ]
    if differing_keys:
        raise UsageError(
            f"{folder} contains another {study}, which differs in {', '.join(differing_keys)}: choose another folder "
            "with --out, or overwrite it with --force"
        )
    return True


@contextmanager
def _lock_study(rows: Path, folder: Path, study: str) -> Iterator[None]:
    """Lock the file `rows` of a sweep or optimisation against other processes while the context is open.

    Raise UsageError if another process has locked it. `folder` and `study`, its name, are for the message.
    """
    try:
        release = lock_file(rows)
    except BlockingIOError as problem:
        raise UsageError(
            f"another process is writing the {study} in {folder}: wait until it ends, or stop it"
        ) from problem
    try:
        yield
    finally:
        release()


def _read_rows(stream: IO[bytes]) -> dict[int, PointResult]:
    """Read the results of a sweep or optimisation from a file open for reading and writing, by index of the point.

    The first line of `stream` that is not valid, and all after it, are cut from the file. A line is incomplete if the
    process was killed while writing, or if the disk was full.
    """
    stream.seek(0)
    rows: dict[int, PointResult] = {}
    valid_length = 0
    for line in stream.read().split(b"\n")[:-1]:
        try:
            fields: dict[str, Any] = json.loads(line)
            index = fields.pop("point") - 1
            rows[index] = PointResult(**{**fields, **{key: tuple(fields[key]) for key in ("warnings", "assumptions")}})
        except (ValueError, AttributeError, KeyError, TypeError):
            break
        valid_length += len(line) + 1
    stream.truncate(valid_length)
    return rows
