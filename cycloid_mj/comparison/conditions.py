"""Shared conditions and differences of compared designs, by keys of the design file.

Conditions are drive, load, environment and settings, except for the load torque, by which the cases differ, and the
drive's ratings, which do not affect a run. A pin is a two-force body between disc and seat, so the clearances and the
compliances of its two contacts add up. With equal total clearance and series stiffness, free pins, fixed pins and an
internal gear have equal losses at equal friction; what still differs is the design.
"""

import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from cycloid_mj.design import Design, dump, override
from cycloid_mj.reducer import Reducer, reducer_of

TABLES = ("drive", "load", "environment", "settings")
HOLD = "drive.hold_s"
NO_CONDITIONS = ("load.torque_nm", "drive.power_kw", "drive.torque_nm")


def design_values(reducer: Reducer) -> dict[str, Any]:
    """Return all values of a design except its name, by ``table.key`` of the design file."""
    tables = tomllib.loads(dump(reducer.design))
    top_level = {table: value for table, value in tables.items() if not isinstance(value, dict) and table != "name"}
    by_table = {table: keys for table, keys in tables.items() if isinstance(keys, dict)}
    return top_level | {f"{table}.{key}": value for table, keys in by_table.items() for key, value in keys.items()}


def conditions(reducer: Reducer) -> dict[str, Any]:
    """Collect the values that compared designs must share."""
    entries = design_values(reducer).items()
    return {key: value for key, value in entries if key.split(".")[0] in TABLES and key not in NO_CONDITIONS}


def apply_conditions(reducer: Reducer, shared: Mapping[str, Any], load: float) -> Design:
    """Return a design with shared conditions and a load torque [N m]."""
    return override(reducer.design, {**shared, "load.torque_nm": load})


def differences(designs: Sequence[Design]) -> dict[str, tuple[Any, ...]]:
    """Return the values that differ between designs, except the load torque: key -> values, None for a missing one."""
    all_values = [design_values(reducer_of(design)) for design in designs]
    keys = dict.fromkeys(key for values in all_values for key in values if key != "load.torque_nm")
    values_by_key = {key: tuple(values.get(key) for values in all_values) for key in keys}
    return {
        key: values_of_designs
        for key, values_of_designs in values_by_key.items()
        if any(value != values_of_designs[0] for value in values_of_designs)
    }


def total_play(reducer: Reducer) -> float:
    """Compute the clearance between disc and housing along the normal of a tooth contact [m]."""
    design = reducer.design
    play = getattr(design.clearance, design.tooth_pair)
    return float(play + design.pin_play)


def with_play_of(nonpin: Reducer, pin: Reducer) -> Design:
    """Return an internal gear's design with the total clearance and the series stiffness of a pin design.

    The stiffness is that of the pin design at its own load, and the same under all loads.
    """
    alike = {"clearance": {"tooth": total_play(pin)}, "stiffness": {"tooth": pin.contacts.mesh_stiffness}}
    return nonpin.but(name=f"{nonpin.design.name}-like-{pin.design.name}", **alike).design
