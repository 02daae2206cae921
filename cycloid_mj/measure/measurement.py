"""The result of a measure: quantities with their numerical errors and closed forms, curves, assumptions, and runs."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

from cycloid_mj.base.frame import Frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Curve, Quantity, Table, quantity_frame
from cycloid_mj.design import Design
from cycloid_mj.figures import of_measure, values_json
from cycloid_mj.geometry.measured import part_notes


@dataclass(frozen=True, eq=False, repr=False)
class Measurement(Presented):
    """Result of a measure.

    Attributes
    ----------
    measure
        Name of the measure, as on the command line.
    design
        The measured design.
    quantities
        Key -> quantity; the keys are those of the JSON object.
    curves
        Curves of the figure.
    tables
        Further tables.
    assumptions
        Assumptions, a sentence each; notes on measured parts and materials are appended.
    runs
        Name -> run, for the logs.
    details
        Further JSON values by key.
    condition
        Load and speed, the title of the figure.
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
        """Append temperatures to the condition, and notes on the parts to the assumptions."""
        sentences = dict.fromkeys((*self.assumptions, *part_notes(self.design)))
        object.__setattr__(self, "assumptions", tuple(sentences))
        if self.design.thermal.words:
            object.__setattr__(self, "condition", f"{self.condition}, {self.design.thermal.words}")

    def __getitem__(self, key: str) -> float:
        """Return the value of a quantity."""
        return self.quantities[key].value

    @property
    def frame(self) -> Frame:
        """A row for each quantity."""
        return quantity_frame(self.quantities)

    @property
    def line(self) -> str:
        """Measure, design, condition, and the first quantities."""
        first_values = ", ".join(_short(key, quantity) for key, quantity in islice(self.quantities.items(), 3))
        return f"{self.measure} of {self.design.name}{f', {self.condition}' if self.condition else ''}; {first_values}"

    def as_json(self) -> dict[str, Any]:
        """Convert the measurement to JSON values.

        ``quantities`` are by their keys, ``figures`` the same by the keys of the catalogue (`cycloid-mj figures`), each
        with value and unit. ``condition`` is load and speed in words. The `details` are included under their own keys.
        """
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


def _short(key: str, quantity: Quantity) -> str:
    return f"{key} {quantity.value:.4g} {quantity.unit if quantity.unit != '1' else ''}".strip()
