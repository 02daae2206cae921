"""Runs at a steady state, and the mean powers over their whole periods."""

import math

from cycloid_mj.analysis.warnings import balance_warnings
from cycloid_mj.base.errors import warn
from cycloid_mj.base.names import GEAR
from cycloid_mj.base.record import Run
from cycloid_mj.dynamics.drive_cycle import DriveCycle
from cycloid_mj.dynamics.regime import lowest_log_rate
from cycloid_mj.dynamics.run import Model, Solver, model_for, simulate
from cycloid_mj.dynamics.settling import slowness
from cycloid_mj.measure.conditions import LOG_RATE, require_motion
from cycloid_mj.measure.reaction import masses
from cycloid_mj.reducer import Reducer

SETTLED = 0.01
"""Time [s] after which a run under a held crank counts: the load's rise, and the time that it takes to ring out."""

NEAR_WHOLE = 0.1
"""By how much of a period the output pins may miss a whole number of theirs."""

REMEDY = (
    "the samples are too coarse for these powers: set settings.log_rate_hz to 40000 or more, or a shorter time step"
)
"""Remedy of an open power balance: the duration of these runs is not the design's."""

HEAVY = 0.02
"""Weight of the discs, as a share of the load's force on their cams, from which the crank's turn shows in the losses:
at 0.02 they go up and down by some 1 % of themselves."""


def whole_periods(reducer: Reducer, least: int, load: float | None = None) -> int:
    """Round up to mesh periods after which the output pins are near to whole periods as well.

    Seen from the ring, torque and losses repeat with the mesh, every 2 pi/N of the crank, and with the output pins,
    which pass the direction of the eccentric every 2 pi/pins x (N - 1)/N of it: m mesh periods are m pins/(N - 1) of
    theirs. After N - 1 of the one and `pins` of the other all repeats, which is why a whole turn of the crank is no
    better a window. Where discs are `HEAVY` against the `load` on the output [N m], by default the rated torque, it is:
    then these are two turns.
    """
    design = reducer.design
    ratio = design.output.pins / design.lobes
    if _heavy(reducer, design.rated_torque if load is None else load):
        return max(least, 2 * reducer.mesh_periods)

    def missed(count: int) -> float:
        return abs(count * ratio - round(count * ratio))

    candidates = range(least, max(least, design.lobes) + 1)
    return next((count for count in candidates if missed(count) <= NEAR_WHOLE), least)


def _heavy(reducer: Reducer, load: float) -> bool:
    design, gravity = reducer.design, reducer.design.environment
    weight = design.gear.discs * masses(reducer)[GEAR].mass * math.hypot(gravity.gravity_x, gravity.gravity_y)
    return weight * design.gear.eccentricity * design.reduction > HEAVY * abs(load)


def steady(
    reducer: Reducer,
    settled: float,
    periods: int,
    solver: Solver = "planar",
    compiled: Model | None = None,
    course: DriveCycle | None = None,
) -> Run:
    """Run a design from full speed; give its samples of so many mesh periods after a time `settled` [s].

    `compiled` is a model for another `course`, by default the solver's own.

    A drive that settles more slowly than the paper's is given as much longer.
    """
    settled *= slowness(reducer)
    timed = densely_logged(reducer).steady(settled, periods / reducer.mesh_periods)
    run = simulate(timed.design, compiled or model_for(solver, timed), course)
    run = run.select(run.time >= settled * (1.0 - 1e-9))
    warn(reducer.design.name, balance_warnings(run, reducer, REMEDY))
    return run


def steady_design(reducer: Reducer) -> Reducer:
    """Return the design with the log rate of these runs, at full speed from the start."""
    require_motion(reducer)
    return reducer.but(settings={"log_rate": max(LOG_RATE, reducer.design.settings.log_rate)})


def densely_logged(reducer: Reducer) -> Reducer:
    """Return the design with a log rate that resolves the passing of its teeth."""
    lowest = lowest_log_rate(reducer)
    return reducer.but(settings={"log_rate": lowest}) if lowest > reducer.design.settings.log_rate else reducer


def first_half(run: Run) -> Run:
    """Return the first half of the samples: a shorter average."""
    return run.select(slice(0, len(run) // 2))
