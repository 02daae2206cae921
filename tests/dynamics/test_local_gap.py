"""The local expansion of a pin's gap: against the search from anywhere, and what it leaves out for speed."""

import math

import numpy as np
import pytest

from cycloid_mj.dynamics.contact.gap import NO_WAVES, Flank, Trochoid, trochoid_curvature, trochoid_distance
from cycloid_mj.dynamics.contact.local_gap import Start, local_distance, multiple_angle, pin_distance

GEARS = {
    "paper": Trochoid(0.04075, 0.001, 36.0),
    "few lobes": Trochoid(0.03, 0.002, 10.0),
    "many lobes": Trochoid(0.06, 0.0004, 120.0),
}
FAR_OUT = 1.0


def place(gear: Trochoid, t: float) -> np.ndarray:
    radius, eccentricity, teeth = gear
    return radius * np.array([math.sin(t), math.cos(t)]) - eccentricity * np.array(
        [math.sin(teeth * t), math.cos(teeth * t)]
    )


def near(gear: Trochoid, point: np.ndarray, t: float, most: float = FAR_OUT):
    turned = gear.teeth * t
    start = Start(math.sin(t), math.cos(t), math.sin(turned), math.cos(turned))
    return local_distance(*point, gear, start, most)


@pytest.mark.parametrize("times", [0, 1, 2, 7, 36, 119])
def test_turned_times_is_the_multiple_of_the_angle(times: int) -> None:
    for angle in np.linspace(-3.0, 3.0, 31):
        expected = (math.sin(times * angle), math.cos(times * angle))
        assert multiple_angle(math.sin(angle), math.cos(angle), times) == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("name", GEARS)
@pytest.mark.parametrize("size", [1e-7, 1e-6, 1e-5])
def test_closed_form_matches_the_search(name: str, size: float) -> None:
    gear, rng = GEARS[name], np.random.default_rng(7)
    for t in rng.uniform(-3.0, 3.0, 300):
        point = place(gear, t) + size * rng.uniform(-1.0, 1.0, 2)
        distance, nx, ny, bend = near(gear, point, t)
        foot, expected, ex, ey = trochoid_distance(*point, gear)
        assert distance == pytest.approx(expected, abs=1e-13)
        assert (nx, ny) == pytest.approx((ex, ey), abs=1e-6)
        assert bend == pytest.approx(trochoid_curvature(foot, gear), rel=1e-2, abs=1.0)


def test_it_falls_back_to_the_search_far_away() -> None:
    gear = GEARS["paper"]
    for t in np.linspace(0.0, 0.17, 20):
        point = place(gear, t) * 1.01
        assert near(gear, point, t + 0.02)[0] == pytest.approx(trochoid_distance(*point, gear)[1], abs=1e-12)


def test_only_gaps_that_are_open_are_left_out() -> None:
    gear, rng = GEARS["paper"], np.random.default_rng(3)
    most, left_out = 1e-6, 0
    for t in rng.uniform(-3.0, 3.0, 2000):
        point = place(gear, t) + 5e-6 * rng.uniform(-1.0, 1.0, 2)
        distance, nx, ny, _ = near(gear, point, t, most)
        true = trochoid_distance(*point, gear)[1]
        if nx == ny == 0.0:
            left_out += 1
            assert distance > most
            assert true > most
        else:
            assert distance == pytest.approx(true, abs=1e-13)
    assert left_out > 300


@pytest.mark.slow
def test_a_pin_without_a_home_is_searched() -> None:
    gear = GEARS["paper"]
    flank = Flank(gear, 0.00225, 0.0, 0.0, 0.0, 0.0, 0.0, NO_WAVES)
    point = place(gear, 0.3) + 1e-6
    assert pin_distance(*point, flank, Start(0.0, 0.0, 0.0, 1.0), FAR_OUT)[0] == trochoid_distance(*point, gear)[1]
