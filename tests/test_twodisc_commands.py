"""Every command that needs no simulation, on the preset with two discs."""

import json
from pathlib import Path

import pytest

from cycloid_mj.cli import main

COMMANDS = (
    ("design", "show", "twodisc"),
    ("design", "check", "twodisc"),
    ("statics", "--design", "twodisc"),
    ("tolerance", "--design", "twodisc", "--set", 'tolerance.cam="normal 0.5"', "--samples", "8"),
    ("rate", "--design", "twodisc"),
    ("kinematics", "--design", "twodisc", "--csv", "k.csv"),
    ("profile", "--design", "twodisc", "--csv", "p.csv"),
)


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: words[0] + "_" + words[1].strip("-"))
def test_a_static_command_takes_two_discs(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(list(words)) == 0
    assert "Traceback" not in capsys.readouterr().err


def test_statics_states_what_each_disc_carries(capsys: pytest.CaptureFixture[str]) -> None:
    held = ["--set", "structure=springs", "--set", "output.support=cantilever"]
    assert main(["statics", "--design", "twodisc", "--json"]) == 0
    even = json.loads(capsys.readouterr().out)["quantities"]
    assert main(["statics", "--design", "twodisc", *held, "--json"]) == 0
    uneven = json.loads(capsys.readouterr().out)["quantities"]
    assert even["disc_1_share"]["value"] == pytest.approx(0.5, rel=0.01)
    # from their roots beside disc 2 the pins give way to disc 1 far more
    assert uneven["disc_1_share"]["value"] < 0.4
    assert uneven["disc_1_share"]["value"] + uneven["disc_2_share"]["value"] == pytest.approx(1.0)
    assert uneven["stiffness_ideal"]["value"] < even["stiffness_ideal"]["value"]
    assert uneven["stiffness_contacts"]["value"] == pytest.approx(even["stiffness_contacts"]["value"])
    assert "output_bearing_far_force" not in uneven
