"""Friction of a turning crank's contacts: where it acts, and which way."""

import math

import numpy as np
import numpy.typing as npt

from cycloid_mj import assembly, envelope, kinematics, profile
from cycloid_mj.design import Design
from cycloid_mj.modification import tooth_profile

Array = npt.NDArray[np.float64]


def ring_rubbing(design: Design, lines: envelope.RingContacts, crank: float) -> Array:
    """Give the friction of the contact lines with the ring on gear x, y [1] and turn [m] per normal force, (n, 4).

    The gear turns about the pitch point, where its pitch circle rolls in that of the ring, c N from the axis.
    """
    gear = tooth_profile(design)
    centre = kinematics.gear_centre(gear, crank)
    along = _quarter_turn(lines.normals)
    swept = -_quarter_turn(lines.points - gear.ring_teeth * centre) * math.copysign(1.0, design.drive.speed)
    drag = -_ring_friction(design) * np.sign(np.sum(swept * along, axis=1))[:, np.newaxis] * along
    turn = _moment(lines.points - centre, drag)
    return np.concatenate([drag, turn[:, np.newaxis], np.zeros((len(turn), 1))], axis=1)


def _ring_friction(design: Design) -> float:
    """Friction per normal force between gear and ring: of pins that move, what both of their contacts can hold."""
    friction, ring = design.friction, design.ring
    if ring.has_sockets:
        return min(friction.pin_gear, friction.pin_socket)
    if ring.has_sleeves:
        return min(friction.pin_gear, friction.pin_sleeve * ring.sleeve_bore_radius / ring.pin_radius)
    return design.friction_of(design.tooth_pair)


def output_rubbing(design: Design, holes: assembly.Gaps, crank: float) -> Array:
    """Give the friction of the output pins on gear x, y [1], its turn and the output's [m] per normal force, (n, 4).

    Gear and output turn alike, and each hole circles about its pin.
    """
    gear, output = tooth_profile(design), design.output
    centre, turned = kinematics.gear_centre(gear, crank), -float(kinematics.gear_rotation(gear, crank))
    pins = output.pin_circle_radius * profile.unit(2 * np.pi * np.arange(output.pins) / output.pins + turned)
    points = pins + output.pin_radius * holes.slope[:, :2]
    ahead = _quarter_turn(centre[np.newaxis] / gear.eccentricity) * math.copysign(1.0, design.drive.speed)
    drag = np.broadcast_to(-design.friction_of("output") * ahead, points.shape)
    turns = [_moment(points - centre, drag), _moment(points, -drag)]
    return np.concatenate([drag, np.stack(turns, axis=1)], axis=1)


def _quarter_turn(vectors: Array) -> Array:
    """Turn vectors (n, 2) counter-clockwise by a right angle."""
    return np.stack([-vectors[:, 1], vectors[:, 0]], axis=1)


def _moment(arms: Array, forces: Array) -> Array:
    """Counter-clockwise moments (n,) of forces at the ends of arms, (n, 2) each."""
    return np.asarray(arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0])
