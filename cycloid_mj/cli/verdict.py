"""Outcome of ``cycloid-mj compare``: designs side by side, by their runs and by the catalogue."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from cycloid_mj.base.errors import CycloidError, warn
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.outcome import Outcome, Picture
from cycloid_mj.base.result import Quantity, Table, load_words
from cycloid_mj.cli.delivery import Destination
from cycloid_mj.design import Design
from cycloid_mj.papers import RunsJudged
from cycloid_mj.reducer import reducer_of

if TYPE_CHECKING:
    from cycloid_mj.comparison import Comparison, Trial

FORMATS = ("png",)

HEADLINE = (
    *("backlash_arcmin", "lost_motion_arcmin", "stiffness_nm_per_arcmin", "te_loaded_arcsec", "capacity_nm", "mass_kg"),
    *("te_unloaded_arcsec", "tooth_force_n", "output_pin_force_n", "cam_force_n", "crank_bearing_force_n"),
    "efficiency_percent",
)
"""Keys of the catalogue's figures that are printed next to those of the runs, the first six in the headline; JSON has
all of geometry and statics."""


def catalogue_figures(designs: Sequence[Design]) -> dict[str, dict[str, Quantity]]:
    """Compute the catalogue's figures of geometry and statics of each design, by its name."""
    from cycloid_mj.figures import quantities

    return {design.name: quantities(reducer_of(design)) for design in designs}


def catalogue_table(by_design: Mapping[str, Mapping[str, Quantity]]) -> Table:
    """Tabulate the main quantities of several designs: a column per design, ratios to the first design, unit.

    The quantities are those of `HEADLINE`. `by_design` has the quantities of each design by its name and their keys.
    """
    first_row = next(iter(by_design.values()))
    rows: list[tuple[str | float, ...]] = []
    for key in _available(HEADLINE, by_design):
        values = [figures[key].value for figures in by_design.values()]
        rows.append((key, *values, *ratios(values), first_row[key].unit))
    header = ("figure", *by_design, *ratio_columns(tuple(by_design)), "unit")
    return Table("by geometry and statics: see `cycloid-mj figures`", header, tuple(rows))


def _available(keys: Sequence[str], by_design: Mapping[str, Mapping[str, Quantity]]) -> list[str]:
    """Return those `keys` of figures that all designs have."""
    return [key for key in keys if all(key in figures for figures in by_design.values())]


def ratio_columns(designs: Sequence[str]) -> tuple[str, ...]:
    """List the headings of the ratios to the first design: "ratio" for two designs, else "second / first"."""
    first_design, *other_designs = designs
    return ("ratio",) if len(other_designs) == 1 else tuple(f"{name} / {first_design}" for name in other_designs)


def ratios(values: Sequence[float]) -> list[str]:
    """Return the ratio of each further value to the first as text with four digits; "-" if it is undefined."""
    first_value, *other_values = values
    return [_number(value / first_value if first_value else math.nan) for value in other_values]


def outcome_of(
    comparison: "Comparison", verdicts: RunsJudged, pictures: Mapping[str, Picture], destination: Destination
) -> Outcome:
    """Convert a comparison to printable results, and issue the warnings of all runs.

    `verdicts` are the conclusions from the runs on claims of a paper. `pictures` has for each diagram, by its
    name, the function that encodes it in a file format. `destination` has the paths of the output files.
    """
    from cycloid_mj.comparison.table import figure_frame
    from cycloid_mj.figures import values_json
    from cycloid_mj.plots.comparison import comparison_captions

    for trial in comparison.trials:
        warn(trial.name, tuple(dict.fromkeys(warning for start in trial.starts for warning in start.findings.warnings)))
    loaded_trials = comparison.at(comparison.loads[-1])
    static_quantities = catalogue_figures([trial.design for trial in loaded_trials])
    overload_warnings = overloads(trial.design for trial in loaded_trials)
    statics = {name: values_json(quantities) for name, quantities in static_quantities.items()}
    return Outcome(
        title=f"compare: {' / '.join(comparison.designs)}",
        condition=f"runs under {load_words(comparison.loads[-1])}, {SOLVERS[comparison.solver]}",
        headline=_headline(loaded_trials, static_quantities),
        headline_columns=(*static_quantities, *ratio_columns(tuple(static_quantities)), "unit"),
        tables=[*comparison.tables, catalogue_table(static_quantities)],
        warnings=[f"{name}: {words}" for name, words in overload_warnings.items()],
        notes=[_differences(comparison), *verdicts.notes],
        summary=[
            *verdicts.summary,
            "logs: " + " ".join(str(trial.measures.findings.log) for trial in comparison.trials),
        ],
        pictures=pictures,
        captions=comparison_captions(comparison.designs),
        formats=FORMATS,
        frame=figure_frame(comparison.trials),
        result=comparison.as_json()
        | dict(verdicts.content)
        | {
            "by_statics": statics,
            "exceeded": overload_warnings,
            "figures": destination.paths(f"{name}.{file_format}" for name in pictures for file_format in FORMATS),
        },
    )


def overload_words(load: float, capacity: float) -> str:
    """Describe a load [N m] beyond a capacity [N m]."""
    return (
        f"the load of {load:.4g} N m is {load / capacity:.3g} times its capacity of {capacity:.4g} N m, the torque at "
        "which a contact first yields, but the runs assume elastic contacts"
    )


def overloads(designs: Iterable[Design]) -> dict[str, str]:
    """Return a sentence for each design whose load exceeds its capacity, by name of the design.

    The capacity is the torque at which a contact first yields (`capacity_of`).
    """
    capacities = {design: capacity_of(design) for design in designs}
    return {
        design.name: overload_words(abs(design.load.torque), capacity)
        for design, capacity in capacities.items()
        if abs(design.load.torque) > capacity
    }


def capacity_of(case: Design) -> float:
    """Compute the torque [N m] at which a contact of the design `case` first yields, by statics under its load.

    If there is no equilibrium under the load, statics is solved under a tenth of the load. The result is NaN if this
    has no equilibrium either, or if the design has no load.
    """
    from cycloid_mj.figures import figure

    if not case.load.torque:
        return math.nan
    for share in (1.0, 0.1):  # a large overload has no static balance, or flattens contacts beyond their model
        try:
            return figure("capacity_nm").value(reducer_of(case).but(load={"torque": share * case.load.torque}))
        except CycloidError:
            continue
    return math.nan


def _headline(
    trials: "Sequence[Trial]", static_quantities: Mapping[str, Mapping[str, Quantity]]
) -> dict[str, tuple[str, ...]]:
    """Return the main quantities of statics and of the runs under one load, as rows of text by name.

    A row has the value of each design, the ratio of each further design to the first, and the unit. There is a `Trial`
    for each design, with the measures of its runs from all initial states; the value is their mean.
    `static_quantities` are the static quantities by design and key.
    """
    from cycloid_mj.comparison.table import HEADLINE as RUN_QUANTITIES

    first_quantities = next(iter(static_quantities.values()))
    rows = [
        (
            first_quantities[key].name,
            [figures[key].value for figures in static_quantities.values()],
            first_quantities[key].unit,
        )
        for key in _available(HEADLINE[:6], static_quantities)
    ]
    for figure in RUN_QUANTITIES:
        start_statistics = [trial.over_starts(figure.read) for trial in trials]
        values = [math.nan if statistics is None else statistics.mean for statistics in start_statistics]
        if not all(map(math.isnan, values)):
            rows.append((f"{figure.words} (runs)", values, figure.unit))
    return {name: (*map(_number, values), *ratios(values), unit) for name, values, unit in rows}


def _number(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.4g}"


def _differences(comparison: "Comparison") -> str:
    """Return the keys in which the designs differ."""
    key_texts = (f"{key} ({', '.join(map(_value, values))})" for key, values in comparison.differences.items())
    return f"{', '.join(comparison.designs)} differ in: {'; '.join(key_texts) or 'nothing'}"


def _value(value: object) -> str:
    """Format a value of a design, a number with six digits."""
    if value is None:
        return "not given"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
