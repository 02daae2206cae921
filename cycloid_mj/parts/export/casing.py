"""Sizes of the casing that turns a mechanism into a drive: covers, bearings, screws, dowels and flanges.

The dimensions of the mechanism stay; those chosen here follow the usual design (assumed) and parts in stock. Along z:
the motor, the motor cover with its flange and a bearing of the shaft, the ring, the output cover with the two bearings
of the hub, and the output flange.
"""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.design import Material, stock
from cycloid_mj.design.materials import MATERIALS, material_name
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts import crank_segments, sleeve_core_radius
from cycloid_mj.parts.export.bearing_retainer import (
    Retainer,
    StopRing,
    max_stop_ring_radius,
    retainer_of,
    stop_ring_of,
)
from cycloid_mj.parts.export.cam_clamp import cam_clamp
from cycloid_mj.parts.export.cam_splines import cam_spline
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    axial_play,
    counterbore,
    hole_depth,
    least_wall,
    min_grip,
    ring_end,
    stock_shaft_bearing,
    thickest_bolt,
    thread_radius,
)
from cycloid_mj.parts.export.cover_screws import Screws, choose_cover_screws, choose_dowels
from cycloid_mj.parts.export.crank_end import CrankEnd, choose_crank_end
from cycloid_mj.parts.export.hub_bearing import (
    choose_hub_bearing,
    count_cover_bearings,
    has_both_seats,
    needs_stop_ring,
    seat_second_disc,
)
from cycloid_mj.parts.export.motor_mount import (
    Motor,
    choose_motor_flange,
    motor_floor_thickness,
    motor_heads_end,
)
from cycloid_mj.parts.export.motors import MotorFlange, frames_for
from cycloid_mj.parts.export.output_flange import OutputFlange, flange_screw_depth, pattern_angles, size_output_flange
from cycloid_mj.parts.output import RIM
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP

LIGHT_METAL = "aluminium 6061"
"""Material of covers on a ring of a heavier metal, unless another is chosen: a third of the mass of steel."""


@dataclass(frozen=True)
class MotorSide:
    """Sizes of the motor cover [m]; positions are along z.

    Attributes
    ----------
    motor, face
        Interface of the motor, and its plane.
    journal
        Start of the crank on the side of the motor.
    cavity, floor, pocket
        Radius and bottom of the cavity for the crank in the motor cover; bottom of the pocket around its bearing, at
        `floor` without a pocket.
    step, slim
        Height below which the motor cover is slimmer, behind the threads of its screws, and its radius there; at `face`
        without a step.
    crank_end
        Retaining rings or seal ring next to the bearings of the crank in the motor cover.
    """

    motor: MotorFlange
    face: float
    journal: float
    cavity: float
    floor: float
    pocket: float
    step: float
    slim: float
    crank_end: CrankEnd


@dataclass(frozen=True)
class OutputSide(OutputFlange):
    """Sizes of hub, bearings and flange of the output [m]; positions are along z.

    Attributes
    ----------
    hub
        Bearing of the output: a pair of equal bearings, or one with crossed rollers.
    hub_floor
        End of the cavity for the output's disc in the output cover, where the inner bearing of a pair starts.
    spacing
        Distance between both bearings in the output cover; the distance of a single bearing there from `hub_floor`.
    retainer
        Ring that clamps the outer ring of a crossed roller bearing; None for a pair.
    motor_bearing
        Ends of the bearing around the second disc of the output, in the motor cover; None without it.
    stop_ring
        Ring on the ring of the drive that supports the outer ring of this bearing, if it has a contact angle: both
        bearings are then back to back. None for deep groove bearings, whose outer rings have lips at their outer ends.
    """

    hub: stock.StockBearing
    hub_floor: float
    spacing: float
    retainer: Retainer | None
    motor_bearing: tuple[float, float] | None
    stop_ring: StopRing | None


@dataclass(frozen=True)
class Casing(MotorSide, OutputSide):
    """Sizes of the casing [m]; positions are along z.

    Attributes
    ----------
    outer, wall
        Outer radius of both covers, and minimum wall around holes.
    screws, dowel, dowel_angles, dowel_circle
        Screws of the covers, and dowels of covers and ring (None if none fits) with angles clockwise from +y and the
        radius of their circle.
    near, far, seat
        Ends of the shaft bearings in the motor cover and in the hub (None without), and the radius of their seats.
    rim
        Radius of the disc of the output.
    play, end
        Least distance of parts that move against each other, and half the width of the ring: it is wider than the discs
        by the play at both ends, so that they turn freely between the covers.
    cover_material
        Material of both covers, a name of the library; empty: that of the ring.
    """

    outer: float
    wall: float
    screws: Screws
    dowel: stock.Dowel | None
    dowel_angles: tuple[float, ...]
    dowel_circle: float
    near: tuple[float, float]
    far: tuple[float, float] | None
    seat: float
    rim: float
    play: float
    end: float
    cover_material: str = ""

    @property
    def seat_start(self) -> float:
        """Start of the seat of the bearings in the motor cover along z [m], which a seal ring shares."""
        return self.near[0] - self.crank_end.seal_width

    @property
    def bearings(self) -> tuple[tuple[float, float], ...]:
        """Ends of the bearings of the output along z [m], the outer one last."""
        first, width = self.hub_floor, self.hub.width
        inner = () if self.hub.has_crossed_rollers else (self.motor_bearing or (first, first + width),)
        return *inner, (self.top - width, self.top)

    @property
    def has_outer_lip(self) -> bool:
        """True if the outer ring of the bearing in the output cover has a lip at its outer end."""
        return self.motor_bearing is not None and self.stop_ring is None

    @property
    def has_outer_dowels(self) -> bool:
        """True if the dowels are outside of the ring, between both covers."""
        return self.screws.outside and self.dowel is not None and self.dowel_circle == self.screws.circle

    @property
    def has_free_ring(self) -> bool:
        """True if neither screws nor dowels locate the ring, which the discs centre before the covers clamp it."""
        return self.screws.outside and (self.dowel is None or self.has_outer_dowels)

    @property
    def load_centres(self) -> tuple[float, float]:
        """Positions at which a pair of output bearings carries radial forces [m]: their middles, or further apart.

        The lines of contact of a pair back to back meet the axis outside of it (SKF, Rolling bearings, 2018).
        """
        inner, outer = (0.5 * sum(ends) for ends in (self.bearings[0], self.bearings[-1]))
        return inner - self.hub.load_centre_offset, outer + self.hub.load_centre_offset

    @property
    def top(self) -> float:
        """End of output cover and hub, where the flange begins [m]."""
        return self.hub_floor + count_cover_bearings(self.hub, self.motor_bearing) * self.hub.width + self.spacing

    @property
    def output_cover_end(self) -> float:
        """End of the output cover [m]: a retainer presses on the outer ring, not on the cover; a lip may retain it."""
        if self.has_outer_lip:
            return self.top + 2.0 * self.wall
        return self.top - (self.play if self.retainer else 0.0)

    @property
    def output_neck(self) -> float:
        """Radius of the output cover beyond the heads of its screws [m], if it is slimmer there."""
        seat = max(self.output_cavity, 0.5 * self.hub.outside)
        return max(seat + 2.0 * self.wall, self.retainer.cover_radius if self.retainer else 0.0)

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
        return self.hub.shoulders[0]

    @property
    def gap_seal_radius(self) -> float:
        """Outer radius of the output flange [m]; with a gap it covers bearings that have no seals."""
        return 0.5 * self.hub.outside if self.hub.contact_angle else self.flange_radius

    @property
    def output_cavity(self) -> float:
        """Return the radius of the cavity for the disc of the output in the output cover [m].

        Next to a stop ring, it is that of the shoulder of the outer ring, which starts at the ring of the drive.
        """
        if self.stop_ring:
            return self.stop_ring.bore
        return max(self.rim + self.wall, 0.5 * self.hub.outside)

    @property
    def grip(self) -> float:
        """Thickness of the output cover below the heads of its screws [m], less what the ring is wider than discs."""
        return min_grip(self.screws.bolt, self.wall) - 2.0 * self.play

    @property
    def motor_bore(self) -> tuple[float, float, float] | None:
        """Radius, start and end [m] of the bore of the crank for the motor shaft; None if that is unknown."""
        end = self.face + self.motor.shaft_length + RULES.blind_room
        return (self.motor.shaft, self.journal, end) if self.motor.shaft else None

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the drive along z without the motor [m]."""
        return self.face, self.top + self.flange_thickness


def casing(reducer: Reducer, motor: Motor = "auto", cover_material: str = "auto") -> Casing:
    """Choose the dimensions of the casing of a drive for a motor: covers, bearings, screws and flanges.

    `motor` is the flange of the motor or its name; with ``auto``, it is the smallest NEMA frame that fits and is strong
    enough, or a bolt circle. `cover_material` is the name of a metal of the library. With ``auto``, the covers are of
    `LIGHT_METAL` if the ring is of a metal more than twice as dense, and otherwise of the material of the ring. Drives
    with equal parts whose motors need the same frames share the result, which is cached.

    Raises
    ------
    DesignError
        Motor flange, output bearing, crank or screws do not fit, a hollow shaft ends before the hub, or the requested
        joint of the cams is not possible.
    """
    design = reducer.design
    frames = frames_for(design.drive.torque, design.drive.speed)
    key = (_size_casing, motor, cover_material, frames, design.contact.cam_rollers)
    return reducer.shape.kept(key, lambda: _size_casing(reducer, motor, cover_material))


def _size_casing(reducer: Reducer, motor: Motor, cover_material: str) -> Casing:
    """Choose the dimensions of the casing as `casing`, but not cached."""
    design, wall = reducer.design, least_wall(reducer)
    screws = choose_cover_screws(reducer, wall)
    outer_radius = _cover_radius(screws, design.housing.outer_radius, wall)
    dowel, dowel_angles, dowel_circle = choose_dowels(reducer, screws, wall)
    far_seat, near_seat = bearing_seats(reducer, crank_segments(reducer))
    straddles = design.shaft.mounting == "straddle"
    if design.shaft.bore_radius and not straddles:
        raise DesignError(
            "a shaft with a through bore needs a bearing in the hub, where its far end is sealed: set "
            'shaft.mounting = "straddle", or shaft.bore_radius_mm = 0'
        )
    _require_cam_joint(reducer)
    seat = seat_radius(reducer, near_seat[1] - near_seat[0])
    rim_radius = design.output.pin_circle_radius + (1.0 + RIM) * design.output.pin_radius
    stop_ring_radius = max_stop_ring_radius(reducer, screws, dowel, dowel_circle, wall)
    output_side = _size_output_side(reducer, screws, seat, rim_radius, stop_ring_radius)
    return Casing(
        outer=outer_radius,
        wall=wall,
        screws=screws,
        dowel=dowel,
        dowel_angles=dowel_angles,
        dowel_circle=dowel_circle,
        near=(near_seat[0] if straddles else far_seat[0], near_seat[1]),
        far=far_seat if straddles else None,
        seat=seat,
        rim=rim_radius,
        play=axial_play(reducer),
        end=ring_end(reducer),
        cover_material=_cover_material(reducer, cover_material),
        **vars(_size_motor_side(reducer, motor, screws, dowel, outer_radius, output_side)),
        **vars(output_side),
    )


def _require_cam_joint(reducer: Reducer) -> None:
    """Raise DesignError if the requested joint of cams and shaft is not possible.

    A plastic shaft cannot have shrunk cams; splines and clamping screws must fit in the cams (`cam_spline`,
    `cam_clamp`).
    """
    design = reducer.design
    if design.shaft.cam_joint == "shrink" and design.material_of(names.SHAFT).is_plastic:
        raise DesignError(
            'a plastic shaft creeps in a shrink fit: set shaft.cam_joint = "key", or choose a metal '
            "(shaft_material.name)"
        )
    cam_spline(reducer)
    cam_clamp(reducer)


def _size_motor_side(
    reducer: Reducer, motor: Motor, screws: Screws, dowel: stock.Dowel | None, outer: float, output_side: OutputSide
) -> MotorSide:
    """Size the motor cover: its cavity for the crank, the flange of the motor and the step in its outer radius.

    A DesignError is raised if motor flange or crank do not fit.

    Parameters
    ----------
    reducer, motor
        The reducer, and its motor.
    screws, dowel
        Screws of the covers, and the dowels between covers and ring; None: no dowels.
    outer
        Outer radius of the cover [m].
    output_side
        Sizes of the output, whose second disc turns in the cover.
    """
    design, wall, end = reducer.design, least_wall(reducer), ring_end(reducer)
    half_width, segments = design.gear.stack_width / 2.0, crank_segments(reducer)
    far_seat, near_seat = bearing_seats(reducer, segments)
    seat = seat_radius(reducer, near_seat[1] - near_seat[0])
    seat_of_second_disc = 0.5 * output_side.hub.outside if output_side.motor_bearing else 0.0
    if output_side.stop_ring:
        seat_of_second_disc = output_side.stop_ring.radius
    second_disc_end = (
        -half_width - AXIAL_GAP - design.output.disc_thickness if design.output.support == "both_ends" else -half_width
    )
    cavity, max_cavity = _cavity_radii(reducer, screws, seat, wall, output_side)
    weight = segments.get("counterweight")
    floor = min(weight.z0 if weight else second_disc_end, second_disc_end) - AXIAL_GAP
    flange = choose_motor_flange(reducer, motor, outer, seat, wall, max_cavity)
    if flange.tapped:
        cavity = max(cavity, motor_heads_end(flange))
    floor_thickness = motor_floor_thickness(reducer, flange, wall)
    clamped_length = min_grip(screws.bolt, wall) + 2.0 * ((0.0 if screws.outside else end) - axial_play(reducer))
    screw_tip = (
        (end if screws.outside else -end)
        - hole_depth(reducer, screws.bolt.thread, screws.length - clamped_length)
        - wall
    )
    bearing_start = near_seat[0] if design.shaft.mounting == "straddle" else far_seat[0]
    bearing = stock_shaft_bearing(reducer, near_seat[1] - near_seat[0])
    ring_parts = choose_crank_end(reducer, bearing, seat, floor - near_seat[1])
    max_face = min(floor, screw_tip) - floor_thickness
    face, journal = _flange_and_crank_start(reducer, flange, bearing_start, ring_parts, wall, max_face)
    return MotorSide(
        motor=flange,
        face=face,
        journal=journal,
        cavity=cavity,
        floor=floor,
        pocket=min(face + floor_thickness, floor),
        step=max(min(screw_tip, -end - min_grip(screws.bolt, wall), _pins_end(reducer, dowel, end) - wall), face),
        slim=max(cavity, seat_of_second_disc, flange.circle + thread_radius(reducer, flange.thread)) + 2.0 * wall,
        crank_end=ring_parts,
    )


def _size_output_side(reducer: Reducer, screws: Screws, seat: float, rim: float, stop_ring_radius: float) -> OutputSide:
    """Choose bearings, hub and flange of the output, within the cover screws and the rim of the output's disc.

    A DesignError is raised if no bearing fits.

    Parameters
    ----------
    reducer, screws
        The reducer, and the screws of its covers.
    seat, rim
        Radii of the seats of the shaft bearings, and of the output's disc [m].
    stop_ring_radius
        Outer radius of a stop ring [m], if the bearings need one.
    """
    output, wall, has_both = reducer.design.output, least_wall(reducer), has_both_seats(reducer)
    hub = choose_hub_bearing(reducer, screws, seat, rim, stop_ring_radius)
    retainer = retainer_of(reducer, hub, wall)
    stop_ring = stop_ring_of(hub, stop_ring_radius, wall) if needs_stop_ring(reducer) else None
    lip_height = 2.0 * wall + axial_play(reducer) if has_both and not stop_ring else 0.0
    flange = size_output_flange(reducer, hub, retainer, lip_height)
    motor_bearing = seat_second_disc(reducer, hub, stop_ring, wall) if has_both else None
    disc_start = reducer.design.gear.stack_width / 2.0 + AXIAL_GAP
    if stop_ring:
        hub_floor = ring_end(reducer) + 2.0 * wall
    else:
        hub_floor = disc_start + (2.0 * wall if output.has_disc_seat else output.disc_thickness + AXIAL_GAP)
    if output.has_disc_seat:
        end, shoulder = _output_disc_end(reducer, screws, seat, flange), 0.0 if has_both else 2.0 * wall
    else:
        thread_length = 2.0 * RULES.engagement * flange.flange_bolt.thread
        end, shoulder = max(_far_end(reducer), hub_floor) + 2.0 * wall + thread_length, 0.5 * hub.width
    bearing_widths = count_cover_bearings(hub, motor_bearing) * hub.width
    return OutputSide(
        hub=hub,
        hub_floor=hub_floor,
        spacing=max(shoulder, end - hub_floor - bearing_widths),
        retainer=retainer,
        motor_bearing=motor_bearing,
        stop_ring=stop_ring,
        **vars(flange),
    )


def _far_end(reducer: Reducer) -> float:
    """Return where the crank ends in the hub [m], with its collar; 0 for a crank that ends before the hub."""
    if reducer.design.shaft.mounting != "straddle":
        return 0.0
    return bearing_seats(reducer, crank_segments(reducer))[0][1] + RULES.collar


def _output_disc_end(reducer: Reducer, screws: Screws, seat: float, flange: OutputFlange) -> float:
    """Return the least z [m] at which the output disc can end and its flange begin: behind pins, screws and crank.

    `screws` are those of the covers, and `seat` is the radius of the seats of the shaft bearings [m]. Raises
    DesignError if the bearing of the crank in the disc reaches the output pins.
    """
    design, wall = reducer.design, least_wall(reducer)
    _require_seat_inside_pins(reducer, seat, design.shaft.mounting == "straddle", wall)
    disc_start = design.gear.stack_width / 2.0 + AXIAL_GAP
    return max(
        disc_start + design.output.disc_thickness,
        disc_start + wall + flange_screw_depth(reducer, flange.flange_bolt, flange.flange_thickness),
        _far_end(reducer) + 2.0 * wall,
        ring_end(reducer) + min_grip(screws.bolt, wall) + screws.bolt.head_height,
    )


def _flange_and_crank_start(
    reducer: Reducer, motor: MotorFlange, bearing_start: float, crank_end: CrankEnd, wall: float, max_face: float
) -> tuple[float, float]:
    """Return the positions of the motor's flange face and of the motor-side end of the crank along z [m].

    A straddled crank with a bore for the motor shaft starts at its bearing. Any other crank starts where the journal of
    the design does; the journal of a hollow crank protrudes from the face, for a belt pulley or the rotor of a
    frameless motor.

    Parameters
    ----------
    reducer, motor
        The reducer, and the flange of its motor.
    bearing_start
        Start of the bearing next to the motor along z [m].
    crank_end
        Retaining ring on the crank or seal ring on the motor side of this bearing.
    wall
        Minimum wall of the cover [m].
    max_face
        Largest z of the flange face [m].
    """
    crank_start = bearing_start - crank_end.journal
    journal = min(crank_segments(reducer)["journal"].z0, crank_start)
    bore_limit = _bore_end(reducer) - motor.shaft_length - RULES.blind_room
    is_hollow = reducer.design.shaft.bore_radius > 0.0
    is_shortened = reducer.design.shaft.mounting == "straddle" and motor.shaft > 0.0
    start, seat_start = crank_start if is_shortened or is_hollow else journal, bearing_start - crank_end.seal_width
    face = min(min(start - axial_play(reducer), seat_start - wall) - RULES.pilot_depth, max_face, bore_limit)
    if is_shortened:
        journal = max(journal, min(crank_start, face + motor.shaft_length - 2.0 * RULES.engagement * motor.shaft))
    return face, journal


def _cover_material(reducer: Reducer, requested: str) -> str:
    """Return the material of the covers by name, or an empty string for the same material as the ring.

    Raises
    ------
    DesignError
        The requested material is not a metal of the library, or the ring is of a plastic.
    """
    ring_material = reducer.design.material_of(names.HOUSING)
    if requested == "auto":
        return (
            ""
            if ring_material.is_plastic or ring_material.density <= 2.0 * MATERIALS[LIGHT_METAL].density
            else LIGHT_METAL
        )
    name = material_name(requested)
    metals = [metal for metal in MATERIALS if not Material(name=metal).is_plastic]
    if ring_material.is_plastic:
        raise DesignError(
            f"covers of {requested!r} are not possible on a ring of {ring_material.name}: covers and ring may differ "
            "in material only if both are metals. Omit the cover material"
        )
    if name not in metals:
        raise DesignError(
            f"covers of {requested!r} are not possible: covers and ring may differ in material only if both are "
            f"metals. Choose one of {', '.join(metals)}, or omit the cover material"
        )
    return name


def casing_or_none(reducer: Reducer, motor: Motor = "auto", cover_material: str = "auto") -> tuple[Casing | None, str]:
    """Return the casing and an empty string, or None and the reason why covers, bearings or screws do not fit.

    `motor` and `cover_material` are those of `casing`.

    Raises
    ------
    DesignError
        The casing does not fit, and the motor or the cover material is not ``auto``.
    """
    try:
        return casing(reducer, motor, cover_material), ""
    except DesignError as error:
        if motor != "auto" or cover_material != "auto":
            raise
        return None, str(error)


def cover_radius(reducer: Reducer) -> float:
    """Return the outer radius of the covers [m]; it is that of the housing if the cover screws fit in its wall.

    Raises
    ------
    DesignError
        No screws in stock are long enough.
    """
    wall = least_wall(reducer)
    return _cover_radius(choose_cover_screws(reducer, wall), reducer.design.housing.outer_radius, wall)


def _cover_radius(screws: Screws, radius: float, wall: float) -> float:
    return screws.circle + counterbore(screws.bolt) + wall if screws.outside else radius


def seat_radius(reducer: Reducer, width: float) -> float:
    """Return the radius [m] of the seats of the shaft bearings, which are `width` [m] wide.

    It is that of a bearing in stock, or `CasingRules.bearing_ratio` times the radius of the shaft.
    """
    bearing = stock_shaft_bearing(reducer, width)
    return 0.5 * bearing.outside if bearing else RULES.bearing_ratio * reducer.design.shaft.radius


def _pins_end(reducer: Reducer, dowel: stock.Dowel | None, end: float) -> float:
    """Return the end of the dowels, and of pins in sleeves, in the motor cover [m]."""
    pin_depth = 2.0 * sleeve_core_radius(reducer) if reducer.design.ring.has_sleeves else 0.0
    return -end - max(0.5 * dowel.length if dowel else 0.0, pin_depth)


def _cavity_radii(
    reducer: Reducer, screws: Screws, seat: float, wall: float, output_side: OutputSide
) -> tuple[float, float]:
    """Compute the radius [m] of the cavity for the crank in the motor cover, and the largest possible radius [m].

    The largest cavity still covers a fifth of the end face of each ring pin, so that the cover retains the pins. If a
    bearing is around the second disc of the output, the cavity is the shoulder of its outer ring instead. Raises
    DesignError if the crank does not fit.

    Parameters
    ----------
    reducer, screws
        The reducer, and the screws of its covers.
    seat
        Radius of the seats of the shaft bearings [m].
    wall
        Gap around the crank, and minimum wall of the cover [m].
    output_side
        Sizes of the output, whose second disc turns in the cavity.
    """
    design = reducer.design
    output, hub = design.output, output_side.hub
    rim_radius = output.pin_circle_radius + (1.0 + RIM) * output.pin_radius if output.support == "both_ends" else 0.0
    if output_side.motor_bearing:
        rim_radius = 0.5 * hub.bore
    min_radius = max(rim_radius, seat - wall)
    crank_radius = design.shaft.counterweight_radius if design.gear.discs == 1 else design.shaft.radius
    cavity_radius = max(crank_radius, min_radius) + wall
    outer_limit = (
        screws.circle - thread_radius(reducer, screws.bolt.thread)
        if not screws.outside
        else design.housing.outer_radius
    )
    max_radius = min(outer_limit - wall, design.ring_root_radius)
    if not cavity_radius <= max_radius:
        raise DesignError(
            f"the crank needs a diameter of {2e3 * cavity_radius:.4g} mm in the motor-side cover, but only "
            f"{2e3 * max_radius:.4g} mm is available: reduce shaft.counterweight_radius_mm or "
            "output.pin_circle_radius_mm"
        )
    if output_side.motor_bearing:
        shoulder = hub.shoulders[1]
        if cavity_radius > shoulder:
            raise DesignError(
                f"a bearing of {MILLIMETRES * hub.bore:g} x {MILLIMETRES * hub.outside:g} mm around the second disc of "
                f"the output leaves {MILLIMETRES * 2.0 * shoulder:.4g} mm for the crank, which needs "
                f"{MILLIMETRES * 2.0 * cavity_radius:.4g} mm: reduce shaft.counterweight_radius_mm or "
                "output.pin_circle_radius_mm"
            )
        return shoulder, shoulder
    return cavity_radius, min(max_radius, reducer.design.pin_retaining_radius)


def output_cover_step(casing: Casing) -> float | None:
    """Return the height [m] of the step of the output cover, above the heads of its screws; None without a step."""
    step_height = casing.end + casing.grip + casing.screws.bolt.head_height
    has_step = (
        casing.output_neck < casing.screws.circle - counterbore(casing.screws.bolt) and step_height < casing.hub_floor
    )
    return step_height if has_step else None


def _bore_end(reducer: Reducer) -> float:
    """Compute the end along z [m] of the longest bore for the motor shaft: the cam if the crank is one piece."""
    segments = crank_segments(reducer)
    return segments[names.CAM].z0 if names.CAM in segments else max(segment.z1 for segment in segments.values())


def bearing_width_of(reducer: Reducer) -> float:
    """Compute the width of each bearing of the shaft [m]."""
    start, end = bearing_seats(reducer, crank_segments(reducer))[0]
    return end - start


def _require_seat_inside_pins(reducer: Reducer, seat: float, straddles: bool, wall: float) -> None:
    """Raise DesignError unless the seat of the shaft's bearing in an output disc stays inside of the output pins.

    `seat` is the radius of the seat and `wall` the minimum wall around it [m]; `straddles` is whether the shaft has a
    bearing on either side of the discs, and so one in an output disc.
    """
    max_seat = reducer.design.output.pin_circle_radius - reducer.design.output.root_radius - wall
    if straddles and seat > max_seat:
        raise DesignError(
            f"the bearing of the shaft needs a seat of {2e3 * seat:.4g} mm in the output disc, but the pins leave "
            f'{2e3 * max_seat:.4g} mm: choose a thinner shaft (shaft.radius_mm), or output.main_bearing_seat = "hub"'
        )


def flange_centres(casing: Casing) -> Array:
    """Compute the centres of the holes of the flange (n, 2) [m].

    Holes of the flange's screws (even indices) alternate with threaded holes for the load (odd indices).
    """
    return casing.flange_circle * unit(casing.flange_phase + pattern_angles(casing.flange_screws))


def flange_dowel_centres(casing: Casing) -> Array:
    """Compute the centres of the dowels of hub and flange (n, 2) [m]: one inside of each threaded hole for the load."""
    return casing.flange_dowel_circle * unit(casing.flange_phase + pattern_angles(casing.flange_screws)[1::2])


def motor_centres(casing: Casing) -> Array:
    """Compute the centres of the motor screws (n, 2) [m]."""
    count = casing.motor.screws
    return casing.motor.circle * unit((2.0 * np.arange(count) + 1.0) * np.pi / count)


def dowel_centres(casing: Casing) -> Array:
    """Compute the centres of the dowels of a face (n, 2) [m]."""
    return casing.dowel_circle * unit(np.array(casing.dowel_angles))
