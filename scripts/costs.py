"""Costs of the benchmark: CPU time and memory of a step, a run or a command, measured once.

Steps are timed by the CPU time of their thread, which does not count waiting for a core. On a busy machine other
processes still displace the caches: compare measurements taken in turn.
"""

import ctypes
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite.binding
import mujoco
import numpy as np
from numba import cfunc, njit, types

from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.contact.library import function_address, library
from cycloid_mj.dynamics.contact.memory import read_address, write_float
from cycloid_mj.dynamics.drive_cycle import initial_state, ramp_and_hold
from cycloid_mj.dynamics.mjcf import ReducerModel, build
from cycloid_mj.dynamics.run import (
    Solver,
    attachments,
    blocks,
    contact_kind,
    log_columns,
    model_for,
    provenance,
    schedule,
)
from cycloid_mj.log import LogWriter
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene import Scene, frame_rate

ROOT = Path(__file__).parents[1]

Case = tuple[Design, ReducerModel]

WARM = 10_000
"""Steps before the clock starts: the first block of samples, at 10 kHz and 1 us; the load is on by then."""

FREE, FIXED, NONPIN = "free pins", "fixed pins", "nonpin"
KINDS = {FREE: ("pin", "free"), FIXED: ("pin", "fixed"), NONPIN: ("nonpin", "free")}

_THREAD_TIME = 3  # CLOCK_THREAD_CPUTIME_ID of Linux
_NARROW = int(mujoco.mjtTimer.mjTIMER_COL_NARROW)
_now = np.zeros(2, dtype=np.int64)
_address = _now.ctypes.data
_clock_gettime = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.intp))
llvmlite.binding.add_symbol("cycloid_mj_benchmark_step", function_address("mj_step"))
_mj_step = types.ExternalFunction("cycloid_mj_benchmark_step", types.void(types.intp, types.intp))


@njit
def _read_clock() -> float:
    _clock_gettime(_THREAD_TIME, _address)
    return 1e6 * read_address(_address) + 1e-3 * read_address(_address + 8)


@njit
def _read_clock_often(times: int) -> float:
    last = 0.0
    for _ in range(times):
        last = _read_clock()
    return last


@cfunc(types.float64())
def _microseconds() -> float:
    """Read the thread's CPU time without Python, as MuJoCo's timer callback."""
    return _read_clock()


@njit
def _steps(model: int, data: int, ctrl: int, commands: Any) -> None:
    for k in range(len(commands)):
        write_float(ctrl, commands[k, 0])
        write_float(ctrl + 8, commands[k, 1])
        _mj_step(model, data)


@contextmanager
def timers() -> Iterator[None]:
    """Switch MuJoCo's internal timers on while the context is open."""
    callback = ctypes.c_void_p.in_dll(library(), "mjcb_time")
    callback.value = _microseconds.address
    try:
        yield
    finally:
        callback.value = None


def example(kind: str, load: float, steps: int, *changes: str) -> Case:
    """Return a design of a kind in `KINDS` with its model, for a run at full speed under a load [N m].

    The run has `steps` time steps of 1 us after the warm-up; `changes` are further changes of the design.
    """
    preset, pins = KINDS[kind]
    hold = (WARM + steps) * 1e-6
    run = ["settings.timestep_us=1.0", "drive.ramp_s=0.0", f"drive.hold_s={hold!r}", f"load.torque_nm={load}"]
    design = override(PRESETS[preset], [f'ring.pins="{pins}"', *run, *changes])
    return design, build(design)


def bare_cost(design: Design, compiled: ReducerModel, warm: int = WARM) -> tuple[float, float]:
    """Measure the CPU time of a step of MuJoCo without Python, and the part of the collision's narrow phase [us].

    The narrow phase counts only within ``timers``, and includes a reading of the clock. `warm` steps are taken before.
    """
    reducer = Reducer(design)
    plan = schedule(reducer)
    commands = ramp_and_hold(compiled, reducer).commands(plan.timestep * np.arange(plan.steps, dtype=np.float64))
    data = initial_state(compiled, reducer)
    places = compiled.model._address, data._address, data.ctrl.ctypes.data
    with install() if contact_kind(compiled) == "profile" else nullcontext():
        _steps(*places, commands[:warm])
        narrow, start = data.timer[_NARROW].duration, time.thread_time_ns()
        _steps(*places, commands[warm:])
        spent = time.thread_time_ns() - start
    steps = plan.steps - warm
    return 1e-3 * spent / steps, (data.timer[_NARROW].duration - narrow) / steps


def _reading_cost() -> float:
    """Measure the CPU time of one reading of the clock [us]."""
    start, readings = time.thread_time_ns(), 1_000
    _read_clock_often(readings)
    return 1e-3 * (time.thread_time_ns() - start) / readings


def own_cost(design: Design, compiled: ReducerModel) -> tuple[float, float]:
    """Measure the CPU time of a step in MuJoCo without the narrow phase of collision, and that of this phase [us]."""
    reading = min(_reading_cost() for _ in range(20))
    with timers():
        _, narrow = bare_cost(design, compiled)
    step, _ = bare_cost(design, compiled)
    return step - (narrow - reading), narrow - reading


def loop_cost(design: Design, compiled: ReducerModel, log: LogWriter | None = None) -> float:
    """Measure the CPU time of a step of ``simulate`` [us], with its log or without."""
    start = 0
    for block in blocks(compiled, Reducer(design)):
        if log:
            log.write(block.time, block.values)
        start = start or time.thread_time_ns()
    return 1e-3 * (time.thread_time_ns() - start) / (schedule(Reducer(design)).steps - WARM)


def run_cost(design: Design, compiled: ReducerModel) -> float:
    """Measure the CPU time of a step [us] over a run from its start on."""
    reducer, start = Reducer(design), time.thread_time_ns()
    samples = sum(len(block.time) for block in blocks(compiled, reducer))
    return 1e-3 * (time.thread_time_ns() - start) / (schedule(reducer).stride * (samples - 1) + 1)


def second_cost(solver: Solver, design: Design) -> float:
    """Measure the CPU time of a simulated second [s] by a solver at its own step, without log and first block."""
    reducer, start, begin, end = Reducer(design), 0, 0.0, 0.0
    for block in blocks(model_for(solver, reducer), reducer):
        end = float(block.time[-1])
        if not start:
            start, begin = time.thread_time_ns(), end
    return 1e-9 * (time.thread_time_ns() - start) / (end - begin)


def logged_cost(design: Design, compiled: ReducerModel) -> float:
    """Measure the CPU time of a step of ``simulate`` [us] with a log as ``cycloid-mj simulate`` writes it."""
    reducer = Reducer(design)
    groups = {topic: list(units.items()) for topic, units in log_columns(compiled, reducer).items()}
    origin, scene = (provenance(reducer), attachments(compiled, reducer)), Scene(design, frame_rate(reducer))
    with (
        tempfile.TemporaryDirectory() as folder,
        LogWriter(Path(folder) / "benchmark.mcap", groups, *origin, viewer=scene) as log,
    ):
        return loop_cost(design, compiled, log)


_LAUNCHER = """
import os, sys, time
start = time.perf_counter()
null = (os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)
process = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ, file_actions=[null])
_, status, usage = os.wait4(process, 0)
print(time.perf_counter() - start, usage.ru_utime + usage.ru_stime, 1.024e-3 * usage.ru_maxrss)
sys.exit(os.waitstatus_to_exitcode(status))
"""
"""Runs a command and prints its cost. A process counts its parent's memory as its own peak: this parent is small."""


class Launched(NamedTuple):
    """Cost of a process: wall and CPU time [s], peak memory [MB]."""

    wall: float
    cpu: float
    memory: float


def launch(*words: str, **environment: str) -> Launched:
    """Run a command of ``cycloid-mj`` in a temporary folder, and return its time [s] and memory [MB], see `Launched`.

    `words` are the arguments of the command, `environment` further variables of its environment.

    Raises
    ------
    CalledProcessError
        The command fails.
    """
    command = [sys.executable, "-S", "-c", _LAUNCHER, sys.executable, "-m", "cycloid_mj", *words]
    around = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (ROOT, ROOT / "papers"))), **environment}
    around.pop("PYTHONDONTWRITEBYTECODE", None)  # an installation keeps what Python compiles
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, cwd=folder, env=around)
    return Launched(*map(float, done.stdout.split()))


def command_cost(design: str, samples: int) -> Launched:
    """Run ``cycloid-mj simulate`` on a number of samples; return its cost."""
    run = ("--ramp-s", "0", "--hold-s", str(samples * 1e-4))
    return launch("simulate", "--design", design, "--quiet", "--json", *run)
