"""All figures of a run that any stage needs, so that its log is read only once."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis import Series, judge
from cycloid_mj.base.array import Array
from cycloid_mj.base.names import OUTPUT
from cycloid_mj.base.record import Run
from cycloid_mj.comparison import measure_run, settle_run
from hsieh2014.peaks import PIN_1, curves_by_angle, pairs_on
from hsieh2014.pin_motion import PinMotion, pin_motion
from hsieh2014.ranking import RANKED
from hsieh2014.stated import ORDER

PRESSED = (*ORDER, OUTPUT, PIN_1)
"""Parts whose forces are evaluated."""


@dataclass(frozen=True, eq=False)
class RunFigures:
    """Figures of one run."""

    design: str
    """Name of the design that ran."""
    mean_speed: float
    """Mean speed of the gear, opposite to the crank, over full turns [rad/s]."""
    transmission_error: float
    """Transmission error of the gear, peak to peak [arcsec]."""
    levels: Mapping[str, float]
    """Key of a ranked quantity -> its rms difference from the closed form."""
    pin_1: PinMotion | None
    """Motion of pin 1; None if no pin can move."""
    forces: Mapping[str, Array]
    """Part -> the largest force on it in each part of a crank turn [N], shape (``peaks.BINS``,)."""


def run_figures(run: Run) -> RunFigures:
    """Compute all quantities of a run that the stages need, so that its log is read only once."""
    motion = settle_run(run)
    measures = measure_run(motion)
    return RunFigures(
        run.provenance["design"],
        mean_speed(motion),
        measures.findings.gear_transmission_error.peak_to_peak_arcsec,
        {each.key: each.level(measures).rms for each in RANKED},
        pin_motion(motion) if motion.pin_1 else None,
        curves_by_angle(run, {part: pairs_on(run, part) for part in PRESSED}),
    )


def mean_speed(motion: Series) -> float:
    """Compute the mean speed of the gear, opposite to the crank [rad/s], over full turns."""
    speed = motion.gear_speed.simulated[motion.whole_periods]
    return -float(np.mean(speed)) * float(np.sign(motion.design.drive.speed))


def transmission_error(motion: Series) -> float:
    """Compute the transmission error of the gear, peak to peak [arcsec]."""
    return judge(motion).gear_transmission_error.peak_to_peak_arcsec
