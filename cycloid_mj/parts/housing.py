"""The ring: pins and the housing with their sockets, or the internal gear."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.geometry import envelope
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts.accuracy import checked_chord_error
from cycloid_mj.parts.contour import CircleContour, Contour, TurnedContour, circles_at
from cycloid_mj.parts.curve import Arc, Curve, SmoothCurve, fit_splines, rotate_curve
from cycloid_mj.parts.fit import require_above, require_below
from cycloid_mj.parts.part import Part, Segment
from cycloid_mj.parts.polygon import arc, rotate_points
from cycloid_mj.parts.prism import Solid
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.reducer.sockets import arc_half_angle, wall_radius

SLIT_SHARE = 1e-3
"""Gap between the halves of a ring relative to its width, so that they can rotate (heuristic)."""


def pin_part(reducer: Reducer) -> Part:
    """Return a ring pin, or its sleeve, as a cylinder through all discs centred at the origin.

    In a ring of two halves it is as long as half of the discs' total width.

    Raises
    ------
    DesignError
        A sleeve is thicker than its radius: it has no bore.
    """
    design = reducer.design
    bores = (
        [CircleContour(sleeve_core_radius(reducer) + design.clearance.pin_sleeve)] if design.ring.has_sleeves else []
    )
    half_length = design.gear.stack_width / 2 / design.ring.halves
    segment = Segment("pin", CircleContour(design.ring.pin_radius), tuple(bores), -half_length, half_length)
    return Part("pin", (segment,), design.material_of("pin").density)


def pin_solid(reducer: Reducer, chord_error: float | None = None) -> Solid:
    """Return `pin_part` as a prism with a chord error [m]; by default that for mass properties."""
    return pin_part(reducer).solid(checked_chord_error(reducer, chord_error))


def sleeve_core_radius(reducer: Reducer) -> float:
    """Compute the radius [m] of the pressed-in pin inside a sleeve: the bore radius of the sleeve minus the clearance.

    Raises
    ------
    DesignError
        The wall of the sleeve leaves no space for the pin.
    """
    design = reducer.design
    thickness, core_space = design.ring.sleeve_thickness, design.ring.pin_radius - design.clearance.pin_sleeve
    require_below("ring.sleeve_thickness", thickness, core_space, "the sleeve leaves no room for its pin")
    return core_space - thickness


def housing_part(reducer: Reducer) -> Part:
    """Return the housing as exact outlines about the reducer axis: the ring without its pins, or the internal gear.

    Each half of a divided ring is one segment, rotated by its angular offset (`ring_spans`), which preloads the teeth;
    the half next to the motor comes first. The housing of sleeved pins includes the pressed-in pins, which both end
    plates (not drawn) support.

    Parameters
    ----------
    reducer
        The reducer; its ``ring.kind`` selects pins or internal gear.

    Raises
    ------
    DesignError
        The housing is too thin, or its sockets do not retain the pins.
    """
    design = reducer.design
    inner_contour = _socket_contour(reducer) if design.ring.kind == "pin" else _internal_gear(reducer)
    outline = CircleContour(design.housing.outer_radius)
    ring_segments = [
        Segment("housing", outline, (TurnedContour(inner_contour, offset_angle),), z_start, z_end)
        for z_start, z_end, offset_angle in ring_spans(reducer)
    ]
    return Part("housing", (*ring_segments, *_sleeve_pins(reducer)), design.material_of("housing").density)


def housing_solid(reducer: Reducer, chord_error: float | None = None) -> Solid:
    """Return `housing_part` as prisms with a chord error [m]; by default that for mass properties."""
    return housing_part(reducer).solid(checked_chord_error(reducer, chord_error))


def ring_spans(reducer: Reducer) -> list[tuple[float, float, float]]:
    """Return the axial position and the rotation of the ring, or of each half of a divided ring.

    Returns
    -------
    list of tuple
        Start and end along the axis [m], and counter-clockwise rotation [rad], 0 for an undivided ring.
    """
    design = reducer.design
    half_width = design.gear.stack_width / 2
    if design.ring.halves == 1:
        return [(-half_width, half_width, 0.0)]
    (first_angle, second_angle), slit = design.ring.ahead, SLIT_SHARE * half_width
    return [(-half_width, -slit, first_angle), (slit, half_width, second_angle)]


def _sleeve_pins(reducer: Reducer) -> list[Segment]:
    """Return the steel pins inside the sleeves of the ring, which are pressed into the housing, as prismatic bodies.

    A `Segment` is an outline that extends between two axial positions. The pins begin with pin 1 on +y and continue
    clockwise. The list is empty for a ring without sleeves.
    """
    design = reducer.design
    if not design.ring.has_sleeves:
        return []
    radius, angles = sleeve_core_radius(reducer), 2 * np.pi * np.arange(design.ring.teeth) / design.ring.teeth
    return [
        Segment("pins", core, (), start, end)
        for start, end, offset_angle in ring_spans(reducer)
        for core in circles_at(radius, design.ring.pin_circle_radius * unit(angles - offset_angle))
    ]


def _socket_contour(reducer: Reducer) -> Contour:
    """Return the contour of the bore of a ring with sockets; raise DesignError if the sockets do not fit."""
    design = reducer.design
    teeth, pin_circle_radius, pin_radius = design.ring.teeth, design.ring.pin_circle_radius, design.ring.pin_radius
    socket_radius = pin_radius + design.socket_play
    require_above("ring.pin_radius", pin_radius, design.gear.eccentricity, "the gear's tips reach beyond the sockets")
    max_wall_radius = pin_circle_radius * math.sin(math.pi / teeth) - design.socket_play
    require_below("ring.pin_radius", pin_radius, max_wall_radius, "neighbouring sockets meet")
    require_above(
        "housing.outer_radius",
        design.housing.outer_radius,
        pin_circle_radius + socket_radius,
        "the sockets cut through it",
    )
    return PinwheelContour(
        pin_circle_radius, socket_radius, arc_half_angle(design, socket_radius), wall_radius(design), teeth
    )


def _internal_gear(reducer: Reducer) -> Contour:
    root_radius, _ = envelope.radii(reducer.tooth_profile)
    require_above(
        "housing.outer_radius", reducer.design.housing.outer_radius, root_radius, "the ring's roots cut through it"
    )
    return InternalGearContour(reducer.shape)


@dataclass(frozen=True)
class PinwheelContour:
    """The wall of a ring with open sockets, socket 1 on +y.

    A socket is an arc of a `radius` [m] about its pin, at the distance `centre` [m] from the axis, of a `half_angle`
    [rad] to both sides; the lands between sockets have the radius `wall` [m].
    """

    centre: float
    radius: float
    half_angle: float
    wall: float
    teeth: int

    def polygon(self, chord_error: float) -> Array:
        """Return the bore of a ring with sockets as a polygon of n points (n, 2) [m] with a chord error [m]."""
        socket = np.array([self.centre, 0.0]) + arc(self.radius, -self.half_angle, self.half_angle, chord_error)
        edge_angle, pitch = math.atan2(socket[-1, 1], socket[-1, 0]), 2 * math.pi / self.teeth
        wall_arc = arc(self.wall, edge_angle, pitch - edge_angle, chord_error)[1:-1]
        pitch_outline = np.concatenate([socket, wall_arc])
        return np.concatenate(
            [rotate_points(pitch_outline, math.pi / 2 + 2 * math.pi * i / self.teeth) for i in range(self.teeth)]
        )

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return sockets and lands in turn, as arcs; `splines` is not used."""
        half_angle, y_axis_angle, pitch = self.half_angle, math.pi / 2.0, 2.0 * math.pi / self.teeth
        edge_angle = math.atan2(self.radius * math.sin(half_angle), self.centre + self.radius * math.cos(half_angle))
        socket = Arc((0.0, self.centre), self.radius, y_axis_angle - half_angle, y_axis_angle + half_angle)
        land = Arc((0.0, 0.0), self.wall, y_axis_angle + edge_angle, y_axis_angle + pitch - edge_angle)
        return tuple(rotate_curve(curve, -i * pitch) for i in range(self.teeth) for curve in (socket, land))


@dataclass(frozen=True)
class InternalGearContour:
    """The outline of the double-enveloping internal gear; the clearance is in the cycloid disc."""

    reducer: Reducer

    def polygon(self, chord_error: float) -> Array:
        """Return the bore as a polygon (n, 2) [m], one root of the teeth after the other."""
        return envelope.sample_ring_by_sagitta(self.reducer.tooth_profile, chord_error).points[::-1]

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return splines for each root and one arc for the lobe after it."""
        return _internal_tooth_outline(self.reducer, splines)


@once
def _internal_tooth_outline(reducer: Reducer, splines: int) -> tuple[Curve, ...]:
    """Return the outline of the internal gear: for each tooth, splines for the root and an arc for the next lobe."""
    gear = reducer.tooth_profile
    pitch, alpha, B0 = 2.0 * math.pi / gear.ring_teeth, envelope.largest_alpha(gear), gear.best_phase
    lobe = Arc((0.0, gear.pin_circle_radius), gear.pin_radius, -math.pi / 2.0 - alpha, -math.pi / 2.0 + alpha)
    flank = SmoothCurve(
        points=lambda B: envelope.Sigma(gear, B).points,
        arc_length=lambda B: envelope.Sigma(gear, B).arc_length,
        tangents=lambda B: unit(envelope.Sigma(gear, B).normal_angle - math.pi / 2.0),
        curvature=lambda B: -1.0 / envelope.Sigma(gear, B).radius,
    )
    # Sigma from B0 to 2 pi - B0 is the full root counter-clockwise of lobe 1.
    root = fit_splines(flank, B0, 2.0 * math.pi - B0, splines)
    next_lobe = rotate_curve(lobe, -pitch)
    return tuple(rotate_curve(curve, -i * pitch) for i in range(gear.ring_teeth) for curve in (*root, next_lobe))
