"""What holds for every test."""

import os
import signal
from pathlib import Path

import numpy as np
import pytest

from cycloid_mj.base.memory import collect_rarely
from cycloid_mj.reducer import Reducer, reducer_of

try:
    import fcntl
except ImportError:  # Windows: each worker compiles for itself
    fcntl = None

collect_rarely()


@pytest.fixture(scope="session", autouse=True)
def interruptible():
    """Take Ctrl-C as a terminal's shell hands it on: what a script starts in the background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session", autouse=True)
def compiled(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Have the contact code compiled: in a new installation the first command takes longer, and says so.

    Of several workers each compiles another part, and waits for the others' instead of compiling them once more.
    """
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")
    if not worker:
        _contact()
        return
    parts = (_dynamics, _statics)
    first = int(worker.removeprefix("gw")) % len(parts)
    for part in (*parts[first:], *parts[:first]):
        with (tmp_path_factory.getbasetemp().parent / f"{part.__name__}.lock").open("w") as lock:
            if fcntl:
                fcntl.flock(lock, fcntl.LOCK_EX)
            part()


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make an empty folder the working directory and return it."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _contact() -> None:
    from cycloid_mj.dynamics.contact.collider import install

    with install():
        pass


def _dynamics() -> None:
    """Compile the contact code and the steps of both solvers."""
    from cycloid_mj.design import PRESETS, override
    from cycloid_mj.dynamics.planar.model import planar_model
    from cycloid_mj.dynamics.run import simulate

    for name in ("pin", "nonpin", "rv80e"):  # an internal gear has contacts of its own, and so have cranks
        design = override(PRESETS[name], {"drive.ramp_s": 0.0, "drive.hold_s": 1e-5})
        simulate(design)
        simulate(design, planar_model(reducer_of(design)))


def _statics() -> None:
    """Compile the static balance with all its paths, of samples, and along a load path with friction."""
    from cycloid_mj.checks import check
    from cycloid_mj.design import PRESETS, Design, override
    from cycloid_mj.statics.friction_path import Losses, follow_torque_path
    from cycloid_mj.statics.samples import MAX_UNCOMPILED, identical_samples, solve_samples
    from cycloid_mj.statics.sheet import sheet

    reducer = Reducer(Design())
    sheet(reducer)
    solve_samples(reducer, identical_samples(reducer, MAX_UNCOMPILED + 1), [1.0], 2)
    follow_torque_path(reducer, np.linspace(0.0, 1.0, 3), 0.0, Losses())
    check(override(PRESETS["pin"], {"friction.pin_gear": 2.0, "friction.pin_socket": 2.0}))  # it jams on every path
