"""Many pieces of work: in threads, processes and on a Dask cluster, with workers that die or are of another kind."""

import os
import select
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

import cycloid_mj
from cycloid_mj.base.engine import Engine, versions
from cycloid_mj.base.engine.packages import require_same_versions
from cycloid_mj.base.errors import DesignError, RunError, UsageError


def square(number: int) -> int:
    return number**2


def fail(number: int) -> int:
    if number == 3:
        raise DesignError("spoiled")
    return number


def inner_workers(_: int) -> int:
    return Engine(8, "threads").local_workers


def die_once(place: Path, number: int) -> int:
    """Kill the process that works on 5, the first time."""
    if number == 5 and not place.exists():
        place.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number**2


def die_always(number: int) -> int:
    if number == 5:
        os.kill(os.getpid(), signal.SIGKILL)
    return number**2


LOCAL = [Engine(1), Engine(2), Engine(2, "threads")]


@pytest.mark.parametrize("engine", LOCAL, ids=["here", "processes", "threads"])
def test_results_come_with_their_places(engine: Engine) -> None:
    assert dict(engine.stream(square, range(20))) == {n: n**2 for n in range(20)}
    told: list[tuple[int, int]] = []
    assert engine.each(square, [3, 1, 2], lambda *one: told.append(one)) == [9, 1, 4]
    assert told == [(1, 3), (2, 3), (3, 3)]
    assert engine.each(square, []) == []


@pytest.mark.parametrize("engine", LOCAL, ids=["here", "processes", "threads"])
def test_an_error_of_the_work_ends_it(engine: Engine) -> None:
    with pytest.raises(DesignError, match="spoiled"):
        engine.each(fail, range(100))


@pytest.mark.parametrize("engine", LOCAL, ids=["here", "processes", "threads"])
def test_a_stream_that_is_closed_early_has_no_warning(engine: Engine) -> None:
    results = engine.stream(square, range(100))
    next(results)
    results.close()


@pytest.mark.parametrize("engine", LOCAL, ids=["here", "processes", "threads"])
def test_nested_work_uses_one_core(engine: Engine) -> None:
    assert inner_workers(0) == 8
    assert engine.each(inner_workers, range(3)) == [1, 1, 1]


@pytest.mark.slow
def test_a_process_that_dies_is_replaced(tmp_path: Path) -> None:
    work = partial(die_once, tmp_path / "died")
    assert Engine(2).each(work, range(12)) == [n**2 for n in range(12)]
    assert (tmp_path / "died").exists()


@pytest.mark.slow
def test_only_the_item_that_kills_its_process_fails() -> None:
    found = dict(Engine(2).stream(die_always, range(12), on_lost=lambda place, why: -place))
    assert found == {n: n**2 for n in range(12)} | {5: -5}
    with pytest.raises(RunError, match="job 6 failed: its worker process died"):
        Engine(2).each(die_always, range(12))


GROW = """
import time, warnings
from cycloid_mj.base.engine import Engine

kept = []

def grow(number):
    kept.append(b"1" * 100_000_000)
    time.sleep(0.2)
    return number

if __name__ == "__main__":
    import grow
    warnings.simplefilter("error")
    assert Engine(2).each(grow.grow, range(16)) == list(range(16))
"""


@pytest.mark.slow
def test_a_worker_that_ends_early_is_replaced_even_if_warnings_are_errors(tmp_path: Path) -> None:
    (tmp_path / "grow.py").write_text(GROW)
    paths = os.pathsep.join([str(tmp_path), str(Path(cycloid_mj.__file__).parents[1])])
    environment = os.environ | {"PYTHONPATH": paths}
    subprocess.run([sys.executable, str(tmp_path / "grow.py")], env=environment, check=True, timeout=600)


def test_other_versions_are_refused() -> None:
    require_same_versions(versions(), "a worker")
    other = tuple((name, "0.0.1" if name == "numpy" else version) for name, version in versions())
    with pytest.raises(
        RunError,
        match=r"has different package versions from this computer: numpy is 0\.0\.1 there and .* here\. Install",
    ):
        require_same_versions(other, "a worker")


@pytest.mark.slow
def test_an_unreachable_scheduler_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    from cycloid_mj.base.engine import cluster as module

    monkeypatch.setattr(module, "SECONDS_TO_CONNECT", 0.5)
    with pytest.raises(UsageError, match="give HOST:PORT"):
        Engine(scheduler="somewhere").each(square, [1])
    with pytest.raises(RunError, match="no Dask scheduler answers at 127"):
        Engine(scheduler="127.0.0.1:9").each(square, [1])


ORPHAN = """
import multiprocessing, os, sys, time
from cycloid_mj.base.engine import housekeeping


def serve(as_on_windows):
    if as_on_windows:
        os.getppid = lambda own=os.getppid(): own
    housekeeping.serve_parent()
    print(os.getpid(), flush=True)
    time.sleep(600)


if __name__ == "__main__":
    multiprocessing.get_context("spawn").Process(target=serve, args=(sys.argv[1] == "windows",)).start()
    time.sleep(600)
"""


@pytest.mark.parametrize("system", ["posix", "windows"])
def test_a_worker_ends_with_a_parent_that_is_killed(system: str, tmp_path: Path) -> None:
    """On Windows the number of a parent stays as it was: a worker outlived it."""
    script = tmp_path / "orphan.py"
    script.write_text(ORPHAN)
    with subprocess.Popen([sys.executable, str(script), system], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout
        worker = int(parent.stdout.readline())
        parent.kill()
        parent.wait()
        # its end of the pipe closes when the worker has gone
        ready, _, _ = select.select([parent.stdout], [], [], 60.0)
        ended = bool(ready) and parent.stdout.read() == ""
        if not ended:
            os.kill(worker, signal.SIGKILL)
    assert ended
