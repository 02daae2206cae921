"""Keys that follow those that vary: formulas, the rules of their own, and wrong wishes; sweep and optimize alike."""

import csv
from pathlib import Path

import pytest

from cycloid_mj.base.engine import Engine
from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, override, value_of
from cycloid_mj.explore.linked_keys import apply_links, parse_links
from cycloid_mj.explore.optimizer import optimize
from cycloid_mj.explore.sweeps import sweep
from cycloid_mj.reducer import Reducer

PIN = PRESETS["pin"]
HERE = Engine(1)
HOLE = "output.hole_radius_mm=output.pin_radius_mm+gear.eccentricity_mm"


def at(changes: dict[str, float], *given: str) -> dict[str, float]:
    """Values of the keys that follow at a point."""
    followers = parse_links(Reducer(PIN), given, changes)
    design = apply_links(Reducer(PIN), Reducer(override(PIN, changes)), followers)
    return {one.key: value_of(design, one.key) for one in followers}


@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("gear.eccentricity_mm + output.pin_radius_mm", 4.7),
        ("2 * (gear.eccentricity_mm - 0.2) + 3", 4.0),
        ("-gear.eccentricity_mm / 7 + 5", 4.9),
        ("ring.teeth - 30", 6.0),
        ("5.5", 5.5),
    ],
)
def test_a_formula_is_arithmetic_of_the_file(formula: str, value: float) -> None:
    found = at({"gear.eccentricity_mm": 0.7}, f"output.hole_radius_mm={formula}")
    assert found == {"output.hole_radius_mm": pytest.approx(value, rel=1e-12)}


def test_later_keys_depend_on_earlier_keys() -> None:
    found = at({"ring.teeth": 31}, "output.pins=(ring.teeth - 1) / 3", "output.pin_radius_mm=output.pins / 4")
    assert found == {"output.pins": 10, "output.pin_radius_mm": 2.5}


def test_two_keys_know_how_they_follow() -> None:
    """A hole keeps the room of the start, the drive's torque the rated torque on the output."""
    wide = override(PIN, {"output.hole_radius_mm": 5.3})
    (hole,) = parse_links(Reducer(wide), "output.hole_radius_mm", ["gear.eccentricity_mm"])
    assert value_of(
        hole.apply(Reducer(wide), Reducer(override(wide, {"gear.eccentricity_mm": 0.8}))), hole.key
    ) == pytest.approx(5.1)
    assert at({"ring.teeth": 31}, "drive.torque_nm")["drive.torque_nm"] == pytest.approx(PIN.rated_torque / 30.0)


def test_a_dependent_value_is_a_column_and_an_invalid_one_an_error() -> None:
    found = sweep(PIN, {"gear.eccentricity_mm": [0.8, 1.0, 1.1]}, "mass", follow=[HOLE], engine=HERE)
    assert found["output.hole_radius_mm"].tolist() == [4.8, 5.0, 5.1]
    assert found.frame.units["output.hole_radius_mm"] == "mm"
    assert "output.hole_radius_mm" not in found.quantities
    broken = sweep(
        PIN, {"gear.eccentricity_mm": [1.0]}, "mass", follow="output.pins=gear.eccentricity_mm / 3", engine=HERE
    )
    assert "output.pins" in broken["error"][0]
    with pytest.raises(DesignError, match=r"cannot be computed \(float division by zero\)"):
        at({"gear.eccentricity_mm": 1.0}, "output.hole_radius_mm=1 / (gear.eccentricity_mm - 1)")


def test_an_optimisation_takes_formulas_over_its_own_rules() -> None:
    vary, follow = {"ring.teeth": [35, 36], "gear.eccentricity_mm": [0.9]}, ["drive.torque_nm=1.048", HOLE]
    found = optimize(PIN, vary, "mass_kg", follow=follow, verify=False, engine=HERE)
    assert found.task.follows == {"drive.torque_nm": "1.048", "output.hole_radius_mm": HOLE.partition("=")[2]}
    best = found.design()
    assert best.drive.torque == 1.048
    assert best.output.hole_radius == pytest.approx(best.output.pin_radius + best.gear.eccentricity)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("output.pins", r"the formula is missing.*Give --follow 'output\.pins=FORMULA'"),
        ("output.hole_radius_mm=", "give KEY=FORMULA"),
        ("=1", "give KEY=FORMULA"),
        ("output.hole_radius_mm=gear.excentricity_mm", "did you mean gear.eccentricity_mm"),
        ("output.hole_radius=1", "did you mean output.hole_radius_mm"),
        ("output.hole_radius_mm=__import__('os')", "may contain only numbers, keys"),
        ("output.hole_radius_mm=2 +", "may contain only numbers, keys"),
        ("output.hole_radius_mm=output.hole_radius_mm + 1", "contains output.hole_radius_mm itself"),
        ("output.hole_radius_mm=ring.kind", r"ring\.kind is not a number"),
        ("output.hole_radius_mm=errors.pin_x_um", r"errors\.pin_x_um is not a number"),
        ("ring.kind=1", r"ring\.kind is not a number"),
        ("gear.eccentricity_mm=1", "is already set by --vary"),
    ],
)
def test_wrong_wishes_are_refused(given: str, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        parse_links(Reducer(PIN), given, ["gear.eccentricity_mm"])


def test_the_command_has_the_same_words(tmp_path: Path) -> None:
    words = ["sweep", "--vary", "gear.eccentricity_mm=0.8,1", "--follow", "output.hole_radius_mm", "--measure", "mass"]
    words += ["--set", "gear.face_width_mm=9"]  # without --design: of the preset pin
    assert main([*words, "--workers", "1", "--out", str(tmp_path), "--quiet"]) == 0
    with (tmp_path / "sweep.csv").open(encoding="utf-8") as stream:
        assert [row["output.hole_radius_mm"] for row in csv.DictReader(stream)] == ["4.8", "5.0"]
    other = [*words[:4], "output.hole_radius_mm=5", *words[5:], "--out", str(tmp_path), "--quiet"]
    assert main(other) == 2
