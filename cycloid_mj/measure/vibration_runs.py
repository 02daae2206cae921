"""Runs of the vibration measure: one speed and load each, with signals relative to their closed form or mean.

Contacts cause vibration far above the log rate: a run is oversampled, low-pass filtered against aliasing, and
decimated.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.analysis import series
from cycloid_mj.analysis.spectrum import decimate
from cycloid_mj.base.array import Array
from cycloid_mj.base.names import PEAK_FORCE, column, gears, planar_speeds
from cycloid_mj.base.record import Run
from cycloid_mj.base.statistics import rms
from cycloid_mj.base.units import RPM
from cycloid_mj.comparison.vibration import acceleration
from cycloid_mj.dynamics.run import Model, simulate
from cycloid_mj.dynamics.settling import slowness
from cycloid_mj.measure.conditions import STEADY
from cycloid_mj.measure.reaction import (
    bearing_reactions,
    carrier_tilting,
    inertia_force,
    reaction,
    without_counterweight,
)
from cycloid_mj.measure.trace import TRACE, preload_cycle
from cycloid_mj.reducer import Reducer, RvReducer

ACCELERATIONS = ("gear_centre", "output", "momentum")
"""Signals that are differences of velocities: means between samples."""


@dataclass(frozen=True, eq=False)
class VibrationRun:
    """Vibration at one speed and load over full crank turns, up to half of the stored rate."""

    load: str
    """``unloaded`` or ``loaded``."""
    speed: float
    """Speed of the driven shaft, crank or sun [rad/s], signed."""
    crank_speed: float
    """Speed of the crank or cranks against the ground [rad/s], signed."""
    crank: Array
    """Swept crank angles [rad], increasing, shape (n,)."""
    signals: Mapping[str, Array]
    """Key -> departures from the closed form or the mean: ``gear_centre`` [m/s2], (n, 2), ``output`` [rad/s2], (n, 1),
    ``housing``, ``housing_bare`` (without counterweight) and ``momentum`` [N], (n, 2). The last is the force on the
    housing by the accelerations of gears and shaft alone, without that of free pins. ``housing_bare`` is that of a
    single disc with a central crank. Of several discs the centre is the first's, and there are ``shaft_tilting`` and
    ``output_tilting`` [N m], the moments of the discs' forces about the middle of all, ``shaft_bearing_far`` and
    ``shaft_bearing_near`` [N], (n, 2); of an RV reducer there is only ``output_tilting``, on the carrier."""
    orbit: float
    """The rms magnitude of the gear centre's acceleration [m/s2]."""
    rate: float
    """Samples kept per second."""
    sampled_rms: Mapping[str, float]
    """Key -> rms magnitude of a signal including frequencies above half of the rate, up to half of `sampled_rate`."""
    sampled_rate: float
    """Samples taken per second."""
    mean_force: Array
    """Mean force on the housing [N], shape (2,)."""
    run: Run
    """The complete run."""

    def rms(self, key: str) -> float:
        """Compute the rms magnitude of a signal."""
        return rms(self.signals[key])

    def above(self, key: str) -> float:
        """Compute the share of a signal's power above half of the rate; 0 without vibration."""
        return max(0.0, 1.0 - (self.rms(key) / self.sampled_rms[key]) ** 2) if self.sampled_rms[key] else 0.0

    def rotating(self, key: str) -> float:
        """Compute the magnitude of the part of a vector signal that rotates with the crank."""
        x, y = self.signals[key].T
        return float(abs(np.mean((x + 1j * y) * np.exp(-1j * np.sign(self.crank_speed) * self.crank))))

    @property
    def rpm(self) -> float:
        """Speed of the driven shaft [rpm]."""
        return self.speed / RPM


def run_vibration(reducer: Reducer, model: Model, load: str, torque: float, speed: float, turns: int) -> VibrationRun:
    """Simulate a design over some crank turns, after it has settled; return the vibration signals in that time.

    The closed-form accelerations are subtracted from the accelerations of disc centre and output, and the mean is
    subtracted from all other signals. Signals are sampled at up to ten times the stored rate, low-pass filtered and
    decimated. `model` is the compiled model of the design, `load` is ``unloaded`` or ``loaded``, `torque` the torque on
    the output [N m] and `speed` the speed of the driven shaft [rad/s].
    """
    # at most ten samples are taken for each stored one
    stride = max(1, min(10, int(1.0 / (STEADY.log_rate * model.timestep) + 1e-6)))
    settling_time = TRACE.settling * slowness(reducer)
    reducer = reducer.steady(
        settling_time,
        turns,
        # for the filter and the differences
        samples=12 * stride,
        drive={"speed": speed},
        load={"torque": torque, "rise": TRACE.rise},
        settings={"log_rate": stride * STEADY.log_rate},
    )
    run = simulate(reducer.design, model, preload_cycle(reducer, model))
    interval = float(np.mean(np.diff(run.time)))
    residuals, crank_speed = acceleration(series(run, settle=settling_time)), float(reducer.member.crank_angle(speed))
    disc_accelerations = [
        np.diff(run.block(planar_speeds(gear)[:2]), axis=0) / interval for gear in gears(reducer.design.gear.discs)
    ]
    first_acceleration = disc_accelerations[0]
    force = reaction(run, reducer).total
    signals = {
        "gear_centre": residuals.centre,
        "output": residuals.output[:, np.newaxis],
        "housing": force,
        "momentum": inertia_force(run, reducer, disc_accelerations),
    }
    if reducer.design.gear.discs > 1:
        signals |= _tilting_signals(run, reducer)
    elif not isinstance(reducer, RvReducer):
        signals["housing_bare"] = without_counterweight(run, reducer, force)
    decimated_signals = {key: decimate(signal, stride, key in ACCELERATIONS) for key, signal in signals.items()}
    first_row = int(np.searchsorted(run.time[::stride], settling_time))
    window_rows = slice(first_row, first_row + round(turns * 2.0 * np.pi / abs(crank_speed) / (stride * interval)))
    sampled_rows = slice(stride * window_rows.start, stride * window_rows.stop)
    return VibrationRun(
        load=load,
        speed=speed,
        crank_speed=crank_speed,
        crank=np.abs(reducer.member.crank_angle(run[f"{reducer.INPUT}_angle"][::stride][window_rows])),
        signals={key: _remove_mean(key, signal[window_rows]) for key, signal in decimated_signals.items()},
        orbit=rms(decimate(first_acceleration, stride, means=True)[window_rows]),
        rate=1.0 / (stride * interval),
        sampled_rms={key: rms(_remove_mean(key, signal[sampled_rows])) for key, signal in signals.items()},
        sampled_rate=1.0 / interval,
        mean_force=decimated_signals["housing"][window_rows].mean(axis=0),
        run=_decimate_run(run, stride),
    )


def _tilting_signals(run: Run, reducer: Reducer) -> dict[str, Array]:
    """Return tilting moments and bearing forces of a run with several discs by name, in n samples (n, 2) each.

    The discs' forces on shaft and output cause the moments [N m], ``shaft_tilting`` and ``output_tilting``. The forces
    [N] act on both shaft bearings, ``shaft_bearing_far`` and ``shaft_bearing_near``. An RV reducer has only the moment
    on the carrier, ``output_tilting``.
    """
    if isinstance(reducer, RvReducer):
        return {"output_tilting": carrier_tilting(run, reducer)}
    reactions = bearing_reactions(run, reducer)
    return {
        "shaft_tilting": reactions.shaft.moment,
        "output_tilting": reactions.output.moment,
        "shaft_bearing_far": reactions.shaft_far,
        "shaft_bearing_near": reactions.shaft_near,
    }


def _remove_mean(key: str, signal: Array) -> Array:
    """Return a force minus its mean; an acceleration is returned unchanged."""
    return signal if key in ("gear_centre", "output") else signal - signal.mean(axis=0)


def _decimate_run(run: Run, stride: int) -> Run:
    """Return a run with every `stride`-th sample of a run.

    A peak of a contact force is the largest of the peaks since the last sample that the result contains.
    """
    decimated_run = run.select(slice(None, None, stride))
    starts = np.maximum(np.arange(len(decimated_run)) * stride - stride + 1, 0)
    peaks = {
        column(pair, PEAK_FORCE): np.maximum.reduceat(peak[: starts[-1] + stride], starts)
        for pair, peak in run.by_stem(PEAK_FORCE).items()
    }
    return replace(decimated_run, columns={**decimated_run.columns, **peaks})
