"""Joints as items of a rating, and the momentary torque that they limit."""

import math

import pytest
from designs import CENTRAL, FOLDER, cases, design_file

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import fits, resolve, stock
from cycloid_mj.life import rate
from cycloid_mj.life.item import ItemKind
from cycloid_mj.life.joints import JointTorques, fit_code, screwed_joints
from cycloid_mj.life.rated import momentary_torque
from cycloid_mj.parts.cam_bearing import cam_radius
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.parts.export.joints import JointKind, drive_joints
from cycloid_mj.parts.export.order import assembly_order
from cycloid_mj.reducer import Reducer

KEYS = {"name", "kind", "value", "unit", "limit", "safety", "life_h", "source", "note"}


def joints_of(name: str) -> dict[str, dict]:
    items = rate(name).as_json()["items"]
    assert all(item.keys() >= KEYS for item in items.values())
    assert all((key.startswith("joint_")) == (item["kind"] == "joint") for key, item in items.items())
    return {key: item for key, item in items.items() if item["kind"] == "joint"}


@pytest.mark.parametrize(
    "name", cases((*CENTRAL, *sorted(path.stem for path in FOLDER.glob("*-n*"))), "pin", "printed")
)
def test_momentary_torque_is_no_larger_than_that_of_the_weakest_joint(name: str) -> None:
    name = name if name in CENTRAL else str(design_file(name))
    design = resolve(name)
    torque, _ = momentary_torque(Reducer(design))
    weakest = min(item["safety"] for item in joints_of(name).values())
    assert torque <= 2.0 * design.rated_torque * weakest * (1.0 + 1e-9)


def test_joints_state_units_sources_and_assumptions() -> None:
    joints = joints_of("pin")
    words = " ".join(item["name"] for item in joints.values())
    for what in ("output flange", "covers", "motor", "dowels", "load", "press fit"):
        assert what in words
    for item in joints.values():
        assert item["unit"] in ("N m", "MPa")
        assert item["source"]
        assert item["note"]
        assert item["safety"] == pytest.approx(item["limit"] / item["value"])


def test_flange_of_pin_slips_at_the_torque_computed_by_hand() -> None:
    """Class 8.8 screws: n x 0.7 x 640 MPa x A_s x 0.15 x r, at twice the nominal torque of 36.68 N m."""
    each = next(each for each in screwed_joints(Reducer(resolve("pin"))) if "output flange" in each.joint.name)
    area = {4e-3: 8.78e-6, 5e-3: 14.2e-6, 6e-3: 20.1e-6}[each.thread.diameter]
    proof = {"8.8": 640e6, "10.9": 940e6, "12.9": 1100e6}[each.property_class]
    by_hand = each.count * 0.7 * proof * area * 0.15 * each.radius
    (item,) = (item for item in rate("pin").items.values() if item.name == f"{each.joint.name}, slip")
    assert item.kind is ItemKind.JOINT
    assert item.limit >= by_hand * (1.0 - 2e-3)
    assert item.value == pytest.approx(2.0 * 36.68)
    assert "0.10 to 0.20" in item.note, "the spread by the assumed friction is stated"


def test_a_ring_that_the_screws_pass_outside_of_slips_or_shears_its_dowels() -> None:
    """It is clamped by n F at its mean radius, friction 0.15; the larger of this torque and that of dowels counts."""
    reducer, joints = Reducer(resolve("printed")), joints_of("printed")
    assert casing(reducer).screws.outside
    cover = next(each for each in screwed_joints(reducer) if each.joint.name == "screws of the covers")
    radius = 0.5 * (reducer.design.ring_root_radius + reducer.design.housing.outer_radius)
    slip, item = cover.count * cover.preload * 0.15 * radius, joints["joint_ring"]
    dowels = [each["limit"] for each in joints.values() if each["name"].startswith("dowels of motor cover")]
    assert item["limit"] == pytest.approx(max(slip, *dowels), rel=1e-6)
    assert item["value"] == pytest.approx(2.0 * reducer.design.rated_torque * 14.0 / 13.0)


def test_ring_pins_in_a_plastic_are_glued_with_epoxy() -> None:
    """Half of a pin, 0.5 pi d l 3 MPa d/2: a retaining compound needs metal to cure."""
    design, item = resolve("printed"), joints_of("printed")["joint_ring_pin_glue"]
    radius, length = design.ring.pin_radius, design.gear.stack_width
    assert item["limit"] == pytest.approx(0.5 * math.pi * 2.0 * radius * length * 3e6 * radius)
    assert "two-part epoxy" in item["note"]
    assert "3 N/mm2" in item["source"]


def test_plastics_limit_the_preload_by_inserts_and_heads() -> None:
    each = next(each for each in screwed_joints(Reducer(resolve("printed"))) if "output flange" in each.joint.name)
    by_mechanism = {limit.mechanism: limit.preload for limit in each.limits}
    assert each.preload == min(by_mechanism.values()) < by_mechanism["slip"]
    insert = stock.insert_of(each.thread.diameter)
    strength = resolve("printed").material_of("housing").yield_strength
    pulled = 0.5 * 3.14159 * insert.hole * insert.length * strength / 3.0**0.5
    assert by_mechanism["threads"] == pytest.approx(pulled, rel=1e-3)
    assert each.tightening_torque < 0.5, "N m; 2.7 N m would strip the inserts"


def test_washers_spread_the_force_of_the_flange_screws_on_a_plastic() -> None:
    """M4 on ISO 7089: 6.53 + 1.6 x 0.8 = 7.81 mm instead of 6.53 mm around the hole of 4.5 mm, 1.82 times the area."""
    reducer = Reducer(resolve("printed"))
    each = next(each for each in screwed_joints(reducer) if "output flange" in each.joint.name)
    heads = next(limit for limit in each.limits if limit.mechanism == "heads")
    allowed = 0.5 * reducer.design.material_of("housing").tensile_strength
    assert heads.preload == pytest.approx(allowed * 0.25 * math.pi * (7.81e-3**2 - 4.5e-3**2), rel=1e-3)
    washers = next(part for part in each.joint.bought if part.item == "flange_washer")
    assert washers.designation == "ISO 7089 - 4"
    assert len(washers.origins) == each.count
    metal = screwed_joints(Reducer(resolve("pin")))
    assert not any(part.item == "flange_washer" for each in metal for part in each.joint.bought)


def test_dowels_of_a_plastic_flange_transmit_more_than_its_screws() -> None:
    """Six dowels 4 x 14 tilt in the plastic of 36 MPa: 6 x 0.414 x 4 mm x 7 mm x 36 MPa x 14.3 mm; screws 10.4 N m."""
    joints = joints_of("printed")
    item = joints["joint_dowels_of_the_output_flange"]
    assert item["limit"] == pytest.approx(6.0 * (2.0**0.5 - 1.0) * 4e-3 * 7e-3 * 36e6 * 14.3e-3, rel=1e-3)
    assert "Johansen" in item["source"]
    assert "screws transmit 10.4 N m" in item["note"]
    for mechanism in ("heads", "threads"):
        assert joints[f"joint_screws_of_the_output_flange_{mechanism}"]["limit"] == item["limit"]
    assert "joint_dowels_of_the_output_flange" not in joints_of("pin")
    torque, _ = momentary_torque(Reducer(resolve("printed")))
    assert torque == pytest.approx(22.8, rel=0.01), "the dowels of the ring, on a torque that is N/(N - 1) as large"


def test_torques_of_carrier_ring_and_crank_balance() -> None:
    fixed, turning = (
        JointTorques.at_output(Reducer(resolve("pin", {"output.member": member})), 35.0)
        for member in ("carrier", "ring")
    )
    assert (fixed.carrier, fixed.ring, fixed.crank) == pytest.approx((35.0, 36.0, 1.0))
    assert (turning.carrier, turning.ring, turning.crank) == pytest.approx((35.0 * 35 / 36, 35.0, 35.0 / 36))


def test_pressed_pins_have_an_interference_over_their_tolerance_zones() -> None:
    assert fit_code("m6 in N7") == "N7/m6"
    assert max(fits.clearances("N7/m6", 6e-3)) < 0.0 < max(fits.clearances("H7/m6", 6e-3))
    seat = joints_of("pin")["joint_output_pin_press"]
    assert seat["safety"] > 100.0


def test_a_key_of_the_cams_is_rated_by_its_side_pressure() -> None:
    """T = 0.9 R_e d (h - t1) l/2 by DIN 6892, method C; keys of shape B have no round ends."""
    design = resolve("twodisc", {"shaft.radius_mm": 6.0, "gear.bore_radius_mm": 19.0})
    reducer = Reducer(design)
    (joint,) = (joint for joint in drive_joints(reducer, casing(reducer)) if joint.kind is JointKind.KEYED)
    key = dict(joint.bought[0].dimensions)
    (item,) = (item for item in rate(design).items.values() if "DIN 6892" in item.source)
    sides = (key["height"] - key["depth"]) * key["length"]
    softest = design.material_of("shaft").yield_strength
    assert item.limit == pytest.approx(0.5 * 0.9 * softest * 12e-3 * sides)
    assert item.value == pytest.approx(2.0 * design.rated_torque / design.reduction)
    assert "joint_cams" in rate("twodisc").items, "the cams of the preset are too thin for a keyway: glued"


def test_shrunk_cams_are_rated_by_the_thinnest_wall_of_a_cam() -> None:
    """T = mu p pi d^2 l/2 with the Lame pressure of a ring around the shaft with its bore (DIN 7190-1)."""
    design = resolve("twodisc", {"shaft.radius_mm": 9.0, "shaft.bore_radius_mm": 4.0, "shaft.cam_joint": "shrink"})
    reducer = Reducer(design)
    sizes = casing(reducer)
    (joint,) = (one for one in drive_joints(reducer, sizes) if one.name == "cams on the shaft")
    assert joint.kind is JointKind.PRESSED
    assert joint.fit == "H7/s6, shrunk"
    assert "dry ice" in "".join(assembly_order(reducer, sizes))
    item = rate(design).items["joint_cams"]
    assert (item.kind, item.value) == ("joint", pytest.approx(2.0 * design.rated_torque / design.reduction))
    outside, inner = 2.0 * (cam_radius(reducer) - design.gear.eccentricity), 8e-3
    ratios = [(large**2 + small**2) / (large**2 - small**2) for large, small in ((outside, 18e-3), (18e-3, inner))]
    interference = 0.5 * (10e-6 + 39e-6) - 0.8 * 6e-6  # H7/s6 at 18 mm: 10 to 39 um; Rz 4 and 2 um are smoothed
    pressure = design.material_of("shaft").youngs_modulus * interference / (18e-3 * sum(ratios))
    assert item.limit == pytest.approx(0.15 * pressure * math.pi * 18e-3**2 * design.gear.face_width / 2.0)
    with pytest.raises(DesignError, match="creeps in a shrink fit"):
        casing(reducer.but(shaft_material={"name": "PETG"}))


def test_splined_cams_are_rated_by_their_flanks() -> None:
    """6 x 16 x 20: h = 1.6 mm, d_m = 18 mm, n = 6, the length of one cam."""
    design = resolve("twodisc", {"shaft.cam_joint": "spline", "shaft.radius_mm": 8.0})
    item = rate(design).items["joint_cams"]
    strength = design.material_of("shaft").yield_strength
    assert item.kind == "joint"
    assert item.limit == pytest.approx(0.5 * strength * 18e-3 * 1.6e-3 * design.gear.face_width * 0.75 * 6)


def test_clamped_cams_are_rated_by_the_preload_of_their_screws() -> None:
    """Two M2 of 8.8: F = 2 x 0.7 x 640 MPa x 2.073 mm2 = 1.857 kN; N = (F l1 - M)/l2; T = 0.15 N d."""
    changes = {"shaft.cam_joint": "clamp", "shaft.radius_mm": 5.0, "gear.bore_radius_mm": 18.5}
    design = resolve("twodisc", changes)
    reducer = Reducer(design)
    item = rate(design).items["joint_cams"]
    assert (item.kind, item.value) == ("joint", pytest.approx(2.0 * design.rated_torque / design.reduction))
    wall = cam_radius(reducer) - design.gear.eccentricity - 5e-3
    shaft_arm = 5e-3 + 0.5 * wall
    screw_arm = shaft_arm + 5e-3 + 0.5 * 2.4e-3 + 0.5e-3  # clearance hole of 2.4 mm, 0.5 mm of wall to the bore
    moment = 210e9 * design.gear.face_width * wall**3 / 12.0 * 12e-6 / (2.0 * shaft_arm**2)  # H7/h6: 0 to 24 um
    normal = (2.0 * 0.7 * 640e6 * 2.073e-6 * screw_arm - moment) / shaft_arm
    assert item.limit == pytest.approx(0.15 * normal * 10e-3, rel=2e-3)
    assert "tighten with 0.336 N m" in item.note
