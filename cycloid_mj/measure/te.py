"""Transmission error: the turn of gear and output less the ideal one at the measured crank angle.

Whole turns of the crank, in both directions, without and under load, slow and at speed. A positive error is
counter-clockwise, as a forward crank is.
"""

from collections.abc import Mapping
from itertools import product

import numpy as np

from cycloid_mj.base.engine import Progress, each_in_threads, silent
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.result import keyed
from cycloid_mj.base.units import ARCSECONDS, RPM
from cycloid_mj.design import Named, resolve
from cycloid_mj.dynamics.run import Solver, model_for
from cycloid_mj.measure import te_table
from cycloid_mj.measure.conditions import DRAG, halved, require_motion
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.measure.orders import base_orders, causes
from cycloid_mj.measure.trace import ErrorCurves, Trace, TraceCondition, copied, trace
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import transmission_error
from cycloid_mj.statics.structure import structure_text

CHECKED = 3
"""Mesh periods that are run again with half the step."""
SOLVED = 8
"""Crank angles in a mesh period at which statics are solved."""
SLOW = 0.25
"""Slow crank speed as a share of the design's."""


def te(
    design: Named,
    load: float | None = None,
    drag: float | None = None,
    slow: float | None = None,
    turns: int = 1,
    quick: bool = False,
    progress: Progress = silent,
    solver: Solver = "planar",
) -> Measurement:
    """Measure the transmission error of a design.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file: the design; its drive gives the speed.
    load
        Torque of the loaded runs [N m]; by default the rated one, drive.torque times the ratio.
    drag
        Torque of the unloaded runs [N m], by default `DRAG` of the rated one; at 0 the gear floats in its backlash.
    slow
        Slow crank speed [rad/s], by default `SLOW` of the design's.
    turns
        Crank turns, seen from the ring; N - 1 of them part the orders of the ring from those of the holes.
    quick
        At speed only, and no runs with half the step.
    progress
        Called after each run with how many are done, and how many there are.
    solver
        What takes the steps of the runs.
    """
    design = resolve(design)
    reducer = Reducer(design)
    require_motion(reducer)
    rated = reducer.design.rated_torque
    torques = {"unloaded": DRAG * rated if drag is None else drag, "loaded": rated if load is None else load}
    speed = abs(reducer.design.drive.speed)
    paces = {"speed": speed} if quick else {"slow": SLOW * speed if slow is None else slow, "speed": speed}
    ways = {"forward": 1.0, "reverse": -1.0}
    cases = [
        TraceCondition(one, way, pace, torques[one], ways[way] * paces[pace])
        for pace, one, way in product(paces, torques, ways)
    ]
    reducer = reducer.working_at(torques["loaded"])
    runs = _traces(reducer, cases, turns * reducer.mesh_turn / (2.0 * np.pi), progress, not quick, solver)
    traces = {case: runs[case, 1.0] for case in cases}
    finer = {(case.load, case.pace): run for (case, share), run in runs.items() if share == 0.5}
    statics = {case: _statics(reducer, case, turns) for case in cases}
    return Measurement(
        measure="te",
        design=reducer.design,
        condition=" and ".join(f"{one} {torque:.3g} N m" for one, torque in torques.items())
        + f", {abs(reducer.design.drive.speed) / RPM:.0f} rpm at speed, {SOLVERS[solver]}",
        quantities=keyed(te_table.quantities(reducer, traces, finer, statics, turns)),
        curves=te_table.curves(reducer, traces, statics),
        assumptions=_assumptions(reducer, turns),
        runs={case.key: trace.run for case, trace in traces.items()},
        details={"orders": te_table.details(reducer, traces, turns)},
    )


def _traces(
    reducer: Reducer, cases: list[TraceCondition], turns: float, progress: Progress, check: bool, solver: Solver
) -> Mapping[tuple[TraceCondition, float], Trace]:
    """Run the cases, and some mesh periods of the forward ones with half the step if they are to be checked."""
    half = halved(reducer, solver)
    models = {1.0: (reducer, model_for(solver, reducer), turns)}
    if check:
        models[0.5] = (half, model_for(solver, half), CHECKED / reducer.mesh_periods)
    work = [(case, share) for share in models for case in cases if share == 1.0 or case.way == "forward"]
    tasks = [
        (reducer, copied(compiled), turns, case) for case, share in work for reducer, compiled, turns in [models[share]]
    ]
    traces = each_in_threads(lambda task: trace(*task), tasks, progress)
    return dict(zip(work, traces, strict=True))


def _statics(reducer: Reducer, case: TraceCondition, turns: int) -> ErrorCurves:
    """Solve a case in statics."""
    design = reducer.design
    points = SOLVED * design.ring.teeth * turns + 1
    crank = np.linspace(0.0, turns * reducer.mesh_turn, points)
    turning = reducer.but(drive={"speed": case.speed})
    errors = (
        ARCSECONDS * reducer.member.sense * transmission_error(turning, crank, float(np.sign(case.speed)) * case.torque)
    )
    return ErrorCurves(crank, errors[:, 0], errors[:, 1])


def _assumptions(reducer: Reducer, turns: int) -> tuple[str, ...]:
    design = reducer.design
    lobes = design.lobes
    ring, holes = base_orders(reducer)
    multiples, apart_from = (holes, "ring") if ring == 1 else (ring, "holes")
    apart = (
        f"orders are cycles in a crank turn; fewer than {lobes} turns cannot tell whole orders from multiples of "
        f"{multiples} in one signal: the gear's error is read in whole orders (of the {apart_from}), the output's "
        "against the gear in multiples"
    )
    return (
        f"shafts run in rigid bearings without runout; {structure_text(reducer)}",
        f"unless it is given, the drag of an unloaded reducer is {DRAG:.0%} of the rated torque: with none, the gear "
        "floats in its backlash; up to the rated torque presses the flanks together before the window",
        "statics: the ideal mesh's contacts as springs at their gaps, without friction, and without inertia but the "
        "gear's centrifugal force; friction makes the teeth press harder, which winds a loaded gear up further",
        "contacts have the secant stiffness of one working force in all runs, that of the loaded ones: "
        f"{reducer.contacts.working_forces_text(design.pair_kinds)}",
        f"numerical error: what half the step changes over the first {CHECKED} mesh periods of the run forward, told "
        "of the run in reverse as well (not known with --quick), and half of what levels change from one half of the "
        "window to the other, as no turn of the crank is like the next; of orders: the rms of what half the step "
        "changes, which none of them exceeds",
        *(f"orders of {cause.name}: {cause.why}" for cause in causes(reducer)),
        *([] if te_table.apart(reducer, turns) else [apart]),
    )
