"""Analysis of a run: from its series to its findings.

Extremes and rms values cover all settled samples of the hold, means its full crank turns (full mesh periods if it is
shorter than a turn). The peak-to-peak transmission error is the mean over the full crank turns.
`crank.max_relative_error` covers the entire run, `ramp` the ramp. A run that ended during the ramp is evaluated over
the ramp; its efficiency is undefined, as the input also accelerates the drive.
"""

import numpy as np
import numpy.typing as npt

from cycloid_mj.analysis.findings import (
    AccelerationFindings,
    ContactSummary,
    Crank,
    Disc,
    Findings,
    Loss,
    PathFindings,
    Pin1,
    Power,
    Ramp,
    SpeedFindings,
    TransmissionError,
    VelocityFindings,
    Window,
    condition,
)
from cycloid_mj.analysis.series import Compared, Series, point_path, series
from cycloid_mj.analysis.warnings import warnings
from cycloid_mj.analysis.window import turn_by_turn
from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.names import FRICTION_POWER, NORMAL_POWER
from cycloid_mj.base.powers import Powers
from cycloid_mj.base.record import Run
from cycloid_mj.base.statistics import peak, rms
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.dynamics.timestep import timestep

MAX_CRANK_STEP = np.radians(5.0)
"""Largest crank angle between samples for accelerations from differences: their relative error is its square / 24."""


def analyze(run: Run, q: npt.ArrayLike | None = None, settle: float | None = None, log: str | None = None) -> Findings:
    """Evaluate a run and compare it with its closed form.

    Parameters
    ----------
    run, q, settle
        Arguments of `series`.
    log
        Path of the log, for `Findings.log`.

    Returns
    -------
    Findings
        Transmission error, speeds, forces, losses and efficiency, each with its closed form.

    Raises
    ------
    LogError
        The run has no design, lacks a column, or has fewer than two samples.
    UsageError
        `q` is no point, or `settle` is negative.
    """
    return judge(series(run, q, settle), log)


def judge(motion: Series, log: str | None = None) -> Findings:
    """Evaluate a series; see `analyze`."""
    run, provenance = motion.run, motion.run.provenance
    power, contacts, judged = _power(motion), _contacts(motion), _window(motion)
    output = _transmission_error(motion.output_angle, motion)
    return Findings(
        design=motion.design.name,
        contact=provenance.get("contact"),
        log=log,
        timestep_s=float(provenance["timestep_s"]) if "timestep_s" in provenance else timestep(motion.reducer),
        timestep=provenance.get("timestep"),
        timestep_for=provenance.get("timestep_for"),
        steps=int(provenance["steps"]) if "steps" in provenance else None,
        wall_s=float(provenance["wall_s"]) if "wall_s" in provenance else None,
        crank=_crank(motion),
        gear_speed=_speed(motion.gear_speed, motion),
        q_path=_path(motion, motion.evaluation_mask),
        q_speed=_velocity(motion.q_velocity, motion.evaluation_mask),
        transmission_error=output,
        contact_summary=contacts,
        pin1=_pin_1(motion),
        q_speed_magnitude=_velocity(motion.q_velocity.size, motion.evaluation_mask),
        q_acceleration=_acceleration(motion, motion.evaluation_mask),
        ramp=_ramp(motion),
        output_speed=_speed(motion.output_speed, motion),
        output_transmission_error=output,
        gear_transmission_error=_transmission_error(motion.gear_angle, motion),
        discs=_discs(motion),
        efficiency=_efficiency(power, motion),
        power=power,
        losses=_losses(motion),
        window=judged,
        complete=run.complete,
        note=run.note,
        condition=condition(motion.reducer),
        solver=provenance.get("solver", "mujoco"),  # logs of the first releases lack the entry
        warnings=tuple(warnings(motion, judged, contacts)),
    )


def _crank(motion: Series) -> Crank:
    nominal = abs(motion.design.drive.speed)
    mean = _mean(motion.crank_speed.simulated, motion)
    return Crank(mean, peak(motion.crank_speed.error) / nominal if nominal else None)


def _discs(motion: Series) -> tuple[Disc, ...]:
    """Return the results of each disc, if there are several."""
    count = motion.design.gear.discs
    each = [motion.of_disc(disc) for disc in range(count)] if count > 1 else []
    return tuple(
        Disc(
            name=series_of_disc.gear,
            speed=_speed(series_of_disc.gear_speed, series_of_disc),
            transmission_error=_transmission_error(series_of_disc.gear_angle, series_of_disc),
            q_path=_path(series_of_disc, series_of_disc.evaluation_mask),
            q_speed=_velocity(series_of_disc.q_velocity, series_of_disc.evaluation_mask),
        )
        for series_of_disc in each
    )


def _speed(speed: Compared, motion: Series) -> SpeedFindings:
    return SpeedFindings(
        theory_rad_s=_mean(speed.theory, motion),
        mean_rad_s=_mean(speed.simulated, motion),
        rms_error_rad_s=rms(speed.error[motion.evaluation_mask]),
        peak_error_rad_s=peak(speed.error[motion.evaluation_mask]),
    )


def _path(motion: Series, rows: Mask) -> PathFindings:
    q_x, q_y = (float(value) for value in 1e3 * motion.q)
    error = motion.q_position.error_size[rows]
    return PathFindings((q_x, q_y), 1e6 * rms(error), 1e6 * peak(error))


def _velocity(velocity: Compared, rows: Mask) -> VelocityFindings:
    error = velocity.error_size[rows]
    return VelocityFindings(1e3 * rms(error), 1e3 * peak(error))


def _acceleration(motion: Series, rows: Mask) -> AccelerationFindings | None:
    """Compare velocity differences with Eq. 19 at the mean crank angle, speed and acceleration between samples."""
    inner = np.flatnonzero(rows[1:] & rows[:-1])
    if inner.size == 0 or peak(np.diff(motion.crank_angle)[inner]) > MAX_CRANK_STEP:
        return None
    interval = np.diff(motion.time)
    angle, speed = (_middle(values) for values in (motion.crank_angle, motion.crank_speed.simulated))
    crank_acceleration = np.diff(motion.crank_speed.simulated) / interval
    path = point_path(motion.reducer, motion.q, motion.disc, angle, speed, crank_acceleration)
    simulated = np.diff(motion.q_velocity.simulated, axis=0) / interval[:, np.newaxis]
    error = Compared(simulated, path.acceleration).error_size[inner]
    return AccelerationFindings(rms(error), peak(error))


def _transmission_error(angle: Compared, motion: Series) -> TransmissionError:
    error = angle.error[motion.evaluation_mask]
    swings = [np.ptp(error[turn]) for turn in turn_by_turn(motion.crank_angle[motion.evaluation_mask])]
    return TransmissionError(ARCSECONDS * float(np.mean(swings)), ARCSECONDS * _mean(angle.error, motion))


def _contacts(motion: Series) -> ContactSummary:
    run, judged = motion.run, motion.evaluation_mask
    return ContactSummary(
        mean_active=_mean(run["contacts"], motion),
        max_penetration_um=1e6 * float(run["penetration"][judged].max()),
        peak_force_n=float(run["peak_force"][judged].max()),
    )


def _pin_1(motion: Series) -> Pin1 | None:
    pin = motion.pin_1
    return Pin1(1e6 * peak(pin.radial[motion.evaluation_mask]), _mean(pin.spin, motion)) if pin else None


def _ramp(motion: Series) -> Ramp | None:
    rows = motion.ramp
    if not rows.any():
        return None
    velocity = _velocity(motion.q_velocity, rows)
    return Ramp(_path(motion, rows), velocity, _acceleration(motion, rows), int(rows.sum()))


def _power(motion: Series) -> Power:
    """Compute mean powers and torques."""
    run = motion.run
    load_torque = _mean(run["load_torque"], motion)
    return Power(
        input_w=_mean(run["crank_torque"] * run["crank_speed"], motion),
        output_w=_mean(-run["load_torque"] * run["output_speed"], motion),
        crank_torque_nm=_mean(run["crank_torque"], motion),
        ideal_crank_torque_nm=-load_torque / motion.design.ratio,
        load_torque_nm=load_torque,
    )


def _efficiency(power: Power, motion: Series) -> float | None:
    loaded = motion.design.load.torque > 0 and power.input_w > 0
    return Powers(power.input_w, -power.output_w).efficiency if loaded and motion.phase == "hold" else None


def _losses(motion: Series) -> tuple[Loss, ...]:
    """Return the losses of each kind of mating pair that was in contact."""
    run = motion.run
    by_friction, by_damping = run.by_stem(FRICTION_POWER), run.by_stem(NORMAL_POWER)
    losses = []
    for kind, friction in sorted(by_friction.items()):
        normal = by_damping.get(kind, np.zeros(len(run)))
        if friction.any() or normal.any():
            losses.append(Loss(kind, _mean(friction, motion), _mean(normal, motion)))
    return tuple(losses)


def _window(motion: Series) -> Window:
    time, angle = motion.time[motion.evaluation_mask], motion.crank_angle[motion.evaluation_mask]
    turns = float(abs(angle[-1] - angle[0]) / (2 * np.pi))
    return Window(float(time[0]), float(time[-1]), time.size, turns, motion.phase)


def _mean(values: Array, motion: Series) -> float:
    return float(np.mean(values[motion.whole_periods]))


def _middle(values: Array) -> Array:
    return (values[1:] + values[:-1]) / 2
