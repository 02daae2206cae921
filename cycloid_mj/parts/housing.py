"""What the cycloid gear rolls in: the pins and the housing with their sockets, or the internal gear."""

import math

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.geometry import envelope
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts.accuracy import drawing_error
from cycloid_mj.parts.fit import require_above, require_below
from cycloid_mj.parts.polygon import arc, circle, turned
from cycloid_mj.parts.prism import Prism, Solid
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import arc_half_angle, wall_radius

SLIT = 1e-3
"""Share of the ring's width that both its halves leave between them, so that they turn."""


def pin_solid(reducer: Reducer, chord_error: float | None = None) -> Solid:
    """Build one pin of the pinwheel, its centre at the origin: a cylinder through all discs, or the sleeve on it.

    That of a ring in two halves is as long as one of them.

    Raises
    ------
    DesignError
        A sleeve is thicker than its radius: it has no bore.
    """
    design = reducer.design
    chord_error = drawing_error(reducer, chord_error)
    bores = [sleeve_core_radius(reducer) + design.clearance.pin_sleeve] if design.ring.has_sleeves else []
    outline, *holes = (circle(radius, chord_error) for radius in (design.ring.pin_radius, *bores))
    half = design.gear.stack_width / 2 / design.ring.halves
    return Solid("pin", (Prism(outline, tuple(holes), -half, half),), design.material_of("pin").density)


def sleeve_core_radius(reducer: Reducer) -> float:
    """Compute the radius of the pressed-in pin inside a sleeve [m]: the bore's less the clearance.

    Raises
    ------
    DesignError
        The sleeve leaves no room for it.
    """
    design = reducer.design
    thickness, room = design.ring.sleeve_thickness, design.ring.pin_radius - design.clearance.pin_sleeve
    require_below("ring.sleeve_thickness", thickness, room, "the sleeve leaves no room for its pin")
    return room - thickness


def housing_solid(reducer: Reducer, chord_error: float | None = None) -> Solid:
    """Build the housing in the frame of the reducer axis: the pinwheel without its pins, or the internal gear.

    Of two halves it has a prism each, the one next to the motor first, turned as they are. The pinwheel of sleeved pins
    comes with the pressed-in ones, which both end plates hold (not drawn).

    Parameters
    ----------
    reducer
        The reducer; ``ring.kind`` chooses between the two.
    chord_error
        Largest distance of a chord from its curve [m]; right for mass properties when left out.

    Raises
    ------
    DesignError
        The housing is too thin, or its sockets cannot hold the pins.
    """
    design = reducer.design
    chord_error = drawing_error(reducer, chord_error)
    hole = _pinwheel(reducer, chord_error) if design.ring.kind == "pin" else _internal_gear(reducer, chord_error)
    outline = circle(design.housing.outer_radius, chord_error)
    rings = [Prism(outline, (turned(hole, ahead),), low, high) for low, high, ahead in ring_stretches(reducer)]
    return Solid("housing", (*rings, *_cores(reducer, chord_error)), design.material_of("housing").density)


def ring_stretches(reducer: Reducer) -> list[tuple[float, float, float]]:
    """List where the ring, or each of its halves, begins and ends along the axis [m], and its turn [rad]."""
    design = reducer.design
    half = design.gear.stack_width / 2
    if design.ring.halves == 1:
        return [(-half, half, 0.0)]
    (one, other), slit = design.ring.ahead, SLIT * half
    return [(-half, -slit, one), (slit, half, other)]


def _cores(reducer: Reducer, chord_error: float) -> list[Prism]:
    """List the pressed-in pins inside the sleeves, pin 1 on +y, clockwise; none elsewhere."""
    design = reducer.design
    if not design.ring.has_sleeves:
        return []
    core = circle(sleeve_core_radius(reducer), chord_error)
    angles = 2 * np.pi * np.arange(design.ring.teeth) / design.ring.teeth
    return [
        Prism(core + centre, (), low, high)
        for low, high, ahead in ring_stretches(reducer)
        for centre in design.ring.pin_circle_radius * unit(angles - ahead)
    ]


def _pinwheel(reducer: Reducer, chord_error: float) -> Array:
    """Compute the wall with N open sockets: one pitch of it, turned N times."""
    design = reducer.design
    teeth, centre, pin = design.ring.teeth, design.ring.pin_circle_radius, design.ring.pin_radius
    play = design.socket_play
    radius, wall = pin + play, wall_radius(design)
    require_above("ring.pin_radius", pin, design.gear.eccentricity, "the gear's tips reach beyond the sockets")
    require_below("ring.pin_radius", pin, centre * math.sin(math.pi / teeth) - play, "neighbouring sockets meet")
    require_above("housing.outer_radius", design.housing.outer_radius, centre + radius, "the sockets cut through it")
    half = arc_half_angle(design, radius)
    socket = np.array([centre, 0.0]) + arc(radius, -half, half, chord_error)
    edge = math.atan2(socket[-1, 1], socket[-1, 0])
    land = arc(wall, edge, 2 * math.pi / teeth - edge, chord_error)[1:-1]
    pitch = np.concatenate([socket, land])
    return np.concatenate([turned(pitch, math.pi / 2 + 2 * math.pi * i / teeth) for i in range(teeth)])


def _internal_gear(reducer: Reducer, chord_error: float) -> Array:
    """Compute the double-enveloping internal gear; the clearance is the cycloid gear's."""
    teeth = reducer.tooth_profile
    root, _ = envelope.radii(teeth)
    require_above("housing.outer_radius", reducer.design.housing.outer_radius, root, "the ring's roots cut through it")
    return envelope.sample_ring_by_sagitta(teeth, chord_error).points[::-1]
