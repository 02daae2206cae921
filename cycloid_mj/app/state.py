"""Designs of the page: the keys of the design file in which they differ from a preset, as in its address.

The preset is that of the layout in `BASES`. A design of another layout than "central" has the key ``layout``.
"""

import tomllib
from collections.abc import Mapping
from functools import cache
from typing import Any

from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.design import PRESETS, Design, dump, override, value_of
from cycloid_mj.design.layouts import Layout, applies
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.statics.sheet import load_of

BASES: Mapping[Layout, Design] = {"central": PRESETS["pin"], "rv": PRESETS["rv80e"]}
"""Layout -> the preset from which the values of a design differ."""

TIED = ("gear.eccentricity_mm", "output.pin_radius_mm")
"""Keys on which the radius of the output holes depends: it follows unless it is set itself."""


def parse_design(values: Any) -> Design:
    """Return the design that the page sends: the preset of its layout, changed by `values` (key of the file -> value).

    Raises
    ------
    DesignError, UsageError
        There is no such key, or its value is not allowed.
    """
    if not isinstance(values, Mapping):
        raise UsageError(
            f"the design is not a JSON object, but of type {type(values).__name__}: send an object of design-file keys "
            'and values, such as {"ring.teeth": 36}'
        )
    base = next((preset for layout, preset in BASES.items() if layout == values.get("layout")), BASES["central"])
    return override(base, {str(key): _as_integer(base, key, value) for key, value in values.items()})


def changed_values(design: Design) -> dict[str, Any]:
    """Return the values in which a design differs from the preset of its layout (`BASES`): key of the file -> value.

    For a material with the values of the library only the name is listed. The layout is listed unless it is "central".

    Raises
    ------
    DesignError
        The design lacks a value that the preset has.
    """
    preset = BASES[design.layout]
    values_by_key, base = _flatten_design(design), _flatten_preset(design.layout)
    if missing := [key for key in base if key not in values_by_key]:
        raise DesignError(
            f"the page cannot edit this design, because it has no {', '.join(missing)}: edit the design file in a text "
            "editor"
        )
    values = {key: value for key, value in values_by_key.items() if base.get(key) != value}
    for name in [key for key in values if key.endswith("material.name")]:
        table = name.removesuffix("name")
        named_material = {key: value for key, value in values.items() if key == name or not key.startswith(table)}
        if _flatten_design(override(preset, named_material)) == _flatten_design(override(preset, values)):
            values = named_material
    return values if design.layout == "central" else {"layout": design.layout, **values}


def differences(values_a: Any, values_b: Any) -> list[tuple[str, Any, Any]]:
    """List (key, value of design a, value of design b) for the keys in which two designs differ, in units of the file.

    `values_a` and `values_b` represent the designs by the values in which they differ from their presets.

    Raises
    ------
    DesignError, UsageError
        There is no such key, or its value is not allowed.
    """
    designs = (values_a, parse_design(values_a)), (values_b, parse_design(values_b))
    value_pairs = {
        key: [
            values[key] if key in values else value_of(design, key) if _has_table(design, key) else None
            for values, design in designs
        ]
        for key in dict.fromkeys((*values_a, *values_b))
    }
    return [(key, value_a, value_b) for key, (value_a, value_b) in value_pairs.items() if value_a != value_b]


def _has_table(design: Design, key: str) -> bool:
    """Return whether the layout of a design has the table of a key of the design file."""
    table, _, name = key.rpartition(".")
    return applies(design.layout, table, name)


def apply_changes(design: Design, changes: Any) -> Design:
    """Return a design with changes of the page applied, and with the values that depend on them.

    `changes` maps keys of the design file to values. The hole radius follows from output-pin radius and eccentricity,
    unless it is changed itself. On the page, load and nominal torque are the same: if one of them changes, the other is
    set to the same value. If the ratio changes, the load is kept, and the motor torque is adapted to it.

    Raises
    ------
    DesignError, UsageError
        There is no such key, or its value is not allowed.
    """
    if not isinstance(changes, Mapping):
        raise UsageError(
            f"the changes are of type {type(changes).__name__}: send a JSON object of design-file keys and values, "
            'such as {"ring.teeth": 36}'
        )
    if not changes:
        return design
    base = BASES[design.layout]
    changed_design = override(design, {str(key): _as_integer(base, key, value) for key, value in changes.items()})
    has_holes = design.layout == "central"
    if has_holes and any(key in changes for key in TIED) and "output.hole_radius_mm" not in changes:
        changed_design = changed_design.but(
            output={"hole_radius": changed_design.output.pin_radius + changed_design.gear.eccentricity}
        )
    if "drive.torque_nm" in changes:
        return changed_design.but(load={"torque": changed_design.rated_torque})
    if changed_design.load.torque and (changed_design.load.torque, changed_design.reduction) != (
        design.load.torque,
        design.reduction,
    ):
        return reducer_of(changed_design).with_nominal_torque(abs(changed_design.load.torque)).design
    return changed_design


def at_load(reducer: Reducer) -> Reducer:
    """Return a reducer whose nominal torque is its load: a design file may have two torques, the page shows one."""
    load, _ = load_of(reducer)
    loaded_reducer = reducer.with_nominal_torque(load)
    return reducer if loaded_reducer == reducer else loaded_reducer  # results of the reducer itself are cached


def _as_integer(base: Design, key: str, value: Any) -> Any:
    """Convert a float without fraction to an integer where the preset `base` has one: JSON has floats only."""
    is_whole = isinstance(value, float) and value.is_integer()
    if is_whole and isinstance(_flatten_preset(base.layout).get(key), int):
        return int(value)
    return value


def _flatten_design(design: Design) -> dict[str, Any]:
    """Return all values of the design file of a design as one mapping: ``table.key`` -> value in the file's unit."""
    flat_values: dict[str, Any] = {}
    for key, value in tomllib.loads(dump(design)).items():
        if isinstance(value, dict):
            flat_values |= {f"{key}.{name}": item for name, item in value.items()}
        else:
            flat_values[key] = value
    return flat_values


@cache
def _flatten_preset(layout: Layout) -> dict[str, Any]:
    return _flatten_design(BASES[layout])
