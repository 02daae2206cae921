"""Results name the friction law that they were computed with."""

import pytest

from cycloid_mj.cli.app import main

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
        "simulate pin",
    ],
)
def test_results_of_long_computations_name_their_friction_law(
    capsys: pytest.CaptureFixture[str], tmp_path_factory: pytest.TempPathFactory, command: str, law: str
) -> None:
    folder = str(tmp_path_factory.mktemp("law"))
    assert LAWS[law] in output(capsys, f"{command} --out {folder}", law)
