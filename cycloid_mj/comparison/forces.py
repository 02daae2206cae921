"""Which teeth carry force, and how much: forces of the mating pairs along a run."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.base.array import Array
from cycloid_mj.comparison.fluctuation import turns


@dataclass(frozen=True)
class ForceSummary:
    """Teeth that carry force, and forces [N], over whole crank turns.

    A tooth is a ring pin, or a lobe of the internal gear with all its contact lines. `tooth_mean_n` is the mean over
    time of the force on the most loaded tooth; peaks are the largest of any sample. Of several discs teeth are counted
    on all, and the forces are those of the contact, the cam and the pin that bear most on any of them.
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
    """Size of the force of each tooth of the ring on each of D discs [N], shape (n, D N)."""
    return _sizes(motion, motion.design.tooth_pair)


def cam_force(motion: Series) -> Array:
    """Size of the force of the cam on the gear that the series follows [N], shape (n,)."""
    return _sizes(motion, "cam")[:, motion.disc]


def forces(motion: Series) -> ForceSummary:
    """Measure the forces of a run."""
    parts = turns(motion)
    rows = slice(parts[0].start, parts[-1].stop)
    teeth, cam = tooth_forces(motion)[rows], _sizes(motion, "cam")[rows]
    output = _sizes(motion, "output")[rows]
    loaded, largest = np.count_nonzero(teeth, axis=1), teeth.max(axis=1)
    return ForceSummary(
        teeth_mean=float(loaded.mean()),
        teeth_least=int(loaded.min()),
        teeth_most=int(loaded.max()),
        tooth_mean_n=float(largest.mean()),
        tooth_peak_n=float(largest.max()),
        cam_mean_n=float(cam.max(axis=1).mean()),
        cam_peak_n=float(cam.max()),
        output_pin_peak_n=float(output.max()),
    )


def _sizes(motion: Series, kind: str) -> Array:
    force = motion.run.forces(kind)
    return np.hypot(force[..., 0], force[..., 1])
