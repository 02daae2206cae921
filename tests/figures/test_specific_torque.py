"""A figure is one function and one row: every command has it."""

import csv
import json
from pathlib import Path

import pytest

from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS
from cycloid_mj.figures import figure
from cycloid_mj.figures.geometry import mass
from cycloid_mj.life.datasheet import datasheet
from cycloid_mj.reducer import Reducer

KEY = "specific_torque_nm_per_kg"
PIN = Reducer(PRESETS["pin"])
VALUE = PIN.design.rated_torque / mass(PIN)


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_it_is_torque_over_mass() -> None:
    stronger = PIN.but(drive={"torque": 2.0 * PIN.design.drive.torque})
    assert figure(KEY).value(PIN) == pytest.approx(VALUE)
    assert figure(KEY).value(stronger) == pytest.approx(2.0 * VALUE)


def test_every_command_has_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def printed(*words: str) -> dict:
        capsys.readouterr()
        assert main([*words, "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    assert printed("figures")["figures"][KEY]["unit"] == "N m/kg"
    assert printed("statics", "pin")["figures"][KEY]["value"] == pytest.approx(VALUE)
    vary = ["--vary", "output.pins=6,8", "--workers", "1", "--quiet"]
    main(["sweep", "pin", *vary, "--measure", KEY, "--out", str(tmp_path / "sweep")])
    assert float(rows(tmp_path / "sweep" / "sweep.csv")[0][KEY]) > 0.0
    best = printed("optimize", "pin", *vary, "--maximize", KEY, "--quick", "--out", str(tmp_path / "best"))
    assert best["objective"] == max(float(row[KEY]) for row in rows(tmp_path / "best" / "history.csv"))
    limits = ["--limit", f"{KEY}>=1", "--set", 'tolerance.cam="uniform 1"', "--samples", "3", "--quiet"]
    found = printed("tolerance", "pin", *limits, "--out", str(tmp_path / "made"))
    assert found["quantities"][KEY]["mean"] == pytest.approx(VALUE, rel=1e-3)


@pytest.mark.slow
def test_the_data_sheet_has_it() -> None:
    assert datasheet(PIN).as_json()["figures"][KEY]["value"] == pytest.approx(VALUE)
