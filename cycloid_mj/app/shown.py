"""What the page says of a design: its failed checks, and its figures by statics and rating."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.result import Quantity
from cycloid_mj.checks import Check, check, soundness
from cycloid_mj.design import Design
from cycloid_mj.figures import figure
from cycloid_mj.life import RatedItem, rate
from cycloid_mj.life.duty import steady
from cycloid_mj.life.lasting import lasting_checks
from cycloid_mj.life.rated import is_bearing_life
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet import glance

NAMES = {
    "backlash_arcmin": "backlash",
    "lost_motion_arcmin": "lost motion at +-3 %",
    "stiffness_nm_per_arcmin": "torsional stiffness",
    "te_loaded_forward_arcsec": "transmission error, peak to peak",
    "efficiency_percent": "efficiency",
    "capacity_nm": "torque at first yield",
    "pin_gear_peak_force_n": "largest force on a pin",
    "tooth_peak_force_n": "largest force on a tooth",
    "pin_gear_pressure_mpa": "its Hertz pressure",
    "tooth_pressure_mpa": "its Hertz pressure",
    "output_peak_force_n": "largest force on an output pin",
    "cam_peak_force_n": "largest force of the cam",
}
"""Keys of the catalogue -> short names, in their order on the page."""


@dataclass(frozen=True)
class FigureLine:
    """One figure as the page has it: name, value with unit, and what it stands on."""

    name: str
    value: str
    note: str = ""


def refused(error: CycloidError) -> tuple[FigureLine, ...]:
    """Return what stands in the place of figures and checks that an error leaves nothing of."""
    return (FigureLine("not possible", str(error).removeprefix("override: ")),)


def error_lines(design: Design) -> tuple[FigureLine, ...]:
    """List the reasons for which a design cannot be built; none of a sound one."""
    return _broken(one for one in soundness(Reducer(design)) if one.severity == "error")


def check_lines(design: Design) -> tuple[FigureLine, ...]:
    """List the checks that do not hold, errors before warnings, or that all do."""
    found = (*check(design), *lasting_checks(Reducer(design)))
    ordered = sorted(found, key=lambda one: one.severity != "error")
    return _broken(ordered) or (FigureLine("checks", "all hold"),)


def static_lines(design: Design) -> tuple[FigureLine, ...]:
    """List the figures of a sound design by statics, at its load, or why there are none."""
    try:
        sheet = glance(Reducer(design), design.load.torque or None)
    except CycloidError as error:
        return (FigureLine("no figures by statics", str(error)),)
    computed = {figure(key).key: quantity for key, quantity in sheet.quantities.items()}
    head = FigureLine("by statics, at", sheet.condition)
    return (
        head,
        *(
            FigureLine(name, _written(computed[key]), computed[key].note or sheet.condition)
            for key, name in NAMES.items()
            if key in computed
        ),
    )


def life_lines(design: Design) -> tuple[FigureLine, ...]:
    """Return the weakest item of a sound design at its load and its shortest-lived bearing, or why there are none."""
    try:
        rating = rate(design, steady(design.load.torque or design.rated_torque, design.drive.speed))
    except CycloidError as error:
        return (FigureLine("no rating", str(error)),)
    named = {f"weakest: {rating.weakest.name}": rating.weakest}
    bearings = (item for key, item in rating.items.items() if is_bearing_life(key))
    named |= {item.name: item for item in islice(bearings, 1)}
    head = FigureLine("by rating, at", rating.duty)
    return (head, *(FigureLine(name, _verdict(item), item.source) for name, item in named.items()))


def _broken(checks: Iterable[Check]) -> tuple[FigureLine, ...]:
    return tuple(
        FigureLine(f"{check.severity}: {check.name}", str(check).partition(": ")[2])
        for check in checks
        if not check.passed
    )


def _verdict(rated_item: RatedItem) -> str:
    return f"safety {rated_item.verdict}" if rated_item.safety is not None else rated_item.verdict


def _written(quantity: Quantity) -> str:
    return "-" if quantity.value != quantity.value else f"{quantity.value:.4g} {quantity.unit}"
