"""How far a rate moves with the inputs that are assumed: each varied alone, over the range that it may have.

A numerical error says how well a model is solved; where its inputs are assumptions, it is no error of the rate.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from cycloid_mj.base.result import Table
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer

PLAY = (0.5, 2.0)
"""Factors on a clearance: what a drawing says against what a gauge finds."""
MOST_PLAY = 1e-3
"""Largest clearance that a design may have [m]."""
CAM_PLAY = (0.1, 2.0)
"""The same on the cam's, down to a bearing next to preload."""
CAM_STIFFNESS = (0.5, 4.0)
"""Factors on the cam's stiffness: a row of few rollers, and about that of a plain journal without play."""
TEETH = (0.02, 0.1)
"""Friction of lubricated hardened steel on steel, from a full film to boundary lubrication (assumed)."""
BEARING = (0.001, 0.003)
"""Friction of rolling bearings: cylindrical rollers 0.0008 to 0.0012, needles with a cage 0.0020 to 0.0030 (JTEKT)."""
CREEP, DAMPING = (0.001, 0.02), (0.1, 0.5)
"""What only regularises the contacts: creep speed [m/s] and damping as a share of critical."""


PERIODS = 4
"""Fewest mesh periods of a run with an input varied."""


@dataclass(frozen=True)
class Input:
    """One input at the ends of its range: the values there, in `unit`, and the designs with them.

    `table` of the design is what it is in, `low_values` and `high_values` are the values there [SI], by their keys.
    """

    name: str
    unit: str
    low: float
    high: float
    table: str
    low_values: Mapping[str, float]
    high_values: Mapping[str, float]
    low_design: Design
    high_design: Design

    @property
    def ends(self) -> tuple[Design, Design]:
        """The designs at both ends."""
        return self.low_design, self.high_design

    @property
    def names(self) -> dict[Design, str]:
        """What the designs at both ends are called: the input and its value there."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return {
            self.low_design: f"{self.name} {self.low:.3g}{unit}",
            self.high_design: f"{self.name} {self.high:.3g}{unit}",
        }

    def between(self, share: float) -> dict[str, float]:
        """Return the values [SI] by their keys, at a share between 0 and 1 of the range of their logarithms."""
        return {key: low ** (1.0 - share) * self.high_values[key] ** share for key, low in self.low_values.items()}


@dataclass(frozen=True)
class Moved:
    """What a rate becomes at the ends of an input's range [1]."""

    input: Input
    value_low: float
    value_high: float


def inputs(reducer: Reducer) -> list[Input]:
    """List the assumed inputs that a design's rate rests on."""
    design = reducer.design
    seats = [kind for kind in design.pair_kinds if kind not in ("cam", "output")]
    stiffness = reducer.contacts["cam"].stiffness
    return [
        _play(reducer, "mesh play", seats, PLAY),
        _play(reducer, "cam play", ["cam"], CAM_PLAY),
        _input(reducer, "cam stiffness", "N/m", "stiffness", ["cam"], [share * stiffness for share in CAM_STIFFNESS]),
        _input(reducer, "friction of the teeth", "1", "friction", seats, TEETH),
        _bearing(reducer, "cam", design.gear.bearing == "rolling", BEARING),
        _bearing(reducer, "output", design.output.has_needles, (BEARING[0], plain_roller(reducer))),
        _input(reducer, "creep speed", "mm/s", "contact", ["creep_speed"], CREEP, 1e3),
        _input(reducer, "contact damping", "of critical", "contact", ["damping_ratio"], DAMPING),
    ]


def slow_ends(varied: Sequence[Input]) -> set[Design]:
    """Collect the ends of the creep speed's own range, which is there to show what friction lacks below it."""
    return {end for one in varied if "creep_speed" in one.low_values for end in one.ends}


def moved(varied: Sequence[Input], rates: Mapping[Any, float]) -> tuple[Moved, ...]:
    """Put the rates [1] of the designs at both ends of every input's range beside it; `rates` holds them by design."""
    return tuple(Moved(one, *(rates[end] for end in one.ends)) for one in varied)


def plain_roller(reducer: Reducer) -> float:
    """Compute the friction at the rim of a roller that is a plain sleeve sliding on its core, as a ring sleeve does."""
    design = reducer.design
    return design.friction.pin_sleeve * design.output.root_radius / design.output.pin_radius


def table(rate: str, base: float, moved: Sequence[Moved]) -> Table:
    """Tabulate the spread of a rate, by name, about the design's own [1] in percent."""
    rows = [
        (one.input.name, one.input.unit, one.input.low, one.input.high, 1e2 * one.value_low, 1e2 * one.value_high)
        for one in moved
    ]
    low, high = spread(base, moved)
    return Table(
        f"{rate} by assumed inputs, one at a time: {1e2 * low:.1f} to {1e2 * high:.1f} %",
        ("input", "unit", "low", "high", "at low [%]", "at high [%]"),
        tuple(rows),
    )


def spread_text(base: float, moved: Sequence[Moved]) -> str:
    """Tell the spread of a rate beside its numerical error."""
    low, high = spread(base, moved)
    widest = max(moved, key=lambda one: abs(one.value_high - one.value_low)).input.name
    return f"by its assumed inputs, one at a time, {1e2 * low:.1f} to {1e2 * high:.1f} %, the widest by {widest}"


def spread(base: float, moved: Sequence[Moved]) -> tuple[float, float]:
    """Compute the least and the largest of a rate over all inputs [1]."""
    values = [base, *(value for one in moved for value in (one.value_low, one.value_high))]
    return min(values), max(values)


def as_json(base: float, moved: Sequence[Moved]) -> dict[str, Any]:
    """Convert the spread to JSON values."""
    low, high = spread(base, moved)
    return {
        "sensitivity": [
            {
                "input": one.input.name,
                "unit": one.input.unit,
                "low": one.input.low,
                "high": one.input.high,
                "value_low": one.value_low,
                "value_high": one.value_high,
            }
            for one in moved
        ],
        "spread": {"value": base, "low": low, "high": high},
    }


def _input(
    reducer: Reducer, name: str, unit: str, table: str, keys: Sequence[str], ends: Sequence[float], scale: float = 1.0
) -> Input:
    """Return an input that sets values of a table of the design, all alike, to either end; `scale` makes the unit."""
    low, high = (dict.fromkeys(keys, end) for end in ends)
    return _between(reducer, name, unit, (scale * ends[0], scale * ends[1]), table, low, high)


def _play(reducer: Reducer, name: str, kinds: Sequence[str], factors: Sequence[float]) -> Input:
    """Return the plays of pairs in series, which add up."""
    low, high = (
        {kind: min(factor * getattr(reducer.design.clearance, kind), MOST_PLAY) for kind in kinds} for factor in factors
    )
    least, most = (sum(1e6 * play for play in end.values()) for end in (low, high))
    return _between(reducer, name, "um", (least, most), "clearance", low, high)


def _between(
    reducer: Reducer,
    name: str,
    unit: str,
    ends: tuple[float, float],
    table: str,
    low: Mapping[str, float],
    high: Mapping[str, float],
) -> Input:
    """Return an input with the designs that have these values of a table."""
    designs = [reducer.but(**{table: values}).design for values in (low, high)]
    return Input(name, unit, *ends, table, low, high, *designs)


def _bearing(reducer: Reducer, kind: str, rolls: bool, rolling: tuple[float, float]) -> Input:
    """Return the friction of cam or output pins: of a bearing, or of what slides."""
    name, key, ends = ("'s rollers", f"{kind}_rolling", rolling) if rolls else (", sliding", kind, TEETH)
    return _input(reducer, f"friction of the {kind}{name}", "1", "friction", [key], ends)
