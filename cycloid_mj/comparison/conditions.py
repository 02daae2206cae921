"""What designs of a comparison share, in what they differ, and what makes them alike; in the words of design files.

Conditions are drive, load, environment and settings, but for the load torque, by which the cases differ, and the
drive's ratings, which no run depends on. A pin is a two-force body between gear and seat: play and compliance of its
two contacts add up. At equal play and series stiffness, free pins, fixed pins and an internal gear lose the same at
equal friction, and what is left to differ is the design itself.
"""

import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from cycloid_mj.design import Design, dump, override
from cycloid_mj.reducer import Reducer

TABLES = ("drive", "load", "environment", "settings")
HOLD = "drive.hold_s"
NO_CONDITIONS = ("load.torque_nm", "drive.power_kw", "drive.torque_nm")


def values(reducer: Reducer) -> dict[str, Any]:
    """Collect every value of a design by its key in the file, ``table.key``, but for its name."""
    tables = tomllib.loads(dump(reducer.design))
    single = {table: value for table, value in tables.items() if not isinstance(value, dict) and table != "name"}
    keyed = {table: keys for table, keys in tables.items() if isinstance(keys, dict)}
    return single | {f"{table}.{key}": value for table, keys in keyed.items() for key, value in keys.items()}


def conditions(reducer: Reducer) -> dict[str, Any]:
    """Collect the values of a design that its rivals must share."""
    entries = values(reducer).items()
    return {key: value for key, value in entries if key.split(".")[0] in TABLES and key not in NO_CONDITIONS}


def under(reducer: Reducer, shared: Mapping[str, Any], load: float) -> Design:
    """Return a design under shared conditions and a load torque [N m]."""
    return override(reducer.design, {**shared, "load.torque_nm": load})


def differences(designs: Sequence[Design]) -> dict[str, tuple[Any, ...]]:
    """Return what differs between designs, load torque apart: key -> the value of each, None where it has none."""
    all_values = [values(Reducer(design)) for design in designs]
    keys = dict.fromkeys(key for values in all_values for key in values if key != "load.torque_nm")
    each = {key: tuple(values.get(key) for values in all_values) for key in keys}
    return {key: of_each for key, of_each in each.items() if any(value != of_each[0] for value in of_each)}


def total_play(reducer: Reducer) -> float:
    """Compute the clearance between the gear and the housing along a contact's normal [m]."""
    design = reducer.design
    play = getattr(design.clearance, design.tooth_pair)
    return float(play + design.pin_play)


def with_play_of(nonpin: Reducer, pin: Reducer) -> Design:
    """Return an internal gear's design with the total play and the series stiffness of a pin design.

    The stiffness is the pin design's at its own load, and is kept under every other: one and the same design.
    """
    alike = {"clearance": {"tooth": total_play(pin)}, "stiffness": {"tooth": pin.contacts.mesh_stiffness}}
    return nonpin.but(name=f"{nonpin.design.name}-like-{pin.design.name}", **alike).design
