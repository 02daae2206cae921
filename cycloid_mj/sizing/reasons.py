"""Reasons for the values of a new drive, for the comments of its file."""

from collections.abc import Iterator

from cycloid_mj.design import Design, stock
from cycloid_mj.design.model import PARTS
from cycloid_mj.design.processes import FIT_TOLERANCES, POSITIONS, PROCESSES, TOLERANCE_SHARE
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import are_discs_identical
from cycloid_mj.sizing.candidates import (
    DISC_SHARE,
    POWER_RESERVE,
    has_plastic_discs,
)
from cycloid_mj.sizing.requirement import Requirement

REASONS = {
    "structure": "includes bending of output pins and torsion of carrier, shaft and housing",
    "gear.disc_gap": "space for a spacer between several discs",
    "output.pin_circle_radius": "the middle of the web between bore and root",
    "output.pin_radius": "by the search",
    "output.hole_radius": "output pin + eccentricity",
    "output.disc_thickness": f"{DISC_SHARE:.0%} of the outer radius; dowels in stock reach from face to face",
    "output.support": "supported at one end, the pins would bend away from the load",
    "output.core_radius": "the thickest dowel within the roller",
    "shaft.bearing_width": "width of a bearing in stock",
    "shaft.length": "space for bearings and counterweight",
    "shaft.counterweight_radius": "three quarters of the space within the pins",
    "shaft.mounting": "a bearing on either side of the discs",
    "drive.torque": "required torque divided by the ratio",
    "drive.speed": "required, or usual for the process",
    "drive.power": f"{POWER_RESERVE:g} times the power of torque and speed",
    **dict.fromkeys(
        (f"service.{key}" for key in ("life", "duty_share", "film_coefficient", "ambient_temperature")),
        "required, or usual for the process",
    ),
}
"""Reasons that are the same for each drive, by the key of the value, ``table.key``."""


def reasons_of(requirement: Requirement, reducer: Reducer, weakest: str) -> Iterator[tuple[str, str]]:
    """Yield pairs of a key of the design file and the reason for its value, such as ("gear.discs", "required").

    `weakest` is the name of the part that fails first.
    """
    design = reducer.design
    ring, gear, output, housing = design.ring, design.gear, design.output, design.housing
    by_search, bought = "by the search", "" if requirement.custom else ", in stock"
    wall = 1.0 - (ring.pin_circle_radius + ring.pin_radius) / housing.outer_radius
    yield from REASONS.items()
    yield "ring.teeth", f"ratio {design.lobes} plus one"
    yield "ring.pin_circle_radius", f"{by_search}; leaves a wall of {wall:.0%} of the outer radius"
    yield "ring.pin_radius", f"{by_search}{bought}"
    k1 = gear.eccentricity * ring.teeth / ring.pin_circle_radius
    yield "gear.eccentricity", f"{by_search}; K1 = c N / E = {k1:.3g}"
    length = "" if requirement.custom else ", as long as pins in stock"
    yield "gear.face_width", f"{by_search}{length}; at the required torque {weakest} fails first"
    yield "gear.bore_radius", f"{by_search}{bought and ', for a bearing in stock'}"
    if gear.discs > 1:
        yield "gear.discs", "required; they balance each other" if requirement.discs else "one disc is not enough"
    parts = "identical parts" if are_discs_identical(gear.discs, output.pins, design.lobes) else "different parts"
    yield "output.pins", by_search if gear.discs == 1 else f"{by_search}; the discs are {parts}"
    if output.main_bearings == "angular_contact":
        yield "output.main_bearings", "several times the tilting moment and stiffness of deep groove bearings"
    is_tube = has_plastic_discs(requirement) and stock.is_tube(2.0 * output.pin_radius)
    tube = "a sleeve from a precision steel tube" if is_tube else "a turned sleeve"
    if not output.rollers:
        yield "output.rollers", "dowels alone, on which the discs of plastic slide: thicker than under a sleeve"
        yield "output.core_radius", "without rollers the pins are solid"
    elif not output.has_needles:
        yield "output.roller_bearing", f"{tube} on the dowel: thinner than a needle bearing"
    else:
        yield "output.roller_bearing", "drawn cup needle bearings in the rollers, on hardened dowels: less loss"
        yield "bearing.output_dynamic_capacity", "of the drawn cup needle bearing in the roller"
    yield "shaft.radius", f"{by_search}{bought}, with space for its bearing within the cam"
    screw = None if housing.support == "rim" else stock.bolt_under(2.0 * housing.bolt_radius)
    yield "housing.support", f"the wall behind the teeth has {'' if screw else 'no '}space for heads of screws in stock"
    if screw:
        yield "housing.bolt_radius", f"half the head of {screw.designation}"
    is_inset = 2.0 * housing.outer_radius < requirement.diameter - 1e-6
    yield (
        "housing.outer_radius",
        "covers with screws outside of it have the required size" if is_inset else "required",
    )
    yield from _process_reasons(requirement, design)


def _process_reasons(requirement: Requirement, design: Design) -> Iterator[tuple[str, str]]:
    """Yield (key, reason) for materials, clearances and tolerances, such as ("clearance.pin_gear", "required")."""
    limits = PROCESSES[requirement.process]
    reasons = dict(limits.reasons) | ({"material.name": "required"} if requirement.material else {})
    clearance = reasons.pop("clearance.pin_gear")
    if requirement.tightened:
        clearance = "the largest found with which the drive has the required torque and backlash"
    elif requirement.clearance:
        clearance = "required"
    elif requirement.fit:
        clearance = f"mean clearance of {requirement.fit}, on the radius"
    if requirement.usual_clearance < limits.finest:
        clearance += "; parts are measured and matched, pins of one group (ISO 3096)"
    reasons |= dict.fromkeys((f"clearance.{pair}" for pair in type(design.clearance).model_fields), clearance)
    if design.clearance.cam < design.clearance.pin_gear:
        reasons["clearance.cam"] = "usual for a ground cam in its bearing"
    default = (
        f"usual for {requirement.process}: six standard deviations are {6.0 * TOLERANCE_SHARE:.0%} of the clearance"
    )
    reasons |= dict.fromkeys((f"tolerance.{key}" for key in (*POSITIONS, "cam_position")), default)
    reasons |= dict.fromkeys(
        (f"tolerance.{zone}" for zone in FIT_TOLERANCES), "required" if requirement.fit else default
    )
    for table in ("material", *(f"{part}_material" for part in PARTS)):
        if material := getattr(design, table):
            numbers = [f"{table}.{key}" for key in type(material).model_fields if key != "name"]
            reasons |= dict.fromkeys(numbers, f"{material.name}, from the library")
    yield from reasons.items()
