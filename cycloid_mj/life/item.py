"""The result of a rating: an item for each failure mode, the weakest first."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from cycloid_mj.base.frame import Frame, make_frame
from cycloid_mj.base.judgement import Judgement, judge
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.result import Table, to_json_values
from cycloid_mj.life.bearing_compliance import CamCompliance
from cycloid_mj.life.duration import MAX_LIFE, finite_life, format_life, format_number

INDICATIVE = ("_wear", "jam_difference", "thermal_torque")
"""Endings of the keys of items that only warn: the coefficient of wear is known to within a factor of ten, and the
conductances between warm parts are assumed."""


class ItemKind(StrEnum):
    """The group of a rated item."""

    BEARING = "bearing"
    SURFACE = "surface"
    STRENGTH = "strength"
    WEAR = "wear"
    HEAT = "heat"
    STOP = "stop"
    JOINT = "joint"


@dataclass(frozen=True)
class RatedItem:
    """A failure mode of a part with its safety or life, or a figure without a limit.

    Attributes
    ----------
    key, name
        Key for programs, and name.
    value, limit, unit
        Load and limit; the limit is NaN where no standard states one.
    safety
        Safety factor, limit over load by the law of the item; None where it has a life.
    life
        Hours until it fails; None where it has a safety factor. A figure without a limit has neither.
    source
        Formula and its source.
    note
        What is assumed.
    kind
        Its group, which the rating sets.
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
    kind: ItemKind = ItemKind.STRENGTH

    def margin(self, required_life: float) -> float:
        """Return the safety factor of a rated part, or the ratio of its life to `required_life` [h]; inf without limit.

        The part is sufficient if this margin [1] is at least 1.
        """
        if self.safety is not None:
            return self.safety
        return math.inf if self.life is None else self.life / required_life

    def as_json(self) -> dict[str, Any]:
        """Convert the rating of a part for one kind of failure to JSON values: load, limit, safety factor or life.

        Keys are ``name``, ``kind``, ``value`` (the load) with its ``unit`` and ``limit``, ``safety``, ``life_h``,
        ``unlimited``, ``source`` and ``note``. ``unlimited`` distinguishes a life of more than `MAX_LIFE` hours, or an
        infinite safety factor, from no life at all.
        """
        return {
            "name": self.name,
            "kind": self.kind,
            "value": self.value,
            "unit": self.unit,
            "limit": self.limit,
            "safety": self.safety,
            "life_h": finite_life(self.life),
            "unlimited": self.is_unlimited,
            "source": self.source,
            "note": self.note,
        }

    @property
    def decisive(self) -> bool:
        """Return whether the item limits the rated torque: neither a quantity without a limit nor wear does."""
        return not (self.safety is None and self.life is None) and not self.key.endswith(INDICATIVE)

    def judgement(self, required_life: float) -> Judgement:
        """Return whether a part passes, fails or causes a warning, for a required life [h].

        A margin below 1 is a failure, or a warning if the item is not `decisive` (such as wear). Without a limit, the
        judgement is `Judgement.NOT_APPLICABLE`.
        """
        has_no_limit = self.safety is None and self.life is None
        return judge(None if has_no_limit else self.margin(required_life), self.decisive)

    @property
    def load_text(self) -> str:
        """The load with its unit."""
        return f"{format_number(self.value)} {self.unit}"

    @property
    def limit_text(self) -> str:
        """The limit with its unit; empty where no standard states one."""
        return "" if math.isnan(self.limit) else f"{format_number(self.limit)} {self.unit}"

    @property
    def verdict(self) -> str:
        """Safety factor or life as text; empty for a quantity without a limit."""
        if self.is_unlimited:
            return "unlimited"
        if self.safety is not None:
            return f"{self.safety:.3g}"
        return "" if self.life is None else format_life(self.life)

    @property
    def is_unlimited(self) -> bool:
        """True if the safety factor is infinite, or the life longer than `MAX_LIFE`."""
        if self.safety is not None:
            return math.isinf(self.safety)
        return self.life is not None and self.life > MAX_LIFE


def torque_item(key: str, name: str, torque: float, torque_limit: float, source: str, note: str) -> RatedItem:
    """Return the rated item of a torque against its limit, both [N m]."""
    return RatedItem(
        key, name, torque, torque_limit, "N m", torque_limit / torque if torque else math.inf, None, source, note
    )


def sort_by_margin(items: Iterable[RatedItem], required_life: float) -> dict[str, RatedItem]:
    """Return items by their keys, the weakest first: by margin at a required life [h] (`RatedItem.margin`)."""
    return {item.key: item for item in sorted(items, key=lambda item: item.margin(required_life))}


@dataclass(frozen=True, repr=False)
class Rating(Presented):
    """The rating of a design for a duty cycle.

    Attributes
    ----------
    design
        Name of the design.
    duty
        The duty cycle in words.
    life
        Required life [h].
    items
        Key -> item, the weakest first.
    assumptions
        Assumptions of all items, a sentence each.
    cam_compliance
        Cam load over the stiffness of its bearing, if requested.
    work
        Largest numerical work of a point of the duty, see `Loading`.
    parts
        The parts that were rated: perfect, with the errors of the design, or toleranced.
    """

    design: str
    duty: str
    life: float
    items: Mapping[str, RatedItem]
    assumptions: tuple[str, ...]
    cam_compliance: CamCompliance | None = None
    work: float = 0.0
    parts: str = "perfect"

    @property
    def weakest(self) -> RatedItem:
        """The decisive item nearest to failing."""
        return next(item for item in self.items.values() if item.decisive)

    @property
    def shortest_life(self) -> float:
        """Shortest life of the decisive items [h], wear excluded; infinite if none has a life."""
        lives = (item.life for item in self.items.values() if item.decisive)
        return min((life for life in lives if life is not None), default=math.inf)

    @property
    def failing(self) -> list[RatedItem]:
        """The items with a safety factor below 1 or a life below the required one; the weakest first."""
        return self._with_judgement(Judgement.FAILED)

    @property
    def warnings(self) -> list[RatedItem]:
        """The same for items that only warn: wear."""
        return self._with_judgement(Judgement.WARNING)

    def _with_judgement(self, judgement: Judgement) -> list[RatedItem]:
        return [item for item in self.items.values() if item.judgement(self.life) is judgement]

    @property
    def frame(self) -> Frame:
        """The items, a row each."""
        rows = [{"key": key, **item} for key, item in self._items_json().items()]
        return make_frame(rows, rows[0], {})

    def _items_json(self) -> dict[str, dict[str, Any]]:
        """Convert the items to JSON values with their judgements and the parts that were rated, by key."""
        return {
            key: {**item.as_json(), "judgement": item.judgement(self.life), "parts": self.parts}
            for key, item in self.items.items()
        }

    @property
    def line(self) -> str:
        """The design and its weakest item."""
        return f"{self.design}; {self.weakest_line()}"

    def line_of(self, item: RatedItem) -> str:
        """Format an item in one line: its name, and its safety factor or its life next to the required one."""
        margin_text = (
            "safety " + item.verdict if item.safety is not None else f"{item.verdict} of the required {self.life:g} h"
        )
        return f"{item.name}: {margin_text}"

    def weakest_line(self) -> str:
        """Format the weakest item in one line."""
        return f"{self.line_of(self.weakest)} at {self.duty}"

    def table(self) -> Table:
        """Return a table with a row for each rated part and kind of failure: load, limit, safety or life, source."""
        header = ("item", "load", "limit", "safety or life", "parts", "formula and source", "assumptions")
        rows = tuple(
            (item.name, item.load_text, item.limit_text, item.verdict, self.parts, item.source, item.note)
            for item in self.items.values()
        )
        return Table(f"rating: {self.design}, {self.duty}, for {self.life:g} h", header, rows, words=(5, 6))

    def as_json(self) -> dict[str, Any]:
        """Convert the rating of a drive to JSON values.

        Keys are ``design`` (its name), ``condition`` (the duty in words), ``required_life_h`` [h], ``parts`` (their
        condition, such as "perfect"), ``weakest`` (key of the weakest item), ``items`` (a dict for each part and kind
        of failure) and ``assumptions`` (sentences). If it was requested, ``cam_give`` lists stiffness [N/m], load [N]
        and life [h] of the cam bearing for several stiffnesses (`CamCase.as_json`).
        """
        content = {
            "design": self.design,
            "condition": self.duty,
            "required_life_h": self.life,
            "parts": self.parts,
            "weakest": self.weakest.key,
            "items": self._items_json(),
            "assumptions": list(self.assumptions),
            **({"cam_give": self.cam_compliance} if self.cam_compliance else {}),
        }
        return dict(to_json_values(content))
