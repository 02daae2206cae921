"""Runs at a steady state, over full periods of the mesh and of output pins or cranks."""

import math

from cycloid_mj.analysis.warnings import balance_warnings
from cycloid_mj.base.errors import warn
from cycloid_mj.base.record import Run
from cycloid_mj.dynamics.drive_cycle import DriveCycle
from cycloid_mj.dynamics.regime import lowest_log_rate
from cycloid_mj.dynamics.run import Model, Solver, model_for, simulate
from cycloid_mj.dynamics.settling import slowness
from cycloid_mj.measure.conditions import STEADY, require_motion
from cycloid_mj.parts import moving_masses
from cycloid_mj.reducer import Reducer

REMEDY = (
    "the samples are too coarse for these powers: set settings.log_rate_hz to 40000 or more, or a shorter time step"
)
"""Remedy of an open power balance: the duration of these runs is not the design's."""


def averaging_periods(reducer: Reducer, min_periods: int, load: float | None = None) -> int:
    """Return the number of mesh periods to average over, at least `min_periods`.

    Torque and losses of a drive with N ring teeth repeat with the mesh, every 2 pi/N of the crank against the ring, and
    with the n output pins or cranks. m mesh periods are m n/(N - 1) periods of these; the result is the smallest m at
    which this is nearly a whole number. If the weight of the discs is not small compared with the `load` on the output
    [N m], by default the nominal torque, the average is over two crank turns (`SteadySettings.heavy_disc_share`).
    """
    design = reducer.design
    ratio = reducer.carrying_parts[1] / design.lobes
    if _weight_matters(reducer, design.rated_torque if load is None else load):
        return max(min_periods, 2 * reducer.mesh_periods)

    def period_error(m: int) -> float:
        return abs(m * ratio - round(m * ratio))

    candidates = range(min_periods, max(min_periods, design.lobes) + 1)
    return next((m for m in candidates if period_error(m) <= STEADY.period_tolerance), min_periods)


def _weight_matters(reducer: Reducer, load: float) -> bool:
    """Return whether the discs weigh more than ``STEADY.heavy_disc_share`` of the cam force under a load [N m]."""
    environment, member = reducer.design.environment, reducer.member
    masses = moving_masses(reducer)
    mass = sum(masses[disc.part].mass for disc in reducer.mechanism.discs)
    weight = mass * math.hypot(environment.gravity_x, environment.gravity_y)
    crank_turns = abs(float(member.crank_angle(1.0) / member.output_angle(1.0)))
    return weight * reducer.design.gear.eccentricity * crank_turns > STEADY.heavy_disc_share * abs(load)


def periods_text(reducer: Reducer, periods: int) -> str:
    """Describe the length of an average [mesh periods], also in periods of output pins or cranks."""
    name, count = reducer.carrying_parts
    return (
        f"mean over {periods} mesh periods, {round(periods * count / reducer.design.lobes, 2):g} periods of the {name}"
    )


def run_steady(
    reducer: Reducer,
    settling_time: float,
    periods: int,
    solver: Solver = "planar",
    compiled: Model | None = None,
    cycle: DriveCycle | None = None,
) -> Run:
    """Simulate a design at full speed from the start; return the samples of some mesh periods in steady state.

    Issues warnings if the power balance or the efficiency of the run is implausible.

    Parameters
    ----------
    reducer
        The drive under its load.
    settling_time
        Time before the first sample [s]; it is multiplied by `settling.slowness`, at least 1.
    periods
        Number of mesh periods.
    solver
        Solver of the run.
    compiled, cycle
        Model and drive cycle; by default a new model, and the cycle at constant speed and load.
    """
    settling_time *= slowness(reducer)
    timed_design = with_log_rate(reducer).steady(settling_time, periods / reducer.mesh_periods)
    run = simulate(timed_design.design, compiled or model_for(solver, timed_design), cycle)
    run = run.select(run.time >= settling_time * (1.0 - 1e-9))
    warn(reducer.design.name, balance_warnings(run, reducer, REMEDY))
    return run


def steady_design(reducer: Reducer) -> Reducer:
    """Return the design with the log rate of steady runs, which are at full speed from the start."""
    require_motion(reducer)
    return reducer.but(settings={"log_rate": max(STEADY.log_rate, reducer.design.settings.log_rate)})


def with_log_rate(reducer: Reducer) -> Reducer:
    """Return the design with a log rate that resolves the passing of its teeth."""
    lowest = lowest_log_rate(reducer)
    return reducer.but(settings={"log_rate": lowest}) if lowest > reducer.design.settings.log_rate else reducer


def first_half(run: Run) -> Run:
    """Return the first half of the samples: a shorter average."""
    return run.select(slice(0, len(run) // 2))
