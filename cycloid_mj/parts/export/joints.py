"""The joints of a drive: each connection of parts as one record of mating parts, fit and geometry.

A joint states the holes that it needs in its mating parts, and the bought parts that make it. Solids and places
(`casing_parts`) and the bill of materials (`bill`) are views of these records.
"""

from collections.abc import Iterable, Iterator

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.units import in_mm
from cycloid_mj.design import stock
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts import crank_segments
from cycloid_mj.parts.export.bearings import (
    DOWEL_FIT,
    DOWEL_MATERIAL,
    cup_fit,
    hub_bearing_designation,
    hub_bearing_fit,
    shaft_bearing,
    shaft_bearing_fit,
)
from cycloid_mj.parts.export.casing import (
    Casing,
    bearing_width_of,
    dowel_centres,
    flange_centres,
    flange_dowel_centres,
    motor_centres,
    output_cover_step,
)
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    core_radius,
    counterbore,
    flange_washer,
    hole_depth,
    insert_in,
    is_printed,
    shoulder_radius,
    thickest_bolt,
)
from cycloid_mj.parts.export.crank_joints import crank_joints
from cycloid_mj.parts.export.joint import BoughtPart, CrossHole, Joint, JointKind, Point, TappedHole
from cycloid_mj.parts.export.motor_mount import motor_grip, motor_screw
from cycloid_mj.parts.export.output_flange import flange_screw_depth, flange_screw_length, pattern_angles
from cycloid_mj.parts.export.round_part import AXIS, Hole, dowel_body, screw_body, tube
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.reducer.bending import AXIAL_GAP

ITEMS = (
    *(names.SCREW, names.FLANGE_SCREW, names.FLANGE_WASHER, names.MOTOR_SCREW, names.RETAINER_SCREW),
    *(names.OUTPUT_BEARING, names.SHAFT_BEARING, *names.RETAINING_RINGS, names.SHAFT_SEAL),
    *(*names.INSERTS, names.DOWEL, names.FLANGE_DOWEL, names.KEY, names.CAM_SCREW),
)
"""Bought parts of joints, in the order of solids and places."""

SEAT_PLAY = 0.05e-3
"""Radial play of a ring in the cover around it, as dowels locate it [m] (heuristic): less than a printer or a lathe
is off."""

MOTOR_SHAFT_FIT, PILOT_FIT, RING_FIT, LOOSE_RING_FIT = "H7, retaining compound", "H8", "g6 in H7", "h9 in H9"
"""Fits of the motor's shaft (h6 to h7) and pilot (h8), and of a ring in its cover without and with dowels (assumed).
A cover of aluminium shrinks by 40 um more than a ring of 90 mm from 20 to -20 °C: without play it would squeeze it."""

MOTOR, LOAD = "motor", "load"
"""Mating parts that are not part of the drive."""

USUAL_CLASS, FLANGE_CLASS = "8.8", "12.9"
"""Property classes of screws (ISO 898-1); those of the output flange, and of the load on it, carry the whole torque."""


@once
def drive_joints(reducer: Reducer, casing: Casing) -> tuple[Joint, ...]:
    """Return all joints between parts of a drive with its casing: fits, bearing seats, screws, threads and dowels.

    They are listed from motor to load, then those of the crank.
    """
    return (
        *_motor_shaft_joint(reducer, casing),
        _motor_pilot_joint(casing),
        _cover_bearing_joint(reducer, casing),
        *_crank_end_joints(reducer, casing),
        *_cavity_joints(casing),
        *_second_disc_joint(casing),
        _output_bearing_joint(casing),
        *_retainer_joint(reducer, casing),
        _cover_screw_joint(reducer, casing),
        _motor_screw_joint(reducer, casing),
        *_ring_seat_joint(reducer, casing),
        _flange_screw_joint(reducer, casing),
        *_hub_bore_joint(reducer, casing),
        *_hub_bearing_joint(reducer, casing),
        _load_thread_joint(reducer, casing),
        *_dowel_joints(casing),
        *_flange_dowel_joint(casing),
        *crank_joints(reducer, casing),
    )


def bought_parts(joints: Iterable[Joint]) -> Iterator[BoughtPart]:
    """Yield the bought parts of joints in the order of `ITEMS` and of their numbers."""
    parts = [part for joint in joints for part in joint.bought]
    yield from sorted(parts, key=lambda part: (ITEMS.index(part.item), part.first))


def cross_holes_of(reducer: Reducer, casing: Casing, part: str) -> tuple[CrossHole, ...]:
    """Return the holes across the axis of a part of a drive."""
    joints = drive_joints(reducer, casing)
    return tuple(hole for joint in joints for name, hole in joint.cross_holes if name == part)


def _motor_shaft_joint(reducer: Reducer, casing: Casing) -> Iterator[Joint]:
    bore = casing.motor_bore
    if bore:
        hole, seat = (AXIS, *bore), (1, 2.0 * bore[0], bore[2] - bore[1])
        parts, name = (MOTOR, names.SHAFT), "shaft of the motor in the crank"
        yield Joint(name, JointKind.LOCATED, parts, ((names.SHAFT, hole),), (), MOTOR_SHAFT_FIT, *seat)


def _motor_pilot_joint(casing: Casing) -> Joint:
    recess = (AXIS, casing.motor.pilot, casing.face, casing.face + RULES.pilot_depth)
    parts, seat = (MOTOR, names.MOTOR_COVER), (1, 2.0 * casing.motor.pilot, RULES.pilot_depth)
    return Joint("pilot of the motor", JointKind.LOCATED, parts, ((names.MOTOR_COVER, recess),), (), PILOT_FIT, *seat)


def _cover_bearing_joint(reducer: Reducer, casing: Casing) -> Joint:
    """Return the joint of shaft and motor cover by bearings: one, or both of an overhung shaft."""
    seat_start = casing.seat_start
    shoulder = shoulder_radius(casing.seat, reducer.design.shaft.radius)
    holes: tuple[Hole, ...] = (
        (AXIS, shoulder, casing.face + RULES.pilot_depth, seat_start),
        *_seat_holes(casing, seat_start),
    )
    numbers = (2,) if casing.far else (1, 2)
    return Joint(
        "shaft in the motor cover",
        JointKind.BEARING,
        (names.SHAFT, names.MOTOR_COVER),
        tuple((names.MOTOR_COVER, hole) for hole in holes),
        (bearings := _shaft_bearings(reducer, casing, numbers),),
        bearings.fit,
        len(numbers),
        2.0 * reducer.design.shaft.radius,
        bearing_width_of(reducer),
    )


def _seat_holes(casing: Casing, start: float) -> Iterator[Hole]:
    """Yield the seat of the bearings in the motor cover, and the groove of their retaining ring if there is one.

    `start` [m] is the lower end of the seat along z.
    """
    ring, groove_start = casing.crank_end.bore_ring, casing.near[1]
    if ring:
        groove_end = groove_start + ring.groove_width
        yield AXIS, casing.seat, start, groove_start
        yield AXIS, 0.5 * ring.groove, groove_start, groove_end
        start = groove_end
    yield AXIS, casing.seat, start, casing.floor


def _crank_end_joints(reducer: Reducer, casing: Casing) -> Iterator[Joint]:
    """Yield the joints of parts next to the bearings of the crank: retaining rings in grooves, or a seal ring."""
    crank_end, (start, end) = casing.crank_end, casing.near
    if ring := crank_end.shaft_ring:
        solid = _retaining_ring(names.SHAFT_RING, ring, names.SHAFT, start - 0.5 * ring.thickness)
        yield _retaining_ring_joint("retaining ring on the crank", names.SHAFT, ring, solid)
    if ring := crank_end.bore_ring:
        solid = _retaining_ring(names.BORE_RING, ring, names.HOUSING, end + 0.5 * ring.thickness)
        yield _retaining_ring_joint("retaining ring in the motor cover", names.MOTOR_COVER, ring, solid)
    if seal := crank_end.seal:
        fit = f"{cup_fit(reducer, names.HOUSING)} outside, lip on the hardened and ground crank (Ra 0.2 to 0.8 um)"
        seal_part = BoughtPart(
            names.SHAFT_SEAL,
            tube(0.5 * seal.bore, 0.5 * seal.outside, seal.width),
            names.HOUSING,
            ((0.0, 0.0, start - 0.5 * seal.width),),
            (("outside diameter", seal.outside), ("bore", seal.bore), ("length", seal.width)),
            "nitrile rubber on steel",
            seal.designation,
            fit,
        )
        yield Joint("seal of the crank", JointKind.LOCATED, (names.SHAFT, names.MOTOR_COVER), (), (seal_part,), fit)


def _retaining_ring(item: str, ring: stock.RetainingRing, body: str, middle: float) -> BoughtPart:
    """Return a retaining ring as a bought part.

    `item` is its name, `body` that of the body that it moves with, and `middle` the height of its middle [m].
    """
    dimensions = ("diameter", ring.diameter), ("length", ring.thickness)
    fit = f"groove {in_mm(ring.groove)} x {in_mm(ring.groove_width)} mm"
    solid, origins = tube(*ring.radii, ring.thickness), ((0.0, 0.0, middle),)
    return BoughtPart(item, solid, body, origins, dimensions, "spring steel", ring.designation, fit)


def _retaining_ring_joint(name: str, part: str, ring: stock.RetainingRing, bought: BoughtPart) -> Joint:
    """Return the joint `name` of a retaining ring in the groove of `part`, which locates a bearing of the crank."""
    seat = 1, ring.groove, ring.groove_width
    return Joint(name, JointKind.LOCATED, (part, names.SHAFT_BEARING), (), (bought,), ring.groove_zone, *seat)


def _hub_bearing_joint(reducer: Reducer, casing: Casing) -> Iterator[Joint]:
    """Yield the joint of a straddled shaft and the hub of the output by a bearing; none for an overhung shaft."""
    if casing.far:
        disc_start = reducer.design.gear.stack_width / 2.0 + AXIAL_GAP
        recess_radius = shoulder_radius(casing.seat, reducer.design.shaft.radius)
        holes: tuple[tuple[str, Hole], ...] = (
            (names.OUTPUT, (AXIS, casing.seat, disc_start, casing.far[1])),
            (names.OUTPUT, (AXIS, recess_radius, casing.far[1], casing.far[1] + RULES.collar)),
        )
        bearing = _shaft_bearings(reducer, casing, (1,))
        parts = (names.SHAFT, names.OUTPUT)
        shaft_diameter, width = 2.0 * reducer.design.shaft.radius, bearing_width_of(reducer)
        yield Joint(
            "shaft in the hub", JointKind.BEARING, parts, holes, (bearing,), bearing.fit, 1, shaft_diameter, width
        )


def _shaft_bearings(reducer: Reducer, casing: Casing, numbers: tuple[int, ...]) -> BoughtPart:
    """Return one bought part with a position for each shaft bearing in `numbers`.

    Number 1 is the bearing far from the discs (with a straddled shaft, in the hub), 2 is near the discs.
    """
    seats = bearing_seats(reducer, crank_segments(reducer))
    middles = [0.5 * (seat_start + seat_end) for seat_start, seat_end in seats]
    radius, width, bearing = reducer.design.shaft.radius, bearing_width_of(reducer), shaft_bearing(reducer)
    return BoughtPart(
        names.SHAFT_BEARING,
        tube(radius, casing.seat, width),
        names.SHAFT,
        tuple((0.0, 0.0, middles[number - 1]) for number in numbers),
        bearing_dimensions(bearing)
        if bearing
        else (("outside diameter", 2.0 * casing.seat), ("bore", 2.0 * radius), ("length", width)),
        designation=bearing.designation if bearing else "",
        fit=shaft_bearing_fit(reducer),
        first=numbers[0],
    )


def _cavity_joints(casing: Casing) -> Iterator[Joint]:
    """Yield the clearances of crank and output in the cavities of the covers, as joints with a hole each."""
    crank_hole = (
        AXIS,
        casing.cavity,
        casing.floor,
        _second_seat_start(casing) if casing.motor_bearing else -casing.end,
    )
    parts = names.SHAFT, names.MOTOR_COVER
    yield Joint("crank in its cavity", JointKind.CLEARANCE, parts, ((names.MOTOR_COVER, crank_hole),))
    output_hole = (AXIS, casing.output_cavity, casing.end, casing.hub_floor)
    parts = names.OUTPUT, names.OUTPUT_COVER
    yield Joint("output in its cavity", JointKind.CLEARANCE, parts, ((names.OUTPUT_COVER, output_hole),))


def _output_bearing_joint(casing: Casing) -> Joint:
    """Return the joint of the output's hub and its cover: two bearings on a common shoulder, or a single bearing.

    The shoulder of a single ball bearing is a lip at the end of the cover; the other bearing is in the motor cover. If
    both are back to back, the shoulder is next to the ring.
    """
    hub, seat_radius, (*inner_seats, (outer_start, seat_end)) = casing.hub, 0.5 * casing.hub.outside, casing.bearings
    shoulder = hub.shoulders[1]
    holes: tuple[Hole, ...] = (
        (AXIS, seat_radius, casing.hub_floor, seat_end),
        (AXIS, shoulder, seat_end, casing.output_cover_end),
    )
    if not casing.has_outer_lip:
        other_seats = () if casing.motor_bearing else inner_seats
        shoulder_start = other_seats[0][1] if other_seats else casing.hub_floor
        holes = (
            *((AXIS, seat_radius, *ends) for ends in other_seats),
            (AXIS, shoulder, shoulder_start, outer_start),
            (AXIS, seat_radius, outer_start, seat_end),
        )
    bearings = _output_bearings(casing, casing.bearings[-1:] if casing.motor_bearing else casing.bearings)
    parts = (names.OUTPUT, names.OUTPUT_COVER)
    cover_holes = tuple((names.OUTPUT_COVER, hole) for hole in holes)
    name, fit, count = "hub in the output cover", bearings.fit, len(bearings.origins)
    return Joint(name, JointKind.BEARING, parts, cover_holes, (bearings,), fit, count, hub.bore, hub.width)


def _second_disc_joint(casing: Casing) -> Iterator[Joint]:
    """Yield the joint of the second disc of the output and the motor cover by a bearing, if there is one around it."""
    if not casing.motor_bearing:
        return
    hub, bearing, ring = casing.hub, _output_bearings(casing, (casing.motor_bearing,)), casing.stop_ring
    seat_end = -casing.end - (ring.thickness if ring else 0.0)
    hole = names.MOTOR_COVER, (AXIS, 0.5 * hub.outside, _second_seat_start(casing), seat_end)
    parts, name = (names.SECOND_OUTPUT, names.MOTOR_COVER), "second disc in the motor cover"
    yield Joint(name, JointKind.BEARING, parts, (hole,), (bearing,), bearing.fit, 1, hub.bore, hub.width)
    if ring:
        recess = names.MOTOR_COVER, (AXIS, ring.radius + SEAT_PLAY, seat_end, -casing.end)
        bore = names.STOP_RING, (AXIS, ring.bore, seat_end, -casing.end)
        ring_parts = names.HOUSING, names.STOP_RING, names.MOTOR_COVER
        yield Joint("stop ring in the motor cover", JointKind.LOCATED, ring_parts, (recess, bore))


def _second_seat_start(casing: Casing) -> float:
    """Return the start [m] of the seat of the bearing around the second disc, whose ends must be known.

    A seat next to a stop ring has play at its other end, so that the stop ring alone supports the outer ring.
    """
    assert casing.motor_bearing
    return casing.motor_bearing[0] - (casing.play if casing.stop_ring else 0.0)


def _output_bearings(casing: Casing, bearing_ends: tuple[tuple[float, float], ...]) -> BoughtPart:
    """Return the bought part of equal bearings of the output: one position, the bearing's centre, for each bearing.

    `bearing_ends` are the start and end of each bearing along z [m]. The numbers of the bearings increase along z, so
    that those in the motor cover precede those in the output cover.
    """
    bearing = casing.hub
    return BoughtPart(
        names.OUTPUT_BEARING,
        tube(0.5 * bearing.bore, 0.5 * bearing.outside, bearing.width),
        names.HOUSING,
        tuple((0.0, 0.0, 0.5 * (start + end)) for start, end in bearing_ends),
        bearing_dimensions(bearing),
        designation=hub_bearing_designation(bearing),
        fit=hub_bearing_fit(bearing),
        first=len(casing.bearings) + 1 - len(bearing_ends) if bearing_ends[-1] == casing.bearings[-1] else 1,
    )


def _retainer_joint(reducer: Reducer, casing: Casing) -> Iterator[Joint]:
    """Yield the screwed joint of the retainer and the output cover, which clamp the outer ring of crossed rollers."""
    ring = casing.retainer
    if ring is None:
        return
    thread, retainer_face, cover_end = ring.bolt.thread, casing.top + ring.thickness, casing.output_cover_end
    centres = ring.circle * unit(pattern_angles(ring.count)[::2])
    depth = hole_depth(reducer, thread, ring.length - ring.thickness)
    holes: tuple[tuple[str, Hole], ...] = (
        (names.OUTPUT_COVER, (centres, core_radius(reducer, thread), cover_end - depth, cover_end)),
        (names.RETAINER, (AXIS, casing.hub.shoulders[1], casing.top, retainer_face)),
        (names.RETAINER, (centres, 0.5 * stock.bolt_hole(thread), casing.top, retainer_face)),
    )
    bought_parts = (
        _bought_screws(names.RETAINER_SCREW, ring.bolt, ring.length, names.HOUSING, centres, retainer_face),
        *_bought_inserts(reducer, names.RETAINER_INSERT, thread, names.HOUSING, centres, cover_end, -1.0),
    )
    threads = (_tapped_holes(reducer, names.OUTPUT_COVER, centres, thread, depth),)
    parts = names.OUTPUT_COVER, names.RETAINER
    name = "screws of the bearing retainer"
    yield Joint(name, JointKind.SCREWED, parts, holes, bought_parts, threads=threads)


def _cover_screw_joint(reducer: Reducer, casing: Casing) -> Joint:
    """Return the joint of both covers by screws, which pass through the ring or outside of it.

    The screws lead from the output cover into threaded holes or inserts of the motor cover.
    """
    screws, bolt, ring_half_width = casing.screws, casing.screws.bolt, casing.end
    centres, thread_end = screws.centres(), ring_half_width - casing.play if screws.outside else -ring_half_width
    engagement = screws.length - casing.grip - ring_half_width + thread_end
    thread_depth = hole_depth(reducer, bolt.thread, engagement)
    head_face, step_height = ring_half_width + casing.grip, output_cover_step(casing)
    holes: list[tuple[str, Hole]] = [
        (names.MOTOR_COVER, (centres, core_radius(reducer, bolt.thread), thread_end - thread_depth, thread_end)),
        (names.OUTPUT_COVER, (centres, screws.hole, ring_half_width, head_face)),
        (names.OUTPUT_COVER, (centres, counterbore(bolt), head_face, step_height or casing.output_cover_end)),
    ]
    if not screws.outside:
        holes.append((names.HOUSING, (centres, screws.hole, -ring_half_width, ring_half_width)))
    bought_parts = [
        _bought_screws(names.SCREW, bolt, screws.length, names.HOUSING, centres, head_face),
        *_bought_inserts(reducer, names.SCREW_INSERT, bolt.thread, names.HOUSING, centres, thread_end, -1.0),
    ]
    parts = (names.MOTOR_COVER, *(() if screws.outside else (names.HOUSING,)), names.OUTPUT_COVER)
    threads = (_tapped_holes(reducer, names.MOTOR_COVER, centres, bolt.thread, thread_depth),)
    return Joint("screws of the covers", JointKind.SCREWED, parts, tuple(holes), tuple(bought_parts), threads=threads)


def _motor_screw_joint(reducer: Reducer, casing: Casing) -> Joint:
    """Return the screwed joint of the motor and its cover.

    If the motor has tapped holes, screws lead from inside the cover into it. Otherwise, the cover has threaded holes.
    """
    motor, centres, face = casing.motor, motor_centres(casing), casing.face
    name, parts = "screws of the motor", (MOTOR, names.MOTOR_COVER)
    if not motor.tapped:
        depth = hole_depth(reducer, motor.thread, RULES.engagement * motor.thread)
        thread_hole = (centres, core_radius(reducer, motor.thread), face, face + depth)
        inserts = tuple(_bought_inserts(reducer, names.MOTOR_INSERT, motor.thread, names.HOUSING, centres, face, 1.0))
        threads = (_tapped_holes(reducer, names.MOTOR_COVER, centres, motor.thread, depth),)
        return Joint(name, JointKind.SCREWED, parts, ((names.MOTOR_COVER, thread_hole),), inserts, threads=threads)
    head_face = face + motor_grip(motor, casing.wall)
    holes: tuple[Hole, ...] = (
        (centres, 0.5 * stock.bolt_hole(motor.thread), face, head_face),
        (centres, counterbore(thickest_bolt(motor.thread)), head_face, casing.floor),
    )
    bought_parts = _bought_screws(
        names.MOTOR_SCREW, *motor_screw(motor, casing.wall), names.HOUSING, centres, head_face
    )
    return Joint(name, JointKind.SCREWED, parts, tuple((names.MOTOR_COVER, hole) for hole in holes), (bought_parts,))


def _ring_seat_joint(reducer: Reducer, casing: Casing) -> Iterator[Joint]:
    """Yield the seat of a ring that the screws pass outside of.

    A ring of metal without dowels slides in it until the discs centre it. Any other ring has play.
    """
    if not casing.screws.outside:
        return
    radius = reducer.design.housing.outer_radius
    has_play = not casing.has_free_ring or is_printed(reducer, names.HOUSING)
    seat_hole = (AXIS, radius + (SEAT_PLAY if has_play else 0.0), -casing.end, casing.end - casing.play)
    name, parts, holes = (
        "ring in the motor cover",
        (names.HOUSING, names.MOTOR_COVER),
        ((names.MOTOR_COVER, seat_hole),),
    )
    if is_printed(reducer, names.HOUSING):
        yield Joint(name, JointKind.LOCATED, parts, holes)
        return
    fit, seat_sizes = LOOSE_RING_FIT if has_play else RING_FIT, (1, 2.0 * radius, 2.0 * casing.end - casing.play)
    yield Joint(name, JointKind.LOCATED, parts, holes, (), fit, *seat_sizes)


def _flange_screw_joint(reducer: Reducer, casing: Casing) -> Joint:
    """Return the joint of flange and hub by screws, which clamp the inner rings of the output's bearings."""
    bolt, hub_end, flange_end = casing.flange_bolt, casing.top, casing.top + casing.flange_thickness
    length, depth = (
        flange_screw_length(bolt, casing.flange_thickness),
        flange_screw_depth(reducer, bolt, casing.flange_thickness),
    )
    centres, head_face = flange_centres(casing)[::2], flange_end - bolt.head_height
    counterbore_radius, washer_thickness = flange_washer(reducer, bolt)
    holes: tuple[tuple[str, Hole], ...] = (
        (names.OUTPUT, (centres, core_radius(reducer, bolt.thread), hub_end - depth, hub_end)),
        (names.FLANGE, (centres, 0.5 * stock.bolt_hole(bolt.thread), hub_end, head_face - washer_thickness)),
        (names.FLANGE, (centres, counterbore_radius, head_face - washer_thickness, flange_end)),
    )
    bought_parts = (
        _bought_screws(names.FLANGE_SCREW, bolt, length, names.OUTPUT, centres, head_face, FLANGE_CLASS),
        *(_bought_washers(bolt, centres, head_face) if washer_thickness else ()),
        *_bought_inserts(reducer, names.FLANGE_INSERT, bolt.thread, names.OUTPUT, centres, hub_end, -1.0),
    )
    threads = (_tapped_holes(reducer, names.OUTPUT, centres, bolt.thread, depth),)
    parts = (names.OUTPUT, names.FLANGE)
    return Joint("screws of the output flange", JointKind.SCREWED, parts, holes, bought_parts, threads=threads)


def _hub_bore_joint(reducer: Reducer, casing: Casing) -> Iterator[Joint]:
    """Yield the joint of hub and flange at their central bore.

    The bore saves mass, and centres a load or continues a hollow shaft.
    Yields nothing for a solid shaft if screws and dowels leave no room for it.
    """
    design, hub_end, wall = reducer.design, casing.top, casing.wall
    bore_start = max(casing.hub_floor, casing.far[1] + RULES.collar if casing.far else 0.0) + 2.0 * wall
    shaft_bore, holes = design.shaft.bore_radius, []
    if min(casing.flange_bore, hub_end - bore_start) > 2.0 * wall:
        holes = [
            (names.OUTPUT, (AXIS, casing.hub_bore, bore_start, hub_end)),
            (names.FLANGE, (AXIS, casing.flange_bore, hub_end, hub_end + casing.flange_thickness)),
        ]
    elif shaft_bore:
        holes = [
            (names.OUTPUT, (AXIS, shaft_bore, bore_start, hub_end)),
            (names.FLANGE, (AXIS, shaft_bore, hub_end, casing.ends[1])),
        ]
    if shaft_bore:
        start = casing.far[1] + RULES.collar if casing.far else design.gear.stack_width / 2.0 + AXIAL_GAP
        holes.append((names.OUTPUT, (AXIS, shaft_bore, start, bore_start)))
    if holes:
        yield Joint("bore of hub and flange", JointKind.CLEARANCE, (names.OUTPUT, names.FLANGE), tuple(holes))


def _load_thread_joint(reducer: Reducer, casing: Casing) -> Joint:
    """Return the joint of output flange and load: threaded holes in the flange for the screws of the load.

    They are on the circle of the flange's own screws, each midway between two of these.
    """
    bolt, centres, end = casing.flange_bolt, flange_centres(casing)[1::2], casing.top + casing.flange_thickness
    thread_hole = (centres, core_radius(reducer, bolt.thread), casing.top, end)
    inserts = tuple(_bought_inserts(reducer, names.LOAD_INSERT, bolt.thread, names.OUTPUT, centres, end, -1.0))
    threads = (_tapped_holes(reducer, names.FLANGE, centres, bolt.thread, end - casing.top),)
    return Joint(
        "threads for the load",
        JointKind.SCREWED,
        (names.FLANGE, LOAD),
        ((names.FLANGE, thread_hole),),
        inserts,
        threads=threads,
    )


def _dowel_joints(casing: Casing) -> Iterator[Joint]:
    """Yield the dowelled joints of covers and ring, one for each face, or that of both covers; none without dowels."""
    if casing.dowel is None:
        return
    ring_half_width, centres = casing.end, dowel_centres(casing)
    faces: tuple[tuple[float, str, str], ...] = ((ring_half_width, names.MOTOR_COVER, names.OUTPUT_COVER),)
    if not casing.has_outer_dowels:
        faces = (
            (-ring_half_width, names.MOTOR_COVER, names.HOUSING),
            (ring_half_width, names.HOUSING, names.OUTPUT_COVER),
        )
    for index, (face, *parts) in enumerate(faces):
        name, first_number = "dowels of {} and {}".format(*parts).replace("_", " "), 1 + index * len(centres)
        yield _dowelled_joint(name, (*parts,), (names.DOWEL, names.HOUSING, first_number), casing.dowel, centres, face)


def _flange_dowel_joint(casing: Casing) -> Iterator[Joint]:
    """Yield the dowelled joint of hub and output flange in a plastic, whose screws transmit little by friction."""
    if casing.flange_dowel:
        item, parts = (names.FLANGE_DOWEL, names.OUTPUT, 1), (names.OUTPUT, names.FLANGE)
        centres = flange_dowel_centres(casing)
        yield _dowelled_joint("dowels of the output flange", parts, item, casing.flange_dowel, centres, casing.top)


def _dowelled_joint(
    name: str,
    parts: tuple[str, ...],
    item: tuple[str, str, int],
    dowel: stock.Dowel,
    centres: Array,
    face: float,
) -> Joint:
    """Return the joint of two parts by dowels that are equally deep in both.

    Parameters
    ----------
    name
        Name of the joint.
    parts
        The parts below and above the face.
    item
        Name of the dowels, the body that they move with, and the number of the first one.
    dowel
        Dowel in stock.
    centres
        Axes of the n dowels, (n, 2) [m].
    face
        Height of the face between the parts [m].
    """
    (lower_part, upper_part), (family, body, first_number) = parts, item
    radius, depth = 0.5 * dowel.diameter, 0.5 * dowel.length
    bought_part = BoughtPart(
        family,
        dowel_body(dowel),
        body,
        tuple(_point(centre, face) for centre in centres),
        (("diameter", dowel.diameter), ("length", dowel.length)),
        DOWEL_MATERIAL,
        dowel.designation,
        DOWEL_FIT,
        first=first_number,
    )
    holes = (lower_part, (centres, radius, face - depth, face)), (upper_part, (centres, radius, face, face + depth))
    seats = len(centres), dowel.diameter, depth
    return Joint(name, JointKind.DOWELLED, parts, holes, (bought_part,), DOWEL_FIT, *seats)


def _tapped_holes(reducer: Reducer, part: str, centres: Array, thread: float, depth: float) -> TappedHole:
    insert = insert_in(reducer, thread)
    return TappedHole(part, len(centres), thread, depth, insert.designation if insert else "")


def _bought_screws(
    item: str,
    bolt: stock.Bolt,
    length: float,
    body: str,
    centres: Array,
    head_face: float,
    property_class: str = USUAL_CLASS,
) -> BoughtPart:
    """Return equal screws, with their heads on top, as a bought part.

    Parameters
    ----------
    item
        Name of the screws.
    bolt, length
        Screw in stock, and its length [m].
    body
        Name of the body that the screws move with.
    centres
        Axes of the n screws, (n, 2) [m].
    head_face
        Height of the faces under their heads [m].
    property_class
        Strength, such as "8.8".
    """
    return BoughtPart(
        item,
        screw_body(bolt, length),
        body,
        tuple(_point(centre, head_face) for centre in centres),
        (("thread", bolt.thread), ("length", length)),
        f"steel {property_class}",
        f"{bolt.designation} x {1e3 * length:.5g}",
    )


def _bought_washers(bolt: stock.Bolt, centres: Array, head_face: float) -> Iterator[BoughtPart]:
    """Yield one bought part with a position for each washer under the heads of the n flange screws.

    The screws have the axes `centres` (n, 2) [m]; their heads are on the plane z = `head_face` [m]. `bolt` is the size
    of the screw in stock.
    """
    washer = stock.washer_of(bolt.thread)
    yield BoughtPart(
        names.FLANGE_WASHER,
        tube(0.5 * washer.bore, 0.5 * washer.outside, washer.thickness),
        names.OUTPUT,
        tuple(_point(centre, head_face - 0.5 * washer.thickness) for centre in centres),
        (("outside diameter", washer.outside), ("bore", washer.bore), ("length", washer.thickness)),
        "steel, 200 HV",
        washer.designation,
        "loose",
    )


def _bought_inserts(
    reducer: Reducer, item: str, thread: float, body: str, centres: Array, mouth: float, direction: float
) -> Iterator[BoughtPart]:
    """Yield one bought part with a position for each heat-set insert of threads in a plastic; nothing in a metal.

    Inserts are flush with the mouths of their holes.

    Parameters
    ----------
    item, body
        Name of the inserts, and of the body that they move with.
    thread
        Nominal diameter of the thread [m].
    centres
        Axes of the n holes, (n, 2) [m].
    mouth, direction
        Height of the mouths of the holes [m], and 1 or -1 for holes that extend along +z or -z.
    """
    if insert := insert_in(reducer, thread):
        insert_middle = mouth + direction * 0.5 * insert.length
        yield BoughtPart(
            item,
            tube(0.5 * insert.thread, 0.5 * insert.hole, insert.length),
            body,
            tuple(_point(centre, insert_middle) for centre in centres),
            (("hole", insert.hole), ("length", insert.length)),
            "brass",
            insert.designation,
        )


def bearing_dimensions(bearing: stock.StockBearing) -> tuple[tuple[str, float], ...]:
    """Return the dimensions of a bearing in stock [m], with their names."""
    return ("outside diameter", bearing.outside), ("bore", bearing.bore), ("length", bearing.width)


def _point(centre: Array, z: float) -> Point:
    return float(centre[0]), float(centre[1]), z
