"""Optimisation: known optima, the front of two objectives, constraints counted, resumption, hostile input."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from designs import unlike

import cycloid_mj as cm
from cycloid_mj.base.engine import Engine
from cycloid_mj.base.errors import CycloidError, DesignError, UsageError
from cycloid_mj.checks import soundness
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, load, override, value_of
from cycloid_mj.explore import optimizer
from cycloid_mj.explore.budget import SobolSettings
from cycloid_mj.explore.optimizer import HISTORY, optimize
from cycloid_mj.explore.problem import compute_rejections, define_problem
from cycloid_mj.figures import figure, figures_of
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet import sheet

PIN = PRESETS["pin"]
HERE = Engine(1)
SERIAL = {"verify": False, "engine": HERE}
SHAPE = {"gear.eccentricity_mm": "0.3:1.1", "ring.pin_radius_mm": "0.5:3"}
CONVEX = {
    "maximize": "least_convex_radius_mm",
    "limits": ["short_width>=0.5"],
    "verify": False,
    "engine": HERE,
    "starts": 1,
}


# --- known optima


def bends(c: np.ndarray, rho: np.ndarray) -> np.ndarray:
    """Least convex radius of the lobes [mm] by brute force: the least over the turn of the closed form's curvature."""
    phase = np.linspace(0.0, np.pi, 4001)
    N, E = PIN.ring.teeth, 1e3 * PIN.ring.pin_circle_radius
    length = np.sqrt(E**2 + (c * N) ** 2 - 2.0 * E * c * N * np.cos(phase))
    curve = E**2 + c**2 * N**3 - E * c * N * (N + 1) * np.cos(phase)
    convex = curve > 0.0
    return np.min(length[convex] ** 3 / curve[convex]) - rho - 1e3 * PIN.clearance.pin_gear


@pytest.fixture(scope="module")
def convex():
    """The largest least convex radius at a K1 of 0.5 or more; closed sockets hold thin pins too."""
    return optimize(PIN.but(ring={"socket": "closed"}), SHAPE, **CONVEX, evaluations=200)


def test_the_largest_convex_radius_is_that_of_a_fine_grid(convex) -> None:
    best, radii = -np.inf, np.linspace(0.5, 3.0, 5001)
    for c in np.linspace(0.3, 1.1, 1601):
        if c * PIN.ring.teeth < 0.5 * 1e3 * PIN.ring.pin_circle_radius:
            continue  # the limit
        # a socket must be wider than the eccentricity, the one check that a thin pin breaks
        rho = radii[np.searchsorted(radii, c, side="right")]
        best = max(best, float(bends(c, rho)))
    at = convex.design()
    assert not compute_rejections(Reducer(at), strict=False)
    found = convex.best_figures["least_convex_radius_mm"]
    assert found == pytest.approx(best, rel=1e-3)
    assert found == pytest.approx(float(bends(1e3 * at.gear.eccentricity, 1e3 * at.ring.pin_radius)), rel=1e-6)
    assert {"socket", "short_width>=0.5"} <= set(convex.refused)


@pytest.mark.slow
def test_the_same_seed_has_the_same_points_wherever_they_are_evaluated(monkeypatch) -> None:
    # quick points would not be handed on
    monkeypatch.setattr(optimizer, "OPTIMIZER", replace(optimizer.OPTIMIZER, min_point_cpu=0.0))
    few = {**CONVEX, "evaluations": 36, "starts": 2}
    one, two, other = (
        optimize(PIN, SHAPE, **{**few, "engine": Engine(workers)}, seed=seed)
        for workers, seed in ((1, 0), (2, 0), (1, 1))
    )
    assert [row.values for row in one.rows] == [row.values for row in two.rows]
    assert one.rows[5].values != other.rows[5].values


@pytest.mark.slow
def test_integers_are_varied_one_by_one_and_holes_follow() -> None:
    """The fewest teeth have the largest lobes; the ratio changes, and the torque on the output stays."""
    vary = {"ring.teeth": "33:38", "gear.eccentricity_mm": (0.3, 1.0), "output.pins": [6, 8]}
    found = optimize(PIN, vary, **{**CONVEX, "limits": ["short_width>=0.5"]}, evaluations=400)
    best = found.design()
    assert {row.values["ring.teeth"] for row in found.rows} == set(range(33, 39))
    assert best.ring.teeth == 33
    assert best.rated_torque == pytest.approx(PIN.rated_torque)
    room = best.output.hole_radius - best.output.pin_radius - best.gear.eccentricity
    assert room == pytest.approx(0.0, abs=1e-12)
    assert set(found.task.follows) == {"output.hole_radius_mm", "drive.torque_nm"}


def test_an_objective_that_does_not_move_is_reported() -> None:
    found = optimize(PIN, {"friction.cam": "0.01:0.02"}, "mass_kg", evaluations=12, starts=1, **SERIAL)
    (warning,) = found.warnings
    assert warning.startswith("the objective mass_kg does not depend on friction.cam: it is ")
    moved = optimize(PIN, {"gear.face_width_mm": "8:12"}, "mass_kg", evaluations=12, starts=1, **SERIAL)
    assert moved.warnings == ()


def test_limits_that_contradict_each_other_are_refused_before_any_point() -> None:
    limits = ["mass_kg<=1", "mass_kg>=2"]
    with pytest.raises(UsageError, match=r"'mass_kg>=2' contradicts --limit 'mass_kg<=1'"):
        optimize(PIN, {"gear.face_width_mm": "8:12"}, "backlash_arcmin", [], limits, **SERIAL)


def test_active_ends_of_ranges_and_limits_are_reported() -> None:
    """A wider face makes a heavier gear: the least mass is at the lower end, or where a limit holds it."""
    vary = {"gear.face_width_mm": "8:12"}
    free = optimize(PIN, vary, "mass_kg", evaluations=60, verify=False, engine=HERE)
    assert free.active_bounds == (
        "gear.face_width_mm is at the lower end of its range, 8: a wider range may allow a better design",
    )
    bound = float(np.mean([free.best_figures["mass_kg"], free.start_figures["mass_kg"]]))
    held = optimize(PIN, vary, "mass_kg", [], [f"mass_kg>={bound}"], evaluations=60, verify=False, engine=HERE)
    (sentence,) = held.active_bounds
    assert sentence.startswith(f"mass_kg is at its limit mass_kg>={bound:g}: ")


def test_all_combinations_of_discrete_values_are_tried() -> None:
    found = optimize(PIN, {"output.pins": "6:9"}, "mass_kg", verify=False, engine=HERE)
    masses = {row.values["output.pins"]: row.values["mass_kg"] for row in found.rows}
    assert set(masses) == {6, 7, 8, 9}
    assert masses[found.design().output.pins] == min(masses.values())
    best, end = found.design().output.pins, {6: "lower", 9: "upper"}
    assert best in end
    assert found.active_bounds == (
        f"output.pins is at the {end[best]} end of its range, {best}: a wider range may allow a better design",
    )


def test_a_front_trades_one_objective_for_the_other() -> None:
    """A larger eccentricity has a larger K1 and sharper lobes: every value is on the front, from end to end."""
    vary, aims = {"gear.eccentricity_mm": "0.4:0.8"}, ["short_width", "least_convex_radius_mm"]
    found = optimize(PIN, vary, maximize=aims, evaluations=210, verify=False, engine=HERE)
    across = np.array([found.values(place)["gear.eccentricity_mm"] for place in found.front])
    assert (across.max(), across.min()) == pytest.approx((0.8, 0.4), abs=0.01)
    assert np.abs(np.diff(across)).max() < 0.1
    costs = -np.array([list(found.figures(place).values()) for place in found.front])
    assert (np.diff(costs[:, 0]) > 0.0).all()
    assert (np.diff(costs[:, 1]) < 0.0).all()
    reach = (costs - costs.min(axis=0)) / np.ptp(costs, axis=0)
    assert np.argmin(reach.max(axis=1)) == found.front.index(found.best)
    assert isinstance(found.as_json()["objective"], list)


@pytest.mark.slow
def test_the_paper_s_design_presses_its_teeth_less_in_the_same_housing() -> None:
    """Rated torque, same housing, no more backlash: docs/explore.md has a longer search, and its price."""
    before = sheet(Reducer(PIN)).quantities
    vary = {"gear.eccentricity_mm": "0.9:1.1", "ring.pin_radius_mm": "1.6:2.3", "ring.pin_circle_radius_mm": "40:47"}
    limit = f"backlash<={before['backlash'].value!r}"
    found = optimize(PIN, vary, "pin_gear_pressure", limits=limit, evaluations=40, starts=1, verify=False, engine=HERE)
    after = sheet(Reducer(found.design())).quantities
    assert after["pin_gear_pressure"].value < 0.75 * before["pin_gear_pressure"].value
    assert after["backlash"].value <= before["backlash"].value
    assert found.design().housing == PIN.housing
    assert found.design().rated_torque == PIN.rated_torque
    assert after["pin_gear_friction_power"].value > before["pin_gear_friction_power"].value  # what it costs


# --- figures


def test_former_and_new_keys_of_limits_have_the_same_figures() -> None:
    pairs = {"backlash": "backlash_arcmin", "pin_gear_pressure": "pin_gear_pressure_mpa"}
    found = optimize(
        PIN, {"output.pins": "7:8"}, limits=[f"{key}<=2000" for key in pairs], minimize="mass_kg", **SERIAL
    )
    there = sheet(Reducer(found.design(0))).quantities
    assert {key: found.figures(0)[key] for key in pairs} == {key: there[key].value for key in pairs}
    new = optimize(
        PIN, {"output.pins": "7:8"}, limits=[f"{key}<=2000" for key in pairs.values()], minimize="mass_kg", **SERIAL
    )
    assert list(new.figures(0).values()) == list(found.figures(0).values())


def test_a_figure_of_a_rating_may_be_sought() -> None:
    found = optimize(PIN, {"drive.speed_rpm": "1640,800"}, maximize="bearing_life_h", **SERIAL)
    assert found.values(found.best) == {"drive.speed_rpm": 800.0}


def test_the_least_convex_radius_is_that_of_a_fine_profile() -> None:
    gear = CycloidGear(
        PIN.ring.teeth,
        *(
            getattr(*one)
            for one in ((PIN.gear, "eccentricity"), (PIN.ring, "pin_circle_radius"), (PIN.ring, "pin_radius"))
        ),
    )
    lobes = profile.sample(gear, 20_000, PIN.ring.pin_radius + PIN.clearance.pin_gear)
    radius = figure("least_convex_radius_mm").value(Reducer(PIN))
    assert radius == pytest.approx(1e3 / lobes.curvature.max(), rel=1e-3)


def test_a_design_that_cannot_be_built_still_names_its_figures() -> None:
    broken = override(PRESETS["nonpin"], {"gear.eccentricity_mm": 1.5})
    assert not all(one.passed for one in soundness(Reducer(broken)))
    assert {"tooth_pressure_mpa", "mass_kg"} <= {row.key for row in figures_of(Reducer(broken))}
    assert "pin_socket_pressure_mpa" not in {
        row.key for row in figures_of(Reducer(override(PIN, {"ring.pins": "fixed"})))
    }


def test_a_search_may_start_from_a_design_that_cannot_be_built() -> None:
    broken = override(PIN, {"gear.eccentricity_mm": 1.5, "output.hole_radius_mm": 5.5})
    found = optimize(broken, SHAPE, **CONVEX, evaluations=40)
    assert not found.start_figures
    assert found.best is not None
    assert not compute_rejections(Reducer(found.design()), strict=False)


@pytest.mark.slow
def test_strict_treats_warnings_as_failures() -> None:
    """The paper's teeth yield under its torque: a warning of the check tooth_yield."""
    vary = {"gear.face_width_mm": "9:20"}
    loose, strict = (
        optimize(PIN, vary, "mass_kg", strict=strict, evaluations=20, starts=1, verify=False, engine=HERE)
        for strict in (False, True)
    )
    assert loose.design().gear.face_width == pytest.approx(9e-3, rel=1e-3)
    assert strict.design().gear.face_width > 13e-3
    assert "tooth_yield" in strict.refused
    assert any("tooth_yield" in note for note in loose.notes)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["printed", "light"])
def test_other_designs(name: str) -> None:
    design = unlike(name)
    c = value_of(design, "gear.eccentricity_mm")
    vary = {"gear.eccentricity_mm": (0.8 * c, 1.05 * c)}
    found = optimize(
        design, vary, "mass_kg", "least_convex_radius_mm", evaluations=4, starts=1, verify=False, engine=HERE
    )
    assert found.best is not None
    assert all(np.isfinite(list(found.figures(place).values())).all() for place in found.front)
    json.dumps(found.as_json())


# --- the best, checked


@pytest.mark.slow
def test_the_best_is_checked_in_statics_dynamics_and_tolerances(monkeypatch) -> None:
    monkeypatch.setattr(optimizer, "OPTIMIZER", replace(optimizer.OPTIMIZER, tolerance_samples=16))
    monkeypatch.setattr("cycloid_mj.explore.tolerances.ANGLES", 12)
    monkeypatch.setattr("cycloid_mj.explore.budget.SOBOL", SobolSettings(min_samples=16, min_drawn=16, max_samples=16))
    design = override(unlike("light"), {"tolerance.cam": "normal 0.5", "tolerance.output": "normal 0.5"})
    wide = value_of(design, "gear.face_width_mm")
    vary = {"gear.face_width_mm": (wide, 1.2 * wide)}
    found = optimize(design, vary, maximize="mass_kg", evaluations=6, starts=1, engine=HERE)
    checked = found.checked
    pressures = [one.quantities["tooth_pressure"].value for one in (checked.sheet, checked.start)]
    assert pressures[0] < 0.99 * pressures[1]
    assert abs(checked.dynamics.differences["tooth_force_n"]) < 0.2
    assert found.checked.tolerances.samples == 16
    assert found.as_json()["verified"]["tolerances"]["yield"] >= 0.0


# --- the command, and what stops it

FLAGS = ["--vary", "gear.eccentricity_mm=0.3:1.1", "--vary", "ring.pin_radius_mm=0.5:3", "--maximize"]
FLAGS += ["least_convex_radius_mm", "--limit", "short_width>=0.5", "--evaluations", "60", "--starts", "1", "--quick"]


@pytest.mark.slow
def test_the_command(tmp_path: Path, capsys) -> None:
    assert main(["optimize", *FLAGS, "--out", str(tmp_path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {"best", "objective", "evaluations", "design"} <= set(found)
    best = load(Path(found["design"]))
    assert found["best"]["gear.eccentricity_mm"] == pytest.approx(1e3 * best.gear.eccentricity)
    assert found["objective"] == found["figures"]["least_convex_radius_mm"]
    assert len((tmp_path / HISTORY).read_text().splitlines()) == found["evaluations"] + 1
    page = (tmp_path / "optimize.html").read_text()
    assert 'src="http' not in page
    assert "short_width&gt;=0.5" in page
    assert (tmp_path / "tradeoff.png").stat().st_size > 10_000


def test_a_folder_of_another_optimisation_is_refused(tmp_path: Path) -> None:
    optimize(PIN, SHAPE, **CONVEX, evaluations=6, out=tmp_path)
    assert load(tmp_path / "best.toml").name == "pin-best"
    with pytest.raises(UsageError, match="differs in seed"):
        optimize(PIN, SHAPE, **CONVEX, evaluations=6, seed=1, out=tmp_path)


@pytest.mark.slow
def test_a_search_that_was_stopped_continues_to_the_same_points(tmp_path: Path) -> None:
    """Ctrl-C in another process; then the same command."""
    arguments = [sys.executable, "-m", "cycloid_mj", "optimize", *FLAGS[:-5], "--evaluations", "200", "--quick"]
    stopped = subprocess.Popen([*arguments, "--out", str(tmp_path / "one")], stderr=subprocess.PIPE, text=True)
    rows = tmp_path / "one" / "optimize.rows.jsonl"
    deadline = time.monotonic() + 60.0
    while not (rows.exists() and rows.read_bytes().count(b"\n") > 20):
        assert time.monotonic() < deadline
        assert stopped.poll() is None
        time.sleep(0.05)
    stopped.send_signal(signal.SIGINT)
    told = stopped.communicate(timeout=60)[1]
    assert stopped.returncode == 130
    assert "Run the same command again to resume" in told
    history = (tmp_path / "one" / HISTORY).read_text().splitlines()
    assert len(history) > 20
    kept = rows.read_bytes().splitlines()
    task = define_problem(Reducer(PIN), SHAPE, (), ("least_convex_radius_mm",), ("short_width>=0.5",))
    resumed, whole = (
        optimizer.run_search(task, 200, 3, 0, folder, HERE, optimizer.silent) for folder in (tmp_path / "one", None)
    )
    assert [row.values for row in resumed.rows] == [row.values for row in whole.rows]
    assert rows.read_bytes().splitlines()[: len(kept)] == kept


def test_a_search_without_a_feasible_point_states_the_rejections(tmp_path: Path, capsys) -> None:
    flags = ["--vary", "gear.eccentricity_mm=1.2:1.5", "--vary", "output.pin_radius_mm=3:12", "--minimize", "mass_kg"]
    assert main(["optimize", *flags, "--evaluations", "30", "--out", str(tmp_path)]) == 1
    told = capsys.readouterr().err
    assert "none of 3" in told
    assert "loops: 3" in told
    assert "Widen the ranges" in told
    assert len((tmp_path / HISTORY).read_text().splitlines()) > 30
    with pytest.raises(DesignError, match=r"mass_kg<=0\.001: "):
        optimize(PIN, {"gear.face_width_mm": "9:11"}, "mass_kg", limits="mass_kg<=0.001", evaluations=6, engine=HERE)


@pytest.mark.parametrize(
    ("vary", "more", "message"),
    [
        ({}, {}, "no key is varied"),
        ({"gear.eccentricty_mm": "0.5:1"}, {}, "did you mean gear.eccentricity_mm"),
        ({"gear.eccentricity_mm": "1:0.5"}, {}, "the smaller one first"),
        ({"gear.eccentricity_mm": "a:b"}, {}, "give LO:HI"),
        ({"ring.teeth": "30.5:36"}, {}, "is not a whole number"),
        ({"errors.pin_x_um": "0:1"}, {}, "of the design file is a list or a table and cannot be varied"),
        ({"gear.eccentricity_mm": "0.5:1"}, {"minimize": "pressure"}, "unknown quantity 'pressure'.*pin_gear_pressure"),
        ({"gear.eccentricity_mm": "0.5:1"}, {"minimize": ()}, "but 0 are given"),
        ({"gear.eccentricity_mm": "0.5:1"}, {"minimize": ["mass_kg"] * 3}, "but 3 are given"),
        ({"gear.eccentricity_mm": "0.5:1"}, {"limits": "masse<=1"}, "unknown quantity 'masse'; did you mean mass_kg"),
        ({"ring.teeth": "4:400", "output.pins": "2:100"}, {}, "combinations"),
    ],
)
def test_wrong_wishes_are_refused(vary, more, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        optimize(PIN, vary, **{"minimize": "mass_kg", "engine": HERE, **more})


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--vary", "gear.eccentricity_mm"], "give KEY=LO:HI"),
        (["--vary", "ring.teeth=34:36", "--vary", "ring.teeth=30:36"], "is repeated"),
        (["--vary", "ring.teeth=34:36", "--evaluations", "0"], "evaluations"),
        (["--vary", "ring.teeth=34:36", "--seed", "1.5"], "whole number"),
    ],
)
def test_wrong_flags_are_refused(tmp_path: Path, capsys, flags: list[str], message: str) -> None:
    assert main(["optimize", *flags, "--minimize", "mass_kg", "--out", str(tmp_path)]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written_is_reported(tmp_path: Path, capsys) -> None:
    tmp_path.chmod(0o500)
    assert main(["optimize", *FLAGS, "--out", str(tmp_path)]) == 1
    assert "permission denied" in capsys.readouterr().err


def test_a_file_in_the_folder_s_place_is_reported(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    with pytest.raises(CycloidError, match="taken"):
        optimize(PIN, SHAPE, **CONVEX, out=tmp_path / "taken")


def test_the_public_face_has_it_as_a_table() -> None:
    found = cm.optimize(PIN, {"gear.face_width_mm": "9:11"}, "mass_kg", evaluations=6, verify=False, engine=HERE)
    assert len(found) == found.evaluations
    assert found["mass_kg"].min() == found.best_figures["mass_kg"]
