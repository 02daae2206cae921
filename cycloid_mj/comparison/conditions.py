"""The settings that every design of a comparison shares, and in what the designs differ; in the words of design files.

Conditions are drive, load, environment and settings, but for the load torque, which tells the cases apart, and the
drive's ratings, which no run depends on.
"""

import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from cycloid_mj.design import Design, dump, override

TABLES = ("drive", "load", "environment", "settings")
HOLD = "drive.hold_s"
NO_CONDITIONS = ("load.torque_nm", "drive.power_kw", "drive.torque_nm")


def values(design: Design) -> dict[str, Any]:
    """Give every value of a design by its key in the file, ``table.key``, but for its name."""
    tables = tomllib.loads(dump(design))
    return {f"{table}.{key}": value for table, keys in tables.items() if table != "name" for key, value in keys.items()}


def conditions(design: Design) -> dict[str, Any]:
    """Give the values of a design that its rivals must share."""
    found = values(design).items()
    return {key: value for key, value in found if key.split(".")[0] in TABLES and key not in NO_CONDITIONS}


def under(design: Design, shared: Mapping[str, Any], load: float) -> Design:
    """Give a design under shared conditions and a load torque [N m]."""
    wanted = {**shared, "load.torque_nm": load}
    return override(
        design, [f'{key}="{value}"' if isinstance(value, str) else f"{key}={value!r}" for key, value in wanted.items()]
    )


def differences(designs: Sequence[Design]) -> dict[str, tuple[Any, ...]]:
    """Give what differs between designs, load torque apart: key -> the value of each."""
    found = [values(design) for design in designs]
    each = {key: tuple(one[key] for one in found) for key in found[0] if key != "load.torque_nm"}
    return {key: told for key, told in each.items() if any(value != told[0] for value in told)}
