"""The output's bearings: their ratings, what they bear beside the discs' forces, and how much they give."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cycloid_mj.design import PRESETS
from cycloid_mj.figures import figure
from cycloid_mj.life import rate
from cycloid_mj.life.bearings import bearing_losses
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.loading import FAR, solve_loading
from cycloid_mj.life.no_load import no_load_torque
from cycloid_mj.life.output_bearing import BALL_BEARINGS, equivalent_load, output_bearing_forces, output_bearings
from cycloid_mj.parts.export import casing
from cycloid_mj.reducer import Reducer

TWO = Reducer(PRESETS["twodisc"])


def test_the_moment_leaves_the_bearings_their_force_over_their_distance() -> None:
    found, (inner, outer) = output_bearings(TWO), (0.5 * sum(ends) for ends in casing(TWO).bearings)
    assert found.spacing == pytest.approx(outer - inner)
    alone = replace(found, own=(0.0, 0.0))
    assert alone.moment == pytest.approx(found.capacity * found.spacing)
    assert found.moment == pytest.approx(alone.moment - max(found.own) * found.spacing)
    # a force on the flange's face, whose moment about the inner bearing the outer one holds
    assert alone.radial == pytest.approx(found.capacity * found.spacing / (found.spacing + found.lever))
    assert replace(found, own=(1e6, 0.0)).moment == replace(found, own=(1e6, 0.0)).radial == 0.0


def test_a_bearing_carries_its_load_for_the_life_that_is_requested() -> None:
    found, design = output_bearings(TWO), TWO.design
    turns = design.service.life * 3600.0 * abs(design.drive.speed) / (2.0 * math.pi) / design.reduction
    assert found.capacity < found.static
    factor = design.bearing.service_factor
    assert factor > 1.0
    assert 1e6 * (found.dynamic / (factor * found.capacity)) ** 3 == pytest.approx(turns)
    shorter = output_bearings(TWO.but(service={"life": 0.01}))
    assert shorter.capacity == shorter.static


def test_the_tilt_of_the_hub_is_that_of_the_balls() -> None:
    """The tilt by both bearings' approach, from Palmgren's formula in N and mm."""
    found = output_bearings(TWO)
    force = 0.5 * found.moment / found.spacing
    ball = 4.37 * force / found.row.balls
    approach = 0.00044e-3 * (ball**2 / (1e3 * found.row.diameter)) ** (1.0 / 3.0)
    assert found.tilting_stiffness() == pytest.approx(0.5 * found.moment / (2.0 * approach / found.spacing))
    assert found.tilting_stiffness(BALL_BEARINGS.usual_clearance) == pytest.approx(
        found.tilting_stiffness() * (4.37 / 5.0) ** (2.0 / 3.0)
    )
    assert replace(found, own=(1e6, 0.0)).tilting_stiffness() == 0.0


def test_angular_contact_bearings_carry_at_their_load_centres() -> None:
    """Back to back at 25 deg the centres of a pair are d_m tan(25 deg) further apart; its forces fall accordingly."""
    pair = Reducer(PRESETS["twodisc"].but(output={"main_bearings": "angular_contact"}))
    deep, angular = output_bearings(TWO), output_bearings(pair)
    assert (deep.bearing.designation, angular.bearing.designation) == ("61816", "71816 ACD")
    tangent = math.tan(math.radians(25.0))
    assert angular.spacing == pytest.approx(deep.spacing + 90e-3 * tangent)
    assert angular.lever == pytest.approx(deep.lever - 45e-3 * tangent)
    # ISO 281 and ISO 76: balls fill 270 instead of 195 deg, at a contact angle
    more, cosine = 270.0 / 195.0, math.cos(math.radians(25.0))
    assert angular.dynamic == pytest.approx(deep.dynamic * more ** (2.0 / 3.0) * cosine**0.7, rel=1e-4)
    assert angular.static == pytest.approx(deep.static * more * cosine, rel=1e-4)
    assert angular.axial == pytest.approx(min(angular.capacity / 0.87, angular.static / 0.38))
    one = solve_loading(pair, constant_duty(pair.design.rated_torque, pair.design.drive.speed).points[0])
    inner, outer = (force @ np.array([1.0, 1.0j]) for force in output_bearing_forces(pair, one))
    places, hub = casing(pair).load_centres, 0.5 * sum(casing(pair).far or (0.0, 0.0))
    shaft = np.exp(1j * one.crank) * (one.shaft[:, FAR] @ np.array([1.0, 1.0j]))
    discs = one.on_output @ np.array([1.0, 1.0j])
    moment = inner * places[0] + outer * places[1] + discs @ np.array(pair.design.gear.disc_planes) - shaft * hub
    np.testing.assert_allclose(moment, 0.0, atol=1e-11)
    assert angular.moment > 5.0 * deep.moment
    assert angular.tilting_stiffness() > 10.0 * deep.tilting_stiffness()


def test_the_catalogue_has_them() -> None:
    assert figure("output_tilting_capacity_nm").value(TWO) == output_bearings(TWO).moment
    assert figure("output_radial_load_n").value(TWO) == output_bearings(TWO).radial
    assert figure("output_axial_load_n").value(TWO) == 0.25 * output_bearings(TWO).static
    assert figure("output_tilting_stiffness_nm_per_arcmin").value(TWO) > 0.0


def test_the_bearings_of_the_hub_are_rated() -> None:
    """Their forces balance those of discs and shaft on the output: no net force, and no moment about either."""
    one = solve_loading(TWO, constant_duty(TWO.design.rated_torque, TWO.design.drive.speed).points[0])
    inner, outer = output_bearing_forces(TWO, one)
    sizes = casing(TWO)
    places = [0.5 * sum(ends) for ends in (*sizes.bearings, sizes.far or (0.0, 0.0))]
    turn = np.exp(1j * one.crank)
    shaft = turn * (one.shaft[:, FAR] @ np.array([1.0, 1.0j]))
    discs = one.on_output @ np.array([1.0, 1.0j])
    held = [force @ np.array([1.0, 1.0j]) for force in (inner, outer)]
    np.testing.assert_allclose(sum(held) + discs.sum(axis=1) - shaft, 0.0, atol=1e-9)
    planes = np.array(TWO.design.gear.disc_planes)
    moment = held[0] * places[0] + held[1] * places[1] + discs @ planes - shaft * places[2]
    np.testing.assert_allclose(moment, 0.0, atol=1e-11)
    items = rate(TWO.design).items
    assert items["output_bearing_inner"].value > items["output_bearing_outer"].value > 0.0
    assert items["output_bearing_inner"].limit == sizes.hub.dynamic
    turns = abs(TWO.design.drive.speed) / TWO.design.reduction / (2.0 * math.pi) * 3600.0
    found = items["output_bearing_inner"]
    assert found.life == pytest.approx(1e6 * (found.limit / found.value) ** 3 / turns)
    peak = 2.0 * output_bearings(TWO).own[0]
    assert items["output_bearing_inner_static"].value == pytest.approx(peak)


def test_the_preload_of_a_pair_loads_its_bearings_and_rubs() -> None:
    """By hand, of 71816: preload 0.01 C, P = max(F, 0.41 F + 0.87 F_p), torque 0.5 x 0.002 x P x 80 mm per bearing."""
    pair = Reducer(PRESETS["twodisc"].but(output={"main_bearings": "angular_contact"}))
    bearing = output_bearings(pair).bearing
    preload = 0.01 * bearing.dynamic
    loads = equivalent_load(bearing, np.array([0.0, preload, 10.0 * preload]))
    np.testing.assert_allclose(loads, np.array([0.87, 1.28, 10.0]) * preload)
    np.testing.assert_array_equal(equivalent_load(output_bearings(TWO).bearing, np.array([0.0, 5.0])), [0.0, 5.0])
    still = constant_duty(1e-3 * pair.design.rated_torque, pair.design.drive.speed).points[0]
    losses = bearing_losses(pair, solve_loading(pair, still))
    speed = pair.design.drive.speed / pair.design.reduction
    mu = pair.design.friction_of("cam")
    assert losses["output_bearing_outer"] == pytest.approx(0.5 * mu * 0.87 * preload * 80e-3 * abs(speed), rel=0.1)
    angular, deep = (no_load_torque(reducer, 100.0, 20.0).bearings for reducer in (pair, TWO))
    expected = 2.0 * 0.5 * mu * 0.87 * preload * 80e-3 / pair.design.reduction
    assert angular - deep == pytest.approx(expected, rel=1e-3)
