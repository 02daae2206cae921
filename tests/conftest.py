"""What holds for every test."""

import os
import signal
from pathlib import Path

import numpy as np
import pytest

from cycloid_mj.base.memory import look_rarely
from cycloid_mj.reducer import Reducer

try:
    import fcntl
except ImportError:  # Windows: each worker compiles for itself
    fcntl = None

look_rarely()


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
    parts = (_contact_and_sliding, _statics)
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


def _contact_and_sliding() -> None:
    from cycloid_mj.design import Design
    from cycloid_mj.statics.friction_path import Losses, course_along

    _contact()
    course_along(Reducer(Design()), np.linspace(0.0, 1.0, 3), 0.0, Losses())


def _statics() -> None:
    from cycloid_mj.design import Design
    from cycloid_mj.statics.samples import identical_samples, solve_samples
    from cycloid_mj.statics.sheet import sheet

    sheet(Reducer(Design()))
    solve_samples(Reducer(Design()), identical_samples(Reducer(Design()), 1), [1.0], 2)
