"""Assembly instructions of a drive in ten steps, and the order of its parts along the axis."""

from cycloid_mj.base import names
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.parts.export.bearings import adhesive_of, hub_bearing_designation, roller_bearing
from cycloid_mj.parts.export.cam_clamp import cam_clamp
from cycloid_mj.parts.export.cam_splines import cam_spline
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.casing_rules import (
    in_one_piece,
    is_plastic,
)
from cycloid_mj.parts.export.crank_joints import cam_key, shrink_fit
from cycloid_mj.parts.export.crank_rings import bearing_spacers, crank_rings
from cycloid_mj.parts.export.hub_bearing import has_both_seats, needs_stop_ring
from cycloid_mj.parts.export.motor_mount import explain_bolt_circle, motor_screw
from cycloid_mj.reducer import Reducer

ALONG = (
    names.MOTOR_INSERT,
    names.MOTOR_COVER,
    names.MOTOR_SCREW,
    names.SCREW_INSERT,
    names.SHAFT_SEAL,
    names.SHAFT_RING,
    names.SHAFT_BEARING,
    names.BORE_RING,
    names.SHAFT,
    names.BEARING_SPACER,
    names.CRANK_RING,
    names.KEY,
    names.CAM,
    names.CAM_SCREW,
    names.SPACER,
    names.CAM_BEARING,
    names.STOP_RING,
    names.GEAR,
    names.PIN,
    names.PRESSED_PIN,
    names.HOUSING,
    names.DOWEL,
    names.ROLLER,
    names.ROLLER_BEARING,
    names.OUTPUT_PIN,
    names.OUTPUT,
    names.FLANGE_INSERT,
    names.OUTPUT_BEARING,
    names.OUTPUT_COVER,
    names.SCREW,
    names.RETAINER_INSERT,
    names.RETAINER,
    names.RETAINER_SCREW,
    names.FLANGE_DOWEL,
    names.FLANGE,
    names.LOAD_INSERT,
    names.FLANGE_WASHER,
    names.FLANGE_SCREW,
)
"""Families of parts from motor to load; the second disc of the output belongs to the first."""


def assembly_order(reducer: Reducer, casing: Casing) -> tuple[str, ...]:
    """Return the assembly instructions of a drive: ten steps in order, each a sentence with its parts and tools."""
    screws = casing.screws
    has_plastic, has_one_bearing = is_plastic(reducer), bool(casing.retainer or casing.motor_bearing)
    dowel_text = ", its dowels in their holes," if casing.dowel else ""
    flange_dowel_text = (
        f", press {casing.flange_screws} {names.FLANGE_DOWEL} into its face" if casing.flange_dowel else ""
    )
    return (
        "Deburr and wash all parts; oil what is pressed, grease bearings, holes and teeth"
        f"{'' if has_plastic else '; put sealant on both faces of the ring before a cover goes on'}.",
        "Set the threaded inserts with a hot iron." if has_plastic else "Check that each screw enters its thread.",
        _describe_output_pins(reducer),
        _describe_output_bearings(casing),
        f"{f'Press a {names.SHAFT_BEARING} into the hub of the {names.OUTPUT}; push' if casing.far else 'Push'} the "
        f"hub through {'it' if has_one_bearing else 'both'}{flange_dowel_text}, and screw the {names.FLANGE} "
        f"on ({casing.flange_screws} x {casing.flange_bolt.designation}"
        f"{', with washers' if has_plastic else ''}): "
        f"it clamps {'the inner ring' if has_one_bearing else 'them'}{_describe_preload(casing)}"
        f"{'' if casing.flange_dowel else '; centre it on the hub by a dial gauge, within 0.02 mm'}.",
        f"Lay the {names.HOUSING} on it{'' if casing.has_outer_dowels else dowel_text.rstrip(',')}"
        f"{_describe_ring_pins(reducer)}.",
        _describe_discs(reducer, casing),
        _describe_crank(reducer, casing),
        f"{_describe_motor_cover(reducer, casing)}, put it on{dowel_text} and tighten "
        f"{len(screws.angles)} x {screws.bolt.designation} x "
        f"{MILLIMETRES * screws.length:g} {'lightly' if casing.has_free_ring else 'crosswise'} from the output's side"
        f"{f'; snap the {names.SHAFT_RING} on the {names.SHAFT}' if casing.crank_end.shaft_ring else ''}.",
        _describe_last_step(reducer, casing),
    )


def _describe_output_bearings(casing: Casing) -> str:
    """Return the sentence of the assembly instructions on how the bearings of the output are mounted in their cover."""
    hub, ring = hub_bearing_designation(casing.hub), casing.retainer
    if ring:
        return (
            f"Put the {names.OUTPUT_BEARING} ({hub}) into the {names.OUTPUT_COVER} from outside, screw the "
            f"{names.RETAINER} on its outer ring ({ring.count} x {ring.bolt.designation}) and tighten "
            "crosswise in steps while it is turned."
        )
    if casing.motor_bearing:
        direction = "within, up to its lip" if casing.has_outer_lip else "outside, up to its shoulder"
        grease = "" if casing.has_outer_lip else "; pack both with grease"
        return (
            f"Press one {names.OUTPUT_BEARING} ({hub}) into the {names.OUTPUT_COVER} from {direction}; the "
            f"other one goes on the disc {names.SECOND_OUTPUT} later{grease}."
        )
    grease = ", back to back, and pack them with grease" if casing.hub.contact_angle else ""
    return (
        f"Press one {names.OUTPUT_BEARING} ({hub}) into the {names.OUTPUT_COVER} from within, the other one from "
        f"outside{grease}."
    )


def _describe_preload(casing: Casing) -> str:
    """Describe how a pair of bearings with a contact angle is preloaded; empty for deep groove bearings.

    A pair around both discs is preloaded when the covers are tight.
    """
    if not casing.hub.contact_angle:
        return ""
    moment = ", when the covers are tight," if casing.stop_ring else ""
    return f"; grind its raised face{moment} until the hub turns without play and not harder than by hand"


def _describe_motor_cover(reducer: Reducer, casing: Casing) -> str:
    """Return the sentence of the assembly instructions on the motor cover, into which bearings are pressed.

    A motor with tapped holes is first bolted on from within.
    """
    article = "the" if casing.far else "both"
    spacer_text = f", both {names.BEARING_SPACER} between them" if bearing_spacers(reducer, casing) else ""
    seal_text = f"the {names.SHAFT_SEAL}, its lip towards the discs, and " if casing.crank_end.seal else ""
    ring_text = f", snap the {names.BORE_RING} in" if casing.crank_end.bore_ring else ""
    press_text = (
        f"press {seal_text}{article} {names.SHAFT_BEARING} into the {names.MOTOR_COVER}{spacer_text}{ring_text}"
    )
    if not casing.motor.tapped:
        return f"P{press_text[1:]}"
    bolt, length = motor_screw(casing.motor, casing.wall)
    screws_text = f"{casing.motor.screws} x {bolt.designation} x {MILLIMETRES * length:g}"
    test_text, glue_text = "Turn the crank by hand through one turn", ""
    if casing.motor.shaft:
        adhesive = adhesive_of(reducer.design.material_of(names.SHAFT).is_plastic)
        glue_text = f", put {adhesive} into the bore of the {names.SHAFT}"
    return f"{test_text}; bolt the motor on ({casing.motor.name}, {screws_text} from within), {press_text}{glue_text}"


def _describe_last_step(reducer: Reducer, casing: Casing) -> str:
    """Return the last sentence of the assembly instructions: mount the motor, or turn the drive."""
    motor, centring_text = casing.motor, ""
    if casing.has_free_ring:
        centring_text = f", which centres the {names.HOUSING} on the disc; then tighten the screws crosswise"
    if reducer.design.shaft.bore_radius:
        return (
            f"Turn the crank by hand through one turn{centring_text}; clamp a belt pulley, or the rotor of a frameless "
            "motor, on the end of the crank, and pass cables or a tool through its bore."
        )
    if motor.tapped:
        shaft_text = "glued into the bore" if motor.shaft else "in a bore that you drill into the end"
        return f"Let the motor, its shaft {shaft_text} of the crank, turn it slowly for a turn{centring_text}."
    bolts_text = (
        f"{motor.screws} x M{MILLIMETRES * motor.thread:g} on a circle of {2.0 * MILLIMETRES * motor.circle:.4g} mm"
    )
    if motor.shaft:
        motor_text = f"bolt the motor on ({motor.name}, {bolts_text}), its shaft glued into the bore of the crank"
    else:
        depth = f"{MILLIMETRES * (casing.journal - casing.face):.3g} mm"
        motor_text = (
            f"bolt the motor on ({motor.name}, {bolts_text}); the crank ends {depth} behind the face and has no bore"
            f"{explain_bolt_circle(reducer, casing.outer, casing.seat, casing.wall, casing.cavity)}: state "
            "--motor-shaft-mm, or make it longer for a coupling (shaft.length_mm)"
        )
    return f"Turn the crank by hand through one turn{centring_text}; {motor_text}."


def _describe_output_pins(reducer: Reducer) -> str:
    """Return the sentence of the assembly instructions on how the output pins are mounted or inspected."""
    if in_one_piece(reducer):
        return "Check that the output pins, in one piece with their disc, are round and smooth."
    roller_step = ""
    if stock_bearing := roller_bearing(reducer):
        bearing, count = stock_bearing
        roller_step = f"; press {count} {names.ROLLER_BEARING} ({bearing.designation}) into each roller"
    return (
        f"Press {reducer.design.output.pins} output pins into the disc of the {names.OUTPUT}, flush with its far face"
        f"{roller_step}."
    )


def _describe_ring_pins(reducer: Reducer) -> str:
    """Return the sentence of the assembly instructions on how the ring pins are inserted; empty without pins."""
    ring = reducer.design.ring
    if ring.kind != "pin":
        return ""
    if ring.has_sleeves:
        return f", press the pins of the sleeves into the {names.OUTPUT_COVER} and put the sleeves on them"
    if ring.has_sockets:
        return "; put the pins into their sockets with grease, which keeps them there until the disc does"
    adhesive = adhesive_of(is_plastic(reducer))
    return f"; glue the pins into their sockets ({adhesive}) and let it cure before the disc goes in"


def _describe_discs(reducer: Reducer, casing: Casing) -> str:
    """Return the sentence of the assembly instructions that mounts a single disc, or several discs with their crank."""
    design = reducer.design
    if design.gear.discs == 1:
        rollers = "; put a roller on each output pin, and the" if design.output.rollers else "; put the"
        bearing_step = _describe_cam_bearing(reducer)
        return f"{bearing_step}{rollers} {names.GEAR} over them{_describe_second_disc(reducer)}."
    if design.has_one_piece_crank:
        gear_1, gear_2 = reducer.gears
        bearing_step = f"put the {names.CAM_BEARING}s on the cams in grease"
        if cam_bearing(reducer):
            bearing_step = f"press a {names.CAM_BEARING} into each gear"
        return (
            f"The {names.SHAFT} is one piece with its cams: {bearing_step}, then push {gear_1} on cam 1 from the motor "
            f"end of the crank, and {gear_2} on cam 2 from its output end, each up to the collar between them."
        )
    if clamp := cam_clamp(reducer):
        screws = f"{clamp.count} x {clamp.bolt.designation} x {MILLIMETRES * clamp.length:g}"
        return (
            f"Clamp each cam on the shaft in a fixture that sets its phase ({screws}), then push its gear with the "
            f"bearing over it: cam 1, gear 1, a {names.SPACER}, cam 2, gear 2."
        )
    if shrink := shrink_fit(reducer, casing):
        return (
            f"Shrink each cam on the shaft in a fixture that sets its phase: cam and shaft {shrink.difference:.0f} K "
            "apart, by an oven (200 °C at most) and dry ice. When it is cold, push its gear with the bearing over it: "
            f"cam 1, gear 1, a {names.SPACER}, cam 2, gear 2{' and so on' if design.gear.discs > 2 else ''}."
        )
    first_step = (
        "Lay the key into the shaft" if cam_key(reducer, casing) else "Mark the phases of the cams on the shaft"
    )
    is_glued = not (cam_key(reducer, casing) or cam_spline(reducer))
    adhesive = adhesive_of(design.material_of(names.SHAFT).is_plastic)
    retaining_note = f" with {adhesive}" if is_glued else ""
    return (
        f"{first_step}. Put each cam with its bearing into its gear, then push them on the shaft from its output "
        f"end{retaining_note}: gear 1, a {names.SPACER}, gear 2{' and so on' if design.gear.discs > 2 else ''}."
    )


def _describe_cam_bearing(reducer: Reducer) -> str:
    """Return a phrase on how the bearing of a single disc is mounted: pressed in, as rollers in the bore, or none."""
    if reducer.design.gear.bearing != "rolling":
        return "Oil its bore"
    if cam_bearing(reducer):
        return f"Press the {names.CAM_BEARING} into the {names.GEAR}"
    rollers = f"the rollers of its {names.CAM_BEARING}"
    return f"Line the bore of the {names.GEAR} with {rollers}, in grease that keeps them there"


def _describe_crank(reducer: Reducer, casing: Casing) -> str:
    """Return the sentence of the assembly instructions that mounts the crank, with several discs together with them."""
    design, rings = reducer.design, {ring.name for ring in crank_rings(reducer, casing)}
    first_ring, second_ring = (names.numbered_name(names.CRANK_RING, number) for number in (1, 2))
    ring_notes = [f"{first_ring} on its journal"] * (first_ring in rings) + [f"{second_ring} on its far end"] * (
        second_ring in rings
    )
    if design.gear.discs == 1:
        start = f"Put {' and '.join(ring_notes)}; push" if ring_notes else "Push"
        return f"{start} the {names.SHAFT}, one piece with cam and counterweight, through from the motor's side."
    rollers = "Put a roller on each output pin; lower" if design.output.rollers else "Lower"
    ring_clause = f"; put {ring_notes[0]}" if first_ring in rings else ""
    far_ring_note = f"{second_ring} on, " if second_ring in rings else ""
    disc = _describe_second_disc(reducer)
    return f"{rollers} the crank, {far_ring_note}with its gears over the output pins into the ring{disc}{ring_clause}."


def _describe_second_disc(reducer: Reducer) -> str:
    """Return the clause of the assembly instructions on the second disc of the output; empty without one."""
    if reducer.design.output.support != "both_ends":
        return ""
    if not has_both_seats(reducer):
        return f"; press the disc {names.SECOND_OUTPUT} on the pins"
    if not needs_stop_ring(reducer):
        return f"; press the disc {names.SECOND_OUTPUT} on the pins, and one {names.OUTPUT_BEARING} on it"
    return (
        f"; press one {names.OUTPUT_BEARING} on the disc {names.SECOND_OUTPUT}, up to its shoulder; put the "
        f"{names.STOP_RING} on the {names.HOUSING}, and press the disc on the pins"
    )
