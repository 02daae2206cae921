"""Selection of samples: the ramp, the settled hold, and full periods of the crank within them."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import LogError, UsageError
from cycloid_mj.dynamics.settling import SETTLING, slowness
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class WindowSettings:
    """Settings of the evaluated samples."""

    settling_turn: float = 1 / 8
    """Shortest settling time, as a share of a crank turn: slow reducers are large, with low natural frequencies."""
    min_samples: int = 2
    period_tolerance: float = 1e-6
    """Tolerance of counts of full turns and mesh periods, in periods: the servo may miss an end by 1e-8."""
    time_rtol: float = 1e-9
    """Relative tolerance of times, for rounding."""


WINDOW = WindowSettings()


def in_ramp(reducer: Reducer, time: Array) -> Mask:
    """Mark the samples before the crank's speed is constant, shape (n,)."""
    return time < reducer.design.drive.ramp * (1 - WINDOW.time_rtol)


def reaches_hold(reducer: Reducer, time: Array) -> bool:
    """Return whether a run has enough samples at constant crank speed to evaluate."""
    return int(np.count_nonzero(~in_ramp(reducer, time))) >= WINDOW.min_samples


def require_hold(reducer: Reducer, time: Array) -> None:
    """Raise LogError if a run has fewer than `WINDOW.min_samples` samples at constant crank speed (hold).

    `time` (n,) [s] are the times of its samples.
    """
    if not reaches_hold(reducer, time):
        sample_count = np.count_nonzero(~in_ramp(reducer, time))
        end_text = f"it ends at {time[-1]:.6g} s" if time.size else "it has no usable samples"
        raise LogError(
            f"the run of {reducer.design.name} has {sample_count} samples at constant crank speed, but at least "
            f"{WINDOW.min_samples} are needed: {end_text}, and the speed ramp ends at {reducer.design.drive.ramp:.6g} "
            "s. Simulate the design again with a longer --hold-s, or without interrupting the run"
        )


def settling(reducer: Reducer) -> float:
    """Compute the settling time of a run of a design [s]."""
    speed, contacts = abs(reducer.orbit_speed), SETTLING.min_time * slowness(reducer)
    return max(contacts, WINDOW.settling_turn * 2.0 * np.pi / speed) if speed else contacts


def in_hold(reducer: Reducer, time: Array, settle: float | None = None) -> Mask:
    """Return a mask of the settled samples at constant crank speed, (n,), of n samples at the times `time` [s].

    They begin `settle` [s] after the end of the speed ramp, but not later than in the middle between the ramp and the
    last sample. The default is the estimate of `settling`, counted from the time of full load if that is later than the
    ramp.

    Raises
    ------
    UsageError
        `settle` is negative or not a number.
    LogError
        The run has too few samples at constant crank speed.
    """
    design = reducer.design
    ramp = design.drive.ramp
    require_hold(reducer, time)
    if settle is None:
        load_rise = design.load.rise if design.load.torque else 0.0
        settle = max(load_rise - ramp, 0.0) + settling(reducer)
    if not settle >= 0.0:
        raise UsageError(
            f"settle = {settle} s (the settling time of the run) is out of range: give a time of at least 0 s, or omit "
            "it to use the estimated settling time"
        )
    start_time = ramp + min(settle, (time[-1] - ramp) / 2)
    return ~in_ramp(reducer, time) & (time >= start_time - WINDOW.time_rtol * max(ramp, time[-1]))


def whole_periods(crank_angle: Array, mesh_period: float) -> slice:
    """Return the slice of the first samples that covers as many full crank turns as possible.

    If there is no full turn, it covers full mesh periods, and if there is no full period, all samples. `crank_angle`
    (n,) [rad] is monotone. `mesh_period` [rad] is the crank angle from tooth to tooth. In sums over the slice, ripple
    with the period of a turn or of the mesh cancels, except for the fraction of a sample at the end.
    """
    swept_angle = np.abs(crank_angle - crank_angle[0])
    total_angle = swept_angle[-1] * swept_angle.size / max(swept_angle.size - 1, 1)
    for period in (2 * np.pi, mesh_period):
        count = np.floor(total_angle / period + WINDOW.period_tolerance)
        if count >= 1:
            return slice(0, int(np.searchsorted(swept_angle, count * period * (1 - WINDOW.period_tolerance))))
    return slice(0, swept_angle.size)


def turn_by_turn(crank_angle: Array) -> list[slice]:
    """Return a slice of the samples of each full crank turn, in sequence from the first sample.

    `crank_angle` (n,) [rad] is monotone. Without a full turn, the only slice has all samples.
    """
    swept_turns = np.abs(crank_angle - crank_angle[0]) / (2 * np.pi)
    # a turn of n samples ends one sample after its last
    turn_count = int(swept_turns[-1] * swept_turns.size / max(swept_turns.size - 1, 1) + WINDOW.period_tolerance)
    # samples may fall on the ends of a turn, which the servo of the drive misses by about 1e-8 of a turn
    start_samples = np.searchsorted(swept_turns, np.arange(turn_count + 1) - WINDOW.period_tolerance / (2 * np.pi))
    return [slice(int(first_sample), int(end_sample)) for first_sample, end_sample in pairwise(start_samples)] or [
        slice(0, swept_turns.size)
    ]


def one_turn(crank_angle: Array) -> slice:
    """Return the slice of the samples of one full crank turn, both ends included; of all samples without a full turn.

    The turn begins at the first multiple of 2 pi, or at the first sample if no full turn follows that multiple.
    `crank_angle` (n,) [rad] does not change its sign, and its magnitude increases.
    """
    turns = np.abs(crank_angle) / (2 * np.pi)
    for first_turn in (np.ceil(turns[0] - 1e-6), turns[0]):
        first_sample, end_sample = np.searchsorted(turns, [first_turn - 1e-6, first_turn + 1 + 1e-6])
        if end_sample < turns.size:
            return slice(int(first_sample), int(end_sample))
    return slice(0, turns.size)


def last_turn(crank_angle: Array) -> slice:
    """Return the slice of the samples of the last full crank turn; of all samples without a full turn."""
    turns = np.abs(crank_angle) / (2 * np.pi)
    return slice(int(np.searchsorted(turns, turns[-1] - 1 - 1e-6)), turns.size)
