"""Whether parts with errors and modified flanks go together, and the pose in which they do so best.

At a crank angle every gap of the ideal mesh is linear in small displacements of gear and output and in the departures
of the parts: the pose that leaves the most room is a linear programme. Angles as in ``kinematics``, lengths in metres.
"""

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from cycloid_mj import envelope, kinematics, profile
from cycloid_mj.design import Design
from cycloid_mj.deviations import deviations
from cycloid_mj.modification import profile_offset, tooth_profile

Array = npt.NDArray[np.float64]

_SCALE = 1e-6
"""Unit of length of the programme [m]."""

_CAM_SIDES = 16
"""The cam's clearance, a circle, as the polygon around it."""


@dataclass(frozen=True)
class Fit:
    """The pose at one crank angle that leaves the most room.

    Attributes
    ----------
    room
        Smallest gap of any pair in this pose [m]; negative where the parts only go together pressed into each other.
    shift
        Of the gear's centre from the ideal one [m], shape (2,).
    gear_turn, output_turn
        Angles of gear and output less the ideal ones [rad].
    pin_shift
        Of each pin or sleeve that moves, out of the gear's way [m], shape (N, 2); zero for pins that do not.
    """

    room: float
    shift: Array
    gear_turn: float
    output_turn: float
    pin_shift: Array


@dataclass(frozen=True)
class Gaps:
    """Gaps of n pairs at the ideal pose, linear in small displacements.

    Attributes
    ----------
    gap
        [m], shape (n,).
    slope
        Derivatives by gear x and y [1], turn of the gear and turn of the output [m], shape (n, 4).
    """

    gap: Array
    slope: Array


def best_fit(design: Design, crank: float) -> Fit:
    """Find the pose at a crank angle [rad] that leaves the most room in all pairs."""
    from scipy.optimize import linprog

    ring, rest = ring_gaps(design, mesh_lines(design, crank)), (_cam(design, crank), output_gaps(design, crank))
    lever = design.output.pin_circle_radius
    unit = _SCALE / np.array([1.0, 1.0, lever, lever])
    gap = np.concatenate([ring.gap + design.pin_play, *(part.gap for part in rest)]) / _SCALE
    slope = np.concatenate([ring.slope, *(part.slope for part in rest)]) * unit / _SCALE
    limits = np.concatenate([-slope, np.ones((len(gap), 1))], axis=1)
    found = linprog([0.0, 0.0, 0.0, 0.0, -1.0], A_ub=limits, b_ub=gap, bounds=[(None, None)] * 5)
    *free, room = np.asarray(found.x, float)
    pose = np.array(free) * unit
    return Fit(
        room=float(room * _SCALE),
        shift=pose[:2],
        gear_turn=float(pose[2]),
        output_turn=float(pose[3]),
        pin_shift=_pin_shift(design, ring, pose),
    )


def _pin_shift(design: Design, ring: Gaps, pose: Array) -> Array:
    """Put each pin that the gear would cut half-way between the gear and the far side of its play."""
    if not design.ring.has_moving_pins:
        return np.zeros((design.ring.teeth, 2))
    gap = ring.gap + ring.slope @ pose
    outwards = np.where(gap < 0.0, (design.pin_play - gap) / 2, 0.0)
    return np.asarray(outwards[:, np.newaxis] * -ring.slope[:, :2])


def mesh_lines(design: Design, crank: float) -> envelope.RingContacts:
    """Give the contact lines of the ideal mesh at a crank angle [rad]: pins or arcs, then an internal gear's flanks."""
    gear = tooth_profile(design)
    arcs = envelope.arc_contacts(gear, crank)
    if design.ring.kind != "nonpin":
        return arcs
    flanks = envelope.sigma_contacts(gear, crank)
    both = {one.name: np.concatenate([getattr(part, one.name) for part in (arcs, flanks)]) for one in fields(arcs)}
    return envelope.RingContacts(**both)


def ring_gaps(design: Design, lines: envelope.RingContacts) -> Gaps:
    """Give the gaps of the contact lines of the ideal mesh; the play of pins that move comes on top.

    A larger generating pin circle moves the gear's flank out by its component along the normal, cos(alpha); a turned
    flank opens by its turn times the arm of the normal about the gear's centre.
    """
    gear, change, made = tooth_profile(design), design.modification, deviations(design)
    B, normals = lines.B, -lines.normals
    arm = profile.moment_arm(gear, B)
    gap = np.full(B.size, profile_offset(design) - gear.pin_radius)
    gap += change.rotation * np.abs(arm) - change.pin_circle * np.cos(profile.conjugate_alpha(gear, B))
    if design.ring.kind == "pin":
        gap += np.sum(normals * made.pin_place, axis=1) - made.pin_radius
    zero = np.zeros(B.size)
    return Gaps(gap, np.stack([-normals[:, 0], -normals[:, 1], arm, zero], axis=1))


def _cam(design: Design, crank: float) -> Gaps:
    """Gaps of the bore to the cam, towards each side of the polygon."""
    sides = profile.unit(2 * np.pi * np.arange(_CAM_SIDES) / _CAM_SIDES)
    away = kinematics.gear_centre(tooth_profile(design), crank) / design.gear.eccentricity
    gap = design.clearance.cam + sides @ away * design.errors.eccentricity
    return Gaps(gap, np.concatenate([-sides, np.zeros((_CAM_SIDES, 2))], axis=1))


def output_gaps(design: Design, crank: float) -> Gaps:
    """Give the gaps of the output pins, which lie in their holes on the side towards the reducer's axis."""
    gear, output, made = tooth_profile(design), design.output, deviations(design)
    inwards = -kinematics.gear_centre(gear, crank) / gear.eccentricity
    turned = -float(kinematics.gear_rotation(gear, crank))
    place = output.pin_circle_radius * profile.unit(2 * np.pi * np.arange(output.pins) / output.pins + turned)
    cos, sin = np.cos(turned), np.sin(turned)
    beside = made.hole_place @ np.array([[cos, -sin], [sin, cos]])
    room = output.hole_radius + design.clearance.output - output.pin_radius - gear.eccentricity
    lever = inwards[1] * place[:, 0] - inwards[0] * place[:, 1]
    slope = np.stack([np.full(output.pins, inwards[0]), np.full(output.pins, inwards[1]), lever, -lever], axis=1)
    return Gaps(room + beside @ inwards, slope)
