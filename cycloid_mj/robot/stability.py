"""Time steps and integrators at which the joint is stable: run at each, with no, its own and a heavy inertia.

A step is stable if the joint vibrates no more than at its start, crank held and free; it is accurate if what the load
winds up to in an `impact` is right as well.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Table
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.robot.impact import impact, peak_of
from cycloid_mj.robot.reducer import LEVELS, Level, ReducedJoint
from cycloid_mj.robot.trial import INTEGRATORS, Integrator, TrialScene, bench

STEPS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3)
"""Time steps of the study [s]."""

FINER = (5e-5, 2e-5)
"""Those that follow, one after the other, where the shortest of `STEPS` is not accurate."""

USUAL = 1e-3
"""Step of a scene [s], if it is accurate."""

INERTIAS = {"bare output": 1e-3, "matched": 1.0, "heavy": 10.0}
"""Inertias on the output, as shares of what the reducer itself has there with its crank free."""

PERIODS, FEWEST = 8.0, 60
"""Length of a run in periods of the joint's vibration, and its steps at least."""

START = 0.8
"""Where the vibration starts, in wind-ups under the rated torque: about the rated torque, on the joint's last slope."""

GROWN = 1.0
"""A vibration of as many wind-ups, two and a half times that of the start, has grown by the integrator's own energy."""

LEFT = 1e-3
"""A vibration smaller than this share of the wind-up has died away."""

WOUND_UP = 0.01
"""Largest relative error of the wind-up at which static values are right."""

ACCURATE = 0.05
"""Largest relative error of the peak of an impact at which a step is accurate."""


@dataclass(frozen=True)
class Tried:
    """One step of one integrator with one inertia.

    Attributes
    ----------
    level, integrator, load
        What was run; the load is a key of `INERTIAS`, or its value in words.
    timestep, inertia
        [s], and on the output [kg m2].
    stable
        Whether it stays within what the torque can do.
    error
        Of the wind-up under the rated torque; of the speed under the rated input torque at the level `rigid` [1].
        Not a number where it is unstable.
    frequency
        Of its vibration over sqrt(k/J) less 1; not a number where too few steps resolve it, or none is left.
    impact_frequency
        Of the load of the impact [Hz]; not a number at the level `rigid`, which has none.
    impact_peak, impact_error
        Wind-up beyond the stop that the impact ends in [rad], and its relative error; not a number where it runs away.
    """

    level: Level
    integrator: Integrator
    load: str
    timestep: float
    inertia: float
    stable: bool
    error: float
    frequency: float
    impact_frequency: float = math.nan
    impact_peak: float = math.nan
    impact_error: float = math.nan

    @property
    def good(self) -> bool:
        """Whether it is stable and the static values are right."""
        return self.stable and abs(self.error) <= WOUND_UP

    @property
    def accurate(self) -> bool:
        """Whether it is good and gets an impact right; at the level `rigid` there is none."""
        return self.good and (self.level == "rigid" or abs(self.impact_error) <= ACCURATE)

    @property
    def words(self) -> str:
        """What to say of it in a table."""
        if not self.stable:
            return "unstable"
        if not self.good:
            return f"off by {100.0 * self.error:+.1f} %"
        return "stable" if self.level == "rigid" else f"{100.0 * self.impact_error:+.1f} %"

    @property
    def sentence(self) -> str:
        """What to say of it alone."""
        if not self.good or self.level == "rigid":
            return self.words
        return (
            f"peak of an impact at {self.impact_frequency:g} Hz under the rated load off by "
            f"{100.0 * self.impact_error:+.1f} % ({self.impact_peak / ARCMINUTE:.4g} arcmin of wind-up)"
        )

    def as_json(self) -> dict[str, Any]:
        """Convert it to JSON values."""
        return {
            "level": self.level,
            "integrator": self.integrator,
            "load": self.load,
            "inertia_kg_m2": self.inertia,
            "timestep_s": self.timestep,
            "stable": self.stable,
            "accurate": self.accurate,
            "static_error": self.error,
            "frequency_error": self.frequency,
            "impact_hz": self.impact_frequency,
            "impact_wind_up_arcmin": self.impact_peak / ARCMINUTE,
            "impact_error": self.impact_error,
        }


def study(reduced: ReducedJoint) -> tuple[Tried, ...]:
    """Try every level, integrator and inertia at `STEPS`, and at `FINER` ones where none of these is accurate."""
    return tuple(_all(reduced))


def scene(
    reduced: ReducedJoint,
    inertia: float,
    timestep: float | None = None,
    integrators: Sequence[Integrator] = ("implicitfast", "discrete"),
) -> Tried:
    """Try the step [s] of a scene with an inertia on the output [kg m2], or choose it if it is None.

    Chosen is the longest accurate step of up to `USUAL`, of the integrators the first that has it; where no step is
    accurate, the stable one with the smallest error.
    """
    shorter = (*(step for step in reversed(STEPS) if step <= USUAL), *FINER)
    runs = []
    for step in shorter if timestep is None else (timestep,):
        for integrator in integrators:
            runs.append(tried(reduced, integrator, step, inertia))
            if runs[-1].accurate:
                return runs[-1]
    return min(runs, key=lambda one: (not one.stable, not one.good, abs(np.nan_to_num(one.impact_error, nan=np.inf))))


def tried(
    reduced: ReducedJoint, integrator: Integrator, timestep: float, inertia: float, load: str = "as asked for"
) -> Tried:
    """Try one step [s] of an integrator with an inertia on the output [kg m2], at the reducer's level."""

    def on() -> TrialScene:
        return bench(reduced, inertia, timestep, integrator)

    run = reduced.level, integrator, load, timestep, inertia
    if reduced.level == "rigid":
        return Tried(*run, *_rigid(on(), inertia))
    struck = impact(reduced, inertia)
    stable, error, frequency = vibration(on(), inertia)
    peak = peak_of(on(), struck) if stable and _stays(on(), inertia) else None
    if peak is None:
        return Tried(*run, False, math.nan, math.nan, struck.frequency)
    return Tried(*run, True, error, frequency, struck.frequency, peak, peak / struck.peak - 1.0)


def longest(tried: Iterable[Tried], level: Level, integrator: Integrator, load: str) -> Tried | None:
    """Return the longest step up to which every one that was tried is accurate; None where none is."""
    steps = [one for one in tried if (one.level, one.integrator, one.load) == (level, integrator, load)]
    best = None
    for step in sorted(steps, key=lambda one: one.timestep):
        if step.accurate:
            best = step
        elif best is not None:
            break
    return best


def recommended(tried: tuple[Tried, ...]) -> list[dict[str, Any]]:
    """List the longest accurate step [s] of each integrator at each level: with any inertia, and with each; 0 is none.

    `impact_error` is the relative error of the peak of an impact at the step of each inertia.
    """
    rows = []
    for level in LEVELS:
        for integrator in INTEGRATORS:
            best = {load: longest(tried, level, integrator, load) for load in INERTIAS}
            by_load = {load: one.timestep if one else 0.0 for load, one in best.items()}
            errors = {load: one.impact_error if one else math.nan for load, one in best.items()}
            rows.append(
                {
                    "level": level,
                    "integrator": integrator,
                    "timestep_s": min(by_load.values()),
                    "by_load": by_load,
                    "impact_error": errors,
                }
            )
    return rows


def recommended_table(tried: tuple[Tried, ...]) -> Table:
    """Tabulate the same: a row for each level and integrator, a column for each inertia."""
    rows = []
    for level in LEVELS:
        for integrator in INTEGRATORS:
            best = [longest(tried, level, integrator, load) for load in INERTIAS]
            cells = (f"{1e3 * one.timestep:g} ms: {one.words}" if one else "none" for one in best)
            rows.append((f"{level}, {integrator}", *cells))
    title = f"Longest step at which the peak of an impact is right within {ACCURATE:.0%}, and its error"
    return Table(title, ("level, integrator", *INERTIAS), tuple(rows))


def table(tried: tuple[Tried, ...]) -> Table:
    """Tabulate the study: a row for each level, integrator and inertia, a column for each step."""
    rows: dict[str, dict[float, str]] = {}
    for one in tried:
        struck = "" if one.level == "rigid" else f", {one.impact_frequency:g} Hz"
        rows.setdefault(f"{one.level}, {one.integrator}, {one.load}{struck}", {})[one.timestep] = one.words
    steps = sorted({one.timestep for one in tried})
    cells = tuple((key, *(words.get(step, "") for step in steps)) for key, words in rows.items())
    header = ("level, integrator, inertia on the output, load", *(f"{1e3 * step:g} ms" for step in steps))
    return Table("Error of the peak of an impact by step, crank held, load rated cos(2 pi f t)", header, cells)


def vibration(on: TrialScene, inertia: float) -> tuple[bool, float, float]:
    """Put the rated torque on the output at once, the crank held; read where it comes to rest and how it vibrates.

    The result is whether it is stable, the relative error of the wind-up, and of the frequency against sqrt(k/J).
    """
    reduced, step = on.reduced, float(on.model.opt.timestep)
    torque, moving = reduced.rated_torque, inertia + reduced.output_inertia
    slowest = np.sqrt(reduced.stiffness(torque) / moving)
    steps = _steps(slowest, step)
    wound, stop = reduced.wind_up(torque), reduced.stops[1]
    if reduced.level == "full":
        stop += reduced.ripple.errors(0.0, 1.0)[1]
    on.hold()
    on.data.qpos[on.place.output_angle] = stop + START * wound
    lengths = on.lengths(lambda time: torque, steps)
    if lengths is None or float(np.ptp(lengths[steps // 2 :])) > GROWN * wound:
        return False, np.nan, np.nan
    rest, frequency = _vibration(lengths[steps // 2 :] - stop, step)
    error = rest / wound - 1.0
    if abs(error) > WOUND_UP:
        error = _left_at_rest(on, steps, stop)
    return True, error, frequency / slowest - 1.0


def _left_at_rest(on: TrialScene, steps: int, stop: float) -> float:
    """Find the relative error of the wind-up where the output starts from its rest under the rated torque.

    Transmission error that changes with the load bends the spring, and the middle of a vibration on it is not its rest.
    """
    torque = on.reduced.rated_torque
    mujoco.mj_resetData(on.model, on.data)
    on.hold()
    on.press(torque)
    lengths = on.lengths(lambda time: torque, steps)
    if lengths is None:
        return math.nan
    return (float(lengths[steps // 2 :].mean()) - stop) / on.reduced.wind_up(torque) - 1.0


def _all(reduced: ReducedJoint) -> Iterator[Tried]:
    for level in LEVELS:
        for integrator in INTEGRATORS:
            for load, share in INERTIAS.items():
                yield from _by_step(reduced.at(level), integrator, load, share * reduced.reflected_inertia)


def _by_step(reduced: ReducedJoint, integrator: Integrator, load: str, inertia: float) -> Iterator[Tried]:
    """Try `STEPS`, and if the shortest is not accurate `FINER` ones until one is."""
    runs = [tried(reduced, integrator, step, inertia, load) for step in STEPS]
    yield from runs
    if runs[0].accurate:
        return
    for step in FINER:
        run = tried(reduced, integrator, step, inertia, load)
        yield run
        if run.accurate:
            return


def _stays(on: TrialScene, inertia: float) -> bool:
    """Tell whether the joint vibrates no more than at the start with its crank free, the motor holding the torque.

    Crank and output move against each other then, faster than the output alone: k (1/J + 1/(i^2 J_rotor)).
    """
    reduced, torque = on.reduced, on.reduced.rated_torque
    wound, moving = reduced.wind_up(torque), inertia + reduced.output_inertia
    swinging = moving / (1.0 + moving / (reduced.ratio**2 * reduced.rotor_inertia))
    steps = _steps(np.sqrt(reduced.stiffness(torque) / swinging), float(on.model.opt.timestep))
    on.press(torque)
    on.data.qpos[on.place.output_angle] -= (1.0 - START) * wound
    on.data.ctrl[:] = reduced.coefficient * torque
    lengths = on.lengths(lambda time: torque, steps)
    return lengths is not None and float(np.ptp(lengths[steps // 2 :])) <= GROWN * wound


def _steps(frequency: float, step: float) -> int:
    """Count the steps of a run in which a vibration of this frequency [rad/s] is seen."""
    return max(FEWEST, math.ceil(2.0 * np.pi * PERIODS / frequency / step))


def _rigid(on: TrialScene, inertia: float) -> tuple[bool, float, float]:
    """Put the rated input torque on the motor; the speed is that of the whole inertia less its friction."""
    reduced, step = on.reduced, float(on.model.opt.timestep)
    on.data.ctrl[:] = reduced.rated_torque / reduced.ratio
    for _ in range(FEWEST):
        on.step()
    whole = inertia + reduced.reflected_inertia
    spare = reduced.rated_torque - float(on.model.dof_frictionloss[on.place.output_speed])
    speed = reduced.way * float(on.data.qvel[on.place.output_speed])
    error = speed / (spare / whole * FEWEST * step) - 1.0
    return bool(np.isfinite(error)), error, np.nan


def _vibration(turn: Array, step: float) -> tuple[float, float]:
    """Compute the place about which a vibration goes, and its circular frequency [rad/s], if there is one."""
    middle = 0.5 * (float(turn.max()) + float(turn.min()))
    if np.ptp(turn) < LEFT * abs(middle):
        return float(turn[-1]), np.nan
    above = turn > middle
    ups = np.flatnonzero(~above[:-1] & above[1:])
    if len(ups) < 3 or (ups[-1] - ups[0]) / (len(ups) - 1) < 8.0:
        return float(turn[-len(turn) // 2 :].mean()), np.nan
    crossings = ups + (middle - turn[ups]) / (turn[ups + 1] - turn[ups])
    whole = slice(int(ups[0]), int(ups[-1]))
    return float(turn[whole].mean()), 2.0 * np.pi * (len(ups) - 1) / float(crossings[-1] - crossings[0]) / step
