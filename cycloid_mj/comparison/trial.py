"""The runs of one design under one load: independent starts, and what each measured."""

from collections.abc import Callable
from dataclasses import dataclass

from cycloid_mj.comparison.measures import Measures
from cycloid_mj.comparison.starts import StartSpread
from cycloid_mj.design import Design


@dataclass(frozen=True)
class Trial:
    """A design that was run under one load, and what the run measured.

    Attributes
    ----------
    design
        Of the first start.
    measures
        Of the first start.
    others
        Measures of further independent starts: all that any figure of an idle run rests on.
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
        """Return a figure of every start that has it; None where none has."""
        values = [value for each in self.starts if (value := figure(each)) is not None]
        return StartSpread.of(values) if values else None
