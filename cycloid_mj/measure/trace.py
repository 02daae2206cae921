"""Runs of the transmission error: one condition each, evaluated on a grid of crank angles."""

from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.analysis.transmission import gear_error, output_error
from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.dynamics.drive_cycle import DriveCycle, braking, load_torque, servo_target
from cycloid_mj.dynamics.planar.model import PlanarModel
from cycloid_mj.dynamics.run import Model, simulate
from cycloid_mj.dynamics.settling import slowness
from cycloid_mj.geometry.kinematics import CrankLaw
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.structure import wind_up

SETTLING, RISE = 0.020, 0.008
"""Time before the window, and rise time of the load [s]."""
SAMPLES = 48
"""Samples of a mesh period."""


@dataclass(frozen=True)
class TraceCondition:
    """Load, direction and speed of a run."""

    load: str
    way: str
    pace: str
    """``unloaded`` or ``loaded``; ``forward`` (counter-clockwise) or ``reverse``; ``slow`` or ``speed``."""
    torque: float
    """Against the output's rotation [N m]."""
    speed: float
    """Of the crank [rad/s], signed."""

    @property
    def key(self) -> str:
        """Key of the condition."""
        return f"{self.load}_{self.way}_{self.pace}"

    @property
    def words(self) -> str:
        """The condition in words."""
        return f"{self.load}, {self.way}, {'slow' if self.pace == 'slow' else 'at speed'}"


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


def preload_cycle(reducer: Reducer, compiled: Model, start: float = 0.0) -> DriveCycle:
    """Return the drive cycle at constant speed from a crank angle [rad], with the flanks pressed together first.

    With a light drag alone the disc oscillates in its clearance for some 30 ms; a pulse of up to the nominal torque, a
    sine squared, shortens this to a few ms.
    """
    design = reducer.design
    law, way = CrankLaw(design.drive.speed, 0.0), braking(reducer)
    press = max(design.rated_torque - design.load.torque, 0.0)

    def load(time: Array) -> Array:
        return load_torque(reducer, time) + way * press * np.sin(np.pi * np.clip(time / 0.016, 0.0, 1.0)) ** 2

    return DriveCycle(start, design.drive.speed, lambda time: start + servo_target(compiled, law, time), load)


def run_trace(reducer: Reducer, compiled: Model, turns: float, case: TraceCondition) -> Trace:
    """Run a condition over some crank turns from the crank angle 0, or back to it from a full turn."""
    way = float(np.sign(case.speed))
    per_second = SAMPLES * reducer.mesh_periods * abs(case.speed) / (2.0 * np.pi)
    settling = SETTLING * slowness(reducer)
    reducer = reducer.steady(
        settling,
        turns,
        samples=4.0,
        drive={"speed": case.speed},
        load={"torque": case.torque, "rise": RISE},
        settings={"log_rate": min(per_second, 1.0 / compiled.timestep)},
    )
    # Both directions cover the same angles, so that their curves can be compared.
    start = (0.0 if way > 0.0 else 2.0 * np.pi * np.ceil(turns)) - case.speed * settling
    run = simulate(reducer.design, compiled, preload_cycle(reducer, compiled, start))
    window = run.select(run.time >= settling - 2.0 / reducer.design.settings.log_rate)
    return _read(window, reducer, turns, way)


def _read(run: Run, reducer: Reducer, turns: float, sense: float) -> Trace:
    """Evaluate the errors at equal intervals of the crank angle, without the end of the window."""
    from scipy.interpolate import CubicSpline

    order = slice(None, None, int(sense))
    crank = run["crank_angle"][order]
    points = round(SAMPLES * reducer.mesh_periods * turns)
    swept = 2.0 * np.pi * turns
    first = 0.0 if sense > 0.0 else 2.0 * np.pi * np.ceil(turns) - swept
    grid = first + swept * np.arange(points) / points
    # linear interpolation would lose 2.6 % of the third harmonic of the mesh
    twisted = wind_up(reducer) * run["load_torque"]
    turns_by = (gear_error(run, reducer), output_error(run, reducer) + twisted)
    gear, output = (ARCSECONDS * CubicSpline(crank, turn[order])(grid) for turn in turns_by)
    return Trace(grid, gear, output, run)
