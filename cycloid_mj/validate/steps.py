"""Rung 8, the step study: the figures of a run at rated load at several time steps, against the finest.

Steps up to that which the design chooses must agree; longer ones are told. The observed order is that of the error's
growth. Under a light load friction must hold, too, which the step could turn round (``dynamics.law.impratio``).
"""

import math
from collections.abc import Iterable, Mapping
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
"""Steps as shares of the one that is chosen, with and without moving pins: these go wrong at twice their step."""


@dataclass(frozen=True)
class StepFigures:
    """Figures of a run that must not depend on the step.

    Deviation of the gear's speed from the closed form, rms [mrad/s]; its mean and peak-to-peak transmission error
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
FINER = StepFigures(0.2, 0.004, 0.06, 0.002, 3e-4)
"""Bounds of half the chosen step without moving pins, in percent but for points of efficiency."""
HELD = StepFigures(0.6, 0.003, 1.2, 0.006, 1.4e-3)
"""The same of the chosen step: three times the changes seen at 10 us."""
MOVING = StepFigures(6.2, 0.08, 6.0, 0.011, 0.017)
"""The same with moving pins, which chatter: at 3.1 us free ones change by 1.8, 0.0013, 0.9, 0.0035 % and 0.0055 points,
at 2.3 us sleeved ones by 2.0, 0.0065, 0.08, 0.0001 % and 0.0032 points; their mean over the twelve meshes of a quick
run, which leave more of the chatter in it, by 0.026 %."""
WITHOUT_INERTIA = StepFigures(math.inf, 0.5, 6.0, 0.03, 0.04)
"""The same of free pins without their inertia against real ones; speeds they do not tell."""

LIGHT = 1.0
"""Light load [N m], 3 % of the rated one."""
LIGHTLY_LOADED = StepFigures(math.inf, math.inf, math.inf, 0.36, 0.11)
"""Bounds of the chosen step under it, three times the changes seen; the speed of a gear on few teeth is not held."""

Study = Mapping[float, StepFigures | RunError]


def rows(kind: str, quick: bool) -> list[ValidationRow]:
    """List the rows of one kind of ring."""
    default = default_step(kind)
    shares = (0.5, 1.0) if quick else SHARES[_is_moving(kind)]
    study = {share * default: _figures(kind, share * default, quick) for share in shares}
    rows = judged(kind, study, default)
    if kind == FREE:
        rows += massless_rows(study[default], quick)
    return rows + light_rows(kind)


def light_rows(kind: str) -> list[ValidationRow]:
    """Hold the step that is chosen under a light load against half of it."""
    load = f"load.torque_nm={LIGHT}"
    step = 1e6 * timestep(Reducer(rated_design(kind, load)))
    figures, finer = (_run(kind, 6, load, f"settings.timestep_us={share * step!r}") for share in (1.0, 0.5))
    rows = _compared(kind, f"{LIGHT:g} N m, {step:.3g} us", figures, finer, f"{0.5 * step:.3g} us", LIGHTLY_LOADED)
    return _compared_rows(rows)


def massless_rows(real: StepFigures | RunError, quick: bool) -> list[ValidationRow]:
    """Hold free pins without their inertia, at their own step, against real ones."""
    if isinstance(real, RunError):
        raise real
    changes = 'ring.pins="massless"'
    step = 1e6 * timestep(Reducer(rated_design(FREE, changes)))
    figures = _run(FREE, _periods(FREE, quick), changes)
    return _compared_rows(_compared(FREE, f"massless, {step:g} us", figures, real, "real pins", WITHOUT_INERTIA))


def judged(kind: str, study: Study, default: float) -> list[ValidationRow]:
    """Hold each step of a study against its finest: every figure up to the `default` step [us], then the worst."""
    finest = min(study)
    reference = study[finest]
    if isinstance(reference, RunError):
        raise reference
    rows = []
    for step, figures in study.items():
        if step == finest:
            continue
        source = f"{finest:g} us"
        if isinstance(figures, RunError):
            bound = HELD.efficiency if step <= default else None
            rows.append(absolute(f"{kind}, {step:g} us", math.nan, math.nan, "", source, bound, str(figures)))
            continue
        bounds = MOVING if _is_moving(kind) else HELD if step >= default else FINER
        compared = _compared(kind, f"{step:g} us", figures, reference, source, bounds)
        if step <= default:
            rows += compared
        else:
            worst = max(compared, key=lambda row: row.difference / (row.bound or math.inf))
            measured = replace(worst.measured, name=f"{worst.measured.name} (the worst of five)")
            rows.append(replace(worst, measured=measured, bound=None))
    return [*rows, *_order_rows(kind, study)]


def default_step(kind: str) -> float:
    """Compute the time step [us] that a kind of ring has at rated load."""
    return 1e6 * timestep(Reducer(rated_design(kind)))


def observed_order(steps: tuple[float, float, float], values: tuple[float, float, float]) -> float:
    """Find p for which values at three rising steps h go as a + b h^p; not a number where no p from 0.1 to 8 does."""

    def excess(order: float) -> float:
        powers = [step**order for step in steps]
        return (values[2] - values[0]) * (powers[1] - powers[0]) - (values[1] - values[0]) * (powers[2] - powers[0])

    low, high = 0.1, 8.0
    return float(brentq(excess, low, high)) if excess(low) * excess(high) < 0.0 else math.nan


def _figures(kind: str, step: float, quick: bool) -> StepFigures | RunError:
    """Run one step [us]; give the error of a run that fails."""
    try:
        return _run(kind, _periods(kind, quick), f"settings.timestep_us={step!r}")
    except RunError as error:
        return error


def _run(kind: str, periods: int, *changes: str) -> StepFigures:
    """Run over some mesh periods."""
    run, _ = rated_run(kind, 1640.0, periods, *changes)
    findings = analyze(run)
    cam = run.forces("cam")[:, 0]
    return StepFigures(
        gear_speed=1e3 * findings.gear_speed.rms_error_rad_s,
        mean_error=findings.gear_transmission_error.mean_arcsec,
        peak_to_peak=findings.gear_transmission_error.peak_to_peak_arcsec,
        cam_force=rms(cam),
        efficiency=100.0 * (findings.efficiency or math.nan),
    )


def _periods(kind: str, quick: bool) -> int:
    """Count the mesh periods of a run: a third of a crank turn, or a whole one; not of sleeves, the dearest to run."""
    return 12 if quick or kind == SLEEVED else PERIODS


def _is_moving(kind: str) -> bool:
    return kind in (FREE, SLEEVED)


def _compared(
    kind: str, which: str, figures: StepFigures, reference: StepFigures, source: str, bounds: StepFigures
) -> list[ValidationRow]:
    compared = []
    values = (astuple(each) for each in (figures, reference, bounds))
    for (quantity, unit), ours, finest, bound in zip(FIGURES, *values, strict=True):
        judge = absolute if unit == "%" else relative
        compared.append(judge(f"{quantity}, {kind}, {which}", ours, finest, unit, source, bound))
    return compared


def _compared_rows(rows: Iterable[ValidationRow]) -> list[ValidationRow]:
    """List rows, those without a finite bound as told only."""
    return [row if math.isfinite(row.bound or 0.0) else replace(row, bound=None) for row in rows]


def _order_rows(kind: str, study: Study) -> list[ValidationRow]:
    """Tell the order of the mean transmission error's convergence over the three finest steps."""
    steps = sorted(study)[:3]
    values = [study[step] for step in steps]
    means = [value.mean_error for value in values if isinstance(value, StepFigures)]
    if len(means) < 3:
        return []
    order = observed_order((steps[0], steps[1], steps[2]), (means[0], means[1], means[2]))
    source = "semi-implicit Euler"
    note = f"of the mean transmission error over {', '.join(f'{step:g}' for step in steps)} us"
    return [absolute(f"observed order of the step, {kind}", order, 1.0, "", source, None, note)]
