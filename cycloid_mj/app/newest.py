"""Solve the newest design only: designs that arrive while an older one is solved replace each other."""

import asyncio
import logging
from collections.abc import Callable, Mapping

from nicegui import background_tasks

from cycloid_mj.app.shown import FigureLine
from cycloid_mj.app.workers import Work, Workers
from cycloid_mj.design import Design

_log = logging.getLogger(__name__)


class Newest:
    """Has works done on the newest design it is asked for, and shows what they give."""

    def __init__(self, workers: Workers, shown: Mapping[Work, Callable[[tuple[FigureLine, ...]], None]]) -> None:
        """Take what shows the lines of each work; the longest works should come first."""
        self._workers, self._shown = workers, shown
        self._asked: Design | None = None
        self._round, self._busy = 0, False

    def ask(self, design: Design) -> None:
        """Have a design solved as soon as the one before it is done."""
        self._asked = design
        if not self._busy:
            self._busy = True
            background_tasks.create(self._solve())

    def drop(self) -> None:
        """Show nothing of what was asked for so far."""
        self._asked = None
        self._round += 1

    async def _solve(self) -> None:
        try:
            while design := self._asked:
                self._asked = None
                await asyncio.gather(*(self._one(work, design, self._round) for work in self._shown))
        finally:
            self._busy = False

    async def _one(self, work: Work, design: Design, asked_in: int) -> None:
        try:
            lines = await self._workers.do(work, design)
        except Exception as error:  # whatever goes wrong with one design, the page goes on
            reason = f"{type(error).__name__}: {error}"
            _log.error("error: %s of a design failed: %s", work.__name__, reason)
            lines = (FigureLine("failed", reason),)
        if asked_in == self._round:
            self._shown[work](lines)
