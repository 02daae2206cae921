"""Independent starts of an idle reducer, and the spread of a quantity over them.

The idle motion is chaotic, and the turns of one run are correlated, so a longer run does not yield reliable rms values.
Figures at no load therefore come from several starts.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer

STARTS = 8
"""Number of independent starts, which is also the smallest number by which two designs are ranked (heuristic)."""

ORDER_MARGIN = 1.05
"""Ratio of two quantities up to which they have no order (heuristic): the time step alone may cause as much."""


@dataclass(frozen=True)
class StartSpread:
    """Values of a quantity at several independent starts."""

    values: tuple[float, ...]

    @classmethod
    def of(cls, values: Iterable[float]) -> "StartSpread":
        """Create the spread from the values of all starts."""
        return cls(tuple(float(value) for value in values))

    @property
    def mean(self) -> float:
        """Mean over the starts."""
        return sum(self.values) / len(self.values)

    @property
    def low(self) -> float:
        """Lowest of the starts."""
        return min(self.values)

    @property
    def high(self) -> float:
        """Highest of the starts."""
        return max(self.values)

    def as_json(self) -> dict[str, Any]:
        """Convert the values of all starts, and their minimum, mean and maximum, to JSON values in the same unit."""
        return {"values": list(self.values), "least": self.low, "mean": self.mean, "largest": self.high}

    @property
    def words(self) -> str:
        """The range as text."""
        return f"{self.low:.3g} to {self.high:.3g}"

    @property
    def half(self) -> float:
        """Half of the range."""
        return (self.high - self.low) / 2.0

    @property
    def independent(self) -> int:
        """Number of different values: starts with identical bits are copies of one start."""
        return len(set(self.values))

    def over(self, other: "StartSpread") -> "StartSpread":
        """Return the ratio to another quantity: of the means, and the smallest and largest of any two starts."""
        pairs = ((self.mean, other.mean), (self.low, other.high), (self.high, other.low))
        return StartSpread(
            tuple(numerator / denominator if denominator else math.inf for numerator, denominator in pairs)
        )


def compare_order(spread: StartSpread, other: StartSpread) -> int:
    """Return which of two positive quantities is larger: 1 the first, -1 the other, 0 if this is not certain.

    `spread` and `other` have the values of the quantities in independent runs (starts). A quantity is larger if each of
    its values exceeds all values of the other quantity by more than the factor `ORDER_MARGIN`.
    """
    if spread.low > ORDER_MARGIN * other.high:
        return 1
    return -1 if other.low > ORDER_MARGIN * spread.high else 0


def start_variant(reducer: Reducer, index: int, count: int = STARTS) -> Design:
    """Return a copy of a design with rotated gravity, one of `count` independent starts; index 0 is the design itself.

    Gravity is rotated by an integer number of tooth pitches, which is equivalent to another initial crank angle at the
    same phase of the mesh. If the ring has fewer teeth than `count`, gravity is rotated by equal parts of a turn.
    Without gravity in the plane of the discs, all starts are equal.
    """
    design = reducer.design
    ring_teeth, environment = design.ring.teeth, design.environment
    rotation = (
        2 * math.pi * round(ring_teeth * index / count) / ring_teeth
        if ring_teeth >= count
        else 2 * math.pi * index / count
    )
    if rotation == 0.0:
        return design
    cos, sin = math.cos(rotation), math.sin(rotation)
    x, y = (
        cos * environment.gravity_x - sin * environment.gravity_y,
        sin * environment.gravity_x + cos * environment.gravity_y,
    )
    return reducer.but(environment={"gravity_x": x, "gravity_y": y}).design


def independent_starts(reducer: Reducer, count: int = STARTS) -> tuple[Design, ...]:
    """List `count` independent starts of a design; only one where no gravity acts in its plane."""
    return tuple(dict.fromkeys(start_variant(reducer, index, count) for index in range(count)))


def gravity_turn(reducer: Reducer) -> float:
    """Compute the rotation of a start's gravity from -y, counter-clockwise [rad], in [0, 2 pi)."""
    pull = reducer.design.environment
    return math.atan2(pull.gravity_x, -pull.gravity_y) % (2 * math.pi)
