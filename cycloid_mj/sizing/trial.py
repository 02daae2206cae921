"""A drive under a torque: what it bears by the laws of its rating, and whether it holds what is asked of it."""

import math
from dataclasses import dataclass, replace

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.item import RatedItem, Rating
from cycloid_mj.life.items import rate
from cycloid_mj.life.loading import POSES
from cycloid_mj.life.rated import weakest_torque
from cycloid_mj.reducer import Reducer

FEW = 19
"""Crank angles of a first look; the last has as many as a data sheet."""

RESERVE = 1.02
"""Torque for which a first look is to be good enough: the worst of all crank angles may lie between those of it."""

NOT_HELD = 0.3
"""Of a torque at which statics found no balance: where a smaller one is looked for."""

MOST_WORK, UNKNOWN_WORK = 4e4, 5e3
"""Of a balance that counts as held: one that takes more snaps over in its play, and is slow to rate; and of none."""

NEAR = 0.08
"""Relative: how near to its torque a trial's bearing torque is to be, so that the laws between need not be exact."""

MOST_TRIALS = 5


@dataclass(frozen=True, eq=False)
class TorqueTrial:
    """A drive at a torque [N m]: its rating, the torque that it bears by the law of its weakest item, and that item.

    Its work is that of a balance, times the teeth.

    Where statics find no balance, or find it only with much work, there is neither rating nor item.
    """

    reducer: Reducer
    torque: float
    rating: Rating | None
    bears: float
    weakest: RatedItem | None
    work: float

    @property
    def life(self) -> float:
        """Hours that the first part lasts of those that wear out [h]."""
        lives = [item.life for item in self.rating.items.values() if item.decisive] if self.rating else []
        return min((life for life in lives if life is not None), default=math.inf)


def tried(reducer: Reducer, torque: float, poses: int = FEW) -> TorqueTrial:
    """Rate a drive made for a torque [N m], at a number of crank angles, for the life that its design asks for."""
    drive = reducer.design.drive
    needed = torque / reducer.design.reduction
    at = reducer.but(drive={"torque": needed, "power": drive.power * needed / drive.torque})
    life = at.design.service.life
    try:
        rating = rate(at.design, constant_duty(torque, drive.speed), life, poses=poses)
    except CycloidError:
        return TorqueTrial(at, torque, None, NOT_HELD * torque, None, UNKNOWN_WORK)
    work = rating.work * at.design.ring.teeth
    if work > MOST_WORK:
        return TorqueTrial(at, torque, None, NOT_HELD * torque, None, work)
    bears, weakest = weakest_torque((item for item in rating.items.values() if item.decisive), torque, life)
    return TorqueTrial(at, torque, rating, bears, weakest, work)


def settled(reducer: Reducer, torque: float) -> TorqueTrial:
    """Rate a drive near the torque that it bears, looking for that from a torque [N m] on.

    Where it holds no torque near that, the trial is of the largest at which it was seen to hold one.
    """
    held = tried(reducer, torque)
    at, high = held.bears, torque if not held.rating else math.inf
    for _ in range(MOST_TRIALS):
        if held.rating and abs(min(held.bears, high) / held.torque - 1.0) < NEAR:
            break
        trial = tried(reducer, at)
        if trial.rating:
            held, at = trial, min(trial.bears, math.sqrt(trial.torque * high))
        else:
            high, at = at, math.sqrt(held.torque * at) if held.rating else trial.bears
    return replace(held, bears=min(held.bears, high))


def holds(reducer: Reducer, torque: float) -> TorqueTrial | None:
    """Rate a drive at a torque [N m], at the crank angles of its data sheet; nothing where it does not hold it."""
    trial = tried(reducer, torque, POSES)
    return trial if trial.rating and trial.bears >= torque else None
