"""Parts of a drive that move against each other neither touch nor rub, at any crank angle."""

import math
from dataclasses import replace

import pytest
from designs import CENTRAL, FOLDER, cases, design_file

from cycloid_mj.checks import check
from cycloid_mj.design import PRESETS, load
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.parts.contour import circle_of
from cycloid_mj.parts.export import Casing, bill, casing, place_parts
from cycloid_mj.parts.export.assembly import assembly_parts
from cycloid_mj.parts.export.bearings import shaft_bearing
from cycloid_mj.parts.export.casing import bearing_width_of
from cycloid_mj.parts.export.joints import JointKind, drive_joints
from cycloid_mj.parts.export.order import assembly_order
from cycloid_mj.parts.export.rules import describe_violations
from cycloid_mj.parts.export.running import running_gaps, swept_annuli
from cycloid_mj.reducer import Reducer

NAMES = (*CENTRAL, *sorted(path.stem for path in FOLDER.glob("*.toml")))


def reducer_of(name: str) -> Reducer:
    return Reducer(PRESETS[name] if name in PRESETS else load(design_file(name)))


def drive_of(name: str) -> tuple[Reducer, Casing]:
    reducer = reducer_of(name)
    return reducer, casing(reducer)


def smallest(reducer, sizes, *parts):
    return min(gap.distance for gap in running_gaps(reducer, sizes) if {gap.part, gap.other} == set(parts))


@pytest.mark.parametrize("name", NAMES)
def test_parts_that_move_against_each_other_are_apart_by_the_play(name):
    reducer = reducer_of(name)
    sizes = casing(reducer)
    assert sizes.play >= 1e-4
    assert all(one.outer > one.inner and one.high > one.low for one in swept_annuli(reducer, sizes))
    assert [gap for gap in running_gaps(reducer, sizes) if not gap.keeps(sizes.play)] == []


@pytest.mark.parametrize("name", ["pin", "printed"])
def test_the_ring_is_wider_than_the_disc_by_its_axial_play(name):
    reducer = reducer_of(name)
    sizes = casing(reducer)
    ring = assembly_parts(reducer, sizes)["housing"].segments
    width = max(one.z1 for one in ring) - min(one.z0 for one in ring)
    assert width - reducer.design.gear.face_width == pytest.approx(2.0 * sizes.play)
    for cover in ("motor_cover", "output_cover"):
        assert smallest(reducer, sizes, "gear", cover) == pytest.approx(sizes.play)


def test_a_ring_as_wide_as_the_disc_jams():
    reducer = reducer_of("pin")
    sizes = casing(reducer)
    tight = replace(sizes, play=0.0, end=0.5 * reducer.design.gear.face_width)
    for cover in ("motor_cover", "output_cover"):
        assert smallest(reducer, tight, "gear", cover) == 0.0
        assert smallest(reducer, sizes, "pin", cover) >= 1e-4 - 1e-9


def test_dowels_key_a_ring_inside_of_its_cover():
    """Its rim is lower than the ring, so that the other cover clamps the ring, and its seat has play."""
    reducer = reducer_of("printed")
    sizes = casing(reducer)
    assert sizes.screws.outside
    dowelled = [set(one.parts) for one in drive_joints(reducer, sizes) if one.kind is JointKind.DOWELLED]
    assert {"motor_cover", "housing"} in dowelled
    assert {"housing", "output_cover"} in dowelled
    cover = assembly_parts(reducer, sizes)["motor_cover"].segments
    assert max(one.z1 for one in cover) <= sizes.end - 1e-4
    seats = [hole.radius for one in cover for hole in one.holes if hole.centre == (0.0, 0.0)]
    assert max(seats) == pytest.approx(reducer.design.housing.outer_radius + 0.05e-3)


@pytest.mark.parametrize("name", ["pin", "printed"])
def test_the_counterweight_stays_off_the_ring_of_its_bearing_that_is_at_rest(name):
    reducer = reducer_of(name)
    sizes = casing(reducer)
    weight = next(one for one in assembly_parts(reducer, sizes)["shaft"].segments if one.name == "counterweight")
    assert weight.z0 - sizes.near[1] >= 0.5e-3 - 1e-12
    collar = next(one for one in assembly_parts(reducer, sizes)["shaft"].segments if one.name == "collar")
    assert (collar.z0, collar.z1) == pytest.approx((sizes.near[1], weight.z0))
    assert collar.outline.radius < 0.5 * (reducer.design.shaft.radius + sizes.seat)


def test_the_crank_floats_between_its_bearings_by_the_axial_play():
    """Its rings leave 0.1 mm between ball bearings on both sides of the discs, so that they are not preloaded."""
    reducer = reducer_of("twodisc")
    sizes = casing(reducer)
    parts = assembly_parts(reducer, sizes)
    (near,), (far,) = parts["crank_ring_1"].segments, parts["crank_ring_2"].segments
    assert near.z0 == pytest.approx(sizes.near[1])
    assert sizes.far[0] - far.z1 == pytest.approx(sizes.play)


def test_spacers_keep_the_bearings_of_an_overhung_crank_apart():
    """One is between the outer rings in the cover, one between the inner rings on the journal, of equal length."""
    reducer = reducer_of("pin")
    sizes = casing(reducer)
    parts = assembly_parts(reducer, sizes)
    (outer,), (inner,) = parts["bearing_spacer_1"].segments, parts["bearing_spacer_2"].segments
    (first, second) = [place.origin[2] for place in place_parts(reducer, 0.0, sizes) if place.part == "shaft_bearing"]
    half = 0.5 * bearing_width_of(reducer)
    assert (outer.z0, outer.z1) == (inner.z0, inner.z1) == pytest.approx((first + half, second - half))
    assert inner.outline.radius < outer.holes[0].radius < outer.outline.radius == sizes.seat
    assert inner.holes[0].radius == reducer.design.shaft.radius
    assert not {"bearing_spacer_1", "bearing_spacer_2"} & assembly_parts(*drive_of("twodisc")).keys(), "straddled"


def test_the_flange_covers_open_bearings_with_a_gap():
    """It clamps the inner ring, and covers the outer ring of an angular contact bearing at a distance."""
    reducer = Reducer(PRESETS["pin"].but(output={"main_bearings": "angular_contact"}))
    sizes = casing(reducer)
    assert all(gap.keeps(sizes.play) for gap in running_gaps(reducer, sizes))
    clamp, cover, *_ = [one for one in swept_annuli(reducer, sizes) if one.part == "output_flange"]
    assert clamp.outer < cover.outer == pytest.approx(0.5 * sizes.hub.outside)
    assert cover.low - clamp.low == pytest.approx(sizes.play)
    (joint,) = [one for one in drive_joints(reducer, sizes) if one.name == "hub in the output cover"]
    assert joint.bought[0].designation == "71812 ACD"
    assert "preload" in joint.fit


@pytest.mark.parametrize("name", cases(("pin", "twodisc"), "pin"))
def test_a_retainer_clamps_the_outer_ring_of_crossed_rollers(name):
    """It touches the outer ring only, stands off the cover, and its screws stay below the face of the flange."""
    reducer = Reducer(PRESETS[name].but(output={"main_bearings": "crossed_roller"}))
    sizes = casing(reducer)
    assert list(describe_violations(reducer, sizes)) == []
    ring, hub = sizes.retainer, sizes.hub
    parts = assembly_parts(reducer, sizes)
    (annulus, *_) = parts["bearing_retainer"].segments
    bore = min(hole.radius for hole in annulus.holes if not any(hole.centre))
    assert 0.5 * hub.outside > bore > 0.5 * hub.pitch > sizes.flange_radius > 0.5 * hub.bore
    cover_end = max(segment.z1 for segment in parts["output_cover"].segments)
    assert annulus.z0 - cover_end == pytest.approx(sizes.play)
    assert annulus.z0 == sizes.top == sizes.bearings[-1][1]
    assert ring.height + sizes.play <= sizes.flange_thickness + 1e-12
    lines = {line.item: line for line in bill(reducer, 0.0, sizes)}
    assert (lines["output_bearing"].count, lines["output_bearing"].designation) == (1, hub.designation)
    assert lines["retainer_screw"].count == ring.count
    assert lines["bearing_retainer"].material == lines["output_cover"].material
    assert any("bearing_retainer" in step for step in assembly_order(reducer, sizes))


@pytest.mark.parametrize("name", ["printed", "twodisc"])
def test_the_end_of_a_straddled_shaft_has_a_recess(name):
    reducer = reducer_of(name)
    sizes = casing(reducer)
    for part in ("shaft", "rolling elements"):
        assert smallest(reducer, sizes, part, "output") >= sizes.play - 1e-9
    assert smallest(reducer, sizes, "shaft", "motor_cover") >= sizes.play - 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_a_bearing_of_the_shaft_can_enter_its_seat(name):
    """From the seat to one of its ends the cover is open as wide as the bearing is."""
    reducer = reducer_of(name)
    sizes = casing(reducer)
    cover = [one for one in swept_annuli(reducer, sizes) if one.part == "motor_cover"]
    assert min(one.inner for one in cover if one.low >= sizes.near[0]) >= sizes.seat - 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_every_rolling_cam_has_its_bearing_in_the_assembly(name):
    reducer = reducer_of(name)
    laid, sizes = assembly_parts(reducer, casing(reducer)), casing(reducer)
    bearings = [place for place in place_parts(reducer, 0.0, sizes) if place.part == "cam_bearing"]
    in_stock = cam_bearing(reducer)
    assert len(bearings) == reducer.design.gear.discs * (in_stock[1] if in_stock else 1)
    bore = laid["cam_bearing"].segments[0].holes[0].radius
    assert reducer.design.shaft.radius + reducer.design.gear.eccentricity <= bore < reducer.design.gear.bore_radius


@pytest.mark.parametrize("name", ["printed", "large"])
def test_the_bore_of_a_disc_is_the_outside_of_its_bearing_in_stock(name):
    """A drawn cup is pressed in: the clearance of the cam is inside of the bearing, not around it."""
    reducer, sizes = drive_of(name)
    assert reducer.design.clearance.cam > 0.0
    circles = [circle_of(hole) for one in assembly_parts(reducer, sizes)["gear"].segments for hole in one.holes]
    (bore,) = {one.radius for one in circles if one and math.hypot(*one.centre) < 1e-9}
    assert bore == pytest.approx(0.5 * cam_bearing(reducer)[0].outside)


def test_design_check_states_the_axial_play_and_what_jams():
    (joints,) = [one for one in check("pin") if one.name == "joints"]
    assert joints.passed
    assert "axial play of discs, pins and crank of 0.1 mm" in joints.got
    (joints,) = [one for one in check(load(design_file("sleeved-n40-d2-ring-25um"))) if one.name == "joints"]
    assert not joints.passed
    assert "turns 39 times for a turn of the output, not 40" in joints.got


def test_a_drawn_cup_does_not_rub_on_the_collars_of_the_crank():
    reducer = Reducer(
        PRESETS["printed"].but(shaft={"bearing_width": 12e-3, "radius": 7.5e-3}, gear={"bore_radius": 12e-3})
    )
    assert shaft_bearing(reducer).designation == "HK1512"
    sizes = casing(reducer)
    assert all(gap.distance >= sizes.play - 1e-9 for gap in running_gaps(reducer, sizes))
    collar = next(one for one in assembly_parts(reducer, sizes)["shaft"].segments if one.name == "collar")
    assert collar.z0 == pytest.approx(sizes.near[1] + sizes.play)
