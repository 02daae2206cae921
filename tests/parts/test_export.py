"""Exported parts read back by independent tools: watertight, exact in area and volume, with the clearance asked for."""

import io
import itertools
import json
import math
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import ezdxf
import manifold3d
import numpy as np
import pytest
import trimesh

from cycloid_mj.base.errors import CycloidError, DesignError, UsageError
from cycloid_mj.base.names import gears
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design, override, resolve
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.parts import Part, Segment, mass_properties, mesh, parts
from cycloid_mj.parts.accuracy import mass_chord_error
from cycloid_mj.parts.contour import CircleContour
from cycloid_mj.parts.curve import (
    SPLINE_ERROR,
    Arc,
    Circle,
    Curve,
    LineSegment,
    SmoothCurve,
    fit_splines,
    rotate_curve,
)
from cycloid_mj.parts.export import (
    Format,
    Spline,
    assembly_step,
    casing,
    casing_or_none,
    drive_files,
    export,
    part_sections,
    plate,
    read_stl,
    read_volume,
    step_part,
    stl_bytes,
)
from cycloid_mj.parts.export import clearance as measured
from cycloid_mj.parts.export.casing_parts import bored_shaft, casing_parts, fit_part
from cycloid_mj.parts.export.printing import manufactured_parts, separate_parts
from cycloid_mj.parts.gear import gear_outline, profile_offset, tooth_profile
from cycloid_mj.parts.parts import lay_out_parts
from cycloid_mj.parts.polygon import arc, area_moments, circle
from cycloid_mj.reducer import Reducer

PIN, NONPIN = PRESETS["pin"], PRESETS["nonpin"]
LOOSE = override(NONPIN, ["clearance.tooth_um=20.0", "clearance.cam_um=7.0", "clearance.output_um=3.0"])
SEVERAL = ["gear.discs=3", "gear.disc_gap_mm=1.5", "output.support=both_ends", "shaft.mounting=straddle"]
THREE = override(LOOSE, SEVERAL)
DESIGNS = {"pin": PIN, "nonpin": NONPIN, "loose": LOOSE, "three": THREE}
CHORD_ERROR = 5e-6
FINE = 1e-8


@pytest.fixture(params=DESIGNS.values(), ids=DESIGNS.keys())
def design(request: pytest.FixtureRequest) -> Design:
    return request.param


@pytest.mark.parametrize("file_format", ["stl", "obj"])
def test_meshes_read_back_by_trimesh(design: Design, file_format: str) -> None:
    """One watertight body each, in millimetres, and of the volume that the solid has at this chord error."""
    found = export(design, file_format, CHORD_ERROR)  # type: ignore[arg-type]
    reducer = Reducer(design)
    bored = bored_shaft(reducer, casing_or_none(reducer)[0], CHORD_ERROR).solid(CHORD_ERROR)
    solids = parts(reducer, CHORD_ERROR) | {"shaft": bored}
    assert {name.partition(".")[0] for name in found.files} == set(solids)
    for name, content in found.files.items():
        part = trimesh.load(io.BytesIO(content), file_type=file_format, process=file_format == "stl")
        volume = mass_properties(solids[name.partition(".")[0]]).volume
        assert part.is_watertight
        assert part.body_count == 1
        assert part.volume * 1e-9 == pytest.approx(volume, rel=1e-6)


def test_pins_pressed_in_for_sleeves_are_a_part_of_their_own() -> None:
    files = export(override(PIN, ["ring.pins=sleeved"]), "stl", CHORD_ERROR).files
    assert {"housing.stl", "pin.stl", "pressed_pin.stl"} < set(files)
    for name, content in files.items():
        assert trimesh.load(io.BytesIO(content), file_type="stl").body_count == 1, name


def test_stl_is_single_precision_of_the_mesh() -> None:
    shape = mesh(parts(Reducer(PIN), CHORD_ERROR)["shaft"])
    corners = read_stl(stl_bytes(shape, 1e3))
    np.testing.assert_allclose(corners, 1e3 * shape.vertices[shape.faces], rtol=0.0, atol=2e-6)
    with pytest.raises(DesignError, match=r"cube\.stl is not a valid binary STL"):
        read_stl(stl_bytes(shape)[:-1], "cube.stl")


@pytest.mark.parametrize("file_format", ["stl", "obj", "dxf", "svg"])
def test_the_same_design_has_the_same_bytes(file_format: str) -> None:
    first, second = (export(NONPIN, file_format, CHORD_ERROR) for _ in range(2))  # type: ignore[arg-type]
    assert first == second


@pytest.mark.slow
def test_the_clearance_is_what_was_requested(design: Design) -> None:
    for file_format in ("stl", "dxf"):
        for one in export(design, file_format, CHORD_ERROR).clearances:  # type: ignore[arg-type]
            assert one.asked == getattr(design.clearance, one.pair)
            assert one.least == pytest.approx(one.asked, abs=measured.TOLERANCE)
            assert one.most == pytest.approx(one.asked, abs=measured.TOLERANCE)
    pairs = {one.pair for one in export(design, "dxf").clearances}
    assert pairs == ({"pin_gear", "cam", "output", "pin_socket"} if design is PIN else {"tooth", "cam", "output"})


def test_a_wrong_clearance_is_an_error() -> None:
    """The outline of a design with another clearance, measured against this one."""
    (gear,), (housing,) = parts(Reducer(LOOSE))["gear"].prisms, parts(Reducer(LOOSE))["housing"].prisms
    with pytest.raises(DesignError, match=r"tooth of the exported outline is 20 to 20 um instead of 1 um"):
        measured.measure_disc(Reducer(NONPIN), [gear.outline, *gear.holes], housing.holes[0])


def test_flank_distance_is_that_of_the_parallel_curve() -> None:
    gear = tooth_profile(PIN)
    for offset in (gear.pin_radius, gear.pin_radius + 5e-6):
        points = profile.sample(gear, 3000, offset).points
        np.testing.assert_allclose(measured.flank_distance(gear, points), offset, rtol=0.0, atol=1e-15)


def curve_points(entity: Any, count: int = 400) -> np.ndarray:
    """Points of a DXF entity, both ends included, by ezdxf's own evaluation [mm]."""
    if entity.dxftype() == "SPLINE":
        tool = entity.construction_tool()
        return np.array([(point.x, point.y) for point in tool.points(np.linspace(0.0, tool.max_t, count))])
    if entity.dxftype() == "LINE":
        return np.array([(point.x, point.y) for point in (entity.dxf.start, entity.dxf.end)])
    angles = np.linspace(0.0, 360.0, count)
    if entity.dxftype() == "ARC":
        start, end = entity.dxf.start_angle, entity.dxf.end_angle
        angles = np.linspace(start, end + 360.0 * (end < start), count)
    centre = np.array([entity.dxf.center.x, entity.dxf.center.y])
    return centre + entity.dxf.radius * np.column_stack([np.cos(np.radians(angles)), np.sin(np.radians(angles))])


def read_dxf(content: bytes) -> Any:
    document = ezdxf.read(io.StringIO(content.decode()))
    assert not document.audit().has_errors
    assert document.units == ezdxf.units.MM
    return document.modelspace()


@pytest.mark.slow
def test_dxf_gear_has_one_spline_a_lobe_and_the_exact_area(design: Design) -> None:
    space = read_dxf(export(design, "dxf").files[f"{gears(design.gear.discs)[0]}.dxf"])
    splines, circles = space.query("SPLINE"), space.query("CIRCLE")
    assert (len(splines), len(circles), len(space)) == (35, 9, 44)
    outline = np.concatenate([curve_points(spline)[:-1] for spline in splines])
    true = profile.area(tooth_profile(design), profile_offset(design))
    assert area_moments(outline).area * 1e-6 == pytest.approx(true, rel=2e-6)
    distance = measured.flank_distance(tooth_profile(design), outline * 1e-3) - profile_offset(design)
    assert np.abs(distance).max() < 1.1 * SPLINE_ERROR


def test_dxf_ring_is_the_double_envelope() -> None:
    """36 arcs and 36 splines, end to end, around the area of the closed form."""
    space = read_dxf(export(NONPIN, "dxf").files["housing.dxf"])
    loop = [entity for entity in space if entity.dxftype() != "CIRCLE"]
    assert [entity.dxftype() for entity in loop] == ["SPLINE", "ARC"] * 36
    segments = []
    for entity in loop:
        points = curve_points(entity)
        # an arc of the ring runs against the loop
        segments.append(points[::-1] if entity.dxftype() == "ARC" else points)
    ends = np.array([segment[-1] for segment in segments])
    starts = np.array([segment[0] for segment in segments])
    assert np.abs(ends - np.roll(starts, -1, axis=0)).max() < 1e-9
    outline = np.concatenate([segment[:-1] for segment in segments])
    assert area_moments(outline).area * 1e-6 == pytest.approx(envelope.area(tooth_profile(NONPIN)), rel=2e-6)


def test_dxf_sockets_and_shaft_are_arcs_and_lines() -> None:
    files = export(PIN, "dxf").files
    housing, shaft = read_dxf(files["housing.dxf"]), read_dxf(files["shaft.dxf"])
    arcs = list(housing.query("ARC"))
    assert len(arcs) == 72
    outline = np.concatenate([curve_points(arc)[:-1] for arc in arcs])
    (body,) = parts(Reducer(PIN), 1e-8)["housing"].prisms
    assert area_moments(outline).area * 1e-6 == pytest.approx(area_moments(body.holes[0]).area, rel=2e-6)
    layers = {entity.dxf.layer for entity in shaft}
    assert {"journal", "counterweight", "inner_journal", "cam"} <= layers
    names = {layer.split(" z ")[0] for layer in layers}
    assert names == {"journal", "collar", "counterweight", "inner_journal", "cam"}
    half_disc = np.concatenate([curve_points(entity)[:-1] for entity in shaft.query('*[layer=="counterweight"]')])
    assert area_moments(half_disc).area == pytest.approx(np.pi / 2.0 * (30.0**2 + 8.0**2), rel=1e-4)


def test_splines_converge_with_the_fourth_power() -> None:
    """Twice the spans, a sixteenth of the deviation: measured where the fit would stop, on a wave."""
    from cycloid_mj.parts import curve

    wave = SmoothCurve(
        points=lambda t: np.column_stack([t, np.zeros_like(t)]) + 1e-3 * np.column_stack([np.zeros_like(t), np.sin(t)]),
        arc_length=lambda t: np.asarray(t, float),
        tangents=lambda t: np.column_stack([np.ones_like(t), 1e-3 * np.cos(t)]),
        curvature=lambda t: -1e-3 * np.sin(t),
    )
    deviations = []
    for spans in (16, 32):
        nodes = np.linspace(0.0, 6.0, spans + 1)
        deviations.append(curve._deviation(wave, curve._interpolate(wave, nodes), nodes))
    assert deviations[0] / deviations[1] == pytest.approx(16.0, rel=0.15)
    pieces = fit_splines(wave, 0.0, 6.0, 3)
    assert len(pieces) == 3
    for before, after in itertools.pairwise(pieces):
        np.testing.assert_allclose(before.points(2)[-1], after.points(2)[0], atol=1e-15)


def test_curves_turn_clockwise() -> None:
    quarter = np.pi / 2.0
    assert rotate_curve(Circle((0.0, 1.0), 0.5), quarter).centre == pytest.approx((1.0, 0.0))  # type: ignore[union-attr]
    line = rotate_curve(LineSegment((0.0, 1.0), (0.0, 2.0)), quarter)
    assert isinstance(line, LineSegment)
    assert line.end == pytest.approx((2.0, 0.0))
    arc = rotate_curve(Arc((0.0, 0.0), 1.0, 0.0, 1.0), quarter)
    assert isinstance(arc, Arc)
    assert (arc.start, arc.end) == pytest.approx((-quarter, 1.0 - quarter))


@pytest.mark.slow
def test_modified_flanks_are_cut_as_the_solid_is() -> None:
    """Two splines a lobe where flanks are turned, closed at corners; the solid's area, the clearance asked for."""
    changes = ["modification.equidistant_um=4", "modification.pin_circle_um=-6", "modification.rotation_arcsec=40"]
    changed = override(NONPIN, changes)
    outline = part_sections(Reducer(changed))["gear"][0].loops[0]
    assert len(outline) == 70
    points = [curve.points(400) for curve in outline if isinstance(curve, Spline)]
    for before, after in zip(points, [*points[1:], points[0]], strict=True):
        np.testing.assert_allclose(before[-1], after[0], rtol=0.0, atol=1e-12)
    area = area_moments(np.concatenate([segment[:-1] for segment in points])).area
    (solid,) = parts(Reducer(changed), 1e-8)["gear"].prisms
    assert area == pytest.approx(area_moments(solid.outline).area, rel=1e-6)
    assert area < area_moments(parts(Reducer(NONPIN), 1e-8)["gear"].prisms[0].outline).area
    for file_format in ("stl", "dxf"):
        teeth = export(changed, file_format, CHORD_ERROR).clearances[0]  # type: ignore[arg-type]
        assert (teeth.least, teeth.most) == pytest.approx((1e-6, 1e-6), abs=measured.TOLERANCE)


@pytest.mark.parametrize("file_format", ["stl", "obj"])
def test_a_mesh_with_the_wrong_volume_is_an_error_and_no_file(
    file_format: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The last prism of each solid is lost."""
    boolean = manifold3d.Manifold.batch_boolean
    lossy = SimpleNamespace(batch_boolean=lambda pieces, operation: boolean(pieces[:-1] or pieces, operation))
    library = SimpleNamespace(CrossSection=manifold3d.CrossSection, OpType=manifold3d.OpType, Manifold=lossy)
    monkeypatch.setattr(sys.modules["cycloid_mj.parts.mesh"], "manifold3d", library)
    out = tmp_path / "parts"
    arguments = ["export", "--design", "pin", "--format", file_format, "--chord-error-um", "20", "--out", str(out)]
    assert main(arguments) == 1
    assert "has a volume of" in capsys.readouterr().err
    assert not out.exists()


def test_an_outline_that_crosses_itself_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two neighbouring vertices of the gear change places."""

    def crossed(reducer: Reducer, chord_error: float) -> np.ndarray:
        outline = gear_outline(reducer, chord_error).copy()
        outline[[10, 12]] = outline[[12, 10]]
        return outline

    monkeypatch.setattr("cycloid_mj.parts.gear.gear_outline", crossed)
    with pytest.raises(DesignError, match="two outlines of the gear touch or cross near"):
        export(PIN, "stl", 2.3e-5)  # a chord error that no other test has: solids of a shape are kept


def test_sections_have_the_solids_heights(design: Design) -> None:
    solids = parts(Reducer(design))
    for name, sections in part_sections(Reducer(design)).items():
        assert [(one.z0, one.z1) for one in sections] == [(one.z0, one.z1) for one in solids[name].prisms]


def drawn(loop: tuple[Curve, ...]) -> np.ndarray:
    """Draw a closed loop of curves as a polygon; an arc of an internal gear runs against the loop."""

    def points(curve: Curve) -> np.ndarray:
        match curve:
            case Circle():
                return circle(curve.radius, FINE, curve.centre)
            case Arc():
                return np.array(curve.centre) + arc(curve.radius, curve.start, curve.end, FINE)
            case LineSegment():
                return np.array([curve.start, curve.end])
            case Spline():
                return curve.points(400)

    segments = [points(loop[0])]
    for curve in loop[1:]:
        after, end = points(curve), segments[-1][-1]
        segments.append(after if np.allclose(after[0], end, rtol=0.0, atol=1e-10) else after[::-1])
        assert segments[-1][0] == pytest.approx(end, abs=1e-10)
    return np.concatenate(segments)


def test_curves_enclose_what_the_solids_polygons_do(design: Design) -> None:
    """Loop by loop: area and middle, so that a part is the same in CAD, in the model and in its mesh."""
    solids = parts(Reducer(design), FINE)
    for name, sections in part_sections(Reducer(design)).items():
        for section, prism in zip(sections, solids[name].prisms, strict=True):
            for loop, polygon in zip(section.loops, (prism.outline, *prism.holes), strict=True):
                ours, theirs = area_moments(drawn(loop)), area_moments(polygon)
                assert ours.area == pytest.approx(theirs.area, rel=1e-5), (name, section.name)
                middle = [(one.x / one.area, one.y / one.area) for one in (ours, theirs)]
                assert middle[0] == pytest.approx(middle[1], abs=1e-8), (name, section.name)


def test_gear_splines_start_and_end_in_the_valleys() -> None:
    outline = part_sections(Reducer(PIN))["gear"][0].loops[0]
    assert len(outline) == PIN.lobes
    root, _ = profile.radii(tooth_profile(PIN))
    for spline in outline:
        assert isinstance(spline, Spline)
        ends = np.linalg.norm(spline.points(2), axis=1)
        np.testing.assert_allclose(ends, root - PIN.clearance.pin_gear, atol=1e-15)


@pytest.mark.slow
def test_step_solids_have_the_parts_volumes() -> None:
    """The shaft is bored for the motor's shaft."""
    pytest.importorskip("OCP")
    reducer = Reducer(NONPIN)
    solids = parts(reducer) | {"shaft": bored_shaft(reducer, casing(reducer)).solid(mass_chord_error(reducer))}
    for name, content in export(NONPIN, "step").files.items():
        true = mass_properties(solids[name.partition(".")[0]]).volume
        # OpenCASCADE's integral over splines is right to some 1e-5, the reference polygons to 1e-6
        assert read_volume(content) == pytest.approx(true, rel=5e-5)


def test_the_crank_of_several_discs_comes_apart_in_named_parts() -> None:
    """Its cams and its spacer fit on the shaft; in STEP they have the volumes of their solids."""
    pytest.importorskip("OCP")
    sections, solids = part_sections(Reducer(THREE)), parts(Reducer(THREE))
    gears, cams = {"gear_1", "gear_2", "gear_3"}, {"cam_1", "cam_2", "cam_3"}
    assert set(sections) == set(solids) == {"housing", "shaft", "spacer", "output"} | gears | cams
    for name in ("shaft", "spacer", "cam_2", "output"):
        true = mass_properties(solids[name]).volume
        assert read_volume(step_part(name, sections[name])) == pytest.approx(true, rel=5e-6)
    for name in ("spacer", "cam_2"):
        hole = sections[name][0].loops[1][0]
        assert hole == Circle((0.0, 0.0), THREE.shaft.radius)


def test_rollers_of_output_pins_are_tubes_in_every_format() -> None:
    """Where their cores are given; the pins of the output that they turn on are as thick as those."""
    pytest.importorskip("OCP")
    design = PRESETS["printed"]
    sections, true = part_sections(Reducer(design)), mass_properties(parts(Reducer(design))["output_roller"]).volume
    (tube,) = sections["output_roller"]
    assert [loop[0] for loop in tube.loops] == [Circle((0.0, 0.0), 4.5e-3), Circle((0.0, 0.0), 2.5e-3)]
    assert (tube.z0, tube.z1) == (-12.5e-3, 12.5e-3)
    assert {section.loops[0][0].radius for section in sections["output"] if section.name == "pins"} == {2.5e-3}
    assert read_volume(step_part("output_roller", (tube,))) == pytest.approx(true, rel=1e-6)
    assert true == pytest.approx(math.pi * (4.5**2 - 2.5**2) * 25.0 * 1e-9, rel=1e-6)
    assert "output_roller.stl" in export(design, "stl", 1e-5).files
    assert "output_roller.dxf" in export(design, "dxf").files


def test_step_of_a_sleeved_pinwheel_holds_its_pins() -> None:
    """The pins inside the sleeves touch nothing that is drawn: solids of their own."""
    pytest.importorskip("OCP")
    sleeved = override(PIN, ["ring.pins=sleeved"])
    content = step_part("housing", part_sections(Reducer(sleeved))["housing"], 37)
    assert content.count(b"MANIFOLD_SOLID_BREP") == 37
    assert read_volume(content) == pytest.approx(mass_properties(parts(Reducer(sleeved))["housing"]).volume, rel=1e-6)
    with pytest.raises(CycloidError, match="37 separate solids instead of 1"):
        step_part("housing", part_sections(Reducer(sleeved))["housing"])


def test_step_is_one_solid_and_the_same_every_time() -> None:
    """The shaft, joined of four prisms, and the pinwheel; nothing else in the file, no time, no counter."""
    pytest.importorskip("OCP")
    sections = part_sections(Reducer(PIN))
    for part in ("shaft", "housing"):
        first, second = (step_part(part, sections[part]) for _ in range(2))
        assert first == second
        assert first.startswith(b"ISO-10303-21;")
        assert first.count(b"MANIFOLD_SOLID_BREP") == 1
        assert read_volume(first) == pytest.approx(mass_properties(parts(Reducer(PIN))[part]).volume, rel=1e-6)


@pytest.mark.slow
def test_the_assembly_is_the_same_every_time_and_prints_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    """Colours that two parts share, and numbers of occurrences, do not depend on addresses or on the process."""
    pytest.importorskip("OCP")
    script = "import sys; from cycloid_mj.parts.export import *; from cycloid_mj.reducer import Reducer; "
    script += (
        "from cycloid_mj.design import PRESETS; sys.stdout.buffer.write(assembly_step(Reducer(PRESETS['twodisc'])))"
    )
    other = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True).stdout
    first, second = (assembly_step(Reducer(PRESETS["twodisc"])) for _ in range(2))
    assert first == second == other
    assert first.count(b"NEXT_ASSEMBLY_USAGE_OCCURRENCE('43'") == 1
    assert capfd.readouterr().out == ""


@pytest.mark.parametrize("file_format", ["stl", "dxf"])
def test_the_command_writes_the_parts(file_format: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "parts"
    arguments = ["export", "--design", "pin", "--format", file_format, "--chord-error-um", "5", "--out", str(out)]
    assert main([*arguments, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert sorted(told["files"]) == sorted(
        str(out / f"{part}.{file_format}") for part in parts(Reducer(PIN), CHORD_ERROR)
    )
    assert {path.name: path.read_bytes() for path in out.iterdir()} == export(PIN, file_format, CHORD_ERROR).files  # type: ignore[arg-type]
    assert told["clearances"][0] == pytest.approx(
        {"pair": "pin_gear", "asked": 1e-6, "least": 1e-6, "most": 1e-6}, abs=2e-8
    )
    assert main([*arguments, "--force"]) == 0
    assert "clearance of the exported outlines" in capsys.readouterr().out


def test_the_command_refuses_what_cannot_be_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "parts"
    assert main(["export", "--design", "pin", "--format", "iges", "--out", str(out)]) == 2
    undercut = ["--set", "ring.pin_radius_mm=2.9", "--format", "stl", "--out", str(out)]
    assert main(["export", "--design", "pin", *undercut]) == 1
    assert "undercut" in capsys.readouterr().err
    assert not out.exists()


SIGTERM_AFTER_STEP = """
import os, signal, threading
from cycloid_mj.design import PRESETS
from cycloid_mj.parts.export import part_sections, step_part
from cycloid_mj.base.interrupt import Stopped, raise_on_signals
from cycloid_mj.reducer import Reducer

raise_on_signals()
worker = threading.Thread(target=step_part, args=("pin", part_sections(Reducer(PRESETS["pin"]))["pin"]))
worker.start()
worker.join()
try:
    os.kill(os.getpid(), signal.SIGTERM)
except Stopped as stop:
    print(stop)
"""


@pytest.mark.slow
def test_sigterm_is_heard_after_step_was_made() -> None:
    """A page that has returned STEP files still ends in order."""
    pytest.importorskip("OCP")
    ended = subprocess.run([sys.executable, "-c", SIGTERM_AFTER_STEP], capture_output=True, text=True, timeout=300)
    assert (ended.returncode, ended.stdout) == (0, "SIGTERM\n"), ended.stderr


def test_step_without_opencascade_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "OCP", None)
    with pytest.raises(CycloidError, match=r"cycloid-mj\[cad\]"):
        export(PIN, "step")


@pytest.mark.parametrize("file_format", ["stl", "dxf", "step"])
@pytest.mark.parametrize("name", ["twodisc", "pin"])
def test_the_shaft_is_bored_for_the_motor_in_every_format(name: str, file_format: Format) -> None:
    """The bore is that of the assembly: a plain shaft of two discs, and the crank of a single disc."""
    reducer = Reducer(PRESETS[name])
    sizes = casing(reducer)
    bore = sizes.motor_bore
    assert bore is not None
    radius, start, end = bore
    content = export(PRESETS[name], file_format, CHORD_ERROR).files[f"shaft.{file_format}"]
    bored = separate_parts(reducer, casing=sizes)["shaft"]
    plain = fit_part(reducer, sizes, "shaft", lay_out_parts(reducer)["shaft"])
    volume = mass_properties(bored.solid(FINE)).volume
    removed = math.pi * radius**2 * (end - start)
    assert volume == pytest.approx(mass_properties(plain.solid(FINE)).volume - removed, rel=1e-5)
    if file_format == "dxf":
        circles = ezdxf.read(io.StringIO(content.decode())).modelspace().query("CIRCLE")
        assert 1e3 * radius in [pytest.approx(one.dxf.radius) for one in circles]
    elif file_format == "step":
        assert read_volume(content) == pytest.approx(volume, rel=1e-3)
    else:
        mesh_of_file = trimesh.load(io.BytesIO(content), file_type="stl")
        assert mesh_of_file.volume * 1e-9 == pytest.approx(volume, rel=1e-3)


def test_the_shaft_is_not_bored_for_a_motor_without_a_shaft() -> None:
    files = export(PRESETS["twodisc"], "stl", CHORD_ERROR, motor="circle").files
    assert files["shaft.stl"] == stl_bytes(mesh(parts(Reducer(PRESETS["twodisc"]), CHORD_ERROR)["shaft"]), 1e3)


def distances(points: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    """Return the distance of points (n, 2) from the edges of a closed polygon."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    along = b - a
    share = ((points[:, np.newaxis] - a) * along).sum(axis=2) / (along**2).sum(axis=1)
    nearest = a + np.clip(share, 0.0, 1.0)[..., np.newaxis] * along
    return np.linalg.norm(points[:, np.newaxis] - nearest, axis=2).min(axis=1)


@pytest.mark.parametrize("chord_um", [pytest.param(1.0, marks=pytest.mark.slow), 20.0])
@pytest.mark.parametrize("name", ["pin", "nonpin"])
def test_polylines_follow_the_splines_within_the_chord_error(name: str, chord_um: float) -> None:
    """The DXF has no SPLINE; its closed polylines leave the exact outline by at most the chord error."""
    exact, chords = export(PRESETS[name], "dxf").files, export(PRESETS[name], "dxf", 1e-6 * chord_um, polylines=True)
    assert set(chords.files) == set(exact)
    assert chords.clearances[0].least == pytest.approx(chords.clearances[0].asked, abs=2e-6 * chord_um)
    for part in ("gear", "housing"):
        space = read_dxf(chords.files[f"{part}.dxf"])
        kinds = {entity.dxftype() for entity in space}
        assert kinds <= {"LWPOLYLINE", "CIRCLE"}, kinds
        polylines = [entity for entity in space if entity.dxftype() == "LWPOLYLINE"]
        assert all(line.closed for line in polylines)
        (outline,) = (np.array(line.get_points("xy")) for line in polylines)
        curves = [one for one in read_dxf(exact[f"{part}.dxf"]) if one.dxftype() in ("SPLINE", "ARC")][:3]
        points = np.array([[*point][:2] for one in curves for point in one.flattening(1e-5)])
        assert distances(points, outline).max() <= 1e-3 * chord_um + 2e-5
        circles = sorted(one.dxf.radius for one in space if one.dxftype() == "CIRCLE")
        assert circles == sorted(one.dxf.radius for one in read_dxf(exact[f"{part}.dxf"]) if one.dxftype() == "CIRCLE")


def svg_polygons(content: bytes) -> list[np.ndarray]:
    """Return the closed loops of an SVG file by their points, y upwards; of a circle, a half of it by two points."""
    root = ElementTree.fromstring(content.decode())
    paths = [one.attrib["d"] for one in root.iter("{http://www.w3.org/2000/svg}path")]
    loops = [loop for path in paths for loop in path.split("M")[1:]]
    numbers = [np.array(re.findall(r"-?[0-9.]+", re.sub(r"A[-0-9. ]+? 0 0 0", "", loop)), float) for loop in loops]
    return [one.reshape(-1, 2) * (1.0, -1.0) for one in numbers]


@pytest.mark.parametrize("name", ["pin", "twodisc"])
def test_svg_has_the_outlines_of_the_polylines_in_millimetres(name: str) -> None:
    drawn, polylines = export(PRESETS[name], "svg"), export(PRESETS[name], "dxf", polylines=True)
    assert {Path(file).stem for file in drawn.files} == {Path(file).stem for file in polylines.files}
    assert drawn.clearances == polylines.clearances
    for file, content in drawn.files.items():
        root = ElementTree.fromstring(content.decode())
        x, y, width, height = map(float, root.attrib["viewBox"].split())
        assert root.attrib["width"] == f"{width:.6f}mm"
        assert root.attrib["height"] == f"{height:.6f}mm"
        loops = svg_polygons(content)
        space = read_dxf(polylines.files[f"{Path(file).stem}.dxf"])
        starts = np.array([loop[0] for loop in loops])
        assert len(np.unique(np.round(starts, 6), axis=0)) <= len(space) <= len(loops)  # DXF has each loop once
        for entity in space:
            if entity.dxftype() == "CIRCLE":
                expected = np.array([entity.dxf.center[0] + entity.dxf.radius, entity.dxf.center[1]])
                assert np.linalg.norm(starts - expected, axis=1).min() < 1e-6
            else:
                points = np.array(entity.get_points("xy"))
                alike = [loop for loop in loops if len(loop) == len(points)]
                assert any(np.abs(loop - points).max() < 1e-6 for loop in alike)
        inside = np.concatenate(loops)
        assert (inside >= (x, -y - height)).all()
        assert (inside <= (x + width, -y)).all()


@pytest.mark.parametrize("file_format", ["svg", "dxf"])
def test_a_drive_with_covers_is_drawn_by_polylines(file_format: Format) -> None:
    reducer = Reducer(PRESETS["twodisc"])
    sizes = casing(reducer)
    files = drive_files(reducer, file_format, sizes, 1e-5, polylines=file_format == "dxf")
    assert {f"motor_cover.{file_format}", f"output_flange.{file_format}"} <= set(files)
    for content in files.values():
        kinds = {one.dxftype() for one in read_dxf(content)} if file_format == "dxf" else set()
        assert kinds <= {"LWPOLYLINE", "CIRCLE"}


def test_polylines_are_an_option_of_dxf(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "pin", "--format", "stl", "--polylines", "--out", str(tmp_path / "parts")]) == 2
    assert "--polylines applies only with --format dxf" in capsys.readouterr().err
    with pytest.raises(UsageError, match="polylines can be used only with the format dxf"):
        export(PIN, "svg", polylines=True)


def test_an_offset_for_a_printer_widens_each_clearance_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Printed holes are small: an offset of 100 um narrows the disc's outline and widens its bore and holes by it."""
    for offset in (0, 100):
        arguments = ["export", "printed", "--format", "dxf", "--offset-um", str(offset)]
        assert main([*arguments, "--json", "--out", str(tmp_path / str(offset))]) == 0
        clearances = json.loads(capsys.readouterr().out)["clearances"]
    assert [one["least"] for one in clearances] == pytest.approx([150e-6, 110e-6, 150e-6], abs=2e-8)

    def radii(offset: int) -> tuple[list[float], list[float]]:
        space = ezdxf.readfile(tmp_path / str(offset) / "gear.dxf").modelspace()
        splines = [one for one in space if one.dxftype() == "SPLINE"]
        outline = np.concatenate([[np.hypot(*[*point][:2]) for point in one.flattening(1e-4)] for one in splines])
        circles = sorted({round(one.dxf.radius, 6) for one in space if one.dxftype() == "CIRCLE"})
        return [outline.min(), outline.max()], circles

    (plain, holes), (offset, wider) = radii(0), radii(100)
    assert plain == pytest.approx([28.95, 31.95], abs=1e-4)
    assert offset == pytest.approx([28.85, 31.85], abs=1e-4)
    assert holes == pytest.approx([6.05, 10.51], abs=1e-6)
    assert wider == pytest.approx([6.15, 10.61], abs=1e-6)
    for file in (tmp_path / "0").iterdir():
        assert (file.read_bytes() == (tmp_path / "100" / file.name).read_bytes()) == (file.name != "gear.dxf")


MILLED = Path(__file__).parents[1] / "data" / "rim_equals_shoulder.toml"


@pytest.mark.parametrize("chord_error", [1e-6, 1e-5, 1e-4])
def test_faces_with_radii_equal_to_rounding_form_one_mesh(chord_error: float) -> None:
    """In this drive, rim and shoulder of the output are both 27.25 mm, the second one unit in the last place more."""
    reducer = Reducer(resolve(str(MILLED)))
    sizes = casing(reducer)
    _, shoulder, _ = casing_parts(reducer, sizes)["output"].rounds
    assert sizes.rim != shoulder[0]
    assert sizes.rim == pytest.approx(shoulder[0], abs=1e-15)
    printed = plate(reducer, chord_error, 0.0, sizes)
    assert printed.counts["output"] == 1


def test_polygons_of_circles_closer_than_their_chords_do_not_cross() -> None:
    """A step of 1 um in the radius, drawn with chords that leave the circle by 100 um."""
    radii = (27.25e-3, 27.251e-3, 27.4e-3)
    segments = tuple(
        Segment("step", CircleContour(radius), (), float(number), number + 1.0) for number, radius in enumerate(radii)
    )
    shape = mesh(Part("stepped", segments, 1.0).solid(1e-4))
    volume = math.pi * sum(radius**2 for radius in radii)
    assert trimesh.Trimesh(shape.vertices, shape.faces).volume == pytest.approx(volume, rel=1e-2)


@pytest.mark.parametrize("file_format", ["stl", pytest.param("obj", marks=pytest.mark.slow), "dxf", "svg", "step"])
def test_every_made_part_of_a_whole_drive_is_a_file(file_format: Format) -> None:
    """Covers and flange too; the solids have the volumes of the meshes."""
    reducer = Reducer(PRESETS["printed"])
    sizes = casing(reducer)
    made = manufactured_parts(reducer, CHORD_ERROR, 0.0, sizes)
    files = drive_files(reducer, file_format, sizes)
    assert set(files) == {f"{name}.{file_format}" for name in made} >= {f"motor_cover.{file_format}"}
    if file_format == "step":
        for name in ("motor_cover", "output_cover", "output_flange", "output"):
            assert read_volume(files[f"{name}.step"]) == pytest.approx(
                mass_properties(made[name].solid).volume, rel=1e-3
            )
