"""Runs of the efficiency measure: a map over torque and speed, no load, and the output as the driver."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from cycloid_mj.base.engine import Progress, all_in_threads
from cycloid_mj.base.errors import suppress_warnings, warn
from cycloid_mj.base.powers import Powers, mean_powers
from cycloid_mj.base.record import Run
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Design
from cycloid_mj.dynamics.massless import massless
from cycloid_mj.dynamics.regime import creep_warning, joint_creep_warning
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.measure import sensitivity
from cycloid_mj.measure.back_driving import BreakAway, break_away
from cycloid_mj.measure.brake_test import run_brake_test
from cycloid_mj.measure.closed_form import ideal_limit
from cycloid_mj.measure.conditions import STEADY, halve_time_step
from cycloid_mj.measure.spread import INPUTS, Input, InputEffect, assumed_inputs, creep_variants, input_effects
from cycloid_mj.measure.steady import averaging_periods, first_half, run_steady
from cycloid_mj.reducer import Reducer, reducer_of

_RUNS = {
    "rated": "rated, {}",
    "ideal": "the same without clearance",
    "unloaded": "no load",
    "backward": "output drives against {}",
    "coasting": "output drives a free crank",
    "halved": "rated with half the time step",
}
"""Names of the runs outside of the map, with their load and speed."""


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """A steady run."""

    torque: float
    """Torque on the output against its motion [N m]; where the output drives, torque on the crank against its
    motion."""
    speed: float
    """Crank speed [rad/s]."""
    powers: Powers
    shorter: Powers
    """Mean powers of the run and of its first half."""
    run: Run
    """The run."""
    reducer: Reducer
    """The simulated drive under its load."""

    @property
    def drag(self) -> float:
        """Torque on the crank that covers the losses [N m]."""
        return self.powers.lost / abs(self.speed)

    @property
    def drag_shift(self) -> float:
        """Difference of that torque to the first half of the run [N m]."""
        return abs(self.powers.lost - self.shorter.lost) / abs(self.speed)

    @property
    def shift(self) -> float:
        """Difference of the efficiency to the first half of the run."""
        return abs(self.powers.efficiency - self.shorter.efficiency)


@dataclass(frozen=True, eq=False)
class EfficiencyMap:
    """All runs: the map; the rated point, also with half the time step and in the ideal limit; no load; back-driving.

    `by_input` is the rated point's efficiency with each assumed input varied, `by_friction` that by the friction of the
    teeth. There is no coasting run where a free crank locks the reducer, as the driven output would jam.
    """

    grid: tuple[OperatingPoint, ...]
    rated: OperatingPoint
    halved: OperatingPoint | None
    ideal: OperatingPoint
    unloaded: OperatingPoint
    coasting: OperatingPoint | None
    backward: OperatingPoint
    rest: BreakAway
    by_input: tuple[InputEffect, ...]
    by_friction: Mapping[float, float]

    @property
    def error(self) -> float:
        """Numerical error of the rated point's efficiency: change with half the time step or averaging time."""
        step = 0.0 if self.halved is None else abs(self.halved.powers.efficiency - self.rated.powers.efficiency)
        return max(step, self.rated.shift)


Values = Sequence[float]
Task = Callable[[], OperatingPoint]


def run_map(
    reducer: Reducer,
    torques: Values,
    speeds: Values,
    periods: int,
    check_step: bool,
    progress: Progress,
    solver: Solver,
) -> EfficiencyMap:
    """Simulate the operating points of an efficiency map and the related runs, in parallel threads; return all of them.

    Related runs are the rated point with half the time step, without clearance and with varied inputs, no-load and
    back-driving runs. Ring pins that can move have no mass in the runs of the map and in those with a varied input.

    Parameters
    ----------
    reducer, torques, speeds
        The drive; torques on the output [N m] and crank speeds [rad/s] of the map.
    periods, check_step
        Smallest number of mesh periods of each run; whether to run the rated point with half the time step.
    progress, solver
        Called with the numbers of finished and of all runs; solver of the runs.
    """
    design = reducer.design
    rated_torque, speed = design.rated_torque, design.drive.speed
    # The longest runs come first, so that no processor waits for one at the end.
    conditions = [(torque, crank_speed) for crank_speed in sorted(speeds, key=abs) for torque in torques]
    break_away_result = break_away(reducer, solver)
    massless_pins = massless(reducer)
    tasks: dict[Hashable, Task] = {
        condition: partial(run_forward, massless_pins, *condition, periods, solver)
        for condition in conditions
        if massless_pins != reducer or condition != (rated_torque, speed)
    }
    tasks |= _named_tasks(reducer, periods, check_step, break_away_result.is_locked, solver)
    varied_inputs = assumed_inputs(reducer)
    variants: dict[Hashable, Reducer] = {
        variant: reducer_of(variant) for varied_input in varied_inputs for variant in varied_input.ends
    }
    variants |= {value: sensitivity.with_common_friction(reducer, value) for value in sensitivity.FRICTION_TABLE.common}
    for key, variant in variants.items():
        tasks[key] = partial(run_forward, massless(variant), rated_torque, speed, INPUTS.periods, solver)
    points = all_in_threads(tasks, progress)
    reported_variants = tasks.keys() - creep_variants(varied_inputs)
    run_names = {key: _run_name(key, points[key], varied_inputs) for key in tasks if key in reported_variants}
    warn(design.name, joint_creep_warning({name: points[key].reducer for key, name in run_names.items()}))
    efficiency_by_variant = {key: points[key].powers.efficiency for key in variants}
    return EfficiencyMap(
        grid=tuple(points.get(condition, points["rated"]) for condition in conditions),
        rated=points["rated"],
        halved=points.get("halved"),
        ideal=points["ideal"],
        unloaded=points["unloaded"],
        coasting=points.get("coasting"),
        backward=points["backward"],
        rest=break_away_result,
        by_input=input_effects(varied_inputs, efficiency_by_variant),
        by_friction={value: efficiency_by_variant[value] for value in sensitivity.FRICTION_TABLE.common},
    )


def _named_tasks(
    reducer: Reducer, periods: int, check_step: bool, is_locked: bool, solver: Solver
) -> dict[Hashable, Task]:
    """Return functions that simulate the runs outside of the efficiency map, by their key in `_RUNS`.

    The keys are "rated", "ideal" (without clearance), "unloaded", "backward" (the output drives against the rated
    torque on the crank), "coasting" (the output drives a free crank, which has no torque) and "halved" (half the time
    step).

    Parameters
    ----------
    periods
        Smallest number of mesh periods of each run.
    check_step
        Whether to add the run "halved", with half the time step.
    is_locked
        Whether the drive is self-locking: then there is no run "coasting".
    solver
        Solver of the runs.
    """
    rated_torque, speed = reducer.design.rated_torque, reducer.design.drive.speed
    tasks: dict[Hashable, Task] = {
        "rated": partial(run_forward, reducer, rated_torque, speed, periods, solver),
        "ideal": partial(run_forward, ideal_limit(reducer), rated_torque, speed, periods, solver),
        "unloaded": partial(run_forward, reducer, 0.0, speed, periods, solver),
        "backward": partial(run_backward, reducer, reducer.design.drive.torque, periods, solver),
    }
    if not is_locked:
        tasks["coasting"] = partial(run_backward, reducer, 0.0, periods, solver)
    if check_step:
        tasks["halved"] = partial(run_forward, halve_time_step(reducer, solver), rated_torque, speed, periods, solver)
    return tasks


def run_forward(reducer: Reducer, torque: float, speed: float, periods: int, solver: Solver) -> OperatingPoint:
    """Simulate a steady run with an output torque [N m] against the motion, at a constant crank speed [rad/s].

    `periods` is the smallest number of mesh periods of the average. `solver` is the solver of the runs, MuJoCo or the
    planar solver.
    """
    drive = reducer.but(drive={"speed": speed}, load={"torque": torque})
    with suppress_warnings(tuple(creep_warning(drive))):
        run = run_steady(drive, STEADY.settling_time, averaging_periods(drive, periods, torque), solver)
    return _operating_point(torque, speed, run, drive)


def run_backward(reducer: Reducer, torque: float, periods: int, solver: Solver) -> OperatingPoint:
    """Simulate the output driving against a `torque` on the crank [N m]; return the operating point.

    A shorter first run, with the output torque of a drive without losses, measures the back-driving efficiency. In the
    second run the output torque is divided by this efficiency. If the drive is self-locking, the first run is the
    result. In both runs the crank turns at constant speed, so that it need not first be accelerated across the
    clearance. Only with a `torque` of 0 is the crank free. `periods` is the smallest number of mesh periods of the
    average. `solver` is the solver of the runs, MuJoCo or the planar solver.
    """
    if not torque:
        with suppress_warnings(tuple(creep_warning(reducer))):
            run = run_brake_test(reducer, torque, averaging_periods(reducer, periods, torque), solver)
        return _operating_point(torque, reducer.design.drive.speed, run, reducer)
    speed, driving_torque = reducer.design.drive.speed, torque * reducer.design.reduction
    point = run_forward(reducer, -driving_torque, speed, INPUTS.periods, solver)
    if point.powers.efficiency > 0.0:
        point = run_forward(reducer, -driving_torque / point.powers.efficiency, speed, periods, solver)
    return replace(point, torque=torque)


def _operating_point(torque: float, speed: float, run: Run, reducer: Reducer) -> OperatingPoint:
    return OperatingPoint(torque, speed, mean_powers(run), mean_powers(first_half(run)), run, reducer)


def _run_name(run_key: Hashable, point: OperatingPoint, varied_inputs: Sequence[Input]) -> str:
    """Return the name of a run for warnings, such as its load and speed, or the input that is varied in it.

    `run_key` is the design with a varied input, the common friction coefficient (float), a condition of the map
    (torque, speed), or a key of `_RUNS`. `point` is the operating point of the run, `varied_inputs` are all inputs that
    are varied.
    """
    if isinstance(run_key, Design):
        return next(varied_input.names[run_key] for varied_input in varied_inputs if run_key in varied_input.ends)
    if isinstance(run_key, float):
        return sensitivity.common_name(run_key)
    condition = f"{point.torque:.4g} N m at {abs(point.speed) / RPM:.4g} rpm"
    return condition if isinstance(run_key, tuple) else _RUNS[str(run_key)].format(condition)
