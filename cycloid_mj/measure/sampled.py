"""Error of a mean and of extremes over the turn that are measured at a few crank angles: part of the numerical error.

The sampling error of a closed form that approximates the measured values is known exactly. Only the error of the
remainder, values minus closed form, is estimated from its scatter.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Quantity
from cycloid_mj.base.statistics import student_half_width


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """A closed form at the measured crank angles, shape (k,), and over the full turn, shape (n,), with its source."""

    sampled: Array
    turn: Array
    source: str = ""


def error_of_mean(values: npt.ArrayLike, closed_form: ClosedForm | None = None) -> float | None:
    """Estimate the sampling error of the mean over the turn of a quantity that is known at k angles.

    It has the unit of the quantity and is the sum of two parts. The sampling error of the closed form is computed
    exactly, because the closed form is known over the full turn. For the remainder (values minus closed form), it is
    the standard error of the mean by Student's t.

    Parameters
    ----------
    values
        Values at a few crank angles, shape (k,).
    closed_form
        Closed form that approximates the values; None without it.

    Returns
    -------
    float or None
        None for a single value without a closed form.
    """
    explained_error, remainder = _split_closed_form(np.asarray(values, float), closed_form)
    if remainder.size == 1:
        return None if closed_form is None else abs(explained_error(np.mean))
    standard_error = float(remainder.std(ddof=1)) / np.sqrt(remainder.size)
    # the coverage of one standard deviation
    return abs(explained_error(np.mean)) + student_half_width(remainder.size - 1, 0.683) * standard_error


def error_of_extreme(values: npt.ArrayLike, largest: bool, closed_form: ClosedForm | None = None) -> float | None:
    """Estimate the sampling error of the largest (or smallest) value of a quantity over the turn, known at k angles.

    It has the unit of the quantity and is the sum of two parts. The sampling error of the closed form is computed
    exactly, because the closed form is known over the full turn. For the remainder (values minus closed form), it is
    the range of the remainder divided by the number of values, an upper bound for a sine that is sampled k times per
    period.

    Parameters
    ----------
    values
        Values at a few crank angles, shape (k,).
    largest
        True for the error of the largest value, False for the error of the smallest.
    closed_form
        Closed form that approximates the values; None without it.

    Returns
    -------
    float or None
        None for a single value without a closed form.
    """
    explained_error, remainder = _split_closed_form(np.asarray(values, float), closed_form)
    if remainder.size == 1:
        return None if closed_form is None else abs(explained_error(np.max if largest else np.min))
    return abs(explained_error(np.max if largest else np.min)) + float(np.ptp(remainder)) / remainder.size


def add_errors(*errors: float | None) -> float | None:
    """Add parts of an error; None where one of them is None."""
    known_errors = [error for error in errors if error is not None]
    return sum(known_errors) if len(known_errors) == len(errors) else None


def _split_closed_form(
    values: Array, closed_form: ClosedForm | None
) -> tuple[Callable[[Callable[[Array], Any]], float], Array]:
    """Separate `values` at k crank angles, shape (k,), into a closed form that approximates them and a remainder.

    Returns
    -------
    tuple
        A function that maps a statistic, such as ``np.mean``, to its sampling error for the closed form: the statistic
        over the full turn minus that over the sampled angles, or 0 without a closed form. Then the remainder, values
        minus closed form, shape (k,).
    """
    if closed_form is None:
        return lambda statistic: 0.0, values
    return lambda statistic: float(
        statistic(closed_form.turn) - statistic(closed_form.sampled)
    ), values - closed_form.sampled


def extreme_quantities(
    key: str,
    name: str,
    values: npt.ArrayLike,
    numerical: float,
    unit: str,
    *,
    scale: float = 1.0,
    closed_form: ClosedForm | None = None,
    reference: ClosedForm | None = None,
    source: str = "",
) -> Iterator[Quantity]:
    """Yield the smallest and the largest value over the crank angle as quantities ``key_min`` and ``key_max``.

    Parameters
    ----------
    key, name, unit, source
        Attributes of both quantities; `key` and `name` are completed by an ending for smallest and largest, and
        `source` is that of the reference.
    values
        Values at some crank angles, shape (k,).
    numerical
        Numerical error of a value, in the unit of the values.
    scale
        Size of `unit` in the unit of the values, by which values, errors and closed forms are divided.
    closed_form
        Closed form that approximates the values, for the sampling error; see `error_of_extreme`.
    reference
        Closed form whose smallest and largest value are the references.
    """
    values = np.asarray(values, float)
    for suffix, adjective, is_largest in (("min", "least", False), ("max", "largest", True)):
        statistic = np.max if is_largest else np.min
        error = add_errors(numerical, error_of_extreme(values, is_largest, closed_form))
        yield Quantity(
            f"{key}_{suffix}",
            f"{name}, {adjective} over the crank angle",
            float(statistic(values)) / scale,
            unit,
            None if error is None else error / scale,
            None if reference is None else float(statistic(reference.turn)) / scale,
            source,
        )
