"""Statics of an RV reducer in closed form: crank forces under ideal load sharing, stiffness, and the error map.

Ideal means rigid parts, equally stiff contacts of each kind, no clearance and no friction. Angles as in `kinematics`:
the crank angle psi is counter-clockwise against the ring, the eccentrics of disc 1 and crank 1 are on +y at 0, and
cranks count clockwise. Load torques act counter-clockwise on the carrier, and oppose cranks that turn
counter-clockwise.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array, cross, quarter_turned
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.ideal_loads import ideal_load_sharing
from cycloid_mj.geometry.profile import CycloidGear

ROLLER_EXPONENT = 10.0 / 3.0
"""Exponent of load and life of roller bearings (ISO 281)."""


@dataclass(frozen=True)
class RvStage:
    """Second stage of an RV reducer: D discs on n cranks.

    Attributes
    ----------
    gear
        Ideal mesh of a disc with the ring.
    phases
        Phase of each disc on the cranks [rad], shape (D,).
    cranks, radius
        n, and radius of the circle of crank axes [m].
    to_carrier
        Turns of the sun per turn of the carrier, both against the ring: R.
    turn_ratio
        1 + z_s/z_p: turn of a crank per turn of the carrier at a fixed sun, both against the ring.
    """

    gear: CycloidGear
    phases: tuple[float, ...]
    cranks: int
    radius: float
    to_carrier: float
    turn_ratio: float

    def crank_positions(self, crank: npt.ArrayLike) -> Array:
        """Return the vectors from the carrier's axis to the crank axes [m], shape (m, n, 2), at crank angles (m,)."""
        turned = np.asarray(crank, dtype=np.float64)[:, np.newaxis] / self.gear.lobes
        return np.asarray(self.radius * profile.unit(2.0 * np.pi * np.arange(self.cranks) / self.cranks + turned))

    def eccentrics(self, crank: npt.ArrayLike) -> Array:
        """Return the unit vectors of the eccentrics of each disc [1], shape (m, D, 2), at crank angles (m,) [rad]."""
        return profile.unit(-(np.asarray(crank, dtype=np.float64)[:, np.newaxis] + np.array(self.phases)))

    @property
    def speed_up(self) -> float:
        """Lobes + 1 + z_s/z_p: crank turn against the carrier, at a fixed sun, per turn of the carrier."""
        return self.gear.lobes + self.turn_ratio


@dataclass(frozen=True)
class IdealRvLoads:
    """Forces on D discs of n cranks at m crank angles.

    Attributes
    ----------
    pins, resultant
        Force of each pin on each disc [N], shape (m, D, N), and their vector sum on each disc, shape (m, D, 2).
    cranks
        Force of each crank on each disc [N], shape (m, D, n, 2).
    crank_torques
        Torque of the discs on each crank [N m], counter-clockwise, shape (m, n).
    """

    pins: Array
    resultant: Array
    cranks: Array
    crank_torques: Array

    @property
    def bearings(self) -> Array:
        """Force on the bearing of each crank in each disc [N], shape (m, D, n)."""
        return np.linalg.norm(self.cranks, axis=-1)


def ideal_rv_loads(
    stage: RvStage, torque: float, crank_angles: npt.ArrayLike, floating_sun: bool = False
) -> IdealRvLoads:
    """Compute the ideal forces in an RV reducer under a torque on the carrier [N m] at m crank angles [rad].

    The result has the forces of pins and cranks on the discs, and the torques on the cranks. `stage` has the geometry;
    the angles have the shape (m,). The torque on the ring, T (R - 1)/R with the ratio R =
    `RvStage.to_carrier`, is shared equally by the discs, and by the pins of each disc as in `ideal_loads.share_load`.
    The crank bearings are equally stiff: their forces are the least-squares forces in equilibrium with the pins on each
    disc. With a floating sun, the cranks also have equal torques.
    """
    crank_angles = np.ravel(np.asarray(crank_angles, dtype=np.float64))
    discs, lobes = len(stage.phases), stage.gear.lobes
    ring_torque = torque * (stage.to_carrier - 1.0) / stage.to_carrier
    disc_torque = ring_torque / discs * lobes / stage.gear.ring_teeth
    pin_forces, disc_forces = [], []
    for phase in stage.phases:
        mesh = ideal_load_sharing(stage.gear, disc_torque, crank_angles + phase)
        angle = crank_angles + phase
        radial_direction, forward_direction = profile.unit(-angle), -np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        reaction = (
            mesh.eccentric_radial[:, np.newaxis] * radial_direction
            + mesh.eccentric_tangential[:, np.newaxis] * forward_direction
        )
        pin_forces.append(mesh.forces)
        disc_forces.append(-reaction)
    disc_force = np.stack(disc_forces, axis=1)
    crank_forces = _crank_forces(stage, crank_angles, disc_force, -disc_torque, floating_sun)
    crank_torques = stage.gear.eccentricity * cross(
        stage.eccentrics(crank_angles)[:, :, np.newaxis], -crank_forces
    ).sum(axis=1)
    return IdealRvLoads(np.stack(pin_forces, axis=1), disc_force, crank_forces, crank_torques)


def _crank_forces(
    stage: RvStage, crank_angles: Array, disc_force: Array, disc_torque: float, floating_sun: bool
) -> Array:
    """Compute least-squares forces (m, D, n, 2) [N] of n cranks on D discs in equilibrium with the load on each disc.

    Parameters
    ----------
    stage, crank_angles
        Geometry of the stage, and m crank angles [rad], shape (m,).
    disc_force, disc_torque
        Force (m, D, 2) [N] and torque [N m] on the centre of each disc.
    floating_sun
        Whether the cranks also have equal torques.
    """
    crank_centres, eccentrics = stage.crank_positions(crank_angles), stage.eccentrics(crank_angles)
    (angle_count, discs, _), cranks = disc_force.shape, stage.cranks
    equations = 3 * discs + (cranks - 1) * floating_sun
    matrix, right_side = np.zeros((angle_count, equations, discs, cranks, 2)), np.zeros((angle_count, equations))
    for disc in range(discs):
        matrix[:, 3 * disc, disc, :, 0] = matrix[:, 3 * disc + 1, disc, :, 1] = 1.0
        matrix[:, 3 * disc + 2, disc] = quarter_turned(crank_centres) / stage.radius
        right_side[:, 3 * disc : 3 * disc + 2] = -disc_force[:, disc]
        right_side[:, 3 * disc + 2] = -disc_torque / stage.radius
    for equation, other_crank in enumerate(range(1, cranks) if floating_sun else (), start=3 * discs):
        matrix[:, equation, :, 0] = quarter_turned(eccentrics)
        matrix[:, equation, :, other_crank] = -quarter_turned(eccentrics)
    flat_matrix = matrix.reshape(angle_count, equations, -1)
    return (np.linalg.pinv(flat_matrix) @ right_side[..., np.newaxis]).reshape(angle_count, discs, cranks, 2)


def mean_force(forces: Array) -> float:
    """Compute the mean of forces [N] by the exponent of roller bearings: (mean F^(10/3))^(3/10)."""
    return float(np.mean(np.asarray(forces) ** ROLLER_EXPONENT) ** (1.0 / ROLLER_EXPONENT))


def closed_form_stiffness(stage: RvStage, bearing_stiffness: float, tooth_stiffness: float) -> float:
    """Compute the torsional stiffness [N m/rad] of the carrier against the ring in closed form, sun and ring fixed.

    Its inverse is the sum of four compliances: that of the teeth, and those of the crank bearings for the rotation of
    the discs, for forces tangential to the eccentric, and for forces radial to it. The compliance of n equal contact
    springs is n f^2/k, with the stiffness k and the force f of a spring per unit torque.

    Parameters
    ----------
    stage
        The stage.
    bearing_stiffness
        Stiffness of the bearings of a crank under the force of one disc, needles and taper in series [N/m].
    tooth_stiffness
        Stiffness of a pin on a disc [N/m].
    """
    crank_angles = np.linspace(0.0, 2.0 * np.pi / stage.gear.ring_teeth, 16, endpoint=False)
    discs, bearing_count = len(stage.phases), len(stage.phases) * stage.cranks
    disc_torque, orbit_arm = stage.gear.lobes / stage.speed_up, stage.gear.eccentricity * stage.speed_up
    sharing = ideal_load_sharing(stage.gear, 1.0, crank_angles)
    squared_arms = np.mean(np.sum(np.where(sharing.forces > 0.0, sharing.arms, 0.0) ** 2, axis=-1))
    radial_force = float(np.mean(np.abs(sharing.eccentric_radial))) * disc_torque / discs
    compliance = (
        disc_torque**2 / (bearing_count * stage.radius**2 * bearing_stiffness)
        + 1.0 / (orbit_arm**2 * bearing_count * bearing_stiffness)
        + disc_torque**2 / (discs * tooth_stiffness * squared_arms)
        + discs * radial_force**2 / (stage.cranks * bearing_stiffness)
    )
    return float(1.0 / compliance)


def closed_form_error(stage: RvStage, crank_angles: npt.ArrayLike, phase_error: Array, misfit: Array) -> Array:
    """Compute the error of the carrier's angle [rad] at m crank angles in closed form, without clearance, (m,).

    Parameters
    ----------
    stage
        The stage.
    crank_angles
        The m crank angles [rad], shape (m,).
    phase_error
        Error of the angle of each of n cranks [rad], shape (m, n).
    misfit
        Displacement of each eccentric from its bore [m], shape (m, D, n, 2), for D discs and n cranks.

    Notes
    -----
    Yang et al. 2021, equation (30), for any errors: -(epsilon + m_t/e + z_c rho)/(z_c + 1 + z_s/z_p), as the mean of
    the discs. epsilon is the mean phase error of the cranks, m_t the mean component of `misfit` perpendicular to the
    eccentricity e, and rho the rotation of the disc that fits the misfits best (least squares). z_c is the number of
    lobes of a disc, z_s and z_p are the numbers of teeth of sun and planet.

    A crank with the phase error epsilon_i displaces its eccentrics by e epsilon_i along their orbit. If the cranks
    differ, this also rotates the discs, so rho includes these displacements. With discs at evenly spaced phases, the
    rotations cancel, and the equation is that of the reference. A single disc requires a fixed sun, because a floating
    sun changes the differences of the crank angles.
    """
    crank_angles = np.ravel(np.asarray(crank_angles, dtype=np.float64))
    perpendicular = quarter_turned(stage.eccentrics(crank_angles))
    tangential_shift = np.einsum("mdnj,mdj->md", misfit, perpendicular) / stage.cranks
    along_orbits = stage.gear.eccentricity * phase_error[:, np.newaxis, :, np.newaxis] * perpendicular[:, :, np.newaxis]
    displacements = misfit + along_orbits
    disc_rotation = np.einsum("mdnj,mnj->md", displacements, quarter_turned(stage.crank_positions(crank_angles)))
    disc_rotation /= stage.cranks * stage.radius**2
    disc_errors = tangential_shift / stage.gear.eccentricity + stage.gear.lobes * disc_rotation
    return -(phase_error.mean(axis=1) + disc_errors.mean(axis=1)) / stage.speed_up
