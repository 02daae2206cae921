"""Thermal expansion: closed forms of each clearance, and the difference of temperatures that jams a drive."""

import math

import numpy as np
import pytest
from designs import design_file

import cycloid_mj as cm
from cycloid_mj.base.errors import DesignError, RunError
from cycloid_mj.design import PRESETS, Design, load, override
from cycloid_mj.geometry.expansion import expand, jam_difference, strain, warm_clearances
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.reducer.limits import find_tightest_pairs, stops

STEEL = 13e-6
"""Expansion of the alloy steel of the presets [1/K]."""


def warm(name: str, *changes: str) -> Design:
    """Return a preset with changed values, before its expansion."""
    return override(PRESETS[name], [*changes])


@pytest.mark.parametrize("name", PRESETS)
def test_at_20_degrees_the_design_itself_is_used(name: str) -> None:
    assert expand(PRESETS[name]) is PRESETS[name]
    assert reducer_of(PRESETS[name]).design is PRESETS[name]


@pytest.mark.parametrize("name", ["pin", "nonpin"])
def test_one_material_at_one_temperature_keeps_all_clearances(name: str) -> None:
    hot = warm(name, *(f"thermal.{part}_c=80" for part in ("disc", "ring", "crank", "output", "housing")))
    for pair, clearance in warm_clearances(hot).items():
        assert clearance == pytest.approx(getattr(hot.clearance, pair), abs=1e-15)


def test_clearances_of_a_warm_disc_match_closed_forms() -> None:
    design = warm("pin", "thermal.disc_c=21")
    growth = STEEL * 1.0
    clearances = warm_clearances(design)
    assert clearances["pin_gear"] == pytest.approx(1e-6 + (2.25e-3 + 1e-6) * growth, rel=1e-12)
    assert clearances["cam"] == pytest.approx(1e-6 + (15e-3 + 1e-6) * growth, rel=1e-12)
    assert clearances["output"] == pytest.approx(1e-6 + (5e-3 + 1e-6 - 1e-3) * growth, rel=1e-12)
    assert clearances["pin_socket"] == 1e-6


def test_an_aluminium_housing_opens_the_pin_circle() -> None:
    """A steel disc in an aluminium ring, all 40 K warmer: the pin circle grows by (23 - 13) 1e-6 E 40 more."""
    parts = ("disc", "ring", "crank", "output", "housing")
    design = warm(
        "pin",
        "housing_material.expansion_um_m_k=23",
        *(f"thermal.{part}_c=60" for part in parts),
        "clearance.pin_socket_um=5",
    )
    shift = expand(design).modification.pin_circle
    relative = (1.0 + STEEL * 40.0) / (1.0 + 23e-6 * 40.0) - 1.0
    assert strain(design, "gear") == pytest.approx(relative, rel=1e-12)
    assert shift == pytest.approx(40.75e-3 * relative, rel=1e-12)
    assert shift == pytest.approx(-16.3e-6, rel=2e-3)


def test_a_warm_disc_moves_its_holes_outward_and_keeps_its_errors() -> None:
    design = warm("pin", "thermal.disc_c=21", "errors.hole_position_um=2", "errors.seed=3")
    before, after = Reducer(PRESETS["pin"]).deviations, expand(design)
    moved = np.stack([after.errors.hole_x, after.errors.hole_y], axis=1)
    drawn = Reducer(warm("pin", "errors.hole_position_um=2", "errors.seed=3")).deviations.hole_displacement[0]
    assert np.allclose(before.hole_displacement, 0.0)
    assert np.allclose(np.linalg.norm(moved - drawn, axis=1), 26e-3 * STEEL, rtol=1e-9)
    assert np.allclose((moved - drawn)[0], [0.0, 26e-3 * STEEL], atol=1e-15), "the first hole is on +y"


@pytest.mark.parametrize(("name", "play"), [("pin", 2e-6), ("nonpin", 1e-6)])
def test_the_jam_difference_closes_the_last_gap(name: str, play: float) -> None:
    """By the closed form, and by the linear programme over all gaps of the teeth at that difference."""
    difference = jam_difference(PRESETS[name])
    assert difference == pytest.approx(play / (STEEL * 38.5e-3), rel=1e-12)
    others = ("clearance.output_um=100", "clearance.cam_um=100")
    for factor, jams in ((0.98, False), (1.02, True)):
        heated = warm(name, *others, f"thermal.disc_c={20.0 + factor * difference}")
        gap, _ = find_tightest_pairs(Reducer(heated), 0.0)
        assert (gap < 0.0) == jams


def test_no_expansion_never_jams() -> None:
    assert jam_difference(warm("pin", "material.expansion_um_m_k=0")) == math.inf


def test_a_lost_clearance_is_an_error_with_its_cause() -> None:
    with pytest.raises(
        DesignError, match=r"parts jam: .*clearance\.pin_(socket|gear)_um from 1 to -6.*ring at 60 °C"
    ) as error:
        Reducer(warm("pin", "pin_material.expansion_um_m_k=80", "thermal.ring_c=60"))
    assert "Increase the clearance" in str(error.value)


def test_a_disc_that_jams_warm_names_its_temperature() -> None:
    """The disc of this design expands more than its ring, although both have the same temperature."""
    parts = ("disc", "ring", "crank", "output", "housing")
    design = override(load(design_file("fixed-n31-d1-carrier-250um")), [f"thermal.{part}_c=60" for part in parts])
    with pytest.raises(RunError, match=r"jams .* because thermal expansion \(60 °C\) .* or keep the parts closer to"):
        stops(Reducer(design), 0.0)


def test_warm_sizes_are_not_expanded_twice_nor_manufactured() -> None:
    design = Reducer(warm("pin", "thermal.disc_c=21")).design
    assert design.thermal.applied
    assert Reducer(design).design is design
    with pytest.raises(DesignError, match="manufactured at 20 °C"):
        _ = design.at_reference


def test_parts_are_drawn_at_20_degrees() -> None:
    hot = cm.export(warm("printed", "thermal.disc_c=60"), "stl", chord_error=1e-4)
    assert hot.files == cm.export(PRESETS["printed"], "stl", chord_error=1e-4).files


def test_backlash_falls_in_a_disc_warmer_than_its_ring() -> None:
    """The play of the pins is lost in proportion: 2 of 4 K leave about half of the play of the teeth."""
    cold, hot = (
        cm.statics(design).quantities["backlash"].value for design in (PRESETS["pin"], warm("pin", "thermal.disc_c=22"))
    )
    assert hot < cold
    assert "disc 22 °C" in cm.statics(warm("pin", "thermal.disc_c=22")).condition


def test_warm_materials_are_softer_and_weaker() -> None:
    """Steel at 100 °C has 0.98 of its modulus and 0.96 of its strengths; POM at 70 °C is between its 60 and 80 °C."""
    steel = warm("pin", *(f"thermal.{part}_c=100" for part in ("disc", "ring", "crank", "output")))
    for part in ("gear", "pin", "shaft"):
        cold, hot = steel.material_of(part), Reducer(steel).design.material_of(part)
        assert hot.youngs_modulus == pytest.approx(0.98 * cold.youngs_modulus)
        assert hot.yield_strength == pytest.approx(0.96 * cold.yield_strength)
        assert (hot.density, hot.expansion, hot.poisson) == (cold.density, cold.expansion, cold.poisson)
    plastic = warm("pin", 'gear_material.name="POM"', "clearance.pin_gear_um=800", "thermal.disc_c=70")
    disc = Reducer(plastic).design
    assert disc.material_of("gear").youngs_modulus == pytest.approx(0.525 * 2850e6)
    assert disc.material_of("pin").youngs_modulus == plastic.material_of("pin").youngs_modulus


def test_a_warm_steel_drive_equals_a_drive_of_softer_steel() -> None:
    """At 100 °C: the stiffness, pressures and yield of a drive of 0.98 of the modulus and 0.96 of the strength."""
    hot = warm("pin", *(f"thermal.{part}_c=100" for part in ("disc", "ring", "crank", "output")))
    steel = PRESETS["pin"].material
    softer = PRESETS["pin"].but(
        material={"youngs_modulus": 0.98 * steel.youngs_modulus, "yield_strength": 0.96 * steel.yield_strength}
    )
    cold = cm.statics("pin").quantities
    for key in ("stiffness_ideal", "pin_gear_pressure", "capacity"):
        values = [cm.statics(design).quantities[key].value for design in (hot, softer)]
        assert values[0] == pytest.approx(values[1], rel=1e-6), key
        assert values[0] < cold[key].value
