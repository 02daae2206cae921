"""Joints of the casing: their holes, bought parts and places agree with each other and with the bill of materials."""

import math
from collections import Counter

import numpy as np
import pytest
from designs import cases, design_file

from cycloid_mj.design import PRESETS, fits, load, override, stock
from cycloid_mj.parts import mesh
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.parts.export import bill, casing, place_parts, shaft_bearing
from cycloid_mj.parts.export.assembly import assembly_parts
from cycloid_mj.parts.export.crank_joints import cam_key
from cycloid_mj.parts.export.crank_rings import hub_radius
from cycloid_mj.parts.export.insertion import blockages
from cycloid_mj.parts.export.joint import JointKind
from cycloid_mj.parts.export.joints import bought_parts, drive_joints
from cycloid_mj.parts.export.keyway import KeywayContour
from cycloid_mj.parts.export.order import assembly_order
from cycloid_mj.parts.export.rules import describe_violations
from cycloid_mj.parts.export.running import running_gaps
from cycloid_mj.reducer import Reducer

DESIGNS = cases(("printed", "pin", "twodisc"), "printed", "twodisc")


def joints_of(name: str):
    reducer = Reducer(PRESETS[name])
    sizes = casing(reducer)
    return reducer, sizes, drive_joints(reducer, sizes)


@pytest.mark.parametrize("name", DESIGNS)
def test_holes_of_a_joint_are_in_its_mating_parts(name):
    _, _, joints = joints_of(name)
    for joint in joints:
        assert {part for part, _ in joint.holes} <= set(joint.parts), joint.name
        assert len(joint.parts) >= 2, joint.name
        assert joint.fit or joint.kind is JointKind.SCREWED or not joint.diameter, joint.name
    kinds = {joint.kind for joint in joints}
    assert {JointKind.SCREWED, JointKind.DOWELLED, JointKind.BEARING, JointKind.LOCATED, JointKind.CLEARANCE} <= kinds


@pytest.mark.parametrize("name", DESIGNS)
def test_bill_and_assembly_have_the_bought_parts_of_the_joints(name):
    reducer, sizes, joints = joints_of(name)
    expected = Counter()
    for part in bought_parts(joints):
        expected[part.item] += len(part.origins)
    in_bill = {line.item: line.count for line in bill(reducer, 0.0, sizes) if line.item in expected}
    in_assembly = Counter(place.part for place in place_parts(reducer, 0.0, sizes) if place.part in expected)
    assert in_bill == in_assembly == expected
    numbered = [place.name for place in place_parts(reducer, 0.0, sizes)]
    assert len(numbered) == len(set(numbered))


@pytest.mark.parametrize("name", DESIGNS)
def test_a_dowel_reaches_equally_far_into_both_parts(name):
    _, sizes, joints = joints_of(name)
    dowelled = [joint for joint in joints if joint.kind is JointKind.DOWELLED]
    assert bool([joint for joint in dowelled if "output_flange" not in joint.parts]) == bool(sizes.dowel)
    assert bool([joint for joint in dowelled if "output_flange" in joint.parts]) == bool(sizes.flange_dowel)
    for joint in dowelled:
        (_, (_, _, start, face)), (_, (_, _, same_face, end)) = joint.holes
        assert face == same_face
        assert face - start == pytest.approx(end - face)
        assert {origin[2] for origin in joint.bought[0].origins} == {face}


def test_dowels_join_hub_and_flange_of_a_plastic_around_their_bore():
    """They are inside of the threads for the load, a wall away from these, from the screw heads and from the bore."""
    reducer, sizes, joints = joints_of("printed")
    (joint,) = [one for one in joints if one.name == "dowels of the output flange"]
    (dowel,) = joint.bought
    assert (joint.parts, dowel.body) == (("output", "output_flange"), "output")
    assert (len(dowel.origins), dowel.designation) == (sizes.flange_screws, "ISO 8734 - 4 x 14 - A")
    radius, wall = 0.5 * sizes.flange_dowel.diameter, sizes.wall
    (bore,) = [one for one in joints if one.name == "bore of hub and flange"]
    for _, (_, bore_radius, *_) in bore.holes:
        assert bore_radius <= sizes.flange_dowel_circle - radius - wall + 1e-12
    insert = 0.5 * stock.insert_of(sizes.flange_bolt.thread).hole
    assert sizes.flange_dowel_circle + radius + wall + insert <= sizes.flange_circle + 1e-12
    (_, (_, _, _, flange_end)) = joint.holes[1]
    assert flange_end <= sizes.top + sizes.flange_thickness - wall + 1e-12
    assert any("press 6 flange_dowel" in step for step in assembly_order(reducer, sizes))
    _, metal_sizes, metal = joints_of("pin")
    assert metal_sizes.flange_dowel is None
    assert not any(one.name == "dowels of the output flange" for one in metal)


@pytest.mark.parametrize("name", DESIGNS)
def test_cover_screws_pass_clearance_holes_and_engage_a_thread(name):
    _, sizes, joints = joints_of(name)
    joint = next(joint for joint in joints if joint.name == "screws of the covers")
    screw, *_ = joint.bought
    (head, *_), length = {origin[2] for origin in screw.origins}, dict(screw.dimensions)["length"]
    thread = next(hole for part, hole in joint.holes if part == "motor_cover")
    engaged = thread[3] - (head - length)
    assert engaged >= 1.5 * dict(screw.dimensions)["thread"] - 1e-12
    assert thread[2] <= head - length + 1e-12
    for part, (_, radius, start, end) in joint.holes:
        if part != "motor_cover":
            assert radius > 0.5 * dict(screw.dimensions)["thread"]
            assert end > start
    assert len(screw.origins) == len(sizes.screws.angles)


def zoo(name):
    reducer = Reducer(load(design_file(name)))
    sizes = casing(reducer)
    return reducer, sizes, drive_joints(reducer, sizes)


KEYED = cases(
    ("sleeved-n40-d2-ring-25um", "massless-n49-d3-carrier-8um", "nonpin-n33-d2-ring-60um"), "sleeved-n40-d2-ring-25um"
)


@pytest.mark.parametrize("name", KEYED)
def test_cams_of_several_discs_are_keyed_to_their_shaft(name):
    """Keyways of shaft, cams and spacers match the key, whose size is that of DIN 6885 for the shaft."""
    reducer, sizes, joints = zoo(name)
    joint = next(one for one in joints if one.kind is JointKind.KEYED)
    (bought,) = joint.bought
    size, radius = dict(bought.dimensions), reducer.design.shaft.radius
    key = cam_key(reducer, sizes)
    assert bought.designation == stock.key_for(2.0 * radius, reducer.design.gear.stack_width).designation
    laid = assembly_parts(reducer, sizes)
    slots = [one.outline for one in laid["shaft"].segments if isinstance(one.outline, KeywayContour)]
    assert slots
    assert {slot.depth for slot in slots} == {-size["depth"]}
    hubs = [laid[f"cam_{number + 1}"] for number in range(reducer.design.gear.discs)] + [laid["spacer"]]
    for hub in hubs:
        for segment in hub.segments:
            (slot,) = segment.holes
            assert (slot.width, slot.depth, slot.angle) == (size["width"], key.bought.in_hub, key.angle)
            outline = segment.outline.polygon(1e-6)
            assert np.linalg.norm(outline, axis=1).min() > radius
    assert size["height"] < size["depth"] + key.bought.in_hub <= size["height"] + 0.5e-3


@pytest.mark.parametrize("name", KEYED)
def test_keyed_parts_have_closed_meshes(name):
    reducer, sizes, _ = zoo(name)
    for part in ("shaft", "cam_1", "spacer", "key"):
        solid = assembly_parts(reducer, sizes)[part].solid(5e-6)
        assert len(mesh(solid).faces) > 10


def test_cams_too_thin_for_a_keyway_are_glued():
    reducer, sizes, joints = joints_of("twodisc")
    assert cam_key(reducer, sizes) is None
    assert next(one for one in joints if one.name == "cams on the shaft").kind is JointKind.GLUED


def test_a_key_that_pierces_the_faces_of_the_spacer_is_replaced_by_adhesive():
    """Shaft of 20 mm: the keyway reaches 13.1 mm from the axis, the faces of the spacer only 12.4 mm."""
    reducer = Reducer(override(PRESETS["twodisc"], ["shaft.radius_mm=10"]))
    sizes = casing(reducer)
    key = stock.key_for(20e-3, reducer.design.gear.stack_width)
    assert math.hypot(10e-3 + key.in_hub, 0.5 * key.width) > hub_radius(reducer, sizes)
    assert cam_key(reducer, sizes) is None
    assert list(describe_violations(reducer, sizes)) == []
    assert len(mesh(assembly_parts(reducer, sizes)["spacer"].solid(5e-6)).faces) > 10


@pytest.mark.parametrize("name", DESIGNS)
def test_tapped_holes_are_drilled_to_their_core(name):
    """M4 is drilled 3.3 mm in a metal; in a plastic its insert has a hole of its own."""
    _, _, joints = joints_of(name)
    tapped = [(joint, thread) for joint in joints for thread in joint.threads]
    assert {thread.part for _, thread in tapped} >= {"motor_cover", "output", "output_flange"}
    for joint, thread in tapped:
        radii = {radius for _, radius, *_ in joint.holes_in(thread.part)}
        if thread.insert:
            assert 0.5 * stock.insert_of(thread.thread).hole in radii
        else:
            assert 0.5 * (thread.thread - stock.pitch(thread.thread)) in radii
            assert 0.5 * thread.thread not in radii
    assert 4e-3 - stock.pitch(4e-3) == pytest.approx(3.3e-3)


@pytest.mark.parametrize("name", ["fixed-n34-d2-carrier-120um", "nonpin-n33-d2-ring-60um"])
def test_every_thread_in_a_plastic_has_an_insert(name):
    _, _, joints = zoo(name)
    assert all(thread.insert for joint in joints for thread in joint.threads)


def test_dowels_centre_the_covers_around_a_ring_that_is_too_thin_for_them():
    """The screws pass outside of the ring, whose wall is 1.85 mm thick: the dowels are in line with the screws."""
    design = PRESETS["pin"].but(
        gear={"eccentricity": 0.8e-3},
        output={"hole_radius": PRESETS["pin"].output.pin_radius + 0.8e-3},
        ring={"pin_radius": 3e-3},
        housing={"outer_radius": 45.6e-3, "support": "rim"},
    )
    reducer = Reducer(design)
    sizes = casing(reducer)
    assert sizes.screws.outside
    (joint,) = [one for one in drive_joints(reducer, sizes) if one.kind is JointKind.DOWELLED]
    assert joint.parts == ("motor_cover", "output_cover")
    ((below, (centres, radius, low, high)), (above, upper)) = joint.holes
    assert (below, above) == joint.parts
    assert high == pytest.approx(upper[2])
    assert high - low == pytest.approx(upper[3] - upper[2]) == pytest.approx(0.5 * sizes.dowel.length)
    assert np.hypot(*centres.T) == pytest.approx(np.full(2, sizes.screws.circle))
    assert np.linalg.norm(centres[:, None] - sizes.screws.centres(), axis=2).min() > radius + sizes.screws.hole + 1e-3
    assert list(describe_violations(reducer, sizes)) == []


def test_bearings_of_a_printed_crank_have_inner_rings():
    """Needles would wear the plastic: its bearings are ball bearings, at most two on the cam, also if needles fit."""
    steel = PRESETS["printed"].but(gear={"bore_radius": 12e-3}, shaft={"bearing_width": 6e-3})
    printed = Reducer(steel.but(shaft_material={"name": "PETG"}))
    assert cam_bearing(Reducer(steel))[0].designation == "HK1812"
    assert [(bearing.designation, count) for bearing, count in [cam_bearing(printed)]] == [("61802", 2)]
    assert shaft_bearing(printed).designation == "61901"
    sizes = casing(printed)
    assert all(gap.keeps(sizes.play) for gap in running_gaps(printed, sizes))
    assert blockages(printed, sizes) == ()
    (joint,) = [one for one in drive_joints(printed, sizes) if one.name == "cam bearings in the discs"]
    assert joint.fit == "H7"
    lines = {line.item: line for line in bill(printed, 0.0, sizes)}
    assert (lines["shaft"].material, lines["shaft"].made_or_bought) == ("PETG", "made")
    assert lines["cam_bearing"].fit == "H7 outside, light press fit on the printed crank"
    assert lines["shaft_bearing"].fit == f"{lines['cam_bearing'].fit}; the one next to the motor sealed (RS1)"
    assert cam_bearing(Reducer(PRESETS["printed"].but(shaft_material={"name": "PETG"}))) is None, "none of 21 mm fits"


def test_fits_follow_the_kind_of_load():
    """What is pressed in is tight, what turns has play: cups N6 (R6 in plastic), rollers E8 on m6, sleeves F7."""
    _, _, printed = joints_of("printed")
    fit = {joint.name: joint.fit for joint in printed}
    assert fit["cam bearings in the discs"] == "R6"
    assert fits.clearances(fit["rollers on the output pins"], 5e-3)[0] > 0.0
    assert fit["output pins in their discs"] == "m6 in N7"
    assert "j5 on the crank" in fit["shaft in the motor cover"]
    assert fits.clearances("N7/m6", 5e-3)[1] <= 0.0


@pytest.mark.parametrize("name", ["sleeved-n27-d1-carrier-3um", "sleeved-n40-d2-ring-25um"])
def test_pins_of_sleeves_are_pressed_into_both_covers(name):
    reducer, sizes, joints = zoo(name)
    joint = next(one for one in joints if one.name == "pins of the sleeves")
    (pin,) = assembly_parts(reducer, sizes)["pressed_pin"].segments
    for part, (_, radius, low, high) in joint.holes:
        assert radius == pin.outline.radius
        assert pin.z0 <= low + 1e-12, part
        assert high <= pin.z1 + 1e-12, part


@pytest.mark.parametrize("name", cases(("printed", "pin", "twodisc"), "printed", "twodisc", "pin"))
def test_screws_and_threads_of_the_flange_have_walls(name):
    _, sizes, joints = joints_of(name)
    centres = np.array(
        [centre for joint in joints for part, hole in joint.holes if part == "output_flange" for centre in hole[0]]
    )
    (screws,) = [joint for joint in joints if joint.name == "screws of the output flange"]
    (threads,) = [joint for joint in joints if joint.name == "threads for the load"]
    reach_of_all = [joint.holes_in("output_flange") for joint in joints if joint.name != "bore of hub and flange"]
    circles = [(centre, radius) for holes in reach_of_all for places, radius, *_ in holes for centre in places]
    for number, (centre, radius) in enumerate(circles):
        for other_centre, other_radius in circles[number + 1 :]:
            distance = np.hypot(*(centre - other_centre))
            assert distance < 1e-9 or distance >= radius + other_radius + sizes.wall - 1e-9
    heads = max(radius for _, radius, *_ in screws.holes_in("output_flange"))
    tapped = max(radius for _, radius, *_ in threads.holes_in("output_flange"))
    assert sizes.flange_screws == len(screws.holes[0][1][0]) == len(threads.holes[0][1][0])
    reach = np.linalg.norm(centres, axis=1).max() + heads
    assert reach <= sizes.flange_radius - sizes.wall + 1e-9
    angle = np.pi / sizes.flange_screws
    assert 2.0 * sizes.flange_circle * np.sin(0.5 * angle) >= heads + tapped
    assert sizes.flange_circle + tapped <= 0.5 * sizes.hub.bore - sizes.wall + 1e-9
