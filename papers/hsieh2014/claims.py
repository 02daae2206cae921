"""A claim of the paper as data: where it stands, under which condition, its number, ours, and a verdict by numbers.

No verdict is read out of a sentence: those below compare numbers, and each claim carries the numbers it was judged by.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from cycloid_mj.comparison import Spread

Verdict = Literal["agrees", "disagrees", "depends", "not determined"]
Kind = Literal["value", "height", "order", "pattern"]

VERDICTS: tuple[Verdict, ...] = ("agrees", "disagrees", "depends", "not determined")

RPM = 30.0 / math.pi
"""Revolutions per minute in one rad/s."""


@dataclass(frozen=True)
class Condition:
    """Under what a claim is judged.

    Attributes
    ----------
    load
        Torque against the output's rotation [N m]; 0 is no load.
    speed
        Of the crank [rad/s].
    input_torque
        On the crank, where the test gives that and the load follows from it [N m].
    """

    load: float
    speed: float
    input_torque: float | None = None

    @property
    def words(self) -> str:
        """The load in words, for a row of a table."""
        if self.input_torque is not None:
            return f"{self.input_torque:g} N m in"
        return f"{self.load:g} N m" if self.load else "no load"

    def as_json(self) -> dict[str, float]:
        """Give load [N m] and speed [rpm] for a program."""
        torque = {} if self.input_torque is None else {"input_torque_nm": self.input_torque}
        return {"load_nm": self.load, "speed_rpm": round(self.speed * RPM, 9)} | torque


@dataclass(frozen=True)
class Stated:
    """What the paper states: the `claim` in our words, its `kind`, and its number: as `text`, and as `value` `unit`."""

    claim: str
    kind: Kind
    text: str
    value: float | None = None
    unit: str = ""

    def as_json(self) -> dict[str, Any]:
        """Give the statement for a program."""
        return {"claim": self.claim, "kind": self.kind, "value": self.value, "unit": self.unit, "text": self.text}


@dataclass(frozen=True)
class Result:
    """What is found here: as `text`, and as a `value` in a `unit`, with the lowest and highest of several starts."""

    text: str
    value: float | None = None
    unit: str = ""
    spread: tuple[float, float] | None = None

    def as_json(self) -> dict[str, Any]:
        """Give the result for a program."""
        spread = None if self.spread is None else list(self.spread)
        return {"value": self.value, "unit": self.unit, "spread": spread, "text": self.text}


@dataclass(frozen=True)
class NumericalError:
    """How far computing alone moves a result: `value` in a `unit`, and its `source`, as in "half the step"."""

    value: float | None
    unit: str
    source: str

    @property
    def words(self) -> str:
        """The error as text."""
        return self.source if self.value is None else f"{self.value:.2g} {self.unit} ({self.source})"

    def as_json(self) -> dict[str, Any]:
        """Give the error for a program."""
        return {"value": self.value, "unit": self.unit, "source": self.source}


@dataclass(frozen=True)
class Claim:
    """One claim of the paper, judged.

    Attributes
    ----------
    key
        Its name for programs.
    figure, part, design
        Figure or section of the paper, the part and the design that it speaks of; "both" where it compares them.
    condition
        Under what the paper states it, and it is judged.
    paper, ours
        What the paper states, and what is found here under that condition.
    error
        Numerical error of ours.
    verdict
        ``agrees``, ``disagrees``; ``depends`` where something decides it that the paper leaves open at this condition;
        ``not determined`` where the spread of independent starts exceeds the difference.
    decided_by
        What decides it.
    rated
        Ours at the rated load, beside it and never judged; None where the rated load is the condition.
    """

    key: str
    figure: str
    part: str
    design: str
    condition: Condition
    paper: Stated
    ours: Result
    error: NumericalError
    verdict: Verdict
    decided_by: str
    rated: Result | None = None

    def as_json(self) -> dict[str, Any]:
        """Give the claim for a program."""
        return {
            "key": self.key,
            "figure": self.figure,
            "part": self.part,
            "design": self.design,
            "condition": self.condition.as_json(),
            "paper": self.paper.as_json(),
            "ours": self.ours.as_json(),
            "numerical_error": self.error.as_json(),
            "verdict": self.verdict,
            "decided_by": self.decided_by,
            "at_rated_load": None if self.rated is None else self.rated.as_json(),
        }


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
        return "not determined", ()
    turned = tuple(name for name, each in varied.items() if each == -found)
    if turned:
        return "depends", turned
    return ("agrees" if found > 0 else "disagrees"), ()


def range_verdict(ours: Spread, low: float, high: float) -> Verdict:
    """Judge whether a quantity lies in a range: all of its starts, none of them, or some."""
    inside = [low <= value <= high for value in ours.values]
    if all(inside):
        return "agrees"
    return "not determined" if any(inside) else "disagrees"


def share_verdict(holds: Iterable[bool]) -> Verdict:
    """Judge something that each start shows or does not."""
    seen = list(holds)
    if all(seen):
        return "agrees"
    return "not determined" if any(seen) else "disagrees"
