"""Every file of results is written whole or not at all: on a full disk, and when the program is stopped meanwhile."""

import math
import signal
from pathlib import Path

import pytest
from commands import told
from folders import contents, disk_of
from made_run import made_groups, made_run

from cycloid_mj.base.atomic_write import atomic_file, atomic_files, write_files
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.interrupt import defer_signals
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.cli.delivery import Destination, write
from cycloid_mj.cli.flags import Delivery
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.mjcf.folder import write_folder
from cycloid_mj.log import LogWriter

pytest.importorskip("resource", reason="limits of processes are of POSIX alone")

DESIGN = override(PRESETS["nonpin"], ["drive.ramp_s=0", "drive.hold_s=0.08", "load.torque_nm=36"])


def test_files_that_belong_together_are_replaced_together(tmp_path):
    old = {tmp_path / name: b"old" for name in "abc"}
    write_files(old)
    assert contents(tmp_path) == {"a": b"old", "b": b"old", "c": b"old"}
    with disk_of(1000), pytest.raises(CycloidError, match="cannot write"):
        write_files({tmp_path / "a": b"new", tmp_path / "b": bytes(5000), tmp_path / "c": b"new"})
    (tmp_path / "folder").mkdir()
    with pytest.raises(CycloidError, match="folder: it is not a regular file"):
        write_files({tmp_path / "a": b"new", tmp_path / "folder": b"new"})
    assert contents(tmp_path) == {"a": b"old", "b": b"old", "c": b"old"}


def test_messages_name_files_as_they_were_given(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(CycloidError, match=r"^cannot write \.: it is not a regular file"):
        write_files({Path("."): b"new"})
    with pytest.raises(CycloidError, match=r"^cannot write none/a: No such file"):
        write_files({Path("none/a"): b"new"})


@pytest.mark.parametrize("error", [KeyboardInterrupt(), RuntimeError("broken")])
def test_an_interrupted_write_leaves_no_trace(error, tmp_path):
    write_files({tmp_path / "a": b"old"})
    with pytest.raises(type(error)), atomic_files([tmp_path / "a", tmp_path / "b"]) as beside:  # noqa: PT012
        beside[0].write_bytes(b"new")
        raise error
    assert contents(tmp_path) == {"a": b"old"}


def test_the_target_of_a_link_is_replaced(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "there" / "file")
    write_files({tmp_path / "link": b"new"})
    assert (tmp_path / "link").is_symlink()
    assert contents(tmp_path / "there") == {"file": b"new"}


def test_a_leftover_file_of_a_killed_process_does_not_prevent_writing(tmp_path, monkeypatch):
    monkeypatch.setattr("os.getpid", lambda: 7)
    for _ in range(2):
        # never ended, as in a process that was killed
        next(atomic_file(tmp_path / "a").gen)
    write_files({tmp_path / "a": b"new"})
    assert (tmp_path / "a").read_bytes() == b"new"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_stop_signals_wait_for_the_end_of_a_block(number):
    seen: list[object] = []
    before = signal.signal(number, lambda number, _: seen.append(number))
    try:
        with defer_signals(), defer_signals():
            signal.raise_signal(number)
            seen.append("whole")
        assert seen == ["whole", number]
        with pytest.raises(RuntimeError, match="broken"), defer_signals():  # noqa: PT012
            signal.raise_signal(number)
            raise RuntimeError("broken")
        assert seen == ["whole", number, number]
    finally:
        signal.signal(number, before)


# --- each command -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def log(tmp_path_factory) -> Path:
    run = made_run(DESIGN)
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    groups = {topic: list(units.items()) for topic, units in made_groups(DESIGN).items()}
    with LogWriter(path, groups, run.provenance, run.attachments) as writer:
        writer.write(run.time, {topic: run.block(list(names)) for topic, names in made_groups(DESIGN).items()})
    return path


COMMANDS = {
    "plot": ("log", "plot", "RUN", "--out", "DIR"),
    "report": ("report", "RUN", "--out", "DIR/run.html"),
    "gif": ("animate", "RUN", "DIR/run.gif", "--frames", "2", "--width", "200"),
    "mp4": ("animate", "RUN", "DIR/run.mp4", "--frames", "2", "--width", "200"),
    "log csv": ("log", "csv", "RUN", "DIR/run.csv", "--columns", "gear_x"),
    "log parquet": ("log", "parquet", "RUN", "DIR/run.parquet", "--columns", "gear_x"),
    "log repair": ("log", "repair", "RUN", "DIR/run.mcap", "--scene-hz", "60", "--force"),
    "export": ("export", "--design", "pin", "--format", "dxf", "--out", "DIR"),
    "profile": ("design", "profile", "--design", "pin", "--csv", "DIR/gear.csv"),
    "kinematics": ("design", "kinematics", "--design", "pin", "--csv", "DIR/q.csv"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_full_disk_leaves_the_files_of_before(name, log, tmp_path):
    argv = [word.replace("RUN", str(log)).replace("DIR", str(tmp_path)) for word in COMMANDS[name]]
    assert told(*argv)[0] == 0
    before = {file: content + b"old" for file, content in contents(tmp_path).items()}
    assert before
    for file, content in before.items():
        (tmp_path / file).write_bytes(content)
    argv += [] if "--force" in argv else ["--force"]
    with disk_of(1000):
        code, _, err = told(*argv)
    assert code == 1
    assert err.startswith(("error: cannot write", "note: "))
    assert "error: cannot write" in err.splitlines()[-1]
    assert contents(tmp_path) == before


def test_model_folder_is_never_a_mixture(tmp_path):
    (tmp_path / "assets").mkdir()
    names = ("assets/gear.obj", "reducer.xml", "scene.xml")
    write_folder(dict.fromkeys(names, b"old"), tmp_path)
    with disk_of(1000), pytest.raises(CycloidError, match="cannot write"):
        write_folder({names[0]: b"new", names[1]: b"new", names[2]: bytes(5000)}, tmp_path)
    assert set(contents(tmp_path).values()) == {b"old"}


def test_an_outcome_is_written_completely(tmp_path):
    sizes = {"shaft": 100, "gear": 100}

    def written():
        maps = {f"nonpin_{part}.vtu": b"x" * size for part, size in sizes.items()}
        outcome = Outcome(title="stress", files=maps, pictures={"fig": lambda form: b"drawn"}, result={"x": math.pi})
        write(outcome, Destination("stress", tmp_path, None), Delivery(quiet=True))

    written()
    before = dict.fromkeys(contents(tmp_path), b"whole")
    assert {"nonpin_shaft.vtu", "nonpin_gear.vtu", "stress.json", "fig.png"} < before.keys()
    for name, content in before.items():
        (tmp_path / name).write_bytes(content)
    sizes["gear"] = 10_000
    with disk_of(1000), pytest.raises(CycloidError, match="cannot write"):
        written()
    assert contents(tmp_path) == before
