"""Every part as exact cross-sections: what CAD files are made of. The same parts as ``solid``, by curves."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj import envelope, profile
from cycloid_mj.design import Design
from cycloid_mj.export.curve import Arc, Circle, Curve, Flank, Line, fit_splines, turned_curve
from cycloid_mj.modification import flank_ends, gear_profile, profile_offset, tooth_profile
from cycloid_mj.solid import (
    VISUAL_CHORD_ERROR,
    housing_solid,
    output_centres,
    output_solid,
    parts,
    shaft_solid,
    sleeve_core_radius,
)
from cycloid_mj.types import Array


@dataclass(frozen=True)
class Section:
    """One stretch of a part: closed loops of curves from `z0` to `z1` [m], the first its outline, the others its holes.

    The curves of a loop follow each other counter-clockwise, and the first runs that way itself.
    """

    name: str
    loops: tuple[tuple[Curve, ...], ...]
    z0: float
    z1: float


def part_sections(design: Design, splines: int = 1) -> dict[str, tuple[Section, ...]]:
    """Give the sections of every part of a design, with its clearances, each part in its own frame.

    Parameters
    ----------
    design
        The design.
    splines
        Splines to each lobe of the gear and each root of the internal gear.

    Raises
    ------
    DesignError
        A part cannot be made.
    """
    parts(design, VISUAL_CHORD_ERROR)  # refuses what does not fit together
    half = design.gear.face_width / 2.0
    ring = _internal_gear(design, splines) if design.ring.kind == "nonpin" else _pinwheel(design)
    wheel = Section("housing", ((_circle(design.housing.outer_radius),), ring), -half, half)
    found = {
        "housing": (wheel, *_cores(design, half)),
        "shaft": _shaft(design),
        "gear": (Section("gear", (_gear_outline(design, splines), *_gear_holes(design)), -half, half),),
        "output": _output(design),
    }
    if design.ring.kind == "pin":
        bore = ((_circle(design.ring.sleeve_bore_radius),),) if design.ring.has_sleeves else ()
        found["pin"] = (Section("pin", ((_circle(design.ring.pin_radius),), *bore), -half, half),)
    return found


def _cores(design: Design, half: float) -> tuple[Section, ...]:
    """Give the pressed-in pins inside the sleeves; none elsewhere."""
    if not design.ring.has_sleeves:
        return ()
    angles = 2.0 * np.pi * np.arange(design.ring.teeth) / design.ring.teeth
    centres = design.ring.pin_circle_radius * profile.unit(angles)
    radius = sleeve_core_radius(design)
    return tuple(Section("pins", ((_circle(radius, centre),),), -half, half) for centre in centres)


def _circle(radius: float, centre: Array | tuple[float, float] = (0.0, 0.0)) -> Circle:
    return Circle((float(centre[0]), float(centre[1])), radius)


def _gear_outline(design: Design, splines: int) -> tuple[Curve, ...]:
    """Give the profile lobe by lobe, counter-clockwise, each from the middle of one valley to that of the next.

    Flanks that are turned towards the middle of their lobe are splines of their own.
    """
    gear, offset, rotation = gear_profile(design), profile_offset(design), design.modification.rotation
    pitch = 2.0 * math.pi / gear.lobes
    backwards = Flank(
        points=lambda x: profile.outline(gear, -x, offset),
        arc_length=lambda x: -profile.arc_length(gear, -x, offset),
        tangents=lambda x: profile.unit(profile.normal_angle(gear, -x) - math.pi / 2.0),
        curvature=lambda x: profile.curvature(gear, -x, offset),
    )
    stretches = [(0.0, pitch, 0.0)]
    if rotation:
        ends = flank_ends(gear, offset, rotation)
        up, down = (-ends.valley, pitch / 2.0 - ends.tip), (pitch / 2.0 + ends.tip, pitch + ends.valley)
        stretches = [(*up, -rotation), (*down, rotation)]
    lobe = [
        turned_curve(curve, turn)
        for low, high, turn in stretches
        for curve in fit_splines(backwards, low, high, splines)
    ]
    return tuple(turned_curve(curve, -i * pitch) for i in range(gear.lobes) for curve in lobe)


def _gear_holes(design: Design) -> list[tuple[Curve, ...]]:
    hole = design.output.hole_radius + design.clearance.output
    bore = _circle(design.gear.bore_radius + design.clearance.cam)
    return [(bore,), *((_circle(hole, centre),) for centre in output_centres(design))]


def _internal_gear(design: Design, splines: int) -> tuple[Curve, ...]:
    """Give the ring as splines for each root and one arc for the lobe after it, counter-clockwise.

    Sigma from B0 to 2 pi - B0 is the whole root counter-clockwise of lobe 1.
    """
    gear = tooth_profile(design)
    pitch, alpha, B0 = 2.0 * math.pi / gear.ring_teeth, envelope.largest_alpha(gear), profile.best_phase(gear)
    arc = Arc((0.0, gear.pin_circle_radius), gear.pin_radius, -math.pi / 2.0 - alpha, -math.pi / 2.0 + alpha)
    flank = Flank(
        points=lambda B: envelope.sigma_points(gear, B),
        arc_length=lambda B: envelope.sigma_arc_length(gear, B),
        tangents=lambda B: profile.unit(envelope.sigma_normal_angle(gear, B) - math.pi / 2.0),
        curvature=lambda B: -1.0 / envelope.sigma_radius(gear, B),
    )
    root = fit_splines(flank, B0, 2.0 * math.pi - B0, splines)
    following = turned_curve(arc, -pitch)
    return tuple(turned_curve(curve, -i * pitch) for i in range(gear.ring_teeth) for curve in (*root, following))


def _pinwheel(design: Design) -> tuple[Curve, ...]:
    """Give the sockets and the lands between them as arcs, counter-clockwise from socket 1 on +y."""
    ring = design.ring
    centre, radius = ring.pin_circle_radius, ring.pin_radius + design.socket_play
    hole = housing_solid(design, VISUAL_CHORD_ERROR).prisms[0].holes[0]
    wall = float(np.linalg.norm(hole, axis=1).min())
    opening = math.acos((wall**2 - centre**2 - radius**2) / (2.0 * centre * radius))
    edge = math.atan2(radius * math.sin(opening), centre + radius * math.cos(opening))
    up, pitch = math.pi / 2.0, 2.0 * math.pi / ring.teeth
    socket = Arc((0.0, centre), radius, up - opening, up + opening)
    land = Arc((0.0, 0.0), wall, up + edge, up + pitch - edge)
    return tuple(turned_curve(curve, -i * pitch) for i in range(ring.teeth) for curve in (socket, land))


def _shaft(design: Design) -> tuple[Section, ...]:
    """Give journal, counterweight, journal and cam, with the faces of the balanced solid."""
    shaft, cam = design.shaft, design.gear.bore_radius
    journal = ((_circle(shaft.radius),),)
    outer, inner = shaft.counterweight_radius, shaft.radius
    counterweight = (
        Arc((0.0, 0.0), outer, math.pi, 2.0 * math.pi),
        Line((outer, 0.0), (inner, 0.0)),
        Arc((0.0, 0.0), inner, 0.0, math.pi),
        Line((-inner, 0.0), (-outer, 0.0)),
    )
    loops = (journal, (counterweight,), journal, ((_circle(cam, (0.0, design.gear.eccentricity)),),), journal)
    names = ("journal", "counterweight", "inner_journal", "cam", "far_journal")
    stretches = shaft_solid(design).prisms  # the last only where the shaft straddles the gear
    return tuple(
        Section(name, loop, stretch.z0, stretch.z1)
        for name, loop, stretch in zip(names, loops, stretches, strict=False)
    )


def _output(design: Design) -> tuple[Section, ...]:
    """Give the disc and its pins."""
    disc, *pins = output_solid(design, VISUAL_CHORD_ERROR).prisms
    rim = float(np.linalg.norm(disc.outline, axis=1).max())
    centres = output_centres(design)
    pin = design.output.pin_radius
    stretches = zip(pins, centres, strict=True)
    return (
        Section("disc", ((_circle(rim),),), disc.z0, disc.z1),
        *(Section("pins", ((_circle(pin, centre),),), stretch.z0, stretch.z1) for stretch, centre in stretches),
    )
