"""Runs of designs, read from a matching log or simulated; only a few are in memory."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from pathlib import Path
from typing import overload

from cycloid_mj.base.errors import LogError, RunError, warn
from cycloid_mj.base.overwrite_guard import note_output
from cycloid_mj.base.record import Run
from cycloid_mj.cli.batch import run_all
from cycloid_mj.design import Design, dump
from cycloid_mj.dynamics.run import Solver, provenance
from cycloid_mj.log import read
from cycloid_mj.reducer import Reducer
from hsieh2014.stage import Runs

KEPT = 8
"""Runs in memory; reading one takes some hundredths of a second, all would take some hundred megabytes."""


def log_name(design: Design, stands_on: Mapping[str, str]) -> str:
    """Return the file name of a design's log, with a hash of the design and of the versions in use."""
    load = f"{design.load.torque:g}Nm" if design.load.torque else "no-load"
    stands_for = dump(design) + "".join(f"\n{key}={value}" for key, value in sorted(stands_on.items()))
    return f"{design.name}-{load}-{hashlib.sha256(stands_for.encode()).hexdigest()[:12]}.mcap"


def fits(run: Run, design: Design, stands_on: Mapping[str, str]) -> bool:
    """Return whether a run is complete and has this design, these versions and this time step."""
    same = all(run.provenance.get(key) == value for key, value in stands_on.items())
    return run.complete and same and run.attachments.get("design.toml") == dump(design).encode()


class LoggedRuns(Sequence[Run]):
    """Sequence of the runs of some logs, each read when it is accessed."""

    def __init__(self, logs: Sequence[Path], read_log: Callable[[Path], Run]) -> None:
        self._logs, self._read_log = tuple(logs), read_log

    @overload
    def __getitem__(self, number: int) -> Run: ...
    @overload
    def __getitem__(self, number: slice) -> Sequence[Run]: ...
    def __getitem__(self, number: int | slice) -> Run | Sequence[Run]:
        """Read one run, or choose several."""
        if isinstance(number, slice):
            return LoggedRuns(self._logs[number], self._read_log)
        return self._read_log(self._logs[number])

    def __len__(self) -> int:
        """Count the runs."""
        return len(self._logs)


class Logs(Runs):
    """Provider of the runs of designs, simulated in parallel into a folder; `fresh` ignores existing logs."""

    def __init__(self, into: Path, fresh: bool, quiet: bool) -> None:
        super().__init__()
        self._into, self._fresh, self._quiet = into, fresh, quiet
        self._known: dict[tuple[Design, Solver], Path] = {}
        self._read = lru_cache(KEPT)(_read_and_warn)

    def __call__(self, designs: Sequence[Design], solver: Solver = "mujoco") -> LoggedRuns:
        """Return the run of each design by a solver; logs of the planar solver have no viewer frames.

        Raises
        ------
        RunError
            A run failed.
        KeyboardInterrupt
            Ctrl-C stopped the runs: it ends the command, not this stage alone.
        """
        known, used = self._known, partial(provenance, solver=solver)
        new = [design for design in designs if (design, solver) not in known]
        paths = {design: self._into / log_name(design, used(Reducer(design))) for design in new}
        missing = {
            design: path for design, path in paths.items() if self._fresh or not self._is_there(design, solver, path)
        }
        if missing:
            for path in missing.values():
                # one that was read did not fit
                note_output(path)
            self._read.cache_clear()
            try:
                run_all(
                    missing, force=True, quiet=self._quiet, solver=solver, viewable=None if solver == "mujoco" else ()
                )
            except RunError as error:
                if isinstance(error.__cause__, KeyboardInterrupt):
                    raise error.__cause__ from None
                raise
        self._known |= {(design, solver): path for design, path in paths.items()}
        return LoggedRuns([self._known[design, solver] for design in designs], self._read)

    def _is_there(self, design: Design, solver: Solver, path: Path) -> bool:
        try:
            return path.exists() and fits(self._read(path), design, provenance(Reducer(design), solver=solver))
        except LogError:
            return False


def _read_and_warn(log: Path) -> Run:
    run = read(log)
    warn(run.provenance["design"], run.warnings)
    return run
