"""The time step of planar runs: contacts and moving pins are implicit, so only what is to be followed sets it.

Means do not depend on what moving pins do in their play, accelerations do. A step that is short enough for MuJoCo
follows it, by the midpoint rule; at a longer one implicit Euler damps it, as the midpoint rule would make it grow.
"""

from cycloid_mj.dynamics.settling import swing_period
from cycloid_mj.dynamics.timestep import Step, StepAccuracy, limits, passing_limit, whole_in_samples
from cycloid_mj.reducer import Reducer

LONGEST = 35e-6
"""Longest step [s] that is chosen: two thirds of the time constant of the servo that turns the crank."""

LONGEST_FOR_ACCELERATIONS = 5e-6
"""Longest step [s] of runs that tell accelerations, without moving pins."""

STEPS_OF_SWING = 5.5
"""Fewest steps in a swing of what turns on all contacts.

At 33 us, against 1 us at the rated load, all means of pin, nonpin, twodisc and printed are right to 0.001 %, peaks to
peak of the transmission error to 0.5 %; rms of the gear's speed are 12 % low with free pins and 1 to 3 % high without.
"""

FEWEST_STEPS = 16.0
"""Fewest steps from tooth to tooth.

Preset pin at 5000 rpm under the rated load, free, massless and fixed pins, teeth at a friction of 0.3, against 96 steps
at the same samples: at 16 steps means differ by 0.003 %, peaks to peak of the transmission error by 0.3 %, rms of the
gear's speed by 2 %; at 12 steps peaks to peak by 0.2 to 2.7 %. 144 free pins at 1640 rpm, 12.7 steps against 102: means
to the last digit shown, peak to peak 0.05 %, rms 3 %.
"""

MOST_ROUNDS = 100
"""Rounds after which a step ends whatever its contacts do, in which they press, creep or slide in other ways."""

ACCURACY = StepAccuracy(
    "mean values within 0.1 %, peak-to-peak values within 1 %, rms speeds within 15 % and accelerations within 40 % "
    "(the time step damps moving pins)",
    "mean values within 0.1 %; peaks and rms speeds are not valid, because they depend on the inertia of the pins",
    "mean values within 0.1 %, peak-to-peak values within 1 % and rms speeds within 4 %",
)
"""Against a tenth of the step."""


def chosen(reducer: Reducer) -> Step:
    """Choose the time step of a design's planar runs: ``settings.timestep``, or the longest that is short enough."""
    design = reducer.design
    if design.settings.timestep:
        return Step(design.settings.timestep, "given")
    allowed = {
        "largest allowed step": LONGEST,
        "log rate": 1.0 / design.settings.log_rate,
        "oscillation on all contacts": swing_period(reducer) / STEPS_OF_SWING,
    }
    if design.drive.speed:
        allowed["tooth passing"] = passing_limit(reducer, FEWEST_STEPS)
    return whole_in_samples(design.settings.log_rate, allowed)


def for_accelerations(reducer: Reducer) -> float:
    """Compute the time step [s] of planar runs that tell accelerations; moving pins are followed in their play."""
    step, rate = chosen(reducer), reducer.design.settings.log_rate
    if reducer.design.settings.timestep:
        return step.seconds
    allowed = {step.reason: step.seconds, "accelerations": LONGEST_FOR_ACCELERATIONS}
    if reducer.design.ring.has_pin_bodies:
        allowed["moving pins"] = _longest_that_follows_pins(reducer)
    return whole_in_samples(rate, allowed).seconds


def follows_pins(reducer: Reducer, step: float) -> bool:
    """Tell whether a time step [s] follows what moving pins do in their play."""
    return step <= _longest_that_follows_pins(reducer) * (1.0 + 1e-9)


def _longest_that_follows_pins(reducer: Reducer) -> float:
    """Compute it [s]: the longest that MuJoCo may take to follow them.

    The paper's free pins at the rated load, accelerations of gear's centre and output up to 10 kHz, and rms of the
    gear's speed: MuJoCo at 0.25 us 1.584 m/s2, 50.0 rad/s2 and 1.95 mrad/s. By the midpoint rule 1.50 to 1.57, 48 to 49
    and 1.92 to 1.94 at 0.1 to 0.5 us, as pins chatter, 1.59, 50.0 and 2.02 at 2.5 us; beyond 7 us it goes wrong, with
    144 pins from 1.5 times this step on. By implicit Euler 1.36, 48.4 and 1.85 at 0.05 us, 1.29, 47 and 1.80 at 0.5 us,
    1.00, 32 and 1.71 at 25 us.
    """
    return min(limits(reducer, followed=True).values())
