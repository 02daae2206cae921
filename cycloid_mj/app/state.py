"""A design as the page has it, and as its address tells it: the keys of the file in which it differs from ``pin``."""

import tomllib
from collections.abc import Mapping
from functools import cache
from typing import Any

from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.design import PRESETS, Design, dump, override, value_of
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet import load_of

BASE = PRESETS["pin"]

TIED = ("gear.eccentricity_mm", "output.pin_radius_mm")
"""Keys with which the holes of the output pins change: they stay as wide as output pin and eccentricity make them."""

Values = Mapping[str, Any]


def design_of(values: Any) -> Design:
    """Read a design from the page's values.

    Raises
    ------
    DesignError, UsageError
        There is no such key, or its value is not allowed.
    """
    if not isinstance(values, Mapping):
        raise UsageError("a design is asked for: keys of the design file with their values")
    return override(BASE, {str(key): _whole(key, value) for key, value in values.items()})


def values_of(design: Design) -> dict[str, Any]:
    """Collect the values in which a design differs from the preset ``pin``, by the keys of its file.

    A material that is as its name says is told by its name alone.

    Raises
    ------
    DesignError
        The design lacks what ``pin`` has.
    """
    own, base = _flat(design), _base()
    if lost := [key for key in base if key not in own]:
        raise DesignError(f"the page cannot hold a design without {', '.join(lost)}: change its file instead")
    values = {key: value for key, value in own.items() if base.get(key) != value}
    for name in [key for key in values if key.endswith("material.name")]:
        table = name.removesuffix("name")
        fewer = {key: value for key, value in values.items() if key == name or not key.startswith(table)}
        if _flat(override(BASE, fewer)) == _flat(override(BASE, values)):
            values = fewer
    return values


def differences(first: Any, second: Any) -> list[tuple[str, Any, Any]]:
    """List the keys in which two designs of the page differ, with both values in the units of the file.

    Both are given by the values in which they differ from the preset ``pin``; errors as `design_of`.
    """
    designs = (first, design_of(first)), (second, design_of(second))
    pairs = {
        key: [values[key] if key in values else value_of(design, key) for values, design in designs]
        for key in dict.fromkeys((*first, *second))
    }
    return [(key, one, other) for key, (one, other) in pairs.items() if one != other]


def changed(design: Design, changes: Any) -> Design:
    """Return a design with changes in the words of its file, and what is tied to them; errors as `design_of`.

    The page has one torque: the load is what the drive is made for, whichever of the two is given.
    """
    if not isinstance(changes, Mapping):
        raise UsageError("changes are asked for: keys of the design file with their values")
    if not changes:
        return design
    new = override(design, {str(key): _whole(key, value) for key, value in changes.items()})
    if any(key in changes for key in TIED) and "output.hole_radius_mm" not in changes:
        new = new.but(output={"hole_radius": new.output.pin_radius + new.gear.eccentricity})
    if "drive.torque_nm" in changes:
        return new.but(load={"torque": new.rated_torque})
    if new.load.torque and (new.load.torque, new.reduction) != (design.load.torque, design.reduction):
        return made_for(Reducer(new), abs(new.load.torque)).design
    return new


def made_for(reducer: Reducer, torque: float) -> Reducer:
    """Return a reducer whose drive is made for a torque on the output [N m], with as much power to spare as before."""
    drive, needed = reducer.design.drive, torque / reducer.design.reduction
    return reducer.but(drive={"torque": needed, "power": drive.power * needed / drive.torque})


def at_load(reducer: Reducer) -> Reducer:
    """Return a reducer that is made for its load: a file may tell of two torques, the page shows one."""
    load, _ = load_of(reducer)
    return made_for(reducer, load)


def _whole(key: str, value: Any) -> Any:
    """Return a whole number as one where the file has one, for JSON's are floats."""
    if isinstance(value, float) and value.is_integer() and isinstance(_base().get(key), int):
        return int(value)
    return value


def _flat(design: Design) -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in tomllib.loads(dump(design)).items():
        if isinstance(value, dict):
            flat |= {f"{key}.{name}": item for name, item in value.items()}
        else:
            flat[key] = value
    return flat


@cache
def _base() -> dict[str, Any]:
    return _flat(BASE)
