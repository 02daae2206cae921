"""``cycloid-mj compare``: runs and logs side by side, its files, and every mistake; figures hold the numbers."""

import json
import math
import re
import threading
from pathlib import Path

import numpy as np
import pytest
from commands import told

import cycloid_mj.dynamics.run
from cycloid_mj.base.comparison_runs import DEFAULTS, TURNS
from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.cli.compare import RUNS
from cycloid_mj.cli.flags import load_design
from cycloid_mj.cli.verdict import catalogue_figures, catalogue_table, overloads, ratio_columns
from cycloid_mj.comparison import STARTS, SWEEP, comparable, differences, settle_run, settling_time
from cycloid_mj.comparison.conditions import conditions
from cycloid_mj.design import PRESETS, dump, loads, override
from cycloid_mj.dynamics.planar.timestep import acceleration_timestep
from cycloid_mj.explore.compared import list_cases
from cycloid_mj.figures import figure as catalogue_figure
from cycloid_mj.geometry.contact_lines import contact_lines, mesh_period
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.log import read
from cycloid_mj.plots.comparison import comparison_figures
from cycloid_mj.plots.curvature import CRANK_ANGLES, curvature_figure
from cycloid_mj.reducer import Reducer

PAPER = CycloidGear(36, 1e-3, 40.75e-3, 2.25e-3)
SHORT = ("--hold-s", "0.012", "--set", "load.rise_s=0.001", "--quick")
DESIGNS = ("pin", "nonpin", "nonpin-like-pin")
NAMES = (
    *("transmission_error", "gear_transmission_error", "output_speed", "gear_speed", "q_path", "q_speed"),
    *("teeth", "tooth_force", "cam_force", "vibration"),
)


def rejected(*argv: str) -> tuple[int, str]:
    """Exit code and message of a mistake, which must be one line, after what is told on the way."""
    code, out, err = told(*argv)
    assert out == ""
    told_before = ("preparing the model", "warning: ")
    lines = [line for line in err.splitlines() if "in parallel" not in line and not line.startswith(told_before)]
    messages = [line for line in lines if not line.endswith(" s simulated")]  # progress, on a loaded machine
    assert len(messages) == 1, err
    assert messages[0].startswith("error: ")
    return code, messages[0]


def design_of(log: str | Path):
    return loads(read(log).attachments["design.toml"].decode())


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    """JSON and folder of a short comparison."""
    folder = tmp_path_factory.mktemp("compare")
    code, out, err = told("compare", "pin", "nonpin", *SHORT, "--out", str(folder), "--json", "--quiet")
    assert (code, err) == (0, "")
    return json.loads(out, parse_constant=pytest.fail), folder


@pytest.fixture
def undrawn(monkeypatch):
    """Draw no figures."""
    monkeypatch.setattr("cycloid_mj.cli.compare._figure_encoders", lambda comparison, motions: {})


@pytest.fixture
def planned(monkeypatch):
    """Let nothing run; give the designs that would have been run."""
    designs = []

    def run_all(jobs, force, quiet, solver, viewable=None):
        designs.extend(jobs)
        raise RunError("nothing is run here")

    monkeypatch.setattr("cycloid_mj.cli.batch.run_all", run_all)
    return designs


@pytest.fixture
def instant(monkeypatch):
    """Let each run be done at once, with noise for its motion and no forces; give the designs that were run.

    The logs have no 3-D scene.
    """
    ran = []
    monkeypatch.setattr("cycloid_mj.scene.Scene.opening", lambda scene, time: iter(()))
    monkeypatch.setattr("cycloid_mj.scene.Scene.frames", lambda scene, time, columns: iter(()))

    def blocks(compiled, reducer):
        ran.append(reducer.design)
        random = np.random.default_rng(len(ran))
        groups = cycloid_mj.dynamics.run.log_columns(compiled, reducer)
        time = (
            np.arange(round(reducer.design.drive.hold * reducer.design.settings.log_rate))
            / reducer.design.settings.log_rate
        )
        values = {topic: np.zeros((len(time), len(group))) for topic, group in groups.items()}
        values["/reducer"] = random.normal(size=values["/reducer"].shape)
        values["/reducer"][:, list(groups["/reducer"]).index("crank_angle")] = reducer.design.drive.speed * time
        yield cycloid_mj.dynamics.run.SampleBlock(time, values)
        return ()

    monkeypatch.setattr(cycloid_mj.dynamics.run, "blocks", blocks)
    return ran


# --- a comparison by runs


@pytest.mark.slow
def test_json_has_a_run_for_each_design_and_load(compared):
    found, _ = compared
    assert found["designs"] == list(DESIGNS)
    cases = [(run["design"], run["load_nm"]) for run in found["runs"]]
    assert cases == [(name, load) for load in (0.0, 36.68) for name in DESIGNS]
    assert set(found["differences"]) == {"ring.kind", "clearance.tooth_um", "stiffness.tooth_n_m"}
    assert found["differences"]["ring.kind"] == ["pin", "nonpin", "nonpin"]
    assert found["differences"]["clearance.tooth_um"] == [1.0, 1.0, 2.0]
    for run in found["runs"]:
        assert {"findings", "fluctuation", "vibration", "forces"} < set(run)
        assert run["findings"]["contact_summary"]["mean_active"] > 0
    loaded = found["runs"][3:]
    assert all(run["forces"]["teeth_least"] > 8 and run["findings"]["efficiency"] > 0.5 for run in loaded)
    assert len(found["rankings"]) == 2 * 2 * 5
    assert len(found["summary"]) == 2 * 2
    assert found["sweep"] == []


@pytest.mark.slow
def test_all_runs_have_the_same_settings(compared):
    found, _ = compared
    designs = [design_of(run["findings"]["log"]) for run in found["runs"]]
    assert all(conditions(Reducer(design)) == found["conditions"] for design in designs)
    given = [design for design in designs if design.name in ("pin", "nonpin")]
    alike = [design.model_copy(update={"name": "", "ring": None, "load": None}) for design in given]
    assert all(design == alike[0] for design in alike)
    assert found["conditions"]["settings.log_rate_hz"] == 20000.0


@pytest.mark.slow
def test_files_of_a_comparison(compared):
    found, folder = compared
    figures = [f"compare_{name}.png" for name in (*NAMES, "curvature")]
    logs = [f"{name}-{run}.mcap" for name in DESIGNS for run in ("no-load", "no-load-start-2", "36.68Nm")]
    figured = ["compare.csv", "compare.json"]
    assert sorted(path.name for path in folder.iterdir()) == sorted(figures + logs + figured)
    assert [Path(path).name for path in found["figures"]] == figures
    assert all((folder / name).read_bytes().startswith(b"\x89PNG") for name in figures)


@pytest.mark.slow
def test_logs_of_further_starts_have_only_samples_and_design(compared):
    """Nobody looks at each of the starts: their frames and models would take a quarter of the time."""
    _, folder = compared
    first, second = (read(folder / f"pin-no-load{start}.mcap") for start in ("", "-start-2"))
    assert {"design.toml", "model.xml", "findings.json"} <= set(first.attachments)
    assert set(second.attachments) == {"design.toml"}
    assert first.topics == second.topics


@pytest.mark.slow
def test_logs_give_the_comparison_again(compared, tmp_path, undrawn):
    found, _ = compared
    logs = [run["findings"]["log"] for run in found["runs"]]
    code, out, err = told("compare", *reversed(logs), "--out", str(tmp_path), "--json")
    assert code == 0
    assert {line.split(":")[0].split(" ")[0] for line in err.splitlines()} == {"warning", "wrote"}  # of short runs
    again = json.loads(out)
    assert again["designs"] == list(reversed(DESIGNS))
    by_case = {(run["design"], run["load_nm"]): run for run in again["runs"]}
    of_starts = {"starts", "start_logs", "spreads"}
    for run in found["runs"]:
        same = by_case[run["design"], run["load_nm"]]
        left_out = set() if run["load_nm"] else of_starts
        assert all(same[key] == value for key, value in run.items() if key not in left_out)
    loaded = [[each for each in one["rankings"] if each["load_nm"]] for one in (again, found)]
    assert sorted(loaded[0], key=str) == sorted(loaded[1], key=str)


@pytest.mark.slow
def test_one_log_is_one_start_and_determines_no_claim(compared, tmp_path, undrawn):
    found, _ = compared
    logs = [run["findings"]["log"] for run in found["runs"] if not run["load_nm"]]
    one = json.loads(told("compare", *logs, "--out", str(tmp_path), "--json")[1])
    assert {run["starts"] for run in one["runs"]} == {1}
    assert {(each["starts"], each["verdict"]) for each in one["rankings"]} == {(1, "not determined")}
    assert all("1 start of the 8" in each["sentence"] for each in one["rankings"])


@pytest.mark.slow
def test_a_quick_comparison_has_two_starts_and_an_undetermined_order(compared):
    found, _ = compared
    for run in found["runs"]:
        assert run["starts"] == len(run["start_logs"]) == len(set(run["start_logs"])) == (1 if run["load_nm"] else 2)
        assert bool(run["spreads"]) == (run["load_nm"] == 0.0)
        for each in run["spreads"]:
            assert len(each["values"]) == 2
            assert each["least"] <= each["mean"] <= each["largest"]
    idle = [each for each in found["rankings"] if each["load_nm"] == 0.0]
    assert {(each["starts"], each["verdict"]) for each in idle} == {(2, "not determined")}
    speed = next(each for each in found["runs"][0]["spreads"] if each["quantity"] == "gear speed error, rms")
    assert speed["values"] == idle[0]["pin_starts"]["values"]
    assert speed["values"][0] == found["runs"][0]["fluctuation"]["gear_speed_rad_s"]["rms"] != speed["values"][1]


@pytest.mark.slow
def test_table_and_words_go_to_stdout(compared, tmp_path, undrawn):
    found, _ = compared
    logs = [run["findings"]["log"] for run in found["runs"] if run["load_nm"]]
    code, out, err = told("compare", *logs, "--out", str(tmp_path), "--quiet", "--all")
    assert (code, err) == (0, "")
    assert "no load" not in out
    flat = " ".join(out.split())
    for words in (
        "36.68 N m, 1640 rpm: from",
        "gear speed error, rms",
        "vibration of the output",
        "differ in: ring.kind (pin",
    ):
        assert words in flat
    assert not re.search(r"[1-9]\.\d{7}|\d{7}\.\d", flat), "a number of more digits than it means"
    for ranking in found["rankings"][10:]:
        assert ranking["sentence"] in flat


def test_default_hold_is_whole_turns_after_settling(here, planned):
    assert told("compare", "pin", "nonpin", "--quiet", "--quick")[0] == 1
    idle, loaded = ([design for design in planned if bool(design.load.torque) == under] for under in (False, True))
    assert len({design.drive for design in idle}) == len({design.drive for design in loaded}) == 1
    assert f"{idle[0].drive.hold:.4f}" == "0.1198", "the help says how long"
    design = loaded[0]
    assert design.drive.ramp == 0.0
    turn = 2 * math.pi / design.drive.speed
    assert design.drive.hold == pytest.approx(
        settling_time(Reducer(design)) + TURNS * turn, abs=1.5 / design.settings.log_rate
    )
    assert f"{design.drive.hold:.4f}" == "0.2661", "the help says how long"


def test_planar_runs_use_the_step_for_accelerations_by_default(here, planned):
    steps = []
    for more in ((), ("--timestep-us", "2"), ("--solver", "mujoco")):
        planned.clear()
        assert told("compare", "pin", "nonpin", "--quiet", "--quick", *more)[0] == 1
        steps.append({design.settings.timestep for design in planned})
    assert steps == [
        {acceleration_timestep(Reducer(override(PRESETS["pin"], ["load.torque_nm=36.68"])))},
        {2e-6},
        {0.0},
    ]


@pytest.mark.slow
def test_loaded_runs_are_repeated_with_each_assumption_unless_quick(here, instant, undrawn, compared):
    argv = ("compare", "pin", "nonpin", "--hold-s", "0.02", "--json", "--quiet", "--out")
    found = json.loads(told(*argv, "whole")[1])
    cases = [(design.name, design.load.torque) for design in instant]
    creep = [design.contact.creep_speed for design in instant]
    damping = [design.contact.damping_ratio for design in instant]
    assert len(cases) == (STARTS + 1) * len(DESIGNS) + 2 * len(DESIGNS)
    # noise of one kind in all runs has no order
    idle = [each for each in found["rankings"] if each["load_nm"] == 0.0]
    assert {(each["starts"], each["verdict"]) for each in idle} == {(STARTS, "not determined")}
    assert creep.count(20e-3) == damping.count(0.1) == len(DESIGNS)
    assert all(load for (_, load), slow, soft in zip(cases, creep, damping, strict=True) if slow or soft < 0.5)
    assert {each["design"] for each in found["sensitivity"]} == set(DESIGNS)
    assert {each["load_nm"] for each in found["sensitivity"]} == {36.68}
    for each in (each for each in found["sensitivity"] if each["quantity"] != "efficiency"):  # noise may have none
        assert [response["parameter"] for response in each["responses"]] == ["creep speed", "damping ratio"]
    quick, _ = compared
    assert quick["sensitivity"] == []


@pytest.mark.slow
def test_next_comparisons_take_free_folders(here, instant, undrawn, monkeypatch):
    monkeypatch.setattr("cycloid_mj.cli.compare.QUICK_STARTS", 1)
    for folder in (RUNS, f"{RUNS}-2"):
        argv = ("compare", "pin", "nonpin", "--load-nm", "0", "--hold-s", "0.02", "--json", "--quiet", "--quick")
        found = json.loads(told(*argv)[1])
        assert {Path(run["findings"]["log"]).parent for run in found["runs"]} == {Path(folder)}
    assert len(instant) == 2 * len(DESIGNS)


@pytest.mark.slow
def test_logs_in_a_named_folder_are_replaced_only_by_force(here, instant, undrawn, monkeypatch):
    monkeypatch.setattr("cycloid_mj.cli.compare.QUICK_STARTS", 1)
    argv = ("compare", "pin", "nonpin", "--load-nm", "0", "--hold-s", "0.02", "--out", "mine", "--quiet", "--quick")
    assert told(*argv)[0] == 0
    before = Path("mine/pin-no-load.mcap").read_bytes()
    code, message = rejected(*argv)
    assert code == 1
    assert "mine/pin-no-load.mcap already exists" in message
    assert Path("mine/pin-no-load.mcap").read_bytes() == before
    assert told(*argv, "--force")[0] == 0
    assert Path("mine/pin-no-load.mcap").read_bytes() != before


def test_the_first_design_rules_the_settings_and_set_changes_all(here, planned):
    slow = override(PRESETS["pin"], ["name=slow", "drive.speed_rpm=820", "drive.torque_nm=0.5", "load.rise_s=0.002"])
    Path("slow.toml").write_text(dump(slow))
    argv = ("compare", "slow.toml", "nonpin", "--set", "friction.cam=0.01", "--quiet", "--quick", "--workers", "1")
    assert told(*argv)[0] == 1
    assert {design.drive.speed for design in planned} == {slow.drive.speed}
    assert {design.load.rise for design in planned} == {0.002}
    assert {design.friction.cam for design in planned} == {0.01}
    assert sorted({design.load.torque for design in planned}) == [0.0, 17.5]


@pytest.mark.slow
def test_sweep_runs_each_different_design_once(here, instant, monkeypatch):
    few = (SWEEP[0], SWEEP[-1])
    monkeypatch.setattr("cycloid_mj.comparison.SWEEP", few)
    monkeypatch.setattr("cycloid_mj.plots.comparison.comparison_figures", lambda motions: {})
    argv = ("compare", "pin", "nonpin", "--sweep", "--load-nm", "0", "--hold-s", "0.02", "--out", "all", "--json")
    code, out, err = told(*argv, "--quick")
    assert code == 0
    found = json.loads(out)
    assert [(point["parameter"], point["value"]) for point in found["sweep"]] == [
        (variation.parameter, variation.value) for variation in few
    ]
    # fixed pins concern the pin design only
    assert len(instant) == len(set(instant)) == 2 * (3 + 3 * len(few) - 2) == 14
    assert len(found["decisions"]) == len(found["rankings"]) == 2 * 5
    assert Path("all/pin-no-load-pins-fixed.mcap").exists()
    assert Path("all/compare_sweep.png").exists()
    assert Path("all/pin-no-load-start-2-pins-fixed.mcap").exists()
    assert all("not determined" in decision for decision in found["decisions"])
    assert "running 14 simulations, " in err


# --- what goes wrong


@pytest.mark.slow
def test_a_run_that_fails_stops_the_others_and_is_reported(here, monkeypatch):
    """The other run ends at its next block, with its log closed and readable."""
    failed = threading.Event()

    def blocks(compiled, reducer):
        groups = cycloid_mj.dynamics.run.log_columns(compiled, reducer)
        for first in range(0, 2000, 2):
            time = 1e-4 * np.arange(first, first + 2)
            yield cycloid_mj.dynamics.run.SampleBlock(
                time, {topic: np.zeros((2, len(group))) for topic, group in groups.items()}
            )
            if reducer.design.name == "nonpin":
                failed.set()
                raise RunError("the gear jumped a tooth")
            assert failed.wait(300)

    monkeypatch.setattr(cycloid_mj.dynamics.run, "blocks", blocks)
    code, message = rejected("compare", "pin", "nonpin", "--load-nm", "0", "--out", "mine", "--workers", "3", "--quick")
    assert code == 1
    assert "jumped a tooth" in message
    assert "mine/nonpin-no-load.mcap" in message
    stopped = read("mine/pin-no-load.mcap")
    assert (stopped.complete, len(stopped) < 2000) == (False, True)


def test_ctrl_c_stops_every_run_and_leaves_readable_logs(here, monkeypatch):
    monkeypatch.setattr("cycloid_mj.cli.batch.wait", interrupting)
    code, message = rejected("compare", "pin", "nonpin", "--out", "mine", "--timestep-us", "4", "--workers", "1")
    assert code == 130
    assert "stopped by Ctrl-C" in message
    assert "mine" in message
    (log,) = Path("mine").glob("*.mcap")
    assert not read(log).complete


def interrupting(runs, return_when):
    """Wait until the first log has samples, then press Ctrl-C."""
    while not any(path.stat().st_size > 30_000 for path in Path("mine").glob("*.mcap")):
        assert not runs[0].done()
    raise KeyboardInterrupt


@pytest.mark.slow
def test_a_log_of_a_stopped_run_is_not_compared(compared, tmp_path):
    found, _ = compared
    whole = Path(found["runs"][0]["findings"]["log"])
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[:-100])
    code, message = rejected("compare", str(cut), found["runs"][1]["findings"]["log"])
    assert code == 1
    assert "is incomplete" in message


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        ((), ("two designs",)),
        (("pin",), ("two designs",)),
        (("pin", "pin"), ("two designs have the name", "'pin'")),
        (("pin", "ponpin"), ("ponpin", "nonpin")),
        (("pin", "run.mcap"), ("run.mcap", "pin", "logs only")),
        (("a.mcap", "b.mcap", "--load-nm", "3"), ("--load-nm applies only to new simulations",)),
        (("a.mcap", "b.mcap", "--sweep"), ("--sweep applies only to new simulations",)),
        (("pin", "nonpin", "--workers", "0"), ("--workers", "from 1 to 4096")),
        (("pin", "nonpin", "--load-nm", "nan"), ("--load-nm", "at least -1000000")),
        (("pin", "nonpin", "--ramp-s", "-1"), ("--ramp-s", "at least 0")),
        (("pin", "nonpin", "--hold-s", "0"), ("--hold-s", "greater than 0")),
        (("pin", "nonpin", "--set", "drive.speed_rpm=0"), ("drive.speed_rpm",)),
        (("pin", "nonpin", "--q", "1"), ("--q", "X,Y")),
        (("pin", "nonpin", "--frob"), ("--frob",)),
    ],
)
def test_wrong_usage_is_one_line_and_exit_code_2(argv, words, here):
    code, message = rejected("compare", *argv)
    assert code == 2
    assert all(word.lower() in message.lower() for word in words), message
    assert not list(here.glob("**/*.mcap"))


def test_help_states_purpose_flags_and_examples():
    code, out, err = told("compare", "--help")
    assert (code, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    lines = [
        line.split() for line in out.split("Examples:")[1].replace("\\\n", " ").splitlines() if "cycloid-mj" in line
    ]
    assert len(lines) == 4
    for line in lines:
        assert "--no-such-flag" in rejected(*line[1:], "--no-such-flag")[1]


# --- contact lines


@pytest.mark.parametrize("preset", ["pin", "nonpin"])
def test_profile_writes_the_contact_lines(preset, tmp_path):
    file = tmp_path / "lines.csv"
    argv = ("design", "profile", "--design", preset, "--part", "curvature", "--csv", str(file), "--points", "7")
    code, out, err = told(*argv)
    header, *rows = (line.split(",") for line in file.read_text().splitlines())
    assert header == [
        *("crank_deg", "tooth", "part", "phase_deg", "x_mm", "y_mm"),
        *("relative_curvature_per_mm", "pressure_mpa"),
    ]
    lines = contact_lines(PAPER, preset, mesh_period(PAPER, 7))
    assert (code, out, err) == (0, "", f"wrote {len(rows)} rows of {len(header)} columns to {file}\n")
    columns = dict(zip(header, zip(*rows, strict=True), strict=True))
    assert list(columns["part"]) == lines.part.tolist()
    assert [int(word) for word in columns["tooth"]] == (lines.tooth + 1).tolist()
    assert [float(word) for word in columns["crank_deg"]] == pytest.approx(np.degrees(lines.crank_angle))
    curvature = np.array([float(word) for word in columns["relative_curvature_per_mm"]])
    assert curvature == pytest.approx(1e-3 * lines.relative_curvature)
    pressure = np.array([float(word) for word in columns["pressure_mpa"]])
    # the most loaded tooth's share of the rated torque on 10 mm of steel: sqrt(F E kappa / (2 pi (1 - nu^2) L))
    force = 4 * 36.68 / (36 * 0.035)
    asked = np.sqrt(force * 210e3 * curvature / (2 * np.pi * (1 - 0.28**2) * 10))
    assert pressure == pytest.approx(asked, rel=1e-3, abs=1e-6)


def test_too_many_lines_are_refused(here):
    argv = ("design", "profile", "--design", "nonpin", "--part", "curvature", "--csv", "x.csv", "--points", "100000")
    code, message = rejected(*argv)
    assert code == 2
    assert "--points" in message


def test_curvature_figure_draws_every_line_of_both_designs():
    top, bottom = curvature_figure([PRESETS["pin"], PRESETS["nonpin"]]).axes
    drawn = [line for line in top.lines if len(line.get_xdata()) > 2]
    assert len(drawn) == 1 + 3
    expected = contact_lines(PAPER, "nonpin", mesh_period(PAPER, CRANK_ANGLES))
    for line, part in zip(drawn[1:], ("arc", "sigma1", "sigma2"), strict=True):
        rows = expected.part == part
        assert np.sort(line.get_ydata()) == pytest.approx(np.sort(1e-3 * expected.relative_curvature[rows]))
    assert "1/mm" in top.get_ylabel()
    assert "MPa" in bottom.get_ylabel()
    assert re.search(r"under [\d., ]+ N$", bottom.get_title(loc="left"))


# --- figures


@pytest.mark.slow
def test_figures_have_a_panel_for_each_run_and_name_it(compared):
    found, _ = compared
    motions = [settle_run(read(run["findings"]["log"])) for run in found["runs"]]
    drawn = comparison_figures(motions)
    assert list(drawn) == [f"compare_{name}" for name in NAMES]
    for name, figure in drawn.items():
        titles = [axes.get_title(loc="left") for axes in figure.axes]
        if name == "compare_vibration":
            assert titles == ["no load", "36.68 N m", "", ""]
            assert all(len(axes.lines) >= 2 for axes in figure.axes)
        else:
            cases = [f"{design}, {load}" for design in DESIGNS for load in ("no load", "36.68 N m")]
            assert [title.split(": mean")[0] for title in titles] == cases
            assert figure.get_supylabel()
        assert figure.get_suptitle().endswith("1640 rpm")
    for figure in drawn.values():
        figure.draw_without_rendering()
        ends = [axes._left_title.get_window_extent().x1 for axes in figure.axes]
        assert max(ends) <= figure.bbox.x1, figure.get_suptitle()
    error = drawn["compare_transmission_error"].axes[1].lines[0].get_ydata()
    truth = 3600 * np.degrees(motions[3].output_angle.error[motions[3].one_turn])
    assert error == pytest.approx(truth - truth.mean())
    assert f"mean {truth.mean():.4g} arcsec" in drawn["compare_transmission_error"].axes[1].get_title(loc="left")
    speed = drawn["compare_gear_speed"].axes[1].lines[0].get_ydata()
    assert speed == pytest.approx(1e3 * motions[3].gear_speed.error[motions[3].one_turn])


@pytest.mark.parametrize("names", [("printed", "pin"), ("pin", "printed"), ("printed", "nonpin")], ids=" ".join)
def test_designs_with_other_settling_times_and_tables_are_compared(names: tuple[str, str]) -> None:
    """The slowest decides the hold of all, whichever is named first, and a key that one lacks is a difference."""
    first = load_design(names[0], DEFAULTS, ())
    cases = list_cases([load_design(name, (), ()) for name in names], first, 5.0, "planar")
    for load in (0.0, 5.0):
        own = [case for case in cases if case.load.torque == load]
        assert len(own) >= 2
        (hold,) = {case.drive.hold for case in own}
        assert hold > max(settling_time(Reducer(case)) for case in own)
    found = differences(list(comparable(cases).values())[:2])
    assert None in found["pin_material.name"]
    assert "bearing steel" in found["pin_material.name"]


def test_cases_that_cannot_be_compared_are_refused_before_they_run() -> None:
    pin, nonpin = PRESETS["pin"], PRESETS["nonpin"]
    assert list(comparable([pin, nonpin])) == ["pin", "nonpin"]
    for spoiled, words in (
        (override(nonpin, ["drive.hold_s=0.3"]), r"drive\.hold_s is .* for pin at no load, but 0\.3 for nonpin"),
        (override(nonpin, ["load.torque_nm=5"]), "the run of pin at 5 N m is missing"),
        (pin.but(name="nonpin", environment={"gravity_x": 1.0}), r"environment\.gravity_x_m_s2"),
    ):
        with pytest.raises(UsageError, match=words):
            comparable([pin, spoiled])


@pytest.mark.parametrize("times", [0.5, 6.0, 60.0])
def test_an_overload_is_reported_before_the_run(here, planned, capfd, times: float) -> None:
    """A second design of a tenth of the face width, under a multiple of the torque at which it first yields."""
    narrow = PRESETS["printed"].but(name="narrow", gear={"face_width": 0.5 * PRESETS["printed"].gear.face_width})
    (here / "narrow.toml").write_text(dump(narrow))
    load = times * catalogue_figure("capacity_nm").value(Reducer(narrow))
    code, _, err = told("compare", "printed", "narrow.toml", "--quick", "--load-nm", f"{load:.6g}", "--out", "c")
    assert code == 1
    assert "nothing is run here" in err
    said = " ".join(err.split())
    assert ("narrow: the load of" in said) == (times > 1.0)
    assert overloads([narrow.but(load={"torque": load})]).keys() == ({"narrow"} if times > 1.0 else set())
    if times > 1.0:
        ratio = float(re.search(r"narrow: the load of [\d.e+-]+ N m is ([\d.e+-]+) times its capacity", said)[1])
        assert ratio == pytest.approx(times, rel=0.02)


def test_the_headline_has_a_column_for_each_design_and_their_ratio() -> None:
    by_design = catalogue_figures([PRESETS["pin"], PRESETS["nonpin"]])
    table = catalogue_table(by_design)
    assert table.header == ("figure", "pin", "nonpin", "ratio", "unit")
    key, pin, nonpin, ratio, unit = next(row for row in table.rows if row[0] == "mass_kg")
    assert (key, unit) == ("mass_kg", "kg")
    assert float(ratio) == pytest.approx(nonpin / pin, rel=1e-3)
    assert ratio_columns(("a", "b", "c")) == ("b / a", "c / a")
