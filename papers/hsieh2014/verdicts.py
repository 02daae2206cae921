"""How a claim of the paper is judged: by comparing numbers, never by reading a sentence."""

import math
from collections.abc import Iterable, Mapping
from statistics import NormalDist, median

from cycloid_mj.base.result import Value, Verdict
from cycloid_mj.comparison import Spread
from cycloid_mj.comparison.starts import ALIKE

SIGNIFICANCE = 0.05
"""Chance of starts as different as those of two designs that do not differ, below which an order counts."""

SUPERIORITY, POWER = 0.9, 0.9
"""A difference that an order must not miss, and how surely: in 9 of 10 pairs of starts one design has more."""


def starts_needed(superiority: float = SUPERIORITY, power: float = POWER, significance: float = SIGNIFICANCE) -> int:
    """Compute how many starts of each design the rank test needs (Noether, J. Am. Stat. Assoc. 82, 1987, 645-647).

    Parameters
    ----------
    superiority
        Chance that a start of the one design has more than one of the other [1]; 1/2 where they are alike.
    power
        Chance that the test finds that difference.
    significance
        Of the test, two-sided.
    """
    normal = NormalDist()
    reach = normal.inv_cdf(1.0 - significance / 2.0) + normal.inv_cdf(power)
    return math.ceil(reach**2 / (6.0 * (superiority - 0.5) ** 2))


def chance(one: Spread, other: Spread) -> float:
    """Compute p of the rank test (Mann and Whitney, two-sided): of starts as different as these if both were alike."""
    from scipy.stats import mannwhitneyu

    return float(mannwhitneyu(one.values, other.values).pvalue)


def rank_order(one: Spread, other: Spread) -> int:
    """Tell which of two quantities is larger by the rank test: 1 the first, -1 the second, 0 neither for sure.

    Medians a hair apart, by what the step alone may change, are alike whatever the test says.
    """
    middles = median(one.values), median(other.values)
    if chance(one, other) >= SIGNIFICANCE or max(middles) <= ALIKE * min(middles):
        return 0
    return 1 if middles[0] > middles[1] else -1


def order_verdict(found: int, varied: Mapping[str, int]) -> tuple[Verdict, tuple[str, ...]]:
    """Judge a claim that the first of two quantities is the larger.

    Parameters
    ----------
    found
        As `rank_order` gives it.
    varied
        The same with something changed that the paper leaves open, by its name.

    Returns
    -------
    verdict
        It depends where a change turns the order round, and is not determined where the other order is found and a
        change leaves none.
    turned
        The names of what turns it round.
    """
    if found == 0:
        return Verdict.NOT_DETERMINED, ()
    turned = tuple(name for name, each in varied.items() if each == -found)
    if turned:
        return Verdict.DEPENDS, turned
    if found < 0 and 0 in varied.values():
        return Verdict.NOT_DETERMINED, ()
    return (Verdict.AGREES if found > 0 else Verdict.DISAGREES), ()


def share_verdict(holds: Iterable[bool]) -> Verdict:
    """Judge something that each start shows or does not: it is determined where all of them do, or none."""
    seen = list(holds)
    if all(seen):
        return Verdict.AGREES
    return Verdict.NOT_DETERMINED if any(seen) else Verdict.DISAGREES


def range_verdict(ours: Spread, low: float, high: float) -> Verdict:
    """Judge whether a quantity lies in a range: all of its starts, none of them, or some."""
    return share_verdict(low <= value <= high for value in ours.values)


def joint_verdict(verdicts: Iterable[Verdict]) -> Verdict:
    """Judge a claim of several parts: it fails with any of them, and agrees with all."""
    parts = set(verdicts)
    if Verdict.DISAGREES in parts:
        return Verdict.DISAGREES
    return Verdict.AGREES if parts == {Verdict.AGREES} else Verdict.NOT_DETERMINED


def spread_value(text: str, ours: Spread, unit: str) -> Value:
    """Give the mean of starts as a value, with the lowest and the highest."""
    return Value(text, ours.mean, unit, (ours.low, ours.high))


def spread_error(ours: Spread, unit: str) -> Value:
    """Give half the spread of starts as the numerical error of their mean."""
    return Value(f"spread of {len(ours.values)} starts", ours.half, unit)
