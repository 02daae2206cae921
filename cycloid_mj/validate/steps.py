"""Validation step "steps": figures of a run at rated load for several time steps, against the shortest.

Time steps up to the automatic one must agree; longer steps are listed without a bound, with the observed order of
convergence. A light load is checked, too, where the time step could reverse friction (``dynamics.law.impratio``).
"""

import math
from collections.abc import Mapping
from dataclasses import astuple, dataclass, replace

from scipy.optimize import brentq

from cycloid_mj.analysis import analyze
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.statistics import rms
from cycloid_mj.base.validation import ValidationRow, absolute, relative
from cycloid_mj.dynamics.timestep import timestep
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate.rig import FREE, PERIODS, SLEEVED, rated_design, rated_run

SHARES = {True: (0.5, 1.0), False: (0.1, 0.5, 1.0, 2.0)}
"""Time steps relative to the automatic one, by whether pins move: moving pins are unstable at twice the step."""


@dataclass(frozen=True)
class StepFigures:
    """Figures of a run that must not depend on the time step.

    Deviation of the speed of the disc from the closed form, rms [mrad/s]; its mean and peak-to-peak transmission error
    [arcsec]; rms of the cam's force [N]; efficiency [%].
    """

    gear_speed: float
    mean_error: float
    peak_to_peak: float
    cam_force: float
    efficiency: float


FIGURES = (
    ("rms gear speed error", "mrad/s"),
    ("mean transmission error of the gear", "arcsec"),
    ("p-p transmission error of the gear", "arcsec"),
    ("rms cam force", "N"),
    ("efficiency", "%"),
)
HALF_STEP_BOUNDS = StepFigures(0.2, 0.004, 0.06, 0.002, 3e-4)
"""Bounds for half the automatic step without moving pins [%, points of efficiency]."""
BOUNDS = StepFigures(0.6, 0.003, 1.2, 0.006, 1.4e-3)
"""Bounds for the automatic step: three times the changes seen at 10 us."""
MOVING_BOUNDS = StepFigures(6.2, 0.08, 6.0, 0.011, 0.017)
"""Bounds with moving pins, which chatter. Changes seen: free pins at 3.1 us 1.8, 0.0013, 0.9, 0.0035 % and 0.0055
points; sleeved pins at 2.3 us 2.0, 0.0065, 0.08, 0.0001 % and 0.0032 points (mean error of a quick run: 0.026 %)."""
MASSLESS_BOUNDS = StepFigures(math.inf, 0.5, 6.0, 0.03, 0.04)
"""Bounds of massless against real free pins; their speeds are not comparable."""

LIGHT_LOAD = 1.0
"""Light load [N m], 3 % of the rated load."""
LIGHT_LOAD_BOUNDS = StepFigures(math.inf, math.inf, math.inf, 0.36, 0.11)
"""Bounds of the automatic step under the light load: three times the changes seen; speeds are not compared."""

Study = Mapping[float, StepFigures | RunError]


def rows(kind: str, quick: bool) -> list[ValidationRow]:
    """Compare results of simulations with several time steps, such as transmission error and efficiency.

    `kind` is the kind of ring, such as `rig.FIXED`. The results (`StepFigures`) are compared by `judge_study`. Free
    pins are also compared with massless pins. Further rows are those of a run under a light load. With `quick` there
    are only the automatic step and half of it.
    """
    automatic_step = 1e6 * timestep(Reducer(rated_design(kind)))
    step_factors = (0.5, 1.0) if quick else SHARES[_has_moving_pins(kind)]
    figures_by_step = {
        step_factor * automatic_step: _try_run(kind, step_factor * automatic_step, quick)
        for step_factor in step_factors
    }
    rows = judge_study(kind, figures_by_step, automatic_step)
    if kind == FREE:
        rows += massless_rows(figures_by_step[automatic_step], quick)
    return rows + light_load_rows(kind)


def light_load_rows(kind: str) -> list[ValidationRow]:
    """Compare runs of a kind of ring with the automatic time step and with half of it, under a light load.

    The compared values are those of `StepFigures`, and their bounds are `LIGHT_LOAD_BOUNDS`.
    """
    load_change = f"load.torque_nm={LIGHT_LOAD}"
    automatic_step = 1e6 * timestep(Reducer(rated_design(kind, load_change)))
    figures, finer_figures = (
        _run_quantities(kind, 6, load_change, f"settings.timestep_us={factor * automatic_step!r}")
        for factor in (1.0, 0.5)
    )
    return _compare_quantities(
        kind,
        f"{LIGHT_LOAD:g} N m, {automatic_step:.3g} us",
        figures,
        finer_figures,
        f"{0.5 * automatic_step:.3g} us",
        LIGHT_LOAD_BOUNDS,
    )


def massless_rows(real_pins: StepFigures | RunError, quick: bool) -> list[ValidationRow]:
    """Compare a run with massless free pins, at its own time step, with a run with real free pins.

    The compared results are those of `StepFigures`. `real_pins` are the results of the run with real pins, or its
    error, which is raised. With `quick` the run is a third as long.
    """
    if isinstance(real_pins, RunError):
        raise real_pins
    changes = 'ring.pins="massless"'
    automatic_step = 1e6 * timestep(Reducer(rated_design(FREE, changes)))
    figures = _run_quantities(FREE, _periods(FREE, quick), changes)
    return _compare_quantities(
        FREE, f"massless, {automatic_step:g} us", figures, real_pins, "real pins", MASSLESS_BOUNDS
    )


def judge_study(kind: str, figures_by_step: Study, automatic_step: float) -> list[ValidationRow]:
    """Compare the results of runs with several time steps with those of the shortest step.

    For steps up to the automatic step, each quantity has a row with a bound. A longer step has a single row without a
    bound, that of the quantity with the largest difference. A failed run is a row that fails. The last row is the
    observed order of convergence.

    Parameters
    ----------
    kind
        Kind of ring.
    figures_by_step
        Results of the run, such as the efficiency, or its error, by time step [us].
    automatic_step
        Automatic time step [us].

    Raises
    ------
    RunError
        The run with the shortest step failed.
    """
    shortest_step = min(figures_by_step)
    reference_figures = figures_by_step[shortest_step]
    if isinstance(reference_figures, RunError):
        raise reference_figures
    rows = []
    for step, figures in figures_by_step.items():
        if step == shortest_step:
            continue
        source = f"{shortest_step:g} us"
        if isinstance(figures, RunError):
            bound = BOUNDS.efficiency if step <= automatic_step else None
            rows.append(absolute(f"{kind}, {step:g} us", math.nan, math.nan, "", source, bound, str(figures)))
            continue
        bounds = MOVING_BOUNDS if _has_moving_pins(kind) else BOUNDS if step >= automatic_step else HALF_STEP_BOUNDS
        step_rows = _compare_quantities(kind, f"{step:g} us", figures, reference_figures, source, bounds)
        if step <= automatic_step:
            rows += step_rows
        else:
            worst_row = max(step_rows, key=lambda row: row.difference / (row.bound or math.inf))
            measured_result = replace(worst_row.measured, name=f"{worst_row.measured.name} (the worst of five)")
            rows.append(replace(worst_row, measured=measured_result, bound=None))
    return [*rows, *_order_rows(kind, figures_by_step)]


def observed_order(steps: tuple[float, float, float], values: tuple[float, float, float]) -> float:
    """Solve for the order of convergence p [1] from the `values` of a quantity at three increasing time steps.

    The values are fitted by a + b h^p with the step h; Brent's method determines p. The result is NaN if no p from 0.1
    to 8 fits.
    """

    def residual(order: float) -> float:
        powers = [step**order for step in steps]
        return (values[2] - values[0]) * (powers[1] - powers[0]) - (values[1] - values[0]) * (powers[2] - powers[0])

    low, high = 0.1, 8.0
    return float(brentq(residual, low, high)) if residual(low) * residual(high) < 0.0 else math.nan


def _try_run(kind: str, timestep_us: float, quick: bool) -> StepFigures | RunError:
    """Simulate with one time step [us]; return the quantities, or the error of a run that fails."""
    try:
        return _run_quantities(kind, _periods(kind, quick), f"settings.timestep_us={timestep_us!r}")
    except RunError as error:
        return error


def _run_quantities(kind: str, periods: int, *changes: str) -> StepFigures:
    """Simulate a kind of ring for a number of mesh periods at rated load and 1640 rpm; return the compared results.

    They are rms speed error, mean and peak-to-peak transmission error of the disc, rms cam force and efficiency.
    `changes` are settings of the form ``key=value``.
    """
    run, _ = rated_run(kind, 1640.0, periods, *changes)
    findings = analyze(run)
    cam_force = run.forces("cam")[:, 0]
    return StepFigures(
        gear_speed=1e3 * findings.gear_speed.rms_error_rad_s,
        mean_error=findings.gear_transmission_error.mean_arcsec,
        peak_to_peak=findings.gear_transmission_error.peak_to_peak_arcsec,
        cam_force=rms(cam_force),
        efficiency=100.0 * (findings.efficiency or math.nan),
    )


def _periods(kind: str, quick: bool) -> int:
    """Return the mesh periods of a run: a third of a crank turn if quick or sleeved (expensive), else a full turn."""
    return 12 if quick or kind == SLEEVED else PERIODS


def _has_moving_pins(kind: str) -> bool:
    return kind in (FREE, SLEEVED)


def _compare_quantities(
    kind: str, case: str, figures: StepFigures, reference: StepFigures, source: str, bounds: StepFigures
) -> list[ValidationRow]:
    """Compare the results of a run, `figures`, with those of a reference run, one row per quantity.

    `kind` (the kind of ring) and `case` name the run in the rows, `source` names the reference. `bounds` are the
    allowed differences; an infinite bound counts as no bound.
    """
    rows = []
    values = (astuple(item) for item in (figures, reference, bounds))
    for (quantity, unit), value, reference_value, bound in zip(FIGURES, *values, strict=True):
        compare = absolute if unit == "%" else relative
        rows.append(
            compare(
                f"{quantity}, {kind}, {case}",
                value,
                reference_value,
                unit,
                source,
                bound if math.isfinite(bound) else None,
            )
        )
    return rows


def _order_rows(kind: str, figures_by_step: Study) -> list[ValidationRow]:
    """Return a row with the observed order of convergence of the mean transmission error over the three shortest steps.

    `kind` is the kind of ring, `figures_by_step` are the results by time step [us]. With fewer than three successful
    runs there is no row.
    """
    steps = sorted(figures_by_step)[:3]
    values = [figures_by_step[step] for step in steps]
    mean_errors = [value.mean_error for value in values if isinstance(value, StepFigures)]
    if len(mean_errors) < 3:
        return []
    order = observed_order((steps[0], steps[1], steps[2]), (mean_errors[0], mean_errors[1], mean_errors[2]))
    source = "semi-implicit Euler"
    note = f"of the mean transmission error over {', '.join(f'{step:g}' for step in steps)} us"
    return [absolute(f"observed order of the step, {kind}", order, 1.0, "", source, None, note)]
