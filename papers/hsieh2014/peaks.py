"""Impact peaks: at no load parts strike each other between samples. As forces of a run, and by crank angle."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter1d

from cycloid_mj.comparison import gravity_turn, settled
from cycloid_mj.design import Design
from cycloid_mj.names import FORCE_X, FORCE_Y, MOMENT, PEAK_FORCE, column
from cycloid_mj.record import Run
from cycloid_mj.types import Array

BINS = 36
"""Parts of a crank turn: ten degrees each, a mesh period of the paper's ring."""


def peak(run: Run, pair: str, window: int = 1) -> Array:
    """Give the largest force of a pair [N], shape (n,), over so many samples about each one.

    A log has at each sample the largest since the one before; of friction it knows the sample's own.
    """
    sampled = np.hypot(run[column(pair, FORCE_X)], run[column(pair, FORCE_Y)])
    largest = np.maximum(sampled, run[column(pair, PEAK_FORCE)])
    return np.asarray(maximum_filter1d(largest, 2 * (window // 2) + 1, mode="nearest"))


def at_peaks(run: Run, window: int = 1) -> Run:
    """Give a run in which every pair has, at each sample, its largest force over so many samples about it.

    All peaks of a window act at once, though they fell one after the other: that is on the safe side for the stress,
    which grows with each force, but where forces would relieve each other. A force keeps its direction; one that only
    peaked between samples has that of the nearest sample at which its pair touched.
    """
    changed: dict[str, Array] = {}
    for pair in run.by_stem(PEAK_FORCE):
        names = [column(pair, part) for part in (FORCE_X, FORCE_Y, MOMENT)]
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


def by_angle(run: Run, among: Sequence[str]) -> Array:
    """Give the largest force of any of some pairs [N] in each bin of the crank turn, shape (BINS,).

    The crank angle is counted from gravity, so that starts at all phases share one axis.
    """
    motion = settled(run)
    force = np.max([peak(run, pair) for pair in among], axis=0)[motion.hold]
    turned = np.mod(motion.crank_angle[motion.hold] - gravity_turn(motion.design), 2 * np.pi)
    number = np.minimum((turned * BINS / (2 * np.pi)).astype(int), BINS - 1)
    found = np.zeros(BINS)
    np.maximum.at(found, number, force)
    return found


def middle(number: int) -> float:
    """Give the middle of a bin [deg]."""
    return (number + 0.5) * 360.0 / BINS


def largest_of_halves(force: Array) -> tuple[float, float]:
    """Give where a curve over the bins is largest in each half turn [deg]."""
    half = BINS // 2
    return middle(int(np.argmax(force[:half]))), middle(half + int(np.argmax(force[half:])))


def share_near(force: Array, reach: float) -> float:
    """Give the share of a curve's sum that lies within so many degrees of crank angle 0, to either side."""
    bins = round(reach * BINS / 360.0)
    total = float(force.sum())
    return float(force[:bins].sum() + force[-bins:].sum()) / total if total else 0.0


def standing_for_pin_1(design: Design) -> int:
    """Give the number of the ring pin, or lobe, that a start has where gravity finds pin 1: as far from straight up."""
    pitches = round(gravity_turn(design) * design.ring.teeth / (2 * np.pi))
    return (-pitches) % design.ring.teeth + 1


def likeness(curves: Sequence[Array]) -> tuple[float, ...]:
    """Give the correlation of each curve with the mean of the others: 1 where each start repeats the same."""
    return tuple(
        float(np.corrcoef(curve, np.mean([other for other in curves if other is not curve], axis=0))[0, 1])
        for curve in curves
    )
