"""Jobs of the page: long work in one queue per kind, which reports its progress and can be stopped.

Studies wait for each other, and so do files; neither waits for the other. A small file is written immediately.
"""

import itertools
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from cycloid_mj.app.limits import REQUESTS
from cycloid_mj.app.workers import Progress, Work
from cycloid_mj.base.errors import CycloidError, UsageError


class JobWorker(Protocol):
    """Runs functions one after the other, see `workers.Worker`."""

    def do(self, work: Work, *args: Any, on_progress: Progress | None = None) -> Any:
        """Run the function `work`, which receives `on_progress` and `args`, and return its result."""

    def stop(self) -> None:
        """Stop the function that is running."""


class InProcess:
    """Runs functions in this process: for work of some milliseconds, which cannot be stopped."""

    def do(self, work: Work, *args: Any, on_progress: Progress | None = None) -> Any:
        """Run the function `work`, which receives `on_progress` and `args`, and return its result."""
        return work(on_progress, *args)

    def stop(self) -> None:
        """Do nothing: functions in this process cannot be stopped."""


@dataclass
class Job:
    """A job.

    Attributes
    ----------
    number
        Its number in the addresses of its files.
    name
        What it computes, in words.
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
    name: str = ""
    state: str = "queued"
    progress: Any = None
    result: Any = None
    error: str = ""
    files: Mapping[str, bytes] = field(default_factory=dict)
    page: str = ""

    def as_json(self) -> dict[str, Any]:
        """Return the state of a background job of the page as JSON values.

        ``job`` is its number, ``state``, ``progress``, ``result`` and ``error`` are its attributes, ``files`` are only
        the names of its files, and ``page`` says whether it has a report.
        """
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


@dataclass
class Queue:
    """Jobs that run one after the other in a worker; `running` is the one that runs now, `waiting` the others."""

    worker: JobWorker
    turn: threading.Lock = field(default_factory=threading.Lock)
    running: Job | None = None
    waiting: list[Job] = field(default_factory=list)


class Jobs:
    """The jobs of a page, in queues by name with a worker each."""

    def __init__(self, workers: Mapping[str, JobWorker]) -> None:
        self._queues = {name: Queue(worker) for name, worker in workers.items()}
        self._numbers = itertools.count(1)
        self._jobs: dict[int, Job] = {}

    def start(self, queue: str, name: str, work: Work, *args: Any) -> Job:
        """Start a background job of the page in a queue, and return it; it waits for the earlier jobs of this queue.

        Parameters
        ----------
        queue
            Name of the queue.
        name
            What the job computes, in words.
        work, args
            Function and its arguments; before these it gets a callback for the progress.

        Raises
        ------
        UsageError
            Too many jobs are queued.
        """
        if sum(job.state in ("queued", "running") for job in self._jobs.values()) > REQUESTS.queued_jobs:
            raise UsageError(
                f"{REQUESTS.queued_jobs} jobs are queued, which is the maximum: stop one of them, or wait until one "
                "of them has finished"
            )
        job = Job(next(self._numbers), name)
        self._jobs[job.number] = job
        finished_numbers = [
            number for number, other_job in self._jobs.items() if other_job.state in ("done", "stopped")
        ]
        for number in finished_numbers[: -REQUESTS.finished_jobs]:
            del self._jobs[number]
        threading.Thread(target=self._run, args=(self._queues[queue], job, work, args), daemon=True).start()
        return job

    def describe(self, job: Job) -> dict[str, Any]:
        """Convert a job to JSON values (`Job.as_json`); a queued job's progress names the job that runs before it."""
        running_job = next((queue.running for queue in self._queues.values() if job in queue.waiting), None)
        if job.state != "queued" or running_job is None:
            return job.as_json()
        activity = running_job.progress.get("doing", "") if isinstance(running_job.progress, Mapping) else ""
        words = ", ".join(filter(None, (f"queued behind {running_job.name}", activity)))
        return job.as_json() | {"progress": {"doing": words}}

    def get(self, number: int) -> Job:
        """Return the background job with this number that the page of the app started.

        Raises
        ------
        UsageError
            There is no such job, or its results are no longer kept.
        """
        if number not in self._jobs:
            raise UsageError(
                f"job {number} does not exist, or its result is no longer stored: check the number, or start a new job"
            )
        return self._jobs[number]

    def stop(self, number: int) -> Job:
        """Stop the queued or running job with a number, and return it; a finished job is returned unchanged.

        Raises
        ------
        UsageError
            There is no such job, or its results are no longer kept.
        """
        job = self.get(number)
        if job.state not in ("queued", "running"):
            return job
        job.state = "stopped"
        for queue in self._queues.values():
            if queue.running is job:
                queue.worker.stop()
        return job

    def _run(self, queue: Queue, job: Job, work: Work, args: tuple[Any, ...]) -> None:
        """Wait for the earlier jobs of the queue, then run a job unless it was stopped; runs in a thread.

        `work` is the function of the job, and `args` are its arguments. The job gets the result, or the text of an
        error.
        """
        queue.waiting.append(job)
        with queue.turn:
            queue.waiting.remove(job)
            if job.state == "stopped":
                return
            job.state, queue.running = "running", job
            try:
                result = queue.worker.do(work, *args, on_progress=lambda report: setattr(job, "progress", report))
            except CycloidError as error:
                job.error = "" if job.state == "stopped" else str(error)
            else:
                if isinstance(result, Download):
                    job.files, job.page = result.files, result.page
                else:
                    job.result = result
            finally:
                queue.running = None
                job.state = "stopped" if job.state == "stopped" else "done"
