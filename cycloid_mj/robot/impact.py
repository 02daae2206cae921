"""Impact of the output: an alternating load carries it across the play onto the other stop, with the crank locked.

The peak wind-up there is the accuracy criterion of a time step. Nothing resists across the play: with a time step that
is too long, the output is deep in the stop before the springs act, or each bounce loses energy.
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


@dataclass(frozen=True)
class ImpactSettings:
    """Settings of the alternating load, and of its reference solution by LSODA (Petzold 1983)."""

    start_frequency: float = 3.0
    """First frequency of the load [Hz]; it is halved until the output crosses the play before the load is largest."""
    max_halvings: int = 12
    """Largest number of halvings."""
    tolerance: float = 1e-8
    """Tolerance of the reference solution: relative, and absolute over the wind-up under the nominal torque."""
    samples_per_cycle: int = 100
    """Samples of the reference in a cycle of load and vibration: a peak between two is at most 5e-4 higher."""
    max_steps: int = 1_000_000
    """Largest number of steps of the reference between two samples."""
    jump_width: float = 1e-9
    """Width of a jump of the tabulated torque, over the range of its bends; the error may fall faster than the
    wind-up."""
    cycles: float = 0.75
    """Cycles of the load: from its maximum in one direction through that in the other to zero."""


IMPACT = ImpactSettings()


@dataclass(frozen=True)
class ImpactLoad:
    """Load T cos(2 pi f t) on the output, with the nominal torque T, and its effect from rest on the upper stop."""

    frequency: float
    """Frequency f [Hz]."""
    peak: float
    """Largest wind-up beyond the mean lower stop [rad], by an integrator of variable order and step size."""

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return IMPACT.cycles / self.frequency


@lru_cache(maxsize=64)
def solve_impact(reduced: ReducedJoint, inertia: float) -> ImpactLoad:
    """Solve the impact of a joint under an alternating load by LSODA, as a reference for MuJoCo.

    `reduced` is the joint model. Results are cached. The equation is J x'' = T cos(2 pi f t) - spring(x) - c x'. T is
    the nominal torque, f the frequency, x the angle of the output, J the inertia of the output and of its load
    (`inertia` [kg m2]), and c the damping. At the level `full`, damping acts beyond the stops only, as in
    `ReducedJoint.step`. At the level `backlash`, it acts within the play as well, as in MJCF. The frequency is halved
    until the output crosses the play within half a cycle.

    Raises
    ------
    RunError
        The load does not carry the output across the play at any of the frequencies.
    """
    for halving in range(IMPACT.max_halvings):
        frequency = IMPACT.start_frequency / 2.0**halving
        crossing_time, peak_wind_up = _solve_motion(reduced, inertia, frequency)
        if crossing_time <= 0.5 / frequency:
            return ImpactLoad(frequency, peak_wind_up)
    raise RunError(
        f"{reduced.name}: under the rated load, an inertia of {inertia:.4g} kg m2 takes more than a minute to "
        "traverse the backlash. Reduce the inertia (--load-inertia-kgm2)"
    )


def run_impact(scene: TrialScene, load: ImpactLoad) -> float | None:
    """Simulate an impact in MuJoCo; return the largest wind-up beyond the lower stop [rad], like `ImpactLoad.peak`.

    `scene` has the joint, and `load` the frequency of the alternating load. Return None if the simulation diverges.
    """
    reduced, angular_frequency = scene.reduced, 2.0 * np.pi * load.frequency
    scene.hold()
    scene.press_to_stop(reduced.rated_torque)
    steps = math.ceil(load.duration / float(scene.model.opt.timestep))
    deviations = scene.simulate_deviation(lambda time: reduced.rated_torque * math.cos(angular_frequency * time), steps)
    return None if deviations is None else reduced.stops[0] - float(deviations.min())


def _solve_motion(reduced: ReducedJoint, inertia: float, frequency: float) -> tuple[float, float]:
    """Integrate the motion of a joint's output under the load T cos(2 pi f t) from rest on the upper stop, by LSODA.

    T is the nominal torque.

    Parameters
    ----------
    inertia
        Inertia on the output [kg m2], without the joint's own.
    frequency
        Frequency f of the load [Hz].

    Returns
    -------
    tuple of float
        Time at which the output reaches the lower stop [s], infinity if it does not, and its largest wind-up beyond
        that stop [rad].
    """
    from scipy.integrate import odeint

    rated_torque, total_inertia, angular_frequency = (
        reduced.rated_torque,
        inertia + reduced.output_inertia,
        2.0 * math.pi * frequency,
    )
    is_full = reduced.level == "full"
    start_deviation = (
        reduced.stops[1] + reduced.wind_up(rated_torque) + (reduced.ripple.errors(0.0, 1.0)[1] if is_full else 0.0)
    )
    spring_torque, damping = _tabulated_torque(reduced), reduced.damping

    def state_derivative(state: np.ndarray, time: float) -> tuple[float, float]:
        deviation, speed = state.tolist()
        torque = spring_torque(deviation)
        damping_torque = damping * speed if torque or not is_full else 0.0
        return speed, (rated_torque * math.cos(angular_frequency * time) + torque - damping_torque) / total_inertia

    duration = IMPACT.cycles / frequency
    natural_frequency = math.sqrt(reduced.stiffness(rated_torque) / total_inertia) / (2.0 * math.pi)
    times = np.linspace(
        0.0, duration, math.ceil(IMPACT.samples_per_cycle * IMPACT.cycles * max(1.0, natural_frequency / frequency))
    )
    states = odeint(
        state_derivative,
        [start_deviation, 0.0],
        times,
        rtol=IMPACT.tolerance,
        atol=IMPACT.tolerance * reduced.wind_up(rated_torque),
        hmax=1.0 / (IMPACT.samples_per_cycle * frequency),
        mxstep=IMPACT.max_steps,
    )
    lower_stop_rows = np.flatnonzero(states[:, 0] <= reduced.stops[0])
    crossing_time = float(times[lower_stop_rows[0]]) if lower_stop_rows.size else math.inf
    return crossing_time, reduced.stops[0] - float(states[:, 0].min())


def _tabulated_torque(reduced: ReducedJoint) -> Callable[[float], float]:
    """Return a fast function that computes the springs' torque [N m] of a reduced joint at a deviation [rad].

    The deviation L is the output's angle minus the ideal angle. The torque is piecewise linear in L; the function
    interpolates between its breakpoints at the crank angle 0.
    """
    breakpoints = reduced.bends(0.0)
    deviation_range = float(np.ptp(breakpoints))
    knots = (bend + sign * IMPACT.jump_width * deviation_range for bend in breakpoints for sign in (-1, 1))
    deviations = [breakpoints[0] - deviation_range, *knots, breakpoints[-1] + deviation_range]
    stops_at = reduced.moving_stops(0.0)
    torques = [
        reduced.torque(deviation, stops_at(deviation) if reduced.level == "full" else reduced.stops)
        for deviation in deviations
    ]
    last_index = len(deviations) - 1

    def spring_torque(deviation: float) -> float:
        index = min(max(bisect(deviations, deviation), 1), last_index)
        fraction = (deviation - deviations[index - 1]) / (deviations[index] - deviations[index - 1])
        return torques[index - 1] + fraction * (torques[index] - torques[index - 1])

    return spring_torque
