"""Jobs of the page: long work that runs one after the other, reports its progress and can be stopped."""

import itertools
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cycloid_mj.app.workers import Work, Worker
from cycloid_mj.base.errors import CycloidError, UsageError

MAX_QUEUED = 6
"""Jobs that may be queued; the server refuses more."""

MAX_FINISHED = 40
"""Finished and stopped jobs whose results are kept, the latest."""


@dataclass
class Job:
    """A job.

    Attributes
    ----------
    number
        Its number in the addresses of its files.
    state
        ``queued``, ``running``, ``done`` or ``stopped``.
    progress
        Its last progress report, in JSON values.
    result, error
        What it returned in JSON values, or why it failed.
    files, page
        Its downloads by name, and its HTML page.
    """

    number: int
    state: str = "queued"
    progress: Any = None
    result: Any = None
    error: str = ""
    files: Mapping[str, bytes] = field(default_factory=dict)
    page: str = ""

    def as_json(self) -> dict[str, Any]:
        """Convert the job to JSON values, with the names of its files only."""
        return {
            "job": self.number,
            "state": self.state,
            "progress": self.progress,
            "result": self.result,
            "error": self.error,
            "files": list(self.files),
            "page": bool(self.page),
        }


@dataclass(frozen=True)
class Download:
    """The result of a job that is not JSON: files by name, or an HTML page."""

    files: Mapping[str, bytes] = field(default_factory=dict)
    page: str = ""


class Jobs:
    """The jobs of a page, which share one worker process."""

    def __init__(self, worker: Worker) -> None:
        self._worker, self._numbers = worker, itertools.count(1)
        self._jobs: dict[int, Job] = {}
        self._turn, self._running = threading.Lock(), 0

    def start(self, work: Work, *args: Any) -> Job:
        """Start a job, or queue it behind the others.

        Raises
        ------
        UsageError
            Too many jobs are queued.
        """
        if sum(job.state in ("queued", "running") for job in self._jobs.values()) > MAX_QUEUED:
            raise UsageError(f"{MAX_QUEUED} jobs are queued already: stop one of them, or wait")
        job = Job(next(self._numbers))
        self._jobs[job.number] = job
        finished = [number for number, other in self._jobs.items() if other.state in ("done", "stopped")]
        for number in finished[:-MAX_FINISHED]:
            del self._jobs[number]
        threading.Thread(target=self._run, args=(job, work, args), daemon=True).start()
        return job

    def get(self, number: int) -> Job:
        """Return a job by its number.

        Raises
        ------
        UsageError
            There is no such job, or its results are no longer kept.
        """
        if number not in self._jobs:
            raise UsageError("this job is no longer available: start it again")
        return self._jobs[number]

    def stop(self, number: int) -> Job:
        """Stop a queued or running job; errors as `get`."""
        job = self.get(number)
        queued = job.state == "queued"
        if job.state in ("queued", "running"):
            job.state = "stopped"
        if not queued and self._running == number:
            self._worker.stop()
        return job

    def _run(self, job: Job, work: Work, args: tuple[Any, ...]) -> None:
        """Run a job when those before it have ended, unless it was stopped; runs in a thread."""
        with self._turn:
            if job.state == "stopped":
                return
            job.state, self._running = "running", job.number
            try:
                result = self._worker.do(work, *args, on_progress=lambda content: setattr(job, "progress", content))
            except CycloidError as error:
                job.error = "" if job.state == "stopped" else str(error)
            else:
                if isinstance(result, Download):
                    job.files, job.page = result.files, result.page
                else:
                    job.result = result
            finally:
                self._running = 0
                job.state = "stopped" if job.state == "stopped" else "done"
