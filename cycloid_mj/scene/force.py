"""Contact forces and their points of action, from the columns of a run."""

from collections.abc import Container, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array, cross
from cycloid_mj.base.record import usable
from cycloid_mj.geometry.ideal_loads import ideal_load_sharing
from cycloid_mj.geometry.kinematics import gear_centre
from cycloid_mj.geometry.rv_loads import ideal_rv_loads
from cycloid_mj.parts import output_centres
from cycloid_mj.parts.parts import Colour
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.reducer.rv_bodies import crank_names
from cycloid_mj.scene.drawing import Drawing, Radii, drawn_radii
from cycloid_mj.scene.pose import poses, ring_places, transform
from cycloid_mj.scene.rv_drawing import RvDrawing

WRENCH = (names.FORCE_X, names.FORCE_Y, names.MOMENT)
_ON_PINS = ("pin_socket", "pin_sleeve")


@dataclass(frozen=True)
class ArrowStyle:
    """Size of force arrows, and position of their tips."""

    length: float = 0.3
    """Length of the arrow of a typical largest force, as a share of the pin-circle radius."""
    thickness: float = 0.012
    """Diameter of an arrow's shaft, as a share of the pin-circle radius."""
    max_shift: float = 1e-3
    """Largest shift of a contact onto the line of action [m]: a friction coefficient of 0.5 on a 2 mm pin."""


ARROWS = ArrowStyle()


FORCE_COLOURS: dict[str, Colour] = {
    "pin_gear": (0.84, 0.37, 0.0, 1.0),
    "tooth": (0.84, 0.37, 0.0, 1.0),
    "cam": (0.0, 0.0, 0.0, 1.0),
    "output": (0.0, 0.45, 0.70, 1.0),
    names.CRANK_BEARING: (0.0, 0.45, 0.70, 1.0),
}
"""Kinds of mating pairs that are shown; the force in a socket or sleeve equals that of the disc on the pin."""


@dataclass(frozen=True, eq=False)
class ContactForces:
    """Forces of k mating pairs at n times.

    Attributes
    ----------
    names, kinds
        Name of each pair (pin_1, ..., cam, output_pin_1, ...; of several discs gear_2_cam, ...) and its kind (pin_gear,
        tooth, pin_socket, pin_sleeve, cam, output; in an RV reducer crank_bearing and planet_mesh instead of the last
        two).
    point
        Point of action, from the reducer axis [m], shape (n, k, 2): on the line of action, at the surface of the pin,
        lobe, cam, output pin or needles, or near the pitch point of a planet.
    force
        Force on the disc, on the pin in its socket, on the sleeve on its pin, or on the sun [N], shape (n, k, 2).
    """

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    point: Array
    force: Array

    @cached_property
    def size(self) -> Array:
        """Magnitude of each force [N], shape (n, k)."""
        return np.linalg.norm(self.force, axis=2)

    @cached_property
    def discs(self) -> tuple[int, ...]:
        """Index of the disc of each pair; 0 if it has none."""
        return tuple(names.disc_of(name) for name in self.names)

    def of(self, *kinds: str) -> "ContactForces":
        """Return the pairs of some kinds."""
        return self._select([row for row, kind in enumerate(self.kinds) if kind in kinds])

    def of_disc(self, disc: int) -> "ContactForces":
        """Return the pairs of a disc, by its index."""
        return self._select([row for row, index in enumerate(self.discs) if index == disc])

    def _select(self, rows: list[int]) -> "ContactForces":
        pair_names, pair_kinds = (tuple(words[row] for row in rows) for words in (self.names, self.kinds))
        return ContactForces(pair_names, pair_kinds, self.point[:, rows], self.force[:, rows])


def contact_forces(
    reducer: Reducer,
    columns: Mapping[str, Array],
    drawing: Drawing | RvDrawing | None = None,
    kinds: Container[str] = names.KINDS.values(),
) -> ContactForces:
    """Compute force and point of action of mating pairs at the n samples of a log, for pairs with logged forces.

    The columns ``<pair>_force_x``, ``_force_y`` and ``_moment`` are force and moment about the origin of the loaded
    body, which determine the line of action. The point of action is the contact point without friction, shifted onto
    this line.

    Parameters
    ----------
    columns
        Values by name, shape (n,), in SI units.
    drawing
        Drawing of the same samples, if the points are to be on the drawn parts; by default they are on the measured
        parts.
    kinds
        Kinds of mating pairs to include, such as "cam" (`ContactForces.kinds`).
    """
    kind_by_pair = {name: kind for name, kind in _pairs(columns).items() if kind in kinds}
    poses_by_part, disc_names = poses(reducer, columns), names.gears(reducer.design.gear.discs)
    measured_geometry = _logged_inner_parts(reducer, poses_by_part)
    displayed_geometry = measured_geometry if drawing is None else _inner_parts_of_drawing(reducer, drawing)
    wrench_columns = [columns[names.column(name, component)] for name in kind_by_pair for component in WRENCH]
    sample_count = columns["output_angle"].size
    wrench = usable(np.reshape(wrench_columns, (len(kind_by_pair), len(WRENCH), sample_count)).transpose(2, 0, 1))
    loaded_parts = [
        names.pin(names.number_of(name))
        if kind in _ON_PINS
        else names.SUN
        if kind == names.PLANET_MESH
        else disc_names[names.disc_of(name)]
        for name, kind in kind_by_pair.items()
    ]
    origin = np.reshape(
        [poses_by_part[part][:, :2] for part in loaded_parts], (len(kind_by_pair), sample_count, 2)
    ).transpose(1, 0, 2)
    direction = _direction(wrench[..., :2])
    shift = _shift_to_action_line(wrench, direction, measured_geometry.contact_points(kind_by_pair, direction) - origin)
    return ContactForces(
        tuple(kind_by_pair),
        tuple(kind_by_pair.values()),
        displayed_geometry.contact_points(kind_by_pair, direction) + shift,
        wrench[..., :2],
    )


def shown_forces(reducer: Reducer, columns: Mapping[str, Array]) -> ContactForces:
    """Return the forces that viewers show; see `contact_forces`."""
    return contact_forces(reducer, columns, kinds=FORCE_COLOURS)


def arrow_heights(reducer: Reducer) -> tuple[float, ...]:
    """Compute the z at which the force arrows of each disc are drawn [m]: just above its face on the output side.

    The first of several discs has its arrows on its other face, which no disc covers.
    """
    design = reducer.design
    height = 0.5 * design.gear.face_width + ARROWS.thickness * design.ring.pin_circle_radius
    first_plane, *other_planes = design.gear.disc_planes
    return (first_plane - height if other_planes else first_plane + height, *(plane + height for plane in other_planes))


def ideal_forces(reducer: Reducer, columns: Mapping[str, Array], disc: int = 0) -> Array | None:
    """Compute the force of a disc on each pin by ideal load sharing [N], shape (n, mates); None for an internal gear.

    `columns` are log columns by name, shape (n,), in SI units. `disc` is the index of the disc. The mates are the pins
    of the ring; if the ring is split axially into halves, the pins of both halves, which share the load equally.
    """
    design = reducer.design
    if design.ring.kind != "pin":
        return None
    if isinstance(reducer, RvReducer):
        return _ideal_rv_forces(reducer, columns, disc)
    disc_torque, crank_angle = columns["load_torque"] / design.gear.discs, columns["crank_angle"] + reducer.phases[disc]
    halves = design.ring.halves
    return np.tile(ideal_load_sharing(reducer.tooth_profile, disc_torque / halves, crank_angle).forces, (1, halves))


def _ideal_rv_forces(reducer: RvReducer, columns: Mapping[str, Array], disc: int) -> Array:
    """Compute the force of a disc of an RV reducer on each pin by ideal load sharing [N], shape (n, mates).

    `columns` are those of the log by name, of which the load and the angle of the sun are used. `disc` is the index of
    the disc.
    """
    member = reducer.member
    input_angle = member.against_ring(columns[f"{reducer.INPUT}_angle"])
    torque = (-1.0 if member.turns_ring else 1.0) * member.share * columns["load_torque"][:, np.newaxis]
    forward, backward = (
        ideal_rv_loads(reducer.stage, direction, input_angle).pins[:, disc] for direction in (1.0, -1.0)
    )
    return np.abs(torque) * np.where(torque > 0.0, forward, backward)


def reference_force(reducer: Reducer) -> dict[str, float]:
    """Compute a typical force for each kind of mating pair [N]: kind, such as "cam" -> force.

    It follows from the load, or from weight and inertia of the disc if they cause larger forces. Symbols: torque T of a
    disc, eccentricity c, N ring contacts, n output pins on the radius R. The cam has the force T/(c (N-1)). Half of the
    ring contacts share it as a sine, so that the largest of their forces is 4 T/(c N (N-1)). The largest force of
    output pins is 4 T/(n R). For an RV reducer, the forces are those of ideal sharing of the load.
    """
    design = reducer.design
    if isinstance(reducer, RvReducer):
        contacts = reducer.at_rated_load.contacts
        return {kind: contacts[kind].force for kind in reducer.mechanism.kinds}
    gear, output, tooth_count = design.gear, design.output, design.ring.teeth
    disc_area = np.pi * (design.ring.pin_circle_radius**2 - gear.bore_radius**2 - output.pins * output.hole_radius**2)
    mass = design.material_of("gear").density * gear.face_width * max(float(disc_area), 0.0)
    inertia_force = mass * (gear.eccentricity * design.drive.speed**2 + abs(design.environment.gravity_y))
    torque = max(abs(design.load.torque) / gear.discs, inertia_force * gear.eccentricity * design.lobes)
    cam_force = torque / (gear.eccentricity * design.lobes)
    ring_force, pin_force = 4 * cam_force / tooth_count, 4 * torque / (output.pins * output.pin_circle_radius)
    ring_forces = dict.fromkeys(("pin_gear", "tooth", "pin_socket", "pin_sleeve"), ring_force)
    return {**ring_forces, "cam": cam_force, "output": pin_force}


def _pairs(columns: Mapping[str, Array]) -> dict[str, str]:
    """Return the kinds of the pairs that have all columns of a wrench, by the name of the pair; skip other pairs."""
    suffix = names.column("", names.FORCE_X)
    pairs = (name.removesuffix(suffix) for name in columns if name.endswith(suffix))
    complete_pairs = (pair for pair in pairs if all(names.column(pair, component) in columns for component in WRENCH))
    return {pair: kind for pair in complete_pairs if (kind := names.kind_of(pair))}


@dataclass(frozen=True, eq=False)
class _InnerParts:
    """Inner parts of the pairs at n times.

    Attributes
    ----------
    ring
        Centres of pins or lobes [m], shape (n, N, 2).
    others
        Kind of pair -> centres of its inner parts on each disc [m], shape (n, D, k, 2).
    radii
        Kind of pair -> radius of its inner parts [m]; negative if the inner part is the loaded one.
    """

    ring: Array
    others: Mapping[str, Array]
    radii: Mapping[str, float]

    def contact_points(self, kind_by_pair: Mapping[str, str], direction: Array) -> Array:
        """Compute the contact points of k pairs at n instants, as they would be without friction, shape (n, k, 2) [m].

        The points are on the surface of the inner part: pin, cam, output pin, needles or core. `kind_by_pair` has the
        kind of each pair by its name (`ContactForces.kinds`), and `direction` (n, k, 2) the unit vectors of the forces
        on the loaded parts. Discs and sleeves are loaded by the inner part, which touches them on the side towards
        which the force acts. A pin in its socket is itself the loaded part, and touches the socket on the opposite
        side.
        """
        points = np.empty_like(direction)
        for row, (name, kind) in enumerate(kind_by_pair.items()):
            index = names.number_of(name) - 1
            centre = self.others[kind][:, names.disc_of(name), index] if kind in self.others else self.ring[:, index]
            points[:, row] = centre + self.radii[kind] * direction[:, row]
        return points


def _logged_inner_parts(reducer: Reducer, poses_by_part: Mapping[str, Array]) -> _InnerParts:
    """Return centres and radii of the inner parts of all mating pairs (pins, cams, needles) at the poses of a log.

    `poses_by_part` has the poses of each part by its name at n samples of the log: x [m], y [m] and angle [rad], shape
    (n, 3).
    """
    nominal_centres = ring_places(reducer)
    ring_centres = transform(poses_by_part[names.HOUSING][:, np.newaxis], nominal_centres)
    if names.pin(1) in poses_by_part:
        ring_centres = np.stack(
            [poses_by_part[names.pin(number)][:, :2] for number in range(1, len(nominal_centres) + 1)], axis=1
        )
    if isinstance(reducer, RvReducer):
        return _rv_inner_parts(reducer, poses_by_part, ring_centres)
    output_pin_centres = transform(poses_by_part[names.OUTPUT][:, np.newaxis], output_centres(reducer))
    return _central_inner_parts(
        ring_centres, cams(reducer, poses_by_part[names.SHAFT]), output_pin_centres, drawn_radii(reducer)
    )


def _inner_parts_of_drawing(reducer: Reducer, drawing: Drawing | RvDrawing) -> _InnerParts:
    """Return centres and radii of the inner parts of all mating pairs (pins, cams or eccentrics) as they are drawn."""
    if isinstance(drawing, RvDrawing):
        return _drawn_rv_parts(cast(RvReducer, reducer), drawing)
    return _central_inner_parts(drawing.ring, cams(reducer, drawing.shaft), drawing.output_pins, drawing.radii)


def _central_inner_parts(
    ring_centres: Array, cam_centres: Array, output_pin_centres: Array, radii: Radii
) -> _InnerParts:
    """Return centres and radii of the inner parts of all mating pairs (pins, cams) with a central crank.

    `ring_centres` (n, N, 2), `cam_centres` (n, D, 2) and `output_pin_centres` (n, k, 2) are the centres of N ring pins,
    D cams and k output pins at n samples [m].
    """
    sample_count, disc_count, _ = cam_centres.shape
    centres_by_disc = np.broadcast_to(
        output_pin_centres[:, np.newaxis], (sample_count, disc_count, *output_pin_centres.shape[1:])
    )
    centres_by_kind = {"cam": cam_centres[:, :, np.newaxis], "output": centres_by_disc}
    return _InnerParts(
        ring_centres,
        centres_by_kind,
        _ring_radii(radii.pin, radii.sleeve_bore) | {"cam": radii.cam, "output": radii.output_pin},
    )


def _rv_inner_parts(reducer: RvReducer, poses_by_part: Mapping[str, Array], ring_centres: Array) -> _InnerParts:
    """Return centres and radii of the inner parts of all mating pairs (pins, needles) of an RV reducer.

    `poses_by_part` has the poses of each part by its name at n samples, shape (n, 3), and `ring_centres` (n, N, 2) the
    centres of the N ring pins [m]. The force of a planet acts at the pitch point on the line to the sun.
    """
    cranks, ring_design = crank_names(reducer), reducer.design.ring
    crank_poses = np.stack([poses_by_part[name] for name in cranks], axis=1)
    eccentric_centres_by_disc = [
        reducer.mechanism.mating(names.CRANK_BEARING, disc).by.position for disc in range(reducer.design.gear.discs)
    ]
    eccentrics = np.stack(
        [transform(crank_poses, eccentric_centres) for eccentric_centres in eccentric_centres_by_disc], axis=1
    )
    pitch_points = _pitch_points(reducer, poses_by_part[names.SUN], crank_poses)
    needle_radius = reducer.needle_circle_radius + reducer.cranks.needle_radius
    radii = _ring_radii(ring_design.pin_radius, ring_design.sleeve_bore_radius)
    return _InnerParts(
        ring_centres,
        {names.CRANK_BEARING: eccentrics, names.PLANET_MESH: pitch_points[:, np.newaxis]},
        radii | {names.CRANK_BEARING: needle_radius, names.PLANET_MESH: 0.0},
    )


def _pitch_points(reducer: RvReducer, sun_poses: Array, crank_poses: Array) -> Array:
    """Return the pitch points of the planets [m], shape (n, k, 2), at poses of sun (n, 3) and cranks (n, k, 3)."""
    planet, sun_centre = reducer.planet, sun_poses[:, np.newaxis, :2]
    return sun_centre + planet.sun_teeth / (planet.sun_teeth + planet.planet_teeth) * (
        crank_poses[..., :2] - sun_centre
    )


def _drawn_rv_parts(reducer: RvReducer, drawing: RvDrawing) -> _InnerParts:
    """Return centres and radii of the inner parts of all mating pairs (pins, needles) of an RV reducer as drawn.

    `drawing` has the poses of the drawn parts, of one disc only. The pairs of all discs have the positions of those of
    the drawn disc.
    """
    eccentrics = np.repeat(drawing.eccentrics[:, np.newaxis], reducer.design.gear.discs, axis=1)
    pitch_points = _pitch_points(reducer, drawing.sun, drawing.cranks)
    radii = _ring_radii(drawing.radii.pin, drawing.radii.sleeve_bore)
    return _InnerParts(
        drawing.ring,
        {names.CRANK_BEARING: eccentrics, names.PLANET_MESH: pitch_points[:, np.newaxis]},
        radii | {names.CRANK_BEARING: drawing.eccentric_radius, names.PLANET_MESH: 0.0},
    )


def _ring_radii(pin_radius: float, sleeve_bore_radius: float) -> dict[str, float]:
    return {"pin_gear": pin_radius, "tooth": pin_radius, "pin_socket": -pin_radius, "pin_sleeve": sleeve_bore_radius}


def cams(reducer: Reducer, shaft: Array) -> Array:
    """Compute the centres of all cams [m], shape (n, D, 2), of a crank in the poses (n, 3)."""
    return transform(shaft[:, np.newaxis], gear_centre(reducer.tooth_profile, np.array(reducer.phases)))


def _direction(force: Array) -> Array:
    """Return unit vectors (..., 2); zero for zero forces."""
    magnitude = np.linalg.norm(force, axis=-1, keepdims=True)
    return np.divide(force, magnitude, out=np.zeros_like(force), where=magnitude > 0)


def _shift_to_action_line(wrench: Array, direction: Array, arm: Array) -> Array:
    """Compute the shift (..., 2) [m] that moves a point onto the line of action of a force.

    `wrench` (..., 3) is force x, y [N] and moment about the origin [N m], `direction` (..., 2) the unit vector of the
    force, and `arm` (..., 2) [m] the vector from the origin to the point. The shift is limited to `ARROWS.max_shift`,
    because the moment of a force near zero, or of two contacts, does not determine a point.
    """
    force_size = np.linalg.norm(wrench[..., :2], axis=-1)
    lever = np.divide(wrench[..., 2], force_size, out=np.zeros_like(force_size), where=force_size > 0)
    distance = cross(arm, direction) - lever
    normal = np.stack([-direction[..., 1], direction[..., 0]], axis=-1)
    return np.clip(distance, -ARROWS.max_shift, ARROWS.max_shift)[..., np.newaxis] * normal
