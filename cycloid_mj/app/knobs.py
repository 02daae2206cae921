"""The dozen values of a design that matter most, each with the range that its slider goes through."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import Design, override
from cycloid_mj.design.units import file_key, unit_of

SHAPES: Mapping[str, Mapping[str, Any]] = {
    "pin": {"ring.kind": "pin", "gear.discs": 1},
    "nonpin": {"ring.kind": "nonpin", "gear.discs": 1},
    "two discs": {"ring.kind": "pin", "gear.discs": 2},
}
"""The switch above the sliders -> values of the design."""


@dataclass(frozen=True)
class Knob:
    """One slider.

    Attributes
    ----------
    key
        ``table.key`` of the design file.
    label
        What stands beside it, with its unit.
    value, low, high, step
        In the unit of the file.
    """

    key: str
    label: str
    value: float
    low: float
    high: float
    step: float


LABELS = {
    "ring.teeth": "ring teeth",
    "ring.pin_circle_radius": "pin circle",
    "ring.pin_radius": "pin radius",
    "gear.eccentricity": "eccentricity",
    "gear.face_width": "face width",
    "gear.bore_radius": "bore radius",
    "output.pins": "output pins",
    "output.pin_radius": "output pin",
    "output.pin_circle_radius": "their circle",
    "clearance.mesh": "clearance of the teeth",
    "clearance.cam": "clearance of the cam",
    "clearance.output": "clearance of the output",
    "load.torque": "torque at the output",
    "drive.speed": "crank speed",
}
"""``table.name`` of the model -> label; the clearance of the teeth is that of the design's own kind of ring."""

UNITS = {"mm": "mm", "um": "um", "nm": "N\u00a0m", "rpm": "rpm"}
COUNTS = {"ring.teeth": (4.0, 100.0), "output.pins": (2.0, 24.0)}
SPAN = 3.0
"""How many times more, and less, than the value that the page starts with a slider goes."""

STEPS = 300
"""Steps of a slider, about."""

WIDE_UM = 100.0
"""A clearance goes from next to nothing up to this, or further."""


def knobs(design: Design) -> tuple[Knob, ...]:
    """List the sliders of a design."""
    return tuple(_knob(design, name, label) for name, label in LABELS.items())


def shape_of(design: Design) -> str | None:
    """Return which of `SHAPES` a design has; none where it has, say, three discs."""
    layout = {"ring.kind": design.ring.kind, "gear.discs": design.gear.discs}
    return next((name for name, values in SHAPES.items() if values == layout), None)


def _knob(design: Design, name: str, label: str) -> Knob:
    table, _, key = name.partition(".")
    key = design.tooth_pair if key == "mesh" else key
    section = getattr(design, table)
    field, current = type(section).model_fields[key], getattr(section, key)
    unit = unit_of(field)
    label = f"{label} [{UNITS[unit.suffix]}]" if unit.suffix in UNITS else label
    path = f"{table}.{file_key(key, field)}"
    if name in COUNTS:
        return Knob(path, label, current, *COUNTS[name], 1.0)
    value = unit.from_si(current)
    middle = abs(value) or unit.from_si(design.rated_torque)  # of a design without load
    high = max(WIDE_UM, SPAN * middle) if table == "clearance" else SPAN * middle
    step = 10.0 ** math.floor(math.log10(high / STEPS))
    low = step if table == "clearance" else max(1.0, math.floor(middle / SPAN / step)) * step
    return Knob(path, label, value, low, math.ceil(high / step) * step, step)


def turned(design: Design, values: Mapping[str, Any]) -> Design:
    """Return a design with values of its knobs; holes stay as wide as output pin and eccentricity make them.

    Raises
    ------
    DesignError
        A value is not allowed.
    """
    changed = override(design, {key: _counted(value) if key in COUNTS else value for key, value in values.items()})
    hole = changed.output.pin_radius + changed.gear.eccentricity
    return changed.but(output={"hole_radius": hole})


def angle(degrees: Any) -> float:
    """Convert the crank slider's value to radians.

    Raises
    ------
    DesignError
        It is no finite number.
    """
    if isinstance(degrees, int | float) and math.isfinite(degrees):
        return math.radians(degrees)
    raise DesignError(f"crank = {degrees!r} is not allowed: give an angle in degrees")


def _counted(value: Any) -> Any:
    """Return a whole number as one, for a slider's are floats; what is none is left for the validation to tell."""
    return int(value) if isinstance(value, float) and value.is_integer() else value
