"""Limits on figures in the words of a user: ``backlash_arcmin<=1``."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import UsageError
from cycloid_mj.figures import COMPUTED, figure
from cycloid_mj.reducer import Reducer

MIN_BOUND = 1e-12
"""Smallest size of a bound that a relative excess, or a relative distance to the bound, refers to."""


@dataclass(frozen=True)
class FigureLimit:
    """An upper or lower `bound` of the figure `key`, in the figure's unit."""

    key: str
    at_most: bool
    bound: float

    def holds(self, values: Array) -> Mask:
        """Return which values, shape (s,), satisfy the limit; NaN does not."""
        return np.asarray(values <= self.bound if self.at_most else values >= self.bound)

    def excess(self, value: float) -> float:
        """Compute by how much a value violates the limit, relative to the bound: 0 if it does not, 1 for NaN."""
        if np.isnan(value):
            return 1.0
        violation = value - self.bound if self.at_most else self.bound - value
        return max(violation, 0.0) / max(abs(self.bound), MIN_BOUND)

    def __str__(self) -> str:
        """Write the limit as the user does."""
        return f"{self.key}{'<=' if self.at_most else '>='}{self.bound:g}"


def parse_limit(text: str, reducer: Reducer | None = None) -> FigureLimit:
    """Parse the text of a limit on a catalogued quantity, such as ``backlash_arcmin<=1``.

    Parameters
    ----------
    text
        ``KEY<=NUMBER`` or ``KEY>=NUMBER``.
    reducer
        Reducer for which the quantity must be defined; None accepts the quantities of any reducer.

    Raises
    ------
    UsageError
        The text does not have this form, or there is no such quantity.
    """
    match = re.fullmatch(r"\s*(\w+)\s*(<=|>=)\s*(\S+)\s*", text)
    try:
        bound = float(match[3]) if match else np.nan
    except ValueError:
        bound = np.nan
    if not match or not np.isfinite(bound):
        raise UsageError(
            f"--limit {text!r} is not a limit: give KEY<=NUMBER or KEY>=NUMBER with a finite number, e.g. --limit "
            "'backlash_arcmin<=1'"
        )
    try:
        figure(match[1], COMPUTED, reducer)
    except UsageError as error:
        raise UsageError(f"--limit {text!r}: {error}") from error
    return FigureLimit(match[1], match[2] == "<=", bound)


def require_consistent(limits: Iterable[FigureLimit]) -> None:
    """Raise UsageError if the limits on a quantity contradict each other."""
    lower_limits: dict[str, FigureLimit] = {}
    upper_limits: dict[str, FigureLimit] = {}
    for limit in limits:
        limits_of_side = upper_limits if limit.at_most else lower_limits
        strictest_limit = limits_of_side.get(limit.key)
        if strictest_limit is None or (limit.bound < strictest_limit.bound) == limit.at_most:
            limits_of_side[limit.key] = limit
    for key in lower_limits.keys() & upper_limits.keys():
        if lower_limits[key].bound > upper_limits[key].bound:
            raise UsageError(
                f"--limit '{lower_limits[key]}' contradicts --limit '{upper_limits[key]}', because no value of {key} "
                "satisfies both: change or remove one of them"
            )
