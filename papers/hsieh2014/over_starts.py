"""Figures of idle starts, as the design is and with one thing changed alone; and what a claim on them comes to."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from cycloid_mj.base.result import Range, Removal, Verdict
from cycloid_mj.comparison import Variation
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer
from hsieh2014.plan import LEFT_OPEN, Plan, idle_runs, ranges, variations, varied_idle_runs
from hsieh2014.run_figures import RunFigures
from hsieh2014.stage import Runs
from hsieh2014.verdicts import most, most_chance

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class OverStarts(Generic[T]):
    """One figure of every idle start of a design.

    Attributes
    ----------
    base
        As the design is, start by start.
    varied
        What was changed alone -> the same.
    ranges
        How far that searched what the paper leaves open.
    """

    base: Sequence[T]
    varied: Mapping[Variation, Sequence[T]]
    ranges: tuple[Range, ...]

    @property
    def searched(self) -> dict[Variation, Sequence[T]]:
        """What was changed of all that the paper leaves open."""
        return {one: evidence for one, evidence in self.varied.items() if one.parameter in LEFT_OPEN}


@dataclass(frozen=True)
class Ruling:
    """What a claim comes to: the verdict, its p, what decides it in words, and what proves that."""

    verdict: Verdict
    p: float | None
    decided_by: str
    removals: tuple[Removal, ...]


def over_starts(
    plan: Plan,
    runs: Runs,
    design: Design,
    figure: Callable[[RunFigures], T],
    has: Callable[[Design], bool] = lambda changed: True,
) -> OverStarts[T]:
    """Take a figure of each idle start, and of each with one thing changed that concerns a design and that `has` it."""
    changed = [
        variation
        for variation in variations(plan)
        if variation.of(Reducer(design)) != design and has(variation.of(Reducer(design)))
    ]
    base, varied = idle_runs(plan, design), {one: varied_idle_runs(plan, one, design) for one in changed}
    # asked for together, so that the runs fill every core
    runs([*base, *(start for starts in varied.values() for start in starts)], plan.solver)
    figures = {one: list(map(figure, runs.figures(starts, plan.solver))) for one, starts in varied.items()}
    return OverStarts([figure(one) for one in runs.figures(base, plan.solver)], figures, ranges(plan))


def ruling(
    evidence: OverStarts[T],
    holds: Callable[[T], bool],
    words: Callable[[Sequence[T]], str],
    decisive: str = "",
    judged: Callable[[Sequence[bool]], Verdict] = most,
) -> Ruling:
    """Judge something that each start shows or does not, and what of all that was changed alone turns it.

    Parameters
    ----------
    evidence
        The figure of every start.
    holds
        Whether a start shows it.
    words
        What is found, of some starts.
    decisive
        What decides it whatever is varied, in words.
    judged
        How starts are judged together.
    """

    def of(starts: Sequence[T]) -> Verdict:
        return judged([holds(start) for start in starts])

    reference = of(evidence.base)
    others = {one: of(starts) for one, starts in evidence.varied.items()}
    agrees = any(others[one] == Verdict.AGREES for one in evidence.searched)
    turned = ", ".join(f"{one.words} ({verdict})" for one, verdict in others.items() if verdict != reference)
    return Ruling(
        Verdict.DEPENDS if reference == Verdict.DISAGREES and agrees else reference,
        most_chance([holds(one) for one in evidence.base]),
        "; ".join(filter(None, (decisive, turned or "nothing that was varied alone changes the verdict"))),
        tuple(Removal(one.words, words(starts), others[one]) for one, starts in evidence.varied.items()),
    )
