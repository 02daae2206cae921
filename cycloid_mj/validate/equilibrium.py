"""Static equilibrium of a loaded reducer at a locked crank: an independent reference for the settled simulation.

Parts are rigid, contacts are unilateral springs at the exact gaps. Without friction and inertia the pose minimises the
elastic energy minus the work of the load. If the stiffness of a tooth contact depends on its curvature, the forces are
not the gradient of an energy; the equilibrium is then solved from the pose of least energy at uniform stiffness.

The unknowns z [m] are displacements from the ideal pose: x, y and rotation of the disc, rotation of the output (both
times the radius of the output pins), and x, y of every free pin or sleeve.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from scipy.optimize import minimize, root

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.errors import RunError
from cycloid_mj.design import Design
from cycloid_mj.geometry import envelope, kinematics, profile
from cycloid_mj.geometry.deviations import Deviations
from cycloid_mj.geometry.modification import profile_offset
from cycloid_mj.geometry.profile import CycloidGear, unit
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import arc_half_angle
from cycloid_mj.validate.gaps import Flanks, GearPose, NearestPoints, design_flanks, pin_gaps, ring_gaps, rotate
from cycloid_mj.validate.stiffness import tooth_stiffness

_SCALE = 1e-6
"""Unit of length of the solver [m]: displacements are of the order of micrometres."""
Method = Literal["trust-exact", "trust-ncg"]
_METHODS: tuple[Method, ...] = ("trust-exact", "trust-ncg")
"""Minimisers, tried in this order: with an unsupported pin the Hessian is singular, on which the first may stop."""
_RESIDUAL_RTOL = 1e-4
"""Largest residual force relative to the load."""


@dataclass(frozen=True)
class Equilibrium:
    """The equilibrium at one crank angle."""

    gear_turn: float
    output_turn: float
    """Rotations of disc and output from their ideal angles [rad]."""
    ring_forces: Array
    """Forces of the ring pins or ring lobes on the disc [N], shape (N, 2)."""
    cam_force: Array
    """Force of the cam on the disc [N], shape (2,)."""
    departures: Array
    """The unknowns z [m], shape (unknowns,); initial guess for a similar problem."""


@dataclass(frozen=True, eq=False)
class LockedReducer:
    """A reducer whose crank is locked."""

    design: Design
    gear: CycloidGear
    """The design and its ideal mesh."""
    stiffness: Mapping[str, float]
    """Contact stiffness of each kind of pair [N/m]; for teeth that of a pin on a flat."""
    crank: float
    """Crank angle [rad]."""
    load: Array
    """Generalised force on each unknown [N], shape (unknowns,)."""
    roots: Integers
    """Roots of an internal gear that the disc may touch."""
    flanks: Flanks
    """Flanks of the disc with their modification."""
    deviations: Deviations
    """Manufacturing errors of the parts."""

    @property
    def has_moving_pins(self) -> bool:
        """True if the positions of the pins are unknowns."""
        return self.load.size > 4

    def pose(self, z: Array) -> GearPose:
        """Return the pose of the disc that the unknowns `z` [m] describe."""
        centre = kinematics.gear_centre(self.gear, self.crank) + z[:2]
        return GearPose(centre, self.angle(z[2]))

    def angle(self, arc: float) -> float:
        """Compute the angle [rad] of gear or output at an arc [m] of the output pins from the ideal one."""
        return float(kinematics.gear_rotation(self.gear, self.crank)) + arc / self.design.output.pin_circle_radius


@dataclass(frozen=True)
class PairSprings:
    """The n springs of one kind of pair at one pose."""

    gap: Array
    stiffness: Array
    """Gaps [m] and stiffnesses [N/m], shape (n,)."""
    slope: Array
    """Gradient of the gaps with respect to the unknowns [1], shape (n, unknowns)."""
    push: Array
    """Direction of the force on the disc (for a socket: on its pin), shape (n, 2)."""

    @property
    def force(self) -> Array:
        """Magnitudes of the forces [N], shape (n,)."""
        return -self.stiffness * np.minimum(self.gap, 0.0)


def solve(
    reducer: Reducer, stiffness: Mapping[str, float], crank: float, start: Equilibrium | None = None
) -> Equilibrium:
    """Solve for rotations and contact forces in static equilibrium at a locked crank, by SciPy's hybrid Powell method.

    Parameters
    ----------
    reducer
        The reducer; the load is that of a positive crank speed.
    stiffness
        Contact stiffness of each kind of pair [N/m]; for teeth, that of a pin on a flat.
    crank
        Crank angle [rad], counter-clockwise.
    start
        Initial guess: an equilibrium under a similar load at a nearby crank angle. If the solver does not converge from
        there, another guess is computed.

    Raises
    ------
    RunError
        The solver did not converge.
    """
    locked = _make_locked_reducer(reducer, stiffness, crank)
    max_residual = _RESIDUAL_RTOL * np.abs(locked.load).max()
    if start is not None:
        pose, residual = _solve_equilibrium(locked, start.departures)
        if residual < max_residual:
            return _make_equilibrium(locked, pose)
    for method in _METHODS:
        pose, residual = _solve_equilibrium(locked, _minimise_energy(locked, method))
        if residual < max_residual:
            return _make_equilibrium(locked, pose)
    raise RunError(
        f"{reducer.design.name}: no static equilibrium at crank angle {np.degrees(crank):.4g} deg: the residual force "
        f"is {residual:.3g} N, but at most {max_residual:.3g} N is allowed. Reduce the load (--load-nm), or increase "
        "the clearances (clearance.*)"
    )


def _solve_equilibrium(locked: LockedReducer, start: Array) -> tuple[Array, float]:
    """Solve for the pose of equilibrium of a `locked` reducer by Powell's hybrid method.

    `start` [m] is the initial guess, u unknowns: displacements of disc, output and moving pins; rotations are
    multiplied by the output pins' radius.

    Returns
    -------
    tuple
        The pose z [m], shape (u,), and the largest residual force [N].
    """

    def residual_force(scaled_pose: Array) -> Array:
        return _residual_force(locked, _SCALE * scaled_pose)

    solution = root(residual_force, start / _SCALE, method="hybr", tol=1e-10)
    return _SCALE * np.asarray(solution.x), float(np.abs(solution.fun).max())


def _minimise_energy(locked: LockedReducer, method: Method) -> Array:
    """Minimise the energy of a `locked` reducer with uniform contact stiffness; return the pose z [m].

    z are the unknown displacements of disc, output and moving pins; rotations are multiplied by the output pins'
    radius. The pose is an initial guess for the equilibrium with a stiffness that depends on the local curvature.
    `method` is a trust-region method of `scipy.optimize.minimize`.
    """

    def gradient(scaled_pose: Array) -> Array:
        return -_residual_force(locked, _SCALE * scaled_pose, uniform=True)

    def hessian(scaled_pose: Array) -> Array:
        return _stiffness_matrix(locked, _SCALE * scaled_pose) * _SCALE

    def energy(scaled_pose: Array) -> float:
        return _energy(locked, _SCALE * scaled_pose) / _SCALE

    start = np.zeros(locked.load.size)
    # a rough minimum, from which the equilibrium is solved
    minimum = minimize(energy, start, jac=gradient, hess=hessian, method=method, options={"gtol": 1e-2, "maxiter": 100})
    return _SCALE * np.asarray(minimum.x)


def _make_locked_reducer(reducer: Reducer, stiffness: Mapping[str, float], crank_angle: float) -> LockedReducer:
    """Return a reducer with its crank locked at an angle [rad], under the load of its design.

    `stiffness` is the contact stiffness of each kind of pair [N/m].
    """
    design = reducer.design
    gear = reducer.tooth_profile
    roots = np.zeros(0, dtype=np.int64)
    if design.ring.kind == "nonpin":
        touched_roots = envelope.sigma_contacts(gear, crank_angle).lobe
        roots = np.unique((touched_roots[:, np.newaxis] + [-1, 0, 1]) % gear.ring_teeth)
    load = np.zeros(4 + (2 * gear.ring_teeth if design.ring.has_moving_pins else 0))
    load[3] = design.load.torque / design.output.pin_circle_radius
    return LockedReducer(design, gear, stiffness, crank_angle, load, roots, design_flanks(reducer), reducer.deviations)


def _energy(locked: LockedReducer, z: Array) -> float:
    """Compute the elastic energy at uniform stiffness minus the work of the load [J]."""
    springs = _springs_at_pose(locked, z, True).values()
    elastic = sum(0.5 * np.sum(spring.stiffness * np.minimum(spring.gap, 0.0) ** 2) for spring in springs)
    return float(elastic - locked.load @ z)


def _residual_force(locked: LockedReducer, z: Array, uniform: bool = False) -> Array:
    """Compute the generalised residual force of springs and load [N], shape (unknowns,)."""
    spring_forces = [spring.slope.T @ spring.force for spring in _springs_at_pose(locked, z, uniform).values()]
    return np.asarray(locked.load + np.sum(spring_forces, axis=0))


def _stiffness_matrix(locked: LockedReducer, z: Array) -> Array:
    """Compute the stiffness matrix of the closed springs [N/m], shape (unknowns, unknowns), at fixed directions."""
    closed_springs = [
        (spring.slope[spring.gap < 0], spring.stiffness[spring.gap < 0])
        for spring in _springs_at_pose(locked, z, True).values()
    ]
    return np.asarray(
        np.sum([slope.T @ (stiffness[:, np.newaxis] * slope) for slope, stiffness in closed_springs], axis=0)
    )


def _make_equilibrium(locked: LockedReducer, z: Array) -> Equilibrium:
    """Return rotations, tooth forces and cam force of a `locked` reducer that is in equilibrium at a pose `z`.

    `z` [m] are the displacements of disc, output and moving pins; rotations are multiplied by the output pins' radius.
    """
    springs = _springs_at_pose(locked, z, False)
    ring_springs, cam_spring = springs["ring"], springs["cam"]
    forces = np.zeros((locked.gear.ring_teeth, 2))
    np.add.at(forces, _nearest_points(locked, z).owner, ring_springs.force[:, np.newaxis] * ring_springs.push)
    pin_circle_radius = locked.design.output.pin_circle_radius
    cam_force = (cam_spring.force[:, np.newaxis] * cam_spring.push)[0]
    return Equilibrium(z[2] / pin_circle_radius, z[3] / pin_circle_radius, forces, cam_force, z)


def _springs_at_pose(locked: LockedReducer, z: Array, uniform: bool) -> dict[str, PairSprings]:
    return _cached_springs(locked, z.tobytes(), uniform)


@lru_cache(maxsize=1)  # energy, residual and stiffness use the same pose
def _cached_springs(locked: LockedReducer, pose: bytes, uniform: bool) -> dict[str, PairSprings]:
    """Compute the contact springs of a `locked` reducer at a pose, by kind of pair.

    The keys are "ring", "cam", "output", and "socket" if pins move. `pose` contains the displacements of disc, output
    and moving pins [m] as bytes (`ndarray.tobytes`), which can be the key of the cache. With `uniform`, all tooth
    contacts have the same stiffness.
    """
    unknowns = np.frombuffer(pose)
    springs = {
        "ring": _ring_springs(locked, unknowns, uniform),
        "cam": _cam_spring(locked, unknowns),
        "output": _output_springs(locked, unknowns),
    }
    return springs | {"socket": _seat_springs(locked, unknowns)} if locked.has_moving_pins else springs


def _nearest_points(locked: LockedReducer, z: Array) -> NearestPoints:
    """Compute the nearest points of disc and ring of a `locked` reducer by search along the exact curves.

    `z` [m] are the displacements of disc, output and moving pins; rotations are multiplied by the output pins' radius.
    The result has a row per ring pin; for an internal gear a row per arc that the disc can touch, then the minima in
    its roots.
    """
    pose = locked.pose(z)
    if locked.design.ring.kind == "nonpin":
        return ring_gaps(locked.gear, pose, locked.roots, locked.flanks)
    pin_centres = (
        locked.gear.pin_circle_radius * unit(profile.pin_angles(locked.gear)) + locked.deviations.pin_displacement
    )
    displaced_centres = pin_centres + z[4:].reshape(-1, 2) if locked.has_moving_pins else pin_centres
    return pin_gaps(locked.gear, pose, displaced_centres, locked.flanks)


def _ring_springs(locked: LockedReducer, z: Array, uniform: bool) -> PairSprings:
    """Compute the contact springs between disc and ring of a `locked` reducer, in the order of `_nearest_points`.

    `z` [m] are the displacements of disc, output and moving pins; rotations are multiplied by the output pins' radius.
    If `uniform`, all contacts have the stiffness of a pin on a flat; otherwise it depends on the local curvature.
    """
    nearest_points, pose, design = _nearest_points(locked, z), locked.pose(z), locked.design
    contact_count, normals = nearest_points.distance.size, nearest_points.normals
    gradient = np.zeros((contact_count, z.size))
    gradient[:, :2] = -normals
    gradient[:, 2] = (
        -np.sum(normals * _quarter_turn(nearest_points.places - pose.centre), axis=1) / design.output.pin_circle_radius
    )
    if locked.has_moving_pins:
        gradient[:, 4:] = (np.eye(contact_count)[:, :, np.newaxis] * normals[:, np.newaxis, :]).reshape(
            contact_count, -1
        )
    clearance = profile_offset(design) - locked.gear.pin_radius - locked.deviations.pin_radius[nearest_points.owner]
    kind = "tooth" if design.ring.kind == "nonpin" else "pin_gear"
    stiffness = np.full(contact_count, locked.stiffness[kind])
    if not uniform:
        stiffness = tooth_stiffness(Reducer(design), locked.stiffness[kind], nearest_points, pose, locked.flanks)
    return PairSprings(nearest_points.distance + clearance, stiffness, gradient, -normals)


def _seat_springs(locked: LockedReducer, z: Array) -> PairSprings:
    """Compute the contact springs of pins in sockets, or of sleeves on pins, of a `locked` reducer, a row per ring pin.

    `z` [m] are the displacements of disc, output and moving pins; rotations are multiplied by the output pins' radius.
    All sockets are assumed to be full circles, because an unloaded pin could leave an open socket during the search.
    The force directions of the result are those on the pin.
    """
    shift = z[4:].reshape(-1, 2)
    distance = np.linalg.norm(shift, axis=1)
    outward = shift / np.maximum(distance, np.finfo(float).tiny)[:, np.newaxis]
    gradient = np.zeros((len(shift), z.size))
    gradient[:, 4:] = (np.eye(len(shift))[:, :, np.newaxis] * -outward[:, np.newaxis, :]).reshape(len(shift), -1)
    kind = "pin_sleeve" if locked.design.ring.has_sleeves else "pin_socket"
    stiffness = np.full(len(shift), locked.stiffness[kind])
    oversize = locked.deviations.pin_radius if locked.design.ring.has_sockets else 0.0
    return PairSprings(locked.design.pin_play - oversize - distance, stiffness, gradient, -outward)


def seat_gaps(reducer: Reducer, shift: Array) -> tuple[Array, Array]:
    """Compute the gaps of n pins or sleeves displaced in their seats, and the directions of the nearest points.

    The nearest point of the arc of a socket is in the direction of the shift, or at the edge of the socket.

    Parameters
    ----------
    reducer
        The reducer; pins and sleeves have their nominal radius.
    shift
        Shift of each pin from the centre of its seat [m], shape (n, 2).

    Returns
    -------
    gap
        Gap between each pin and its seat [m], shape (n,).
    outward
        Unit vectors from each pin towards the nearest point of its seat, shape (n, 2).
    """
    design = reducer.design
    ring, distance = design.ring, np.linalg.norm(shift, axis=1)
    outward = shift / np.maximum(distance, np.finfo(float).tiny)[:, np.newaxis]
    if not ring.has_sockets or ring.socket == "closed":
        return design.pin_play - distance, outward
    pin_angles = profile.pin_angles(reducer.tooth_profile)
    angle = np.arctan2(shift[:, 0], shift[:, 1]) - pin_angles
    angle = (angle + np.pi) % (2.0 * np.pi) - np.pi
    radius = ring.pin_radius + design.clearance.pin_socket
    half_angle = arc_half_angle(design, radius)
    wall_offset = radius * unit(pin_angles + np.clip(angle, -half_angle, half_angle)) - shift
    distance_to_wall = np.linalg.norm(wall_offset, axis=1)
    outward = np.where(
        (np.abs(angle) > half_angle)[:, np.newaxis], wall_offset / distance_to_wall[:, np.newaxis], outward
    )
    return np.where(np.abs(angle) > half_angle, distance_to_wall - ring.pin_radius, design.pin_play - distance), outward


def _cam_spring(locked: LockedReducer, z: Array) -> PairSprings:
    """Compute the contact spring between disc and cam of a `locked` reducer; the result has a single row.

    `z` [m] are the displacements of disc, output and moving pins; rotations are multiplied by the output pins' radius.
    """
    eccentric_direction = kinematics.gear_centre(locked.gear, locked.crank) / locked.gear.eccentricity
    offset = z[:2] - locked.deviations.eccentricity * eccentric_direction
    distance = np.linalg.norm(offset)
    inward = -offset / max(distance, np.finfo(float).tiny)
    gradient = np.zeros((1, z.size))
    gradient[0, :2] = inward
    gap = np.array([locked.design.clearance.cam - distance])
    return PairSprings(gap, np.array([locked.stiffness["cam"]]), gradient, inward[np.newaxis])


def _output_springs(locked: LockedReducer, z: Array) -> PairSprings:
    """Compute the contact springs between output pins and holes of a `locked` reducer, a row per pin.

    `z` [m] are the displacements of disc, output and moving pins; rotations are multiplied by the output pins' radius.
    Each force acts along the line between the centres of pin and hole.
    """
    output, pose = locked.design.output, locked.pose(z)
    ideal_positions = output.pin_circle_radius * unit(2 * np.pi * np.arange(output.pins) / output.pins)
    hole_centres, pin_centres = (
        rotate(ideal_positions + locked.deviations.hole_displacement[0], pose.angle),
        rotate(ideal_positions, locked.angle(z[3])),
    )
    centre_distances = pin_centres - pose.centre - hole_centres
    distance = np.linalg.norm(centre_distances, axis=1)
    normals = centre_distances / distance[:, np.newaxis]
    gradient = np.zeros((output.pins, z.size))
    gradient[:, :2] = normals
    gradient[:, 2] = np.sum(normals * _quarter_turn(hole_centres), axis=1) / output.pin_circle_radius
    gradient[:, 3] = -np.sum(normals * _quarter_turn(pin_centres), axis=1) / output.pin_circle_radius
    clearance = output.hole_radius + locked.design.clearance.output - output.pin_radius
    return PairSprings(clearance - distance, np.full(output.pins, locked.stiffness["output"]), gradient, normals)


def _quarter_turn(vectors: Array) -> Array:
    """Turn vectors (n, 2) counter-clockwise by a right angle."""
    return np.stack([-vectors[:, 1], vectors[:, 0]], axis=-1)
