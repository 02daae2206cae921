"""The result of a check, and of all checks of a design."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from cycloid_mj.base.frame import Frame, make_frame
from cycloid_mj.base.judgement import Judgement, count_judgements, judge
from cycloid_mj.base.notebook_display import Presented

UPPER = ("less than", "at most")
"""First words of the text of an upper limit."""

COLUMNS = ("name", "judgement", "passed", "severity", "key", "got", "limit", "why", "remedy", "value", "bound", "unit")
"""Columns of the frame of some checks."""

Severity = Literal["error", "warning"]

Change = Mapping[str, float]
"""Keys of the design file -> the values that they get together."""


@dataclass(frozen=True)
class Check:
    """The result of one check of a design.

    Attributes
    ----------
    name
        For programs.
    passed
        Whether the design is within the limit.
    got, limit
        The value that is checked, and what is allowed, as text with units.
    why
        Why the limit exists.
    remedy
        Keys to change, in which direction and to which value; empty if passed.
    severity
        "error" if a design that fails the check cannot be built; else "warning".
    key
        The key of the design file that is checked, or what is checked in words.
    value, bound, unit
        The numbers of `got` and `limit` and their unit in the file, where each is one number.
    changes
        The alternatives of the remedy: the keys of the design file to change together, with their values.
    """

    name: str
    passed: bool
    got: str
    limit: str
    why: str
    remedy: str
    severity: Severity = "error"
    key: str = ""
    value: float | None = None
    bound: float | None = None
    unit: str = ""
    changes: tuple[Change, ...] = ()

    @property
    def judgement(self) -> Judgement:
        """Passed; else failed if the design cannot be built, or a warning."""
        return judge(math.inf if self.passed else 0.0, decisive=self.severity == "error")

    def as_json(self) -> dict[str, Any]:
        """Convert the check to JSON values: its attributes without `changes`, by the names in `COLUMNS`."""
        return {name: getattr(self, name) for name in COLUMNS}

    def __str__(self) -> str:
        """Format the check in one line."""
        text = f"{self.name}: {self.key} is {self.got}, must be {self.limit}: {self.why}"
        return f"{text}; {self.remedy}" if self.remedy else text


class Checks(Presented, tuple[Check, ...]):
    """The checks of a design, in their order."""

    @property
    def frame(self) -> Frame:
        """The checks, a row each."""
        rows = [{name: value for name, value in check.as_json().items() if value is not None} for check in self]
        return make_frame(rows, COLUMNS, {})

    @property
    def line(self) -> str:
        """The number of checks, of failures and of warnings, and the names of both."""
        check_names = [check.name for check in (*self.failures, *self.warnings)]
        summary = f"{len(self)} checks: {self.counts}"
        return f"{summary} ({', '.join(check_names)})" if check_names else summary

    @property
    def counts(self) -> str:
        """The number of failures and of warnings, in words."""
        return count_judgements(check.judgement for check in self)

    @property
    def failures(self) -> tuple[Check, ...]:
        """The checks without which the design cannot be built."""
        return self._with(Judgement.FAILED)

    @property
    def warnings(self) -> tuple[Check, ...]:
        """The checks that the design does not pass, but can be built without."""
        return self._with(Judgement.WARNING)

    @property
    def passes(self) -> tuple[Check, ...]:
        """The checks that the design passes."""
        return self._with(Judgement.PASSED)

    def _with(self, judgement: Judgement) -> tuple[Check, ...]:
        return tuple(check for check in self if check.judgement is judgement)

    @property
    def margins(self) -> dict[str, float]:
        """Return the margin [1] of each check by name: the factor by which its value may change to reach its bound.

        It is above 1 if the check passes. Checks without number, or with a value or bound of 0, are left out.
        """
        all_values = {check.name: (check.value, check.bound, check.limit.startswith(UPPER)) for check in self}
        usable_values = {
            name: (value, bound, is_upper) for name, (value, bound, is_upper) in all_values.items() if value and bound
        }
        return {
            name: bound / value if is_upper else value / bound
            for name, (value, bound, is_upper) in usable_values.items()
        }
