"""Cost of a point of a sweep, and of sending it to a worker: in this process, in processes, and on a Dask cluster."""

import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from dask_cluster import ROOT, Cluster

from cycloid_mj.base.engine import Engine
from cycloid_mj.design import PRESETS, override
from cycloid_mj.explore.measured import MeasureSettings
from cycloid_mj.explore.row import PointResult, Task, evaluate_row
from cycloid_mj.explore.sampling import SAMPLING, list_batches, tolerance_zones
from cycloid_mj.explore.tolerances import solve_sample_batch
from cycloid_mj.figures import SAMPLED
from cycloid_mj.figures.sampled import ANGLES
from cycloid_mj.reducer import Reducer

WORKERS = 2  # processes that are compared with one
COLUMNS = ("CPU", "2 processes", "Dask", "client", "scheduler")

TURN = {"drive.ramp_s": 0.0, "drive.hold_s": 0.05, "load.torque_nm": 36.0}
"""A crank turn at rated load, which takes 0.037 s, after what settles."""

TOLERANCES = {"tolerance.cam": "normal 0.2", "tolerance.pin_position": "normal 0.2", "tolerance.output": "normal 0.2"}


@dataclass(frozen=True)
class Work:
    """A function for `Engine`, and items for it."""

    work: Callable[[Any], Any]
    items: Sequence[Any]


def nothing(_: int) -> PointResult:
    """Return a row of the size of statics, without any work."""
    return PointResult({f"a_quantity_of_statics_{number}": 1.0 / 3.0 for number in range(60)})


def works(fast_points: int, slow_points: int) -> dict[str, Work]:
    """Return the work to measure, by name: "nothing" with `fast_points` items, statics and turn with `slow_points`."""
    pin = PRESETS["pin"]

    def points(key: str, measure: str, changes: dict[str, Any], count: int, real_pins: bool = False) -> Work:
        task = Task(Reducer(override(pin, changes)), (key,), (measure,), MeasureSettings(real_pins=real_pins))
        return Work(partial(evaluate_row, task), [(20.0 + 0.1 * number,) for number in range(count)])

    toleranced = override(pin, TOLERANCES)
    return {
        "nothing": Work(nothing, range(fast_points)),
        "statics": points("load.torque_nm", "statics", {}, slow_points),
        "turn, massless pins": points("load.torque_nm", "simulate", TURN, slow_points),
        "turn, free pins": points("load.torque_nm", "simulate", TURN, WORKERS, real_pins=True),
        f"{SAMPLING.block} samples": Work(
            partial(solve_sample_batch, Reducer(toleranced), tolerance_zones(Reducer(toleranced)), 0, ANGLES),
            [(block, SAMPLED) for block in list_batches(WORKERS * SAMPLING.block)],
        ),
    }


def sweep_table(passes: int, chosen: Mapping[str, Work] | None = None) -> dict[str, dict[str, list[float]]]:
    """Measure the cost of a sweep's points and of their transfer to workers [ms per point], workers warm.

    CPU time of the work; wall time in two processes and on a Dask cluster with two workers; CPU time of its client and
    its scheduler. A line ``512 samples`` is a block of `tolerance`, a piece of work as the others are points.
    """
    chosen = works(fast_points=1000, slow_points=16) if chosen is None else chosen
    with tempfile.TemporaryDirectory() as folder, Cluster(Path(folder), WORKERS, (ROOT / "scripts",)) as cluster:
        there = Engine(scheduler=cluster.address)
        return {name: _costs(one, there, cluster.scheduler.pid, passes) for name, one in chosen.items()}


def _costs(work: Work, there: Engine, scheduler: int, passes: int) -> dict[str, list[float]]:
    """Measure a piece of work in this process, in workers and on a cluster, in turn; return the costs by column."""
    costs: dict[str, list[float]] = {name: [] for name in COLUMNS}
    for engine in (Engine(1), Engine(WORKERS), there):
        engine.each(work.work, work.items[:WORKERS])
    for _ in range(passes):
        before = time.process_time()
        Engine(1).each(work.work, work.items)
        spent = [time.process_time() - before]
        before = time.perf_counter()
        Engine(WORKERS).each(work.work, work.items)
        spent.append(time.perf_counter() - before)
        before, start, others = time.perf_counter(), time.process_time(), cpu_of(scheduler)
        there.each(work.work, work.items)
        spent += [time.perf_counter() - before, time.process_time() - start, cpu_of(scheduler) - others]
        for name, seconds in zip(COLUMNS, spent, strict=True):
            costs[name].append(1e3 * seconds / len(work.items))
    return costs


def cpu_of(process: int) -> float:
    """Compute the CPU time of a process so far [s]."""
    from psutil import Process

    times = Process(process).cpu_times()
    return float(times.user + times.system)


def hours(points: float, cpu: float, overhead: float, cores: int) -> float:
    """Extrapolate the wall time [h] of a number of points on a cluster of some cores.

    `cpu` is the CPU time of a point [ms], `overhead` that of the busier of client and scheduler per point [ms], as in
    `sweep_table`. The slower of workers and scheduler determines the result.
    """
    return points * max(cpu / cores, overhead) / 3.6e6
