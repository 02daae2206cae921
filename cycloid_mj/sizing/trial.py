"""Rating of a drive at a torque: its capacity by the laws of its items, and whether it supports the torque."""

import math
from dataclasses import dataclass, replace

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.item import RatedItem, Rating
from cycloid_mj.life.items import rate
from cycloid_mj.life.loading import POSES
from cycloid_mj.life.rated import weakest_torque
from cycloid_mj.reducer import Reducer

FEW_ANGLES = 19
"""Number of crank angles of a first rating; a final one has those of the data sheet."""

TORQUE_RESERVE = 1.02
"""Torque reserve of a first rating, as the worst crank angle may be between its angles."""

RETRY_SHARE = 0.3
"""Next torque relative to one without a static equilibrium."""

MAX_WORK, UNKNOWN_WORK = 4e4, 5e3
"""Largest work of an accepted equilibrium (more indicates teeth that skip), and the work assumed without one."""

CAPACITY_RTOL = 0.08
"""Relative tolerance between torque and capacity of a trial."""

MAX_TRIALS = 5
"""Maximum number of trials of `solve_capacity`."""


@dataclass(frozen=True, eq=False)
class TorqueTrial:
    """A drive at a torque [N m]: its rating, its capacity by the law of its weakest item, and that item.

    `work` is that of an equilibrium times teeth. Without an equilibrium, or if it takes too much work, there is neither
    rating nor item.
    """

    reducer: Reducer
    torque: float
    rating: Rating | None
    capacity: float
    weakest: RatedItem | None
    work: float

    @property
    def life(self) -> float:
        """Shortest life of its parts [h]."""
        return self.rating.shortest_life if self.rating else math.inf


def rate_drive(reducer: Reducer, torque: float, poses: int = FEW_ANGLES) -> TorqueTrial:
    """Rate a drive for a torque [N m] and the life of its design, at a number of crank angles."""
    drive = reducer.design.drive
    needed = torque / reducer.design.reduction
    at = reducer.but(drive={"torque": needed, "power": drive.power * needed / drive.torque})
    life = at.design.service.life
    try:
        rating = rate(at.design, constant_duty(torque, drive.speed), life, poses=poses)
    except CycloidError:
        return TorqueTrial(at, torque, None, RETRY_SHARE * torque, None, UNKNOWN_WORK)
    work = rating.work * at.design.ring.teeth
    if work > MAX_WORK:
        return TorqueTrial(at, torque, None, RETRY_SHARE * torque, None, work)
    capacity, weakest = weakest_torque((item for item in rating.items.values() if item.decisive), torque, life)
    return TorqueTrial(at, torque, rating, capacity, weakest, work)


def solve_capacity(reducer: Reducer, torque: float) -> TorqueTrial:
    """Solve for the capacity of a drive by a damped fixed-point iteration from a torque [N m]; return the last trial.

    If it supports no torque near its capacity, the trial is that of the largest supported torque.
    """
    held = rate_drive(reducer, torque)
    at, high = held.capacity, torque if not held.rating else math.inf
    for _ in range(MAX_TRIALS):
        if held.rating and abs(min(held.capacity, high) / held.torque - 1.0) < CAPACITY_RTOL:
            break
        trial = rate_drive(reducer, at)
        if trial.rating:
            held, at = trial, min(trial.capacity, math.sqrt(trial.torque * high))
        else:
            high, at = at, math.sqrt(held.torque * at) if held.rating else trial.capacity
    return replace(held, capacity=min(held.capacity, high))


def rate_at_all_angles(reducer: Reducer, torque: float) -> TorqueTrial | None:
    """Rate a drive at a torque [N m] and all crank angles of its data sheet; return None if it does not support it."""
    trial = rate_drive(reducer, torque, POSES)
    return trial if trial.rating and trial.capacity >= torque else None
