"""Transmission error in closed form and in statics: the ideal mesh, its small gaps, and springs that only push.

All contacts of the ideal pose are kept, with their normals, arms and curvatures; clearances, manufacturing errors and
modifications are gaps there, and each curve is its circle of curvature. In a valley that is 18 um, so what holds for
errors of some micrometres is an estimate beyond. Nothing is from the collider, and friction and inertia but the gear's
centrifugal force are left out. The unknowns z [m] are the gear's x, y from the cam's centre, and the turns of gear
and output from the ideal ones, both times the radius R of the output pins.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj import envelope, profile
from cycloid_mj.contact.law import curvature_law, pair_stiffness
from cycloid_mj.design import Design
from cycloid_mj.deviations import deviations
from cycloid_mj.errors import RunError
from cycloid_mj.kinematics import gear_centre
from cycloid_mj.solid import gear_solid, mass_properties
from cycloid_mj.solid.gear import profile_offset, tooth_profile

Array = npt.NDArray[np.float64]

_ROUNDS = 200
_BALANCED = 1e-4
"""Largest residual of a balance, as a share of the largest force in it."""
_FLOATING = 1e-9
"""Stiffness that keeps a floating gear where it is, as a share of the cam's."""
_NEAR = 0.5
"""Longest step on the way to a balance, as a share of the least radius that a contact's curve has: past its middle the
circle would push the other way."""


@dataclass(frozen=True)
class Contacts:
    """Contacts of gear with ring or output at one crank angle; n of them.

    Attributes
    ----------
    gap
        At z = 0 [m], shape (n,).
    slope
        Derivative of the gaps by z [1], shape (n, 4).
    stiffness
        [N/m], shape (n,); of a pin that moves, in series with what carries it.
    shift, shift_slope
        How far the pin lies off the ideal normal along the surface at z = 0 [m], shape (n,), and its derivative by z.
    bend
        Curvature of the curve that the pin's centre keeps its distance from [1/m], shape (n,), convex positive.
    """

    gap: Array
    slope: Array
    stiffness: Array
    shift: Array
    shift_slope: Array
    bend: Array

    def at(self, z: Array) -> tuple[Array, Array]:
        """Give the gaps [m], shape (n,), and their derivative by z, shape (n, 4): distances from a circle."""
        shift = self.shift + self.shift_slope @ z
        along, across = 1.0 + self.bend * (self.gap + self.slope @ z), self.bend * shift
        reach = np.hypot(along, across)
        slope = (along / reach)[:, np.newaxis] * self.slope + (across / reach)[:, np.newaxis] * self.shift_slope
        return (reach - 1.0) / self.bend, slope


def ring_contacts(design: Design, crank: float) -> Contacts:
    """Give the contacts of gear and ring at a crank angle [rad], counter-clockwise.

    A pin displaced by d opens its gap by d . n, n the gear's outward normal; a radius larger by r closes it by r. A cam
    more eccentric by e carries the gear by e along the eccentric. A pin circle of the gear larger by x moves its
    profile by x u(t) . n; flanks turned by a retreat by a times their arm. An internal gear touches on its arcs; its
    flanks Sigma close only beside an arc, as one patch with it, and are left out (below 0.1 % of the gear's turn).
    """
    gear, made, change = tooth_profile(design), deviations(design), design.modification
    arcs = envelope.arc_contacts(gear, crank)
    if design.ring.kind == "nonpin":
        arcs = _at(arcs, np.abs(profile.conjugate_alpha(gear, arcs.B)) <= envelope.largest_alpha(gear))
    lobe, push = arcs.lobe, arcs.normals
    arm, play = profile.moment_arm(gear, arcs.B), profile_offset(design) - gear.pin_radius + design.pin_play
    outward = profile.unit(arcs.t)
    moved = made.pin_place[lobe] - made.eccentricity * gear_centre(gear, crank) / gear.eccentricity
    gap = play - np.sum(moved * push, axis=1) - made.pin_radius[lobe]
    gap += change.rotation * np.abs(arm) - change.pin_circle * np.sum(outward * profile.normals(gear, arcs.t), axis=1)
    slope = np.column_stack([push, arm / design.output.pin_circle_radius, np.zeros(arm.size)])
    law = curvature_law(design)
    stiffness = law.stiffness * np.array([law.factor(float(kappa)) for kappa in arcs.relative_curvature])
    for kind, moves in (("pin_socket", design.ring.has_sockets), ("pin_sleeve", design.ring.has_sleeves)):
        if moves:
            stiffness = 1.0 / (1.0 / stiffness + 1.0 / pair_stiffness(design, kind))
    # Across the normal the arm is that of the pin's centre about the gear's, along it.
    side, centre = _quarter_turned(push), gear_centre(gear, crank)
    places = gear.pin_circle_radius * profile.unit(profile.pin_angles(gear))[lobe] - centre
    turning = np.sum(side * _quarter_turned(places), axis=1) / design.output.pin_circle_radius
    shift_slope = np.column_stack([-side, -turning, np.zeros(arm.size)])
    bend = profile.curvature(gear, arcs.t, 0.0)
    return Contacts(gap, slope, stiffness, np.sum(moved * side, axis=1), shift_slope, bend)


def output_contacts(design: Design, crank: float) -> Contacts:
    """Give the contacts of the gear's holes and the output pins: every pin pushes inwards along the eccentric.

    A hole displaced by d in the gear opens its gap by d along that push; a cam more eccentric by e closes all by e.
    """
    gear, made, output = tooth_profile(design), deviations(design), design.output
    push = -gear_centre(gear, crank) / gear.eccentricity
    at_rest = 2.0 * np.pi * np.arange(output.pins) / output.pins
    place = profile.unit(at_rest + crank / gear.lobes)
    arm = place[:, 0] * push[1] - place[:, 1] * push[0]
    gap = design.clearance.output - made.eccentricity + _turned(made.hole_place, -crank / gear.lobes) @ push
    # Holes and pins turn together: the same arm, about the gear's centre and about the output's.
    slope = np.column_stack([np.tile(push, (output.pins, 1)), arm, -arm])
    side = _quarter_turned(push[np.newaxis])[0]
    lever = place @ push
    off = -_turned(made.hole_place, -crank / gear.lobes) @ side
    shift_slope = np.column_stack([np.tile(-side, (output.pins, 1)), -lever, lever])
    bend = np.full(output.pins, -1.0 / (output.hole_radius - output.pin_radius))
    stiffness = np.full(output.pins, pair_stiffness(design, "output"))
    return Contacts(gap, slope, stiffness, off, shift_slope, bend)


def kinematic_error(design: Design, crank: npt.ArrayLike, direction: float) -> Array:
    """Turn of the gear from the ideal one [rad], shape of `crank`, where a torque's `direction` (+-1) presses it.

    Rigid parts, and a gear centred on the cam (no cam clearance): the first contact to close stops the gear, at its
    gap over its arm. So where one pin stands in the way alone, the error is its normal displacement over its arm.
    """
    found = []
    for angle in np.ravel(crank):
        ring = ring_contacts(design, float(angle))
        closing = -direction * design.output.pin_circle_radius * ring.slope[:, 2]
        facing = closing > 0.0
        found.append(direction * np.min(ring.gap[facing] / closing[facing]))
    return np.reshape(found, np.shape(crank))


def static_error(design: Design, crank: npt.ArrayLike, torque: float, speed: float = 0.0) -> Array:
    """Transmission errors of gear and output in balance [rad], shape (k, 2), at k crank angles [rad].

    Parameters
    ----------
    design
        The design; friction is left out.
    crank
        Crank angles [rad].
    torque
        On the output [N m], counter-clockwise: against a crank that turns counter-clockwise.
    speed
        Of the crank [rad/s]: the gear's centrifugal force.

    Raises
    ------
    RunError
        No balance was found.
    """
    mass = mass_properties(gear_solid(design)).mass
    weight = mass * np.array([design.environment.gravity_x, design.environment.gravity_y])
    found, start = [], np.zeros(4)
    for angle in np.ravel(crank):
        centrifugal = mass * speed**2 * gear_centre(tooth_profile(design), float(angle))
        load = np.array([*(weight + centrifugal), 0.0, torque / design.output.pin_circle_radius])
        parts = (ring_contacts(design, float(angle)), output_contacts(design, float(angle)))
        start = _balance(design, _joined(*parts), load, start)
        found.append(start[2:] / design.output.pin_circle_radius)
    return np.array(found)


def _balance(design: Design, contacts: Contacts, load: Array, start: Array) -> Array:
    """Give z of least energy by Newton's method, each step shortened until the energy falls."""
    stiffness = np.diag(np.full(4, _FLOATING * pair_stiffness(design, "cam")))
    z, energy = start, np.inf
    for _ in range(_ROUNDS):
        energy, force, matrix = _springs(design, contacts, load, z)
        if np.abs(force).max() <= _BALANCED * max(float(np.abs(load).max()), 1.0):
            return z
        step = np.linalg.solve(matrix + stiffness, force)
        share = min(1.0, _NEAR / float(np.abs(contacts.bend).max() * np.abs(step).max()))
        while _springs(design, contacts, load, z + share * step)[0] > energy and share > 1e-6:
            share *= 0.5
        z = z + share * step
    raise RunError(f"no static balance of the mesh: {np.abs(force).max():.3g} N are left over")


def _springs(design: Design, contacts: Contacts, load: Array, z: Array) -> tuple[float, Array, Array]:
    """Energy [J] of springs and load, the force on z [N], shape (4,), and the springs' stiffness [N/m], (4, 4)."""
    gap, slope = contacts.at(z)
    closed = gap < 0.0
    slope, stiffness = slope[closed], contacts.stiffness[closed]
    energy = 0.5 * np.sum(stiffness * gap[closed] ** 2) - load @ z
    force = load - slope.T @ (stiffness * gap[closed])
    matrix = slope.T @ (stiffness[:, np.newaxis] * slope)
    cam, reach = pair_stiffness(design, "cam"), float(np.hypot(*z[:2]))
    deep = reach - design.clearance.cam
    if deep > 0.0:
        out = z[:2] / reach
        along = np.outer(out, out)
        energy += 0.5 * cam * deep**2
        force[:2] -= cam * deep * out
        matrix[:2, :2] += cam * (along + deep / reach * (np.eye(2) - along))
    return float(energy), force, matrix


def _joined(*parts: Contacts) -> Contacts:
    return Contacts(**{name: np.concatenate([vars(part)[name] for part in parts]) for name in vars(parts[0])})


def _at(contacts: envelope.RingContacts, rows: npt.NDArray[np.bool_]) -> envelope.RingContacts:
    return envelope.RingContacts(**{name: values[rows] for name, values in vars(contacts).items()})


def _quarter_turned(vectors: Array) -> Array:
    """Turn vectors (n, 2) counter-clockwise by a right angle."""
    return np.stack([-vectors[:, 1], vectors[:, 0]], axis=1)


def _turned(vectors: Array, angle: float) -> Array:
    """Turn vectors (n, 2) counter-clockwise by an angle [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    return vectors @ np.array([[cos, sin], [-sin, cos]])
