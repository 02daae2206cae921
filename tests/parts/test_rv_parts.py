"""The parts of an RV reducer: sizes, mesh of the planet stage, and places in the assembly."""

import manifold3d
import numpy as np
import pytest

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks import soundness
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.parts import mass_properties, mesh
from cycloid_mj.parts.export import assembly_step, export, read_volume
from cycloid_mj.parts.export.rv_assembly import place_rv_parts, rv_assembly_parts, rv_mass
from cycloid_mj.parts.polygon import rotate_points
from cycloid_mj.parts.rv import rv_parts
from cycloid_mj.reducer import RvReducer

RV80E = PRESETS["rv80e"]
MICROMETRES = 1e6


def _sections(design: Design, crank: float, shown: set[str]) -> dict[str, manifold3d.CrossSection]:
    """Return the first sections [um] of the parts of some families, in place, by the name of the place."""
    reducer = RvReducer(design)
    parts = rv_parts(reducer)

    def loops(part: str) -> list[Array]:
        prism = parts[part].solid(1e-7).prisms[0]
        return [prism.outline, *(hole[::-1] for hole in prism.holes)]

    return {
        place.name: manifold3d.CrossSection(
            [
                MICROMETRES * (rotate_points(loop, place.angle) + np.array(place.origin[:2]))
                for loop in loops(place.part)
            ]
        )
        for place in place_rv_parts(reducer, crank)
        if names.family(place.part) in shown
    }


@pytest.mark.parametrize("crank", [0.0, 0.11, 0.37])
def test_sun_and_planets_mesh_without_backlash_at_every_angle(crank: float) -> None:
    teeth = _sections(RV80E, crank, {"sun", "planet"})
    sun = teeth.pop("sun")
    assert len(teeth) == 3
    for planet in teeth.values():
        assert (sun ^ planet).area() < 1.0  # square micrometres: rounding of the polygons
        assert (sun ^ planet.offset(2.0, manifold3d.JoinType.Round)).area() > 100.0


def test_backlash_separates_sun_and_planets() -> None:
    """Flanks are apart by the circumferential backlash times the cosine of the pressure angle."""
    # at the crank angle 0 a tooth is in the middle of its space: each flank has half of 40 um cos(20 deg) = 18.8 um
    teeth = _sections(RV80E.but(planet={"backlash": 40e-6}), 0.0, {"sun", "planet"})
    planet = teeth["planet_1"]
    assert (teeth["sun"] ^ planet.offset(18.7, manifold3d.JoinType.Round)).area() < 1.0
    assert (teeth["sun"] ^ planet.offset(19.0, manifold3d.JoinType.Round)).area() > 5.0


@pytest.mark.parametrize("crank", [0.0, 1.3])
def test_needles_fill_the_bores_and_posts_stay_clear(crank: float) -> None:
    shapes = _sections(RV80E, crank, {"gear", "needle", "pin"})
    for name in ("gear_1", "gear_2"):
        disc = shapes[name]
        inner = [shape for part, shape in shapes.items() if names.family(part) == "needle"]
        own = inner[:14] if name == "gear_1" else inner[14:28]
        # the polygons of needles are inside of their circles, the bores' too: 0.1 um each
        assert all((disc ^ needle.offset(-1.0, manifold3d.JoinType.Round)).area() == 0.0 for needle in own)
        assert all((disc ^ needle.offset(1.0, manifold3d.JoinType.Round)).area() > 0.0 for needle in own)
        pins = [shape for part, shape in shapes.items() if names.family(part) == "pin"]
        assert all((disc ^ pin.offset(-0.5, manifold3d.JoinType.Round)).area() < 1.0 for pin in pins)


def test_the_disc_has_the_section_of_the_reducer_and_every_part_is_closed() -> None:
    reducer = RvReducer(RV80E)
    parts = rv_assembly_parts(reducer)
    width = RV80E.gear.face_width
    disc = mass_properties(parts["gear_1"].solid(1e-7))
    assert disc.volume == pytest.approx(reducer.disc_section * width, rel=1e-4)
    for part in parts.values():
        mesh(part.solid(5e-6))  # checks that the surface is closed and has the volume of the solid


def test_exports_have_every_part_and_the_clearances_of_the_design() -> None:
    made = export(RV80E, "dxf")
    wanted = {"housing", "gear_1", "gear_2", "crank", "planet", "sun", "carrier_1", "carrier_2", "pin", "needle"}
    assert set(made.files) == {f"{name}.dxf" for name in wanted}
    assert {clearance.pair: clearance.most for clearance in made.clearances} == pytest.approx(
        {"pin_gear": 1e-7, "pin_socket": 1e-7}, abs=2e-8
    )


@pytest.mark.parametrize(
    ("key", "value", "check"),
    [
        ("cranks.taper_radius_mm", 28.0, "flange_in_ring"),
        ("cranks.taper_radius_mm", 10.0, "tapered_bearings"),
        ("planet.planet_teeth", 11, "planet_teeth"),
    ],
)
def test_a_check_reports_parts_that_do_not_fit(key: str, value: float, check: str) -> None:
    """`design check` prints the mass of the parts, so whatever the parts refuse has to be a failed check before."""
    checks = soundness(RvReducer(override(RV80E, {key: value})))
    assert check in [item.name for item in checks if not item.passed]


def test_an_assembly_of_sleeved_pins_has_all_its_parts() -> None:
    reducer = RvReducer(RV80E.but(ring={"pins": "sleeved"}))
    assert {place.part for place in place_rv_parts(reducer)} == rv_assembly_parts(reducer).keys()


def test_undercut_planets_are_refused_with_the_key() -> None:
    with pytest.raises(DesignError, match=r"planet\.planet_teeth = 11.*undercut.*Use more teeth"):
        rv_parts(RvReducer(RV80E.but(planet={"planet_teeth": 11}, cranks={"radius": 0.0184})))


def test_the_mass_is_that_of_an_rv_reducer_of_its_size() -> None:
    """The catalogue's RV-80E weighs 13.1 kg with main bearings and screws, which are not drawn."""
    mass = rv_mass(RvReducer(RV80E))
    closed_form = 2.0 * RvReducer(RV80E).disc_section * RV80E.gear.face_width * RV80E.material.density
    assert closed_form < mass
    assert 8.0 < mass < 13.1


@pytest.mark.slow
def test_the_assembly_has_the_volume_of_its_parts() -> None:
    reducer = RvReducer(RV80E)
    parts = rv_assembly_parts(reducer)
    volumes = {name: mass_properties(part.solid(1e-6)).volume for name, part in parts.items()}
    total = sum(volumes[place.part] for place in place_rv_parts(reducer))
    assert read_volume(assembly_step(reducer)) == pytest.approx(total, rel=1e-3)
