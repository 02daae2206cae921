"""Every part of a drive can be put in by the steps of its assembly."""

from dataclasses import replace

import pytest
from designs import CENTRAL, FOLDER, cases, design_file

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import PRESETS, load
from cycloid_mj.parts.export import assembly_order, casing, insertion, place_parts
from cycloid_mj.parts.export.insertion import DOWN, UP, Blockage, Move, assembly_moves, blockages
from cycloid_mj.reducer import Reducer

NAMES = (*CENTRAL, *sorted(path.stem for path in FOLDER.glob("*.toml")))


def drive(name):
    reducer = Reducer(PRESETS[name] if name in PRESETS else load(design_file(name)))
    return reducer, casing(reducer)


@pytest.mark.parametrize("name", cases(NAMES, "pin", "printed", "twodisc", "sleeved-n40-d2-ring-25um"))
def test_every_part_can_be_put_in_by_the_steps(name):
    reducer, sizes = drive(name)
    moved = {part for move in assembly_moves(reducer, sizes) for part in move.parts}
    assert {place.name for place in place_parts(reducer, 0.0, sizes)} <= moved
    assert blockages(reducer, sizes) == ()
    assert len(assembly_order(reducer, sizes)) == 10


def test_the_hub_passes_its_bearings_before_the_flange_clamps_them():
    reducer, sizes = drive("pin")
    assert assembly_order(reducer, sizes)[4].startswith("Push the hub through both, and screw the output_flange on")
    reducer, sizes = drive("printed")
    assert "into the hub of the output; push the hub through both" in assembly_order(reducer, sizes)[4]


def test_an_enclosed_seat_blocks_its_bearing():
    reducer, sizes = drive("nonpin-n33-d2-ring-60um")
    shut = replace(sizes, cavity=0.5 * (sizes.seat + reducer.design.shaft.radius))
    assert any(one == Blockage("shaft_bearing_1", "motor_cover") for one in blockages(reducer, shut))


def test_a_cam_with_its_bearing_cannot_pass_a_spacer(monkeypatch):
    """With the spacer on the shaft before, gear 1 with its cam comes too late."""
    reducer, sizes = drive("twodisc")
    order = list(assembly_moves(reducer, sizes))
    first = next(move for move in order if move.parts == ("gear_1",) and move.group == "shaft")
    order.remove(first)
    spacer = next(index for index, move in enumerate(order) if move.parts == ("spacer_1",))
    order.insert(spacer + 1, Move(first.parts, "shaft", DOWN))
    monkeypatch.setattr(insertion, "assembly_moves", lambda *_: order)
    assert {one.other for one in blockages(reducer, sizes)} == {"spacer_1"}


def test_steps_put_cams_into_gears_before_the_spacer_and_keep_pins_in():
    reducer, sizes = drive("twodisc")
    steps = assembly_order(reducer, sizes)
    assert steps[6].index("each cam with its bearing into its gear") < steps[6].index("spacer")
    assert "glue the pins" in steps[5]
    free, sizes = drive("pin")
    assert "with grease" in assembly_order(free, sizes)[5]


def test_shrunk_cams_are_on_the_shaft_before_their_gears():
    """A hot cam is not in a bearing: cam 1, gear 1, spacer, cam 2, gear 2, each past what is there."""
    reducer, _ = drive("twodisc")
    shrunk = reducer.but(shaft={"cam_joint": "shrink"})
    sizes = casing(shrunk)
    onto_shaft = [move.parts[0] for move in assembly_moves(shrunk, sizes) if move.group == "shaft" and move.parts]
    assert onto_shaft[:6] == ["shaft", "cam_1", "gear_1", "spacer_1", "cam_2", "gear_2"]
    assert blockages(shrunk, sizes) == ()


def one_piece(name):
    reducer, _ = drive(name)
    reducer = reducer.but(shaft={"cam_joint": "one_piece"})
    return reducer, casing(reducer)


@pytest.mark.parametrize("name", cases(("twodisc", "sleeved-n40-d2-ring-25um", "nonpin-n33-d2-ring-60um"), "twodisc"))
def test_each_gear_is_put_on_a_crank_in_one_piece_from_its_own_end(name):
    reducer, sizes = one_piece(name)
    onto_shaft = [(move.parts[0], move.direction) for move in assembly_moves(reducer, sizes) if move.group == "shaft"]
    assert onto_shaft == [("shaft", 0), ("gear_1", UP), ("gear_2", DOWN)]
    assert blockages(reducer, sizes) == ()
    assert "gear_1 on cam 1 from the motor end" in assembly_order(reducer, sizes)[6]


def test_a_gear_cannot_pass_the_collar_of_a_crank_in_one_piece(monkeypatch):
    reducer, sizes = one_piece("twodisc")
    order = [
        replace(move, direction=DOWN) if move.parts == ("gear_1",) and move.group == "shaft" else move
        for move in assembly_moves(reducer, sizes)
    ]
    monkeypatch.setattr(insertion, "assembly_moves", lambda *_: order)
    assert Blockage("gear_1", "shaft") in blockages(reducer, sizes)


def test_a_crank_in_one_piece_with_three_discs_is_refused():
    reducer, _ = drive("massless-n49-d3-carrier-8um")
    with pytest.raises(DesignError, match="cannot be assembled"):
        casing(reducer.but(shaft={"cam_joint": "one_piece"}))
