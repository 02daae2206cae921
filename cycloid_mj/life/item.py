"""The result of a rating: one item for each thing that can fail, the weakest first."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cycloid_mj.base.frame import Frame, framed
from cycloid_mj.base.judgement import Judgement, judge
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.result import Table, plain
from cycloid_mj.life.bearing_compliance import CamGive
from cycloid_mj.life.duration import LONGEST, hours, plain_life, written

INDICATIVE = ("_wear",)
"""How the keys of items end that only warn: the coefficient of wear is known to within a factor of ten."""


@dataclass(frozen=True)
class RatedItem:
    """One thing that can fail, or a figure that a designer asks for beside it.

    Attributes
    ----------
    key, name
        For programs, and in words.
    value, limit, unit
        What acts, and what is borne: not a number where there is no standard limit.
    safety
        Limit over value as its law counts it; None where a life stands instead.
    life
        Hours until it fails, by its law; None where a safety stands instead. Neither stands beside a mere figure.
    source
        Formula and where it is from.
    note
        What is assumed.
    """

    key: str
    name: str
    value: float
    limit: float
    unit: str
    safety: float | None
    life: float | None
    source: str
    note: str = ""

    def margin(self, life: float) -> float:
        """Compute how far it is from failing: its safety, or its life over a required one [h]; 1 is just enough."""
        if self.safety is not None:
            return self.safety
        return math.inf if self.life is None else self.life / life

    def as_json(self) -> dict[str, Any]:
        """Convert the item to JSON values, which has its key beside it; what has no limit is None there.

        `unlimited` tells a life of more than `LONGEST` hours, or a safety without end, from what has none.
        """
        return {
            "name": self.name,
            "value": self.value,
            "unit": self.unit,
            "limit": self.limit,
            "safety": self.safety,
            "life_h": plain_life(self.life),
            "unlimited": self.unlimited,
            "source": self.source,
            "note": self.note,
        }

    @property
    def decisive(self) -> bool:
        """Whether the item decides what a drive is rated for: neither a mere figure nor wear."""
        return not (self.safety is None and self.life is None) and not self.key.endswith(INDICATIVE)

    def judgement(self, life: float) -> Judgement:
        """Judge the item for a required life [h]; wear only warns, and a mere figure has no judgement."""
        figure = self.safety is None and self.life is None
        return judge(None if figure else self.margin(life), self.decisive)

    @property
    def load(self) -> str:
        """What acts, with its unit."""
        return f"{written(self.value)} {self.unit}"

    @property
    def borne(self) -> str:
        """What is borne, with its unit; nothing where there is no standard limit."""
        return "" if math.isnan(self.limit) else f"{written(self.limit)} {self.unit}"

    @property
    def verdict(self) -> str:
        """Its safety, or its hours, in words; nothing for a mere figure."""
        if self.unlimited:
            return "unlimited"
        if self.safety is not None:
            return f"{self.safety:.3g}"
        return "" if self.life is None else hours(self.life)

    @property
    def unlimited(self) -> bool:
        """Whether its safety has no end, or its life more hours than `LONGEST`."""
        if self.safety is not None:
            return math.isinf(self.safety)
        return self.life is not None and self.life > LONGEST


@dataclass(frozen=True, repr=False)
class Rating(Presented):
    """Items of one design under one duty.

    Attributes
    ----------
    design
        Its name.
    duty
        In words.
    life
        That is asked for [h].
    items
        Key -> item, the weakest first.
    assumptions
        What stands behind all of them, a sentence each.
    cam_give
        What the cam carries over the give of its bearing, where that was asked for.
    work
        The most that a point of the duty took, see `Loading`.
    """

    design: str
    duty: str
    life: float
    items: Mapping[str, RatedItem]
    assumptions: tuple[str, ...]
    cam_give: CamGive | None = None
    work: float = 0.0

    @property
    def weakest(self) -> RatedItem:
        """The decisive item nearest to failing."""
        return next(item for item in self.items.values() if item.decisive)

    @property
    def failing(self) -> list[RatedItem]:
        """The items whose safety is below 1, or whose life is below the required one; the weakest first."""
        return self._judged(Judgement.FAILED)

    @property
    def warnings(self) -> list[RatedItem]:
        """The same of the items that only warn: wear."""
        return self._judged(Judgement.WARNING)

    def _judged(self, judgement: Judgement) -> list[RatedItem]:
        return [item for item in self.items.values() if item.judgement(self.life) is judgement]

    @property
    def frame(self) -> Frame:
        """The items, a row each."""
        rows = [{"key": key, **item} for key, item in self._items_json().items()]
        return framed(rows, rows[0], {})

    def _items_json(self) -> dict[str, dict[str, Any]]:
        return {key: {**item.as_json(), "judgement": item.judgement(self.life)} for key, item in self.items.items()}

    @property
    def line(self) -> str:
        """Design, and its weakest item."""
        return f"{self.design}; {self.weakest_line()}"

    def line_of(self, item: RatedItem) -> str:
        """Format an item in one line."""
        what = "safety " + item.verdict if item.safety is not None else f"{item.verdict} of {self.life:g} h asked for"
        return f"{item.name}: {what}"

    def weakest_line(self) -> str:
        """Format the weakest item in one line."""
        return f"{self.line_of(self.weakest)} at {self.duty}"

    def table(self) -> Table:
        """Tabulate the items as text."""
        header = ("item", "load", "limit", "safety or hours", "formula and source", "assumption")
        rows = tuple(
            (item.name, item.load, item.borne, item.verdict, item.source, item.note) for item in self.items.values()
        )
        return Table(f"rating: {self.design}, {self.duty}, for {self.life:g} h", header, rows, words=(4, 5))

    def as_json(self) -> dict[str, Any]:
        """Convert the rating to JSON values."""
        content = {
            "design": self.design,
            "condition": self.duty,
            "required_life_h": self.life,
            "weakest": self.weakest.key,
            "items": self._items_json(),
            "assumptions": list(self.assumptions),
            **({"cam_give": self.cam_give} if self.cam_give else {}),
        }
        return dict(plain(content))
