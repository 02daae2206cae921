"""Contacts of each part along a crank turn: forces in the part's frame, where they act, and how sharply."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.contact.pressure import hertz_holds, hertz_pressure, line_curvature, line_share, pair_modulus
from cycloid_mj.design import Design
from cycloid_mj.deviations import deviations
from cycloid_mj.names import FORCE_X, FORCE_Y, LOBE, MOMENT, OUTPUT_PIN, PIN, SOCKET, column, numbered, planar_joints
from cycloid_mj.profile import unit
from cycloid_mj.solid import output_centres
from cycloid_mj.solid.gear import gear_profile, profile_offset, tooth_profile
from cycloid_mj.statics import hertz_line_contact
from cycloid_mj.stress.action import Action, turned
from cycloid_mj.stress.flank import lobe_lines, lobe_place, pin_curvature
from cycloid_mj.stress.turn import Turn
from cycloid_mj.types import Array, Mask

WIDEST = np.pi / 3
"""Largest half width of a patch [rad of the thinner body]; assumed.

A cylinder in a hole with little clearance touches that arc, where Hertz's strip would be wider than the cylinder; and
so does a roller bearing with its loaded half.
"""


@dataclass(frozen=True)
class Line:
    """Hertz's line contact along a turn of k samples: peak `pressure` [Pa] (k,), `half_width` [m] (k,) of its strip.

    `holds` (k,): whether he does; not where the contact is conformal, the numbers are then no more than formal.
    """

    pressure: Array
    half_width: Array
    holds: Mask


@dataclass(frozen=True)
class Contact:
    """One contact of a part along a turn of k samples.

    Attributes
    ----------
    name
        "pin_3", "lobe_3", "socket_3", "cam", "output_pin_2" or "gear".
    action
        The force on the part and its moment about the origin, in the part's frame.
    place
        Where it acts [m], shape (k, 2); nan where there is no force.
    half_width
        Half width of its patch on the part [m], shape (k,): Hertz's, or that of a conformal contact.
    line
        The line contact in it that bears most.
    """

    name: str
    action: Action
    place: Array
    half_width: Array
    line: Line


@dataclass(frozen=True)
class Frame:
    """Frame of a part along a turn: `origin` from the reducer's axis [m] (k, 2) and `angle` [rad] (k,)."""

    origin: Array
    angle: Array

    def sees(self, points: Array) -> Array:
        """Give points of the reducer's frame (k, 2) or (2,) [m] in this one."""
        return turned(points - self.origin, -self.angle)


def frame(turn: Turn, part: str) -> Frame:
    """Give the frame of a part, that of its solid, as it moves."""
    still = np.zeros_like(turn.angle)
    fixed = np.zeros((still.size, 2))
    if part == "gear":
        return Frame(turn.vectors("gear_x", "gear_y"), turn["gear_angle"])
    if part == "shaft":
        return Frame(fixed, turn["crank_angle"])
    if part == "output":
        return Frame(fixed, turn["output_angle"])
    if part == "pin_1":
        return Frame(pin_centre(turn, 0), turn["pin_1_angle"] if turn.design.ring.has_pin_bodies else still)
    return Frame(fixed, still)


def contacts(turn: Turn, part: str) -> list[Contact]:
    """Give every contact of a part: "shaft", "gear", "ring", "output" or "pin_1"."""
    found = {"shaft": _of_shaft, "gear": _of_gear, "ring": _of_ring, "output": _of_output, "pin_1": _of_pin}
    return found[part](turn)


def half_width(design: Design, kind: str, force: Array, curvature: Array | float, radius: float) -> Array:
    """Give Hertz's half width [m] in a kind of pair under a force [N], by its relative curvature [1/m].

    `radius` is that of the thinner body [m].
    """
    length, modulus = design.gear.face_width, pair_modulus(design, kind)
    conformal = 4.0 * force / (np.pi * length * modulus * (WIDEST * radius) ** 2)
    bounded = np.maximum(curvature, np.maximum(conformal, np.finfo(float).tiny))
    return hertz_line_contact(force, length, bounded, modulus).half_width


def line(design: Design, kind: str, force: Array, curvature: Array | float | None = None) -> Line:
    """Give the line contact that bears most of the force [N] (k,) on a pair of a kind.

    `curvature` [1/m] is that of a tooth; other kinds have one of their own. It is the same line, and the same pressure,
    that ``measure loads`` gives: of a rolling cam, that of the most loaded roller.
    """
    bend = line_curvature(design, kind) if curvature is None else curvature
    force = force * line_share(design, kind)
    pressure = hertz_pressure(design, kind, force, bend)
    load = 2.0 * force / (np.pi * design.gear.face_width)
    width = np.divide(load, pressure, out=np.zeros_like(load), where=pressure > 0.0)
    return Line(pressure, width, hertz_holds(design, kind, force, bend))


def pin_centre(turn: Turn, pin: int) -> Array:
    """Centre of a ring pin (0 on +y, clockwise) from the reducer's axis [m], shape (k, 2)."""
    ring = turn.design.ring
    nominal = ring.pin_circle_radius * unit(2 * np.pi * pin / ring.teeth) + deviations(turn.design).pin_place[pin]
    if not ring.has_pin_bodies:
        return np.broadcast_to(nominal, (turn.angle.size, 2))
    return nominal + turn.vectors(*planar_joints(numbered(PIN, pin + 1))[:2])


def _on_gear(turn: Turn, name: str) -> Action:
    """Give the logged force of a pair on the gear, about the reducer's axis."""
    return _logged(turn, name, frame(turn, "gear").origin)


def _logged(turn: Turn, name: str, origin: Array) -> Action:
    force, moment = turn.vectors(column(name, FORCE_X), column(name, FORCE_Y)), turn[column(name, MOMENT)]
    return Action(force, moment).seen_from(-origin, np.zeros_like(moment)).without_rounding()


def _in(seat: Frame, action: Action) -> Action:
    return action.seen_from(seat.origin, seat.angle)


def _of_gear(turn: Turn) -> list[Contact]:
    return [*_teeth(turn, "gear"), _cam_in_bore(turn), *_holes(turn)]


def _of_ring(turn: Turn) -> list[Contact]:
    design = turn.design
    if design.ring.kind == "nonpin":
        return _teeth(turn, "ring")
    return [_socket(turn, pin) for pin in range(design.ring.teeth)]


def _teeth(turn: Turn, part: str) -> list[Contact]:
    """Give the contacts of gear and ring, on either of the two."""
    if turn.design.ring.kind == "pin":
        return [_pin_on_gear(turn, pin) for pin in range(turn.design.ring.teeth)]
    gear, flank, offset = tooth_profile(turn.design), gear_profile(turn.design), profile_offset(turn.design)
    on_gear, seat = frame(turn, "gear"), frame(turn, part)
    lines, curvatures = lobe_lines(gear, turn["crank_angle"])
    ahead = turn["gear_angle"] + turn["crank_angle"] / gear.lobes
    found = []
    for lobe in range(gear.ring_teeth):
        name = numbered(LOBE, lobe + 1)
        action = _on_gear(turn, name)
        place, curvature = lobe_place(flank, _in(on_gear, action), lines[:, lobe], curvatures[:, lobe], ahead, offset)
        if part == "ring":
            place, action = turned(place, on_gear.angle) + on_gear.origin, action.reaction()
        width = half_width(turn.design, "tooth", action.size, curvature, gear.pin_radius)
        found.append(Contact(name, _in(seat, action), place, width, line(turn.design, "tooth", action.size, curvature)))
    return found


def _pin_on_gear(turn: Turn, pin: int) -> Contact:
    gear, seat = gear_profile(turn.design), frame(turn, "gear")
    action = _in(seat, _on_gear(turn, numbered(PIN, pin + 1)))
    place = action.on_hole(seat.sees(pin_centre(turn, pin)), gear.pin_radius + deviations(turn.design).pin_radius[pin])
    curvature = pin_curvature(gear, pin, seat.angle, profile_offset(turn.design))
    width = half_width(turn.design, "pin_gear", action.size, curvature, gear.pin_radius)
    return Contact(numbered(PIN, pin + 1), action, place, width, line(turn.design, "pin_gear", action.size, curvature))


def _cam_in_bore(turn: Turn) -> Contact:
    action = _in(frame(turn, "gear"), _on_gear(turn, "cam"))
    radius = turn.design.gear.bore_radius + turn.design.clearance.cam
    width = _cam_width(turn, action)
    place = action.on_hole(np.zeros(2), radius, width)
    return Contact("cam", action, place, width, line(turn.design, "cam", action.size))


def _holes(turn: Turn) -> list[Contact]:
    """Give the output pins in the gear's holes."""
    output, seat = turn.design.output, frame(turn, "gear")
    radius = output.hole_radius + turn.design.clearance.output
    found = []
    centres = output_centres(turn.design) + deviations(turn.design).hole_place[0]
    for number, centre in enumerate(centres, start=1):
        action = _in(seat, _on_gear(turn, numbered(OUTPUT_PIN, number)))
        width = _hole_width(turn, action)
        place, pressed = action.on_hole(centre, radius, width), line(turn.design, "output", action.size)
        found.append(Contact(numbered(OUTPUT_PIN, number), action, place, width, pressed))
    return found


def _of_output(turn: Turn) -> list[Contact]:
    """Give the output pins' contacts: on the pins themselves, or handed on by the bores of rollers to their cores."""
    output, seat = turn.design.output, frame(turn, "output")
    radius = output.root_radius
    found = []
    for number, centre in enumerate(output_centres(turn.design), start=1):
        action = _in(seat, _on_gear(turn, numbered(OUTPUT_PIN, number)).reaction())
        width = np.full_like(action.size, WIDEST * radius) if output.rollers else _hole_width(turn, action)
        place, pressed = action.on_disc(centre, radius, width), line(turn.design, "output", action.size)
        found.append(Contact(numbered(OUTPUT_PIN, number), action, place, width, pressed))
    return found


def _of_shaft(turn: Turn) -> list[Contact]:
    gear, seat = turn.design.gear, frame(turn, "shaft")
    action = _in(seat, _on_gear(turn, "cam").reaction())
    width = _cam_width(turn, action)
    centre = np.array([0.0, gear.eccentricity + deviations(turn.design).eccentricity])
    place = action.on_disc(centre, gear.bore_radius, width)
    return [Contact("cam", action, place, width, line(turn.design, "cam", action.size))]


def _of_pin(turn: Turn) -> list[Contact]:
    """Give the contacts of pin 1: the gear, and its socket, which carries all of it where the pin is pressed in."""
    gear, seat, centre = gear_profile(turn.design), frame(turn, "pin_1"), np.zeros(2)
    radius = gear.pin_radius
    pushed, held = _in(seat, _on_gear(turn, "pin_1").reaction()), _in(seat, _by_socket(turn, 0))
    curvature = pin_curvature(gear, 0, turn["gear_angle"], profile_offset(turn.design))
    narrow, wide = half_width(turn.design, "pin_gear", pushed.size, curvature, radius), _socket_width(turn, held)
    return [
        Contact(
            *("gear", pushed, pushed.on_disc(centre, radius, narrow), narrow),
            line(turn.design, "pin_gear", pushed.size, curvature),
        ),
        Contact("socket", held, held.on_disc(centre, radius, wide), wide, line(turn.design, "pin_socket", held.size)),
    ]


def _socket(turn: Turn, pin: int) -> Contact:
    """Give the contact of a pin and the wall of its socket, which is open towards the gear.

    In the simulation sockets are whole circles: an idle pin may lie, by its weight, where there is no wall.
    """
    ring = turn.design.ring
    action = _by_socket(turn, pin).reaction()
    centre, radius = ring.pin_circle_radius * unit(2 * np.pi * pin / ring.teeth), ring.pin_radius
    centre = centre + deviations(turn.design).pin_place[pin]
    out = np.linalg.norm(action.on_hole(centre, radius), axis=-1)
    action = action.where(out > ring.pin_circle_radius)
    width = _socket_width(turn, action)
    place = action.on_hole(centre, radius + turn.design.socket_play, width)
    return Contact(numbered(SOCKET, pin + 1), action, place, width, line(turn.design, "pin_socket", action.size))


def _by_socket(turn: Turn, pin: int) -> Action:
    """Give the force of a socket on its pin, about the reducer's axis."""
    if turn.design.ring.has_sockets and turn.design.ring.has_pin_bodies:
        return _logged(turn, numbered(SOCKET, pin + 1), pin_centre(turn, pin))
    return _on_gear(turn, numbered(PIN, pin + 1))


def _cam_width(turn: Turn, action: Action) -> Array:
    radius = turn.design.gear.bore_radius
    return _nested_width(turn, "cam", action, radius, radius + turn.design.clearance.cam)


def _hole_width(turn: Turn, action: Action) -> Array:
    output = turn.design.output
    return _nested_width(turn, "output", action, output.pin_radius, output.hole_radius + turn.design.clearance.output)


def _socket_width(turn: Turn, action: Action) -> Array:
    """Half width of the patch of a pin in its socket [m], (k,); as wide as can be where the pin is pressed in."""
    radius = turn.design.ring.pin_radius
    return _nested_width(turn, "pin_socket", action, radius, radius + turn.design.socket_play)


def _nested_width(turn: Turn, kind: str, action: Action, inner: float, outer: float) -> Array:
    return half_width(turn.design, kind, action.size, 1.0 / inner - 1.0 / outer, inner)


def total(found: Sequence[Contact]) -> Action:
    """Sum the actions of contacts."""
    force = np.sum([contact.action.force for contact in found], axis=0)
    return Action(force, np.sum([contact.action.moment for contact in found], axis=0))
