"""The casing that turns a mechanism into a drive: covers, bearings, screws, dowels and flanges.

The mechanism's own sizes stay; what is chosen here are those of the usual design (assumed), and of stock. Along z: the
motor, the cover on its side with its flange and the shaft's bearing, the ring, the cover on the output's side with the
two bearings of the output's hub, and the output's flange.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import stock
from cycloid_mj.design.materials import SOFTEST_METAL
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts import Part, Stretch, crank_stretches, laid_out
from cycloid_mj.parts.contour import CircleContour, circles_at
from cycloid_mj.parts.output import RIM
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.reducer.bending import AXIAL_GAP
from cycloid_mj.reducer.sockets import wall_radius

MOTOR_COVER, OUTPUT_COVER, FLANGE = "motor_cover", "output_cover", "output_flange"
SCREW, FLANGE_SCREW, MOTOR_SCREW, DOWEL = "screw", "flange_screw", "motor_screw", "dowel"
SCREW_INSERT, FLANGE_INSERT = "screw_insert", "flange_screw_insert"
LOAD_INSERT, MOTOR_INSERT = "load_screw_insert", "motor_screw_insert"
CAM_BEARING, SHAFT_BEARING, OUTPUT_BEARING = "cam_bearing", "shaft_bearing", "output_bearing"

Motor = Literal["auto", "nema17", "nema23", "circle"]

WALL_SHARE, LEAST_WALL, LEAST_PRINTED_WALL = 0.02, 0.5e-3, 0.8e-3
"""Least wall around holes, as a share of the outer radius, and at least [m]: two lines of a nozzle of 0.4 mm."""

USUAL_OUTSIDE = 1.4
"""Radius of a shaft's bearing outside over the shaft's, where none in stock has its size (as its rollers are rated)."""

PILOT = 2.5e-3
"""Depth of the recess for a motor's pilot [m]."""

SAME = 1e-9
"""Within which faces are the same [m]."""

THREAD_SHARE = 0.09
"""Thread of the housing's screws in the outer radius, about."""

MOST_SCREWS = 8
ENGAGED = 1.5
"""Length of a thread in its part, in its diameters."""

HEAD_PLAY = 0.2e-3
"""Of a screw's head in its counterbore [m], at its radius (assumed; DIN 974-1: 0.5 mm, for which walls are wanting)."""

FLANGE_SCREWS, FLANGE_CIRCLE, FLANGE_THREAD = 6, 0.66, 0.16
"""Screws of the output's flange, radius of their circle and their thread in the hub's radius."""

SHOULDER = 0.3
"""Of a bearing's section: how high a shoulder stands before its rings."""


@dataclass(frozen=True)
class MotorFlange:
    """Where a motor is bolted on: radii of its pilot and its bolts' circle, thread, radius and length of its shaft [m].

    A shaft of no radius: that of the motor is not given, and it is coupled to the end of the journal. A motor whose own
    holes are `tapped` is held by screws from within the cover; others have holes that screws into the cover pass.
    """

    name: str
    pilot: float
    circle: float
    thread: float
    shaft: float = 0.0
    shaft_length: float = 0.0
    tapped: bool = False


NEMA = {
    "nema17": MotorFlange("NEMA 17", 11.0e-3, 15.5e-3 * math.sqrt(2.0), 3e-3, 2.5e-3, 22e-3, tapped=True),
    "nema23": MotorFlange("NEMA 23", 19.05e-3, 23.57e-3 * math.sqrt(2.0), 4e-3, 3.175e-3, 20.6e-3),
}
"""NEMA ICS 16: pilots 22 and 38.1 mm, holes in squares of 31 and 47.14 mm, shafts of 5 and 6.35 mm.

Those of 23 are 4.95 to 5.1 mm wide (0.195 in), which M4 passes and M5 does not; makers tap those of 17 M3, some 4.5 mm
deep. Shafts are 20.6 +- 0.8 mm long there, 22 mm of many motors of 17. As in the charts of Kollmorgen and piclist.com.
"""


@dataclass(frozen=True)
class Screws:
    """The screws that hold the covers: bolt, length, how many, radius of their circle [m], and their angles [rad].

    Angles are clockwise from +y. Outside of the ring they leave it a seat in the cover of the motor's side.
    """

    bolt: stock.Bolt
    length: float
    circle: float
    angles: tuple[float, ...]
    outside: bool

    @property
    def hole(self) -> float:
        """Radius of the hole that they pass through [m]."""
        return 0.5 * stock.bolt_hole(self.bolt.thread)

    def centres(self) -> Array:
        """Compute the middles of the screws (n, 2) [m]."""
        return self.circle * unit(np.array(self.angles))


@dataclass(frozen=True)
class Casing:
    """Sizes of what holds a mechanism together [m]; heights are along z, what is `_radius` or in `Screws` is beside it.

    Attributes
    ----------
    outer, wall
        Outer radius of both covers, and the least wall around holes.
    screws, dowel, dowel_angles
        What holds the covers, and the pins that place them (none where none fits), with their angles clockwise from +y.
    motor, face
        The motor's flange, and its plane.
    near, far, seat
        From where to where the shaft's bearings stand in the cover, and the one in the output's hub; their radius.
    cavity, floor
        Radius and bottom of the room for the crank in the cover on the motor's side.
    hub, hub_floor, spacing
        Bearing of the output, of which there are two, where the first stands, and their distance.
    rim
        Radius of the output's disc.
    flange_bolt, flange_thickness
        Screws of the output's flange, and its thickness.
    """

    outer: float
    wall: float
    screws: Screws
    dowel: stock.Dowel | None
    dowel_angles: tuple[float, ...]
    motor: MotorFlange
    face: float
    near: tuple[float, float]
    far: tuple[float, float] | None
    seat: float
    cavity: float
    floor: float
    hub: stock.StockBearing
    hub_floor: float
    spacing: float
    rim: float
    flange_bolt: stock.Bolt
    flange_thickness: float

    @property
    def bearings(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Where the two bearings of the output stand along z [m]."""
        first, width = self.hub_floor, self.hub.width
        return (first, first + width), (first + width + self.spacing, self.top)

    @property
    def top(self) -> float:
        """Where cover and hub end on the output's side, and its flange begins [m]."""
        return self.hub_floor + 2.0 * self.hub.width + self.spacing

    @property
    def flange_radius(self) -> float:
        """Radius of the output's flange, which clamps the inner rings [m]."""
        return _shoulder(0.5 * self.hub.bore, 0.5 * self.hub.outside)

    @property
    def grip(self) -> float:
        """Thickness of the cover below the heads of its screws [m]."""
        return _grip(self.screws.bolt, self.wall)

    @property
    def ends(self) -> tuple[float, float]:
        """Where the drive begins and ends along z, the motor left out [m]."""
        return self.face, self.top + self.flange_thickness


@once
def casing(reducer: Reducer, motor: Motor = "auto") -> Casing:
    """Choose the sizes of covers, bearings, screws and flanges around a mechanism, for a motor.

    Raises
    ------
    DesignError
        The motor's flange, the output's bearing, the crank or the screws have no room.
    """
    design = reducer.design
    radius, half, output = design.housing.outer_radius, design.gear.stack_width / 2.0, design.output
    wall = least_wall(reducer)
    screws = _screws(reducer, wall)
    outer = screws.circle + counterbore(screws.bolt) + wall if screws.outside else radius
    rim = output.pin_circle_radius + (1.0 + RIM) * output.pin_radius
    prisms, straddles = crank_stretches(reducer), design.shaft.mounting == "straddle"
    far, near = bearing_seats(reducer, prisms)
    seat = seat_radius(reducer, near[1] - near[0])
    weight = prisms.get("counterweight")
    second = -half - AXIAL_GAP - output.disc_thickness if output.support == "both_ends" else -half
    cavity, most = _cavity(reducer, screws, rim if second < -half else 0.0, wall)
    floor = min(weight.z0 if weight else second, second) - AXIAL_GAP
    flange = _motor_flange(reducer, motor, outer, seat, wall, most)
    if flange.tapped:
        cavity = max(cavity, _heads_end(flange))
    under = _under_floor(reducer, flange, wall)
    first = near[0] if straddles else far[0]
    through = _grip(screws.bolt, wall) + (0.0 if screws.outside else 2.0 * half)
    tip = (half if screws.outside else -half) - _depth(reducer, screws.bolt.thread, screws.length - through) - wall
    bored = _bore_end(reducer) - flange.shaft_length
    face = min(min(prisms["journal"].z0, first - wall) - PILOT, floor - under, tip - under, bored)
    dowel, dowel_angles = _dowel(reducer, screws, wall)
    room = screws.circle - counterbore(screws.bolt) - 2.0 * wall
    hub = _hub(min(room, design.ring_root_radius), rim - wall, seat + 2.0 * wall if straddles else 0.0)
    bolt = _thickest(FLANGE_THREAD * hub.bore / 2.0)
    hub_floor = half + AXIAL_GAP + output.disc_thickness + AXIAL_GAP
    deepest = max(far[1] if straddles else 0.0, hub_floor) + 2.0 * wall + 2.0 * ENGAGED * bolt.thread
    return Casing(
        outer=outer,
        wall=wall,
        screws=screws,
        dowel=dowel,
        dowel_angles=dowel_angles,
        motor=flange,
        face=face,
        near=(first, near[1]),
        far=far if straddles else None,
        seat=seat,
        cavity=cavity,
        floor=floor,
        hub=hub,
        hub_floor=hub_floor,
        spacing=max(0.5 * hub.width, deepest - hub_floor - 2.0 * hub.width),
        rim=rim,
        flange_bolt=bolt,
        flange_thickness=_depth(reducer, bolt.thread, bolt.head_height + max(bolt.thread, wall)),
    )


def casing_or_none(reducer: Reducer, motor: Motor = "auto") -> tuple[Casing | None, str]:
    """Return the casing, or None and the reason why covers, bearings or screws have no room.

    Raises
    ------
    DesignError
        There is no casing with the motor that was chosen.
    """
    try:
        return casing(reducer, motor), ""
    except DesignError as error:
        if motor != "auto":
            raise
        return None, str(error)


def least_wall(reducer: Reducer) -> float:
    """Compute the least wall around holes of a drive [m]."""
    least = LEAST_PRINTED_WALL if _is_printed(reducer) else LEAST_WALL
    return max(least, WALL_SHARE * reducer.design.housing.outer_radius)


def covers_fit(reducer: Reducer) -> bool:
    """Tell whether the screws of the covers have room within the housing's outer radius."""
    try:
        return not _screws(reducer, least_wall(reducer)).outside
    except DesignError:
        return False


def seat_radius(reducer: Reducer, width: float) -> float:
    """Find the radius of the seat of the shaft's bearings [m]: of those in stock, or as their rollers are rated."""
    radius = reducer.design.shaft.radius
    stocked = stock.bearings_on(2.0 * radius, width)
    return 0.5 * stocked[0].outside if stocked else USUAL_OUTSIDE * radius


def _thickest(thread: float) -> stock.Bolt:
    """Find the thickest screw of at most a thread [m], or the thinnest of all."""
    bolts = stock.bolts()
    return max((one for one in bolts if one.thread <= thread), key=lambda one: one.thread, default=bolts[0])


def _grip(bolt: stock.Bolt, wall: float) -> float:
    return max(bolt.thread, 2.0 * wall)


def _screws(reducer: Reducer, wall: float) -> Screws:
    """Place the screws in the ring's wall, or between its pins, or where neither has room outside of it.

    Thin screws that would pass through a wide ring are not in stock.
    """
    design = reducer.design
    ring, housing = design.ring, design.housing
    around = wall if _is_printed(reducer) else max(0.5 * wall - HEAD_PLAY, 0.5 * LEAST_WALL)
    for bolt in _candidates(housing.outer_radius):
        hole, head = 0.5 * stock.bolt_hole(bolt.thread), counterbore(bolt)
        if housing.support == "bolts":
            angles = tuple(2.0 * math.pi * number / housing.bolts for number in range(housing.bolts))
            circle = design.bolt_circle_radius
            outside = max(hole + wall, head + around)
            fits = circle - design.ring_root_radius >= hole + wall and housing.outer_radius - circle >= outside
        else:
            circle, angles = housing.outer_radius - max(hole, head) - around, _lands(ring.teeth)
            apart = unit(np.array([0.0, math.pi / ring.teeth])) * np.array([[ring.pin_circle_radius], [circle]])
            fits = (
                ring.kind == "pin"
                and math.dist(*apart.tolist()) >= ring.pin_radius + design.socket_play + hole + wall
                and circle - hole - wall >= wall_radius(design)
            )
        if fits and stock.bolt_length(bolt.thread, _reach(bolt, wall, design.gear.stack_width)):
            return _of_length(bolt, circle, angles, wall, design.gear.stack_width)
    bolt = _thickest(THREAD_SHARE * housing.outer_radius)
    circle = housing.outer_radius + max(0.5 * stock.bolt_hole(bolt.thread), counterbore(bolt)) + wall
    angles = tuple(2.0 * math.pi * number / MOST_SCREWS for number in range(MOST_SCREWS))
    return _of_length(bolt, circle, angles, wall, 0.0)


def _candidates(radius: float) -> Iterator[stock.Bolt]:
    most = _thickest(THREAD_SHARE * radius)
    yield from (bolt for bolt in reversed(stock.bolts()) if bolt.thread <= most.thread)


def _lands(teeth: int) -> tuple[float, ...]:
    """Choose the lands between pins that have screws, two at least left for dowels; their angles clockwise from +y."""
    count = max(min(MOST_SCREWS, teeth - 2), 2)
    return tuple(2.0 * math.pi * (number * teeth // count + 0.5) / teeth for number in range(count))


def _reach(bolt: stock.Bolt, wall: float, through: float) -> float:
    """Compute the least length of a screw that passes through a cover and a ring into the cover beyond [m]."""
    return _grip(bolt, wall) + through + ENGAGED * bolt.thread


def _of_length(bolt: stock.Bolt, circle: float, angles: tuple[float, ...], wall: float, through: float) -> Screws:
    length = _screw_length(bolt, _reach(bolt, wall, through))
    return Screws(bolt, length, circle, angles, outside=not through)


def _dowel(reducer: Reducer, screws: Screws, wall: float) -> tuple[stock.Dowel | None, tuple[float, ...]]:
    """Choose two dowels for each face that covers meet at, opposite each other between the screws."""
    design = reducer.design
    sizes = [size for size in reversed(stock.dowel_diameters()) if size <= screws.bolt.thread]
    pins = [in_stock[0] for size in sizes if (in_stock := stock.pins(size, 2.0 * size))]
    pin = next((one for one in pins if one.length <= design.gear.stack_width - wall), None)
    if not pin:
        return None, ()
    if screws.outside or design.housing.support == "bolts":
        step = math.pi / len(screws.angles)
        return pin, (step, step + 2.0 * math.pi * (len(screws.angles) // 2) / len(screws.angles))
    teeth = design.ring.teeth
    free = sorted({*range(teeth)} - {round(angle * teeth / (2.0 * math.pi) - 0.5) for angle in screws.angles})
    other = min(free[1:], key=lambda land: abs(land - free[0] - 0.5 * teeth))
    return pin, tuple(2.0 * math.pi * (land + 0.5) / teeth for land in (free[0], other))


def counterbore(bolt: stock.Bolt) -> float:
    """Compute the radius of the counterbore for a screw's head [m]."""
    return 0.5 * bolt.head + HEAD_PLAY


def _cavity(reducer: Reducer, screws: Screws, second: float, wall: float) -> tuple[float, float]:
    """Find the radius of the room for crank and second disc [m] in the cover, which keeps the ring's pins in; its most.

    Where the heads of a motor's screws widen it, pins still rest on the cover with a fifth of their ends.
    """
    design = reducer.design
    weight = design.shaft.counterweight_radius if design.gear.discs == 1 else design.shaft.radius
    cavity = max(weight, second) + wall
    room = screws.circle - _core(reducer, screws.bolt.thread) if not screws.outside else design.housing.outer_radius
    most = min(room - wall, design.ring_root_radius)
    if not cavity <= most:
        raise DesignError(
            f"the crank needs {2e3 * cavity:.4g} mm in the cover on the motor's side, which has room for "
            f"{2e3 * most:.4g} mm; lower shaft.counterweight_radius_mm, or output.pin_circle_radius_mm"
        )
    ring = design.ring
    return cavity, min(most, ring.pin_circle_radius + 0.5 * ring.pin_radius) if ring.kind == "pin" else most


def _motor_flange(reducer: Reducer, motor: Motor, outer: float, seat: float, wall: float, most: float) -> MotorFlange:
    """Choose a flange: that asked for, or the largest of NEMA's that fits with its shaft, or a circle of bolts.

    `most` is the radius [m] within which the heads of screws from within the cover have room.
    """

    def hole(one: MotorFlange) -> float:
        return counterbore(_thickest(one.thread)) if one.tapped else _core(reducer, one.thread)

    def reach(one: MotorFlange) -> tuple[float, float]:
        return (_heads_end(one), most) if one.tapped else (one.circle + hole(one) + wall, outer)

    def fits(one: MotorFlange) -> bool:
        needed, there = reach(one)
        return one.circle - hole(one) - wall >= seat and needed <= there and _takes(reducer, one, wall)

    if motor in NEMA and not fits(NEMA[motor]):
        one = NEMA[motor]
        needed, there = reach(one)
        place = "room for the heads of its screws up to" if one.tapped else "a cover with"
        raise DesignError(
            f"a flange {one.name} needs {place} a radius of {1e3 * needed:.4g} mm, a bearing of at most "
            f"{2e3 * (one.circle - hole(one) - wall):.4g} mm and a shaft of {2e3 * one.shaft + 4e3 * wall:.4g} mm "
            f"around its own; there are {1e3 * there:.4g} mm, the bearing has {2e3 * seat:.4g} mm, the shaft "
            f"{2e3 * reducer.design.shaft.radius:.4g} mm: take another motor"
        )
    wanted = ("nema23", "nema17") if motor == "auto" else (motor,)
    if frame := next((NEMA[key] for key in wanted if key in NEMA and fits(NEMA[key])), None):
        return frame
    thread = _thickest(THREAD_SHARE * outer).thread
    circle = outer - _core(reducer, thread) - 2.0 * wall
    return MotorFlange("bolt circle", max(0.6 * circle, min(seat, circle - thread)), circle, thread)


def motor_screw(motor: MotorFlange, wall: float) -> tuple[stock.Bolt, float]:
    """Choose the screws from within the cover into a motor that is tapped, by a thread's diameter: bolt, length [m]."""
    bolt = _thickest(motor.thread)
    return bolt, _screw_length(bolt, _grip(bolt, wall) + motor.thread)


def _heads_end(motor: MotorFlange) -> float:
    """Compute the least radius of a cavity on whose floor the counterbores of the motor's screws open [m]."""
    return motor.circle + counterbore(_thickest(motor.thread)) + HEAD_PLAY


def _motor_grip(motor: MotorFlange, wall: float) -> float:
    """Compute the thickness of the cover under the heads of the motor's screws [m]."""
    _, length = motor_screw(motor, wall)
    return length - motor.thread


def _under_floor(reducer: Reducer, motor: MotorFlange, wall: float) -> float:
    """Compute how thick the cover has to be behind its cavity for what holds the motor [m]."""
    if motor.tapped:
        return _motor_grip(motor, wall) + _thickest(motor.thread).head_height
    return _depth(reducer, motor.thread, ENGAGED * motor.thread) + wall


def _takes(reducer: Reducer, motor: MotorFlange, wall: float) -> bool:
    """Tell whether the crank is thick enough for a bore for a motor's shaft."""
    return motor.shaft <= reducer.design.shaft.radius - 2.0 * wall


def _bore_end(reducer: Reducer) -> float:
    """Compute how far a bore for the motor's shaft may reach along the crank [m]: to the cam, which is one piece."""
    prisms = crank_stretches(reducer)
    return prisms[names.CAM].z0 if reducer.design.gear.discs == 1 else max(one.z1 for one in prisms.values())


def insert_in(reducer: Reducer, thread: float) -> stock.Insert | None:
    """Choose the heat-set insert of a thread [m] in covers and hub; none in a metal, or where none is in stock."""
    return stock.insert_of(thread) if _is_printed(reducer) else None


def _is_printed(reducer: Reducer) -> bool:
    """Tell whether covers and hub are of a plastic, as the housing."""
    return reducer.design.material_of(names.HOUSING).youngs_modulus < SOFTEST_METAL


def _core(reducer: Reducer, thread: float) -> float:
    """Compute the radius of the hole of a thread, or of its insert [m]."""
    insert = insert_in(reducer, thread)
    return 0.5 * (insert.hole if insert else thread)


def _depth(reducer: Reducer, thread: float, reach: float) -> float:
    """Compute the depth of the hole of a thread, or of its insert, which a screw is to reach into [m]."""
    insert = insert_in(reducer, thread)
    return max(reach, insert.length) if insert else reach


def _hub(room: float, most: float, least: float) -> stock.StockBearing:
    """Choose the widest bearing for the hub in a room [m], its bore from a least radius to a most [m]."""
    for bearing in reversed(stock.thin_ball_bearings()):
        if bearing.outside <= 2.0 * room and 2.0 * least <= bearing.bore <= 2.0 * most:
            return bearing
    raise DesignError(
        f"no bearing in stock fits the output's hub: its bore is to be {2e3 * least:.4g} to {2e3 * most:.4g} mm, its "
        f"outside at most {2e3 * room:.4g} mm; take a larger diameter, or a thinner shaft (shaft.radius_mm)"
    )


Round = tuple[float, float, float]
"""Radius about the part's axis, from z0 to z1 [m]."""

Hole = tuple[Array, float, float, float]
"""Middles (n, 2), radius, from z0 to z1 [m]."""

AXIS = np.zeros((1, 2))


@dataclass(frozen=True, eq=False)
class CasingPart:
    """A part of rounds with round holes, of the material of a part of the mechanism; or the holes that one has here."""

    material: str
    rounds: tuple[Round, ...] = ()
    holes: tuple[Hole, ...] = ()
    bought: bool = False


@dataclass(frozen=True)
class CasingPlace:
    """Where a part of the casing is: its name there, the part, its origin [m], and the body that it moves with."""

    name: str
    part: str
    origin: tuple[float, float, float]
    body: str


def casing_parts(reducer: Reducer, sizes: Casing) -> dict[str, CasingPart]:
    """Build all parts of the casing by name, those bought in frames of their own; of the mechanism's what is added."""
    screws, bolt, hub = sizes.screws, sizes.screws.bolt, sizes.hub
    parts = {
        names.HOUSING: _ring(reducer, sizes),
        names.OUTPUT: _output(reducer, sizes),
        MOTOR_COVER: _motor_cover(reducer, sizes),
        OUTPUT_COVER: _output_cover(reducer, sizes),
        FLANGE: _flange(reducer, sizes),
        SCREW: _screw(bolt, screws.length),
        FLANGE_SCREW: _screw(sizes.flange_bolt, flange_screw_length(sizes)),
        OUTPUT_BEARING: tube(0.5 * hub.bore, 0.5 * hub.outside, hub.width),
        SHAFT_BEARING: tube(reducer.design.shaft.radius, sizes.seat, bearing_width_of(reducer)),
    }
    if bore := motor_bore(reducer, sizes):
        parts[names.SHAFT] = _bored(bore)
    threads = {SCREW_INSERT: bolt.thread, FLANGE_INSERT: sizes.flange_bolt.thread}
    threads |= {LOAD_INSERT: sizes.flange_bolt.thread}
    if sizes.motor.tapped:
        parts[MOTOR_SCREW] = _screw(*motor_screw(sizes.motor, sizes.wall))
    else:
        threads |= {MOTOR_INSERT: sizes.motor.thread}
    for name, thread in threads.items():
        if insert := insert_in(reducer, thread):
            parts[name] = tube(0.5 * insert.thread, 0.5 * insert.hole, insert.length)
    if sizes.dowel:
        half = 0.5 * sizes.dowel.length
        parts[DOWEL] = CasingPart(names.PIN, ((0.5 * sizes.dowel.diameter, -half, half),), bought=True)
    return parts


def casing_places(reducer: Reducer, sizes: Casing) -> Iterator[CasingPlace]:
    """Yield where each part of the casing is, beside ring and output, at the crank angle 0."""
    half, screws = reducer.design.gear.stack_width / 2.0, sizes.screws
    for name in (MOTOR_COVER, OUTPUT_COVER):
        yield CasingPlace(name, name, (0.0, 0.0, 0.0), names.HOUSING)
    yield CasingPlace(FLANGE, FLANGE, (0.0, 0.0, 0.0), names.OUTPUT)
    for number, centre in enumerate(screws.centres(), start=1):
        yield CasingPlace(names.numbered(SCREW, number), SCREW, _place(centre, half + sizes.grip), names.HOUSING)
    for number, centre in enumerate(_flange_centres(sizes)[::2], start=1):
        at = _place(centre, sizes.top + sizes.flange_thickness - sizes.flange_bolt.head_height)
        yield CasingPlace(names.numbered(FLANGE_SCREW, number), FLANGE_SCREW, at, names.OUTPUT)
    for number, centre in enumerate(_motor_centres(sizes) if sizes.motor.tapped else (), start=1):
        at = _place(centre, sizes.face + _motor_grip(sizes.motor, sizes.wall))
        yield CasingPlace(names.numbered(MOTOR_SCREW, number), MOTOR_SCREW, at, names.HOUSING)
    for number, (low, high) in enumerate(sizes.bearings, start=1):
        yield CasingPlace(
            names.numbered(OUTPUT_BEARING, number), OUTPUT_BEARING, (0.0, 0.0, 0.5 * (low + high)), names.HOUSING
        )
    for number, (low, high) in enumerate(bearing_seats(reducer, crank_stretches(reducer)), start=1):
        yield CasingPlace(
            names.numbered(SHAFT_BEARING, number), SHAFT_BEARING, (0.0, 0.0, 0.5 * (low + high)), names.SHAFT
        )
    yield from _inserts(reducer, sizes)
    if sizes.dowel:
        faces = (half,) if screws.outside else (-half, half)
        spots = [(centre, z) for z in faces for centre in _dowel_centres(sizes)]
        for number, (centre, z) in enumerate(spots, start=1):
            yield CasingPlace(names.numbered(DOWEL, number), DOWEL, _place(centre, z), names.HOUSING)


def _inserts(reducer: Reducer, sizes: Casing) -> Iterator[CasingPlace]:
    """Yield where the inserts are, each in the mouth of its hole."""
    half, screws, bolt = reducer.design.gear.stack_width / 2.0, sizes.screws, sizes.flange_bolt
    centres, end = _flange_centres(sizes), sizes.top + sizes.flange_thickness
    motor = _motor_centres(sizes) if not sizes.motor.tapped else ()
    for name, thread, at, mouth, inwards, body in (
        (SCREW_INSERT, screws.bolt.thread, screws.centres(), half if screws.outside else -half, -1.0, names.HOUSING),
        (FLANGE_INSERT, bolt.thread, centres[::2], sizes.top, -1.0, names.OUTPUT),
        (LOAD_INSERT, bolt.thread, centres[1::2], end, -1.0, names.OUTPUT),
        (MOTOR_INSERT, sizes.motor.thread, motor, sizes.face, 1.0, names.HOUSING),
    ):
        if insert := insert_in(reducer, thread):
            for number, centre in enumerate(at, start=1):
                place = _place(centre, mouth + inwards * 0.5 * insert.length)
                yield CasingPlace(names.numbered(name, number), name, place, body)


def bearing_width_of(reducer: Reducer) -> float:
    """Compute the width of each bearing of the shaft [m]."""
    low, high = bearing_seats(reducer, crank_stretches(reducer))[0]
    return high - low


def flange_screw_length(sizes: Casing) -> float:
    """Return the length of the screws of the output's flange [m]."""
    bolt = sizes.flange_bolt
    return _screw_length(bolt, sizes.flange_thickness - bolt.head_height + ENGAGED * bolt.thread)


def with_holes(name: str, part: CasingPart, base: Sequence[Stretch] = ()) -> tuple[Stretch, ...]:
    """Return the stretches of a part of the casing, or those of a part of the mechanism with the casing's holes.

    The stretches end at all faces of the part and of its holes.
    """
    shells = [*base, *(Stretch(name, CircleContour(radius), (), z0, z1) for radius, z0, z1 in part.rounds)]
    ends = [(one.z0, one.z1) for one in shells] + [(start, end) for _, _, start, end in part.holes]
    faces = sorted({z for pair in ends for z in pair})
    laid = []
    for shell in shells:
        within = [z for z in faces if shell.z0 + SAME < z < shell.z1 - SAME]
        for low, high in pairwise([shell.z0, *within, shell.z1]):
            if high - low < SAME:
                continue
            through = [
                hole
                for centres, radius, start, end in part.holes
                if start < 0.5 * (low + high) < end
                for hole in circles_at(radius, centres)
            ]
            laid.append(Stretch(shell.name, shell.outline, (*shell.holes, *through), low, high))
    return tuple(laid)


def motor_bore(reducer: Reducer, sizes: Casing) -> Round | None:
    """Return radius, start and end [m] of the shaft's bore for the motor's shaft; None if the motor states no shaft."""
    motor, start = sizes.motor, crank_stretches(reducer)["journal"].z0
    return (motor.shaft, start, sizes.face + motor.shaft_length) if motor.shaft else None


def bored_shaft(reducer: Reducer, sizes: Casing | None, chord_error: float | None = None) -> Part:
    """Return the shaft, bored where the motor's shaft enters if `sizes` state one.

    `chord_error` [m] is that of the outlines that balance, see `laid_out`.
    """
    shaft = laid_out(reducer, chord_error)[names.SHAFT]
    bore = motor_bore(reducer, sizes) if sizes else None
    return shaft.of(with_holes(names.SHAFT, _bored(bore), shaft.stretches)) if bore else shaft


def _bored(bore: Round) -> CasingPart:
    radius, start, end = bore
    return CasingPart(names.SHAFT, holes=((AXIS, radius, start, end),))


def _ring(reducer: Reducer, sizes: Casing) -> CasingPart:
    half, screws = reducer.design.gear.stack_width / 2.0, sizes.screws
    if screws.outside:
        return CasingPart(names.HOUSING)
    holes: list[Hole] = [(screws.centres(), screws.hole, -half, half)]
    if sizes.dowel:
        size, deep = 0.5 * sizes.dowel.diameter, 0.5 * sizes.dowel.length
        holes += [(_dowel_centres(sizes), size, -half, -half + deep), (_dowel_centres(sizes), size, half - deep, half)]
    return CasingPart(names.HOUSING, holes=tuple(holes))


def _motor_cover(reducer: Reducer, sizes: Casing) -> CasingPart:
    design, screws, motor = reducer.design, sizes.screws, sizes.motor
    half, (first, _) = design.gear.stack_width / 2.0, sizes.near
    end = half if screws.outside else -half
    depth = screws.length - sizes.grip - (0.0 if screws.outside else 2.0 * half)
    in_cover = _depth(reducer, screws.bolt.thread, depth)
    holes: list[Hole] = [
        (AXIS, motor.pilot, sizes.face, sizes.face + PILOT),
        (AXIS, _shoulder(sizes.seat, design.shaft.radius), sizes.face + PILOT, first),
        (AXIS, sizes.seat, first, sizes.floor),
        (AXIS, sizes.cavity, sizes.floor, -half),
        (screws.centres(), _core(reducer, screws.bolt.thread), end - in_cover, end),
        *_motor_holes(reducer, sizes),
    ]
    if screws.outside:
        holes.append((AXIS, design.housing.outer_radius, -half, half))
    if sizes.dowel:
        holes.append((_dowel_centres(sizes), 0.5 * sizes.dowel.diameter, end - 0.5 * sizes.dowel.length, end))
    return CasingPart(names.HOUSING, ((sizes.outer, sizes.face, end),), tuple(holes))


def _motor_holes(reducer: Reducer, sizes: Casing) -> Iterator[Hole]:
    """Yield the holes for the motor's screws: threads, or for screws from within holes and counterbores."""
    motor, at, face = sizes.motor, _motor_centres(sizes), sizes.face
    if not motor.tapped:
        yield at, _core(reducer, motor.thread), face, face + _depth(reducer, motor.thread, ENGAGED * motor.thread)
        return
    under_head = face + _motor_grip(motor, sizes.wall)
    yield at, 0.5 * stock.bolt_hole(motor.thread), face, under_head
    yield at, counterbore(_thickest(motor.thread)), under_head, sizes.floor


def _output_cover(reducer: Reducer, sizes: Casing) -> CasingPart:
    screws, hub, half = sizes.screws, sizes.hub, reducer.design.gear.stack_width / 2.0
    (first, inner), (outer, top) = sizes.bearings
    seat = 0.5 * hub.outside
    room = max(sizes.rim + sizes.wall, seat)
    flush = half + sizes.grip + screws.bolt.head_height
    slim = room + 2.0 * sizes.wall
    stepped = slim < screws.circle - counterbore(screws.bolt) and flush < first
    rounds = ((sizes.outer, half, flush), (slim, flush, top)) if stepped else ((sizes.outer, half, top),)
    holes: list[Hole] = [
        (AXIS, room, half, first),
        (AXIS, seat, first, inner),
        (AXIS, _shoulder(seat, 0.5 * hub.bore), inner, outer),
        (AXIS, seat, outer, top),
        (screws.centres(), screws.hole, half, half + sizes.grip),
        (screws.centres(), counterbore(screws.bolt), half + sizes.grip, flush if stepped else top),
    ]
    if sizes.dowel:
        deep = 0.5 * sizes.dowel.length
        holes.append((_dowel_centres(sizes), 0.5 * sizes.dowel.diameter, half, half + deep))
    return CasingPart(names.HOUSING, rounds, tuple(holes))


def _output(reducer: Reducer, sizes: Casing) -> CasingPart:
    """Build what stands on the output's disc: a floor over its bores, the shoulder, the hub; and the holes in them."""
    disc = reducer.design.gear.stack_width / 2.0 + AXIAL_GAP
    floor, hub = disc + reducer.design.output.disc_thickness, 0.5 * sizes.hub.bore
    shoulder = floor + 0.5 * AXIAL_GAP
    rounds = (
        (sizes.rim, floor, shoulder),
        (_shoulder(hub, 0.5 * sizes.hub.outside), shoulder, sizes.hub_floor),
        (hub, sizes.hub_floor, sizes.top),
    )
    bolt = sizes.flange_bolt
    depth = _depth(reducer, bolt.thread, flange_screw_length(sizes) - sizes.flange_thickness + bolt.head_height)
    holes: list[Hole] = [(_flange_centres(sizes)[::2], _core(reducer, bolt.thread), sizes.top - depth, sizes.top)]
    if sizes.far:
        holes.append((AXIS, sizes.seat, disc, sizes.far[1]))
    return CasingPart(names.OUTPUT, rounds, tuple(holes))


def _flange(reducer: Reducer, sizes: Casing) -> CasingPart:
    """Build the output's flange: it clamps the inner rings, and has threads for the load between its screws."""
    bolt, top, thickness = sizes.flange_bolt, sizes.top, sizes.flange_thickness
    under, centres = top + thickness - bolt.head_height, _flange_centres(sizes)
    holes: tuple[Hole, ...] = (
        (centres[::2], 0.5 * stock.bolt_hole(bolt.thread), top, under),
        (centres[::2], counterbore(bolt), under, top + thickness),
        (centres[1::2], _core(reducer, bolt.thread), top, top + thickness),
    )
    return CasingPart(names.OUTPUT, ((sizes.flange_radius, top, top + thickness),), holes)


def _screw_length(bolt: stock.Bolt, reach: float) -> float:
    length = stock.bolt_length(bolt.thread, reach)
    if length is None:
        raise DesignError(
            f"the casing needs screws {bolt.designation} of {1e3 * reach:.4g} mm; those in stock are shorter: "
            "lower housing.outer_radius_mm"
        )
    return length


def _screw(bolt: stock.Bolt, length: float) -> CasingPart:
    """Build a screw that points along -z, its head above z = 0."""
    return CasingPart(
        names.SHAFT, ((0.5 * bolt.thread, -length, 0.0), (0.5 * bolt.head, 0.0, bolt.head_height)), bought=True
    )


def tube(bore: float, outside: float, width: float) -> CasingPart:
    """Draw a bearing as one ring, its middle at z = 0 [m]."""
    half = 0.5 * width
    return CasingPart(names.SHAFT, ((outside, -half, half),), ((AXIS, bore, -half, half),), bought=True)


def _shoulder(ring: float, other: float) -> float:
    """Compute the radius of a shoulder before a bearing [m]: it stands before its ring of one radius alone."""
    return ring + SHOULDER * (other - ring)


def _flange_centres(sizes: Casing) -> Array:
    """Compute the middles of the flange's holes (n, 2) [m]: its screws, and between them the threads for the load."""
    return FLANGE_CIRCLE * 0.5 * sizes.hub.bore * unit(math.pi * np.arange(2 * FLANGE_SCREWS) / FLANGE_SCREWS)


def _motor_centres(sizes: Casing) -> Array:
    return sizes.motor.circle * unit(np.array([0.25, 0.75, 1.25, 1.75]) * math.pi)


def _dowel_centres(sizes: Casing) -> Array:
    return sizes.screws.circle * unit(np.array(sizes.dowel_angles))


def _place(centre: Array, z: float) -> tuple[float, float, float]:
    return float(centre[0]), float(centre[1]), z
