"""One judgement of a requirement for the terminal, Python, the page and reports."""

import math

import pytest

from cycloid_mj.base.judgement import Judgement, count_judgements, gravest, judge


@pytest.mark.parametrize(
    ("margin", "decisive", "judgement"),
    [
        (math.inf, True, Judgement.PASSED),
        (1.0, True, Judgement.PASSED),
        (0.999, True, Judgement.FAILED),
        (0.999, False, Judgement.WARNING),
        (None, True, Judgement.NOT_APPLICABLE),
        (math.nan, True, Judgement.NOT_APPLICABLE),
    ],
)
def test_margin_decides_the_judgement(margin: float | None, decisive: bool, judgement: Judgement) -> None:
    assert judge(margin, decisive) is judgement


def test_gravest_judgement_and_counts() -> None:
    some = [Judgement.PASSED, Judgement.WARNING, Judgement.NOT_APPLICABLE]
    assert gravest(some) is Judgement.WARNING
    assert gravest([]) is Judgement.NOT_APPLICABLE
    assert count_judgements(some) == "0 failed, 1 warning"
    assert count_judgements([Judgement.FAILED, *some, *some]) == "1 failed, 2 warnings"
