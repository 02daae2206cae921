"""Lost motion and stiffness by statics: equilibrium of contact springs, without friction, weight and inertia.

The total compliance is that of three parts in series, distinguished by their motion, in simulation and statics: the
output relative to the disc (output pins); the rotation of the disc about the pitch point that corresponds to the path s
of its centre along the circle of the eccentric, -s/(c (N-1)) (cam); and the remaining rotation of the disc (teeth,
pins, sockets).

This shows how the parts move, as in a run, and not which spring deflects: output pins, half of which carry, also rotate
the output if the cam allows the disc's centre to move. The compliance of each spring follows from its work: the
increment of the torque times that of the rotation is the sum, over all contacts, of the increments of force times
deflection.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.balance import Loads, loads
from cycloid_mj.statics.rv_motion import rv_springs_at, static_rotations
from cycloid_mj.statics.springs import Springs, at_rest, springs_of
from cycloid_mj.statics.structure import wind_up

LOST_MOTION_SHARE = 0.03
"""Torque at which lost motion is evaluated, relative to the nominal torque: the definition of the industry."""

STRAIGHT = (0.5, 1.0)
"""Ends of the linear part of the curve, relative to the nominal torque."""

SERIES = ("output", "cam", "mesh")
SPRINGS = ("output", "cam", "mesh", "bending")
"""Keys of the springs: contacts, and bending of the output pins."""

SHARES = (*sorted(STRAIGHT, reverse=True), LOST_MOTION_SHARE)


@dataclass(frozen=True, eq=False)
class Windup:
    """Static solutions at a crank angle, at +-1, +-0.5 and +-0.03 times the nominal torque.

    Attributes
    ----------
    rated
        Nominal torque [N m].
    turn, gear_turn, centre_lead
        Rotation of output and disc from the ideal pose [rad], and displacement of the disc's centre along the circle of
        the eccentric [m], by relative torque.
    work
        Work of the forces over the linear part, both sides together, by `SPRINGS` [J].

    `centre_lead` and `work` of an RV reducer are empty.
    """

    rated: float
    turn: dict[float, float]
    gear_turn: dict[float, float]
    centre_lead: dict[float, float] = field(default_factory=dict)
    work: dict[str, float] = field(default_factory=dict)

    @property
    def lost_motion(self) -> float:
        """Rotation between +3 % and -3 % of the nominal torque [rad]."""
        return self.turn[LOST_MOTION_SHARE] - self.turn[-LOST_MOTION_SHARE]

    def compliance(self, values: dict[float, float]) -> float:
        """Compute the slope of rotations or displacements over the output torque, from half to full rated torque.

        `values` are rotations [rad] or displacements [m], such as `turn`; their keys are torques relative to `rated`.
        The result is in [rad/(N m)] or [m/(N m)], the mean of both directions.
        """
        low_share, high_share = STRAIGHT
        differences = (values[high_share] - values[low_share], values[-low_share] - values[-high_share])
        return 0.5 * sum(differences) / ((high_share - low_share) * self.rated)

    def series(self, reducer: Reducer) -> dict[str, float]:
        """Compute the compliances in series of output pins, cam and mesh [rad/(N m)], keyed by `SERIES`."""
        return split_in_series(
            reducer, *(self.compliance(motion) for motion in (self.turn, self.gear_turn, self.centre_lead))
        )

    def compliance_by_spring(self, reducer: Reducer) -> dict[str, float]:
        """Compute the compliance of each spring [rad/(N m)], keyed by `SPRINGS`; without torsion of the structure."""
        contact_compliance, work = self.compliance(self.turn) - wind_up(reducer), sum(self.work.values())
        return {spring: item / work * contact_compliance for spring, item in self.work.items()}


def split_in_series(reducer: Reducer, output_rate: float, disc_rate: float, centre_lead: float) -> dict[str, float]:
    """Split the compliance of the output [rad/(N m)] into shares of output pins, cam and mesh, keyed by `SERIES`.

    If the carrier is the output, the cam has -`centre_lead`/(c (N - 1)), with the eccentricity c and N ring teeth, the
    mesh has the rest of `disc_rate`, and the output pins have `output_rate` - `disc_rate`, including the torsion of the
    structure. If the ring is the output, the disc rotates against a fixed carrier.

    Parameters
    ----------
    output_rate, disc_rate
        Rotation of output and disc per torque [rad/(N m)].
    centre_lead
        Displacement of the disc's centre along its circle, ahead of the crank, per torque [m/(N m)].
    """
    design = reducer.design
    cam_part, share = -centre_lead / (design.gear.eccentricity * design.lobes), reducer.share
    carrier_rate = output_rate / share
    disc_part = carrier_rate - wind_up(reducer) / share - disc_rate if design.output.turns_ring else disc_rate
    return {
        contact: share * rate
        for contact, rate in (("output", carrier_rate - disc_part), ("cam", cam_part), ("mesh", disc_part - cam_part))
    }


def solve_windups(
    reducer: Reducer, cranks: Sequence[float] | Array, rated_torque: float, warm_start: bool = False
) -> list[Windup]:
    """Solve for the rotations of output and disc under shares of a rated output torque [N m], without friction.

    Returns a `Windup` for each of the angles `cranks` [rad] of the locked crank, with the rotations under both signs of
    each torque share of `SHARES` (1, 0.5 and 0.03). With `warm_start`, each solution starts from the previous
    equilibria, which halves the time if the angles vary smoothly.

    Raises
    ------
    RunError
        There is no equilibrium.
    """
    if isinstance(reducer, RvReducer):
        return _solve_rv_windups(reducer, cranks, rated_torque)
    static_reducer = at_rest(reducer)
    springs = springs_of(static_reducer, cranks, friction=False)
    solutions = {
        sign * share: loads(static_reducer, springs, sign * share * rated_torque, warm_start)
        for sign in (-1, 1)
        for share in SHARES
    }
    crank_angles = springs.crank[:, np.newaxis] + np.array(reducer.phases)
    tangents = -np.stack([np.cos(crank_angles), np.sin(crank_angles)], axis=-1)

    def mean_lead(departures: Array) -> Array:
        """Compute the displacement of the disc centres along their circle, as the mean of all discs [m], shape (m,)."""
        poses = departures[:, :-1].reshape(*crank_angles.shape, 3)
        return np.asarray((poses[..., :2] * tangents).sum(axis=-1).mean(axis=-1))

    low_share, high_share = STRAIGHT
    work_by_sign = [
        _spring_work(reducer, springs, solutions[sign * low_share], solutions[sign * high_share]) for sign in (-1, 1)
    ]
    work = {spring: (work_by_sign[0][spring] + work_by_sign[1][spring]).tolist() for spring in SPRINGS}
    turns = {share: contact_loads.output_turn.tolist() for share, contact_loads in solutions.items()}
    gear_turns = {share: contact_loads.gear_turn.tolist() for share, contact_loads in solutions.items()}
    centre_leads = {share: mean_lead(contact_loads.departures).tolist() for share, contact_loads in solutions.items()}

    def select_angle(index: int, values: dict[float, list[float]]) -> dict[float, float]:
        return {share: rotations[index] for share, rotations in values.items()}

    return [
        Windup(
            rated_torque,
            select_angle(index, turns),
            select_angle(index, gear_turns),
            select_angle(index, centre_leads),
            {spring: by_angle[index] for spring, by_angle in work.items()},
        )
        for index in range(len(cranks))
    ]


def _solve_rv_windups(reducer: RvReducer, cranks: Sequence[float] | Array, rated_torque: float) -> list[Windup]:
    """Solve for the rotations of output and discs of an RV reducer under shares of a rated output torque [N m].

    Friction is left out. Returns a `Windup` for each angle of the `cranks` against the ground [rad], with the rotations
    under both signs of each torque share of `SHARES`.
    """
    springs = rv_springs_at(reducer, cranks)
    rotations = {
        sign * share: static_rotations(reducer, springs, sign * share * rated_torque).tolist()
        for sign in (-1, 1)
        for share in SHARES
    }
    return [
        Windup(
            rated_torque,
            turn={share: turns[index][1] for share, turns in rotations.items()},
            gear_turn={share: turns[index][0] for share, turns in rotations.items()},
        )
        for index in range(len(cranks))
    ]


def _spring_work(reducer: Reducer, springs: Springs, low_loads: Loads, high_loads: Loads) -> dict[str, Array]:
    """Compute the work [J] in output pins, cam and mesh as the load rises from a `low_loads` to a `high_loads` one.

    The keys are "output", "cam" and "mesh", and "bending" for the work that bends the output pins; each has the shape
    (m,) for m crank angles. The work is force increment times relative displacement, summed over the contact `springs`.
    """
    displacement = high_loads.departures - low_loads.departures
    approach = -np.einsum("mnu,mu->mn", springs.contacts.slope, displacement)
    tooth_force, cam_force, pin_force = (
        high_loads.teeth - low_loads.teeth,
        high_loads.cam - low_loads.cam,
        high_loads.output - low_loads.output,
    )
    cam_displacement = displacement[:, :-1].reshape(*cam_force.shape[:2], 3)[..., :2]
    phases, force_by_disc = np.array(reducer.phases), high_loads.by_disc(pin_force)
    flexibility = reducer.contacts.pin_flexibility * np.cos(np.subtract.outer(phases, phases))
    bending = np.einsum("mdp,de,mep->m", force_by_disc, flexibility, force_by_disc)
    return {
        "output": (pin_force * approach[:, springs.teeth :]).sum(axis=1) - bending,
        "cam": -(cam_force * cam_displacement).sum(axis=(1, 2)),
        "mesh": (tooth_force * approach[:, : springs.teeth]).sum(axis=1),
        "bending": bending,
    }
