"""Samples of an RV reducer within its tolerances: transmission error of cranks, bores and planets, in closed form.

The closed form is linear in the errors: a sample is a sum of the responses to unit errors. The variance of the
transmission error at each crank angle is therefore the sum of those of the tolerances, which is the error budget.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.units import ARCSECOND
from cycloid_mj.design import Design
from cycloid_mj.design.rv import CrankErrors
from cycloid_mj.explore.budget import Share
from cycloid_mj.explore.zone import Zone, zone
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv_sheet import closed_rotation

FIGURE = "te_errors_arcsec"
"""The figure of the samples."""

ERRORS: Mapping[str, tuple[str, ...]] = {
    "eccentricity": ("eccentric_radial",),
    "phase": ("eccentric_tangential",),
    "bore_position": ("bore_x", "bore_y"),
    "carrier_position": ("carrier_x", "carrier_y"),
    "planet_runout": ("planet_x", "planet_y"),
    "axis_position": ("axis_x", "axis_y"),
}
"""Key of the table [crank_tolerance] -> the errors in [crank_errors] that it varies."""

BLOCK = 2_000
"""Samples that are evaluated at a time, which bounds the memory."""
UNIT_ERROR = 1e-6
"""Error of the responses [m]."""


@dataclass(frozen=True)
class RvSamples:
    """Samples: values of `FIGURE` [arcsec], drawn departures [um] by column, error budget, and the worst designs."""

    values: Array
    drawn: Mapping[str, Array]
    budget: tuple[Share, ...]
    worst: tuple[Design, ...]


def crank_zones(reducer: RvReducer) -> dict[str, Zone]:
    """Return the tolerances of a design by key of [crank_tolerance].

    Raises
    ------
    UsageError
        There are none.
    DesignError
        A tolerance does not have a known form.
    """
    cranks = reducer.cranks
    sizes = {
        "eccentricity": 2.0 * cranks.eccentric_radius,
        "phase": 2.0 * cranks.eccentric_radius,
        "bore_position": 2.0 * reducer.bore_radius,
        "carrier_position": 2.0 * cranks.taper_radius,
        "planet_runout": reducer.planet.module * reducer.planet.planet_teeth,
        "axis_position": 2.0 * reducer.design.ring.pin_circle_radius,
    }
    texts = {key: getattr(reducer.crank_tolerance, key) for key in ERRORS}
    parsed = {key: zone(text, key, sizes[key], table="crank_tolerance") for key, text in texts.items()}
    zones = {key: item for key, item in parsed.items() if item}
    if not zones:
        raise UsageError(
            f"the design {reducer.design.name!r} has no tolerances: set at least one in the table [crank_tolerance], "
            "e.g. --set 'crank_tolerance.bore_position=\"uniform 4\"'"
        )
    return zones


def draw_rv_samples(reducer: RvReducer, samples: int, seed: int, worst: int) -> RvSamples:
    """Draw samples within the tolerances; the `worst` with the largest transmission error are kept as designs."""
    zones, rng = crank_zones(reducer), np.random.default_rng(seed)
    own, responses = closed_rotation(reducer), dict[str, Array]()
    drawn, variances = dict[str, Array](), dict[str, float]()
    for key, item in zones.items():
        of_key = {column: turn for field in ERRORS[key] for column, turn in _responses(reducer, field, own).items()}
        drawn |= {column: item.quantiles(rng.random(samples)) for column in of_key}
        variances[key] = item.deviation**2 * sum(float(np.var(turn)) for turn in of_key.values())
        responses |= of_key
    values = _ranges(own, np.array(list(responses.values())), np.array(list(drawn.values()))) / ARCSECOND
    total = sum(variances.values())
    parts = {key: variance / total if total else 0.0 for key, variance in variances.items()}
    ordered = sorted(parts, key=lambda key: -parts[key])
    order = np.argsort(-values)[:worst]
    return RvSamples(
        values=values,
        drawn={column: 1e6 * departure for column, departure in drawn.items()},
        budget=tuple(Share(key, parts[key], parts[key], (parts[key], parts[key])) for key in ordered),
        worst=tuple(_design_of(reducer, drawn, int(row), place) for place, row in enumerate(order, 1)),
    )


def _ranges(own: Array, responses: Array, departures: Array) -> Array:
    """Return the range of the output's angle of each sample [rad], shape (samples,).

    From the angle without departures, shape (m,), the responses (columns, m) and the departures (columns, samples).
    """
    starts = range(0, departures.shape[1], BLOCK)
    blocks = (departures[:, start : start + BLOCK].T @ responses + own for start in starts)
    return np.concatenate([np.ptp(block, axis=1) for block in blocks])


def _responses(reducer: RvReducer, field: str, own: Array) -> dict[str, Array]:
    """Return the response of the output's angle to each error of a field [rad/m], by the name of its column."""
    count = _count(reducer, field)
    names = [f"{field}_{number + 1}" for number in range(count)] if count else [field]
    responses = {}
    for number, name in enumerate(names):
        values = np.array(_values(reducer, field))
        values[number] += UNIT_ERROR
        moved = reducer.but(crank_errors={field: tuple(values.tolist()) if count else float(values[0])})
        responses[name] = (closed_rotation(moved) - own) / UNIT_ERROR
    return responses


def _count(reducer: RvReducer, field: str) -> int:
    """Return the length of a list of errors; 0 of a single number."""
    if isinstance(CrankErrors.model_fields[field].default, float):
        return 0
    of_eccentrics = field.startswith(("eccentric", "bore"))
    return reducer.cranks.count * (len(reducer.phases) if of_eccentrics else 1)


def _values(reducer: RvReducer, field: str) -> list[float]:
    """Return the errors of a field [m]; an empty list has zeros."""
    values = getattr(reducer.crank_errors, field)
    if isinstance(values, float):
        return [values]
    return list(values) or [0.0] * _count(reducer, field)


def _design_of(reducer: RvReducer, drawn: Mapping[str, Array], row: int, place: int) -> Design:
    """Return a sample as a design."""
    changes: dict[str, float | tuple[float, ...]] = {}
    for field in (field for fields in ERRORS.values() for field in fields):
        count = _count(reducer, field)
        names = [f"{field}_{number + 1}" for number in range(count)] if count else [field]
        if names[0] in drawn:
            values = [own + float(drawn[name][row]) for own, name in zip(_values(reducer, field), names, strict=True)]
            changes[field] = tuple(values) if count else values[0]
    return reducer.design.but(name=f"{reducer.design.name}-worst-{place}", crank_errors=changes)
