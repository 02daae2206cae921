"""Parts of every result: quantities, curves, tables, verdicts."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.text import four_digits

if TYPE_CHECKING:
    from cycloid_mj.base.array import Array
    from cycloid_mj.base.frame import Frame


def to_json_values(value: Any) -> Any:
    """Convert dataclass objects, mappings, lists and tuples to JSON values; NaN and infinities become None.

    An object with the method `as_json` becomes the return value of this method, any other dataclass object a dict of
    its fields. Objects of other types, such as numbers and texts, are returned unchanged.
    """
    if hasattr(value, "as_json"):
        return to_json_values(value.as_json())
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: to_json_values(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {key: to_json_values(element) for key, element in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_json_values(element) for element in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@dataclass(frozen=True)
class Quantity:
    """A measured number.

    Attributes
    ----------
    key, name
        What it is: for programs, where it is the key of the JSON object, and in words.
    value, unit
        What was measured.
    error
        Its numerical error, in the same unit: what half the step, or a shorter average, changes. None where a closed
        form yields the value itself.
    reference
        The closed form, in the same unit; None where there is none.
    source
        Where the reference comes from.
    note
        What decides a difference, or what the value stands on.
    low, high
        Interval of the value from the spread of its inputs, 5 and 95 %, in the same unit; None where it has none.
    causes
        Inputs that vary, each with its share of the variance, the largest first.
    """

    key: str
    name: str
    value: float
    unit: str
    error: float | None = None
    reference: float | None = None
    source: str = ""
    note: str = ""
    low: float | None = None
    high: float | None = None
    causes: tuple[tuple[str, float], ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Convert a quantity to JSON values, without its key.

        ``value`` and its closed form, ``reference``, are in ``unit``, as is ``numerical_error``. ``source`` is that of
        the reference; ``name`` and ``note`` are texts. An interval adds the keys of `interval_json`.
        """
        return {
            "name": self.name,
            "value": self.value,
            "unit": self.unit,
            "numerical_error": self.error,
            "reference": self.reference,
            "source": self.source,
            "note": self.note,
            **self.interval_json(),
        }

    @property
    def interval_text(self) -> str:
        """Return the interval and the two inputs that cause most of it, in words; empty if there is no interval."""
        if self.low is None or self.high is None:
            return ""
        inputs = " and ".join(f"{name} ({share:.0%})" for name, share in self.causes[:2])
        return f"{self.low:.4g} to {self.high:.4g} (5 to 95 %), mostly from {inputs}"

    def interval_json(self) -> dict[str, Any]:
        """Convert the interval of a quantity to JSON values: its ends ``low`` and ``high``, and its ``causes``.

        ``causes`` are the (at most two) uncertain inputs that cause most of the interval, each with ``input``, its
        name, and ``share_of_variance``. The dict is empty if there is no interval.
        """
        if self.low is None:
            return {}
        return {
            "low": self.low,
            "high": self.high,
            "causes": [{"input": name, "share_of_variance": share} for name, share in self.causes[:2]],
        }


def by_key(*groups: Iterable[Quantity]) -> dict[str, Quantity]:
    """Collect the quantities of all groups by their keys, in their order."""
    return {quantity.key: quantity for group in groups for quantity in group}


def quantity_frame(quantities: Mapping[str, Quantity]) -> "Frame":
    """Return quantities as a frame, a row each; intervals are left out."""
    from cycloid_mj.base.frame import make_frame  # which takes NumPy, that no help page needs

    rows = [{"key": key, **quantity.as_json()} for key, quantity in quantities.items()]
    names = ("key", "name", "value", "unit", "numerical_error", "reference", "source", "note")
    return make_frame(rows, names, {})


def quantity_table(title: str, quantities: Iterable[Quantity]) -> "Table":
    """Return a table with a row per quantity: name, value, unit, numerical error, closed form and its source.

    `title` is the heading of the table. A value that is NaN is a dash. A missing error or closed form is an empty cell.
    """
    rows = (
        (
            quantity.name,
            "-" if math.isnan(quantity.value) else four_digits(quantity.value),
            quantity.unit,
            "" if quantity.error is None or math.isnan(quantity.error) else f"{quantity.error:.2g}",
            "" if quantity.reference is None else four_digits(quantity.reference),
            quantity.source,
        )
        for quantity in quantities
    )
    return Table(title, ("quantity", "value", "unit", "num. error", "closed form", "source"), tuple(rows))


@dataclass(frozen=True, eq=False, repr=False)
class Curve(Presented):
    """A curve of a figure.

    Attributes
    ----------
    panel
        Title of the panel that it is drawn in.
    name
        Label that distinguishes it from the panel's other curves.
    x, y
        Points, shape (n,) each.
    x_label, y_label
        What the axes show, with units: ``crank angle [deg]``.
    style
        ``line``, ``theory`` (broad and light), ``points``, ``rings`` (theory at single points), ``bars`` (a spectrum)
        or ``polar`` (x in degrees, clockwise from +y).
    of
        Of a theory: name of the one of the panel's curves that it belongs to, drawn in its colour.
    """

    panel: str
    name: str
    x: "Array"
    y: "Array"
    x_label: str
    y_label: str
    style: str = "line"
    of: str = ""

    @property
    def frame(self) -> "Frame":
        """Its points, a row each, under the labels of the axes."""
        from cycloid_mj.base.frame import Frame  # which takes NumPy, that no help page needs

        return Frame({self.x_label: self.x, self.y_label: self.y})

    @property
    def line(self) -> str:
        """Panel, name and axes."""
        return f"{self.panel}: {self.name}, {len(self.x)} points; {self.x_label}, {self.y_label}"

    def as_json(self) -> dict[str, Any]:
        """Convert the curve to JSON values: ``panel``, ``name``, ``x_label``, ``y_label``, points ``x``, ``y``."""
        x, y = self.x.tolist(), self.y.tolist()
        return {
            "panel": self.panel,
            "name": self.name,
            "x_label": self.x_label,
            "y_label": self.y_label,
            "x": x,
            "y": y,
        }


@dataclass(frozen=True, repr=False)
class Table(Presented):
    """A table of numbers, such as a map or a sensitivity study.

    Attributes
    ----------
    title
        What it shows.
    header
        Names of the columns, with units; the first column names the row.
    rows
        Texts and numbers, as many as there are columns.
    words
        Columns of prose, which are set flush left like the first.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str | float, ...], ...]
    words: Sequence[int] = ()

    @property
    def frame(self) -> "Frame":
        """Its rows, under the names of its columns."""
        from cycloid_mj.base.frame import make_frame  # which takes NumPy, that no help page needs

        return make_frame([dict(zip(self.header, row, strict=True)) for row in self.rows], self.header, {})

    @property
    def line(self) -> str:
        """Title and size of the table."""
        return f"{self.title}; {len(self.rows)} rows of {', '.join(self.header)}"

    @property
    def cells(self) -> list[list[str]]:
        """The rows as text, numbers with five digits, as shown on terminal, page and paper."""
        return [[cell if isinstance(cell, str) else four_digits(cell) for cell in row] for row in self.rows]

    def as_markdown(self) -> str:
        """Write header and rows as a table in Markdown."""
        lines = [self.header, ["---"] * len(self.header), *self.cells]
        return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)

    def as_json(self) -> dict[str, Any]:
        """Convert the table to JSON values: ``title``, ``columns`` (names) and ``rows`` (lists of cells)."""
        return {"title": self.title, "columns": list(self.header), "rows": [list(row) for row in self.rows]}


class Verdict(StrEnum):
    """Verdict on a published claim; its value is the word for people and programs."""

    AGREES = "agrees"
    DISAGREES = "disagrees"
    """No physical values of what the source leaves open produce it."""
    DEPENDS = "depends"
    """It is decided by something that the source leaves open at the claim's condition."""
    NOT_DETERMINED = "not determined"
    """The spread of independent starts exceeds the difference."""


@dataclass(frozen=True)
class Condition:
    """Condition of a figure: load, speed and solver.

    Attributes
    ----------
    load
        Torque against the output's rotation [N m]; 0 is no load.
    speed
        Speed of the crank [rad/s].
    input_torque
        Torque on the crank [N m], if the test prescribes it instead of the load.
    solver
        Solver of the runs that the figure is judged by, if it is named.
    temperature
        Temperatures of the parts in words; empty for 20 °C.
    friction_law, lubricant
        Friction law, if it is named, and the lubricant of film friction.
    """

    load: float
    speed: float
    input_torque: float | None = None
    solver: str = ""
    temperature: str = ""
    friction_law: str = ""
    lubricant: str = ""

    def __str__(self) -> str:
        """Format the condition in words, such as "36.68 N m, 1640 rpm"."""
        film = f"film friction, {self.lubricant}" if self.lubricant else ""
        return ", ".join(filter(None, (self.words, f"{self.speed_rpm:g} rpm", self.temperature, film)))

    @property
    def speed_rpm(self) -> float:
        """Speed of the crank [rpm], as a design file has it: without the rounding of the way to rad/s and back."""
        return round(self.speed * 30.0 / math.pi, 9)

    @property
    def words(self) -> str:
        """The load in words, for a row of a table."""
        return load_words(self.load) if self.input_torque is None else f"{self.input_torque:g} N m on the crank"

    def as_json(self) -> dict[str, float | str]:
        """Convert the condition to JSON values; keys end in their units, and values that are not set are omitted."""
        torque = {} if self.input_torque is None else {"input_torque_nm": self.input_torque}
        solver = {"solver": self.solver} if self.solver else {}
        named = ("temperature", "friction_law", "lubricant")
        words = {key: getattr(self, key) for key in named if getattr(self, key)}
        return {"load_nm": self.load, "speed_rpm": self.speed_rpm} | torque | solver | words


def load_words(load: float) -> str:
    """Name a load [N m]."""
    return f"{load:g} N m" if load else "no load"


@dataclass(frozen=True)
class Value:
    """A value as number and as text.

    Attributes
    ----------
    text
        As it is written for people.
    value, unit
        The number; None where there is none, as for a pattern.
    spread
        Lowest and highest of several starts, or as far as the numerical error of one run reaches, in the same unit.
    """

    text: str
    value: float | None = None
    unit: str = ""
    spread: tuple[float, float] | None = None

    def as_json(self) -> dict[str, Any]:
        """Convert the value to JSON values: ``value`` and ``spread`` (both ends, or None) in ``unit``, and ``text``."""
        spread = None if self.spread is None else list(self.spread)
        return {"value": self.value, "unit": self.unit, "spread": spread, "text": self.text}


@dataclass(frozen=True)
class Range:
    """Physical range of an input that the source leaves open, as far as it was searched.

    Attributes
    ----------
    name, unit
        The input, by its key in the design file where it has one.
    low, high
        Ends of the range, in `unit`.
    source
        Why the range is physical.
    """

    name: str
    low: float
    high: float
    unit: str
    source: str

    def as_json(self) -> dict[str, Any]:
        """Convert the range to JSON values, by the names of the attributes."""
        return dict(vars(self))


@dataclass(frozen=True)
class Removal:
    """A claim evaluated with one effect removed: the effect, our value and the verdict."""

    what: str
    ours: str
    verdict: Verdict

    def as_json(self) -> dict[str, str]:
        """Convert the removal to JSON values: ``taken_away`` (the effect), ``ours`` (our value) and ``verdict``."""
        return {"taken_away": self.what, "ours": self.ours, "verdict": str(self.verdict)}


@dataclass(frozen=True)
class Claim:
    """A published claim with its verdict.

    Attributes
    ----------
    key
        Its name for programs.
    figure, part, design
        Figure or section of the source, the part and the design that it speaks of; "both" where it compares them.
    condition
        Under what the source states it, and it is judged.
    claim, kind
        What is claimed, in our words, and whether that is a ``value``, a ``height``, an ``order`` or a ``pattern``.
    stated, ours
        Values of the source, and of this package under the same condition.
    error
        Numerical error of ours; its text is where the error comes from, as in "half the step".
    verdict, decided_by
        Whether they agree, and what decides it.
    rated
        Ours at the rated load, for information and never judged; None where the rated load is the condition.
    searched
        What the source leaves open, and the ranges in which it was searched for the claim.
    removals
        The same claim with one thing taken away or changed alone: what proves, or refutes, that it decides.
    p
        Chance of starts at least as different if the two designs were equal (p-value); None where no order is judged.
    """

    key: str
    figure: str
    part: str
    design: str
    condition: Condition
    claim: str
    kind: str
    stated: Value
    ours: Value
    error: Value
    verdict: Verdict
    decided_by: str
    rated: Value | None = None
    searched: tuple[Range, ...] = ()
    removals: tuple[Removal, ...] = ()
    p: float | None = None

    def as_json(self) -> dict[str, Any]:
        """Convert a claim of a paper, with our value for it, to JSON values.

        ``paper`` is the claim with the value that the paper states, ``ours`` our value with its ``numerical_error``,
        and ``at_rated_load`` our value at the rated load, or None. ``ranges_searched`` are the ranges of unpublished
        inputs in which agreement was searched. The other keys are names of attributes, such as ``verdict``.
        """
        return {
            "key": self.key,
            "figure": self.figure,
            "part": self.part,
            "design": self.design,
            "condition": self.condition.as_json(),
            "paper": {
                "claim": self.claim,
                "kind": self.kind,
                "value": self.stated.value,
                "unit": self.stated.unit,
                "text": self.stated.text,
            },
            "ours": self.ours.as_json(),
            "numerical_error": {"value": self.error.value, "unit": self.error.unit, "source": self.error.text},
            "verdict": self.verdict,
            "p": self.p,
            "decided_by": self.decided_by,
            "removals": [removal.as_json() for removal in self.removals],
            "ranges_searched": [searched_range.as_json() for searched_range in self.searched],
            "at_rated_load": None if self.rated is None else self.rated.as_json(),
        }
