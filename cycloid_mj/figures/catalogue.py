"""The catalogue: all figures by key, and functions that look them up and compute them."""

import math
import warnings
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from difflib import get_close_matches
from typing import Any

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import CycloidError, CycloidWarning, UsageError
from cycloid_mj.base.registry import get_provider
from cycloid_mj.base.result import Quantity
from cycloid_mj.figures.figure import Figure, Need
from cycloid_mj.figures.geometry import OF_GEOMETRY
from cycloid_mj.figures.sampled import ANGLES, OF_SAMPLES, solve_states
from cycloid_mj.figures.simulated import OF_RUNS
from cycloid_mj.figures.statics import OF_BALANCE, OF_STATICS
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.samples import Samples

FIGURES: Mapping[str, Figure] = {
    row.key: row
    for need in Need
    for row in (*OF_GEOMETRY, *OF_STATICS, *OF_BALANCE, *OF_SAMPLES, *get_provider("upper_figures"), *OF_RUNS)
    if row.need == need
}
"""Key -> figure, the cheapest first."""

SAMPLED = tuple(row.key for row in FIGURES.values() if row.sampled)
"""Keys of the figures that many samples of a reducer are balanced for at a time."""

_BY_ANY_NAME: Mapping[str, Figure] = {
    **{alias: figure for figure in FIGURES.values() for alias in (*figure.aliases, *figure.deprecated)},
    **FIGURES,
}

CHEAP = frozenset({Need.GEOMETRY, Need.STATICS})
"""Needs that take well under a second."""

COMPUTED = frozenset({*CHEAP, Need.LIFE})
"""Needs without finite elements and runs."""

MAX_SUGGESTIONS = 5
"""Similar keys that an error message suggests."""

NEED_NAMES = {
    Need.GEOMETRY: "dimensions only",
    Need.STATICS: "statics",
    Need.LIFE: "a life rating",
    Need.STRESS: "a finite-element analysis",
    Need.RUN: "a simulation",
}
"""Names of the needs in messages."""


def find_figure(key: str) -> Figure | None:
    """Return the catalogue row of a key or alias; None if there is none."""
    return _BY_ANY_NAME.get(key)


def figure(key: str, needs: Collection[Need] = frozenset(Need), reducer: Reducer | None = None) -> Figure:
    """Return the entry (`Figure`) of a quantity in the catalogue by key or alias; warn if the key is deprecated.

    Parameters
    ----------
    key
        Key or alias, as a user writes it.
    needs
        Kinds of computation (`Need`) that the caller can carry out, such as statics.
    reducer
        A reducer that must have the quantity; None for any.

    Raises
    ------
    UsageError
        The quantity does not exist, the reducer does not have it, or it requires a computation that is not in `needs`.
    """
    entry = find_figure(key)
    if entry is None:
        raise UsageError(
            f"unknown quantity {key!r:.60}; {_suggest_keys(key, needs, reducer)}choose one listed by "
            "`cycloid-mj figures`"
        )
    if key in entry.deprecated:
        warnings.warn(
            f"the quantity {key} is deprecated: use {entry.key}; the old key will be removed in the next release",
            CycloidWarning,
            stacklevel=2,
        )
    if entry.need not in needs:
        need_text = " or ".join(NEED_NAMES[need] for need in Need if need in needs)
        raise UsageError(
            f"the quantity {key} is computed from {NEED_NAMES[entry.need]}, but this command accepts only quantities "
            f"computed from {need_text}; {_suggest_keys(key, needs, reducer)}choose one listed by `cycloid-mj figures`"
        )
    if reducer is not None and not entry.applies_to(reducer):
        raise UsageError(
            f"the quantity {key} does not apply to the design {reducer.design.name!r}; "
            f"{_suggest_keys(key, needs, reducer)}choose one listed by `cycloid-mj figures`"
        )
    return entry


def _suggest_keys(key: str, needs: Collection[Need], reducer: Reducer | None) -> str:
    """Return a question for an error message that suggests up to `MAX_SUGGESTIONS` similar keys, or "".

    Similar keys contain `key`; if none does, they resemble it. Only quantities with one of the `needs` are considered,
    and only those that apply to the reducer unless it is None.
    """
    available_keys = [
        name
        for name, entry in _BY_ANY_NAME.items()
        if entry.need in needs
        and (reducer is None or entry.applies_to(reducer))
        and name != key
        and name not in entry.deprecated
    ]
    similar_keys = [name for name in available_keys if key and key in name] or get_close_matches(
        key, available_keys, n=MAX_SUGGESTIONS, cutoff=0.5
    )
    suggested_keys = list(dict.fromkeys(_BY_ANY_NAME[name].key for name in similar_keys))[:MAX_SUGGESTIONS]
    return f"did you mean {', '.join(suggested_keys)}? Otherwise " if suggested_keys else ""


def figures_of(reducer: Reducer, needs: Collection[Need] = CHEAP) -> tuple[Figure, ...]:
    """Return the catalogue rows that apply to a reducer and have one of the `needs`, the cheapest first."""
    return tuple(row for row in FIGURES.values() if row.need in needs and row.applies_to(reducer))


def compute(reducer: Reducer, keys: Iterable[str]) -> dict[str, float]:
    """Compute the values of quantities by their keys or aliases, each in its unit, for a reducer.

    Errors are those of the quantities.
    """
    return {key: figure(key).value(reducer) for key in keys}


def of_measure(measure: str, measured: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """Return those quantities of a measure that are quantities of the catalogue, with the catalogue's keys and names.

    `measure` is the name of the measure, `measured` are its quantities by its own keys.
    """
    rows = {key: row for key in measured if (row := find_figure(f"{measure}/{key}"))}
    return {row.key: replace(measured[key], key=row.key, name=row.name) for key, row in rows.items()}


def quantities(reducer: Reducer, needs: Collection[Need] = CHEAP) -> dict[str, Quantity]:
    """Compute all quantities with one of the `needs` that apply to a reducer, by key.

    The value of a quantity that fails is NaN, and its note is the error.
    """
    return {row.key: _quantity_of_row(reducer, row) for row in figures_of(reducer, needs)}


def quantity(reducer: Reducer, key: str) -> Quantity:
    """Compute the quantity of a key or alias; if that fails, its value is NaN, and its note is the error."""
    return _quantity_of_row(reducer, figure(key))


def _quantity_of_row(reducer: Reducer, row: Figure) -> Quantity:
    """Compute the quantity of a catalogue row; if that fails, its value is NaN, and its note is the error."""
    try:
        return row.quantity(reducer)
    except CycloidError as error:
        return Quantity(row.key, row.name, math.nan, row.unit, note=str(error))


def values_json(figures: Mapping[str, Quantity]) -> dict[str, dict[str, Any]]:
    """Convert computed quantities to JSON values: name, value and unit by key, and the interval if there is any."""
    return {
        key: {"name": figure.name, "value": figure.value, "unit": figure.unit, **figure.interval_json()}
        for key, figure in figures.items()
    }


def compute_sampled(
    reducer: Reducer, samples: Samples, keys: Collection[str] = SAMPLED, angles: int = ANGLES
) -> dict[str, Array]:
    """Compute catalogued quantities for random samples of a reducer: key -> values, shape (samples,).

    `samples` have the manufacturing errors of the drives. `keys` are the keys of the quantities; keys that are not in
    `SAMPLED` are ignored. `angles` is the number of crank angles over a turn.
    """
    entries = {key: sampled_figure for key in keys if (sampled_figure := figure(key).sampled)}
    needed_states = {state for entry in entries.values() for state in entry.states}
    states = solve_states(reducer, samples, needed_states, angles)
    return {key: entry.value(*(states[state] for state in entry.states)) for key, entry in entries.items()}
