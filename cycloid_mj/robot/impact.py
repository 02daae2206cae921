"""An impact: a load that swings to and fro carries the output across the play onto the other stop, the crank held.

What it winds up to there is what a step has to get right: across the play nothing resists, and a step too long is deep
in the stop before the springs act, or takes energy out of every bounce.
"""

import math
from bisect import bisect
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cycloid_mj.base.errors import RunError
from cycloid_mj.robot.reducer import ReducedJoint
from cycloid_mj.robot.trial import TrialScene

FREQUENCY = 3.0
"""Of the load [Hz]; halved until the output has crossed the play when the load is at its largest."""

HALVINGS = 12
"""At most."""

TOLERANCE = 1e-8
"""Of the reference in a step, relative, and absolute over the wind-up under the rated torque."""

LOOKS = 100
"""Places of the reference in a cycle of the load, and of the vibration: a peak between two is 5e-4 higher at most."""

MOST_STEPS = 1_000_000
"""Of the reference between two of its places."""

EDGE = 1e-9
"""Width over which the tabulated torque may jump, where errors outrun the wind-up: a share of where it bends."""

LENGTH = 0.75
"""Cycles of the load that are run: from its largest one way through its largest the other way to zero."""


@dataclass(frozen=True)
class ImpactLoad:
    """The load rated cos(2 pi f t) on the output, from rest on the upper stop.

    Attributes
    ----------
    frequency
        f [Hz].
    peak
        Largest wind-up beyond the mean lower stop [rad], by an integrator of variable order and step.
    """

    frequency: float
    peak: float

    @property
    def duration(self) -> float:
        """Time that is run [s]."""
        return LENGTH / self.frequency


@lru_cache(maxsize=64)
def impact(reduced: ReducedJoint, inertia: float) -> ImpactLoad:
    """Solve the impact of a joint with an inertia on its output [kg m2] at its level, by LSODA instead of MuJoCo.

    J x'' = T cos(2 pi f t) - spring(x) - c x', J being all that turns with the output and c the damping: at the level
    `full` beyond the stops alone, as `ReducedJoint.step` has it, at `backlash` within the play too, as MJCF does.

    Raises
    ------
    RunError
        The load carries the output across the play at none of the frequencies.
    """
    for halving in range(HALVINGS):
        frequency = FREQUENCY / 2.0**halving
        crossed, peak = _swing(reduced, inertia, frequency)
        if crossed <= 0.5 / frequency:
            return ImpactLoad(frequency, peak)
    raise RunError(f"{reduced.name}: the rated load does not carry {inertia:.4g} kg m2 across the play in a minute")


def peak_of(on: TrialScene, struck: ImpactLoad) -> float | None:
    """Compute the largest wind-up [rad] of an impact by MuJoCo, `ImpactLoad.peak`; None where the joint runs away."""
    reduced, pulse = on.reduced, 2.0 * np.pi * struck.frequency
    on.hold()
    on.press(reduced.rated_torque)
    steps = math.ceil(struck.duration / float(on.model.opt.timestep))
    lengths = on.lengths(lambda time: reduced.rated_torque * math.cos(pulse * time), steps)
    return None if lengths is None else reduced.stops[0] - float(lengths.min())


def _swing(reduced: ReducedJoint, inertia: float, frequency: float) -> tuple[float, float]:
    """Compute when the output reaches the lower stop [s], infinity for never, and its largest wind-up there [rad]."""
    from scipy.integrate import odeint

    rated, moving, pulse = reduced.rated_torque, inertia + reduced.output_inertia, 2.0 * math.pi * frequency
    full = reduced.level == "full"
    start = reduced.stops[1] + reduced.wind_up(rated) + (reduced.ripple.errors(0.0, 1.0)[1] if full else 0.0)
    pull, damping = _pull(reduced), reduced.damping

    def motion(state: np.ndarray, time: float) -> tuple[float, float]:
        length, speed = state.tolist()
        torque = pull(length)
        resisted = damping * speed if torque or not full else 0.0
        return speed, (rated * math.cos(pulse * time) + torque - resisted) / moving

    duration = LENGTH / frequency
    vibration = math.sqrt(reduced.stiffness(rated) / moving) / (2.0 * math.pi)
    times = np.linspace(0.0, duration, math.ceil(LOOKS * LENGTH * max(1.0, vibration / frequency)))
    states = odeint(
        motion,
        [start, 0.0],
        times,
        rtol=TOLERANCE,
        atol=TOLERANCE * reduced.wind_up(rated),
        hmax=1.0 / (LOOKS * frequency),
        mxstep=MOST_STEPS,
    )
    beyond = np.flatnonzero(states[:, 0] <= reduced.stops[0])
    crossed = float(times[beyond[0]]) if beyond.size else math.inf
    return crossed, reduced.stops[0] - float(states[:, 0].min())


def _pull(reduced: ReducedJoint) -> Callable[[float], float]:
    """Tabulate the springs' torque [N m] over L [rad] at the crank angle 0, which is asked for a million times."""
    bends = reduced.bends(0.0)
    apart = float(np.ptp(bends))
    places = [bends[0] - apart, *(bend + side * EDGE * apart for bend in bends for side in (-1, 1)), bends[-1] + apart]
    stops_at = reduced.moving_stops(0.0)
    torques = [reduced.torque(at, stops_at(at) if reduced.level == "full" else reduced.stops) for at in places]
    last = len(places) - 1

    def pull(length: float) -> float:
        i = min(max(bisect(places, length), 1), last)
        share = (length - places[i - 1]) / (places[i] - places[i - 1])
        return torques[i - 1] + share * (torques[i] - torques[i - 1])

    return pull
