"""Extent of the computation, and the conditions of the runs, which are equal for both designs."""

import math
from dataclasses import dataclass

from cycloid_mj.base.result import Condition, Range
from cycloid_mj.comparison import SWEEP, Variation, independent_starts, settling_time, with_play_of
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class PaperSampling:
    """Sampling and starts of the runs."""

    per_turn: int = 360
    """Samples of a crank turn in the figures: one for each degree, 0.000101626 s at 1640 rpm (the paper's)."""
    logged: int = 2
    """Samples logged for each sample in the figures; vibration and stress need more."""
    steps: int = 17
    """Time steps per logged sample, 2.989 us each: samples are at full and half degrees. At least one design allows no
    longer step in some run (`dynamics.timestep`)."""
    starts: int = 12
    """Independent starts of each design without load, three tooth pitches apart: one more than the rank test needs to
    detect, with a power of 0.9, a difference that nine of ten pairs of starts show (`verdicts.starts_needed`)."""
    spare: int = 3
    """Samples after the last turn, so that it is complete."""


SAMPLES = PaperSampling()


@dataclass(frozen=True)
class Plan:
    """Extent of the computation."""

    quick: bool
    """Whether stress and torque use coarser grids and shorter averages."""
    steps: int
    """Time steps per logged sample."""
    turns: int
    varied_turns: int
    finer_turns: int
    """Settled crank turns of the main runs, of each run of the sweep, and of the runs with half the step (0: none)."""
    varied_starts: int
    """Independent starts of each run without load in the sweep, and of those with half the step; the main runs have
    `SAMPLES.starts`. With fewer than 6, the rank test detects only starts that do not overlap; with 3, nothing."""
    ramp: bool
    """Whether the ramp of 1 s is simulated for Fig. 5."""
    solver: Solver = "planar"
    """Solver of the independent starts and of the variations. The runs of the figures, and the rated runs for stress
    and torque, use MuJoCo."""


PAIRS = ("pin_gear", "pin_socket", "tooth", "cam", "output")
CREEP_SPEED = 0.02
"""Creep speed [m/s] at one end of the searched range; parts slide at 0.01 to 0.36 m/s."""

IMPACT = Variation("contact law", "IMPACT", ('contact.law="impact"',))
"""The default contact of motion solvers, which the authors may have used."""

TIGHT = Variation("clearance", "0.1 um", tuple(f"clearance.{pair}_um=0.1" for pair in PAIRS))
"""A tenth of the clearance, as an approximation of no clearance."""

MORE = (
    Variation("creep speed", "1 mm/s", ("contact.creep_speed_mm_s=1.0",)),
    Variation("stiffness", "half", ("material.youngs_modulus_mpa=105000.0",)),
    Variation("clearance", "2 um", tuple(f"clearance.{pair}_um=2.0" for pair in PAIRS)),
)
"""Further variations of the full sweep; parts are rigid except at their contacts, so that Young's modulus determines
only their stiffness.
"""

QUICK_SWEEP = (("friction", "0.0"), ("pins", "fixed"))
"""Variations of a quick sweep in addition to contact law and clearance."""

LEFT_OPEN = ("damping", "friction", "creep speed", "stiffness", "contact law")
"""Parameters of the sweep that the paper leaves open; it states the clearance, and that its pins are free."""

RANGES = (
    Range("friction.pin_gear, pin_socket, tooth", 0.0, 0.05, "1", "a model without friction to lubricated steel"),
    Range("contact.law", 0.0, 1.0, "line or impact", "line contacts of steel, or the default of motion solvers"),
)
"""What the paper leaves open of its motion without load, with the range of the quick sweep."""

MORE_RANGES = (
    Range("contact.damping_ratio", 0.1, 1.0, "of critical", "from dry steel to a full film"),
    Range("friction.pin_gear, pin_socket, tooth", 0.0, 0.1, "1", "a model without friction to boundary lubrication"),
    Range("contact.creep_speed_mm_s", 1.0, 20.0, "mm/s", "what regularises friction"),
    Range("material.youngs_modulus_mpa", 105e3, 210e3, "N/mm2", "contacts half as stiff as steel"),
)
"""Additional or wider ranges of the full sweep."""

QUICK_CHORD_ERRORS = (0.0, 50e-6)
CHORD_ERRORS = (0.0, 2e-6, 10e-6, 20e-6, 50e-6, 100e-6)
"""Chord errors of the flanks' facets, starting with exact flanks [m]."""

QUICK = Plan(
    quick=True, steps=SAMPLES.steps, turns=1, varied_turns=1, finer_turns=0, varied_starts=SAMPLES.starts, ramp=False
)
FULL = Plan(False, 2 * SAMPLES.steps, turns=4, varied_turns=2, finer_turns=2, varied_starts=SAMPLES.starts, ramp=True)


def designs() -> tuple[Design, Design]:
    """Return the paper's two designs, pin and nonpin, with `CREEP_SPEED`."""
    pin, nonpin = (PRESETS[name].but(contact={"creep_speed": CREEP_SPEED}) for name in ("pin", "nonpin"))
    return pin, nonpin


def loads() -> tuple[float, float]:
    """Return the load torques of the runs [N m]: none, and the torque without losses, 36.68."""
    first = PRESETS["pin"]
    return 0.0, round(first.drive.torque * first.lobes, 9)


def no_load() -> Condition:
    """Return the condition of the paper's motion and stress (sections 3.1 and 3.3: "no-load running")."""
    return Condition(0.0, PRESETS["pin"].drive.speed)


def torque_test() -> Condition:
    """Return the condition of the paper's torque test: the rated torque on the crank, the load that follows from it."""
    first = PRESETS["pin"]
    return Condition(loads()[1], first.drive.speed, first.drive.torque)


def at_speed(design: Design, load: float, turns: int, steps: int = SAMPLES.steps) -> Design:
    """Return a design that starts at full speed under `load` [N m], and runs for `turns` settled turns.

    There are `steps` time steps per logged sample. Both kinds of ring use the settling time of the slower.
    """
    sample = 2 * math.pi / abs(design.drive.speed) / (SAMPLES.per_turn * SAMPLES.logged)
    sampling = {"timestep": sample / steps, "log_rate": 1.0 / sample}
    design = design.but(drive={"ramp": 0.0}, load={"torque": load}, settings=sampling)
    slower = max(settling_time(Reducer(design.but(ring={"kind": kind}))) for kind in ("pin", "nonpin"))
    return design.steady(slower, turns, samples=SAMPLES.spare)


def ramp_run(plan: Plan, design: Design) -> Design:
    """Return a design with the paper's ramp and one settled turn, without load, at the paper's sampling."""
    short = at_speed(design, 0.0, 1, plan.steps)
    rate = short.settings.log_rate / SAMPLES.logged
    return short.but(drive={"ramp": design.drive.ramp}, settings={"log_rate": rate})


def main_runs(plan: Plan) -> list[Design]:
    """List the designs of the main runs: load by load, pin and nonpin."""
    return [at_speed(design, load, plan.turns, plan.steps) for load in loads() for design in designs()]


def idle_runs(plan: Plan, design: Design) -> list[Design]:
    """List the independent starts of a design without load; the first equals its main run."""
    return list(independent_starts(Reducer(at_speed(design, 0.0, plan.turns, plan.steps)), SAMPLES.starts))


def equal_play_design() -> Design:
    """Return the third design of the rated runs: nonpin with the pin design's total play and series stiffness there."""
    pin, nonpin = designs()
    return with_play_of(Reducer(nonpin), Reducer(pin.but(load={"torque": loads()[1]})))


def rated_runs(plan: Plan) -> list[Design]:
    """List the main runs under the rated load: pin, nonpin, and nonpin with the play and stiffness of pin."""
    return [at_speed(design, loads()[1], plan.turns, plan.steps) for design in (*designs(), equal_play_design())]


def finer_idle_runs(plan: Plan, design: Design) -> list[Design]:
    """List some idle starts with half the step, or none."""
    turns, count = plan.finer_turns, plan.varied_starts
    return list(independent_starts(Reducer(at_speed(design, 0.0, turns, 2 * plan.steps)), count)) if turns else []


def finer_rated_runs(plan: Plan) -> list[Design]:
    """List the rated runs with half the step, or none."""
    turns, steps = plan.finer_turns, 2 * plan.steps
    return [at_speed(design, loads()[1], turns, steps) for design in designs()] if turns else []


def variations(plan: Plan) -> tuple[Variation, ...]:
    """List what the sweep varies, one at a time."""
    if not plan.quick:
        return (*SWEEP, IMPACT, TIGHT, *MORE)
    return (*(variation for variation in SWEEP if (variation.parameter, variation.value) in QUICK_SWEEP), IMPACT, TIGHT)


def open_parameters(plan: Plan) -> tuple[str, ...]:
    """List what the paper leaves open of its motion without load and the sweep does not vary."""
    searched = {variation.parameter for variation in variations(plan)}
    return tuple(parameter for parameter in LEFT_OPEN if parameter not in searched)


def ranges(plan: Plan) -> tuple[Range, ...]:
    """List the ranges that the sweep searches of what the paper leaves open."""
    return RANGES if plan.quick else (*RANGES, *MORE_RANGES)


def chord_errors(plan: Plan) -> tuple[float, ...]:
    """List the chord errors of the flanks' facets in the search over treatments of contact [m]."""
    return QUICK_CHORD_ERRORS if plan.quick else CHORD_ERRORS


def contact_ranges(plan: Plan) -> tuple[Range, ...]:
    """List the searched ranges of chord error and contact law, for the claims on the maximum stress (`hypothesis`)."""
    least, most = 1e6 * min(chord_errors(plan)), 1e6 * max(chord_errors(plan))
    laws = "line, IMPACT, IMPACT of steel"
    return (
        Range("chord error of the flanks' facets", least, most, "um", "exact flanks to a coarse tessellation"),
        Range("contact law on facets", 0.0, 2.0, laws, "as here; defaults of motion solvers"),
    )


def varied_idle_runs(plan: Plan, variation: Variation, design: Design) -> list[Design]:
    """List the starts of a design without load with one parameter varied; the main starts if it has no effect."""
    changed, count = variation.of(Reducer(design)), plan.varied_starts
    if changed == design:
        return idle_runs(plan, design)
    return list(independent_starts(Reducer(at_speed(changed, 0.0, plan.varied_turns, plan.steps)), count))


def varied_rated_runs(plan: Plan, variation: Variation) -> list[Design]:
    """List the rated runs with one parameter varied; the main run if it has no effect."""
    varied = []
    for design in designs():
        changed = variation.of(Reducer(design))
        turns = plan.turns if changed == design else plan.varied_turns
        varied.append(at_speed(changed, loads()[1], turns, plan.steps))
    return varied
