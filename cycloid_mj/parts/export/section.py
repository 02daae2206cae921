"""Every part as exact cross-sections: what CAD files are made of. The same parts as ``parts``, by curves."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.geometry.modification import flank_ends
from cycloid_mj.parts import (
    VISUAL_CHORD_ERROR,
    crank_stretches,
    output_centres,
    output_solid,
    parts,
    pin_radius,
    sleeve_core_radius,
    spacer_radius,
)
from cycloid_mj.parts.export.curve import Arc, Circle, Curve, LineSegment, SmoothCurve, fit_splines, turned_curve
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import arc_half_angle, wall_radius


@dataclass(frozen=True)
class PartSection:
    """One stretch of a part: closed loops of curves from `z0` to `z1` [m], the first its outline, the others its holes.

    The curves of a loop follow each other counter-clockwise, and the first runs that way itself.
    """

    name: str
    loops: tuple[tuple[Curve, ...], ...]
    z0: float
    z1: float


def part_sections(reducer: Reducer, splines: int = 1) -> dict[str, tuple[PartSection, ...]]:
    """Build the sections of every part of a design, with its clearances, each part in its own frame.

    Parameters
    ----------
    reducer
        The reducer.
    splines
        Splines to each lobe of the gear and each root of the internal gear.

    Raises
    ------
    DesignError
        A part cannot be made.
    """
    design = reducer.design
    solids = parts(reducer, VISUAL_CHORD_ERROR)  # refuses what does not fit together
    half, width = design.gear.stack_width / 2.0, design.gear.face_width / 2.0
    ring = _internal_gear(reducer, splines) if design.ring.kind == "nonpin" else _pinwheel(reducer)
    wheel = PartSection("housing", ((_circle(design.housing.outer_radius),), ring), -half, half)
    teeth = _gear_outline(reducer, splines)
    gears = {
        name: (PartSection("gear", (_ahead(reducer, teeth, phase), *_gear_holes(reducer)), -width, width),)
        for name, phase in zip(reducer.gears, reducer.phases, strict=True)
    }
    sections = {"housing": (wheel, *_cores(reducer, half)), **_crank(reducer), **gears, "output": _output(reducer)}
    if design.ring.kind == "pin":
        bore = ((_circle(design.ring.sleeve_bore_radius),),) if design.ring.has_sleeves else ()
        sections["pin"] = (PartSection("pin", ((_circle(design.ring.pin_radius),), *bore), -half, half),)
    if names.ROLLER in solids:
        tube = ((_circle(design.output.pin_radius),), (_circle(design.output.core_radius),))
        sections[names.ROLLER] = (PartSection("roller", tube, -width, width),)
    return sections


def _cores(reducer: Reducer, half: float) -> tuple[PartSection, ...]:
    """List the pressed-in pins inside the sleeves; none elsewhere."""
    design = reducer.design
    if not design.ring.has_sleeves:
        return ()
    angles = 2.0 * np.pi * np.arange(design.ring.teeth) / design.ring.teeth
    centres = design.ring.pin_circle_radius * profile.unit(angles)
    radius = sleeve_core_radius(reducer)
    return tuple(PartSection("pins", ((_circle(radius, centre),),), -half, half) for centre in centres)


def _circle(radius: float, centre: Array | tuple[float, float] = (0.0, 0.0)) -> Circle:
    return Circle((float(centre[0]), float(centre[1])), radius)


def _gear_outline(reducer: Reducer, splines: int) -> tuple[Curve, ...]:
    """List the profile lobe by lobe, counter-clockwise, each from the middle of one valley to that of the next.

    Flanks that are turned towards the middle of their lobe are splines of their own.
    """
    gear, offset, rotation = reducer.gear_profile, reducer.profile_offset, reducer.design.modification.rotation
    pitch = 2.0 * math.pi / gear.lobes
    backwards = SmoothCurve(
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


def _ahead(reducer: Reducer, teeth: tuple[Curve, ...], phase: float) -> tuple[Curve, ...]:
    """Turn the teeth of a disc that is ahead on the crank by a phase [rad] back against its holes."""
    return tuple(turned_curve(curve, phase / reducer.design.lobes) for curve in teeth) if phase else teeth


def _gear_holes(reducer: Reducer) -> list[tuple[Curve, ...]]:
    design = reducer.design
    hole = design.output.hole_radius + design.clearance.output
    bore = _circle(design.gear.bore_radius + design.clearance.cam)
    return [(bore,), *((_circle(hole, centre),) for centre in output_centres(reducer))]


def _internal_gear(reducer: Reducer, splines: int) -> tuple[Curve, ...]:
    """List the ring as splines for each root and one arc for the lobe after it, counter-clockwise.

    Sigma from B0 to 2 pi - B0 is the whole root counter-clockwise of lobe 1.
    """
    gear = reducer.tooth_profile
    pitch, alpha, B0 = 2.0 * math.pi / gear.ring_teeth, envelope.largest_alpha(gear), gear.best_phase
    arc = Arc((0.0, gear.pin_circle_radius), gear.pin_radius, -math.pi / 2.0 - alpha, -math.pi / 2.0 + alpha)
    flank = SmoothCurve(
        points=lambda B: envelope.Sigma(gear, B).points,
        arc_length=lambda B: envelope.Sigma(gear, B).arc_length,
        tangents=lambda B: profile.unit(envelope.Sigma(gear, B).normal_angle - math.pi / 2.0),
        curvature=lambda B: -1.0 / envelope.Sigma(gear, B).radius,
    )
    root = fit_splines(flank, B0, 2.0 * math.pi - B0, splines)
    following = turned_curve(arc, -pitch)
    return tuple(turned_curve(curve, -i * pitch) for i in range(gear.ring_teeth) for curve in (*root, following))


def _pinwheel(reducer: Reducer) -> tuple[Curve, ...]:
    """List the sockets and the lands between them as arcs, counter-clockwise from socket 1 on +y."""
    design = reducer.design
    ring = design.ring
    centre, radius = ring.pin_circle_radius, ring.pin_radius + design.socket_play
    half, wall = arc_half_angle(design, radius), wall_radius(design)
    edge = math.atan2(radius * math.sin(half), centre + radius * math.cos(half))
    up, pitch = math.pi / 2.0, 2.0 * math.pi / ring.teeth
    socket = Arc((0.0, centre), radius, up - half, up + half)
    land = Arc((0.0, 0.0), wall, up + edge, up + pitch - edge)
    return tuple(turned_curve(curve, -i * pitch) for i in range(ring.teeth) for curve in (socket, land))


def _crank(reducer: Reducer) -> dict[str, tuple[PartSection, ...]]:
    """Build the crank with the faces of its solids: one part, or shaft, spacer and cams."""
    design = reducer.design
    solids, radius = parts(reducer, VISUAL_CHORD_ERROR), design.shaft.radius
    if design.gear.discs == 1:
        return {names.SHAFT: _shaft(reducer)}
    (shaft,), (spacer,) = solids[names.SHAFT].prisms, solids[names.SPACER].prisms
    rings = {names.SPACER: (spacer, _circle(spacer_radius(reducer)))}
    for name, phase in zip(names.all_numbered(names.CAM, design.gear.discs), reducer.phases, strict=True):
        (cam,) = solids[name].prisms
        rings[name] = (cam, _circle(design.gear.bore_radius, design.gear.eccentricity * profile.unit(-phase)))
    sections: dict[str, tuple[PartSection, ...]] = {
        names.SHAFT: (PartSection("journal", ((_circle(radius),),), shaft.z0, shaft.z1),)
    }
    for name, (ring, outline) in rings.items():
        sections[name] = (PartSection(names.family(name), ((outline,), (_circle(radius),)), ring.z0, ring.z1),)
    return sections


def _shaft(reducer: Reducer) -> tuple[PartSection, ...]:
    """List journal, counterweight, journal and cam, with the faces of the balanced solid."""
    design = reducer.design
    shaft, cam = design.shaft, design.gear.bore_radius
    outer, inner = shaft.counterweight_radius, shaft.radius
    counterweight = (
        Arc((0.0, 0.0), outer, math.pi, 2.0 * math.pi),
        LineSegment((outer, 0.0), (inner, 0.0)),
        Arc((0.0, 0.0), inner, 0.0, math.pi),
        LineSegment((-inner, 0.0), (-outer, 0.0)),
    )
    special = {"counterweight": (counterweight,), "cam": ((_circle(cam, (0.0, design.gear.eccentricity)),),)}
    return tuple(
        PartSection(name, special.get(name, ((_circle(inner),),)), stretch.z0, stretch.z1)
        for name, stretch in crank_stretches(reducer).items()
    )


def _output(reducer: Reducer) -> tuple[PartSection, ...]:
    """List the disc and its pins, and the second disc where it holds them, too."""
    disc, *others = output_solid(reducer, VISUAL_CHORD_ERROR).prisms
    rim = float(np.linalg.norm(disc.outline, axis=1).max())
    centres = output_centres(reducer)
    pins, second = others[: len(centres)], others[len(centres) :]
    pin, eye = pin_radius(reducer), reducer.design.gear.bore_radius + reducer.design.gear.eccentricity
    return (
        PartSection("disc", ((_circle(rim),),), disc.z0, disc.z1),
        *(
            PartSection("pins", ((_circle(pin, centre),),), one.z0, one.z1)
            for one, centre in zip(pins, centres, strict=True)
        ),
        *(PartSection("second_disc", ((_circle(rim),), (_circle(eye),)), one.z0, one.z1) for one in second),
    )
