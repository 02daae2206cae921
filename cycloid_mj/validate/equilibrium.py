"""The static pose of a loaded reducer at a locked crank: an independent solution of what the simulation settles to.

Parts are rigid, contacts are springs that only push, at the exact gaps; without friction and inertia the pose has the
least elastic energy less the work of the load. Where the stiffness of a tooth contact follows its curvature, the
forces are no gradient of an energy: then their balance is solved, from the pose of least energy at uniform stiffness.

The unknowns z [m] are the departures from the ideal pose: gear x, y and turn, turn of the output (both times the
radius of the output pins), and x, y of every free pin or sleeve.
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
from cycloid_mj.validate.gaps import Flanks, GearPose, NearestPoints, flanks_of, pin_gaps, ring_gaps, rotate
from cycloid_mj.validate.stiffness import tooth_stiffness

_SCALE = 1e-6
"""Unit of length of the search [m]: poses depart from the ideal one by micrometres."""
_DESCENTS = 100
"""Most steps down the energy; the balance is solved from there."""
Method = Literal["trust-exact", "trust-ncg"]
_METHODS: tuple[Method, ...] = ("trust-exact", "trust-ncg")
"""Ways down the energy: where nothing holds a pin the matrix is singular, and what factors it may stop on the way."""
_IMBALANCE = 1e-4
"""Largest residual of the balance, as a share of the load."""


@dataclass(frozen=True)
class Equilibrium:
    """The solution at one crank angle.

    Attributes
    ----------
    gear_turn, output_turn
        Angles of gear and output less the ideal ones [rad].
    ring_forces
        Forces of the ring's pins or lobes on the gear [N], shape (N, 2).
    cam_force
        Force of the cam on the gear [N], shape (2,).
    departures
        The unknowns z [m], shape (unknowns,): a start for a like problem.
    """

    gear_turn: float
    output_turn: float
    ring_forces: Array
    cam_force: Array
    departures: Array


@dataclass(frozen=True, eq=False)
class Locked:
    """A reducer whose crank is locked.

    Attributes
    ----------
    design, gear
        The design and its ideal mesh.
    stiffness
        Of each kind of pair [N/m]; of teeth, that of a pin on a flat.
    crank
        Crank angle [rad].
    load
        Generalised force on each unknown [N], shape (unknowns,).
    roots
        Roots of an internal gear that the gear may touch.
    flanks
        The gear's, with their modification.
    made
        Departures of the parts from the design.
    """

    design: Design
    gear: CycloidGear
    stiffness: Mapping[str, float]
    crank: float
    load: Array
    roots: Integers
    flanks: Flanks
    made: Deviations

    @property
    def has_moving_pins(self) -> bool:
        """Whether the pins' places are unknown."""
        return self.load.size > 4

    def pose(self, z: Array) -> GearPose:
        """Return the gear's pose."""
        centre = kinematics.gear_centre(self.gear, self.crank) + z[:2]
        return GearPose(centre, self.angle(z[2]))

    def angle(self, arc: float) -> float:
        """Compute the angle [rad] of gear or output at an arc [m] of the output pins from the ideal one."""
        return float(kinematics.gear_rotation(self.gear, self.crank)) + arc / self.design.output.pin_circle_radius


@dataclass(frozen=True)
class PairSprings:
    """Springs of one kind at one pose; n of them.

    Attributes
    ----------
    gap, stiffness
        [m] and [N/m], shape (n,).
    slope
        Derivative of the gaps by the unknowns [1], shape (n, unknowns).
    push
        Direction of the force, on the gear (of a socket: on its pin), shape (n, 2).
    """

    gap: Array
    stiffness: Array
    slope: Array
    push: Array

    @property
    def force(self) -> Array:
        """Sizes of the forces [N], shape (n,)."""
        return -self.stiffness * np.minimum(self.gap, 0.0)


def solve(
    reducer: Reducer, stiffness: Mapping[str, float], crank: float, start: Equilibrium | None = None
) -> Equilibrium:
    """Solve for the pose at which contacts and load balance.

    Parameters
    ----------
    reducer
        The reducer; the load is that of a positive crank speed.
    stiffness
        Of each kind of pair [N/m]; of teeth, that of a pin on a flat.
    crank
        Crank angle [rad], counter-clockwise.
    start
        Solution under a similar load at a near crank angle, to begin from; where that leads nowhere, it is not used.

    Raises
    ------
    RunError
        No balance was found.
    """
    locked = _locked(reducer, stiffness, crank)
    allowed = _IMBALANCE * np.abs(locked.load).max()
    if start is not None:
        z, residual = _balanced(locked, start.departures)
        if residual < allowed:
            return _solution(locked, z)
    for method in _METHODS:
        z, residual = _balanced(locked, _least_energy(locked, method))
        if residual < allowed:
            return _solution(locked, z)
    raise RunError(f"no static balance at crank angle {crank:.4f} rad: {residual:.3g} N are left over")


def _balanced(locked: Locked, start: Array) -> tuple[Array, float]:
    """Compute the pose [m] at which forces balance, sought from another, and the largest force left over [N]."""

    def imbalance(x: Array) -> Array:
        return _imbalance(locked, _SCALE * x)

    solution = root(imbalance, start / _SCALE, method="hybr", tol=1e-10)
    return _SCALE * np.asarray(solution.x), float(np.abs(solution.fun).max())


def _least_energy(locked: Locked, method: Method) -> Array:
    """Compute the pose [m] of least energy at uniform stiffness, as far as a method finds it."""

    def slope(x: Array) -> Array:
        return -_imbalance(locked, _SCALE * x, uniform=True)

    def hessian(x: Array) -> Array:
        return _stiffness_matrix(locked, _SCALE * x) * _SCALE

    def energy(x: Array) -> float:
        return _energy(locked, _SCALE * x) / _SCALE

    start = np.zeros(locked.load.size)
    minimum = minimize(
        energy, start, jac=slope, hess=hessian, method=method, options={"gtol": 1e-2, "maxiter": _DESCENTS}
    )
    return _SCALE * np.asarray(minimum.x)


def _locked(reducer: Reducer, stiffness: Mapping[str, float], crank: float) -> Locked:
    design = reducer.design
    gear = reducer.tooth_profile
    roots = np.zeros(0, dtype=np.int64)
    if design.ring.kind == "nonpin":
        ideal = envelope.sigma_contacts(gear, crank).lobe
        roots = np.unique((ideal[:, np.newaxis] + [-1, 0, 1]) % gear.ring_teeth)
    load = np.zeros(4 + (2 * gear.ring_teeth if design.ring.has_moving_pins else 0))
    load[3] = design.load.torque / design.output.pin_circle_radius
    return Locked(design, gear, stiffness, crank, load, roots, flanks_of(reducer), reducer.deviations)


def _energy(locked: Locked, z: Array) -> float:
    """Elastic energy at uniform stiffness less the work of the load [J]."""
    springs = _springs(locked, z, True).values()
    elastic = sum(0.5 * np.sum(s.stiffness * np.minimum(s.gap, 0.0) ** 2) for s in springs)
    return float(elastic - locked.load @ z)


def _imbalance(locked: Locked, z: Array, uniform: bool = False) -> Array:
    """Generalised forces of springs and load [N], shape (unknowns,)."""
    pushes = [s.slope.T @ s.force for s in _springs(locked, z, uniform).values()]
    return np.asarray(locked.load + np.sum(pushes, axis=0))


def _stiffness_matrix(locked: Locked, z: Array) -> Array:
    """Stiffness of the closed springs [N/m], shape (unknowns, unknowns); their turning with the pose is left out."""
    closed = [(s.slope[s.gap < 0], s.stiffness[s.gap < 0]) for s in _springs(locked, z, True).values()]
    return np.asarray(np.sum([slope.T @ (stiffness[:, np.newaxis] * slope) for slope, stiffness in closed], axis=0))


def _solution(locked: Locked, z: Array) -> Equilibrium:
    springs = _springs(locked, z, False)
    ring, cam = springs["ring"], springs["cam"]
    forces = np.zeros((locked.gear.ring_teeth, 2))
    np.add.at(forces, _mesh(locked, z).owner, ring.force[:, np.newaxis] * ring.push)
    lever = locked.design.output.pin_circle_radius
    cam_force = (cam.force[:, np.newaxis] * cam.push)[0]
    return Equilibrium(z[2] / lever, z[3] / lever, forces, cam_force, z)


def _springs(locked: Locked, z: Array, uniform: bool) -> dict[str, PairSprings]:
    return _springs_at(locked, z.tobytes(), uniform)


@lru_cache(maxsize=1)  # energy, balance and stiffness ask for them at the same pose
def _springs_at(locked: Locked, pose: bytes, uniform: bool) -> dict[str, PairSprings]:
    z = np.frombuffer(pose)
    springs = {"ring": _ring(locked, z, uniform), "cam": _cam(locked, z), "output": _output(locked, z)}
    return springs | {"socket": _sockets(locked, z)} if locked.has_moving_pins else springs


def _mesh(locked: Locked, z: Array) -> NearestPoints:
    pose = locked.pose(z)
    if locked.design.ring.kind == "nonpin":
        return ring_gaps(locked.gear, pose, locked.roots, locked.flanks)
    centres = locked.gear.pin_circle_radius * unit(profile.pin_angles(locked.gear)) + locked.made.pin_place
    moved = centres + z[4:].reshape(-1, 2) if locked.has_moving_pins else centres
    return pin_gaps(locked.gear, pose, moved, locked.flanks)


def _ring(locked: Locked, z: Array, uniform: bool) -> PairSprings:
    mesh, pose, design = _mesh(locked, z), locked.pose(z), locked.design
    count, n = mesh.distance.size, mesh.normals
    slope = np.zeros((count, z.size))
    slope[:, :2] = -n
    slope[:, 2] = -np.sum(n * _quarter_turn(mesh.places - pose.centre), axis=1) / design.output.pin_circle_radius
    if locked.has_moving_pins:
        slope[:, 4:] = (np.eye(count)[:, :, np.newaxis] * n[:, np.newaxis, :]).reshape(count, -1)
    clearance = profile_offset(design) - locked.gear.pin_radius - locked.made.pin_radius[mesh.owner]
    kind = "tooth" if design.ring.kind == "nonpin" else "pin_gear"
    stiffness = np.full(count, locked.stiffness[kind])
    if not uniform:
        stiffness = tooth_stiffness(Reducer(design), locked.stiffness[kind], mesh, pose, locked.flanks)
    return PairSprings(mesh.distance + clearance, stiffness, slope, -n)


def _sockets(locked: Locked, z: Array) -> PairSprings:
    """Seats of pins and sleeves, sockets as whole circles: under a load pins lie on the walls or carry nothing.

    What carries nothing has no place of its own, and through an opening the search would lose it.
    """
    shift = z[4:].reshape(-1, 2)
    distance = np.linalg.norm(shift, axis=1)
    outward = shift / np.maximum(distance, np.finfo(float).tiny)[:, np.newaxis]
    slope = np.zeros((len(shift), z.size))
    slope[:, 4:] = (np.eye(len(shift))[:, :, np.newaxis] * -outward[:, np.newaxis, :]).reshape(len(shift), -1)
    kind = "pin_sleeve" if locked.design.ring.has_sleeves else "pin_socket"
    stiffness = np.full(len(shift), locked.stiffness[kind])
    larger = locked.made.pin_radius if locked.design.ring.has_sockets else 0.0
    return PairSprings(locked.design.pin_play - larger - distance, stiffness, slope, -outward)


def seats(reducer: Reducer, shift: Array) -> tuple[Array, Array]:
    """Compute how far pins or sleeves are from their seats.

    The nearest point of a socket's arc is straight ahead of the pin, or where the socket ends.

    Parameters
    ----------
    reducer
        Which pins or sleeves they are, of the radius that is drawn.
    shift
        Of each from the middle of its seat [m], shape (n, 2).

    Returns
    -------
    gap
        Shape (n,) [m].
    outward
        Unit vectors towards what is nearest, shape (n, 2).
    """
    design = reducer.design
    ring, distance = design.ring, np.linalg.norm(shift, axis=1)
    outward = shift / np.maximum(distance, np.finfo(float).tiny)[:, np.newaxis]
    if not ring.has_sockets or ring.socket == "closed":
        return design.pin_play - distance, outward
    home = profile.pin_angles(reducer.tooth_profile)
    ahead = np.arctan2(shift[:, 0], shift[:, 1]) - home
    ahead = (ahead + np.pi) % (2.0 * np.pi) - np.pi
    radius = ring.pin_radius + design.clearance.pin_socket
    wall = arc_half_angle(design, radius)
    away = radius * unit(home + np.clip(ahead, -wall, wall)) - shift
    size = np.linalg.norm(away, axis=1)
    outward = np.where((np.abs(ahead) > wall)[:, np.newaxis], away / size[:, np.newaxis], outward)
    return np.where(np.abs(ahead) > wall, size - ring.pin_radius, design.pin_play - distance), outward


def _cam(locked: Locked, z: Array) -> PairSprings:
    away = kinematics.gear_centre(locked.gear, locked.crank) / locked.gear.eccentricity
    from_cam = z[:2] - locked.made.eccentricity * away
    distance = np.linalg.norm(from_cam)
    inward = -from_cam / max(distance, np.finfo(float).tiny)
    slope = np.zeros((1, z.size))
    slope[0, :2] = inward
    gap = np.array([locked.design.clearance.cam - distance])
    return PairSprings(gap, np.array([locked.stiffness["cam"]]), slope, inward[np.newaxis])


def _output(locked: Locked, z: Array) -> PairSprings:
    """Output pins in the gear's holes; a pin pushes its hole outwards, along the line of centres."""
    output, pose = locked.design.output, locked.pose(z)
    start = output.pin_circle_radius * unit(2 * np.pi * np.arange(output.pins) / output.pins)
    on_gear, pins = rotate(start + locked.made.hole_place[0], pose.angle), rotate(start, locked.angle(z[3]))
    between = pins - pose.centre - on_gear
    distance = np.linalg.norm(between, axis=1)
    push = between / distance[:, np.newaxis]
    slope = np.zeros((output.pins, z.size))
    slope[:, :2] = push
    slope[:, 2] = np.sum(push * _quarter_turn(on_gear), axis=1) / output.pin_circle_radius
    slope[:, 3] = -np.sum(push * _quarter_turn(pins), axis=1) / output.pin_circle_radius
    room = output.hole_radius + locked.design.clearance.output - output.pin_radius
    return PairSprings(room - distance, np.full(output.pins, locked.stiffness["output"]), slope, push)


def _quarter_turn(vectors: Array) -> Array:
    """Turn vectors (n, 2) counter-clockwise by a right angle."""
    return np.stack([-vectors[:, 1], vectors[:, 0]], axis=-1)
