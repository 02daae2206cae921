"""Materials by part: the library, the design file, and what follows from both partners of a contact."""

import math
from dataclasses import replace

import numpy as np
import pytest
from designs import UNLIKE, unlike

from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks import check, summarize
from cycloid_mj.design import PARTNERS, PARTS, PRESETS, Design, describe_plastic_limits, dump, loads, override
from cycloid_mj.design.materials import DEFAULT, MATERIALS, SOFTEST_METAL
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.items import rate
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.parts import mass_properties, parts
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import loads as carried
from cycloid_mj.statics import springs_of
from cycloid_mj.statics.sheet import sheet
from cycloid_mj.stress.region import material_of

PIN = PRESETS["pin"]
PLASTICS = {"POM", "PA6", "PA12", "PA-CF", "Onyx", "PETG", "PLA", "resin"}


@pytest.mark.slow
def test_the_library_is_plausible_and_states_its_sources() -> None:
    for name, entry in MATERIALS.items():
        assert entry.source, name
        assert entry.yield_strength <= entry.tensile_strength < 0.05 * entry.youngs_modulus, name
        assert 0.25 < entry.poisson < 0.45, name
        assert (entry.youngs_modulus < SOFTEST_METAL) == (name in PLASTICS) == (entry.youngs_modulus < 1e10), name
    for name in MATERIALS:
        failed = [one.name for one in check(override(PIN, {"material.name": name})) if not one.passed]
        assert not {"yield_strength", "youngs_modulus", "density", "poisson"} & set(failed), name


def test_a_material_name_sets_its_values_except_those_stated() -> None:
    named = override(PIN, {"material.name": "bronze"}).material
    assert named.youngs_modulus == MATERIALS["bronze"].youngs_modulus
    assert loads('[material]\nname = "POM"\ndensity_kg_m3 = 1500.0\n').material.density == 1500.0
    assert loads('[material]\nname = "POM"\n').material.youngs_modulus == MATERIALS["POM"].youngs_modulus
    assert PIN.but(material={"name": "POM"}).material == override(PIN, {"material.name": "POM"}).material
    assert loads("[material]\ndensity_kg_m3 = 7800.0\n").material.name == ""
    assert PIN.material.name == DEFAULT


def test_a_part_without_a_material_name_starts_from_the_common_material() -> None:
    design = loads('[material]\nname = "bronze"\n[gear_material]\ndensity_kg_m3 = 9000.0\n')
    assert design.material_of("gear").youngs_modulus == MATERIALS["bronze"].youngs_modulus
    assert design.material_of("gear").density == 9000.0
    assert design.material_of("pin") == design.material


def test_the_file_has_only_tables_of_parts_that_differ() -> None:
    assert "_material]" not in dump(PIN)
    design = override(PIN, {"gear_material.name": "POM", "pin_material.name": "bearing steel"})
    assert loads(dump(design)) == design
    assert "[gear_material]" in dump(design)
    assert "[shaft_material]" not in dump(design)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (["gear_material.name=PEEK"], 'gear_material.name = "PEEK" is not allowed.*bearing steel'),
        (["gear_material.colour=red"], "unknown key gear_material.colour"),
        (["gear_material=POM"], "gear_material is a table"),
        (["rotor_material.name=POM"], "unknown key rotor_material"),
    ],
)
def test_wrong_materials_are_refused(changes: list[str], message: str) -> None:
    with pytest.raises(DesignError, match=message):
        override(PIN, changes)


def test_one_material_named_for_every_part_changes_nothing() -> None:
    apart = override(PIN, {f"{part}_material.name": DEFAULT for part in PARTS})
    for kind in PARTNERS:
        assert Reducer(apart).contacts[kind].modulus == Reducer(PIN).contacts[kind].modulus
        if kind != "pin_sleeve":
            assert Reducer(apart).contacts[kind].stiffness == Reducer(PIN).contacts[kind].stiffness


@pytest.mark.parametrize("kind", PARTNERS)
def test_the_modulus_of_a_pair_is_that_of_springs_in_series(kind: str) -> None:
    soft = override(PIN, {"gear_material.name": "POM"})
    one, other = soft.partners(kind)
    flexibility = sum((1.0 - part.poisson**2) / part.youngs_modulus for part in (one, other))
    assert Reducer(soft).contacts[kind].modulus == pytest.approx(1.0 / flexibility, rel=1e-12)
    assert ("gear" in PARTNERS[kind]) == (
        Reducer(soft).contacts[kind].modulus < 0.1 * Reducer(PIN).contacts[kind].modulus
    )
    assert Reducer(soft).contacts[kind].strength == min(one.yield_strength, other.yield_strength)


def test_only_contacts_of_the_soft_part_are_softer_and_less_pressed() -> None:
    steel = override(PIN, {"contact.working_force_n": 50.0})  # else it follows the weight of the gear
    soft = override(steel, {"gear_material.name": "POM"})
    # both in series: the compliance is at least that of the soft part alone, half of what two soft ones have
    both = override(steel, {"material.name": "POM"})
    for kind in ("pin_gear", "output"):
        assert (
            Reducer(both).contacts[kind].stiffness
            < Reducer(soft).contacts[kind].stiffness
            < 2.2 * Reducer(both).contacts[kind].stiffness
        )
        assert Reducer(soft).contacts[kind].pressure(100.0, 400.0) < 0.2 * Reducer(PIN).contacts[kind].pressure(
            100.0, 400.0
        )
    assert Reducer(soft).contacts["pin_socket"].stiffness == Reducer(steel).contacts["pin_socket"].stiffness
    assert (
        Reducer(soft).contacts.teeth.curvature_law.deflection
        > 10.0 * Reducer(steel).contacts.teeth.curvature_law.deflection
    )


def test_a_rolling_cam_is_two_rows_of_contacts_in_series() -> None:
    soft, steel = override(PIN, {"gear_material.name": "POM"}), PIN
    rollers_on_steel, whole = 2.0 * Reducer(steel).contacts["cam"].stiffness, Reducer(soft).contacts["cam"].stiffness
    on_plastic = 1.0 / (1.0 / whole - 1.0 / rollers_on_steel)
    assert 0.01 * rollers_on_steel < on_plastic < 0.04 * rollers_on_steel


def test_the_mass_of_each_part_follows_its_material() -> None:
    design = override(PIN, {f"{part}_material.density_kg_m3": 1000.0 * n for n, part in enumerate(PARTS, start=1)})
    for n, part in enumerate(PARTS, start=1):
        before, after = (mass_properties(parts(Reducer(one))[part]) for one in (PIN, design))
        assert after.mass / after.volume == pytest.approx(1000.0 * n, rel=1e-9)
        assert part == "shaft" or after.volume == before.volume  # the shaft's counterweight balances the gear


def test_statics_share_the_load_over_more_teeth_of_a_soft_gear() -> None:
    def teeth(design: Design) -> float:
        force = carried(Reducer(design), springs_of(Reducer(design), np.linspace(0.0, 0.2, 5)), 10.0).teeth
        return float((force > 0.01 * force.max()).sum(axis=1).mean())

    assert teeth(override(PIN, {"gear_material.name": "POM"})) > teeth(PIN)


def test_the_weaker_part_decides_and_the_remedy_names_its_table() -> None:
    failed = {one.name: one for one in check(override(PIN, {"gear_material.name": "POM"})) if not one.passed}
    assert failed["tooth_yield"].bound == pytest.approx(1.79 * 64.0)
    assert "gear_material.yield_strength_mpa" in failed["tooth_yield"].remedy
    own = override(PIN, {"pin_material.yield_strength_mpa": 800.0, "pin_material.tensile_strength_mpa": 700.0})
    assert [one.name for one in check(own) if one.severity == "error" and not one.passed] == ["pin_yield_strength"]


def test_plastics_state_that_they_creep_and_how_hot_they_may_be() -> None:
    assert describe_plastic_limits(PIN) == ()
    (limit,) = summarize(Reducer(override(PIN, {"gear_material.name": "POM"}))).material_limits
    assert "POM (gear) creeps and is usable up to 90 °C" in limit
    (own,) = describe_plastic_limits(unlike("printed"))
    assert own.startswith("a plastic (gear, housing, pin, output, shaft) creeps:")


@pytest.mark.parametrize("name", UNLIKE)
def test_statics_runs_with_parts_of_another_material_on_every_design(name: str) -> None:
    design = override(unlike(name), {"pin_material.name": "bearing steel"})
    found = summarize(Reducer(design))
    assert math.isfinite(found.backlash)
    assert math.isfinite(found.mass)


def test_stress_uses_the_material_of_each_part() -> None:
    design = override(PIN, {"housing_material.name": "aluminium 6061", "pin_material.name": "bearing steel"})
    assert material_of(Reducer(design), "ring").name == "aluminium 6061"
    assert material_of(Reducer(design), "pin_1").name == "bearing steel"
    assert material_of(Reducer(design), "gear") == material_of(Reducer(design), "shaft") == PIN.material


def test_limits_of_plastics_are_printed_next_to_their_figures() -> None:
    printed = PRESETS["printed"]
    (limit,) = describe_plastic_limits(printed)
    assert "Onyx (gear, housing) creeps and is usable up to 80 °C" in limit
    assert describe_plastic_limits(PIN) == ()
    assert sheet(Reducer(printed)).assumptions[-1] == limit
    assert rate(printed, duty_of(printed, 10.0)).assumptions[-1] == limit
    measured = Measurement("te", printed, {}, assumptions=("one",))
    assert measured.assumptions == ("one", limit)
    assert replace(measured, condition="any").assumptions == ("one", limit)
    assert Measurement("te", PIN, {}, assumptions=("one",)).assumptions == ("one",)


def duty_of(design: Design, torque: float):
    return constant_duty(torque, design.drive.speed)
