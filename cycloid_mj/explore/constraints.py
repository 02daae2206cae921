"""Limits on figures, as a user writes them: ``backlash_arcmin<=1``."""

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import UsageError
from cycloid_mj.figures import COMPUTED, Need, figure
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class FigureLimit:
    """A figure's `key` that is to be at most, or at least, a `bound` in the key's unit."""

    key: str
    at_most: bool
    bound: float

    def holds(self, values: Array) -> Mask:
        """Tell where values, shape (s,), keep it; what is no number does not."""
        return np.asarray(values <= self.bound if self.at_most else values >= self.bound)

    def excess(self, value: float) -> float:
        """Find by how much a value breaks it, relative to the bound; 0 where it keeps it, 1 for what is no number."""
        if np.isnan(value):
            return 1.0
        beyond = value - self.bound if self.at_most else self.bound - value
        return max(beyond, 0.0) / max(abs(self.bound), 1e-12)

    def __str__(self) -> str:
        """Tell it as it was written."""
        return f"{self.key}{'<=' if self.at_most else '>='}{self.bound:g}"


def limit(text: str, reducer: Reducer | None = None, needs: Collection[Need] = COMPUTED) -> FigureLimit:
    """Read a limit on a figure that a reducer has, and that can be computed from some needs.

    Raises
    ------
    UsageError
        It has not that form, or there is no such figure.
    """
    match = re.fullmatch(r"\s*(\w+)\s*(<=|>=)\s*(\S+)\s*", text)
    try:
        bound = float(match[3]) if match else np.nan
    except ValueError:
        bound = np.nan
    if not match or not np.isfinite(bound):
        raise UsageError(f"--limit {text!r}: expected KEY<=NUMBER or KEY>=NUMBER, e.g. 'backlash_arcmin<=1'")
    try:
        figure(match[1], needs, reducer)
    except UsageError as error:
        raise UsageError(f"--limit {text!r}: {error}") from error
    return FigureLimit(match[1], match[2] == "<=", bound)


def require_consistent(limits: Iterable[FigureLimit]) -> None:
    """Require that some value of each figure satisfies all its limits.

    Raises
    ------
    UsageError
        Two limits contradict each other.
    """
    lowest: dict[str, FigureLimit] = {}
    highest: dict[str, FigureLimit] = {}
    for each in limits:
        kept = highest if each.at_most else lowest
        other = kept.get(each.key)
        if other is None or (each.bound < other.bound) == each.at_most:
            kept[each.key] = each
    for key in lowest.keys() & highest.keys():
        if lowest[key].bound > highest[key].bound:
            raise UsageError(
                f"--limit '{lowest[key]}' contradicts --limit '{highest[key]}': no value of {key} satisfies both; "
                "change or leave out one of them"
            )
