"""Sizes of the casing that turns a mechanism into a drive: covers, bearings, screws, dowels and flanges.

The dimensions of the mechanism stay; those chosen here follow the usual design (assumed) and parts in stock. Along z:
the motor, the motor cover with its flange and a bearing of the shaft, the ring, the output cover with the two bearings
of the hub, and the output flange.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import Material, stock
from cycloid_mj.design.materials import MATERIALS, material_name
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts import crank_stretches, sleeve_core_radius
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    axial_play,
    counterbore,
    flange_washer,
    hole_depth,
    is_plastic,
    least_wall,
    min_grip,
    ring_end,
    shoulder_radius,
    stock_screw_length,
    thickest_bolt,
    thread_radius,
)
from cycloid_mj.parts.export.motors import MOTORS, MotorFlange, MotorName, frames_for
from cycloid_mj.parts.output import RIM
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.reducer.bending import AXIAL_GAP
from cycloid_mj.reducer.sockets import wall_radius

MOTOR_COVER, OUTPUT_COVER, FLANGE = "motor_cover", "output_cover", "output_flange"
SCREW, FLANGE_SCREW, MOTOR_SCREW, DOWEL = "screw", "flange_screw", "motor_screw", "dowel"
FLANGE_WASHER = "flange_washer"
SCREW_INSERT, FLANGE_INSERT = "screw_insert", "flange_screw_insert"
LOAD_INSERT, MOTOR_INSERT = "load_screw_insert", "motor_screw_insert"
CAM_BEARING, SHAFT_BEARING, OUTPUT_BEARING = "cam_bearing", "shaft_bearing", "output_bearing"

Motor = MotorName | MotorFlange
"""The name of a motor's interface, or an interface of one's own."""

LIGHT_METAL = "aluminium 6061"
"""Material of covers on a ring of a heavier metal, unless another is chosen: a third of the mass of steel."""


@dataclass(frozen=True)
class Screws:
    """Screws of the covers: bolt, length and circle radius [m], and angles clockwise from +y [rad].

    `outside`: they pass next to the ring, which then has a seat in the motor cover.
    """

    bolt: stock.Bolt
    length: float
    circle: float
    angles: tuple[float, ...]
    outside: bool

    @property
    def hole(self) -> float:
        """Radius of the through hole [m]."""
        return 0.5 * stock.bolt_hole(self.bolt.thread)

    def centres(self) -> Array:
        """Compute the centres of the screws (n, 2) [m]."""
        return self.circle * unit(np.array(self.angles))


@dataclass(frozen=True)
class Casing:
    """Sizes of the casing [m]; positions are along z.

    Attributes
    ----------
    outer, wall
        Outer radius of both covers, and minimum wall around holes.
    screws, dowel, dowel_angles, dowel_circle
        Screws of the covers, and dowels of covers and ring (None if none fits) with angles clockwise from +y and the
        radius of their circle.
    motor, face
        Interface of the motor, and its plane.
    journal
        Start of the crank on the side of the motor.
    near, far, seat
        Ends of the shaft bearings in the motor cover and in the hub (None without), and the radius of their seats.
    cavity, floor, pocket
        Radius and bottom of the cavity for the crank in the motor cover; bottom of the pocket around its bearing, at
        `floor` without a pocket.
    step, slim
        Height below which the motor cover is slimmer, behind the threads of its screws, and its radius there; at `face`
        without a step.
    hub, hub_floor, spacing
        Bearing of the output (two of it), start of the first one, and the distance between them.
    rim
        Radius of the disc of the output.
    play, end
        Least distance of parts that move against each other, and half the width of the ring: it is wider than the discs
        by the play at both ends, so that they turn freely between the covers.
    flange_bolt, flange_thickness, flange_screws, flange_circle
        Screws of the output flange, its thickness, and number and circle radius of the screws.
    cover_material
        Material of both covers, a name of the library; empty: that of the ring.
    """

    outer: float
    wall: float
    screws: Screws
    dowel: stock.Dowel | None
    dowel_angles: tuple[float, ...]
    dowel_circle: float
    motor: MotorFlange
    face: float
    journal: float
    near: tuple[float, float]
    far: tuple[float, float] | None
    seat: float
    cavity: float
    floor: float
    pocket: float
    step: float
    slim: float
    hub: stock.StockBearing
    hub_floor: float
    spacing: float
    rim: float
    play: float
    end: float
    flange_bolt: stock.Bolt
    flange_thickness: float
    flange_screws: int
    flange_circle: float
    cover_material: str = ""

    @property
    def bearings(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Ends of the two bearings of the output along z [m]."""
        first, width = self.hub_floor, self.hub.width
        return (first, first + width), (first + width + self.spacing, self.top)

    @property
    def top(self) -> float:
        """End of output cover and hub, where the flange begins [m]."""
        return self.hub_floor + 2.0 * self.hub.width + self.spacing

    @property
    def boss(self) -> float:
        """Radius of the boss around the bearing in the motor cover [m]; heads of screws into the motor are outside."""
        radius = self.seat + max(RULES.boss_share * self.seat, 2.0 * self.wall)
        if not self.motor.tapped:
            return radius
        return min(radius, self.motor.circle - counterbore(thickest_bolt(self.motor.thread)))

    @property
    def flange_radius(self) -> float:
        """Radius of the output flange, which clamps the inner rings [m]."""
        return shoulder_radius(0.5 * self.hub.bore, 0.5 * self.hub.outside)

    @property
    def output_cavity(self) -> float:
        """Radius of the cavity for the disc of the output in the output cover [m]."""
        return max(self.rim + self.wall, 0.5 * self.hub.outside)

    @property
    def grip(self) -> float:
        """Thickness of the output cover below the heads of its screws [m], less what the ring is wider than discs."""
        return min_grip(self.screws.bolt, self.wall) - 2.0 * self.play

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the drive along z without the motor [m]."""
        return self.face, self.top + self.flange_thickness


@once
def casing(reducer: Reducer, motor: Motor = "auto", cover_material: str = "auto") -> Casing:
    """Choose the sizes of covers, bearings, screws and flanges around a mechanism, for a motor.

    `cover_material` is a metal of the library, ``auto``: `LIGHT_METAL` for a ring of a heavier metal.

    Raises
    ------
    DesignError
        Motor flange, output bearing, crank or screws do not fit.
    """
    design = reducer.design
    radius, half, output = design.housing.outer_radius, design.gear.stack_width / 2.0, design.output
    wall = least_wall(reducer)
    screws = _screws(reducer, wall)
    outer = _cover_radius(screws, radius, wall)
    rim = output.pin_circle_radius + (1.0 + RIM) * output.pin_radius
    prisms, straddles = crank_stretches(reducer), design.shaft.mounting == "straddle"
    far, near = bearing_seats(reducer, prisms)
    seat = seat_radius(reducer, near[1] - near[0])
    weight = prisms.get("counterweight")
    second = -half - AXIAL_GAP - output.disc_thickness if output.support == "both_ends" else -half
    cavity, most = _cavity(reducer, screws, max(rim if second < -half else 0.0, seat - wall), wall)
    floor = min(weight.z0 if weight else second, second) - AXIAL_GAP
    flange = _motor_flange(reducer, motor, outer, seat, wall, most)
    if flange.tapped:
        cavity = max(cavity, _heads_end(flange))
    under = _floor_thickness(reducer, flange, wall)
    first = near[0] if straddles else far[0]
    end = ring_end(reducer)
    through = min_grip(screws.bolt, wall) + 2.0 * ((0.0 if screws.outside else end) - axial_play(reducer))
    tip = (end if screws.outside else -end) - hole_depth(reducer, screws.bolt.thread, screws.length - through) - wall
    face, journal = _input_side(reducer, flange, first, wall, min(floor, tip) - under)
    dowel, dowel_angles, dowel_circle = _dowel(reducer, screws, wall)
    room = screws.circle - counterbore(screws.bolt) - 2.0 * wall
    hub = _hub(min(room, design.ring_root_radius), rim - wall, seat + 2.0 * wall if straddles else 0.0)
    bolt = thickest_bolt(RULES.flange_thread * hub.bore / 2.0, inserted=is_plastic(reducer))
    flange_circle, flange_screws = _flange_pattern(reducer, hub, bolt, wall)
    hub_floor = half + AXIAL_GAP + output.disc_thickness + AXIAL_GAP
    deepest = (
        max(far[1] + RULES.collar if straddles else 0.0, hub_floor) + 2.0 * wall + 2.0 * RULES.engagement * bolt.thread
    )
    return Casing(
        outer=outer,
        wall=wall,
        screws=screws,
        dowel=dowel,
        dowel_angles=dowel_angles,
        dowel_circle=dowel_circle,
        motor=flange,
        face=face,
        journal=journal,
        near=(first, near[1]),
        far=far if straddles else None,
        seat=seat,
        cavity=cavity,
        floor=floor,
        pocket=min(face + under, floor),
        step=max(min(tip, -end - min_grip(screws.bolt, wall), _pins_end(reducer, dowel, end) - wall), face),
        slim=max(cavity, flange.circle + thread_radius(reducer, flange.thread)) + 2.0 * wall,
        hub=hub,
        hub_floor=hub_floor,
        spacing=max(0.5 * hub.width, deepest - hub_floor - 2.0 * hub.width),
        rim=rim,
        play=axial_play(reducer),
        end=end,
        flange_bolt=bolt,
        flange_thickness=hole_depth(
            reducer, bolt.thread, bolt.head_height + flange_washer(reducer, bolt)[1] + max(bolt.thread, wall)
        ),
        flange_screws=flange_screws,
        flange_circle=flange_circle,
        cover_material=_cover_material(reducer, cover_material),
    )


def _input_side(reducer: Reducer, motor: MotorFlange, first: float, wall: float, most: float) -> tuple[float, float]:
    """Return the plane of the motor, at `most` as far up as that, and the start of the crank there [m].

    A straddled crank with a bore for the motor shaft starts at its bearing (`first`); one to be coupled, or overhung,
    keeps its journal.
    """
    journal = crank_stretches(reducer)["journal"].z0
    bored = _bore_end(reducer) - motor.shaft_length - RULES.blind_room
    shortened = reducer.design.shaft.mounting == "straddle" and motor.shaft > 0.0
    start = first if shortened else journal
    face = min(min(start - axial_play(reducer), first - wall) - RULES.pilot_depth, most, bored)
    if shortened:
        journal = max(journal, min(first, face + motor.shaft_length - 2.0 * RULES.engagement * motor.shaft))
    return face, journal


def _cover_material(reducer: Reducer, asked: str) -> str:
    """Return the material of the covers by name, or an empty string for that of the ring.

    Raises
    ------
    DesignError
        It is not a metal of the library, or the ring is of a plastic.
    """
    ring = reducer.design.material_of(names.HOUSING)
    if asked == "auto":
        return "" if ring.is_plastic or ring.density <= 2.0 * MATERIALS[LIGHT_METAL].density else LIGHT_METAL
    name = material_name(asked)
    if name not in MATERIALS or ring.is_plastic or Material(name=name).is_plastic:
        raise DesignError(
            f"covers of {asked!r} are not possible: covers and ring may differ in material only if both are metals. "
            f"Choose one of {', '.join(one for one in MATERIALS if not Material(name=one).is_plastic)}, or omit the "
            "cover material"
        )
    return name


def casing_or_none(reducer: Reducer, motor: Motor = "auto", cover_material: str = "auto") -> tuple[Casing | None, str]:
    """Return the casing, or None and the reason why covers, bearings or screws do not fit.

    Raises
    ------
    DesignError
        The chosen motor does not fit.
    """
    try:
        return casing(reducer, motor, cover_material), ""
    except DesignError as error:
        if motor != "auto" or cover_material != "auto":
            raise
        return None, str(error)


def cover_radius(reducer: Reducer) -> float:
    """Return the outer radius of the covers [m], that of the housing where their screws fit in its wall.

    Raises
    ------
    DesignError
        No screws in stock are long enough.
    """
    wall = least_wall(reducer)
    return _cover_radius(_screws(reducer, wall), reducer.design.housing.outer_radius, wall)


def _cover_radius(screws: Screws, radius: float, wall: float) -> float:
    return screws.circle + counterbore(screws.bolt) + wall if screws.outside else radius


def seat_radius(reducer: Reducer, width: float) -> float:
    """Return the radius of the seats of the shaft bearings [m]: of a bearing in stock, or as the rollers are rated."""
    radius = reducer.design.shaft.radius
    stocked = stock.bearings_on(2.0 * radius, width)
    return 0.5 * stocked[0].outside if stocked else RULES.bearing_ratio * radius


def _screws(reducer: Reducer, wall: float) -> Screws:
    """Place the screws in the wall of the ring, between its pins, or else outside of it.

    Thin screws are not in stock in the length of a wide ring.
    """
    design = reducer.design
    ring, housing = design.ring, design.housing
    around = wall if is_plastic(reducer) else max(0.5 * wall - RULES.head_play, 0.5 * RULES.min_wall)
    for bolt in _bolts_up_to(housing.outer_radius, is_plastic(reducer)):
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
        if fits and stock.bolt_length(bolt.thread, _min_screw_length(bolt, wall, design.gear.stack_width)):
            return _screws_of_length(bolt, circle, angles, wall, design.gear.stack_width)
    bolt = thickest_bolt(RULES.thread_share * housing.outer_radius, inserted=is_plastic(reducer))
    circle = housing.outer_radius + max(0.5 * stock.bolt_hole(bolt.thread), counterbore(bolt)) + wall
    angles = tuple(2.0 * math.pi * number / RULES.max_screws for number in range(RULES.max_screws))
    return _screws_of_length(bolt, circle, angles, wall, 0.0)


def _bolts_up_to(radius: float, inserted: bool) -> Iterator[stock.Bolt]:
    most = thickest_bolt(RULES.thread_share * radius, inserted=inserted)
    usable = (bolt for bolt in reversed(stock.bolts()) if not inserted or stock.insert_of(bolt.thread))
    yield from (bolt for bolt in usable if bolt.thread <= most.thread)


def _lands(teeth: int) -> tuple[float, ...]:
    """Return the angles [rad] of screws between pins, clockwise from +y; at least two lands stay free for dowels."""
    count = max(min(RULES.max_screws, teeth - 2), 2)
    return tuple(2.0 * math.pi * (number * teeth // count + 0.5) / teeth for number in range(count))


def _min_screw_length(bolt: stock.Bolt, wall: float, through: float) -> float:
    """Compute the minimum length of a screw through a cover and a ring, wide as the discs, into the other cover [m]."""
    return min_grip(bolt, wall) + through + RULES.engagement * bolt.thread


def _screws_of_length(
    bolt: stock.Bolt, circle: float, angles: tuple[float, ...], wall: float, through: float
) -> Screws:
    length = stock_screw_length(bolt, _min_screw_length(bolt, wall, through))
    return Screws(bolt, length, circle, angles, outside=not through)


def _dowel(reducer: Reducer, screws: Screws, wall: float) -> tuple[stock.Dowel | None, tuple[float, ...], float]:
    """Choose two dowels for each face between covers and ring, opposite each other, with their angles and circle.

    They stand between the screws, or in the wall of a ring that the screws pass outside of: they keep it from turning.
    """
    design = reducer.design
    room = design.housing.outer_radius - design.ring_root_radius - 2.0 * wall if screws.outside else screws.bolt.thread
    sizes = [size for size in reversed(stock.dowel_diameters()) if size <= min(screws.bolt.thread, room)]
    pins = [in_stock[0] for size in sizes if (in_stock := stock.pins(size, 2.0 * size))]
    pin = next((one for one in pins if one.length <= design.gear.stack_width - wall), None)
    if not pin:
        return None, (), 0.0
    if screws.outside or design.housing.support == "bolts":
        step = math.pi / len(screws.angles)
        angles = step, step + 2.0 * math.pi * (len(screws.angles) // 2) / len(screws.angles)
        middle = 0.5 * (design.ring_root_radius + design.housing.outer_radius)
        return pin, angles, middle if screws.outside else screws.circle
    teeth = design.ring.teeth
    free = sorted({*range(teeth)} - {round(angle * teeth / (2.0 * math.pi) - 0.5) for angle in screws.angles})
    other = min(free[1:], key=lambda land: abs(land - free[0] - 0.5 * teeth))
    return pin, tuple(2.0 * math.pi * (land + 0.5) / teeth for land in (free[0], other)), screws.circle


def _pins_end(reducer: Reducer, dowel: stock.Dowel | None, end: float) -> float:
    """Return the end of the dowels, and of pins in sleeves, in the motor cover [m]."""
    pressed = 2.0 * sleeve_core_radius(reducer) if reducer.design.ring.has_sleeves else 0.0
    return -end - max(0.5 * dowel.length if dowel else 0.0, pressed)


def _cavity(reducer: Reducer, screws: Screws, second: float, wall: float) -> tuple[float, float]:
    """Compute the radius of the cavity for crank and a `second` radius [m] in the motor cover, and its maximum [m].

    The cover retains the ring pins: the maximum leaves them a fifth of their end face.
    """
    design = reducer.design
    weight = design.shaft.counterweight_radius if design.gear.discs == 1 else design.shaft.radius
    cavity = max(weight, second) + wall
    room = (
        screws.circle - thread_radius(reducer, screws.bolt.thread)
        if not screws.outside
        else design.housing.outer_radius
    )
    most = min(room - wall, design.ring_root_radius)
    if not cavity <= most:
        raise DesignError(
            f"the crank needs a diameter of {2e3 * cavity:.4g} mm in the motor-side cover, but only {2e3 * most:.4g} "
            "mm is available: reduce shaft.counterweight_radius_mm or output.pin_circle_radius_mm"
        )
    ring = design.ring
    return cavity, min(most, ring.pin_circle_radius + 0.5 * ring.pin_radius) if ring.kind == "pin" else most


def _motor_flange(reducer: Reducer, motor: Motor, outer: float, seat: float, wall: float, most: float) -> MotorFlange:
    """Return the flange of the motor: the chosen one, or a bolt circle.

    For `auto` it is the smallest NEMA frame that is strong enough for torque and speed of the design and fits. `most`
    is the largest radius [m] of the cavity for the heads of screws from within the cover.
    """

    def hole(one: MotorFlange) -> float:
        return counterbore(thickest_bolt(one.thread)) if one.tapped else thread_radius(reducer, one.thread)

    def reach(one: MotorFlange) -> tuple[float, float]:
        return (_heads_end(one), most) if one.tapped else (one.circle + hole(one) + wall, outer)

    def fits(one: MotorFlange) -> bool:
        needed, there = reach(one)
        return one.circle - hole(one) - wall >= seat and needed <= there and _fits_shaft(reducer, one, wall)

    drive = reducer.design.drive
    if motor == "auto":
        one = next((frame for frame in frames_for(drive.torque, drive.speed) if fits(frame)), None)
    else:
        one = motor if isinstance(motor, MotorFlange) else MOTORS.get(motor)
    if one and fits(one):
        return one
    if one:
        needed, there = reach(one)
        place = "room for its screw heads up to" if one.tapped else "a cover with"
        raise DesignError(
            f"a motor flange {one.name} does not fit: it needs {place} a radius of {1e3 * needed:.4g} mm (here "
            f"{1e3 * there:.4g}), a bearing of at most {2e3 * (one.circle - hole(one) - wall):.4g} mm diameter (here "
            f"{2e3 * seat:.4g}), and a crank of at least {2e3 * one.shaft + 4e3 * wall:.4g} mm diameter around the "
            f"motor shaft (here {2e3 * reducer.design.shaft.radius:.4g}). Choose another motor"
        )
    thread = thickest_bolt(RULES.thread_share * outer, inserted=is_plastic(reducer)).thread
    circle = outer - thread_radius(reducer, thread) - 2.0 * wall
    return MotorFlange("bolt circle", max(0.6 * circle, min(seat, circle - thread)), circle, thread)


def output_cover_step(sizes: Casing) -> float | None:
    """Return the height [m] of the step of the output cover, above the heads of its screws; None without a step."""
    step = sizes.end + sizes.grip + sizes.screws.bolt.head_height
    slim = sizes.output_cavity + 2.0 * sizes.wall
    fits = slim < sizes.screws.circle - counterbore(sizes.screws.bolt) and step < sizes.bearings[0][0]
    return step if fits else None


def motor_screw(motor: MotorFlange, wall: float) -> tuple[stock.Bolt, float]:
    """Return bolt and length [m] of screws from within the cover into a tapped motor, by one thread diameter."""
    bolt = thickest_bolt(motor.thread)
    return bolt, stock_screw_length(bolt, min_grip(bolt, wall) + motor.thread)


def _heads_end(motor: MotorFlange) -> float:
    """Compute the minimum radius of a cavity with the counterbores of the motor screws in its floor [m]."""
    return motor.circle + counterbore(thickest_bolt(motor.thread)) + RULES.head_play


def motor_grip(motor: MotorFlange, wall: float) -> float:
    """Compute the thickness of the cover under the heads of the motor screws [m]."""
    _, length = motor_screw(motor, wall)
    return length - motor.thread


def _floor_thickness(reducer: Reducer, motor: MotorFlange, wall: float) -> float:
    """Compute the thickness of the cover behind its cavity that the motor screws need [m]."""
    if motor.tapped:
        return motor_grip(motor, wall) + thickest_bolt(motor.thread).head_height
    return hole_depth(reducer, motor.thread, RULES.engagement * motor.thread) + wall


def _fits_shaft(reducer: Reducer, motor: MotorFlange, wall: float) -> bool:
    """Return whether the crank is thick enough for a bore for the shaft of the motor."""
    return motor.shaft <= reducer.design.shaft.radius - 2.0 * wall


def _bore_end(reducer: Reducer) -> float:
    """Compute the end of the longest bore for the shaft of the motor [m]: the cam if the crank is one piece."""
    prisms = crank_stretches(reducer)
    return prisms[names.CAM].z0 if reducer.design.gear.discs == 1 else max(one.z1 for one in prisms.values())


def _hub(room: float, most: float, least: float) -> stock.StockBearing:
    """Return the largest bearing of the hub within a radius [m], with a bore between two radii [m]."""
    for bearing in reversed(stock.thin_ball_bearings()):
        if bearing.outside <= 2.0 * room and 2.0 * least <= bearing.bore <= 2.0 * most:
            return bearing
    raise DesignError(
        f"no bearing in stock fits the hub of the output: it needs a bore of {2e3 * least:.4g} to {2e3 * most:.4g} mm "
        f"and an outside diameter of at most {2e3 * room:.4g} mm. Choose a larger outer diameter, or a thinner shaft "
        "(shaft.radius_mm)"
    )


def bearing_width_of(reducer: Reducer) -> float:
    """Compute the width of each bearing of the shaft [m]."""
    low, high = bearing_seats(reducer, crank_stretches(reducer))[0]
    return high - low


def flange_screw_length(sizes: Casing) -> float:
    """Return the length of the screws of the output's flange [m]."""
    bolt = sizes.flange_bolt
    return stock_screw_length(bolt, sizes.flange_thickness - bolt.head_height + RULES.engagement * bolt.thread)


def motor_bore(reducer: Reducer, sizes: Casing) -> tuple[float, float, float] | None:
    """Return radius, start and end [m] of the bore of the crank for the motor shaft; None if that is unknown."""
    motor, end = sizes.motor, sizes.face + sizes.motor.shaft_length + RULES.blind_room
    return (motor.shaft, sizes.journal, end) if motor.shaft else None


def flange_centres(sizes: Casing) -> Array:
    """Compute the centres of the holes of the flange (n, 2) [m]: screws and threads for the load in turn."""
    count = sizes.flange_screws
    return sizes.flange_circle * unit(math.pi * np.arange(2 * count) / count)


def _flange_pattern(reducer: Reducer, hub: stock.StockBearing, bolt: stock.Bolt, wall: float) -> tuple[float, int]:
    """Return circle radius [m] and number of the flange screws in a hub, with walls around all holes."""
    radius, hole, head = 0.5 * hub.bore, thread_radius(reducer, bolt.thread), flange_washer(reducer, bolt)[0]
    flange = shoulder_radius(radius, 0.5 * hub.outside)
    circle = min(RULES.flange_circle * radius, radius - hole - wall, flange - head - wall)
    fitting = (one for one in RULES.flange_screws if 2.0 * circle * math.sin(0.5 * math.pi / one) >= head + hole + wall)
    return circle, next(fitting, RULES.flange_screws[-1])


def motor_centres(sizes: Casing) -> Array:
    """Compute the centres of the motor screws (n, 2) [m]."""
    count = sizes.motor.screws
    return sizes.motor.circle * unit((2.0 * np.arange(count) + 1.0) * math.pi / count)


def dowel_centres(sizes: Casing) -> Array:
    """Compute the centres of the dowels of a face (n, 2) [m]."""
    return sizes.dowel_circle * unit(np.array(sizes.dowel_angles))
