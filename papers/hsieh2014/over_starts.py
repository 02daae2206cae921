"""Figures of starts without load, for the design itself and with single changes, and verdicts on them."""

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
from hsieh2014.verdicts import majority_verdict, sign_test_p

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class OverStarts(Generic[T]):
    """A figure of every start of a design without load."""

    base: Sequence[T]
    """Figure of each start of the design itself."""
    varied: Mapping[Variation, Sequence[T]]
    """Single change -> figure of each start."""
    ranges: tuple[Range, ...]
    """Searched ranges of what the paper leaves open."""

    @property
    def searched(self) -> dict[Variation, Sequence[T]]:
        """Return the changes of parameters that the paper leaves open."""
        return {variation: evidence for variation, evidence in self.varied.items() if variation.parameter in LEFT_OPEN}


@dataclass(frozen=True)
class Ruling:
    """Verdict on a claim: the verdict, its p, its cause in words, and the changes that prove it."""

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
    """Return a quantity of every start of a design without load, as designed and with single parameters varied.

    `figure` computes the quantity from the results of a run. Variations that do not change the design, or for which
    `has` is False, are left out.
    """
    designs = {variation: variation.of(Reducer(design)) for variation in variations(plan)}
    changed = [variation for variation, other in designs.items() if other != design and has(other)]
    base, varied = idle_runs(plan, design), {each: varied_idle_runs(plan, each, design) for each in changed}
    # requested together, so that the runs fill every core
    runs([*base, *(start for starts in varied.values() for start in starts)], plan.solver)
    figures = {each: list(map(figure, runs.figures(starts, plan.solver))) for each, starts in varied.items()}
    return OverStarts([figure(each) for each in runs.figures(base, plan.solver)], figures, ranges(plan))


def ruling(
    evidence: OverStarts[T],
    holds: Callable[[T], bool],
    words: Callable[[Sequence[T]], str],
    decisive: str = "",
    judged: Callable[[Sequence[bool]], Verdict] = majority_verdict,
) -> Ruling:
    """Judge a feature that each start shows or does not, and which single changes reverse the verdict.

    Parameters
    ----------
    evidence
        The quantity of every start.
    holds
        Whether a start shows the feature, from its quantity.
    words
        Description of the quantity of some starts.
    decisive
        Cause that applies whatever is varied, in words.
    judged
        Function that judges all starts together from whether each shows the feature.
    """

    def judge_starts(starts: Sequence[T]) -> Verdict:
        return judged([holds(start) for start in starts])

    reference = judge_starts(evidence.base)
    others = {each: judge_starts(starts) for each, starts in evidence.varied.items()}
    agrees = any(others[each] == Verdict.AGREES for each in evidence.searched)
    turned = ", ".join(f"{each.words} ({verdict})" for each, verdict in others.items() if verdict != reference)
    return Ruling(
        Verdict.DEPENDS if reference == Verdict.DISAGREES and agrees else reference,
        sign_test_p([holds(each) for each in evidence.base]),
        "; ".join(filter(None, (decisive, turned or "no single variation changes the verdict"))),
        tuple(Removal(each.words, words(starts), others[each]) for each, starts in evidence.varied.items()),
    )
