"""Checks of arguments of public functions: words of a list, and numbers within limits."""

import math
from collections.abc import Iterable
from numbers import Integral, Real

from cycloid_mj.base.errors import UsageError


def require_choice(name: str, value: object, choices: Iterable[str]) -> None:
    """Raise UsageError if the argument `name` is not one of several words."""
    words = tuple(choices)
    if not isinstance(value, str) or value not in words:
        raise UsageError(f"{name} = {value!r} is not allowed: choose one of {', '.join(map(repr, words))}")


def require_number(name: str, value: object, unit: str, above: float = -math.inf) -> None:
    """Raise UsageError if the argument `name` [unit] is not a finite number, or not greater than `above`."""
    if not isinstance(value, bool) and isinstance(value, Real) and above < float(value) < math.inf:
        return
    limit_text = f" greater than {above:g}" if above > -math.inf else ""
    raise UsageError(f"{name} = {value!r} is not allowed: choose a finite number{limit_text} [{unit}]")


def require_count(name: str, value: object, low: int, high: float = math.inf) -> None:
    """Raise UsageError if the argument `name` is not a whole number from `low` to `high`."""
    if not isinstance(value, bool) and isinstance(value, Integral) and low <= int(value) <= high:
        return
    range_text = f"of at least {low}" if high == math.inf else f"from {low} to {high:g}"
    raise UsageError(f"{name} = {value!r} is not allowed: choose a whole number {range_text}")
