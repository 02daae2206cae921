"""Cost of the step loop against MuJoCo's own work for the same contacts, by MuJoCo's internal timers.

The ratio of a case compares two passes over the same steps in one run of this script: the step loop of ``simulate``
with its sampling and checks, and bare ``mj_step`` with the timers on, of which all but the narrow phase of collision
counts as MuJoCo's own work. Run it on an idle machine:

    python scripts/benchmark.py
"""

import ctypes
import platform
import statistics
import time
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np
from numba import cfunc, types

from cycloid_mj.contact.collider import installed
from cycloid_mj.contact.library import library
from cycloid_mj.contact.memory import read_address
from cycloid_mj.course import initial_state, load_torque, servo_target
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.kinematics import CrankLaw
from cycloid_mj.mjcf import ReducerModel, build
from cycloid_mj.simulate import blocks, schedule

REPEATS = 5
CASES = {
    "free pins, no load": ("pin", 0.0, "free"),
    "free pins, 36 N m": ("pin", 36.0, "free"),
    "fixed pins, no load": ("pin", 0.0, "fixed"),
    "fixed pins, 36 N m": ("pin", 36.0, "fixed"),
    "nonpin, no load": ("nonpin", 0.0, "free"),
    "nonpin, 36 N m": ("nonpin", 36.0, "free"),
}
MONOTONIC = 1
NARROW, STEP = int(mujoco.mjtTimer.mjTIMER_COL_NARROW), int(mujoco.mjtTimer.mjTIMER_STEP)

_now = np.zeros(2, dtype=np.int64)
_clock_gettime = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.intp))
_address = _now.ctypes.data


@cfunc(types.float64())
def _microseconds() -> float:
    """Read the system's clock without Python, as MuJoCo's timer callback."""
    _clock_gettime(MONOTONIC, _address)
    return 1e6 * read_address(_address) + 1e-3 * read_address(_address + 8)


@contextmanager
def timers() -> Iterator[None]:
    """Switch MuJoCo's internal timers on."""
    callback = ctypes.c_void_p.in_dll(library(), "mjcb_time")
    callback.value = _microseconds.address
    try:
        yield
    finally:
        callback.value = None


def loop_cost(reducer: ReducerModel, design: Design) -> float:
    """Wall time of a step of ``simulate`` [us]."""
    start = time.perf_counter()
    for _ in blocks(reducer, design):
        pass
    return 1e6 * (time.perf_counter() - start) / schedule(design).steps


def own_cost(reducer: ReducerModel, design: Design) -> tuple[float, float]:
    """MuJoCo's own work and the narrow phase of a step, by its timers [us]."""
    plan = schedule(design)
    moments = plan.timestep * np.arange(plan.steps, dtype=np.float64)
    target = servo_target(reducer, CrankLaw(design.drive.speed, design.drive.ramp), moments)
    load = load_torque(design, moments)
    data = initial_state(reducer, design)
    with installed(), timers():
        for k in range(plan.steps):
            data.ctrl[0], data.ctrl[1] = target[k], load[k]
            mujoco.mj_step(reducer.model, data)
    narrow = data.timer[NARROW].duration / plan.steps
    return data.timer[STEP].duration / plan.steps - narrow, narrow


def main() -> None:
    """Print the table."""
    print(f"MuJoCo {mujoco.__version__}, {platform.machine()}, Python {platform.python_version()}")
    print(f"median of {REPEATS} passes of 20 000 steps (spread); us per step")
    print(f"{'case':24} {'loop':>14} {'MuJoCo':>14} {'narrow phase':>14} {'loop / MuJoCo':>14}")
    for name, (preset, load, pins) in CASES.items():
        changes = ["drive.ramp_s=0.0", "drive.hold_s=0.02", f"load.torque_nm={load}", f'ring.pins="{pins}"']
        design = override(PRESETS[preset], changes)
        reducer = build(design)
        loop_cost(reducer, design)
        rows = [(loop_cost(reducer, design), *own_cost(reducer, design)) for _ in range(REPEATS)]
        columns = [*zip(*rows, strict=True), [loop / own for loop, own, _ in rows]]
        told = [f"{statistics.median(column):7.2f} ({max(column) - min(column):4.2f})" for column in columns]
        print(f"{name:24} " + " ".join(f"{cell:>14}" for cell in told))


if __name__ == "__main__":
    main()
