"""Runs whose contact forces are impact peaks: at no load parts strike each other between samples."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter1d

from cycloid_mj.record import Run
from cycloid_mj.types import Array

ENDING = "_peak_force"
COMPONENTS = ("_force_x", "_force_y", "_moment")


def pairs(run: Run) -> list[str]:
    """Name the mating pairs of a run whose peaks it has."""
    found = (name.removesuffix(ENDING) for name in run.columns if name.endswith(ENDING))
    return [name for name in found if f"{name}_force_x" in run.columns]


def peak(run: Run, pair: str, window: int = 1) -> Array:
    """Give the largest force of a pair [N], shape (n,), over so many samples about each one.

    A log has at each sample the largest since the one before; of friction it knows the sample's own.
    """
    sampled = np.hypot(run[f"{pair}_force_x"], run[f"{pair}_force_y"])
    largest = np.maximum(sampled, run[f"{pair}{ENDING}"])
    return np.asarray(maximum_filter1d(largest, 2 * (window // 2) + 1, mode="nearest"))


def at_peaks(run: Run, window: int = 1) -> Run:
    """Give a run in which every pair has, at each sample, its largest force over so many samples about it.

    All peaks of a window act at once, though they fell one after the other: that is on the safe side for the stress,
    which grows with each force, but where forces would relieve each other. A force keeps its direction; one that only
    peaked between samples has that of the nearest sample at which its pair touched.
    """
    changed: dict[str, Array] = {}
    for pair in pairs(run):
        names = [f"{pair}{ending}" for ending in COMPONENTS]
        logged = run.block(names)
        size = np.hypot(logged[:, 0], logged[:, 1])
        touching = np.flatnonzero(size > 0.0)
        if touching.size == 0:
            continue
        nearest = touching[_nearest(touching, len(run))]
        scaled = logged[nearest] * (peak(run, pair, window) / size[nearest])[:, np.newaxis]
        changed |= dict(zip(names, scaled.T, strict=True))
    return replace(run, columns={**run.columns, **changed})


def _nearest(rows: npt.NDArray[np.intp], count: int) -> npt.NDArray[np.intp]:
    """Give for each of `count` samples the place in `rows`, which rise, of the one nearest to it."""
    every = np.arange(count)
    after = np.clip(np.searchsorted(rows, every), 0, rows.size - 1)
    before = np.maximum(after - 1, 0)
    return np.where(np.abs(rows[before] - every) <= np.abs(rows[after] - every), before, after)
