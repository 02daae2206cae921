"""Spectra: amplitudes by order, power spectral densities by frequency, and the low-pass filter before decimation.

An order is a number of cycles per turn of the crank. `periodic_orders` is for values at even crank steps that repeat:
it is exact. `tapered_orders` is for logs, whose samples are even in time while the crank's speed varies, and whose
signals need not repeat in the window: it resamples by band-limited interpolation and applies a Hann window. Amplitudes
of cosines are right within 1 % between ``SPECTRUM.min_cycles`` cycles in the window and ``SPECTRUM.band`` of the
sampling rate; linear interpolation would lose 7 % at 0.15 of the rate and nearly half at 0.4.
"""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.notebook_display import Presented


@dataclass(frozen=True)
class SpectrumSettings:
    """Settings of band-limited interpolation, Hann-windowed spectra and the decimation filter."""

    band: float = 0.4
    """Highest frequency of a spectrum, as a share of the sampling rate."""
    min_cycles: float = 3.0
    """Fewest cycles in the window at which any cosine is right within 1 %; a cosine of an integer number of cycles is
    right below it, too, at its own order."""
    reach: int = 16
    """Samples on either side that a value between samples is interpolated from."""
    kaiser_beta: float = 9.0
    """Parameter beta of the Kaiser window: ripple 1e-4."""
    padding: int = 8
    """Orders per cycle in the window (zero padding), so that a peak between two cycles is not too low."""
    hann_bandwidth: float = 1.5
    """Equivalent noise bandwidth of a Hann window, in cycles of the window."""
    decimation_reach: int = 10
    """Half length of the decimation filter, in samples of the new rate."""
    decimation_beta: float = 6.0
    """Parameter beta of its Kaiser window: attenuation to 1e-3."""
    step_rtol: float = 1e-6
    """Relative tolerance of the even steps of the crank."""
    missing_cycle_share: float = 0.02
    """Share of a cycle by which a window may be shorter than full cycles."""


SPECTRUM = SpectrumSettings()


@dataclass(frozen=True, eq=False, repr=False)
class Orders(Presented):
    """A spectrum by order.

    Attributes
    ----------
    base
        Cycles per crank turn of the lowest order that is resolved [1].
    order
        Orders [1], increasing, shape (n,).
    amplitude
        Half of the peak-to-peak value of a cosine of each order, in the values' unit, shape (n,).
    band
        Lowest and highest order whose amplitude is right within 1 % [1].
    cycles
        Full cycles of the base in the window.
    spread
        Number of orders over which the power of a cosine is spread; 1 if it appears in its own order only.
    """

    base: float
    order: Array
    amplitude: Array
    band: tuple[float, float]
    cycles: int
    spread: float = 1.0

    @property
    def frame(self) -> Frame:
        """The orders, one per row."""
        return Frame({"order": self.order, "amplitude": self.amplitude})

    @property
    def line(self) -> str:
        """Number of orders, and the largest amplitude."""
        strongest = int(np.argmax(self.amplitude))
        return f"{len(self.order)} orders; largest {self.amplitude[strongest]:.4g} at {self.order[strongest]:.4g}"

    def rms(self, kept: Mask) -> float:
        """Compute the rms value of the signal that consists of the orders in the mask `kept`."""
        return float(np.sqrt(0.5 * np.sum(self.amplitude[kept] ** 2) / self.spread))


def periodic_orders(
    crank_angle: Array, values: Array, cycles_per_turn: float = 1.0, max_order: float = np.inf
) -> Orders:
    """Compute the amplitudes of periodic values by order, by a discrete Fourier transform over all full cycles.

    An order is a number of cycles per crank turn. The mean (order 0) is omitted, as is the order at two samples per
    cycle.

    Parameters
    ----------
    crank_angle
        Crank angles [rad] at even steps, increasing, an integer number of steps in a cycle, shape (n,) for n samples.
    values
        Values at these angles in any unit, shape (n,).
    cycles_per_turn
        Cycles of the periodic values in a crank turn [1].
    max_order
        Largest order to return [1].

    Raises
    ------
    UsageError
        The steps are not even, or do not fit in a cycle, or there is no full cycle.
    """
    period, increment = 2.0 * np.pi / cycles_per_turn, float(crank_angle[-1] - crank_angle[0]) / (len(crank_angle) - 1)
    cycle_count = int((len(crank_angle) * increment) / period + SPECTRUM.step_rtol)
    point_count = round(cycle_count * period / increment)
    is_uneven = np.abs(np.diff(crank_angle) - increment).max() > SPECTRUM.step_rtol * increment
    if (
        cycle_count < 1
        or is_uneven
        or abs(point_count * increment - cycle_count * period) > SPECTRUM.step_rtol * period
    ):
        problem = f"have steps of {np.degrees(increment):.6g} deg, which do not divide full cycles"
        if is_uneven:
            problem = "are not equally spaced"
        elif cycle_count < 1:
            problem = f"cover only {np.degrees(len(crank_angle) * increment):.6g} deg"
        raise UsageError(
            "the spectrum needs equally spaced crank angles whose step divides full cycles of "
            f"{np.degrees(period):.6g} deg, but the {len(crank_angle)} angles {problem}: sample the signal again"
        )
    amplitude = 2.0 / point_count * np.abs(np.fft.rfft(values[:point_count]))
    order = cycles_per_turn * np.arange(amplitude.size) / cycle_count
    nyquist_order = 0.5 * cycles_per_turn * point_count / cycle_count
    is_selected = (order > 0.0) & (order <= max_order) & (order < nyquist_order)
    return Orders(
        cycles_per_turn,
        order[is_selected],
        amplitude[is_selected],
        (cycles_per_turn / cycle_count, min(max_order, nyquist_order)),
        cycle_count,
    )


def tapered_orders(
    angle: Array, values: Array, max_order: float = np.inf, cycles_per_turn: float = 1.0
) -> Orders | None:
    """Compute the amplitudes of logged values by order, over all full cycles; the mean is subtracted.

    An order is a number of cycles per crank turn. The values are interpolated at even crank angles, and a Hann window
    is applied.

    Parameters
    ----------
    angle
        The n crank angles [rad] at even times, strictly increasing or decreasing, shape (n,).
    values
        Values at these angles in any unit, shape (n,).
    max_order
        Largest order to return [1]; it is limited to ``SPECTRUM.band`` times the number of samples per crank turn.
    cycles_per_turn
        Number of periods of the signal in a crank turn [1]; as many full periods as the samples cover are evaluated.

    Returns
    -------
    Orders or None
        Orders and amplitudes. None if there are fewer values than twice ``SPECTRUM.reach``, if they cover less than a
        period, or if the crank reverses or stops.
    """
    swept_cycles = cycles_per_turn * np.abs(angle - angle[0]) / (2.0 * np.pi)
    if len(swept_cycles) < 2 * SPECTRUM.reach or (np.diff(swept_cycles) <= 0.0).any():
        return None
    sampled_cycles = float(swept_cycles[-1]) * len(swept_cycles) / (len(swept_cycles) - 1)
    cycles = int(sampled_cycles + SPECTRUM.missing_cycle_share)
    if cycles < 1:
        return None
    point_count = int(np.ceil(cycles / sampled_cycles * len(swept_cycles)))
    sample_numbers = _invert_samples(swept_cycles, cycles * np.arange(point_count) / point_count)
    even_samples = between_samples(values, sample_numbers)
    window = np.hanning(point_count + 1)[:-1]
    amplitude = (
        2.0
        * np.abs(np.fft.rfft(window * (even_samples - even_samples.mean()), SPECTRUM.padding * point_count))
        / np.sum(window)
    )
    order = cycles_per_turn * np.arange(amplitude.size) / (SPECTRUM.padding * cycles)
    highest_order = min(max_order, SPECTRUM.band * cycles_per_turn * len(swept_cycles) / sampled_cycles)
    is_kept = (order > 0.0) & (order <= highest_order)
    band = SPECTRUM.min_cycles * cycles_per_turn / cycles, highest_order
    return Orders(
        cycles_per_turn, order[is_kept], amplitude[is_kept], band, cycles, SPECTRUM.hann_bandwidth * SPECTRUM.padding
    )


def _invert_samples(increasing: Array, targets: Array) -> Array:
    """Compute the fractional sample numbers (k,) at which n increasing values reach k target values.

    At least 4 samples are needed. Lagrange's cubic interpolation is accurate to 1e-5 samples, because the crank angle
    of a run is smooth. SciPy's splines are not used, because their import takes longer than the evaluation of a run.
    """
    first_index = np.clip(np.searchsorted(increasing, targets) - 2, 0, len(increasing) - 4)
    node_values = increasing[first_index + np.arange(4)[:, np.newaxis]]
    sample_numbers = np.zeros(len(targets))
    for node_index in range(4):
        other_nodes = [node for node in range(4) if node != node_index]
        weight = np.prod(
            [(targets - node_values[node]) / (node_values[node_index] - node_values[node]) for node in other_nodes],
            axis=0,
        )
        sample_numbers += weight * (first_index + node_index)
    return sample_numbers


def between_samples(values: Array, sample_numbers: Array) -> Array:
    """Interpolate a band-limited signal between evenly spaced samples, with a Kaiser-windowed sinc kernel.

    It is accurate to 1e-3 up to ``SPECTRUM.band`` of the sampling rate.

    Parameters
    ----------
    values
        The n samples, shape (n,); they are extended at both ends by odd reflection.
    sample_numbers
        Sample numbers, from 0 to n - 1 or little more, that need not be integers, shape (k,).

    Returns
    -------
    Array
        Interpolated values, shape (k,).
    """
    padded_values = np.pad(values, SPECTRUM.reach, mode="reflect", reflect_type="odd")
    index = np.clip(np.floor(sample_numbers).astype(np.int64), 0, len(values) - 1)
    weighted_sum, weights = np.zeros(len(sample_numbers)), np.zeros(len(sample_numbers))
    for offset in range(1 - SPECTRUM.reach, SPECTRUM.reach + 1):
        distance = sample_numbers - index - offset
        weight = np.sinc(distance) * np.i0(
            SPECTRUM.kaiser_beta * np.sqrt(np.clip(1.0 - (distance / SPECTRUM.reach) ** 2, 0.0, 1.0))
        )
        weighted_sum += weight * padded_values[index + offset + SPECTRUM.reach]
        weights += weight
    return np.asarray(weighted_sum / weights)


def decimate(values: Array, factor: int, means: bool = False) -> Array:
    """Reduce the sampling rate of a signal by a factor, after a low-pass filter that prevents aliasing.

    The filter is a linear-phase FIR filter with a Kaiser window. Frequencies above ``1 - SPECTRUM.band`` of the new
    rate are attenuated to 1e-3, those below ``SPECTRUM.band`` of it are kept.

    Parameters
    ----------
    values
        The n evenly spaced samples of one or k signals, shape (n,) or (n, k).
    factor
        Old over new sampling rate; 1 returns the values unchanged.
    means
        Whether each value is the mean of the signal between two samples. The filter then also corrects the attenuation
        that such means cause.

    Returns
    -------
    Array
        Shape (ceil(n / factor),) or (ceil(n / factor), k). The first and last ``SPECTRUM.decimation_reach`` samples are
        less accurate, because the filter extends the signal beyond its ends.
    """
    if factor == 1:
        return values
    from scipy.signal import firwin2, upfirdn

    half_length, new_nyquist = SPECTRUM.decimation_reach * factor, 1.0 / factor
    frequency = np.linspace(
        0.0, new_nyquist, 1 + 2 ** (2 * half_length).bit_length()
    )  # the grid of firwin2 and points between
    gain = 1.0 / np.sinc(0.5 * frequency) if means else np.ones(frequency.size)
    filter_taps = firwin2(
        2 * half_length + 1,
        [*frequency, new_nyquist, 1.0],
        [*gain, 0.0, 0.0],
        window=("kaiser", SPECTRUM.decimation_beta),
    )
    margins = ((half_length, half_length), *[(0, 0)] * (values.ndim - 1))
    padded = np.pad(values, margins, mode="reflect", reflect_type="odd")
    start_index = 2 * half_length // factor
    return np.asarray(
        upfirdn(filter_taps, padded, down=factor, axis=0)[start_index : start_index + math.ceil(len(values) / factor)]
    )


def density(values: Array, rate: float, segment: int) -> tuple[Array, Array]:
    """Compute frequencies [Hz] and one-sided power spectral densities by Welch's method.

    The segments have Hann windows and overlap by half.

    Parameters
    ----------
    values
        The n evenly spaced samples of one or k signals, shape (n,) or (n, k).
    rate
        Sampling rate [Hz].
    segment
        Number of samples in a segment.

    Returns
    -------
    tuple of Array
        Frequencies, shape (m,), and densities in squares of the values' unit per Hz, shape (m,) or (m, k). Frequencies
        above ``SPECTRUM.band`` of the rate are omitted.
    """
    from scipy.signal import welch

    frequency, power = welch(values, rate, nperseg=segment, axis=0)
    is_in_band = frequency <= SPECTRUM.band * rate
    return frequency[is_in_band], power[is_in_band]
