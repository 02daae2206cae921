"""Sensitivity of the output rate to the friction of each pair, with free, fixed and sleeved pins."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.base.result import Curve, Table
from cycloid_mj.design import Design
from cycloid_mj.measure.published import Published
from cycloid_mj.measure.steady import steady_design
from cycloid_mj.reducer import Reducer

ROLLING = (0.0, 0.003)
"""Coefficients of a rolling bearing: none, and the largest of caged needles (JTEKT)."""
COMMON = (0.0, 0.02, 0.05, 0.1)
"""Common coefficients of all sliding pairs, between which the friction of a rate is interpolated."""
EVERY, OWN, NONE = "all sliding", "as designed", "none"
PERIODS = 8
"""Mesh periods of a row at least."""


@dataclass(frozen=True)
class FrictionVariant:
    """A row: support of the ring's pins, the pair whose friction is set, its coefficient [1], and the design."""

    pins: str
    pair: str
    friction: float
    design: Design

    @property
    def name(self) -> str:
        """Name of its run."""
        held = "" if self.pins == NONE else f", {self.pins} pins"
        return f"friction as designed{held}" if self.pair == OWN else f"friction {self.friction:g} of {self.pair}{held}"


def variations(reducer: Reducer, quick: bool = False) -> list[FrictionVariant]:
    """List the rows of a design's table: its friction, then each pair on its own, then all together."""
    kinds = [steady_design(kind) for kind in ring_kinds(reducer)[: 1 if quick else None]]
    rows = [row for kind in kinds for row in _of_ring(kind, quick)]
    return rows if quick else [*rows, *_of_bearings(kinds[0])]


def ring_kinds(reducer: Reducer) -> list[Reducer]:
    """List the design, and its variants with the other supports of the ring's pins."""
    if reducer.design.ring.kind == "nonpin":
        return [reducer]
    others = [pins for pins in ("free", "fixed", "sleeved") if pins != reducer.design.ring.pins]
    return [reducer, *(reducer.but(ring={"pins": pins}) for pins in others)]


def pins_of(reducer: Reducer) -> str:
    """Return the support of the ring's pins: free, fixed, sleeved, or `NONE` for an internal gear."""
    return NONE if reducer.design.ring.kind == "nonpin" else f"{reducer.design.ring.pins}"


def sliding_pairs(reducer: Reducer) -> list[str]:
    """List the kinds of sliding pairs."""
    design = reducer.design
    ring = design.ring
    pairs = [design.tooth_pair, *["pin_socket"] * ring.has_sockets, *["pin_sleeve"] * ring.has_sleeves]
    return pairs + ["output"] * (not design.output.has_needles) + ["cam"] * (design.gear.bearing == "plain")


def with_common_friction(reducer: Reducer, friction: float) -> Reducer:
    """Return the design with one coefficient for all sliding pairs."""
    return reducer.but(friction=dict.fromkeys(sliding_pairs(reducer), friction))


def common_name(friction: float) -> str:
    """Return the name of a run with one coefficient for all sliding pairs."""
    return f"friction {friction:.3g} of all sliding pairs"


def friction_for(rates: Mapping[float, float], target: float) -> float:
    """Interpolate the common friction at a rate; NaN outside of the range run.

    The interpolated quantity is the relative loss 1/rate - 1, which is nearly proportional to the friction.
    """
    from scipy.interpolate import PchipInterpolator

    friction = np.array(sorted(rates))
    losses = np.array([1.0 / rates[key] - 1.0 for key in friction])
    rising = bool(np.all(np.diff(losses) > 0.0))
    return float(PchipInterpolator(losses, friction, extrapolate=False)(1.0 / target - 1.0)) if rising else np.nan


def slope(rates: Mapping[float, float]) -> float:
    """Compute the mean slope of the rate over the common friction [1]."""
    return (rates[max(rates)] - rates[min(rates)]) / (max(rates) - min(rates))


def common_rates(by_variant: Mapping[FrictionVariant, float], pins: str) -> dict[float, float]:
    """Map the common friction to the rate, for one support of the pins."""
    return {row.friction: rate for row, rate in by_variant.items() if row.pair == EVERY and row.pins == pins}


def table(reducer: Reducer, by_variant: Mapping[FrictionVariant, float]) -> Table:
    """Tabulate the rates, and their change from the design's friction."""
    ideal = reducer.design.rated_torque
    base = {row.pins: rate for row, rate in by_variant.items() if row.pair == OWN}
    header = ("pins", "pair", "friction", "output torque [N m]", "rate [%]", "change [points]")
    rows: list[tuple[str | float, ...]] = []
    for row, rate in by_variant.items():
        friction = "" if row.pair == OWN else row.friction
        rows.append((row.pins, row.pair, friction, ideal * rate, 1e2 * rate, 1e2 * (rate - base[row.pins])))
    return Table("output rate by friction, one pair at a time", header, tuple(rows))


def curves(by_variant: Mapping[FrictionVariant, float], published: Sequence[Published]) -> list[Curve]:
    """Return curves of the rate over the common friction, with the published rates on them."""
    panel, x, y = "output rate by the friction of all sliding pairs", "friction coefficient", "rate [%]"
    drawn = []
    for pins in dict.fromkeys(row.pins for row in by_variant):
        rates = common_rates(by_variant, pins)
        friction = np.array(sorted(rates))
        name = "internal gear" if pins == NONE else f"{pins} pins"
        drawn.append(Curve(panel, name, friction, 1e2 * np.array([rates[key] for key in friction]), x, y))
    for each in (each for each in published if math.isfinite(each.friction)):
        point = (np.array([each.friction]), np.array([1e2 * each.rate]))
        drawn.append(Curve(panel, f"the paper, {each.way}", *point, x, y, "points"))
    return drawn


def _of_ring(reducer: Reducer, quick: bool) -> list[FrictionVariant]:
    """List the rows of one support of the pins."""
    design = reducer.design
    pins, pairs = pins_of(reducer), sliding_pairs(reducer)
    rows = [FrictionVariant(pins, OWN, design.friction_of(design.tooth_pair), design)]
    if len(pairs) > 1 and not quick:
        cases = [(pair, value) for pair in pairs for value in (0.0, 0.1)]
        rows += [FrictionVariant(pins, *case, reducer.but(friction=dict([case])).design) for case in cases]
    return rows + [FrictionVariant(pins, EVERY, value, with_common_friction(reducer, value).design) for value in COMMON]


def _of_bearings(reducer: Reducer) -> list[FrictionVariant]:
    """List the rows of the rolling bearings, and of plain bearings in their place."""
    rows, pins = [], pins_of(reducer)
    plain: dict[str, dict[str, Any]] = {"cam": {"gear": {"bearing": "plain"}}, "output": {"output": {"rollers": False}}}
    for pair in [pair for pair in plain if pair not in sliding_pairs(reducer)]:
        for value in ROLLING:
            changed = reducer.but(friction={f"{pair}_rolling": value})
            rows.append(FrictionVariant(pins, f"{pair}, rolling", value, changed.design))
        sliding = reducer.but(**plain[pair])
        rows.append(FrictionVariant(pins, f"{pair}, sliding", sliding.design.friction_of(pair), sliding.design))
    return rows
