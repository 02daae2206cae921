"""Sensitivity of the output rate to the friction of each pair, with free, fixed and sleeved pins."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.base.names import CRANK_BEARING, PLANET_MESH
from cycloid_mj.base.result import Curve, Table
from cycloid_mj.design import Design
from cycloid_mj.measure.published import Published
from cycloid_mj.measure.steady import steady_design
from cycloid_mj.reducer import Reducer, RvReducer


@dataclass(frozen=True)
class FrictionTableSettings:
    """Coefficients of friction of the variants of a design, and the length of their runs."""

    rolling: tuple[float, ...] = (0.0, 0.003)
    """Coefficients of a rolling bearing: none, and the largest of caged needles (JTEKT)."""
    sliding: tuple[float, ...] = (0.0, 0.1)
    """Coefficients of each sliding pair on its own."""
    common: tuple[float, ...] = (0.0, 0.02, 0.05, 0.1)
    """Common coefficients of all sliding pairs, between which the friction of a rate is interpolated."""
    periods: int = 8
    """Smallest number of mesh periods of a run."""


FRICTION_TABLE = FrictionTableSettings()

ALL_PAIRS, AS_DESIGNED, NO_PINS = "all sliding", "as designed", "none"


@dataclass(frozen=True)
class FrictionVariant:
    """A row: support of the ring's pins, the pair whose friction is set, its coefficient [1], and the design."""

    pins: str
    pair: str
    friction: float
    design: Design

    @property
    def name(self) -> str:
        """Return the name of the run with this friction: as designed, or the changed pair and its coefficient."""
        support_text = "" if self.pins == NO_PINS else f", {self.pins} pins"
        return (
            f"friction as designed{support_text}"
            if self.pair == AS_DESIGNED
            else f"friction {self.friction:g} of {self.pair}{support_text}"
        )


def friction_variants(reducer: Reducer, quick: bool = False) -> list[FrictionVariant]:
    """Return variants of the design for the friction table: other friction, support of the ring's pins, bearings.

    The supports of pins are free, fixed and sleeved. For each there are the design's friction, the friction of one kind
    of sliding pair changed at a time, and equal friction of all kinds. For the design's support, there are also
    variants with another bearing of cam or output. `quick` omits other supports, single kinds and bearings. With the
    friction law ``film``, single kinds and bearings are omitted.
    """
    ring_variants = [steady_design(ring_variant) for ring_variant in ring_kinds(reducer)[: 1 if quick else None]]
    variants = [variant for ring_variant in ring_variants for variant in _sliding_variants(ring_variant, quick)]
    return variants if quick or reducer.design.has_film else [*variants, *_bearing_variants(ring_variants[0])]


def ring_kinds(reducer: Reducer) -> list[Reducer]:
    """List the design, and its variants with the other supports of the ring's pins."""
    if reducer.design.ring.kind == "nonpin":
        return [reducer]
    other_supports = [support for support in ("free", "fixed", "sleeved") if support != reducer.design.ring.pins]
    return [reducer, *(reducer.but(ring={"pins": support}) for support in other_supports)]


def pins_of(reducer: Reducer) -> str:
    """Return the support of the ring's pins: free, fixed, sleeved, or `NO_PINS` for an internal gear."""
    return NO_PINS if reducer.design.ring.kind == "nonpin" else f"{reducer.design.ring.pins}"


def sliding_pairs(reducer: Reducer) -> list[str]:
    """List the kinds of mating pairs of a design that slide, by keys such as "pin_gear" and "output"."""
    design = reducer.design
    ring = design.ring
    pairs = [design.tooth_pair, *["pin_socket"] * ring.has_sockets, *["pin_sleeve"] * ring.has_sleeves]
    if isinstance(reducer, RvReducer):
        return [*pairs, PLANET_MESH]
    return pairs + ["output"] * (not design.output.has_needles) + ["cam"] * (design.gear.bearing == "plain")


def with_common_friction(reducer: Reducer, friction: float) -> Reducer:
    """Return the design with the law ``coulomb`` and one coefficient for all sliding pairs."""
    coefficients = _coefficients(dict.fromkeys(sliding_pairs(reducer), friction))
    return reducer.but(**coefficients | {"friction": {**coefficients["friction"], "law": "coulomb"}})


def _coefficients(friction: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """Return friction coefficients by kind of sliding pair [1] as values of the design, by table."""
    tables: dict[str, dict[str, float]] = {
        "friction": {pair: value for pair, value in friction.items() if pair != PLANET_MESH}
    }
    return tables | ({"planet": {"friction": friction[PLANET_MESH]}} if PLANET_MESH in friction else {})


def common_name(friction: float) -> str:
    """Return the name of a run with one coefficient for all sliding pairs."""
    return f"friction {friction:.3g} of all sliding pairs"


def interpolate_friction(rate_by_friction: Mapping[float, float], rate: float) -> float:
    """Interpolate the friction coefficient of all sliding pairs [1] at which the model has an output `rate` (PCHIP).

    The output rate [1] is the output torque over that without losses. `rate_by_friction` maps the friction
    coefficients of runs, common to all pairs, to their output rates. The interpolated quantity is the relative loss
    1/rate - 1, which is nearly proportional to the friction. The result is NaN outside of the range that was run, or if
    the losses do not increase with the friction.
    """
    from scipy.interpolate import PchipInterpolator

    coefficients = np.array(sorted(rate_by_friction))
    losses = np.array([1.0 / rate_by_friction[coefficient] - 1.0 for coefficient in coefficients])
    is_increasing = bool(np.all(np.diff(losses) > 0.0))
    return (
        float(PchipInterpolator(losses, coefficients, extrapolate=False)(1.0 / rate - 1.0)) if is_increasing else np.nan
    )


def slope(rates: Mapping[float, float]) -> float:
    """Compute the mean slope of the rate over the common friction [1]."""
    return (rates[max(rates)] - rates[min(rates)]) / (max(rates) - min(rates))


def common_rates(rate_by_variant: Mapping[FrictionVariant, float], pins: str) -> dict[float, float]:
    """Map the common friction to the rate, for one support of the pins."""
    return {row.friction: rate for row, rate in rate_by_variant.items() if row.pair == ALL_PAIRS and row.pins == pins}


def table(reducer: Reducer, rate_by_variant: Mapping[FrictionVariant, float]) -> Table:
    """Return a table of the output rate of each variant of friction, in percent and as a torque, and its change.

    The output rate is the output torque over that without losses. `rate_by_variant` are the rates [1]. The change, in
    percentage points, is relative to the design's friction with the same support of the ring's pins.
    """
    rated_torque = reducer.design.rated_torque
    design_rate = {run.pins: rate for run, rate in rate_by_variant.items() if run.pair == AS_DESIGNED}
    header = ("pins", "pair", "friction", "output torque [N m]", "rate [%]", "change [points]")
    rows: list[tuple[str | float, ...]] = []
    for run, rate in rate_by_variant.items():
        friction = "" if run.pair == AS_DESIGNED else run.friction
        rows.append(
            (run.pins, run.pair, friction, rated_torque * rate, 1e2 * rate, 1e2 * (rate - design_rate[run.pins]))
        )
    return Table("output rate by friction, one pair at a time", header, tuple(rows))


def curves(rate_by_variant: Mapping[FrictionVariant, float], published: Sequence[Published]) -> list[Curve]:
    """Return curves of the output rate [%] over the common friction, by support of the pins, with published rates.

    The output rate is the output torque over that without losses. `rate_by_variant` are the rates [1] of the designs.
    Published rates outside of the range that was run are omitted.
    """
    panel, x, y = "output rate by the friction of all sliding pairs", "friction coefficient", "rate [%]"
    curve_list = []
    for pin_support in dict.fromkeys(run.pins for run in rate_by_variant):
        rates = common_rates(rate_by_variant, pin_support)
        coefficients = np.array(sorted(rates))
        name = "internal gear" if pin_support == NO_PINS else f"{pin_support} pins"
        curve_list.append(
            Curve(panel, name, coefficients, 1e2 * np.array([rates[coefficient] for coefficient in coefficients]), x, y)
        )
    for paper in (paper for paper in published if math.isfinite(paper.friction)):
        position = (np.array([paper.friction]), np.array([1e2 * paper.rate]))
        curve_list.append(Curve(panel, f"the paper, {paper.method}", *position, x, y, "points"))
    return curve_list


def _sliding_variants(reducer: Reducer, quick: bool) -> list[FrictionVariant]:
    """Return designs with other friction of the sliding pairs, whose ring pins are free or fixed as in the reducer.

    They have the design's friction, other friction of one kind of sliding pair, or equal friction of all kinds. With
    `quick` or the friction law ``film``, variants of a single kind are omitted.
    """
    design = reducer.design
    pin_support, pairs = pins_of(reducer), sliding_pairs(reducer)
    variants = [FrictionVariant(pin_support, AS_DESIGNED, design.friction_of(design.tooth_pair), design)]
    if len(pairs) > 1 and not quick and not design.has_film:
        pair_frictions = [(pair, coefficient) for pair in pairs for coefficient in FRICTION_TABLE.sliding]
        variants += [
            FrictionVariant(pin_support, *pair_friction, reducer.but(**_coefficients(dict([pair_friction]))).design)
            for pair_friction in pair_frictions
        ]
    return variants + [
        FrictionVariant(pin_support, ALL_PAIRS, coefficient, with_common_friction(reducer, coefficient).design)
        for coefficient in FRICTION_TABLE.common
    ]


def _bearing_variants(reducer: Reducer) -> list[FrictionVariant]:
    """Return design variants with each coefficient `FRICTION_TABLE.rolling` of a rolling bearing, or a plain bearing.

    Cam or output bearings that slide in the design have no variants. The bearings of an RV reducer remain rolling.
    """
    variants, pin_support = [], pins_of(reducer)
    if isinstance(reducer, RvReducer):
        rolling_designs = {
            coefficient: reducer.but(friction={"cam_rolling": coefficient}).design
            for coefficient in FRICTION_TABLE.rolling
        }
        return [FrictionVariant(pin_support, f"{CRANK_BEARING}, rolling", *row) for row in rolling_designs.items()]
    plain_changes: dict[str, dict[str, Any]] = {
        "cam": {"gear": {"bearing": "plain"}},
        "output": {"output": {"rollers": False}},
    }
    for pair in [pair for pair in plain_changes if pair not in sliding_pairs(reducer)]:
        for coefficient in FRICTION_TABLE.rolling:
            rolling_reducer = reducer.but(friction={f"{pair}_rolling": coefficient})
            variants.append(FrictionVariant(pin_support, f"{pair}, rolling", coefficient, rolling_reducer.design))
        sliding_reducer = reducer.but(**plain_changes[pair])
        variants.append(
            FrictionVariant(
                pin_support, f"{pair}, sliding", sliding_reducer.design.friction_of(pair), sliding_reducer.design
            )
        )
    return variants
