"""The joints of the mechanism: cams on the shaft, bearings in the discs, pins of ring and output with their rollers."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.design import fits, stock
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts import crank_segments, sleeve_core_radius
from cycloid_mj.parts.cam_bearing import cam_bearing, cam_radius
from cycloid_mj.parts.export.bearings import (
    FREE_FIT,
    RETAINED_FIT,
    ROLLER_FIT,
    cam_bearing_fit,
    cup_fit,
    output_pin_fit,
    pin_pieces,
    roller_bearing,
    sleeve_pin_depth,
    sleeve_pin_fit,
)
from cycloid_mj.parts.export.cam_clamp import CLAMP_FIT, cam_clamp, cam_screws, cross_holes
from cycloid_mj.parts.export.cam_splines import cam_spline, spline_fit
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    in_one_piece,
)
from cycloid_mj.parts.export.crank_rings import hub_radius
from cycloid_mj.parts.export.joint import BoughtPart, Joint, JointKind
from cycloid_mj.parts.export.keyway import KeyContour
from cycloid_mj.parts.export.round_part import Hole, RoundPart
from cycloid_mj.parts.joint_strength import JOINTS, PressFit, shrink_difference
from cycloid_mj.reducer import Reducer, once

KEY_ANGLES = 360
"""Number of angles around the shaft at which the wall of the cams over a keyway is compared (heuristic)."""

GLUE_FIT = "H7/g6, retaining compound"
"""Fit of cams that are too thin for a keyway: the gap for an anaerobic compound."""


SHRINK_FITS = "H7/u6", "H7/s6", "H7/r6", "H7/p6"
"""Press fits of ISO 286-2 of cams on the shaft, the tightest first."""


@dataclass(frozen=True)
class ShrinkFit:
    """The shrink fit of cams on the shaft: its zones, and the press fit of the thinnest wall of a cam.

    `yield_pressure` [Pa] is that at which the wall or the shaft yields, `difference` [K] that of the temperatures of
    cam and shaft to be joined.
    """

    zones: str
    press: PressFit
    yield_pressure: float
    difference: float


@dataclass(frozen=True)
class CamKey:
    """The key of all cams: the bought key, its angle from +x at the crank angle 0 [rad], and its ends along z [m]."""

    bought: stock.StockKey
    angle: float
    low: float
    high: float


def crank_joints(reducer: Reducer, casing: Casing) -> Iterator[Joint]:
    """Yield the joints of crank, discs, ring pins and output pins."""
    yield from _cam_joint(reducer, casing)
    yield from _cam_bearing_joint(reducer)
    yield from _ring_pin_joints(reducer, casing)
    yield from _output_pin_joints(reducer)


@once
def cam_key(reducer: Reducer, casing: Casing) -> CamKey | None:
    """Choose the parallel key that joins the cams of several discs to the shaft.

    The result is None if no key fits, or if the cams are joined to the shaft in another way. The keyways fix the phases
    of the cams. The key is at the angle at which the walls of the cams over it are thickest. It must leave a wall in
    the cams, and in the shaft over the motor's bore, and stay within the faces of the spacer, which touch the cams but
    not their bearings.
    """
    design = reducer.design
    if design.cam_joint != "key":
        return None
    segments, radius = crank_segments(reducer), design.shaft.radius
    cams = [segments[name] for name in names.all_numbered(names.CAM, design.gear.discs)]
    cams_start, cams_end = cams[0].z0, cams[-1].z1
    key = stock.key_for(2.0 * radius, cams_end - cams_start)
    if key is None:
        return None
    angles = 2.0 * math.pi * np.arange(KEY_ANGLES) / KEY_ANGLES
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    cam_outer_radius, eccentricity = cam_radius(reducer), design.gear.eccentricity
    offsets = eccentricity * directions @ unit(-np.array(reducer.phases)).T
    walls = (offsets + np.sqrt(offsets**2 + cam_outer_radius**2 - eccentricity**2)).min(axis=1)
    best_index, bore = int(np.argmax(walls)), casing.motor_bore
    core_radius = bore[0] if bore and bore[2] > cams_start else design.shaft.bore_radius
    keyway_radius = math.hypot(radius + key.in_hub, 0.5 * key.width)
    does_fit = walls[best_index] >= keyway_radius + RULES.min_wall and hub_radius(reducer, casing) >= keyway_radius
    if not (does_fit and radius - key.in_shaft >= core_radius + RULES.min_wall):
        return None
    midpoint = 0.5 * (cams_start + cams_end)
    return CamKey(key, float(angles[best_index]), midpoint - 0.5 * key.length, midpoint + 0.5 * key.length)


def shrink_fit(reducer: Reducer, casing: Casing) -> ShrinkFit | None:
    """Return the shrink fit of cams on the shaft; None if the cams have another joint.

    It is the tightest of `SHRINK_FITS` that can be joined and at which neither part yields, or the last. The hub is a
    ring as thick as the thinnest wall of the cam (conservative). The result has the tolerance zones, the press fit, the
    pressure at which a part yields, and the temperature difference for joining.
    """
    design = reducer.design
    if design.cam_joint != "shrink":
        return None
    steel, diameter, bore = design.material_of(names.SHAFT), 2.0 * design.shaft.radius, casing.motor_bore
    cam_start = crank_segments(reducer)[names.numbered_name(names.CAM, 1)].z0
    core_radius = bore[0] if bore and bore[2] > cam_start else design.shaft.bore_radius
    hub_diameter = 2.0 * (cam_radius(reducer) - design.gear.eccentricity)
    elasticity = steel.youngs_modulus, steel.poisson
    press_fit = PressFit(diameter, design.gear.face_width, hub_diameter, elasticity, elasticity, 2.0 * core_radius)
    max_pressure = min(
        press_fit.yield_pressure(steel.yield_strength), press_fit.shaft_yield_pressure(steel.yield_strength)
    )
    for zones in SHRINK_FITS:
        max_interference = -fits.clearances(zones, diameter)[0]
        temperature_difference = shrink_difference(diameter, max_interference, steel.expansion)
        if press_fit.pressure(max_interference) <= max_pressure and temperature_difference <= JOINTS.shrink_difference:
            break
    return ShrinkFit(zones, press_fit, max_pressure, temperature_difference)


def _cam_joint(reducer: Reducer, casing: Casing) -> Iterator[Joint]:
    """Yield the joint of cams and shaft of several discs as the design requests it, glued if no key fits.

    Nothing is yielded for a crank in one piece.
    """
    gear, radius = reducer.design.gear, reducer.design.shaft.radius
    if reducer.design.has_one_piece_crank:
        return
    key, parts = cam_key(reducer, casing), (names.SHAFT, *names.all_numbered(names.CAM, gear.discs))
    name, seat_sizes = "cams on the shaft", (gear.discs, 2.0 * radius, gear.face_width)
    if shrink_joint := shrink_fit(reducer, casing):
        yield Joint(name, JointKind.PRESSED, parts, (), (), f"{shrink_joint.zones}, shrunk", *seat_sizes)
        return
    if spline := cam_spline(reducer):
        sizes_of_hub = gear.discs, spline.minor, gear.face_width
        yield Joint(name, JointKind.SPLINED, parts, (), (), spline_fit(spline), *sizes_of_hub)
        return
    if clamp := cam_clamp(reducer):
        holes = tuple(cross_holes(reducer, clamp))
        screws = cam_screws(reducer, clamp)
        yield Joint(name, JointKind.CLAMPED, parts, (), (screws,), CLAMP_FIT, *seat_sizes, cross_holes=holes)
        return
    if key is None:
        yield Joint(name, JointKind.GLUED, parts, (), (), GLUE_FIT, *seat_sizes)
        return
    stock_key = key.bought
    key_bottom = radius - stock_key.in_shaft
    key_contour = KeyContour(key_bottom, key_bottom + stock_key.height, stock_key.width, key.angle)
    dimensions = (
        *(("width", stock_key.width), ("height", stock_key.height)),
        *(("depth", stock_key.in_shaft), ("length", stock_key.length)),
    )
    solid = RoundPart(names.SHAFT, blocks=((key_contour, key.low, key.high),), bought=True)
    key_part = BoughtPart(
        names.KEY, solid, names.SHAFT, ((0.0, 0.0, 0.0),), dimensions, "C45", stock_key.designation, "P9"
    )
    yield Joint(name, JointKind.KEYED, parts, (), (key_part,), "H7/k6", *seat_sizes)


def _cam_bearing_joint(reducer: Reducer) -> Iterator[Joint]:
    """Yield the joint of discs and cam bearings: pressed in, or rollers in the bore; none if the cam slides."""
    gear, stock_bearing = reducer.design.gear, cam_bearing(reducer)
    if gear.bearing != "rolling":
        return
    kind = JointKind.PRESSED if stock_bearing else JointKind.BEARING
    fit = cam_bearing_fit(reducer, stock_bearing[0]) if stock_bearing else "H6, rollers in the bore of the disc"
    seat_sizes = gear.discs, 2.0 * gear.bore_radius, gear.face_width
    yield Joint("cam bearings in the discs", kind, (names.CAM_BEARING, *reducer.gears), (), (), fit, *seat_sizes)


def _ring_pin_joints(reducer: Reducer, casing: Casing) -> Iterator[Joint]:
    """Yield the connections of the ring pins with other parts (`Joint`); none for an internal gear.

    Pins with sleeves are pressed into both covers, and the sleeves turn on them. Pins without sleeves are in sockets of
    the housing, free or glued.
    """
    ring, width = reducer.design.ring, reducer.design.gear.stack_width
    if ring.kind != "pin":
        return
    if ring.has_sleeves:
        yield _sleeve_pin_joint(reducer, casing)
        seat_sizes = ring.teeth, 2.0 * sleeve_core_radius(reducer), width
        parts = names.PIN, names.PRESSED_PIN
        yield Joint("sleeves on their pins", JointKind.CLEARANCE, parts, (), (), "F7/m6", *seat_sizes)
        return
    fit = FREE_FIT if ring.has_sockets else RETAINED_FIT
    kind = JointKind.CLEARANCE if ring.has_sockets else JointKind.GLUED
    count, length = pin_pieces(reducer)
    seat_sizes = count * ring.teeth, 2.0 * ring.pin_radius, length
    yield Joint("ring pins in their sockets", kind, (names.PIN, names.HOUSING), (), (), fit, *seat_sizes)


def _sleeve_pin_joint(reducer: Reducer, casing: Casing) -> Joint:
    """Return the press-fit joint of the fixed pins, on which the ring's sleeves turn, with motor and output cover.

    Each cover has a hole for each pin, with the radius of the pin. The holes are as deep as `sleeve_pin_depth`.
    """
    ring, radius, depth = reducer.design.ring, sleeve_core_radius(reducer), sleeve_pin_depth(reducer)
    centres = ring.pin_circle_radius * unit(2.0 * np.pi * np.arange(ring.teeth) / ring.teeth)
    holes: tuple[tuple[str, Hole], ...] = (
        (names.MOTOR_COVER, (centres, radius, -casing.end - depth, -casing.end)),
        (names.OUTPUT_COVER, (centres, radius, casing.end, casing.end + depth)),
    )
    parts = names.PRESSED_PIN, names.MOTOR_COVER, names.OUTPUT_COVER
    seat_sizes = 2 * ring.teeth, 2.0 * radius, depth
    return Joint("pins of the sleeves", JointKind.PRESSED, parts, holes, (), sleeve_pin_fit(reducer), *seat_sizes)


def _output_pin_joints(reducer: Reducer) -> Iterator[Joint]:
    """Yield the joints of separate output pins, pressed into the discs of the output, and of the rollers on them."""
    gear, output = reducer.design.gear, reducer.design.output
    if in_one_piece(reducer):
        return
    diameter, disc_count = 2.0 * output.root_radius, 2 if output.support == "both_ends" else 1
    parts = names.OUTPUT_PIN, *((names.OUTPUT, names.SECOND_OUTPUT)[:disc_count])
    seat_sizes = output.pins * disc_count, diameter, output.disc_thickness
    yield Joint("output pins in their discs", JointKind.PRESSED, parts, (), (), output_pin_fit(reducer), *seat_sizes)
    if output.rollers:
        roller_seats = output.pins * gear.discs, diameter, gear.face_width
        parts = names.ROLLER, names.OUTPUT_PIN
        if cup := roller_bearing(reducer):
            cup_seats = roller_seats[0] * cup[1], cup[0].outside, cup[0].width
            name, parts = "needle bearings in the rollers", (names.ROLLER, names.ROLLER_BEARING)
            yield Joint(name, JointKind.PRESSED, parts, (), (), cup_fit(reducer, names.OUTPUT), *cup_seats)
            return
        yield Joint("rollers on the output pins", JointKind.CLEARANCE, parts, (), (), ROLLER_FIT, *roller_seats)
