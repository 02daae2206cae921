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
from cycloid_mj.dynamics.regime import creeping, creeping_in
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.measure import sensitivity
from cycloid_mj.measure.back_driving import BreakAway, break_away
from cycloid_mj.measure.brake_test import run_brake_test
from cycloid_mj.measure.closed_form import ideal_limit
from cycloid_mj.measure.conditions import halve_time_step
from cycloid_mj.measure.spread import INPUTS, Input, InputEffect, inputs, pair_rates, slow_ends
from cycloid_mj.measure.steady import SETTLING_TIME, first_half, run_steady, whole_periods
from cycloid_mj.reducer import Reducer

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
class Point:
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
    """What ran, under its load."""

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

    grid: tuple[Point, ...]
    rated: Point
    halved: Point | None
    ideal: Point
    unloaded: Point
    coasting: Point | None
    backward: Point
    rest: BreakAway
    by_input: tuple[InputEffect, ...]
    by_friction: Mapping[float, float]

    @property
    def error(self) -> float:
        """Numerical error of the rated point's efficiency: change with half the time step or averaging time."""
        step = 0.0 if self.halved is None else abs(self.halved.powers.efficiency - self.rated.powers.efficiency)
        return max(step, self.rated.shift)


Floats = Sequence[float]


def run_map(
    reducer: Reducer, torques: Floats, speeds: Floats, periods: int, check: bool, progress: Progress, solver: Solver
) -> EfficiencyMap:
    """Run the points of the map, the variants of the rated one, and those driven backward, several at a time.

    The map, and the rated point with a varied input, use massless pins where pins move.

    Parameters
    ----------
    reducer
        The drive.
    torques, speeds
        Torques on the output [N m] and crank speeds [rad/s] of the map.
    periods
        Mesh periods of each run at least.
    check
        Whether to run the rated point with half the time step.
    progress, solver
        Progress report, and solver of the runs.
    """
    design = reducer.design
    rated, speed = design.rated_torque, design.drive.speed
    # The longest runs come first, so that no processor waits for one at the end.
    grid = [(torque, pace) for pace in sorted(speeds, key=abs) for torque in torques]
    rest = break_away(reducer, solver)
    light = massless(reducer)
    tasks: dict[Hashable, Callable[[], Point]] = {
        place: partial(forward, light, *place, periods, solver)
        for place in grid
        if light != reducer or place != (rated, speed)
    }
    tasks["rated"] = partial(forward, reducer, rated, speed, periods, solver)
    tasks["ideal"] = partial(forward, ideal_limit(reducer), rated, speed, periods, solver)
    tasks["unloaded"] = partial(forward, reducer, 0.0, speed, periods, solver)
    tasks["backward"] = partial(backward, reducer, design.drive.torque, periods, solver)
    if not rest.locked:
        tasks["coasting"] = partial(backward, reducer, 0.0, periods, solver)
    if check:
        tasks["halved"] = partial(forward, halve_time_step(reducer, solver), rated, speed, periods, solver)
    assumed = inputs(reducer)
    varied: dict[Hashable, Reducer] = {end: Reducer(end) for item in assumed for end in item.ends}
    varied |= {value: sensitivity.with_common_friction(reducer, value) for value in sensitivity.COMMON}
    tasks |= {key: partial(forward, massless(end), rated, speed, INPUTS.periods, solver) for key, end in varied.items()}
    points = all_in_threads(tasks, progress)
    slow = slow_ends(assumed)
    named = {_run_name(key, points[key], assumed): points[key].reducer for key in tasks if key not in slow}
    warn(design.name, creeping_in(named))
    rates = {key: points[key].powers.efficiency for key in varied}
    return EfficiencyMap(
        grid=tuple(points.get(place, points["rated"]) for place in grid),
        rated=points["rated"],
        halved=points.get("halved"),
        ideal=points["ideal"],
        unloaded=points["unloaded"],
        coasting=points.get("coasting"),
        backward=points["backward"],
        rest=rest,
        by_input=pair_rates(assumed, rates),
        by_friction={value: rates[value] for value in sensitivity.COMMON},
    )


def forward(reducer: Reducer, torque: float, speed: float, periods: int, solver: Solver) -> Point:
    """Run under an output torque [N m] at a constant crank speed [rad/s]."""
    loaded = reducer.but(drive={"speed": speed}, load={"torque": torque})
    with suppress_warnings(tuple(creeping(loaded))):
        run = run_steady(loaded, SETTLING_TIME, whole_periods(loaded, periods, torque), solver)
    return _point(torque, speed, run, loaded)


def backward(reducer: Reducer, torque: float, periods: int, solver: Solver) -> Point:
    """Drive the output against a torque on the crank [N m]; without a torque, the crank is free.

    The crank runs at constant speed against the torque, so that its rotor does not have to cross the clearance first.
    The driving torque follows from a shorter run; for a self-locking drive it is that without losses.
    """
    if not torque:
        with suppress_warnings(tuple(creeping(reducer))):
            run = run_brake_test(reducer, torque, whole_periods(reducer, periods, torque), solver)
        return _point(torque, reducer.design.drive.speed, run, reducer)
    speed, driving = reducer.design.drive.speed, torque * reducer.design.reduction
    point = forward(reducer, -driving, speed, INPUTS.periods, solver)
    if point.powers.efficiency > 0.0:
        point = forward(reducer, -driving / point.powers.efficiency, speed, periods, solver)
    return replace(point, torque=torque)


def _point(torque: float, speed: float, run: Run, reducer: Reducer) -> Point:
    return Point(torque, speed, mean_powers(run), mean_powers(first_half(run)), run, reducer)


def _run_name(key: Hashable, point: Point, assumed: Sequence[Input]) -> str:
    """Return the name of a run: its load and speed, or its varied input."""
    if isinstance(key, Design):
        return next(item.names[key] for item in assumed if key in item.ends)
    if isinstance(key, float):
        return sensitivity.common_name(key)
    condition = f"{point.torque:.4g} N m at {abs(point.speed) / RPM:.4g} rpm"
    return condition if isinstance(key, tuple) else _RUNS[str(key)].format(condition)
