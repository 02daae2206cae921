"""A Dask scheduler with workers, each a process of this machine: for measurements and tests."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType

ROOT = Path(__file__).parents[1]


class Cluster:
    """A scheduler and its workers; a context manager that ends them.

    Parameters
    ----------
    folder
        For the scheduler's file.
    workers
        How many, of one thread each.
    path
        Further folders that the workers import from.
    """

    def __init__(self, folder: Path, workers: int = 2, path: tuple[Path, ...] = ()) -> None:
        """Start the scheduler and the workers, and wait for the scheduler's file."""
        self._file = folder / "scheduler.json"
        self._path = os.pathsep.join(map(str, (ROOT, *path)))
        self.scheduler = self._start("scheduler", "--port", "0", "--no-dashboard")
        self.workers = [
            self._start("worker", "--no-nanny", "--nthreads", "1", "--no-dashboard") for _ in range(workers)
        ]
        while not self._file.exists() and self.scheduler.poll() is None:
            time.sleep(0.05)

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()

    @property
    def address(self) -> str:
        """``HOST:PORT`` of the scheduler."""
        return str(json.loads(self._file.read_text())["address"]).removeprefix("tcp://")

    def _start(self, *words: str) -> subprocess.Popen[bytes]:
        command = (sys.executable, "-m", "dask", *words, "--scheduler-file", str(self._file))
        environment = {**os.environ, "PYTHONPATH": self._path}
        return subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL, cwd=self._file.parent)
