"""Levels of a signal (root mean square, about zero or about its mean, and peak), and Student's t."""

import numpy as np

from cycloid_mj.base.array import Array


def rms(values: Array) -> float:
    """Compute the root mean square of numbers (n,), or of the lengths of vectors (n, k)."""
    squares = values**2
    return float(np.sqrt(np.mean(squares if values.ndim == 1 else np.sum(squares, axis=1))))


def rms_about_mean(values: Array) -> float:
    """Compute the root mean square deviation of numbers (n,) from their mean."""
    return float(np.std(values))


def peak(values: Array) -> float:
    """Find the largest size among numbers."""
    return float(np.max(np.abs(values)))


def peak_to_peak(values: Array) -> float:
    """Compute the distance from the least of numbers to the largest."""
    return float(np.ptp(values))


def student_half_width(freedom: float, confidence: float) -> float:
    """Compute the half width of a two-sided interval in standard errors, by Student's t distribution."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + 0.5 * confidence))
