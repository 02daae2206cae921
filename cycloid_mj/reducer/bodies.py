"""Mechanism of a reducer: bodies with their degrees of freedom, surfaces, and mating pairs.

The gaps (``gaps``), the MuJoCo model and the columns of a log follow from it. Manufacturing errors and clearances are
in the positions and radii of its surfaces, nowhere else; the modification is in the profile of the teeth. Masses and
contact laws stand on solids and are attached above. Written for D discs at phases on the one crank.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.deprecated import deprecated_attribute
from cycloid_mj.design import Design, Ring
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.deviations import Deviations, deviations
from cycloid_mj.geometry.kinematics import gear_centre
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.reducer.member import member_of
from cycloid_mj.reducer.sockets import socket_half_angle


class Role(IntEnum):
    """Role of a surface in a contact: the priority of its geom, a number that other models are unlikely to use."""

    PIN = 0x63796D01
    TEETH = 0x63796D02
    INNER = 0x63796D03
    OUTER = 0x63796D04
    LOBE = 0x63796D05
    SUN = 0x63796D06
    PLANET = 0x63796D07
    ECCENTRIC = 0x63796D08


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid part.

    Attributes
    ----------
    name
        Name.
    part
        Its solid, a key of ``parts.body_solids``.
    joints
        Its degrees of freedom by name: none, its turn about the axis of its frame, or x, y and turn in the plane.
    position
        Position of its frame at the crank angle 0 [m], shape (2,).
    origin
        Values of its joints x and y there [m], shape (2,).
    plane
        Position of its frame along z [m]: the middle of a disc; 0 is the middle of all discs.
    carrier
        Name of the body that its joints are relative to: the housing for the pins of a ring that rotates, the carrier
        for the cranks of an RV reducer; empty: none.
    """

    name: str
    part: str
    joints: tuple[str, ...]
    position: Array
    origin: Array
    plane: float = 0.0
    carrier: str = ""

    place = deprecated_attribute("Body", "place", "position")


@dataclass(frozen=True, eq=False)
class Surfaces:
    """A group of n identical surfaces: the ring pins, the holes of a disc, or the cam.

    Attributes
    ----------
    names, bodies
        Name of each surface, and of its body.
    role
        Kind of the surfaces.
    angle
        Clockwise angle from +y [rad], shape (n,): of the ideal position, or by which teeth are turned on their disc.
    position
        Position in the body's frame, with manufacturing errors [m], shape (n, 2).
    radius
        Radius as manufactured, including clearance [m], shape (n,); of teeth, the largest radius of the ring.
    play
        Clearance of massless pins [m], shape (n,); otherwise 0.
    disc
        Index of the disc whose width they have; None if they span all discs.
    half_angle
        Half of the arc on which sockets support their pins, about the direction `angle` [rad]; massless pins have that
        of their sockets; pi for closed circles.
    """

    names: tuple[str, ...]
    bodies: tuple[str, ...]
    role: Role
    angle: Array
    position: Array
    radius: Array
    play: Array
    disc: int | None = None
    half_angle: float = math.pi

    place = deprecated_attribute("Surfaces", "place", "position")


@dataclass(frozen=True)
class Pair:
    """A pair of mating surfaces.

    Attributes
    ----------
    name
        Name, and the stem of its columns in the log.
    kind
        ``pin_gear``, ``pin_socket``, ``pin_sleeve``, ``tooth``, ``cam`` or ``output``: the key of its clearance,
        friction, stiffness, damping and working force; of an RV reducer also ``crank_bearing`` and ``planet_mesh``.
    on
        Surface whose body feels the logged force: the gear, the pin in its socket, the sleeve on its pin, or the sun.
    by
        Surface that exerts it.
    owner
        Index of the pin, lobe, output pin, crank or planet, 0 on +y, clockwise.
    disc
        Index of the disc; 0 where none takes part.
    """

    name: str
    kind: str
    on: str
    by: str
    owner: int
    disc: int


@dataclass(frozen=True, eq=False)
class Mating:
    """A group of identical pairs: surface i of `on` mates with surface i of `by`, or with its only surface."""

    kind: str
    names: tuple[str, ...]
    on: Surfaces
    by: Surfaces
    disc: int = 0

    @property
    def pairs(self) -> Iterator[Pair]:
        """The pairs of a surface with its mate, in the order of the surfaces."""
        lonely = len(self.on.names) == 1
        for owner, (name, mate) in enumerate(zip(self.names, self.by.names, strict=True)):
            yield Pair(name, self.kind, self.on.names[0 if lonely else owner], mate, owner, self.disc)


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A reducer.

    Attributes
    ----------
    design
        The design.
    phases
        Phase of each disc on the crank [rad], counter-clockwise.
    bodies
        The fixed member (the housing, or the output if the ring rotates), shaft, discs, the loaded member, and moving
        pins or sleeves.
    matings
        Teeth of every disc, then what carries the pins, then cams, then output pins.
    """

    design: Design
    phases: tuple[float, ...]
    bodies: tuple[Body, ...]
    matings: tuple[Mating, ...]

    @property
    def pairs(self) -> tuple[Pair, ...]:
        """Every mating pair."""
        return tuple(pair for mating in self.matings for pair in mating.pairs)

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of mating pairs, in the order of the pairs."""
        return tuple(dict.fromkeys(mating.kind for mating in self.matings))

    @property
    def surfaces(self) -> tuple[Surfaces, ...]:
        """All groups of surfaces, without repetition."""
        return tuple(dict.fromkeys(side for mating in self.matings for side in (mating.on, mating.by)))

    @property
    def discs(self) -> tuple[Body, ...]:
        """The bodies of the discs."""
        return tuple(body for body in self.bodies if names.family(body.part) == names.GEAR)

    @property
    def pins(self) -> tuple[Body, ...]:
        """The bodies of moving pins or sleeves, in the order of the ring."""
        return tuple(body for body in self.bodies if body.part == names.PIN)

    def body(self, name: str) -> Body:
        """Return the body with a name."""
        return next(body for body in self.bodies if body.name == name)

    @property
    def turning(self) -> str:
        """Name of the loaded body."""
        return next(body.name for body in self.bodies if names.OUTPUT_JOINT in body.joints)

    @property
    def turning_along(self) -> tuple[Body, ...]:
        """The bodies that rotate with the loaded body: discs with their carrier, or pins with their ring."""
        return {names.OUTPUT: self.discs, names.HOUSING: self.pins}[self.turning]

    @property
    def carried(self) -> tuple[Body, ...]:
        """The bodies whose joints are relative to the loaded body: pins of a ring, or cranks of a carrier."""
        return tuple(body for body in self.bodies if body.carrier == self.turning)

    @property
    def carriers(self) -> dict[str, str]:
        """Map from the name of each surface to that of its body."""
        return {name: body for group in self.surfaces for name, body in zip(group.names, group.bodies, strict=True)}

    def against(self, body: str) -> list[str]:
        """Return the names of the pairs in which a body, by its name, receives the forces of discs, pins or sleeves."""
        carriers = self.carriers
        return [pair.name for pair in self.pairs if carriers[pair.by] == body]

    def mating(self, kind: str, disc: int = 0) -> Mating:
        """Return the group of pairs of a `kind` on the disc of index `disc`."""
        return next(mating for mating in self.matings if (mating.kind, mating.disc) == (kind, disc))


def phases(design: Design) -> tuple[float, ...]:
    """Return the phase of each disc on the crank [rad], counter-clockwise: evenly spaced, the first with the crank."""
    discs = design.gear.discs
    return tuple(2.0 * math.pi * disc / discs for disc in range(discs))


def are_discs_identical(discs: int, output_pins: int, lobes: int) -> bool:
    """Return whether all discs are identical parts, which are only mounted at different angles on the output pins.

    Symbols: D `discs`, n `output_pins`, and L `lobes` of a disc. On disc d, the teeth are ahead of the holes by d/D of
    a tooth pitch. Rotating a disc by j hole pitches rotates it by j L/n tooth pitches. The fractional parts of j L/n
    are the multiples of 1/m, with m = n/gcd(n, L). So the discs are identical if m is a multiple of D.
    """
    return output_pins // math.gcd(output_pins, lobes) % discs == 0


def build_mechanism(design: Design) -> Mechanism:
    """Build the mechanism of a design: its bodies, and the pairs of surfaces that may touch.

    Raises
    ------
    DesignError
        The design has a measured profile, but its nominal profile is undercut.
    """
    errors, discs = deviations(design), range(design.gear.discs)
    ring_side, seats = ring_surfaces(design, errors)
    output = design.output
    pin_names = names.all_numbered(names.OUTPUT_PIN, output.pins)
    output_pins = surfaces_on_circle(pin_names, names.OUTPUT, Role.INNER, output.pin_circle_radius, output.pin_radius)
    return Mechanism(
        design=design,
        phases=phases(design),
        bodies=tuple(_mechanism_bodies(design, errors)),
        matings=(
            *(tooth_mating(design, disc, ring_side) for disc in discs),
            *seats,
            *(_cam_mating(design, errors, disc) for disc in discs),
            *(_hole_mating(design, errors, disc, output_pins) for disc in discs),
        ),
    )


def _mechanism_bodies(design: Design, errors: Deviations) -> Iterator[Body]:
    """Yield the bodies of a mechanism at crank angle 0 with their joints.

    They are the fixed member, crank, discs, output and moving pins. `errors` displace the ring pins. If the ring is the
    output, its pins move relative to it.
    """
    origin, gear = np.zeros(2), tooth_profile(design)
    output_body, fixed_body = member_of(design).turning_and_held
    # the ring is the housing's: where that turns it takes its pins along
    carrier = names.HOUSING if output_body == names.HOUSING else ""
    yield Body(fixed_body, fixed_body, (), origin, origin)
    yield Body(names.SHAFT, names.SHAFT, (names.CRANK_JOINT,), origin, origin)
    for disc, phase in enumerate(phases(design)):
        name, centre = _of_disc(design, names.GEAR, disc), gear_centre(gear, phase)
        yield Body(name, name, names.planar_joints(name), centre, centre, design.gear.disc_planes[disc])
    yield Body(output_body, output_body, (names.OUTPUT_JOINT,), origin, origin)
    yield from pin_bodies(design, errors, carrier)


def pin_bodies(design: Design, errors: Deviations, carrier: str = "") -> Iterator[Body]:
    """Yield the bodies of moving pins or sleeves, which are in the middle of their seats at crank angle 0.

    Nothing is yielded for fixed or massless pins. `errors` displace the seats. The joints are relative to the body with
    the name `carrier`; "" is the world.
    """
    ring = design.ring
    if not ring.has_pin_bodies:
        return
    positions = ring.pin_circle_radius * profile.unit(_ring_angles(ring)) + _pin_position_errors(ring, errors)
    planes = np.repeat(ring_planes(ring, design.gear.stack_width), ring.teeth).tolist()
    for name, centre, plane in zip(names.all_numbered(names.PIN, ring.mate_count), positions, planes, strict=True):
        yield Body(name, names.PIN, names.planar_joints(name), centre, np.zeros(2), plane, carrier=carrier)


def ring_surfaces(design: Design, errors: Deviations) -> tuple[Surfaces, list[Mating]]:
    """Return the surfaces of the ring (pins or lobes) that mate with the discs, and the pairs of moving pins and seats.

    Moving pins mate with their seats: sockets of pins, or cores of sleeves. `errors` change positions and radii of the
    pins.

    Returns
    -------
    tuple
        The surfaces, which belong to moving pins if there are any and to the housing if not; and the group of pairs of
        pins and seats, in a list that is empty without moving pins.
    """
    ring, clearance = design.ring, design.clearance
    radius_errors = np.tile(errors.pin_radius, ring.halves)
    radius, angles, position_errors = (
        ring.pin_radius + radius_errors,
        _ring_angles(ring),
        _pin_position_errors(ring, errors),
    )
    half_angle = socket_half_angle(design) if ring.has_sockets else math.pi

    def on_housing(stem: str, role: Role, radius: float | Array, play: float | Array = 0.0) -> Surfaces:
        """Return surfaces of the housing on the pin circle, of a `radius` and a `play` [m], named after `stem`."""
        surface_names = names.all_numbered(stem, ring.mate_count)
        return surfaces_on_circle(
            surface_names, names.HOUSING, role, ring.pin_circle_radius, radius, position_errors, angles, play
        )

    def on_pins(stem: str, role: Role, radius: float | Array) -> Surfaces:
        """Return surfaces about the axes of the pin bodies, of a `radius` [m], named after `stem`."""
        surface_names = names.all_numbered(stem, ring.mate_count)
        return surfaces_on_circle(
            surface_names, names.all_numbered(names.PIN, ring.mate_count), role, 0.0, radius, angles=angles
        )

    if not ring.has_pin_bodies:
        stem, role = (names.LOBE, Role.LOBE) if ring.kind == "nonpin" else (names.PIN, Role.PIN)
        # What is larger fills a socket; a sleeve's play is in its bore.
        play = design.pin_play - radius_errors * ring.has_sockets if ring.has_massless_pins else 0.0
        fixed_surfaces = on_housing(stem, role, radius, play)
        return (replace(fixed_surfaces, half_angle=half_angle) if ring.has_massless_pins else fixed_surfaces), []
    pin_surfaces = on_pins(names.PIN, Role.PIN, radius)
    if ring.has_sockets:
        sockets = on_housing(names.SOCKET, Role.OUTER, ring.pin_radius + clearance.pin_socket)
        sockets = replace(sockets, half_angle=half_angle)
        return pin_surfaces, [Mating("pin_socket", sockets.names, pin_surfaces, sockets)]
    bores = on_pins(names.SLEEVE, Role.OUTER, ring.sleeve_bore_radius)
    cores = on_housing(names.CORE, Role.INNER, ring.pin_radius - clearance.pin_sleeve - ring.sleeve_thickness)
    return pin_surfaces, [Mating("pin_sleeve", bores.names, bores, cores)]


def tooth_mating(design: Design, disc: int, ring_side: Surfaces) -> Mating:
    """Return the pairs of surfaces of a disc's teeth and the ring's pins or lobes, `ring_side`.

    `disc` is the index of the disc. The teeth are rotated by the phase of the disc on the crank.
    """
    tooth_surfaces = Surfaces(
        names=(_of_disc(design, names.TEETH, disc),),
        bodies=(_of_disc(design, names.GEAR, disc),),
        role=Role.TEETH,
        angle=np.array([phases(design)[disc] / design.lobes]),
        position=np.zeros((1, 2)),
        radius=np.array([design.ring_root_radius]),
        play=np.zeros(1),
        disc=disc,
    )
    pairs = tuple(_of_disc(design, name, disc) for name in ring_side.names)
    return Mating(design.tooth_pair, pairs, tooth_surfaces, ring_side, disc)


def _cam_mating(design: Design, errors: Deviations, disc: int) -> Mating:
    """Return the pair of surfaces of a disc's bore and its cam; `errors` displace the cam on the shaft.

    `disc` is the index of the disc. The clearance is included in the radius of the bore.
    """
    disc_name, radius = _of_disc(design, names.GEAR, disc), design.gear.bore_radius
    bore_name, cam_name = (_of_disc(design, name, disc) for name in (names.BORE, names.CAM))
    phase, orbit = phases(design)[disc], design.gear.eccentricity + errors.eccentricity
    return Mating(
        "cam",
        (cam_name,),
        surfaces_on_circle((bore_name,), disc_name, Role.OUTER, 0.0, radius + design.clearance.cam, disc=disc),
        surfaces_on_circle(
            (cam_name,),
            names.SHAFT,
            Role.INNER,
            orbit,
            radius,
            errors.cam_displacement[disc],
            np.array([-phase]),
            disc=disc,
        ),
        disc,
    )


def _hole_mating(design: Design, errors: Deviations, disc: int, pin_surfaces: Surfaces) -> Mating:
    """Return the pairs of surfaces of a disc's holes and the output pins, `pin_surfaces`; `errors` displace the holes.

    `disc` is the index of the disc. The clearance is included in the radius of the holes.
    """
    output = design.output
    hole_names = tuple(_of_disc(design, name, disc) for name in names.all_numbered(names.HOLE, output.pins))
    radius, disc_name = output.hole_radius + design.clearance.output, _of_disc(design, names.GEAR, disc)
    hole_surfaces = surfaces_on_circle(
        hole_names, disc_name, Role.OUTER, output.pin_circle_radius, radius, errors.hole_displacement[disc], disc=disc
    )
    return Mating(
        "output", tuple(_of_disc(design, name, disc) for name in pin_surfaces.names), hole_surfaces, pin_surfaces, disc
    )


def _of_disc(design: Design, name: str, disc: int) -> str:
    return names.of_disc(name, disc, design.gear.discs)


def surfaces_on_circle(
    surface_names: tuple[str, ...],
    body: str | tuple[str, ...],
    role: Role,
    circle_radius: float,
    radius: float | Array,
    error: Array | float = 0.0,
    angles: Array | None = None,
    play: float | Array = 0.0,
    disc: int | None = None,
) -> Surfaces:
    """Return n round surfaces with centres on a circle about the axis of their body.

    Parameters
    ----------
    surface_names, body
        Names of the n surfaces, and name of their body: a common name, or one for each surface.
    role
        Kind of the surfaces, such as pin, lobe or planet.
    circle_radius
        Radius of the circle [m].
    radius
        Radius of the surfaces [m], a number or of shape (n,).
    error
        Displacement of the centres from the circle [m], shape (n, 2).
    angles
        Angles of the centres, clockwise from +y [rad], shape (n,); by default evenly spaced from 0.
    play
        Clearance of massless pins in their seats [m], a number or of shape (n,).
    disc
        Index of the disc whose width the surfaces have; None if they span all discs.
    """
    count = len(surface_names)
    angle = _angles(count) if angles is None else angles
    bodies = (body,) * count if isinstance(body, str) else body
    position = circle_radius * profile.unit(angle) + error
    return Surfaces(
        surface_names, bodies, role, angle, position, np.zeros(count) + radius, np.zeros(count) + play, disc
    )


def ring_planes(ring: Ring, width: float) -> Array:
    """Return the axial position of the centre of the ring, or of each of its halves [m], shape (halves,).

    The discs are `width` [m] wide together.
    """
    return np.asarray(width * ((np.arange(ring.halves) + 0.5) / ring.halves - 0.5))


def _ring_angles(ring: Ring) -> Array:
    """Return the clockwise angles of pins or lobes from +y [rad], shape (mates,), with the rotation of their half."""
    return np.concatenate([_angles(ring.teeth) - ahead for ahead in ring.ahead])


def _pin_position_errors(ring: Ring, errors: Deviations) -> Array:
    """Return the position errors of pins or lobes [m], shape (mates, 2), equal in both halves."""
    turns = (
        np.array([[np.cos(preload), np.sin(preload)], [-np.sin(preload), np.cos(preload)]]) for preload in ring.ahead
    )
    return np.concatenate([errors.pin_displacement @ turn for turn in turns])


def _angles(count: int) -> Array:
    """Return equally spaced angles around the axis, clockwise from +y [rad], shape (count,)."""
    return np.asarray(2.0 * np.pi * np.arange(count) / count)
