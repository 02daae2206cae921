"""Several runs in parallel, each with its own log, and one progress display for all of them.

Threads are enough: time steps release Python's global lock.
"""

import threading
from collections.abc import Container, Mapping
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from pathlib import Path
from typing import TYPE_CHECKING

from cycloid_mj.base.engine import Engine
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.interrupt import Stopped, signal_name
from cycloid_mj.cli.progress import Progress
from cycloid_mj.cli.simulate import run_into_log
from cycloid_mj.design import Design

if TYPE_CHECKING:
    from cycloid_mj.dynamics.run import Solver


def run_all(
    jobs: Mapping[Design, Path],
    force: bool,
    quiet: bool,
    solver: "Solver" = "mujoco",
    viewable: Container[Design] | None = None,
) -> None:
    """Simulate designs in parallel threads, each into its own log.

    Parameters
    ----------
    jobs
        Design -> path of its log.
    force
        Whether existing logs are replaced.
    quiet
        If true, no progress is printed.
    solver
        Solver of the runs.
    viewable
        Designs whose runs are evaluated, and whose logs contain model and frames for 3-D viewers; by default all.

    Raises
    ------
    RunError
        A run failed, or Ctrl-C stopped them. All runs have ended, and each log that was begun is readable.
    CycloidError
        Another error of a run, such as an existing log.
    """
    workers = min(Engine(kind="threads").local_workers, len(jobs))
    total_time = sum(design.drive.ramp + design.drive.hold for design in jobs)
    with Progress(total_time, quiet) as progress, ThreadPoolExecutor(workers) as pool:
        count_text = "1 simulation" if len(jobs) == 1 else f"{len(jobs)} simulations, {workers} of them in parallel"
        progress.tell(f"running {count_text}")
        total_progress = _TotalProgress(progress)
        runs = [
            pool.submit(
                run_into_log,
                design,
                [path],
                force,
                _PartProgress(total_progress),
                solver=solver,
                viewable=viewable is None or design in viewable,
            )
            for design, path in jobs.items()
        ]
        try:
            wait(runs, return_when=FIRST_EXCEPTION)
            failed_run = next((run for run in runs if run.done() and run.exception()), None)
            if failed_run is not None:
                failed_run.result()
        except KeyboardInterrupt as stop:
            total_progress.stop(signal_name(stop))
            raise RunError(_stop_message(jobs, stop)) from stop
        finally:
            total_progress.stop("the failure of another run")
            pool.shutdown(wait=False, cancel_futures=True)


class _TotalProgress:
    """Simulated time of all runs together, and whether they are to stop."""

    def __init__(self, progress: Progress) -> None:
        self.stopped_by = ""
        self._progress = progress
        self._simulated = 0.0
        self._lock = threading.Lock()

    def stop(self, reason: str) -> None:
        self.stopped_by = self.stopped_by or reason

    def advance(self, seconds: float) -> None:
        with self._lock:
            self._simulated += seconds
            self._progress.report_time(self._simulated)


class _PartProgress(Progress):
    """Progress of one run; it stops the run like Ctrl-C when all runs are to stop."""

    def __init__(self, total_progress: _TotalProgress) -> None:
        super().__init__(end=0.0, quiet=True)
        self._total_progress = total_progress
        self._reported = 0.0

    def report_time(self, simulated: float) -> None:
        if self._total_progress.stopped_by:
            raise Stopped(self._total_progress.stopped_by)
        self._total_progress.advance(simulated - self._reported)
        self._reported = simulated


def _stop_message(jobs: Mapping[Design, Path], stop: KeyboardInterrupt) -> str:
    folder = next(iter(jobs.values())).parent
    return f"stopped by {signal_name(stop)}; the logs of the finished part are in {folder}"
