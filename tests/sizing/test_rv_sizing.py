"""RV reducers for a requirement."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.units import RPM
from cycloid_mj.checks import soundness
from cycloid_mj.cli import main
from cycloid_mj.design import load, stock
from cycloid_mj.geometry.rv import planet_misfit
from cycloid_mj.life import rate
from cycloid_mj.life.item import ItemKind
from cycloid_mj.reducer.rv_main_bearings import min_flange_thickness
from cycloid_mj.sizing import rv
from cycloid_mj.sizing.rv import DUTY_SHARE, RvRequirement, assemblies, candidates, rate_candidate


def _requirement(ratio: int, diameter: float, torque: float) -> RvRequirement:
    return RvRequirement(ratio=ratio, diameter=diameter, torque=torque, speed=15.0 * ratio * RPM, duty_share=DUTY_SHARE)


@pytest.mark.parametrize("cranks", [2, 3])
def test_assemblies_have_the_ratio_and_close(cranks: int) -> None:
    found = list(assemblies(153, cranks))
    assert (10, 38, 40) in found
    for sun, planet, ring in found:
        assert 1 + ring * planet / sun == 153
        assert planet_misfit(sun, planet, cranks) == 0


def test_candidates_have_the_ratio_and_diameter_and_come_by_length() -> None:
    pool = list(candidates(_requirement(121, 0.16, 412.0)))
    lengths = [item.length for item in pool]
    assert lengths == sorted(lengths)
    assert {item.reducer.design.reduction for item in pool} == {121.0}
    assert {item.reducer.design.housing.outer_radius for item in pool} == {0.08}
    assert list(candidates(_requirement(121, 0.16, 412.0).but(length=0.05))) == []


def test_candidates_with_main_bearings_have_flanges_for_their_seats() -> None:
    changes = ("cranks.main_bearings=angular_contact",)
    pool = list(candidates(_requirement(121, 0.16, 412.0).but(changes=changes)))
    plain = min(item.length for item in candidates(_requirement(121, 0.16, 412.0)))
    assert len(pool) > 100
    for candidate in pool[::100]:
        reducer = candidate.reducer
        assert reducer.main_bearing is not None
        assert reducer.cranks.flange_thickness >= min_flange_thickness(reducer, reducer.main_bearing) - 1e-9
        assert candidate.length > plain
    thin = (*changes, "cranks.flange_thickness_mm=10")
    assert {
        item.reducer.cranks.flange_thickness for item in candidates(_requirement(121, 0.16, 412.0).but(changes=thin))
    } == {0.01}, "a required value is kept"


def test_an_estimate_is_that_of_the_rating_with_ideal_sharing() -> None:
    """Where crank bearings fail first, both have the forces of ideal sharing."""
    weak = ("bearing.shaft_dynamic_capacity_n=12000", "bearing.shaft_static_capacity_n=20000")
    requirement = _requirement(121, 0.16, 412.0).but(changes=weak)
    candidate = max(list(candidates(requirement))[::60], key=lambda item: item.estimate)
    rated = rate_candidate(requirement, candidate)
    assert rated
    assert rated.weakest.key == "crank_tapers"
    assert rated.torque == pytest.approx(candidate.estimate, rel=2e-3)
    assert rated.momentary >= 2.0 * rated.torque


@pytest.mark.parametrize("diameter", [0.145, 0.222, 0.325])
def test_crank_bearings_and_needles_are_in_stock(diameter: float) -> None:
    for candidate in candidates(_requirement(121, diameter, 167.0))[::40]:
        reducer = candidate.reducer
        assert reducer.crank_bearing in stock.crank_bearings()
        assert 2.0 * reducer.cranks.needle_radius in stock.needle_diameters()
        failures = {item.name for item in soundness(reducer) if item.severity == "error" and not item.passed}
        assert failures <= {"sun_teeth", "planet_teeth"}, "walls and flanges have room for the bearings"


def test_drives_too_small_for_crank_bearings_in_stock_have_special_bearings() -> None:
    pool = candidates(_requirement(121, 0.08, 10.0))
    assert pool
    assert {item.reducer.crank_bearing for item in pool} == {None}
    assert pool[0].reducer.crank_bearing_text.startswith("special, by drawing, ")


def test_a_ratio_that_no_teeth_have_is_refused() -> None:
    with pytest.raises(UsageError, match="from 31 to 321 for an RV reducer"):
        _requirement(400, 0.2, 100.0)


def test_flags_without_use_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["design", "new", "my", "--layout", "rv", "--ratio", "121", "--diameter-mm", "160", "--torque-nm", "412"]
    assert main([*words, "--backlash-arcmin", "1"]) == 2
    assert "--layout rv does not support --backlash-arcmin" in capsys.readouterr().err


def test_heat_limits_a_candidate_under_continuous_load() -> None:
    requirement = _requirement(121, 0.16, 412.0).but(changes=("friction.law=coulomb",))
    candidate = next(item for item in candidates(requirement) if item.estimate > 412.0)
    paused = rate_candidate(requirement, candidate)
    continuous = requirement.but(duty_share=1.0)
    sizes = candidate.reducer.but(service={"duty_share": 1.0})
    heated = rate_candidate(continuous, replace(candidate, reducer=sizes, requirement=continuous))
    assert paused
    assert heated
    assert heated.weakest.key == "temperature"
    assert heated.torque < 412.0 < paused.torque


@pytest.mark.slow
def test_a_sized_drive_passes_its_rating_and_a_smaller_one_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["design", "new", "my", "--layout", "rv", "--ratio", "121", "--torque-nm", "412", "--json"]
    assert main([*words, "--diameter-mm", "160"]) == 0
    drive = json.loads(capsys.readouterr().out)["designs"][0]
    assert set(drive) == {"file", "title", "figures", "why", "reasons"}
    design = load(Path(drive["file"]))
    assert design.ratio == 121
    assert not rate(design).failing
    assert drive["figures"]["rated_torque_nm"] >= 412.0
    assert 3.0 < drive["figures"]["mass_kg"] < 9.3, "the RV-40E of the catalogue weighs 9.3 kg"
    assert main(["design", "check", drive["file"]]) == 0
    capsys.readouterr()
    assert main([*words, "--diameter-mm", "110", "--force"]) == 1
    refusal = json.loads(capsys.readouterr().out)
    assert set(refusal) >= {"most", "limit", "ways", "why"}
    assert 0.0 < refusal["most"] < 412.0
    assert refusal["ways"][-1]["flags"][0] == "--diameter-mm"
    dry = ["--set", "friction.law=coulomb"]  # with film friction, the pins roll, and the drive stays cool enough
    assert main([*words, "--diameter-mm", "160", "--duty", "1", "--force", *dry]) == 1
    flags = [way["flags"] for way in json.loads(capsys.readouterr().out)["ways"]]
    assert [item[0] for item in flags] == ["--duty", "--cooling", "--diameter-mm"]


def test_remedies_start_where_the_torque_suffices_by_similarity(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of the required torque at full duty: half the duty, 1.26 times the diameter, or the life that was rated."""
    monkeypatch.setattr(rv, "_is_feasible", lambda requirement: True)
    requirement = _requirement(121, 0.16, 412.0).but(duty_share=1.0)

    def words(kind: ItemKind, life: float | None) -> list[str]:
        weakest, rating = SimpleNamespace(kind=kind, life=life), SimpleNamespace(shortest_life=3000.0)
        drive = SimpleNamespace(torque=206.0, weakest=weakest, rating=rating)
        return [remedy.words for remedy in rv._remedies(requirement, drive)]

    assert words(ItemKind.HEAT, None) == ["a duty of 0.494 of the time", "cooling: mounted", "202 mm"]
    assert words(ItemKind.BEARING, 3000.0) == ["a life of 2960 h", "202 mm"]
    assert words(ItemKind.BEARING, None) == ["202 mm"]
    assert [remedy.words for remedy in rv._remedies(requirement, None)] == ["166 mm"]
    shortest = SimpleNamespace(candidate=SimpleNamespace(length=64.46e-3))
    monkeypatch.setattr(rv, "_search_shortest", lambda any_length, pool: (shortest, shortest))
    longer, _ = rv._remedies(requirement.but(length=0.06), None)
    assert longer.requirement.length == pytest.approx(64.5e-3)
    assert longer.words == "a length of 64.5 mm"
    answer = rv.size_rv(requirement.but(length=0.05))
    assert answer.limit.startswith("no drive is shorter than ")
    assert [remedy.words for remedy in answer.remedies] == ["a length of 64.5 mm", "166 mm"]
