"""Main bearings around both discs of the output: distance, tilting moment, parts, assembly and refusals."""

import math
from dataclasses import replace

import pytest
from casings import check_casing
from designs import design_file

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import PRESETS, override, resolve
from cycloid_mj.life import rate
from cycloid_mj.life.output_bearing import output_bearings
from cycloid_mj.parts.contour import circle_of
from cycloid_mj.parts.export import assembly_order, casing
from cycloid_mj.parts.export.assembly import assembly_parts
from cycloid_mj.parts.export.bearings import hub_bearing_designation
from cycloid_mj.parts.export.drive import TURNING, casing_inertia, drive_length
from cycloid_mj.parts.export.insertion import assembly_moves
from cycloid_mj.reducer import Reducer

CHANGES = {
    "pin": ("output.support=both_ends", "shaft.mounting=straddle", "output.disc_thickness_mm=12"),
    "printed": ("output.disc_thickness_mm=11",),
}


BACK_TO_BACK = {
    "pin": ("output.main_bearings=angular_contact", "output.disc_thickness_mm=16.1"),
    "twodisc": (
        *("output.support=both_ends", "shaft.mounting=straddle", "output.main_bearings=angular_contact"),
        *("output.disc_thickness_mm=22", "output.pin_circle_radius_mm=33"),
    ),
    "printed": ("output.main_bearings=tapered", "output.disc_thickness_mm=24"),
}
"""Drives with bearings that have a contact angle around both discs."""


def drive(name: str, seat: str = "both_discs", *more: str) -> Reducer:
    return Reducer(override(PRESETS[name], [*CHANGES.get(name, ()), f"output.main_bearing_seat={seat}", *more]))


def pair(name: str) -> Reducer:
    return drive(name, "both_discs", *BACK_TO_BACK[name])


@pytest.mark.parametrize("name", CHANGES)
def test_parts_run_free_can_be_assembled_and_the_bill_has_their_mass(name: str) -> None:
    reducer = drive(name)
    (bearings,) = [line for line in check_casing(reducer, casing(reducer)) if line.item == "output_bearing"]
    assert bearings.count == 2
    assert bearings.designation == hub_bearing_designation(casing(reducer).hub)


@pytest.mark.parametrize("name", CHANGES)
def test_each_disc_has_a_bearing_against_a_shoulder_next_to_the_cycloid_discs(name: str) -> None:
    reducer = drive(name)
    sizes, parts = casing(reducer), assembly_parts(reducer, casing(reducer))
    bore, shoulder = 0.5 * sizes.hub.bore, sizes.hub.shoulders[0]
    (motor_side, output_side), face = sizes.bearings, 0.5 * reducer.design.gear.stack_width + 1e-3
    assert motor_side[1] == pytest.approx(-face - 2.0 * sizes.wall)
    assert output_side[0] >= face + 2.0 * sizes.wall - 1e-12
    thickness, steps = (
        reducer.design.output.disc_thickness,
        sorted((segment.z0, segment.z1, circle_of(segment.outline).radius) for segment in parts["output_2"].segments),
    )
    assert steps == [
        pytest.approx((-face - thickness, motor_side[1], bore)),
        pytest.approx((motor_side[1], -face, shoulder)),
    ]


def test_bearings_on_both_sides_carry_a_larger_tilting_moment_in_a_shorter_drive() -> None:
    """Those of `pin` are 26 instead of 12 mm apart: capacity grows with the distance, and own forces are shared."""
    both, one_sided = drive("pin"), drive("pin", "disc")
    wide, narrow = output_bearings(both), output_bearings(one_sided)
    assert wide.bearing == narrow.bearing
    assert (1e3 * wide.spacing, 1e3 * narrow.spacing) == (pytest.approx(26.0), pytest.approx(12.0))
    assert max(wide.own) < 0.5 * max(narrow.own)
    assert wide.moment > 5.0 * narrow.moment
    assert wide.tilting_stiffness() > (26.0 / 12.0) ** 2 * narrow.tilting_stiffness()
    assert drive_length(both) < drive_length(one_sided)


def test_the_second_disc_with_its_bearing_seat_is_in_the_inertia(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its radius grows from that of the rim to 30 and 32.7 mm: pi rho r^4 h/2 of both cylinders less that disc."""
    reducer = drive("pin")
    whole = casing_inertia(reducer)
    monkeypatch.setitem(TURNING, "output", ("output", "output_flange"))
    missing = (whole - casing_inertia(reducer)) * reducer.design.reduction**2
    sizes, density = casing(reducer), reducer.design.material_of("output").density
    inner, outer, rim = sizes.hub.shoulders[0], 0.5 * sizes.hub.bore, sizes.rim
    by_hand = 0.5 * math.pi * density * (2e-3 * inner**4 + 10e-3 * outer**4 - 12e-3 * rim**4)
    assert missing == pytest.approx(by_hand, rel=0.01)


def test_forces_on_both_bearings_balance_those_of_discs_and_shaft() -> None:
    """With the discs in the middle between the bearings, each carries about half of the forces, so both are alike."""
    inner, outer = output_bearings(drive("pin")).own
    assert inner == pytest.approx(outer, rel=0.1)


def test_the_bearing_of_the_second_disc_is_put_on_it_before_the_motor_cover() -> None:
    reducer = drive("printed")
    moves = [move.parts for move in assembly_moves(reducer, casing(reducer)) if move.group == "drive"]
    second, bearing, cover = ("output_2",), ("output_bearing_1",), ("motor_cover",)
    assert moves.index(("output_bearing_2",)) < moves.index(("hub",)) < moves.index(second)
    assert moves.index(second) < moves.index(bearing) < moves.index(cover)
    steps = " ".join(assembly_order(reducer, casing(reducer)))
    assert "press the disc output_2 on the pins, and one output_bearing on it" in steps
    assert "up to its lip" in steps


@pytest.mark.parametrize("name", BACK_TO_BACK)
def test_bearings_back_to_back_run_free_can_be_assembled_and_are_in_the_bill(name: str) -> None:
    reducer = pair(name)
    lines = {line.item: line for line in check_casing(reducer, casing(reducer))}
    assert lines["output_bearing"].count == 2
    assert "back to back" in lines["output_bearing"].fit
    assert (lines["stop_ring"].count, lines["stop_ring"].made_or_bought) == (1, "made")
    assert lines["stop_ring"].material == lines["housing"].material, "that of the ring, not of light covers"


@pytest.mark.parametrize("name", BACK_TO_BACK)
def test_outer_rings_are_supported_next_to_the_discs_and_inner_rings_at_their_outer_ends(name: str) -> None:
    """So the load centres are further apart than the bearings; the stop ring is on the solid part of the ring."""
    reducer = pair(name)
    sizes, parts, hub = casing(reducer), assembly_parts(reducer, casing(reducer)), casing(reducer).hub
    (low, high), (bottom, top), stop = *sizes.bearings, sizes.stop_ring
    assert stop
    assert stop.radius > reducer.design.ring_root_radius
    assert stop.thickness >= 0.5 * hub.width
    assert high == pytest.approx(-sizes.end - stop.thickness)
    assert (top, bottom) == pytest.approx((sizes.top, sizes.top - hub.width))
    inner, outer = hub.shoulders
    assert stop.bore == outer
    cover = [
        (one.z0, one.z1, min(circle_of(hole).radius for hole in one.holes)) for one in parts["motor_cover"].segments
    ]
    seat = [ends for *ends, radius in cover if radius == pytest.approx(0.5 * hub.outside)]
    assert seat[0][0] == pytest.approx(low - sizes.play), "the other end of the outer ring is free"
    lip = [one for one in parts["output_cover"].segments if one.z0 < bottom - 1e-9]
    assert {round(circle_of(one.holes[0]).radius, 9) for one in lip} == {round(outer, 9)}
    discs = sorted((one.z0, one.z1, circle_of(one.outline).radius) for one in parts["output_2"].segments)
    face = 0.5 * reducer.design.gear.stack_width + 1e-3
    assert discs == [
        pytest.approx((-face - reducer.design.output.disc_thickness, low, inner)),
        pytest.approx((low, -face, 0.5 * hub.bore)),
    ]
    assert circle_of(parts["output_flange"].segments[0].outline).radius == pytest.approx(inner)


@pytest.mark.parametrize(
    ("name", "beyond"), [("pin", 0.25 * 138e-3 * math.tan(math.radians(25.0))), ("printed", 5.5e-3)]
)
def test_load_centres_are_beyond_both_bearings(name: str, beyond: float) -> None:
    """71812: d_m/2 tan(25 deg) from its middle; 32910: a - T/2 = 13 - 7.5 mm (SKF)."""
    reducer = pair(name)
    middles = [0.5 * sum(ends) for ends in casing(reducer).bearings]
    assert output_bearings(reducer).spacing == pytest.approx(middles[1] - middles[0] + 2.0 * beyond)


def test_bearings_back_to_back_around_both_discs_tilt_less_than_around_one() -> None:
    both, one_sided = pair("pin"), drive("pin", "disc", *BACK_TO_BACK["pin"])
    wide, narrow = output_bearings(both), output_bearings(one_sided)
    assert wide.bearing == narrow.bearing
    assert (1e3 * wide.spacing, 1e3 * narrow.spacing) == (
        pytest.approx(64.38, abs=0.01),
        pytest.approx(44.18, abs=0.01),
    )
    assert wide.moment > 1.7 * narrow.moment
    assert wide.tilting_stiffness() > (wide.spacing / narrow.spacing) ** 2 * narrow.tilting_stiffness()
    assert drive_length(both) < drive_length(one_sided)


def test_the_press_fits_of_the_second_disc_limit_what_a_pair_carries() -> None:
    """Eight pins of 6 mm: F = n mu p pi d l; F_a = 1.216 tan(25 deg) F_r if half of the balls carry the load."""
    reducer = pair("pin")
    found, ratio = output_bearings(reducer), 1.216 * math.tan(math.radians(25.0))
    item = rate(reducer).items["joint_second_disc_axial"]
    assert (item.unit, item.kind) == ("N", "joint")
    assert item.limit == found.disc_force
    assert item.value == pytest.approx(max(2.0 * ratio * max(found.own), 0.01 * found.bearing.dynamic))
    pressure = 1e6 * float(item.note.split(" um: ")[1].split(" MPa")[0])
    assert item.limit == pytest.approx(8 * 0.15 * pressure * math.pi * 6e-3 * 16.1e-3, rel=5e-3)
    loose = replace(found, disc_force=1500.0)
    assert loose.load_limit == pytest.approx(1500.0 / ratio)
    assert loose.moment == pytest.approx(found.spacing * (1500.0 / ratio - max(found.own)))
    assert loose.axial == 1500.0
    assert "joint_second_disc_axial" not in rate(drive("pin")).items


def test_the_bearing_is_on_the_second_disc_and_the_stop_ring_on_the_ring_before_this_disc() -> None:
    reducer = pair("pin")
    moves = [(move.parts, move.group) for move in assembly_moves(reducer, casing(reducer))]
    on_disc, stop = moves.index((("output_bearing_1",), "output_2")), moves.index((("stop_ring",), "drive"))
    assert on_disc < stop < moves.index((("output_2",), "drive")) < moves.index((("motor_cover",), "drive"))
    steps = " ".join(assembly_order(reducer, casing(reducer)))
    assert "from outside, up to its shoulder; the other one goes on the disc output_2 later" in steps
    assert "grind its raised face, when the covers are tight, until the hub turns without play" in steps
    assert "put the stop_ring on the housing, and press the disc on the pins" in steps


@pytest.mark.parametrize("seat", ["disc", "both_discs"])
def test_bearings_around_discs_stay_inside_of_the_pins_of_sleeves(seat: str) -> None:
    """The pins of sleeves stand in the covers, next to the seats of these bearings."""
    changes = "output.support=both_ends", "shaft.mounting=straddle", f"output.main_bearing_seat={seat}"
    design = override(
        resolve(str(design_file("sleeved-n27-d1-carrier-3um"))), [*changes, "output.disc_thickness_mm=15"]
    )
    check_casing(Reducer(design), casing(Reducer(design)))


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        (("output.support=cantilever",), "need a second output disc"),
        (("output.main_bearings=crossed_roller",), "a single crossed roller bearing carries forces and moments alone"),
        (("output.main_bearings=angular_contact",), r"output.disc_thickness_mm to at least 16.1"),
        (
            ("output.main_bearings=angular_contact", "housing.outer_radius_mm=47"),
            "does not fit between the ring pins and the screws",
        ),
        (("output.main_bearings=tapered",), "no standard bearing"),
        (("output.disc_thickness_mm=11.9",), r"output.disc_thickness_mm to at least 12"),
        (("shaft.counterweight_radius_mm=36",), "reduce shaft.counterweight_radius_mm"),
    ],
)
def test_designs_without_such_bearings_are_refused_with_the_remedy(changes: tuple[str, ...], reason: str) -> None:
    with pytest.raises(DesignError, match=reason):
        casing(drive("pin", "both_discs", *changes))
