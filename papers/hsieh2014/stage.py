"""What a stage is given, and what it leaves."""

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
    """Gives the run of each design by a solver: from a log that fits, or by running it.

    A run is read whenever it is asked for; what is judged of it is kept.
    """

    def __init__(self) -> None:
        self._figures: dict[tuple[Design, Solver], RunFigures] = {}

    @abstractmethod
    def __call__(self, designs: Sequence[Design], solver: Solver = "mujoco") -> Sequence[Run]:
        """Return the runs in the order of their designs."""

    def figures(self, designs: Sequence[Design], solver: Solver) -> list[RunFigures]:
        """Return what is judged of each run, in the order of their designs."""
        missing = [design for design in dict.fromkeys(designs) if (design, solver) not in self._figures]
        for design, run in zip(missing, self(missing, solver), strict=True):
            self._figures[design, solver] = run_figures(run)
        return [self._figures[design, solver] for design in designs]


Progress = Callable[[str], None]
"""Called with what a stage does next."""


def silent(text: str) -> None:
    """Report no progress."""


@dataclass(frozen=True, eq=False)
class PaperFigure:
    """One figure: its `name` as a file, the paper's figure that it stands for, what it shows, and the drawing."""

    name: str
    stands_for: str
    caption: str
    drawing: Any


@dataclass(frozen=True, eq=False)
class StageResult:
    """What a stage found: figures, tables, claims, findings for a program, and notes, a sentence each."""

    plates: tuple[PaperFigure, ...] = ()
    tables: tuple[Table, ...] = ()
    claims: tuple[Claim, ...] = ()
    findings: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


Work = Callable[[Plan, Runs, Progress], StageResult]


@dataclass(frozen=True)
class Stage:
    """A stage to run: its `key`, `title`, the `paper`'s figures, its `work`, and shares of the time, quick and full.

    Its claims may be `judged_on_starts`, which the plan's solver runs.
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
        """Title, and the paper's figures."""
        return f"{self.title} ({self.paper})"


@dataclass(frozen=True, eq=False)
class StageRun:
    """A step that was run: what it found, the `seconds` it took, and its `error`; "" if it came through."""

    step: Stage
    result: StageResult
    seconds: float
    error: str = ""

    def as_json(self) -> dict[str, Any]:
        """Convert the stage to JSON values; its claims stand apart."""
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
