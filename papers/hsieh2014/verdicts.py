"""Verdicts on claims of the paper, by comparisons of numbers."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from statistics import NormalDist, median

from cycloid_mj.base.result import Claim, Value, Verdict
from cycloid_mj.comparison import StartSpread
from cycloid_mj.comparison.starts import ORDER_MARGIN

SIGNIFICANCE = 0.05
"""Significance level of the rank test of starts."""

SUPERIORITY, POWER = 0.9, 0.9
"""Difference that the rank test must detect (9 of 10 pairs of starts), and the power required for it."""


def starts_needed(superiority: float = SUPERIORITY, power: float = POWER, significance: float = SIGNIFICANCE) -> int:
    """Compute how many starts of each design the rank test needs (Noether, J. Am. Stat. Assoc. 82, 1987, 645-647).

    Parameters
    ----------
    superiority
        Probability that a start of one design exceeds a start of the other [1]; 1/2 for equal designs.
    power
        Probability that the test detects that difference.
    significance
        Level of the two-sided test.
    """
    normal = NormalDist()
    reach = normal.inv_cdf(1.0 - significance / 2.0) + normal.inv_cdf(power)
    return math.ceil(reach**2 / (6.0 * (superiority - 0.5) ** 2))


def chance(start_spread: StartSpread, other: StartSpread) -> float:
    """Compute the p value of the two-sided rank test of Mann and Whitney."""
    from scipy.stats import mannwhitneyu

    return float(mannwhitneyu(start_spread.values, other.values).pvalue)


def rank_order(start_spread: StartSpread, other: StartSpread) -> int:
    """Return which of two quantities is larger by the rank test: 1 the first, -1 the second, 0 not significant.

    Medians that differ by less than the effect of the time step count as equal.
    """
    middles = median(start_spread.values), median(other.values)
    if chance(start_spread, other) >= SIGNIFICANCE or max(middles) <= ORDER_MARGIN * min(middles):
        return 0
    return 1 if middles[0] > middles[1] else -1


def order_verdict(order: int, varied: Mapping[str, int]) -> tuple[Verdict, tuple[str, ...]]:
    """Judge a claim that the first of two quantities is the larger; name the changes that reverse or remove the order.

    `order` is by `rank_order`, `varied` the same for each change of what the paper leaves open, by its name. The claim
    depends if a change reverses the order. It is not determined if the result is the opposite order and a change leaves
    no order. A claim that agrees still does if a change leads to no clear ranking.
    """
    if order == 0:
        return Verdict.NOT_DETERMINED, ()
    turned, none = (tuple(name for name, each in varied.items() if each == wanted) for wanted in (-order, 0))
    if turned:
        return Verdict.DEPENDS, turned
    if order > 0:
        return Verdict.AGREES, none
    return (Verdict.NOT_DETERMINED if none else Verdict.DISAGREES), none


def order_cause(verdict: Verdict, deciding: Sequence[str], else_by: str) -> str:
    """Return in words what decides an order: changes that reverse it or leave none, or another cause."""
    if not deciding:
        return else_by
    effect = "" if verdict == Verdict.DEPENDS else " leads to no clear ranking"
    return f"omitted by the paper: {', '.join(deciding)}{effect}"


def as_searched(claim: Claim, unsearched: Sequence[str]) -> Claim:
    """Return the claim, not determined where it disagreed but the paper's open parameters were not all searched.

    A value that follows from the geometry, such as the ratio, needs no search. Claims under load have their own search:
    both are returned unchanged.
    """
    if claim.verdict != Verdict.DISAGREES or claim.kind == "value" or claim.condition.load or not unsearched:
        return claim
    words = f"{claim.decided_by}; not varied here: {', '.join(unsearched)}"
    return replace(claim, verdict=Verdict.NOT_DETERMINED, decided_by=words)


def sign_test_p(holds: Iterable[bool]) -> float | None:
    """Compute the p value of the two-sided sign test; None for a single figure."""
    from scipy.stats import binomtest

    seen = list(holds)
    return float(binomtest(sum(seen), len(seen)).pvalue) if len(seen) > 1 else None


def majority_verdict(holds: Iterable[bool]) -> Verdict:
    """Judge by the sign test whether most starts show a feature, or most do not.

    With 12 starts this needs 10, so that a single start decides nothing. A single value decides by itself.
    """
    seen = list(holds)
    p = sign_test_p(seen)
    if p is not None and p >= SIGNIFICANCE:
        return Verdict.NOT_DETERMINED
    return Verdict.AGREES if 2 * sum(seen) > len(seen) else Verdict.DISAGREES


def within(ours: StartSpread, low: float, high: float) -> list[bool]:
    """Return for each start whether it lies in a range."""
    return [low <= value <= high for value in ours.values]


def range_verdict(ours: StartSpread, low: float, high: float) -> Verdict:
    """Judge whether a quantity lies in a range, in most of its starts."""
    return majority_verdict(within(ours, low, high))


Part = tuple[Verdict, float | None]
"""Verdict and p value of a part of a claim."""


def jointly(parts: Sequence[Part]) -> Part:
    """Judge a claim of several parts: it fails with any part and agrees with all; p is that of the deciding part."""
    verdicts = {verdict for verdict, _ in parts}
    together = Verdict.AGREES if verdicts == {Verdict.AGREES} else Verdict.NOT_DETERMINED
    together = Verdict.DISAGREES if Verdict.DISAGREES in verdicts else together
    deciding = [p for verdict, p in parts if verdict == together and p is not None]
    return together, (min if together == Verdict.DISAGREES else max)(deciding, default=None)


def spread_value(text: str, ours: StartSpread, unit: str) -> Value:
    """Return the mean of the starts as a value, with the lowest and the highest."""
    return Value(text, ours.mean, unit, (ours.low, ours.high))


def spread_error(ours: StartSpread, unit: str) -> Value:
    """Return half the spread of the starts as the numerical error of their mean."""
    return Value(f"spread of {len(ours.values)} runs", ours.half, unit)
