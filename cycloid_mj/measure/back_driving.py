"""The reducer turned by its output: from rest, at speed with the crank free, and against the rated crank torque."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.powers import SELF_LOCKING
from cycloid_mj.base.record import Run
from cycloid_mj.dynamics.course import Course, braking
from cycloid_mj.dynamics.run import Solver, model_for, simulate
from cycloid_mj.parts import turning_inertia
from cycloid_mj.reducer import Reducer

GROWTHS, GROWS_FOR = (0.025, 0.1), 0.04
"""The torque from rest grows to this share of the rated output torque, over this time [s] or a longer one; to the
second share where the crank has stayed at rest under the first, or hardly left it."""

TURNED = math.radians(0.1)
"""A free crank that has come this far [rad] turns: the clearances let it move by less."""

LEAST_TRAVEL = 0.25
"""Share of the way of a crank without friction; one that comes less far creeps at best."""

LEAST_WAY = 30.0 * TURNED
"""Way [rad] of a crank without friction, while the torque grows."""

CROSSED = 0.25
"""Share of the time in which the torque carries the output across all of its play."""

FEWEST = 40
"""Samples of a turning crank."""


@dataclass(frozen=True, eq=False)
class BreakAway:
    """A free crank under a growing output torque.

    Attributes
    ----------
    torque
        Output torque from which the crank speeds up [N m]; not a number where it stays at rest: self-locking.
    error
        By how much the first quarter and the second half of the samples differ [N m].
    largest
        Largest output torque that was tried [N m].
    run
        The run.
    """

    torque: float
    error: float
    largest: float
    run: Run

    @property
    def locked(self) -> bool:
        """Whether the crank stays at rest: the reducer is self-locking."""
        return math.isnan(self.torque)

    @property
    def resolved(self) -> bool:
        """Whether the torque is more than its own error: pins that cross wide play strike the crank on its way."""
        return self.torque > self.error

    @property
    def note(self) -> str:
        """What the torque says, or why it says nothing."""
        if self.locked:
            return f"{SELF_LOCKING} with no torque on the crank, by up to {self.largest:g} N m on the output"
        if not self.resolved:
            return (
                f"below {self.torque + self.error:.2g} N m: less than its own error, as parts cross their play while "
                "the crank comes up to speed"
            )
        return "none to speak of: friction is in proportion to the load, and there is only the parts' weight"


def break_away(reducer: Reducer, solver: Solver = "planar") -> BreakAway:
    """Let the output torque grow from zero on a reducer at rest, its crank free.

    Contacts have the stiffness of the rated load, or they would creep under the growing one. Friction without a load is
    that of the parts' own weight and inertia; what is in proportion to the load is in the efficiency of back-driving.
    The crank's speed follows T t^2/2 - T0 t: the straight line of its acceleration meets zero at the torque T0.
    """
    for growth in GROWTHS:
        found = _under(reducer, growth * reducer.design.rated_torque, solver)
        if found.torque + found.error < found.largest:
            break
    return found


def _under(reducer: Reducer, largest: float, solver: Solver) -> BreakAway:
    """Let the output torque grow to a `largest` one [N m]."""
    forward = -braking(reducer)
    compiled = model_for(solver, reducer.at_rated_load, held="")
    light = largest / (6.0 * reducer.design.reduction * compiled.crank_inertia)
    grows_for = max(GROWS_FOR, math.sqrt(LEAST_WAY / light), _crossing(reducer, largest))
    course = Course(
        angle=0.0,
        speed=0.0,
        drive=lambda time: np.zeros_like(time),
        load=lambda time: forward * largest * time / grows_for,
    )
    run = simulate(reducer.at_rated_load.but(drive={"ramp": 0.0, "hold": grows_for}).design, compiled, course)
    moving = run.select(np.abs(run["crank_angle"]) > TURNED)
    if abs(run["crank_angle"][-1]) < LEAST_TRAVEL * light * grows_for**2 or len(moving) < FEWEST:
        return BreakAway(math.nan, math.nan, largest, run)
    growth, count = largest / grows_for, len(moving)
    parts = [slice(None), slice(0, count // 4), slice(count // 2, None)]
    torque, *others = (growth * _start(moving.select(part)) for part in parts)
    return BreakAway(torque, max(abs(other - torque) for other in others), largest, run)


def _crossing(reducer: Reducer, largest: float) -> float:
    """Compute the time [s] of growth to a torque that carries the output across its play in `CROSSED` of it."""
    return math.sqrt(6.0 * reducer.play * turning_inertia(reducer) / (largest * CROSSED**3))


def _start(moving: Run) -> float:
    """Compute the time [s] at which a parabola through the crank's speed has no acceleration."""
    square, linear, _ = np.polyfit(moving.time - moving.time[0], moving["crank_speed"], 2)
    return float(moving.time[0] - linear / (2.0 * square))
