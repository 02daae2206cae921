"""The order spectrum of a run: amplitudes by cycles per crank turn."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.analysis import Series

Array = npt.NDArray[np.float64]

FEWEST = 16
"""Samples below which a spectrum says nothing."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Orders [cycles per crank turn] and amplitudes, both shape (m,), over a number of whole crank `turns`."""

    order: Array
    amplitude: Array
    turns: int


def order_spectrum(motion: Series, values: Array) -> Spectrum | None:
    """Give the spectrum of a column over the whole crank turns of the settled hold; None if there are none.

    The column is resampled evenly in crank angle, its mean is taken away, and a Hann window keeps what does not repeat
    with the turn from smearing; amplitudes are those of sines (a sine of amplitude 1 gives 1 at its order).
    """
    from scipy.interpolate import CubicSpline

    if motion.phase != "hold":
        return None
    part = motion.whole_periods
    angle = np.abs(motion.crank_angle[part] - motion.crank_angle[part.start]) / (2 * np.pi)
    sampled = angle.size / max(angle.size - 1, 1) * float(angle[-1])
    turns = round(sampled)
    if angle.size < FEWEST or turns < 1 or abs(sampled - turns) > 0.02 or (np.diff(angle) <= 0.0).any():
        return None
    # a spline: a line between samples would take 4 % from what repeats with ten samples
    even = CubicSpline(angle, values[part])(np.arange(angle.size) * turns / angle.size)
    window = np.hanning(even.size + 1)[:-1]
    amplitude = 2 * np.abs(np.fft.rfft(window * (even - even.mean()))) / window.sum()
    return Spectrum(np.arange(amplitude.size) / turns, amplitude, turns)
