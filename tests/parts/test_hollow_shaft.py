"""A bore through shaft, hub and flange: solids, bill, section properties, and what it excludes."""

import math

import pytest
from casings import check_casing

from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks import check
from cycloid_mj.design import PRESETS, override
from cycloid_mj.parts.contour import circle_of
from cycloid_mj.parts.crank import shaft_dimensions
from cycloid_mj.parts.export import bill, casing
from cycloid_mj.parts.export.assembly import assembly_parts
from cycloid_mj.parts.export.order import assembly_order
from cycloid_mj.parts.export.output_flange import axial_bores
from cycloid_mj.parts.inertia import mass_properties
from cycloid_mj.parts.parts import crank_solid
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.film import seal_torques
from cycloid_mj.statics.structure import crank_flexibility, twisting_stiffness

BORED = {
    "twodisc": ("shaft.bore_radius_mm=6",),
    "pin": ("shaft.bore_radius_mm=5", "shaft.mounting=straddle"),
    "printed": ("shaft.bore_radius_mm=3",),
}


def hollow(name: str, *more: str) -> Reducer:
    return Reducer(override(PRESETS[name], [*BORED[name], *more]))


@pytest.mark.parametrize("name", BORED)
def test_the_bore_is_open_from_the_motor_side_to_the_flange(name: str) -> None:
    reducer = hollow(name)
    sizes = casing(reducer)
    around_axis = [
        math.dist(circle.centre, (0.0, 0.0)) < 1e-9 and circle.radius
        for part in ("shaft", "output", "output_flange", "motor_cover")
        for segment in assembly_parts(reducer, sizes)[part].segments
        if math.hypot(*segment.outline.polygon(1e-5).mean(axis=0)) < 2e-3  # not an output pin
        for circle in [max(map(circle_of, segment.holes), key=lambda one: one.radius - math.hypot(*one.centre))]
    ]
    assert min(around_axis) >= reducer.design.shaft.bore_radius - 1e-12


@pytest.mark.parametrize("name", BORED)
def test_parts_run_free_and_the_bill_has_their_mass(name: str) -> None:
    reducer = hollow(name)
    (shaft,) = [line for line in check_casing(reducer, casing(reducer)) if line.item == "shaft"]
    assert f"bored through {2e3 * reducer.design.shaft.bore_radius:g} mm" in shaft.size


def test_the_crank_loses_the_mass_of_the_bore_and_stays_balanced() -> None:
    cranks = hollow("pin", "shaft.bore_radius_mm=0"), hollow("pin")
    solid, bored = (mass_properties(crank_solid(one)) for one in cranks)
    prisms = crank_solid(hollow("pin")).prisms
    length = max(one.z1 for one in prisms) - min(one.z0 for one in prisms)
    lost = hollow("pin").design.material_of("shaft").density * math.pi * 5e-3**2 * length
    assert solid.mass - bored.mass == pytest.approx(lost, rel=1e-3)
    assert solid.mass * solid.centroid[1] == pytest.approx(bored.mass * bored.centroid[1], abs=1e-9)
    about_axis = [one.inertia[2, 2] + one.mass * one.centroid[1] ** 2 for one in (solid, bored)]
    assert about_axis[0] - about_axis[1] == pytest.approx(0.5 * lost * 5e-3**2, rel=1e-3)


def test_bending_and_torsion_are_those_of_a_hollow_section() -> None:
    """I of a tube is pi/64 (D^4 - d^4) and its section modulus 2 I/D: 24 mm with a bore of 12 mm has 15/16."""
    bored, solid = (hollow("twodisc", "structure=springs", *more) for more in ((), ("shaft.bore_radius_mm=0",)))
    assert twisting_stiffness(bored)["shaft"] == pytest.approx(15.0 / 16.0 * twisting_stiffness(solid)["shaft"])
    assert crank_flexibility(bored) == pytest.approx(16.0 / 15.0 * crank_flexibility(solid))
    modulus = math.pi / 32.0 * (24e-3**4 - 12e-3**4) / 24e-3
    assert shaft_dimensions(bored).nominal_bending == pytest.approx(1.0 / modulus)


def test_a_second_seal_is_counted() -> None:
    bored, solid = (seal_torques(one) for one in (hollow("twodisc"), hollow("twodisc", "shaft.bore_radius_mm=0")))
    assert bored[0] == pytest.approx(2.0 * solid[0])
    assert bored[1] == pytest.approx(solid[1])
    fits = {line.item: line.fit for line in bill(hollow("printed"), 0.0, casing(hollow("printed")))}
    assert fits["shaft_bearing"].endswith("both sealed (RS1)")


def test_no_motor_is_on_the_axis() -> None:
    reducer = hollow("twodisc")
    sizes = casing(reducer)
    assert sizes.motor_bore is None
    assert sizes.journal < sizes.face, "the crank protrudes"
    assert "belt pulley" in assembly_order(reducer, sizes)[-1]
    with pytest.raises(DesignError, match=r"closes the through bore.*--motor circle"):
        casing(reducer, "nema34")


def test_impossible_bores_are_refused() -> None:
    with pytest.raises(DesignError, match=r'shaft.mounting = "straddle"'):
        casing(hollow("pin", "shaft.mounting=overhang"))
    with pytest.raises(DesignError, match=r"does not pass between the screws of the output flange"):
        axial_bores(hollow("twodisc"), casing(hollow("twodisc")).flange_bolt, 9e-3, None, 0.0, 1e-3)
    found = check(hollow("pin", "shaft.bore_radius_mm=7.5").design)
    assert [one.passed for one in found if one.name == "shaft_bore"] == [False]
