"""One run of a comparison: its design under one load, and its measures."""

from dataclasses import dataclass

from cycloid_mj.comparison.measures import Measures
from cycloid_mj.design import Design


@dataclass(frozen=True)
class Trial:
    """A design that was run under one load, and what the run measured."""

    design: Design
    measures: Measures

    @property
    def name(self) -> str:
        """Name of the design."""
        return self.design.name

    @property
    def load(self) -> float:
        """Load torque on the output [N m]."""
        return self.design.load.torque
