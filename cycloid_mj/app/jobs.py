"""Long work for the page: one after the other, with what it tells on its way; it can be stopped."""

import itertools
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cycloid_mj.app.workers import Work, Worker
from cycloid_mj.base.errors import CycloidError, UsageError

MOST_WAITING = 6
MOST_KEPT = 40
"""Jobs that wait, and that are kept after they are done or stopped."""


@dataclass
class Job:
    """One long-running job: `told` is its last progress report, `files` and `page` are its downloads."""

    number: int
    state: str = "waits"
    told: Any = None
    result: Any = None
    error: str = ""
    files: Mapping[str, bytes] = field(default_factory=dict)
    page: str = ""

    def as_json(self) -> dict[str, Any]:
        """Convert it to JSON values: files by their names alone."""
        state = {"job": self.number, "state": self.state, "told": self.told, "result": self.result, "error": self.error}
        return {**state, "files": list(self.files), "page": bool(self.page)}


@dataclass(frozen=True)
class Made:
    """What a job makes to be fetched: files by name, or a page."""

    files: Mapping[str, bytes] = field(default_factory=dict)
    page: str = ""


class Jobs:
    """All long work of the page."""

    def __init__(self, worker: Worker) -> None:
        self._worker, self._numbers = worker, itertools.count(1)
        self._jobs: dict[int, Job] = {}
        self._turn, self._running = threading.Lock(), 0

    def start(self, work: Work, *args: Any) -> Job:
        """Start a work, or let it wait for those before it.

        Raises
        ------
        UsageError
            Too many wait.
        """
        if sum(job.state in ("waits", "runs") for job in self._jobs.values()) > MOST_WAITING:
            raise UsageError("too much work waits already: stop some of it, or wait")
        job = Job(next(self._numbers))
        self._jobs[job.number] = job
        for old in [one for one, other in self._jobs.items() if other.state in ("done", "stopped")][:-MOST_KEPT]:
            del self._jobs[old]
        threading.Thread(target=self._run, args=(job, work, args), daemon=True).start()
        return job

    def get(self, number: int) -> Job:
        """Return a job by its number.

        Raises
        ------
        UsageError
            It is gone.
        """
        if number not in self._jobs:
            raise UsageError("this work is gone: start it again")
        return self._jobs[number]

    def stop(self, number: int) -> Job:
        """Stop a job, wherever it is; errors as `get`."""
        job = self.get(number)
        waits, job.state = job.state == "waits", "stopped" if job.state in ("waits", "runs") else job.state
        if not waits and self._running == number:
            self._worker.stop()
        return job

    def _run(self, job: Job, work: Work, args: tuple[Any, ...]) -> None:
        with self._turn:
            if job.state == "stopped":
                return
            job.state, self._running = "runs", job.number
            try:
                result = self._worker.do(work, *args, told=lambda content: setattr(job, "told", content))
            except CycloidError as error:
                job.error = "" if job.state == "stopped" else str(error)
            else:
                if isinstance(result, Made):
                    job.files, job.page = result.files, result.page
                else:
                    job.result = result
            finally:
                self._running = 0
                job.state = "stopped" if job.state == "stopped" else "done"
