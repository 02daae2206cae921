"""Main bearings around both discs of the output: distance, tilting moment, parts, assembly and refusals."""

import pytest
from casings import check_casing

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import PRESETS, override
from cycloid_mj.life.output_bearing import output_bearings
from cycloid_mj.parts.contour import circle_of
from cycloid_mj.parts.export import assembly_order, casing
from cycloid_mj.parts.export.assembly import assembly_parts
from cycloid_mj.parts.export.casing_rules import hub_shoulders
from cycloid_mj.parts.export.drive import drive_length
from cycloid_mj.parts.export.insertion import assembly_moves
from cycloid_mj.reducer import Reducer

CHANGES = {
    "pin": ("output.support=both_ends", "shaft.mounting=straddle", "output.disc_thickness_mm=12"),
    "printed": ("output.disc_thickness_mm=11",),
}


def drive(name: str, seat: str = "both_discs", *more: str) -> Reducer:
    return Reducer(override(PRESETS[name], [*CHANGES[name], f"output.main_bearing_seat={seat}", *more]))


@pytest.mark.parametrize("name", CHANGES)
def test_parts_run_free_can_be_assembled_and_the_bill_has_their_mass(name: str) -> None:
    reducer = drive(name)
    (bearings,) = [line for line in check_casing(reducer, casing(reducer)) if line.item == "output_bearing"]
    assert bearings.count == 2
    assert bearings.designation == casing(reducer).hub.designation


@pytest.mark.parametrize("name", CHANGES)
def test_each_disc_has_a_bearing_against_a_shoulder_next_to_the_cycloid_discs(name: str) -> None:
    reducer = drive(name)
    sizes, parts = casing(reducer), assembly_parts(reducer, casing(reducer))
    bore, shoulder = 0.5 * sizes.hub.bore, hub_shoulders(sizes.hub)[0]
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


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        (("output.support=cantilever",), "need a second disc"),
        (("output.main_bearings=angular_contact",), "face to face"),
        (("output.disc_thickness_mm=11.9",), r"output.disc_thickness_mm to at least 12"),
        (("shaft.counterweight_radius_mm=36",), "reduce shaft.counterweight_radius_mm"),
    ],
)
def test_designs_without_such_bearings_are_refused_with_the_remedy(changes: tuple[str, ...], reason: str) -> None:
    with pytest.raises(DesignError, match=reason):
        casing(drive("pin", "both_discs", *changes))
