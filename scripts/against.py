"""Hold this tree against another revision of it: CPU time of whole commands, taken in turn, and the figures of both.

The other revision is laid out in a folder of its own and run by the same interpreter with the same packages. Both logs
are judged by this tree's reader, so that a figure means the same for both.
"""

import os
import subprocess
import sys
import tarfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from cycloid_mj.log import read
from cycloid_mj.record import Run

ROOT = Path(__file__).resolve().parents[1]
RATED = ("--load-nm", "36.68", "--ramp-s", "0")
SETTLING = 0.015
"""Start of the figures [s]: the load is on after 5 ms, and the jolt of the start gone after 10."""

ARCSEC = np.pi / 648000.0


@dataclass(frozen=True)
class Trial:
    """A run to time.

    Attributes
    ----------
    name
        What it is called.
    flags
        Flags of ``cycloid-mj simulate`` for both revisions.
    timestep_us
        Time step of this tree; the other revision keeps its own default. None for both on their defaults.
    reference_us
        Time step of the other revision's run that the figures are held against.
    """

    name: str
    flags: tuple[str, ...]
    timestep_us: float | None = None
    reference_us: float = 0.5


def turn(share: float) -> tuple[str, str]:
    """Give the flag of a hold that goes on for so many crank turns after the figures start."""
    return "--hold-s", repr(SETTLING + share * 60.0 / 1640.0)


TRIALS = (
    Trial("default run", ("--design", "pin"), reference_us=1.0),
    Trial("free pins, 36.68 N m", ("--design", "pin", *RATED, *turn(1.0))),
    Trial("fixed pins, 36.68 N m", ("--design", "pin", "--set", 'ring.pins="fixed"', *RATED, *turn(1.0)), 10.0),
    Trial("nonpin, 36.68 N m", ("--design", "nonpin", *RATED, *turn(1.0)), 10.0),
)


@contextmanager
def laid_out(revision: str) -> Iterator[Path]:
    """Lay a revision of this repository out in a folder, which is given.

    Raises
    ------
    SystemExit
        Git does not know the revision.
    """
    packed = subprocess.run(["git", "archive", revision, "cycloid_mj"], cwd=ROOT, capture_output=True, check=False)
    if packed.returncode:
        sys.exit(f"no revision {revision} here: {packed.stderr.decode().strip().splitlines()[-1]}")
    with TemporaryDirectory() as folder:
        with tarfile.open(fileobj=BytesIO(packed.stdout)) as archive:
            archive.extractall(folder, filter="data")
        yield Path(folder)


def cpu_time(tree: Path, flags: tuple[str, ...], out: Path) -> float:
    """Run ``cycloid-mj simulate`` of a tree into a folder; give its CPU time [s], its threads and children included."""
    command = [sys.executable, "-m", "cycloid_mj.cli", "simulate", "--quiet", "--json", "--out", str(out), *flags]
    environment = os.environ | {"PYTHONPATH": str(tree)}
    process = subprocess.Popen(command, cwd=tree, env=environment, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"failed with exit code {process.returncode}: {' '.join(command)}")
    return usage.ru_utime + usage.ru_stime


def figures(run: Run, lobes: int) -> dict[str, float]:
    """Give the figures of a run over the crank turn at its end: speeds, transmission error, cam force, efficiency."""
    late = run.select(run.time > max(SETTLING, run.time[-1] - 60.0 / 1640.0))
    error = (late["output_angle"] + late["crank_angle"] / lobes) / ARCSEC
    speed = late["gear_speed"] + late["crank_speed"] / lobes
    power_in = float((late["crank_torque"] * late["crank_speed"]).mean())
    power_out = -float((late["load_torque"] * late["output_speed"]).mean())
    found = {
        "rms gear speed [rad/s]": float(np.sqrt((speed**2).mean())),
        "mean TE [arcsec]": float(error.mean()),
        "TE p-p [arcsec]": float(np.ptp(error)),
        "cam [N]": float(np.hypot(late["cam_force_x"], late["cam_force_y"]).mean()),
    }
    return found | ({"efficiency [%]": 1e2 * power_out / power_in} if power_out > 0.0 else {})


def compare(trial: Trial, other: Path, passes: int) -> tuple[list[float], list[float], dict[str, Mapping[str, float]]]:
    """Time a run of this tree and of another in turn; give both CPU times of each pass [s], and the figures.

    The figures are those of this tree, of the other one, and of the other one at the reference's step.
    """
    step = () if trial.timestep_us is None else ("--timestep-us", repr(trial.timestep_us))
    ours: list[float] = []
    theirs: list[float] = []
    with TemporaryDirectory() as folder:
        out = Path(folder)
        for number, tree in enumerate((ROOT, other)):
            cpu_time(tree, (*trial.flags[:2], "--ramp-s", "0", "--hold-s", "0.001"), out / f"warm{number}")
        for number in range(passes):
            ours.append(cpu_time(ROOT, (*trial.flags, *step), out / f"ours{number}"))
            theirs.append(cpu_time(other, trial.flags, out / f"other{number}"))
        fine = ("--timestep-us", repr(trial.reference_us))
        cpu_time(other, (*trial.flags, *fine), out / "reference")
        places = {"this tree": "ours0", "other": "other0", f"other at {trial.reference_us:g} us": "reference"}
        design = trial.flags[1]
        return ours, theirs, {name: figures(read(out / at / f"{design}.mcap"), 35) for name, at in places.items()}
