"""Warnings about the results of a run, as sentences that terminal, page and JSON share.

Some are known before the run; the others concern its end, its time step, its power balance and its efficiency.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis.findings import ContactSummary, Window
from cycloid_mj.analysis.series import Series
from cycloid_mj.base.names import REDUCER
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.base.record import Run
from cycloid_mj.design.units import MICROMETRE, RPM
from cycloid_mj.dynamics.jam import JAM
from cycloid_mj.dynamics.planar.settings import NEWTON
from cycloid_mj.dynamics.planar.timestep import PLANAR_RULE
from cycloid_mj.dynamics.regime import pace_warnings
from cycloid_mj.dynamics.settling import penetration_limit
from cycloid_mj.dynamics.timestep import MUJOCO_RULE
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class WarningLimits:
    """Limits from which on the results of a run cause a warning."""

    balance_rtol: float = 0.002
    """Largest error of the power balance, relative to the power: at 20 kHz over full turns it closes to 2e-5."""
    idling_balance_rtol: float = 0.01
    """The same for an idling reducer, relative to its input power: the stated accuracy of its mean values."""
    min_turns: float = 0.99
    """Crank turns from which on sampled powers average out; rounding may take a sample off a full turn."""
    min_power_share: float = 0.01
    """Smallest power that errors are related to, relative to the rated power: an idling reducer takes next to none."""
    min_driving_share: float = 0.1
    """Input power relative to output power below which the load does not yet act on the shaft that drives."""
    penetration_share: float = 0.5
    """Share of the allowed penetration from which on a run is warned of."""


LIMITS = WarningLimits()


COARSE = "the log rate or the hold is too low for these powers: raise settings.log_rate_hz or drive.hold_s"
"""Cause of an open balance, and its remedy."""


def warnings(motion: Series, window: Window, contacts: ContactSummary) -> Iterator[str]:
    """Yield all warnings about the results of a run.

    They report that the run is incomplete, the note of a complete run, a run that ended before constant speed, less
    than a crank turn in the evaluated `window`, and a large deflection in `contacts`. `motion` are the signals of the
    run. The limit of the deflection is half of that at which a run stops with an error. The warnings of `run_warnings`
    are included.
    """
    run = motion.run
    if not run.complete:
        yield f"the run is incomplete: {run.note or 'the reason is unknown'}"
    elif run.note:
        yield run.note
    if window.phase == "ramp":
        yield _ramp_warning(motion)
    elif _window_turns(window) < 1.0:
        yield _short_run_warning(motion, window)
    yield from run_warnings(motion)
    penetration_limit_um = MICROMETRE.from_si(penetration_limit(motion.reducer))
    if contacts.max_penetration_um > LIMITS.penetration_share * penetration_limit_um:
        yield (
            f"largest contact deflection {contacts.max_penetration_um:.3g} um; a run stops with an error at "
            f"{penetration_limit_um:g} um (contact.max_penetration_um)"
        )


def run_warnings(motion: Series) -> tuple[str, ...]:
    """Return the warnings about log rate, time step, convergence and power balance of a run, with remedies.

    Warnings that were recorded during the run come first. The power balance is omitted for a run that did not reach
    constant speed. `motion` are the time series of the run.
    """
    run, reducer = motion.run, motion.reducer
    # the columns of powers suffice: most columns of a run are forces, whose copy would be as large as the run
    evaluated_run = run.of_topic(REDUCER).select(motion.whole_periods)
    powers = balance_warnings(evaluated_run, reducer) if motion.phase == "hold" and len(evaluated_run) > 1 else ()
    min_steps = (PLANAR_RULE if run.provenance.get("solver") == "planar" else MUJOCO_RULE).min_steps_per_tooth
    return tuple(
        dict.fromkeys((*run.warnings, *pace_warnings(reducer, min_steps), *convergence_warnings(run), *powers))
    )


def convergence_warnings(run: Run) -> Iterator[str]:
    """Yield a warning if samples include time steps whose contact iteration did not converge.

    Only the planar solver logs this; there is no warning about other runs.
    """
    if run.provenance.get("solver") != "planar" or "solver_iterations" not in run.columns:
        return
    count = int(np.count_nonzero(run["solver_iterations"] > NEWTON.max_iterations))
    if count:
        yield (
            f"in {count} of {len(run)} samples, the contact iteration of the planar solver did not converge within "
            f"{NEWTON.max_iterations} iterations: forces and losses there are wrong; reduce settings.timestep_us"
        )


def balance_warnings(run: Run, reducer: Reducer, remedy: str = "") -> tuple[str, ...]:
    """Return the warnings about power balance and efficiency of a run.

    They report power that is missing in the balance, a load that does not act yet, and an efficiency that is impossible
    or below `JAM.min_efficiency`, where the drive is almost self-locking. `LIMITS` has the tolerances. The balance is
    not checked if the run has no energies or covers less than a crank turn, and the efficiency is not checked if it is
    undefined, because no shaft supplies significant power.

    Parameters
    ----------
    run, reducer
        The run, and the drive under its load.
    remedy
        Remedy for the messages; by default longer hold and higher log rate, by their keys in the design file.
    """
    design = reducer.design
    powers = mean_powers(run)
    idle_power = LIMITS.min_power_share * design.drive.torque * abs(design.drive.speed)
    largest_power = max(powers.crank, powers.output, powers.lost)
    reference_power = max(largest_power, idle_power)
    texts = []
    is_short = _swept_turns(run) < LIMITS.min_turns
    if "kinetic_energy" in run.columns and not is_short:
        is_idle = powers.delivered <= idle_power
        balance_power, max_balance_error = (
            (max(largest_power, LIMITS.min_power_share * idle_power), LIMITS.idling_balance_rtol)
            if is_idle
            else (reference_power, LIMITS.balance_rtol)
        )
        if abs(powers.missing) > max_balance_error * balance_power:
            texts.append(
                _open_balance_warning(powers.missing, balance_power, abs(design.drive.speed), is_idle, remedy or COARSE)
            )
    if design.load.torque and 0.0 < powers.efficiency < JAM.min_efficiency:
        texts.append(
            f"efficiency {powers.efficiency:.2%}: friction losses are {1.0 / powers.efficiency - 1.0:.3g} times the "
            "output power, and the drive is almost self-locking; check friction.*, clearance.* and load.torque_nm"
        )
    explanation = remedy or ("the hold is shorter than a crank turn: raise drive.hold_s" if is_short else COARSE)
    load_power = abs(design.load.torque * design.drive.speed) / design.reduction
    if (
        powers.supplied < LIMITS.min_driving_share * powers.delivered
        and powers.delivered > LIMITS.min_power_share * load_power > 0.0
    ):
        texts.append(
            f"the load does not act yet: {powers.supplied:.3g} W in, {powers.delivered:.3g} W out, while parts cross "
            "their clearances; forces and efficiency are not steady: "
            f"raise {'' if remedy else 'drive.hold_s or '}load.torque_nm, or reduce clearance.*"
        )
    if powers.supplied <= LIMITS.min_driving_share * powers.delivered:
        # the efficiency of a drive that floats or stands still is undefined
        return tuple(texts)
    # without friction the efficiency is 1 to rounding and what sampled powers leave open
    max_efficiency = 1.0 + (LIMITS.balance_rtol if powers.lost < LIMITS.balance_rtol * reference_power else 0.0)
    is_impossible = powers.efficiency > max_efficiency or (design.load.torque != 0.0 and not powers.efficiency >= 0.0)
    if design.load.torque and powers.note:
        texts.append(f"efficiency 0, {powers.note}: both shafts drive, and friction takes all power; or {explanation}")
    if is_impossible and (design.load.torque or max(powers.crank, powers.output) > idle_power):
        texts.append(f"efficiency {powers.efficiency:.2%} is impossible: {explanation}")
    return tuple(texts)


def _open_balance_warning(missing_power: float, total_power: float, speed: float, is_idle: bool, remedy: str) -> str:
    """Return the warning that power is missing in the power balance of a run.

    `missing_power` [W] is stated as a share of `total_power` [W]. `speed` is the crank speed [rad/s]. `is_idle` is true
    if the output power is negligible. `remedy` is the end of the warning.
    """
    affected_results = "powers and losses" if is_idle else "powers, losses and efficiency"
    conditions = f"{' of the idling drive' if is_idle else ''} at {RPM.from_si(speed):.4g} rpm"
    return (
        f"power balance{conditions}: {missing_power:.3g} W are missing, {abs(missing_power) / total_power:.2%} of "
        f"{total_power:.4g} W; {affected_results} have an error of this size; {remedy}"
    )


def _swept_turns(run: Run) -> float:
    shaft_angle = run[f"{run.driven_shaft}_angle"]
    return float(abs(shaft_angle[-1] - shaft_angle[0]) / (2.0 * np.pi) * shaft_angle.size / (shaft_angle.size - 1))


def _ramp_warning(motion: Series) -> str:
    """Return the warning for a run that ended while the crank speed was still rising; the caller has tested this.

    `motion` are the time series of the run.
    """
    drive = motion.design.drive
    reached_speed = RPM.from_si(float(motion.crank_speed.simulated[-1]))
    return (
        f"the run ended during the ramp, at {motion.time[-1]:.4g} of {drive.ramp:g} s and {reached_speed:.4g} of"
        f" {RPM.from_si(drive.speed):g} rpm: all results are those of the ramp; results at constant speed, such as the"
        " efficiency, are missing"
    )


def _short_run_warning(motion: Series, window: Window) -> str:
    """Return the warning for a run with less than a crank turn at constant speed, with the required drive.hold_s.

    `window` are the evaluated samples of the run. `motion` are the time series of the run.
    """
    speed = abs(motion.reducer.orbit_speed)
    settling_duration = window.start_s - motion.design.drive.ramp
    remedy = (
        f"; a full turn needs drive.hold_s = {settling_duration + 2.0 * np.pi / speed:.2g}, settling included"
        if speed
        else ""
    )
    return (
        f"only {window.crank_turns:.2f} crank turns at constant speed were evaluated: means and peaks are those of part"
        f" of a turn{remedy}"
    )


def _window_turns(window: Window) -> float:
    """Return the crank turns of a window, including the interval after its last sample."""
    return window.crank_turns * window.samples / max(window.samples - 1, 1) + 1e-6
