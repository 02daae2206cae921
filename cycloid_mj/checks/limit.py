"""Limits on values of a design, as numbers and as text."""

import math
import operator
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np
from pydantic.fields import FieldInfo

from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks.check import UPPER, Change
from cycloid_mj.design import Design, override
from cycloid_mj.design.units import MILLIMETRE, Unit, file_key, section_of, unit_of
from cycloid_mj.reducer import Reducer, once

SIDES = {"less than": operator.lt, "at most": operator.le, "more than": operator.gt, "at least": operator.ge}
STRICT = ("less than", "more than")
SYMBOLS = {"mpa": "MPa", "nm": "N m", "kw": "kW", "kg_m3": "kg/m3"}


@dataclass(frozen=True)
class LimitSettings:
    """Rounding of values and remedies."""

    strict_margin: float = 1e-9
    """Relative distance of a remedy from a strict limit: rounding must not undo it."""
    full_digits: int = 13
    """Digits that write a value of the file in full: two fewer than those of float64, which rounding needs."""
    smallest_bound: float = 1e-30
    """Bounds nearer to 0 [SI] are no remedy."""


LIMIT = LimitSettings()


class Numbers(TypedDict):
    """Value, bound and unit of a check, as arguments of `Check`."""

    value: float
    bound: float
    unit: str


class Remedy(TypedDict):
    """Remedy of a check in words and as changes, as arguments of `Check`."""

    remedy: str
    changes: tuple[Change, ...]


@dataclass(frozen=True)
class Limit:
    """A `bound` [SI] on the value at `key` (table.field of the model); `side` is one of `SIDES`."""

    key: str
    side: str
    bound: float

    def value(self, reducer: Reducer) -> float:
        """Return the design's value [SI]."""
        table, name = self.key.split(".")
        return float(getattr(getattr(reducer.design, table), name))

    def is_met(self, reducer: Reducer) -> bool:
        """Return whether the design is within the limit."""
        return bool(SIDES[self.side](self.value(reducer), self.bound))

    def texts(self, reducer: Reducer) -> tuple[str, str]:
        """Format value and limit in the file's unit."""
        return value_and_limit(self.value(reducer), self.side, self.bound, self.unit)

    def numbers(self, reducer: Reducer) -> Numbers:
        """Return value and bound in the file's unit."""
        return numbers(self.value(reducer), self.bound, self.unit)

    def remedy(self, reducer: Reducer) -> str:
        """Describe the change of the design that satisfies the limit, as ``lower KEY to VALUE or less``.

        The text is empty if the bound is 0 or infinite, or the file does not allow the value.
        """
        if not LIMIT.smallest_bound < abs(self.bound) < math.inf or not _is_allowed(reducer, self):
            return ""
        verb, comparative = ("lower", "less") if self.side in UPPER else ("raise", "more")
        return f"{verb} {self.file_key} to {self.safe_number} or {comparative}"

    def change(self, reducer: Reducer) -> tuple[str, float] | None:
        """Return the file's key and the value that satisfies the limit; None if the file does not allow it."""
        if not self.remedy(reducer):
            return None
        return self.file_key, int(self.safe_number) if self._is_integer else float(self.safe_number)

    @property
    def unit(self) -> Unit:
        """Unit of the value in the design file."""
        return unit_of(self._model_field)

    @property
    def file_key(self) -> str:
        """The key as the design file has it, with its unit."""
        table, name = self.key.split(".")
        return f"{table}.{file_key(name, self._model_field)}"

    @property
    def safe_number(self) -> str:
        """The last number of four digits, or the last integer, that satisfies the limit, in the file's unit."""
        inward = -1 if self.side in UPPER else 1
        margin = LIMIT.strict_margin * abs(self.bound) if self.side in STRICT else 0.0
        bound = self.unit.from_si(self.bound + inward * margin)
        return round_beyond(bound, inward < 0, self._is_integer)

    @property
    def _is_integer(self) -> bool:
        """Whether the value is an integer, which the design file requires without a decimal point."""
        return self._model_field.annotation is int

    @property
    def _model_field(self) -> FieldInfo:
        """The field of the model that has the key."""
        table, name = self.key.split(".")
        field: FieldInfo = section_of(Design.model_fields[table]).model_fields[name]
        return field


@once
def _is_allowed(reducer: Reducer, limit: Limit) -> bool:
    """Return whether the design file allows the value that satisfies a limit."""
    try:
        override(reducer.design, [f"{limit.file_key}={limit.safe_number}"])
    except DesignError:
        return False
    return True


def joint_remedy(reducer: Reducer, limits: Sequence[Limit], other_remedy: str = "") -> Remedy:
    """Return the remedy of a failed check that changes several keys together, in words and as a single change.

    The keys and their new values are those of `limits`. `other_remedy`, in words, is an alternative to this change.
    Without limits, text and changes are empty. A limit whose value the design file does not allow is left out of the
    text, and no change is returned.
    """
    changes = [limit.change(reducer) for limit in limits]
    remedy_text = " and ".join(filter(None, (limit.remedy(reducer) for limit in limits)))
    return {
        "remedy": ", or ".join(filter(None, (remedy_text, other_remedy))) if limits else "",
        "changes": (dict(filter(None, changes)),) if changes and all(changes) else (),
    }


def single_remedies(reducer: Reducer, limits: Sequence[Limit], otherwise: str = "") -> Remedy:
    """Return alternative remedies of a failed check, each of which changes one key, in words and as changes.

    There is one remedy for each limit; each alone is sufficient. `otherwise`, in words, is a further alternative. A
    limit whose value the design file does not allow is left out. Without limits, both text and changes are empty.
    """
    remedy_texts = [*(limit.remedy(reducer) for limit in limits), otherwise] if limits else []
    return {
        "remedy": ", or ".join(filter(None, remedy_texts)),
        "changes": tuple(dict([change]) for limit in limits if (change := limit.change(reducer))),
    }


def round_beyond(value: float, down: bool, is_integer: bool) -> str:
    """Round a value, not 0, down or up to four digits or to a whole number, and write it as text."""
    increment = 1.0 if is_integer else 10.0 ** (math.floor(math.log10(abs(value))) - 3)
    return f"{(math.floor if down else math.ceil)(value / increment) * increment:.10g}"


def numbers(value: float, bound: float, unit: Unit) -> Numbers:
    """Convert a value and its bound [SI] to a unit of the file."""
    return {"value": unit.from_si(value), "bound": unit.from_si(bound), "unit": unit.suffix}


def value_and_limit(value: float, side: str, bound: float, unit: Unit) -> tuple[str, str]:
    """Format a `value` and its limit, both in SI units, in the `unit` of a key of the design file.

    Both have four digits, or more if their texts would otherwise be equal. If value and limit themselves are equal, all
    digits are written, because a remedy that lies slightly beyond the limit must differ from it. `bound` is the limit,
    and `side` the text before it, such as "at most".

    Returns
    -------
    tuple of str
        Value with unit, such as "12 um"; side and limit with unit, such as "at most 10 um".
    """
    unit_symbol = SYMBOLS.get(unit.suffix, unit.suffix)
    shown_value, shown_limit = unit.from_si(value), unit.from_si(bound)
    digit_count = next(
        (
            candidate_count
            for candidate_count in range(4, LIMIT.full_digits)
            if decimal(shown_value, candidate_count) != decimal(shown_limit, candidate_count)
        ),
        LIMIT.full_digits,
    )
    return (
        f"{decimal(shown_value, digit_count)} {unit_symbol}".rstrip(),
        f"{side} {decimal(shown_limit, digit_count)} {unit_symbol}".rstrip(),
    )


def millimetres(length: float) -> str:
    """Format a length [m] in mm with four digits."""
    return f"{decimal(MILLIMETRE.from_si(length), 4)} mm"


def decimal(number: float, digits: int) -> str:
    """Format a number with significant digits and without an exponent."""
    return np.format_float_positional(float(f"{number:.{digits}g}"), trim="-")
