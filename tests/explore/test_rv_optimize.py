"""Optimisation of an RV reducer: linked keys, figures and checks of its layout, and the run of the best design."""

import json
from pathlib import Path

import pytest

from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, load
from cycloid_mj.explore.optimizer import optimize
from cycloid_mj.explore.problem import define_problem, evaluate_point
from cycloid_mj.explore.verify import verify_design
from cycloid_mj.reducer import RvReducer

RV80E = RvReducer(PRESETS["rv80e"])


def test_the_torque_of_the_sun_follows_the_ratio() -> None:
    task = define_problem(RV80E, {"planet.sun_teeth": "10:16", "planet.planet_teeth": "32:41"}, minimize="mass_kg")
    assert task.follows == {"drive.torque_nm": "keeps the nominal torque on the output"}
    design = task.design_at((12, 36))
    assert design.ratio == pytest.approx(121.0)
    assert design.rated_torque == pytest.approx(784.0)
    # an RV reducer has no holes for output pins, so nothing follows the eccentricity
    assert not define_problem(RV80E, {"gear.eccentricity_mm": "1.2:1.6"}, minimize="mass_kg").links


def test_a_point_has_the_figures_of_its_design_or_the_check_that_rejects_it() -> None:
    task = define_problem(
        RV80E, {"gear.face_width_mm": "12:18"}, minimize="mass_kg", limits=["stiffness_nm_per_arcmin>=200"]
    )
    point, other = evaluate_point(task, (15.0,)), evaluate_point(task, (13.0,))
    assert point.values["feasible"]
    assert point.values["stiffness_nm_per_arcmin"] == pytest.approx(208.0, rel=2e-3)
    assert other.values["mass_kg"] < point.values["mass_kg"]
    teeth = define_problem(RV80E, {"planet.sun_teeth": "10:12"}, minimize="mass_kg")
    assert evaluate_point(teeth, (12,)).values["refused"] == "planets_mesh"


def test_the_run_of_a_design_agrees_with_its_statics() -> None:
    check = verify_design(RV80E.but(ring={"pins": "fixed"}, crank_errors={"bore_x": (1e-5, 0.0, 0.0, 0.0, 0.0, 0.0)}))
    assert set(check.dynamics) == set(check.statics)
    assert check.dynamics["te_loaded_forward_arcsec"] > 5.0
    for key, difference in check.differences.items():
        assert abs(difference) < 0.01, key


@pytest.mark.slow
def test_the_lightest_drive_of_a_stiffness_is_at_the_limit() -> None:
    pytest.importorskip("cma")
    limits = ["stiffness_nm_per_arcmin>=205"]
    found = optimize(
        "rv80e", {"gear.face_width_mm": "12:18"}, minimize="mass_kg", limits=limits, evaluations=40, starts=1
    )
    assert found.best is not None
    width = found.values(found.best)["gear.face_width_mm"]
    assert isinstance(width, float)
    assert found.figures(found.best)["stiffness_nm_per_arcmin"] >= 205.0
    assert found.checked is not None
    assert not found.checked.dynamics.note
    assert abs(found.checked.dynamics.differences["crank_bearing_running_force_n"]) < 0.02


def test_the_command_writes_the_best_design(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "best")
    words = ["optimize", "rv80e", "--vary", "gear.discs=2,3", "--minimize", "mass_kg", "--quick", "--quiet", "--json"]
    assert main([*words, "--out", out]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["best"]["gear.discs"] == 2
    assert load(tmp_path / "best" / "best.toml").layout == "rv"
