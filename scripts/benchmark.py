"""Costs of a run: tables of medians with their spread, each ratio of passes that were taken in turn in the same run.

    python scripts/benchmark.py                        # every table
    python scripts/benchmark.py loop log --quick       # some, from fewer passes
    python scripts/benchmark.py requirements --quick   # requirements on commands, and their costs
    python scripts/benchmark.py --json benchmark.json  # every pass of every table, for a machine
    python scripts/benchmark.py against REVISION       # whole runs of this tree and of another revision, in turn

`loop / MuJoCo` sets the step loop of ``simulate``, with its sampling and checks, against steps that are taken without
Python, less the narrow phase of collision by MuJoCo's internal timers. Steps cost CPU time of their thread; for wall
times the machine should be idle.
"""

import argparse
import inspect
import json
import math
import os
import platform
import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import costs
import mujoco
import numba
import numpy as np
from against import TRIALS, check_out, compare, difference, figures_of_log, loops
from cost_limits import limits_table
from sweeping import sweep_table

from cycloid_mj.base.engine.engine import cores
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import Solver, reducer_model
from cycloid_mj.reducer import Reducer

Row = dict[str, list[float]]
Table = dict[str, Row]

TEETH = {
    12: {"gear.eccentricity_mm": 2.0, "ring.pin_radius_mm": 5.0, "output.hole_radius_mm": 6.0},
    36: {},
    72: {"gear.eccentricity_mm": 0.4, "ring.pin_radius_mm": 1.1, "output.hole_radius_mm": 4.4},
    120: {"gear.eccentricity_mm": 0.25, "ring.pin_radius_mm": 0.7, "output.hole_radius_mm": 4.25},
}
"""What fits the number of ring teeth into the pin circle of the presets."""

FREE_PINS = {
    **{teeth: TEETH[teeth] for teeth in (12, 36, 72)},
    144: {"gear.eccentricity_mm": 0.2, "ring.pin_radius_mm": 0.55, "output.hole_radius_mm": 4.2},
}
"""Numbers of free pins over which the cost of a step is to grow nearly as they do."""

EXUDYN = {costs.FIXED: (5.0, 15.0), costs.FREE: (247.0,)}
"""CPU time of a simulated second in Exudyn 1.13.6 at its best known settings [s], one core, as published.

Fixed pins: a contact of the user's own, compiled, least and most. Free pins: its own contact.
"""
OWN_STEP = "settings.timestep_us=0"


def in_turn(passes: int, **cases: Callable[[], float]) -> Row:
    """Measure several cases in turn (A B A B ...), `passes` times each, so that other load affects all of them.

    A case is a function that returns its cost. Return the costs of each case by its name.
    """
    values: Row = {name: [] for name in cases}
    for _ in range(passes):
        for name, case in cases.items():
            values[name].append(case())
    return values


def ratio(row: Row, over: str, under: str) -> Row:
    """Return the ratio of two cases pass by pass."""
    return {f"{over} / {under}": [a / b for a, b in zip(row[over], row[under], strict=True)]}


def loop_table(passes: int) -> Table:
    """Measure the step loop and MuJoCo's own work in it [us per step]."""
    table: Table = {}
    for kind in costs.KINDS:
        for load in (0.0, 36.0):
            case = costs.example(kind, load, 20_000)
            rows = [(costs.loop_cost(*case), *costs.own_cost(*case)) for _ in range(passes)]
            row = {name: [values[k] for values in rows] for k, name in enumerate(("loop", "MuJoCo", "narrow phase"))}
            row["Python"] = [loop - own - narrow for loop, own, narrow in rows]
            table[f"{kind}, {load:g} N m"] = row | ratio(row, "loop", "MuJoCo")
    return table


def log_table(passes: int) -> Table:
    """Measure the cost of a log at 10 kHz: steps without Python, with samples, and with their log [us per step]."""
    table: Table = {}
    for kind in (costs.FREE, costs.NONPIN):
        for load in (0.0, 36.0):
            case = costs.example(kind, load, 30_000 if kind == costs.FREE else 100_000)
            row = in_turn(
                passes,
                bare=lambda case=case: costs.bare_cost(*case)[0],  # type: ignore[misc]
                sampled=partial(costs.loop_cost, *case),
                logged=partial(costs.logged_cost, *case),
            )
            ratios = ratio(row, "sampled", "bare") | ratio(row, "logged", "sampled")
            table[f"{kind}, {load:g} N m"] = row | ratios
    return table


def mesh_table(passes: int) -> Table:
    """Measure exact profiles against convex meshes of them in MuJoCo's own collision [us per step of 1 us]."""

    def cost(case: costs.Case) -> float:
        return costs.bare_cost(*case, warm=100)[0]

    table: Table = {}
    for kind in costs.KINDS:
        design, profile = costs.example(kind, 36.0, 0, "drive.hold_s=6e-4", "load.rise_s=1e-4")
        mesh = reducer_model(Reducer(design), "mesh")
        row = in_turn(passes, profile=partial(cost, (design, profile)), mesh=partial(cost, (design, mesh)))
        table[f"{kind}, 36 N m"] = row | ratio(row, "mesh", "profile")
    return table


def teeth_table(passes: int) -> Table:
    """Measure the step loop over the number of ring teeth, under 36 N m [us per step]."""
    table: Table = {}
    for teeth, fit in TEETH.items():
        changes = [f"ring.teeth={teeth}", *(f"{name}={value}" for name, value in fit.items())]
        cases = {kind: partial(costs.loop_cost, *costs.example(kind, 36.0, 10_000, *changes)) for kind in costs.KINDS}
        table[f"{teeth} teeth"] = in_turn(passes, **cases)
    return table


def threads_table(passes: int) -> Table:
    """Measure independent runs in threads, as many as cores, relative to a single run: wall time [s] and CPU time.

    Hashing needs no Python and shows how much of the cores is available; at 10 us a sample is ten steps. Wall times
    require an idle machine. CPU times, us per step of a thread, include the effect of threads on each other's caches,
    but no waiting for Python.
    """

    def hashing() -> float:
        start = time.thread_time_ns()
        sha256(zeros)
        return 1e-3 * (time.thread_time_ns() - start)

    zeros = bytes(10**9)
    works: dict[str, Callable[[], float]] = {
        costs.FREE: partial(costs.loop_cost, *costs.example(costs.FREE, 36.0, 10_000)),
        costs.NONPIN: partial(costs.loop_cost, *costs.example(costs.NONPIN, 36.0, 60_000)),
        f"{costs.NONPIN}, 10 us": partial(
            costs.run_cost, *costs.example(costs.NONPIN, 36.0, 0, OWN_STEP, "drive.hold_s=0.6")
        ),
        "hashing": hashing,
    }
    table: Table = {}
    for name, work in works.items():
        pairs = [(together(1, work), together(cores(), work)) for _ in range(passes)]
        wall = {part: [pair[k][0] for pair in pairs] for k, part in enumerate(("one", "all"))}
        cpu = {f"{part}, CPU": [pair[k][1] for pair in pairs] for k, part in enumerate(wall)}
        table[f"{name}, {cores()} runs"] = wall | ratio(wall, "all", "one") | cpu | ratio(cpu, "all, CPU", "one, CPU")
    return table


def together(runs: int, work: Callable[[], float]) -> tuple[float, float]:
    """Run a function several times at once, in threads; return the wall time [s] and the mean of its results."""
    start = time.perf_counter()
    with ThreadPoolExecutor(runs) as pool:
        results = [run.result() for run in [pool.submit(work) for _ in range(runs)]]
    return time.perf_counter() - start, statistics.mean(results)


def command_table(passes: int) -> Table:
    """Measure ``cycloid-mj simulate`` as a process with warm caches: wall and CPU time [s], peak memory [MB]."""
    table: Table = {}
    for kind in (costs.FREE, costs.NONPIN):
        for samples in (2, 500):
            rows = [costs.command_cost(costs.KINDS[kind][0], samples) for _ in range(passes + 1)][1:]
            table[f"{kind}, {samples} samples"] = {
                name: [values[k] for values in rows] for k, name in enumerate(("wall", "CPU", "memory"))
            }
    return table


def _lasting(steps: int, timestep: float) -> tuple[str, str]:
    """Return the changes for a run of some time steps [s] after the warm-up, which ends at its 100th sample."""
    return (
        f"drive.hold_s={(costs.WARM + steps) * timestep!r}",
        f"settings.log_rate_hz={100.0 / (costs.WARM * timestep)!r}",
    )


def scaling_table(passes: int) -> Table:
    """Measure the step loop over the number of free pins under 36 N m, at a step that resolves them [us per step].

    Thinner pins are lighter, as their radius squared, and take a step shorter as their radius. The exponent is that of
    the cost from the smallest number of pins on.
    """
    cases = {}
    for teeth, fit in FREE_PINS.items():
        step = fit.get("ring.pin_radius_mm", 2.25) / 2.25
        changes = {"ring.teeth": teeth, "settings.timestep_us": step, **fit, "load.rise_s": 5e-4}
        words = [f"{name}={value!r}" for name, value in changes.items()]
        case = costs.example(costs.FREE, 36.0, 0, *words, *_lasting(5_000, 1e-6 * step))
        cases[str(teeth)] = partial(costs.loop_cost, *case)
    row = in_turn(passes, **cases)
    first = next(iter(FREE_PINS))
    table: Table = {}
    for name, values in row.items():
        table[f"{name} pins"] = {"step": values}
        if int(name) > first:
            wider = math.log(int(name) / first)
            exponents = [math.log(cost / least) / wider for cost, least in zip(values, row[str(first)], strict=True)]
            table[f"{name} pins"]["exponent"] = exponents
    return table


def solvers_table(passes: int) -> Table:
    """Measure both solvers at their own steps: CPU time of a simulated second [s], and its exponent over free pins."""
    loaded, own = "load.torque_nm=36.68", ("drive.ramp_s=0", "drive.hold_s=0.13")
    cases = {
        "free pins": ("pin", loaded),
        "free pins, idle": ("pin",),
        "massless pins": ("pin", loaded, 'ring.pins="massless"'),
        "fixed pins": ("pin", loaded, 'ring.pins="fixed"'),
        "nonpin": ("nonpin", loaded),
        "two discs": ("twodisc", "load.torque_nm=100"),
    }
    solvers: tuple[Solver, ...] = ("mujoco", "planar")
    table: Table = {}
    for name, (preset, *changes) in cases.items():
        design = override(PRESETS[preset], [*own, *changes])
        row = in_turn(passes, **{solver: partial(costs.second_cost, solver, design) for solver in solvers})
        table[name] = row | ratio(row, "mujoco", "planar")
    first = next(iter(FREE_PINS))
    for teeth, fit in FREE_PINS.items():
        words = [f"ring.teeth={teeth}", *(f"{key}={value!r}" for key, value in fit.items())]
        design = override(PRESETS["pin"], [*own, loaded, *words])
        table[f"{teeth} free pins"] = in_turn(passes, planar=partial(costs.second_cost, "planar", design))
        if teeth > first:
            wider, least = math.log(teeth / first), table[f"{first} free pins"]["planar"]
            pairs = zip(table[f"{teeth} free pins"]["planar"], least, strict=True)
            table[f"{teeth} free pins"]["exponent"] = [math.log(cost / fewest) / wider for cost, fewest in pairs]
    return table


def discs_table(passes: int) -> Table:
    """Measure the step loop of two discs relative to one, under the same load for each disc [us per step].

    The preset twodisc at its own step, 58 N m a disc; the paper's designs, all their parts rigid, at 36 N m a disc.
    """
    table: Table = {}
    for name in ("twodisc", *costs.KINDS):
        one, two = (partial(costs.loop_cost, *_of_discs(name, discs)) for discs in (1, 2))
        row = in_turn(passes, **{"1 disc": one, "2 discs": two})
        table[name] = row | ratio(row, "2 discs", "1 disc")
    return table


def _of_discs(name: str, discs: int) -> costs.Case:
    """Return the case of a design with a number of discs.

    The preset turns slowly, so that a sample each 100 steps contains every tooth.
    """
    if name in costs.KINDS:
        return costs.example(name, 36.0 * discs, 10_000, f"gear.discs={discs}")
    step = float(build(PRESETS[name]).model.opt.timestep)
    run = ["drive.ramp_s=0", "drive.speed_rpm=100", f"settings.timestep_us={1e6 * step!r}", *_lasting(10_000, step)]
    design = override(PRESETS[name], [f"gear.discs={discs}", f"load.torque_nm={58 * discs}", *run])
    return design, build(design)


def exudyn_table(passes: int) -> Table:
    """Measure the CPU time of a simulated second at rated load [s] at its own step, next to Exudyn (published).

    ``scripts/peer_exudyn.py`` runs Exudyn itself, with the one contact that it has for such a profile, a polygon.
    """
    table: Table = {}
    for kind, published in EXUDYN.items():
        step = float(costs.example(kind, 36.0, 0, OWN_STEP)[1].model.opt.timestep)
        case = costs.example(kind, 36.0, 0, OWN_STEP, *_lasting(20_000, step))
        here = [costs.loop_cost(*case) / (1e6 * step) for _ in range(passes)]
        row = {"here": here, "Exudyn": list(published)}
        table[kind] = row | {"Exudyn / here": [cost / statistics.median(here) for cost in published]}
    return table


def against_table(revision: str, passes: int) -> Table:
    """Measure step loops and commands here and in another revision in turn: CPU time [s], peak memory [MB], figures.

    The effect of the step is the difference to this tree's own fine step; the other revision may also have other
    physics.
    """
    table: Table = {}
    with check_out(revision) as other:
        for name, (here, there) in loops(other, passes).items():
            times = {"this tree": here, revision: there}
            table[f"1 s of {name}"] = times | ratio(times, revision, "this tree")
        show(table)
        for trial in TRIALS:
            ours, theirs, rows = compare(trial, other, passes)
            row = {"this tree": [one.cpu for one in ours], revision: [one.cpu for one in theirs]}
            memory = {
                f"{name}, MB": [end.memory for end in ends] for name, ends in zip(row, (ours, theirs), strict=True)
            }
            table[trial.name] = row | ratio(row, revision, "this tree") | memory
            show({trial.name: table[trial.name]})
            for name in rows["this tree"] if trial.figures is figures_of_log else ():
                values = ", ".join(f"{tree} {one[name]:.5g}" for tree, one in rows.items() if name in one)
                print(f"    {name}: {values}")
            for tree in list(rows)[1:]:
                worst, size, count = difference(rows["this tree"], rows[tree])
                print(f"    largest difference of {count} figures to {tree}: {size:.2%}, {worst}", flush=True)
    return table


SECTIONS: dict[str, Callable[[int], Table]] = {
    "loop": loop_table,
    "log": log_table,
    "mesh": mesh_table,
    "teeth": teeth_table,
    "scaling": scaling_table,
    "solvers": solvers_table,
    "discs": discs_table,
    "exudyn": exudyn_table,
    "threads": threads_table,
    "command": command_table,
    "sweep": sweep_table,
    "requirements": limits_table,
}


def machine() -> dict[str, str]:
    """Return processor, versions and date as the source of the figures."""
    info = Path("/proc/cpuinfo")
    models = [line.partition(": ")[2] for line in info.read_text().splitlines() if "model name" in line]
    return {
        "processor": f"{models[0] if models else platform.processor()}, {cores()} cores",
        "system": f"{platform.system()} {platform.machine()}",
        "load average": " ".join(f"{load:.1f}" for load in os.getloadavg()),
        "versions": f"Python {platform.python_version()}, MuJoCo {mujoco.__version__}, numba {numba.__version__}, "
        f"numpy {np.__version__}",
    }


def show(table: Table) -> None:
    """Print a table: median (spread: largest less smallest) of each value."""
    names = list(next(iter(table.values())))
    print(f"{'':22}" + "".join(f"{name:>18}" for name in names))
    for case, row in table.items():
        cells = [f"{statistics.median(values):.3g} ({max(values) - min(values):.2g})" for values in row.values()]
        print(f"{case:22}" + "".join(f"{cell:>18}" for cell in cells), flush=True)


def main() -> None:
    """Measure and print the requested tables."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("sections", nargs="*", help=f"of {', '.join(SECTIONS)}; all by default")
    parser.add_argument("--quick", action="store_true", help="two passes of each case instead of seven")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every pass to this file as well")
    options = parser.parse_args()
    sections, revision = options.sections, ""
    if "against" in sections:
        if len(sections) != 2 or sections[0] != "against":
            parser.error("against takes one revision and no other section: benchmark.py against REVISION")
        sections, revision = [], sections[1]
    if unknown := set(sections) - set(SECTIONS):
        parser.error(f"no section {', '.join(sorted(unknown))}: choose of {', '.join(SECTIONS)}, or against REVISION")
    passes = (1 if options.quick else 3) if revision else (2 if options.quick else 7)
    content: dict[str, Any] = {"machine": machine(), "passes": passes, "tables": {}}
    for name, value in content["machine"].items():
        print(f"{name}: {value}")
    print(f"median of {passes} passes (spread)")
    if revision:
        content["tables"][f"against {revision}"] = against_table(revision, passes)
    for name in sections or ([] if revision else SECTIONS):
        print(f"\n{name}: {inspect.getdoc(SECTIONS[name])}")
        content["tables"][name] = SECTIONS[name](passes)
        show(content["tables"][name])
    content["machine"]["load average at the end"] = machine()["load average"]
    if options.json:
        options.json.write_text(json.dumps(content, indent=2) + "\n")


if __name__ == "__main__":
    main()
