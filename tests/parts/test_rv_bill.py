"""The bill of an RV reducer: pins, needles and crank bearings are in stock, or special by drawing."""

import re

import pytest

from cycloid_mj.checks import soundness
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, stock
from cycloid_mj.life import rate
from cycloid_mj.life.rv import crank_bearing_ratings
from cycloid_mj.parts.export.rv_assembly import place_rv_parts, rv_assembly_parts
from cycloid_mj.parts.export.rv_bill import rv_bill
from cycloid_mj.plots.exploded import BILL, assembly_files
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.bending import AXIAL_GAP

RV80E = RvReducer(PRESETS["rv80e"])
STOCKED = RvReducer(PRESETS["rv80e"].but(cranks={"eccentric_radius": 11.5e-3, "taper_radius": 21e-3}))
"""The preset with 32004 X (20 x 42 x 15 mm) at the ends of its cranks."""


def test_a_crank_bearing_in_stock_has_its_designation_and_dimensions() -> None:
    (bearing,) = (item for item in stock.crank_bearings() if item.designation == "32004 X")
    assert STOCKED.crank_bearing == bearing
    line = {item.item: item for item in rv_bill(STOCKED)}["tapered_bearing"]
    assert (line.designation, line.count) == ("32004 X", 6)
    assert line.size == "diameter 42 x bore 20 x length 15 mm"
    (check,) = (item for item in soundness(STOCKED) if item.name == "tapered_bearings")
    assert "(32004 X, 20 x 42 x 15 mm)" in check.why


def test_a_bearing_wider_than_the_flange_is_not_in_stock_for_it() -> None:
    assert STOCKED.but(cranks={"flange_thickness": 14.9e-3}).crank_bearing is None


def test_a_crank_bearing_in_stock_is_next_to_the_discs() -> None:
    face = 0.5 * STOCKED.design.gear.stack_width + AXIAL_GAP
    middles = [abs(part.origin[2]) for part in place_rv_parts(STOCKED) if part.part == "tapered_bearing"]
    assert middles == pytest.approx([face + 7.5e-3] * 6)
    (segment,) = rv_assembly_parts(STOCKED)["tapered_bearing"].segments
    assert segment.z1 - segment.z0 == pytest.approx(15e-3)
    assert STOCKED.crank_support == pytest.approx(15e-3 - 10.6e-3), "load centre, outer rings away from the discs"


def test_a_crank_bearing_in_stock_has_the_ratings_of_the_catalogue() -> None:
    ratings = crank_bearing_ratings(STOCKED)[1]
    assert (ratings.dynamic, ratings.static) == pytest.approx((24.6e3, 27.4e3))
    assert "C of NSK's catalogue: 32004 X" in rate(STOCKED.design).items["crank_tapers"].note
    stated = STOCKED.but(bearing={"shaft_dynamic_capacity": 30e3})
    assert crank_bearing_ratings(stated)[1].dynamic == 30e3


@pytest.mark.parametrize("name", ["rv80e", "rv64"])
def test_crank_bearings_of_presets_are_special_parts_with_required_ratings(name: str) -> None:
    reducer = RvReducer(PRESETS[name])
    assert reducer.crank_bearing is None
    ratings = crank_bearing_ratings(reducer)[1]
    line = re.search(r"^tapered_bearing,.*$", assembly_files(reducer, None)[BILL].decode(), re.MULTILINE)
    assert line
    assert "special, by drawing" in line[0]
    assert f"C at least {1e-3 * ratings.dynamic:.3g} kN; C0 at least {1e-3 * ratings.static:.3g} kN" in line[0]
    (check,) = (item for item in soundness(reducer) if item.name == "tapered_bearings")
    assert "(special, by drawing, " in check.why


def test_needles_are_rollers_in_stock_or_special() -> None:
    lines = {item.item: item for item in rv_bill(RV80E)}
    assert (lines["needle"].designation, lines["needle"].fit) == ("ISO 3096 - 5 x 15.8 - G2", "cut to 15 mm")
    odd = RV80E.but(cranks={"needle_radius": 2.452e-3})
    assert {item.item: item for item in rv_bill(odd)}["needle"].designation == "special, by drawing"


def test_the_summary_of_design_check_names_the_crank_bearing(capsys: pytest.CaptureFixture[str]) -> None:
    main(["design", "check", "rv80e"])
    assert "bearings of the cranks in the flanges: special, by drawing, 21 x 38 x 18 mm" in capsys.readouterr().out
