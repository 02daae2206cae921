"""Error of a mean and of extremes over the turn that are measured at a few crank angles: part of the numerical error.

A closed form near the measured values contributes its part exactly; only the remainder is estimated by its scatter.
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
class Known:
    """A closed form at the measured crank angles, shape (k,), and over the full turn, shape (n,)."""

    sampled: Array
    turn: Array


def error_of_mean(values: npt.ArrayLike, known: Known | None = None) -> float | None:
    """Estimate the error of the mean over the turn by values at some crank angles, shape (k,).

    For the remainder of the closed form it is the standard error of the mean, by Student's t.

    Returns
    -------
    float or None
        In the unit of the values; None for a single value without a closed form.
    """
    explained, rest = _split(np.asarray(values, float), known)
    if rest.size == 1:
        return None if known is None else abs(explained(np.mean))
    spread = float(rest.std(ddof=1)) / np.sqrt(rest.size)
    # the coverage of one standard deviation
    return abs(explained(np.mean)) + student_half_width(rest.size - 1, 0.683) * spread


def error_of_extreme(values: npt.ArrayLike, largest: bool, known: Known | None = None) -> float | None:
    """Estimate the error of the largest (or smallest) value over the turn by values at crank angles, shape (k,).

    For the remainder of the closed form it is its range over the number of values: the peak of a sine that is sampled k
    times in its period exceeds the samples by less.
    """
    explained, rest = _split(np.asarray(values, float), known)
    if rest.size == 1:
        return None if known is None else abs(explained(np.max if largest else np.min))
    return abs(explained(np.max if largest else np.min)) + float(np.ptp(rest)) / rest.size


def add_errors(*errors: float | None) -> float | None:
    """Add parts of an error; None where one of them is None."""
    known = [error for error in errors if error is not None]
    return sum(known) if len(known) == len(errors) else None


def _split(values: Array, known: Known | None) -> tuple[Callable[[Callable[[Array], Any]], float], Array]:
    """Return the error of a statistic by the closed form, as a function of it, and the remainder of the values."""
    if known is None:
        return lambda statistic: 0.0, values
    return lambda statistic: float(statistic(known.turn) - statistic(known.sampled)), values - known.sampled


def extreme_quantities(
    key: str,
    name: str,
    values: npt.ArrayLike,
    numerical: float,
    unit: str,
    *,
    scale: float = 1.0,
    known: Known | None = None,
    reference: Known | None = None,
    source: str = "",
) -> Iterator[Quantity]:
    """Yield the smallest and the largest of values over the crank angle as quantities ``key_min`` and ``key_max``.

    Parameters
    ----------
    key, name, unit, source
        As of `Quantity`.
    values
        Values at some crank angles, shape (k,).
    numerical
        Numerical error of a value.
    scale
        Size of the unit: values, errors and closed forms are divided by it.
    known
        Closed form near the values, for the error; see `error_of_extreme`.
    reference
        Closed form that is the reference of both.
    """
    values = np.asarray(values, float)
    for end, word, largest in (("min", "least", False), ("max", "largest", True)):
        statistic = np.max if largest else np.min
        error = add_errors(numerical, error_of_extreme(values, largest, known))
        yield Quantity(
            f"{key}_{end}",
            f"{name}, {word} over the crank angle",
            float(statistic(values)) / scale,
            unit,
            None if error is None else error / scale,
            None if reference is None else float(statistic(reference.turn)) / scale,
            source,
        )
