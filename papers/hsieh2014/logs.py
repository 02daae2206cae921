"""The runs of designs, each read from a log that fits it, else run into one."""

import hashlib
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from cycloid_mj.base.errors import LogError, RunError, warn
from cycloid_mj.base.record import Run
from cycloid_mj.base.replacing import as_own
from cycloid_mj.cli.batch import run_all
from cycloid_mj.design import Design, dump
from cycloid_mj.dynamics.run import provenance
from cycloid_mj.log import read
from cycloid_mj.reducer import Reducer

DIGITS = 12


def log_name(design: Design, stands_on: Mapping[str, str]) -> str:
    """Give the file name of a design's log, with a hash of the design and of what a run of it stands on."""
    load = f"{design.load.torque:g}Nm" if design.load.torque else "no-load"
    stands_for = dump(design) + "".join(f"\n{key}={value}" for key, value in sorted(stands_on.items()))
    return f"{design.name}-{load}-{hashlib.sha256(stands_for.encode()).hexdigest()[:DIGITS]}.mcap"


def fits(run: Run, design: Design, stands_on: Mapping[str, str]) -> bool:
    """Whether a run reached its end, has this design, and stands on these versions and this step."""
    same = all(run.provenance.get(key) == value for key, value in stands_on.items())
    return run.complete and same and run.attachments.get("design.toml") == dump(design).encode()


class Logs:
    """Gives the runs of designs, several run at a time: `into` a folder, all of them anew where `fresh`."""

    def __init__(self, into: Path, fresh: bool, quiet: bool) -> None:
        self._into, self._fresh, self._quiet = into, fresh, quiet
        self._known: dict[Design, Run] = {}

    def __call__(self, designs: Sequence[Design]) -> list[Run]:
        """Give the run of each design.

        Raises
        ------
        RunError
            A run went wrong.
        KeyboardInterrupt
            Ctrl-C stopped the runs: it ends the command, not this stage alone.
        """
        paths = {
            design: self._into / log_name(design, provenance(Reducer(design)))
            for design in designs
            if design not in self._known
        }
        missing = {design: path for design, path in paths.items() if self._fresh or not _is_there(design, path)}
        if missing:
            for path in missing.values():
                # one that was read did not fit
                as_own(path)
            try:
                run_all(missing, min(os.cpu_count() or 1, len(missing)), force=True, quiet=self._quiet)
            except RunError as error:
                if isinstance(error.__cause__, KeyboardInterrupt):
                    raise error.__cause__ from None
                raise
        self._known |= {design: read(path) for design, path in paths.items()}
        for design in paths:
            warn(design.name, self._known[design].warnings)
        return [self._known[design] for design in designs]


def _is_there(design: Design, path: Path) -> bool:
    try:
        return path.exists() and fits(read(path), design, provenance(Reducer(design)))
    except LogError:
        return False
