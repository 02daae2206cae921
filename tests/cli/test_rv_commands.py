"""Commands on an RV reducer: figures of those that support it, and one sentence from all others."""

import json
import math
from pathlib import Path

import pytest

from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, load


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("command", ["profile", "kinematics"])
def test_ideal_profile_and_motion_of_the_discs(command: str) -> None:
    assert main(["design", command, "rv80e", "--csv", "out.csv", "--quiet"]) == 0
    header, *rows = Path("out.csv").read_text().splitlines()
    first = dict(zip(header.split(","), map(float, rows[0].split(",")), strict=True))
    if command == "profile":
        # a valley on +y: the pin circle less eccentricity and pin radius
        assert (first["x_mm"], first["y_mm"]) == (pytest.approx(0.0, abs=1e-9), pytest.approx(72.0))
        return
    assert first["y_mm"] == pytest.approx(42.0)
    last = dict(zip(header.split(","), map(float, rows[-1].split(",")), strict=True))
    # the cranks turn 39/153 as fast as the sun, against it; the ramp takes 0.1 s, the hold 0.4 s
    assert last["crank_rad"] == pytest.approx(-39.0 * 2.0 * math.pi * 0.25 * 0.45, rel=1e-3)


def test_export_writes_the_parts(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "rv80e", "--format", "svg", "--chord-error-um", "20", "--out", "parts", "--quiet"]) == 0
    assert {path.stem for path in Path("parts").glob("*.svg")} >= {"gear_1", "crank", "planet", "sun", "carrier_2"}
    assert main(["export", "rv80e", "--plate", "--out", "plate"]) == 2
    refusal = capsys.readouterr().err
    assert '--plate does not support layout = "rv" (rv80e)' in refusal
    assert "Use --format stl without --plate" in refusal
    assert main(["export", "rv80e", "--format", "stl", "--motor", "nema17"]) == 2
    assert "an RV reducer has neither a motor flange nor covers" in capsys.readouterr().err


def test_checks_are_json_values(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["design", "check", "rv64", "--json"]) == 0
    checks = json.loads(capsys.readouterr().out)["checks"]
    assert next(check for check in checks if check["name"] == "momentary_torque")["passed"] is True


def test_statics_has_the_figures_of_the_rv80e(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["statics", "--design", "rv80e", "--load-nm", "784", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)["figures"]
    assert figures["ratio"]["value"] == pytest.approx(153.0, rel=1e-9)
    assert figures["crank_bearing_force_n"]["value"] == pytest.approx(5333.0, rel=1e-3)
    assert figures["crank_bearing_mean_force_n"]["value"] == pytest.approx(4083.0, rel=1e-3)
    assert figures["stiffness_nm_per_arcmin"]["value"] == pytest.approx(208.0, rel=2e-3)


def test_planets_that_miss_their_mesh_are_refused_with_the_nearest_that_close(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["design", "check", "rv80e", "--set", "planet.sun_teeth=12"]) == 1
    told = " ".join(capsys.readouterr().out.split())
    assert "miss the sun's by 1/3 of a pitch; set planet.planet_teeth to 39 or 36" in told
    assert main(["statics", "rv80e", "--set", "planet.sun_teeth=12"]) == 1
    assert "set planet.planet_teeth to 39 or 36" in capsys.readouterr().err


@pytest.mark.parametrize(("teeth", "word"), [(53, "ok"), (62, "FAIL")])
def test_tips_of_neighbouring_planets_are_those_of_shifted_profiles(
    teeth: int, word: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """With 53 teeth, tips of a module above the pitch circles would meet; the profile shift lowers them."""
    circle = math.sin(math.pi / 3.0) * 1.75 * (10 + teeth) / 2.0
    assert 1.75 * (teeth / 2.0 + 1.0) > circle
    main(["design", "check", "rv80e", "--set", f"planet.planet_teeth={teeth}", "--all"])
    lines = [line for line in capsys.readouterr().out.splitlines() if "planets_apart" in line]
    assert lines[0].startswith(word)


def test_a_copy_of_the_preset_is_the_preset() -> None:
    assert main(["design", "new", "mine", "--from", "rv80e"]) == 0
    assert load(Path("mine.toml")).but(name="rv80e") == PRESETS["rv80e"]
    text = Path("mine.toml").read_text()
    assert "[shaft]" not in text
    assert "\nhole_radius_mm" not in text


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("output.pins=4", 'layout = "rv" has no use for output.pins'),
        ("cranks.count=4", "it must be from 2 to 3"),
        ("crank_errors.bore_x_um=[1.0]", "cranks.count times gear.discs is 6"),
        ("friction.cam=0.1", 'layout = "rv" has no use for friction.cam'),
    ],
)
def test_values_that_the_layout_has_no_use_for_are_refused(
    change: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["design", "show", "rv80e", "--set", change]) == 2
    assert told in capsys.readouterr().err
    assert main(["design", "show", "pin", "--set", "cranks.count=3"]) == 2
    assert 'or set layout = "rv"' in capsys.readouterr().err
