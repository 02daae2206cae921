"""The commands on a drive with two discs, whichever member turns, and the short ones on other kinds of drives."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from designs import design_file

from cycloid_mj.cli import main
from cycloid_mj.explore.budget import SobolSettings

STATIC = (
    ("design", "show", "{name}"),
    ("design", "check", "{name}"),
    ("design", "new", "mine", "--from", "{name}"),
    ("statics", "--design", "{name}"),
    ("tolerance", "--design", "{name}", "--set", 'tolerance.cam="normal 0.5"', "--samples", "4"),
    ("rate", "--design", "{name}", "--html", "rate.html"),
    ("thermal", "--design", "{name}", "--out", "heat"),
    ("wear", "--design", "{name}", "--hours", "1", "--out", "wear"),
    ("design", "kinematics", "--design", "{name}", "--until-s", "0.01", "--csv", "k.csv"),
    ("design", "profile", "--design", "{name}", "--csv", "p.csv"),
    ("design", "profile", "--design", "{name}", "--part", "curvature", "--points", "4", "--csv", "p.csv"),
    ("export", "--design", "{name}", "--format", "dxf", "--out", "parts"),
)
OF_A_LOG = (
    ("analyze", "{log}"),
    ("log", "plot", "{log}"),
    ("report", "{log}"),
    ("animate", "{log}", "film.gif", "--frames", "1", "--width", "320"),
    ("log", "info", "{log}"),
    ("log", "columns", "{log}"),
    ("log", "csv", "{log}", "run.csv", "--columns", "crank_angle"),
    ("log", "layout", "{log}"),
    ("log", "repair", "{log}", "again.mcap"),
)
SEARCH = ("--vary", "clearance.cam_um=5:12", "--minimize", "backlash_max", "--evaluations", "6")
MEASURES = ("te", "backlash", "lost-motion", "loads", "efficiency", "vibration")
SLOW = (
    ("datasheet", "--design", "{name}", "--out", "sheet"),
    ("reduce", "--design", "{name}", "--out", "joint"),
    ("build", "--design", "{name}", "--out", "model"),
    ("export", "--design", "{name}", "--format", "stl", "--out", "parts"),
    ("export", "--design", "{name}", "--format", "obj", "--out", "parts"),
    ("sweep", "--design", "{name}", "--vary", "clearance.cam_um=5,20", "--out", "sweep", "--workers", "1"),
    ("export", "--design", "{name}", "--format", "step", "--plate", "--out", "parts"),
    ("optimize", "--design", "{name}", *SEARCH, "--quick", "--workers", "1", "--out", "best"),
    ("stress", "--design", "{name}", "--quick", "--part", "output", "--out", "stress"),
    *(("measure", one, "--design", "{name}", "--quick") for one in MEASURES),
    ("measure", "torque", "{name}", "--quick"),
)
RING_TURNS = ("--set", "output.member=ring")
NONSENSE = re.compile(r"\b(nan|inf|None)\b")
"""What no command prints where a number belongs."""


@pytest.fixture
def call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Call a command in a folder of its own, and give what it printed."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cycloid_mj.explore.budget.SOBOL", SobolSettings(min_samples=16, min_drawn=16, max_samples=16))

    def called(words: tuple[str, ...], **filling: str) -> str:
        assert main([word.format(**filling) if "{" in word else word for word in words]) == 0
        found = capsys.readouterr()
        assert "Traceback" not in found.err
        assert not NONSENSE.search(found.out), found.out
        return found.out

    return called


@pytest.mark.parametrize("words", STATIC, ids=lambda words: "_".join(words[:2]))
def test_a_static_command_takes_two_discs(words: tuple[str, ...], call: Callable[..., str]) -> None:
    call(words, name="twodisc")


@pytest.mark.slow
@pytest.mark.parametrize("words", SLOW, ids=lambda words: "_".join(words[:2]))
def test_a_long_command_takes_two_discs_whose_ring_turns(words: tuple[str, ...], call: Callable[..., str]) -> None:
    call((*words, *RING_TURNS), name="twodisc")


@pytest.mark.slow
@pytest.mark.parametrize(("name", "change"), [("light", ()), ("large", RING_TURNS)], ids=["internal gear", "sleeves"])
@pytest.mark.parametrize("words", STATIC, ids=lambda words: "_".join(words[:2]))
def test_a_static_command_takes_other_designs(
    words: tuple[str, ...], name: str, change: tuple[str, ...], call: Callable[..., str]
) -> None:
    call((*words, *change), name=str(design_file(name)))


@pytest.mark.slow
def test_two_logs_of_several_discs_are_compared(log: str, call: Callable[..., str]) -> None:
    wide = (
        "--set",
        "name=wide",
        "--set",
        "clearance.cam_um=15",
        "--ramp-s",
        "0",
        "--hold-s",
        "0.03",
        "--load-nm",
        "10",
    )
    call(("simulate", "--design", "twodisc", *wide, "--out", "runs"))
    found = call(("compare", "{log}", "runs/wide.mcap", "--all", "--out", "side"), log=log)
    assert "disc and q of disc 1" in " ".join(found.split())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["twodisc", "printed"])
def test_vibration_depends_on_the_counterweight(name: str, call: Callable[..., str]) -> None:
    found = json.loads(call(("measure", "vibration", "--design", "{name}", "--quick", "--json"), name=name))
    balanced = [key for key, one in found["quantities"].items() if "counterweight" in one["name"]]
    assert bool(balanced) == (name == "printed")
    assert found["quantities"]["housing_rotating"]["reference"] == pytest.approx(0.0, abs=1e-6)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Run the drive with two discs for a moment, once, and return its log."""
    folder = tmp_path_factory.mktemp("logs")
    run = ["simulate", "--design", "twodisc", "--ramp-s", "0", "--hold-s", "0.03", "--load-nm", "10"]
    assert main([*run, "--out", str(folder), "--quiet"]) == 0
    return str(folder / "twodisc.mcap")


@pytest.mark.parametrize("words", OF_A_LOG, ids=lambda words: "_".join(words[:2]).replace("{", "").replace("}", ""))
def test_a_command_takes_a_log_of_two_discs(words: tuple[str, ...], log: str, call: Callable[..., str]) -> None:
    call(words, log=log)


def test_a_viewer_without_a_display_is_reported_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for variable in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(variable, raising=False)
    assert main(["view", "twodisc"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_the_parts_of_a_compliance_add_up_to_it(member: str, capsys: pytest.CaptureFixture[str]) -> None:
    """With all that bends and twists to the drive's; without, nearly to that of contacts alone: pins that bend share
    the load otherwise.
    """
    assert main(["statics", "--design", "printed", "--set", f"output.member={member}", "--json"]) == 0
    found = {key: one["value"] for key, one in json.loads(capsys.readouterr().out)["quantities"].items()}
    contacts = sum(found[f"compliance_{part}"] for part in ("output", "cam", "mesh"))
    structure = sum(found[f"compliance_{part}"] for part in ("bending", "carrier", "shaft", "housing"))
    # the mean of a stiffness over the turn is not quite the inverse of the mean compliance
    assert contacts * found["stiffness_contacts"] == pytest.approx(1.0, rel=0.035)
    assert (contacts + structure) * found["stiffness_ideal"] == pytest.approx(1.0, rel=5e-3)


@pytest.mark.slow
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
