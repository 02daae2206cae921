"""Test of Hsieh 2014, Fig. 19: constant torque on the crank, and a brake that keeps the speed of the output."""

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from cycloid_mj.analysis.spectrum import tapered_orders
from cycloid_mj.base.engine import Progress, all_in_threads, each_in_threads, silent
from cycloid_mj.base.errors import suppress_warnings, warn
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.powers import Powers, mean_powers
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Curve, Quantity, by_key
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Named, resolve
from cycloid_mj.dynamics.massless import assumptions, massless
from cycloid_mj.dynamics.regime import creeping, creeping_in
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.measure import loss_breakdown, sensitivity, spread
from cycloid_mj.measure.brake_test import DECAY, run_brake_test
from cycloid_mj.measure.closed_form import AS_BUILT, ideal_efficiency
from cycloid_mj.measure.conditions import drag_assumption, halve_time_step
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.measure.published import Published, friction_quantities, tables
from cycloid_mj.measure.sensitivity import FrictionVariant
from cycloid_mj.measure.spread import Input, InputEffect
from cycloid_mj.measure.steady import SETTLING_TIME, first_half, run_steady, steady_design, whole_periods
from cycloid_mj.reducer import Reducer

_RUNS: dict[Hashable, str] = {"own": "as designed", "halved": "the same with half the time step"}
"""Names of the runs that do not vary the design."""

PERIODS, QUICK_PERIODS = 12, 4
"""Mesh periods of the main run at least: a third of a crank turn, or less."""


@dataclass(frozen=True, eq=False)
class BrakedRun:
    """A braked run, its mean powers, and its mean output and input torque [N m]."""

    run: Run
    powers: Powers
    output: float
    input: float


@shows_progress
def torque(
    design: Named,
    quick: bool = False,
    progress: Progress = silent,
    published: Sequence[Published] = (),
    solver: Solver = "planar",
) -> Measurement:
    """Measure the output torque of a design under its rated input torque.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file; its crank speed is that of the test.
    quick
        Whether to average over a shorter time, skip the run with half the time step, and vary only the friction of all
        sliding pairs together.
    progress, solver
        Called after each run with the numbers of finished and of all runs; solver of the runs.
    published
        Published torques of this design, for comparison.

    Returns
    -------
    Measurement
        Figures with their numerical errors and closed forms, curves and tables.
    """
    reducer = Reducer(resolve(design))
    steady = steady_design(reducer).working_at(reducer.design.rated_torque)
    main = whole_periods(steady, QUICK_PERIODS if quick else PERIODS)
    drive = steady.design.drive
    rows, assumed = sensitivity.variations(reducer, quick), spread.inputs(steady)
    tested: dict[Hashable, tuple[Reducer, int]] = {"own": (steady, main)}
    tested |= {} if quick else {"halved": (halve_time_step(steady, solver), main)}
    tested |= _variants(steady, rows, assumed)
    tasks = {key: partial(_untold_test, item, count, solver) for key, (item, count) in tested.items()}
    last = 1 + len(published)
    tests = all_in_threads(tasks, lambda done, whole: progress(done, whole + last))
    ours, finer = tests["own"], tests.get("halved")
    rates = {key: test.powers.efficiency for key, test in tests.items()}
    by_row, by_input = {row: rates[row] for row in rows}, spread.pair_rates(assumed, rates)
    held = steady.but(load={"torque": ours.output})
    with suppress_warnings(tuple(creeping(held))):
        at_held_crank = held_efficiency(steady, ours.output, main, solver)
    beside = with_friction(published, steady, by_row, None if quick else rate_error(ours, finer), solver)
    called = _RUNS | {row: row.name for row in rows} | {end: key for item in assumed for end, key in item.names.items()}
    slow = spread.slow_ends(assumed)
    by_name = {called[key]: _at_rated_torque(each) for key, (each, _) in tested.items() if key not in slow}
    by_name["crank held"] = held
    for friction in (each.friction for each in beside if each.error is not None):
        by_name[sensitivity.common_name(friction)] = _with_common(steady, friction)
    warn(reducer.design.name, creeping_in(by_name))
    progress(len(tasks) + last, len(tasks) + last)
    losses = loss_breakdown.table(ours.powers, beside, rate_error(ours, finer))
    inputs = spread.table("output rate", rates["own"], by_input)
    return Measurement(
        measure="torque",
        design=steady.design,
        condition=f"{drive.torque:.4g} N m on the crank, {abs(drive.speed) / RPM:.0f} rpm, {SOLVERS[solver]}",
        quantities=by_key(_quantities(steady, ours, finer, at_held_crank, by_input), friction_quantities(beside)),
        curves=(*_curves(steady, ours), *sensitivity.curves(by_row, beside)),
        tables=(losses, *tables(ours.output, beside), inputs, sensitivity.table(steady, by_row)),
        assumptions=_assumptions(steady, main),
        details=loss_breakdown.as_json(ours.powers, beside) | spread.as_json(ours.powers.efficiency, by_input),
        runs={"braked": ours.run},
    )


def _variants(
    steady: Reducer, rows: Sequence[FrictionVariant], assumed: Sequence[Input]
) -> dict[Hashable, tuple[Reducer, int]]:
    """Return each row of the friction table and each end of an input with massless pins, and their mesh periods."""
    drives = {row: Reducer(row.design) for row in rows}
    periods = whole_periods(steady, spread.INPUTS.periods)
    return {row: (massless(drive), whole_periods(drive, sensitivity.PERIODS)) for row, drive in drives.items()} | {
        end: (massless(Reducer(end)), periods) for each in assumed for end in each.ends
    }


def _at_rated_torque(reducer: Reducer) -> Reducer:
    """Return the drive with the contact stiffness of the rated output torque without losses."""
    return reducer.working_at(reducer.design.rated_torque)


def _untold_test(reducer: Reducer, periods: int, solver: Solver) -> BrakedRun:
    """Run the rated test without the warning about incomplete friction, which `torque` issues for all tests at once."""
    with suppress_warnings(tuple(creeping(_at_rated_torque(reducer)))):
        return rated_test(reducer, periods, solver)


def rated_test(reducer: Reducer, periods: int, solver: Solver = "planar") -> BrakedRun:
    """Run the test under the nominal torque over so many mesh periods."""
    run = run_brake_test(reducer, reducer.design.drive.torque, periods, solver)
    output, crank = (abs(float(np.mean(run[name]))) for name in ("load_torque", "crank_torque"))
    return BrakedRun(run, mean_powers(run), output, crank)


def held_efficiency(reducer: Reducer, load: float, periods: int, solver: Solver = "planar") -> float:
    """Compute the efficiency under a load [N m] at constant crank speed, as a second method."""
    return mean_powers(run_steady(reducer.but(load={"torque": load}), SETTLING_TIME, periods, solver)).efficiency


def rate_error(ours: BrakedRun, finer: BrakedRun | None) -> float:
    """Compute the numerical error of the rate: the change with half the averaging time, and with half the time step."""
    others = [mean_powers(first_half(ours.run)), *([finer.powers] if finer else [])]
    return max(abs(other.efficiency - ours.powers.efficiency) for other in others)


def with_friction(
    published: Sequence[Published],
    reducer: Reducer,
    by_variant: Mapping[FrictionVariant, float],
    error: float | None,
    solver: Solver,
) -> list[Published]:
    """Return published torques with the friction that explains each of them.

    With the numerical `error` of a rate, each is run at its friction; the error of the friction follows from the
    deviation, that error and the slope.
    """
    rates = sensitivity.common_rates(by_variant, sensitivity.pins_of(reducer))
    figures = [replace(item, friction=sensitivity.friction_for(rates, item.rate)) for item in published]
    inside = [figure for figure in figures if math.isfinite(figure.friction)]
    if error is None or not inside:
        return figures
    slope = abs(sensitivity.slope(rates))
    periods = whole_periods(reducer, sensitivity.PERIODS)
    reached = each_in_threads(lambda item: _untold_test(_with_common(reducer, item.friction), periods, solver), inside)
    missed = {item: abs(test.powers.efficiency - item.rate) for item, test in zip(inside, reached, strict=True)}
    return [
        replace(figure, error=(missed[figure] + error) / slope) if figure in missed else figure for figure in figures
    ]


def _with_common(reducer: Reducer, friction: float) -> Reducer:
    """Return the drive with one friction for all sliding pairs, and massless pins."""
    return massless(sensitivity.with_common_friction(reducer, friction))


def _quantities(
    reducer: Reducer, ours: BrakedRun, finer: BrakedRun | None, at_held_crank: float, by_input: Sequence[InputEffect]
) -> list[Quantity]:
    """List the quantities of the rated test."""
    ideal = reducer.design.rated_torque
    powers, closed = ours.powers, ideal_efficiency(reducer, ours.output)
    error = rate_error(ours, finer)
    torque_error = max(error * ideal, abs(ours.output - powers.efficiency * ideal))
    ripple, rms = (float(size(ours.run["load_torque"])) for size in (np.ptp, np.std))
    # what is left of the ringing shows in the second half, which has less of it
    later = ours.run.select(slice(len(ours.run) // 2, None))
    others = [run["load_torque"] for run in (later, *([finer.run] if finer else []))]
    ripple_error = max(abs(float(np.ptp(other)) - ripple) for other in others)
    rms_error = max(abs(float(np.std(other)) - rms) for other in others)
    expected, rate = (closed.efficiency * ideal, closed.source), 1e2 * ours.output / ideal
    inputs = spread.spread_text(powers.efficiency, by_input)
    at_speed, rate_by_powers = "efficiency at constant crank speed under this load", 1e2 * powers.efficiency
    return [
        Quantity("output_torque", "output torque", ours.output, "N m", torque_error, *expected, AS_BUILT),
        Quantity("output_rate", f"output rate, of {ideal:g} N m", rate, "%", 1e2 * torque_error / ideal, note=inputs),
        Quantity("ripple_peak_to_peak", "ripple of the output torque, p-p", ripple, "N m", ripple_error),
        Quantity("ripple_rms", "ripple of the output torque, rms", rms, "N m", rms_error),
        Quantity("input_torque", "mean input torque", ours.input, "N m", None, reducer.design.drive.torque, "as given"),
        Quantity("efficiency", "efficiency by powers", rate_by_powers, "%", 1e2 * error),
        Quantity("efficiency_crank_held", at_speed, 1e2 * at_held_crank, "%", None, rate_by_powers, "braked run"),
        Quantity("balance_residual", "residual of the energy balance", 1e2 * powers.residual, "% of input"),
    ]


def _curves(reducer: Reducer, ours: BrakedRun) -> tuple[Curve, ...]:
    """List the output torque against the crank angle, and its orders."""
    torque, angle = ours.run["load_torque"], ours.run["crank_angle"]
    turned = np.abs(angle - angle[0])
    teeth, x, y = reducer.mesh_periods, "crank angle [deg]", "torque [N m]"
    curves = [
        Curve("output torque", "mean", np.degrees(turned), np.full(len(torque), ours.output), x, y, "theory"),
        Curve("output torque", "simulated", np.degrees(turned), np.abs(torque), x, y),
    ]
    orders = tapered_orders(angle, torque, 4.0 * teeth, teeth)
    if orders is not None:
        low, high = orders.band
        words = f"order of the crank, accurate to 1 % from {low:.3g} to {high:.4g}"
        curves.append(Curve("its ripple by order", "", orders.order, orders.amplitude, words, "amplitude [N m]"))
    return tuple(curves)


def _assumptions(reducer: Reducer, periods: int) -> tuple[str, ...]:
    """List the assumptions of the runs."""
    design = reducer.design
    friction = ", ".join(f"{pair} {design.friction_of(pair):g}" for pair in sensitivity.sliding_pairs(reducer))
    pins = round(periods * design.output.pins / design.lobes, 2)
    return (
        f"friction of the pairs that slide: {friction}; of rolling bearings: cam {design.friction_of('cam'):g}, "
        f"output {design.friction_of('output'):g}; {drag_assumption(reducer)}; the bearings of the shafts are "
        "neglected",
        "contacts have the secant stiffness of one working force in all runs: "
        f"{reducer.contacts.working_forces_text(design.pair_kinds)}",
        f"mean over {periods} mesh periods, {pins:g} periods of the output pins: the torque repeats with both, and "
        "hardly with the crank turn",
        "the motor's torque falls with its speed, which damps the oscillation of its inertia on the mesh within "
        f"{1e3 * DECAY:g} ms (to 1/e); its mean is the given torque, as the brake keeps the mean speed",
        "numerical error: change with half the time step (unless --quick) or half the averaging time, whichever is "
        "larger; of a friction: that and the deviation of a run with it, by the slope",
        "the oscillation has not fully decayed at the start of the table's runs: up to 0.1 points",
        *assumptions(reducer, "runs with an input varied"),
    )
