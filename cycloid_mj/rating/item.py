"""The result of a rating: one item for each thing that can fail, the weakest first."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cycloid_mj.result import Table, plain


@dataclass(frozen=True)
class Item:
    """One thing that can fail.

    Attributes
    ----------
    key, name
        For programs, and in words.
    value, limit, unit
        What acts, and what is borne.
    safety
        Limit over value as its law counts it; None where a life stands instead.
    life
        Hours until it fails, by its law; None where a safety stands instead.
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
        """Give how far it is from failing: its safety, or its life over a required one [h]; 1 is just enough."""
        return self.safety if self.safety is not None else (self.life or 0.0) / life


@dataclass(frozen=True)
class Rating:
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
    """

    design: str
    duty: str
    life: float
    items: Mapping[str, Item]
    assumptions: tuple[str, ...]

    @property
    def weakest(self) -> Item:
        """The item nearest to failing."""
        return next(iter(self.items.values()))

    def table(self) -> Table:
        """Give the items as a table of text."""
        header = ("item", "acts", "borne", "unit", "safety", "life [h]", "by")
        rows = tuple(
            (
                item.name,
                f"{item.value:.4g}",
                f"{item.limit:.4g}",
                item.unit,
                "" if item.safety is None else f"{item.safety:.3g}",
                "" if item.life is None else f"{item.life:.4g}" if math.isfinite(item.life) else "endless",
                item.source,
            )
            for item in self.items.values()
        )
        return Table(f"rating: {self.design}, {self.duty}", header, rows)

    def as_json(self) -> dict[str, Any]:
        """Give the rating for a program."""
        items = {
            item.key: {
                "name": item.name,
                "value": item.value,
                "unit": item.unit,
                "limit": item.limit,
                "safety": item.safety,
                "life_h": item.life,
                "source": item.source,
                "note": item.note,
            }
            for item in self.items.values()
        }
        found = {
            "design": self.design,
            "condition": self.duty,
            "required_life_h": self.life,
            "weakest": self.weakest.key,
            "items": items,
            "assumptions": list(self.assumptions),
        }
        return dict(plain(found))
