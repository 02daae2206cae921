"""Assembly instructions of a drive in ten steps, and the order of its parts along the axis."""

from cycloid_mj.base import names
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts.export.casing import (
    CAM_BEARING,
    DOWEL,
    FLANGE,
    FLANGE_INSERT,
    FLANGE_SCREW,
    LOAD_INSERT,
    MOTOR_COVER,
    MOTOR_INSERT,
    MOTOR_SCREW,
    OUTPUT_BEARING,
    OUTPUT_COVER,
    SCREW,
    SCREW_INSERT,
    SHAFT_BEARING,
    Casing,
    in_one_piece,
    is_plastic,
    motor_screw,
)
from cycloid_mj.parts.export.crank_joints import KEY
from cycloid_mj.parts.export.crank_rings import CRANK_RING
from cycloid_mj.parts.export.joint import OUTPUT_PIN, PRESSED_PIN, SECOND_OUTPUT
from cycloid_mj.reducer import Reducer

ALONG = (
    MOTOR_INSERT,
    MOTOR_COVER,
    MOTOR_SCREW,
    SCREW_INSERT,
    SHAFT_BEARING,
    names.SHAFT,
    CRANK_RING,
    KEY,
    names.CAM,
    names.SPACER,
    CAM_BEARING,
    names.GEAR,
    names.PIN,
    PRESSED_PIN,
    names.HOUSING,
    DOWEL,
    names.ROLLER,
    OUTPUT_PIN,
    names.OUTPUT,
    FLANGE_INSERT,
    OUTPUT_BEARING,
    OUTPUT_COVER,
    SCREW,
    FLANGE,
    LOAD_INSERT,
    FLANGE_SCREW,
)
"""Families of parts from motor to load; the second disc of the output belongs to the first."""


def assembly_order(reducer: Reducer, sizes: Casing) -> tuple[str, ...]:
    """Describe the assembly of a drive in ten steps, with parts and tools of each."""
    design, screws, hub = reducer.design, sizes.screws, sizes.hub.designation
    printed, free = is_plastic(reducer), design.ring.has_sockets
    dowels = ", its dowels in their holes," if sizes.dowel else ""
    return (
        "Deburr and wash all parts; oil what is pressed, grease bearings, holes and teeth.",
        "Set the threaded inserts with a hot iron." if printed else "Check that each screw enters its thread.",
        _output_pins(reducer),
        f"Press one {OUTPUT_BEARING} ({hub}) into the {OUTPUT_COVER} from within, the other one from outside.",
        f"{f'Press a {SHAFT_BEARING} into the hub of the {names.OUTPUT}; push' if sizes.far else 'Push'} the hub "
        f"through both, and screw the {FLANGE} on ({sizes.flange_screws} x {sizes.flange_bolt.designation}): it clamps "
        "them.",
        f"Lay the {names.HOUSING} on it{dowels if not screws.outside else ''} and "
        f"{'put the pins into their sockets' if free else 'check that all pins are flush'}.",
        _discs(reducer),
        _crank(reducer),
        f"{_first_on_cover(sizes)}the {SHAFT_BEARING} into the {MOTOR_COVER}, put it on{dowels} and tighten "
        f"{len(screws.angles)} x {screws.bolt.designation} x {MILLIMETRES * screws.length:g} crosswise from the "
        "output's side.",
        _last(sizes),
    )


def _first_on_cover(sizes: Casing) -> str:
    """Describe the step before the bearing of the motor cover: a tapped motor is bolted on from within."""
    if not sizes.motor.tapped:
        return "Press "
    bolt, length = motor_screw(sizes.motor, sizes.wall)
    screws = f"4 x {bolt.designation} x {MILLIMETRES * length:g}"
    return (
        f"Turn the crank by hand through one turn; bolt the motor on ({sizes.motor.name}, {screws} from within), press "
    )


def _last(sizes: Casing) -> str:
    """Describe the last step: mount the motor, or let a mounted motor turn the drive."""
    motor = sizes.motor
    if motor.tapped:
        return "Let the motor, its shaft glued into the bore of the crank, turn it slowly for a turn."
    return (
        f"Turn the crank by hand through one turn; bolt the motor on ({motor.name}, 4 x "
        f"M{MILLIMETRES * motor.thread:g} on a circle of {2.0 * MILLIMETRES * motor.circle:.4g} mm), its shaft "
        f"{'glued into the bore' if motor.shaft else 'coupled to the end'} of the crank."
    )


def _output_pins(reducer: Reducer) -> str:
    """Describe the step that mounts or inspects the output pins."""
    if in_one_piece(reducer):
        return "Check that the output pins, in one piece with their disc, are round and smooth."
    return (
        f"Press {reducer.design.output.pins} output pins into the disc of the {names.OUTPUT}, flush with its far face."
    )


def _discs(reducer: Reducer) -> str:
    """Describe the step that mounts the discs, and the second disc of the output if there is one."""
    design = reducer.design
    rollers = "Put a roller on each output pin, and the" if design.output.rollers else "Put the"
    gears = f"{names.GEAR} over them"
    if design.gear.discs > 1:
        gears = f"{design.gear.discs} gears over them, gear {design.gear.discs} first, a {names.SPACER} between two"
    second = f"; press the disc {SECOND_OUTPUT} on the pins" if design.output.support == "both_ends" else ""
    return f"{rollers} {gears}{second}."


def _crank(reducer: Reducer) -> str:
    """Describe the step that mounts the crank."""
    if reducer.design.gear.discs > 1:
        return "Push the shaft through, and with it each cam with its bearing into its gear, as marked by their turn."
    bearing = "Press the cam's bearing into the gear, and push" if reducer.design.gear.bearing == "rolling" else "Push"
    return f"{bearing} the {names.SHAFT}, one piece with cam and counterweight, through from the motor's side."
