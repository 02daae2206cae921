"""Input and output of a stage."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Claim, Table
from cycloid_mj.design import Design
from cycloid_mj.dynamics.run import Solver
from hsieh2014.plan import Plan
from hsieh2014.run_figures import RunFigures, run_figures


class Runs(ABC):
    """Provider of the run of each design by a solver, from a matching log or by simulation.

    A run is read each time it is requested; its figures are kept.
    """

    def __init__(self) -> None:
        self._figures: dict[tuple[Design, Solver], RunFigures] = {}

    @abstractmethod
    def __call__(self, designs: Sequence[Design], solver: Solver = "mujoco") -> Sequence[Run]:
        """Return the runs in the order of their designs."""

    def figures(self, designs: Sequence[Design], solver: Solver) -> list[RunFigures]:
        """Return the figures of each run, in the order of the designs."""
        missing = [design for design in dict.fromkeys(designs) if (design, solver) not in self._figures]
        for design, run in zip(missing, self(missing, solver), strict=True):
            self._figures[design, solver] = run_figures(run)
        return [self._figures[design, solver] for design in designs]


Progress = Callable[[str], None]
"""Callback with the next task of a stage."""


def silent(text: str) -> None:
    """Report no progress."""


@dataclass(frozen=True, eq=False)
class PaperFigure:
    """A figure: `name` of its file, number of the paper's figure, caption, and drawing."""

    name: str
    stands_for: str
    caption: str
    drawing: Any


@dataclass(frozen=True, eq=False)
class StageResult:
    """Results of a stage: figures, tables, claims, machine-readable values, and notes of one sentence each."""

    plates: tuple[PaperFigure, ...] = ()
    tables: tuple[Table, ...] = ()
    claims: tuple[Claim, ...] = ()
    findings: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


Work = Callable[[Plan, Runs, Progress], StageResult]


@dataclass(frozen=True)
class Stage:
    """A stage: `key`, `title`, the `paper`'s figures, its function `work`, and its run time, quick and full [s].

    Claims that are `judged_on_starts` use the runs of the plan's solver.
    """

    key: str
    title: str
    paper: str
    work: Work
    quick: float
    full: float
    judged_on_starts: bool = False

    @property
    def heading(self) -> str:
        """Return the title with the paper's figures."""
        return f"{self.title} ({self.paper})"


@dataclass(frozen=True, eq=False)
class StageRun:
    """A stage that ran: its results, its run time in `seconds`, and its `error` ("" for success)."""

    step: Stage
    result: StageResult
    seconds: float
    error: str = ""

    def as_json(self) -> dict[str, Any]:
        """Convert the stage to JSON values without its claims, which are listed separately."""
        return {
            "key": self.step.key,
            "title": self.step.title,
            "paper": self.step.paper,
            "seconds": round(self.seconds, 1),
            "error": self.error,
            "figures": [plate.name for plate in self.result.plates],
            "findings": dict(self.result.findings),
            "tables": [table.as_json() for table in self.result.tables],
            "notes": list(self.result.notes),
        }
