"""How a claim of the paper is judged: by comparing numbers, never by reading a sentence."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from statistics import NormalDist, median

from cycloid_mj.base.result import Claim, Value, Verdict
from cycloid_mj.comparison import StartSpread
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


def chance(start_spread: StartSpread, other: StartSpread) -> float:
    """Compute p of the rank test (Mann and Whitney, two-sided): of starts as different as these if both were alike."""
    from scipy.stats import mannwhitneyu

    return float(mannwhitneyu(start_spread.values, other.values).pvalue)


def rank_order(start_spread: StartSpread, other: StartSpread) -> int:
    """Tell which of two quantities is larger by the rank test: 1 the first, -1 the second, 0 neither for sure.

    Medians a hair apart, by what the step alone may change, are alike whatever the test says.
    """
    middles = median(start_spread.values), median(other.values)
    if chance(start_spread, other) >= SIGNIFICANCE or max(middles) <= ALIKE * min(middles):
        return 0
    return 1 if middles[0] > middles[1] else -1


def order_verdict(order: int, varied: Mapping[str, int]) -> tuple[Verdict, tuple[str, ...]]:
    """Judge a claim that the first of two quantities is the larger.

    Parameters
    ----------
    order
        As `rank_order` gives it.
    varied
        The same with something changed that the paper leaves open, by its name.

    Returns
    -------
    verdict
        It depends where a change turns the order round, and is not determined where the other order is found and a
        change leaves none; one that agrees stays so where a change leaves none.
    deciding
        The names of what turns it round, or leaves none.
    """
    if order == 0:
        return Verdict.NOT_DETERMINED, ()
    turned, none = (tuple(name for name, each in varied.items() if each == wanted) for wanted in (-order, 0))
    if turned:
        return Verdict.DEPENDS, turned
    if order > 0:
        return Verdict.AGREES, none
    return (Verdict.NOT_DETERMINED if none else Verdict.DISAGREES), none


def order_decided(verdict: Verdict, deciding: Sequence[str], else_by: str) -> str:
    """Tell what decides an order: what the paper leaves open and turns it or leaves none, or something else."""
    if not deciding:
        return else_by
    return f"left open by the paper: {', '.join(deciding)}{'' if verdict == Verdict.DEPENDS else ' leaves no order'}"


def as_searched(claim: Claim, unsearched: Sequence[str]) -> Claim:
    """Return a claim at no load that disagrees only if all was searched that the paper leaves open there.

    A value that the geometry gives, as the ratio, needs no search; claims under load have one of their own.
    """
    if claim.verdict != Verdict.DISAGREES or claim.kind == "value" or claim.condition.load or not unsearched:
        return claim
    words = f"{claim.decided_by}; not searched here: {', '.join(unsearched)}"
    return replace(claim, verdict=Verdict.NOT_DETERMINED, decided_by=words)


def most_chance(holds: Iterable[bool]) -> float | None:
    """Compute p of the sign test (two-sided): of as many starts on one side if half of all starts showed it.

    None of a single figure, which has no spread.
    """
    from scipy.stats import binomtest

    seen = list(holds)
    return float(binomtest(sum(seen), len(seen)).pvalue) if len(seen) > 1 else None


def most(holds: Iterable[bool]) -> Verdict:
    """Judge something that each start shows or does not: whether most starts do, or most do not, by the sign test.

    Of 12 starts that takes 10: a single one that strays decides nothing. A single figure is as it is.
    """
    seen = list(holds)
    p = most_chance(seen)
    if p is not None and p >= SIGNIFICANCE:
        return Verdict.NOT_DETERMINED
    return Verdict.AGREES if 2 * sum(seen) > len(seen) else Verdict.DISAGREES


def within(ours: StartSpread, low: float, high: float) -> list[bool]:
    """Tell of each start whether it lies in a range."""
    return [low <= value <= high for value in ours.values]


def range_verdict(ours: StartSpread, low: float, high: float) -> Verdict:
    """Judge whether a quantity lies in a range, in most of its starts."""
    return most(within(ours, low, high))


Part = tuple[Verdict, float | None]
"""Part of a claim: its verdict and its p."""


def jointly(parts: Sequence[Part]) -> Part:
    """Judge a claim of several parts: it fails with any of them, and agrees with all; p is of the part that decides."""
    verdicts = {verdict for verdict, _ in parts}
    together = Verdict.AGREES if verdicts == {Verdict.AGREES} else Verdict.NOT_DETERMINED
    together = Verdict.DISAGREES if Verdict.DISAGREES in verdicts else together
    deciding = [p for verdict, p in parts if verdict == together and p is not None]
    return together, (min if together == Verdict.DISAGREES else max)(deciding, default=None)


def spread_value(text: str, ours: StartSpread, unit: str) -> Value:
    """Compute the mean of starts as a value, with the lowest and the highest."""
    return Value(text, ours.mean, unit, (ours.low, ours.high))


def spread_error(ours: StartSpread, unit: str) -> Value:
    """Compute half the spread of starts as the numerical error of their mean."""
    return Value(f"spread of {len(ours.values)} starts", ours.half, unit)
