"""Where the load of a sheet is from, and what it says of the structure."""

import json

import pytest

from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, override
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet import load_of, sheet


def test_the_load_is_the_given_the_designs_or_the_rated_torque(capsys: pytest.CaptureFixture[str]) -> None:
    pin = PRESETS["pin"]
    assert load_of(Reducer(pin)) == (pin.rated_torque, "rated torque")
    assert load_of(Reducer(override(pin, ["load.torque_nm=-7"]))) == (7.0, "load.torque_nm")
    assert load_of(Reducer(override(pin, ["load.torque_nm=-7"])), 3.0) == (3.0, "given")
    assert main(["statics", "--design", "pin", "--set", "load.torque_nm=7", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["load_source"] == "load.torque_nm"
    assert told["condition"].startswith("7 N m")


def test_compliant_parts_are_not_called_rigid() -> None:
    found = sheet(Reducer(override(PRESETS["pin"], ["structure=springs"])))
    assert found.assumptions[0].startswith("statics: output pins, carrier, shaft and housing are elastic")
    assert sheet(Reducer(PRESETS["pin"])).assumptions[0].startswith("statics: parts are rigid")
