"""The judgement of a requirement, the same on the terminal, in Python, on the page and in reports."""

from collections.abc import Iterable
from enum import StrEnum


class Judgement(StrEnum):
    """Verdict on a requirement; its value is the word for people and programs."""

    PASSED = "passed"
    WARNING = "warning"
    """The requirement is not met, but what was judged works without it."""
    FAILED = "failed"
    NOT_APPLICABLE = "not applicable"
    """There is no limit to judge by: a mere figure, or a life or safety that its law does not define."""


_GRAVITY = (Judgement.FAILED, Judgement.WARNING, Judgement.PASSED, Judgement.NOT_APPLICABLE)


def judge(margin: float | None, decisive: bool = True) -> Judgement:
    """Return the verdict on a requirement: passed for a margin of at least 1, else failed or a warning.

    Parameters
    ----------
    margin
        Limit over load, or life over the required life: 1 is just enough. It is infinite where nothing wears out, which
        is passed. None and NaN mean that there is no limit; the verdict is then "not applicable".
    decisive
        Whether a requirement that is not met is a failure; else it is a warning.
    """
    if margin is None or margin != margin:
        return Judgement.NOT_APPLICABLE
    if margin >= 1.0:
        return Judgement.PASSED
    return Judgement.FAILED if decisive else Judgement.WARNING


def gravest(judgements: Iterable[Judgement]) -> Judgement:
    """Return the gravest of some judgements: failed, warning, passed; not applicable if there is no other."""
    return min(judgements, key=_GRAVITY.index, default=Judgement.NOT_APPLICABLE)


def count_judgements(judgements: Iterable[Judgement]) -> str:
    """Summarize judgements in words: ``52 checks: 0 failed, 1 warning`` without the first two words."""
    judgement_list = list(judgements)
    warnings = judgement_list.count(Judgement.WARNING)
    return f"{judgement_list.count(Judgement.FAILED)} failed, {warnings} {'warning' if warnings == 1 else 'warnings'}"
