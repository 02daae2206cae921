"""Range of a rate over its assumed inputs, each varied on its own over its plausible range.

The numerical error of a rate does not include the uncertainty of its inputs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from cycloid_mj.base.result import Table
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.film_spread import RANGES, boundary_range


@dataclass(frozen=True)
class InputRanges:
    """Plausible ranges of the assumed inputs of a rate."""

    clearance: tuple[float, float] = (0.5, 2.0)
    """Factors on a clearance: measured against drawn."""
    max_clearance: float = 1e-3
    """Largest clearance that a design may have [m]."""
    cam_clearance: tuple[float, float] = (0.1, 2.0)
    """Factors on the cam's clearance, down to a nearly preloaded bearing."""
    cam_stiffness: tuple[float, float] = (0.5, 4.0)
    """Factors on the cam's stiffness: a row of few rollers, and about that of a plain journal without play."""
    tooth_friction: tuple[float, float] = (0.02, 0.1)
    """Friction of lubricated hardened steel on steel, from a full film to boundary lubrication (assumed)."""
    bearing_friction: tuple[float, float] = (0.001, 0.003)
    """Friction of rolling bearings: cylindrical rollers 0.0008 to 0.0012, needles with a cage 0.0020 to 0.0030
    (JTEKT)."""
    creep: tuple[float, float] = (0.001, 0.02)
    """Creep speed that regularises friction [m/s]."""
    damping: tuple[float, float] = (0.1, 0.5)
    """Damping ratio of the contacts."""
    periods: int = 4
    """Mesh periods of a run with a varied input at least."""


INPUTS = InputRanges()


@dataclass(frozen=True)
class Input:
    """An input at the ends of its range."""

    name: str
    unit: str
    """Name and unit, for tables."""
    low: float
    high: float
    """Values at the ends [`unit`]."""
    table: str
    """Table of the design that it belongs to."""
    low_values: Mapping[str, float]
    high_values: Mapping[str, float]
    """Values at the ends [SI], by key."""
    low_design: Design
    high_design: Design
    """Designs with these values."""

    @property
    def ends(self) -> tuple[Design, Design]:
        """The designs at both ends."""
        return self.low_design, self.high_design

    @property
    def names(self) -> dict[Design, str]:
        """Names of the designs at both ends: the input and its value."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return {
            self.low_design: f"{self.name} {self.low:.3g}{unit}",
            self.high_design: f"{self.name} {self.high:.3g}{unit}",
        }

    def between(self, share: float) -> dict[str, float]:
        """Return the values [SI] by their keys, at a share between 0 and 1 of the range of their logarithms."""
        return {
            key: low_value ** (1.0 - share) * self.high_values[key] ** share
            for key, low_value in self.low_values.items()
        }


@dataclass(frozen=True)
class InputEffect:
    """Values of a rate at the ends of an input's range [1]."""

    input: Input
    value_low: float
    value_high: float


def assumed_inputs(reducer: Reducer) -> list[Input]:
    """Return the assumed inputs of a design's efficiency or output rate, each with both ends of its plausible range.

    Assumed inputs are values of the design that are known only roughly: play of mesh and cam, stiffness of the cam,
    friction, creep speed and damping. With the law ``film``, boundary friction and roughness replace the friction
    coefficients that the law computes. An RV reducer has the inputs that its statics depends on.
    """
    design = reducer.design
    mesh_pairs = [kind for kind in design.pair_kinds if kind not in ("cam", "output")]
    if isinstance(reducer, RvReducer):
        return _rv_inputs(reducer, mesh_pairs)
    stiffness = reducer.contacts["cam"].stiffness
    return [
        _clearance_input(reducer, "mesh play", mesh_pairs, INPUTS.clearance),
        _clearance_input(reducer, "cam play", ["cam"], INPUTS.cam_clearance),
        _shared_value_input(
            reducer,
            "cam stiffness",
            "N/m",
            "stiffness",
            ["cam"],
            [share * stiffness for share in INPUTS.cam_stiffness],
        ),
        *(_film_inputs(reducer) if design.has_film else _coulomb_inputs(reducer, mesh_pairs)),
        _shared_value_input(reducer, "creep speed", "mm/s", "contact", ["creep_speed"], INPUTS.creep, 1e3),
        _shared_value_input(reducer, "contact damping", "of critical", "contact", ["damping_ratio"], INPUTS.damping),
    ]


def _rv_inputs(reducer: RvReducer, mesh_pairs: Sequence[str]) -> list[Input]:
    """Return the assumed inputs of an RV reducer: play of the teeth, and friction of teeth, crank bearings and planets.

    Each has both ends of its plausible range. `mesh_pairs` are the kinds of pairs at which teeth slide.
    """
    friction = (
        _film_inputs(reducer)
        if reducer.design.has_film
        else [
            _shared_value_input(reducer, "friction of the teeth", "1", "friction", mesh_pairs, INPUTS.tooth_friction),
            _shared_value_input(
                reducer, "friction of the crank bearings", "1", "friction", ["cam_rolling"], INPUTS.bearing_friction
            ),
            _shared_value_input(reducer, "friction of the planets", "1", "planet", ["friction"], INPUTS.tooth_friction),
        ]
    )
    return [_clearance_input(reducer, "mesh play", mesh_pairs, INPUTS.clearance), *friction]


def _coulomb_inputs(reducer: Reducer, mesh_pairs: Sequence[str]) -> list[Input]:
    """Return the assumed friction coefficients of teeth, cam and output pins (law ``coulomb``), with their ranges.

    `mesh_pairs` are the kinds of pairs at which teeth slide.
    """
    design = reducer.design
    return [
        _shared_value_input(reducer, "friction of the teeth", "1", "friction", mesh_pairs, INPUTS.tooth_friction),
        _bearing_input(reducer, "cam", design.gear.bearing == "rolling", INPUTS.bearing_friction),
        _bearing_input(
            reducer, "output", design.output.has_needles, (INPUTS.bearing_friction[0], plain_roller(reducer))
        ),
    ]


def _film_inputs(reducer: Reducer) -> list[Input]:
    """Return the assumed inputs of the law ``film`` with ranges: boundary friction, roughness, friction of needles."""
    friction = reducer.design.friction
    inputs = []
    for key, factor_range, design_value, unit, unit_factor in (
        ("boundary", boundary_range(reducer), friction.boundary, "1", 1.0),
        ("roughness", RANGES["roughness"], friction.roughness, "um", 1e6),
    ):
        limits = [factor * design_value for factor in (factor_range.low, factor_range.high)]
        inputs.append(_shared_value_input(reducer, factor_range.name, unit, "friction", [key], limits, unit_factor))
    if reducer.design.output.has_needles and not isinstance(reducer, RvReducer):
        inputs.append(_bearing_input(reducer, "output", True, INPUTS.bearing_friction))
    return inputs


def creep_variants(inputs: Sequence[Input]) -> set[Design]:
    """Collect the ends of the range of the creep speed, which shows how much friction is missing below it."""
    return {end for assumed_input in inputs if "creep_speed" in assumed_input.low_values for end in assumed_input.ends}


def input_effects(inputs: Sequence[Input], rates: Mapping[Any, float]) -> tuple[InputEffect, ...]:
    """Pair each input with the rates [1] of the designs at both ends of its range; `rates` are by design."""
    return tuple(InputEffect(varied_input, *(rates[end] for end in varied_input.ends)) for varied_input in inputs)


def plain_roller(reducer: Reducer) -> float:
    """Compute the friction at the rim of a roller that is a plain sleeve sliding on its core."""
    design = reducer.design
    return design.friction.pin_sleeve * design.output.root_radius / design.output.pin_radius


def table(rate: str, design_rate: float, effects: Sequence[InputEffect]) -> Table:
    """Return a table of a rate [%], such as the efficiency, at both ends of the plausible range of each input.

    `rate` is the name of the rate, `design_rate` is its value for the design [1], and `effects` are the effects of the
    inputs on it.
    """
    rows = [
        (item.input.name, item.input.unit, item.input.low, item.input.high, 1e2 * item.value_low, 1e2 * item.value_high)
        for item in effects
    ]
    min_rate, max_rate = spread(design_rate, effects)
    title = f"{rate} by assumed inputs, one at a time: {1e2 * min_rate:.1f} to {1e2 * max_rate:.1f} %"
    return Table(title, ("input", "unit", "low", "high", "at low [%]", "at high [%]"), tuple(rows))


def spread_text(design_rate: float, effects: Sequence[InputEffect]) -> str:
    """Describe the range of a rate over its inputs."""
    low_rate, high_rate = spread(design_rate, effects)
    widest = max(effects, key=lambda effect: abs(effect.value_high - effect.value_low)).input.name
    return (
        f"range over its assumed inputs, one at a time: {1e2 * low_rate:.1f} to {1e2 * high_rate:.1f} %, "
        f"widest for {widest}"
    )


def spread(design_rate: float, effects: Sequence[InputEffect]) -> tuple[float, float]:
    """Compute the smallest and the largest rate over all inputs [1]."""
    rates = [design_rate, *(rate for effect in effects for rate in (effect.value_low, effect.value_high))]
    return min(rates), max(rates)


def as_json(design_rate: float, effects: Sequence[InputEffect]) -> dict[str, Any]:
    """Convert a rate [1], such as the efficiency, its range, and its values at both ends of each input to JSON values.

    `design_rate` is the rate of the design, `effects` are the effects of the assumed inputs on it. ``spread`` has
    ``value``, ``low`` and ``high`` of the rate. ``sensitivity`` has the ends of each input, ``low`` and ``high``, in
    ``unit``, and the rates there, ``value_low`` and ``value_high`` [1].
    """
    min_rate, max_rate = spread(design_rate, effects)
    return {
        "sensitivity": [
            {"input": effect.input.name, "unit": effect.input.unit, "low": effect.input.low, "high": effect.input.high}
            | {"value_low": effect.value_low, "value_high": effect.value_high}
            for effect in effects
        ],
        "spread": {"value": design_rate, "low": min_rate, "high": max_rate},
    }


def _shared_value_input(
    reducer: Reducer, name: str, unit: str, table: str, keys: Sequence[str], limits: Sequence[float], scale: float = 1.0
) -> Input:
    """Return an input of the spread study: an assumption, such as a friction, not a value that the user has stated.

    The study sets several values in a table of the design file to the same value within a range.

    Parameters
    ----------
    name, unit
        Name of the input, and the unit in which reports show its value.
    table, keys
        Table of the design file, and the keys in it that are set.
    limits
        Smallest and largest value [SI].
    scale
        Factor from SI to `unit`.
    """
    low_values, high_values = (dict.fromkeys(keys, limit) for limit in limits)
    return _input_with_designs(
        reducer, name, unit, (scale * limits[0], scale * limits[1]), table, low_values, high_values
    )


def _clearance_input(reducer: Reducer, name: str, kinds: Sequence[str], factors: Sequence[float]) -> Input:
    """Return the assumed input `name`, which scales the clearances of some `kinds` of pairs by a common factor.

    `factors` are the factors on the design's clearances at the lower and the upper end of the range; each clearance is
    limited to `INPUTS.max_clearance`. As ends of the range, tables state the sum of these clearances [um].
    """
    low_values, high_values = (
        {kind: min(factor * getattr(reducer.design.clearance, kind), INPUTS.max_clearance) for kind in kinds}
        for factor in factors
    )
    low_total, high_total = (
        sum(1e6 * clearance for clearance in clearances.values()) for clearances in (low_values, high_values)
    )
    return _input_with_designs(reducer, name, "um", (low_total, high_total), "clearance", low_values, high_values)


Values = Mapping[str, float]


def _input_with_designs(
    reducer: Reducer,
    name: str,
    unit: str,
    limits: tuple[float, float],
    table: str,
    low_values: Values,
    high_values: Values,
) -> Input:
    """Return an input with the designs at its ends, whose table has `low_values` and `high_values` by key [SI]."""
    designs = [reducer.but(**{table: values}).design for values in (low_values, high_values)]
    return Input(name, unit, *limits, table, low_values, high_values, *designs)


def _bearing_input(reducer: Reducer, kind: str, has_rollers: bool, rolling_range: tuple[float, float]) -> Input:
    """Return the input of the friction of cam or output pins, rolling or sliding."""
    name, key, limits = (
        ("'s rollers", f"{kind}_rolling", rolling_range) if has_rollers else (", sliding", kind, INPUTS.tooth_friction)
    )
    return _shared_value_input(reducer, f"friction of the {kind}{name}", "1", "friction", [key], limits)
