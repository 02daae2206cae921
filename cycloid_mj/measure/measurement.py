"""The result of a measure: quantities with their numerical errors and closed forms, curves, assumptions, and runs."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Curve, Quantity, Table
from cycloid_mj.design import Design, material_limits
from cycloid_mj.figures import of_measure, values_json


@dataclass(frozen=True, eq=False)
class Measurement:
    """What one measure found of one design.

    Attributes
    ----------
    measure
        Name of the measure, as on the command line.
    design
        What was measured.
    quantities
        Key -> number; the keys are those of the JSON object.
    curves
        For the figure.
    tables
        Beside the quantities.
    assumptions
        What the numbers stand on, a sentence each; the limits of the materials come last by themselves.
    runs
        Name -> underlying run, for the logs.
    details
        More for a program: key -> anything that JSON can hold.
    condition
        Under what it was measured: load, speed; it stands above the figure.
    """

    measure: str
    design: Design
    quantities: Mapping[str, Quantity]
    curves: tuple[Curve, ...] = ()
    tables: tuple[Table, ...] = ()
    assumptions: tuple[str, ...] = ()
    runs: Mapping[str, Run] = field(default_factory=dict)
    details: Mapping[str, Any] = field(default_factory=dict)
    condition: str = ""

    def __post_init__(self) -> None:
        """State what time and heat do to the design's materials beside the assumptions, once."""
        sentences = dict.fromkeys((*self.assumptions, *material_limits(self.design)))
        object.__setattr__(self, "assumptions", tuple(sentences))

    def __getitem__(self, key: str) -> float:
        """Return the value of a quantity."""
        return self.quantities[key].value

    def as_json(self) -> dict[str, Any]:
        """Convert the measurement to JSON values."""
        return {
            "measure": self.measure,
            "design": self.design.name,
            "condition": self.condition,
            "quantities": {key: quantity.as_json() for key, quantity in self.quantities.items()},
            "figures": values_json(of_measure(self.measure, self.quantities)),
            "assumptions": list(self.assumptions),
            **self.details,
            "tables": [table.as_json() for table in self.tables],
            "curves": [curve.as_json() for curve in self.curves],
        }
