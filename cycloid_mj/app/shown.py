"""What the page says of a design: its failed checks, and its figures by statics and rating."""

from dataclasses import dataclass

from cycloid_mj.checks import Check, check
from cycloid_mj.design import Design
from cycloid_mj.loaded.sheet import sheet
from cycloid_mj.rating import Item, rate
from cycloid_mj.result import Quantity

KEYS = {
    "backlash": "backlash",
    "lost_motion_ideal": "lost motion at +-3 %",
    "stiffness_ideal": "torsional stiffness",
    "output_peak_to_peak_loaded_forward_speed": "transmission error, peak to peak",
    "efficiency": "efficiency",
    "capacity": "torque at first yield",
    "pin_gear_peak_force": "largest force on a pin",
    "tooth_peak_force": "largest force on a tooth",
    "pin_gear_pressure": "its Hertz pressure",
    "tooth_pressure": "its Hertz pressure",
    "output_peak_force": "largest force on an output pin",
    "cam_peak_force": "largest force of the cam",
}
"""Keys of the data sheet -> short names, in their order on the page."""

CAM = "cam_bearing"
"""Key of the item that stands beside the weakest."""


@dataclass(frozen=True)
class Line:
    """One figure as the page has it: name, value with unit, and what it stands on."""

    name: str
    value: str
    note: str = ""


def failed(design: Design) -> tuple[Check, ...]:
    """Give the checks that do not hold, errors before warnings."""
    found = [one for one in check(design) if not one.passed]
    return tuple(sorted(found, key=lambda one: one.severity != "error"))


def static_lines(design: Design) -> tuple[Line, ...]:
    """Give the figures of a sound design by statics, at its load.

    Raises
    ------
    CycloidError
        As `sheet`.
    """
    found = sheet(design, design.load.torque or None)
    quantities = [found.quantities[key] for key in KEYS if key in found.quantities]
    head = Line("by statics, at", found.condition)
    return (head, *(Line(KEYS[one.key], _written(one), found.condition) for one in quantities))


def life_lines(design: Design) -> tuple[Line, ...]:
    """Give the weakest item of a sound design and the life of its cam's bearing.

    Raises
    ------
    CycloidError
        As `rate`.
    """
    rating = rate(design)
    weakest, cam = rating.weakest, rating.items[CAM]
    lines = [Line("by rating, at", rating.duty), Line(f"weakest: {weakest.name}", _verdict(weakest), weakest.source)]
    return (*lines, Line(cam.name, _verdict(cam), cam.source)) if weakest.key != CAM else tuple(lines)


def _verdict(one: Item) -> str:
    return f"safety {one.verdict}" if one.safety is not None else one.verdict


def _written(one: Quantity) -> str:
    return "-" if one.value != one.value else f"{one.value:.4g} {one.unit}"
