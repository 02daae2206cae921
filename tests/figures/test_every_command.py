"""A figure is one function and one row: every command has it."""

import csv
import json
from pathlib import Path

import pytest

from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS
from cycloid_mj.design.model import NO_FRICTION
from cycloid_mj.figures import figure
from cycloid_mj.figures.geometry import mass
from cycloid_mj.life.datasheet import datasheet
from cycloid_mj.reducer import Reducer

PIN = Reducer(PRESETS["pin"])
SPECIFIC, NO_LOAD = "specific_torque_nm_per_kg", "no_load_torque_nm"
VALUES = {key: figure(key).value(PIN) for key in (SPECIFIC, NO_LOAD)}


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_specific_torque_is_torque_over_mass() -> None:
    stronger = PIN.but(drive={"torque": 2.0 * PIN.design.drive.torque})
    assert VALUES[SPECIFIC] == pytest.approx(PIN.design.rated_torque / mass(PIN))
    assert figure(SPECIFIC).value(stronger) == pytest.approx(2.0 * VALUES[SPECIFIC])


def test_no_load_torque_is_that_of_the_drag_where_nothing_rubs() -> None:
    """Of a light drive in oil with smooth contacts, the crank feels the seals alone."""
    oiled = PIN.but(friction=NO_FRICTION, drag={"crank": 1e-4, "output": 0.07})
    drag = oiled.design.drag
    expected = drag.crank + drag.output / oiled.design.reduction
    assert figure(NO_LOAD).value(oiled) == pytest.approx(expected, rel=1e-9)


def test_no_load_torque_grows_with_the_square_of_a_high_speed() -> None:
    """Centrifugal force presses the discs, and nothing else does."""
    slow, fast = (PIN.but(drive={"speed": factor * PIN.design.drive.speed}) for factor in (4.0, 8.0))
    assert figure(NO_LOAD).value(fast) == pytest.approx(4.0 * figure(NO_LOAD).value(slow), rel=0.1)


@pytest.mark.parametrize("key", [SPECIFIC, NO_LOAD])
def test_every_command_has_it(key: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def printed(*words: str) -> dict:
        capsys.readouterr()
        assert main([*words, "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    assert printed("figures")["figures"][key]["unit"] == figure(key).unit
    assert printed("statics", "pin")["figures"][key]["value"] == pytest.approx(VALUES[key])
    vary = ["--vary", "output.pins=6,8", "--workers", "1", "--quiet"]
    main(["sweep", "pin", *vary, "--measure", key, "--out", str(tmp_path / "sweep")])
    assert float(rows(tmp_path / "sweep" / "sweep.csv")[0][key]) > 0.0
    best = printed("optimize", "pin", *vary, "--maximize", key, "--quick", "--out", str(tmp_path / "best"))
    assert best["objective"] == max(float(row[key]) for row in rows(tmp_path / "best" / "history.csv"))
    limits = ["--limit", f"{key}>=0", "--set", 'tolerance.cam="uniform 1"', "--samples", "3", "--quiet"]
    made = printed("tolerance", "pin", *limits, "--out", str(tmp_path / "made"))
    assert made["quantities"][key]["mean"] == pytest.approx(VALUES[key], rel=0.1)


@pytest.mark.slow
def test_the_data_sheet_has_them() -> None:
    figures = datasheet(PIN).as_json()["figures"]
    assert {key: figures[key]["value"] for key in VALUES} == pytest.approx(VALUES)
