"""The output's bearings: their ratings, what they bear beside the discs' forces, and how much they give."""

import math
from dataclasses import replace

import numpy as np
import pytest
import skfem
from skfem.models.elasticity import linear_elasticity

from cycloid_mj.design import PRESETS
from cycloid_mj.design.stock import tapered_bearings
from cycloid_mj.figures import figure
from cycloid_mj.life import rate
from cycloid_mj.life.bearings import bearing_losses
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.joints import flange_joint, retainer_joint
from cycloid_mj.life.loading import FAR, solve_loading
from cycloid_mj.life.no_load import no_load_torque
from cycloid_mj.life.output_bearing import output_bearings, seat_stiffness
from cycloid_mj.life.output_loads import (
    BALL_BEARINGS,
    crossed_roller_loads,
    equivalent_load,
    output_bearing_forces,
    output_bearing_loads,
    thrust_factors,
)
from cycloid_mj.parts.export import casing
from cycloid_mj.reducer import Reducer

TWO = Reducer(PRESETS["twodisc"])
CROSSED = Reducer(PRESETS["pin"].but(output={"main_bearings": "crossed_roller"}, drive={"torque": 0.25}))


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
    ball = 4.37 * force / found.row.count
    approach = 0.00044e-3 * (ball**2 / (1e3 * found.row.diameter)) ** (1.0 / 3.0)
    assert found.tilting_stiffness() == pytest.approx(0.5 * found.moment / (2.0 * approach / found.spacing))
    assert found.tilting_stiffness(BALL_BEARINGS.usual_clearance) == pytest.approx(
        found.tilting_stiffness() * (4.37 / 5.0) ** (2.0 / 3.0)
    )
    assert replace(found, own=(1e6, 0.0)).tilting_stiffness() == 0.0


def test_the_stiffness_of_a_seat_matches_finite_elements() -> None:
    """A rigid ring of 65 mm in a plate of 100 mm that is fixed at its outside, 7 mm thick, in plane stress."""
    inner, outer, width, modulus, poisson = 32.5e-3, 50e-3, 7e-3, 1.4e9, 0.39
    mesh = skfem.MeshQuad.init_tensor(np.linspace(inner, outer, 13), np.linspace(0.0, 2.0 * np.pi, 97))
    radius, angle = mesh.p
    points = np.round(np.ascontiguousarray([radius * np.cos(angle), radius * np.sin(angle)]), 12)
    mesh = skfem.MeshQuad(points, mesh.t).remove_duplicate_nodes()
    first, second = modulus * poisson / (1.0 - poisson**2), modulus / (2.0 * (1.0 + poisson))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad2()))
    stiffness = linear_elasticity(first, second).assemble(basis)
    ring, rim = (basis.get_dofs(lambda x, at=at: np.abs(np.hypot(*x) / at - 1.0) < 2e-3).all() for at in (inner, outer))
    along_x = np.concatenate([basis.nodal_dofs[0], basis.facet_dofs[0]])
    shift, held = np.zeros(basis.N), np.concatenate([ring, rim])
    shift[np.intersect1d(ring, along_x)] = 1.0
    solution = skfem.solve(*skfem.condense(stiffness, x=shift, D=held))
    computed = width * float(solution @ (stiffness @ solution))
    assert seat_stiffness(2.0 * inner, 2.0 * outer, width, modulus, poisson) == pytest.approx(computed, rel=1e-3)


def test_seats_in_plastic_covers_make_the_output_softer() -> None:
    """Both bearings of printed yield by the balls and by the plate up to the screws; in a metal only by the balls."""
    printed = output_bearings(Reducer(PRESETS["printed"]))
    rigid = replace(printed, seat_stiffness=math.inf)
    force, spacing = 0.5 * printed.moment / printed.spacing, printed.spacing
    softer, stiffer = (0.5 * printed.moment / one.tilting_stiffness() for one in (printed, rigid))
    assert softer - stiffer == pytest.approx(2.0 * force / printed.seat_stiffness / spacing)
    assert "plastic of their seats" in printed.stiffness_note
    assert math.isinf(output_bearings(TWO).seat_stiffness)
    assert "plastic" not in output_bearings(TWO).stiffness_note


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


def tapered_pair() -> Reducer:
    return Reducer(PRESETS["twodisc"].but(output={"main_bearings": "tapered"}))


def test_tapered_roller_bearings_are_rated_by_their_catalogue() -> None:
    """SKF states a, Y and Y_0 of 32915: 18 mm, 1.8 and 1.0; C 86.8 kN, life exponent 10/3."""
    pair, design = output_bearings(tapered_pair()), TWO.design
    assert pair.bearing.designation == "32915"
    inner, outer = (0.5 * sum(ends) for ends in casing(tapered_pair()).bearings)
    assert pair.spacing == pytest.approx(outer - inner + 2.0 * (18e-3 - 10e-3))
    factors = thrust_factors(pair.bearing)
    assert (factors.axial, factors.static_axial) == (pytest.approx(1.8, abs=0.05), pytest.approx(1.0, abs=0.05))
    turns = design.service.life * 3600.0 * abs(design.drive.speed) / (2.0 * math.pi) / design.reduction
    lasting = 86.8e3 * (1e6 / turns) ** 0.3 / design.bearing.service_factor
    assert pair.capacity == pytest.approx(min(lasting, 116e3))
    assert pair.moment == pytest.approx(pair.spacing * (pair.capacity - max(pair.own)))
    assert pair.axial == pytest.approx(min(pair.capacity / factors.axial, 116e3 / factors.static_axial))
    items = rate(tapered_pair().design).items
    assert (items["output_bearing_outer"].limit, items["output_bearing_outer_static"].limit) == (86.8e3, 116e3)
    assert pair.moment > 2.0 * output_bearings(Reducer(design.but(output={"main_bearings": "angular_contact"}))).moment


@pytest.mark.parametrize(
    ("designation", "axial", "static"), [("32008 X", 1.6, 0.9), ("32912", 1.8, 1.0), ("32936", 1.25, 0.7)]
)
def test_contact_angles_of_tapered_bearings_agree_with_the_stated_factors(
    designation: str, axial: float, static: float
) -> None:
    (bearing,) = [bearing for bearing in tapered_bearings() if bearing.designation == designation]
    factors = thrust_factors(bearing)
    assert (factors.radial, factors.axial, factors.static_axial) == (
        0.4,
        pytest.approx(axial, abs=0.05),
        pytest.approx(static, abs=0.05),
    )


def test_the_tilt_of_tapered_rollers_is_that_of_each_roller() -> None:
    """Palmgren, in N and mm; number and length of the rollers have the static rating of ISO 76."""
    found = output_bearings(tapered_pair())
    row, cosine = found.row, math.cos(found.bearing.contact_angle)
    gamma = row.diameter * cosine / row.pitch
    rating = 44e6 * (1.0 - gamma) * row.count * row.length * row.diameter * cosine
    assert rating == pytest.approx(found.bearing.static)
    assert 9e-3 < row.length < 16e-3, "less than the width of the outer ring"
    force = 0.5 * found.moment / found.spacing
    roller = 4.08 * force / (row.count * cosine)
    approach = 3.84e-8 * roller**0.9 / (1e3 * row.length) ** 0.8 / cosine
    assert found.tilting_stiffness() == pytest.approx(0.5 * found.moment / (2.0 * approach / found.spacing))
    assert "upper bound" in found.stiffness_note


def test_a_tilting_moment_passes_through_the_screws_of_the_flange() -> None:
    """Six M4 in plastic inserts on 40 mm, n F d/4; bearings with rollers would carry 30 times that moment."""
    reducer = Reducer(PRESETS["printed"].but(output={"main_bearings": "tapered"}))
    found, screws = output_bearings(reducer), flange_joint(reducer)
    assert (screws.count, screws.radius) == (6, pytest.approx(20e-3))
    assert found.moment == pytest.approx(6.0 * screws.preload * 40e-3 / 4.0)
    assert replace(found, flange_moment=math.inf).moment > 10.0 * found.moment
    assert found.moment_source.startswith("gaping of the output flange")
    assert output_bearings(Reducer(PRESETS["printed"])).moment_source == "ISO 281 and 76"
    crossed = replace(output_bearings(CROSSED), own=0.0)
    limited = replace(crossed, flange_moment=0.5)
    assert (limited.moment, limited.moment_source) == (0.5, found.moment_source)
    assert crossed.moment_source == "ISO 281 and 76"


def test_the_preload_of_tapered_rollers_is_their_least_load() -> None:
    """0.02 C (SKF); P = max(F, 0.4 F + Y F_p)."""
    bearing = output_bearings(tapered_pair()).bearing
    axial = 0.4 / math.tan(bearing.contact_angle)
    loads = equivalent_load(bearing, np.array([0.0, 1e4, 1e6]))
    np.testing.assert_allclose(loads, [axial * 0.02 * 86.8e3, 1e4, 1e6])
    tapered, deep = (no_load_torque(reducer, 100.0, 20.0).bearings for reducer in (tapered_pair(), TWO))
    assert tapered > deep


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


def test_a_crossed_roller_bearing_carries_forces_and_moments_by_the_equation_of_its_maker() -> None:
    """P = F + 2 M/d_pw (THK, No. 382-3E): moment, force on the flange and both together reach the same limit."""
    found, pitch = output_bearings(CROSSED), 57e-3
    assert (found.bearing.designation, found.bearing.pitch) == ("RA 5008 UU CC0", pitch)
    free = replace(found, retainer_moment=math.inf, retainer_force=math.inf)
    assert free.moment == pytest.approx((found.capacity - found.own) * 0.5 * pitch)
    assert found.own + free.radial * (1.0 + 2.0 * found.lever / pitch) == pytest.approx(found.capacity)
    assert free.axial == pytest.approx(min(found.capacity / 0.67, found.bearing.static / 0.44))
    design = CROSSED.design
    turns = design.service.life * 3600.0 * abs(design.drive.speed) / (2.0 * math.pi) / design.reduction
    lasting = found.bearing.dynamic * (1e6 / turns) ** 0.3 / design.bearing.service_factor
    assert found.capacity == pytest.approx(min(lasting, found.bearing.static))
    assert replace(found, retainer_moment=1.0).moment == 1.0
    assert replace(found, own=1e6).moment == replace(found, own=1e6).tilting_stiffness() == 0.0


def test_force_and_moment_on_crossed_rollers_balance_discs_and_shaft() -> None:
    """Force and moment about the middle of the single bearing are those of a pair of supports anywhere on the axis."""
    one = solve_loading(CROSSED, constant_duty(CROSSED.design.rated_torque, CROSSED.design.drive.speed).points[0])
    force, moment = crossed_roller_loads(CROSSED, one)
    ((low, high),) = casing(CROSSED).bearings
    discs = one.on_output @ np.array([1.0, 1.0j])
    arms = np.array(CROSSED.design.gear.disc_planes) - 0.5 * (low + high)
    np.testing.assert_allclose(force, np.abs(discs.sum(axis=1)), rtol=1e-9)
    np.testing.assert_allclose(moment, np.abs(discs @ arms), rtol=1e-9)
    (load,) = output_bearing_loads(CROSSED, one)
    expected = np.maximum(force + 2.0 * moment / 57e-3, 0.02 * 5100.0)
    np.testing.assert_allclose(load, expected, rtol=1e-9)
    items = rate(CROSSED.design).items
    assert "output_bearing_inner" not in items
    assert items["output_bearing"].limit == 5100.0
    assert items["output_bearing_static"].limit == 7190.0


def test_the_retainer_of_crossed_rollers_is_a_joint_with_a_limit() -> None:
    """Eight M3 8.8 on 71 mm: n F d/4 with F = 0.7 x 640 MPa x 5.03 mm2, and all of them against an axial load."""
    retainer, found = retainer_joint(CROSSED), output_bearings(CROSSED)
    preload = retainer.preload
    assert (retainer.count, retainer.radius) == (8, pytest.approx(35.5e-3))
    assert preload == pytest.approx(0.7 * 640e6 * 5.03e-6, rel=2e-3)
    assert found.retainer_force == pytest.approx(8.0 * preload)
    item = rate(CROSSED.design).items["joint_screws_of_the_bearing_retainer_gap"]
    assert item.limit == pytest.approx(8.0 * preload * 71e-3 / 4.0)
    at_rated = solve_loading(CROSSED, constant_duty(CROSSED.design.rated_torque, CROSSED.design.drive.speed).points[0])
    assert found.retainer_moment == pytest.approx(item.limit - crossed_roller_loads(CROSSED, at_rated)[1].max())
    assert item.safety == pytest.approx(item.limit / item.value)
    assert not any("retainer" in key and key.endswith("slip") for key in rate(CROSSED.design).items)


def test_the_tilt_of_crossed_rollers_is_that_of_each_roller() -> None:
    """The moment that rollers around the bearing exert at the tilt by its stiffness, by Palmgren's formula."""
    found = output_bearings(CROSSED)
    count, length = found.rollers
    assert 44e6 * count * length**2 * math.cos(math.pi / 4.0) == pytest.approx(found.bearing.static)
    tilt = 0.5 * found.moment / found.tilting_stiffness()
    angles = np.linspace(0.0, math.pi, 20001)
    approach = 1e3 * tilt * 0.5 * found.bearing.pitch * np.sin(angles) * math.cos(math.pi / 4.0)
    force = (approach * (1e3 * length) ** 0.8 / 3.84e-5) ** (1.0 / 0.9)
    moment = 0.5 * count * np.mean(force * np.sin(angles)) * math.cos(math.pi / 4.0) * 0.5 * found.bearing.pitch
    assert moment == pytest.approx(0.5 * found.moment, rel=1e-3)
