"""Exact geometry of displaced parts, any number of discs: gaps by search along the curves, and how their springs press.

The witness of ``reducer``: it takes from there only what the unknowns mean and how stiff a contact is.
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
from cycloid_mj.validate.gaps import GearPose, flanks_of, pin_gaps, rotate

_STEP = 1e-8
"""Of a difference [m]."""

_ROUNDS, _IMBALANCE = 30, 1e-6
"""Most steps to a balance, and the largest force that may be left over, as a share of the load."""


def pose_of(reducer: Reducer, crank: float, z: Array, disc: int = 0) -> GearPose:
    """Return the pose of a disc's teeth at departures z [m]: those of disc d mesh as a gear d/D of a turn ahead."""
    gear, ahead = reducer.tooth_profile, crank + phase_of(reducer, disc)
    x, y, turn = z[3 * disc : 3 * disc + 3]
    angle = float(kinematics.gear_rotation(gear, ahead)) + turn / reducer.design.output.pin_circle_radius
    return GearPose(kinematics.gear_centre(gear, ahead) + np.array([x, y]), angle)


def phase_of(reducer: Reducer, disc: int) -> float:
    """Compute how far a disc's eccentric is ahead of the first one's [rad]."""
    return 2.0 * np.pi * disc / reducer.design.gear.discs


def in_workshop(reducer: Reducer, crank: float, shift: Array, turns: Array, output: float) -> tuple[float, Array]:
    """Find what an observer on the ring sees of parts in the workshop: the crank's angle [rad], and the unknowns z [m].

    The workshop has the crank at an angle [rad], each disc beside its ideal place by a shift [m], seen from the ring,
    shape (D, 2), and by a turn [rad], shape (D,); and the output, carrier or ring, turned on by an angle [rad].
    """
    design = reducer.design
    ring, carrier = float(reducer.member.ring_angle(crank)), float(reducer.member.gear_angle(crank))
    turned = carrier + turns
    with_ring, with_carrier = reducer.member.ring_and_carrier(output)
    ring, carrier = ring + float(with_ring), carrier + float(with_carrier)
    seen = crank - ring
    ideal = float(kinematics.gear_rotation(reducer.tooth_profile, seen))
    arcs = design.output.pin_circle_radius * (np.append(turned, carrier) - ring - ideal)
    return seen, np.append(np.column_stack([shift, arcs[:-1]]), arcs[-1])


def exact_gaps(reducer: Reducer, crank: float, z: Array, aside: Array | float = 0.0) -> Array:
    """Compute the gaps of pins or arcs, disc after disc, then those of output pins [m], at the unknowns of ``reducer``.

    All pins are `aside` of their places [m]; what a pin gives way by is not in its gap.
    """
    return exact_contacts(reducer, crank, z, aside)[0]


def exact_contacts(reducer: Reducer, crank: float, z: Array, aside: Array | float = 0.0) -> tuple[Array, Array]:
    """Compute what `exact_gaps` does, shape (n,), and the gradients of these gaps [1], shape (n, u)."""
    sides = [
        side(reducer, crank, z, disc)
        for side in (partial(_teeth, aside=aside), _holes)
        for disc in range(reducer.design.gear.discs)
    ]
    return np.concatenate([gaps for gaps, _ in sides]), np.concatenate([slopes for _, slopes in sides])


def _teeth(reducer: Reducer, crank: float, z: Array, disc: int, aside: Array | float = 0.0) -> tuple[Array, Array]:
    """Compute the gaps of pins or arcs to a disc [m] and their gradients: moved along its normal, it closes one."""
    gear, errors, pose = reducer.tooth_profile, reducer.deviations, pose_of(reducer, crank, z, disc)
    pins = gear.pin_circle_radius * profile.unit(profile.pin_angles(gear)) + errors.pin_place + aside
    mesh = pin_gaps(gear, pose, pins, flanks_of(reducer))
    grown = reducer.profile_offset - errors.disc_radius[disc] - gear.pin_radius - errors.pin_radius
    slopes = np.zeros((mesh.distance.size, z.size))
    slopes[:, 3 * disc : 3 * disc + 2] = -mesh.normals
    slopes[:, 3 * disc + 2] = (
        -_moment(mesh.places - pose.centre, mesh.normals) / reducer.design.output.pin_circle_radius
    )
    return mesh.distance + grown, slopes


def _holes(reducer: Reducer, crank: float, z: Array, disc: int) -> tuple[Array, Array]:
    """Compute the gaps of the output pins in the holes of a disc [m], circles in circles, and their gradients."""
    output, ideal = reducer.design.output, float(kinematics.gear_rotation(reducer.tooth_profile, crank))
    around = output.pin_circle_radius * profile.unit(2.0 * np.pi * np.arange(output.pins) / output.pins)
    turn, out = (ideal + float(arc) / output.pin_circle_radius for arc in (z[3 * disc + 2], z[-1]))
    holes, pins = rotate(around + reducer.deviations.hole_place[disc], turn), rotate(around, out)
    between = pins - holes - pose_of(reducer, crank, z, disc).centre
    apart = np.linalg.norm(between, axis=1)
    push, slopes = between / apart[:, np.newaxis], np.zeros((output.pins, z.size))
    slopes[:, 3 * disc : 3 * disc + 2] = push
    slopes[:, 3 * disc + 2] = _moment(holes, push) / output.pin_circle_radius
    slopes[:, -1] = -_moment(pins, push) / output.pin_circle_radius
    return output.hole_radius + reducer.design.clearance.output - output.pin_radius - apart, slopes


def _moment(arms: Array, forces: Array) -> Array:
    """Compute the moments of forces (n, 2) at arms (n, 2), counter-clockwise."""
    return np.asarray(arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0])


def cam_ways(reducer: Reducer, crank: float, z: Array) -> Array:
    """Compute the way of each disc's centre from its cam's [m], shape (D, 2)."""
    design = reducer.design
    errors, ways = reducer.deviations, []
    for disc in range(design.gear.discs):
        out = kinematics.gear_centre(reducer.tooth_profile, crank + phase_of(reducer, disc)) / design.gear.eccentricity
        ways.append(z[3 * disc : 3 * disc + 2] - errors.eccentricity * out - rotate(errors.cam_place[disc], crank))
    return np.array(ways)


@dataclass(frozen=True)
class DisplacedSprings:
    """Springs on exact gaps at one crank angle, under no friction.

    Attributes
    ----------
    design
        Seen from its ring.
    crank
        From the ring [rad].
    stiffness
        Of the contacts [N/m], shape (n,), in the order of `exact_gaps`.
    cam_stiffness
        Of each cam [N/m].
    play
        By which each contact gives way first [m], shape (n,).
    bending
        Of the output pins by a force at each disc, along the pushes there [m/N], (D, D); the diagonal, which is in
        `stiffness`, is 0; None where no disc bends the pins for another.
    """

    design: Design
    crank: float
    stiffness: Array
    cam_stiffness: float
    play: Array
    bending: Array | None

    def contacts(self, z: Array) -> tuple[Array, Array]:
        """Compute the gaps of contacts, then of cams [m], where a contact that gives way has done so; and gradients."""
        gaps, slopes = exact_contacts(Reducer(self.design), self.crank, z)
        ways = cam_ways(Reducer(self.design), self.crank, z)
        out, of_cams = np.linalg.norm(ways, axis=1), np.zeros((len(ways), z.size))
        for disc, way in enumerate(ways):
            of_cams[disc, 3 * disc : 3 * disc + 2] = -way / (out[disc] or 1.0)
        cams = self.design.clearance.cam - out
        return np.concatenate([gaps + self.play, cams]), np.concatenate([slopes, of_cams])

    def gaps(self, z: Array) -> Array:
        """Compute the gaps of contacts, then of cams [m], shape (n + D,)."""
        return self.contacts(z)[0]

    def forces(self, z: Array) -> Array:
        """Compute the forces of contacts, then of cams [N], shape (n + D,)."""
        return self._forces_at(self.gaps(z))

    def _forces_at(self, gaps: Array) -> Array:
        discs = self.design.gear.discs
        force = -np.append(self.stiffness, [self.cam_stiffness] * discs) * np.minimum(gaps, 0.0)
        if self.bending is not None:
            pins = self.design.output.pins
            first = self.stiffness.size - discs * pins
            for pin in range(pins):
                of_pin = first + pin + pins * np.arange(discs)
                force[of_pin] = _shared(gaps[of_pin], np.diag(1.0 / self.stiffness[of_pin]) + self.bending)
        return force

    def energy(self, z: Array) -> float:
        """Compute the energy of contacts, cams and bent pins [J]: half of each force times what its gap closes by."""
        gaps = self.gaps(z)
        return float(-0.5 * self._forces_at(gaps) @ gaps)

    def push(self, z: Array) -> Array:
        """Compute the generalised force of the springs [N], shape (u,)."""
        gaps, slopes = self.contacts(z)
        return np.asarray(slopes.T @ self._forces_at(gaps))

    def balance(self, load: Array, start: Array) -> Array:
        """Compute where a load (u,) [N] is balanced [m], by the stiffness at a start near there.

        Raises
        ------
        RunError
            That leads to no balance.
        """
        z, pushed = start, self.push(start)
        stiffness = np.stack([(pushed - self.push(start + way)) / _STEP for way in _STEP * np.eye(z.size)], axis=1)
        for _ in range(_ROUNDS):
            left = load + self.push(z)
            if np.abs(left).max() < _IMBALANCE * np.abs(load).max():
                return z
            z = z + np.linalg.solve(stiffness, left)
        raise RunError(f"no balance on exact gaps: {np.abs(left).max():.3g} N are left over")


def _shared(gaps: Array, flexible: Array) -> Array:
    """Compute the forces on one pin [N], shape (D,), at the gaps that it has while straight [m], shape (D,).

    Of all sets of contacts it is the one that holds: those in it press, f >= 0, the bent gap of the others is >= 0.
    """
    discs = gaps.size
    for code in range(2**discs):
        closed: Mask = np.array([bool(code >> disc & 1) for disc in range(discs)])
        force = np.zeros(discs)
        force[closed] = np.linalg.solve(flexible[np.ix_(closed, closed)], -gaps[closed])
        bent = gaps + flexible @ force
        if np.all(force >= 0.0) and np.all(bent[~closed] >= 0.0):
            return force
    raise RunError("no forces hold a bent output pin: its flexibility is not positive")


def held_back(force: Array, stretch: Array, limit: Array, stick: npt.ArrayLike) -> Array:
    """Compute the force of springs that slip [N] after a stretch [m], from what they held: at most their limit."""
    return np.clip(force + np.asarray(stick) * stretch, -limit, limit)
