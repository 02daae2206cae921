"""Hysteresis loop of a reducer at a locked crank, and its characteristic values.

The torque on the output is T sin^5(2 pi t/period): it passes zero so slowly that the parts come to rest on the other
side of the clearance before the torque matters. The first quarter leads to the loop.

Lost motion, as the industry defines it, is the turn between the middles of the two branches at +3 % and -3 % of the
nominal torque; stiffness is the slope from 50 to 100 %; backlash is the turn between the unloading branches,
extrapolated to zero torque.
"""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis.transmission import gear_error, output_error
from cycloid_mj.base.array import Array
from cycloid_mj.base.names import FRICTION_POWER, NORMAL_POWER
from cycloid_mj.base.record import Run
from cycloid_mj.dynamics.drive_cycle import Signal
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.dynamics.settling import swing_period
from cycloid_mj.measure import bench
from cycloid_mj.parts import play_inertia
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.structure import wind_up
from cycloid_mj.statics.windup import LOST_MOTION_SHARE, STRAIGHT


@dataclass(frozen=True)
class SlowLoopSettings:
    """Settings of the torque loop at a locked crank, and of its readings."""

    power: int = 5
    """Power of the sine."""
    unloading: tuple[float, float] = (0.005, 0.015)
    """Part of the unloading branch that is extrapolated to zero, relative to the nominal torque."""
    window: float = 0.2
    """Half width of the range of a reading, relative to its torque."""
    arrival: float = 0.003
    """Torque at which a reducer without friction has crossed its clearance, relative to the rated one: a tenth of 3
    %."""
    slowness: float = 40.0
    """Least period of the loop in periods of the lowest vibration of output and gear on the reducer's stiffness."""
    samples: int = 2000
    """Samples of a period."""
    lead: float = 0.25
    """Periods before the loop."""
    angles: int = 6
    quick_angles: int = 2
    """Number of crank angles by default, and of a quick measurement."""
    slower: float = 2.0
    finer: float = 4.0
    """Factors of the numerical checks: on the period, and on the number of time steps."""
    rv_damping_ratio: float = 0.1
    """Damping of the contacts of an RV reducer as a share of critical. Its crank bearings carry most of the deflection,
    so the rotation lags behind the torque by their relaxation time, damping over stiffness. With critical damping,
    loading branches are up to 2 % too stiff and loops without friction 5 % wider than the backlash; at this damping it
    is 0.2 % and 0.8 %, as in a loop that is eight times slower."""


LOOP = SlowLoopSettings()


@dataclass(frozen=True, eq=False)
class HysteresisLoop:
    """A period of the loop, from one peak of the torque to the next."""

    crank: float
    """Angle at which the crank is locked [rad]."""
    rated: float
    """Peak of the torque [N m]."""
    phase: Array
    """Phase in the period of the torque, 0.25 to 1.25, shape (n,)."""
    torque: Array
    turn: Array
    """Torque on the output [N m], and deviation of the output's angle from the ideal one [rad], shape (n,) each."""
    gear_turn: Array
    centre_lead: Array
    """Deviation of the disc's angle [rad], and `bench.centre_lead` [m], shape (n,) each."""
    run: Run
    """The complete run."""

    def read_branch(self, share: float, loading: bool, sign: int, values: Array | None = None) -> float:
        """Read the rotation on a branch of the torque loop at a share of the nominal torque, by a line fit nearby.

        Parameters
        ----------
        share
            Torque relative to the nominal torque.
        loading
            Whether to read the loading branch.
        sign
            Sign of the torque, +1 or -1.
        values
            Values at the n samples of the loop, shape (n,); by default the rotation of the output [rad].

        Returns
        -------
        float
            Value of the line at that torque, in the unit of `values`.
        """
        coefficients = self._fit_branch((1.0 - LOOP.window) * share, (1.0 + LOOP.window) * share, loading, sign, values)
        return float(np.polyval(coefficients, sign * share * self.rated))

    def read_middle(self, share: float, sign: int, values: Array | None = None) -> float:
        """Return the mean of loading and unloading branch at a share of the nominal torque.

        `share` is the torque relative to the nominal torque, `sign` its sign, +1 or -1. `values` (n,) are the values at
        the n samples of the loop, by default the rotation of the output [rad].
        """
        return 0.5 * (self.read_branch(share, True, sign, values) + self.read_branch(share, False, sign, values))

    @property
    def lost_motion(self) -> float:
        """Turn between the middles of the branches at +3 % and -3 % of the nominal torque [rad]."""
        return self.read_middle(LOST_MOTION_SHARE, 1) - self.read_middle(LOST_MOTION_SHARE, -1)

    @property
    def backlash(self) -> float:
        """Turn between the unloading branches, extrapolated to zero torque [rad]."""
        low_angle, high_angle = (
            float(np.polyval(self._fit_branch(*LOOP.unloading, False, side), 0.0)) for side in (-1, 1)
        )
        return high_angle - low_angle

    @property
    def offset(self) -> float:
        """Middle of the loop at +3 % and -3 % of the nominal torque [rad]: where weight shifts it."""
        return 0.5 * (self.read_middle(LOST_MOTION_SHARE, 1) + self.read_middle(LOST_MOTION_SHARE, -1))

    @property
    def stiffness(self) -> float:
        """Torsional stiffness over the straight part [N m/rad]."""
        return 1.0 / self.compliance()

    @property
    def dissipation(self) -> float:
        """Work of friction and contacts over the period by the log [J]; stored energy is released at its end."""
        within = self.run.select(self.run.time >= LOOP.lead / (1.0 + LOOP.lead) * self.run.time[-1])
        power_columns = [name for name in within.columns if name.endswith((FRICTION_POWER, NORMAL_POWER))]
        return float(np.trapezoid(within.block(power_columns).sum(axis=1), within.time))

    @property
    def width(self) -> float:
        """Mean width between the branches at half the nominal torque [rad]: friction."""
        widths = [abs(self.read_branch(0.5, False, side) - self.read_branch(0.5, True, side)) for side in (-1, 1)]
        return float(np.mean(widths))

    @property
    def work(self) -> float:
        """Area of the loop: the work that one period takes [J]."""
        torque, turn = (np.append(values, values[0]) for values in (self.torque, self.turn))
        return float(np.trapezoid(torque, turn))

    def compliance(self, values: Array | None = None) -> float:
        """Compute the compliance of a torque loop: output rotation [rad/(N m)], or n `values` (n,), per torque.

        It is the slope of the mean of the loading and the unloading branch, between the two shares of the nominal
        torque in `STRAIGHT` (1 and 0.5). The result is the mean over both signs of the torque.
        """
        low_share, high_share = STRAIGHT
        rotations = [
            sign * (self.read_middle(high_share, sign, values) - self.read_middle(low_share, sign, values))
            for sign in (-1, 1)
        ]
        return float(np.mean(rotations)) / ((high_share - low_share) * self.rated)

    def _fit_branch(
        self, min_share: float, max_share: float, loading: bool, sign: int, values: Array | None = None
    ) -> Array:
        """Fit a line by least squares to a branch of the loop between two shares of the nominal torque.

        The torque is a sine to an odd power, so that each branch is a quarter of the period.

        Parameters
        ----------
        min_share, max_share
            Torques relative to the nominal torque.
        loading, sign
            Whether the branch is the loading branch, and the sign of its torque.
        values
            Values at the n samples of the loop, shape (n,); by default the rotation of the output [rad].

        Returns
        -------
        Array
            Slope [rad/(N m)] and intercept [rad], shape (2,), or in the unit of `values`.
        """
        # the period begins at the positive peak, with unloading
        quarter = {(False, 1): 0, (True, -1): 1, (False, -1): 2, (True, 1): 3}[loading, sign]
        torque_share = sign * self.torque / self.rated
        is_inside = (
            (np.floor((self.phase - LOOP.lead) * 4.0) == quarter)
            & (min_share <= torque_share)
            & (torque_share <= max_share)
        )
        ordinates = self.turn if values is None else values
        return np.asarray(np.polyfit(self.torque[is_inside], ordinates[is_inside], 1))


def loop_torque(rated: float, period: float) -> Signal:
    """Return the torque of the loop [N m]."""
    return lambda time: rated * np.sin(2.0 * np.pi * time / period) ** LOOP.power


def run_loop(
    reducer: Reducer,
    crank_angle: float,
    peak_torque: float,
    period: float,
    step_divisor: float = 1.0,
    solver: Solver = "planar",
) -> HysteresisLoop:
    """Simulate the torque loop at a locked crank angle [rad]; return torque and motion over its last period.

    The torque on the output is an odd power of a sine. `solver` is the solver of the run, MuJoCo or the planar solver.

    Parameters
    ----------
    peak_torque, period
        Peak [N m] and period [s] of the torque.
    step_divisor
        Divisor of the time step; for retries and errors see `bench.run_with_step_retries`.
    """
    duration, samples = (1.0 + LOOP.lead) * period, round((1.0 + LOOP.lead) * LOOP.samples)
    damping_ratio = LOOP.rv_damping_ratio if isinstance(reducer, RvReducer) else bench.BENCH.damping_ratio
    run = bench.run_with_step_retries(
        reducer,
        crank_angle,
        loop_torque(peak_torque, period),
        peak_torque,
        duration,
        samples,
        step_divisor,
        solver,
        damping_ratio,
    )
    last_period = run.select(run.time >= LOOP.lead * period)
    return HysteresisLoop(
        crank=crank_angle,
        rated=peak_torque,
        phase=last_period.time / period,
        torque=last_period["load_torque"],
        turn=output_error(last_period, reducer) + wind_up(reducer) * last_period["load_torque"],
        gear_turn=gear_error(last_period, reducer),
        centre_lead=reducer.member.sense * bench.centre_lead(last_period, reducer),
        run=run,
    )


def quasi_static_period(reducer: Reducer, peak_torque: float) -> float:
    """Compute the period [s] of a torque loop that is so slow that inertia does not matter.

    It is the shortest period that meets two conditions. Output and discs cross the backlash b [rad] before the torque
    exceeds the share `LOOP.arrival` of its peak T = `peak_torque` [N m]. With the inertia J [kg m2] and the initial
    torque T (omega t)^5, they have crossed it at (omega t)^7 = 42 J b omega^2/T. The period is also at least
    `LOOP.slowness` times the longest oscillation period at a locked driven shaft.
    """
    inertia = play_inertia(reducer)
    angular_frequency = math.sqrt(
        LOOP.arrival ** (7.0 / LOOP.power) * peak_torque / (42.0 * inertia * max(reducer.play, 1e-9))
    )
    return max(2.0 * math.pi / angular_frequency, LOOP.slowness * swing_period(reducer))
