"""The results of a command as one record, which one delivery turns into terminal, JSON, page and files."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import TYPE_CHECKING, Any

from cycloid_mj.base.result import Quantity, Table
from cycloid_mj.base.text import four_digits

if TYPE_CHECKING:
    from cycloid_mj.base.frame import Frame

Picture = Callable[[str], bytes]
"""Draws a picture in a format, such as ``svg``, as the bytes of a file."""

MOST_FIGURES = 12
"""Figures of a headline."""


def headline(quantities: Iterable[Quantity]) -> dict[str, str]:
    """Write the first dozen quantities: name -> value with its unit."""
    return {item.name: _format_quantity(item) for item in islice(quantities, MOST_FIGURES)}


def _format_quantity(quantity: Quantity) -> str:
    if math.isnan(quantity.value):
        return "-"
    unit = "" if quantity.unit == "1" else f" {quantity.unit}"
    if quantity.low is not None:
        return f"{quantity.value:.4g} ({quantity.low:.4g} to {quantity.high:.4g}){unit}"
    return f"{four_digits(quantity.value)}{unit}"


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Result of a command, for people and for programs.

    Attributes
    ----------
    title, condition
        What was computed, of which design; under what it holds.
    text
        What the terminal shows in place of these: paths of written files, a design file, a list, line by line.
    headline
        The figures that one looks for first, a dozen at most: name -> value with its unit, or the values of several
        columns.
    headline_columns
        Headings of these columns; none where each figure has one value.
    failures, warnings, passes
        What does not hold, what to know before trusting the figures, and what holds, a sentence each.
    summary
        Closing sentences.
    tables
        All figures, for people.
    frame
        All figures, for programs: the CSV file.
    notes
        What the figures stand on, a sentence each.
    pictures, formats
        By the names of their files, and the formats that they are written in.
    captions
        What pictures show, by their names, for the page.
    files
        Other files, by name.
    result, filed
        The JSON object, and whether it becomes a file as well.
    page
        Renders a page of its own, instead of the one that shows headline, pictures, tables and notes.
    code
        Exit code.
    """

    title: str
    condition: str = ""
    text: Sequence[str] | None = None
    headline: Mapping[str, str | Sequence[str]] = field(default_factory=dict)
    headline_columns: Sequence[str] = ()
    failures: Sequence[str] = ()
    warnings: Sequence[str] = ()
    passes: Sequence[str] = ()
    summary: Sequence[str] = ()
    tables: Sequence[Table] = ()
    frame: "Frame | None" = None
    notes: Sequence[str] = ()
    pictures: Mapping[str, Picture] = field(default_factory=dict)
    formats: Sequence[str] = ("png", "svg")
    captions: Mapping[str, str] = field(default_factory=dict)
    files: Mapping[str, bytes] = field(default_factory=dict)
    result: Mapping[str, Any]
    filed: bool = True
    page: Callable[[], str] | None = None
    code: int = 0

    @property
    def headline_table(self) -> Table:
        """The headline as a table without a title."""
        rows = ((name, *([cells] if isinstance(cells, str) else cells)) for name, cells in self.headline.items())
        return Table("", ("figure", *(self.headline_columns or ("value",))), tuple(rows))

    def __post_init__(self) -> None:
        """Refuse a headline with too many figures."""
        if len(self.headline) > MOST_FIGURES:
            raise ValueError(f"a headline has at most {MOST_FIGURES} figures, but {len(self.headline)} are given")
