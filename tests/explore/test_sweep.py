"""Sweeps: their points, their rows against single runs, and tables that nothing can spoil."""

import csv
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from designs import unlike

import cycloid_mj as cm
from cycloid_mj.base.engine import Engine
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.units import with_unit
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.explore import journal, sweeps
from cycloid_mj.explore.measured import MeasureSettings
from cycloid_mj.explore.points import MAX_POINTS, draw_points, grid_points, list_rows
from cycloid_mj.explore.ranks import rank_correlations, select_quantities
from cycloid_mj.explore.row import PointResult, Task
from cycloid_mj.explore.sweeps import sweep
from cycloid_mj.figures import FIGURES, compute, figure
from cycloid_mj.plots import save
from cycloid_mj.plots.explored import sweep_figure
from cycloid_mj.reducer import Reducer
from cycloid_mj.report.sweep import sweep_page
from cycloid_mj.statics.sheet import sheet

HERE = Engine(1)
PIN = PRESETS["pin"]
UNDISTURBED = ("cpu_s",)
"""Columns that differ from run to run of the same sweep."""


def same(one: Frame, other: Frame) -> bool:
    """Tell whether two tables have the same bits, but for the time they took."""
    if list(one.columns) != list(other.columns) or one.units != other.units:
        return False
    kept = [name for name in one.columns if name not in UNDISTURBED]
    return all(one[name].tolist() == other[name].tolist() or _same(one[name], other[name]) for name in kept)


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    return one.dtype.kind == other.dtype.kind == "f" and np.array_equal(one, other, equal_nan=True)


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return [{key: cell for key, cell in row.items() if key not in UNDISTURBED} for row in csv.DictReader(stream)]


def test_a_grid_is_every_combination() -> None:
    found = grid_points(
        {"clearance.cam_um": "1:2:3", "ring.kind": "pin,nonpin", "output.rollers": [True], "ring.teeth": "36"}
    )
    assert found.keys == ("clearance.cam_um", "ring.kind", "output.rollers", "ring.teeth")
    assert [row[:2] for row in found.rows] == [(cam, kind) for cam in (1.0, 1.5, 2.0) for kind in ("pin", "nonpin")]
    assert {row[2:] for row in found.rows} == {(True, 36)}
    assert grid_points({"clearance.cam_um": "0.1:0.5:5"}).rows[2] == (0.3,)


@pytest.mark.parametrize("method", ["sobol", "lhs", "random"])
def test_samples_fill_their_ranges_and_follow_their_seed(method: str) -> None:
    vary = {"clearance.cam_um": "1:3", "ring.teeth": "12:15", "ring.kind": "pin,nonpin"}
    found = draw_points(vary, method, 200, 4)
    assert found == draw_points(vary, method, 200, 4) != draw_points(vary, method, 200, 5)
    cam, teeth, kinds = zip(*found.rows, strict=True)
    assert 1.0 <= min(cam) < 1.05 < 2.95 < max(cam) <= 3.0
    assert np.mean(cam) == pytest.approx(2.0, abs=0.15)
    assert [round(teeth.count(n) / 50) for n in (12, 13, 14, 15)] == [1] * 4
    assert set(kinds) == {"pin", "nonpin"}


def test_sobol_points_are_more_even_than_random_ones() -> None:
    from scipy.stats import qmc

    uneven = {}
    for method in ("sobol", "random"):
        points = draw_points({"clearance.cam_um": "0:1", "clearance.output_um": "0:1"}, method, 100, 0)
        uneven[method] = qmc.discrepancy(np.array(points.rows))
    assert uneven["sobol"] < 0.2 * uneven["random"]


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ({"clearance.cam": "1,2"}, r"unknown key clearance\.cam; did you mean clearance\.cam_um\?"),
        ({"ring.teth": "30"}, r"did you mean ring\.teeth\?"),
        ({"nothing": "1"}, "unknown key nothing"),
        ({"ring.teeth": "30:37:3"}, r"33\.5 is not a whole number"),
        ({"ring.teeth": "30.5"}, "give a whole number"),
        ({"ring.kind": "pin,none"}, "give pin, nonpin"),
        ({"output.rollers": "1"}, "give true or false"),
        ({"clearance.cam_um": "one"}, "give a number"),
        ({"clearance.cam_um": "1:2"}, r"1:2:5, or sample the range with --sample"),
        ({"clearance.cam_um": "2:1:3"}, "the smaller one first"),
        ({"clearance.cam_um": "1:2:1"}, "a range needs at least 2"),
        ({"clearance.cam_um": "1:2:x"}, "give LO:HI:N"),
        ({"clearance.cam_um": "0:inf:3"}, "the smaller one first"),
        ({"clearance.cam_um": "1:2:100000000000"}, f"may have 1 to {MAX_POINTS:,} points"),
        ({f"clearance.{key}_um": "1:2:2000" for key in ("cam", "output")}, "this one has 4,000,000"),
        ({"errors.pin_x_um": "1,2"}, "is a list"),
        ({"clearance": "1"}, "is a list or a table"),
        ({"clearance.cam_um": []}, "list of values is empty"),
    ],
)
def test_wrong_points_are_refused(vary: dict[str, str], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        grid_points(vary)


def test_tables_are_converted_to_points() -> None:
    found = list_rows([{"clearance.cam_um": "2", "ring.kind": "nonpin"}, {"ring.kind": "pin", "clearance.cam_um": 1}])
    assert found.rows == ((2.0, "nonpin"), (1.0, "pin"))
    for rows in ([], [{"clearance.cam_um": 1}, {"ring.kind": "pin"}], [{"clearance.cam_um": None}]):
        with pytest.raises(UsageError, match="table"):
            list_rows(rows)


@pytest.fixture(scope="module")
def statics() -> sweeps.Sweep:
    return sweep(PIN, {"clearance.cam_um": [1.0, 2.0], "ring.kind": "pin,nonpin"}, "statics", engine=HERE)


def test_rows_are_single_runs(statics: sweeps.Sweep) -> None:
    alone = sheet(Reducer(override(PIN, {"clearance.cam_um": 2.0, "ring.kind": "nonpin"}))).quantities
    frame = statics.frame
    assert frame["point"].tolist() == [1, 2, 3, 4]
    assert frame["backlash_arcmin"][3] == alone["backlash"].value
    assert frame["efficiency_percent"][3] == alone["efficiency"].value
    assert frame.units["stiffness_nm_per_arcmin"] == "N m/arcmin"
    assert frame.units["clearance.cam_um"] == "um"
    # what only one kind of ring has
    assert np.isnan(frame["tooth_peak_force_n"][[0, 2]]).all()
    assert np.isfinite(frame["tooth_peak_force_n"][[1, 3]]).all()
    assert not any(frame["error"])
    assert (frame["cpu_s"] > 0.0).all()
    assert "mujoco" in frame["versions"][0]
    assert any("unilateral springs" in assumption for assumption in statics.assumptions)


@pytest.mark.slow
def test_two_processes_compute_the_same_bits(statics: sweeps.Sweep) -> None:
    again = sweep(PIN, {"clearance.cam_um": [1.0, 2.0], "ring.kind": "pin,nonpin"}, "statics", engine=Engine(2))
    assert same(statics.frame, again.frame)


def test_other_packages_accept_the_table(statics: sweeps.Sweep) -> None:
    import duckdb

    found = duckdb.sql("select count(*), min(backlash_arcmin) from statics").fetchall()
    assert found == [(4, statics["backlash_arcmin"].min())]
    assert len(statics) == 4


def test_a_failed_point_has_an_error_and_the_others_have_figures() -> None:
    found = sweep(PIN, {"gear.eccentricity_mm": [1.0, 1.2, -1.0]}, ["statics", "checks"], engine=HERE)
    good, unsound, invalid = found["error"]
    assert good == ""
    assert "statics: the design 'pin' cannot be built" in unsound
    assert "\n" not in unsound
    assert "gear.eccentricity_mm = -1.0 is not allowed" in invalid
    assert found.failed == 2
    # `checks` takes what cannot be built
    assert found["checks.failed_errors"].tolist()[:2] == [0.0, found["checks.failed_errors"][1]]
    assert found["checks.failed_errors"][1] >= 1.0
    assert np.isnan(found["statics.backlash_arcmin"][1:]).all()


def test_figures_of_the_catalogue_are_columns_under_their_keys() -> None:
    """Beside a measure, too, whose own columns bear its name; what a design has not got is no number."""
    keys = ("mass_kg", "te_loaded_arcsec", "tooth_pressure_mpa", "life_h")
    found = sweep(PIN, {"clearance.cam_um": [1.0]}, ["mass", *keys], engine=HERE)
    assert found.quantities[-4:] == keys
    assert found["mass_kg"] == found["mass.mass_kg"]
    assert found["te_loaded_arcsec"][0] == compute(Reducer(PIN.but(clearance={"cam": 1e-6})), keys)["te_loaded_arcsec"]
    assert np.isnan(found["tooth_pressure_mpa"][0])
    assert found.frame.units["life_h"] == "h"


def test_statics_has_one_column_for_each_figure_under_its_catalogue_key(statics: sweeps.Sweep) -> None:
    assert set(statics.quantities) <= FIGURES.keys()
    assert {figure(key).key for key in sheet(Reducer(PIN)).quantities} <= set(statics.quantities)
    # an older name still shows the column
    assert select_quantities(statics, ("stiffness_ideal_nm_arcmin",)) == ("stiffness_nm_per_arcmin",)


def test_columns_name_quotients_with_a_torque_by_per() -> None:
    assert with_unit("stiffness", "N m/arcmin") == "stiffness_nm_per_arcmin"
    assert with_unit("compliance", "arcmin/(N m)") == "compliance_arcmin_per_nm"
    assert with_unit("speed", "mm/s") == "speed_mm_s"


def test_an_error_of_the_program_is_reported_in_its_row(monkeypatch: pytest.MonkeyPatch) -> None:
    from cycloid_mj.explore import measured

    def spoiled(*_: object) -> None:
        raise ZeroDivisionError("spoiled")

    monkeypatch.setattr(measured, "MEASURED", measured.MEASURED)
    monkeypatch.setitem(measured.MEASURED, "mass", spoiled)
    assert sweep(PIN, {"clearance.cam_um": [1.0]}, "mass", engine=HERE)["error"][0] == "ZeroDivisionError: spoiled"


LOADED = {"drive.ramp_s": 0.0, "drive.hold_s": 0.004, "load.torque_nm": 36.0, "load.rise_s": 0.001}


def test_loaded_runs_have_massless_pins_and_state_so() -> None:
    design = override(PIN, LOADED)
    found = sweep(design, {"load.torque_nm": [36.0]}, "simulate", engine=HERE)
    assert found["pins"].tolist() == ["massless"]
    assert any("are massless" in one for one in found.assumptions)
    assert found["solver"].tolist() == ["planar"]
    light = override(design, {"ring.pins": "massless"})
    alone = cm.analyze(cm.simulate(light, planar_model(Reducer(light))))
    assert found["power_crank_torque_nm"][0] == alone.power.crank_torque_nm
    short = override(design, {"drive.hold_s": 0.0005})
    for chosen in (
        sweep(short, {"ring.pins": ["free"]}, "simulate", engine=HERE),
        sweep(short, {"load.torque_nm": [36.0]}, "simulate", engine=HERE, real_pins=True),
        sweep(short, {"load.torque_nm": [0.0]}, "simulate", engine=HERE),
    ):
        assert chosen["pins"].tolist() == ["free"]
        assert not chosen.assumptions


def test_an_impossible_run_is_reported_in_its_row() -> None:
    design = override(PIN, {**LOADED, "drive.hold_s": 0.002})
    found = sweep(design, {"drive.speed_rpm": [0.0]}, "simulate", engine=HERE)
    assert "drive.speed_rpm is 0" in found["error"][0]
    found = sweep(design, {"drive.hold_s": [1000.0], "settings.timestep_us": [0.1]}, "simulate", engine=HERE)
    assert "1e+10 time steps, but at most 1e+09 are allowed: reduce drive.hold_s" in found["error"][0]


@pytest.mark.parametrize("name", ["light", "few"])
def test_other_designs(name: str) -> None:
    found = sweep(unlike(name), {"clearance.cam_um": [1.0, 1.5]}, "statics,mass,checks", engine=HERE)
    assert not any(found["error"])
    low, high = found["statics.backlash_arcmin"]
    assert 0.0 < low < high
    assert found["mass.mass_kg"][0] == found["checks.mass_kg"][0]


@pytest.mark.slow
def test_ranks_are_those_of_monotonic_functions() -> None:
    found = sweep(PIN, {"clearance.cam_um": "1,2", "clearance.output_um": "1,2,3"}, "statics", engine=HERE)
    one = rank_correlations(found, ("backlash_arcmin",))
    assert one.inputs == ("clearance.cam_um", "clearance.output_um")
    assert (one.rho > 0.2).all()
    assert select_quantities(found)[0] == "backlash_arcmin"
    assert select_quantities(found, ("cam_margin",)) == ("cam_margin",)
    with pytest.raises(UsageError, match=r"--show nothing: unknown quantity\. Choose from backlash_arcmin"):
        select_quantities(found, ("nothing",))


def command(folder: Path, *more: str) -> list[str]:
    return [
        "sweep",
        "--design",
        "pin",
        "--vary",
        "clearance.cam_um=1:3:6",
        "--measure",
        "mass",
        "--out",
        str(folder),
        *more,
    ]


@pytest.mark.slow
def test_the_command_writes_one_table_in_three_formats(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import duckdb

    assert main([*command(tmp_path, "--json", "--workers", "1"), "--vary", "ring.kind=pin,nonpin"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["points"], found["failed"]) == (12, 0)
    rows = rows_of(Path(found["table"]))
    assert len(rows) == 12
    parquet = duckdb.sql(f"select * from '{found['parquet']}'")
    assert parquet.columns == [*list(rows[0])[:-1], "cpu_s", "versions"]
    assert [float(row["mass_kg"]) for row in rows] == [value for (value,) in parquet.select("mass_kg").fetchall()]
    units = dict(duckdb.sql(f"select key, value from parquet_kv_metadata('{found['parquet']}')").fetchall())
    assert json.loads(units[b"units"])["mass_kg"] == "kg"


def made_up(vary: dict[str, object], spoiled: int = -1) -> sweeps.Sweep:
    """A sweep whose quantities are functions of its first input, without any measuring."""
    points = grid_points(vary)
    rows = {}
    for place, values in enumerate(points.rows):
        number = float(values[0]) if not isinstance(values[0], str) else 1.0
        good = {"rising_mm": number, "falling_long_name_that_has_to_be_folded_somewhere_n": -(number**3) + place}
        rows[place] = (
            PointResult(error="<spoiled>")
            if place == spoiled
            else PointResult({**good, "word": "a"}, {"rising_mm": "mm"})
        )
    return sweeps.Sweep(Task(Reducer(PIN), points.keys, ("mass",), MeasureSettings()), points, rows)


SHAPES = {
    "line": ({"clearance.cam_um": "1:3:5"}, 1),
    "words": ({"ring.kind": "pin,nonpin"}, 1),
    "map": ({"clearance.cam_um": "1:3:4", "clearance.output_um": "1:3:4"}, 2),
    "lines": ({"clearance.cam_um": "1:3:4", "ring.kind": "pin,nonpin"}, 1),
    "flat": ({"clearance.cam_um": "1:3:4", "clearance.output_um": "2"}, 1),
    "pairs": ({"clearance.cam_um": "1:3:3", "ring.kind": "pin,nonpin", "ring.teeth": "30,31"}, 3),
    "one": ({"clearance.cam_um": "1"}, 1),
}


@pytest.mark.parametrize(("vary", "columns"), SHAPES.values(), ids=SHAPES)
def test_figures_suit_the_inputs(vary: dict[str, object], columns: int, tmp_path: Path) -> None:
    found = made_up(vary, spoiled=1)
    quantities = ("rising_mm", "falling_long_name_that_has_to_be_folded_somewhere_n")
    figure = sweep_figure(found, quantities)
    panels = [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]
    assert len(panels) == 2 if columns < 3 else len(panels) == 6
    (drawn,) = save({"sweep": figure}, tmp_path, ["svg"])
    page = sweep_page(found, quantities, drawn.read_bytes())
    assert "rising_mm" in page
    assert ("&lt;spoiled&gt;" in page) == (found.failed > 0)
    assert "<spoiled>" not in page
    assert "https://" not in page


def test_a_sweep_with_only_errors_has_a_page() -> None:
    found = made_up({"clearance.cam_um": "1"}, spoiled=0)
    assert select_quantities(found) == ()
    assert "1 of 1" in sweep_page(found, (), b"<svg/>")
    assert sweep_figure(found, ()) is not None


def test_a_sweep_continues_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Broken off after some points, with half a line of a row: the rest is done, and nothing twice."""
    monkeypatch.setattr(sweeps, "SECONDS_BETWEEN_TABLES", 0.0)
    vary, whole = {"clearance.cam_um": "1:3:8"}, tmp_path / "whole"
    undisturbed = sweep(PIN, vary, "mass", out=whole, engine=HERE)

    def stop(done: int, _: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    part = tmp_path / "part"
    with pytest.raises(KeyboardInterrupt):
        sweep(PIN, vary, "mass", out=part, engine=HERE, progress=stop)
    assert len(rows_of(part / "sweep.csv")) == 3
    with (part / journal.rows_file("sweep")).open("ab") as stream:
        stream.write(b'{"point": 4, "values": {"mass_')
    told: list[tuple[int, int]] = []
    found = sweep(PIN, vary, "mass", out=part, engine=HERE, progress=lambda *one: told.append(one))
    assert told == [(n, 5) for n in range(1, 6)]
    assert same(found.frame, undisturbed.frame)
    assert rows_of(part / "sweep.csv") == rows_of(whole / "sweep.csv")


def test_a_folder_of_another_sweep_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    vary = {"clearance.cam_um": "1,2"}
    sweep(PIN, vary, "mass", out=tmp_path, engine=HERE)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    for design, points, measure, what in (
        (PRESETS["nonpin"], vary, "mass", "design"),
        (PIN, {"clearance.cam_um": "1,3"}, "mass", "points"),
        (PIN, {"clearance.output_um": "1,2"}, "mass", "keys, points"),
        (PIN, vary, "checks", "measures"),
    ):
        with pytest.raises(UsageError, match=f"contains another sweep, which differs in {what}: choose another"):
            sweep(design, points, measure, out=tmp_path, engine=HERE)
    monkeypatch.setattr(sweeps, "versions", lambda: (("mujoco", "9.9"),))
    with pytest.raises(UsageError, match="differs in versions"):
        sweep(PIN, vary, "mass", out=tmp_path, engine=HERE)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_two_simultaneous_runs_do_not_share_a_folder(tmp_path: Path) -> None:
    with (
        journal.open_journal(tmp_path, {}),
        pytest.raises(UsageError, match="another process is writing"),
        journal.open_journal(tmp_path, {}),
    ):
        pass


@pytest.mark.slow
def test_a_full_disk_is_reported_and_loses_nothing(tmp_path: Path) -> None:
    """A limit on the size of files stands for a full disk; the manifest fits, the rows do not."""
    code = (
        "import resource, sys; from cycloid_mj.cli import main;"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, resource.RLIM_INFINITY)); sys.exit(main(sys.argv[1:]))"
    )
    words = [sys.executable, "-c", code, *command(tmp_path, "--workers", "1", "--vary", "ring.kind=pin,nonpin")]
    words += ["--vary", "clearance.output_um=1:2:10"]
    ended = subprocess.run(words, capture_output=True, text=True)
    assert ended.returncode == 1
    assert "cannot write" in ended.stderr
    assert "Traceback" not in ended.stderr
    kept = len((tmp_path / journal.rows_file("sweep")).read_bytes().splitlines()) - 1
    assert kept > 10
    assert main([*words[3:], "--quiet"]) == 0
    assert len(rows_of(tmp_path / "sweep.csv")) == 120


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        ([], "a sweep needs either --vary"),
        (["--vary", "clearance.cam_um"], "give KEY=VALUES"),
        (["--vary", "clearance.cam_um=1", "--vary", "clearance.cam_um=2"], "is repeated"),
        (
            ["--vary", "clearance.cam_um=1", "--measure", "play"],
            "unknown measure 'play': choose one of statics, te",
        ),
        (["--vary", "clearance.cam_um=1", "--measure", ","], "unknown measure ''"),
        (["--vary", "clearance.cam_um=1", "--points", "3"], "add --sample"),
        (["--vary", "clearance.cam_um=1:2", "--sample", "sobol", "--points", "0"], "this one has 0"),
        (["--vary", "clearance.cam_um=1:2", "--sample", "sobol", "--points", "-5"], "this one has -5"),
        (["--vary", "clearance.cam_um=1:2", "--sample", "halton"], "halton"),
        (["--vary", "clearance.cam_um=1", "--table", "EMPTY"], "either --vary KEY=VALUES or --table"),
        (["--table", "EMPTY"], "is empty: add a header"),
        (["--table", "HEADER"], "is empty: add a header"),
        (["--table", "UNEVEN"], "row 2 has 1 values, but the header has 2 columns"),
        (["--table", "BINARY"], "cannot read --table"),
        (["--table", "NONE"], "No such file or directory. Choose a CSV file"),
        (["--table", "TWICE"], "is repeated"),
        (["--vary", "clearance.cam_um=1", "--workers", "0"], "--workers"),
        (["--vary", "clearance.cam_um=1", "--workers", "2", "--scheduler", "a:1"], "cannot be used together"),
        (["--vary", "clearance.cam_um=1", "--scheduler", "here"], "give HOST:PORT"),
    ],
)
def test_wrong_wishes_are_refused(
    flags: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    texts = {
        "EMPTY": b"",
        "HEADER": b"clearance.cam_um\n",
        "UNEVEN": b"clearance.cam_um,ring.kind\n1,pin\n2\n",
        "BINARY": b"\xff\xfe\x00\x01",
        "TWICE": b"clearance.cam_um,clearance.cam_um\n1,2\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_bytes(text)
    words = [str(tmp_path / word) if word in (*texts, "NONE") else word for word in flags]
    assert main(["sweep", "--design", "pin", *words, "--out", str(tmp_path / "out")]) == 2
    told = capsys.readouterr().err
    assert message in told
    assert told.count("\n") == 1


def test_an_impossible_folder_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").touch()
    for out in (str(tmp_path / "file"), "/dev/full", str(tmp_path / "file" / "below")):
        assert main(command(Path(out))) == 1
        assert "Choose another" in (told := capsys.readouterr().err) or "it is a file" in told


@pytest.mark.slow
def test_every_point_failed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        main(["sweep", "--design", "pin", "--vary", "gear.eccentricity_mm=5,6", "--out", str(tmp_path), "--quiet"]) == 1
    )
    assert "2 points, 2 failed" in capsys.readouterr().out


@pytest.mark.slow
def test_ctrl_c_and_kill_leave_what_was_done(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Ended twice, then resumed: the table of a sweep that nothing disturbed."""
    words = ["--vary", "clearance.cam_um=1:3:60", "--measure", "mass", "--workers", "1"]
    disturbed_twice(tmp_path, capsys, words, 60)


@pytest.mark.slow
def test_two_hundred_loaded_runs_killed_twice(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = [word for key, value in (LOADED | {"drive.hold_s": 0.02}).items() for word in ("--set", f"{key}={value}")]
    disturbed_twice(tmp_path, capsys, [*run, "--vary", "load.torque_nm=20:40:200", "--measure", "simulate"], 200)


def disturbed_twice(tmp_path: Path, capsys: pytest.CaptureFixture[str], flags: list[str], points: int) -> None:
    # Ctrl-C is ignored by what a shell without job control starts, and so by what that starts
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from cycloid_mj.cli import run; run()"
    )
    words = [sys.executable, "-c", code, "sweep", "--design", "pin", *flags, "--quiet", "--json", "--out"]
    for signal_number, share in ((signal.SIGKILL, 0.2), (signal.SIGINT, 0.6)):
        process = subprocess.Popen(
            [*words, str(tmp_path / "disturbed")], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        rows = tmp_path / "disturbed" / journal.rows_file("sweep")
        while process.poll() is None and not (rows.exists() and rows.read_bytes().count(b"\n") >= share * points):
            time.sleep(0.01)
        process.send_signal(signal_number)
        _, told = process.communicate()
        assert process.returncode != 0
        kept = rows.read_bytes().count(b"\n")
        assert share * points <= kept < points
        assert "Traceback" not in told
        if signal_number == signal.SIGINT:
            assert "stopped by Ctrl-C; the points evaluated so far are in" in told
            assert len(rows_of(tmp_path / "disturbed" / "sweep.csv")) == kept
    for name in ("disturbed", "undisturbed"):
        capsys.readouterr()
        assert main([*words[3:], str(tmp_path / name)]) == 0
        told = json.loads(capsys.readouterr().out)
        assert (told["points"], told["failed"]) == (points, 0)
    assert rows_of(tmp_path / "disturbed" / "sweep.csv") == rows_of(tmp_path / "undisturbed" / "sweep.csv")


@pytest.mark.parametrize("left", [1, 40], ids=["all but the line's end", "half a line"])
def test_a_sweep_killed_in_the_middle_of_a_line_continues(left: int, tmp_path: Path) -> None:
    """What was written of the last row is cut off, and only that row is measured again."""
    whole, out = tmp_path / "whole", tmp_path / "out"
    words = ["sweep", "--vary", "clearance.cam_um=1,2,3", "--measure", "mass", "--quiet", "--out"]
    assert main([*words, str(whole)]) == 0
    out.mkdir()
    (out / "sweep.json").write_bytes((whole / "sweep.json").read_bytes())
    rows = (whole / "sweep.rows.jsonl").read_bytes()
    (out / "sweep.rows.jsonl").write_bytes(rows[:-left])
    assert main([*words, str(out)]) == 0
    kept, again = rows.splitlines(), (out / "sweep.rows.jsonl").read_bytes().splitlines()
    assert again[:2] == kept[:2]
    assert len(again) == 3
    masses = []
    for path in (whole, out):
        with (path / "sweep.csv").open(newline="") as stream:
            masses.append([row["mass_kg"] for row in csv.DictReader(stream)])
    assert masses[0] == masses[1]
    assert len(masses[0]) == 3
