"""A log that is to be replaced stays until the new one is whole, and two runs never write one log."""

import json
import signal
import threading
from pathlib import Path

import numpy as np
import pytest
from commands import told

import cycloid_mj.dynamics.run
from cycloid_mj.base.errors import LogError, RunError
from cycloid_mj.base.interrupt import STOPPING, Stopped, raise_on_signals
from cycloid_mj.cli.compare import RUNS
from cycloid_mj.cli.simulate import logs_folder
from cycloid_mj.log import LogTakenError, LogWriter, read
from cycloid_mj.log import write as write_run
from cycloid_mj.log.reader import load

GROUPS = {"/reducer": [("crank_angle", "rad")]}
SHORT = ("--ramp-s", "0", "--hold-s", "0.01", "--quiet")


def write(log: LogWriter, first: int, last: int) -> None:
    time = np.arange(first, last, dtype=np.float64)
    log.write(time, {"/reducer": time[:, np.newaxis]})


def write_log(path: Path, samples: int, **options) -> None:
    with LogWriter(path, GROUPS, **options) as log:
        write(log, 0, samples)


@pytest.fixture
def old(tmp_path) -> Path:
    path = tmp_path / "run.mcap"
    write_log(path, 3)
    return path


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


# --- the writer -------------------------------------------------------------------------------------------------------


def test_forced_log_is_written_beside_the_old_one_and_replaces_it_when_complete(old):
    with LogWriter(old, GROUPS, force=True) as log:
        write(log, 0, 5)
        log.flush()
        assert names(old.parent) == ["run.mcap", "run.partial.mcap"]
        assert (log.path, log.name) == (old.with_name("run.partial.mcap"), old)
        assert len(read(old)) == 3
        assert len(read(log.path)) == 5
    assert log.path == old
    assert names(old.parent) == ["run.mcap"]
    assert len(read(old)) == 5


@pytest.mark.parametrize("error", [RuntimeError("NaN"), KeyboardInterrupt(), Stopped("SIGTERM")])
def test_an_interrupted_forced_log_keeps_the_old_log_and_its_own_samples(error, old):
    for number, name in ((1, "run.partial.mcap"), (2, "run.partial-2.mcap")):
        with pytest.raises(type(error)), LogWriter(old, GROUPS, force=True) as log:  # noqa: PT012
            write(log, 0, 10 * number)
            raise error
        assert log.path.name == name
        partial = read(old.with_name(name))
        assert (len(partial), partial.complete) == (10 * number, False)
    assert (len(read(old)), read(old).complete) == (3, True)


def test_forced_log_without_samples_leaves_only_the_old_one(old):
    with pytest.raises(RuntimeError, match="early"), LogWriter(old, GROUPS, force=True):
        raise RuntimeError("early")
    assert names(old.parent) == ["run.mcap"]
    assert len(read(old)) == 3


def test_log_that_another_run_writes_or_replaces_is_not_replaced(old, tmp_path):
    with LogWriter(old, GROUPS, force=True) as log:
        write(log, 0, 5)
        with pytest.raises(LogError, match=r"another run is writing the log .*run\.mcap"):
            LogWriter(old, GROUPS, force=True)
    write_log(old, 7, force=True)
    with LogWriter(tmp_path / "new.mcap", GROUPS) as log:
        write(log, 0, 5)
        with pytest.raises(LogError, match=r"another run is writing the log .*new\.mcap"):
            LogWriter(tmp_path / "new.mcap", GROUPS, force=True)
        with pytest.raises(LogTakenError, match="already exists"):
            LogWriter(tmp_path / "new.mcap", GROUPS)
    assert names(tmp_path) == ["new.mcap", "run.mcap"]
    assert (len(read(old)), len(read(tmp_path / "new.mcap"))) == (7, 5)


def test_a_rewritten_log_appears_completely_or_not_at_all(old, tmp_path):
    found = load(old)
    new = tmp_path / "new.mcap"
    with pytest.raises(KeyboardInterrupt), LogWriter(new, GROUPS, hidden=True) as log:  # noqa: PT012
        write(log, 0, 5)
        assert not new.exists()
        raise KeyboardInterrupt
    assert names(tmp_path) == ["run.mcap"]
    with LogWriter(new, GROUPS, hidden=True) as log:
        write(log, 0, 5)
        write_log(new, 2)  # meanwhile
        with pytest.raises(LogTakenError, match="already exists"):
            log.close()
    assert names(tmp_path) == ["new.mcap", "run.mcap"]
    assert len(read(new)) == 2
    write_run(found.run, new, force=True)
    assert len(read(new)) == 3
    assert names(tmp_path) == ["new.mcap", "run.mcap"]


# --- the command ------------------------------------------------------------------------------------------------------


@pytest.fixture
def at_the_end(monkeypatch):
    """Let runs last an instant; what is put in the list is called when half of the samples are logged."""
    calls = []

    def blocks(compiled, reducer):
        groups = cycloid_mj.dynamics.run.log_columns(compiled, reducer)
        for first in (0, 2):
            time = 1e-4 * np.arange(first, first + 2)
            speed = np.full(2, reducer.design.drive.speed)
            values = {topic: np.zeros((2, len(group))) for topic, group in groups.items()}
            values["/reducer"][:, list(groups["/reducer"]).index("crank_speed")] = speed
            values["/reducer"][:, list(groups["/reducer"]).index("crank_angle")] = time * speed
            yield cycloid_mj.dynamics.run.SampleBlock(time, values)
            if not first and calls:
                calls.pop()()
        return ()

    monkeypatch.setattr(cycloid_mj.dynamics.run, "blocks", blocks)
    return calls


def simulated(*argv: str) -> dict:
    code, out, err = told("simulate", "--design", "pin", *SHORT, "--json", *argv)
    assert (code, err) == (0, "")
    return json.loads(out)


def failing(error: BaseException):
    def fail():
        raise error

    return fail


@pytest.mark.parametrize(
    ("error", "words", "exit_code"),
    [
        (RunError("the gear jumped a tooth"), "jumped", 1),
        (KeyboardInterrupt(), "by Ctrl-C", 130),
        (Stopped("SIGTERM"), "by SIGTERM", 143),
    ],
)
def test_forced_run_that_ends_early_keeps_the_old_log(here, at_the_end, error, words, exit_code):
    simulated("--out", "mine")
    before = Path("mine/pin.mcap").read_bytes()
    at_the_end.append(failing(error))
    code, _, err = told("simulate", "--design", "pin", *SHORT, "--out", "mine", "--force")
    assert code == exit_code
    assert err.count("\n") == 1
    assert words in err
    assert "the 2 samples up to then are in mine/pin.partial.mcap; the previous log mine/pin.mcap is unchanged" in err
    assert Path("mine/pin.mcap").read_bytes() == before
    partial = read("mine/pin.partial.mcap")
    assert (len(partial), partial.complete) == (2, False)
    assert names(here / "mine") == ["pin.mcap", "pin.partial.mcap"]


@pytest.mark.slow
def test_second_forced_run_meanwhile_ends_with_one_error(here, at_the_end):
    simulated("--out", "mine", "--speed-rpm", "100")
    second = []
    at_the_end.append(lambda: second.append(told("simulate", "--design", "pin", *SHORT, "--out", "mine", "--force")))
    first = simulated("--out", "mine", "--speed-rpm", "200", "--force")
    ((code, out, err),) = second
    assert (code, out) == (1, "")
    assert err.startswith("error: another run is writing the log mine/pin.mcap")
    assert err.count("\n") == 1
    assert first["crank"]["speed_rad_s"] == pytest.approx(200 * 2 * np.pi / 60)
    assert names(here / "mine") == ["pin.mcap"]


@pytest.mark.slow
def test_a_run_whose_name_is_taken_meanwhile_uses_the_next_name(here, at_the_end, monkeypatch):
    second = []
    built = cycloid_mj.dynamics.run.model_for

    def slowly(*args):
        # the name was free when this run began, and is taken by another one while the model is made
        if not second:
            second.append(None)
            second.append(simulated("--speed-rpm", "200"))
        return built(*args)

    monkeypatch.setattr(cycloid_mj.dynamics.run, "model_for", slowly)
    first = simulated("--speed-rpm", "100")
    assert (second[1]["log"], first["log"]) == ("runs/pin.mcap", "runs/pin-2.mcap")
    for found, rpm in ((second[1], 200), (first, 100)):
        assert found["crank"]["speed_rad_s"] == pytest.approx(rpm * 2 * np.pi / 60)
    assert names(here / "runs") == ["pin-2.mcap", "pin.mcap"]


@pytest.mark.slow
def test_figures_of_a_run_are_its_own_if_its_log_is_replaced_at_the_same_time(here, at_the_end, monkeypatch):
    simulated("--out", "mine", "--speed-rpm", "50")
    close, second = LogWriter.close, []

    def closed(self, *args, **options):
        close(self, *args, **options)
        if not second:
            second.append(None)
            simulated("--out", "mine", "--speed-rpm", "200", "--force")

    monkeypatch.setattr(LogWriter, "close", closed)
    found = simulated("--out", "mine", "--speed-rpm", "100", "--force")
    assert found["crank"]["speed_rad_s"] == pytest.approx(100 * 2 * np.pi / 60)


def test_simultaneous_commands_get_their_own_folders(here):
    found: list[Path] = []
    threads = [
        threading.Thread(target=lambda: found.append(logs_folder(RUNS, None, ["pin-no-load"], False))) for _ in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(map(str, found)) == sorted([RUNS, *(f"{RUNS}-{number}" for number in range(2, 9))])


@pytest.mark.slow
@pytest.mark.parametrize("number", [number for number in STOPPING if number != signal.SIGINT])
def test_stopped_run_states_by_what(here, at_the_end, number):
    before = {number: signal.getsignal(number) for number in STOPPING}
    signal.signal(number, signal.SIG_DFL)  # a test run under nohup ignores one
    raise_on_signals()
    try:
        at_the_end.append(lambda: signal.raise_signal(number))
        code, out, err = told("simulate", "--design", "pin", *SHORT)
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)
    name = signal.Signals(number).name
    assert (code, out) == (128 + number, "")
    assert err == f"error: stopped by {name}; the 2 samples up to then are in runs/pin.mcap\n"
    assert read("runs/pin.mcap").note == f"stopped by {name}"
