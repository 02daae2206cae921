"""Exact geometry of displaced parts with any number of discs: gaps by search along the curves, and spring forces.

The reference for ``reducer``; it takes from there only the meaning of the unknowns and the contact stiffness.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import RunError
from cycloid_mj.design import Design
from cycloid_mj.geometry import kinematics, profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate.gaps import GearPose, design_flanks, pin_gaps, rotate

_DIFFERENCE_STEP = 1e-8
"""Step of finite differences [m]."""


def pose_of(reducer: Reducer, crank: float, unknowns: Array, disc: int = 0) -> GearPose:
    """Return the pose of the teeth of a disc at displacements z [m]; disc d of D is d/D of a turn ahead."""
    gear, crank_angle = reducer.tooth_profile, crank + phase_of(reducer, disc)
    x, y, arc = unknowns[3 * disc : 3 * disc + 3]
    angle = float(kinematics.gear_rotation(gear, crank_angle)) + arc / reducer.design.output.pin_circle_radius
    return GearPose(kinematics.gear_centre(gear, crank_angle) + np.array([x, y]), angle)


def phase_of(reducer: Reducer, disc: int) -> float:
    """Compute the angle of the eccentric of a disc from that of the first disc [rad]."""
    return 2.0 * np.pi * disc / reducer.design.gear.discs


def in_ring_frame(
    reducer: Reducer, crank_angle: float, shifts: Array, rotations: Array, output_turn: float
) -> tuple[float, Array]:
    """Transform a pose of D discs and the output from the fixed frame to the frame of the ring, which may turn.

    Parameters
    ----------
    crank_angle
        Crank angle in the fixed frame [rad].
    shifts
        Displacement of each disc from its ideal pose along the axes of the ring [m], shape (D, 2); it is returned
        unchanged.
    rotations
        Rotation of each disc from its ideal angle in the fixed frame [rad], shape (D,).
    output_turn
        Rotation of the output (carrier or ring) from its ideal angle in the fixed frame [rad].

    Returns
    -------
    relative_angle, z
        Crank angle relative to the ring [rad], and the pose as in ``reducer.gaps`` [m], shape (3 D + 1,): x, y and
        rotation of each disc, then rotation of the output. Rotations are multiplied by the radius of the circle of
        output pins.
    """
    design = reducer.design
    ring_angle, carrier_angle = (
        float(reducer.member.ring_angle(crank_angle)),
        float(reducer.member.gear_angle(crank_angle)),
    )
    disc_angles = carrier_angle + rotations
    ring_turn, carrier_turn = reducer.member.ring_and_carrier(output_turn)
    ring_angle, carrier_angle = ring_angle + float(ring_turn), carrier_angle + float(carrier_turn)
    relative_angle = crank_angle - ring_angle
    ideal_angle = float(kinematics.gear_rotation(reducer.tooth_profile, relative_angle))
    arc_lengths = design.output.pin_circle_radius * (np.append(disc_angles, carrier_angle) - ring_angle - ideal_angle)
    return relative_angle, np.append(np.column_stack([shifts, arc_lengths[:-1]]), arc_lengths[-1])


def exact_gaps(reducer: Reducer, crank: float, z: Array, pin_shift: Array | float = 0.0) -> Array:
    """Compute the gaps of teeth, disc after disc, then of output pins [m] at the unknowns z [m], on exact curves.

    All pins are shifted by `pin_shift` [m]. The play of a pin in its socket is not part of its gap.
    """
    return exact_contacts(reducer, crank, z, pin_shift)[0]


def exact_contacts(reducer: Reducer, crank: float, z: Array, pin_shift: Array | float = 0.0) -> tuple[Array, Array]:
    """Compute the gaps of `exact_gaps` [m], shape (n,), and their gradients [1], shape (n, u)."""
    discs, functions = range(reducer.design.gear.discs), (partial(_tooth_contacts, pin_shift=pin_shift), _hole_contacts)
    contacts = [function(reducer, crank, z, disc) for function in functions for disc in discs]
    return np.concatenate([gaps for gaps, _ in contacts]), np.concatenate([slopes for _, slopes in contacts])


def _tooth_contacts(
    reducer: Reducer, crank_angle: float, z: Array, disc: int, pin_shift: Array | float = 0.0
) -> tuple[Array, Array]:
    """Compute the gaps of the N ring pins or lobe arcs to a disc, and their gradients by the unknowns.

    Parameters
    ----------
    crank_angle, z
        Crank angle relative to the ring [rad], and pose [m] by u unknowns: x, y and rotation of each disc, then the
        rotation of the output. Rotations are arc lengths at the radius of the circle of output pins.
    disc
        Index of the disc.
    pin_shift
        Displacement of the pins [m], shape (N, 2) or (2,).

    Returns
    -------
    tuple of Array
        Gaps [m], shape (N,), and gradients [1], shape (N, u).
    """
    gear, errors, pose = reducer.tooth_profile, reducer.deviations, pose_of(reducer, crank_angle, z, disc)
    pin_centres = gear.pin_circle_radius * profile.unit(profile.pin_angles(gear)) + errors.pin_displacement + pin_shift
    nearest_points = pin_gaps(gear, pose, pin_centres, design_flanks(reducer))
    offset = reducer.profile_offset - errors.disc_radius[disc] - gear.pin_radius - errors.pin_radius
    gradients = np.zeros((nearest_points.distance.size, z.size))
    gradients[:, 3 * disc : 3 * disc + 2] = -nearest_points.normals
    gradients[:, 3 * disc + 2] = (
        -_moment(nearest_points.places - pose.centre, nearest_points.normals) / reducer.design.output.pin_circle_radius
    )
    return nearest_points.distance + offset, gradients


def _hole_contacts(reducer: Reducer, crank_angle: float, z: Array, disc: int) -> tuple[Array, Array]:
    """Compute the gaps of the n output pins in the holes of a disc, and their gradients by the unknowns.

    Parameters
    ----------
    crank_angle, z
        Crank angle relative to the ring [rad], and pose [m] by u unknowns: x, y and rotation of each disc, then the
        rotation of the output. Rotations are arc lengths at the radius of the circle of output pins.
    disc
        Index of the disc.

    Returns
    -------
    tuple of Array
        Gaps [m], shape (n,), and gradients [1], shape (n, u).
    """
    output, ideal_angle = reducer.design.output, float(kinematics.gear_rotation(reducer.tooth_profile, crank_angle))
    ideal_positions = output.pin_circle_radius * profile.unit(2.0 * np.pi * np.arange(output.pins) / output.pins)
    disc_angle, output_angle = (ideal_angle + float(arc) / output.pin_circle_radius for arc in (z[3 * disc + 2], z[-1]))
    hole_centres, pin_centres = (
        rotate(ideal_positions + reducer.deviations.hole_displacement[disc], disc_angle),
        rotate(ideal_positions, output_angle),
    )
    centre_distances = pin_centres - hole_centres - pose_of(reducer, crank_angle, z, disc).centre
    distance = np.linalg.norm(centre_distances, axis=1)
    normals, gradients = centre_distances / distance[:, np.newaxis], np.zeros((output.pins, z.size))
    gradients[:, 3 * disc : 3 * disc + 2] = normals
    gradients[:, 3 * disc + 2] = _moment(hole_centres, normals) / output.pin_circle_radius
    gradients[:, -1] = -_moment(pin_centres, normals) / output.pin_circle_radius
    return output.hole_radius + reducer.design.clearance.output - output.pin_radius - distance, gradients


def _moment(arms: Array, forces: Array) -> Array:
    """Compute the moments of forces (n, 2) at arms (n, 2), counter-clockwise."""
    return np.asarray(arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0])


def cam_offsets(reducer: Reducer, crank: float, z: Array) -> Array:
    """Compute the offset of the centre of each of D discs from that of its cam [m], (D, 2), in the frame of the ring.

    `crank` is the crank angle relative to the ring [rad]. `z` is the pose [m]: x, y and rotation of each disc, then the
    rotation of the output; rotations are multiplied by the radius of the circle of output pins.
    """
    design = reducer.design
    errors, offsets = reducer.deviations, []
    for disc in range(design.gear.discs):
        direction = (
            kinematics.gear_centre(reducer.tooth_profile, crank + phase_of(reducer, disc)) / design.gear.eccentricity
        )
        offsets.append(
            z[3 * disc : 3 * disc + 2] - errors.eccentricity * direction - rotate(errors.cam_displacement[disc], crank)
        )
    return np.array(offsets)


@dataclass(frozen=True)
class DisplacedSprings:
    """Springs on exact gaps at one crank angle, without friction."""

    design: Design
    """The design, in the frame of its ring."""
    crank: float
    """Crank angle relative to the ring [rad]."""
    stiffness: Array
    """Stiffness of the contacts [N/m], shape (n,), in the order of `exact_gaps`."""
    cam_stiffness: float
    """Stiffness of each cam [N/m]."""
    play: Array
    """Free travel of each contact [m], shape (n,)."""
    bending: Array
    """Compliance of the output pins under a force at each disc, along these forces [m/N], shape (D, D); the diagonal is
    part of `stiffness` and is 0 here."""

    def contacts(self, unknowns: Array) -> tuple[Array, Array]:
        """Compute the gaps of n contacts and D cams from the exact curves, and the gradients of the gaps.

        The pose `unknowns`, u in number [m], has x, y and rotation of each disc, then the rotation of the output.
        Rotations are arc lengths at the radius of the circle of output pins. The gaps include the free travel of ring
        pins. Gradients are those by the unknowns.

        Returns
        -------
        tuple of Array
            Gaps [m], shape (n + D,), and gradients [1], shape (n + D, u).
        """
        gaps, slopes = exact_contacts(Reducer(self.design), self.crank, unknowns)
        offsets = cam_offsets(Reducer(self.design), self.crank, unknowns)
        cam_distances, cam_gradients = np.linalg.norm(offsets, axis=1), np.zeros((len(offsets), unknowns.size))
        for disc, offset in enumerate(offsets):
            cam_gradients[disc, 3 * disc : 3 * disc + 2] = -offset / (cam_distances[disc] or 1.0)
        cam_gaps = self.design.clearance.cam - cam_distances
        return np.concatenate([gaps + self.play, cam_gaps]), np.concatenate([slopes, cam_gradients])

    def gaps(self, z: Array) -> Array:
        """Compute the gaps of contacts, then of cams [m], shape (n + D,)."""
        return self.contacts(z)[0]

    def forces(self, z: Array) -> Array:
        """Compute the forces of contacts, then of cams [N], shape (n + D,)."""
        return self._contact_forces(self.gaps(z))

    def _contact_forces(self, gaps: Array) -> Array:
        """Compute the forces of n contacts and D cams [N], shape (n + D,), including the effect of bent output pins.

        `gaps` [m], shape (n + D,), are those of the contacts, then of the cams; for output pins, the gaps before
        bending.
        """
        disc_count = self.design.gear.discs
        forces = -np.append(self.stiffness, [self.cam_stiffness] * disc_count) * np.minimum(gaps, 0.0)
        if self.bending.any():
            pin_count = self.design.output.pins
            first_row = self.stiffness.size - disc_count * pin_count
            for pin in range(pin_count):
                rows = first_row + pin + pin_count * np.arange(disc_count)
                forces[rows] = _pin_forces(gaps[rows], np.diag(1.0 / self.stiffness[rows]) + self.bending)
        return forces

    def energy(self, z: Array) -> float:
        """Compute the energy of contacts, cams and bent pins [J]: half the sum of force times penetration."""
        gaps = self.gaps(z)
        return float(-0.5 * self._contact_forces(gaps) @ gaps)

    def generalised_force(self, z: Array) -> Array:
        """Compute the forces of all springs along the u unknown displacements `z` [N], shape (u,)."""
        gaps, slopes = self.contacts(z)
        return np.asarray(slopes.T @ self._contact_forces(gaps))

    def solve_equilibrium(self, load: Array, start: Array) -> Array:
        """Solve for static equilibrium of contact springs by modified Newton steps; return the pose (u,) [m].

        The gaps are nonlinear functions of the u unknowns, not linearised. The pose has x, y and rotation of each disc,
        then the rotation of the output. Rotations are arc lengths at the radius of the circle of output pins. `load`
        (u,) [N] is the generalised force on each unknown. `start` (u,) [m] is a pose near the solution. All steps use
        the stiffness matrix at this pose, which is computed by finite differences.

        Raises
        ------
        RunError
            The steps do not converge.
        """
        pose, start_force = start, self.generalised_force(start)
        stiffness_matrix = np.stack(
            [
                (start_force - self.generalised_force(start + shift)) / _DIFFERENCE_STEP
                for shift in _DIFFERENCE_STEP * np.eye(pose.size)
            ],
            axis=1,
        )
        tolerance = 1e-6 * np.abs(load).max()
        for _ in range(30):
            residual = load + self.generalised_force(pose)
            if np.abs(residual).max() < tolerance:
                return pose
            pose = pose + np.linalg.solve(stiffness_matrix, residual)
        raise RunError(
            "the reference solution (gaps measured between the displaced curves of the parts) does not converge: the "
            f"residual force is {np.abs(residual).max():.3g} N, but at most {tolerance:.3g} N is allowed. Reduce the "
            "load or the clearances of the design"
        )


def _pin_forces(gaps: Array, compliance: Array) -> Array:
    """Solve for the forces of D discs on one bent output pin [N], from the gaps of the unbent pin [m], shape (D,) each.

    The forces solve the linear complementarity problem with the `compliance` (D, D) [m/N]: a closed contact has a force
    >= 0, an open contact has a gap >= 0. All combinations of closed contacts are tried. Raises RunError if there is no
    solution.
    """
    disc_count = gaps.size
    for closed_bits in range(2**disc_count):
        is_closed: Mask = np.array([bool(closed_bits >> disc & 1) for disc in range(disc_count)])
        forces = np.zeros(disc_count)
        forces[is_closed] = np.linalg.solve(compliance[np.ix_(is_closed, is_closed)], -gaps[is_closed])
        bent_gaps = gaps + compliance @ forces
        if np.all(forces >= 0.0) and np.all(bent_gaps[~is_closed] >= 0.0):
            return forces
    raise RunError(
        "cannot compute the forces of the discs on a bending output pin: the pin's compliance matrix is not positive "
        "definite. Check output.pin_radius_mm, output.core_radius_mm, gear.face_width_mm and gear.disc_gap_mm"
    )


def slip_force(force: Array, displacement: Array, limit: Array, stiffness: npt.ArrayLike) -> Array:
    """Compute the force [N] after a `displacement` [m] of springs that slip at the forces +-`limit` [N].

    `force` is the force before the displacement [N], `stiffness` the stiffness of the springs [N/m].
    """
    return np.clip(force + np.asarray(stiffness) * displacement, -limit, limit)
