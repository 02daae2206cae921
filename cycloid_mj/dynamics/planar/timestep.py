"""The time step of planar runs: contacts and moving pins are implicit, so only what is to be followed sets it."""

from cycloid_mj.dynamics.swing import swing_period
from cycloid_mj.dynamics.timestep import Step, StepAccuracy, passing_limit, whole_in_samples
from cycloid_mj.reducer import Reducer

LONGEST = 35e-6
"""Longest step [s] that is chosen: two thirds of the time constant of the servo that turns the crank."""

LONGEST_FOR_ACCELERATIONS = 5e-6
"""Longest step [s] of runs that tell accelerations, in which free pins rolling in their play have their part.

Against 0.5 us, on the paper's free pins at the rated load, accelerations up to 10 kHz are 7 % (centre of the gear) and
9 % (output) low, the rms of the velocity of q 2 %; at 25 us 22, 32 and 3 %. At 0.5 us they are 19, 4 and 13 % below
MuJoCo's at 1 us, whose cone is not the cause; the damping of implicit Euler steps may be.
"""

STEPS_OF_SWING = 5.5
"""Fewest steps in a swing of what turns on all contacts.

At 33 us, against 1 us at the rated load, all means of pin, nonpin, twodisc and printed are right to 0.001 %, peaks to
peak of the transmission error to 0.5 %; rms of the gear's speed are 5 % low with free pins and 1 to 3 % high without.
"""

MOST_ROUNDS = 100
"""Rounds after which a step ends whatever its contacts do, in which they press, creep or slide in other ways."""

ACCURACY = StepAccuracy(
    "means within 0.1 %, peaks to peak within 1 %; rms of speeds within 10 %, as moving pins chatter",
    "means within 0.1 %; no peaks and no rms of speeds, which the inertia of pins has its part in",
    "means within 0.1 %, peaks to peak within 1 % and rms of speeds within 4 %",
)
"""Against a tenth of the step."""


def chosen(reducer: Reducer) -> Step:
    """Choose the time step of a design's planar runs: ``settings.timestep``, or the longest that is short enough."""
    design = reducer.design
    if design.settings.timestep:
        return Step(design.settings.timestep, "given")
    allowed = {
        "the longest that is taken": LONGEST,
        "a sample at every step": 1.0 / design.settings.log_rate,
        "the swing on all contacts": swing_period(reducer) / STEPS_OF_SWING,
    }
    if design.drive.speed:
        allowed["the passing of teeth"] = passing_limit(reducer)
    return whole_in_samples(design.settings.log_rate, allowed)
