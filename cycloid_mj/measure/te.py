"""Transmission error: the turn of gear and output less the ideal one at the measured crank angle.

Whole turns of the crank, in both directions, without and under load, slow and at speed. A positive error is
counter-clockwise, as a forward crank is.
"""

from collections.abc import Callable, Mapping
from itertools import product

import numpy as np

from cycloid_mj.base.engine import Progress, each_in_threads, silent
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.result import by_key
from cycloid_mj.base.units import ARCSECONDS, MILLIMETRES, RPM
from cycloid_mj.design import Named, resolve
from cycloid_mj.design.layouts import Layout
from cycloid_mj.dynamics.run import Solver, model_for
from cycloid_mj.measure import te_table
from cycloid_mj.measure.conditions import STEADY, describe_loads, halve_time_step, load_cases, require_motion
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.measure.orders import base_orders, causes
from cycloid_mj.measure.trace import TRACE, ErrorCurves, Trace, TraceCondition, copy_model, run_trace
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.statics import transmission_error
from cycloid_mj.statics.structure import structure_text

STATICS: Mapping[Layout, str] = {
    "central": "statics: contacts of the ideal mesh as springs with gaps, without friction, and without inertia except "
    "the centrifugal force of the disc; friction increases the tooth forces, and with them the wind-up of a loaded "
    "disc",
    "rv": "statics: contacts of the ideal mesh, crank bearings and planets as springs with gaps, with friction, but "
    "without weight and inertia",
}
"""Assumptions of the static solution of each layout."""

SEPARATION: Mapping[Layout, Callable[[bool], str]] = {
    "central": lambda ring_is_fixed: (
        f": the disc's error is evaluated in whole orders (of the {'ring' if ring_is_fixed else 'holes'}), that of the "
        "output relative to the disc in multiples"
    ),
    "rv": lambda ring_is_fixed: ", so each of both spectra includes orders of the other cause",
}
"""Evaluation of runs that do not separate all orders, for a fixed or rotating ring, as the end of a sentence."""


@shows_progress
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
        A design, or the name of a preset or a file; its drive sets the speed.
    load
        Torque of the loaded runs [N m]; by default the rated torque, drive.torque times the ratio.
    drag
        Torque of the unloaded runs [N m], by default the rated torque times `SteadySettings.drag_share`; at 0 the disc
        floats in its clearances.
    slow
        Slow speed of the driven shaft [rad/s], by default the design's speed times `TraceSettings.slow_share`.
    turns
        Crank turns relative to the ring; N - 1 turns (N ring teeth) separate the orders of the ring from the orders of
        holes or cranks.
    quick
        Whether to skip the slow runs and those with half the time step.
    progress, solver
        Called after each run with the numbers of finished and of all runs; solver of the runs.

    Returns
    -------
    Measurement
        For each load, direction and speed the peak-to-peak and rms errors of disc and output, the shifts between loads
        and directions, and the rms of the orders that a cause such as the mesh excites [arcsec], with numerical errors
        and static solutions; curves over the crank angle and spectra.
    """
    reducer = reducer_of(resolve(design))
    require_motion(reducer)
    torques = load_cases(reducer, load, drag)
    rpm = abs(reducer.design.drive.speed) / RPM
    conditions = _list_conditions(reducer, torques, slow, quick)
    reducer = reducer.working_at(torques["loaded"])
    runs = _run_traces(reducer, conditions, turns * reducer.mesh_turn / (2.0 * np.pi), progress, not quick, solver)
    traces = {condition: runs[condition, 1.0] for condition in conditions}
    finer_traces = {(condition.load, condition.pace): run for (condition, factor), run in runs.items() if factor == 0.5}
    statics = {condition: _solve_statics(reducer, condition, turns) for condition in conditions}
    return Measurement(
        measure="te",
        design=reducer.design,
        condition=(
            f"{describe_loads(torques)}, {rpm:.0f} rpm at speed, {reducer.design.condition_words}, {SOLVERS[solver]}"
        ),
        quantities=by_key(te_table.quantities(reducer, traces, finer_traces, statics, turns)),
        curves=te_table.curves(reducer, traces, statics),
        assumptions=_assumptions(reducer, turns),
        runs={condition.key: trace.run for condition, trace in traces.items()},
        details={"orders": te_table.order_details(reducer, traces, turns)},
    )


def _list_conditions(
    reducer: Reducer, torques: Mapping[str, float], slow: float | None, quick: bool
) -> list[TraceCondition]:
    """List the conditions of the runs: each load in both directions, at full speed and, unless `quick`, at slow speed.

    `torques` maps the loads to output torques [N m]. `slow` is the slow speed of the driven shaft [rad/s]; None for the
    design's speed times `TraceSettings.slow_share`.
    """
    speed = abs(reducer.design.drive.speed)
    speed_by_pace = (
        {"speed": speed} if quick else {"slow": TRACE.slow_share * speed if slow is None else slow, "speed": speed}
    )
    directions = {"forward": 1.0, "reverse": -1.0}
    return [
        TraceCondition(load, direction, pace, torques[load], directions[direction] * speed_by_pace[pace])
        for pace, load, direction in product(speed_by_pace, torques, directions)
    ]


def _run_traces(
    reducer: Reducer,
    conditions: list[TraceCondition],
    turns: float,
    progress: Progress,
    check_step: bool,
    solver: Solver,
) -> Mapping[tuple[TraceCondition, float], Trace]:
    """Simulate the runs of a transmission error measurement in threads, each over some crank `turns`.

    `conditions` are load, speed and direction of each run. With `check_step`, the first mesh periods of forward runs
    are simulated again with half the time step. `solver` is the solver of the runs.

    Returns
    -------
    Mapping
        (condition, factor on the time step: 1 or 0.5) -> errors of disc and output over the crank angle.
    """
    half_step = halve_time_step(reducer, solver)
    models = {1.0: (reducer, model_for(solver, reducer), turns)}
    if check_step:
        models[0.5] = (half_step, model_for(solver, half_step), TRACE.checked_periods / reducer.mesh_periods)
    keys = [
        (condition, step_factor)
        for step_factor in models
        for condition in conditions
        if step_factor == 1.0 or condition.direction == "forward"
    ]
    tasks = [
        (reducer, copy_model(model), turns, condition)
        for condition, step_factor in keys
        for reducer, model, turns in [models[step_factor]]
    ]
    traces = each_in_threads(lambda task: run_trace(*task), tasks, progress)
    return dict(zip(keys, traces, strict=True))


def _solve_statics(reducer: Reducer, condition: TraceCondition, turns: int) -> ErrorCurves:
    """Compute the transmission errors of disc and output [arcsec] under a load by statics, over some crank turns.

    `condition` has load and direction.
    """
    design = reducer.design
    # eight in a mesh period
    point_count = 8 * design.ring.teeth * turns + 1
    crank_angle = np.linspace(0.0, turns * reducer.mesh_turn, point_count)
    driven_reducer = reducer.but(drive={"speed": condition.speed})
    errors = (
        ARCSECONDS
        * reducer.member.sense
        * transmission_error(driven_reducer, crank_angle, float(np.sign(condition.speed)) * condition.torque)
    )
    return ErrorCurves(crank_angle, errors[:, 0], errors[:, 1])


def _runout_text(reducer: Reducer) -> str:
    """Return the assumption about the run-out of shafts."""
    if isinstance(reducer, RvReducer) and reducer.has_runout:
        return f"without runout, except that of the output, on a radius of {MILLIMETRES * reducer.output_radius:.4g} mm"
    return "without runout"


def _assumptions(reducer: Reducer, turns: int) -> tuple[str, ...]:
    """Return the assumptions of a transmission error measurement by simulation, a sentence each.

    They are about bearings, drag, statics, contact stiffness, numerical errors and orders. `turns` is the number of
    crank turns of a run.
    """
    design = reducer.design
    ring_base, holes_base = base_orders(reducer)
    separation_sentence = (
        f"orders are cycles in a crank turn; fewer than {design.lobes} turns cannot separate whole orders from "
        f"multiples of {holes_base if ring_base == 1 else ring_base} in one signal"
        f"{SEPARATION[reducer.LAYOUT](ring_base == 1)}"
    )
    return (
        f"shafts run in rigid bearings {_runout_text(reducer)}; {structure_text(reducer)}",
        f"the default drag of an unloaded reducer is {STEADY.drag_share:.0%} of the nominal torque: without it the "
        "disc floats in its clearances; up to the nominal torque presses the flanks together before the window",
        STATICS[reducer.LAYOUT],
        "contacts have the secant stiffness of one working force in all runs, that of the loaded ones: "
        f"{reducer.contacts.working_forces_text(tuple(reducer.clearance_keys))}",
        f"numerical error: change with half the time step over the first {TRACE.checked_periods} mesh periods of the "
        "forward run, also used for the reverse run (not available with --quick), and half the change of a level "
        "between the halves of the window, as crank turns differ; of orders: the rms of the change with half the "
        "step, an upper bound of each",
        *(f"orders of {cause_of_orders.name}: {cause_of_orders.why}" for cause_of_orders in causes(reducer)),
        *([] if te_table.separates_orders(reducer, turns) else [separation_sentence]),
    )
