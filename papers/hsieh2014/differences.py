"""Derivatives by finite differences of fourth order: an error of h^4 in the step, and rounding of eps/h or eps/h^2."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from cycloid_mj.types import Array


def first(function: Callable[[Array], Array], at: npt.ArrayLike, step: float) -> Array:
    """Differentiate a function once, at points of shape (n,)."""
    x = np.asarray(at, float)
    one, two = (function(x + k * step) - function(x - k * step) for k in (1, 2))
    return (8 * one - two) / (12 * step)


def second(function: Callable[[Array], Array], at: npt.ArrayLike, step: float) -> Array:
    """Differentiate a function twice, at points of shape (n,)."""
    x = np.asarray(at, float)
    one, two = (function(x + k * step) + function(x - k * step) for k in (1, 2))
    return (16 * one - two - 30 * function(x)) / (12 * step**2)
