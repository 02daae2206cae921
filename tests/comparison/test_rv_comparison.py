"""Comparison of RV reducers: one duration for all runs, and forces of crank bearings in place of those of a cam."""

import json
from pathlib import Path

import pytest

from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS
from cycloid_mj.explore.compared import list_cases

RV80E, RV64 = PRESETS["rv80e"], PRESETS["rv64"]


def test_runs_cover_crank_turns_of_each_design_in_one_duration() -> None:
    """At the same speed of the sun, the cranks of both designs turn at different speeds."""
    cases = list_cases([RV64, RV80E], RV64, 400.0, "planar")
    assert [(case.name, case.load.torque) for case in cases] == [
        *[(name, 0.0) for name in ("rv64", "rv80e")],
        *[(name, 400.0) for name in ("rv64", "rv80e")],
    ]
    for load in (0.0, 400.0):
        assert len({case.drive.hold for case in cases if case.load.torque == load}) == 1


def test_a_pin_and_a_lobe_ring_of_different_layouts_have_no_third_design() -> None:
    cases = list_cases([RV64, PRESETS["nonpin"]], RV64, 10.0, "planar")
    assert {case.name for case in cases} == {"rv64", "nonpin"}


@pytest.mark.slow
def test_the_command_compares_two_rv_reducers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("--quick", "--load-nm", "400", "--hold-s", "0.15", "--timestep-us", "30")
    assert main(["compare", "rv64", "rv80e", *words, "--out", str(tmp_path), "--json", "--quiet"]) == 0
    result = json.loads(capsys.readouterr().out)
    loaded = [run for run in result["runs"] if run["load_nm"] == 400.0]
    assert [run["design"] for run in loaded] == ["rv64", "rv80e"]
    for run in loaded:
        forces, statics = run["forces"], result["by_statics"][run["design"]]
        assert forces["cam_peak_n"] is None
        assert forces["crank_bearing_peak_n"] == pytest.approx(
            statics["crank_bearing_running_force_n"]["value"], rel=0.02
        )
        efficiency = 100.0 * run["findings"]["efficiency"]
        assert efficiency == pytest.approx(statics["efficiency_percent"]["value"], abs=0.3)
    assert (tmp_path / "compare_crank_bearing_force.png").exists()
    assert not (tmp_path / "compare_cam_force.png").exists()
