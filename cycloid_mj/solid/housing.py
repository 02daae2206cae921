"""What the cycloid gear rolls in: the pins and the housing with their sockets, or the internal gear."""

import math

import numpy as np
import numpy.typing as npt

from cycloid_mj import envelope
from cycloid_mj.design import Design
from cycloid_mj.solid.accuracy import drawing_error
from cycloid_mj.solid.fit import require_above, require_below
from cycloid_mj.solid.gear import tooth_profile
from cycloid_mj.solid.polygon import arc, circle
from cycloid_mj.solid.prism import Prism, Solid

Array = npt.NDArray[np.float64]

WALL_GAP = 0.1
"""Least gap between the gear's tips and the wall, as a share of rho - c."""


def pin_solid(design: Design, chord_error: float | None = None) -> Solid:
    """Give one pin of the pinwheel: a cylinder of the face width, its centre at the origin."""
    outline = circle(design.ring.pin_radius, drawing_error(design, chord_error))
    half = design.gear.face_width / 2
    return Solid("pin", (Prism(outline, (), -half, half),), design.material.density)


def housing_solid(design: Design, chord_error: float | None = None) -> Solid:
    """Give the housing in the frame of the reducer axis: the pinwheel without its pins, or the internal gear.

    Parameters
    ----------
    design
        The design; ``ring.kind`` chooses between the two.
    chord_error
        Largest distance of a chord from its curve [m]; right for mass properties when left out.

    Raises
    ------
    DesignError
        The housing is too thin, or its sockets cannot hold the pins.
    """
    chord_error = drawing_error(design, chord_error)
    hole = _pinwheel(design, chord_error) if design.ring.kind == "pin" else _internal_gear(design, chord_error)
    outline = circle(design.housing.outer_radius, chord_error)
    half = design.gear.face_width / 2
    return Solid("housing", (Prism(outline, (hole,), -half, half),), design.material.density)


def _pinwheel(design: Design, chord_error: float) -> Array:
    """Give the wall with N open sockets: one pitch of it, turned N times."""
    teeth, centre, pin = design.ring.teeth, design.ring.pin_circle_radius, design.ring.pin_radius
    play = design.clearance.pin_socket if design.ring.pins == "free" else 0.0  # fixed pins are pressed in
    radius, wall = pin + play, _wall_radius(design)
    require_below("ring.pin_radius", pin, centre * math.sin(math.pi / teeth) - play, "neighbouring sockets meet")
    require_above("housing.outer_radius", design.housing.outer_radius, centre + radius, "the sockets cut through it")
    opening = math.acos((wall**2 - centre**2 - radius**2) / (2 * centre * radius))
    socket = np.array([centre, 0.0]) + arc(radius, -opening, opening, chord_error)
    edge = math.atan2(socket[-1, 1], socket[-1, 0])
    land = arc(wall, edge, 2 * math.pi / teeth - edge, chord_error)[1:-1]
    pitch = np.concatenate([socket, land])
    return np.concatenate([_turned(pitch, math.pi / 2 + 2 * math.pi * i / teeth) for i in range(teeth)])


def _internal_gear(design: Design, chord_error: float) -> Array:
    """Give the double-enveloping internal gear; the clearance is the cycloid gear's."""
    teeth = tooth_profile(design)
    root, _ = envelope.radii(teeth)
    require_above("housing.outer_radius", design.housing.outer_radius, root, "the ring's roots cut through it")
    return envelope.sample_ring_by_sagitta(teeth, chord_error).points[::-1]


def _wall_radius(design: Design) -> float:
    """Radius of the wall between the sockets [m]: half-open sockets, unless the gear's tips reach further.

    The tips reach E - rho + 2c from the reducer axis, and the bottoms of the sockets are at E + rho: rho > c.
    """
    centre, pin, eccentricity = design.ring.pin_circle_radius, design.ring.pin_radius, design.gear.eccentricity
    require_above("ring.pin_radius", pin, eccentricity, "the gear's tips reach beyond the sockets")
    return max(centre, centre - pin + 2 * eccentricity + WALL_GAP * (pin - eccentricity))


def _turned(points: Array, angle: float) -> Array:
    """Turn points (n, 2) counter-clockwise about the origin by an angle [rad]."""
    cos, sin = math.cos(angle), math.sin(angle)
    return points @ np.array([[cos, sin], [-sin, cos]])
