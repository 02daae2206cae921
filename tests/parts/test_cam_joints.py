"""Splined and clamped cams: solids, fits, order of assembly, bill, drawings and refusals."""

import math

import numpy as np
import pytest
from designs import cases, design_file

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import load, override, resolve, stock
from cycloid_mj.parts import mass_properties, mesh
from cycloid_mj.parts.cam_bearing import cam_bearing, cam_radius
from cycloid_mj.parts.export import assembly_order, bill, casing, casing_or_none, drive_files, read_volume
from cycloid_mj.parts.export.assembly import assembly_parts
from cycloid_mj.parts.export.cam_clamp import CLAMP, cam_clamp
from cycloid_mj.parts.export.cam_splines import cam_spline
from cycloid_mj.parts.export.drawing import part_drawings
from cycloid_mj.parts.export.insertion import assembly_moves, blockages
from cycloid_mj.parts.export.keyway import SlottedContour, SplineContour
from cycloid_mj.parts.export.rules import describe_violations
from cycloid_mj.parts.polygon import signed_area
from cycloid_mj.reducer import Reducer

SPLINED = "shaft.cam_joint=spline", "shaft.radius_mm=8"
CLAMPED = "shaft.cam_joint=clamp", "shaft.radius_mm=5", "gear.bore_radius_mm=18.5"


def drive(*changes, name="twodisc"):
    reducer = Reducer(override(resolve(name), list(changes)))
    return reducer, casing(reducer)


def notes(reducer, sizes, part):
    return next("; ".join(drawing.notes) for drawing in part_drawings(reducer, sizes) if drawing.name == part)


@pytest.mark.parametrize("changes", [SPLINED, CLAMPED], ids=["spline", "clamp"])
def test_drive_can_be_assembled_and_turns(changes):
    reducer, sizes = drive(*changes)
    assert list(describe_violations(reducer, sizes)) == []
    assert blockages(reducer, sizes) == ()
    for part in ("shaft", "cam_1", "cam_2", "spacer"):
        assert len(mesh(assembly_parts(reducer, sizes)[part].solid(5e-6)).faces) > 10


def test_spline_is_the_smallest_of_iso_14_over_the_journals():
    reducer, sizes = drive(*SPLINED)
    assert cam_spline(reducer).designation == "ISO 14 - 6 x 16 x 20"
    parts = assembly_parts(reducer, sizes)
    cams = [segment for segment in parts["shaft"].segments if isinstance(segment.outline, SplineContour)]
    width = reducer.design.gear.stack_width
    assert (cams[0].z0, cams[-1].z1) == (pytest.approx(-0.5 * width), pytest.approx(0.5 * width))
    for hub in ("cam_1", "cam_2", "spacer"):
        assert {segment.holes for segment in parts[hub].segments} == {(cams[0].outline,)}
    lines = {line.item: line for line in bill(reducer, 0.0, sizes)}
    assert lines["shaft"].made_or_bought == "made"
    assert "H7/g7" in lines["cam_1"].fit
    assert "6 splines" in notes(reducer, sizes, "shaft")
    assert "compound" not in assembly_order(reducer, sizes)[6]


def test_area_of_a_splined_section():
    """Between circles, a spline of a width b adds b (R_D - R_d) and the caps of its arcs."""
    contour = SplineContour(6, 8e-3, 10e-3, 4e-3, 0.3)
    caps = [
        radius**2 * (half - math.sin(half) * math.cos(half))
        for radius, half in ((r, math.asin(2e-3 / r)) for r in (10e-3, 8e-3))
    ]
    heights = math.sqrt(10e-3**2 - 2e-3**2) - math.sqrt(8e-3**2 - 2e-3**2)
    expected = math.pi * 8e-3**2 + 6 * (4e-3 * heights + caps[0] - caps[1])
    assert signed_area(contour.polygon(1e-9)) == pytest.approx(expected, rel=1e-6)


def test_area_of_a_slotted_cam():
    contour = SlottedContour(10e-3, 1.25e-3, 5e-3, 1e-3)
    ends = 1.25e-3 + math.sqrt(10e-3**2 - 0.5e-3**2), math.sqrt(5e-3**2 - 0.5e-3**2)
    approximate = math.pi * (10e-3**2 - 5e-3**2) - 1e-3 * (ends[0] - ends[1])
    assert signed_area(contour.polygon(1e-9)) == pytest.approx(approximate, rel=1e-4)


def test_clamping_screws_are_within_the_cam_under_a_bearing_with_an_inner_ring():
    reducer, sizes = drive(*CLAMPED)
    clamp, radius, gear = cam_clamp(reducer), cam_radius(reducer), reducer.design.gear
    assert stock.has_inner_ring(cam_bearing(reducer)[0])
    outward = clamp.distance - gear.eccentricity
    assert math.hypot(outward + 0.5 * clamp.bolt.head, clamp.head_face + clamp.bolt.head_height) < radius
    assert math.hypot(outward, clamp.length - clamp.head_face) < radius
    assert clamp.distance - 0.5 * stock.bolt_hole(clamp.bolt.thread) > reducer.design.shaft.radius
    assert clamp.engaged_length >= 1.5 * clamp.bolt.thread
    assert clamp.count * (clamp.bolt.head + 0.4e-3) < gear.face_width
    lines = {line.item: line for line in bill(reducer, 0.0, sizes)}
    assert lines["cam_screw"].count == 2 * clamp.count
    assert lines["cam_screw"].designation == f"{clamp.bolt.designation} x {1e3 * clamp.length:g}"
    assert "across the slot" in notes(reducer, sizes, "cam_1")


def test_clamped_cams_are_on_the_shaft_before_their_gears():
    reducer, sizes = drive(*CLAMPED)
    onto_shaft = [move.parts[0] for move in assembly_moves(reducer, sizes) if move.group == "shaft" and move.parts]
    assert onto_shaft[:8] == ["shaft", "cam_1", "cam_screw_1", "gear_1", "spacer_1", "cam_2", "cam_screw_3", "gear_2"]
    assert "Clamp each cam" in assembly_order(reducer, sizes)[6]


def test_step_file_of_a_clamped_cam_has_the_holes_of_its_screws():
    reducer, sizes = drive(*CLAMPED)
    clamp, cam = cam_clamp(reducer), assembly_parts(reducer, sizes)["cam_2"]
    drilled = read_volume(drive_files(reducer, "step", sizes)["cam_2.step"])
    removed = mass_properties(cam.solid(1e-7)).volume - drilled
    assert removed == pytest.approx(clamp.count * clamp.removed_volume(reducer), rel=0.03)
    line = next(line for line in bill(reducer, 0.0, sizes) if line.item == "cam_2")
    assert line.mass_kg == pytest.approx(cam.density * drilled, rel=2e-3)


@pytest.mark.parametrize("name", cases(("sleeved-n40-d2-ring-25um", "nonpin-n33-d2-ring-60um")))
def test_joints_of_the_zoo_are_built_or_refused_with_a_remedy(name):
    """A joint adds no violation of a rule to those of the design itself, such as a motor that turns with the ring."""
    filed = Reducer(load(design_file(name)))
    casing, _ = casing_or_none(filed)
    own = set(describe_violations(filed, casing)) if casing else set()
    for joint in ("spline", "clamp"):
        reducer = filed.but(shaft={"cam_joint": joint})
        sizes, reason = casing_or_none(reducer)
        assert set(describe_violations(reducer, sizes)) <= own if sizes else "is not possible" in reason


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (("shaft.cam_joint=spline",), "the cams leave"),
        (("shaft.cam_joint=clamp",), "inner ring"),
        ((*CLAMPED, "gear.face_width_mm=4"), "no screw|inner ring"),
        ((*CLAMPED, "shaft_material.name=PETG"), "creeps"),
        ((*CLAMPED, "gear.discs=3"), "3 discs"),
    ],
)
def test_impossible_joints_are_refused(changes, message):
    with pytest.raises(DesignError, match=message):
        drive(*changes)


def test_a_slot_is_on_the_thick_side_of_each_cam():
    reducer, sizes = drive(*CLAMPED)
    for number, phase in enumerate(reducer.phases, start=1):
        (outline,) = {segment.outline for segment in assembly_parts(reducer, sizes)[f"cam_{number}"].segments}
        points = outline.polygon(1e-6)
        thick = np.array([-math.sin(phase), math.cos(phase)])
        across = points @ np.array([thick[1], -thick[0]])
        sides = points[np.isclose(np.abs(across), 0.5 * CLAMP.slot, atol=1e-9)]
        assert (sides @ thick > 0.0).all()
