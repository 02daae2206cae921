"""How a claim of the paper is judged: by comparing numbers, never by reading a sentence."""

from collections.abc import Iterable, Mapping

from cycloid_mj.comparison import Spread
from cycloid_mj.result import Value, Verdict


def order_verdict(found: int, varied: Mapping[str, int]) -> tuple[Verdict, tuple[str, ...]]:
    """Judge a claim that the first of two quantities is the larger.

    Parameters
    ----------
    found
        As `comparison.order` gives it.
    varied
        The same with something changed that the paper leaves open, by its name.

    Returns
    -------
    verdict
        It depends where a change turns the order round.
    turned
        The names of what turns it round.
    """
    if found == 0:
        return Verdict.NOT_DETERMINED, ()
    turned = tuple(name for name, each in varied.items() if each == -found)
    if turned:
        return Verdict.DEPENDS, turned
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
