"""The one spectrum: unit cosines all over the band it shows, at any order, under a crank that sways."""

import numpy as np
import pytest

from cycloid_mj.analysis.spectrum import (
    SPECTRUM,
    between_samples,
    decimate,
    density,
    periodic_orders,
    tapered_orders,
)
from cycloid_mj.base.errors import UsageError

PER_TURN = 365.85
"""Samples in a turn at 10 kHz and 1640 rpm: no whole number."""


def swept(turns: float, ripple: float = 0.0) -> np.ndarray:
    """Crank angles at even times; the speed sways by `ripple` nine times a turn."""
    even = 2.0 * np.pi / PER_TURN * np.arange(int(turns * PER_TURN))
    return even + ripple / 9.0 * np.sin(9.0 * even)


def read(crank: np.ndarray, order: float, phase: float = 0.3, amplitude: float = 1.0) -> float:
    found = tapered_orders(crank, 7.0 + amplitude * np.cos(order * crank + phase))
    near = np.abs(found.order - order) < 2.0
    return float(found.amplitude[near].max())


@pytest.mark.parametrize("turns", [1.0, 3.4, 6.8])
@pytest.mark.parametrize("ripple", [0.0, 0.02])
@pytest.mark.parametrize("share", [0.05, 0.15, 0.25, 0.3, 0.35, 0.395])
def test_a_unit_cosine_is_read_as_one_at_any_order_up_to_the_band(turns, ripple, share):
    crank = swept(turns, ripple)
    whole = round(share * PER_TURN)
    limit = 0.01
    for order in (whole, whole + 0.229, whole + 0.5):
        if order * (1.0 + ripple) < SPECTRUM.band * PER_TURN:
            assert read(crank, order) == pytest.approx(1.0, abs=limit), order


@pytest.mark.parametrize("phase", [0.0, 0.8, 1.6, 2.4])
@pytest.mark.parametrize("turns", [1.0, 4.2])
def test_a_unit_cosine_is_read_as_one_down_to_the_lowest_order(turns, phase):
    crank = swept(turns)
    least = SPECTRUM.min_cycles / int(turns + 0.01)
    assert tapered_orders(crank, np.cos(crank)).band[0] == pytest.approx(least)
    for order in (least, 1.13 * least, 2.5 * least):
        assert read(crank, order, phase) == pytest.approx(1.0, abs=0.01)
    # below it, whole orders are right at their own place
    found = tapered_orders(crank, np.cos(crank + phase))
    assert found.amplitude[np.argmin(np.abs(found.order - 1.0))] == pytest.approx(1.0, abs=0.01)


def test_straight_lines_between_samples_would_not_do():
    crank = swept(3.4)
    grid = 6.0 * np.pi * np.arange(2000) / 2000
    for share, left in ((0.15, 0.93), (0.395, 0.57)):
        order = round(share * PER_TURN)
        line = np.interp(grid, crank, np.cos(order * crank))
        # so the vibration's figures were read before: sinc squared
        assert 2.0 / 2000 * np.abs(np.fft.rfft(line))[3 * order] == pytest.approx(left, abs=0.03)
        assert read(crank, order) == pytest.approx(1.0, abs=0.01)


def test_the_band_is_stated_and_nothing_is_reported_beyond_it():
    crank = swept(3.4)
    found = tapered_orders(crank, np.cos(36.0 * crank))
    assert found.band == pytest.approx((1.0, SPECTRUM.band * PER_TURN), rel=1e-3)
    assert found.order[-1] <= found.band[1]
    assert tapered_orders(crank, np.cos(36.0 * crank), max_order=80.0).band[1] == 80.0


def test_a_backward_crank_has_the_same_spectrum():
    crank = swept(3.4)
    forward, back = (tapered_orders(sign * crank, np.cos(36.0 * crank)) for sign in (1.0, -1.0))
    assert back.amplitude == pytest.approx(forward.amplitude, abs=1e-9)


@pytest.mark.parametrize("signal", ["lines", "noise"])
def test_the_power_of_a_tapered_spectrum_is_the_signals(signal):
    crank = swept(40.0)
    random = np.random.default_rng(1)
    if signal == "lines":
        values = 2.0 + np.cos(36.3 * crank) + 0.5 * np.cos(100.2 * crank)
        expected = np.sqrt(0.5 + 0.125)
    else:
        noise = np.fft.rfft(random.standard_normal(len(crank)))
        noise[int(0.35 * len(crank)) :] = 0.0
        values = np.fft.irfft(noise, len(crank))
        expected = values.std()
    found = tapered_orders(crank, values)
    assert found.rms(found.order > 0.0) == pytest.approx(expected, rel=0.02)


def test_less_than_a_turn_has_no_spectrum():
    assert tapered_orders(swept(0.9), np.ones(int(0.9 * PER_TURN))) is None
    assert tapered_orders(np.zeros(400), np.ones(400)) is None


@pytest.mark.parametrize(("base", "turns"), [(1.0, 1), (36 / 35, 1), (36 / 35, 35)])
def test_periodic_orders_are_exact_up_to_two_samples_in_a_cycle(base, turns):
    crank = 2.0 * np.pi * np.arange(8 * 36 * turns + 1) / (8 * 36)
    error = 5.0 + 2.0 * np.cos(3.0 * base * crank + 0.4) + 0.5 * np.sin(105.0 * base * crank)
    found = periodic_orders(crank, error, base, 120.0)
    sizes = {round(order / base, 6): size for order, size in zip(found.order, found.amplitude, strict=True)}
    assert sizes.pop(3.0) == pytest.approx(2.0, rel=1e-9)
    # 2.7 samples in a cycle, of which straight lines would leave 0.57
    assert sizes.pop(105.0) == pytest.approx(0.5, rel=1e-9)
    assert max(sizes.values()) < 1e-9
    assert found.rms(found.order > 0.0) == pytest.approx(np.sqrt(2.0 + 0.125), rel=1e-9)


def test_a_window_of_mesh_periods_suffices_for_mesh_periodic_values():
    crank = swept(0.9)
    found = tapered_orders(crank, 7.0 + np.cos(36.0 * crank + 0.3), max_order=144.0, cycles_per_turn=36.0)
    assert found.cycles == 32
    assert found.band == pytest.approx((3.0 * 36.0 / 32.0, 144.0))
    assert found.amplitude.max() == pytest.approx(1.0, abs=0.002)
    assert found.order[np.argmax(found.amplitude)] == pytest.approx(36.0)


def test_periodic_orders_refuse_unsuitable_samples():
    even = 2.0 * np.pi * np.arange(100) / 100
    for crank, problem in (
        (even[:90], "the 90 angles cover only 324 deg"),
        (even + 1e-3 * np.sin(even), "the 100 angles are not equally spaced"),
        (2.0 * np.pi * np.arange(107) / 106.5, "have steps of 3.38028 deg, which do not divide full cycles"),
    ):
        with pytest.raises(UsageError, match=f"step divides full cycles of 360 deg, but .*{problem}"):
            periodic_orders(crank, np.ones(len(crank)))


@pytest.mark.parametrize("share", [0.0, 0.1, 0.3, 0.395])
def test_values_between_samples_are_those_of_the_signal(share):
    times = np.arange(400.0)
    places = np.linspace(20.0, 379.0, 997)
    omega = 2.0 * np.pi * share
    assert between_samples(np.cos(omega * times), places) == pytest.approx(np.cos(omega * places), abs=1e-3)


@pytest.mark.parametrize("every", [1, 5, 10])
@pytest.mark.parametrize("share", [0.05, 0.2, 0.39])
def test_thinning_keeps_the_band_and_removes_aliases(every, share):
    times = np.arange(4000.0)
    rows = slice(10, -10)
    inside = decimate(np.cos(2.0 * np.pi * share / every * times), every)[rows]
    assert np.sqrt(2.0) * inside.std() == pytest.approx(1.0, abs=0.01)
    if every > 1:
        folding = decimate(np.cos(2.0 * np.pi * (1.0 - share) / every * times), every)[rows]
        assert np.abs(folding).max() < 0.01


@pytest.mark.parametrize("every", [5, 10])
def test_thinning_corrects_the_attenuation_of_means(every):
    times = np.arange(4000.0)
    omega = 2.0 * np.pi * 0.39 / every
    means = np.diff(np.sin(omega * times)) / omega
    found = decimate(np.column_stack([means, means]), every, means=True)[10:-10]
    assert np.sqrt(2.0) * found.std(axis=0) == pytest.approx([1.0, 1.0], abs=0.005)


def test_a_density_adds_up_to_the_mean_square_within_the_band():
    times = np.arange(20000) / 1e4
    frequency, power = density(np.sqrt(2.0) * np.cos(2.0 * np.pi * 3000.0 * times), 1e4, 1000)
    assert np.sqrt(np.trapezoid(power, frequency)) == pytest.approx(1.0, rel=0.01)
    assert frequency[-1] <= SPECTRUM.band * 1e4
