"""Lost motion and stiffness by statics: the balance of contact springs, without friction, weight or time.

The compliance of the whole is that of three parts in series, told apart by how the parts move, in simulation and
statics alike: the output against the gear (output pins); the gear's turn about the pitch point that goes with its
centre's way s along the eccentric's circle, -s/(c (N-1)) (cam); and the rest of the gear's turn (teeth, pins, sockets).

That is how the parts move, as a run shows it, and not which spring gives: output pins, half of which carry, turn the
output as well where the cam lets the gear's centre go aside. What each spring gives is told by its work: the torque's
increment times the turn's is the sum, over all contacts, of the force's increment times the way by which it closes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.balance import Loads, loads
from cycloid_mj.statics.springs import Springs, springs_of
from cycloid_mj.statics.structure import wind_up

LOST_MOTION_SHARE = 0.03
"""Torque at which lost motion is read, as a share of the rated torque: the industry's definition."""

STRAIGHT = (0.5, 1.0)
"""Ends of the straight part of the curve, as shares of the rated torque."""

SERIES = ("output", "cam", "mesh")
GIVING = ("output", "cam", "mesh", "bending")
"""Springs of the contacts, and the bending of the output pins."""

SHARES = (*sorted(STRAIGHT, reverse=True), LOST_MOTION_SHARE)


@dataclass(frozen=True, eq=False)
class Windup:
    """Static solutions at one crank angle, at the shares (+-1, +-0.5, +-0.03) of the rated torque.

    Attributes
    ----------
    rated
        [N m].
    turn, gear_turn, centre_lead
        Share -> turn of output and gear, from the ideal pose [rad], and way of the gear's centre along the eccentric's
        circle [m].
    work
        Of the forces over the straight part, both sides together, by `GIVING` [J].
    """

    rated: float
    turn: dict[float, float]
    gear_turn: dict[float, float]
    centre_lead: dict[float, float]
    work: dict[str, float]

    @property
    def lost_motion(self) -> float:
        """Turn between +3 % and -3 % of the rated torque [rad]."""
        return self.turn[LOST_MOTION_SHARE] - self.turn[-LOST_MOTION_SHARE]

    def compliance(self, values: dict[float, float]) -> float:
        """Slope of the turn, or of other values, over the straight part [rad/(N m)]; mean of both sides."""
        low, high = STRAIGHT
        rise = (values[high] - values[low], values[-low] - values[-high])
        return 0.5 * sum(rise) / ((high - low) * self.rated)

    def series(self, reducer: Reducer) -> dict[str, float]:
        """Compute the compliance of each part in series [rad/(N m)], keyed by `SERIES`."""
        return in_series(reducer, *(self.compliance(at) for at in (self.turn, self.gear_turn, self.centre_lead)))

    def gives(self, reducer: Reducer) -> dict[str, float]:
        """Compute the compliance of each spring [rad/(N m)], keyed by `GIVING`; with what twists they are the whole."""
        whole, work = self.compliance(self.turn) - wind_up(reducer), sum(self.work.values())
        return {spring: one / work * whole for spring, one in self.work.items()}


def in_series(reducer: Reducer, turn: float, gear_turn: float, centre_lead: float) -> dict[str, float]:
    """Tell the parts of a compliance [rad/(N m)] from those of turn, gear and gear's centre [m/(N m)].

    What twists counts with the output's contacts. Where the ring turns, the gear turns against a carrier that is held.
    """
    design = reducer.design
    cam, of = -centre_lead / (design.gear.eccentricity * design.lobes), reducer.share
    carrier = turn / of
    gear = carrier - wind_up(reducer) / of - gear_turn if design.output.turns_ring else gear_turn
    return {part: of * seen for part, seen in (("output", carrier - gear), ("cam", cam), ("mesh", gear - cam))}


def windups(reducer: Reducer, cranks: Sequence[float] | Array, rated: float, follow: bool = False) -> list[Windup]:
    """Solve for the static poses at crank angles [rad] under shares of a rated torque [N m] on the output.

    `follow` is that of `loads`: angles that follow each other take half of the time.

    Raises
    ------
    RunError
        No balance was found.
    """
    still = reducer.but(drive={"speed": 0.0}, environment={"gravity_x": 0.0, "gravity_y": 0.0})
    springs = springs_of(still, cranks, friction=False)
    by_torque = {
        side * share: loads(still, springs, side * share * rated, follow) for side in (-1, 1) for share in SHARES
    }
    ahead = springs.crank[:, np.newaxis] + np.array(reducer.phases)
    along = -np.stack([np.cos(ahead), np.sin(ahead)], axis=-1)

    def leads(departures: Array) -> Array:
        poses = departures[:, :-1].reshape(*ahead.shape, 3)
        return np.asarray((poses[..., :2] * along).sum(axis=-1).mean(axis=-1))

    low, high = STRAIGHT
    sides = [_work(reducer, springs, by_torque[side * low], by_torque[side * high]) for side in (-1, 1)]
    work = {spring: (sides[0][spring] + sides[1][spring]).tolist() for spring in GIVING}
    turns = {share: one.output_turn.tolist() for share, one in by_torque.items()}
    gear_turns = {share: one.gear_turn.tolist() for share, one in by_torque.items()}
    centre_leads = {share: leads(one.departures).tolist() for share, one in by_torque.items()}

    def of_angle(place: int, values: dict[float, list[float]]) -> dict[float, float]:
        return {share: one[place] for share, one in values.items()}

    return [
        Windup(
            rated,
            of_angle(place, turns),
            of_angle(place, gear_turns),
            of_angle(place, centre_leads),
            {spring: one[place] for spring, one in work.items()},
        )
        for place in range(len(cranks))
    ]


def _work(reducer: Reducer, springs: Springs, low: Loads, high: Loads) -> dict[str, Array]:
    """Compute what the increment of the forces between two loads works on the way between them [J], shape (m,) each."""
    moved = high.departures - low.departures
    closed = -np.einsum("mnu,mu->mn", springs.contacts.slope, moved)
    teeth, cam, pins = high.teeth - low.teeth, high.cam - low.cam, high.output - low.output
    aside = moved[:, :-1].reshape(*cam.shape[:2], 3)[..., :2]
    phases, of_discs = np.array(reducer.phases), high.by_disc(pins)
    flexibility = reducer.contacts.pin_flexibility * np.cos(np.subtract.outer(phases, phases))
    bending = np.einsum("mdp,de,mep->m", of_discs, flexibility, of_discs)
    return {
        "output": (pins * closed[:, springs.teeth :]).sum(axis=1) - bending,
        "cam": -(cam * aside).sum(axis=(1, 2)),
        "mesh": (teeth * closed[:, : springs.teeth]).sum(axis=1),
        "bending": bending,
    }
