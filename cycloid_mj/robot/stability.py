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
from cycloid_mj.robot.trial import INTEGRATORS, Integrator, TrialScene, create_trial_scene


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
    min_crossings: int = 3
    min_steps_per_period: float = 8.0
    """Smallest number of upward zero crossings, and of time steps in a period, from which a frequency is computed."""
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
        """Return a sentence on the trial: relative error of the largest wind-up in an impact of the rated load.

        The error is relative to the closed form. If there is no valid impact test, the text is a short verdict
        (`summary`) such as "unstable": the joint is unstable or rigid, or the error of its wind-up under a constant
        torque is too large.
        """
        if not self.good or self.level == "rigid":
            return self.summary
        return (
            f"error of the peak wind-up in an impact {100.0 * self.impact_error:+.1f} % (peak "
            f"{self.impact_peak / ARCMINUTE:.4g} arcmin, rated load at {self.impact_frequency:g} Hz)"
        )

    def as_json(self) -> dict[str, Any]:
        """Convert the trial simulation with a time step to JSON values; keys end in units, errors are relative [1].

        ``static_error`` is the error of the wind-up under the nominal torque, ``frequency_error`` that of the frequency
        of the vibration, and ``impact_error`` the error of the largest wind-up in an impact at ``impact_hz``. ``load``
        is the inertia in words.
        """
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
    """Return a trial simulation of a joint for each level, integrator, load inertia (`INERTIAS`) and time step.

    The time steps are `STUDY.steps`. If the shortest of these is not accurate, `STUDY.finer_steps` are tried as well.
    `reduced` is the joint model of the drive.
    """
    trials: list[StepTrial] = []
    for level, integrator in itertools.product(LEVELS, INTEGRATORS):
        for load, relative_inertia in INERTIAS.items():
            inertia = relative_inertia * reduced.reflected_inertia
            trials += _try_time_steps(reduced.at(level), integrator, load, inertia)
    return tuple(trials)


def choose_time_step(
    reduced: ReducedJoint,
    inertia: float,
    timestep: float | None = None,
    integrators: Sequence[Integrator] = ("implicitfast", "discrete"),
) -> StepTrial:
    """Choose the longest accurate time step for a scene, up to `STUDY.max_scene_step`; return its trial.

    A trial simulates the joint with one time step, and is accurate if its errors are small (`StepTrial.accurate`). If
    no time step is accurate, return the stable trial with the smallest error.

    Parameters
    ----------
    reduced
        The joint at its level of detail.
    inertia
        Inertia on the output [kg m2].
    timestep
        Time step to try [s]; None tries those of `STUDY`.
    integrators
        Integrators to try at each time step, the preferred one first.
    """
    candidates = (*(step for step in reversed(STUDY.steps) if step <= STUDY.max_scene_step), *STUDY.finer_steps)
    trials = []
    for candidate in candidates if timestep is None else (timestep,):
        for integrator in integrators:
            trials.append(try_time_step(reduced, integrator, candidate, inertia))
            if trials[-1].accurate:
                return trials[-1]
    return min(
        trials, key=lambda trial: (not trial.stable, not trial.good, abs(np.nan_to_num(trial.impact_error, nan=np.inf)))
    )


def try_time_step(
    reduced: ReducedJoint, integrator: Integrator, timestep: float, inertia: float, load: str = "as requested"
) -> StepTrial:
    """Try a time step [s] with an integrator: test stability, the static error, and the largest wind-up in an impact.

    `reduced` is the joint model. Stability is tested with a locked and with a free crank. `inertia` is the inertia on
    the output [kg m2], and `load` is the name of this inertia in the result, such as a key of `INERTIAS`. A rigid joint
    is only accelerated.
    """

    def scene() -> TrialScene:
        return create_trial_scene(reduced, inertia, timestep, integrator)

    conditions = reduced.level, integrator, load, timestep, inertia
    if reduced.level == "rigid":
        return StepTrial(*conditions, *_accelerate_rigid_joint(scene(), inertia))
    load_case = solve_impact(reduced, inertia)
    stable, static_error, frequency_error = measure_vibration(scene(), inertia)
    peak_wind_up = run_impact(scene(), load_case) if stable and _is_stable_with_free_crank(scene(), inertia) else None
    if peak_wind_up is None:
        return StepTrial(*conditions, False, math.nan, math.nan, load_case.frequency)
    return StepTrial(
        *conditions,
        True,
        static_error,
        frequency_error,
        load_case.frequency,
        peak_wind_up,
        peak_wind_up / load_case.peak - 1.0,
    )


def longest_accurate(trials: Iterable[StepTrial], level: Level, integrator: Integrator, load: str) -> StepTrial | None:
    """Return the trial simulation with the longest accurate time step of a joint; None if none is accurate.

    Only trials of this level, integrator and load (a key of `INERTIAS`) count. Starting from the shortest accurate
    step, longer steps count up to the first that is not accurate.
    """
    matching_trials = [
        trial for trial in trials if (trial.level, trial.integrator, trial.load) == (level, integrator, load)
    ]
    longest_trial = None
    for trial in sorted(matching_trials, key=lambda trial: trial.timestep):
        if trial.accurate:
            longest_trial = trial
        elif longest_trial is not None:
            break
    return longest_trial


def recommend_time_steps(trials: tuple[StepTrial, ...]) -> list[dict[str, Any]]:
    """List the longest accurate time steps as JSON values, with a dictionary for each level and integrator.

    Its keys are ``level``, ``integrator``, and ``timestep_s``, the longest step [s] that is accurate with all inertias.
    ``by_load`` has the longest accurate step [s] for each inertia (keys of `INERTIAS`), and ``impact_error`` the
    relative error of the largest wind-up in an impact with that step. A step of 0 means that none is accurate. `trials`
    are the simulated tests, one for each time step.
    """
    rows = []
    for level in LEVELS:
        for integrator in INTEGRATORS:
            longest_by_load = {load: longest_accurate(trials, level, integrator, load) for load in INERTIAS}
            step_by_load = {load: trial.timestep if trial else 0.0 for load, trial in longest_by_load.items()}
            errors = {load: trial.impact_error if trial else math.nan for load, trial in longest_by_load.items()}
            recommendation = {"timestep_s": min(step_by_load.values()), "by_load": step_by_load, "impact_error": errors}
            rows.append({"level": level, "integrator": integrator, **recommendation})
    return rows


def recommended_table(trials: tuple[StepTrial, ...]) -> Table:
    """Tabulate the recommended time steps and their errors, by level and integrator (rows) and inertia (columns).

    `trials` are the simulated tests, one for each time step.
    """
    rows = []
    for level in LEVELS:
        for integrator in INTEGRATORS:
            longest_trials = [longest_accurate(trials, level, integrator, load) for load in INERTIAS]
            cells = (f"{1e3 * trial.timestep:g} ms: {trial.summary}" if trial else "none" for trial in longest_trials)
            rows.append((f"{level}, {integrator}", *cells))
    title = f"Longest time step at which the peak of an impact is within {STUDY.impact_rtol:.0%}, and its error"
    return Table(title, ("level, integrator", *INERTIAS), tuple(rows))


def trials_table(trials: tuple[StepTrial, ...]) -> Table:
    """Tabulate the errors of trials: a row for each level, integrator and inertia, a column for each time step.

    A cell is `StepTrial.summary`: the error of the largest wind-up in an impact [%], or a verdict such as "unstable".
    """
    rows: dict[str, dict[float, str]] = {}
    for trial in trials:
        impact = "" if trial.level == "rigid" else f", {trial.impact_frequency:g} Hz"
        rows.setdefault(f"{trial.level}, {trial.integrator}, {trial.load}{impact}", {})[trial.timestep] = trial.summary
    steps = sorted({trial.timestep for trial in trials})
    cells = tuple((key, *(cells_by_step.get(step, "") for step in steps)) for key, cells_by_step in rows.items())
    header = ("level, integrator, inertia on the output, load", *(f"{1e3 * step:g} ms" for step in steps))
    return Table("Error of the peak of an impact by time step, crank locked, rated load cos(2 pi f t)", header, cells)


def measure_vibration(scene: TrialScene, inertia: float) -> tuple[bool, float, float]:
    """Simulate the output under a suddenly applied nominal torque with a locked crank, and analyse its vibration.

    `scene` has the joint, and `inertia` [kg m2] is the inertia on the output, without that of the reducer.

    Returns
    -------
    tuple
        Whether the vibration is stable; relative error of the mean wind-up; and relative error of the frequency against
        sqrt(k/J), with the stiffness k and total inertia J. The errors are NaN if the vibration is unstable.
    """
    reduced, timestep = scene.reduced, float(scene.model.opt.timestep)
    torque, total_inertia = reduced.rated_torque, inertia + reduced.output_inertia
    angular_frequency = np.sqrt(reduced.stiffness(torque) / total_inertia)
    step_count = _count_steps(angular_frequency, timestep)
    wind_up, stop_angle = reduced.wind_up(torque), reduced.stops[1]
    if reduced.level == "full":
        stop_angle += reduced.ripple.errors(0.0, 1.0)[1]
    scene.hold()
    scene.data.qpos[scene.addresses.output_angle] = stop_angle + STUDY.start * wind_up
    deviations = scene.simulate_deviation(lambda time: torque, step_count)
    if deviations is None or float(np.ptp(deviations[step_count // 2 :])) > STUDY.max_vibration * wind_up:
        return False, np.nan, np.nan
    mean_wind_up, frequency = _analyse_vibration(deviations[step_count // 2 :] - stop_angle, timestep)
    relative_error = mean_wind_up / wind_up - 1.0
    if abs(relative_error) > STUDY.static_rtol:
        relative_error = _settled_wind_up_error(scene, step_count, stop_angle)
    return True, relative_error, frequency / angular_frequency - 1.0


def _settled_wind_up_error(scene: TrialScene, steps: int, stop_angle: float) -> float:
    """Simulate the output from rest under nominal torque; return the relative error of its mean wind-up.

    With a nonlinear spring, such as with a transmission error that depends on the load, the mean of a vibration differs
    from the position of rest; `measure_vibration` then returns this error instead. `scene` has the joint, `stop_angle`
    is the angle of its stop [rad], and `steps` is the number of time steps.
    """
    torque = scene.reduced.rated_torque
    mujoco.mj_resetData(scene.model, scene.data)
    scene.hold()
    scene.press_to_stop(torque)
    deviations = scene.simulate_deviation(lambda time: torque, steps)
    if deviations is None:
        return math.nan
    return (float(deviations[steps // 2 :].mean()) - stop_angle) / scene.reduced.wind_up(torque) - 1.0


def _try_time_steps(
    joint_model: ReducedJoint, integrator: Integrator, load: str, inertia: float
) -> Iterator[StepTrial]:
    """Yield the trial simulations at the time steps `STUDY.steps` of a joint with an integrator and an inertia [kg m2].

    If the shortest step is not accurate, those at `STUDY.finer_steps` follow until one is. `load` is the name of the
    inertia. `joint_model` is the reduced model of the drive.
    """
    trials = [try_time_step(joint_model, integrator, step, inertia, load) for step in STUDY.steps]
    yield from trials
    if trials[0].accurate:
        return
    for finer_step in STUDY.finer_steps:
        trial = try_time_step(joint_model, integrator, finer_step, inertia, load)
        yield trial
        if trial.accurate:
            return


def _is_stable_with_free_crank(scene: TrialScene, inertia: float) -> bool:
    """Return whether a vibration with a free crank does not grow, while the motor carries the nominal torque.

    Crank and output vibrate against each other, faster than the output alone does with a locked crank. The square of
    their angular frequency is k (1/J + 1/(i^2 J_rotor)), with the stiffness k, the ratio i, the inertia J_rotor of the
    crank, and the inertia J of output and load. `scene` has the joint; `inertia` is that of the load alone [kg m2].
    """
    reduced, torque = scene.reduced, scene.reduced.rated_torque
    wind_up, output_inertia = reduced.wind_up(torque), inertia + reduced.output_inertia
    effective_inertia = 1.0 / (1.0 / output_inertia + 1.0 / (reduced.ratio**2 * reduced.rotor_inertia))
    step_count = _count_steps(np.sqrt(reduced.stiffness(torque) / effective_inertia), float(scene.model.opt.timestep))
    scene.press_to_stop(torque)
    scene.data.qpos[scene.addresses.output_angle] -= (1.0 - STUDY.start) * wind_up
    scene.data.ctrl[:] = reduced.coefficient * torque
    deviations = scene.simulate_deviation(lambda time: torque, step_count)
    return deviations is not None and float(np.ptp(deviations[step_count // 2 :])) <= STUDY.max_vibration * wind_up


def _count_steps(frequency: float, timestep: float) -> int:
    """Return the number of time steps [s] of a run over `STUDY.periods` of a vibration, at least `STUDY.min_steps`.

    `frequency` is its angular frequency [rad/s].
    """
    return max(STUDY.min_steps, math.ceil(2.0 * np.pi * STUDY.periods / frequency / timestep))


def _accelerate_rigid_joint(scene: TrialScene, inertia: float) -> tuple[bool, float, float]:
    """Simulate a rigid joint from rest under its rated input torque, and compare its speed with the closed form.

    `scene` has the joint. The closed form is (torque - friction) t / J after the time t, with the inertia J of reducer
    and load; `inertia` is the inertia of the load [kg m2]. Return whether the simulation is stable, the relative error
    of the speed, and NaN, because a rigid joint has no vibration frequency.
    """
    reduced, timestep = scene.reduced, float(scene.model.opt.timestep)
    scene.data.ctrl[:] = reduced.rated_torque / reduced.ratio
    for _ in range(STUDY.min_steps):
        scene.step()
    total_inertia = inertia + reduced.reflected_inertia
    accelerating_torque = reduced.rated_torque - float(scene.model.dof_frictionloss[scene.addresses.output_speed])
    speed = reduced.way * float(scene.data.qvel[scene.addresses.output_speed])
    relative_error = speed / (accelerating_torque / total_inertia * STUDY.min_steps * timestep) - 1.0
    return bool(np.isfinite(relative_error)), relative_error, np.nan


def _analyse_vibration(angles: Array, timestep: float) -> tuple[float, float]:
    """Compute the mean angle of a vibration [rad] and its angular frequency [rad/s] from its upward zero crossings.

    `angles` (n,) [rad] are the angles after each of n time steps, `timestep` is in [s]. The mean is that over complete
    periods. If there are none, it is the mean over the second half, or the last angle if the vibration has decayed. The
    frequency is NaN if the vibration has decayed, has fewer crossings than `STUDY.min_crossings`, or fewer time steps
    per period than `STUDY.min_steps_per_period`.
    """
    midpoint = 0.5 * (float(angles.max()) + float(angles.min()))
    if np.ptp(angles) < STUDY.min_vibration * abs(midpoint):
        return float(angles[-1]), np.nan
    is_above = angles > midpoint
    upward_crossings = np.flatnonzero(~is_above[:-1] & is_above[1:])
    crossing_count = len(upward_crossings)
    if (
        crossing_count < STUDY.min_crossings
        or (upward_crossings[-1] - upward_crossings[0]) / (crossing_count - 1) < STUDY.min_steps_per_period
    ):
        return float(angles[-len(angles) // 2 :].mean()), np.nan
    crossings = upward_crossings + (midpoint - angles[upward_crossings]) / (
        angles[upward_crossings + 1] - angles[upward_crossings]
    )
    periods = slice(int(upward_crossings[0]), int(upward_crossings[-1]))
    period = timestep * float(crossings[-1] - crossings[0]) / (crossing_count - 1)
    return float(angles[periods].mean()), 2.0 * np.pi / period
