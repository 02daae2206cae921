"""A short run of the page's design, with how far it has come, and the page that reviews it."""

import math

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import Design
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.report import report

TURNS = 1.25
"""Crank turns after the load has come on and the start has rung out."""

SETTLING = 0.015
"""Seconds for that."""


class Runner:
    """Runs designs one after the other; `share` is how much of the one that runs is done."""

    def __init__(self) -> None:
        self.share = 0.0

    def run(self, design: Design) -> str:
        """Run a design at full speed under its load, and give the review of the run as a page.

        Raises
        ------
        CycloidError
            The run went wrong, or the crank stands still.
        """
        if design.drive.speed == 0.0:
            raise DesignError("the crank stands still: give it a speed")
        self.share = 0.0
        turn = 2.0 * math.pi / abs(design.drive.speed)
        short = design.but(drive={"ramp": 0.0, "hold": SETTLING + TURNS * turn})
        return report({design.name: simulate(short, progress=self._note)})

    def _note(self, done: int, whole: int) -> None:
        self.share = done / whole
