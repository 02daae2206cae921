"""Time steps and integrators at which the joint is stable and accurate, with no, a matched and a heavy inertia.

A time step is stable if a vibration does not grow, with the crank locked and free. It is accurate if the peak
wind-up of an impact (`robot.impact`) is correct as well.
"""

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Table
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.robot.impact import run_impact, solve_impact
from cycloid_mj.robot.reducer import LEVELS, Level, ReducedJoint
from cycloid_mj.robot.trial import INTEGRATORS, Integrator, TrialScene, trial_scene


@dataclass(frozen=True)
class StabilitySettings:
    """Time steps of the study, and its criteria."""

    steps: tuple[float, ...] = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3)
    """Time steps of the study [s]."""
    finer_steps: tuple[float, float] = (5e-5, 2e-5)
    """Time steps that follow, one after the other, where the shortest of `steps` is not accurate [s]."""
    max_scene_step: float = 1e-3
    """Largest time step of a scene [s]."""
    periods: float = 8.0
    min_steps: int = 60
    """Length of a run in periods of the joint's vibration, and its smallest number of time steps."""
    start: float = 0.8
    """Start of the vibration, over the wind-up under the nominal torque: it stays on the last slope of the joint."""
    max_vibration: float = 1.0
    """Range of a vibration over the wind-up, 2.5 times that of the start, from which the integrator has added
    energy."""
    min_vibration: float = 1e-3
    """Range of a vibration over the wind-up below which it has decayed."""
    static_rtol: float = 0.01
    """Allowed relative error of the static wind-up."""
    impact_rtol: float = 0.05
    """Allowed relative error of the peak of an impact."""


STUDY = StabilitySettings()


INERTIAS = {"bare output": 1e-3, "matched": 1.0, "heavy": 10.0}
"""Inertias on the output, relative to the reducer's own there with its crank free."""


@dataclass(frozen=True)
class StepTrial:
    """Trial of one time step of an integrator with one inertia."""

    level: Level
    integrator: Integrator
    load: str
    """Level, integrator, and the key of `INERTIAS` or the inertia in words."""
    timestep: float
    inertia: float
    """Time step [s], and inertia on the output [kg m2]."""
    stable: bool
    """Whether the vibration does not grow."""
    error: float
    """Relative error of the wind-up under the nominal torque; at the level `rigid`, of the speed under the rated input
    torque. NaN where it is unstable."""
    frequency: float
    """Relative error of the vibration's frequency against sqrt(k/J); NaN where it is not resolved, or decayed."""
    impact_frequency: float = math.nan
    """Frequency of the load of the impact [Hz]; NaN at the level `rigid`, which has none."""
    impact_peak: float = math.nan
    impact_error: float = math.nan
    """Wind-up beyond the stop at the end of the impact [rad], and its relative error; NaN where it runs away."""

    @property
    def good(self) -> bool:
        """True if it is stable and its static values are correct."""
        return self.stable and abs(self.error) <= STUDY.static_rtol

    @property
    def accurate(self) -> bool:
        """True if the impact is correct as well; at the level `rigid` there is none."""
        return self.good and (self.level == "rigid" or abs(self.impact_error) <= STUDY.impact_rtol)

    @property
    def summary(self) -> str:
        """Summary for a table."""
        if not self.stable:
            return "unstable"
        if not self.good:
            return f"static error {100.0 * self.error:+.1f} %"
        return "stable" if self.level == "rigid" else f"{100.0 * self.impact_error:+.1f} %"

    @property
    def sentence(self) -> str:
        """Summary as a sentence."""
        if not self.good or self.level == "rigid":
            return self.summary
        return (
            f"peak of an impact at {self.impact_frequency:g} Hz under the rated load: error "
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


def study_time_steps(reduced: ReducedJoint) -> tuple[StepTrial, ...]:
    """Try all levels, integrators and inertias at `STUDY.steps`, and at `STUDY.finer_steps` where none is accurate."""
    trials: list[StepTrial] = []
    for level, integrator in itertools.product(LEVELS, INTEGRATORS):
        for load, share in INERTIAS.items():
            trials += _try_time_steps(reduced.at(level), integrator, load, share * reduced.reflected_inertia)
    return tuple(trials)


def choose_time_step(
    reduced: ReducedJoint,
    inertia: float,
    timestep: float | None = None,
    integrators: Sequence[Integrator] = ("implicitfast", "discrete"),
) -> StepTrial:
    """Try the time step [s] of a scene with an inertia on the output [kg m2], or choose one if it is None.

    It is the longest accurate time step up to `STUDY.max_scene_step`, with the first of the integrators that has it.
    Where none is accurate, it is the stable one with the smallest error.
    """
    shorter = (*(item for item in reversed(STUDY.steps) if item <= STUDY.max_scene_step), *STUDY.finer_steps)
    runs = []
    for candidate in shorter if timestep is None else (timestep,):
        for integrator in integrators:
            runs.append(try_time_step(reduced, integrator, candidate, inertia))
            if runs[-1].accurate:
                return runs[-1]
    return min(
        runs, key=lambda item: (not item.stable, not item.good, abs(np.nan_to_num(item.impact_error, nan=np.inf)))
    )


def try_time_step(
    reduced: ReducedJoint, integrator: Integrator, timestep: float, inertia: float, load: str = "as requested"
) -> StepTrial:
    """Try one time step [s] of an integrator with an inertia on the output [kg m2], at the reducer's level."""

    def scene() -> TrialScene:
        return trial_scene(reduced, inertia, timestep, integrator)

    run = reduced.level, integrator, load, timestep, inertia
    if reduced.level == "rigid":
        return StepTrial(*run, *_accelerate_rigid_joint(scene(), inertia))
    load_case = solve_impact(reduced, inertia)
    stable, error, frequency = measure_vibration(scene(), inertia)
    peak = run_impact(scene(), load_case) if stable and _is_stable_with_free_crank(scene(), inertia) else None
    if peak is None:
        return StepTrial(*run, False, math.nan, math.nan, load_case.frequency)
    return StepTrial(*run, True, error, frequency, load_case.frequency, peak, peak / load_case.peak - 1.0)


def longest_accurate(trials: Iterable[StepTrial], level: Level, integrator: Integrator, load: str) -> StepTrial | None:
    """Return the longest time step up to which all trials are accurate; None where none is."""
    chosen = [item for item in trials if (item.level, item.integrator, item.load) == (level, integrator, load)]
    best = None
    for trial in sorted(chosen, key=lambda item: item.timestep):
        if trial.accurate:
            best = trial
        elif best is not None:
            break
    return best


def recommend_time_steps(trials: tuple[StepTrial, ...]) -> list[dict[str, Any]]:
    """List the longest accurate time step [s] by level and integrator, for any inertia and for each; 0 is none.

    `impact_error` is the relative error of the peak of an impact at the time step of each inertia.
    """
    rows = []
    for level in LEVELS:
        for integrator in INTEGRATORS:
            best = {load: longest_accurate(trials, level, integrator, load) for load in INERTIAS}
            by_load = {load: item.timestep if item else 0.0 for load, item in best.items()}
            errors = {load: item.impact_error if item else math.nan for load, item in best.items()}
            steps = {"timestep_s": min(by_load.values()), "by_load": by_load, "impact_error": errors}
            rows.append({"level": level, "integrator": integrator, **steps})
    return rows


def recommended_table(trials: tuple[StepTrial, ...]) -> Table:
    """Tabulate the recommended time steps: a row for each level and integrator, a column for each inertia."""
    rows = []
    for level in LEVELS:
        for integrator in INTEGRATORS:
            best = [longest_accurate(trials, level, integrator, load) for load in INERTIAS]
            cells = (f"{1e3 * item.timestep:g} ms: {item.summary}" if item else "none" for item in best)
            rows.append((f"{level}, {integrator}", *cells))
    title = f"Longest time step at which the peak of an impact is within {STUDY.impact_rtol:.0%}, and its error"
    return Table(title, ("level, integrator", *INERTIAS), tuple(rows))


def trials_table(trials: tuple[StepTrial, ...]) -> Table:
    """Tabulate all trials: a row for each level, integrator and inertia, a column for each time step."""
    rows: dict[str, dict[float, str]] = {}
    for item in trials:
        struck = "" if item.level == "rigid" else f", {item.impact_frequency:g} Hz"
        rows.setdefault(f"{item.level}, {item.integrator}, {item.load}{struck}", {})[item.timestep] = item.summary
    steps = sorted({item.timestep for item in trials})
    cells = tuple((key, *(words.get(step, "") for step in steps)) for key, words in rows.items())
    header = ("level, integrator, inertia on the output, load", *(f"{1e3 * step:g} ms" for step in steps))
    return Table("Error of the peak of an impact by time step, crank locked, rated load cos(2 pi f t)", header, cells)


def measure_vibration(scene: TrialScene, inertia: float) -> tuple[bool, float, float]:
    """Apply the nominal torque to the output suddenly with the crank locked, and measure its rest and vibration.

    Returns
    -------
    tuple
        Whether it is stable, relative error of the wind-up, and that of the frequency against sqrt(k/J).
    """
    reduced, step = scene.reduced, float(scene.model.opt.timestep)
    torque, moving = reduced.rated_torque, inertia + reduced.output_inertia
    slowest = np.sqrt(reduced.stiffness(torque) / moving)
    steps = _steps(slowest, step)
    wound, stop = reduced.wind_up(torque), reduced.stops[1]
    if reduced.level == "full":
        stop += reduced.ripple.errors(0.0, 1.0)[1]
    scene.hold()
    scene.data.qpos[scene.place.output_angle] = stop + STUDY.start * wound
    lengths = scene.lengths(lambda time: torque, steps)
    if lengths is None or float(np.ptp(lengths[steps // 2 :])) > STUDY.max_vibration * wound:
        return False, np.nan, np.nan
    rest, frequency = _analyse_vibration(lengths[steps // 2 :] - stop, step)
    error = rest / wound - 1.0
    if abs(error) > STUDY.static_rtol:
        error = _settled_wind_up_error(scene, steps, stop)
    return True, error, frequency / slowest - 1.0


def _settled_wind_up_error(scene: TrialScene, steps: int, stop: float) -> float:
    """Compute the relative error of the wind-up when the output is released from rest under the nominal torque.

    A transmission error that changes with the load makes the spring nonlinear: the middle of a vibration is not the
    rest.
    """
    torque = scene.reduced.rated_torque
    mujoco.mj_resetData(scene.model, scene.data)
    scene.hold()
    scene.press(torque)
    lengths = scene.lengths(lambda time: torque, steps)
    if lengths is None:
        return math.nan
    return (float(lengths[steps // 2 :].mean()) - stop) / scene.reduced.wind_up(torque) - 1.0


def _try_time_steps(reduced: ReducedJoint, integrator: Integrator, load: str, inertia: float) -> Iterator[StepTrial]:
    """Yield the trials of `STUDY.steps`, and of `STUDY.finer_steps` until one is accurate if the shortest is not."""
    runs = [try_time_step(reduced, integrator, item, inertia, load) for item in STUDY.steps]
    yield from runs
    if runs[0].accurate:
        return
    for finer in STUDY.finer_steps:
        run = try_time_step(reduced, integrator, finer, inertia, load)
        yield run
        if run.accurate:
            return


def _is_stable_with_free_crank(scene: TrialScene, inertia: float) -> bool:
    """Return whether a vibration with a free crank does not grow, with the motor balancing the torque.

    Crank and output then move against each other, faster than the output alone: k (1/J + 1/(i^2 J_rotor)).
    """
    reduced, torque = scene.reduced, scene.reduced.rated_torque
    wound, moving = reduced.wind_up(torque), inertia + reduced.output_inertia
    swinging = moving / (1.0 + moving / (reduced.ratio**2 * reduced.rotor_inertia))
    steps = _steps(np.sqrt(reduced.stiffness(torque) / swinging), float(scene.model.opt.timestep))
    scene.press(torque)
    scene.data.qpos[scene.place.output_angle] -= (1.0 - STUDY.start) * wound
    scene.data.ctrl[:] = reduced.coefficient * torque
    lengths = scene.lengths(lambda time: torque, steps)
    return lengths is not None and float(np.ptp(lengths[steps // 2 :])) <= STUDY.max_vibration * wound


def _steps(frequency: float, timestep: float) -> int:
    """Return the number of time steps of a run that shows a vibration of this frequency [rad/s]."""
    return max(STUDY.min_steps, math.ceil(2.0 * np.pi * STUDY.periods / frequency / timestep))


def _accelerate_rigid_joint(scene: TrialScene, inertia: float) -> tuple[bool, float, float]:
    """Apply the rated input torque to the motor, and compare the speed with that of the total inertia with friction."""
    reduced, step = scene.reduced, float(scene.model.opt.timestep)
    scene.data.ctrl[:] = reduced.rated_torque / reduced.ratio
    for _ in range(STUDY.min_steps):
        scene.step()
    total = inertia + reduced.reflected_inertia
    spare = reduced.rated_torque - float(scene.model.dof_frictionloss[scene.place.output_speed])
    speed = reduced.way * float(scene.data.qvel[scene.place.output_speed])
    error = speed / (spare / total * STUDY.min_steps * step) - 1.0
    return bool(np.isfinite(error)), error, np.nan


def _analyse_vibration(turn: Array, timestep: float) -> tuple[float, float]:
    """Compute the middle of a vibration and its angular frequency [rad/s], NaN if it is not resolved."""
    middle = 0.5 * (float(turn.max()) + float(turn.min()))
    if np.ptp(turn) < STUDY.min_vibration * abs(middle):
        return float(turn[-1]), np.nan
    above = turn > middle
    ups = np.flatnonzero(~above[:-1] & above[1:])
    if len(ups) < 3 or (ups[-1] - ups[0]) / (len(ups) - 1) < 8.0:
        return float(turn[-len(turn) // 2 :].mean()), np.nan
    crossings = ups + (middle - turn[ups]) / (turn[ups + 1] - turn[ups])
    periods = slice(int(ups[0]), int(ups[-1]))
    return float(turn[periods].mean()), 2.0 * np.pi * (len(ups) - 1) / float(crossings[-1] - crossings[0]) / timestep
