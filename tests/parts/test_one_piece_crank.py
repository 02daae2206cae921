"""A crank of two discs in one piece: its solid, its fillets, its line of the bill and its drawing."""

import math

import pytest

from cycloid_mj.design import override, resolve
from cycloid_mj.parts import body_solids, mass_properties, parts
from cycloid_mj.parts.export import bill, casing
from cycloid_mj.parts.export.assembly import assembly_parts
from cycloid_mj.parts.export.drawing import part_drawings
from cycloid_mj.parts.export.edges import broken_edges
from cycloid_mj.parts.export.rules import describe_violations
from cycloid_mj.reducer import Reducer


def crank(*changes):
    reducer = Reducer(override(resolve("twodisc"), ["shaft.cam_joint=one_piece", *changes]))
    return reducer, casing(reducer)


def test_cams_and_collar_are_in_the_solid_of_the_shaft():
    reducer, _ = crank()
    assert {name for name in parts(reducer) if name.startswith(("shaft", "cam", "spacer"))} == {"shaft"}
    separate = Reducer(resolve("twodisc"))
    masses = [mass_properties(body_solids(item)["shaft"]).mass for item in (reducer, separate)]
    assert masses[0] == pytest.approx(masses[1], rel=1e-9)


def test_bill_lists_one_manufactured_crank_without_cams_and_spacer():
    reducer, sizes = crank()
    lines = {line.item: line for line in bill(reducer, 0.0, sizes)}
    assert not {"cam_1", "cam_2", "spacer", "key"} & lines.keys()
    assert (lines["shaft"].count, lines["shaft"].made_or_bought) == (1, "made")
    solid = assembly_parts(reducer, sizes)["shaft"].solid(1e-6)
    assert lines["shaft"].mass_kg == pytest.approx(mass_properties(solid).mass, rel=1e-5)


def test_every_shoulder_has_the_fillet_of_the_fatigue_item():
    """Journals at both cams, and necks between cams and collar: six shoulders inside, two at the outer collars."""
    reducer, sizes = crank()
    fillets = [edge for edge in broken_edges(reducer, sizes, assembly_parts(reducer, sizes)["shaft"]) if edge.is_fillet]
    assert len(fillets) == 6
    assert {edge.size for edge in fillets} == {reducer.design.shaft.shoulder_fillet}
    half_gap = 0.5 * reducer.design.gear.disc_gap
    assert sum(math.isclose(abs(edge.z), half_gap) for edge in fillets) == 2


def test_a_narrow_gap_without_room_for_fillets_is_reported():
    reducer, sizes = crank("gear.disc_gap_mm=1")
    assert any("no room for fillets" in sentence for sentence in describe_violations(reducer, sizes))
    wider, sizes = crank("gear.disc_gap_mm=2")
    assert list(describe_violations(wider, sizes)) == []


def test_drawing_dimensions_both_eccentrics():
    reducer, sizes = crank()
    (sheet,) = (drawing for drawing in part_drawings(reducer, sizes) if drawing.name == "shaft")
    eccentric = [item for item in sheet.diameters if "eccentric by 1.2500" in item.text]
    assert len(eccentric) == 2
