"""The measures of one run that a comparison holds side by side."""

import math
from dataclasses import dataclass

import numpy.typing as npt

from cycloid_mj.analysis import Findings, Series, judge, series
from cycloid_mj.analysis.series import design_of
from cycloid_mj.analysis.window import require_hold
from cycloid_mj.base.record import Run
from cycloid_mj.comparison.fluctuation import Level, level, turns, unshifted
from cycloid_mj.comparison.forces import ForceSummary, forces
from cycloid_mj.comparison.vibration import VibrationLevels, vibration
from cycloid_mj.dynamics.settling import SETTLING, slowness
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class Fluctuation:
    """Errors about the closed form over whole crank turns; path and velocity of q without their steady shifts."""

    gear_speed_rad_s: Level
    q_path_um: Level
    q_velocity_mm_s: Level


@dataclass(frozen=True)
class Measures:
    """All that is compared: the findings of the run, and what only a comparison asks for."""

    findings: Findings
    fluctuation: Fluctuation
    vibration: VibrationLevels
    forces: ForceSummary


def settling(reducer: Reducer) -> float:
    """Find the time after the ramp that is not judged [s]: until the load is on and settled, and one crank turn more.

    At no load a gear that starts centred takes about a turn to its rattling.
    """
    design = reducer.design
    loaded = max(design.load.rise - design.drive.ramp, 0.0) + SETTLING * slowness(reducer)
    return loaded + (2 * math.pi / abs(design.drive.speed) if design.drive.speed else 0.0)


def settled(run: Run, q: npt.ArrayLike | None = None) -> Series:
    """Hold a run against the closed form, after its `settling`; `q` as in `analysis.series`, which lists the errors."""
    motion = series(run, q, settling(Reducer(design_of(run))))
    require_hold(motion.reducer, motion.time)
    return motion


def measure(motion: Series, log: str | None = None) -> Measures:
    """Measure a run.

    Raises
    ------
    LogError
        The run lacks a column.
    """
    return Measures(judge(motion, log), _fluctuation(motion), vibration(motion), forces(motion))


def _fluctuation(motion: Series) -> Fluctuation:
    parts = turns(motion)
    rows = slice(parts[0].start, parts[-1].stop)
    within = [slice(part.start - rows.start, part.stop - rows.start) for part in parts]
    angle = motion.crank_angle[rows]
    turned = Reducer(motion.design).member.gear_angle(angle)
    path, velocity = (unshifted(q.error[rows], angle, turned) for q in (motion.q_position, motion.q_velocity))
    return Fluctuation(
        gear_speed_rad_s=level(motion.gear_speed.error, parts),
        q_path_um=level(1e6 * path, within),
        q_velocity_mm_s=level(1e3 * velocity, within),
    )
