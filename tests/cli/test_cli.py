"""The command line, called in-process: main paths, interface that others rely on, and every mistake's exit code."""

import json
import math
import os
import re
import signal
import subprocess
import sys
import threading
from importlib.util import cache_from_source
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from commands import told

import cycloid_mj.dynamics.run
from cycloid_mj import __version__
from cycloid_mj.base import frame
from cycloid_mj.base.errors import DesignError, LogError, RunError
from cycloid_mj.base.interrupt import Stopped, defer_signals
from cycloid_mj.cli import flags, main, terminal
from cycloid_mj.cli.app import FOLDED, application
from cycloid_mj.cli.process import BLAS_THREADS, LOADED, first_start
from cycloid_mj.cli.progress import Progress
from cycloid_mj.design import PRESETS, dump, loads, override
from cycloid_mj.design.presets import preset_reasons
from cycloid_mj.dynamics.timestep import timestep
from cycloid_mj.figures import quantity
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.geometry.kinematics import CrankLaw
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.log import LogWriter, read
from cycloid_mj.reducer import Reducer

DATA = Path(__file__).parents[1] / "data"
PAPER = CycloidGear(ring_teeth=36, eccentricity=1e-3, pin_circle_radius=40.75e-3, pin_radius=2.25e-3)
SHORT = ("--ramp-s", "0", "--hold-s", "0.01")
COMMANDS = ("simulate", "analyze", "log plot", "design profile", "design kinematics", "design show", "design check")

FIXED_KEYS = {
    "design": None,
    "contact": None,
    "log": None,
    "timestep_s": None,
    "timestep": None,
    "steps": None,
    "wall_s": None,
    "crank": ["speed_rad_s", "max_relative_error"],
    "gear_speed": ["theory_rad_s", "mean_rad_s", "rms_error_rad_s", "peak_error_rad_s"],
    "q_path": ["q_mm", "rms_error_um", "max_error_um"],
    "q_speed": ["rms_error_mm_s", "max_error_mm_s"],
    "transmission_error": ["peak_to_peak_arcsec", "mean_arcsec"],
    "contact_summary": ["mean_active", "max_penetration_um", "peak_force_n"],
    "pin1": ["max_radial_um", "mean_spin_rad_s"],
}
"""The fixed interface: keys of the JSON object, and the keys of those that are objects."""


@pytest.fixture(autouse=True)
def no_progress_lines(monkeypatch):
    """On a slow machine a run takes long enough for a line of progress; what a command prints must not depend on it."""
    monkeypatch.setattr("cycloid_mj.cli.progress.SECONDS_BETWEEN_LINES", math.inf)


def rejected(*argv: str) -> tuple[int, str]:
    """Exit code and message of a mistake, which must be one line, beside warnings of a run, and leave stdout empty."""
    code, out, err = told(*argv)
    messages = [
        line
        for line in err.splitlines()
        if not line.startswith(("preparing the model", "evaluating the run", "time step ", "warning: "))
    ]
    assert out == ""
    assert len(messages) == 1, err
    assert messages[0].startswith("error: ")
    return code, messages[0]


def one_object(text: str) -> dict:
    """Parse stdout that must hold exactly one JSON object: nothing after it, and no NaN."""
    found = json.loads(text, parse_constant=pytest.fail)
    assert isinstance(found, dict)
    return found


def table_of(path: Path) -> tuple[list[str], np.ndarray]:
    header, *rows = path.read_text().splitlines()
    return header.split(","), np.array([[float(word) for word in row.split(",")] for row in rows])


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Findings and log of a short run, made through the command line."""
    folder = tmp_path_factory.mktemp("run")
    code, out, err = told("simulate", "--design", "pin", *SHORT, "--out", str(folder), "--json", "--quiet")
    assert (code, err) == (0, "")
    return one_object(out), folder / "pin.mcap"


# --- help and start ---------------------------------------------------------------------------------------------------


def test_version_and_bare_command():
    assert told("--version") == (0, f"{__version__}\n", "")
    code, out, err = told()
    assert (code, err) == (0, "")
    assert all(command.split()[0] in out for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_states_purpose_flags_and_an_example(command):
    code, out, err = told(*command.split(), "--help")
    assert (code, err) == (0, "")
    examples = out.split("Example")[-1]
    assert f"cycloid-mj {command}" in examples
    assert max(map(len, out.splitlines())) <= 80, "lines of help would be broken on a plain terminal"


def test_every_flag_of_the_fixed_interface_states_unit_and_default():
    out = " ".join(told("simulate", "--help")[1].replace("│", " ").split())
    for flag, unit in [
        ("--timestep-us", "[us]"),
        ("--speed-rpm", "[rpm]"),
        ("--ramp-s", "[s]"),
        ("--hold-s", "[s]"),
        ("--load-nm", "[N m]"),
    ]:
        text = out.split(f"{flag} X ")[1].split(" --")[0]
        assert unit in text
        assert "Default:" in text


@pytest.mark.slow
def test_every_example_of_the_help_is_parsed():
    """An unknown flag at the end is found last: when all that stands before it has been understood."""
    for module in ("simulate", "analyze", "log plot", "design profile", "design kinematics", "design"):
        text = told(*module.split(), "--help")[1].split("Examples:")[1].replace("\\\n", " ")
        lines = [line.split(">")[0].split() for line in text.splitlines() if "cycloid-mj" in line]
        assert lines
        for line in lines:
            argv = [*line[1:], "--no-such-flag"]
            assert "--no-such-flag" in rejected(*argv)[1]


def test_help_imports_nothing_heavy():
    script = (
        "import sys; from cycloid_mj.cli import main; main(['--help']);"
        "print([m for m in ('mujoco', 'numba', 'numpy', 'scipy', 'trimesh', 'matplotlib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


# --- simulate ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_json_of_a_run_has_the_fixed_keys(run):
    found, log = run
    assert list(found)[: len(FIXED_KEYS)] == list(FIXED_KEYS)
    for key, inner in FIXED_KEYS.items():
        assert inner is None or list(found[key]) == inner
    assert found["design"] == "pin"
    assert found["log"] == str(log)
    assert found["timestep_s"] == timestep(Reducer(PRESETS["pin"]))
    assert found["timestep"] == "6.66667 us (automatic: stiffness of pin_socket)"
    assert found["steps"] == round(0.01 / found["timestep_s"])
    assert found["wall_s"] > 0
    assert found["q_path"]["q_mm"] == [0.0, 26.0]


def test_run_agrees_with_the_signs_and_sizes_of_the_closed_form(run):
    found, _ = run
    omega = 1640 * 2 * math.pi / 60
    assert found["crank"]["speed_rad_s"] == pytest.approx(omega, rel=1e-4)
    assert found["gear_speed"]["theory_rad_s"] == pytest.approx(-omega / 35, rel=1e-4)
    assert found["q_path"]["max_error_um"] < 5


def test_log_holds_the_design_the_model_and_the_settings(run):
    _, log = run
    logged = read(log)
    asked = override(PRESETS["pin"], ["drive.ramp_s=0", "drive.hold_s=0.01"])
    assert loads(logged.attachments["design.toml"].decode()) == asked
    assert logged.attachments["model.xml"].startswith(b"<mujoco")
    assert logged.provenance["timestep_s"] == repr(timestep(Reducer(asked)))
    assert logged.complete


@pytest.mark.slow
@pytest.mark.parametrize(("between_lines", "progress"), [(math.inf, False), (-1.0, True)])
def test_the_table_of_a_run_is_on_stdout_and_messages_are_on_stderr(here, monkeypatch, between_lines, progress):
    monkeypatch.setattr("cycloid_mj.cli.progress.SECONDS_BETWEEN_LINES", between_lines)
    code, out, err = told("simulate", "--design", "pin", *SHORT, "--all")
    assert code == 0
    first, step, *lines, judging, last, drawing, wrote = [line for line in err.splitlines() if "s so far" not in line]
    assert first == "preparing the model"
    assert (judging, drawing) == ("evaluating the run", "drawing the page of the run")
    assert wrote == "wrote runs/pin-review.html"
    assert step == (
        "time step 6.66667 us (automatic: stiffness of pin_socket); accuracy of the results: "
        "only ranges over independent starts are valid: without load, the motion within the clearances is chaotic"
    )
    # 0.01 s at 1640 rpm are 0.27 turns, half of which is settling
    assert last.startswith("warning: pin: only 0.13 crank turns")
    assert bool(lines) == progress
    assert all(re.fullmatch(r" *\d+%  \S+ of 0.01 s simulated(, about \d+ s left)?", line) for line in lines), err
    assert Path("runs/pin-review.html").read_text().startswith("<!doctype html>")
    assert "log: runs/pin.mcap; page for a browser: runs/pin-review.html" in out
    assert "no load: the output drives nothing (load.torque_nm = 0)" in out
    loaded = re.search(r"at the nominal torque of 36\.68 N m, by statics: .*stiffness ([\d.]+) N m/arcmin", out)
    sheet = quantity(Reducer(PRESETS["pin"]), "stiffness_nm_per_arcmin").value
    assert float(loaded.group(1)) == pytest.approx(sheet, rel=5e-3)
    commands = [line.split("    #")[0].split()[1:] for line in out.splitlines() if line.startswith("next: cycloid-mj ")]
    assert [words[1] for words in commands] == ["simulate", "design", "statics", "reduce"]
    for words in commands:
        application(words[1:2]).parse_args(words[1:])
    for words in ("quantity", "simulated", "closed form", "error", "gear speed", "runs/pin.mcap", "wall time"):
        assert words in out


def test_nonpin_run_has_no_pin_1(here):
    code, out, _ = told("simulate", "--design", "nonpin", *SHORT, "--json", "--quiet")
    assert code == 0
    assert [path.name for path in Path("runs").iterdir()] == ["nonpin.mcap"], "no page for programs"
    assert one_object(out)["pin1"] is None


def test_planar_run_with_single_needles_logs_a_model_with_lumped_ones(here):
    flags = ("--solver", "planar", "--ramp-s", "0", "--hold-s", "0.002", "--set", "contact.needles=each", "--json")
    code, out, err = told("simulate", "pin", *flags)
    assert code == 0, err
    files = read(json.loads(out)["log"]).attachments
    assert loads(files["design.toml"].decode()).contact.needles == "each"
    assert files["model.xml"].startswith(b"<mujoco")


def test_flags_overrule_set_which_overrules_the_file(here):
    Path("mine.toml").write_text(dump(override(PRESETS["pin"], ["drive.speed_rpm=100", "load.torque_nm=3"])))
    code, out, _ = told(
        *("simulate", "--design", "mine.toml", "--set", "drive.speed_rpm=200", "--set", "name=other"),
        *("--speed-rpm", "-1000", "--load-nm", "5", "--timestep-us", "4", *SHORT, "--json"),
    )
    assert code == 0
    found = one_object(out)
    design = loads(read(found["log"]).attachments["design.toml"].decode())
    assert found["log"] == "runs/other.mcap"
    assert design.drive.speed == -1000 * 2 * math.pi / 60
    assert (design.load.torque, design.settings.timestep, design.drive.ramp, design.drive.hold) == (5, 4e-6, 0, 0.01)
    assert found["gear_speed"]["theory_rad_s"] == pytest.approx(1000 * 2 * math.pi / 60 / 35, rel=1e-3)


@pytest.fixture
def two_samples(monkeypatch):
    """Let runs last an instant: the given blocks, then what `end` raises."""
    ends = []

    def blocks(compiled, reducer):
        groups = cycloid_mj.dynamics.run.log_columns(compiled, reducer)
        for first in (0, 2):
            time = 1e-4 * np.arange(first, first + 2)
            yield cycloid_mj.dynamics.run.SampleBlock(
                time, {topic: np.zeros((2, len(group))) for topic, group in groups.items()}
            )
            if first and ends:
                raise ends[0]
        return ()

    monkeypatch.setattr(cycloid_mj.dynamics.run, "blocks", blocks)
    return ends


@pytest.mark.slow
def test_next_runs_in_the_usual_folder_take_free_names(here, two_samples):
    for name in ("pin", "pin-2", "pin-3"):
        assert one_object(told("simulate", "--design", "pin", *SHORT, "--json")[1])["log"] == f"runs/{name}.mcap"


@pytest.mark.slow
def test_log_in_a_named_folder_is_replaced_only_by_force(here, two_samples):
    argv = ("simulate", "--design", "pin", *SHORT, "--out", "mine", "--quiet")
    assert told(*argv)[0] == 0
    before = Path("mine/pin.mcap").read_bytes()
    code, message = rejected(*argv, "--load-nm", "1")
    assert code == 1
    assert "mine/pin.mcap already exists" in message
    assert "--force" in message
    assert Path("mine/pin.mcap").read_bytes() == before
    assert told(*argv, "--load-nm", "1", "--force")[0] == 0
    assert loads(read("mine/pin.mcap").attachments["design.toml"].decode()).load.torque == 1
    assert sorted(path.name for path in Path("mine").iterdir()) == ["pin-review.html", "pin.mcap"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("end", "words", "ended"),
    [
        (KeyboardInterrupt(), "stopped by Ctrl-C", 130),
        (Stopped("SIGTERM"), "stopped by SIGTERM", 143),
        (RunError("the gear jumped a tooth"), "jumped", 1),
    ],
)
def test_run_that_ends_early_leaves_a_readable_log(here, two_samples, end, words, ended):
    two_samples.append(end)
    code, message = rejected("simulate", "--design", "pin", *SHORT, "--json")
    assert code == ended
    assert words in message
    assert "the 4 samples up to then are in runs/pin.mcap" in message
    run = read("runs/pin.mcap")
    assert (len(run), run.complete) == (4, False)
    assert words in run.note


def test_ctrl_c_while_samples_are_written_cuts_none_in_two(here, two_samples, monkeypatch):
    write = LogWriter.write

    def interrupted(self, time, values):
        signal.raise_signal(signal.SIGINT)
        write(self, time, values)

    monkeypatch.setattr(LogWriter, "write", interrupted)
    code, message = rejected("simulate", "--design", "pin", *SHORT)
    assert code == 130
    assert "the 2 samples up to then" in message
    assert len(read("runs/pin.mcap")) == 2


def test_defer_signals_delays_ctrl_c_and_restores_the_old_handler():
    before, seen = signal.getsignal(signal.SIGINT), []

    def work():
        with defer_signals():
            signal.raise_signal(signal.SIGINT)
            seen.append("whole")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert seen == ["whole"]
    assert signal.getsignal(signal.SIGINT) is before


def test_main_runs_in_another_thread(here, two_samples):
    codes = []
    thread = threading.Thread(target=lambda: codes.append(main(["simulate", "--design", "pin", *SHORT, "--quiet"])))
    thread.start()
    thread.join()
    assert codes == [0]


def test_ctrl_c_before_the_run_is_reported(here, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("cycloid_mj.dynamics.run.build", interrupted)
    assert rejected("simulate", "--design", "pin", *SHORT) == (130, "error: stopped by Ctrl-C")


def test_a_full_disk_is_reported_in_one_line(here, two_samples, monkeypatch):
    def full(self, time, values):
        raise LogError("cannot write log: No space left on device")

    monkeypatch.setattr(LogWriter, "write", full)
    code, message = rejected("simulate", "--design", "pin", *SHORT)
    assert code == 1
    assert "No space left" in message


def test_progress_without_a_terminal_is_an_occasional_line(monkeypatch, capsys):
    now = 0.0
    monkeypatch.setattr("cycloid_mj.cli.progress.SECONDS_BETWEEN_LINES", 10.0)
    monkeypatch.setattr("cycloid_mj.cli.progress.monotonic", lambda: now)
    with Progress(end=2.0) as progress:
        for seconds, simulated in ((60.0, 0.2), (64.0, 0.4), (71.0, 0.5), (72.0, 0.6)):
            now = seconds
            progress.report_time(simulated)
        progress.judging()
    captured = capsys.readouterr()
    assert captured.err.splitlines() == [
        "preparing the model",
        " 10%  0.200 of 2 s simulated",
        " 25%  0.500 of 2 s simulated, about 55 s left",  # 11 s for 0.3 s: the minute before was no run
        "evaluating the run",
    ]
    assert captured.out == ""


def test_progress_is_reported_before_the_first_sample(monkeypatch, capsys):
    monkeypatch.setattr("cycloid_mj.cli.progress.SECONDS_BETWEEN_COUNTS", 0.01)
    told_so_far = threading.Event()
    monkeypatch.setattr("cycloid_mj.cli.progress.tell", lambda text: "so far" in text and told_so_far.set())
    with Progress(end=2.0) as progress:
        assert told_so_far.wait(60.0)
        progress.report_time(0.2)
    with Progress(end=2.0, quiet=True):
        assert capsys.readouterr().err == ""


@pytest.mark.parametrize("width", [20, 60, 500])
def test_progress_on_a_terminal_is_a_bar_that_vanishes(width, monkeypatch):
    class Terminal(StringIO):
        def isatty(self):
            return True

    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", str(width))
    with Progress(end=2.0) as progress:
        progress.report_time(1.0)
    assert "50%" in stream.getvalue()
    assert width < 60 or "1.000 of 2 s" in stream.getvalue()


# --- analyze and plot -------------------------------------------------------------------------------------------------


def test_analyze_prints_the_results_of_simulate(run):
    found, log = run
    code, out, err = told("analyze", str(log), "--json")
    assert code == 0
    again = one_object(out)
    assert err.splitlines() == [f"warning: pin: {text}" for text in again["warnings"]]
    assert again.pop("wall_s") is None
    assert again == {key: value for key, value in found.items() if key != "wall_s"}


def test_analyze_follows_the_point_requested(run):
    _, log = run
    found = one_object(told("analyze", str(log), "--q", "-3,4.5", "--json")[1])
    assert found["q_path"]["q_mm"] == [-3, 4.5]


def test_analyze_prints_the_table(run):
    code, out, _ = told("analyze", str(run[1]))
    assert code == 0
    assert "transmission error" in out
    assert str(run[1]) in out


@pytest.mark.slow
def test_analysis_and_plots_do_not_import_mujoco(run, tmp_path):
    script = (
        "import sys; from cycloid_mj.cli import main;"
        "codes = [main(['analyze', sys.argv[1]]), main(['plot', sys.argv[1], '--out', sys.argv[2]])];"
        "print(codes, 'mujoco' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(run[1]), str(tmp_path)], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "[0, 0] False"


def test_log_that_was_cut_is_judged_with_a_note(run, tmp_path):
    whole = run[1].read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[:-100])
    code, out, err = told("analyze", str(cut), "--json")
    found = one_object(out)
    assert code == 0
    assert err.startswith("warning: pin: the run is incomplete")
    assert found["warnings"][0].startswith("the run is incomplete")
    assert (found["complete"], found["steps"]) == (False, None)


def test_plot_draws_the_figures_and_prints_their_paths(run, tmp_path):
    code, out, err = told("log", "plot", str(run[1]), "--out", str(tmp_path), "--format", "svg", "--q", "3,4")
    assert code == 0
    assert err.startswith("warning: pin: only 0.13 crank turns")
    paths = [Path(line) for line in out.splitlines()]
    assert {path.suffix for path in paths} == {".svg"}
    assert sorted(path.name[:4] for path in paths if path.name.startswith("fig")) == [f"fig{n}" for n in range(5, 10)]
    assert sorted(paths) == sorted(tmp_path.iterdir())
    assert all(path.stat().st_size > 1000 for path in paths)


@pytest.mark.slow
def test_plot_puts_figures_beside_the_log(run):
    _, log = run
    first = Path(told("log", "plot", str(log))[1].splitlines()[0])
    assert first.parent == log.parent / "pin"
    assert first.read_bytes().startswith(b"\x89PNG")


# --- profile ----------------------------------------------------------------------------------------------------------


def test_profile_writes_the_outline_with_every_digit(tmp_path):
    file = tmp_path / "gear.csv"
    code, out, err = told("design", "profile", "--design", "pin", "--csv", str(file), "--points", "701")
    assert (code, out, err) == (0, "", f"wrote 701 rows of 5 columns to {file}\n")
    header, rows = table_of(file)
    assert header == ["x_mm", "y_mm", "nx", "ny", "curvature_per_mm"]
    outline = profile.sample(PAPER, 701)
    expected = np.column_stack([1e3 * outline.points, outline.normals, 1e-3 * outline.curvature])
    assert np.array_equal(rows, expected)


@pytest.mark.slow
def test_out_also_names_a_file_which_is_written_silently(tmp_path):
    file = tmp_path / "gear.csv"
    assert told("design", "profile", "--design", "pin", "--out", str(file), "--quiet") == (0, "", "")
    assert file.read_text().startswith("x_mm,y_mm")


def test_profile_passes_through_the_reference_points(tmp_path):
    """A reference point at the distance s from its nearest row lies kappa s^2/2 inside the tangent there.

    What is left is of third order: 10/mm^2 (0.005 mm)^3 / 6 < 1e-6 mm.
    """
    file = tmp_path / "gear.csv"
    assert told("design", "profile", "--design", "pin", "--csv", str(file), "--points", "35000")[0] == 0
    _, rows = table_of(file)
    reference = np.loadtxt(DATA / "gear_points.csv", delimiter=",", skiprows=1, usecols=(3, 4))

    def residual(curvature_sign):
        nearest = [int(np.argmin(np.sum((rows[:, :2] - point) ** 2, axis=1))) for point in reference]
        away = reference - rows[nearest, :2]
        bulge = curvature_sign * rows[nearest, 4] * np.sum(away**2, axis=1) / 2
        return np.max(np.abs(np.sum(away * rows[nearest, 2:4], axis=1) + bulge))

    assert residual(+1) < 1e-6
    assert residual(-1) > 1e-5


def test_profile_is_one_closed_outline_by_arc_length(tmp_path):
    file = tmp_path / "gear.csv"
    assert told("design", "profile", "--design", "pin", "--csv", str(file))[0] == 0
    x, y = table_of(file)[1][:, :2].T
    assert len(x) == 3500
    chords = np.hypot(np.roll(x, -1) - x, np.roll(y, -1) - y)
    arc = 1e3 * profile.length(PAPER) / len(x)
    # a chord of a bend of 1/0.358 mm falls short of its arc by (arc/0.358)^2/24
    assert np.all((chords <= arc * (1 + 1e-12)) & (chords > arc * (1 - (arc / 0.358) ** 2 / 24 * 1.01)))


def test_profile_of_the_ring_has_its_parts(tmp_path):
    file = tmp_path / "ring.csv"
    assert (
        told("design", "profile", "--design", "nonpin", "--part", "ring", "--csv", str(file), "--points", "500")[0] == 0
    )
    header, *lines = file.read_text().splitlines()
    assert header == "x_mm,y_mm,nx,ny,curvature_per_mm,part"
    words = [line.split(",") for line in lines]
    ring = envelope.sample_ring(PAPER, 500)
    expected = np.column_stack([1e3 * ring.points, ring.normals, 1e-3 * ring.curvature])
    assert np.array_equal(np.array([[float(word) for word in row[:5]] for row in words]), expected)
    assert [row[5] for row in words] == ring.part.tolist()
    assert {row[5] for row in words} == {"arc", "sigma1", "sigma2"}


# --- kinematics -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("table", "argv"),
    [
        ("traj_const_q0_24.csv", ("--ramp-s", "0", "--until-s", "0.1097560975609756")),
        ("traj_ramp_q0_24.csv", ("--step-s", "0.001", "--until-s", "1.1")),
    ],
)
def test_kinematics_agrees_with_the_30_digit_reference(table, argv, tmp_path):
    file = tmp_path / "q.csv"
    code, out, _ = told("design", "kinematics", "--design", "pin", "--q", "0,24", "--csv", str(file), *argv)
    assert (code, out) == (0, "")
    header, rows = table_of(file)
    assert header == ["t_s", "crank_rad", "x_mm", "y_mm", "vx_mm_s", "vy_mm_s", "ax_mm_s2", "ay_mm_s2"]
    t, crank_deg, _, x, y, vx, vy, _, ax, ay = np.loadtxt(DATA / table, delimiter=",", skiprows=1, usecols=range(10)).T
    assert rows.shape == (len(t), 8)
    assert np.allclose(rows[:, 0], t, rtol=1e-14, atol=0)
    assert np.allclose(rows[:, 1], np.radians(crank_deg), rtol=1e-9, atol=0)
    for columns, expected in (((2, 3), (x, y)), ((4, 5), (vx, vy)), ((6, 7), (ax, ay))):
        vectors = np.column_stack(expected)
        off = np.linalg.norm(rows[:, columns] - vectors, axis=1)
        assert np.all(off <= 1e-9 * np.linalg.norm(vectors, axis=1))


def test_kinematics_takes_ramp_hold_and_one_degree_by_default(tmp_path):
    file = tmp_path / "q.csv"
    assert told("design", "kinematics", "--design", "pin", "--csv", str(file))[0] == 0
    _, rows = table_of(file)
    step = math.radians(1) / PRESETS["pin"].drive.speed
    assert np.array_equal(rows[:, 0], step * np.arange(len(rows)))
    assert rows[-1, 0] <= 1.25 * (1 + 1e-12) < rows[-1, 0] + step
    assert rows[0, 2:4].tolist() == [0, 26]
    law = CrankLaw(PRESETS["pin"].drive.speed, 1.0)
    assert np.array_equal(rows[:, 1], law.angle_at(rows[:, 0]))


# --- changes of the design --------------------------------------------------------------------------------------------


def test_kinematics_and_profile_take_changes_of_the_design(tmp_path):
    file = tmp_path / "k.csv"
    argv = ("--until-s", "0.002", "--step-s", "0.001", "--csv", str(file))
    assert (
        told(
            "design", "kinematics", "--design", "pin", "--set", "drive.ramp_s=0", "--set", "drive.speed_rpm=600", *argv
        )[0]
        == 0
    )
    _, rows = table_of(file)
    assert rows[:, 1] == pytest.approx(20.0 * math.pi * np.array([0.0, 0.001, 0.002]))
    assert (
        told(
            "design",
            "kinematics",
            "--design",
            "pin",
            "--set",
            "drive.speed_rpm=600",
            "--speed-rpm",
            "60",
            *argv,
            "--force",
        )[0]
        == 0
    )
    assert table_of(file)[1][-1, 1] == pytest.approx(2.0 * math.pi * 0.002**2 / 2.0)
    outline = tmp_path / "p.csv"
    assert told("design", "profile", "--design", "pin", "--set", "ring.pin_radius_mm=2", "--csv", str(outline))[0] == 0
    largest = np.hypot(*table_of(outline)[1][:, :2].T).max()
    assert largest == pytest.approx(40.75 - 2.0 + 1.0, abs=1e-9)


def test_design_show_applies_changes_and_drops_their_reasons():
    _, shown, _ = told("design", "show", "twodisc", "--set", "gear.disc_gap_mm=5")
    assert loads(shown) == PRESETS["twodisc"].but(gear={"disc_gap": 0.005})
    (line,) = [line for line in shown.splitlines() if line.startswith("disc_gap_mm")]
    assert "worked calculation" not in line
    assert "worked calculation" in next(line for line in shown.splitlines() if line.startswith("face_width_mm"))


@pytest.mark.parametrize(
    "words", [("design", "kinematics", "--csv", "x.csv"), ("design", "profile", "--csv", "x.csv")], ids=lambda w: w[1]
)
def test_a_change_of_an_unknown_key_is_wrong_usage(words):
    code, message = rejected(*words, "--design", "pin", "--set", "ring.teth=3")
    assert (code, "ring.teth" in message) == (2, True)


# --- files ------------------------------------------------------------------------------------------------------------


def test_csv_is_written_to_stdout_only():
    code, out, err = told(
        "design", "kinematics", "--design", "pin", "--csv", "-", "--until-s", "0.01", "--step-s", "0.005"
    )
    assert (code, err) == (0, "")
    assert len(out.splitlines()) == 4


def test_csv_is_replaced_only_when_complete(tmp_path, monkeypatch):
    file = tmp_path / "gear.csv"
    file.write_text("old")

    def broken(columns, stream, missing):
        stream.write("new")
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(frame, "write_rows", broken)
        code, message = rejected("design", "profile", "--design", "pin", "--csv", str(file), "--force")
    assert (code, "No space left" in message) == (1, True)
    assert file.read_text() == "old"
    assert told("design", "profile", "--design", "pin", "--csv", str(file), "--force")[0] == 0
    assert file.read_text().startswith("x_mm,")
    assert list(tmp_path.iterdir()) == [file]


def test_csv_follows_a_link_and_keeps_it(tmp_path):
    (tmp_path / "link.csv").symlink_to(tmp_path / "real.csv")
    assert told("design", "profile", "--design", "pin", "--csv", str(tmp_path / "link.csv"))[0] == 0
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "real.csv").read_text().startswith("x_mm,")


@pytest.mark.slow
def test_closed_pipe_ends_the_command_without_output():
    command = [sys.executable, "-m", "cycloid_mj", "design", "kinematics", "--design", "pin", "--csv", "-"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout
        assert process.stderr
        process.stdout.readline()
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 1


def test_json_has_null_where_there_is_no_number(capsys):
    terminal.say_json({"a": math.nan, "b": [math.inf, 1.5], "c": {"d": -math.inf}})
    assert one_object(capsys.readouterr().out) == {"a": None, "b": [None, 1.5], "c": {"d": None}}


# --- design -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", PRESETS)
def test_design_show_prints_the_whole_commented_file(name, tmp_path):
    code, out, err = told("design", "show", name)
    assert (code, err) == (0, "")
    assert loads(out) == PRESETS[name]
    assert out.count("(assumed)") > 10
    file = tmp_path / "mine.toml"
    file.write_text(out)
    code, again, err = told("design", "show", str(file))
    assert (code, loads(again), err) == (0, PRESETS[name], "")
    if not preset_reasons(name, PRESETS[name]):  # a file of one's own has none of the preset's
        assert again == out


def test_design_check_passes_a_preset():
    code, out, err = told("design", "check", "pin")
    assert (code, err) == (0, "")
    warned = {line.split()[1] for line in out.splitlines() if line.startswith("warn")}
    assert warned == {"tooth_yield:", "momentary_torque:", "life:", "heat:", "strength:"}
    assert "FAIL" not in out
    assert out.splitlines()[-1].endswith("checks: 0 failed, 5 warnings")


@pytest.fixture
def unsound(tmp_path):
    file = tmp_path / "bad.toml"
    file.write_text(dump(override(PRESETS["pin"], ["gear.eccentricity_mm=1.5", "housing.outer_radius_mm=42"])))
    return str(file)


def test_design_check_lists_all_failures_with_remedies(unsound):
    code, out, err = told("design", "check", unsound, "--all")
    assert (code, err) == (1, "")
    failed = [line for line in out.splitlines() if line.startswith("FAIL")]
    for key in ("gear.eccentricity_mm", "housing.outer_radius_mm", "output.hole_radius_mm"):
        assert any(key in line and ("raise" in line or "lower" in line) for line in failed)
    assert out.splitlines()[-1].split(": ")[1] == f"{len(failed)} failed, 0 warnings"
    assert sum(line.startswith("ok ") for line in out.splitlines()) > 5


def test_design_check_json(unsound):
    code, out, _ = told("design", "check", unsound, "--json")
    found = one_object(out)
    assert (code, found["sound"]) == (1, False)
    keys = {"name", "passed", "severity", "key", "got", "limit", "why", "remedy", "value", "bound", "unit", "judgement"}
    assert keys == set(found["checks"][0])
    assert found["summary"] is None
    assert one_object(told("design", "check", "nonpin", "--json")[1])["sound"]


def test_warnings_do_not_fail_a_design(tmp_path):
    file = tmp_path / "loaded.toml"
    file.write_text(dump(override(PRESETS["pin"], ["load.torque_nm=50"])))
    code, out, _ = told("design", "check", str(file))
    assert code == 0
    assert "warn  load" in out
    assert out.splitlines()[-1].endswith("0 failed, 6 warnings")


def test_unsound_design_is_not_simulated_and_every_reason_is_reported(unsound, here):
    code, out, err = told("simulate", "--design", unsound)
    assert (code, out) == (1, "")
    assert err.startswith("error: the design 'pin' cannot be built:")
    assert all(key in err for key in ("gear.eccentricity_mm", "housing.outer_radius_mm"))
    assert not list(here.glob("runs/*"))


@pytest.mark.parametrize("command", FOLDED)
def test_a_command_of_a_group_is_found_by_its_name_in_scripts(command: str, capsys) -> None:
    assert main([command, "--help"]) == 0
    shown = capsys.readouterr()
    assert " ".join(FOLDED[command]) in shown.out
    assert shown.err == (
        f"warning: the command `{command}` is deprecated: use `{' '.join(FOLDED[command])}`; the old name will be "
        "removed in the next release\n"
    )


# --- mistakes ---------------------------------------------------------------------------------------------------------

SIMULATE = ("simulate", "--design", "pin")
PROFILE = ("design", "profile", "--design", "pin", "--csv", "x.csv")
MOTION = ("design", "kinematics", "--design", "pin", "--csv", "x.csv")


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("frob",), ("frob", "simulate")),
        (("simulat",), ("did you mean", "simulate")),
        (("sim",), ("did you mean simulate?",)),
        (("check",), ("did you mean design check?",)),
        (("re",), ("did you mean report or render or reduce or reproduce?",)),
        (("measure", "frob"), ("'frob'", "te, backlash", "vibration", "measure --help")),
        (("measure", "los"), ("did you mean lost-motion?",)),
        (("log", "frob"), ("'frob'", "info", "layout")),
        (("measure", "--frob"), ("--frob", "after a command")),
        (("design", "--frob"), ("--frob", "after a command")),
        (("log", "info", "--frob"), ("LOG",)),
        (("measure", "loads", "--frob"), ("--frob", "measure loads --help")),
        (("design", "chck"), ("check",)),
        (("design", "check"), ("DESIGN", "needs a value")),
        (("--frob",), ("--frob",)),
        (("simulate",), ("--design", "needs a value")),
        (("simulate", "--desgin", "pin"), ("unknown option --desgin", "did you mean --design?")),
        ((*SIMULATE, "more"), ("'more'",)),
        (("simulate", "--design", "pon"), ("'pon'", "pin")),
        (("simulate", "--design", "my.toml"), ("my.toml", "neither")),
        ((*SIMULATE, "--speed-rmp", "5"), ("--speed-rmp", "--speed-rpm")),
        ((*SIMULATE, "--speed-rpm"), ("--speed-rpm", "needs a value")),
        ((*SIMULATE, "--speed-rpm", "--json"), ("--speed-rpm", "needs a value")),
        ((*SIMULATE, "--speed-rpm", "fast"), ("--speed-rpm", "'fast'", "number")),
        ((*SIMULATE, "--speed-rpm", "5", "--speed-rpm", "6"), ("--speed-rpm", "multiple")),
        ((*SIMULATE, "--no-json"), ("--no-json", "--json")),
        ((*SIMULATE, "--json=perhaps"), ("--json", "perhaps")),
        ((*SIMULATE, "--set", "load.torqe_nm=3"), ("load.torqe_nm", "load.torque_nm")),
        ((*SIMULATE, "--set", "load.torque_nm"), ("--set", "table.key=value")),
        ((*SIMULATE, "--set", "load.torque_nm=nan"), ("load.torque_nm",)),
        ((*SIMULATE, "--set", "drive.speed_rpm=0"), ("drive.speed_rpm", "0")),
        ((*SIMULATE, "--hold-s", "1e-5"), ("--hold-s",)),
        ((*SIMULATE, "--timestep-us", "1e-9"), ("--timestep-us", "steps")),
        (("analyze",), ("LOG", "needs a value")),
        (("analyze", "run.mcap", "--q", "1"), ("--q", "'1'", "X,Y")),
        (("analyze", "run.mcap", "--q", "1,2,3"), ("--q", "X,Y")),
        (("analyze", "run.mcap", "--q", "a,b"), ("--q", "X,Y")),
        (("analyze", "run.mcap", "--q", "nan,0"), ("--q", "nan,0", "10000")),
        (("analyze", "run.mcap", "--q", "0,nan"), ("--q", "0,nan", "10000")),
        (("analyze", "run.mcap", "--q", "0,-1e9"), ("--q", "10000")),
        (("analyze", "run.mcap", "--q"), ("--q", "needs a value")),
        (("log", "plot", "run.mcap", "--format", "gif"), ("--format", "gif", "png")),
        (("design", "profile", "--design", "pin"), ("--csv", "needs a value")),
        (("design", "profile", "--design", "pin", "--cvs=x.csv"), ("unknown option --cvs", "did you mean --csv?")),
        ((*PROFILE, "--quite"), ("unknown option --quite; did you mean --quiet?",)),
        ((*PROFILE, "--turns", "2"), ("unknown option --turns; see",)),
        (("design", "profile", "--design", "pin", "--csv", "--points"), ("--csv", "--points")),
        ((*PROFILE, "--points", "1.5"), ("--points", "1.5", "whole number")),
        ((*PROFILE, "--points", "2"), ("--points", "2", "from 3 to 1000000")),
        ((*PROFILE, "--points", "-5"), ("--points", "-5", "from 3 to 1000000")),
        ((*PROFILE, "--points", "9" * 30), ("--points", "from 3 to 1000000")),
        ((*PROFILE, "--part", "rim"), ("--part", "rim", "ring")),
        ((*PROFILE, "--part", "ring"), ("--part ring", "nonpin")),
        ((*MOTION, "--step-s", "1e-9"), ("--step-s", "rows")),
        ((*MOTION, "--q", "1;2"), ("--q", "X,Y")),
    ],
)
def test_wrong_usage_is_one_line_and_exit_code_2(argv, words, here):
    code, message = rejected(*argv)
    assert code == 2
    assert all(word.lower() in message.lower() for word in words), message
    assert list(here.iterdir()) in ([], [here / "runs"])


LIMITS = {
    "--timestep-us": "at least 0 and at most 1000",
    "--speed-rpm": "greater than -100000 and less than 100000, not 0",
    "--ramp-s": "at least 0 and at most 1000",
    "--hold-s": "greater than 0 and at most 1000",
    "--load-nm": "at least -1000000 and at most 1000000",
}


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "1e300", "-1e300", "-1e9"])
@pytest.mark.parametrize("flag", LIMITS)
def test_absurd_value_of_a_flag_is_reported_with_its_range(flag, value):
    code, message = rejected(*SIMULATE, flag, value)
    assert code == 2
    assert f"{flag} {value}: must be {LIMITS[flag]}" in message


@pytest.mark.parametrize(
    ("flag", "value"),
    [("--timestep-us", "-1"), ("--speed-rpm", "0"), ("--hold-s", "0"), ("--ramp-s", "-1")],
)
def test_zero_and_negative_values_are_reported_with_their_range(flag, value):
    code, message = rejected(*SIMULATE, flag, value)
    assert code == 2
    assert f"{flag} {value}: must be {LIMITS[flag]}" in message


@pytest.mark.parametrize("value", ["nan", "inf", "-1", "0", "1e300"])
@pytest.mark.parametrize("flag", ["--until-s", "--step-s"])
def test_absurd_times_of_kinematics_are_reported(flag, value):
    code, message = rejected(*MOTION, flag, value)
    assert code == 2
    assert f"{flag} {value}: must be from 1e-12 to 1000000" in message


def test_flags_keep_the_limits_of_the_design():
    """The range that the command line states is the one that the design has: the same values pass both."""
    for flagged in (flags.TIMESTEP, flags.SPEED, flags.RAMP, flags.HOLD, flags.LOAD):
        for value in (-1e7, -2e5, -1.0, 0.0, 1e-3, 999.0, 2e5, 1e7, math.nan, math.inf):
            by_flag = by_design = True
            try:
                flagged.require(value)
            except ValueError:
                by_flag = False
            try:
                override(PRESETS["pin"], [f"{flagged.key}={value!r}"])
            except DesignError:
                by_design = False
            assert by_flag == by_design or (flagged is flags.SPEED and value == 0.0), (flagged, value)


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("simulate", "--design", "broken.toml"), ("broken.toml", "TOML")),
        (("simulate", "--design", "unknown.toml"), ("load.torqe_nm", "load.torque_nm")),
        (("design", "check", "broken.toml"), ("broken.toml",)),
        (("design", "show", "empty.toml"), ("empty",)),
        ((*SIMULATE, "--out", "broken.toml"), ("broken.toml", "file", "--out")),
        ((*SIMULATE, "--out", "broken.toml/in"), ("broken.toml/in", "--out")),
        (("analyze", "empty.toml"), ("empty",)),
        (("analyze", "broken.toml"), ("not an MCAP file",)),
        (("design", "profile", "--design", "pin", "--csv", "."), ("cannot write", "not a regular file")),
        (("design", "profile", "--design", "pin", "--csv", "no/such/x.csv"), ("no folder no/such. Create it",)),
        (("design", "profile", "--design", "pin", "--csv", "broken.toml/x.csv"), ("broken.toml/x.csv",)),
        (("design", "profile", "--design", "loops.toml", "--csv", "x.csv"), ("eccentricity", "mm")),
    ],
)
def test_file_errors_are_one_line_and_exit_code_1(argv, words, here):
    Path("broken.toml").write_text("[gear\n")
    Path("unknown.toml").write_text("[load]\ntorqe_nm = 3.0\n")
    Path("empty.toml").write_text("")
    Path("loops.toml").write_text("[gear]\neccentricity_mm = 1.5\n")
    code, message = rejected(*argv)
    assert code == 1
    assert all(word.lower() in message.lower() for word in words), message
    assert not Path("x.csv").exists()


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("statics", "none.toml"), ("unknown design 'none.toml'",)),
        (("statics", "."), (". is a folder: give the name of a design",)),
        (("design", "check", "."), (". is a folder: give the name of a design",)),
        (("analyze", "none.mcap"), ("log none.mcap does not exist",)),
        (("analyze", "."), (". is a folder: choose a log",)),
        (("log", "plot", "none.mcap"), ("log none.mcap does not exist",)),
        (("rate", "pin", "--stress", "none"), ("cannot read none: No such file",)),
        (("rate", "pin", "--duty", "none.csv"), ("none.csv: No such file",)),
    ],
)
def test_the_name_of_a_missing_file_is_wrong_usage(argv, words, here):
    """A folder in a design's place, and any log that was not there, ended with 1 where a missing design was 2."""
    code, message = rejected(*argv)
    assert code == 2
    assert all(word in message for word in words), message
    assert "Errno" not in message


def test_a_table_without_a_name_is_reported_by_its_flag(run, here):
    code, message = rejected("log", "csv", str(run[1]), "")
    assert code == 2
    assert "the file name after --out, '', is empty" in message
    assert "--csv" not in message


def test_plot_into_a_file_is_reported(run, tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    code, message = rejected("log", "plot", str(run[1]), "--out", str(file))
    assert code == 1
    assert str(file) in message


def test_a_program_error_is_not_reported_as_a_user_error(monkeypatch):
    def faulty(*words):
        raise ZeroDivisionError

    monkeypatch.setattr("cycloid_mj.cli.flags.load_design", faulty)
    with pytest.raises(ZeroDivisionError):
        main(["design", "show", "pin"])


def test_a_command_with_duckdb_prints_nothing_at_its_end(tmp_path: Path) -> None:
    """Its nanobind tells of every object that is left when Python ends."""
    pytest.importorskip("duckdb")
    script = """
import sys, duckdb
sys.argv = ["cycloid-mj", "design", "show", "pin"]
from cycloid_mj.cli.process import run
run()
"""
    done = subprocess.run([sys.executable, "-B", "-c", script], capture_output=True, text=True, check=True)
    assert done.stderr == ""


def test_a_short_command_collects_no_reference_cycles() -> None:
    script = """
import atexit, gc, sys
whole = []
gc.callbacks.append(lambda phase, info: phase == "stop" and info["generation"] == 2 and whole.append(1))
atexit.register(lambda: print(len(whole), gc.get_freeze_count() > 10_000))
sys.argv = ["cycloid-mj", "design", "show", "pin"]
from cycloid_mj.cli.process import run
run()
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "0 True"


THREADS_OF_BLAS = """
import os, sys
from cycloid_mj.cli import process
def main():
    print(os.environ.get("OPENBLAS_NUM_THREADS"))
    return 0
process.main = main
process.run()
"""


@pytest.mark.parametrize(
    ("own", "taken"),
    [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3"), ({"OMP_NUM_THREADS": "3"}, "None")],
    ids=["none", "openblas", "omp"],
)
def test_matrices_are_multiplied_by_one_thread_unless_others_are_requested(own: dict[str, str], taken: str) -> None:
    there = {name: value for name, value in os.environ.items() if name not in BLAS_THREADS} | own
    done = subprocess.run(
        [sys.executable, "-c", THREADS_OF_BLAS], env=there, capture_output=True, text=True, check=True
    )
    assert done.stdout == f"{taken}\n"


STOPPED_IN_AN_IMPORT = """
from cycloid_mj.cli import process
def main():
    try:
        raise ImportError("initialization failed") from KeyboardInterrupt()
    except ImportError as inner:
        raise ImportError("a module that loads the first one") from inner
process.main = main
process.run()
"""


def test_ctrl_c_during_the_import_of_a_c_module_is_reported_in_one_line() -> None:
    done = subprocess.run([sys.executable, "-c", STOPPED_IN_AN_IMPORT], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "error: stopped by Ctrl-C\n")


def test_the_first_start_states_what_it_waits_for(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path))
    assert first_start(["statics", "pin"])
    assert not any(map(first_start, ([], ["--help"], ["statics", "--help"], ["statics", "pin", "--quiet"])))
    compiled = Path(cache_from_source(str(LOADED)))
    compiled.parent.mkdir(parents=True)
    compiled.touch()
    assert not first_start(["statics", "pin"])


FIRST_START = """
from cycloid_mj.cli import process
process.first_start, process.main = (lambda words: True), lambda: 0
process.run()
"""


def test_the_first_start_prints_one_line() -> None:
    done = subprocess.run([sys.executable, "-c", FIRST_START], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "first start: Python compiles its modules, which takes some seconds\n")
