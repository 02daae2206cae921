"""Measures of one run for a comparison."""

import math
from dataclasses import dataclass

import numpy.typing as npt

from cycloid_mj.analysis import Findings, Series, judge, series
from cycloid_mj.analysis.series import design_of
from cycloid_mj.analysis.window import require_hold
from cycloid_mj.base.record import Run
from cycloid_mj.comparison.fluctuation import Level, compute_level, full_turns, remove_steady_shifts
from cycloid_mj.comparison.forces import ForceSummary, forces
from cycloid_mj.comparison.vibration import VibrationLevels, vibration
from cycloid_mj.dynamics.settling import SETTLING, slowness
from cycloid_mj.reducer import Reducer, reducer_of


@dataclass(frozen=True)
class Fluctuation:
    """Errors relative to the closed form over full crank turns; path and velocity of q without their steady shifts."""

    gear_speed_rad_s: Level
    q_path_um: Level
    q_velocity_mm_s: Level


@dataclass(frozen=True)
class Measures:
    """All measures of a run: its findings, and those of comparisons only."""

    findings: Findings
    fluctuation: Fluctuation
    vibration: VibrationLevels
    forces: ForceSummary


def settling_time(reducer: Reducer) -> float:
    """Compute the time after the ramp of a run [s] that is not evaluated.

    It is the time in which the load rises and settles, plus a crank turn: without load, a disc that starts in the
    centre takes about a turn until it rattles steadily.
    """
    design = reducer.design
    load_settling = max(design.load.rise - design.drive.ramp, 0.0) + SETTLING.min_time * slowness(reducer)
    crank_speed = abs(float(reducer.member.crank_angle(design.drive.speed)))
    return load_settling + (2 * math.pi / crank_speed if crank_speed else 0.0)


def settle_run(run: Run, q: npt.ArrayLike | None = None) -> Series:
    """Compare a run with the closed form after its `settling_time`; `q` and errors as of `analysis.series`."""
    motion = series(run, q, settling_time(reducer_of(design_of(run))))
    require_hold(motion.reducer, motion.time)
    return motion


def measure_run(motion: Series, log: str | None = None) -> Measures:
    """Compute the measures of a run for a comparison: results of its analysis, rms errors, vibration and forces.

    `motion` are the time series of the run. `log` is the path of the log. It is not read, but stored in the results
    (`Findings.log`).

    Raises
    ------
    LogError
        A column of the run is missing.
    """
    return Measures(judge(motion, log), _fluctuation_errors(motion), vibration(motion), forces(motion))


def _fluctuation_errors(motion: Series) -> Fluctuation:
    """Compute the rms errors of a disc's speed and of path and velocity of its point `Series.q`, over full crank turns.

    `motion` are the time series of the run. Errors are differences from the ideal motion (`Series`). Steady shifts are
    removed from those of path and velocity, see `remove_steady_shifts`.
    """
    turns = full_turns(motion)
    selection = slice(turns[0].start, turns[-1].stop)
    turns_in_selection = [slice(turn.start - selection.start, turn.stop - selection.start) for turn in turns]
    angle = motion.crank_angle[selection]
    ideal_angle = motion.reducer.member.gear_angle(angle)
    path, velocity = (
        remove_steady_shifts(point_motion.error[selection], angle, ideal_angle)
        for point_motion in (motion.q_position, motion.q_velocity)
    )
    return Fluctuation(
        gear_speed_rad_s=compute_level(motion.gear_speed.error, turns),
        q_path_um=compute_level(1e6 * path, turns_in_selection),
        q_velocity_mm_s=compute_level(1e3 * velocity, turns_in_selection),
    )
