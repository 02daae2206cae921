"""Runs of one design under one load: independent starts and their measures."""

from collections.abc import Callable
from dataclasses import dataclass

from cycloid_mj.comparison.measures import Measures
from cycloid_mj.comparison.starts import StartSpread
from cycloid_mj.design import Design


@dataclass(frozen=True)
class Trial:
    """A design under one load, and the measures of its runs.

    Attributes
    ----------
    design, measures
        Design and measures of the first start.
    others
        Measures of further independent starts.
    """

    design: Design
    measures: Measures
    others: tuple[Measures, ...] = ()

    @property
    def name(self) -> str:
        """Name of the design."""
        return self.design.name

    @property
    def load(self) -> float:
        """Load torque on the output [N m]."""
        return self.design.load.torque

    @property
    def starts(self) -> tuple[Measures, ...]:
        """Measures of every start."""
        return (self.measures, *self.others)

    def over_starts(self, figure: Callable[[Measures], float | None]) -> StartSpread | None:
        """Return the values of a quantity at all starts that have it; None where none has."""
        values = [value for each in self.starts if (value := figure(each)) is not None]
        return StartSpread.of(values) if values else None
