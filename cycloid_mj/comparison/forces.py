"""Forces of the mating pairs in a run, and the teeth that carry them."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.base.array import Array
from cycloid_mj.base.names import CRANK_BEARING
from cycloid_mj.comparison.fluctuation import full_turns


@dataclass(frozen=True)
class ForceSummary:
    """Numbers of teeth that carry force, and forces [N], over full crank turns.

    A tooth is a ring pin, or a lobe of the internal gear with all its contact lines. `tooth_mean_n` is the mean over
    time of the force on the most loaded tooth; peaks are the largest of any sample. Teeth are counted on all discs, and
    forces are those of the most loaded contact of any disc: tooth, cam, output pin, or crank bearing and planet of an
    RV reducer. Forces of contacts that the reducer does not have are None.
    """

    teeth_mean: float
    teeth_least: int
    teeth_most: int
    tooth_mean_n: float
    tooth_peak_n: float
    cam_mean_n: float | None = None
    cam_peak_n: float | None = None
    output_pin_peak_n: float | None = None
    crank_bearing_mean_n: float | None = None
    crank_bearing_peak_n: float | None = None
    planet_mesh_peak_n: float | None = None


MEAN_AND_PEAK = {"cam": "cam", "crank_bearing": "crank_bearing"}
PEAK = {"output": "output_pin", "planet_mesh": "planet_mesh"}
"""Kinds of pairs -> stems of their attributes of `ForceSummary`: with mean and peak force, and with peak force only."""


def tooth_forces(motion: Series) -> Array:
    """Compute the force of each tooth of the ring on each of D discs [N], shape (n, D N)."""
    return _force_magnitudes(motion, motion.design.tooth_pair)


def crank_bearing_force(motion: Series) -> Array:
    """Compute the force of the most loaded crank bearing on the disc of the series [N], shape (n,); RV reducers."""
    force = _force_magnitudes(motion, CRANK_BEARING)
    return np.asarray(np.split(force, len(motion.reducer.gears), axis=1)[motion.disc].max(axis=1))


def cam_force(motion: Series) -> Array:
    """Compute the force of the cam on the disc of the series [N], shape (n,)."""
    return _force_magnitudes(motion, "cam")[:, motion.disc]


def forces(motion: Series) -> ForceSummary:
    """Compute how many teeth carry force, and the peak force [N] of each kind of mating pair, over full turns.

    The number of teeth is the mean, least and largest of the samples. Teeth, cams and crank bearings also have the mean
    of the largest force in each sample. `motion` are the time series of the run. The samples are those at constant
    speed after settling, or all of them if these are less than a turn.
    """
    turns = full_turns(motion)
    window = slice(turns[0].start, turns[-1].stop)
    tooth_force, kinds = tooth_forces(motion)[window], motion.reducer.mechanism.kinds
    maxima = {
        kind: _force_magnitudes(motion, kind)[window].max(axis=1) for kind in (*MEAN_AND_PEAK, *PEAK) if kind in kinds
    }
    means = {f"{stem}_mean_n": float(maxima[kind].mean()) for kind, stem in MEAN_AND_PEAK.items() if kind in maxima}
    stems = MEAN_AND_PEAK | PEAK
    peaks = {f"{stems[kind]}_peak_n": float(force.max()) for kind, force in maxima.items()}
    loaded_teeth, largest_force = np.count_nonzero(tooth_force, axis=1), tooth_force.max(axis=1)
    return ForceSummary(
        teeth_mean=float(loaded_teeth.mean()),
        teeth_least=int(loaded_teeth.min()),
        teeth_most=int(loaded_teeth.max()),
        tooth_mean_n=float(largest_force.mean()),
        tooth_peak_n=float(largest_force.max()),
        **means,
        **peaks,
    )


def _force_magnitudes(motion: Series, kind: str) -> Array:
    force = motion.run.forces(kind)
    return np.hypot(force[..., 0], force[..., 1])
