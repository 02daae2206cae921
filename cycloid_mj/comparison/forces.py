"""Forces of the mating pairs in a run, and the teeth that carry them."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.base.array import Array
from cycloid_mj.comparison.fluctuation import full_turns


@dataclass(frozen=True)
class ForceSummary:
    """Numbers of teeth that carry force, and forces [N], over full crank turns.

    A tooth is a ring pin, or a lobe of the internal gear with all its contact lines. `tooth_mean_n` is the mean over
    time of the force on the most loaded tooth; peaks are the largest of any sample. Teeth are counted on all discs, and
    forces are those of the most loaded contact, cam and pin of any disc.
    """

    teeth_mean: float
    teeth_least: int
    teeth_most: int
    tooth_mean_n: float
    tooth_peak_n: float
    cam_mean_n: float
    cam_peak_n: float
    output_pin_peak_n: float


def tooth_forces(motion: Series) -> Array:
    """Compute the force of each tooth of the ring on each of D discs [N], shape (n, D N)."""
    return _force_magnitudes(motion, motion.design.tooth_pair)


def cam_force(motion: Series) -> Array:
    """Compute the force of the cam on the disc of the series [N], shape (n,)."""
    return _force_magnitudes(motion, "cam")[:, motion.disc]


def forces(motion: Series) -> ForceSummary:
    """Compute how many teeth carry force, and the forces of teeth, cams and output pins [N], over full crank turns.

    The samples are those of the hold after settling, or all of them if these are less than a turn.
    """
    turns = full_turns(motion)
    rows = slice(turns[0].start, turns[-1].stop)
    teeth, cams = tooth_forces(motion)[rows], _force_magnitudes(motion, "cam")[rows]
    output_pins = _force_magnitudes(motion, "output")[rows]
    loaded_teeth, largest_force = np.count_nonzero(teeth, axis=1), teeth.max(axis=1)
    return ForceSummary(
        teeth_mean=float(loaded_teeth.mean()),
        teeth_least=int(loaded_teeth.min()),
        teeth_most=int(loaded_teeth.max()),
        tooth_mean_n=float(largest_force.mean()),
        tooth_peak_n=float(largest_force.max()),
        cam_mean_n=float(cams.max(axis=1).mean()),
        cam_peak_n=float(cams.max()),
        output_pin_peak_n=float(output_pins.max()),
    )


def _force_magnitudes(motion: Series, kind: str) -> Array:
    force = motion.run.forces(kind)
    return np.hypot(force[..., 0], force[..., 1])
