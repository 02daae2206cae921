"""What some crank angles leave out of a mean, and of the extremes, over the turn: a part of the numerical error.

Where a closed form is near the measured values, it tells its own part exactly, and only what it does not explain is
judged by its scatter.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array

TWO_SIDED = 0.683
"""Confidence of an error: that of one standard deviation."""


@dataclass(frozen=True, eq=False)
class Known:
    """A closed form at the crank angles that were measured, shape (k,), and all over the turn, shape (n,)."""

    sampled: Array
    turn: Array


def error_of_mean(values: npt.ArrayLike, known: Known | None = None) -> float | None:
    """Compute by how much the mean of values at some crank angles, shape (k,), may miss that over the turn.

    Of what the closed form does not explain: the standard error of the mean, by Student's t for so few values.

    Returns
    -------
    float or None
        In the unit of the values; None where it is not known: one value, and no closed form.
    """
    from scipy.special import stdtrit

    explained, rest = _parted(np.asarray(values, float), known)
    if rest.size == 1:
        return None if known is None else abs(explained(np.mean))
    spread = float(rest.std(ddof=1)) / np.sqrt(rest.size)
    return abs(explained(np.mean)) + float(stdtrit(rest.size - 1, 0.5 + 0.5 * TWO_SIDED)) * spread


def error_of_extreme(values: npt.ArrayLike, largest: bool, known: Known | None = None) -> float | None:
    """Compute by how much the largest (or least) of some values, shape (k,), may miss that over the turn.

    Of what the closed form does not explain: its range over the number of values. A sine that is sampled k times in its
    period rises above the samples by less.
    """
    explained, rest = _parted(np.asarray(values, float), known)
    if rest.size == 1:
        return None if known is None else abs(explained(np.max if largest else np.min))
    return abs(explained(np.max if largest else np.min)) + float(np.ptp(rest)) / rest.size


def added(*errors: float | None) -> float | None:
    """Add parts of an error; None where one of them is not known."""
    known = [error for error in errors if error is not None]
    return sum(known) if len(known) == len(errors) else None


def _parted(values: Array, known: Known | None) -> tuple[Callable[[Callable[[Array], Any]], float], Array]:
    """Get what a closed form says that the samples miss of a statistic, and what it does not explain of the values."""
    if known is None:
        return lambda statistic: 0.0, values
    return lambda statistic: float(statistic(known.turn) - statistic(known.sampled)), values - known.sampled
