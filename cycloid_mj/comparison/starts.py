"""Independent starts of an idle reducer, and what a quantity spreads over them.

The idle motion is chaotic: turns of one run depend on each other, so that no turn more makes its rms values sure. What
is said of no load is said of several starts.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer

STARTS = 8
"""Independent starts over which an idle quantity is given, and from which on two designs are ranked by it."""

ALIKE = 1.05
"""Ratio within which two quantities have no order: what the time step alone may change."""


@dataclass(frozen=True)
class StartSpread:
    """One quantity of several independent starts: its `values`."""

    values: tuple[float, ...]

    @classmethod
    def of(cls, values: Iterable[float]) -> "StartSpread":
        """Collect the values."""
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
        """Convert values, least, mean and largest to JSON values."""
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
        """Number of different values: starts that agree to the last bit are copies of one."""
        return len(set(self.values))

    def over(self, other: "StartSpread") -> "StartSpread":
        """Return the ratio to another quantity: of the means, and the least and most that starts of both make."""
        pairs = ((self.mean, other.mean), (self.low, other.high), (self.high, other.low))
        return StartSpread(tuple(one / below if below else math.inf for one, below in pairs))


def order(start_spread: StartSpread, other: StartSpread) -> int:
    """Say which of two quantities is larger: 1 the first, -1 the second, 0 where their starts overlap.

    Where all starts of the one lie beyond all of the other, by more than `ALIKE`, the difference of the two exceeds
    what the starts spread.
    """
    if start_spread.low > ALIKE * other.high:
        return 1
    return -1 if other.low > ALIKE * start_spread.high else 0


def started(reducer: Reducer, number: int, of: int = STARTS) -> Design:
    """Vary a design into one of several independent starts, the first as it is.

    Gravity is turned by a whole number of tooth pitches: the same as to let the crank begin elsewhere in its turn, at
    the same phase of the mesh. A ring of fewer teeth than there are starts has gravity turned by equal parts of a turn.
    """
    design = reducer.design
    teeth, pull = design.ring.teeth, design.environment
    turn = 2 * math.pi * round(teeth * number / of) / teeth if teeth >= of else 2 * math.pi * number / of
    if turn == 0.0:
        return design
    cos, sin = math.cos(turn), math.sin(turn)
    x, y = cos * pull.gravity_x - sin * pull.gravity_y, sin * pull.gravity_x + cos * pull.gravity_y
    return reducer.but(environment={"gravity_x": x, "gravity_y": y}).design


def all_started(reducer: Reducer, count: int = STARTS) -> tuple[Design, ...]:
    """List so many independent starts of a design; a single one where no gravity acts in its plane."""
    return tuple(dict.fromkeys(started(reducer, number, count) for number in range(count)))


def gravity_turn(reducer: Reducer) -> float:
    """Compute the angle [rad] by which the gravity of a start is turned, counter-clockwise from -y, in [0, 2 pi)."""
    pull = reducer.design.environment
    return math.atan2(pull.gravity_x, -pull.gravity_y) % (2 * math.pi)
