"""Validation step "witness": MuJoCo against the planar solver at high friction and at high speed.

Halving the time step cannot reveal how a constraint solver affects friction in every step. The planar solver
(``dynamics.planar``) has its own equations of motion and computes friction from the contact force.
"""

from dataclasses import dataclass

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
from cycloid_mj.validate.rig import FIXED, RATED_LOAD, SETTLED, clearances, design_of_kind, without_gravity


@dataclass(frozen=True)
class WitnessSettings:
    """Settings of the comparison of both solvers."""

    timestep: float = 1e-6
    """Time step of the planar solver [s]; half of it changes the figures by less than 0.2 %."""
    periods: int = 48
    """Tooth passing periods at the end of a run over which it is evaluated."""
    bounds: tuple[float, ...] = (0.02, 0.5, 0.01, 0.01, 1.1)
    """Bounds of mean and peak-to-peak transmission error, cam force [%], efficiency [points] and rms speed [%].

    Twice the largest differences, those of two discs (0.007, 0.22, 0.004 %, 0.004 points, 0.53 %). With fixed pins all
    are below 0.2 %.
    """


WITNESS = WitnessSettings()


CONDITIONS = ["drive.ramp_s=0.0", "drive.rotor_inertia_kg_m2=1.0", "settings.log_rate_hz=50000.0", *without_gravity()]
"""A crank of large inertia, and no gravity."""


def high_friction() -> Design:
    """Return the paper's reducer with fixed pins and a tooth friction of 0.3, at its load and speed."""
    hold = SETTLED + WITNESS.periods * 60.0 / (1640.0 * 36.0)
    return design_of_kind(
        FIXED, *CONDITIONS, "friction.pin_gear=0.3", f"load.torque_nm={RATED_LOAD}", f"drive.hold_s={hold!r}"
    )


def high_speed() -> Design:
    """Return the preset `twodisc` at 12 000 rpm with clearances of 2 um and Coulomb friction, under 5 % of its load."""
    preset = PRESETS["twodisc"]
    load = [f"load.torque_nm={0.05 * preset.rated_torque!r}", "drive.speed_rpm=12000.0", "friction.law=coulomb"]
    hold = 5.0 * SETTLED + WITNESS.periods * 60.0 / (12000.0 * preset.ring.teeth)  # a light load damps less
    return override(preset, [*CONDITIONS, *load, *clearances(2.0), f"drive.hold_s={hold!r}"])


CASES = {"fixed pins, friction 0.3": high_friction, "two discs, 12 000 rpm": high_speed}


def rows(quick: bool) -> list[ValidationRow]:
    """Return the comparisons of this validation step, the rows of its table; `quick` has no effect."""
    return [row for case, create_design in CASES.items() for row in comparison_rows(case, Reducer(create_design()))]


def comparison_rows(case: str, reducer: Reducer) -> list[ValidationRow]:
    """Compare a MuJoCo run of a design with the planar solver, and return a row for each of five quantities.

    They are mean and peak-to-peak transmission error of the output, mean cam force, efficiency, and rms speed error of
    the disc, see `figures`. `case` names the design in the rows.
    """
    units = ("arcsec", "arcsec", "N", "%", "mrad/s")
    quantities = (
        "mean transmission error",
        "p-p transmission error",
        "mean cam force",
        "efficiency",
        "rms gear speed error",
    )
    comparisons = (relative, relative, relative, absolute, relative)
    value_pairs = zip(figures(reducer, simulate(reducer.design)), planar_figures(reducer), strict=True)
    return [
        compare(f"{name}, {case}", value, reference, unit, "planar solver", bound)
        for (value, reference), name, unit, bound, compare in zip(
            value_pairs, quantities, units, WITNESS.bounds, comparisons, strict=True
        )
    ]


def planar_figures(reducer: Reducer, timestep: float = WITNESS.timestep) -> tuple[float, ...]:
    """Compute the quantities of `WITNESS.bounds` by the planar solver."""
    return figures(reducer, simulate(reducer.design, planar_model(reducer, timestep=timestep)))


def figures(reducer: Reducer, run: Run) -> tuple[float, ...]:
    """Compute the compared results of a run over its last mesh periods, in the order of `WITNESS.bounds`.

    They are mean and peak-to-peak transmission error of the output [arcsec], mean magnitude of the cam force [N],
    efficiency [%] and rms speed error of the first disc about its mean [mrad/s]. There are `WITNESS.periods` mesh
    periods.
    """
    design = reducer.design
    duration = WITNESS.periods * 2.0 * np.pi / (design.ring.teeth * abs(design.drive.speed))
    evaluated_run = run.select(run.time >= max(design.drive.hold - duration, SETTLED))
    gear = names.of_disc(names.GEAR, 0, design.gear.discs)
    powers = (
        evaluated_run["crank_torque"] * evaluated_run["crank_speed"],
        evaluated_run["load_torque"] * evaluated_run["output_speed"],
    )
    speed_error = evaluated_run[f"{gear}_speed"] + evaluated_run["crank_speed"] / design.lobes
    speed_error = speed_error - speed_error.mean()  # where the ring turns, gears do not
    return _compute_quantities(
        output_error(evaluated_run, reducer), evaluated_run.forces("cam")[:, 0], powers, speed_error
    )


def _compute_quantities(
    error: Array, cam_force: Array, powers: tuple[Array, Array], speed_error: Array
) -> tuple[float, ...]:
    """Compute the results by which MuJoCo and the planar solver are compared, over n samples.

    Parameters
    ----------
    error
        Transmission error of the output [rad], shape (n,).
    cam_force
        Force of the cam [N], shape (n, 2).
    powers
        Power of the crank and of the load on the output [W], shape (n,) each.
    speed_error
        Speed of the disc minus its ideal speed [rad/s], shape (n,).

    Returns
    -------
    tuple of float
        Mean and peak-to-peak error [arcsec], mean magnitude of the cam force [N], efficiency [%], rms speed error
        [mrad/s].
    """
    crank_power, output_power = (float(power.mean()) for power in powers)
    return (
        ARCSECONDS * float(error.mean()),
        ARCSECONDS * peak_to_peak(error),
        float(np.hypot(cam_force[:, 0], cam_force[:, 1]).mean()),
        100.0 * Powers(crank_power, output_power).efficiency,
        1e3 * rms(speed_error),
    )
