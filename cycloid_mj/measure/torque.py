"""Test of Hsieh 2014, Fig. 19: constant torque on crank or sun, and a brake that keeps the speed of the output."""

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
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
from cycloid_mj.base.result import Curve, Quantity, Table, by_key
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Named, resolve
from cycloid_mj.dynamics.massless import assumptions, massless
from cycloid_mj.dynamics.regime import creep_warning, joint_creep_warning
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.measure import loss_breakdown, sensitivity, spread
from cycloid_mj.measure.brake_test import DECAY, run_brake_test
from cycloid_mj.measure.closed_form import AS_BUILT, ideal_efficiency
from cycloid_mj.measure.conditions import STEADY, drag_assumption, halve_time_step
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.measure.published import Published, friction_quantities, tables
from cycloid_mj.measure.sensitivity import FrictionVariant
from cycloid_mj.measure.spread import Input, InputEffect
from cycloid_mj.measure.steady import averaging_periods, first_half, periods_text, run_steady, steady_design
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.statics.film import film_text

_RUNS: dict[Hashable, str] = {"own": "as designed", "halved": "the same with half the time step"}
"""Names of the runs that do not vary the design."""


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
        A design, or the name of a preset or a file; the test has its speed.
    quick
        Whether to average over a shorter time, skip the run with half the time step, and vary only the common friction.
    progress, solver
        Called after each run with the numbers of finished and of all runs; solver of the runs.
    published
        Published torques of this design, for comparison.

    Returns
    -------
    Measurement
        Output torque and its ripple [N m], output rate (torque divided by input torque times ratio) and efficiency [%],
        each with numerical error and closed form; curves of the torque; tables of the losses, and of the output rate at
        other values of friction and of other inputs.
    """
    reducer = reducer_of(resolve(design))
    steady_reducer = steady_design(reducer).working_at(reducer.design.rated_torque)
    periods = averaging_periods(steady_reducer, STEADY.min_periods(quick))
    variants, varied_inputs = sensitivity.friction_variants(reducer, quick), spread.assumed_inputs(steady_reducer)
    half_step = None if quick else halve_time_step(steady_reducer, solver)
    tested_drives = _tested_drives(steady_reducer, variants, varied_inputs, periods, half_step)
    tasks = {key: partial(_quiet_rated_test, drive, count, solver) for key, (drive, count) in tested_drives.items()}
    later_runs = 1 + len(published)
    tests = all_in_threads(tasks, lambda finished, task_count: progress(finished, task_count + later_runs))
    design_test, finer_test = tests["own"], tests.get("halved")
    rates = {key: rated_test.powers.efficiency for key, rated_test in tests.items()}
    by_variant, by_input = {variant: rates[variant] for variant in variants}, spread.input_effects(varied_inputs, rates)
    design_at_output_torque = steady_reducer.but(load={"torque": design_test.output})
    with suppress_warnings(tuple(creep_warning(design_at_output_torque))):
        held_crank_efficiency = constant_speed_efficiency(steady_reducer, design_test.output, periods, solver)
    error = rate_error(design_test, finer_test)
    explanation = explain_published(published, steady_reducer, by_variant, None if quick else error, solver)
    drive_by_run = _name_runs(steady_reducer, tested_drives, variants, varied_inputs, explanation)
    warn(reducer.design.name, joint_creep_warning(drive_by_run | {f"{reducer.INPUT} held": design_at_output_torque}))
    progress(len(tasks) + later_runs, len(tasks) + later_runs)
    quantities = _quantities(steady_reducer, design_test, finer_test, held_crank_efficiency, by_input)
    return Measurement(
        measure="torque",
        design=steady_reducer.design,
        condition=f"{_describe_drive(steady_reducer)}, {steady_reducer.design.condition_words}, {SOLVERS[solver]}",
        quantities=by_key(quantities, friction_quantities(explanation)),
        curves=(*_curves(steady_reducer, design_test), *sensitivity.curves(by_variant, explanation)),
        tables=_tables(steady_reducer, design_test, error, explanation, by_variant, by_input),
        assumptions=_assumptions(steady_reducer, periods),
        details=loss_breakdown.as_json(design_test.powers, explanation)
        | spread.as_json(design_test.powers.efficiency, by_input),
        runs={"braked": design_test.run},
    )


def _describe_drive(reducer: Reducer) -> str:
    """Format the torque on the driven shaft and its speed, for the title of the measurement."""
    drive = reducer.design.drive
    return f"{drive.torque:.4g} N m on the {reducer.INPUT}, {abs(drive.speed) / RPM:.0f} rpm"


def _name_runs(
    steady_reducer: Reducer,
    tested_drives: Mapping[Hashable, tuple[Reducer, int]],
    variants: Sequence[FrictionVariant],
    varied_inputs: Sequence[Input],
    published: Sequence[Published],
) -> dict[str, Reducer]:
    """Return the simulated drives of the brake test by name of the run, for the warning about slowly sliding contacts.

    Runs that vary the creep speed are left out. The drives are the design, its friction variants and varied inputs.

    Parameters
    ----------
    steady_reducer, variants, varied_inputs
        The design in steady motion, its friction variants, and its varied inputs.
    tested_drives
        Drive and number of mesh periods of each run, by key of the run.
    published
        Published torques from `explain_published`; the runs at their friction coefficients are included.
    """
    run_names = _RUNS | {variant: variant.name for variant in variants}
    run_names |= {end_design: name for entry in varied_inputs for end_design, name in entry.names.items()}
    excluded_keys = spread.creep_variants(varied_inputs)
    drives = {
        run_names[key]: _at_rated_torque(drive) for key, (drive, _) in tested_drives.items() if key not in excluded_keys
    }
    coefficients = [entry.friction for entry in published if entry.error is not None]
    return drives | {
        sensitivity.common_name(friction): _with_common_friction(steady_reducer, friction) for friction in coefficients
    }


def _tested_drives(
    steady_reducer: Reducer,
    variants: Sequence[FrictionVariant],
    varied_inputs: Sequence[Input],
    periods: int,
    half_step: Reducer | None,
) -> dict[Hashable, tuple[Reducer, int]]:
    """Return drive and number of mesh periods of each run of the brake test by its key.

    The keys are "own" (the design), "halved" (half the time step), each friction variant, and the designs at both ends
    of the range of each assumed input. In all runs but the first two, ring pins that can move have no mass.

    Parameters
    ----------
    steady_reducer, periods
        The drive in the test, and its number of mesh periods.
    variants, varied_inputs
        Variants of the friction, and inputs with their ranges.
    half_step
        The drive with half the time step; None without this run.
    """
    tested_drives: dict[Hashable, tuple[Reducer, int]] = {"own": (steady_reducer, periods)}
    if half_step is not None:
        tested_drives["halved"] = (half_step, periods)
    for variant in variants:
        drive = reducer_of(variant.design)
        tested_drives[variant] = (massless(drive), averaging_periods(drive, sensitivity.FRICTION_TABLE.periods))
    input_periods = averaging_periods(steady_reducer, spread.INPUTS.periods)
    end_designs = [end_design for varied_input in varied_inputs for end_design in varied_input.ends]
    return tested_drives | {end_design: (massless(reducer_of(end_design)), input_periods) for end_design in end_designs}


def _at_rated_torque(reducer: Reducer) -> Reducer:
    """Return the drive with the contact stiffness of the rated output torque without losses."""
    return reducer.working_at(reducer.design.rated_torque)


def _quiet_rated_test(reducer: Reducer, periods: int, solver: Solver) -> BrakedRun:
    """Run the rated test without the warning about incomplete friction, which `torque` issues for all tests at once."""
    with suppress_warnings(tuple(creep_warning(_at_rated_torque(reducer)))):
        return rated_test(reducer, periods, solver)


def rated_test(reducer: Reducer, periods: int, solver: Solver = "planar") -> BrakedRun:
    """Run the test under the nominal torque over so many mesh periods."""
    run = run_brake_test(reducer, reducer.design.drive.torque, periods, solver)
    output_torque, driven_torque = (
        abs(float(np.mean(run[name]))) for name in ("load_torque", f"{run.driven_shaft}_torque")
    )
    return BrakedRun(run, mean_powers(run), output_torque, driven_torque)


def constant_speed_efficiency(reducer: Reducer, load: float, periods: int, solver: Solver = "planar") -> float:
    """Compute the efficiency under a load [N m] at constant crank speed, as a second method."""
    return mean_powers(run_steady(reducer.but(load={"torque": load}), STEADY.settling_time, periods, solver)).efficiency


def rate_error(test: BrakedRun, half_step: BrakedRun | None) -> float:
    """Compute the error of the output rate: the largest change with half the averaging time and with half the step."""
    other_powers = [mean_powers(first_half(test.run)), *([half_step.powers] if half_step else [])]
    return max(abs(powers.efficiency - test.powers.efficiency) for powers in other_powers)


def explain_published(
    published: Sequence[Published],
    reducer: Reducer,
    rate_by_variant: Mapping[FrictionVariant, float],
    error: float | None,
    solver: Solver,
) -> list[Published]:
    """Return the published torques with the friction coefficient at which the model has the same output rate.

    The coefficient is common to all sliding pairs. It is interpolated in the output rates [1] of the friction variants,
    `rate_by_variant`, and NaN outside of their range. `error` is the numerical error of a rate [1]. Unless it is None,
    each torque is also simulated with its coefficient. The error of the coefficient is then the sum of `error` and the
    deviation of the simulated rate, divided by the slope of the rate over the coefficient. `solver` is the solver of
    the runs, MuJoCo or the planar solver.
    """
    rates = sensitivity.common_rates(rate_by_variant, sensitivity.pins_of(reducer))
    explained_figures = [
        replace(paper, friction=sensitivity.interpolate_friction(rates, paper.rate)) for paper in published
    ]
    interpolated_figures = [figure for figure in explained_figures if math.isfinite(figure.friction)]
    if error is None or not interpolated_figures:
        return explained_figures
    slope = abs(sensitivity.slope(rates))
    periods = averaging_periods(reducer, sensitivity.FRICTION_TABLE.periods)
    tests = each_in_threads(
        lambda paper: _quiet_rated_test(_with_common_friction(reducer, paper.friction), periods, solver),
        interpolated_figures,
    )
    deviations = {
        paper: abs(test.powers.efficiency - paper.rate) for paper, test in zip(interpolated_figures, tests, strict=True)
    }
    return [
        replace(figure, error=(deviations[figure] + error) / slope) if figure in deviations else figure
        for figure in explained_figures
    ]


def _with_common_friction(reducer: Reducer, friction: float) -> Reducer:
    """Return the drive with one friction for all sliding pairs, and massless pins."""
    return massless(sensitivity.with_common_friction(reducer, friction))


def _quantities(
    reducer: Reducer,
    test: BrakedRun,
    half_step: BrakedRun | None,
    held_crank_efficiency: float,
    by_input: Sequence[InputEffect],
) -> list[Quantity]:
    """Return the quantities of a torque test at rated input: torques, output rate, ripple, efficiency, energy balance.

    Errors are the largest changes with half the time step and with half the averaging time. Half the averaging time is
    the second half of the run for the ripple, and otherwise the first half.

    Parameters
    ----------
    test, half_step
        The run, and that with half the time step; None without it.
    held_crank_efficiency
        Efficiency at constant crank speed under this load [1].
    by_input
        Output rates at both ends of the range of each assumed input, such as a friction coefficient.
    """
    rated_torque = reducer.design.rated_torque
    powers, reference = test.powers, ideal_efficiency(reducer, test.output)
    error = rate_error(test, half_step)
    torque_error = max(error * rated_torque, abs(test.output - powers.efficiency * rated_torque))
    torque_reference, rate = (reference.efficiency * rated_torque, reference.source), 1e2 * test.output / rated_torque
    input_text, as_built = spread.spread_text(powers.efficiency, by_input), AS_BUILT[reducer.LAYOUT]
    condition_text, rate_by_powers = (
        f"efficiency at constant {reducer.INPUT} speed under this load",
        1e2 * powers.efficiency,
    )
    return [
        Quantity("output_torque", "output torque", test.output, "N m", torque_error, *torque_reference, as_built),
        Quantity(
            "output_rate",
            f"output rate, of {rated_torque:g} N m",
            rate,
            "%",
            1e2 * torque_error / rated_torque,
            note=input_text,
        ),
        *_ripple_quantities(test, half_step),
        Quantity("input_torque", "mean input torque", test.input, "N m", None, reducer.design.drive.torque, "as given"),
        Quantity("efficiency", "efficiency by powers", rate_by_powers, "%", 1e2 * error),
        Quantity(
            "efficiency_crank_held",
            condition_text,
            1e2 * held_crank_efficiency,
            "%",
            None,
            rate_by_powers,
            "braked run",
        ),
        Quantity("balance_residual", "residual of the energy balance", 1e2 * powers.residual, "% of input"),
    ]


def _ripple_quantities(test: BrakedRun, half_step: BrakedRun | None) -> Iterator[Quantity]:
    """Yield peak to peak and rms of the output torque's ripple [N m], with their errors.

    `test` is the run. The errors are the largest changes over its second half, which has less of the initial ringing,
    and in the run `half_step` with half the time step.
    """
    second_half = test.run.select(slice(len(test.run) // 2, None))
    other_torques = [run["load_torque"] for run in (second_half, *([half_step.run] if half_step else []))]
    for key, name, statistic in (("peak_to_peak", "p-p", np.ptp), ("rms", "rms", np.std)):
        ripple = float(statistic(test.run["load_torque"]))
        error = max(abs(float(statistic(other_torque)) - ripple) for other_torque in other_torques)
        yield Quantity(f"ripple_{key}", f"ripple of the output torque, {name}", ripple, "N m", error)


def _tables(
    reducer: Reducer,
    test: BrakedRun,
    error: float,
    published: Sequence[Published],
    rate_by_variant: Mapping[FrictionVariant, float],
    by_input: Sequence[InputEffect],
) -> tuple[Table, ...]:
    """Return the tables of losses, published torques, and output rates with other inputs and other friction.

    `test` is the run of the design, `error` its `rate_error`, and `published` are from `explain_published`.
    `rate_by_variant` are the output rates of the friction variants [1]. `by_input` are the rates at both ends of the
    range of each assumed input. An output rate is the output torque over that without losses.
    """
    return (
        loss_breakdown.table(test.powers, published, error),
        *tables(test.output, published),
        spread.table("output rate", test.powers.efficiency, by_input),
        sensitivity.table(reducer, rate_by_variant),
    )


def _curves(reducer: Reducer, test: BrakedRun) -> tuple[Curve, ...]:
    """Return the curves of a torque test: simulated and mean output torque over the crank angle, and its spectrum.

    The torque is in [N m], the angle in [deg] from the start. The spectrum has the amplitudes [N m] of the torque by
    order (cycles per crank turn) up to four times the order of the tooth mesh; it is omitted if the run is shorter than
    a mesh period, or if the crank stops or reverses. `test` is the simulated run with a braked output.
    """
    torque, angle = test.run["load_torque"], reducer.member.crank_angle(test.run[f"{test.run.driven_shaft}_angle"])
    swept_angle = np.abs(angle - angle[0])
    mesh_order, axis_labels = reducer.mesh_periods, ("crank angle [deg]", "torque [N m]")
    curves = [
        Curve(
            "output torque", "mean", np.degrees(swept_angle), np.full(len(torque), test.output), *axis_labels, "theory"
        ),
        Curve("output torque", "simulated", np.degrees(swept_angle), np.abs(torque), *axis_labels),
    ]
    spectrum = tapered_orders(angle, torque, 4.0 * mesh_order, mesh_order)
    if spectrum is not None:
        min_order, max_order = spectrum.band
        axis_label = f"order of the crank, accurate to 1 % from {min_order:.3g} to {max_order:.4g}"
        curves.append(
            Curve("its ripple by order", "", spectrum.order, spectrum.amplitude, axis_label, "amplitude [N m]")
        )
    return tuple(curves)


def _friction_text(reducer: Reducer) -> str:
    """Return a phrase with the friction coefficients of sliding pairs and bearings, or the lubricant (law ``film``)."""
    design = reducer.design
    if design.has_film:
        return film_text(reducer)
    pair_text = ", ".join(f"{pair} {design.friction_of(pair):g}" for pair in sensitivity.sliding_pairs(reducer))
    bearing_text = ", ".join(f"{pair} {design.friction_of(pair):g}" for pair in reducer.BEARING_PAIRS)
    return f"friction of the pairs that slide: {pair_text}; of rolling bearings: {bearing_text}"


def _assumptions(reducer: Reducer, periods: int) -> tuple[str, ...]:
    """Return the assumptions of a brake test in simulation, a sentence each.

    They are about friction, contact stiffness, averaging, motor and numerical errors. `periods` is the number of mesh
    periods of the averages.
    """
    return (
        f"{_friction_text(reducer)}; {drag_assumption(reducer)}; the bearings of the shafts are neglected",
        "contacts have the secant stiffness of one working force in all runs: "
        f"{reducer.contacts.working_forces_text(tuple(reducer.clearance_keys))}",
        f"{periods_text(reducer, periods)}: the torque repeats with both, and hardly with the crank turn",
        "the motor's torque falls with its speed, which damps the oscillation of its inertia on the mesh within "
        f"{1e3 * DECAY:g} ms (to 1/e); its mean is the given torque, as the brake keeps the mean speed",
        "numerical error: change with half the time step (unless --quick) or half the averaging time, whichever is "
        "larger; of a friction: that and the deviation of a run with it, by the slope",
        "the oscillation has not fully decayed at the start of the table's runs: up to 0.1 points",
        *assumptions(reducer, "runs with an input varied"),
    )
