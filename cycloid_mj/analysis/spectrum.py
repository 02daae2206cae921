"""The one spectrum of the project: amplitudes by order, densities by frequency, and the filter before sampling less.

An order is a number of cycles in a turn of the crank. `periodic_orders` is for values at even steps of the crank that
repeat: it is exact. `tapered_orders` is for logs, whose samples are even in time while the crank's speed sways, and
whose signals need not repeat in the window: values between samples are those of the band-limited signal through them,
and a Hann window keeps apart what does not fit. It reads a cosine within 1 % of its amplitude between ``LOWEST`` cycles
in the window and ``BAND`` of the sampling rate; straight lines between samples would take 7 % at 0.15 of the rate and
nearly half of it at 0.4.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.notebook_display import Presented

BAND = 0.4
"""Highest frequency that is given, as a share of the sampling rate."""

LOWEST = 3.0
"""Least number of cycles in the window at which any cosine is read within 1 %; one that fits in whole is below it, too,
at its own order."""

REACH = 16
"""Samples on either side that a value between samples is made of."""

SHARPNESS = 9.0
"""Kaiser's beta of the windows: ripples of 1e-4."""

PADDING = 8
"""Orders given for each cycle in the window, so that one that lies between is not read too low."""

HANN_BANDWIDTH = 1.5
"""Equivalent noise bandwidth of a Hann window, in cycles of the window."""

EVEN = 1e-6
"""Relative; by how much steps of the crank may differ."""

SHORT = 0.02
"""Share of a cycle by which a window may fall short of whole ones."""


@dataclass(frozen=True, eq=False, repr=False)
class Orders(Presented):
    """A spectrum by order.

    Attributes
    ----------
    base
        Cycles in a crank turn of the first of the orders that are told apart [1].
    order
        Orders [1], increasing, shape (n,).
    amplitude
        Half of the peak-to-peak value of a cosine of each order, in the values' unit, shape (n,).
    band
        Lowest and highest order that is read within 1 % [1].
    cycles
        Whole cycles of the base in the window.
    spread
        Orders that one cosine shows in, as a power: 1 where each is given once.
    """

    base: float
    order: Array
    amplitude: Array
    band: tuple[float, float]
    cycles: int
    spread: float = 1.0

    @property
    def frame(self) -> Frame:
        """Its orders, a row each."""
        return Frame({"order": self.order, "amplitude": self.amplitude})

    @property
    def line(self) -> str:
        """How many there are, and the largest."""
        largest = int(np.argmax(self.amplitude))
        return f"{len(self.order)} orders; largest {self.amplitude[largest]:.4g} at {self.order[largest]:.4g}"

    def rms(self, kept: Mask) -> float:
        """Compute the rms value of some orders together."""
        return float(np.sqrt(0.5 * np.sum(self.amplitude[kept] ** 2) / self.spread))


def periodic_orders(crank: Array, values: Array, base: float = 1.0, most: float = np.inf) -> Orders:
    """Compute the orders of values that repeat, over as many whole cycles as there are.

    Parameters
    ----------
    crank
        Crank angles [rad] at even steps, increasing, a whole number of them in a cycle, shape (n,).
    values
        Shape (n,).
    base
        Cycles in a crank turn of what the values repeat with [1].
    most
        The largest order that is given [1]; at most that of two samples in a cycle.

    Raises
    ------
    UsageError
        The steps are not even, or do not fit in a cycle, or there is no whole cycle.
    """
    period, step = 2.0 * np.pi / base, float(crank[-1] - crank[0]) / (len(crank) - 1)
    cycles = int((len(crank) * step) / period + EVEN)
    points = round(cycles * period / step)
    uneven = np.abs(np.diff(crank) - step).max() > EVEN * step
    if cycles < 1 or uneven or abs(points * step - cycles * period) > EVEN * period:
        raise UsageError(
            f"{len(crank)} crank angles over {np.degrees(crank[-1] - crank[0]):.6g} deg are no even division of whole "
            f"cycles of {np.degrees(period):.6g} deg: sample at even angles, a whole number in a cycle"
        )
    amplitude = 2.0 / points * np.abs(np.fft.rfft(values[:points]))
    order = base * np.arange(amplitude.size) / cycles
    highest = 0.5 * base * points / cycles
    kept = (order > 0.0) & (order <= most) & (order < highest)
    return Orders(base, order[kept], amplitude[kept], (base / cycles, min(most, highest)), cycles)


def tapered_orders(angle: Array, values: Array, most: float = np.inf, base: float = 1.0) -> Orders | None:
    """Compute the orders of logged values about their mean, over as many whole cycles of a base as there are.

    Parameters
    ----------
    angle
        Crank angles [rad] at even times, strictly increasing or decreasing, shape (n,).
    values
        Shape (n,).
    most
        The largest order that is given [1]; at most ``BAND`` of the samples in a turn.
    base
        Cycles in a crank turn of which the window is to hold whole ones [1]; by default whole turns.

    Returns
    -------
    Orders or None
        None where there is not one whole cycle.
    """
    swept = base * np.abs(angle - angle[0]) / (2.0 * np.pi)
    if len(swept) < 2 * REACH or (np.diff(swept) <= 0.0).any():
        return None
    sampled = float(swept[-1]) * len(swept) / (len(swept) - 1)
    cycles = int(sampled + SHORT)
    if cycles < 1:
        return None
    points = int(np.ceil(cycles / sampled * len(swept)))
    places = _inverse(swept, cycles * np.arange(points) / points)
    even = between_samples(values, places)
    taper = np.hanning(points + 1)[:-1]
    amplitude = 2.0 * np.abs(np.fft.rfft(taper * (even - even.mean()), PADDING * points)) / np.sum(taper)
    order = base * np.arange(amplitude.size) / (PADDING * cycles)
    highest = min(most, BAND * base * len(swept) / sampled)
    kept = (order > 0.0) & (order <= highest)
    band = LOWEST * base / cycles, highest
    return Orders(base, order[kept], amplitude[kept], band, cycles, HANN_BANDWIDTH * PADDING)


def _inverse(rising: Array, targets: Array) -> Array:
    """Return at which sample number, between samples, rising values (n,) reach targets (k,): by Lagrange's cubic.

    The crank angle of a run is so smooth that this is right to 1e-5 samples; to import SciPy's splines for it takes
    longer than to judge a run.
    """
    first = np.clip(np.searchsorted(rising, targets) - 2, 0, len(rising) - 4)
    nodes = rising[first + np.arange(4)[:, np.newaxis]]
    numbers = np.zeros(len(targets))
    for node in range(4):
        others = [other for other in range(4) if other != node]
        weight = np.prod([(targets - nodes[other]) / (nodes[node] - nodes[other]) for other in others], axis=0)
        numbers += weight * (first + node)
    return numbers


def between_samples(values: Array, places: Array) -> Array:
    """Compute the band-limited signal through even samples, right to 1e-3 up to ``BAND`` of their rate.

    Parameters
    ----------
    values
        Samples, shape (n,); beyond both ends they are taken to go on turned by half a turn about the end.
    places
        Where to read it, in samples from the first, from 0 to n - 1 or little more, shape (k,).
    """
    ahead = np.pad(values, REACH, mode="reflect", reflect_type="odd")
    first = np.clip(np.floor(places).astype(np.int64), 0, len(values) - 1)
    total, weights = np.zeros(len(places)), np.zeros(len(places))
    for offset in range(1 - REACH, REACH + 1):
        away = places - first - offset
        weight = np.sinc(away) * np.i0(SHARPNESS * np.sqrt(np.clip(1.0 - (away / REACH) ** 2, 0.0, 1.0)))
        total += weight * ahead[first + offset + REACH]
        weights += weight
    return np.asarray(total / weights)


def thinned(values: Array, every: int, means: bool = False) -> Array:
    """Keep one of `every` samples, after a filter that takes away what would fold into the band.

    Parameters
    ----------
    values
        Even samples, shape (n,) or (n, k).
    every
        What is above ``1 - BAND`` of the new rate is taken away to 1e-3, what is below ``BAND`` of it kept.
    means
        Whether each value is a mean from one sample to the next, which reads high frequencies too low: made good.

    Returns
    -------
    Array
        Shape (ceil(n / every),) or (ceil(n / every), k); the first and last 10 of them feel the ends.
    """
    if every == 1:
        return values
    taps = low_pass(every, means)
    columns = values.reshape(len(values), -1)
    ends = len(taps) // 2
    ahead = np.pad(columns, ((ends, ends), (0, 0)), mode="reflect", reflect_type="odd")
    kept = sliding_window_view(ahead, len(taps), axis=0)[::every] @ taps  # taps read alike from both ends
    return np.asarray(kept.reshape(-1, *values.shape[1:]))


def low_pass(every: int, means: bool = False) -> Array:
    """Compute the filter of `thinned`, shape (20 every + 1,): its response by frequency, under a Kaiser window.

    The response is sampled finely and transformed back, as SciPy's ``firwin2`` does; to load ``scipy.signal`` takes
    longer than all the filtering of a measure.
    """
    ends = 10 * every
    frequency = np.linspace(0.0, 0.5, 1 + 2 ** math.ceil(math.log2(2 * ends + 1)))
    beyond = frequency * every - 0.5
    response = np.where(beyond < 0.0, 1.0, np.where(beyond > 0.0, 0.0, 0.5))
    if means:
        response /= np.sinc(np.minimum(frequency, 0.5 / every))
    pulse = np.fft.irfft(response)
    return np.concatenate([pulse[-ends:], pulse[: ends + 1]]) * np.kaiser(2 * ends + 1, 6.0)


def density(values: Array, rate: float, segment: int) -> tuple[Array, Array]:
    """Compute frequencies [Hz] and one-sided power spectral densities by Welch's method, Hann windows half laid over.

    Parameters
    ----------
    values
        Even samples, shape (n,) or (n, k).
    rate
        Samples per second.
    segment
        Samples in a segment.

    Returns
    -------
    tuple of Array
        Up to ``BAND`` of the rate: shapes (m,), and (m,) or (m, k) in squares of the values' unit per Hz.
    """
    from scipy.signal import welch

    frequency, power = welch(values, rate, nperseg=segment, axis=0)
    kept = frequency <= BAND * rate
    return frequency[kept], power[kept]
