"""The doctor finds a sound installation sound, and says what to do about one that is not."""

import json
import tomllib
from pathlib import Path

import mujoco
import pytest

from cycloid_mj.base.errors import ContactError
from cycloid_mj.cli import doctor, main

PROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"


def test_a_sound_installation(capsys) -> None:
    assert main(["doctor", "--json"]) == 0
    findings = {one["name"]: one for one in json.loads(capsys.readouterr().out)["findings"]}
    assert findings["contact and simulation"]["well"]
    assert findings["mujoco"]["found"] == mujoco.__version__
    assert findings["self-test of MuJoCo"]["well"]
    assert f"release {mujoco.__version__} passes" in findings["self-test of MuJoCo"]["found"]
    offered = tomllib.loads(PROJECT.read_text())["project"]["optional-dependencies"]
    assert set(doctor.EXTRAS) == set(offered) - {"docs", "test"}
    assert set(doctor.NEEDED) <= set(findings)
    assert {f"extra {name}" for name in doctor.EXTRAS} <= set(findings)


@pytest.mark.slow
def test_missing_components_are_reported_with_remedies(capsys, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> str:
        raise ContactError("MuJoCo 9.9 is not one that was tested: pip install another")

    monkeypatch.setattr(doctor, "NEEDED", ("numpy", "no-such-package"))
    monkeypatch.setattr(doctor, "_simulate_self_test", broken)
    monkeypatch.setattr(doctor, "EXTRAS", {"cad": ("no_such_module",)})
    assert main(["doctor"]) == 1
    out = capsys.readouterr().out
    assert "FAIL  no-such-package: not installed: pip install no-such-package" in out
    assert "FAIL  contact and simulation: MuJoCo 9.9" in out
    assert "none  extra cad: missing no_such_module: pip install 'cycloid-mj[cad]'" in out


@pytest.mark.slow
def test_a_gear_off_its_closed_form_is_a_failure(capsys, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "MOST_ERROR", 0.0)
    assert main(["doctor"]) == 1
    assert "from its closed-form value" in capsys.readouterr().out
