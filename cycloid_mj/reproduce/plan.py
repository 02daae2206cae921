"""How much is computed, and under which conditions the two designs run: the same for both."""

import math
from dataclasses import dataclass

from cycloid_mj.comparison import SWEEP, Variation, settling
from cycloid_mj.design import PRESETS, Design, override

SAMPLING = 360
"""Samples of a crank turn in the figures: one for each degree, 0.000101626 s at 1640 rpm (the paper's)."""

LOGGED = 2
"""Samples logged for each one in the figures: vibration and stress take more."""

STEPS = 51
"""Time steps from one logged sample to the next: 0.9963 us each, so that samples fall on whole and half degrees."""

SPARE = 3
"""Samples after the last turn, so that it is whole."""


@dataclass(frozen=True)
class Plan:
    """How much is computed.

    Attributes
    ----------
    quick
        Whether stress and torque take coarser grids and shorter averages.
    turns, varied_turns, finer_turns
        Settled crank turns of the main runs, of each run of the sweep, and of the runs with half the step (0: none).
    ramp
        Whether the real ramp of 1 s is run for Fig. 5.
    """

    quick: bool
    turns: int
    varied_turns: int
    finer_turns: int
    ramp: bool


PAIRS = ("pin_gear", "pin_socket", "tooth", "cam", "output")
MORE = (
    Variation("stiffness", "half", ("material.youngs_modulus_mpa=105000.0",)),
    Variation("clearance", "2 um", tuple(f"clearance.{pair}_um=2.0" for pair in PAIRS)),
)
"""What is varied beside damping, friction and the pins' freedom, unless quick; parts are rigid but at their contacts,
so that Young's modulus is the stiffness of these.
"""

QUICK = Plan(quick=True, turns=4, varied_turns=2, finer_turns=0, ramp=False)
FULL = Plan(quick=False, turns=6, varied_turns=6, finer_turns=6, ramp=True)


def designs() -> tuple[Design, Design]:
    """Give the paper's two designs, pin and nonpin."""
    return PRESETS["pin"], PRESETS["nonpin"]


def loads() -> tuple[float, float]:
    """Give the load torques of the runs [N m]: none, and the torque without losses, 36.68."""
    first = PRESETS["pin"]
    return 0.0, round(first.drive.torque * first.lobes, 9)


def at_speed(design: Design, load: float, turns: int, finer: int = 1) -> Design:
    """Give a design that runs from full speed until so many turns have settled, its step divided by `finer`."""
    turn = 2 * math.pi / abs(design.drive.speed)
    sample = turn / (SAMPLING * LOGGED)
    changes = [
        "drive.ramp_s=0.0",
        f"load.torque_nm={load!r}",
        f"settings.timestep_us={1e6 * sample / (STEPS * finer)!r}",
        f"settings.log_rate_hz={1.0 / sample!r}",
    ]
    design = override(design, changes)
    return override(design, [f"drive.hold_s={settling(design) + turns * turn + SPARE * sample!r}"])


def ramped(design: Design) -> Design:
    """Give a design with the paper's ramp and a settled turn after it, without load, at the paper's sampling."""
    short = at_speed(design, 0.0, 1)
    rate = short.settings.log_rate / LOGGED
    return override(short, [f"drive.ramp_s={design.drive.ramp!r}", f"settings.log_rate_hz={rate!r}"])


def main_runs(plan: Plan) -> list[Design]:
    """Give the designs of the main runs: load by load, pin and nonpin."""
    return [at_speed(design, load, plan.turns) for load in loads() for design in designs()]


def finer_runs(plan: Plan) -> list[Design]:
    """Give the main runs with half the step, or none."""
    turns = plan.finer_turns
    return [at_speed(design, load, turns, 2) for load in loads() for design in designs()] if turns else []


def variations(plan: Plan) -> tuple[Variation, ...]:
    """Give what the sweep varies, one at a time."""
    return SWEEP if plan.quick else (*SWEEP, *MORE)


def varied_runs(plan: Plan, variation: Variation) -> list[Design]:
    """Give the main runs with one parameter varied; what it does not concern stays the main run."""
    found = []
    for load in loads():
        for design in designs():
            changed = variation.of(design)
            found.append(at_speed(changed, load, plan.turns if changed == design else plan.varied_turns))
    return found
