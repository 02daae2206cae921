"""Contact springs of a reducer: gaps, gradients, stiffness and friction of every contact at many crank angles."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.geometry import kinematics
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.contact import tooth_stiffness
from cycloid_mj.reducer.gaps import Gaps, arc_gaps, cam_displacements, ideal_motion
from cycloid_mj.statics import kernel
from cycloid_mj.statics.film import FilmContacts, FilmFriction, build_film_contacts
from cycloid_mj.statics.friction import compute_friction_per_force

POSES = 61
"""Default number of crank angles over a turn (heuristic)."""


_SAME_IN_GAPS = ("disc", "distance", "slope", "shift", "shift_slope", "curvature", "curvature_rate", "phase")
"""Attributes that the springs of the kernel have from `Gaps`."""


@dataclass(frozen=True)
class Springs:
    """Contact springs of a reducer at m crank angles, on the unknowns of ``reducer.gaps``.

    The flanks of an internal gear touch only next to an arc, as a single patch, and are left out: their effect on the
    rotation of the output is below 1e-5 of that of the load.

    Attributes
    ----------
    crank
        Crank angles in the frame of the ring [rad], shape (m,).
    teeth
        Number of contact lines with the ring, which precede the output pins.
    contacts
        Springs of the contact lines and output pins, n at each angle, and of the cams.
    curvature
        Relative curvature of the contact lines with the ring [1/m], shape (m, teeth).
    body_force
        Weight and centrifugal force of each disc [N], shape (m, D, 2).
    slip
        Sliding speed of the disc at each contact line and output pin [m/s], shape (m, n).
    film, friction
        Contacts of the film law, and their friction in `contacts`; None with the law ``coulomb`` or without friction.
    """

    crank: Array
    teeth: int
    contacts: kernel.KernelSprings
    curvature: Array
    body_force: Array
    slip: Array
    film: FilmContacts | None = None
    friction: FilmFriction | None = None

    def with_friction(self, friction: FilmFriction) -> "Springs":
        """Return a copy of the contact springs with the friction coefficients `friction`; requires the law ``film``."""
        assert self.film is not None
        friction_per_force = friction.contacts[..., np.newaxis] * self.film.unit_friction_per_force
        speed = self.film.surfaces.reducer.design.drive.speed
        contacts = _with_cam_friction(
            self.contacts._replace(friction_per_force=friction_per_force),
            self.film.surfaces.reducer,
            math.copysign(friction.cam, speed),
        )
        return replace(self, contacts=contacts, friction=friction)

    @property
    def cam_normal_share(self) -> float:
        """Normal force of a cam over its total force [1], the cosine of the friction angle; 1 on rollers."""
        return 1.0 / math.hypot(1.0, self.contacts.cam_lateral)

    @property
    def directions(self) -> Array:
        """Direction of the normal force of each contact line and output pin on its disc, shape (m, n, 2)."""
        slope = self.contacts.slope
        return np.asarray(slope[..., :-1].reshape(*slope.shape[:2], -1, 3)[..., :2].sum(axis=2))

    def load(self, torque: float | Array) -> Array:
        """Return the generalised load on the unknowns [N]: a torque on the carrier, weight and centrifugal force.

        The shape is (m, 3 D + 1) at m crank angles; the unknowns are x, y and rotation of each of the D discs, then the
        rotation of the output. `torque` [N m] is a number, or has shape (m,).
        """
        load = np.zeros((self.crank.size, self.contacts.slope.shape[2]))
        for disc in range(self.body_force.shape[1]):
            load[:, 3 * disc : 3 * disc + 2] = self.body_force[:, disc]
        load[:, -1] = torque / self.contacts.radius
        return load


def turn_evenly(reducer: Reducer, poses: int = POSES) -> Array:
    """Return crank angles in order [rad], shape (poses,), that cover a turn and every mesh period evenly.

    They are multiples of the golden ratio of the turn, `Reducer.mesh_turn`.
    """
    golden_ratio = (math.sqrt(5.0) - 1.0) / 2.0
    return np.asarray(reducer.mesh_turn * np.sort(np.mod(golden_ratio * np.arange(poses), 1.0)))


def at_rest(reducer: Reducer) -> Reducer:
    """Return a reducer with a crank at rest and without weight, for `springs_of` without friction."""
    return reducer.but(drive={"speed": 0.0}, environment={"gravity_x": 0.0, "gravity_y": 0.0})


def springs_of(reducer: Reducer, crank: npt.ArrayLike | None = None, friction: bool = True) -> Springs:
    """Compute the contact springs of a design at m crank angles, with the stiffness at the rated load.

    Parameters
    ----------
    reducer
        Reducer of a valid design.
    crank
        Crank angles [rad], shape (m,); by default evenly over a turn.
    friction
        Whether contacts have friction; without it, the speed of the crank may be 0. With the law ``film``, this is the
        friction under the working forces; `balance.loads` replaces it by the friction under the actual forces.

    Raises
    ------
    ContactError
        The working force flattens a pin beyond the range of a line contact.
    """
    if crank is None:
        crank = turn_evenly(reducer)
    crank = np.ravel(np.asarray(crank, dtype=np.float64))
    disc_forces = np.stack([body_force(reducer, crank, phase) for phase in reducer.phases], axis=1)
    crank = reducer.member.against_ring(crank)
    speed, reducer = reducer.speed_against_ring, reducer.at_rated_load
    mesh_gaps, motion = arc_gaps(reducer, crank), ideal_motion(reducer, crank) * speed
    tooth_count = int(np.sum(mesh_gaps.kind == reducer.design.tooth_pair))
    contacts = _kernel_springs(reducer, mesh_gaps, tooth_count, cam_displacements(reducer, crank))
    film = (
        build_film_contacts(reducer, crank, mesh_gaps, tooth_count, motion)
        if friction and reducer.design.has_film
        else None
    )
    if friction and film is None:
        contacts = contacts._replace(friction_per_force=compute_friction_per_force(reducer, mesh_gaps, motion))
        contacts = _with_cam_friction(contacts, reducer, math.copysign(reducer.design.friction_of("cam"), speed))
    springs = Springs(
        crank=crank,
        teeth=tooth_count,
        contacts=contacts,
        curvature=mesh_gaps.relative_curvature[:, :tooth_count],
        body_force=disc_forces,
        slip=np.einsum("mnu,mu->mn", mesh_gaps.slip_slope, motion),
        film=film,
    )
    return springs if film is None else springs.with_friction(film.friction_at_working_forces())


def _with_cam_friction(contacts: kernel.KernelSprings, reducer: Reducer, coefficient: float) -> kernel.KernelSprings:
    """Return springs with the friction of the cams, whose coefficient [1] has the sign of the crank's rotation."""
    gear = reducer.design.gear
    return contacts._replace(
        cam_friction_per_force=coefficient * gear.bore_radius / contacts.radius,
        cam_lateral=coefficient if gear.bearing == "plain" else 0.0,
    )


def _kernel_springs(reducer: Reducer, mesh_gaps: Gaps, tooth_count: int, cam_positions: Array) -> kernel.KernelSprings:
    """Return the contact springs, including those of the cams, for the compiled kernel, without friction.

    `mesh_gaps` are the gaps at m crank angles, and `tooth_count` is the number of those with the ring.
    `cam_positions` [m], shape (m, D, 2), are the positions of the cams in D discs.
    """
    design, bending = reducer.design, _cross_compliances(reducer)
    pin_stiffness = np.repeat(np.array(reducer.contacts["output"].stiffness_by_disc), design.output.pins)
    output_stiffness = np.broadcast_to(pin_stiffness, (len(cam_positions), pin_stiffness.size))
    stiffness = tooth_stiffness(reducer, mesh_gaps.relative_curvature[:, :tooth_count])
    gap_attributes = {name: getattr(mesh_gaps, name) for name in _SAME_IN_GAPS}
    return kernel.KernelSprings(
        radius=design.output.pin_circle_radius,
        rotates=mesh_gaps.kind == design.tooth_pair,
        clearance=(mesh_gaps.clearance + mesh_gaps.play)[0],
        trochoid=(design.ring.pin_circle_radius, design.gear.eccentricity, float(design.ring.teeth)),
        stiffness=np.concatenate([stiffness, output_stiffness], axis=1),
        cam_position=cam_positions,
        cam_clearance=design.clearance.cam + (reducer.worn.cam if reducer.worn else 0.0),
        cam_stiffness=reducer.contacts["cam"].stiffness,
        friction_per_force=np.zeros((0, *mesh_gaps.slope.shape[1:])),
        cam_friction_per_force=0.0,
        cam_lateral=0.0,
        bending=bending,
        pins=design.output.pins if bending.any() else 0,
        **gap_attributes,
    )


def _cross_compliances(reducer: Reducer) -> Array:
    """Compute the deflection of an output pin at each disc per force of each other of D discs [m/N], shape (D, D).

    The diagonal is 0, as the deflection under a disc's own force is part of the contact's stiffness. Only the component
    of a deflection along the force of its disc counts: the forces of discs at phases b and b' include the angle b - b',
    so it is multiplied by cos(b - b'). The other component only moves the contact along its circle.
    """
    phases, flexibility = np.array(reducer.phases), reducer.contacts.pin_flexibility
    np.fill_diagonal(flexibility, 0.0)
    return flexibility * np.cos(np.subtract.outer(phases, phases))


def body_force(reducer: Reducer, crank_angle: Array, phase: float = 0.0) -> Array:
    """Compute weight and centrifugal force of a disc in the frame of the ring [N], shape (m, 2), at m crank angles.

    The mass is density times face width times `Reducer.disc_section`, without bearings.

    Parameters
    ----------
    reducer
        The reducer.
    crank_angle
        Crank angles [rad], shape (m,), not relative to a ring that rotates.
    phase
        Phase of the disc on the crank [rad].
    """
    design = reducer.design
    gx, gy, ring_angle = (
        design.environment.gravity_x,
        design.environment.gravity_y,
        reducer.member.ring_angle(crank_angle),
    )
    gravity = np.stack(
        [gx * np.cos(ring_angle) + gy * np.sin(ring_angle), gy * np.cos(ring_angle) - gx * np.sin(ring_angle)], axis=-1
    )
    centrifugal = design.drive.speed**2 * kinematics.gear_centre(
        reducer.tooth_profile, reducer.member.against_ring(crank_angle) + phase
    )
    return np.asarray(
        design.material_of("gear").density * design.gear.face_width * reducer.disc_section * (gravity + centrifugal)
    )
