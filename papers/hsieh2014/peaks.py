"""Impact peaks: largest forces between the samples of a run without load, over time and over the crank angle."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter1d
from scipy.signal import find_peaks

from cycloid_mj.analysis.series import design_of
from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.comparison import gravity_turn, settle_run
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer

PIN_1 = "pin_1"

BINS = 36
"""Parts of a crank turn: ten degrees each, a mesh period of the paper's ring."""


def peak(run: Run, pair: str, window: int = 1) -> Array:
    """Compute the largest force of a pair [N], shape (n,), over a window of samples around each sample.

    A log has the largest normal force since the previous sample; friction is that of the sample itself.
    """
    sampled = np.hypot(run[names.column(pair, names.FORCE_X)], run[names.column(pair, names.FORCE_Y)])
    largest = np.maximum(sampled, run[names.column(pair, names.PEAK_FORCE)])
    return np.asarray(maximum_filter1d(largest, 2 * (window // 2) + 1, mode="nearest"))


def pairs_on(run: Run, part: str) -> list[str]:
    """List the contact pairs of a run whose forces act on a part; on pin 1 only the contact with the gear.

    Pin 1 is the pin, or lobe, at the position of pin 1 relative to gravity.
    """
    ring = next(stem for stem in (names.SOCKET, names.LOBE, names.PIN) if run.pairs(names.KINDS[stem]))
    if part == PIN_1:
        return [f"{names.LOBE if ring == names.LOBE else names.PIN}_{standing_for_pin_1(design_of(run))}"]
    stems = {
        names.SHAFT: (names.CAM,),
        "ring": (ring,),
        "gear": (names.CAM, names.PIN, names.LOBE, names.OUTPUT_PIN),
        names.OUTPUT: (names.OUTPUT_PIN,),
    }[part]
    return [name for stem in stems for name in run.pairs(names.KINDS[stem])]


def largest_force(run: Run, among: Sequence[str]) -> float:
    """Return the largest force [N] of some pairs in the settled part of the run."""
    hold = settle_run(run).hold
    return max(float(peak(run, pair)[hold].max()) for pair in among)


def at_peaks(run: Run, window: int = 1) -> Run:
    """Return a run in which every pair has, at each sample, its largest force over a window around it.

    All peaks of a window act at once, although they occurred one after the other. This is conservative, because stress
    grows with each force, except where forces relieve each other. A force keeps its direction; if it occurred only
    between samples, it has the direction of the nearest sample with contact.
    """
    changed: dict[str, Array] = {}
    for pair in run.by_stem(names.PEAK_FORCE):
        columns = [names.column(pair, part) for part in (names.FORCE_X, names.FORCE_Y, names.MOMENT)]
        logged = run.block(columns)
        size = np.hypot(logged[:, 0], logged[:, 1])
        touching = np.flatnonzero(size > 0.0)
        if touching.size == 0:
            continue
        nearest = touching[_nearest(touching, len(run))]
        scaled = logged[nearest] * (peak(run, pair, window) / size[nearest])[:, np.newaxis]
        changed |= dict(zip(columns, scaled.T, strict=True))
    return replace(run, columns={**run.columns, **changed})


def _nearest(rows: npt.NDArray[np.intp], count: int) -> npt.NDArray[np.intp]:
    """Return for each of `count` samples the index of the nearest value in the ascending `rows`."""
    every = np.arange(count)
    after = np.clip(np.searchsorted(rows, every), 0, rows.size - 1)
    before = np.maximum(after - 1, 0)
    return np.where(np.abs(rows[before] - every) <= np.abs(rows[after] - every), before, after)


def by_angle(run: Run, among: Sequence[str]) -> Array:
    """Compute the largest force of any of some pairs [N] in each bin of the crank turn, shape (BINS,).

    The crank angle is measured from the direction of gravity, so that starts at all phases share one axis.
    """
    return curves_by_angle(run, {"": among})[""]


def curves_by_angle(run: Run, of_parts: Mapping[str, Sequence[str]]) -> dict[str, Array]:
    """Compute the largest force on each part in each bin of the crank turn [N], shape (BINS,), by part.

    `of_parts` are the pairs that act on each part. The crank angle is measured from the direction of gravity.
    """
    motion = settle_run(run)
    forces = {
        part: np.max([peak(run, pair) for pair in among], axis=0)[motion.hold] for part, among in of_parts.items()
    }
    turned = np.mod(motion.crank_angle[motion.hold] - gravity_turn(motion.reducer), 2 * np.pi)
    number = np.minimum((turned * BINS / (2 * np.pi)).astype(int), BINS - 1)
    largest = {part: np.zeros(BINS) for part in forces}
    for part, force in forces.items():
        np.maximum.at(largest[part], number, force)
    return largest


def middle(number: int) -> float:
    """Return the centre of a bin [deg]."""
    return (number + 0.5) * 360.0 / BINS


def largest_of_halves(force: Array) -> tuple[float, float]:
    """Return where a curve over the bins is largest in each half turn [deg]."""
    half = BINS // 2
    return middle(int(np.argmax(force[:half]))), middle(half + int(np.argmax(force[half:])))


@dataclass(frozen=True)
class PeakCurveSettings:
    """Bins of a curve over the crank turn, and what counts as one of its maxima."""

    harmonics: int = 6
    prominence: float = 0.15
    """Highest crank order kept for counting maxima, and the least prominence of a maximum as a share of the range."""


CURVE = PeakCurveSettings()


def maxima(force: npt.ArrayLike) -> tuple[float, ...]:
    """Return the crank angles [deg] of the maxima of a curve over the bins of a turn, smoothed, shape (BINS,).

    Orders above `CURVE.harmonics` are filtered out; maxima of low prominence do not count.
    """
    orders = np.fft.rfft(np.asarray(force, float))
    orders[CURVE.harmonics + 1 :] = 0.0
    smooth = np.fft.irfft(orders, BINS)
    swing = float(np.ptp(smooth))
    if swing == 0.0:
        return ()
    # twice round from the least on, so that no maximum lies at an end
    least = int(np.argmin(smooth))
    peaks, _ = find_peaks(np.roll(np.tile(smooth, 2), -least)[: BINS + 1], prominence=CURVE.prominence * swing)
    return tuple(sorted(middle((int(index) + least) % BINS) for index in peaks))


def share_near(force: Array, reach: float) -> float:
    """Compute the share of a curve's sum that lies within `reach` [deg] of crank angle 0, on either side."""
    bins = round(reach * BINS / 360.0)
    total = float(force.sum())
    return float(force[:bins].sum() + force[-bins:].sum()) / total if total else 0.0


def standing_for_pin_1(design: Design) -> int:
    """Return the number of the ring pin, or lobe, at the position of pin 1 relative to gravity."""
    pitches = round(gravity_turn(Reducer(design)) * design.ring.teeth / (2 * np.pi))
    return (-pitches) % design.ring.teeth + 1


def likeness(curves: Sequence[Array]) -> tuple[float, ...]:
    """Compute the correlation of each curve with the mean of the others; 1 if all starts are equal."""
    return tuple(
        float(np.corrcoef(curve, np.mean([other for other in curves if other is not curve], axis=0))[0, 1])
        for curve in curves
    )
