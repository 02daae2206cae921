"""Bearings: which bodies each joins, its speed, equivalent load, friction and load ratings."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cycloid_mj.checks import check
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.figures import figure
from cycloid_mj.life import Duty, DutyPoint, rate, rolling
from cycloid_mj.life.bearings import bearing_forces, bearing_load, bearing_losses, bearings_of
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.figures import SPEED_LIMITS
from cycloid_mj.life.loading import solve_loading
from cycloid_mj.parts.export import cam_bearing
from cycloid_mj.reducer import Reducer

PIN = PRESETS["pin"]
RING_OUTPUT = PIN.but(output={"member": "ring"})


def speeds(design: Design) -> dict[str, float]:
    """Return the speed of each bearing over that of the crank."""
    reducer = Reducer(design)
    return {one.key: one.speed(reducer, design.drive.speed) / abs(design.drive.speed) for one in bearings_of(reducer)}


def test_bearing_speeds_follow_from_the_bodies_that_they_join() -> None:
    """Ring held, N = 36: crank 1, disc and output -1/35; carrier held: ring 1/36.

    A roller of the radius r in a hole of the radius R: the hole's middle moves at (R - r) w against the pin, where w is
    the crank against the disc, and the roller rolls in it: (R/r - 1) w.
    """
    hole = PIN.output.hole_radius / PIN.output.pin_radius - 1.0
    held = speeds(PIN)
    assert held["cam_bearing"] == pytest.approx(1.0 + 1.0 / 35.0)
    assert held["output_rollers"] == pytest.approx(hole * (1.0 + 1.0 / 35.0))
    assert held["shaft_bearing_far"] == held["shaft_bearing_near"] == pytest.approx(1.0)
    assert held["output_bearing_inner"] == pytest.approx(1.0 / 35.0)
    straddled = speeds(PRESETS["twodisc"])
    lobes = PRESETS["twodisc"].lobes
    assert straddled["shaft_bearing_far"] == pytest.approx(1.0 + 1.0 / lobes), "in the hub, which turns back"
    assert straddled["shaft_bearing_near"] == pytest.approx(1.0)
    turning = speeds(RING_OUTPUT)
    assert turning["cam_bearing"] == pytest.approx(1.0)
    assert turning["output_rollers"] == pytest.approx(hole)
    assert turning["shaft_bearing_near"] == pytest.approx(1.0 - 1.0 / 36.0), "in the cover, which turns with the ring"
    assert turning.get("output_bearing_inner", 1.0 / 36.0) == pytest.approx(1.0 / 36.0)


def test_lives_at_these_speeds() -> None:
    """Recomputed by hand from C, P and speed; they were 58 472 h and 4 062 071 h."""
    assert rate(PIN).items["output_rollers"].life == pytest.approx(63_344.0, rel=1e-4)
    two = PRESETS["twodisc"].but(friction={"law": "coulomb"})
    assert rate(two).items["shaft_bearing_far"].life == pytest.approx(3_926_700.0, rel=1e-4)


def test_roller_rolls_in_its_hole() -> None:
    """Roll a roller by its contact alone: its turn is the arc that it passes over its radius, less that of the hole."""
    radius, hole, steps = 4.0, 5.0, 20_000
    angle = np.linspace(0.0, 2.0 * math.pi, steps + 1)
    # in the frame of the carrier the hole does not turn, and its middle circles at hole - radius
    middle = (hole - radius) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    towards = -np.stack([np.cos(angle), np.sin(angle)], axis=1)  # from the roller's axis to the contact
    slid = np.diff(middle, axis=0)
    along = np.stack([-towards[:-1, 1], towards[:-1, 0]], axis=1)
    spun = np.einsum("ij,ij->i", slid, along).sum() / radius
    assert abs(spun) == pytest.approx(2.0 * math.pi * (hole / radius - 1.0), rel=1e-4)


@pytest.mark.parametrize("name", ["pin", pytest.param("twodisc", marks=pytest.mark.slow)])
def test_life_over_a_duty_is_miners_sum(name: str) -> None:
    """1/L = sum of share/L_i, for each item that counts cycles: bearings (p = 10/3, of balls 3), pitting, set, wear.

    With the exponent of rollers, ball bearings lived 43 779 h over a duty instead of 36 526 h.
    """
    design = PRESETS[name].but(friction={"law": "coulomb"})
    torque, speed = design.rated_torque, abs(design.drive.speed)
    parts = ((1.0, 0.5, 0.2), (0.4, 1.0, 0.5), (0.1, 1.0, 0.3))
    points = tuple(DutyPoint(load * torque, turn * speed, share) for load, turn, share in parts)
    together = rate(design, Duty(points, 2.0 * torque), stops=False).items
    alone = [rate(design, Duty((replace(one, share=1.0),), 2.0 * torque), stops=False).items for one in points]
    lives = {key: item.life for key, item in together.items() if item.life is not None}
    assert {"output_bearing_inner", "cam_bearing", "pin_gear_pitting", "pin_gear_wear"} <= lives.keys()
    for key, life in lives.items():
        miner = 1.0 / sum(one.share / items[key].life for one, items in zip(points, alone, strict=True))
        assert life == pytest.approx(miner, rel=1e-9), key


def test_equivalent_load_has_the_exponent_of_its_bearing() -> None:
    """Two loads of 1 and 3 kN for equal turns: ((1 + 27)/2)^(1/3) = 2.4101, and ((1 + 3^(10/3))/2)^(3/10) = 2.4725."""
    plain = Reducer(PIN.but(bearing={"service_factor": 1.0}))
    forces, turns = [np.full((4, 1), 1.0), np.full((4, 1), 3.0)], np.array([1.0, 1.0])
    assert bearing_load(plain, forces, turns, 3.0) == pytest.approx(14.0 ** (1.0 / 3.0))
    assert bearing_load(plain, forces, turns, 10.0 / 3.0) == pytest.approx((0.5 * (1.0 + 3.0 ** (10.0 / 3.0))) ** 0.3)


def test_bearings_of_shaft_and_output_heat_the_housing() -> None:
    """mu F d/2 w by hand: 0.002, the mean force, the bore of 16 mm, 171.74 rad/s; all losses heat the housing."""
    reducer = Reducer(PIN)
    one = solve_loading(reducer, constant_duty(PIN.rated_torque, PIN.drive.speed).points[0])
    lost = bearing_losses(reducer, one)
    near = float(bearing_forces(reducer, "shaft_bearing_near", one).mean())
    assert near == pytest.approx(2276.0, rel=0.01)
    assert lost["shaft_bearing_near"] == pytest.approx(0.002 * near * 8e-3 * PIN.drive.speed, rel=1e-9)
    inner = float(bearing_forces(reducer, "output_bearing_inner", one).mean())
    bore = next(bearing.bore for bearing in bearings_of(reducer) if bearing.key == "output_bearing_inner")
    assert lost["output_bearing_inner"] == pytest.approx(0.001 * inner * bore * PIN.drive.speed / 35.0, rel=1e-9)
    assert sum(lost.values()) == pytest.approx(10.3, rel=0.01), "next to 24.4 W of the contacts"
    items = rate(PIN).items
    assert items["power_lost"].value == pytest.approx(sum(one.losses.values()) + sum(lost.values()))
    assert "shaft bearing near 6.25 W" in items["power_lost"].note
    assert items["temperature"].value == pytest.approx(105.6, abs=0.1), "80.2 without them"
    assert figure("drive_efficiency_percent").value(reducer) == pytest.approx(83.8, abs=0.05)
    assert figure("efficiency_percent").value(reducer) == pytest.approx(88.05, abs=0.05)


def test_tilting_capacity_has_the_service_factor_of_the_rating() -> None:
    """A hub of `twodisc` under service factors 1 and f: (P/f - own) times the spacing; 48.75 N m ignored it."""
    two = PRESETS["twodisc"].but(friction={"law": "coulomb"})
    assert figure("output_tilting_capacity_nm").value(Reducer(two)) == pytest.approx(32.5, abs=0.05)
    plain = two.but(bearing={"service_factor": 1.0})
    assert figure("output_tilting_capacity_nm").value(Reducer(plain)) == pytest.approx(48.75, abs=0.05)


@pytest.mark.parametrize(
    ("gamma", "published"), [(0.01, 29.1), (0.05, 46.7), (0.1, 55.5), (0.16, 59.6), (0.2, 59.9), (0.3, 55.9)]
)
def test_factor_of_balls_is_that_of_the_table(gamma: float, published: float) -> None:
    """ISO 281:2007, Table 2: f_c of deep groove ball bearings; one ball of 1 mm leaves b_m f_c."""
    assert rolling.ball_capacity(1, 1e-3, 1e-3 / gamma) / 1.3 == pytest.approx(published, rel=2e-3)


def test_rating_of_thin_bearings_states_its_spread() -> None:
    """61812: 8.71 kN in the catalogue; by ISO 281, 22 balls of 5.4 mm on 69 mm have 1.3 x 52.5 x 7.85 x 20.8 = 11.2 kN.

    f_c at gamma 0.0783 between 46.7 (0.05) and 55.5 (0.1) of Table 2: 52.6.
    """
    note = rate(PIN).items["output_bearing_inner"].note
    assert "61812" in note
    assert "ISO 281 gives 1.116e+04 N for 22 balls of 5.4 mm (estimated), 2.1 times the life" in note


def test_bought_cam_bearing_is_not_rated_as_bare_rollers() -> None:
    """2 x HK1512 turn in the gear of `printed`: its plastic bore meets their cups, not rollers."""
    items = rate(PRESETS["printed"]).items
    assert "2 x HK1512" in items["cam_bearing"].note
    assert "in cam" not in items["peak_yield"].note + items["peak_dents"].note
    assert not [one.name for one in check(PRESETS["printed"]) if one.name.startswith("cam_y")]


def test_speed_limit_of_a_cage_is_not_that_of_rollers_that_touch() -> None:
    """20 rollers fill the cam of `pin` on a circle of 15 mm: half of 300 000/(2 x 15) rpm, over 1 + 1/35."""
    reducer = Reducer(PIN)  # the shaft's own bearings allow more
    assert cam_bearing(reducer) is None
    assert SPEED_LIMITS.full_complement_share == 0.5
    limit = SPEED_LIMITS.full_complement_share * SPEED_LIMITS.caged / 30e-3 / (1.0 + 1.0 / 35.0)
    assert figure("largest_speed_rpm").value(reducer) == pytest.approx(limit)
