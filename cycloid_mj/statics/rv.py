"""Static equilibrium of an RV reducer: discs on several cranks, their bearings, the pins, and the planet meshes.

The frame is that of the ring. The unknowns z [m] at a crank angle are the displacements x, y and R phi of each of the D
discs, R psi of the carrier, R chi of each of the n cranks, and x and y of the sun; R is the radius of the circle of
crank axes, rotations are counter-clockwise departures from the ideal motion. The sun does not turn, and
moves only if it floats. Pins are unilateral springs with the gaps of `reducer.gaps`, for curved flanks of discs that
turn. Planet teeth are unilateral springs, to first order in z. A crank bearing is a spring between two circles: needles
and taper in series, with the sum of their clearances. With ``contact.needles = "each"``, it is a unilateral spring for
each needle, with this clearance and a share of the taper's compliance. A semismooth Newton method with Armijo's
line search minimises the energy of all springs at all crank angles at once.

Weight and inertia are left out, and friction too, unless `RvFriction` is added.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array, Integers, quarter_turned, rotate
from cycloid_mj.base.errors import RunError
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.contact import tooth_stiffness
from cycloid_mj.reducer.gaps import ideal_motion, mesh_gaps
from cycloid_mj.reducer.rv_bodies import expanded, needle_directions, needle_share


@dataclass(frozen=True)
class RvNewtonSettings:
    """Settings of the semismooth Newton method (Nocedal & Wright, Numerical Optimization, algorithm 3.2)."""

    max_steps: int = 200
    rtol: float = 1e-9
    """Largest residual over the load."""
    armijo: float = 1e-4
    """Share of the predicted decrease of the energy that a step has to reach."""
    max_halvings: int = 40
    rounding: float = 2e-14
    """Rounding of energies and forces over their largest terms: that of sums of a hundred terms."""
    damping: float = 1e-9
    """Levenberg-Marquardt term over the largest stiffness, which keeps the tangent regular within clearances."""


NEWTON = RvNewtonSettings()


@dataclass(frozen=True)
class RvFrictionSettings:
    """Settings of the fixed-point iteration of the friction forces.

    For `rv80e`, each step changes the forces by 5 % of the change of the previous step. If a step changes them by more
    than the previous step, the step size is halved (under-relaxation): the friction of a film can depend so much on the
    sliding of a pin that full steps oscillate.
    """

    max_steps: int = 50
    rtol: float = 1e-6
    """Largest change of a friction force over the load."""


FRICTION = RvFrictionSettings()


@dataclass(frozen=True)
class RvSprings:
    """Springs of an RV reducer at m crank angles, on the u unknowns of the module's docstring.

    Attributes
    ----------
    crank
        Crank angles against the ring [rad], shape (m,).
    gap, slope, stiffness
        Gaps of pins and planet flanks at z = 0 [m] and their stiffness [N/m], shape (m, c), and their gradient [1],
        shape (m, c, u). The pins of all discs come first, then two flanks of each planet.
    pins
        Number of contacts with the ring.
    disc, shift, bend, twist, phase
        Attributes of the contacts with the ring as in `reducer.gaps.Gaps`: index of the disc, shape (pins,);
        displacement along the flank at z = 0 [m], `curvature` [1/m], `curvature_rate` [1/m2] and `phase` [rad], shape
        (m, pins).
    tooth_slope, shift_slope
        Gradients of gap and shift of these contacts by x, y and rotation of their disc [1], shape (m, pins, 3).
    curvature, slip
        Relative curvature of these [1/m], and sliding of the disc per turn of the crank against the ring [m/rad], shape
        (m, pins).
    offset, offset_slope
        Displacement of each crank from its bore at z = 0 [m], shape (m, D, n, 2), and its gradient [1], shape
        (m, D, n, 2, u).
    bearing_stiffness, bearing_clearance
        Stiffness [N/m] and clearance [m] of the bearings of a crank under one disc; a negative clearance is a preload.
    needles
        Directions of the separate needles of each eccentric [1], shape (m, Z, 2); Z is 0 for a lumped bearing.
    lever
        R [m].
    """

    crank: Array
    gap: Array
    slope: Array
    stiffness: Array
    pins: int
    disc: Integers
    shift: Array
    tooth_slope: Array
    shift_slope: Array
    bend: Array
    twist: Array
    phase: Array
    curvature: Array
    slip: Array
    offset: Array
    offset_slope: Array
    bearing_stiffness: float
    bearing_clearance: float
    needles: Array
    lever: float

    @property
    def discs(self) -> int:
        """Number of discs."""
        return self.offset.shape[1]

    @property
    def carrier(self) -> int:
        """Index of the carrier's unknown."""
        return 3 * self.discs

    @property
    def disc_unknowns(self) -> Integers:
        """Indices of the unknowns of the disc of each contact with the ring: x, y and rotation, shape (pins, 3)."""
        return np.asarray(3 * self.disc[:, np.newaxis] + np.arange(3))


@dataclass(frozen=True)
class RvCoefficients:
    """Friction of each kind of contact over its normal force.

    Attributes
    ----------
    teeth, planets
        Coefficients of cycloid teeth and of planet meshes [1].
    needles, tapers
        Friction torque over force of the bearings of a crank in a disc, and in the carrier under that force [m].
    """

    teeth: float
    planets: float
    needles: float
    tapers: float


class RunningFriction(Protocol):
    """Friction of cranks that turn against the load, under the forces of a solution."""

    def load(self, loads: "RvLoads") -> Array:
        """Return the generalised forces of friction [N], shape (m, u)."""

    def on_discs(self, loads: "RvLoads") -> tuple[Array, Array]:
        """Return the generalised friction per force of pins (m, pins, u) and of crank bearings (D, n, u) [1]."""


@dataclass(frozen=True)
class RvFriction:
    """Coulomb friction of cranks that turn against the load, as generalised forces on u unknowns per force [1].

    Attributes
    ----------
    teeth
        Per force of each contact line with the ring, shape (m, pins, u).
    bearings
        Per force of a crank on a disc, by needles and taper, shape (D, n, u).
    meshes
        Per force of each planet mesh, shape (n, u).
    """

    teeth: Array
    bearings: Array
    meshes: Array

    def load(self, loads: "RvLoads") -> Array:
        """Return the generalised forces of friction under the forces of a solution [N], shape (m, u)."""
        return self.generalised(loads.pins, loads.bearings, loads.meshes)

    def on_discs(self, loads: "RvLoads") -> tuple[Array, Array]:
        """Return the generalised friction per force of pins (m, pins, u) and of crank bearings (D, n, u) [1]."""
        return self.teeth, self.bearings

    def generalised(self, pins: Array, bearings: Array, meshes: Array) -> Array:
        """Return the friction forces along the u unknown displacements [N], shape (m, u), under contact forces [N]."""
        return np.asarray(
            np.einsum("mc,mcu->mu", pins, self.teeth)
            + np.einsum("mdn,dnu->mu", bearings, self.bearings)
            + np.einsum("mn,nu->mu", meshes, self.meshes)
        )


@dataclass(frozen=True)
class RvLoads:
    """Forces and displacements at m crank angles, in the frame of the ring.

    Attributes
    ----------
    pins
        Force of each contact line with the ring [N], shape (m, D lines).
    cranks
        Force of each crank on each disc [N], shape (m, D, n, 2).
    flanks
        Force of both flanks of each planet on the sun [N], shape (m, 2, n); the first carries a counter-clockwise load
        on the carrier.
    carrier_turn
        Rotation of the carrier from its ideal angle [rad], shape (m,).
    compliance
        Its derivative by the torque on the carrier [rad/(N m)], shape (m,).
    displacements
        Displacements z [m], shape (m, u).
    """

    pins: Array
    cranks: Array
    flanks: Array
    carrier_turn: Array
    compliance: Array
    displacements: Array

    @property
    def bearings(self) -> Array:
        """Force on the bearing of each crank in each disc [N], shape (m, D, n)."""
        return np.linalg.norm(self.cranks, axis=-1)

    @property
    def meshes(self) -> Array:
        """Total normal force of both flanks of each planet [N], shape (m, n)."""
        return np.asarray(self.flanks.sum(axis=1))


def compute_rv_springs(reducer: RvReducer, crank: npt.ArrayLike) -> RvSprings:
    """Compute the contact springs of an RV reducer at m crank angles against the ring [rad], shape (m,).

    Contact stiffnesses are valid at the rated load (`at_rated_load`).

    Raises
    ------
    ContactError
        The working force flattens a pin beyond the range of a line contact.
    """
    crank, reducer = np.ravel(np.asarray(crank, dtype=np.float64)), reducer.at_rated_load
    gaps = mesh_gaps(reducer, crank)
    flank_gap, flank_slope = _flank_gaps(reducer, crank)
    offset, offset_slope = _crank_offsets(reducer, crank)
    unknowns = offset_slope.shape[-1]
    stiffness = tooth_stiffness(reducer, gaps.relative_curvature)
    index, disc_unknowns = np.arange(gaps.disc.size)[:, np.newaxis], 3 * gaps.disc[:, np.newaxis] + np.arange(3)
    return RvSprings(
        crank=crank,
        gap=np.concatenate([gaps.width + gaps.play, flank_gap], axis=1),
        slope=np.concatenate([_pad_gradient(gaps.slope, unknowns), flank_slope], axis=1),
        stiffness=np.concatenate([stiffness, np.full(flank_gap.shape, reducer.mesh_stiffness)], axis=1),
        pins=stiffness.shape[1],
        disc=gaps.disc,
        shift=gaps.shift,
        tooth_slope=gaps.slope[:, index, disc_unknowns],
        shift_slope=gaps.shift_slope[:, index, disc_unknowns],
        bend=gaps.curvature,
        twist=gaps.curvature_rate,
        phase=gaps.phase,
        curvature=gaps.relative_curvature,
        slip=np.einsum("mcu,mu->mc", gaps.slip_slope, ideal_motion(reducer, crank)),
        offset=offset,
        offset_slope=offset_slope,
        bearing_stiffness=reducer.bearing_stiffness,
        bearing_clearance=reducer.bearing_clearance,
        needles=needle_directions(reducer, crank),
        lever=reducer.lever,
    )


def _pad_gradient(slope: Array, unknowns: int) -> Array:
    """Extend a gradient by the unknowns of the teeth, (m, c, 3 D + 1), with zeros to shape (m, c, `unknowns`)."""
    return np.concatenate([slope, np.zeros((*slope.shape[:2], unknowns - slope.shape[2]))], axis=2)


def _unknown_count(reducer: RvReducer) -> int:
    return 3 * len(reducer.phases) + 1 + reducer.cranks.count + 2


def _crank_offsets(reducer: RvReducer, crank: Array) -> tuple[Array, Array]:
    """Return the displacement of each eccentric from its bore by manufacturing errors, and the gradient of it.

    `crank` are crank angles against the ring [rad], shape (m,). There are D discs, n cranks and u unknown displacements
    [m]: x, y and rotation of each disc, the rotations of the carrier and of each crank, and x and y of the sun.
    Rotations are multiplied by the radius of the circle of crank axes.

    Returns
    -------
    tuple
        Displacement in x and y (m, D, n, 2) [m], and gradient by the unknowns (m, D, n, 2, u) [1].
    """
    stage, lever, eccentricity = reducer.stage, reducer.lever, reducer.design.gear.eccentricity
    discs, cranks, carrier_dof = len(stage.phases), stage.cranks, 3 * len(stage.phases)
    slope = np.zeros((crank.size, discs, cranks, 2, _unknown_count(reducer)))
    carrier_rate = quarter_turned(stage.crank_positions(crank)) / lever
    crank_rate = eccentricity / lever * quarter_turned(stage.eccentrics(crank))
    for disc in range(discs):
        slope[:, disc, :, 0, 3 * disc] = slope[:, disc, :, 1, 3 * disc + 1] = -1.0
        slope[:, disc, :, :, 3 * disc + 2] = -carrier_rate
        for crank_index in range(cranks):
            slope[:, disc, crank_index, :, carrier_dof + 1 + crank_index] = crank_rate[:, disc]
    slope[..., carrier_dof] = carrier_rate[:, np.newaxis]
    return crank_misfits(reducer, crank), slope


def crank_misfits(reducer: RvReducer, crank: Array) -> Array:
    """Compute the displacement of each eccentric from its bore due to manufacturing errors [m], shape (m, D, n, 2).

    There are D discs and n cranks; the last axis is x and y in the frame of the ring. `crank` are crank angles against
    the ring [rad], shape (m,).
    """
    errors, shape = reducer.crank_errors, (len(reducer.phases), reducer.cranks.count)
    carrier_angle = -crank / reducer.design.lobes
    directions = reducer.stage.eccentrics(crank)[:, :, np.newaxis]
    radial_errors, tangential_errors = (
        expanded(values, shape)[..., np.newaxis] for values in (errors.eccentric_radial, errors.eccentric_tangential)
    )
    bore_errors = np.stack([expanded(errors.bore_x, shape), expanded(errors.bore_y, shape)], axis=-1)
    carrier_errors = np.stack([expanded(errors.carrier_x, shape[1:]), expanded(errors.carrier_y, shape[1:])], axis=-1)
    axis_error = np.array([errors.axis_x, errors.axis_y])
    return (
        radial_errors * directions
        + tangential_errors * quarter_turned(directions)
        + rotate(carrier_errors - bore_errors, carrier_angle[:, np.newaxis, np.newaxis])
        + axis_error
    )


def planet_offsets(reducer: RvReducer, crank: Array) -> Array:
    """Compute the displacement of the teeth of each planet from its crank due to run-out [m], shape (m, n, 2).

    n is the number of planets; the last axis is x and y in the frame of the ring. `crank` are crank angles against the
    ring [rad], shape (m,).
    """
    errors, shape = reducer.crank_errors, (reducer.cranks.count,)
    displacements = np.stack([expanded(errors.planet_x, shape), expanded(errors.planet_y, shape)], axis=-1)
    return rotate(displacements, crank[:, np.newaxis])


def runout_error(reducer: RvReducer, output_angle: npt.ArrayLike) -> Array:
    """Compute the apparent rotation of the output due to its run-out [rad], counter-clockwise, in the given shape.

    A hole or flange with the offset o from the axis of rotation turns with the output. The rotation is measured at the
    radius r, in the fixed direction +y. There, the x component of the rotated offset, d, appears as the rotation
    ``-d/r``: a wave of order 1 with the amplitude ``|o|/r``. The parts of the drive do not move because of it. The same
    applies to the run-out of main bearings, which displaces the carrier by an offset that turns with it.

    `output_angle` is the angle of the output [rad].
    """
    errors, angle = reducer.crank_errors, np.asarray(output_angle, dtype=np.float64)
    return np.asarray((errors.output_y * np.sin(angle) - errors.output_x * np.cos(angle)) / reducer.output_radius)


def phase_errors(reducer: RvReducer, crank: Array) -> Array:
    """Compute the phase error of each of n cranks due to the errors of its planet [rad], (m, n), at a fixed sun.

    The errors are run-out and transmission error. A displacement o of the planet's teeth along the line of action turns
    the crank back by o divided by the base radius of the planet. The flanks are those that a driving sun loads, and the
    backlash is larger than the run-out, so that the opposite flanks do not touch. `crank` are crank angles against the
    ring [rad], shape (m,). The result is an argument of `closed_form_error`.
    """
    outward_axis = reducer.stage.crank_positions(crank) / reducer.lever
    radial_share = np.copysign(np.tan(reducer.planet.pressure_angle), reducer.design.drive.speed)
    # the line of action, divided by the cosine of the pressure angle: so are base and pitch radius
    action_direction = quarter_turned(outward_axis) + radial_share * outward_axis
    offset = np.sum(planet_offsets(reducer, crank) * action_direction, axis=-1)
    return np.asarray((offset + _mesh_error(reducer, crank)) / _planet_radius(reducer))


def _planet_radius(reducer: RvReducer) -> float:
    """Return the pitch radius of a planet [m], at the distance of sun and planet."""
    planet = reducer.planet
    return reducer.lever * planet.planet_teeth / (planet.sun_teeth + planet.planet_teeth)


def _mesh_error(reducer: RvReducer, crank: Array) -> Array:
    """Return the transmission error of each planet mesh at the pitch circle [m], shape (m, n), equal in all meshes."""
    planet = reducer.planet
    phase = planet.planet_teeth * crank * reducer.design.ring.teeth / reducer.design.lobes
    return np.repeat((planet.transmission_error * np.sin(phase))[:, np.newaxis], reducer.cranks.count, axis=1)


def _flank_gaps(reducer: RvReducer, crank: Array) -> tuple[Array, Array]:
    """Return the gaps between the flanks of the planets and the sun without load, and their gradients by the unknowns.

    Each of the n planets has two flanks. The first n flanks carry a counter-clockwise load on the carrier. The normal
    of a flank points from the sun to the planet, at the pressure angle to the circle of cranks. `crank` are crank
    angles against the ring [rad], shape (m,). There are u unknown displacements [m]: x, y and rotation of each disc,
    the rotations of the carrier and of each crank, and x and y of the sun; rotations are multiplied by the radius of
    the circle of crank axes.

    Returns
    -------
    tuple
        Gaps (m, 2 n) [m], and gradients (m, 2 n, u) [1].
    """
    planet, stage, lever = reducer.planet, reducer.stage, reducer.lever
    outward_axis = stage.crank_positions(crank) / lever
    tangent, carrier_dof = quarter_turned(outward_axis), 3 * len(stage.phases)
    offset = planet_offsets(reducer, crank) + _mesh_error(reducer, crank)[..., np.newaxis] * tangent
    gaps, slopes = [], []
    for sign in (-1.0, 1.0):
        normal = sign * np.cos(planet.pressure_angle) * tangent + np.sin(planet.pressure_angle) * outward_axis
        slope = np.zeros((*outward_axis.shape[:2], _unknown_count(reducer)))
        tangent_share = sign * np.cos(planet.pressure_angle)
        slope[..., carrier_dof] = tangent_share
        for planet_index in range(stage.cranks):
            slope[:, planet_index, carrier_dof + 1 + planet_index] = -tangent_share * _planet_radius(reducer) / lever
        if planet.sun_support == "floating":
            slope[..., -2:] = -normal
        gaps.append(0.5 * planet.backlash * np.cos(planet.pressure_angle) + np.sum(normal * offset, axis=-1))
        slopes.append(slope)
    return np.concatenate(gaps, axis=1), np.concatenate(slopes, axis=1)


def coulomb_coefficients(reducer: RvReducer) -> RvCoefficients:
    """Return the coefficients of a design with the law ``coulomb``; those of bearings act at the eccentric's radius."""
    design = reducer.design
    bearing = design.friction.cam_rolling * reducer.cranks.eccentric_radius
    return RvCoefficients(design.mesh_friction, reducer.planet.friction, bearing, bearing)


def compute_rv_friction(
    reducer: RvReducer, crank: npt.ArrayLike, sense: float, coefficients: RvCoefficients | None = None
) -> RvFriction:
    """Compute the friction of an RV reducer at m angles of its cranks against the ring [rad], `crank` (m,).

    The result has the generalised friction force on each degree of freedom of the statics per unit of contact force
    [1]: of teeth, crank bearings and planet meshes. Moments are divided by `reducer.lever` [m]. Cranks turn
    counter-clockwise against the ring if `sense` is 1, and clockwise if it is -1. The needles and the tapered bearings
    of a crank both carry the force of a disc. The sliding of a planet is the mean over its path of contact
    (`PlanetMesh`). The default of `coefficients` are the constant coefficients of the law ``coulomb``.
    """
    crank, reducer = np.ravel(np.asarray(crank, dtype=np.float64)), reducer.at_rated_load
    coefficients = coefficients or coulomb_coefficients(reducer)
    tooth_gaps, unknown_count = mesh_gaps(reducer, crank), _unknown_count(reducer)
    discs, carrier_dof, cranks = len(reducer.phases), 3 * len(reducer.phases), reducer.cranks.count
    slip = np.einsum("mcu,mu->mc", tooth_gaps.slip_slope, ideal_motion(reducer, crank))
    sliding = -coefficients.teeth * sense * np.sign(slip)[..., np.newaxis] * tooth_gaps.slip_slope
    needle_term, taper_term = (sense * torque / reducer.lever for torque in (coefficients.needles, coefficients.tapers))
    sliding_arm = coefficients.planets * reducer.planet_mesh.arm / reducer.lever
    bearing_terms, mesh_terms = np.zeros((discs, cranks, unknown_count)), np.zeros((cranks, unknown_count))
    for crank_index in range(cranks):
        bearing_terms[:, crank_index, carrier_dof] = taper_term
        bearing_terms[:, crank_index, carrier_dof + 1 + crank_index] = -(needle_term + taper_term)
        mesh_terms[crank_index, carrier_dof + 1 + crank_index] = -sense * sliding_arm
    for disc in range(discs):
        bearing_terms[disc, :, 3 * disc + 2] = needle_term
    return RvFriction(_pad_gradient(sliding, unknown_count), bearing_terms, mesh_terms)


def solve_rv_loads(
    springs: RvSprings, torque: float | Array, friction: RunningFriction | None = None, start: Array | None = None
) -> RvLoads:
    """Solve for the static equilibrium of an RV reducer under a torque on the carrier.

    Parameters
    ----------
    springs
        Contact springs at m crank angles.
    torque
        Torque on the carrier [N m], not 0, counter-clockwise positive: a number, or a torque per crank angle, shape
        (m,).
    friction
        Friction at these angles, which depends on the forces and is determined by fixed-point iteration; None: no
        friction.
    start
        Displacements (m, u) [m] at which the Newton method starts; None: 0.

    Returns
    -------
    RvLoads
        Forces of pins, cranks and planet flanks [N], rotation [rad] and compliance [rad/(N m)] of the carrier, and
        displacements [m], at the m crank angles.

    Raises
    ------
    RunError
        The Newton method or the iteration of friction does not converge.
    """
    load = np.zeros((springs.crank.size, springs.slope.shape[2]))
    load[:, springs.carrier] = torque / springs.lever
    displacements = _minimise_energy(springs, load, np.zeros(load.shape) if start is None else start)
    if friction is None:
        return _loads_from_displacements(springs, displacements)
    friction_load, load_size = np.zeros(load.shape), np.max(np.abs(load), axis=1)
    relative_change, relaxation = np.full(len(load), np.inf), np.ones(len(load))
    for _ in range(FRICTION.max_steps):
        residual, previous_change = (
            friction.load(_loads_from_displacements(springs, displacements)) - friction_load,
            relative_change,
        )
        relative_change = np.max(np.abs(residual), axis=1) / load_size
        relaxation = np.where(relative_change > previous_change, 0.5 * relaxation, relaxation)
        friction_load = friction_load + relaxation[:, np.newaxis] * residual
        displacements = _minimise_energy(springs, load + friction_load, displacements)
        if relative_change.max() <= FRICTION.rtol:
            return _loads_from_displacements(springs, displacements)
    raise RunError(
        f"no static equilibrium with friction found: the friction forces of the last two iterations differ by "
        f"{relative_change.max():.3g} times the load, but at most {FRICTION.rtol:.0e} is allowed. Reduce the friction "
        "coefficients (friction.*, planet.friction)"
    )


def _loads_from_displacements(springs: RvSprings, displacements: Array) -> RvLoads:
    """Return forces, rotation and compliance of an RV reducer from its u displacements in equilibrium (m, u) [m].

    `springs` are the contact springs at the m crank angles.
    """
    unit_load = np.zeros(displacements.shape)
    unit_load[:, springs.carrier] = 1.0 / springs.lever
    compliance = np.asarray(np.linalg.solve(_tangent_stiffness(springs, displacements), unit_load[..., np.newaxis]))
    compliance = compliance[:, springs.carrier, 0]
    gaps, _, _ = _contact_gaps(springs, displacements)
    force = springs.stiffness * np.maximum(-gaps, 0.0)
    bearing_forces, _, _ = _bearing_forces(springs, displacements)
    return RvLoads(
        pins=force[:, : springs.pins],
        cranks=bearing_forces,
        flanks=force[:, springs.pins :].reshape(len(displacements), 2, -1),
        carrier_turn=displacements[:, springs.carrier] / springs.lever,
        compliance=np.asarray(compliance / springs.lever),
        displacements=displacements,
    )


def _minimise_energy(springs: RvSprings, load: Array, start: Array) -> Array:
    """Return the displacements of least energy (m, u) [m], by a semismooth Newton method with Armijo backtracking.

    `springs` are the contact springs; all m crank angles are solved together. `load` [N] are the generalised forces on
    the u unknown displacements, shape (m, u), and `start` (m, u) [m] are the displacements at which the method starts.
    The tangent neglects the curvature of flanks: its share, which is pin force times curvature over stiffness, is below
    1e-3.

    Raises
    ------
    RunError
        The method does not converge.
    """
    z, load_size, largest_stiffness = start, np.max(np.abs(load), axis=1), float(springs.stiffness.max())
    energy, residual = _assemble(springs, load, z)
    for _ in range(NEWTON.max_steps):
        force_rounding = NEWTON.rounding * largest_stiffness * np.max(np.abs(z), axis=1)
        is_unsolved = np.max(np.abs(residual), axis=1) > NEWTON.rtol * load_size + force_rounding
        if not is_unsolved.any():
            return z
        step = (
            np.linalg.solve(_tangent_stiffness(springs, z), residual[..., np.newaxis])[..., 0]
            * is_unsolved[:, np.newaxis]
        )
        predicted_decrease, step_length = np.sum(step * residual, axis=1), np.ones(len(z))
        # a change of the energy below the rounding of its terms cannot be compared
        max_energy = energy + NEWTON.rounding * (np.abs(energy) + np.sum(np.abs(load * z), axis=1))
        for _ in range(NEWTON.max_halvings):
            trial_z = z + step_length[:, np.newaxis] * step
            trial_energy, residual = _assemble(springs, load, trial_z)
            is_rejected = trial_energy > max_energy - NEWTON.armijo * step_length * predicted_decrease
            if not is_rejected.any():
                break
            step_length = np.where(is_rejected, 0.5 * step_length, step_length)
        z, energy = trial_z, trial_energy
    max_error = float(np.max(np.max(np.abs(residual), axis=1) / load_size))
    raise RunError(
        f"no static equilibrium found: the residual is {max_error:.3g} of the load, but at most {NEWTON.rtol:.0e} is "
        "allowed. Check the clearances (clearance.*), or increase the load (--load-nm)"
    )


def _contact_gaps(springs: RvSprings, displacements: Array) -> tuple[Array, Array, Array]:
    """Return the gaps of all contacts at known displacements, and factors a and b in the gradients of the pins' gaps.

    The gap of a pin is q - phi (p - p_phi/2) + bend p^2/2 + twist p^3/6, as in ``statics.kernel``. q and p are the
    displacements along the normal and along the flank, phi is the rotation of the disc, and p_phi is the part of p that
    phi causes. bend is the relative curvature, and twist is its rate. The gradient is grad q + a grad p - b grad phi.

    Parameters
    ----------
    springs
        Contact springs at m crank angles.
    displacements
        The u displacements at each angle (m, u) [m].

    Returns
    -------
    tuple
        Gaps of all c contacts, pins before planet flanks (m, c) [m]; a (m, pins) [1]; b (m, pins) [m].
    """
    disc_displacements, pin_count = displacements[:, springs.disc_unknowns], springs.pins
    gaps = springs.gap.copy()
    gaps[:, pin_count:] += (springs.slope[:, pin_count:] @ displacements[..., np.newaxis])[..., 0]
    rotation, shift_of_rotation = (
        disc_displacements[..., 2] / springs.lever,
        springs.shift_slope[..., 2] * disc_displacements[..., 2],
    )
    shift = springs.shift + np.einsum("mci,mci->mc", springs.shift_slope, disc_displacements)
    rise = shift * (springs.bend + 0.5 * springs.twist * shift)
    curvature_term = shift**2 * (0.5 * springs.bend + springs.twist * shift / 6.0)
    gaps[:, :pin_count] += (
        np.einsum("mci,mci->mc", springs.tooth_slope, disc_displacements)
        + curvature_term
        - rotation * (shift - 0.5 * shift_of_rotation)
    )
    return gaps, rise - rotation, shift - shift_of_rotation


def contact_gradients(springs: RvSprings, displacements: Array) -> Array:
    """Return the gradients of the gaps of pins and planet flanks at displacements (m, u) [m], shape (m, c, u) [1]."""
    _, rise, arm = _contact_gaps(springs, displacements)
    gradients = springs.slope.copy()
    gradients[:, np.arange(springs.pins)[:, np.newaxis], springs.disc_unknowns] = _tooth_gradients(springs, rise, arm)
    return gradients


def _tooth_gradients(springs: RvSprings, rise: Array, arm: Array) -> Array:
    """Return the gradients of the gaps of pins by x, y and rotation of their disc [1], shape (m, pins, 3).

    `rise` [1] and `arm` [m] are the factors a and b of `_contact_gaps`, shape (m, pins). `springs` are the contact
    springs at m crank angles.
    """
    gradients = springs.tooth_slope + rise[..., np.newaxis] * springs.shift_slope
    gradients[..., 2] -= arm / springs.lever
    return np.asarray(gradients)


def _bearing_forces(springs: RvSprings, displacements: Array) -> tuple[Array, Array, Array]:
    """Return the forces of cranks on discs at known displacements, with their energy and stiffness.

    There are D discs and n cranks. With a preload, the needles on both sides are loaded up to the displacement at which
    those on the far side open.

    Parameters
    ----------
    springs
        Contact springs at m crank angles.
    displacements
        The u displacements at each angle (m, u) [m].

    Returns
    -------
    tuple
        Forces (m, D, n, 2) [N]; energy (m, D, n) [J]; and the derivative of each force by the displacement of its crank
        (m, D, n, 2, 2) [N/m].
    """
    stiffness, clearance = springs.bearing_stiffness, springs.bearing_clearance
    offsets = springs.offset + np.einsum("mdnju,mu->mdnj", springs.offset_slope, displacements)
    if springs.needles.shape[1]:
        return _needle_forces(springs, offsets)
    distance = np.maximum(np.linalg.norm(offsets, axis=-1), np.finfo(float).tiny)
    near_depth, far_depth = np.maximum(distance - clearance, 0.0), np.maximum(-distance - clearance, 0.0)
    directions = offsets / distance[..., np.newaxis]
    magnitude = stiffness * (near_depth - far_depth)
    projection = directions[..., :, np.newaxis] * directions[..., np.newaxis, :]
    radial_stiffness = stiffness * ((near_depth > 0.0) + 1.0 * (far_depth > 0.0))
    transverse_stiffness = np.where(distance > abs(clearance) * 1e-9 + 1e-18, magnitude / distance, radial_stiffness)
    tangent = radial_stiffness[..., np.newaxis, np.newaxis] * projection + transverse_stiffness[
        ..., np.newaxis, np.newaxis
    ] * (np.eye(2) - projection)
    return magnitude[..., np.newaxis] * directions, 0.5 * stiffness * (near_depth**2 + far_depth**2), tangent


def _needle_forces(springs: RvSprings, offsets: Array) -> tuple[Array, Array, Array]:
    """Return forces [N], energy [J] and stiffness [N/m] of crank bearings with separate needles at given displacements.

    `offsets` are the displacements of the eccentrics in their bores [m], shape (m, D, n, 2), for D discs and n cranks;
    the results have the shapes (m, D, n, 2), (m, D, n) and (m, D, n, 2, 2). `springs` are the contact springs. Each
    needle is a spring along its direction, which closes once the displacement exceeds the clearance.
    """
    directions = springs.needles
    stiffness = needle_share(directions.shape[1]) * springs.bearing_stiffness
    depth = np.maximum(np.einsum("mdnj,mzj->mdnz", offsets, directions) - springs.bearing_clearance, 0.0)
    forces = stiffness * np.einsum("mdnz,mzj->mdnj", depth, directions)
    projections = directions[..., :, np.newaxis] * directions[..., np.newaxis, :]
    tangent = stiffness * np.einsum("mdnz,mzij->mdnij", depth > 0.0, projections)
    return forces, 0.5 * stiffness * np.sum(depth**2, axis=-1), tangent


def _assemble(springs: RvSprings, load: Array, displacements: Array) -> tuple[Array, Array]:
    """Compute the energy of contact springs and load, and the residual forces, at known displacements.

    Parameters
    ----------
    springs
        Contact springs at m crank angles.
    load, displacements
        Generalised forces [N] on the u unknown displacements, and these displacements [m], shape (m, u) each.

    Returns
    -------
    tuple
        Energy of the contact springs minus work of the load (m,) [J]; and residual forces (m, u) [N], which are 0 in
        equilibrium.
    """
    gaps, rise, arm = _contact_gaps(springs, displacements)
    force = springs.stiffness * np.maximum(-gaps, 0.0)
    bearing_forces, bearing_energy, _ = _bearing_forces(springs, displacements)
    energy = 0.5 * np.sum(force * np.maximum(-gaps, 0.0), axis=1) + bearing_energy.sum(axis=(1, 2))
    energy -= np.sum(load * displacements, axis=1)
    residual = load + _sum_along(springs.slope[:, springs.pins :], force[:, springs.pins :])
    tooth_forces = force[:, : springs.pins, np.newaxis] * _tooth_gradients(springs, rise, arm)
    residual[:, : springs.carrier] += (
        tooth_forces.reshape(len(load), springs.discs, -1, 3).sum(axis=2).reshape(len(load), -1)
    )
    residual -= np.einsum("mdnju,mdnj->mu", springs.offset_slope, bearing_forces)
    return energy, residual


def _sum_along(slope: Array, force: Array) -> Array:
    """Convert contact forces (m, c) [N] to forces along the u unknowns (m, u) [N], by the gaps' gradients (m, c, u)."""
    return np.asarray((force[:, np.newaxis] @ slope)[:, 0])


def _tangent_stiffness(springs: RvSprings, displacements: Array) -> Array:
    """Return the tangent stiffness (m, u, u) [N/m] by the u displacements, at known displacements (m, u) [m].

    `springs` are the contact springs at m crank angles. The curvature of the flanks is neglected.
    """
    gaps, rise, arm = _contact_gaps(springs, displacements)
    weights = np.sqrt(springs.stiffness * (gaps < 0.0))[..., np.newaxis]
    flank_gradients = springs.slope[:, springs.pins :] * weights[:, springs.pins :]
    tangent = np.swapaxes(flank_gradients, 1, 2) @ flank_gradients
    weighted_gradients = (_tooth_gradients(springs, rise, arm) * weights[:, : springs.pins]).reshape(
        len(gaps), springs.discs, -1, 3
    )
    disc_stiffness = np.swapaxes(weighted_gradients, 2, 3) @ weighted_gradients
    for disc in range(springs.discs):
        unknowns = slice(3 * disc, 3 * disc + 3)
        tangent[:, unknowns, unknowns] += disc_stiffness[:, disc]
    unknown_count = displacements.shape[1]
    _, _, bearing_tangents = _bearing_forces(springs, displacements)
    bearing_gradients = bearing_tangents @ springs.offset_slope
    gradients, bearing_gradients = (
        array.reshape(len(displacements), -1, unknown_count) for array in (springs.offset_slope, bearing_gradients)
    )
    tangent += np.swapaxes(gradients, 1, 2) @ bearing_gradients
    return np.asarray(tangent + NEWTON.damping * float(springs.stiffness.max()) * np.eye(unknown_count))
