"""A claim of the paper beside what is found here: both numbers, the numerical error, a verdict, and what decides it."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

Verdict = Literal["agree", "disagree", "depends"]


@dataclass(frozen=True)
class Claim:
    """One row of the table of claims.

    Attributes
    ----------
    figure
        Figure or section of the paper.
    statement
        What the paper says, in our words.
    paper
        Its number, or what stands for it.
    ours
        Ours.
    error
        Numerical error of ours.
    verdict
        ``agree``, ``disagree``, or ``depends``.
    on
        What decides it.
    sweep
        What shows that: numbers of a sweep, or the figure or table that has them.
    values
        Our numbers for a program: key with unit -> value.
    """

    figure: str
    statement: str
    paper: str
    ours: str
    error: str
    verdict: Verdict
    on: str
    sweep: str
    values: Mapping[str, float] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """Give the claim as text and numbers."""
        return asdict(self) | {"values": dict(self.values)}


def judged(here: Sequence[bool], elsewhere: Sequence[bool] = ()) -> Verdict:
    """Judge by whether the paper's statement holds in each of our cases, and in each case of a sweep.

    Where all hold it agrees, where none does it disagrees; else it depends.
    """
    cases = [*here, *elsewhere]
    if all(cases):
        return "agree"
    return "depends" if any(cases) else "disagree"
