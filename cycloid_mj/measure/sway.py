"""Runs for the vibration: one speed and load each, with what sways there about its closed form or mean."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.analysis import series
from cycloid_mj.comparison.vibration import acceleration
from cycloid_mj.design import Design
from cycloid_mj.measure.conditions import LOG_RATE, RPM, at_speed, turn_period
from cycloid_mj.measure.reaction import masses, reaction, shaft_acceleration, without_counterweight
from cycloid_mj.measure.trace import RISE, SETTLING, pressed
from cycloid_mj.mjcf import ReducerModel
from cycloid_mj.mjcf.names import GEAR, SHAFT
from cycloid_mj.record import Run
from cycloid_mj.simulate import simulate

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sway:
    """What sways at one speed and load, over whole crank turns; each value the mean from a sample to the next.

    Attributes
    ----------
    load
        ``unloaded`` or ``loaded``.
    speed
        Of the crank [rad/s], signed.
    crank
        Swept crank angles [rad], increasing, shape (n,).
    signals
        Key -> departures from the closed form or the mean: ``gear_centre`` [m/s2], (n, 2), ``output`` [rad/s2],
        (n, 1), ``housing``, ``housing_bare`` (without counterweight) and ``momentum`` [N], (n, 2). The last is the
        force on the housing by the accelerations of gear and shaft alone, without that of free pins.
    orbit
        The rms size of the gear centre's acceleration [m/s2].
    mean_force
        On the housing [N], shape (2,).
    run
        The whole run.
    """

    load: str
    speed: float
    crank: Array
    signals: Mapping[str, Array]
    orbit: float
    mean_force: Array
    run: Run

    def rms(self, key: str) -> float:
        """Give the rms size of a signal."""
        return rms(self.signals[key])

    def rms_of_half(self, key: str) -> float:
        """Give the same over the first half of the window: a shorter average."""
        return rms(self.signals[key][: len(self.crank) // 2])

    def rotating(self, key: str) -> float:
        """Give the size of the part of a signal of vectors that goes round with the crank."""
        x, y = self.signals[key].T
        return float(abs(np.mean((x + 1j * y) * np.exp(-1j * np.sign(self.speed) * self.crank))))

    @property
    def rpm(self) -> float:
        """Crank speed [rpm]."""
        return self.speed / RPM


def rms(signal: Array) -> float:
    """Give the rms size of vectors (n, k)."""
    return float(np.sqrt(np.mean(np.sum(signal**2, axis=1))))


def sway(design: Design, reducer: ReducerModel, load: str, torque: float, speed: float, turns: int) -> Sway:
    """Run a design at a crank speed [rad/s] under a torque [N m], over some crank turns after it has settled.

    Raises
    ------
    RunError
        The run went wrong.
    """
    swept_time = turns * turn_period(speed)
    design = at_speed(design, speed, SETTLING + swept_time + 4.0 / LOG_RATE, torque, RISE, LOG_RATE)
    run = simulate(design, reducer, pressed(design, reducer))
    step = float(np.mean(np.diff(run.time)))
    first = int(np.searchsorted(run.time, SETTLING))
    rows = slice(first, first + round(swept_time / step))
    of, found = masses(design), acceleration(series(run, settle=SETTLING))
    orbit = np.diff(run.block(["gear_vx", "gear_vy"]), axis=0) / step
    whole = reaction(run, design).whole
    signals = {
        "gear_centre": found.centre,
        "output": found.output[:, np.newaxis],
        "housing": whole,
        "housing_bare": without_counterweight(run, design, whole),
        "momentum": -of[GEAR].mass * orbit - of[SHAFT].mass * shaft_acceleration(run, of[SHAFT])[1:],
    }
    of_forces = ("housing", "housing_bare", "momentum")
    kept = {key: signal[rows] - signal[rows].mean(axis=0) * (key in of_forces) for key, signal in signals.items()}
    swept = np.abs(run["crank_angle"][rows])
    return Sway(load, speed, swept, kept, rms(orbit[rows]), whole[rows].mean(axis=0), run)
