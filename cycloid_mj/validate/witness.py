"""Validation step "witness": MuJoCo against the planar solver at high friction and at high speed.

Halving the time step cannot reveal how a constraint solver affects friction in every step. The planar solver
(``dynamics.planar``) has its own equations of motion and computes friction from the contact force.
"""

import numpy as np

from cycloid_mj.analysis.transmission import output_error
from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.powers import Powers
from cycloid_mj.base.record import Run
from cycloid_mj.base.statistics import peak_to_peak, rms
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.base.validation import ValidationRow, absolute, relative
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate.rig import FIXED, RATED_LOAD, SETTLED, clearances, reducer_of, without_gravity

STEP = 1e-6
"""Time step of the planar solver [s]; half of it changes the figures by less than 0.2 %."""

JUDGED_PERIODS = 48
"""Tooth passing periods at the end of a run over which it is evaluated."""

CONDITIONS = ["drive.ramp_s=0.0", "drive.rotor_inertia_kg_m2=1.0", "settings.log_rate_hz=50000.0", *without_gravity()]
"""A crank of large inertia, and no gravity."""


def high_friction() -> Design:
    """Return the paper's reducer with fixed pins and a tooth friction of 0.3, at its load and speed."""
    hold = SETTLED + JUDGED_PERIODS * 60.0 / (1640.0 * 36.0)
    return reducer_of(
        FIXED, *CONDITIONS, "friction.pin_gear=0.3", f"load.torque_nm={RATED_LOAD}", f"drive.hold_s={hold!r}"
    )


def high_speed() -> Design:
    """Return the preset `twodisc` at 12 000 rpm with clearances of 2 um, under 5 % of its load."""
    preset = PRESETS["twodisc"]
    load = [f"load.torque_nm={0.05 * preset.rated_torque!r}", "drive.speed_rpm=12000.0", *clearances(2.0)]
    hold = 5.0 * SETTLED + JUDGED_PERIODS * 60.0 / (12000.0 * preset.ring.teeth)  # a light load damps less
    return override(preset, [*CONDITIONS, *load, f"drive.hold_s={hold!r}"])


CASES = {"fixed pins, friction 0.3": high_friction, "two discs, 12 000 rpm": high_speed}

BOUNDS = (0.02, 0.5, 0.01, 0.01, 1.1)
"""Bounds of mean and peak-to-peak transmission error, cam force [%], efficiency [points] and rms speed [%].

Twice the largest differences, those of two discs (0.007, 0.22, 0.004 %, 0.004 points, 0.53 %). With fixed pins all are
below 0.2 %.
"""


def rows(quick: bool) -> list[ValidationRow]:
    """Return the rows of this step."""
    return [row for which, design in CASES.items() for row in rows_of(which, Reducer(design()))]


def rows_of(which: str, reducer: Reducer) -> list[ValidationRow]:
    """Compare a MuJoCo run of a design with the planar solver; `which` names the case."""
    units = ("arcsec", "arcsec", "N", "%", "mrad/s")
    quantities = (
        "mean transmission error",
        "p-p transmission error",
        "mean cam force",
        "efficiency",
        "rms gear speed error",
    )
    judges = (relative, relative, relative, absolute, relative)
    pairs = zip(figures(reducer, simulate(reducer.design)), planar_figures(reducer), strict=True)
    return [
        judge_row(f"{name}, {which}", ours, theirs, unit, "planar solver", bound)
        for (ours, theirs), name, unit, bound, judge_row in zip(pairs, quantities, units, BOUNDS, judges, strict=True)
    ]


def planar_figures(reducer: Reducer, timestep: float = STEP) -> tuple[float, ...]:
    """Compute the figures of `BOUNDS` by the planar solver."""
    return figures(reducer, simulate(reducer.design, planar_model(reducer, timestep=timestep)))


def figures(reducer: Reducer, run: Run) -> tuple[float, ...]:
    """Compute the figures of `BOUNDS` of a run."""
    design = reducer.design
    judged = JUDGED_PERIODS * 2.0 * np.pi / (design.ring.teeth * abs(design.drive.speed))
    late = run.select(run.time >= max(design.drive.hold - judged, SETTLED))
    gear = names.of_disc(names.GEAR, 0, design.gear.discs)
    powers = late["crank_torque"] * late["crank_speed"], late["load_torque"] * late["output_speed"]
    speed = late[f"{gear}_speed"] + late["crank_speed"] / design.lobes
    speed = speed - speed.mean()  # where the ring turns, gears do not
    return _figures(output_error(late, reducer), late.forces("cam")[:, 0], powers, speed)


def _figures(error: Array, cam: Array, powers: tuple[Array, Array], speed: Array) -> tuple[float, ...]:
    """Compute the figures from output error [rad], cam force [N], powers of crank and output [W], and speed error."""
    crank, output = (float(power.mean()) for power in powers)
    return (
        ARCSECONDS * float(error.mean()),
        ARCSECONDS * peak_to_peak(error),
        float(np.hypot(cam[:, 0], cam[:, 1]).mean()),
        100.0 * Powers(crank, output).efficiency,
        1e3 * rms(speed),
    )
