"""Work on a real Dask scheduler and two workers, each a process: the same bits as here, and one worker killed."""

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cycloid_mj.base.engine import Engine, Versions
from cycloid_mj.base.engine.packages import require_same_versions
from cycloid_mj.base.errors import DesignError, RunError
from cycloid_mj.design import PRESETS, override
from cycloid_mj.explore import tolerances
from cycloid_mj.explore.budget import SobolSettings
from cycloid_mj.explore.sweeps import sweep
from cycloid_mj.explore.tolerances import tolerance

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1] / "scripts"))

from dask_cluster import Cluster  # noqa: E402

PIN = PRESETS["pin"]


def fail(number: int) -> int:
    if number == 3:
        raise DesignError("spoiled")
    return number


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with Cluster(tmp_path_factory.mktemp("cluster"), path=(HERE, HERE.parent)) as found:
        yield found


@pytest.mark.slow
def test_a_sweep_equals_a_local_sweep_bit_by_bit_after_a_worker_is_killed(cluster: Cluster, tmp_path: Path) -> None:
    vary = {"clearance.cam_um": "1:3:6", "ring.kind": "pin,nonpin"}
    here = sweep(PIN, vary, "statics,mass", engine=Engine(1))

    def kill(done: int, _: int) -> None:
        if done == 3:
            cluster.workers[0].kill()

    there = sweep(PIN, vary, "statics,mass", out=tmp_path, engine=Engine(scheduler=cluster.address), progress=kill)
    assert cluster.workers[0].wait() < 0
    assert list(here.frame.columns) == list(there.frame.columns)
    assert len(there) == 12
    assert there.failed == 0
    for name in here.quantities:
        assert np.array_equal(here[name], there[name], equal_nan=True), name


@pytest.mark.slow
def test_tolerances_have_the_bits_of_local_ones(cluster: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tolerances, "ANGLES", 12)
    monkeypatch.setattr("cycloid_mj.explore.budget.SOBOL", SobolSettings(min_samples=16, min_drawn=16, max_samples=16))
    design = override(PIN, ['tolerance.pin_position="normal 0.2"', 'tolerance.cam="uniform 0.3"'])
    here, there = (tolerance(design, 40, 1, engine=engine) for engine in (Engine(1), Engine(scheduler=cluster.address)))
    assert all(np.array_equal(values, there.figures[key]) for key, values in here.figures.items())
    assert here.budget == there.budget


@pytest.mark.slow
def test_workers_of_other_versions_are_refused(cluster: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    """As if every worker had another numba."""

    def compared(theirs: Versions, whose: str) -> None:
        require_same_versions((*theirs[:-1], ("numba", "0.1")), whose)

    monkeypatch.setattr("cycloid_mj.base.engine.cluster.require_same_versions", compared)
    with pytest.raises(RunError, match=r"the worker tcp://.*: numba is 0\.1 there and .* here"):
        Engine(scheduler=cluster.address).each(fail, [1])


@pytest.mark.slow
def test_an_error_on_a_cluster_ends_the_work(cluster: Cluster) -> None:
    with pytest.raises(DesignError, match="spoiled"):
        Engine(scheduler=cluster.address).each(fail, range(20))


@pytest.mark.slow
def test_a_killed_scheduler_is_reported_in_one_line_and_the_sweep_continues_elsewhere(tmp_path: Path) -> None:
    out = tmp_path / "sweep"
    words = [
        sys.executable,
        "-m",
        "cycloid_mj",
        "sweep",
        "--vary",
        "clearance.cam_um=1:3:30",
        "--measure",
        "statics",
    ]
    with Cluster(tmp_path) as found:
        ours = [*words, "--out", str(out), "--scheduler", found.address]
        with subprocess.Popen(ours, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
            rows = out / "sweep.rows.jsonl"
            while process.poll() is None and not (rows.exists() and rows.stat().st_size):
                time.sleep(0.1)
            found.scheduler.kill()
            err = process.communicate(timeout=300)[1]
    assert process.returncode == 1
    told = [line for line in err.splitlines() if not line.startswith("sweep: ")]
    assert len(told) == 1, err
    assert told[0].startswith(f"error: the connection to the scheduler {ours[-1]} was lost")
    kept = rows.read_bytes()
    assert kept.endswith(b"\n")
