"""Which samples count: the ramp, the settled hold, and whole periods of the crank within them."""

from itertools import pairwise

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import LogError, UsageError
from cycloid_mj.dynamics.swing import SETTLING, slowness
from cycloid_mj.reducer import Reducer

SETTLING_TURN = 1 / 8
"""The same as a share of a crank turn: slow reducers are large, and ring at lower frequencies."""

FEWEST_SAMPLES = 2
ROUNDING = 1e-9


def in_ramp(reducer: Reducer, time: Array) -> Mask:
    """Mark the samples before the crank's speed is constant, shape (n,)."""
    return time < reducer.design.drive.ramp * (1 - ROUNDING)


def reaches_hold(reducer: Reducer, time: Array) -> bool:
    """Say whether a run has enough samples at constant crank speed to judge them."""
    return int(np.count_nonzero(~in_ramp(reducer, time))) >= FEWEST_SAMPLES


def require_hold(reducer: Reducer, time: Array) -> None:
    """Raise LogError for a run that does not reach its hold."""
    if not reaches_hold(reducer, time):
        count = np.count_nonzero(~in_ramp(reducer, time))
        reached = f"it ends at {time[-1]:.6g} s" if time.size else "it has no usable samples"
        raise LogError(
            f"the run has {count} samples at constant crank speed, but this needs at least {FEWEST_SAMPLES}: {reached},"
            f" the ramp ends at {reducer.design.drive.ramp:.6g} s; run the design to its end"
        )


def settling(reducer: Reducer) -> float:
    """Compute the time that a run of a design takes to ring out [s]."""
    speed, contacts = abs(reducer.design.drive.speed), SETTLING * slowness(reducer)
    return max(contacts, SETTLING_TURN * 2.0 * np.pi / speed) if speed else contacts


def in_hold(reducer: Reducer, time: Array, settle: float | None = None) -> Mask:
    """Mark the settled samples at constant crank speed, shape (n,).

    They begin `settle` [s] after the ramp, but never after more than half of the hold that was run. By default
    `settle` is `settling`, counted from the end of the load's rise where that comes later than the ramp's.

    Raises
    ------
    UsageError
        `settle` is negative or not a number.
    LogError
        The run ended before the hold, or with too few samples of it.
    """
    design = reducer.design
    ramp = design.drive.ramp
    require_hold(reducer, time)
    if settle is None:
        loaded = design.load.rise if design.load.torque else 0.0
        settle = max(loaded - ramp, 0.0) + settling(reducer)
    if not settle >= 0.0:
        raise UsageError(f"the settling time is {settle} s; give 0 s or more, or leave it out")
    start = ramp + min(settle, (time[-1] - ramp) / 2)
    return ~in_ramp(reducer, time) & (time >= start - ROUNDING * max(ramp, time[-1]))


def whole_periods(crank_angle: Array, mesh_period: float) -> slice:
    """Find the longest first part that lasts whole crank turns, or else whole mesh periods, or else everything.

    Sums over it are free of the ripple that repeats with the turn or the mesh; the odd share of one sample is left.
    """
    swept = np.abs(crank_angle - crank_angle[0])
    span = swept[-1] * swept.size / max(swept.size - 1, 1)
    for period in (2 * np.pi, mesh_period):
        count = np.floor(span / period + 1e-6)
        if count >= 1:
            return slice(0, int(np.searchsorted(swept, count * period * (1 - 1e-6))))
    return slice(0, swept.size)


def turn_by_turn(crank_angle: Array) -> list[slice]:
    """List each whole crank turn from the first sample on; everything where it is shorter than one turn."""
    swept = np.abs(crank_angle - crank_angle[0]) / (2 * np.pi)
    # a turn of n samples ends one sample after its last
    turns = int(swept[-1] * swept.size / max(swept.size - 1, 1) + 1e-6)
    # samples may fall on the turn's ends, which the drive's servo misses by some 1e-8 of a turn
    starts = np.searchsorted(swept, np.arange(turns + 1) - 1e-6 / (2 * np.pi))
    return [slice(int(first), int(last)) for first, last in pairwise(starts)] or [slice(0, swept.size)]


def one_turn(crank_angle: Array) -> slice:
    """Find the first turn from crank angle 0 (modulo a turn), else the first turn from anywhere, else everything."""
    turns = np.abs(crank_angle) / (2 * np.pi)
    for start in (np.ceil(turns[0] - 1e-6), turns[0]):
        first, last = np.searchsorted(turns, [start - 1e-6, start + 1 + 1e-6])
        if last < turns.size:
            return slice(int(first), int(last))
    return slice(0, turns.size)


def last_turn(crank_angle: Array) -> slice:
    """Find the last turn, or everything where there is less: in a ramp it is the nearest to the drive's speed."""
    turns = np.abs(crank_angle) / (2 * np.pi)
    return slice(int(np.searchsorted(turns, turns[-1] - 1 - 1e-6)), turns.size)
