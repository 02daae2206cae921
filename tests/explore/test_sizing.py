"""A design from ratio, diameter and torque: sound, as large and as strong as asked for, and with its reasons."""

import math
from pathlib import Path

import pytest
from designs import cases

from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.cli import main
from cycloid_mj.design import load, loads
from cycloid_mj.design.file import dump
from cycloid_mj.explore.sizing import MARGIN, Process, sized
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import are_one_part
from cycloid_mj.statics.sheet import sheet

CASES = [
    (5, 0.1, 10.0, "steel"),
    (20, 0.06, 10.0, "steel"),
    (35, 0.3, 540.0, "steel"),
    (60, 0.1, 20.0, "steel"),
    (12, 0.08, 1.0, "printed"),
    (20, 0.15, 3.0, "printed"),
]


@pytest.mark.parametrize(("ratio", "diameter", "torque", "process"), CASES)
def test_it_is_what_was_asked_for_and_passes_its_checks(
    ratio: int, diameter: float, torque: float, process: Process
) -> None:
    found = sized("mine", ratio, diameter, torque, process)
    design = found.design
    assert design.lobes == ratio
    assert 2.0 * design.housing.outer_radius == pytest.approx(diameter)
    assert design.rated_torque == pytest.approx(torque)
    assert all(item.passed for item in found.checks if item.severity == "error")
    pressures = [item for item in found.checks if item.name in ("tooth_yield", "output_yield", "cam_yield")]
    assert len(pressures) == 3
    assert all(MARGIN * item.value <= item.bound for item in pressures if item.value and item.bound)
    assert all(key.partition(".")[0] in type(design).model_fields for key in found.reasons)


@pytest.mark.slow
def test_more_torque_takes_a_wider_gear_up_to_a_limit() -> None:
    widths = [sized("mine", 20, 0.06, torque).design.gear.face_width for torque in (8.0, 12.0, 18.0)]
    assert widths == sorted(set(widths))
    with pytest.raises(UsageError, match=r"1000 N m are too much for a diameter of 60 mm.*larger diameter"):
        sized("mine", 20, 0.06, 1000.0)


@pytest.mark.parametrize(
    ("ratio", "diameter", "torque", "message"),
    [
        (2, 0.1, 1.0, "the ratio is 2; one stage of pins has from 3 to 119"),
        (20, -0.1, 1.0, "the diameter is -100 mm"),
        (20, 0.1, 0.0, "the torque is 0 N m"),
        (20, math.inf, 1.0, "the diameter is inf mm"),
    ],
)
def test_absurd_sizes_are_refused(ratio: int, diameter: float, torque: float, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        sized("mine", ratio, diameter, torque)


def test_no_room_for_a_gear_is_said() -> None:
    with pytest.raises(DesignError, match="no gear with a ratio of 119 fits into 20 mm"):
        sized("mine", 119, 0.02, 0.1, "printed")


def test_the_file_has_each_reason_beside_its_value() -> None:
    found = sized("mine", 20, 0.06, 10.0)
    text = dump(found.design, found.reasons)
    assert loads(text) == found.design
    for reason in found.reasons.values():
        assert text.count(f"({reason})") == 1


def test_the_command_writes_a_file_and_states_what_it_carries(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    asked = ["--ratio", "20", "--diameter-mm", "60", "--torque-nm", "10"]
    assert main(["design", "new", "mine", *asked, "--set", "clearance.cam_um=3"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("mine.toml\n")
    assert "at the rated 10 N m" in out
    assert "backlash" in out
    assert load(tmp_path / "mine.toml").clearance.cam == 3e-6


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--ratio", "20"], "--diameter-mm and --torque-nm is missing"),
        (["--from", "pin", "--ratio", "20", "--diameter-mm", "60", "--torque-nm", "1"], "leave one of them out"),
        (["--ratio", "20", "--diameter-mm", "60", "--torque-nm", "1", "--process", "wood"], "steel"),
    ],
)
def test_the_command_says_what_is_missing(tmp_path: Path, monkeypatch, capsys, flags: list[str], message: str) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["design", "new", "mine", *flags]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "mine.toml").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ratio", "discs", "process"),
    cases([(29, 2, "steel"), (20, 3, "steel"), (15, 2, "printed")], (29, 2, "steel")),
)
def test_several_discs_share_the_width_and_pass_every_check(ratio: int, discs: int, process: Process) -> None:
    torque, diameter = (20.0, 0.08) if process == "steel" else (1.0, 0.1)
    found = sized("mine", ratio, diameter, torque, process, discs)
    assert all(item.passed or item.severity == "warning" for item in found.checks)
    assert found.design.gear.discs == discs
    assert found.design.structure == "springs"
    assert are_one_part(discs, found.design.output.pins, ratio)
    assert found.design.output.support == "both_ends"
    assert loads(dump(found.design, found.reasons)).gear == found.design.gear
    value = sheet(Reducer(found.design)).quantities
    for disc in range(1, discs + 1):
        assert value[f"disc_{disc}_share"].value == pytest.approx(1.0 / discs, rel=0.15)
    if discs == 2:
        assert found.design.gear.face_width < sized("mine", ratio, diameter, torque, process).design.gear.face_width


@pytest.mark.parametrize("discs", [0, 5])
def test_a_crank_has_one_to_four_discs(discs: int) -> None:
    with pytest.raises(UsageError, match="a crank has from 1 to 4"):
        sized("mine", 20, 0.06, 5.0, discs=discs)
