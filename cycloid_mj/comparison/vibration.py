"""Vibration of the disc's centre and of the output: acceleration relative to the closed form, and its spectrum."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.analysis.spectrum import density
from cycloid_mj.base.array import Array
from cycloid_mj.base.names import planar_speeds
from cycloid_mj.comparison.fluctuation import Level, compute_level, full_turns
from cycloid_mj.geometry import kinematics

OCTAVES = 1e3 * 2.0 ** np.arange(-5, 7)
"""Centres of the octave bands [Hz], those of IEC 61260."""
TURNS_PER_SEGMENT = 2
"""Crank turns of a segment of Welch's method (heuristic)."""


@dataclass(frozen=True, eq=False)
class Acceleration:
    """Accelerations minus their closed form (Eq. 12, Eq. 14 corrected) at the measured crank angle.

    Each value is the mean from one sample to the next. `centre` is that of the disc's centre [m/s^2], shape (n-1, 2);
    `output` that of the output's rotation [rad/s^2], shape (n-1,).
    """

    centre: Array
    output: Array


@dataclass(frozen=True, eq=False)
class Spectrum:
    """One-sided power spectral densities at `frequency` [Hz], up to ``spectrum.SPECTRUM.band`` of the log rate.

    Velocities are instantaneous samples, so vibration above half of the log rate is aliased from `rate` - f to f,
    reduced by f/(`rate` - f): to two thirds at the end of the band, to a tenth at a quarter of it. `centre`
    is the sum of both components [(m/s^2)^2/Hz]; `output` in [(rad/s^2)^2/Hz].
    """

    frequency: Array
    centre: Array
    output: Array


@dataclass(frozen=True)
class OctaveBand:
    """Rms accelerations of the disc's centre and of the output in the octave about `centre_hz`."""

    centre_hz: float
    gear_centre_m_s2: float
    output_rad_s2: float


@dataclass(frozen=True)
class VibrationLevels:
    """Rms accelerations relative to the closed form up to `band_hz`, half the log rate, and by full octaves.

    Means between samples read 36 % too low near half of the log rate; the octaves are corrected for that.
    """

    gear_centre_m_s2: Level
    output_rad_s2: Level
    band_hz: float
    octaves: tuple[OctaveBand, ...]


def acceleration(motion: Series) -> Acceleration:
    """Compute the accelerations of the disc's centre and of the output, minus those of the closed-form motion.

    `motion` are the time series of the run. They are mean values from one sample to the next, so n samples have n - 1
    accelerations, see `Acceleration`. The disc is `Series.disc`.
    """
    run, reducer = motion.run, motion.reducer
    angle, speed = (reducer.member.crank_angle(run[f"{reducer.INPUT}_{quantity}"]) for quantity in ("angle", "speed"))
    ideal_velocity = kinematics.gear_centre_velocity(reducer.tooth_profile, angle + reducer.phases[motion.disc], speed)
    velocity_error = run.block(planar_speeds(motion.gear)[:2]) - ideal_velocity
    interval = np.diff(motion.time)
    return Acceleration(
        np.diff(velocity_error, axis=0) / interval[:, np.newaxis], np.diff(motion.output_speed.error) / interval
    )


def spectrum(run_series: Series) -> Spectrum:
    """Compute power spectral densities of the accelerations of disc centre and output in a run, by Welch's method.

    The accelerations are those of `acceleration`: [m/s^2] and [rad/s^2], minus those of the ideal motion. `run_series`
    are the time series of the run, of which full crank turns are used. A segment of Welch's method has two turns, or
    all samples if there are fewer. The accelerations are means between samples, which attenuates high frequencies; this
    is corrected.
    """
    turns = full_turns(run_series)
    window = slice(turns[0].start, turns[-1].stop)
    accelerations, interval = acceleration(run_series), _sample_interval(run_series)
    segment_length = min(TURNS_PER_SEGMENT * (turns[0].stop - turns[0].start), len(accelerations.output[window]))
    frequency, power = density(
        np.column_stack([accelerations.centre, accelerations.output])[window], 1.0 / interval, segment_length
    )
    power /= np.sinc(frequency * interval)[:, np.newaxis] ** 2
    return Spectrum(frequency, power[:, :2].sum(axis=1), power[:, 2])


def vibration(motion: Series) -> VibrationLevels:
    """Compute the rms of the accelerations of disc centre [m/s^2] and output [rad/s^2] minus the closed form.

    The rms values are those over all full crank turns together, over each turn, and in octave bands. `motion` are the
    time series of the run.
    """
    accelerations, turns = acceleration(motion), full_turns(motion)
    return VibrationLevels(
        gear_centre_m_s2=compute_level(accelerations.centre, turns),
        output_rad_s2=compute_level(accelerations.output, turns),
        band_hz=0.5 / _sample_interval(motion),
        octaves=_octave_bands(spectrum(motion)),
    )


def _sample_interval(motion: Series) -> float:
    return float(np.mean(np.diff(motion.time)))


def _octave_bands(spectrum: Spectrum) -> tuple[OctaveBand, ...]:
    """Compute the rms accelerations of disc centre [m/s^2] and output [rad/s^2] in octave bands.

    Of the bands `OCTAVES` [Hz], only those are returned that lie entirely within the spectrum.
    """
    resolution = spectrum.frequency[1] - spectrum.frequency[0]
    bands = []
    for centre_frequency in OCTAVES:
        lower_limit, upper_limit = centre_frequency / np.sqrt(2.0), centre_frequency * np.sqrt(2.0)
        if lower_limit >= resolution and upper_limit <= spectrum.frequency[-1]:
            in_band = (spectrum.frequency >= lower_limit) & (spectrum.frequency < upper_limit)
            centre_rms, output_rms = (
                np.sqrt(resolution * density[in_band].sum()) for density in (spectrum.centre, spectrum.output)
            )
            bands.append(OctaveBand(float(centre_frequency), float(centre_rms), float(output_rms)))
    return tuple(bands)
