"""One line of the validation table: a quantity, its reference, and whether they agree."""

import dataclasses
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from cycloid_mj.types import Array

Verdict = Literal["pass", "fail", "told"]


@dataclass(frozen=True)
class Row:
    """A quantity held against a reference.

    Attributes
    ----------
    quantity
        What it is, and of which design.
    ours, reference
        The two values, in `unit`.
    unit
        "" for a plain number.
    source
        Where the reference comes from.
    error
        The difference, in `error_unit`.
    error_unit
        Unit of `error` and `bound`: "%", "points" of a percentage, or `unit`.
    bound
        Largest error that passes, about three times the largest that was seen; None where the row only tells.
    note
        What explains the error, where it needs that.
    rung
        Name of the rung of the ladder.
    """

    quantity: str
    ours: float
    reference: float
    unit: str
    source: str
    error: float
    error_unit: str
    bound: float | None
    note: str = ""
    rung: str = ""

    @property
    def verdict(self) -> Verdict:
        """Whether the row passes; an error that is not a number fails."""
        if self.bound is None:
            return "told"
        return "pass" if self.error <= self.bound else "fail"

    def as_json(self) -> dict[str, Any]:
        """Give the row as a flat dict with its verdict."""
        return {**dataclasses.asdict(self), "verdict": self.verdict}


def relative(
    quantity: str, ours: float, reference: float, unit: str, source: str, bound: float | None, note: str = ""
) -> Row:
    """Give a row judged by |ours/reference - 1| in percent; `bound` in percent too."""
    error = 100.0 * abs(ours / reference - 1.0) if reference else float("nan")
    return Row(quantity, float(ours), float(reference), unit, source, float(error), "%", bound, note)


def absolute(
    quantity: str, ours: float, reference: float, unit: str, source: str, bound: float | None, note: str = ""
) -> Row:
    """Give a row judged by |ours - reference| in `unit`; the difference of two percentages is in points."""
    error_unit = "points" if unit == "%" else unit
    return Row(
        quantity, float(ours), float(reference), unit, source, float(abs(ours - reference)), error_unit, bound, note
    )


def deviation(
    quantity: str, ours: Array, reference: Array, unit: str, source: str, bound: float | None, note: str = ""
) -> Row:
    """Give a row of many values, shape (n,), or vectors, shape (..., 2).

    It shows the largest size of each side and is judged by the largest difference of any two, in percent of the
    largest reference.
    """
    size, largest, error = (float(_sizes(values).max()) for values in (ours, reference, ours - reference))
    return Row(quantity, size, largest, unit, source, 100.0 * error / largest, "%", bound, note)


def _sizes(values: Array) -> Array:
    return np.abs(values) if values.ndim == 1 else np.linalg.norm(values, axis=-1)
