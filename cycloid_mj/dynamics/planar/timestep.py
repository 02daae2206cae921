"""Automatic choice of the time step of planar runs.

Contacts and moving pins are implicit, so only the motion that results depend on limits the step. Mean values do not
depend on the motion of pins within their clearance, accelerations do. A step that is short enough for MuJoCo follows
this motion by the midpoint rule; at a longer step implicit Euler damps it, where the midpoint rule would amplify it.
"""

from dataclasses import dataclass

from cycloid_mj.dynamics.settling import output_period
from cycloid_mj.dynamics.timestep import (
    StepAccuracy,
    StepRule,
    TimeStep,
    divide_sample_time,
    passing_limit,
    step_limits,
)
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class PlanarStepSettings:
    """Limits of the time step of planar runs."""

    max_step: float = 35e-6
    """[s]: two thirds of the time constant of the servo on the crank."""
    max_step_for_accelerations: float = 5e-6
    """[s]: of runs that evaluate accelerations, without moving pins."""
    min_steps_per_swing: float = 5.5
    """Time steps in a period of the oscillation on all contacts: mean values agree with those at 1 us to 0.001 %,
    peak-to-peak transmission errors to 0.5 %."""
    min_steps_per_tooth: float = 16.0
    """Time steps from tooth to tooth: against 96 steps mean values differ by 0.003 %, peak-to-peak transmission errors
    by 0.3 %; at 12 steps by up to 2.7 %."""


SETTINGS = PlanarStepSettings()

ACCURACY = StepAccuracy(
    "mean values within 0.1 %, peak-to-peak values within 1 %, rms speeds within 15 % and accelerations within 40 % "
    "(the time step damps moving pins)",
    "mean values within 0.1 %; peaks and rms speeds are not valid, because they depend on the inertia of the pins",
    "mean values within 0.1 %, peak-to-peak values within 1 % and rms speeds within 4 %",
)
"""Accuracy of planar runs, against a tenth of the step."""


def choose_step(reducer: Reducer) -> TimeStep:
    """Return the time step of planar runs and the limit that determines it; ``settings.timestep`` if that is set.

    Otherwise the step is the longest that divides the time between two log samples and is within the limits: an
    absolute limit, and limits by the oscillation on all contacts and by the passing of a tooth.
    """
    design = reducer.design
    if design.settings.timestep:
        return TimeStep(design.settings.timestep, "given")
    max_step_by_reason = {
        "largest allowed step": SETTINGS.max_step,
        "log rate": 1.0 / design.settings.log_rate,
        "oscillation on all contacts": output_period(reducer) / SETTINGS.min_steps_per_swing,
    }
    if design.drive.speed:
        max_step_by_reason["tooth passing"] = passing_limit(reducer, SETTINGS.min_steps_per_tooth)
    return divide_sample_time(design.settings.log_rate, max_step_by_reason)


def acceleration_timestep(reducer: Reducer) -> float:
    """Return the time step [s] of planar runs from whose motion accelerations are computed.

    It is that of `choose_step`, limited by `SETTINGS.max_step_for_accelerations` and by the oscillation of moving pins.
    A time step that the design sets is not changed.
    """
    chosen_step, log_rate = choose_step(reducer), reducer.design.settings.log_rate
    if reducer.design.settings.timestep:
        return chosen_step.seconds
    max_step_by_reason = {chosen_step.reason: chosen_step.seconds, "accelerations": SETTINGS.max_step_for_accelerations}
    if reducer.design.ring.has_pin_bodies:
        max_step_by_reason["moving pins"] = _max_pin_step(reducer)
    return divide_sample_time(log_rate, max_step_by_reason).seconds


def resolves_pins(reducer: Reducer, seconds: float) -> bool:
    """Return whether a time step [s] resolves the motion of moving pins within their clearance."""
    return seconds <= _max_pin_step(reducer) * (1.0 + 1e-9)


def _max_pin_step(reducer: Reducer) -> float:
    """Return the longest step [s] that resolves the motion of moving pins, as in MuJoCo runs.

    From 1.5 times this step on the midpoint rule may diverge; implicit Euler damps the motion at any step.
    """
    return min(step_limits(reducer, must_follow=True).values())


PLANAR_RULE = StepRule(choose_step, SETTINGS.min_steps_per_tooth, ACCURACY)
"""The time step of planar runs."""
