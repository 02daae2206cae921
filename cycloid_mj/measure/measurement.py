"""The result of a measure: quantities with their numerical errors and closed forms, curves, assumptions, and runs."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.design import Design
from cycloid_mj.record import Run

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Quantity:
    """One measured number.

    Attributes
    ----------
    name
        What it is, in words.
    value, unit
        What was measured.
    error
        Its numerical error, in the same unit: what half the step, or a shorter average, changes. None where a closed
        form gives the value itself.
    reference
        The closed form, in the same unit; None where there is none.
    source
        Where the reference comes from.
    note
        What decides a difference, or what the value stands on.
    """

    name: str
    value: float
    unit: str
    error: float | None = None
    reference: float | None = None
    source: str = ""
    note: str = ""

    def as_json(self) -> dict[str, Any]:
        """Give the quantity for a program."""
        return {
            "name": self.name,
            "value": self.value,
            "unit": self.unit,
            "numerical_error": self.error,
            "reference": self.reference,
            "source": self.source,
            "note": self.note,
        }


@dataclass(frozen=True, eq=False)
class Curve:
    """One curve of a figure.

    Attributes
    ----------
    panel
        Title of the panel that it is drawn in.
    name
        What tells it from the panel's other curves.
    x, y
        Points, shape (n,) each.
    x_label, y_label
        What the axes show, with units: ``crank angle [deg]``.
    style
        ``line``, ``theory`` (broad and light), ``points``, ``rings`` (theory at single points), ``bars`` (a spectrum)
        or ``polar`` (x in degrees, clockwise from +y).
    of
        Of a theory: name of the one of the panel's curves that it belongs to, drawn in its colour.
    """

    panel: str
    name: str
    x: Array
    y: Array
    x_label: str
    y_label: str
    style: str = "line"
    of: str = ""

    def as_json(self) -> dict[str, Any]:
        """Give the curve for a program."""
        x, y = self.x.tolist(), self.y.tolist()
        return {
            "panel": self.panel,
            "name": self.name,
            "x_label": self.x_label,
            "y_label": self.y_label,
            "x": x,
            "y": y,
        }


@dataclass(frozen=True)
class Table:
    """Numbers that belong together: a map, or a sensitivity.

    Attributes
    ----------
    title
        What it shows.
    header
        Names of the columns, with units; the first column names the row.
    rows
        Texts and numbers, as many as there are columns.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str | float, ...], ...]

    def as_json(self) -> dict[str, Any]:
        """Give the table for a program."""
        return {"title": self.title, "columns": list(self.header), "rows": [list(row) for row in self.rows]}


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
        What the numbers stand on, a sentence each.
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

    def __getitem__(self, key: str) -> float:
        """Give the value of a quantity."""
        return self.quantities[key].value

    def as_json(self) -> dict[str, Any]:
        """Give the measurement for a program."""
        return {
            "measure": self.measure,
            "design": self.design.name,
            "condition": self.condition,
            "quantities": {key: quantity.as_json() for key, quantity in self.quantities.items()},
            "assumptions": list(self.assumptions),
            **self.details,
            "tables": [table.as_json() for table in self.tables],
            "curves": [curve.as_json() for curve in self.curves],
        }
