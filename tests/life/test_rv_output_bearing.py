"""Main bearings of an RV reducer: forces, life, permitted moment, tilting stiffness, friction and data-sheet rows."""

import math

import numpy as np
import pytest
from page_texts import require_separate_texts

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import ARCMINUTE, HOUR, RPM
from cycloid_mj.design import PRESETS, override
from cycloid_mj.figures import figure
from cycloid_mj.life import rate, rolling
from cycloid_mj.life.bearing_pair import OutputBearings
from cycloid_mj.life.datasheet import datasheet
from cycloid_mj.life.output_bearing import output_bearings
from cycloid_mj.life.rv import crank_forces, main_bearing_forces
from cycloid_mj.plots.datasheet import datasheet_pages
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.film import roller_bearings, seal_torques

KEYS = ("cranks.main_bearings=angular_contact", "cranks.flange_thickness_mm=22")
DRIVE = RvReducer(override(PRESETS["rv80e"], KEYS))
ROWS = (
    "output_tilting_capacity_nm",
    "output_tilting_stiffness_nm_per_arcmin",
    "output_radial_load_n",
    "output_axial_load_n",
)


@pytest.fixture(scope="module")
def pair() -> OutputBearings:
    bearings = output_bearings(DRIVE)
    assert isinstance(bearings, OutputBearings)
    return bearings


def test_load_centres_are_beyond_the_bearings(pair: OutputBearings) -> None:
    """Middles at 26 mm on both sides of the discs; contact lines at 25 deg on the mean diameter of 147.5 mm."""
    centre = 26e-3 + 0.5 * 147.5e-3 * math.tan(math.radians(25.0))
    assert pair.spacing == pytest.approx(2.0 * centre)
    assert pair.lever == pytest.approx(39e-3 - centre), "the face of the carrier is within the load centre"


def test_forces_balance_those_of_the_discs() -> None:
    bearing = DRIVE.main_bearing
    assert bearing is not None
    forces = crank_forces(DRIVE, 784.0)
    near, far = main_bearing_forces(DRIVE, bearing, forces)
    on_discs, planes = forces.sum(axis=2), np.array(DRIVE.design.gear.disc_planes)
    largest = np.abs(on_discs).max()
    np.testing.assert_allclose(near + far + on_discs.sum(axis=1), 0.0, atol=1e-9 * largest)
    moment = np.einsum("mdi,d->mi", on_discs, planes)
    centre = 0.5 * output_bearings(DRIVE).spacing
    np.testing.assert_allclose(centre * (far - near), -moment, atol=1e-9 * largest)


def test_discs_load_the_bearings_by_their_couple(pair: OutputBearings) -> None:
    """Two opposed discs press on their cranks with 6490.6 N along the pitch line and 2525.5 N, 17 mm apart."""
    ideal = math.hypot(6490.6, 2525.5) * 17e-3 / pair.spacing
    assert pair.own == pytest.approx((ideal, ideal), rel=0.04), "with friction, 3 % more"


def test_permitted_moment_has_the_required_life(pair: OutputBearings) -> None:
    """71826.E carries 37 kN for a million turns; the design requires 6000 h at 15 rpm, 5.4 million turns."""
    load = 37000.0 / 5.4 ** (1.0 / 3.0)
    assert pair.capacity == pytest.approx(load)
    assert rolling.life_hours(37000.0, pair.capacity, 15.0 * RPM, 0.9, 3.0) == pytest.approx(6000.0)
    assert pair.moment == pytest.approx(pair.spacing * (load - max(pair.own)))
    assert pair.moment_source == "ISO 281 and 76"


def test_for_a_short_life_the_static_factor_limits_the_moment() -> None:
    short = output_bearings(DRIVE.but(service={"life": 10.0}))
    assert isinstance(short, OutputBearings)
    assert short.capacity == short.static == 64500.0
    force = short.moment / short.spacing + max(short.own)
    assert short.static / force == pytest.approx(1.0), "s0 = C0/P0, ISO 76"


def test_tilting_stiffness_matches_the_closed_form_of_a_pair(pair: OutputBearings) -> None:
    """A tilt t moves both load centres by t s/2 across the axis; the forces F on them balance the moment F s."""
    force = 0.5 * pair.moment / pair.spacing
    stiffness = force / _radial_deflection(force)
    assert pair.tilting_stiffness() == pytest.approx(0.5 * stiffness * pair.spacing**2, rel=0.01)


def _radial_deflection(force: float) -> float:
    """Compute the radial deflection [m] of a 71826 under a `force` [N] by summing its 34 balls, without clearance.

    A ball of 10.5 mm under Q deflects by 0.44 um (Q^2/D)^(1/3) in N and mm (Palmgren), at 25 deg to the plane.
    """
    cosine, angles = math.cos(math.radians(25.0)), 2.0 * math.pi * np.arange(34) / 34

    def radial_force(deflection: float) -> float:
        approach = np.maximum(deflection * np.cos(angles), 0.0) * cosine
        return float(np.sum((approach / 0.44e-6) ** 1.5 * math.sqrt(10.5) * np.cos(angles)) * cosine)

    low, high = 0.0, 1e-3
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if radial_force(middle) < force else (low, middle)
    return low


def test_a_larger_distance_of_the_bearings_stiffens_the_pair(pair: OutputBearings) -> None:
    wide = output_bearings(DRIVE.but(gear={"disc_gap": 22e-3}))
    assert isinstance(wide, OutputBearings)
    assert wide.spacing == pytest.approx(pair.spacing + 20e-3)
    assert wide.moment > pair.moment
    # at equal forces the deflections are equal; Palmgren's are as the force^(2/3)
    share = (wide.moment / wide.spacing) / (pair.moment / pair.spacing)
    expected = (wide.spacing / pair.spacing) ** 2 * share ** (1.0 / 3.0)
    assert wide.tilting_stiffness() / pair.tilting_stiffness() == pytest.approx(expected)


def test_items_are_those_of_bearings_with_the_preload() -> None:
    items = rate(DRIVE.design).items
    inner, outer = items["output_bearing_inner"], items["output_bearing_outer"]
    assert {item.kind for item in (inner, outer, items["output_bearing_outer_static"])} == {"bearing"}
    assert inner.life is not None
    turns = 15.0 * 60.0 * inner.life
    assert turns == pytest.approx(1e6 * (37000.0 / inner.value) ** 3)
    assert "15 rpm mean speed" in inner.note
    assert "IBC's catalogue: 71826.E" in inner.note
    assert inner.value == pytest.approx(outer.value, rel=1e-3)
    idle = rate(DRIVE.but(drive={"torque": 1e-3 * DRIVE.design.drive.torque}).design).items["output_bearing_inner"]
    assert idle.value == pytest.approx(0.87 * 370.0, rel=0.01), "X F_r + Y F_a with the preload of 1 % of C"
    static = items["output_bearing_inner_static"]
    assert static.safety == pytest.approx(64500.0 / (2.0 * output_bearings(DRIVE).own[0]), rel=1e-6)


def test_bearings_of_a_ring_that_turns_have_the_speed_of_the_output() -> None:
    turning = DRIVE.but(output={"member": "ring"})
    life = rate(turning.design).items["output_bearing_inner"]
    assert f"{abs(turning.output_speed) / RPM:.4g} rpm mean speed" in life.note
    assert output_bearings(turning).capacity == pytest.approx(
        37000.0 * (1e6 * 2.0 * math.pi / (6000.0 * HOUR * abs(turning.output_speed))) ** (1.0 / 3.0)
    )


def test_friction_follows_the_chosen_bearings() -> None:
    bearing = DRIVE.main_bearing
    assert bearing is not None
    main = roller_bearings(DRIVE)[2]
    assert (main.count, main.diameter) == (2, pytest.approx(147.5e-3))
    assumed = roller_bearings(RvReducer(PRESETS["rv80e"]))[2]
    assert assumed.diameter == pytest.approx(129.75e-3 / 2.0 + 77.5e-3)
    assert seal_torques(DRIVE)[1] == pytest.approx(7.69e-6 * (2e3 * bearing.shoulders[0]) ** 2 / RPM)


def test_figures_exist_with_main_bearings_only() -> None:
    for key in ROWS:
        assert figure(key).applies_to(DRIVE)
        assert not figure(key).applies_to(RvReducer(PRESETS["rv80e"]))
    assert figure(ROWS[1]).value(DRIVE) == pytest.approx(output_bearings(DRIVE).tilting_stiffness() * ARCMINUTE)
    with pytest.raises(DesignError, match="rv80e has no main bearings"):
        output_bearings(RvReducer(PRESETS["rv80e"]))


@pytest.mark.slow
def test_the_data_sheet_has_the_rows_of_the_output_bearings(pair: OutputBearings) -> None:
    sheet = datasheet(DRIVE)
    rows = {row.key: row for row in sheet.groups["Output bearing"]}
    assert [*rows] == [*ROWS]
    assert rows[ROWS[0]].value == pair.moment
    assert "2 x 71826.E, load centres 120.8 mm apart" in rows[ROWS[0]].note
    mass = next(row for row in sheet.groups["Mass and size"] if row.key == "mass")
    assert "main bearings" not in mass.note
    assert any("friction by preload and run-out of the main bearings" in note for note in sheet.notes)
    for page in datasheet_pages(sheet):
        require_separate_texts(page)
    plain = datasheet(RvReducer(PRESETS["rv80e"]))
    assert "Output bearing" not in plain.groups
    assert not {*ROWS} & plain.as_json()["quantities"].keys()
