"""Compare this tree with another revision: CPU time and memory of whole commands, taken in turn, and their figures.

The other revision is laid out in a folder of its own and run by the same interpreter with the same packages. The logs
of both are judged by this tree's reader, so that a figure means the same for both.
"""

import json
import math
import os
import subprocess
import sys
import tarfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from typing import Any

import numpy as np

from cycloid_mj.base.record import Run
from cycloid_mj.design import loads
from cycloid_mj.log import read

ROOT = Path(__file__).resolve().parents[1]
TURN = 60.0 / 1640.0
"""A crank turn at the designs' speed [s]."""

SETTLING = 0.015
"""Start of the figures [s] (heuristic): the load is on after 5 ms, and the jolt of the start gone after 10."""

ARCSEC = np.pi / 648000.0  # [rad]

Figures = Mapping[str, float]


@dataclass(frozen=True)
class Finished:
    """A command that has run: CPU time [s], its children's included, peak memory [MB], output and folder."""

    cpu: float
    memory: float
    printed: str
    out: Path


def figures(run: Run) -> dict[str, float]:
    """Compute figures of a run over its last crank turn: speeds, transmission error, cam force, efficiency."""
    lobes = loads(run.attachments["design.toml"].decode()).lobes
    last_turn = run.select(run.time > max(SETTLING, run.time[-1] - TURN))
    error = (last_turn["output_angle"] + last_turn["crank_angle"] / lobes) / ARCSEC
    speed = last_turn["gear_speed"] + last_turn["crank_speed"] / lobes
    power_in = float((last_turn["crank_torque"] * last_turn["crank_speed"]).mean())
    power_out = -float((last_turn["load_torque"] * last_turn["output_speed"]).mean())
    values = {
        "rms gear speed [rad/s]": float(np.sqrt((speed**2).mean())),
        "mean TE [arcsec]": float(error.mean()),
        "TE p-p [arcsec]": float(np.ptp(error)),
        "q path, rms [um]": 1e6 * float(np.hypot(last_turn["gear_x"], last_turn["gear_y"]).std()),
        "cam [N]": float(np.hypot(last_turn["cam_force_x"], last_turn["cam_force_y"]).mean()),
    }
    return values | ({"efficiency [%]": 1e2 * power_out / power_in} if power_out > 0.0 else {})


def figures_of_log(finished: Finished) -> Figures:
    """Return the figures of the one run that a command has logged."""
    (log,) = finished.out.glob("*.mcap")
    return figures(read(log))


def figures_of_json(finished: Finished) -> Figures:
    """Collect the numbers that a command has printed as JSON by their path, except times and memory."""
    numbers: dict[str, float] = {}

    def add_numbers(path: str, value: Any) -> None:
        """Add the numbers in a JSON value, and in all values below it, by their path."""
        if isinstance(value, dict):
            for key, item in value.items():
                add_numbers(f"{path}.{key}", item)
        elif isinstance(value, list):
            for number, item in enumerate(value):
                add_numbers(f"{path}.{item.get('key', number) if isinstance(item, dict) else number}", item)
        elif isinstance(value, float) and math.isfinite(value) and not path.endswith(("_s", "_mb")):
            numbers[path.lstrip(".")] = value

    add_numbers("", json.loads(finished.printed))
    return numbers


@dataclass(frozen=True)
class Trial:
    """A command to time in both trees."""

    name: str
    """What it is called."""
    words: tuple[str, ...]
    """The command: words of ``cycloid-mj``, or a program for Python if its first line is ``import``."""
    ours: tuple[str, ...] = ()
    """Further words for this tree."""
    reference: tuple[str, ...] = ()
    """Further words for a reference run of both trees; none: no reference run."""
    figures: Callable[[Finished], Figures] = figures_of_log
    """Figures by which both trees are compared."""
    logged: bool = True
    """Whether the command takes ``--out`` for its files."""


def list_run_words(design: str, *flags: str, hold: float = SETTLING + TURN) -> tuple[str, ...]:
    """List the words of a run at full speed under the rated load, by default of one crank turn after it has settled."""
    return ("simulate", "--design", design, "--load-nm", "36.68", "--ramp-s", "0", "--hold-s", repr(hold), *flags)


FINE = ("--timestep-us", "0.5")
STATICS = """import json, sys
import numpy as np
from cycloid_mj.design import PRESETS, override
try:
    from cycloid_mj.reducer import Reducer as prepared
    from cycloid_mj.statics.balance import transmission_error
except ImportError:
    prepared = lambda design: design
    try:
        from cycloid_mj.loaded.balance import transmission_error
    except ImportError:
        from cycloid_mj.measure.static_error import static_error as transmission_error
by_case = {}
crank = np.linspace(0.0, 2.0 * np.pi, 361)[:-1]
for name in ("pin", "nonpin"):
    for seed in range(5):
        made = ["hole_position", "pin_position"] if name == "pin" else ["hole_position"]
        changes = [f"errors.seed={seed}", *(f"errors.{each}_um=1.0" for each in made)]
        errors = transmission_error(prepared(override(PRESETS[name], changes)), crank, 36.68)
        by_case[f"{name} {seed}"] = {"mean": float(errors[:, 0].mean()), "std": float(errors[:, 0].std())}
json.dump(by_case, sys.stdout)
"""
"""Static transmission error of ten toleranced reducers over a turn, by what each revision has for it."""

LOOPS = """import json, sys, time
from cycloid_mj.design import PRESETS, override
prepared, newer = lambda design: design, True
try:
    from cycloid_mj.dynamics.mjcf import build
    from cycloid_mj.dynamics.run import blocks
    from cycloid_mj.reducer import Reducer as prepared
except ImportError:
    from cycloid_mj.mjcf import build
    try:
        from cycloid_mj.run import blocks
    except ImportError:
        from cycloid_mj.simulate import blocks
        newer = False
massless = ["ring.pins=massless"] if newer else []
cases = {
    "free pins, 36.68 N m": ("pin", 36.68, 0.03, []),
    "massless pins, 36.68 N m": ("pin", 36.68, 0.03, massless),
    "fixed pins, 36.68 N m": ("pin", 36.68, 0.1, ["ring.pins=fixed"]),
    "nonpin, 36.68 N m": ("nonpin", 36.68, 0.1, []),
}
by_case = {}
for name, (preset, load, hold, changes) in cases.items():
    run = ["drive.ramp_s=0", f"drive.hold_s={hold}", f"load.torque_nm={load}", *changes]
    design = override(PRESETS[preset], run)
    samples = blocks(build(design), prepared(design))
    next(samples)
    start = time.thread_time()
    taken = sum(len(block.time) for block in samples)
    by_case[name] = (time.thread_time() - start) * design.settings.log_rate / taken
json.dump(by_case, sys.stdout)
"""
"""CPU time of a simulated second [s] in the step loop alone, from the first block of samples on.

Each is at the step that the revision runs it at; one that has no massless pins runs free ones instead. Idle pins cost
more once they have come to move about, which takes a fifth of a second: the default run is the measure of them.
"""

TRIALS = (
    Trial("start and end of a run", list_run_words("pin", hold=0.001), figures=figures_of_json),
    Trial("default run", ("simulate", "--design", "pin")),
    Trial("free pins, 36.68 N m", list_run_words("pin"), reference=FINE),
    Trial("massless pins, 36.68 N m", list_run_words("pin"), ("--set", 'ring.pins="massless"'), reference=FINE),
    Trial("fixed pins, 36.68 N m", list_run_words("pin", "--set", 'ring.pins="fixed"'), reference=FINE),
    Trial("nonpin, 36.68 N m", list_run_words("nonpin"), reference=FINE),
    Trial("stress of pin", ("stress", "--design", "pin"), figures=figures_of_json),
    Trial("validate", ("validate",), figures=figures_of_json, logged=False),
    Trial("statics, 10 x 360 angles", (STATICS,), figures=figures_of_json, logged=False),
)


@contextmanager
def check_out(revision: str) -> Iterator[Path]:
    """Check out a revision of this repository in a temporary folder while the context is open, and yield the folder.

    The script exits if there is no such revision.
    """
    packed = subprocess.run(["git", "archive", revision, "cycloid_mj"], cwd=ROOT, capture_output=True, check=False)
    if packed.returncode:
        sys.exit(f"no revision {revision} here: {packed.stderr.decode().strip().splitlines()[-1]}")
    with TemporaryDirectory() as folder:
        with tarfile.open(fileobj=BytesIO(packed.stdout)) as archive:
            archive.extractall(folder, filter="data")
        yield Path(folder)


def run_trial(tree: Path, trial: Trial, extra_words: tuple[str, ...], out: Path) -> Finished:
    """Run a trial's command with the package in `tree` and with extra words; its files go to the folder `out`.

    The script exits if the command fails.
    """
    program, *flags = trial.words
    into = ("--out", str(out)) if trial.logged else ()
    if program.startswith("import"):
        command = [sys.executable, "-c", program]
    else:
        quiet = ("--quiet",) if trial.logged else ()
        run = "from cycloid_mj.cli import run; run()"
        command = [sys.executable, "-c", run, program, *flags, *extra_words, "--json", *quiet, *into]
    out.mkdir()
    with TemporaryFile() as printed:
        environment = os.environ | {"PYTHONPATH": str(tree)}
        process = subprocess.Popen(command, cwd=out, env=environment, stdout=printed)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            sys.exit(f"failed with exit code {process.returncode}: {' '.join(command)}")
        printed.seek(0)
        text = printed.read().decode()
    return Finished(usage.ru_utime + usage.ru_stime, 1e-3 * usage.ru_maxrss, text, out)


def compare(trial: Trial, other: Path, passes: int) -> tuple[list[Finished], list[Finished], dict[str, Figures]]:
    """Run a trial in this tree and in another in turn, `passes` times each, after a run that compiles.

    Return the finished commands of this tree, those of the other, and the figures of both trees by name of the run. If
    the trial has a reference run, its figures in both trees are included.
    """
    ours: list[Finished] = []
    theirs: list[Finished] = []
    with TemporaryDirectory() as folder:
        out = Path(folder)
        warm_up = Trial("warm", ("simulate", *trial.words[1:3], "--ramp-s", "0", "--hold-s", "0.001"))
        for number, tree in enumerate((ROOT, other)):
            run_trial(tree, warm_up if trial.words[0] == "simulate" else trial, (), out / f"warm{number}")
        for number in range(passes):
            ours.append(run_trial(ROOT, trial, trial.ours, out / f"ours{number}"))
            theirs.append(run_trial(other, trial, (), out / f"other{number}"))
        figures_by_run = {"this tree": trial.figures(ours[0]), "other": trial.figures(theirs[0])}
        if trial.reference:
            for name, tree in (("this tree, fine", ROOT), ("other, fine", other)):
                figures_by_run[name] = trial.figures(run_trial(tree, trial, trial.reference, out / name))
    return ours, theirs, figures_by_run


def loops(other: Path, passes: int) -> dict[str, tuple[list[float], list[float]]]:
    """Measure the step loops of `LOOPS` in this tree and in another in turn: case -> CPU times here and there [s]."""
    times: dict[str, tuple[list[float], list[float]]] = {}
    trial = Trial("loops", (LOOPS,), figures=figures_of_json, logged=False)
    with TemporaryDirectory() as folder:
        for number in range(passes):
            for side, tree in enumerate((ROOT, other)):
                costs = trial.figures(run_trial(tree, trial, (), Path(folder) / f"{number}-{side}"))
                for name, cost in costs.items():
                    times.setdefault(name, ([], []))[side].append(cost)
    return times


def difference(ours: Figures, theirs: Figures) -> tuple[str, float, int]:
    """Find the figure that differs most between two runs; return its name, its relative difference, and their number.

    The difference is relative to `theirs`; figures that only one run has are left out.
    """
    common = {name: abs(ours[name] / theirs[name] - 1.0) for name in ours if theirs.get(name)}
    worst = max(common, key=lambda name: common[name], default="")
    return worst, common.get(worst, math.nan), len(common)
