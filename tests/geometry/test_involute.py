"""Involute gears: radii, the end of the flank, and conjugate action of a pair cut by the rack."""

import math

import numpy as np
import pytest

from cycloid_mj.geometry.involute import InvoluteGear, gear_pair, least_shift, shift_sum

ANGLE = math.radians(20.0)


def _gear(teeth: int, shift: float, thinning: float = 0.0) -> InvoluteGear:
    module = 1.75e-3
    return InvoluteGear(teeth, module, ANGLE, shift, module * (teeth / 2.0 + shift + 1.0), thinning)


@pytest.mark.parametrize(("teeth", "shift"), [(10, 0.45), (17, 0.0), (38, -0.45), (80, 0.2)])
def test_fillet_and_flank_join_smoothly(teeth: int, shift: float) -> None:
    gear = _gear(teeth, shift)
    np.testing.assert_allclose(gear.fillet(gear.last_corner), gear.flank(gear.first_roll), atol=1e-15)
    np.testing.assert_allclose(gear.fillet_tangents(gear.last_corner), gear.flank_tangents(gear.first_roll), atol=1e-12)
    assert np.linalg.norm(gear.fillet(0.0)) == pytest.approx(gear.root_radius, rel=1e-12)
    assert np.linalg.norm(gear.flank(gear.last_roll)) == pytest.approx(gear.tip_radius, rel=1e-12)


def test_lengths_are_those_of_the_sampled_curves() -> None:
    gear = _gear(10, 0.45)
    corner, roll = np.linspace(0.0, gear.last_corner, 20001), np.linspace(gear.first_roll, gear.last_roll, 20001)
    for points, length in (
        (gear.fillet(corner), gear.fillet_length(gear.last_corner)),
        (gear.flank(roll), np.diff(gear.flank_length(roll[[0, -1]]))[0]),
    ):
        assert np.linalg.norm(np.diff(points, axis=0), axis=1).sum() == pytest.approx(float(length), rel=1e-8)


def test_tooth_and_space_fill_the_pitch_less_the_thinning() -> None:
    gear = _gear(38, -0.4, thinning=20e-6)
    roll = math.tan(ANGLE)
    x, y = gear.flank(roll)
    half_space = math.atan2(x, y)
    nominal = gear.module * (math.pi / 2.0 - 2.0 * gear.shift * math.tan(ANGLE))
    assert 2.0 * half_space * gear.reference_radius == pytest.approx(nominal + 20e-6, rel=1e-12)


def test_the_least_shift_puts_the_first_point_on_the_base_circle() -> None:
    """ISO 21771: x = 1 - z sin^2(alpha)/2 at 20 degrees, where the rack is straight to the depth 1.0 m."""
    assert least_shift(17, ANGLE) == pytest.approx(1.0 - 17.0 * math.sin(ANGLE) ** 2 / 2.0, abs=1e-4)
    assert least_shift(40, ANGLE) == 0.0
    assert _gear(10, least_shift(10, ANGLE)).first_roll == pytest.approx(0.0, abs=1e-14)
    assert _gear(10, 0.2).first_roll < 0.0


def test_a_pair_states_what_is_wrong_with_its_teeth() -> None:
    sun, planet = gear_pair((10, 38), 1.75e-3, ANGLE, 0.042, 0.0)
    assert (sun.fault, planet.fault) == ("", "")
    assert (sun.shift, planet.shift) == pytest.approx((0.45, -0.45))
    assert gear_pair((10, 11), 1.75e-3, ANGLE, 0.018375, 0.0)[1].fault == "undercut"
    assert gear_pair((5, 38), 1.75e-3, ANGLE, 0.037625, 0.0)[0].fault == "pointed"


def test_the_shift_of_a_pair_follows_its_centre_distance() -> None:
    """DIN 3960, worked backwards: with the sum of shifts, working angle and distance are consistent."""
    assert shift_sum(48, 1.75e-3, ANGLE, 0.042) == pytest.approx(0.0, abs=1e-14)
    total = shift_sum(48, 1.75e-3, ANGLE, 0.0426)
    working = math.acos(0.042 * math.cos(ANGLE) / 0.0426)
    involutes = (math.tan(working) - working) - (math.tan(ANGLE) - ANGLE)
    assert 2.0 * total * math.tan(ANGLE) / 48.0 == pytest.approx(involutes, rel=1e-12)
