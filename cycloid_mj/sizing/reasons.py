"""Why each value of a new drive is as it is, for the comments of its file."""

from collections.abc import Iterator

from cycloid_mj.design import Design, stock
from cycloid_mj.design.model import PARTS
from cycloid_mj.reducer.bodies import are_one_part
from cycloid_mj.sizing.process import PROCESSES
from cycloid_mj.sizing.proportions import DISC_SHARE, FITTED, OVERRATED, Proportions
from cycloid_mj.sizing.requirement import Requirement
from cycloid_mj.sizing.trial import TorqueTrial

THICKER = 0.015
"""Of the outer radius: by how much a wall is thicker than asked for, so that it is not by rounding."""


def reasons_of(asked: Requirement, of: Proportions, trial: TorqueTrial) -> Iterator[tuple[str, str]]:
    """Yield value and reason, by ``table.value``."""
    design, discs = trial.reducer.design, trial.reducer.design.gear.discs
    weakest = f"; at the torque asked for {trial.weakest.name} is the first to fail" if trial.weakest else ""
    yield "structure", "as drives are built: output pins bend, carrier, shaft and housing twist"
    yield "ring.teeth", f"the ratio {design.lobes} plus one"
    outer = design.housing.outer_radius
    wall = 1.0 - (design.ring.pin_circle_radius + design.ring.pin_radius) / outer
    needed = "" if wall < of.wall + THICKER else ", as the screws of the covers need it"
    yield "ring.pin_circle_radius", f"leaves a wall of {wall:.0%} of the outer radius{needed}"
    stock = "" if asked.custom else ", in stock"
    yield "ring.pin_radius", f"{of.pin:.0%} of the room between neighbours, about{stock}"
    yield "gear.eccentricity", f"K1 = c N / E = {of.short_width:g}: the largest with which nothing else is weaker"
    as_sold = "" if asked.custom else ", about, as long as pins in stock"
    yield "gear.face_width", f"{of.width:.0%} of the pin circle for all discs{as_sold}{weakest}"
    yield "gear.bore_radius", f"{of.bore:.0%} of the gear's root, about{stock and ', for a bearing in stock'}"
    if discs > 1:
        one_part = are_one_part(discs, design.output.pins, design.lobes)
        yield "gear.discs", "as asked for; they balance each other" if asked.discs else "one is too few"
        yield "output.pins", "with them all discs are one and the same part" if one_part else "discs differ as parts"
    else:
        yield "output.pins", "as many as leave walls between their holes"
    yield "gear.disc_gap", "room for a spacer, of several discs"
    yield "output.pin_circle_radius", "the middle of the web between bore and root"
    yield "output.pin_radius", f"its hole takes {of.hole:.0%} of the web, or of the room between neighbours"
    yield "output.hole_radius", "output pin + eccentricity"
    reach = stock and ", about: dowels in stock reach from face to face"
    yield "output.disc_thickness", f"{DISC_SHARE:.0%} of the outer radius{reach}"
    yield "output.support", "held at one end, the pins would bend away from the load"
    if stock:
        yield "output.core_radius", "a dowel in stock under the roller"
        yield "output.roller_bearing", "a turned sleeve has room on the dowel, needles have not"
        yield "shaft.bearing_width", "of a bearing in stock"
        yield from _clamping(design)
    yield "shaft.radius", f"at most {of.shaft:.0%} of the bore, and room for its bearing within the cam{stock}"
    yield "shaft.length", "room for a bearing" + (", and for the counterweight" if discs == 1 else "")
    yield "shaft.counterweight_radius", "three quarters of the room within the pins"
    yield "shaft.mounting", "a bearing on either side of the discs"
    yield "housing.outer_radius", "as asked for"
    yield "drive.torque", "the torque asked for, over the ratio"
    yield "drive.speed", "as asked for, or a motor with four poles at 50 Hz"
    yield "drive.power", f"{OVERRATED:g} times what torque and speed ask for"
    yield "service.life", "as asked for"
    yield from _made(asked, design)


def _clamping(design: Design) -> Iterator[tuple[str, str]]:
    """Yield why the ring is held as it is, where its screws are those in stock."""
    screw = stock.bolt_under(2.0 * design.housing.bolt_radius)
    if design.housing.support == "rim" or not screw:
        yield "housing.support", "the wall behind the teeth has no room for the heads of screws in stock"
        return
    yield "housing.support", "the wall behind the teeth has room for the heads of screws in stock"
    yield "housing.bolt_radius", f"half the head of {screw.designation}"


def _made(asked: Requirement, design: Design) -> Iterator[tuple[str, str]]:
    """Yield why materials, clearances and tolerances are as they are."""
    reasons = dict(PROCESSES[asked.process].reasons)
    if asked.material:
        reasons["material.name"] = "as asked for"
    clearance = reasons.pop("clearance.pin_gear")
    if asked.tightened:
        clearance = "what the backlash leaves, and the process can hold"
    elif asked.clearance:
        clearance = "as asked for"
    elif asked.fit:
        clearance = f"the mean of {asked.fit}, of the radius"
    reasons |= dict.fromkeys((f"clearance.{pair}" for pair in type(design.clearance).model_fields), clearance)
    if asked.fit:
        reasons |= dict.fromkeys((f"tolerance.{zone}" for zone in FITTED), "as asked for")
    for table in ("material", *(f"{part}_material" for part in PARTS)):
        if material := getattr(design, table):
            numbers = [f"{table}.{key}" for key in type(material).model_fields if key != "name"]
            reasons |= dict.fromkeys(numbers, f"of {material.name}, in the library")
    yield from reasons.items()
