"""The runs that efficiency is measured by: a map of torque and speed, no load, and the output as the driver."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from cycloid_mj.base.engine import Progress, all_in_threads
from cycloid_mj.base.errors import told_elsewhere, warn
from cycloid_mj.base.powers import Powers, mean_powers
from cycloid_mj.base.record import Run
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Design
from cycloid_mj.dynamics.massless import massless
from cycloid_mj.dynamics.regime import creeping, creeping_in
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.measure import sensitivity
from cycloid_mj.measure.back_driving import BreakAway, break_away
from cycloid_mj.measure.brake_test import braked_run
from cycloid_mj.measure.closed_form import ideal_limit
from cycloid_mj.measure.conditions import halved
from cycloid_mj.measure.spread import PERIODS as SPREAD_PERIODS
from cycloid_mj.measure.spread import Input, Moved, inputs, moved, slow_ends
from cycloid_mj.measure.steady import SETTLED, first_half, steady, whole_periods
from cycloid_mj.reducer import Reducer

_RUNS = {
    "rated": "rated, {}",
    "ideal": "the same without play",
    "unloaded": "no load",
    "backward": "output drives against {}",
    "coasting": "output drives a free crank",
    "halved": "rated with half the step",
}
"""Words for runs that are not of the map, with their load and speed."""


@dataclass(frozen=True, eq=False)
class Point:
    """One steady run.

    Attributes
    ----------
    torque
        Torque on the output against its way [N m]; where the output drives, torque on the crank against its way.
    speed
        Crank speed [rad/s].
    powers, shorter
        Mean powers of the run and of its first half.
    run
        The run.
    reducer
        What ran, under its load.
    """

    torque: float
    speed: float
    powers: Powers
    shorter: Powers
    run: Run
    reducer: Reducer

    @property
    def drag(self) -> float:
        """Torque on the crank [N m] that the losses ask for."""
        return self.powers.lost / abs(self.speed)

    @property
    def drag_shift(self) -> float:
        """By how much that of the first half differs [N m]."""
        return abs(self.powers.lost - self.shorter.lost) / abs(self.speed)

    @property
    def shift(self) -> float:
        """By how much the efficiency of the first half differs."""
        return abs(self.powers.efficiency - self.shorter.efficiency)


@dataclass(frozen=True, eq=False)
class EfficiencyMap:
    """Points of the map; the rated point, with half the step, and in the ideal limit; no load; the output as driver.

    `by_input` is the rated point's efficiency with each assumed input varied, `by_friction` that by the friction of the
    teeth. A free crank that locks the reducer has no coasting: with the output held at its speed it would jam.
    """

    grid: tuple[Point, ...]
    rated: Point
    halved: Point | None
    ideal: Point
    unloaded: Point
    coasting: Point | None
    backward: Point
    rest: BreakAway
    by_input: tuple[Moved, ...]
    by_friction: Mapping[float, float]

    @property
    def error(self) -> float:
        """Numerical error of the rated point's efficiency: half the step, or half the average."""
        step = 0.0 if self.halved is None else abs(self.halved.powers.efficiency - self.rated.powers.efficiency)
        return max(step, self.rated.shift)


def run_map(
    reducer: Reducer,
    torques: Sequence[float],
    speeds: Sequence[float],
    periods: int,
    check: bool,
    progress: Progress,
    solver: Solver,
) -> EfficiencyMap:
    """Run every point over at least so many mesh periods, several at a time, and the rated one with half the step.

    The map, and the rated point with an input varied, are of massless pins where pins move.

    `torques` on the output [N m] and crank `speeds` [rad/s] make the map.
    """
    design = reducer.design
    rated, speed = design.rated_torque, design.drive.speed
    # The longest runs come first, so that no processor is left alone with one.
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
        tasks["halved"] = partial(forward, halved(reducer, solver), rated, speed, periods, solver)
    assumed = inputs(reducer)
    varied: dict[Hashable, Reducer] = {end: Reducer(end) for one in assumed for end in one.ends}
    varied |= {value: sensitivity.with_common_friction(reducer, value) for value in sensitivity.COMMON}
    tasks |= {key: partial(forward, massless(one), rated, speed, SPREAD_PERIODS, solver) for key, one in varied.items()}
    points = all_in_threads(tasks, progress)
    told = [key for key in tasks if key not in slow_ends(assumed)]
    warn(design.name, creeping_in({_named(key, points[key], assumed): points[key].reducer for key in told}))
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
        by_input=moved(assumed, rates),
        by_friction={value: rates[value] for value in sensitivity.COMMON},
    )


def forward(reducer: Reducer, torque: float, speed: float, periods: int, solver: Solver) -> Point:
    """Run under an output torque [N m], the crank held at a speed [rad/s]."""
    loaded = reducer.but(drive={"speed": speed}, load={"torque": torque})
    with told_elsewhere(tuple(creeping(loaded))):
        run = steady(loaded, SETTLED, whole_periods(loaded, periods, torque), solver)
    return _point(torque, speed, run, loaded)


def backward(reducer: Reducer, torque: float, periods: int, solver: Solver) -> Point:
    """Drive the output against a torque on the crank [N m]; with none, the crank is free.

    The crank is held at its speed against the torque, so that its rotor does not have to cross the play first. What the
    output is driven by follows from a shorter run, and is what that torque asks for without losses where both shafts
    drive: self-locking.
    """
    if not torque:
        with told_elsewhere(tuple(creeping(reducer))):
            run = braked_run(reducer, torque, whole_periods(reducer, periods, torque), solver)
        return _point(torque, reducer.design.drive.speed, run, reducer)
    speed, driving = reducer.design.drive.speed, torque * reducer.design.reduction
    point = forward(reducer, -driving, speed, SPREAD_PERIODS, solver)
    if point.powers.efficiency > 0.0:
        point = forward(reducer, -driving / point.powers.efficiency, speed, periods, solver)
    return replace(point, torque=torque)


def _point(torque: float, speed: float, run: Run, reducer: Reducer) -> Point:
    return Point(torque, speed, mean_powers(run), mean_powers(first_half(run)), run, reducer)


def _named(key: Hashable, point: Point, assumed: Sequence[Input]) -> str:
    """Name a run of the map: by its load and speed, or by what it has else."""
    if isinstance(key, Design):
        return next(one.names[key] for one in assumed if key in one.ends)
    if isinstance(key, float):
        return sensitivity.common_name(key)
    at = f"{point.torque:.4g} N m at {abs(point.speed) / RPM:.4g} rpm"
    return at if isinstance(key, tuple) else _RUNS[str(key)].format(at)
