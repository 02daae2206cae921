"""Measures of a sweep as named numbers with units, and figures of the catalogue."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from cycloid_mj.base.errors import DesignError, RunError, UsageError
from cycloid_mj.base.frame import Cell
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.result import Quantity
from cycloid_mj.base.units import ARCMINUTE, MILLIMETRES, with_unit
from cycloid_mj.design.layouts import BOTH, Layout, layouts_of
from cycloid_mj.dynamics.massless import assumptions as massless_assumptions
from cycloid_mj.dynamics.massless import massless
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.figures import FIGURES, Figure, figure, quantities
from cycloid_mj.measure import MEASURES
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class MeasureSettings:
    """Settings of the measures."""

    quick: bool = False
    """Whether they use fewer angles and runs, as by their flag of that name."""
    real_pins: bool = False
    """Whether runs keep the inertia of moving pins under a load."""
    solver: Solver = "planar"
    """Solver of the runs."""


@dataclass(frozen=True)
class MeasuredFigures:
    """Result of one measure of one design."""

    values: Mapping[str, Cell]
    """Column -> number, text or switch; a column of a number ends in its unit."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Column -> unit, of numbers that have one."""
    assumptions: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    """Sentences about the numbers."""


def _columns_from_quantities(quantities: Iterable[Quantity], **other_fields: Any) -> MeasuredFigures:
    """Return the values and units of quantities as columns of the table of a sweep, by their names.

    The name is the quantity's key if it is in `cycloid_mj.figures.FIGURES`, otherwise key and unit (``mass_kg``).
    `other_fields` are the other fields of `MeasuredFigures`: assumptions and warnings.
    """
    quantities_by_name = {
        quantity.key if quantity.key in FIGURES else with_unit(quantity.key, quantity.unit): quantity
        for quantity in quantities
    }
    units = {name: quantity.unit for name, quantity in quantities_by_name.items() if quantity.unit not in ("", "1")}
    return MeasuredFigures(
        {name: quantity.value for name, quantity in quantities_by_name.items()}, units, **other_fields
    )


def _compute_statics(reducer: Reducer, _: MeasureSettings) -> MeasuredFigures:
    """Compute all quantities of the static data sheet of a reducer, as columns of a sweep's table under their keys.

    The keys are those of `cycloid_mj.figures.FIGURES`. The settings have no effect.
    """
    from cycloid_mj.statics.sheet import sheet

    figures = sheet(reducer)
    keyed_quantities = (replace(quantity, key=figure(quantity.key).key) for quantity in figures.quantities.values())
    return _columns_from_quantities(keyed_quantities, assumptions=figures.assumptions)


def _run_measurement(name: str, reducer: Reducer, options: MeasureSettings) -> MeasuredFigures:
    measurement = MEASURES[name](reducer.design, quick=options.quick, solver=options.solver)
    warnings = {text: None for run in measurement.runs.values() for text in run.warnings}
    assumptions = (f"runs are {SOLVERS[options.solver]}", *measurement.assumptions)
    return _columns_from_quantities(measurement.quantities.values(), assumptions=assumptions, warnings=tuple(warnings))


def _simulate_design(reducer: Reducer, options: MeasureSettings) -> MeasuredFigures:
    """Simulate a design (ramp, then constant speed); return the results of its analysis as columns of a table.

    A `MeasuredFigures` has the columns. `options` are settings of the run. Under a load, pins have no inertia unless
    `options.real_pins` is set, because this allows longer time steps.

    Raises
    ------
    DesignError
        The crank speed is zero.
    RunError
        The run would take too many time steps, or fails.
    """
    from cycloid_mj.analysis import analyze
    from cycloid_mj.dynamics.run import RUN, model_for, schedule, simulate

    if reducer.design.drive.speed == 0.0:
        raise DesignError(
            f"{reducer.design.name}: drive.speed_rpm is 0, so the crank would not turn: set a speed other than 0, such "
            "as 1640 rpm"
        )
    is_massless = not options.real_pins and abs(reducer.design.load.torque) > reducer.contacts.own_load
    simulated_reducer = massless(reducer) if is_massless else reducer
    model = model_for(options.solver, simulated_reducer)
    if (steps := schedule(simulated_reducer, model.timestep).steps) > RUN.max_steps:
        raise RunError(
            f"the run of {reducer.design.name} would take {steps:.3g} time steps, but at most {RUN.max_steps:.0e} are "
            "allowed: reduce drive.hold_s"
        )
    findings = analyze(simulate(simulated_reducer.design, model))
    pins = simulated_reducer.design.ring.pins if simulated_reducer.design.ring.kind == "pin" else "none"
    values = {"solver": options.solver, "pins": pins, **dict(_flatten_results(findings.as_json()))}
    assumptions = (
        massless_assumptions(reducer, "loaded runs (mean values; speeds sway up to a fifth less)")
        if is_massless
        else ()
    )
    return MeasuredFigures(values, assumptions=assumptions, warnings=findings.warnings)


def _flatten_results(results: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Cell]]:
    """Yield name and value of a column for each number and boolean in the results of an analysis.

    `results` are nested mappings, whose keys are joined by underscores, after the `prefix` of all names. A list may
    have dicts with the key ``pair``; the names of its columns begin with the value of that key instead of the outer
    keys. Texts, other lists and None are left out.
    """
    for key, value in results.items():
        if isinstance(value, Mapping):
            yield from _flatten_results(value, f"{prefix}{key}_")
        elif isinstance(value, (bool, int, float)):
            yield f"{prefix}{key}", value
        elif isinstance(value, (list, tuple)):
            for table_row in value:
                if isinstance(table_row, Mapping) and "pair" in table_row:
                    numbers = {name: number for name, number in table_row.items() if name != "pair"}
                    yield from _flatten_results(numbers, f"{table_row['pair']}_")


def _compute_masses(reducer: Reducer, _: MeasureSettings) -> MeasuredFigures:
    from cycloid_mj.figures.geometry import masses

    parts = masses(reducer)
    values = {"mass_kg": sum(parts.values()), **{f"{name}_mass_kg": mass for name, mass in parts.items()}}
    return MeasuredFigures(dict(values), dict.fromkeys(values, "kg"))


def _list_checks(reducer: Reducer, _: MeasureSettings) -> MeasuredFigures:
    """Convert the results of all checks of a design to columns of a sweep's table; the settings have no effect.

    The columns are the numbers of failed checks with the severity error and warning, the names of failed checks, and
    the values of checks that have a value. If no check with the severity error fails, the columns of
    `_summarize_design` follow.
    """
    from cycloid_mj.checks import check

    results = check(reducer.design)
    failed_checks = [result for result in results if not result.passed]
    values: dict[str, Cell] = {
        "failed_errors": sum(result.severity == "error" for result in failed_checks),
        "failed_warnings": sum(result.severity == "warning" for result in failed_checks),
        "failed_checks": "; ".join(result.name for result in failed_checks),
    }
    units: dict[str, str] = {}
    for result in results:
        if result.value is not None:
            column = with_unit("_".join(result.name.split()).replace("-", "_"), result.unit)
            values[column] = result.value
            units |= {column: result.unit} if result.unit else {}
    if not values["failed_errors"]:
        summary_values = _summarize_design(reducer)
        values, units = {**values, **summary_values.values}, {**units, **summary_values.units}
    return MeasuredFigures(values, units)


def _summarize_design(reducer: Reducer) -> MeasuredFigures:
    """Collect the summary of `design check` as table columns with units: ratio, size, mass, torques, backlash etc.

    ``weakest`` names the contact that limits the capacity.
    """
    from cycloid_mj.checks import summarize

    figures = summarize(reducer)
    numbers = (
        Quantity("ratio", "", figures.ratio, "1"),
        Quantity("outer_diameter", "", MILLIMETRES * figures.outer_diameter, "mm"),
        Quantity("mass", "", figures.mass, "kg"),
        Quantity("rated_torque", "", figures.rated_torque, "N m"),
        Quantity("loaded_teeth", "", figures.loaded_teeth, "1"),
        Quantity("loaded_teeth_per_disc", "", figures.loaded_teeth, "1"),
        Quantity("pressure_angle", "", math.degrees(figures.pressure_angle), "deg"),
        Quantity("backlash", "", figures.backlash / ARCMINUTE, "arcmin"),
        Quantity("capacity", "", figures.capacity, "N m"),
    )
    measured_figures = _columns_from_quantities(numbers)
    return MeasuredFigures({**measured_figures.values, "weakest": figures.weakest}, measured_figures.units)


def _compute_quantities(reducer: Reducer, _: MeasureSettings) -> MeasuredFigures:
    return _columns_from_quantities(quantities(reducer).values())


def _compute_quantity(row: Figure, reducer: Reducer, _: MeasureSettings) -> MeasuredFigures:
    """Compute one quantity of the catalogue: a column under its key."""
    return MeasuredFigures({row.key: row.value(reducer)}, {row.key: row.unit} if row.unit != "1" else {})


MEASURED: Mapping[str, Callable[[Reducer, MeasureSettings], MeasuredFigures]] = {
    "statics": _compute_statics,
    **{name: partial(_run_measurement, name) for name in MEASURES},
    **{"simulate": _simulate_design, "mass": _compute_masses, "checks": _list_checks, "figures": _compute_quantities},
}
"""Name -> measure; only `checks` accepts a design that cannot be built; `figures` are those of geometry and statics."""


def measure_design(name: str, reducer: Reducer, options: MeasureSettings) -> MeasuredFigures:
    """Compute a measure of a design, or a quantity of the catalogue."""
    if name in MEASURED:
        return MEASURED[name](reducer, options)
    return _compute_quantity(figure(name), reducer, options)


MEASURE_LAYOUTS: Mapping[str, tuple[Layout, ...]] = {
    **dict.fromkeys(MEASURED, BOTH),
    **{name: layouts_of(f"measure {name}") for name in MEASURES},
}
"""Measure of `MEASURED` -> layouts of reducers that it supports."""


def require_measures(reducer: Reducer, names: Iterable[str]) -> tuple[str, ...]:
    """Return the names of what a sweep computes, without duplicates; raise UsageError for an unknown name.

    A name is that of a measure, a group of results such as ``statics`` or ``simulate``, or the key of a single quantity
    of the catalogue, such as ``backlash_arcmin``.

    Raises
    ------
    UsageError
        A name is neither a measure nor a quantity, the layout of the reducer does not have it, or there is no name.
    """
    measure_names = tuple(dict.fromkeys(names))
    for name in measure_names:
        _require_measure(reducer, name)
    if not measure_names:
        raise UsageError(
            f"no measure is given (--measure): choose at least one of {', '.join(MEASURED)}, or a quantity listed "
            "by `cycloid-mj figures`"
        )
    return measure_names


def _require_measure(reducer: Reducer, name: str) -> None:
    """Raise UsageError unless the layout of a reducer (central crank, RV) has the measure or quantity `name`.

    A measure is a group of results, such as ``statics``; a quantity is a single one, such as ``backlash_arcmin``.
    """
    design = reducer.design
    if name in MEASURED:
        if reducer.LAYOUT not in MEASURE_LAYOUTS[name]:
            supported_measures = (measure for measure, layouts in MEASURE_LAYOUTS.items() if reducer.LAYOUT in layouts)
            raise UsageError(
                f'the measure {name!r} does not support layout = "{design.layout}" ({design.name}): choose one of '
                f"{', '.join(supported_measures)}, or a quantity listed by `cycloid-mj figures`"
            )
        return
    try:
        known_figure = figure(name)
    except UsageError as error:
        raise UsageError(
            f"unknown measure {name!r:.80}: choose one of {', '.join(MEASURED)}, or a quantity listed by "
            f"`cycloid-mj figures` ({error})"
        ) from error
    if reducer.LAYOUT not in known_figure.layouts:
        raise UsageError(
            f'the figure {known_figure.key} does not apply to layout = "{design.layout}" ({design.name}): '
            f"`cycloid-mj statics {design.name} --all` lists the figures of statics that do"
        )
