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
    CrankBearings,
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
from cycloid_mj.base import names
from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.names import FRICTION_POWER, NORMAL_POWER
from cycloid_mj.base.powers import Powers
from cycloid_mj.base.record import Run
from cycloid_mj.base.statistics import peak, rms
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.dynamics.timestep import timestep
from cycloid_mj.geometry.rv_loads import mean_force

MAX_CRANK_STEP = np.radians(5.0)
"""Largest crank angle between samples for accelerations from differences: their relative error is its square / 24."""


def analyze(run: Run, q: npt.ArrayLike | None = None, settle: float | None = None, log: str | None = None) -> Findings:
    """Evaluate a run, and compare it with closed-form results.

    Parameters
    ----------
    run
        Run with its ``design.toml``.
    q
        Point of the disc in its frame [m], shape (2,); by default the centre of hole 1 (or crank bore 1), on +y.
    settle
        Time after the ramp of the crank speed that is not evaluated [s]; by default an estimate, see `window.in_hold`.
    log
        Path of the log, which is stored as `Findings.log`; it is not read.

    Returns
    -------
    Findings
        Transmission error, speeds, forces, losses and efficiency; those with a closed form are compared with it.

    Raises
    ------
    LogError
        The run has no design, the design does not match it, a column is missing, or it has fewer than two samples.
    DesignError
        The attached design is not valid.
    UsageError
        `q` is not two finite numbers, or `settle` is negative.
    """
    return judge(series(run, q, settle), log)


def judge(motion: Series, log: str | None = None) -> Findings:
    """Evaluate a simulated run: measured values, their closed forms, and warnings.

    `motion` are the time series of the run. `log` is the path of the log, which is stored as `Findings.log`. If the
    log's provenance lacks an entry, the time step of the design and the solver ``mujoco`` are stated, and the other
    entries are None.
    """
    run, provenance = motion.run, motion.run.provenance
    power, contacts, evaluated_window = _mean_powers(motion), _summarize_contacts(motion), _window(motion)
    output_error = _transmission_error(motion.output_angle, motion)
    return Findings(
        design=motion.design.name,
        contact=provenance.get("contact"),
        log=log,
        timestep_s=float(provenance["timestep_s"]) if "timestep_s" in provenance else timestep(motion.reducer),
        timestep=provenance.get("timestep"),
        timestep_for=provenance.get("timestep_for"),
        steps=int(provenance["steps"]) if "steps" in provenance else None,
        wall_s=float(provenance["wall_s"]) if "wall_s" in provenance else None,
        driven_shaft=run.driven_shaft,
        crank=_crank(motion),
        gear_speed=_compare_speeds(motion.gear_speed, motion),
        q_path=_path(motion, motion.evaluation_mask),
        q_speed=_velocity(motion.q_velocity, motion.evaluation_mask),
        transmission_error=output_error,
        contact_summary=contacts,
        crank_bearings=_summarize_crank_bearings(motion),
        pin1=_pin_1(motion),
        q_speed_magnitude=_velocity(motion.q_velocity.size, motion.evaluation_mask),
        q_acceleration=_compare_accelerations(motion, motion.evaluation_mask),
        ramp=_ramp(motion),
        output_speed=_compare_speeds(motion.output_speed, motion),
        output_transmission_error=output_error,
        gear_transmission_error=_transmission_error(motion.gear_angle, motion),
        discs=_evaluate_discs(motion),
        efficiency=_efficiency(power, motion),
        power=power,
        losses=_mean_losses(motion),
        window=evaluated_window,
        complete=run.complete,
        note=run.note,
        condition=condition(motion.reducer),
        solver=provenance.get("solver", "mujoco"),  # logs of the first releases lack the entry
        warnings=tuple(warnings(motion, evaluated_window, contacts)),
    )


def _crank(motion: Series) -> Crank:
    nominal_speed = abs(motion.design.drive.speed)
    mean_speed = _mean(motion.crank_speed.simulated, motion)
    return Crank(mean_speed, peak(motion.crank_speed.error) / nominal_speed if nominal_speed else None)


def _evaluate_discs(motion: Series) -> tuple[Disc, ...]:
    """Return the findings on each disc: speed, transmission error, and path and speed of its point q.

    The point has the coordinates `Series.q` in the frame of each disc, by default those of the centre of hole 1.
    `motion` are the time series of the run. The tuple is empty for a single disc, which the findings of the run
    describe.
    """
    disc_count = motion.design.gear.discs
    series_by_disc = [motion.of_disc(disc) for disc in range(disc_count)] if disc_count > 1 else []
    return tuple(
        Disc(
            name=series_of_disc.gear,
            speed=_compare_speeds(series_of_disc.gear_speed, series_of_disc),
            transmission_error=_transmission_error(series_of_disc.gear_angle, series_of_disc),
            q_path=_path(series_of_disc, series_of_disc.evaluation_mask),
            q_speed=_velocity(series_of_disc.q_velocity, series_of_disc.evaluation_mask),
        )
        for series_of_disc in series_by_disc
    )


def _compare_speeds(speed: Compared, motion: Series) -> SpeedFindings:
    """Return the mean of a speed and of its closed form over full periods, and rms and peak of the difference [rad/s].

    The difference is evaluated in all settled samples (`Series.evaluation_mask`). `speed` is one of the signals of
    `motion`.
    """
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


def _compare_accelerations(motion: Series, mask: Mask) -> AccelerationFindings | None:
    """Return rms and peak of the difference between simulated and closed-form acceleration of a disc's point q [m/s2].

    Each interval between two successive samples that are both in the mask (n,) is evaluated. The simulated acceleration
    is the difference of their velocities over the interval. The closed form (Hsieh 2014, Eq. 19) is evaluated at the
    mean crank angle and speed of both samples. Return None if there is no such interval, or if the crank turns by more
    than `MAX_CRANK_STEP` in one of them. `motion` are the time series of the run.
    """
    evaluated_intervals = np.flatnonzero(mask[1:] & mask[:-1])
    if evaluated_intervals.size == 0 or peak(np.diff(motion.crank_angle)[evaluated_intervals]) > MAX_CRANK_STEP:
        return None
    duration = np.diff(motion.time)
    angle, speed = (
        (series_values[1:] + series_values[:-1]) / 2 for series_values in (motion.crank_angle, motion.orbit_speed)
    )
    crank_acceleration = np.diff(motion.orbit_speed) / duration
    path = point_path(motion.reducer, motion.q, motion.disc, angle, speed, crank_acceleration)
    simulated_acceleration = np.diff(motion.q_velocity.simulated, axis=0) / duration[:, np.newaxis]
    acceleration_error = Compared(simulated_acceleration, path.acceleration).error_size[evaluated_intervals]
    return AccelerationFindings(rms(acceleration_error), peak(acceleration_error))


def _transmission_error(angle: Compared, motion: Series) -> TransmissionError:
    error = angle.error[motion.evaluation_mask]
    ranges = [np.ptp(error[turn]) for turn in turn_by_turn(motion.crank_angle[motion.evaluation_mask])]
    return TransmissionError(ARCSECONDS * float(np.mean(ranges)), ARCSECONDS * _mean(angle.error, motion))


def _summarize_contacts(motion: Series) -> ContactSummary:
    """Return the mean number of contacts, and the largest penetration [um] and force [N] of one contact.

    The mean is over full periods, the extremes are over all evaluated samples. `motion` are the time series of the run.
    """
    run, is_evaluated = motion.run, motion.evaluation_mask
    return ContactSummary(
        mean_active=_mean(run["contacts"], motion),
        max_penetration_um=1e6 * float(run["penetration"][is_evaluated].max()),
        peak_force_n=float(run["peak_force"][is_evaluated].max()),
    )


def _summarize_crank_bearings(motion: Series) -> CrankBearings | None:
    """Return the largest force of any crank on a disc of an RV reducer, and the largest of their mean forces [N].

    The mean force of a crank is the equivalent load of a roller bearing (exponent 10/3) over full periods. Return None
    without cranks, or if their forces were not logged. `motion` are the time series of the run.
    """
    kind = names.KINDS[names.CRANK]
    if not motion.run.pairs(kind):
        return None
    crank_forces = np.linalg.norm(motion.run.forces(kind), axis=2)
    means = [mean_force(bearing) for bearing in crank_forces[motion.whole_periods].T]
    return CrankBearings(float(crank_forces[motion.evaluation_mask].max()), max(means))


def _pin_1(motion: Series) -> Pin1 | None:
    pin = motion.pin_1
    return Pin1(1e6 * peak(pin.radial[motion.evaluation_mask]), _mean(pin.spin, motion)) if pin else None


def _ramp(motion: Series) -> Ramp | None:
    rows = motion.ramp
    if not rows.any():
        return None
    velocity = _velocity(motion.q_velocity, rows)
    return Ramp(_path(motion, rows), velocity, _compare_accelerations(motion, rows), int(rows.sum()))


def _mean_powers(motion: Series) -> Power:
    """Return mean input and output power [W], mean torques of driven shaft and load, and ideal input torque [N m].

    All are means over full periods. The driven shaft is the crank, or the sun of an RV reducer. Input power is positive
    if it flows into the drive, output power if it flows into the load. Both are therefore positive if the motor drives
    the load, and negative if the load drives the motor. Torques have the sign of the log: positive counter-clockwise.
    The ideal input torque balances the load torque without losses. `motion` are the time series of the run.
    """
    run, driven_shaft = motion.run, motion.run.driven_shaft
    load_torque = _mean(run["load_torque"], motion)
    return Power(
        input_w=_mean(run[f"{driven_shaft}_torque"] * run[f"{driven_shaft}_speed"], motion),
        output_w=_mean(-run["load_torque"] * run["output_speed"], motion),
        crank_torque_nm=_mean(run[f"{driven_shaft}_torque"], motion),
        ideal_crank_torque_nm=-load_torque / motion.design.ratio,
        load_torque_nm=load_torque,
    )


def _efficiency(power: Power, motion: Series) -> float | None:
    is_loaded = motion.design.load.torque > 0 and power.input_w > 0
    return Powers(power.input_w, -power.output_w).efficiency if is_loaded and motion.phase == "hold" else None


def _mean_losses(motion: Series) -> tuple[Loss, ...]:
    """Return the mean friction and damping losses [W] of each kind of mating pair, over full periods.

    Kinds whose losses are 0 in every sample are omitted. `motion` are the time series of the run.
    """
    run = motion.run
    friction_powers, damping_powers = run.by_stem(FRICTION_POWER), run.by_stem(NORMAL_POWER)
    losses = []
    for kind, friction_power in sorted(friction_powers.items()):
        damping_power = damping_powers.get(kind, np.zeros(len(run)))
        if friction_power.any() or damping_power.any():
            losses.append(Loss(kind, _mean(friction_power, motion), _mean(damping_power, motion)))
    return tuple(losses)


def _window(motion: Series) -> Window:
    time, angle = motion.time[motion.evaluation_mask], motion.crank_angle[motion.evaluation_mask]
    turns = float(abs(angle[-1] - angle[0]) / (2 * np.pi))
    return Window(float(time[0]), float(time[-1]), time.size, turns, motion.phase)


def _mean(values: Array, motion: Series) -> float:
    return float(np.mean(values[motion.whole_periods]))
