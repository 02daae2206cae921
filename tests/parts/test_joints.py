"""Joints of the casing: their holes, bought parts and places agree with each other and with the bill of materials."""

from collections import Counter

import pytest
from designs import cases

from cycloid_mj.design import PRESETS
from cycloid_mj.parts.export import bill, casing, places
from cycloid_mj.parts.export.joints import JointKind, bought_parts, drive_joints
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
    assert {joint.kind for joint in joints} == set(JointKind)


@pytest.mark.parametrize("name", DESIGNS)
def test_bill_and_assembly_have_the_bought_parts_of_the_joints(name):
    reducer, sizes, joints = joints_of(name)
    expected = Counter()
    for part in bought_parts(joints):
        expected[part.item] += len(part.origins)
    in_bill = {line.item: line.count for line in bill(reducer, 0.0, sizes) if line.item in expected}
    in_assembly = Counter(place.part for place in places(reducer, 0.0, sizes) if place.part in expected)
    assert in_bill == in_assembly == expected
    numbered = [place.name for place in places(reducer, 0.0, sizes)]
    assert len(numbered) == len(set(numbered))


@pytest.mark.parametrize("name", DESIGNS)
def test_a_dowel_reaches_equally_far_into_both_parts(name):
    _, sizes, joints = joints_of(name)
    dowelled = [joint for joint in joints if joint.kind is JointKind.DOWELLED]
    assert bool(dowelled) == bool(sizes.dowel)
    for joint in dowelled:
        (_, (_, _, start, face)), (_, (_, _, same_face, end)) = joint.holes
        assert face == same_face
        assert face - start == pytest.approx(end - face)
        assert {origin[2] for origin in joint.bought[0].origins} == {face}


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
