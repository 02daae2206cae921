"""Levels of a signal, by hand."""

import numpy as np
import pytest

from cycloid_mj.base.statistics import peak, peak_to_peak, rms, rms_about_mean


def test_levels_of_numbers() -> None:
    values = np.array([1.0, -3.0, 2.0, 4.0])
    assert rms(values) == pytest.approx(np.sqrt(7.5))
    assert rms_about_mean(values) == pytest.approx(np.sqrt(6.5))
    assert rms_about_mean(values + 100.0) == pytest.approx(rms_about_mean(values))
    assert (peak(-values), peak_to_peak(values)) == (4.0, 7.0)


def test_the_rms_of_vectors_is_that_of_their_lengths() -> None:
    assert rms(np.array([[3.0, 4.0], [0.0, 5.0]])) == 5.0
