"""Drawings of RV reducers: parts, fits, teeth and files."""

import math
from pathlib import Path

import ezdxf
import pytest

from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, resolve
from cycloid_mj.geometry.involute import InvoluteGear, span_measurement
from cycloid_mj.parts.export.rv_drawing import rv_part_drawings
from cycloid_mj.reducer import RvReducer

RV80E = RvReducer(PRESETS["rv80e"])


def involute_gear(teeth: int, shift: float = 0.0, thinning: float = 0.0) -> InvoluteGear:
    """Return a gear of module 1 mm with a pressure angle of 20 deg."""
    return InvoluteGear(teeth, 1e-3, math.radians(20.0), shift, 1e-3 * (teeth / 2.0 + 1.0 + shift), thinning)


@pytest.mark.parametrize(("teeth", "count", "span"), [(20, 3, 7.6604), (38, 5, 13.8168), (100, 12, 35.3501)])
def test_spans_are_those_of_tables_for_module_1(teeth: int, count: int, span: float) -> None:
    """Tables of the base tangent length for 20 deg and no profile shift, in mm."""
    assert span_measurement(involute_gear(teeth)) == (count, pytest.approx(1e-3 * span, abs=1e-7))


def test_a_profile_shift_increases_a_span_and_backlash_decreases_it() -> None:
    _, plain = span_measurement(involute_gear(20))
    _, shifted = span_measurement(involute_gear(20, shift=0.1))
    _, thinned = span_measurement(involute_gear(20, thinning=1e-5))
    assert shifted - plain == pytest.approx(2.0 * 0.1 * 1e-3 * math.sin(math.radians(20.0)))
    assert plain - thinned == pytest.approx(1e-5 * math.cos(math.radians(20.0)))


def test_limits_are_those_of_the_tolerance_study_and_angles_have_no_rounding_errors() -> None:
    changes = {"crank_tolerance.eccentricity": "normal 1", "crank_tolerance.bore_position": "uniform 4"}
    drawings = {item.name: item for item in rv_part_drawings(RvReducer(resolve(PRESETS["rv80e"], changes)))}
    assert any("± 0.003" in item.text for item in drawings["crank"].diameters)
    assert any("position ⌀0.008 to A" in note for note in drawings["gear_1"].notes)
    assert any("position ⌀0.01 to A" in note for note in drawings["carrier_1"].notes)
    assert not any("e-" in note for item in drawings.values() for note in item.notes)


def test_each_made_part_has_a_drawing_with_its_count_and_fits() -> None:
    drawings = {item.name: item for item in rv_part_drawings(RV80E)}
    assert list(drawings) == ["housing", "gear_1", "gear_2", "crank", "planet", "sun", "carrier_1", "carrier_2"]
    assert drawings["crank"].title[1].startswith("3 off")
    diameters = [item.text for item in drawings["crank"].diameters]
    assert diameters[0].startswith("⌀21 k6")
    assert [text.startswith("⌀24 h5") and "eccentric by 1.5000" in text for text in diameters[1:]] == [True, True]
    assert any(note.startswith("3 x ⌀34 G6 on ⌀84") for note in drawings["gear_1"].notes)
    assert any(note.startswith("3 x ⌀38 H7 on ⌀84") for note in drawings["carrier_2"].notes)
    assert any("z = 38, m = 1.75" in note for note in drawings["planet"].notes)
    assert max(item.high for item in drawings["crank"].lengths) - drawings["crank"].lengths[0].low == pytest.approx(
        83e-3
    )


def test_the_command_writes_a_pdf_and_a_dxf_of_each_part(tmp_path: Path) -> None:
    assert main(["export", "--design", "rv80e", "--drawings", "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out" / "drawings.pdf").read_bytes().startswith(b"%PDF")
    document = ezdxf.readfile(tmp_path / "out" / "crank-drawing.dxf")
    assert {"section", "front", "dimensions", "text"} <= {entity.dxf.layer for entity in document.modelspace()}
