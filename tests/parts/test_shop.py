"""What a shop gets: outlines by height, arcs, plates of a bed's size, materials, torques and consumables."""

import io
import json
import re
import zipfile
from pathlib import Path

import ezdxf
import numpy as np
import pytest
from designs import CENTRAL, cases, design_file

from cycloid_mj.base.errors import DesignError
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, load, resolve
from cycloid_mj.design.fits import limits
from cycloid_mj.parts import mesh, part_sections
from cycloid_mj.parts.biarcs import arcs_of
from cycloid_mj.parts.curve import Arc, Spline
from cycloid_mj.parts.export import bill, casing, dxf_bytes, plates
from cycloid_mj.parts.export import drive_files as files_of
from cycloid_mj.parts.export.assembly import assembly_parts, place_parts
from cycloid_mj.parts.export.bill import consumables, out_of_stock
from cycloid_mj.parts.export.drawing import part_drawings
from cycloid_mj.parts.export.drive import drive_mass
from cycloid_mj.parts.export.joints import drive_joints
from cycloid_mj.parts.export.order import assembly_order
from cycloid_mj.parts.export.printing import manufactured_parts
from cycloid_mj.parts.export.rules import describe_violations
from cycloid_mj.parts.export.triangles import read_stl, stl_bytes
from cycloid_mj.reducer import Reducer

PRINTED, PIN = Reducer(PRESETS["printed"]), Reducer(PRESETS["pin"])


def entities(content: bytes):
    return ezdxf.read(io.StringIO(content.decode())).modelspace()


def test_a_stepped_part_is_drawn_by_height_without_repeats():
    drawing = files_of(PRINTED, "dxf", casing(PRINTED), 1e-5)["motor_cover.dxf"]
    circles = [(one.dxf.layer, one.dxf.center.x, one.dxf.center.y, one.dxf.radius) for one in entities(drawing)]
    assert len(circles) == len(set(circles)) > 5
    for layer, *_ in circles:
        low, high = map(float, re.fullmatch(r"(?:M4 )?z (-?[\d.]+) to (-?[\d.]+)", layer).groups())
        assert low < high
    same = [(x, y, round(radius, 6)) for _, x, y, radius in circles]
    assert len(same) == len(set(same))  # each hole once, from end to end
    threads = [one for one in circles if one[0].startswith("M4")]
    assert len(threads) == 8 + 4
    assert {radius for *_, radius in threads} == {2.8}  # holes of the inserts


def test_threads_in_steel_are_drawn_by_their_core():
    drawing = files_of(PIN, "dxf", casing(PIN), 1e-5)["output.dxf"]
    threads = [one for one in entities(drawing) if one.dxf.layer.startswith("M4 z ")]
    assert len(threads) == casing(PIN).flange_screws
    assert {round(one.dxf.radius, 6) for one in threads} == {1.65}


@pytest.mark.parametrize("tolerance", [1e-6, 1e-5])
def test_arcs_follow_the_teeth_within_their_tolerance(tolerance):
    (section,) = part_sections(PIN)["gear"]
    splines = [curve for curve in section.loops[0] if isinstance(curve, Spline)]
    arcs = arcs_of(splines[0], tolerance)
    ends = np.array([[arc_end(arc, angle) for angle in (arc.start, arc.end)] for arc in arcs if isinstance(arc, Arc)])
    assert len(ends) == len(arcs) < 50
    points = splines[0].points(400)
    apart = [np.abs(np.linalg.norm(points - np.array(arc.centre), axis=1) - arc.radius) for arc in arcs]
    assert np.min(apart, axis=0).max() <= tolerance
    corners = np.round(ends.reshape(-1, 2), 12)
    assert len(np.unique(corners, axis=0)) == len(arcs) + 1  # consecutive
    kinds = {one.dxftype() for one in entities(dxf_bytes((section,), arcs=tolerance))}
    assert kinds == {"ARC", "CIRCLE"}


def arc_end(arc: Arc, angle: float):
    return arc.centre[0] + arc.radius * np.cos(angle), arc.centre[1] + arc.radius * np.sin(angle)


def test_plates_fit_the_bed():
    sizes = casing(PRINTED)
    laid = plates(PRINTED, 5e-5, 0.0, sizes, (0.22, 0.13))
    assert len(laid) > 1
    for one in laid:
        assert one.size[0] <= 0.22
        assert one.size[1] <= 0.13
    (single,) = plates(PRINTED, 5e-5, 0.0, sizes)
    assert sum(len(one.places) for one in laid) == len(single.places)
    with pytest.raises(
        DesignError, match=r"_cover measures 108\.4 x 108\.\d mm, but the bed measures only 100 x 100 mm"
    ):
        plates(PRINTED, 5e-5, 0.0, sizes, (0.1, 0.1))


def test_covers_of_steel_drives_are_of_aluminium():
    sizes = casing(PIN)
    assert sizes.cover_material == "aluminium 6061"
    assert assembly_parts(PIN, sizes)["motor_cover"].density == pytest.approx(2700.0)
    steel = casing(PIN, "auto", "tempered steel")
    assert assembly_parts(PIN, steel)["motor_cover"].density == pytest.approx(7850.0)
    assert casing(PRINTED).cover_material == ""
    for reducer, name in ((PIN, "PLA"), (PRINTED, "aluminium 6061"), (PIN, "wood")):
        with pytest.raises(DesignError, match="covers of"):
            casing(reducer, "auto", name)


def test_the_bill_states_exact_sizes_threads_and_what_is_out_of_stock():
    sizes = casing(PRINTED)
    lines = {line.item: line for line in bill(PRINTED, 0.0, sizes)}
    assert lines["housing"].size == "90 x 90 x 25.4 mm"
    assert "4 x M4, 8.1 mm deep, insert M4 x 8.1" in lines["motor_cover"].fit
    steel = {line.item: line for line in bill(PIN, 0.0, casing(PIN))}
    assert "drilled 3.3 mm" in steel["output"].fit
    assert any(
        "shaft_bearing: no standard part has outside diameter 22.4 x bore 16" in text
        for text in out_of_stock(steel.values())
    )
    assert not list(out_of_stock(line for line in lines.values() if line.item != "output_roller"))


def test_the_bill_states_the_bore_of_a_bought_shaft():
    """The shaft of twodisc is a ground bar, bored for the motor shaft of a NEMA 34."""
    reducer = Reducer(PRESETS["twodisc"])
    radius, start, end = casing(reducer).motor_bore
    (shaft,) = [line for line in bill(reducer, 0.0, casing(reducer)) if line.item == "shaft"]
    assert shaft.made_or_bought == "bought"
    assert f"bored {2e3 * radius:g} x {1e3 * (end - start):g} mm" in shaft.size


def test_ring_pins_in_half_open_sockets_are_glued():
    """A press fit would push them out of sockets of 184 to 190 degrees."""
    reducer = Reducer(PRESETS["printed"])
    sizes = casing(reducer)
    (pin,) = [line for line in bill(reducer, 0.0, sizes) if line.item == "pin"]
    assert "glued: its socket is open" in pin.fit
    assert "m6" not in pin.fit
    assert "glue the pins into their sockets" in " ".join(assembly_order(reducer, sizes))


@pytest.mark.parametrize("name", cases(("printed", "pin", "twodisc"), "printed"))
def test_no_triangle_of_an_stl_file_has_zero_area(name):
    """In the single precision of the file, as a program reads it: at least 1e-12 mm2."""
    reducer = Reducer(PRESETS[name])
    for part, made in manufactured_parts(reducer, 1e-6, 0.0, casing(reducer)).items():
        corners = read_stl(stl_bytes(mesh(made.solid), 1e3)).astype(float)
        first, second, third = corners.transpose(1, 0, 2)
        areas = 0.5 * np.linalg.norm(np.cross(second - first, third - first), axis=1)
        assert areas.min() > 1e-12, part


SLEEVED = "sleeved-n27-d1-carrier-3um"


@pytest.mark.parametrize("name", [*CENTRAL, SLEEVED])
def test_counts_of_the_bill_are_those_of_the_solids(name):
    reducer = Reducer(load(design_file(name)) if name == SLEEVED else PRESETS[name])
    sizes = casing(reducer)
    counts: dict[str, int] = {}
    for place in place_parts(reducer, 0.0, sizes):
        counts[place.part] = counts.get(place.part, 0) + 1
    assert {line.item: line.count for line in bill(reducer, 0.0, sizes)} == counts


def test_grease_and_adhesive_are_listed():
    grease, adhesive, _ = consumables(PRINTED, casing(PRINTED))
    volume = float(grease.size.removesuffix(" cm3"))
    inside = 1e6 * np.pi * PRINTED.design.ring_root_radius**2 * PRINTED.design.gear.face_width
    assert 0.02 * inside < volume < inside
    assert 1e3 * grease.mass_kg == pytest.approx(0.95 * volume, rel=0.05)
    assert "ring pins" in adhesive.fit
    assert 0.0 < float(adhesive.size.removesuffix(" cm3")) < 0.1 * volume


def test_adhesive_on_a_plastic_is_an_epoxy():
    """Anaerobic compounds do not cure on plastics: Onyx around the glued ring pins, steel around the motor shaft."""
    (line,) = [line for line in consumables(PRINTED, casing(PRINTED)) if line.item == "adhesive"]
    assert line.material == "retaining compound and two-part epoxy"
    assert "two-part epoxy: ring pins in their sockets" in line.fit
    assert "retaining compound: motor shaft in the crank" in line.fit
    assert "glue the pins into their sockets (two-part epoxy)" in " ".join(assembly_order(PRINTED, casing(PRINTED)))
    (steel,) = [line for line in consumables(PIN, casing(PIN)) if line.item == "adhesive"]
    assert steel.material == "retaining compound"


def test_screws_of_a_motor_without_threads_are_listed():
    """The cover has M4, 6 mm deep, for a NEMA 23 with holes of 5 mm; a NEMA 17 with threads has screws from within."""
    (screw,) = [line for line in consumables(PIN, casing(PIN)) if line.item == "motor_screw"]
    assert (screw.count, screw.designation) == (4, "ISO 4762 - M4")
    assert screw.size.startswith("4 off, 4 to 6 mm longer than the flange of the motor")
    tapped = Reducer(resolve(PRESETS["printed"], {"drive.torque_nm": 0.1}))
    sizes = casing(tapped, "nema17")
    assert sizes.motor.tapped
    assert "motor_screw" not in {line.item for line in consumables(tapped, sizes)}
    assert "motor_screw" in {line.item for line in bill(tapped, 0.0, sizes)}


def test_steps_state_when_a_motor_shaft_is_glued_and_what_centres_the_flange():
    """A tapped motor is bolted on before its cover, so the adhesive must be in the bore before the cover goes on."""
    reducer = Reducer(resolve(PRESETS["printed"], {"drive.torque_nm": 0.1}))
    steps = assembly_order(reducer, casing(reducer, "nema17"))
    assert "put retaining compound into the bore of the shaft" in steps[8]
    assert "dial gauge" in assembly_order(PIN, casing(PIN))[4]
    open_end = " ".join(assembly_order(PIN, casing(PIN, "circle")))
    assert "mm behind the face and has no bore: state --motor-shaft-mm" in open_end


def test_sealed_bearings_are_ordered_by_their_suffix():
    """Deep groove bearings of the output have seals, which keep the grease in; angular contact bearings have none."""
    (line,) = [line for line in bill(PIN, 0.0, casing(PIN)) if line.item == "output_bearing"]
    assert (line.designation, "sealed (2RS1)" in line.fit) == ("61812-2RS1", True)
    assert "61812-2RS1" in assembly_order(PIN, casing(PIN))[3]
    angular = Reducer(resolve(PRESETS["pin"], {"output.main_bearings": "angular_contact"}))
    (line,) = [line for line in bill(angular, 0.0, casing(angular)) if line.item == "output_bearing"]
    assert line.designation.endswith("ACD")


def test_steps_state_why_no_motor_fits_on_a_thin_crank():
    thin = {"shaft.radius_mm": 3.0, "drive.torque_nm": 0.2, "drive.speed_rpm": 300.0}
    reducer = Reducer(resolve(PRESETS["printed"], thin))
    sizes = casing(reducer)
    assert sizes.motor.name == "bolt circle"
    assert "(NEMA 17: it needs a crank with a diameter of at least" in assembly_order(reducer, sizes)[9]


def test_bought_dowels_have_the_material_of_their_standard():
    lines = bill(PIN, 0.0, casing(PIN))
    dowels = [line for line in lines if line.designation.startswith("ISO 8734")]
    assert dowels
    assert {line.material for line in dowels} == {"hardened steel"}


def test_sealant_closes_the_faces_of_a_metal_ring():
    """0.1 mm on both faces of the ring, 2 x pi (50^2 - 42.2^2) mm2 of the preset pin; none in a plastic."""
    lines = {line.item: line for line in consumables(PIN, casing(PIN))}
    wall, outer = PIN.design.ring_root_radius, PIN.design.housing.outer_radius
    assert 1e9 * 1e-4 * 2.0 * np.pi * (outer**2 - wall**2) == pytest.approx(
        1e3 * float(lines["sealant"].size.removesuffix(" cm3")), rel=0.05
    )
    assert "sealant" not in {line.item for line in consumables(PRINTED, casing(PRINTED))}


def test_rules_report_a_motor_that_turns_with_the_ring():
    assert list(describe_violations(PIN, casing(PIN))) == []
    turning = Reducer(PRESETS["pin"].but(output={"member": "ring"}))
    (text,) = describe_violations(turning, casing(turning))
    assert "turns 35 times for a turn of the output, not 36" in text


def test_the_command_writes_plates_materials_and_torques(tmp_path: Path, capsys, recwarn):
    out = tmp_path / "made"
    arguments = ["export", "--design", "printed", "--plate", "--bed", "220x130", "--chord-error-um", "50", "--json"]
    assert main([*arguments, "--out", str(out)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["plates"]) > 1
    assert told["plate"] == told["plates"][0]
    assert (out / "plate_2.3mf").exists()
    model = zipfile.ZipFile(out / "plate_1.3mf").read("3D/3dmodel.model").decode()
    assert '<base name="Onyx" displaycolor="#' in model
    objects = re.findall(r'<object [^>]*name="[a-z_]*_cover"[^>]*>', model)
    assert objects
    assert all("pindex=" in one for one in objects)
    screw = next(line for line in told["bom"] if line["item"] == "screw")
    assert re.fullmatch(r"tighten with [\d.]+ N m", screw["fit"])
    assert told["consumables"]
    assert [line["item"] for line in told["bom"] if line["made_or_bought"] == "consumable"] == [
        "grease",
        "adhesive",
        "motor_screw",
    ]


@pytest.mark.parametrize("bed", ["220", "0x200", "axb", "1x2x3", "infx2"])
def test_a_bed_without_a_valid_size_is_refused(bed, capsys, tmp_path):
    assert main(["export", "--design", "printed", "--plate", "--bed", bed, "--out", str(tmp_path / "no")]) == 2
    assert f"--bed {bed} is not a valid size" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["pin", "printed", "twodisc"])
def test_every_made_part_has_a_drawing(name):
    reducer = Reducer(PRESETS[name])
    sizes = casing(reducer)
    made = [line.item for line in bill(reducer, 0.0, sizes) if line.made_or_bought == "made"]
    drawings = part_drawings(reducer, sizes)
    assert {one.name for one in drawings} == set(made)
    for one in drawings:
        assert one.section
        assert one.front
        assert one.lengths
        assert any("chamfer" in note for note in one.notes)
        assert any("ISO 2768" in note for note in one.notes)


def test_a_drawing_states_zones_deviations_and_threads():
    drawings = {one.name: one for one in part_drawings(PIN, casing(PIN))}
    cover, hub = drawings["motor_cover"], drawings["output"]
    assert any(one.text.startswith("⌀22.4 H7 (+21/+0 µm)") for one in cover.diameters)
    assert any(one.text.startswith("⌀60 k6 (+21/+2 µm)") for one in hub.diameters)
    assert any(re.match(r"8 x ⌀3.3, 6 deep, M4 in it", note) for note in hub.notes)
    assert any("datum A" in note for note in cover.notes)
    assert any("Ra 0.8" in note for note in cover.notes)
    assert any("35 lobes, N = 36" in note for note in drawings["gear"].notes)
    assert "no heat treatment" in cover.title


@pytest.mark.parametrize("name", ["pin", "nonpin", "printed", "twodisc"])
def test_each_drawing_defines_its_datums_and_a_single_general_tolerance(name):
    reducer = Reducer(PRESETS[name])
    for drawing in part_drawings(reducer, casing(reducer)):
        text = "\n".join(drawing.notes)
        if " to A" in text:
            assert "datum A: axis of" in text, drawing.name
            assert "datum B:" in text, drawing.name
        assert ("ISO 2768-m" in text) != ("printed: general tolerance" in text), drawing.name


def test_all_sizes_that_parts_run_or_fit_on_have_a_tolerance():
    """Bores for motor shaft and pilot, rollers, output holes, sockets, widths, and pin holes of the second disc."""
    reducer = Reducer(resolve(PRESETS["pin"], {"output.support": "both_ends", "tolerance.eccentricity": "normal 0.5"}))
    sizes = casing(reducer)
    drawings = {drawing.name: drawing for drawing in part_drawings(reducer, sizes)}
    notes = {name: "\n".join(drawing.notes) for name, drawing in drawings.items()}
    diameters = {name: [item.text for item in drawing.diameters] for name, drawing in drawings.items()}
    assert any(text.startswith("⌀38.1 H8 (+39/+0 µm)") for text in diameters["motor_cover"])
    assert any(text.startswith("⌀6.35 H7 (+15/+0 µm)") for text in diameters["shaft"])
    assert diameters["gear"] == ["⌀30.002 H6 (+16/+0 µm)"], "the rollers of the cam run in it"
    assert diameters["bearing_spacer_1"][0].startswith("⌀22.4 f7 (-20/-41 µm)")
    assert diameters["bearing_spacer_2"][1].startswith("⌀16 F8 (+43/+16 µm)")
    assert any("± 0.0015" in text for text in diameters["shaft"]), "three standard deviations of the study"
    assert re.search(r"counterweight: half disc R[\d.]+", notes["shaft"])
    assert re.search(r"\d+ x ⌀[\d.]+ ± [\d.]+ on ⌀[\d.]+, position ⌀[\d.]+ to A", notes["gear"])
    assert re.search(r"36 sockets ⌀4.5020 on ⌀81.5, open to the bore ⌀", notes["housing"])
    for disc in ("output", "output_2"):
        assert re.search(r"\d+ x ⌀[\d.]+ N7 on ⌀[\d.]+, position ⌀0.01 to A", notes[disc])
    play = f"{0.5e3 * sizes.play:g}"
    assert f"0/-{play}; faces" in notes["gear"]
    assert f"+{play}/0; faces" in notes["housing"]


def test_a_ring_between_covers_is_centred_by_its_seat_or_by_dowels():
    """Without dowels it slides (H7/g6) until the disc centres it; else its play is larger than both tolerances."""
    changes = {"gear.eccentricity_mm": 0.8, "output.hole_radius_mm": 4.8, "ring.pin_radius_mm": 3.0}
    thin = Reducer(resolve(PRESETS["pin"], changes | {"housing.outer_radius_mm": 45.6, "housing.support": "rim"}))
    assert casing(thin).has_free_ring
    for reducer in (thin, *(Reducer(PRESETS[name]) for name in ("pin", "twodisc", "printed", "nonpin"))):
        sizes = casing(reducer)
        steps = assembly_order(reducer, sizes)
        assert ("lightly" in steps[8]) == ("centres the housing" in steps[9]) == sizes.has_free_ring
        assert sizes.has_free_ring or "crosswise" in steps[8]
        for joint in drive_joints(reducer, sizes):
            if joint.name == "ring in the motor cover" and joint.fit:
                ((_, radius, *_),) = joint.holes_in("motor_cover")
                play = 2.0 * radius - joint.diameter
                shaft, hole = joint.fit.split(" in ")
                loosest_shaft, tightest_hole = limits(shaft, joint.diameter)[1], limits(hole, joint.diameter)[0]
                assert play + tightest_hole - loosest_shaft >= 0.0
                assert (play > 0.0) == (bool(sizes.dowel) and not sizes.has_outer_dowels)


def test_a_plain_roller_is_drawn_with_its_fit():
    reducer = Reducer(resolve(PRESETS["pin"], {"output.roller_bearing": "plain", "output.core_radius_mm": 2.0}))
    drawings = {drawing.name: drawing for drawing in part_drawings(reducer, casing(reducer))}
    outside, bore = sorted((item.text for item in drawings["output_roller"].diameters), key=lambda text: "E8" in text)
    assert re.match(r"⌀[\d.]+ ± [\d.]+", outside)
    assert re.match(r"⌀[\d.]+ E8 \(\+\d+/\+\d+ µm\)", bore)


def test_drawings_are_files(tmp_path: Path):
    out = tmp_path / "made"
    assert main(["export", "--design", "pin", "--drawings", "--format", "stl", "--out", str(out)]) == 0
    assert (out / "drawings.pdf").read_bytes().startswith(b"%PDF")
    drawing = ezdxf.readfile(out / "motor_cover-drawing.dxf")
    assert not drawing.audit().errors
    dimensions = drawing.modelspace().query("DIMENSION")
    assert any("%%c22.4 H7" in one.dxf.text for one in dimensions)
    assert {"section", "front", "dimensions", "text"} <= {layer.dxf.name for layer in drawing.layers}


@pytest.mark.parametrize("name", ["pin", "printed", "twodisc"])
def test_the_bill_weighs_as_much_as_the_solids(name):
    """The bill counts cylinders, and manufactured parts by themselves; the drive the solids in their places."""
    reducer = Reducer(PRESETS[name])
    lines = bill(reducer, 0.0, casing(reducer))
    assert sum(line.mass_kg for line in lines) == pytest.approx(drive_mass(reducer), rel=1e-3)
    bearing = next(line for line in lines if line.item == "output_bearing")
    outside, bore, width = (float(value) for value in re.findall(r"[\d.]+", bearing.size))
    ring = 0.25e-9 * np.pi * (outside**2 - bore**2) * width * 7850.0
    assert bearing.mass_kg == pytest.approx(2.0 * 0.67 * ring, rel=1e-3)
