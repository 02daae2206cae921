"""What every measure, check, comparison and claim is made of: quantities, curves, tables."""

from dataclasses import dataclass
from typing import Any

from cycloid_mj.types import Array


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
