"""Which time steps and integrators the joint bears: run at each, with nothing, its own and a heavy inertia on it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.result import Table
from cycloid_mj.robot.reducer import LEVELS, Level, Reducer
from cycloid_mj.robot.trial import INTEGRATORS, Bench, Integrator, bench
from cycloid_mj.types import Array

STEPS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3)
"""Time steps of the study [s]."""

INERTIAS = {"bare output": 1e-3, "matched": 1.0, "heavy": 10.0}
"""Inertias on the output, as shares of what the reducer itself has there with its crank free."""

PERIODS, FEWEST, MOST = 10.0, 60, 4000
"""Length of a run in periods of the joint's vibration, and its steps at least and at most."""

START = 0.8
"""Where the vibration starts, in wind-ups under the rated torque: about the rated torque, on the joint's last slope."""

GROWN = 1.0
"""A vibration of as many wind-ups, two and a half times that of the start, has grown by the integrator's own energy."""

LEFT = 1e-3
"""A vibration smaller than this share of the wind-up has died away."""

WOUND_UP = 0.01
"""Largest relative error of the wind-up at which a step is good."""


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
    """

    level: Level
    integrator: Integrator
    load: str
    timestep: float
    inertia: float
    stable: bool
    error: float
    frequency: float

    @property
    def good(self) -> bool:
        """Whether it is stable and the static values are right."""
        return self.stable and abs(self.error) <= WOUND_UP

    @property
    def words(self) -> str:
        """What to say of it in a table."""
        if not self.stable:
            return "unstable"
        if not self.good:
            return f"off by {100.0 * self.error:+.1f} %"
        return "stable" if np.isnan(self.frequency) else f"f {100.0 * self.frequency:+.1f} %"

    def as_json(self) -> dict[str, Any]:
        """Give it for a program."""
        return {
            "level": self.level,
            "integrator": self.integrator,
            "load": self.load,
            "inertia_kg_m2": self.inertia,
            "timestep_s": self.timestep,
            "stable": self.stable,
            "static_error": self.error,
            "frequency_error": self.frequency,
        }


def study(reducer: Reducer) -> tuple[Tried, ...]:
    """Try every level, integrator, inertia and step."""
    return tuple(_all(reducer))


def tried(
    reducer: Reducer, integrator: Integrator, timestep: float, inertia: float, load: str = "as asked for"
) -> Tried:
    """Try one step [s] of an integrator with an inertia on the output [kg m2], at the reducer's level."""

    def on() -> Bench:
        return bench(reducer, inertia, timestep, integrator)

    if reducer.level == "rigid":
        stable, error, frequency = _rigid(on(), inertia)
    else:
        stable, error, frequency = _wound_up(on(), inertia)
        stable = stable and _stays(on(), inertia)
    return Tried(reducer.level, integrator, load, timestep, inertia, stable, error, frequency)


def longest(found: tuple[Tried, ...], level: Level, integrator: Integrator, load: str) -> float:
    """Give the longest step up to which every step was good; 0 where none is."""
    steps = [one for one in found if (one.level, one.integrator, one.load) == (level, integrator, load)]
    good = 0.0
    for one in sorted(steps, key=lambda one: one.timestep):
        if not one.good:
            break
        good = one.timestep
    return good


def recommended(found: tuple[Tried, ...]) -> list[dict[str, Any]]:
    """Give the longest good step [s] of each integrator at each level: with any inertia, and with each; 0 is none."""
    return [
        {
            "level": level,
            "integrator": integrator,
            "timestep_s": min(by_load.values()),
            "by_load": by_load,
        }
        for level in LEVELS
        for integrator in INTEGRATORS
        for by_load in [{load: longest(found, level, integrator, load) for load in INERTIAS}]
    ]


def recommended_table(found: tuple[Tried, ...]) -> Table:
    """Give the same as a table: a row for each level and integrator, a column for each inertia."""
    rows = [
        (
            f"{one['level']}, {one['integrator']}",
            *(f"{1e3 * step:g} ms" if step else "none" for step in one["by_load"].values()),
        )
        for one in recommended(found)
    ]
    return Table("Longest good step by inertia on the output", ("level, integrator", *INERTIAS), tuple(rows))


def table(found: tuple[Tried, ...]) -> Table:
    """Give the study as a table: a row for each level, integrator and inertia, a column for each step."""
    rows: dict[tuple[str, str, str], list[str]] = {}
    for one in found:
        rows.setdefault((one.level, one.integrator, one.load), []).append(one.words)
    header = ("level, integrator, inertia on the output", *(f"{1e3 * step:g} ms" for step in STEPS))
    return Table("Steps", header, tuple((", ".join(key), *words) for key, words in rows.items()))


def _all(reducer: Reducer) -> Iterator[Tried]:
    for level in LEVELS:
        for integrator in INTEGRATORS:
            for load, share in INERTIAS.items():
                inertia = share * reducer.reflected_inertia
                for step in STEPS:
                    yield tried(reducer.at(level), integrator, step, inertia, load)


def _wound_up(on: Bench, inertia: float) -> tuple[bool, float, float]:
    """Put the rated torque on the output at once, the crank held; read where it comes to rest and how it vibrates."""
    reducer, step = on.reducer, float(on.model.opt.timestep)
    torque, moving = reducer.rated_torque, inertia + reducer.output_inertia
    slowest = np.sqrt(reducer.stiffness(torque) / moving)
    steps = _steps(slowest, step)
    wound, stop = reducer.wind_up(torque), reducer.stops[1]
    if reducer.level == "full":
        stop += reducer.ripple.errors(0.0, 1.0)[1]
    on.hold()
    on.data.qpos[on.place.output_angle] = stop + START * wound
    lengths = on.lengths(lambda time: torque, steps)
    if lengths is None or float(np.ptp(lengths[steps // 2 :])) > GROWN * wound:
        return False, np.nan, np.nan
    rest, frequency = _vibration(lengths[steps // 2 :] - stop, step)
    return True, rest / wound - 1.0, frequency / slowest - 1.0


def _stays(on: Bench, inertia: float) -> bool:
    """Tell whether the joint vibrates no more than at the start with its crank free, the motor holding the torque.

    Crank and output move against each other then, faster than the output alone: k (1/J + 1/(i^2 J_rotor)).
    """
    reducer, torque = on.reducer, on.reducer.rated_torque
    wound, moving = reducer.wind_up(torque), inertia + reducer.output_inertia
    swinging = moving / (1.0 + moving / (reducer.ratio**2 * reducer.rotor_inertia))
    steps = _steps(np.sqrt(reducer.stiffness(torque) / swinging), float(on.model.opt.timestep))
    on.press(torque)
    on.data.qpos[on.place.output_angle] -= (1.0 - START) * wound
    on.data.ctrl[:] = reducer.coefficient * torque
    lengths = on.lengths(lambda time: torque, steps)
    return lengths is not None and float(np.ptp(lengths[steps // 2 :])) <= GROWN * wound


def _steps(frequency: float, step: float) -> int:
    """Count the steps of a run in which a vibration of this frequency [rad/s] is seen."""
    return int(np.clip(2.0 * np.pi * PERIODS / frequency / step, FEWEST, MOST))


def _rigid(on: Bench, inertia: float) -> tuple[bool, float, float]:
    """Put the rated input torque on the motor; the speed is that of the whole inertia less its friction."""
    reducer, step = on.reducer, float(on.model.opt.timestep)
    on.data.ctrl[:] = reducer.rated_torque / reducer.ratio
    for _ in range(FEWEST):
        on.step()
    whole = inertia + reducer.reflected_inertia
    given = reducer.rated_torque - float(on.model.dof_frictionloss[on.place.output_speed])
    speed = reducer.way * float(on.data.qvel[on.place.output_speed])
    error = speed / (given / whole * FEWEST * step) - 1.0
    return bool(np.isfinite(error)), error, np.nan


def _vibration(turn: Array, step: float) -> tuple[float, float]:
    """Give the place about which a vibration goes, and its circular frequency [rad/s], if there is one."""
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
