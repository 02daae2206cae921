"""Reasons for the values of a new drive, for the comments of its file."""

from collections.abc import Iterator

from cycloid_mj.design import Design, stock
from cycloid_mj.design.model import PARTS
from cycloid_mj.reducer.bodies import are_one_part
from cycloid_mj.sizing.process import PROCESSES
from cycloid_mj.sizing.proportions import DISC_SHARE, FIT_TOLERANCES, POWER_RESERVE, Proportions
from cycloid_mj.sizing.requirement import Requirement
from cycloid_mj.sizing.trial import TorqueTrial

WALL_ROUNDING = 0.015
"""Increase of a wall relative to the outer radius that is not due to rounding."""


def reasons_of(requirement: Requirement, proportions: Proportions, trial: TorqueTrial) -> Iterator[tuple[str, str]]:
    """Yield the reason of each value, by ``table.value``."""
    design, discs = trial.reducer.design, trial.reducer.design.gear.discs
    weakest = f"; at the required torque {trial.weakest.name} fails first" if trial.weakest else ""
    yield "structure", "includes bending of output pins and torsion of carrier, shaft and housing"
    yield "ring.teeth", f"ratio {design.lobes} plus one"
    outer = design.housing.outer_radius
    wall = 1.0 - (design.ring.pin_circle_radius + design.ring.pin_radius) / outer
    needed = "" if wall < proportions.wall + WALL_ROUNDING else ", as the screws of the covers need it"
    yield "ring.pin_circle_radius", f"leaves a wall of {wall:.0%} of the outer radius{needed}"
    stock = "" if requirement.custom else ", in stock"
    yield "ring.pin_radius", f"{proportions.pin:.0%} of the space between neighbours, approximately{stock}"
    yield (
        "gear.eccentricity",
        f"K1 = c N / E = {proportions.short_width:g}: the largest at which no other part becomes the weakest",
    )
    as_sold = "" if requirement.custom else ", as long as pins in stock"
    yield "gear.face_width", f"{proportions.width:.0%} of the pin circle for all discs{as_sold}{weakest}"
    yield (
        "gear.bore_radius",
        f"{proportions.bore:.0%} of the disc's root radius, approximately{stock and ', for a bearing in stock'}",
    )
    if discs > 1:
        one_part = are_one_part(discs, design.output.pins, design.lobes)
        yield "gear.discs", "required; they balance each other" if requirement.discs else "one disc is not enough"
        yield (
            "output.pins",
            "with this number all discs are identical parts" if one_part else "the discs are different parts",
        )
    else:
        yield "output.pins", "the largest number with walls between the holes"
    yield "gear.disc_gap", "space for a spacer between several discs"
    yield "output.pin_circle_radius", "the middle of the web between bore and root"
    yield "output.pin_radius", f"its hole takes {proportions.hole:.0%} of the web, or of the space between neighbours"
    yield "output.hole_radius", "output pin + eccentricity"
    reach = stock and ", approximately: dowels in stock reach from face to face"
    yield "output.disc_thickness", f"{DISC_SHARE:.0%} of the outer radius{reach}"
    yield "output.support", "supported at one end, the pins would bend away from the load"
    if stock:
        yield "output.core_radius", "a dowel in stock under the roller"
        yield "output.roller_bearing", "a turned sleeve fits on the dowel, needles do not"
        yield "shaft.bearing_width", "width of a bearing in stock"
        yield from _clamping(design)
    yield (
        "shaft.radius",
        f"at most {proportions.shaft:.0%} of the bore, with space for its bearing within the cam{stock}",
    )
    yield "shaft.length", "space for a bearing" + (", and for the counterweight" if discs == 1 else "")
    yield "shaft.counterweight_radius", "three quarters of the space within the pins"
    yield "shaft.mounting", "a bearing on either side of the discs"
    yield "housing.outer_radius", "required"
    yield "drive.torque", "required torque divided by the ratio"
    yield "drive.speed", "required, or that of a four-pole motor at 50 Hz"
    yield "drive.power", f"{POWER_RESERVE:g} times the power of torque and speed"
    yield "service.life", "required"
    yield from _process_reasons(requirement, design)


def _clamping(design: Design) -> Iterator[tuple[str, str]]:
    """Yield the reasons for the support of the ring, with screws in stock."""
    screw = stock.bolt_under(2.0 * design.housing.bolt_radius)
    if design.housing.support == "rim" or not screw:
        yield "housing.support", "the wall behind the teeth has no space for the heads of screws in stock"
        return
    yield "housing.support", "the wall behind the teeth has space for the heads of screws in stock"
    yield "housing.bolt_radius", f"half the head of {screw.designation}"


def _process_reasons(requirement: Requirement, design: Design) -> Iterator[tuple[str, str]]:
    """Yield the reasons for materials, clearances and tolerances."""
    reasons = dict(PROCESSES[requirement.process].reasons)
    if requirement.material:
        reasons["material.name"] = "required"
    clearance = reasons.pop("clearance.pin_gear")
    if requirement.tightened:
        clearance = "the largest that the backlash allows, within the process's accuracy"
    elif requirement.clearance:
        clearance = "required"
    elif requirement.fit:
        clearance = f"mean clearance of {requirement.fit}, on the radius"
    reasons |= dict.fromkeys((f"clearance.{pair}" for pair in type(design.clearance).model_fields), clearance)
    if requirement.fit:
        reasons |= dict.fromkeys((f"tolerance.{zone}" for zone in FIT_TOLERANCES), "required")
    for table in ("material", *(f"{part}_material" for part in PARTS)):
        if material := getattr(design, table):
            numbers = [f"{table}.{key}" for key in type(material).model_fields if key != "name"]
            reasons |= dict.fromkeys(numbers, f"{material.name}, from the library")
    yield from reasons.items()
