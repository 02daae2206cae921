"""Commands that are killed or stopped at any moment leave every earlier result whole, and every log readable."""

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pytest
from folders import contents

import cycloid_mj
from cycloid_mj.base.errors import LogError
from cycloid_mj.log import read

resource = pytest.importorskip("resource", reason="limits of processes are of POSIX alone")

SHORT = ("--ramp-s", "0", "--hold-s", "0.055", "--timestep-us", "10", "--set", 'ring.pins="fixed"', "--load-nm", "36")
COMMANDS = {
    "simulate": ("simulate", "--design", "pin", *SHORT, "--out", "sim", "--force"),
    "measure": (
        "measure",
        "loads",
        "--design",
        "pin",
        "--quick",
        "--set",
        'ring.pins="fixed"',
        "--out",
        "measured",
        "--force",
    ),
    "stress": ("stress", "--log", "sim/pin.mcap", "--part", "pin_1", "--quick", "--out", "stressed", "--force"),
    "plot": ("log", "plot", "sim/pin.mcap", "--out", "plotted", "--force"),
    "report": ("report", "sim/pin.mcap", "--out", "report.html", "--force"),
    "export": ("export", "--design", "pin", "--format", "stl", "--out", "parts", "--force"),
    "rate": ("rate", "--design", "pin", "--html", "rating.html", "--force"),
    "calibrate": (
        "calibrate",
        "--design",
        "printed",
        "--loop",
        "loop.csv",
        "--fit",
        "drag",
        "--out",
        "made",
        "--force",
    ),
    "tolerance": ("tolerance", "--set", 'tolerance.cam="IT6"', "--samples", "4", "--out", "drawn", "--force"),
    "reproduce": ("reproduce", "--quick", "--only", "geometry", "--out", "paper", "--force"),
    "build": ("build", "--design", "pin", "--out", "model", "--chord-error-um", "5", "--force"),
}
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
SEED = 14
PATIENCE = 600
"""Seconds after which a command counts as hung, on whatever machine."""


@dataclass(frozen=True)
class Moment:
    """When a command is ended: at a `share` of the processor time that it takes undisturbed, or `late` after it.

    `late` counts from its first change in the folder [s], for it is then that there is most to be spoilt.
    """

    command: str
    signal: signal.Signals
    share: float
    late: float | None


def moments(count: int, seed: int, commands: tuple[str, ...]) -> Iterator[Moment]:
    """Draw moments at which commands are ended; each command and each signal occurs about as often as the others."""
    drawn = random.Random(seed)
    # before a tenth, Python itself begins, and tells of Ctrl-C in its own way
    for number in range(count):
        share, late = drawn.uniform(0.1, 1.05), drawn.choice([None, drawn.uniform(0.0, 0.03)])
        yield Moment(commands[number % len(commands)], SIGNALS[number // len(commands) % len(SIGNALS)], share, late)


def started(command: str, folder: Path) -> subprocess.Popen[str]:
    environment = os.environ | {"PYTHONPATH": str(Path(cycloid_mj.__file__).parents[1])}
    argv = [sys.executable, "-m", "cycloid_mj", *COMMANDS[command]]
    return subprocess.Popen(
        argv,
        cwd=folder,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=_hear_signals,
    )


def _hear_signals() -> None:
    """Let a child be stopped though these tests run in the background of a shell, where Ctrl-C is ignored."""
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, signal.SIG_DFL)


def processor_time(process: "subprocess.Popen[str]") -> float:
    """Find the processor time that a process has taken so far [s]: a moment in its work, on however busy a machine."""
    try:
        fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return float("inf")
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def stamps(folder: Path) -> dict[str, tuple[int, int]]:
    """Map name to size and time of change [ns] of every file that is there at the moment."""
    found = {}
    for root, _, names in os.walk(folder):
        for name in names:
            with suppress(OSError):
                of = os.stat(os.path.join(root, name))
                found[os.path.join(root, name)] = (of.st_size, of.st_mtime_ns)
    return found


def whole_run(command: str, folder: Path) -> float:
    """Run a command to its end; give the processor time that it took [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    process = started(command, folder)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def logs_are_readable(files: dict[str, bytes], folder: Path) -> None:
    for name in files:
        if name.endswith(".mcap"):
            try:
                read(folder / name)
            except LogError as error:
                # killed before the first chunk: the log says so itself
                if "because the run was stopped too early" not in str(error):
                    raise


def result_is_whole(name: str, content: bytes, old: bytes, folder: Path) -> None:
    """Hold one file after a kill against what it was: it is as before, or a whole new one."""
    if content == old:
        return
    if name.endswith(".mcap"):
        assert read(folder / name).complete, name
    elif name.endswith((".html", ".json", ".svg", ".vtu", ".xml")):
        ending = {"html": b"</html>", "json": b"}", "svg": b"</svg>", "vtu": b"</VTKFile>", "xml": b"</mujoco>"}
        assert content.rstrip().endswith(ending[name.rpartition(".")[2]]), name
    elif name.endswith(".png"):
        assert content.endswith(b"IEND\xaeB`\x82"), name
    else:
        # parts, meshes, tables and designs have the same bytes every time
        raise AssertionError(f"{name} has changed")


def end_at(moment: Moment, taken: float, folder: Path) -> None:
    """End a command at a moment, and hold what it leaves against what was there before."""
    before = contents(folder)
    process = started(moment.command, folder)
    give_up = time.monotonic() + PATIENCE
    seen, end = stamps(folder), moment.share * taken
    while processor_time(process) < end and process.poll() is None:
        assert time.monotonic() < give_up, f"{moment}: hung before"
        time.sleep(0.0005)
        if moment.late is not None:
            end = float("inf") if stamps(folder) == seen else 0.0
    time.sleep(moment.late or 0.0)
    process.send_signal(moment.signal)
    try:
        _, err = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        raise
    after = contents(folder)
    for name, old in before.items():
        assert name in after, f"{moment}: {name} is gone"
        result_is_whole(name, after[name], old, folder)
    logs_are_readable(after, folder)
    new = set(after) - set(before)
    if moment.signal == signal.SIGKILL:
        assert process.returncode in (0, -signal.SIGKILL), (moment, err)
        assert all(Path(name).name.startswith(".") or ".partial" in name for name in new), (moment, new)
    else:
        # before Python has begun with the program, and after the program has ended, the system ends it
        stopped = 128 + moment.signal
        assert process.returncode in (0, stopped, -moment.signal), (moment, err)
        assert "Traceback" not in err, (moment, err)
        if process.returncode == stopped:
            word = "Ctrl-C" if moment.signal == signal.SIGINT else moment.signal.name
            assert f"stopped by {word}" in err.splitlines()[-1], (moment, err)
        assert all(".partial" in name for name in new), (moment, new)
    for name in new:
        (folder / name).unlink()


def killed(count: int, seed: int, chosen: tuple[str, ...], folder: Path) -> None:
    loop = (Path(__file__).parents[1] / "data" / "bench" / "play_loop.csv").read_text().splitlines()
    (folder / "loop.csv").write_text("\n".join([loop[0], *loop[1::8]]))
    taken = {command: whole_run(command, folder) for command in dict.fromkeys(("simulate", *chosen))}
    for moment in moments(count, seed, chosen):
        end_at(moment, taken[moment.command], folder)


@pytest.mark.slow
def test_commands_interrupted_at_any_moment_leave_complete_results(tmp_path):
    """Each command is ended once by each signal."""
    killed(len(COMMANDS) * len(SIGNALS), SEED, tuple(COMMANDS), tmp_path)
