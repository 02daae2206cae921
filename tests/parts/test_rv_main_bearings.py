"""Main bearings of RV reducers: choice in stock, seats in flanges and housing, checks, bill, drawings and assembly."""

import math
from pathlib import Path

import numpy as np
import pytest

from cycloid_mj.base import names
from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks import soundness
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design, override, stock
from cycloid_mj.parts import Part, mass_properties, mesh
from cycloid_mj.parts.contour import circle_of
from cycloid_mj.parts.export import assembly_step, export, read_volume
from cycloid_mj.parts.export.rv_assembly import BEARING_FILL, place_rv_parts, rv_assembly_parts, rv_mass
from cycloid_mj.parts.export.rv_bill import rv_bill
from cycloid_mj.parts.export.rv_drawing import rv_part_drawings
from cycloid_mj.parts.rv import axial_layout, rv_parts
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.bending import AXIAL_GAP
from cycloid_mj.reducer.rv_main_bearings import main_bearing_ends, main_bearing_space

KEY = "cranks.main_bearings=angular_contact"
DESIGNS = {
    "rv80e": override(PRESETS["rv80e"], [KEY, "cranks.flange_thickness_mm=22"]),
    "rv64": override(PRESETS["rv64"], [KEY, "cranks.flange_thickness_mm=20"]),
}
WITH_STOP_RINGS = override(
    PRESETS["rv64"], [KEY, "cranks.taper_radius_mm=22", "cranks.post_radius_mm=7", "cranks.flange_thickness_mm=22.4"]
)
BEARINGS = {"rv80e": ("71826.E", 130.0, 165.0, 18.0), "rv64": ("71822.E", 110.0, 140.0, 16.0)}


def bearing_of(reducer: RvReducer) -> stock.StockBearing:
    assert reducer.main_bearing is not None
    return reducer.main_bearing


def radii(part: Part) -> list[tuple[float, float, float, float]]:
    """Return start, end, outer radius and radius of the central hole of each segment [mm]; 0 without one."""
    rows = []
    for segment in part.segments:
        outline, holes = circle_of(segment.outline), [circle_of(hole) for hole in segment.holes]
        assert outline is not None
        inner = max((hole.radius for hole in holes if hole and hole.centre == (0.0, 0.0)), default=0.0)
        rows.append((1e3 * segment.z0, 1e3 * segment.z1, 1e3 * outline.radius, 1e3 * inner))
    return rows


@pytest.mark.parametrize("name", ["rv80e", "rv64"])
def test_presets_have_no_main_bearings(name: str) -> None:
    reducer = RvReducer(PRESETS[name])
    assert (reducer.cranks.main_bearings, reducer.main_bearing) == ("none", None)
    assert reducer.flange_radius == reducer.flange_outer_radius == reducer.min_flange_radius
    assert names.OUTPUT_BEARING not in rv_assembly_parts(reducer)
    assert [len(part.segments) for part in rv_parts(reducer).values() if part.name in ("housing", "carrier_1")] == [
        1,
        1,
    ]


@pytest.mark.parametrize("name", DESIGNS)
def test_the_largest_bearing_between_flange_and_housing_is_chosen(name: str) -> None:
    reducer = RvReducer(DESIGNS[name])
    bearing, design = bearing_of(reducer), reducer.design
    sizes = bearing.designation, 1e3 * bearing.bore, 1e3 * bearing.outside, 1e3 * bearing.width
    assert sizes == pytest.approx(BEARINGS[name])
    assert bearing.bore >= 2.0 * reducer.min_flange_radius
    assert bearing.outside >= 2.0 * (design.ring.pin_circle_radius + design.ring.pin_radius), "beyond the sockets"
    assert bearing.outside <= 2.0 * design.housing.outer_radius - 0.1 * design.ring.pin_circle_radius
    bearings = stock.catalogued_angular_contact_bearings()
    space = main_bearing_space(reducer)
    for larger in bearings[bearings.index(bearing) + 1 :]:
        assert not (space.fits(larger) and space.retains_pins(larger))


def test_the_outer_ring_retains_the_ring_pins() -> None:
    reducer = RvReducer(DESIGNS["rv80e"])
    outer_ring, pin_circle, pin = bearing_of(reducer).shoulders[1], 77.5e-3, 4e-3
    assert outer_ring <= pin_circle + 0.5 * pin, "at least a fifth of the end face of a pin is covered"
    start, _ = main_bearing_ends(reducer, bearing_of(reducer))
    (segment,) = rv_parts(reducer)["pin"].segments
    assert (segment.z0, segment.z1) == pytest.approx((0.1e-3 - start, start - 0.1e-3))


def test_seats_and_shoulders_are_next_to_the_rings() -> None:
    """rv80e: discs and gap to 17 mm, bearings from there to 35 mm, flanges with their shoulders to 39 mm."""
    parts = rv_parts(RvReducer(DESIGNS["rv80e"]))
    ring, *seats = parts["housing"].segments
    assert (ring.z0, ring.z1) == pytest.approx((-17e-3, 17e-3))
    housing = radii(parts["housing"].of(seats))
    np.testing.assert_allclose(housing, [(-35.0, -17.0, 95.0, 82.5), (17.0, 35.0, 95.0, 82.5)], rtol=1e-12)
    shoulder = 65.0 + 0.3 * 17.5
    near, far = (radii(parts[flange])[:2] for flange in ("carrier_1", "carrier_2"))
    np.testing.assert_allclose(near, [(-35.0, -17.0, 65.0, 18.0), (-39.0, -35.0, shoulder, 18.0)], rtol=1e-12)
    np.testing.assert_allclose(far, [(17.0, 35.0, 65.0, 18.0), (35.0, 39.0, shoulder, 18.0)], rtol=1e-12)


@pytest.mark.parametrize("name", DESIGNS)
def test_turning_parts_stay_apart(name: str) -> None:
    """Discs orbit within the inner face of the bearings, and the flange's shoulder is inside of the outer ring."""
    reducer = RvReducer(DESIGNS[name])
    bearing, gear = bearing_of(reducer), reducer.design.gear
    start, end = main_bearing_ends(reducer, bearing)
    assert start - 0.5 * gear.stack_width == pytest.approx(AXIAL_GAP)
    assert reducer.flange_outer_radius < bearing.shoulders[1]
    assert axial_layout(reducer).flanges[1][1] >= end + reducer.flange_wall - 1e-9
    assert axial_layout(reducer).planets[1] < -end


def test_stop_rings_retain_the_pins_next_to_larger_bearings() -> None:
    """71824.E: 120 x 150 x 16; its outer ring begins at 70.5 mm, but a fifth of the pins' ends is within 65.5 mm."""
    reducer = RvReducer(WITH_STOP_RINGS)
    assert bearing_of(reducer).designation == "71824.E"
    assert all(item.passed for item in soundness(reducer))
    thickness, face = 0.05 * 64.0, 14.0
    np.testing.assert_allclose(radii(rv_parts(reducer)["stop_ring"]), [(-thickness / 2, thickness / 2, 75.0, 65.5)])
    places = {place.name: 1e3 * place.origin[2] for place in place_rv_parts(reducer)}
    middles = places["stop_ring_2"], places["output_bearing_2"]
    assert middles == pytest.approx((face + 0.5 * thickness, face + thickness + 8.0))
    assert places["stop_ring_1"] == -places["stop_ring_2"]
    (seat, shoulder) = radii(rv_parts(reducer)["carrier_2"])[:2]
    assert (seat[0], seat[1], shoulder[0]) == pytest.approx((face, face + thickness + 16.0, face + thickness + 16.0))
    lines = {line.item: line for line in rv_bill(reducer)}
    assert (lines["stop_ring"].count, lines["stop_ring"].made_or_bought) == (2, "made")
    assert "stop_ring" in [drawing.name for drawing in rv_part_drawings(reducer)]
    thin = RvReducer(WITH_STOP_RINGS.but(cranks={"flange_thickness": 22.3e-3}))
    (check,) = (item for item in soundness(thin) if not item.passed)
    assert (check.name, "passes a stop ring" in check.why) == ("main_bearing_width", True)


def test_every_part_is_closed_and_placed() -> None:
    reducer = RvReducer(DESIGNS["rv80e"])
    parts, placements = rv_assembly_parts(reducer), [*place_rv_parts(reducer, 0.4)]
    for part in parts.values():
        mesh(part.solid(5e-6))  # checks that the surface is closed and has the volume of the solid
    bearings = [place for place in placements if place.part == names.OUTPUT_BEARING]
    assert [place.origin[2] for place in bearings] == pytest.approx([-26e-3, 26e-3])
    assert {place.part for place in placements} == parts.keys()


def test_a_thin_flange_is_a_failed_check_with_its_remedy() -> None:
    design = override(PRESETS["rv80e"], [KEY])
    (check,) = (item for item in soundness(RvReducer(design)) if not item.passed)
    assert (check.name, check.key) == ("main_bearing_width", "cranks.flange_thickness_mm")
    assert "raise cranks.flange_thickness_mm to 21.88" in check.remedy
    with pytest.raises(DesignError, match=r"flange_thickness_mm = 18 is too small for the main bearing 71826\.E"):
        rv_parts(RvReducer(design))
    assert all(item.passed for item in soundness(RvReducer(override(design, dict(check.changes[0])))))


def test_missing_bearings_are_a_failed_check() -> None:
    remedy = "set housing.outer_radius_mm to at least 73.2"
    design = override(DESIGNS["rv64"], ["housing.outer_radius_mm=72"])
    (check,) = (item for item in soundness(RvReducer(design)) if not item.passed)
    assert (check.name, check.remedy.partition(", or")[0]) == ("main_bearings", remedy)
    with pytest.raises(DesignError, match=r"no stock bearing fits cranks\.main_bearings"):
        rv_parts(RvReducer(design))
    for change in check.changes:
        assert RvReducer(override(design, dict(change))).main_bearing is not None


def test_sleeved_pins_are_refused() -> None:
    design = DESIGNS["rv80e"].but(ring={"pins": "sleeved"})
    assert [item.name for item in soundness(RvReducer(design)) if not item.passed] == ["main_bearings_and_sleeves"]
    with pytest.raises(DesignError, match="no space for main bearings"):
        rv_parts(RvReducer(design))


def test_the_key_of_central_drives_names_that_of_rv_reducers() -> None:
    with pytest.raises(DesignError, match=r"output.main_bearings.*set by cranks\.main_bearings"):
        override(PRESETS["rv80e"], ["output.main_bearings=angular_contact"])


def test_warm_parts_have_the_same_bearing() -> None:
    warm = RvReducer(override(DESIGNS["rv64"], {"thermal.disc_c": 60.0, "thermal.ring_c": 40.0}))
    assert warm.main_bearing == RvReducer(DESIGNS["rv64"]).main_bearing


@pytest.mark.parametrize("name", DESIGNS)
def test_the_bill_has_the_parts_of_the_assembly(name: str) -> None:
    reducer = RvReducer(DESIGNS[name])
    lines, bearing = {line.item: line for line in rv_bill(reducer)}, bearing_of(reducer)
    assert sum(line.mass_kg for line in lines.values()) == pytest.approx(rv_mass(reducer))
    places = [place.part for place in place_rv_parts(reducer)]
    assert {item: line.count for item, line in lines.items()} == {part: places.count(part) for part in places}
    line = lines[names.OUTPUT_BEARING]
    assert (line.designation, line.fit[:29]) == (bearing.designation, "H6 outside, k5 on the flanges")
    ring = math.pi * (bearing.outside**2 - bearing.bore**2) / 4.0 * bearing.width
    assert line.mass_kg == pytest.approx(2.0 * BEARING_FILL * ring * PRESETS[name].material.density, rel=1e-4)


def test_drawings_have_the_fits_of_the_bearings() -> None:
    drawings = {drawing.name: drawing for drawing in rv_part_drawings(RvReducer(DESIGNS["rv80e"]))}
    for part, text in (("housing", "⌀165 H6"), ("carrier_1", "⌀130 k5"), ("carrier_2", "⌀130 k5")):
        assert any(item.text.startswith(text) for item in drawings[part].diameters), part


def test_outlines_are_exported_with_the_clearances_of_the_ring() -> None:
    made = export(DESIGNS["rv80e"], "dxf")
    assert {clearance.pair: clearance.most for clearance in made.clearances} == pytest.approx(
        {"pin_gear": 1e-7, "pin_socket": 1e-7}, abs=2e-8
    )


@pytest.mark.slow
@pytest.mark.parametrize("design", [DESIGNS["rv80e"], WITH_STOP_RINGS], ids=["rv80e", "stop rings"])
def test_the_assembly_has_the_volume_of_its_parts(design: Design) -> None:
    reducer = RvReducer(design)
    volumes = {name: mass_properties(part.solid(1e-6)).volume for name, part in rv_assembly_parts(reducer).items()}
    total = sum(volumes[place.part] for place in place_rv_parts(reducer))
    assert read_volume(assembly_step(reducer)) == pytest.approx(total, rel=1e-3)


@pytest.mark.slow
def test_the_command_writes_assembly_bill_and_drawings(tmp_path: Path) -> None:
    words = ["export", "rv80e", "--format", "step", "--assembly", "--drawings", "--quiet"]
    changes = ["--set", KEY, "--set", "cranks.flange_thickness_mm=22"]
    assert main([*words, *changes, "--out", str(tmp_path / "parts")]) == 0
    files = {path.name for path in (tmp_path / "parts").iterdir()}
    assert files >= {"assembly.step", "bom.csv", "drawings.pdf", "housing.step", "carrier_1-drawing.dxf"}
    assert "71826.E" in (tmp_path / "parts" / "bom.csv").read_text()
