"""Each erratum: printed wrong, corrected right, by finite differences; and again by derivatives at 50 digits."""

import numpy as np
import pytest
from hsieh2014 import equations, errata
from hsieh2014.equations import GEAR, HOLD, RAMP, SPEED, Q, zeta_at
from hsieh2014.errata import ERRATA, RIGHT, TIMES, first, second
from mpmath import mp, mpf

EQUATIONS = ["2", "6, 10", "12, 17", "13", "14", "17", "18", "19", "20", "21", "27"]
WRONG = 0.03
"""The least that a printed formula misses: Eq. 20, by 4 %."""


@pytest.mark.parametrize("order", [1, 2])
def test_differences_are_of_fourth_order(order):
    derive, wanted = (first, np.cos) if order == 1 else (second, lambda x: -np.sin(x))
    at = np.array([0.3, 1.1])
    errors = [np.abs(derive(np.sin, at, h) - wanted(at)).max() for h in (0.2, 0.1)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.05)


def test_every_erratum_is_listed_once():
    assert [one.equation for one in ERRATA] == EQUATIONS


@pytest.mark.parametrize("one", ERRATA, ids=EQUATIONS)
def test_printed_is_wrong_and_corrected_is_right(one):
    printed, right = one.errors()
    assert right < RIGHT
    assert printed < RIGHT if one.harmless else printed > WRONG


@pytest.mark.parametrize("one", ERRATA, ids=EQUATIONS)
def test_json_has_both_errors(one):
    told = one.as_json()
    assert (told["printed_error"], told["right_error"]) == one.errors()


def test_the_third_component_changes_no_velocity_but_is_no_length():
    # Eqs 6 and 10: the same velocity, but |R| would depend on the unit of length
    places = np.array([[0.01, 0.04]])
    assert np.array_equal(equations.eq6(1.0, places), equations.eq6(0.0, places))
    in_metres, in_mm = np.hypot(0.04075, 1.0), np.hypot(40.75, 1.0) / 1e3
    assert abs(in_metres / in_mm - 1.0) > 1.0


# --- Eqs 13, 14 and 16-20 at 50 digits


@pytest.fixture
def digits():
    with mp.workdps(50):
        yield


def eq16(zeta):
    """Position of q (Eq. 16) at full precision, from its own text and not from `kinematics`."""
    N, c, (q_x, q_y) = GEAR.lobes, mpf(GEAR.eccentricity), map(mpf, Q.tolist())
    x = -c * mp.sin(N * zeta) + q_x * mp.cos(zeta) + q_y * mp.sin(zeta)
    y = c * (mp.cos(N * zeta) - 1) + q_y * mp.cos(zeta) - q_x * mp.sin(zeta)
    return x, y


def derived(zeta, order):
    return [mp.diff(lambda at, axis=axis: eq16(at)[axis], zeta, order) for axis in (0, 1)]


@pytest.mark.parametrize("place", [0.003, 0.011, 0.17])
def test_eqs_17_and_18_at_50_digits(digits, place):
    wanted = np.array([float(value) for value in derived(mpf(place), 1)])
    right, printed = (equations.eq17(sign, np.array([place]))[0] for sign in (-1, 1))
    assert np.abs(right - wanted).max() < 1e-14 * np.abs(wanted).max() + 1e-16
    assert np.abs(printed - wanted).max() > 0.1 * np.abs(wanted).max()
    assert equations.eq18(np.array([place]))[0] == pytest.approx(np.hypot(*wanted), rel=1e-13)


@pytest.mark.parametrize("place", [0.003, 0.011, 0.17])
def test_eqs_19_and_20_at_50_digits(digits, place):
    wanted = np.array([float(value) for value in derived(mpf(place), 2)])
    assert equations.curve(np.array([place]))[0] == pytest.approx(wanted, rel=1e-12)
    right, printed = (equations.eq20(sign, np.array([place]))[0] for sign in (1, -1))
    assert right == pytest.approx(np.hypot(*wanted), rel=1e-13)
    assert abs(printed / np.hypot(*wanted) - 1.0) > 1e-3


def test_eqs_13_and_14_at_50_digits(digits):
    omega, c, time = mpf(SPEED), mpf(GEAR.eccentricity), mpf("0.0123")
    place = [lambda t: -c * mp.sin(omega * t), lambda t: c * mp.cos(omega * t)]
    speed, size = (float(mp.sqrt(sum(mp.diff(one, time, order) ** 2 for one in place))) for order in (1, 2))
    assert equations.eq13(SPEED) == pytest.approx(speed, rel=1e-14)
    assert equations.eq13(SPEED / GEAR.lobes) == pytest.approx(speed / 35.0, rel=1e-14)
    assert equations.eq14_right(HOLD, np.array([0.0123]))[0] == pytest.approx(size, rel=1e-14)
    assert equations.eq14_printed(HOLD, np.array([0.0123]))[0] == pytest.approx(size / 1225.0, rel=1e-14)


# --- spoiled corrections are noticed


def test_without_the_tangential_term_eq_19_fails_in_the_ramp():
    wanted = errata.acceleration(RAMP, 2e-4)
    rate = RAMP.speed_at(TIMES) / GEAR.lobes
    without = equations.curve(zeta_at(RAMP)(TIMES)) * rate[:, np.newaxis] ** 2
    assert errata.relative_error(without, wanted) > 100 * RIGHT


def test_an_error_of_one_milliradian_in_alpha_fails_eq_2(monkeypatch):
    true = equations.conjugate_alpha
    monkeypatch.setattr(equations, "conjugate_alpha", lambda gear, B: true(gear, B) + 1e-3)
    assert errata.tangency_error(-1) > 10 * RIGHT


def test_eq_21_is_a_statement_about_the_variation():
    # along the constraint's normal, and only there, the constraint's own force shows
    force, inertia, normal = np.array([0.0, -9.8]), np.array([1.0, -9.8]), np.array([1.0, 0.0])
    assert equations.eq21(normal, force, inertia) == pytest.approx(1.0 / 9.8)
    assert equations.eq21(np.array([0.0, 1.0]), force, inertia) == 0.0
