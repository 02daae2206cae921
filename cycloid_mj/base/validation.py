"""One line of the validation table: a quantity, its reference, and whether they agree."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Quantity


class RowOutcome(StrEnum):
    """What becomes of a row; its value is the word for people and programs."""

    PASS = "pass"
    FAIL = "fail"
    STATED = "told"
    """The row has no bound: it states a difference."""


@dataclass(frozen=True)
class ValidationRow:
    """A quantity held against a reference.

    Attributes
    ----------
    measured
        The quantity, named with its design, and its reference; its note explains a difference, where it needs that.
    difference
        Of the two, in `difference_unit`.
    difference_unit
        Of `difference` and `bound`: "%", "points" of a percentage, or the quantity's unit.
    bound
        Largest difference that passes, about three times the largest that was seen; None where the row only states it.
    rung
        Name of the rung of the ladder.
    """

    measured: Quantity
    difference: float
    difference_unit: str
    bound: float | None
    rung: str = ""

    @property
    def verdict(self) -> RowOutcome:
        """Whether the row passes; a difference that is not a number fails."""
        if self.bound is None:
            return RowOutcome.STATED
        return RowOutcome.PASS if self.difference <= self.bound else RowOutcome.FAIL

    def as_json(self) -> dict[str, Any]:
        """Convert the row to a flat dict with its verdict."""
        return {
            "quantity": self.measured.name,
            "ours": self.measured.value,
            "reference": self.measured.reference,
            "unit": self.measured.unit,
            "source": self.measured.source,
            "error": self.difference,
            "error_unit": self.difference_unit,
            "bound": self.bound,
            "note": self.measured.note,
            "rung": self.rung,
            "verdict": self.verdict,
        }


def relative(
    quantity: str, ours: float, reference: float, unit: str, source: str, bound: float | None, note: str = ""
) -> ValidationRow:
    """Judge by |ours/reference - 1| in percent; `bound` in percent too."""
    error = 100.0 * abs(ours / reference - 1.0) if reference else float("nan")
    return ValidationRow(_compared(quantity, ours, reference, unit, source, note), float(error), "%", bound)


def absolute(
    quantity: str, ours: float, reference: float, unit: str, source: str, bound: float | None, note: str = ""
) -> ValidationRow:
    """Judge by |ours - reference| in `unit`; the difference of two percentages is in points."""
    measured = _compared(quantity, ours, reference, unit, source, note)
    return ValidationRow(measured, float(abs(ours - reference)), "points" if unit == "%" else unit, bound)


def deviation(
    quantity: str, ours: Array, reference: Array, unit: str, source: str, bound: float | None, note: str = ""
) -> ValidationRow:
    """Judge many values, shape (n,), or vectors, shape (..., 2).

    It shows the largest size of each side and is judged by the largest difference of any two, in percent of the
    largest reference.
    """
    size, largest, error = (float(_sizes(values).max()) for values in (ours, reference, ours - reference))
    return ValidationRow(_compared(quantity, size, largest, unit, source, note), 100.0 * error / largest, "%", bound)


def broken(why: str) -> ValidationRow:
    """Fail the row of a part that could not be run."""
    nan = float("nan")
    return ValidationRow(_compared("could not be run", nan, nan, "", "", why), nan, "", 0.0)


def _compared(name: str, ours: float, reference: float, unit: str, source: str, note: str) -> Quantity:
    return Quantity("", name, float(ours), unit, None, float(reference), source, note)


def _sizes(values: Array) -> Array:
    return np.abs(values) if values.ndim == 1 else np.linalg.norm(values, axis=-1)
