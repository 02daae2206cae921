"""Parameters that decide a ranking: contact damping, friction and freedom of the pins, each varied alone."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cycloid_mj.base.result import load_words
from hsieh2014.ranking import Ranking


@dataclass(frozen=True)
class Varied:
    """Rankings with one parameter changed."""

    parameter: str
    value: str
    rankings: tuple[Ranking, ...]


def decisions(base: Sequence[Ranking], sweep: Sequence[Varied]) -> list[str]:
    """Return a sentence for each ranking: its ratio for each parameter, and which parameters decide it."""
    return [_describe_decision(ranking, _answers(ranking, sweep)) for ranking in base] if sweep else []


def _answers(base: Ranking, sweep: Sequence[Varied]) -> dict[str, list[tuple[str, Ranking]]]:
    """Return parameter -> (value, ranking) of the same quantity, designs and load."""
    answers: dict[str, list[tuple[str, Ranking]]] = {}
    for point in sweep:
        same = next(ranking for ranking in point.rankings if _case(ranking) == _case(base))
        answers.setdefault(point.parameter, []).append((point.value, same))
    return answers


def _case(ranking: Ranking) -> tuple[str, str, str, float]:
    return ranking.quantity, ranking.pin, ranking.nonpin, ranking.load_nm


def _describe_decision(base: Ranking, answers: Mapping[str, list[tuple[str, Ranking]]]) -> str:
    """Describe how each varied parameter changes a ranking, and which of them is decisive.

    `answers` are values with their rankings by parameter. A parameter is decisive if less than a third of the designs'
    difference (log ratio) remains.
    """
    parts = [f"ratio {base.ratio:.2f}"]
    parts += [
        f"{parameter} " + ", ".join(f"{value}: {ranking.ratio:.2f}" for value, ranking in points)
        for parameter, points in answers.items()
    ]
    least = {key: min(_difference(ranking) for _, ranking in points) for key, points in answers.items()}
    decisive = [key for key, difference in least.items() if difference < 1 / 3 * _difference(base)]
    if base.verdict == "not determined":
        verdict = "not determined, as the order of the designs is not"
    elif base.verdict == "alike":
        verdict = "the designs are alike"
    else:
        verdict = f"decided by {' and '.join(decisive)}" if decisive else "decided by none of them"
    return f"{load_words(base.load_nm)}, {base.quantity}, {base.pin} / {base.nonpin}: {'; '.join(parts)}: {verdict}"


def _difference(ranking: Ranking) -> float:
    return abs(math.log(ranking.ratio)) if ranking.ratio > 0.0 else math.inf
