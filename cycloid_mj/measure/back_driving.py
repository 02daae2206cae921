"""Back-driving: the output torque from rest, with a free crank or sun."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.base.engine import each_in_threads
from cycloid_mj.base.powers import SELF_LOCKING
from cycloid_mj.base.record import Run
from cycloid_mj.comparison import StartSpread, independent_starts
from cycloid_mj.dynamics.drive_cycle import DriveCycle, braking_sign
from cycloid_mj.dynamics.run import Solver, model_for, simulate
from cycloid_mj.parts import turning_inertia
from cycloid_mj.reducer import Reducer, reducer_of


@dataclass(frozen=True)
class BreakAwaySettings:
    """Settings of a free crank under a growing output torque (`break_away`)."""

    growths: tuple[float, float] = (0.025, 0.1)
    """Shares of the rated output torque to which the torque grows. The second applies where the crank stays at rest
    under the first, or hardly turns."""
    min_time: float = 0.04
    """Shortest time of growth [s]."""
    turned: float = math.radians(0.1)
    """Rotation of a free crank or sun [rad] from which it turns; within the clearances it moves by less."""
    min_travel: float = 0.25
    """Rotation over that of a crank without friction, below which the crank only creeps, or stays at rest."""
    min_rotation: float = 30.0 * turned
    """Rotation of a crank without friction [rad] while the torque grows, at least."""
    crossing: float = 0.25
    """Share of the time in which the torque moves the output across all of its play."""
    min_samples: int = 40
    """Smallest number of samples of a turning crank."""


START = BreakAwaySettings()


@dataclass(frozen=True, eq=False)
class StartFromRest:
    """A free crank under a growing output torque, from one position at rest."""

    torque: float
    """Output torque from which the crank speeds up [N m]; not a number where it stays at rest: self-locking."""
    error: float
    """Largest change of the torque if only the first quarter, or the second half, of the samples is used [N m]."""
    max_torque: float
    """Largest output torque that was tried [N m]."""
    run: Run
    """The run."""

    @property
    def is_locked(self) -> bool:
        """True if the crank stays at rest."""
        return math.isnan(self.torque)


@dataclass(frozen=True, eq=False)
class BreakAway:
    """Break-away torques from several positions at rest, `starts`; the first is the position of the design itself."""

    starts: tuple[StartFromRest, ...]

    @property
    def turning(self) -> tuple[StartFromRest, ...]:
        """The starts from which the crank turns."""
        return tuple(start for start in self.starts if not start.is_locked)

    @property
    def is_locked(self) -> bool:
        """True if the crank stays at rest from most starts: self-locking, though weight may turn it from some."""
        return 2 * len(self.turning) < len(self.starts)

    @property
    def spread(self) -> StartSpread | None:
        """The torque [N m] over the starts from which the crank turns; None where it is self-locking."""
        return None if self.is_locked else StartSpread.of(start.torque for start in self.turning)

    @property
    def torque(self) -> float:
        """Mean of the torque over those starts [N m]; not a number where it is self-locking."""
        return self.spread.mean if self.spread else math.nan

    @property
    def error(self) -> float:
        """Error of the mean [N m]: half the range of the starts, or the mean of their own errors if that is larger."""
        if self.spread is None:
            return math.nan
        return max(self.spread.half, sum(start.error for start in self.turning) / len(self.turning))

    @property
    def exceeds_error(self) -> bool:
        """True if the torque exceeds its error: pins that cross wide clearances strike the crank."""
        return self.torque > self.error

    @property
    def run(self) -> Run:
        """The run of the first start."""
        return self.starts[0].run

    @property
    def note(self) -> str:
        """Return a sentence on the break-away torque: its range over all starts from rest, or why it is uncertain."""
        if self.spread is None:
            max_torque = max(start_test.max_torque for start_test in self.starts)
            turn_text = f", but from {len(self.turning)} of {len(self.starts)} starts" if self.turning else ""
            driven = self.run.driven_shaft
            return (
                f"{SELF_LOCKING} with no torque on the {driven}, by up to {max_torque:g} N m on the output{turn_text}"
            )
        if not self.exceeds_error:
            return (
                f"below {max(self.torque, 0.0) + self.error:.2g} N m: less than its error, as the weight of the discs "
                f"and parts that cross their clearance also move the crank; {self._starts_text}"
            )
        return (
            f"{self._starts_text}; small, as friction is in proportion to the load, which is only the weight of "
            "the parts"
        )

    @property
    def _starts_text(self) -> str:
        """Return a phrase with the range of the break-away torque and the numbers of starts with and without motion."""
        start_count, turning_count = len(self.starts), len(self.turning)
        if start_count == 1:
            return "one start, as there is no gravity"
        rest_text = (
            f"; from the other {start_count - turning_count} the {self.run.driven_shaft} stays at rest"
            if turning_count < start_count
            else ""
        )
        torque_text = self.spread.words if self.spread else ""
        return f"{torque_text} N m over {turning_count} starts around the crank turn{rest_text}"

    def as_json(self) -> dict[str, Any]:
        """Convert mean and range of the break-away torques [N m] and the number of starts at rest to JSON values."""
        return {
            "from_rest": self.spread.as_json() if self.spread else None,
            "from_rest_locked": len(self.starts) - len(self.turning),
        }


def break_away(reducer: Reducer, solver: Solver = "planar") -> BreakAway:
    """Measure the output torque at which a free crank starts to turn, at several independent starting positions.

    In each run the output torque rises in proportion to time. The acceleration of the crank is then proportional to the
    excess of the torque over the break-away torque, so the break-away torque is where a line fitted to the acceleration
    is zero. It contains only the friction that weight and inertia of the parts cause; friction in proportion to the
    load is part of the back-driving efficiency. Contact stiffnesses are valid at the rated load. The result has the
    torque and its error [N m] at each starting position, their mean and range, and whether the drive is self-locking.
    `solver` is the solver of the runs, MuJoCo or the planar solver.
    """
    return BreakAway(
        tuple(each_in_threads(lambda start: _find_break_away(reducer_of(start), solver), independent_starts(reducer)))
    )


def _find_break_away(reducer: Reducer, solver: Solver) -> StartFromRest:
    """Find the output torque at which the crank starts to turn, and its error [N m], from one position at rest.

    The torque is NaN if the crank stays at rest. In the first run, the output torque rises to the smaller share of the
    rated torque in `START.growths`. If the crank does not turn clearly, a second run rises to the larger share.
    `solver` is the solver of the runs, MuJoCo or the planar solver.
    """
    for growth in START.growths:
        start_test = _run_growing_torque(reducer, growth * reducer.design.rated_torque, solver)
        if start_test.torque + start_test.error < start_test.max_torque:
            break
    return start_test


def _run_growing_torque(reducer: Reducer, max_torque: float, solver: Solver) -> StartFromRest:
    """Simulate back-driving with an output torque that rises linearly from 0 to `max_torque` [N m]; the crank is free.

    The break-away torque is the torque at which the fitted acceleration is zero. It is NaN if the crank turns by less
    than a share of the rotation of a crank without friction, or in too few samples. Its error is the largest change if
    only the first quarter, or only the second half, of the motion is fitted. `solver` is the solver of the runs, MuJoCo
    or the planar solver.
    """
    sign = -braking_sign(reducer)
    model = model_for(solver, reducer.at_rated_load, held="")
    frictionless_rate = max_torque / (6.0 * reducer.design.reduction * model.crank_inertia)
    # a torque that rises in this time crosses the output's play in a share of it
    crossing_time = math.sqrt(6.0 * reducer.play * turning_inertia(reducer) / (max_torque * START.crossing**3))
    growth_time = max(START.min_time, math.sqrt(START.min_rotation / frictionless_rate), crossing_time)
    cycle = DriveCycle(0.0, 0.0, drive=np.zeros_like, load=lambda time: sign * max_torque * time / growth_time)
    run = simulate(reducer.at_rated_load.but(drive={"ramp": 0.0, "hold": growth_time}).design, model, cycle)
    angle = np.abs(run[f"{reducer.INPUT}_angle"])
    moving_run = run.select(angle > START.turned)
    frictionless_rotation = frictionless_rate * growth_time**2
    if angle[-1] < START.min_travel * frictionless_rotation or len(moving_run) < START.min_samples:
        return StartFromRest(math.nan, math.nan, max_torque, run)
    torque_rate, samples = max_torque / growth_time, len(moving_run)
    windows = [slice(None), slice(0, samples // 4), slice(samples // 2, None)]
    torque, *other_torques = (torque_rate * _zero_acceleration_time(moving_run.select(window)) for window in windows)
    return StartFromRest(torque, max(abs(other_torque - torque) for other_torque in other_torques), max_torque, run)


def _zero_acceleration_time(run: Run) -> float:
    """Fit a parabola to the crank speed of a run by least squares; return its vertex's time [s]."""
    quadratic, linear, _ = np.polyfit(run.time - run.time[0], run[f"{run.driven_shaft}_speed"], 2)
    return float(run.time[0] - linear / (2.0 * quadratic))
