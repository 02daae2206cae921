"""Closed forms of RV reducers: ratio, orders, assembly, ideal crank forces, stiffness and the error map."""

import math
from fractions import Fraction

import numpy as np
import pytest

from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.geometry.rv import (
    RvKinematics,
    are_one_part,
    contact_ratio,
    flip_clockings,
    mesh_stiffness,
    meshing_planet_teeth,
    planet_misfit,
)
from cycloid_mj.geometry.rv_loads import RvStage, closed_form_stiffness, ideal_rv_loads, mean_force

GEAR = CycloidGear(ring_teeth=40, eccentricity=1.5e-3, pin_circle_radius=77.5e-3, pin_radius=4e-3)
TORQUE = 784.0
LIFE_TURNS = 60.0 * 600.0 * 6000.0
"""Turns of a crank bearing in 6000 h at 15 rpm of the output."""


def stage(cranks: int, discs: int) -> RvStage:
    """Build the second stage of the RV-80E."""
    phases = tuple(2.0 * math.pi * disc / discs for disc in range(discs))
    return RvStage(GEAR, phases, cranks, 42e-3, 153.0, 1.0 + 10.0 / 38.0)


def test_speeds_of_the_rv80e_solve_the_mesh_conditions() -> None:
    ring_fixed, carrier_fixed = RvKinematics(10, 38, 40, 39), RvKinematics(10, 38, 40, 39, turns_ring=True)
    assert (ring_fixed.ratio, carrier_fixed.ratio) == (153, -152)
    # with the ring fixed and the carrier turning once, the pin mesh requires 39 (1 - psi) = 40 (0 - psi)
    crank = -39.0
    assert 39.0 * (1.0 - crank) == 40.0 * (0.0 - crank)
    assert 1.0 - (crank - 1.0) * 38.0 / 10.0 == pytest.approx(float(ring_fixed.ratio), rel=1e-9)
    assert ring_fixed.crank_per_carrier == -39
    assert ring_fixed.bearing_turns == 40
    orders = [int(order) for order in ring_fixed.orders.values()]
    assert orders == [1, 153, 152, 39, 40, 1520, 1560]
    assert RvKinematics(12, 36, 40, 38).ratio == 1 + Fraction(40 * 36, 2 * 12)


@pytest.mark.parametrize(
    ("sun", "planet", "count", "misfit"),
    [(10, 38, 2, 0), (10, 38, 3, 0), (12, 38, 3, Fraction(1, 3)), (17, 38, 2, Fraction(1, 2)), (15, 30, 3, 0)],
)
def test_planets_mesh_if_their_number_divides_the_sum_of_teeth(
    sun: int, planet: int, count: int, misfit: Fraction
) -> None:
    assert planet_misfit(sun, planet, count) == misfit
    # brute force: phase of sun and planet teeth at each mesh, against the first planet's
    angles = 2.0 * math.pi * np.arange(count) / count
    phase = (sun * angles + planet * (angles + math.pi)) / (2.0 * math.pi) - planet / 2.0
    assert np.abs(phase - np.round(phase)).max() == pytest.approx(float(misfit), abs=1e-9)


def test_the_nearest_planets_that_close_are_named() -> None:
    assert meshing_planet_teeth(12, 38, 3) == (39, 36)
    assert meshing_planet_teeth(17, 38, 2) == (39, 37)


def test_discs_are_one_part_where_a_turn_or_a_flip_clocks_them() -> None:
    turned = {
        (lobes, cranks) for lobes in (35, 36, 39, 40) for cranks in (2, 3) if are_one_part(lobes + 1, lobes, 2, cranks)
    }
    assert turned == {(35, 2), (39, 2)}
    assert [lobes for lobes in (35, 36, 39, 40) if are_one_part(lobes + 1, lobes, 3, 3)] == [35, 40]
    for lobes in (35, 36, 39, 40):
        for cranks in (2, 3):
            clockings = flip_clockings(lobes + 1, lobes, cranks)
            assert Fraction(1, 4) in clockings
            assert (Fraction(0) in clockings) == (cranks == 2 and lobes % 2 == 1)


@pytest.mark.parametrize(
    ("cranks", "discs", "floating", "forces"),
    [
        (3, 2, False, [[5245.1, 1886.0, 3513.6], [4806.5, 796.6, 4426.6], [2979.3, 2482.3, 5326.8]]),
        (2, 2, False, [[7867.6, 1794.5], [7209.7, 3607.9], [4468.9, 6719.2]]),
        (3, 1, False, [[10490.1, 3772.0, 7027.1], [9613.0, 1593.2, 8853.2], [5958.6, 4964.5, 10653.6]]),
        (3, 1, True, [[4643.1, 9766.3, 12871.9], [6253.9, 6054.7, 14371.2], [11227.9, 9206.4, 8473.6]]),
    ],
)
def test_crank_forces_are_those_of_the_table(
    cranks: int, discs: int, floating: bool, forces: list[list[float]]
) -> None:
    """Cranks count clockwise here, and counter-clockwise in the derivation of the table."""
    found = ideal_rv_loads(stage(cranks, discs), TORQUE, np.radians([0.0, 30.0, 90.0]), floating)
    assert found.bearings[:, 0] == pytest.approx(np.array(forces), abs=0.1)
    places = stage(cranks, discs).crank_positions(np.radians([0.0, 30.0, 90.0]))
    for disc in range(discs):
        assert found.cranks[:, disc].sum(axis=1) == pytest.approx(-found.resultant[:, disc], abs=1e-6)
        force = found.cranks[:, disc]
        turning = (places[..., 0] * force[..., 1] - places[..., 1] * force[..., 0]).sum(axis=1)
        assert turning == pytest.approx(TORQUE * 152.0 / 153.0 / discs * 39.0 / 40.0, rel=1e-9)


def test_pins_and_crank_torques_are_those_of_the_table() -> None:
    at = np.radians([0.0, 30.0, 90.0])
    both, one = (ideal_rv_loads(stage(3, discs), TORQUE, at) for discs in (2, 1))
    assert both.resultant[:, 0] == pytest.approx(
        np.array([[6490.6, 2525.5], [4382.6, 5390.4], [-2525.5, 6490.6]]), abs=0.1
    )
    assert both.pins[:, 0].max(axis=1) == pytest.approx(647.9, abs=0.1)
    assert (both.pins[:, 0] > 1e-6).sum(axis=1).tolist() == [19, 20, 19]
    assert both.crank_torques == pytest.approx(-TORQUE * 152.0 / 153.0 / 40.0 / 3.0, rel=1e-9)
    assert one.crank_torques == pytest.approx(
        np.array([[-15.53, -1.97, -1.97], [-14.26, 1.40, -6.61], [-6.13, 1.15, -14.50]]), abs=0.01
    )


@pytest.mark.parametrize(
    ("cranks", "least", "most", "mean", "capacity"), [(3, 696, 5333, 4083, 20.5e3), (2, 1044, 8000, 6124, 30.7e3)]
)
def test_bore_force_over_a_turn_of_the_carrier(
    cranks: int, least: float, most: float, mean: float, capacity: float
) -> None:
    turn = np.linspace(0.0, 2.0 * math.pi * 39.0, 3510, endpoint=False)
    bore = ideal_rv_loads(stage(cranks, 2), TORQUE, turn).bearings[:, 0, 0]
    assert (bore.min(), bore.max(), mean_force(bore)) == pytest.approx((least, most, mean), abs=1.0)
    assert mean_force(bore) * (LIFE_TURNS / 1e6) ** 0.3 == pytest.approx(capacity, rel=5e-3)


def test_stiffness_of_crank_bearings_and_teeth_in_series() -> None:
    arcminute = math.pi / 10800.0
    assert closed_form_stiffness(stage(3, 2), 1e8, 3e8) * arcminute == pytest.approx(199.0, rel=0.01)
    rigid_bearings, rigid_teeth = (closed_form_stiffness(stage(3, 2), *pair) for pair in ((1e15, 3e8), (1e8, 1e15)))
    together = 1.0 / (1.0 / rigid_bearings + 1.0 / rigid_teeth)
    assert closed_form_stiffness(stage(3, 2), 1e8, 3e8) == pytest.approx(together, rel=1e-5)


def test_mesh_stiffness_is_in_the_usual_range_of_steel_gears() -> None:
    """Spur gears of steel have about 20 N/(mm um) (ISO 6336-1, 9.3.1)."""
    angle = math.radians(20.0)
    assert contact_ratio(10, 38, angle) == pytest.approx(1.536, abs=1e-3)
    assert 14e9 < mesh_stiffness(10, 38, angle, 1.0) < mesh_stiffness(30, 38, angle, 1.0) < 21e9
