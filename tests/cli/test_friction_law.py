"""Results name the friction law that they were computed with."""

import json

import pytest

from cycloid_mj.analysis.findings import condition
from cycloid_mj.cli.app import main
from cycloid_mj.design import PRESETS, override
from cycloid_mj.reducer import Reducer

LAWS = {"coulomb": "Coulomb friction", "film": "film friction, lithium grease 100"}
"""Value of `friction.law` -> words in the results of `pin`."""


def output(capsys: pytest.CaptureFixture[str], command: str, law: str) -> str:
    """Return what a command prints as JSON for `pin` at a twentieth of its nominal torque."""
    assert main([*command.split(), "--set", f"friction.law={law}", "--json", "--quiet"]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("command", ["statics pin", "thermal pin --load-nm 2", "rate pin --load-nm 2"])
def test_results_name_their_friction_law(capsys: pytest.CaptureFixture[str], command: str, law: str) -> None:
    assert LAWS[law] in output(capsys, command, law)


@pytest.mark.parametrize("command", ["statics pin", "rate pin --load-nm 2"])
def test_results_name_the_temperature_of_the_parts(capsys: pytest.CaptureFixture[str], command: str) -> None:
    assert "60 °C" in json.loads(output(capsys, f"{command} --at-c 60", "film"))["condition"]


@pytest.mark.parametrize("command", ["statics pin", "rate pin --load-nm 2", "thermal pin --load-nm 2"])
def test_commands_warn_of_temperatures_outside_the_range_of_the_lubricant(
    capsys: pytest.CaptureFixture[str], command: str
) -> None:
    assert main([*command.split(), "--set", "friction.law=film", "--at-c", "-25"]) == 0
    err = " ".join(capsys.readouterr().err.split())
    assert err.count("temperatures outside the range of lithium grease 100, -20 to 100 °C: disc -25 °C") == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    ["wear pin --hours 1 --load-nm 2", "datasheet pin", "protocol pin", "reduce pin", "measure backlash pin --quick"],
)
def test_results_of_long_computations_name_the_temperature_of_the_parts(
    capsys: pytest.CaptureFixture[str], tmp_path_factory: pytest.TempPathFactory, command: str
) -> None:
    folder = str(tmp_path_factory.mktemp("warm"))
    assert "60 \\u00b0C" in output(capsys, f"{command} --at-c 60 --out {folder}", "coulomb")


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(
    "command",
    [
        "wear pin --hours 1 --load-nm 2",
        "datasheet pin",
        "protocol pin",
        "reduce pin",
        "measure torque pin --quick",
        "measure efficiency pin --quick",
    ],
)
def test_results_of_long_computations_name_their_friction_law(
    capsys: pytest.CaptureFixture[str], tmp_path_factory: pytest.TempPathFactory, command: str, law: str
) -> None:
    folder = str(tmp_path_factory.mktemp("law"))
    assert LAWS[law] in output(capsys, f"{command} --out {folder}", law)


@pytest.mark.parametrize(
    ("changes", "words"),
    [((), "36 N m, 1640 rpm"), (("friction.law=film",), "36 N m, 1640 rpm, film friction, lithium grease 100")],
)
def test_runs_name_their_friction_law(changes: tuple[str, ...], words: str) -> None:
    reducer = Reducer(override(PRESETS["pin"], ["load.torque_nm=36", *changes]))
    assert str(condition(reducer)) == words
    assert condition(reducer).as_json()["friction_law"] == reducer.design.friction.law
