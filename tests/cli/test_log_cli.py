"""The commands about logs, the report, films and pictures, called in-process: main paths and every mistake."""

import json
import sys
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from commands import told
from made_run import made_groups, made_run
from mcap.reader import make_reader
from PIL import Image

from cycloid_mj.cli import render
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.mjcf.model import xml
from cycloid_mj.log import LogWriter, load, read
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene import RATE, Scene, replay
from cycloid_mj.scene import render as rendering
from cycloid_mj.scene.layout import viewer_layout

DESIGN = override(PRESETS["nonpin"], ["drive.ramp_s=0", "drive.hold_s=0.08", "load.torque_nm=36"])
COLUMNS = [name for names in made_groups(DESIGN).values() for name in names]


def rejected(*argv: str) -> tuple[int, str]:
    """Exit code and message of a mistake, which must be one line and leave stdout empty."""
    code, out, err = told(*argv)
    assert out == ""
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    return code, err.removeprefix("error: ").rstrip()


def write(path: Path, **options) -> None:
    run = made_run(DESIGN, attachments={"model.xml": xml(build(DESIGN).spec).encode()})
    groups = {topic: list(units.items()) for topic, units in made_groups(DESIGN).items()}
    with LogWriter(path, groups, run.provenance, run.attachments, viewer=Scene(DESIGN), **options) as log:
        log.write(run.time, {topic: run.block(list(names)) for topic, names in made_groups(DESIGN).items()})


@pytest.fixture(scope="module")
def path(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("logs") / "run.mcap"
    write(path, chunk_size=300_000)
    return path


@pytest.fixture
def cut(path, tmp_path) -> Path:
    with path.open("rb") as stream:
        chunk = make_reader(stream).get_summary().chunk_indexes[2]
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: chunk.chunk_start_offset + chunk.chunk_length + 100])
    return cut


def test_info_states_what_a_log_holds(path, cut):
    code, out, err = told("log", "info", path)
    assert (code, err) == (0, "")
    for words in (
        "complete",
        "800 samples from 0 to 0.0799 s, 10000 per second",
        "/reducer",
        "foxglove.FrameTransforms",
    ):
        assert words in out
    assert f"{path.stat().st_size:,} bytes" in out
    _, out, _ = told("log", "info", path, "--json")
    found, run = json.loads(out), read(path)
    assert found["topics"] == {topic: list(names) for topic, names in made_groups(DESIGN).items()}
    assert found["viewers"]["/tf"] == {"schema": "foxglove.FrameTransforms", "messages": 5, "rate": 60.0}
    assert (found["samples"], found["end_s"], found["whole"]) == (800, run.time[-1], True)
    assert found["attachments"] == {name: len(content) for name, content in run.attachments.items()}
    code, out, _ = told("log", "info", cut, "--json")
    assert (code, json.loads(out)["whole"]) == (0, False)
    assert json.loads(out)["note"] == read(cut).note
    assert "not complete: the log is truncated" in told("log", "info", cut)[1]


def test_columns_lists_names_and_units(path):
    code, out, _ = told("log", "columns", path)
    assert code == 0
    listed = [line.split("\t") for line in out.splitlines()]
    assert [name for _, name, _ in listed] == COLUMNS
    assert listed[0] == ["/reducer", "crank_angle", "rad"]
    rows = json.loads(told("log", "columns", path, "--json")[1])["columns"]
    assert [[row["topic"], row["column"], row["unit"]] for row in rows] == listed


def test_csv_has_every_digit(path, cut, tmp_path):
    run, target = read(path), tmp_path / "run.csv"
    code, out, err = told("log", "csv", path, target)
    assert (code, out, err) == (0, "", f"wrote 800 rows of {len(COLUMNS) + 1} columns to {target}\n")
    table = np.genfromtxt(target, delimiter=",", names=True)
    assert table.dtype.names == ("time", *COLUMNS)
    for name in COLUMNS:
        np.testing.assert_array_equal(table[name], run[name])
    _, out, _ = told("log", "csv", path, "--columns", "gear_speed, gear_x")
    header, first, *others = out.splitlines()
    assert (header, len(others)) == ("time,gear_speed,gear_x", 799)
    assert [float(word) for word in first.split(",")] == [run.time[0], run["gear_speed"][0], run["gear_x"][0]]
    code, out, err = told("log", "csv", cut, "--columns", "gear_x")
    assert err.startswith(f"note: the run in {cut} is incomplete: the log is truncated")
    assert len(out.splitlines()) == len(read(cut)) + 1
    assert told("log", "csv", cut, "--out", target, "--force", "--quiet") == (0, "", "")
    assert len(target.read_text().splitlines()) == len(read(cut)) + 1
    code, message = rejected("log", "csv", path, "--columns", "gear_sped")
    assert (code, "columns with similar names: gear_speed" in message) == (1, True)


def test_parquet_holds_the_columns_with_their_units(path, tmp_path, monkeypatch):
    duckdb = pytest.importorskip("duckdb")
    target, run = tmp_path / "it's.parquet", read(path)
    assert told("log", "parquet", path, target)[:2] == (0, f"{target}\n")
    name = str(target).replace("'", "''")
    table = duckdb.sql(f"SELECT * FROM '{name}'").fetchnumpy()
    assert list(table) == ["time", *COLUMNS]
    for column in COLUMNS:
        np.testing.assert_array_equal(table[column], run[column])
    told_of = dict(duckdb.sql(f"SELECT key, value FROM parquet_kv_metadata('{name}')").fetchall())
    assert json.loads(told_of[b"units"]) == {"time": "s", **run.units}
    assert json.loads(told_of[b"provenance"]) == dict(run.provenance)
    few = tmp_path / "few.parquet"
    told("log", "parquet", path, few, "--columns", "gear_x")
    assert list(duckdb.sql(f"SELECT * FROM '{few}'").fetchnumpy()) == ["time", "gear_x"]
    assert rejected("log", "parquet", path, tmp_path / "no" / "x.parquet")[0] == 1
    monkeypatch.setitem(sys.modules, "duckdb", None)
    code, message = rejected("log", "parquet", path, few, "--force")
    assert code == 1
    assert "pip install 'cycloid-mj[parquet]', or write CSV" in message


def test_repair_completes_a_cut_log(cut, tmp_path):
    before = cut.read_bytes()
    code, out, err = told("log", "repair", cut)
    mended = tmp_path / "cut-repaired.mcap"
    assert (code, out) == (0, f"{mended}\n")
    assert "samples, up to" in err
    old, new = load(cut), load(mended)
    assert (new.complete, new.run.complete, new.run.note) == (True, False, old.run.note)
    assert new.run.topics == old.run.topics
    assert new.viewers == old.viewers
    for name in COLUMNS:
        assert new.run[name].tobytes() == old.run[name].tobytes()
    assert cut.read_bytes() == before
    assert rejected("log", "repair", cut)[0] == 1
    assert told("log", "repair", cut, "--force")[0] == 0
    assert told("log", "repair", mended) == (0, "", f"{mended} is complete: nothing to repair\n")


def test_repair_replaces_the_scene_of_a_complete_log(path, tmp_path):
    slow = tmp_path / "slow.mcap"
    code, out, _ = told("log", "repair", path, slow, "--scene-hz", "2000")
    assert (code, out) == (0, f"{slow}\n")
    found = load(slow)
    assert (found.viewers["/tf"].messages, found.viewers["/tf"].rate) == (160, 2000.0)
    assert found.run.complete
    code, message = rejected("log", "repair", path, path, "--scene-hz", "10", "--force")
    assert (code, "over itself" in message) == (1, True)
    assert rejected("log", "repair", path, slow, "--scene-hz", "0")[0] == 2


def test_log_without_a_design_is_repaired_without_a_scene(tmp_path):
    with LogWriter(tmp_path / "a.mcap", {"/a": [("x", "1")]}, chunk_size=1) as log:
        log.write(np.arange(5.0), {"/a": np.ones((5, 1))})
    whole = (tmp_path / "a.mcap").read_bytes()
    (tmp_path / "a.mcap").write_bytes(whole[:-4])
    code, _, err = told("log", "repair", tmp_path / "a.mcap")
    assert code == 0
    assert f"the new log has no 3-D scene: log {tmp_path / 'a.mcap'} lacks the attached file design.toml" in err
    assert load(tmp_path / "a-repaired.mcap").viewers == {}


def test_layout_is_json_for_foxglove(path):
    code, out, _ = told("log", "layout", path)
    assert (code, json.loads(out)) == (0, json.loads(json.dumps(viewer_layout(Reducer(DESIGN)))))


@pytest.mark.slow
def test_rerun_writes_a_recording(path, tmp_path):
    pytest.importorskip("rerun")
    target = tmp_path / "run.rrd"
    assert told("log", "rerun", path, target)[:2] == (0, f"{target}\n")
    assert target.read_bytes()[:3] == b"RRF"


def test_rerun_that_is_missing(path, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun", None)
    code, message = rejected("log", "rerun", path, tmp_path / "x.rrd")
    assert (code, "pip install 'cycloid-mj[rerun]'" in message) == (1, True)


@pytest.mark.slow
def test_report_of_one_and_of_several_logs(path, cut, tmp_path):
    target = tmp_path / "page.html"
    told("report", path, "--out", target)  # in a new installation the first page says that code is compiled
    assert told("report", path, "--out", target, "--q", "10,3", "--force") == (0, f"{target}\n", "")
    page = target.read_text(encoding="utf-8")
    assert "(10, 3) mm" in page
    code, out, err = told("report", cut, path)
    assert (code, out) == (0, f"{cut.with_suffix('.html')}\n")
    assert f"warning: {cut.stem}: the run is incomplete: the log is truncated" in err
    assert "stopped early" in cut.with_suffix(".html").read_text(encoding="utf-8")
    assert rejected("report") == (2, "no log is given: name at least one log, e.g. cycloid-mj report runs/pin.mcap")
    assert rejected("report", path, path) == (2, f"log {path} is given twice: name each log once")
    assert rejected("report", tmp_path / "no.mcap")[0] == 2
    assert rejected("report", path, "--out", tmp_path / "no" / "x.html")[0] == 1


@pytest.mark.slow
def test_animate_writes_a_film(path, tmp_path):
    target = tmp_path / "run.gif"
    options = ("--frames", "5", "--turns", "0.25", "--magnify", "150", "--fps", "20", "--width", "240")
    assert told("animate", path, target, *options) == (0, f"{target}\n", "")
    with Image.open(target) as picture:
        assert (picture.n_frames, picture.size, picture.info["duration"]) == (5, (240, 300), 50)
    for options, code in (
        (("--magnify", "1e5"), 2),
        (("--frames", "0"), 2),
        (("--frames", "1.5"), 2),
        (("--turns", "0"), 2),
        (("--fps", "90"), 2),
        (("--width", "5"), 2),
    ):
        assert rejected("animate", path, tmp_path / "other.gif", *options)[0] == code, options
    assert rejected("animate", path, tmp_path / "run.avi")[0] == 2


def test_defaults_in_the_help_are_those_of_the_library():
    assert (rendering.IMAGE.width, rendering.IMAGE.height) == (render.WIDTH, render.HEIGHT)
    assert (replay.VIEW.azimuth, replay.VIEW.elevation) == (render.AZIMUTH, render.ELEVATION)


def test_render_writes_a_picture(path, tmp_path):
    target = tmp_path / "run.png"
    code, out, err = told(
        "render", path, "--out", target, "--json", "--time-s", "0.03", "--width", "160", "--height", "120"
    )
    if "no OpenGL" in err:
        pytest.skip(err)
    assert (code, json.loads(out), err) == (0, {"files": [str(target)], "warnings": []}, "")
    with Image.open(target) as picture:
        assert picture.size == (160, 120)
        assert len(set(np.asarray(picture).reshape(-1, 3)[:, 2])) > 20


def test_pictures_that_are_refused(path, tmp_path, monkeypatch):
    assert rejected("render", path, tmp_path / "run.bmp")[0] == 2
    code, message = rejected("render", path, tmp_path / "run.png", "--time-s", "3")
    assert (code, message) == (2, "--time-s 3 is outside the run: give a time from 0 to 0.0799 s")
    assert rejected("render", path, tmp_path / "run.png", "--width", "1")[0] == 2
    monkeypatch.setenv("MUJOCO_GL", "nothing")
    code, message = rejected("render", path, tmp_path / "run.png")
    assert (code, message.startswith("OpenGL (nothing)")) == (1, True)


def test_view_needs_a_display(path, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    for what in ("pin", path):
        code, message = rejected("view", what)
        assert (code, "there is no display" in message, "cycloid-mj animate" in message) == (2, True, True)


def test_view_replays_a_log_until_its_window_is_closed(path, monkeypatch):
    """A window that stands in for MuJoCo's is aimed at the reducer, follows the run, and is closed after a while."""
    from cycloid_mj.scene import viewer

    seen = []

    class Window:
        def __init__(self, model, data):
            self.data, self.cam = data, type("Camera", (), {"lookat": np.zeros(3)})()

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def is_running(self):
            return len(seen) < 4

        def sync(self):
            seen.append((self.data.time, float(self.data.joint("crank").qpos[0]), self.cam.distance))

    module = type("Viewer", (), {"launch_passive": Window, "launch": lambda *_: 1 / 0})
    monkeypatch.setattr(viewer, "_viewer", lambda: module)
    # a clock that goes on by a frame a look: the run is over in five, and begins again
    looks = count()
    clock = SimpleNamespace(monotonic=lambda: next(looks) / RATE, sleep=lambda _: None)
    monkeypatch.setattr(viewer, "time", clock)
    monkeypatch.setenv("DISPLAY", ":0")
    assert told("view", path, "--slow", "1") == (
        0,
        "",
        "replaying the log in the MuJoCo viewer; close its window to stop\n",
    )
    run = read(path)
    times = [time for time, _, _ in seen]
    assert times == sorted(times)
    assert times[-1] > times[0]
    for time, angle, distance in seen:
        assert angle == run["crank_angle"][np.searchsorted(run.time, time)]
        assert 0.1 < distance < 0.3
    code, _, err = told("view", "nonpin", "--set", "friction.cam=0.01")
    assert (code, "the MuJoCo viewer cannot open a window: division by zero" in err) == (1, True)
    assert "warning: nonpin: friction.cam = 0.01 has no effect" in err
