"""One check, and the bound on one value of the design that most checks consist of."""

import math
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from pydantic.fields import FieldInfo

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.frame import Frame, framed
from cycloid_mj.base.judgement import Judgement, count_judgements, judge
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.design import Design, override
from cycloid_mj.design.units import MILLIMETRE, Unit, file_key, section_of, unit_of
from cycloid_mj.reducer import Reducer

SIDES = {"less than": operator.lt, "at most": operator.le, "more than": operator.gt, "at least": operator.ge}
UPPER = ("less than", "at most")
STRICT = ("less than", "more than")
SYMBOLS = {"mpa": "MPa", "nm": "N m", "kw": "kW", "kg_m3": "kg/m3"}

STRICT_MARGIN = 1e-9
"""Relative; a remedy stays that far inside a strict limit, so that rounding cannot undo it."""

FULL_DIGITS = 13
"""Digits that write a value of the file in full: two of float64's fewer, which rounding takes."""

SMALLEST = 1e-30
"""SI; smaller bounds, and 0, are no remedy."""

COLUMNS = (
    "name",
    "judgement",
    "passed",
    "severity",
    "key",
    "got",
    "limit",
    "why",
    "remedy",
    "value",
    "bound",
    "unit",
)
"""Columns of the frame of some checks."""

Severity = Literal["error", "warning"]

Change = Mapping[str, float]
"""Keys of the design file -> the values that they get together."""


@dataclass(frozen=True)
class Check:
    """One verdict on a design.

    `got` and `limit` are short texts in the file's units, about the value of the file's `key`; `why` says what the
    limit is there for; `remedy` names the keys to change, in which direction and to which number (empty if passed). A
    failed check of severity "error" means that the design cannot be built; a "warning" is told and stops nothing.
    `value` and `bound` are what `got` and `limit` tell, in the file's `unit`, where each is one number. `changes` are
    the ways of the remedy, any of which helps alone: each names keys of the file and the values to give them together.
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
        """Convert the check to JSON values, without its `changes`."""
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
        return framed(rows, COLUMNS, {})

    @property
    def line(self) -> str:
        """The number of checks, of failures and of warnings, and the names of both."""
        names = [check.name for check in (*self.failures, *self.warnings)]
        summary = f"{len(self)} checks: {self.counts}"
        return f"{summary} ({', '.join(names)})" if names else summary

    @property
    def counts(self) -> str:
        """The number of failures and of warnings, in words."""
        return count_judgements(check.judgement for check in self)

    @property
    def failures(self) -> tuple[Check, ...]:
        """The checks without which the design cannot be built."""
        return self._judged(Judgement.FAILED)

    @property
    def warnings(self) -> tuple[Check, ...]:
        """The checks that the design does not pass, but can be built without."""
        return self._judged(Judgement.WARNING)

    @property
    def passes(self) -> tuple[Check, ...]:
        """The checks that the design passes."""
        return self._judged(Judgement.PASSED)

    def _judged(self, judgement: Judgement) -> tuple[Check, ...]:
        return tuple(check for check in self if check.judgement is judgement)

    @property
    def margins(self) -> dict[str, float]:
        """Of each check of a number against a bound, how many times the number may grow, or shrink, until it fails."""
        sides = {one.name: (one.value, one.bound, one.limit.startswith(UPPER)) for one in self}
        numbers = {name: (value, bound, upper) for name, (value, bound, upper) in sides.items() if value and bound}
        return {name: bound / value if upper else value / bound for name, (value, bound, upper) in numbers.items()}


@dataclass(frozen=True)
class Limit:
    """A `bound` [SI] on the value at `key` (table.field of the model); `side` is a word of ``SIDES``."""

    key: str
    side: str
    bound: float

    def value(self, reducer: Reducer) -> float:
        """Compute the design's value [SI]."""
        table, name = self.key.split(".")
        return float(getattr(getattr(reducer.design, table), name))

    def holds(self, reducer: Reducer) -> bool:
        """Tell whether the design keeps the limit."""
        return bool(SIDES[self.side](self.value(reducer), self.bound))

    def formatted(self, reducer: Reducer) -> tuple[str, str]:
        """Format value and limit in the file's unit."""
        return value_and_limit(self.value(reducer), self.side, self.bound, self.unit)

    def numbers(self, reducer: Reducer) -> tuple[float, float, str]:
        """Return value, bound and the file's unit of both."""
        return self.unit.from_si(self.value(reducer)), self.unit.from_si(self.bound), self.unit.suffix

    def remedy(self, reducer: Reducer) -> str:
        """Tell the change that keeps the limit, rounded to the safe side; empty if the file allows none."""
        if not SMALLEST < abs(self.bound) < math.inf:
            return ""
        number = self._number
        try:
            override(reducer.design, [f"{self.file_key}={number}"])
        except DesignError:
            return ""
        turn, beyond = ("lower", "less") if self.side in UPPER else ("raise", "more")
        return f"{turn} {self.file_key} to {number} or {beyond}"

    def change(self, reducer: Reducer) -> tuple[str, float] | None:
        """Return the file's key and the value that keeps the limit; nothing if the file allows none."""
        return (self.file_key, float(self._number)) if self.remedy(reducer) else None

    @property
    def unit(self) -> Unit:
        """Unit of the value in the design file."""
        return unit_of(self._field)

    @property
    def file_key(self) -> str:
        """The key as the design file has it, with its unit."""
        table, name = self.key.split(".")
        return f"{table}.{file_key(name, self._field)}"

    @property
    def _number(self) -> str:
        """The last number of four digits (or the last integer) inside the limit, in the file's unit."""
        whole = self._field.annotation is int
        inward = -1 if self.side in UPPER else 1
        margin = STRICT_MARGIN * abs(self.bound) if self.side in STRICT else 0.0
        bound = self.unit.from_si(self.bound + inward * margin)
        step = 1.0 if whole else 10.0 ** (math.floor(math.log10(abs(bound))) - 3)
        steps = math.floor(bound / step) if inward < 0 else math.ceil(bound / step)
        return f"{steps * step:.10g}"

    @property
    def _field(self) -> FieldInfo:
        table, name = self.key.split(".")
        field: FieldInfo = section_of(Design.model_fields[table]).model_fields[name]
        return field


@dataclass(frozen=True)
class Demand:
    """A limit that a design is to keep; `judged` makes a check of it.

    Attributes
    ----------
    name, limit, why, severity
        As in ``Check``.
    instead
        Limits on other keys that would do as well: further remedies.
    tied
        Whether the checked value is tied to others, so that changing it alone is no remedy.
    first
        A graver rule on the same value: where it fails, it is told instead, with this one's remedy.
    """

    name: str
    limit: Limit
    why: str
    instead: tuple[Limit, ...] = ()
    severity: Severity = "error"
    tied: bool = False
    first: "Demand | None" = None


def wall_rule(
    name: str, limits: Callable[[float], tuple[Limit, ...]], share: float, radius: float, where: str, tied: bool = False
) -> Demand:
    """State the rule of a wall: thinner than is assumed is a warning, cut-outs that run into each other are an error.

    Parameters
    ----------
    name, tied
        As in `Demand`.
    limits
        Gives the limits that leave a wall of a share of E, that of the checked value first.
    share, radius
        Least share, assumed, and E [m].
    where
        Between what the wall is.
    """
    limit, *instead = limits(share)
    why = f"{where} a wall of at least {millimetres(share * radius)} is wanted ({share:.0%} of E, assumed)"
    none_left = Demand(name, limits(0.0)[0], f"{where} no wall is left")
    return Demand(name, limit, why, tuple(instead), severity="warning", tied=tied, first=none_left)


def judged(reducer: Reducer, rules: Iterable[Demand | Check]) -> Iterator[Check]:
    """Judge a design by rules, in their order; what is a check already is handed through."""
    return (rule if isinstance(rule, Check) else _judged(reducer, rule) for rule in rules)


def _judged(reducer: Reducer, rule: Demand) -> Check:
    limit = rule.limit
    passed = limit.holds(reducer)
    got, allowed = limit.formatted(reducer)
    helpful = [] if passed else [*([] if rule.tied else [limit]), *rule.instead]
    remedy = "" if passed else _remedy(reducer, helpful)
    value, bound, unit = limit.numbers(reducer)
    key, changes = limit.file_key, single_changes(reducer, helpful)
    check = Check(rule.name, passed, got, allowed, rule.why, remedy, rule.severity, key, value, bound, unit, changes)
    if rule.first is None or rule.first.limit.holds(reducer):
        return check
    return replace(_judged(reducer, rule.first), remedy=remedy, changes=changes)


def single_changes(reducer: Reducer, limits: Iterable[Limit]) -> tuple[Change, ...]:
    """List the changes, each of which keeps one of some limits alone."""
    return tuple(dict([change]) for limit in limits if (change := limit.change(reducer)))


def joint_change(reducer: Reducer, limits: Iterable[Limit]) -> tuple[Change, ...]:
    """List the one change that keeps all of some limits: none where one of them allows none, or there is no limit."""
    changes = [limit.change(reducer) for limit in limits]
    return (dict(filter(None, changes)),) if changes and all(changes) else ()


def _remedy(reducer: Reducer, limits: list[Limit]) -> str:
    """Tell each single change that helps, or that none does."""
    single = [remedy for limit in limits if (remedy := limit.remedy(reducer))]
    together = " and ".join(limit.file_key for limit in limits)
    return ", or ".join(single) or f"no single change that the file allows is enough: change {together} together"


def value_and_limit(value: float, side: str, bound: float, unit: Unit) -> tuple[str, str]:
    """Format a value and its limit [SI] in a unit, with as many digits as distinguish them, and at least four.

    Where they are the same they are written in full: an advice then has another number.
    """
    symbol = SYMBOLS.get(unit.suffix, unit.suffix)
    a, b = unit.from_si(value), unit.from_si(bound)
    digits = next((n for n in range(4, FULL_DIGITS) if _shortened(a, n) != _shortened(b, n)), FULL_DIGITS)
    return f"{_shortened(a, digits)} {symbol}".rstrip(), f"{side} {_shortened(b, digits)} {symbol}".rstrip()


def millimetres(length: float) -> str:
    """Format a length [m]."""
    return f"{_shortened(MILLIMETRE.from_si(length), 4)} mm"


def _shortened(number: float, digits: int) -> str:
    """Round to significant digits, without the exponent that large numbers would get."""
    return np.format_float_positional(float(f"{number:.{digits}g}"), trim="-")
