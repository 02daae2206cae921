"""A plate of parts for a printer, read back as its STL, and the bill of materials beside it."""

import csv
import io
import json
import re
import zipfile
from collections import Counter
from dataclasses import replace
from itertools import combinations, pairwise
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from designs import unlike

from cycloid_mj.base.errors import DesignError
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.geometry.modification import gear_profile
from cycloid_mj.parts import (
    Prism,
    Solid,
    circle,
    mass_properties,
    mesh,
    output_centres,
    parts,
    sleeve_core_radius,
)
from cycloid_mj.parts.export import (
    PrintPlate,
    bill,
    bill_csv,
    export,
    plate,
    read_stl,
    stl_bytes,
    threemf_bytes,
    widen_clearances,
)
from cycloid_mj.parts.export.casing import (
    casing,
)
from cycloid_mj.parts.export.casing_rules import (
    RULES,
)
from cycloid_mj.parts.export.clearance import flank_distance
from cycloid_mj.parts.export.plate import GAP, pack_rows
from cycloid_mj.parts.export.printable import COUPON, coupon_solids, print_warnings, thinnest_wall
from cycloid_mj.parts.export.printing import manufactured_parts, printed_parts
from cycloid_mj.parts.export.supports import SUPPORTS, build_support, find_overhangs
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import phases
from cycloid_mj.sizing.requirement import Requirement
from cycloid_mj.sizing.search import first_drive

CHORD_ERROR = 2e-5
OFFSET = 8e-5
SINGLE = 1e-7
"""Rounding of an STL's coordinates up to 1 m, in single precision [m]."""

SEVERAL = ["gear.disc_gap_mm=1.5", "output.support=both_ends", "shaft.mounting=straddle"]
PLASTIC = ["material.name=PLA", "output.rollers=false", "gear.bearing=plain", "housing.support=rim"]
DESIGNS = {
    "pin": PRESETS["pin"],
    "nonpin": PRESETS["nonpin"],
    "printed": PRESETS["printed"],
    "sleeved": override(PRESETS["pin"], ["ring.pins=sleeved"]),
    "plastic": override(PRESETS["pin"], ["ring.pins=sleeved", *PLASTIC]),
    "plastic_three": override(PRESETS["nonpin"], ["gear.discs=3", *SEVERAL, *PLASTIC]),
    **{f"{discs}_discs": override(PRESETS["nonpin"], [f"gear.discs={discs}", *SEVERAL]) for discs in (2, 3, 4)},
    "large": unlike("large"),
}
ON_PLATE = {
    "pin": {"housing": 1, "gear": 1, "shaft": 1, "output": 1},
    "nonpin": {"housing": 1, "gear": 1, "shaft": 1, "output": 1},
    "printed": {"housing": 1, "gear": 1, "output": 1, "output_2": 1},
    "sleeved": {"housing": 1, "gear": 1, "shaft": 1, "output": 1},
    "plastic": {"housing": 1, "gear": 1, "shaft": 1, "output": 1, "pin": 36, "pressed_pin": 36},
    "plastic_three": {
        **{"housing": 1, "gear_1": 1, "gear_2": 1, "gear_3": 1, "cam_1": 1, "cam_2": 1, "cam_3": 1, "spacer": 2},
        **{"shaft": 1, "output": 1, "output_2": 1, "output_pin": 8},
    },
    "3_discs": {
        **{"housing": 1, "gear_1": 1, "gear_2": 1, "gear_3": 1, "cam_1": 1, "cam_2": 1, "cam_3": 1, "spacer": 2},
        **{"output": 1, "output_2": 1},
    },
}
BOUGHT = {
    "pin": {"pin": 36, "output_pin": 8, "output_roller": 8, "cam_bearing": 1, "shaft_bearing": 2, "bolt": 6},
    "nonpin": {"output_pin": 8, "output_roller": 8, "cam_bearing": 1, "shaft_bearing": 2, "bolt": 6},
    "sleeved": {
        **{"pin": 36, "pressed_pin": 36, "output_pin": 8, "output_roller": 8, "cam_bearing": 1},
        **{"shaft_bearing": 2, "bolt": 6},
    },
    "plastic": {"shaft_bearing": 2},
    "plastic_three": {"shaft_bearing": 2},
    "3_discs": {
        **{"output_pin": 8, "shaft": 1, "output_roller": 24, "cam_bearing": 3},
        **{"shaft_bearing": 2, "bolt": 6},
    },
}


@pytest.fixture(scope="module", params=DESIGNS)
def laid(request: pytest.FixtureRequest) -> tuple[str, Design, PrintPlate, np.ndarray]:
    """Return a design by its name, its plate with the offset, and the triangles of the plate's STL [m]."""
    design = DESIGNS[request.param]
    found = plate(widen_clearances(Reducer(design), OFFSET), CHORD_ERROR)
    return request.param, design, found, 1e-3 * read_stl(stl_bytes(found.mesh, 1e3))


def test_every_part_lies_flat_in_its_own_box(laid: tuple[str, Design, PrintPlate, np.ndarray]) -> None:
    """Boxes are apart; each triangle is in one; each box has its part's volume, closed, and stands on z = 0."""
    _, design, found, triangles = laid
    solids = {
        name: part.solid for name, part in printed_parts(widen_clearances(Reducer(design), OFFSET), CHORD_ERROR).items()
    }
    for one, other in combinations(found.places, 2):
        apart = np.maximum(np.subtract(one.low, other.high), np.subtract(other.low, one.high))[:2].max()
        assert apart > GAP - 1e-12
    inside = np.zeros(len(triangles), int)
    for place in found.places:
        low, high = np.subtract(place.low, SINGLE), np.add(place.high, SINGLE)
        own = ((triangles > low) & (triangles < high)).all(axis=(1, 2))
        inside += own
        shape = trimesh.Trimesh(triangles[own].reshape(-1, 3), np.arange(3 * own.sum()).reshape(-1, 3))
        assert shape.is_watertight
        assert shape.body_count == 1
        assert shape.volume == pytest.approx(mass_properties(solids[place.part]).volume, rel=1e-5)
        assert triangles[own][..., 2].min() == 0.0
    assert (inside == 1).all()


def test_the_plate_has_what_is_made_and_the_bill_all_of_it(laid: tuple[str, Design, PrintPlate, np.ndarray]) -> None:
    name, design, found, _ = laid
    items = bill(Reducer(design))
    if name in ON_PLATE:
        assert found.counts == ON_PLATE[name]
    if name in BOUGHT:
        assert {item.item: item.count for item in items if item.made_or_bought == "bought"} == BOUGHT[name]
    listed = {item.item: item.count for item in items}
    assert {part: count for part, count in listed.items() if part in found.counts} == found.counts
    assert len({item.item for item in items}) == len(items)


def test_the_offset_is_in_the_outlines(laid: tuple[str, Design, PrintPlate, np.ndarray]) -> None:
    """The gears on the plate, about their own origin: flanks, bore and holes stand back by clearance and offset."""
    _, design, found, triangles = laid
    gears = [place for place in found.places if place.part.startswith("gear")]
    assert len(gears) == design.gear.discs
    asked, output = design.clearance, design.output
    for place, phase in zip(gears, phases(design), strict=True):
        assert not place.turned_over
        own = ((triangles > np.subtract(place.low, SINGLE)) & (triangles < np.add(place.high, SINGLE))).all(axis=(1, 2))
        points = triangles[own].reshape(-1, 3)[:, :2] - place.origin
        radius = np.linalg.norm(points, axis=1)
        to_hole = np.min(
            [np.linalg.norm(points - centre, axis=1) for centre in output_centres(Reducer(design))], axis=0
        )
        reach = output.hole_radius + asked.output + 2.0 * OFFSET
        bore, hole = radius < design.gear.bore_radius + asked.cam + 2.0 * OFFSET, to_hole < reach
        np.testing.assert_allclose(radius[bore], design.gear.bore_radius + asked.cam + OFFSET, rtol=0.0, atol=SINGLE)
        np.testing.assert_allclose(to_hole[hole], output.hole_radius + asked.output + OFFSET, rtol=0.0, atol=SINGLE)
        cos, sin = np.cos(phase / design.lobes), np.sin(phase / design.lobes)
        flank = points[~bore & ~hole] @ np.array([[cos, sin], [-sin, cos]])
        depth = flank_distance(gear_profile(design), flank) - design.ring.pin_radius - design.modification.equidistant
        np.testing.assert_allclose(depth, getattr(asked, design.tooth_pair) + OFFSET, rtol=0.0, atol=SINGLE)


def test_sockets_and_sleeves_take_the_offset_and_pins_keep_their_size() -> None:
    free, sleeved = DESIGNS["pin"], DESIGNS["plastic"]
    pairs = {one.pair: one for one in export(free, "dxf", offset=OFFSET).clearances}
    assert set(pairs) == {"pin_gear", "pin_socket", "cam", "output"}
    for name, one in pairs.items():
        assert one.asked == getattr(free.clearance, name)
        assert (one.least, one.most) == pytest.approx((one.asked + OFFSET,) * 2, abs=2e-8)
    wide = widen_clearances(Reducer(sleeved), OFFSET)
    assert sleeve_core_radius(wide) == pytest.approx(sleeve_core_radius(Reducer(sleeved)), rel=1e-12)
    bores = [
        np.linalg.norm(parts(one, CHORD_ERROR)["pin"].prisms[0].holes[0], axis=1).mean()
        for one in (Reducer(sleeved), wide)
    ]
    assert bores[1] - bores[0] == pytest.approx(OFFSET, rel=1e-9)
    assert widen_clearances(Reducer(free), 0.0) == Reducer(free)


@pytest.mark.parametrize(("name", "offset"), [("pin", 1.1e-3), ("sleeved", 7.6e-4)])
def test_an_excessive_offset_is_refused(name: str, offset: float) -> None:
    with pytest.raises(DesignError, match=rf"offset of {1e6 * offset:g} um is too large"):
        widen_clearances(Reducer(DESIGNS[name]), offset)


def test_output_pins_that_are_bought_fill_their_bores_and_reach_through_the_discs() -> None:
    """Of the preset printed: 5 mm under rollers of 9 mm, through two discs of 8 mm, two gaps of 1 mm and the gear."""
    design = DESIGNS["printed"]
    lines = {item.item: item for item in bill(Reducer(design))}
    assert (
        lines["output_pin"].size == "diameter 5 x length 45 mm"
    )  # the shortest in stock that is 43 mm long, cut to that
    assert lines["output_pin"].designation == "ISO 8734 - 5 x 45 - A"
    assert lines["output_pin"].fit == "m6 in N7, cut to 43 mm"
    assert lines["output_roller"].size == "outside diameter 9 x bore 5 x length 25 mm"
    assert (lines["pin"].size, lines["pin"].material) == ("diameter 7 x length 70 mm", "bearing steel")
    assert lines["pin"].fit.endswith("cut to 25 mm")
    assert lines["shaft_bearing"].size == "outside diameter 24 x bore 12 x length 6 mm"
    assert lines["shaft_bearing"].designation == "61901"
    assert lines["shaft_bearing"].fit == "H7 outside, j5 on the crank; the one next to the motor sealed (RS1)"
    for name in ("output", "output_2"):
        bores = printed_parts(Reducer(design), CHORD_ERROR)[name].solid.prisms[0].holes[-design.output.pins :]
        for bore, centre in zip(bores, output_centres(Reducer(design)), strict=True):
            np.testing.assert_allclose(np.linalg.norm(bore - centre, axis=1), 2.5e-3, rtol=1e-9)


def test_parts_are_placed_on_their_larger_end_without_mirroring() -> None:
    """The shaft stands on its cam, whose eccentricity then points to -y; the plastic output stands pins up."""
    design = override(DESIGNS["plastic"], ["ring.pins=fixed"])
    found = plate(Reducer(design), CHORD_ERROR)
    places = {place.part: place for place in found.places}
    assert {part for part, place in places.items() if place.turned_over} == {"shaft", "output"}
    shaft, low = places["shaft"], found.mesh.vertices[:, 2] == 0.0
    x, y = found.mesh.vertices[:, 0], found.mesh.vertices[:, 1]
    cam = found.mesh.vertices[
        low & (x >= shaft.low[0]) & (x <= shaft.high[0]) & (y >= shaft.low[1]) & (y <= shaft.high[1])
    ]
    middle = (cam.max(axis=0) + cam.min(axis=0))[:2] / 2.0 - shaft.origin
    np.testing.assert_allclose(middle, [0.0, -design.gear.eccentricity], atol=CHORD_ERROR)


@pytest.mark.parametrize(("name", "seat"), [("pin", 1e-2), ("3_discs", 12e-3)])
def test_cams_are_as_thick_as_the_bore_of_their_bearing(name: str, seat: float) -> None:
    """About the same axis as before, each in its own direction; the bill tells the bore; nothing else changes."""
    design = DESIGNS[name]
    drawn, seated = printed_parts(Reducer(design), CHORD_ERROR), printed_parts(Reducer(design), CHORD_ERROR, seat)
    changed = [part for part in drawn if seated[part].solid is not drawn[part].solid and part not in ("housing",)]
    cams = ["shaft"] if design.gear.discs == 1 else ["cam_1", "cam_2", "cam_3"]
    assert set(changed) - {"output", "output_2"} == set(cams)
    for part, phase in zip(cams, phases(design), strict=True):
        pairs = zip(drawn[part].solid.prisms, seated[part].solid.prisms, strict=True)
        (outline,) = [new.outline for old, new in pairs if len(old.outline) != len(new.outline)]
        centre = design.gear.eccentricity * np.array([-np.sin(phase), np.cos(phase)])
        np.testing.assert_allclose(np.linalg.norm(outline - centre, axis=1), seat, rtol=1e-9)
    (bearing,) = [item for item in bill(Reducer(design), seat) if item.item == "cam_bearing"]
    assert f"outside diameter 30 x bore {2e3 * seat:g} x length" in bearing.size
    assert {part: one.count for part, one in seated.items()} == {part: one.count for part, one in drawn.items()}


def test_a_cam_that_is_flush_with_the_shaft_is_one_body_with_it() -> None:
    design = DESIGNS["printed"]
    (bearing,) = [item for item in bill(Reducer(design)) if item.item == "cam_bearing"]
    seat = design.gear.eccentricity + design.shaft.radius
    assert f"bore {2e3 * seat:g} x" in bearing.size
    shaft = mesh(manufactured_parts(Reducer(design), CHORD_ERROR, seat)["shaft"].solid)
    assert trimesh.Trimesh(shaft.vertices, shaft.faces, process=False).body_count == 1
    cam = shaft.vertices[shaft.vertices[:, 2] >= -0.5 * design.gear.face_width] - [0.0, design.gear.eccentricity, 0.0]
    largest = np.linalg.norm(cam[:, :2], axis=1).max()
    assert largest == pytest.approx(seat, abs=1e-8), "not widened to enclose the journal, as the STEP file is not"


def test_a_bore_that_does_not_fit_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    for name, seat in (("pin", 15e-3), ("pin", 1e-3), ("printed", 7e-3), ("3_discs", 9e-3)):
        with pytest.raises(DesignError, match=rf"--cam-bearing-bore-mm is {2e3 * seat:g}, which does not fit"):
            printed_parts(Reducer(DESIGNS[name]), CHORD_ERROR, seat)
    with pytest.raises(DesignError, match="needs a cam with a rolling bearing"):
        printed_parts(Reducer(DESIGNS["plastic"]), CHORD_ERROR, 10e-3)
    arguments = ["export", "--design", "pin", "--cam-bearing-bore-mm", "20", "--out", str(tmp_path / "no")]
    assert main(arguments) == 2
    assert "add --plate" in capsys.readouterr().err
    assert not (tmp_path / "no").exists()


def test_shelves_keep_rectangles_apart_and_the_plate_about_square() -> None:
    sizes = [(3.0, 2.0), (1.0, 4.0), (2.0, 2.0), (6.0, 1.0), (1.0, 1.0), (2.0, 3.0)] * 4
    corners = pack_rows(sizes, 0.5)
    for (a, b), (c, d) in combinations(zip(corners, sizes, strict=True), 2):
        gaps = [max(a[k] - c[k] - d[k], c[k] - a[k] - b[k]) for k in (0, 1)]
        assert max(gaps) >= 0.5
    width, depth = (max(corner[k] + size[k] for corner, size in zip(corners, sizes, strict=True)) for k in (0, 1))
    assert 0.5 < width / depth < 2.0
    assert all(corner == (0.0, 0.0) for corner in pack_rows([(7.0, 1.0)], 0.5))


def test_the_command_writes_plate_and_bill(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "print"
    arguments = ["export", "--design", "pin", "--plate", "--offset-um", "80", "--chord-error-um", "20"]
    assert main([*arguments, "--out", str(out), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["offset"] == pytest.approx(OFFSET)
    assert told["plate"]["file"] == str(out / "plate.stl")
    assert told["plate"]["parts"] == ON_PLATE["pin"] | {
        "motor_cover": 1,
        "output_cover": 1,
        "output_flange": 1,
        "bearing_spacer_1": 1,
        "bearing_spacer_2": 1,
    }
    extent = read_stl((out / "plate.stl").read_bytes()).reshape(-1, 3).max(axis=0)
    assert told["plate"]["size"] == pytest.approx(1e-3 * extent, abs=SINGLE)
    for one in told["clearances"]:
        assert one["least"] == pytest.approx(one["asked"] + told["offset"], abs=2e-8)
    rows = list(csv.DictReader(io.StringIO((out / "bom.csv").read_text())))
    read = [{**row, "count": int(row["count"]), "mass_kg": float(row["mass_kg"])} for row in rows]
    assert read == told["bom"]
    assert Counter(row["made_or_bought"] for row in rows) == {"made": 9, "bought": 9, "consumable": 4}
    assert {str(path) for path in out.iterdir()} == set(told["files"])
    assert main([*arguments, "--out", str(out), "--force", "--all"]) == 0
    shown = capsys.readouterr().out
    for words in (
        "requested",
        "offset",
        "80.0000",
        "bill of materials",
        "diameter 4.5 x length 70 mm",
        "made or bought",
    ):
        assert words in shown


def test_the_command_without_a_plate_writes_only_parts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["export", "--design", "nonpin", "--chord-error-um", "20", "--out", str(tmp_path)]
    assert main([*arguments, "--json"]) == 0
    assert "bom" not in json.loads(capsys.readouterr().out)
    assert {path.name for path in tmp_path.iterdir()} == {"housing.stl", "shaft.stl", "gear.stl", "output.stl"}
    assert main([*arguments, "--offset-um", "-1"]) == 2
    assert main([*arguments, "--offset-um", "1000"]) == 1
    assert "offset of 1000 um is too large" in capsys.readouterr().err


def test_a_bill_is_csv_of_its_lines() -> None:
    items = bill(Reducer(DESIGNS["sleeved"]))
    rows = list(csv.reader(io.StringIO(bill_csv(items).decode())))
    assert rows[0] == ["item", "count", "size", "material", "made_or_bought", "designation", "fit", "mass_kg"]
    assert len(rows) == 1 + len(items)
    assert all(len(one) == len(other) for one, other in pairwise(rows))


def test_a_plate_as_3mf_has_each_part_by_its_name() -> None:
    found = plate(Reducer(DESIGNS["plastic"]), CHORD_ERROR)
    content = threemf_bytes(found)
    assert content == threemf_bytes(found)
    with zipfile.ZipFile(io.BytesIO(content)) as package:
        assert package.namelist() == ["[Content_Types].xml", "_rels/.rels", "3D/3dmodel.model"]
        model = ElementTree.fromstring(package.read("3D/3dmodel.model"))
    space = {"m": "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"}
    assert model.attrib["unit"] == "millimeter"
    objects = model.findall("m:resources/m:object", space)
    named = Counter(re.sub(r"_\d+$", "", one.attrib["name"]) for one in objects)
    assert named == ON_PLATE["plastic"]
    assert len({one.attrib["name"] for one in objects}) == len(objects)
    built = [one.attrib["objectid"] for one in model.findall("m:build/m:item", space)]
    assert built == [one.attrib["id"] for one in objects]
    for one, drawn in zip(objects, found.meshes, strict=True):
        corners = [[float(at.attrib[axis]) for axis in "xyz"] for at in one.findall(".//m:vertex", space)]
        faces = [[int(at.attrib[axis]) for axis in ("v1", "v2", "v3")] for at in one.findall(".//m:triangle", space)]
        np.testing.assert_allclose(corners, 1e3 * drawn.vertices, rtol=1e-6, atol=1e-9)
        np.testing.assert_array_equal(faces, drawn.faces)


def test_the_coupon_is_a_pin_and_a_block_with_three_sockets_by_their_clearances() -> None:
    drawn = coupon_solids(CHORD_ERROR)
    (block,), (pin,) = (drawn[name].prisms for name in ("coupon_block", "coupon_pin"))
    radius = 0.5 * np.ptp(pin.outline, axis=0).min()
    sockets = [hole for hole in block.holes if np.ptp(hole, axis=0).min() > radius]
    rooms = [0.5 * np.ptp(hole, axis=0).min() - radius for hole in sockets]
    np.testing.assert_allclose(rooms, COUPON.clearances, atol=2.0 * CHORD_ERROR)
    assert len(block.holes) == len(sockets) + 1 + 2 + 3
    for solid in drawn.values():
        shape = mesh(solid)
        assert trimesh.Trimesh(shape.vertices, shape.faces, process=False).body_count == 1
    assert thinnest_wall(block) > RULES.min_printed_wall


def test_thin_walls_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    disc = Prism(circle(10e-3, CHORD_ERROR), (circle(9.5e-3, CHORD_ERROR),), 0.0, 5e-3)
    assert thinnest_wall(disc) == pytest.approx(0.5e-3, abs=2.0 * CHORD_ERROR)
    reducer = Reducer(made_by_printing(Requirement(15, 0.075, 1.0, process="printed")))
    sizes = casing(reducer)
    laid = plate(reducer, CHORD_ERROR, 0.0, sizes)
    assert not any("wall of" in text for text in print_warnings(reducer, laid.hanging, CHORD_ERROR, sizes))
    monkeypatch.setattr("cycloid_mj.parts.export.printable.RULES", replace(RULES, min_printed_wall=2e-3))
    assert any(
        "output_cover has a wall of" in text for text in print_warnings(reducer, laid.hanging, CHORD_ERROR, sizes)
    )
    assert not list(print_warnings(Reducer(DESIGNS["pin"]), {}, CHORD_ERROR, None))


def cup(hole: float) -> Solid:
    """Draw a cup of 10 mm radius upside down, its lid with a hole of a radius [m]; 0: none."""
    wall = Prism(circle(10e-3, CHORD_ERROR), (circle(9.5e-3, CHORD_ERROR),), 0.0, 5e-3)
    lid = Prism(circle(10e-3, CHORD_ERROR), (circle(hole, CHORD_ERROR),) if hole else (), 5e-3, 6e-3)
    return Solid("cup", (wall, lid), 1.0)


def test_a_face_in_mid_air_is_supported_a_layer_below() -> None:
    (face,) = find_overhangs(mesh(cup(5e-3)))
    assert (face.z, len(face.holes)) == (5e-3, 1)
    assert face.area == pytest.approx(np.pi * (9.5e-3**2 - 5e-3**2), rel=1e-2)
    below = build_support(cup(5e-3), face, CHORD_ERROR)
    assert below is not None
    radii = np.hypot(below.vertices[:, 0], below.vertices[:, 1])
    assert (radii.min(), radii.max()) == pytest.approx(
        (5e-3 + SUPPORTS.gap_aside, 9.5e-3 - SUPPORTS.gap_aside), abs=1e-6
    )
    assert (below.vertices[:, 2].min(), below.vertices[:, 2].max()) == pytest.approx((0.0, 5e-3 - SUPPORTS.gap_below))
    assert not list(find_overhangs(mesh(cup(9.5e-3 - 0.9 * SUPPORTS.max_ledge))))


def test_a_face_on_uneven_ground_has_no_support() -> None:
    step = Prism(np.array([[1e-3, -1e-3], [3e-3, -1e-3], [3e-3, 1e-3], [1e-3, 1e-3]]), (), 0.0, 1e-3)
    uneven = Solid("cup", (*cup(0.0).prisms, step), 1.0)
    (face,) = find_overhangs(mesh(uneven))
    assert build_support(cup(0.0), face, CHORD_ERROR) is not None
    corners = Prism(np.array([[-9e-3, 0.0], [0.0, -9e-3], [9.4e-3, 0.0], [0.0, 9.4e-3]]), (), 0.0, 1e-3)
    assert build_support(Solid("cup", (*cup(0.0).prisms, corners), 1.0), face, CHORD_ERROR) is None


PRINTED = PRESETS["printed"]


def made_by_printing(asked: Requirement) -> Design:
    reducer = first_drive(asked)
    assert reducer is not None
    return reducer.design


@pytest.mark.parametrize(
    "design",
    [
        PRINTED,
        made_by_printing(Requirement(15, 0.075, 1.0, process="printed")),
        made_by_printing(Requirement(24, 0.15, 3.0, process="printed", discs=2)),
    ],
    ids=["preset", "small", "of_two"],
)
def test_no_part_of_a_printed_drive_is_unsupported(design: Design) -> None:
    """Each point of a face that looks down has a support a layer below it, or is near walls that it is bridged from."""
    reducer = Reducer(design)
    laid = plate(reducer, CHORD_ERROR, 0.0, casing(reducer))
    assert not laid.hanging
    assert sum(map(len, laid.supports)) > 2
    for shape, place, supports in zip(laid.meshes, laid.places, laid.supports, strict=True):
        body = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
        assert body.is_watertight
        assert body.body_count == 1
        corners = shape.vertices[shape.faces]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        size = np.linalg.norm(normal, axis=1)
        steep = (normal[:, 2] < -np.cos(np.radians(45.0)) * size) & (size > 1e-12)
        walls = shape.vertices[:, :2]
        for one in corners[steep & (corners[..., 2].max(axis=1) > 0.0)]:
            for point in (one.mean(axis=0), *(0.6 * one + 0.4 * one.mean(axis=0))):
                tops = [
                    below.vertices[below.vertices[:, 2] > point[2] - 1.01 * SUPPORTS.gap_below] for below in supports
                ]
                held = any(
                    len(top) and np.ptp(np.append(top[:, 2], point[2])) < 1.01 * SUPPORTS.gap_below for top in tops
                )
                bridged = np.linalg.norm(walls - point[:2], axis=1).min() <= 0.5 * SUPPORTS.max_bridge
                assert held or bridged, f"{place.part} at {1e3 * point} mm"
        for below in supports:
            assert trimesh.Trimesh(below.vertices, below.faces, process=False).is_watertight
            assert (below.vertices >= np.subtract(place.low, SINGLE)).all()
            assert (below.vertices <= np.add(place.high, SINGLE)).all()
