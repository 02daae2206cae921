"""A figure: a number of a reducer, with its key, unit, definition and function."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from importlib import import_module
from typing import TYPE_CHECKING

from cycloid_mj.base.result import Quantity
from cycloid_mj.design.layouts import CENTRAL, Layout
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.figures.sampled import Sampled

Compute = Callable[[Reducer], float]
"""A function of a reducer that computes a number in the figure's unit; NaN where there is none."""


class Need(StrEnum):
    """Sources of figures, by increasing cost."""

    GEOMETRY = "geometry"
    """Dimensions and materials: milliseconds."""
    STATICS = "statics"
    """The equilibrium of the contacts over a turn of the crank: tenths of a second."""
    LIFE = "life"
    """The rating of every part for its life: about a second."""
    STRESS = "stress"
    """Finite elements of the parts: minutes."""
    RUN = "run"
    """A run in MuJoCo: minutes."""


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A row of the catalogue.

    Attributes
    ----------
    key
        Name for programs and flags; it ends in the unit.
    name, unit
        Name in words, and unit as printed: ``N m``, ``arcmin``, ``1`` of a number without a unit.
    definition
        Definition and condition, in a sentence.
    need
        What the figure is computed from.
    function
        The function that computes it; of an upper layer ``module:function``, which is imported when first used.
    sampled
        How it is computed for many samples of a reducer at a time; None if each sample is a design of its own.
    aliases
        Other keys of the figure in flags, JSON and CSV.
    deprecated
        Former keys, which are accepted with a warning.
    exists
        Returns whether a reducer of these layouts has the figure.
    layouts
        Layouts of reducers that have the figure.
    interval
        Computes the value together with its interval, where the figure may have one.
    """

    key: str
    name: str
    unit: str
    definition: str
    need: Need
    function: Compute | str
    sampled: "Sampled | None" = None
    aliases: tuple[str, ...] = ()
    deprecated: tuple[str, ...] = ()
    exists: Callable[[Reducer], bool] = lambda _: True
    layouts: tuple[Layout, ...] = CENTRAL
    interval: Callable[[Reducer], Quantity] | None = None

    def applies_to(self, reducer: Reducer) -> bool:
        """Return whether a reducer has the quantity, by its layout and by `exists`."""
        return reducer.LAYOUT in self.layouts and self.exists(reducer)

    def value(self, reducer: Reducer) -> float:
        """Compute the quantity of a sound reducer [`unit`], NaN if it has none; errors are those of the function."""
        return self._compute(reducer) if self.applies_to(reducer) else math.nan

    def quantity(self, reducer: Reducer) -> Quantity:
        """Compute the quantity with its name and unit, its definition as a note, and its interval if it has any."""
        quantity = Quantity(self.key, self.name, self.value(reducer), self.unit, note=self.definition)
        if self.interval is None or not self.applies_to(reducer):
            return quantity
        spread = self.interval(reducer)
        return replace(quantity, low=spread.low, high=spread.high, causes=spread.causes)

    @property
    def _compute(self) -> Compute:
        if not isinstance(self.function, str):
            return self.function
        module, _, name = self.function.partition(":")
        compute: Compute = getattr(import_module(module), name)
        return compute

    def as_json(self) -> dict[str, str | list[str]]:
        """Convert a quantity of the catalogue to JSON values: name, unit, definition, aliases, and ``need``.

        The key is not included. ``need`` is the kind of computation that the quantity requires (`Need`).
        """
        return {
            "name": self.name,
            "unit": self.unit,
            "definition": self.definition,
            "need": str(self.need),
            "aliases": list(self.aliases),
        }
