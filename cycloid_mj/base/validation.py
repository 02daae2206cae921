"""Rows of the validation table (a quantity, its reference, whether they agree) and the parts that compute them."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Quantity


class RowOutcome(StrEnum):
    """Verdict on a row; the value is the word for people and programs."""

    PASS = "pass"
    FAIL = "fail"
    STATED = "stated"
    """The row has no bound; it states a difference."""


@dataclass(frozen=True)
class ValidationRow:
    """A quantity compared with a reference.

    Attributes
    ----------
    measured
        The quantity, named with its design, and its reference; a note explains a difference if necessary.
    difference
        Difference of the two, in `difference_unit`.
    difference_unit
        Unit of `difference` and `bound`: "%", "points" of a percentage, or the unit of the quantity.
    bound
        Largest difference that passes, about three times the largest seen; None if the row only states a difference.
    rung
        Name of the validation step.
    """

    measured: Quantity
    difference: float
    difference_unit: str
    bound: float | None
    rung: str = ""

    @property
    def verdict(self) -> RowOutcome:
        """The verdict on the row; a difference that is not a number fails."""
        if self.bound is None:
            return RowOutcome.STATED
        return RowOutcome.PASS if self.difference <= self.bound else RowOutcome.FAIL

    def as_json(self) -> dict[str, Any]:
        """Convert a row of the validation (a value compared with its reference) to a flat dict of JSON values.

        ``ours`` and ``reference`` are in ``unit``, ``error`` and ``bound`` in ``error_unit``. ``rung`` is the name of
        the validation step.
        """
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


@dataclass(frozen=True)
class ValidationPart:
    """A part of a validation step that runs on its own.

    Attributes
    ----------
    rung
        Name of the step.
    rows
        Function that returns the rows; its argument is whether to be quick.
    cost
        CPU time [s], quick and in full, on one core of 2026: the longest parts start first.
    """

    rung: str
    rows: Callable[[bool], list[ValidationRow]]
    cost: tuple[float, float]


def relative(
    quantity: str, result: float, reference: float, unit: str, source: str, bound: float | None, note: str = ""
) -> ValidationRow:
    """Return a row judged by |result/reference - 1|, with `bound` in percent; it fails if the reference is 0."""
    error = 100.0 * abs(result / reference - 1.0) if reference else float("nan")
    return ValidationRow(_as_quantity(quantity, result, reference, unit, source, note), float(error), "%", bound)


def absolute(
    quantity: str, result: float, reference: float, unit: str, source: str, bound: float | None, note: str = ""
) -> ValidationRow:
    """Return a row judged by |result - reference| in `unit`; the difference of two percentages is in points."""
    compared_quantity = _as_quantity(quantity, result, reference, unit, source, note)
    return ValidationRow(compared_quantity, float(abs(result - reference)), "points" if unit == "%" else unit, bound)


def deviation_row(
    quantity: str, result: Array, reference: Array, unit: str, source: str, bound: float | None, note: str = ""
) -> ValidationRow:
    """Return a validation row that compares n values with their references, (n,), or (..., 2) for vectors.

    The row shows the largest magnitude of the values and of the references. It is judged by the largest difference, in
    percent of the largest reference.

    Parameters
    ----------
    quantity, unit
        Name and unit of the values.
    result, reference
        Values, and their references.
    source, note
        Source of the reference, and a remark.
    bound
        Allowed difference [%]; None: not judged.
    """
    largest_value, largest_reference, largest_error = (
        float(_sizes(values).max()) for values in (result, reference, result - reference)
    )
    return ValidationRow(
        _as_quantity(quantity, largest_value, largest_reference, unit, source, note),
        100.0 * largest_error / largest_reference,
        "%",
        bound,
    )


def failed_part(reason: str) -> ValidationRow:
    """Return the failing row of a part that could not be run."""
    nan = float("nan")
    return ValidationRow(_as_quantity("could not be run", nan, nan, "", "", reason), nan, "", 0.0)


def _as_quantity(name: str, result: float, reference: float, unit: str, source: str, note: str) -> Quantity:
    return Quantity("", name, float(result), unit, None, float(reference), source, note)


def _sizes(values: Array) -> Array:
    return np.abs(values) if values.ndim == 1 else np.linalg.norm(values, axis=-1)
