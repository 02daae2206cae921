"""Processes beside the page's own that check and solve: it redraws at once whatever they are busy with."""

import asyncio
import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

from cycloid_mj.app.shown import FigureLine
from cycloid_mj.base.engine.housekeeping import serve_parent
from cycloid_mj.design import PRESETS, Design

Work = Callable[[Design], tuple[FigureLine, ...]]

COUNT = 2
"""Processes: two share what a page shows of a design about evenly."""


class Workers:
    """A few processes, which all windows share. They end with this one, however it ends."""

    def __init__(self, works: Sequence[Work]) -> None:
        """Start them, each of which does the `works` once, for their code to be loaded when somebody waits."""
        self._works = tuple(works)
        self._pool = self._started()

    async def do(self, work: Work, design: Design) -> tuple[FigureLine, ...]:
        """Return what a work makes of a design; if a process has died, as for want of memory, with new ones."""
        loop, pool = asyncio.get_running_loop(), self._pool
        try:
            return await loop.run_in_executor(pool, work, design)
        except BrokenProcessPool:
            if self._pool is pool:  # else another work has found it broken before
                self._pool = self._started()
            return await loop.run_in_executor(self._pool, work, design)

    def close(self) -> None:
        """End them at once: nothing is lost with what they are at."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        for child in multiprocessing.active_children():
            child.terminate()

    def _started(self) -> ProcessPoolExecutor:
        pool = ProcessPoolExecutor(COUNT, multiprocessing.get_context("spawn"), _prepare, (self._works,))
        for _ in range(COUNT):
            pool.submit(os.getpid)
        return pool


def _prepare(works: Sequence[Work]) -> None:
    """Serve the page's process, and load what the works need."""
    serve_parent()
    for work in works:
        work(PRESETS["pin"])
