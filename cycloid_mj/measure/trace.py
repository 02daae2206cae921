"""Runs of the transmission error: one condition each, evaluated on a grid of crank angles."""

from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.analysis.transmission import gear_error, output_error
from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.dynamics.drive_cycle import DriveCycle, braking_sign, load_torque, servo_target
from cycloid_mj.dynamics.planar.model import PlanarModel
from cycloid_mj.dynamics.run import Model, simulate
from cycloid_mj.dynamics.settling import slowness
from cycloid_mj.geometry.kinematics import CrankLaw
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.rv_motion import runout_at
from cycloid_mj.statics.structure import wind_up


@dataclass(frozen=True)
class TraceSettings:
    """Settings of the runs of transmission error and vibration."""

    settling: float = 0.020
    rise: float = 0.008
    """Time before the evaluated window, and rise time of the load [s]."""
    samples: int = 48
    """Samples of a mesh period."""
    checked_periods: int = 3
    """Mesh periods that are run again with half the time step."""
    slow_share: float = 0.25
    """Slow crank speed relative to the design's."""


TRACE = TraceSettings()


@dataclass(frozen=True)
class TraceCondition:
    """Load, direction and speed of a run."""

    load: str
    direction: str
    pace: str
    """``unloaded`` or ``loaded``; ``forward`` (counter-clockwise) or ``reverse``; ``slow`` or ``speed``."""
    torque: float
    """Against the output's rotation [N m]."""
    speed: float
    """Speed of the driven shaft [rad/s], signed: of the crank, or of the sun of an RV reducer."""

    @property
    def key(self) -> str:
        """Key of the condition."""
        return f"{self.load}_{self.direction}_{self.pace}"

    @property
    def words(self) -> str:
        """The condition in words."""
        return f"{self.load}, {self.direction}, {'slow' if self.pace == 'slow' else 'at speed'}"


@dataclass(frozen=True, eq=False)
class ErrorCurves:
    """Errors of disc and output [arcsec] at increasing crank angles [rad] from 0, shape (n,) each."""

    crank: Array
    gear: Array
    output: Array

    @property
    def stage(self) -> Array:
        """Rotation of the output relative to the disc [arcsec], shape (n,)."""
        return self.output - self.gear


@dataclass(frozen=True, eq=False)
class Trace(ErrorCurves):
    """The errors of a run, and the run."""

    run: Run


def copy_model(compiled: Model) -> Model:
    """Copy a model with its specification: one cannot be written to XML by two threads at a time."""
    if isinstance(compiled, PlanarModel):
        return compiled
    return replace(compiled, spec=compiled.spec.copy())


def preload_cycle(reducer: Reducer, model: Model, start: float = 0.0) -> DriveCycle:
    """Return a drive cycle (commands over time) at constant speed that begins with a pulse of the load.

    The pulse presses the flanks together. With a light load, the disc oscillates in its clearance for about 30 ms. The
    pulse, a squared sine with a peak of up to the nominal torque, shortens this to a few milliseconds. `start` is the
    initial angle of the driven shaft [rad]. `model` is the compiled model of the design.
    """
    design = reducer.design
    crank_law, brake_sign = CrankLaw(design.drive.speed, 0.0), braking_sign(reducer)
    pulse_torque = max(design.rated_torque - design.load.torque, 0.0)

    def load(time: Array) -> Array:
        return (
            load_torque(reducer, time)
            + brake_sign * pulse_torque * np.sin(np.pi * np.clip(time / 0.016, 0.0, 1.0)) ** 2
        )

    return DriveCycle(start, design.drive.speed, lambda time: start + servo_target(model, crank_law, time), load)


def run_trace(reducer: Reducer, model: Model, turns: float, condition: TraceCondition) -> Trace:
    """Simulate a design over some crank turns; return the transmission errors of disc and output over the crank angle.

    `condition` has load, speed and direction, `model` is the compiled model of the design. A run with increasing crank
    angle starts at the angle 0, one with decreasing angle at the number of turns, rounded up. Over an integer number of
    turns, both directions therefore cover the same angles.
    """
    crank_speed = float(reducer.member.crank_angle(condition.speed))
    direction = float(np.sign(crank_speed))
    sample_rate = TRACE.samples * reducer.mesh_periods * abs(crank_speed) / (2.0 * np.pi)
    settling_time = TRACE.settling * slowness(reducer)
    reducer = reducer.steady(
        settling_time,
        turns,
        samples=4.0,
        drive={"speed": condition.speed},
        load={"torque": condition.torque, "rise": TRACE.rise},
        settings={"log_rate": min(sample_rate, 1.0 / model.timestep)},
    )
    # Both directions cover the same angles, so that their curves can be compared.
    start_angle = (0.0 if direction > 0.0 else 2.0 * np.pi * np.ceil(turns)) - crank_speed * settling_time
    run = simulate(
        reducer.design, model, preload_cycle(reducer, model, float(reducer.member.driven_angle(start_angle)))
    )
    settled_run = run.select(run.time >= settling_time - 2.0 / reducer.design.settings.log_rate)
    return _resample_errors(settled_run, reducer, turns, direction)


def _resample_errors(run: Run, reducer: Reducer, turns: float, direction: float) -> Trace:
    """Resample the errors of disc and output [arcsec] at equal steps of the crank angle, by a cubic spline.

    `turns` is the number of crank turns; `direction` is 1 if the crank angle increases in the run, -1 if it decreases.
    The angles of the result always increase; the last angle is one step before the end of the turns.
    """
    from scipy.interpolate import CubicSpline

    ascending_order = slice(None, None, int(direction))
    crank_angle = reducer.member.crank_angle(run[f"{run.driven_shaft}_angle"])[ascending_order]
    angle_count = round(TRACE.samples * reducer.mesh_periods * turns)
    span = 2.0 * np.pi * turns
    start_angle = 0.0 if direction > 0.0 else 2.0 * np.pi * np.ceil(turns) - span
    angles = start_angle + span * np.arange(angle_count) / angle_count
    # linear interpolation would lose 2.6 % of the third harmonic of the mesh
    shaft_twist = wind_up(reducer) * run["load_torque"]
    errors = (gear_error(run, reducer), output_error(run, reducer) + shaft_twist)
    gear_errors, output_errors = (
        ARCSECONDS * CubicSpline(crank_angle, error[ascending_order])(angles) for error in errors
    )
    if isinstance(reducer, RvReducer):
        output_errors = output_errors + ARCSECONDS * runout_at(reducer, angles)
    return Trace(angles, gear_errors, output_errors, run)
