"""Contacts of each part along a crank turn: forces in the part's frame, positions, and widths of their patches.

A force acts where its line of action, from force and moment, intersects the surface on which it presses.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.special import j1

from cycloid_mj.base import names
from cycloid_mj.base.array import Array, Mask, cross
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.ideal_loads import contact_modulus, hertz_line_contact
from cycloid_mj.geometry.profile import CycloidGear, unit
from cycloid_mj.parts import output_centres
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.reducer.contact import CONTACT, STRIBECK
from cycloid_mj.reducer.sockets import wall_radius
from cycloid_mj.stress.flank import lobe_contact_point, lobe_lines
from cycloid_mj.stress.turn import Turn

MAX_HALF_ANGLE = np.pi / 3
"""Largest half width of a patch [rad of the thinner body]; assumed.

A cylinder in a hole with little clearance touches that arc, where Hertz's strip would be wider than the cylinder. The
same applies to the loaded half of a roller bearing.
"""


@dataclass(frozen=True)
class Action:
    """A force along a turn: `force` [N] (k, 2), and its `moment` [N m] (k,) about the origin of its frame."""

    force: Array
    moment: Array

    @property
    def size(self) -> Array:
        """Magnitude of the force [N], shape (k,)."""
        return np.linalg.norm(self.force, axis=-1)

    @property
    def direction(self) -> Array:
        """Unit vectors along the force, nan where there is none, shape (k, 2)."""
        size = self.size[..., np.newaxis]
        return np.divide(self.force, size, out=np.full_like(self.force, np.nan), where=size > 0.0)

    @property
    def nearest_point(self) -> Array:
        """Point of the line of action nearest to the origin [m], nan where there is no force, shape (k, 2)."""
        squared = self.size**2
        arm = np.divide(self.moment, squared, out=np.full_like(squared, np.nan), where=squared > 0.0)
        return arm[..., np.newaxis] * turned_right(self.force)

    def reaction(self) -> "Action":
        """Compute the reaction: the same action on the other body."""
        return Action(-self.force, -self.moment)

    def in_frame(self, origin: Array, angle: Array) -> "Action":
        """Transform the action to a frame at `origin` [m] (k, 2) that is rotated by `angle` [rad] (k,)."""
        return Action(rotate_vectors(self.force, -angle), self.moment - cross(origin, self.force))

    def without_rounding(self) -> "Action":
        """Compute the action with negligible forces set to zero."""
        return self.select(self.size > 1e-9 * np.max(self.size, initial=0.0))

    def select(self, chosen: Mask) -> "Action":
        """Compute the action at the chosen samples (k,), and no force at the others."""
        return Action(np.where(chosen[..., np.newaxis], self.force, 0.0), np.where(chosen, self.moment, 0.0))

    def on_hole(self, centre: Array, radius: float, half_width: Array | float = 0.0) -> Array:
        """Compute where the force presses on the wall of a hole [m], (k, 2): ahead of the hole's centre."""
        return self._on_circle(centre, radius, half_width, 1.0)

    def on_disc(self, centre: Array, radius: float, half_width: Array | float = 0.0) -> Array:
        """Compute where the force presses on a disc [m], (k, 2): behind the disc's centre."""
        return self._on_circle(centre, radius, half_width, -1.0)

    def _on_circle(self, centre: Array, radius: float, half_width: Array | float, side: float) -> Array:
        """Compute the middle of the force's contact patch on a circle [m] at k angles, (k, 2); NaN without a force.

        A narrow patch is where the line of action intersects the circle. On a wide patch, tractions have different
        directions. For the same resultant force, they and their moment of friction are then larger than on a narrow
        patch. The line of action is therefore intersected with a larger circle (the friction circle of a journal
        bearing), and the intersection is projected onto the circle. A line of action outside the circle counts as a
        tangent.

        Parameters
        ----------
        centre, radius
            Centre [m], shape (k, 2) or (2,), and radius [m] of the circle, in the frame of this force.
        half_width
            Half width of the patch along the circle [m].
        side
            1 for the intersection ahead of the centre in the direction of the force, -1 for that behind the centre.
        """
        direction = self.direction
        point_offset = self.nearest_point - centre
        perpendicular = point_offset - dot(point_offset, direction)[..., np.newaxis] * direction
        friction_radius = radius / mean_cosine(np.asarray(half_width) / radius)
        depth = np.sqrt(np.maximum(friction_radius**2 - dot(perpendicular, perpendicular), 0.0))
        intersection = perpendicular + side * depth[..., np.newaxis] * direction
        return centre + intersection * (radius / friction_radius)[..., np.newaxis]


@dataclass(frozen=True)
class HertzStrip:
    """Hertz's line contact along a turn of k samples: peak `pressure` [Pa] (k,) and `half_width` [m] (k,) of its strip.

    `valid` (k,) states whether Hertz's theory applies. It does not where the contact is conformal; the values are then
    formal.
    """

    pressure: Array
    half_width: Array
    valid: Mask


@dataclass(frozen=True)
class PartContact:
    """Contact of a part along a turn of k samples.

    Attributes
    ----------
    name
        "pin_3", "lobe_3", "socket_3", "cam", "output_pin_2" or "gear".
    action
        The force on the part and its moment about the origin, in the part's frame.
    position
        Position of the force [m], shape (k, 2); NaN where there is no force.
    half_width
        Half width of its patch on the part [m], shape (k,): Hertz's, or that of a conformal contact.
    line
        The line contact in it with the largest load.
    """

    name: str
    action: Action
    position: Array
    half_width: Array
    line: HertzStrip


@dataclass(frozen=True)
class PartFrame:
    """Frame of a part along a turn: `origin` from the reducer's axis [m] (k, 2) and `angle` [rad] (k,)."""

    origin: Array
    angle: Array

    def transform_points(self, points: Array) -> Array:
        """Transform points (k, 2) or (2,) [m] from the frame of the reducer to this frame."""
        return rotate_vectors(points - self.origin, -self.angle)


def part_frame(turn: Turn, part: str) -> PartFrame:
    """Return the moving frame of a part along a turn, relative to the ring: origin [m] (k, 2) and angle [rad] (k,).

    `turn` has k crank angles. `part` is "shaft", the name of a disc ("gear", "gear_1", ...), "ring", "output" or
    "pin_1". The frame of the ring does not move.
    """
    zeros = np.zeros_like(turn.angle)
    origin = np.zeros((zeros.size, 2))
    if part in turn.reducer.gears:
        x, y, angle = names.planar_joints(part)
        return PartFrame(turn.vectors(x, y), turn[angle])
    if part == "shaft":
        return PartFrame(origin, turn["crank_angle"])
    if part == "output":
        return PartFrame(origin, turn["output_angle"])
    if part == "pin_1":
        return PartFrame(pin_centre(turn, 0), turn["pin_1_angle"] if turn.reducer.design.ring.has_pin_bodies else zeros)
    return PartFrame(origin, zeros)


def list_contacts(turn: Turn, part: str) -> list[PartContact]:
    """List force, position and patch width of every contact of a part over a turn, in the frame of the part.

    `part` is "shaft", the name of a disc ("gear", or with several discs "gear_1", "gear_2", ...), "ring", "output" or
    "pin_1".
    """
    if part in turn.reducer.gears:
        return _gear_contacts(turn, turn.reducer.gears.index(part))
    return {"shaft": _shaft_contacts, "ring": _ring_contacts, "output": _output_contacts, "pin_1": _pin_contacts}[part](
        turn
    )


def half_width(reducer: Reducer, kind: str, force: Array, curvature: Array | float, radius: float) -> Array:
    """Compute the half width [m] of the contact strips of k line contacts by Hertz, shape (k,).

    It is at most the arc that `MAX_HALF_ANGLE` spans on the thinner body.

    Parameters
    ----------
    reducer
        The reducer, for face width and materials.
    kind
        Kind of mating pair, such as "cam".
    force
        Normal force [N], shape (k,).
    curvature
        Relative curvature [1/m], shape (k,) or constant.
    radius
        Radius of the thinner body [m].
    """
    length, modulus = reducer.design.gear.face_width, reducer.contacts[kind].modulus
    min_curvature = 4.0 * force / (np.pi * length * modulus * (MAX_HALF_ANGLE * radius) ** 2)
    bounded_curvature = np.maximum(curvature, np.maximum(min_curvature, np.finfo(float).tiny))
    return hertz_line_contact(force, length, bounded_curvature, modulus).half_width


def line_contact(reducer: Reducer, kind: str, force: Array, curvature: Array | float | None = None) -> HertzStrip:
    """Compute Hertz's peak pressure [Pa] and half width [m] of line contacts of a kind of mating pair.

    Parameters
    ----------
    reducer
        The reducer, for face width and material constants.
    kind
        Kind of mating pair: "pin_gear", "tooth", "cam", "output" or "pin_socket".
    force
        Normal forces of k contacts [N], shape (k,). In a cam with a rolling bearing, the most loaded roller carries a
        share of them.
    curvature
        Relative curvature of a tooth contact [1/m], shape (k,); None for other kinds, which have a constant curvature.
    """
    contact = reducer.contacts[kind]
    relative_curvature = contact.relative_curvature if curvature is None else curvature
    force = force * contact.line_share
    pressure = contact.pressure(force, relative_curvature)
    load = 2.0 * force / (np.pi * reducer.design.gear.face_width)
    width = np.divide(load, pressure, out=np.zeros_like(load), where=pressure > 0.0)
    return HertzStrip(pressure, width, contact.hertz_holds(force, relative_curvature))


def pin_centre(turn: Turn, pin: int) -> Array:
    """Compute the centre of a ring pin (index from 0 on +y, clockwise) from the reducer's axis [m], shape (k, 2)."""
    ring = turn.reducer.design.ring
    nominal = nominal_pin_centre(turn.reducer, pin)
    if not ring.has_pin_bodies:
        return np.broadcast_to(nominal, (turn.angle.size, 2))
    return nominal + turn.vectors(*names.planar_joints(names.numbered_name(names.PIN, pin + 1))[:2])


def nominal_pin_centre(reducer: Reducer, pin: int) -> Array:
    """Compute the centre of a ring pin in the middle of its socket [m], shape (2,).

    `pin` is the index of the pin from 0 on +y, clockwise.
    """
    ring = reducer.design.ring
    return ring.pin_circle_radius * unit(2 * np.pi * pin / ring.teeth) + reducer.deviations.pin_displacement[pin]


def _pin_curvature(gear: CycloidGear, pin: int, gear_angle: Array, offset: float) -> Array:
    """Compute the relative curvature [1/m] of a ring pin and the flank of the disc at k angles, shape (k,).

    `pin` is its index: 0 is on +y, and indices increase clockwise. `gear_angle` [rad] (k,) is the counter-clockwise
    rotation of the disc's teeth against the ring. `offset` [m] is the distance of the flank from its trochoid.
    """
    t = profile.pin_angles(gear)[pin] + gear_angle
    return profile.curvature(gear, t, offset) + 1.0 / gear.pin_radius


def _on_gear(turn: Turn, name: str, disc: int) -> Action:
    """Return the logged force of the pair `name` on a disc, with its moment about the reducer's axis."""
    return _read_action(turn, _pair_name(turn, name, disc), _disc(turn, disc).origin)


def _pair_name(turn: Turn, name: str, disc: int) -> str:
    """Return the name of a pair of a disc."""
    return names.of_disc(name, disc, turn.reducer.design.gear.discs)


def _discs(turn: Turn) -> range:
    return range(turn.reducer.design.gear.discs)


def _disc(turn: Turn, disc: int) -> PartFrame:
    """Return the frame of a disc."""
    return part_frame(turn, turn.reducer.gears[disc])


def _tooth_frame(turn: Turn, disc: int) -> PartFrame:
    """Return the frame of a disc's teeth: on a disc ahead on the crank they are turned back."""
    disc_frame = _disc(turn, disc)
    return PartFrame(disc_frame.origin, disc_frame.angle - turn.reducer.phases[disc] / turn.reducer.design.lobes)


def _read_action(turn: Turn, name: str, origin: Array) -> Action:
    force, moment = (
        turn.vectors(names.column(name, names.FORCE_X), names.column(name, names.FORCE_Y)),
        turn[names.column(name, names.MOMENT)],
    )
    return Action(force, moment).in_frame(-origin, np.zeros_like(moment)).without_rounding()


def _in(frame: PartFrame, action: Action) -> Action:
    return action.in_frame(frame.origin, frame.angle)


def _gear_contacts(turn: Turn, disc: int) -> list[PartContact]:
    """List force, position and patch width of each contact of a disc with ring, cam and output pins over a turn.

    `disc` is its index from 0. A disc of an RV reducer has contacts with the ring and the cranks instead.
    """
    if isinstance(turn.reducer, RvReducer):
        return [*_tooth_contacts(turn, turn.reducer.gears[disc], disc), *_crank_contacts(turn, turn.reducer, disc)]
    disc_frame = _disc(turn, disc)
    cam_contact = _hole_contact(
        turn, _pair_name(turn, names.CAM, disc), "cam", _in(disc_frame, _on_gear(turn, names.CAM, disc)), np.zeros(2)
    )
    centres = output_centres(turn.reducer) + turn.reducer.deviations.hole_displacement[disc]
    pin_names = [names.numbered_name(names.OUTPUT_PIN, pin_number) for pin_number in range(1, len(centres) + 1)]
    hole_contacts = [
        _hole_contact(turn, _pair_name(turn, name, disc), "output", _in(disc_frame, _on_gear(turn, name, disc)), centre)
        for name, centre in zip(pin_names, centres, strict=True)
    ]
    return [*_tooth_contacts(turn, turn.reducer.gears[disc], disc), cam_contact, *hole_contacts]


def _crank_contacts(turn: Turn, reducer: RvReducer, disc: int) -> list[PartContact]:
    """List force, position and patch width of the contacts of cranks and a disc's bores over a `turn`, in its frame.

    `disc` is its index from 0. Position and width of a contact describe the load on the bore; its Hertz pressure is
    computed for the most loaded needle.
    """
    frame, contacts = _disc(turn, disc), []
    bores = reducer.stage.crank_positions([0.0])[0]
    for crank_number, centre in enumerate(bores, start=1):
        name = _pair_name(turn, names.numbered_name(names.CRANK, crank_number), disc)
        action = _in(frame, _on_gear(turn, names.numbered_name(names.CRANK, crank_number), disc))
        width = np.full_like(action.size, MAX_HALF_ANGLE * reducer.bore_radius)
        position = action.on_hole(centre, reducer.bore_radius, width)
        strip = needle_contact(reducer, action.size, -1.0 / reducer.bore_radius)
        contacts.append(PartContact(name, action, position, width, strip))
    return contacts


def needle_contact(reducer: RvReducer, force: Array, raceway_curvature: float) -> HertzStrip:
    """Compute Hertz's pressure [Pa] and half width [m] of the most loaded needle between an eccentric and a disc.

    `force` [N] is the force of the crank on the disc; the results have its shape. `raceway_curvature` [1/m] is the
    curvature of the eccentric, or the negative curvature of the bore. The result also states whether Hertz's theory is
    valid.
    """
    cranks, material = reducer.cranks, reducer.design.material_of(names.GEAR)
    needle_force = force * STRIBECK / cranks.needles
    modulus = contact_modulus(material.youngs_modulus, material.poisson)
    curvature = 1.0 / cranks.needle_radius + raceway_curvature
    strip = hertz_line_contact(needle_force, reducer.design.gear.face_width, curvature, modulus)
    return HertzStrip(
        strip.peak_pressure, strip.half_width, strip.half_width < CONTACT.hertz_reach * cranks.needle_radius
    )


def _ring_contacts(turn: Turn) -> list[PartContact]:
    """List force, position and patch width of the contacts of the ring over a turn.

    Its lobes have contacts with the discs, or its sockets with ring pins.
    """
    design = turn.reducer.design
    if design.ring.kind == "nonpin":
        return [contact for disc in _discs(turn) for contact in _tooth_contacts(turn, "ring", disc)]
    # a free pin presses on its socket as a whole, wherever discs press on it
    discs = range(1) if _has_free_pins(turn) else _discs(turn)
    return [_socket_contact(turn, pin, disc) for disc in discs for pin in range(design.ring.teeth)]


def _output_contacts(turn: Turn) -> list[PartContact]:
    """List force, position and patch width of the contacts of output pins with discs or rollers over a `turn`.

    Each combination of pin and disc is one contact.
    """
    output, frame = turn.reducer.design.output, part_frame(turn, "output")
    contacts = []
    for disc, (pin_number, centre) in product(_discs(turn), enumerate(output_centres(turn.reducer), start=1)):
        name = names.numbered_name(names.OUTPUT_PIN, pin_number)
        contact_force = _in(frame, _on_gear(turn, name, disc).reaction())
        max_width = np.full_like(contact_force.size, MAX_HALF_ANGLE * output.root_radius)
        width = max_width if output.rollers else _round_width(turn, "output", contact_force)
        position = contact_force.on_disc(centre, output.root_radius, width)
        contacts.append(_contact(turn, _pair_name(turn, name, disc), "output", contact_force, position, width))
    return contacts


def _shaft_contacts(turn: Turn) -> list[PartContact]:
    """List force, position and patch width of the contact of each cam of the shaft with its disc over a `turn`."""
    gear, frame, errors = turn.reducer.design.gear, part_frame(turn, "shaft"), turn.reducer.deviations
    contacts = []
    for disc, phase in enumerate(turn.reducer.phases):
        contact_force = _in(frame, _on_gear(turn, names.CAM, disc).reaction())
        width = _round_width(turn, "cam", contact_force)
        centre = (gear.eccentricity + errors.eccentricity) * unit(-phase) + errors.cam_displacement[disc]
        position = contact_force.on_disc(centre, gear.bore_radius, width)
        contacts.append(_contact(turn, _pair_name(turn, names.CAM, disc), "cam", contact_force, position, width))
    return contacts


def _pin_contacts(turn: Turn) -> list[PartContact]:
    """List force, position and patch width of the contacts of ring pin 1 over a turn: with each disc, then its socket.

    A free pin has a single contact with its socket. A fixed pin has one for the force of each disc.
    """
    gear, frame, centre = turn.reducer.gear_profile, part_frame(turn, "pin_1"), np.zeros(2)
    contacts, socket_forces = [], []
    for disc, name in enumerate(turn.reducer.gears):
        contact_force = _in(frame, _on_gear(turn, "pin_1", disc).reaction())
        curvature = _pin_curvature(gear, 0, _tooth_frame(turn, disc).angle, turn.reducer.profile_offset)
        width = half_width(turn.reducer, "pin_gear", contact_force.size, curvature, gear.pin_radius)
        position = contact_force.on_disc(centre, gear.pin_radius, width)
        contacts.append(_contact(turn, name, "pin_gear", contact_force, position, width, curvature))
        socket_forces.append(_in(frame, _socket_force(turn, 0, disc)))
    for disc, contact_force in enumerate(socket_forces[:1] if _has_free_pins(turn) else socket_forces):
        width = _round_width(turn, "pin_socket", contact_force)
        name = names.SOCKET if _has_free_pins(turn) else _pair_name(turn, names.SOCKET, disc)
        position = contact_force.on_disc(centre, gear.pin_radius, width)
        contacts.append(_contact(turn, name, "pin_socket", contact_force, position, width))
    return contacts


def _tooth_contacts(turn: Turn, part: str, disc: int) -> list[PartContact]:
    """List the contacts of a disc and the ring over a `turn`, as forces on `part` in its frame.

    `disc` is the index of the disc. `part` is "ring" or the name of that disc; for a ring with pins it must be the
    disc.
    """
    reducer = turn.reducer
    if reducer.design.ring.kind == "pin":
        return [_pin_contact(turn, pin, disc) for pin in range(reducer.design.ring.teeth)]
    gear, flank, offset = reducer.tooth_profile, reducer.gear_profile, reducer.profile_offset
    tooth_frame, frame, phase = _tooth_frame(turn, disc), part_frame(turn, part), reducer.phases[disc]
    line_t, curvatures = lobe_lines(gear, turn["crank_angle"] + phase)
    rotation_error = tooth_frame.angle + (turn["crank_angle"] + phase) / gear.lobes
    contacts = []
    for lobe in range(gear.ring_teeth):
        name = names.numbered_name(names.LOBE, lobe + 1)
        contact_force = _on_gear(turn, name, disc)
        tooth_action = _in(tooth_frame, contact_force)
        position, curvature = lobe_contact_point(
            flank,
            tooth_action.nearest_point,
            tooth_action.direction,
            line_t[:, lobe],
            curvatures[:, lobe],
            rotation_error,
            offset,
        )
        position = rotate_vectors(position, tooth_frame.angle - frame.angle)
        if part == "ring":
            position, contact_force = position + tooth_frame.origin, contact_force.reaction()
        width = half_width(reducer, "tooth", contact_force.size, curvature, gear.pin_radius)
        name = _pair_name(turn, name, disc)
        contacts.append(_contact(turn, name, "tooth", _in(frame, contact_force), position, width, curvature))
    return contacts


def _pin_contact(turn: Turn, pin: int, disc: int) -> PartContact:
    """Return force, position and patch width of a ring pin on a disc over a turn, in the frame of the disc.

    `pin` and `disc` are indices from 0.
    """
    gear, frame, name = turn.reducer.gear_profile, _disc(turn, disc), names.numbered_name(names.PIN, pin + 1)
    contact_force = _in(frame, _on_gear(turn, name, disc))
    position = contact_force.on_hole(
        frame.transform_points(pin_centre(turn, pin)), gear.pin_radius + turn.reducer.deviations.pin_radius[pin]
    )
    curvature = _pin_curvature(gear, pin, _tooth_frame(turn, disc).angle, turn.reducer.profile_offset)
    width = half_width(turn.reducer, "pin_gear", contact_force.size, curvature, gear.pin_radius)
    return _contact(turn, _pair_name(turn, name, disc), "pin_gear", contact_force, position, width, curvature)


def _socket_contact(turn: Turn, pin: int, disc: int) -> PartContact:
    """Return force, position and patch width of a ring pin on the wall of its socket, in the frame of the ring.

    `pin` and `disc` are indices from 0; the force of a free pin does not depend on the disc. The wall is open towards
    the gear. A force where the ring has no wall is set to zero, since end plates carry it.
    """
    ring = turn.reducer.design.ring
    contact_force = _socket_force(turn, pin, disc).reaction()
    centre = ring.pin_circle_radius * unit(2 * np.pi * pin / ring.teeth) + turn.reducer.deviations.pin_displacement[pin]
    radius = np.linalg.norm(contact_force.on_hole(centre, _round_radii(turn, "pin_socket")[1]), axis=-1)
    contact_force = contact_force.select(radius > wall_radius(turn.reducer.design) * (1.0 - 1e-9))
    name = names.numbered_name(names.SOCKET, pin + 1)
    return _hole_contact(
        turn, name if _has_free_pins(turn) else _pair_name(turn, name, disc), "pin_socket", contact_force, centre
    )


def _socket_force(turn: Turn, pin: int, disc: int) -> Action:
    """Return the force of the socket on a ring pin, or of a disc on a fixed pin (moment about the reducer's axis)."""
    if _has_free_pins(turn):
        return _read_action(turn, names.numbered_name(names.SOCKET, pin + 1), pin_centre(turn, pin))
    return _on_gear(turn, names.numbered_name(names.PIN, pin + 1), disc)


def _has_free_pins(turn: Turn) -> bool:
    """Return whether the ring's pins are bodies of their own in sockets."""
    return turn.reducer.design.ring.has_sockets and turn.reducer.design.ring.has_pin_bodies


def _hole_contact(turn: Turn, name: str, kind: str, action: Action, centre: Array) -> PartContact:
    """Return the contact of a round part on the wall of the hole around `centre` [m], under the force `action`."""
    width = _round_width(turn, kind, action)
    return _contact(turn, name, kind, action, action.on_hole(centre, _round_radii(turn, kind)[1], width), width)


def _contact(
    turn: Turn, name: str, kind: str, action: Action, position: Array, width: Array, curvature: Array | None = None
) -> PartContact:
    """Return a contact of a kind of pair with its Hertzian stress; `curvature` [1/m] is that of a tooth."""
    return PartContact(name, action, position, width, line_contact(turn.reducer, kind, action.size, curvature))


def _round_radii(turn: Turn, kind: str) -> tuple[float, float]:
    """Return the radii of a round part and of the hole around it [m]; the radius of the hole includes the clearance.

    `kind` is the kind of mating pair: "cam", "output" or "pin_socket".
    """
    design = turn.reducer.design
    part_radius, hole_radius = {
        "cam": (design.gear.bore_radius, design.gear.bore_radius + design.clearance.cam),
        "output": (design.output.pin_radius, design.output.hole_radius + design.clearance.output),
        "pin_socket": (design.ring.pin_radius, design.ring.pin_radius + design.socket_play),
    }[kind]
    return part_radius, hole_radius


def _round_width(turn: Turn, kind: str, action: Action) -> Array:
    """Compute the half width of the patch of a round part in its hole [m], (k,); the widest without clearance."""
    part_radius, hole_radius = _round_radii(turn, kind)
    return half_width(turn.reducer, kind, action.size, 1.0 / part_radius - 1.0 / hole_radius, part_radius)


def total(contacts: Sequence[PartContact]) -> Action:
    """Return the sum of forces and moments of all contacts."""
    force = np.sum([contact.action.force for contact in contacts], axis=0)
    return Action(force, np.sum([contact.action.moment for contact in contacts], axis=0))


def mean_cosine(half_angle: Array) -> Array:
    """Average the cosine over an elliptical pressure of a half angle a [rad]: 2 J1(a)/a."""
    a = np.maximum(half_angle, 1e-9)
    return 2.0 * j1(a) / a


def dot(a: Array, b: Array) -> Array:
    """Compute inner products along the last axis."""
    return np.sum(a * b, axis=-1)


def turned_right(vectors: Array) -> Array:
    """Rotate vectors (..., 2) by a quarter turn clockwise."""
    return np.stack([vectors[..., 1], -vectors[..., 0]], axis=-1)


def rotate_vectors(vectors: Array, angle: Array) -> Array:
    """Rotate vectors (..., 2) counter-clockwise by angles (...) [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
